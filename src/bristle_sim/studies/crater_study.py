"""Chapter 4's crater depths compared with print, and what a contact simulated in time says of the crater.

Chapter 4's depths are formulas and stand under theory; nothing of them is simulated. They are computed a second time: the
sums over plies by the printed (4.57) and (4.64), number by number and ply by ply, the limit of many plies by Richardson's
extrapolation of the sums, where the theory has a quadrature. The simulated contact is
the bristle's in the scene, compression only, as long as the camera saw: its force and its energy give depths of their own,
and its work is held against the energy given up.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Bristle, Hub, Surface
from bristle_sim.parameters.crater import Crater
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.crater_sums import (
    constant_in_words,
    constant_row,
    constants_over,
    energy_depth_course,
    merchant_depth_course,
    merchant_depth_extrapolated,
    merchant_depth_sum,
)
from bristle_sim.studies.timed_contact import BALANCE, reported, timed_contact, work_row
from bristle_sim.theory.crater import energy_crater_depth, energy_crater_depth_ratio, merchant_crater_depth_limit
from bristle_sim.theory.crater_cutting import (
    ContactCrater,
    crater_depth_from_contact,
    depth_from_energy,
    depth_from_force,
)
from bristle_sim.theory.merchant import CuttingAngles, ShearAngleError, oblique_angles, specific_cutting_energy
from bristle_sim.theory.merchant import Surface as SurfaceKind
from bristle_sim.theory.monofilament import tip_speed

MEASURED = 1.3e-4
"""Depth of the crater on the micrograph, m (Zhang 2020, fig. 4.13)."""

PRINTED = {"merchant_crater_depth": 1.4e-4, "merchant_crater_depth_limit": 1.4e-4, "energy_crater_depth": 7.58e-5}
"""m; Zhang 2020, fig. 4.13, where 300 plies are called converged, and fig. 4.19."""


@dataclass(frozen=True, slots=True)
class CraterStudy:
    """Results of the study, from which its figures are drawn.

    Attributes:
        crater: its parameters.
        angles: of the cut, or None where the shear plane does not come out of the surface.
        no_chip: why not.
        contact: simulated, or None where the tip does not approach, and ``no_contact`` says so.
        parallel, inclined: craters that follow from it, for a shear plane that ends at a surface parallel to the path or
            inclined to it.
    """

    crater: Crater
    angles: CuttingAngles | None
    no_chip: str = ""
    contact: TimedContact | None = None
    no_contact: str = ""
    parallel: ContactCrater | None = None
    inclined: ContactCrater | None = None

    @property
    def impact_angle(self) -> float:
        """Return gamma, rad."""
        return math.radians(self.crater.impact_angle_deg)


def crater_study(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings) -> Report:
    """Compute the crater's depth in every way there is.

    Raises:
        ValueError: if the parameters leave a formula's range, or the contact of a tip that strikes cannot be simulated.
    """
    study = _with_contact(_with_angles(crater), hub, bristle, settings)
    report = Report(
        outcome="no contact",
        quantities=(
            *_merchant_rows(study),
            _energy_row(crater),
            *_contact_rows(study, hub, bristle),
            constant_row(crater, MEASURED),
        ),
        remarks=_remarks(study),
        extra={"measured_crater_depth": MEASURED, "shear_constants": constants_over(crater, MEASURED)},
        subject=study,
    )
    return report if study.contact is None else reported(report, study.contact)


def _with_angles(crater: Crater) -> CraterStudy:
    try:
        return CraterStudy(crater, oblique_angles(crater.friction, math.radians(crater.impact_angle_deg)))
    except ShearAngleError as error:
        return CraterStudy(crater, None, no_chip=str(error))


def _with_contact(study: CraterStudy, hub: Hub, bristle: Bristle, settings: Settings) -> CraterStudy:
    """Simulate the contact's compression only: what the tip cuts, it cuts until it is deepest."""
    crater, surface = study.crater, Surface(friction=study.crater.friction, restitution=0.0)
    try:
        contact = timed_contact(
            hub,
            bristle,
            surface,
            study.impact_angle,
            settings,
            compression_time=crater.compression_time,
            rate=crater.speed_ratio * hub.speed,
        )
    except ValueError as error:
        if float(tip_speed(bristle.length, hub.radius, hub.speed, crater.speed_ratio)) > 0.0:
            raise
        return dataclasses.replace(study, no_contact=str(error))
    parallel, inclined = (_crater_of(contact, study, kind) for kind in ("parallel", "inclined"))
    return dataclasses.replace(study, contact=contact, parallel=parallel, inclined=inclined)


def _crater_of(contact: TimedContact, study: CraterStudy, surface: SurfaceKind) -> ContactCrater:
    h = contact.history
    return crater_depth_from_contact(
        h.time,
        h.normal_force,
        h.tangential_force,
        h.penetration,
        h.normal_velocity,
        h.tangential_velocity,
        impact_angle=study.impact_angle,
        shear_yield_stress=study.crater.shear_yield_stress,
        friction=study.crater.friction,
        surface=surface,
    )


def _merchant_rows(study: CraterStudy) -> tuple[Quantity, ...]:
    """Return rows of formulas alone, with nothing simulated; empty where there is no chip."""
    crater = study.crater
    names = ("merchant_crater_depth", "merchant_crater_depth_limit")
    if study.angles is None:
        return tuple(_depth(name, crater, None, None) for name in names)
    stress, time = crater.shear_yield_stress, crater.compression_time
    limit = merchant_crater_depth_limit(crater.friction, study.impact_angle, stress, compression_time=time)
    values = float(merchant_depth_sum(crater, crater.plies)), float(limit)
    return tuple(_depth(name, crater, None, value) for name, value in zip(names, values, strict=True))


def _energy_row(crater: Crater) -> Quantity:
    return _depth("energy_crater_depth", crater, None, _energy_depth(crater))


def _energy_depth(crater: Crater) -> float:
    angle, time = math.radians(crater.impact_angle_deg), crater.compression_time
    return float(energy_crater_depth(int(crater.plies), angle, compression_time=time))


def _depth(name: str, crater: Crater, simulated: float | None, theory: float | None) -> Quantity:
    printed = PRINTED.get(name, MEASURED) if crater == Crater() else None
    return Quantity(name, "m", simulated, theory, printed=printed)


def _contact_rows(study: CraterStudy, hub: Hub, bristle: Bristle) -> tuple[Quantity, ...]:
    """Work beside energy, and depths beside those of a rigid-body impact whose force is a quarter of a sine wave."""
    names = ("contact_force_depth", "contact_energy_depth", "contact_energy_depth_inclined")
    contact, parallel, inclined = study.contact, study.parallel, study.inclined
    speed = float(tip_speed(bristle.length, hub.radius, hub.speed, study.crater.speed_ratio))
    if contact is None or parallel is None or inclined is None:
        works = tuple(Quantity(name, "J", None) for name in ("contact_work", "contact_work_in_hub_frame"))
        return (*works, *(_depth(name, study.crater, None, None) for name in names))
    simulated = (parallel.depth_from_force, parallel.depth_from_energy, inclined.depth_from_energy)
    theory = _rigid_depths(study, bristle, speed)
    shown = (parallel.shear_plane_emerges, parallel.shear_plane_emerges, True)
    rows = [
        _depth(name, study.crater, *(sides if emerges else (None, None)))
        for name, emerges, *sides in zip(names, shown, simulated, theory, strict=True)
    ]
    return (*_work_rows(contact), *rows)


def _work_rows(contact: TimedContact) -> tuple[Quantity, ...]:
    """Work of the force over the path beside the energy given up; in the hub's frame one is force, the other states alone.

    There the work is a difference, whose error is that of the works it is the difference of.
    """
    turning, given = -contact.work_in_hub_frame, contact.energy_given_up_in_hub_frame
    allowed = BALANCE * abs(contact.work / given) if given else BALANCE
    return (
        work_row(contact),
        Quantity("contact_work_in_hub_frame", "J", turning, given, tolerance=allowed),
    )


def _rigid_depths(study: CraterStudy, bristle: Bristle, speed: float) -> tuple[float, float, float]:
    """Return the depths from the force and energy of an impact without duration: m v/3 along the path, m v^2/6."""
    crater, gamma = study.crater, study.impact_angle
    force = 0.5 * math.pi * bristle.mass * speed / 3.0 / crater.compression_time
    energy = bristle.mass * speed**2 / 6.0
    cut = (crater.friction, gamma, crater.shear_yield_stress)
    parallel, inclined = (specific_cutting_energy(*cut, kind) for kind in ("parallel", "inclined"))
    return (
        float(depth_from_force(force, parallel, gamma)),
        float(depth_from_energy(energy, parallel, gamma)),
        float(depth_from_energy(energy, inclined, gamma)),
    )


def _remarks(study: CraterStudy) -> tuple[str, ...]:
    measured = f"measured: {1e6 * MEASURED:.0f} um (fig. 4.13), shown as printed where the dissertation has no number"
    constant = constant_in_words(study.crater, MEASURED)
    lines = (_chip_line(study), constant, *_second_reckoning(study), *_energy_lines(study), *_contact_lines(study))
    return ("", measured, *lines)


def _second_reckoning(study: CraterStudy) -> tuple[str, ...]:
    """Say how far the printed sums, number by number, and their extrapolated limit are from the theory."""
    crater, pairs = study.crater, []
    if study.angles is not None:
        stress, time = crater.shear_yield_stress, crater.compression_time
        limit = merchant_crater_depth_limit(crater.friction, study.impact_angle, stress, compression_time=time)
        pairs = [
            ("plies", merchant_depth_course(crater)[-1], merchant_depth_sum(crater, crater.plies)),
            ("limit", merchant_depth_extrapolated(crater), limit),
        ]
    pairs.append(("energy", energy_depth_course(crater)[-1], _energy_depth(crater)))
    apart = ", ".join(f"{name} {abs(float(again) / float(once) - 1.0):.1e}" for name, again, once in pairs)
    return (
        "theory computed twice; the printed sums ply by ply and their extrapolated limit differ from it by",
        f"  {apart} of it (the printed coefficients of the energy have three digits)",
    )


def _chip_line(study: CraterStudy) -> str:
    if study.angles is None:
        return f"no chip by (4.35): {study.no_chip}"
    angles = (study.angles.rake, study.angles.friction, study.angles.shear)
    rake, beta, eta = (math.degrees(float(each)) for each in angles)
    gamma = f"{study.crater.impact_angle_deg:g} deg"
    return (
        f"chip: rake angle {rake:.2f}, friction angle {beta:.2f}, shear angle {eta:.2f} deg, not below gamma = {gamma}"
    )


def _energy_lines(study: CraterStudy) -> tuple[str, ...]:
    plies, time = int(study.crater.plies), study.crater.compression_time
    five, asked = (
        1e6 * float(energy_crater_depth_ratio(n, study.impact_angle, compression_time=time)) for n in (5, plies)
    )
    return (
        "energy_crater_depth grows with the plies, since the force begins near zero; read as a ratio of two sums (4.66)",
        f"  it is {five:.2f} um with 5 plies, {asked:.2f} with {plies}",
    )


def _contact_lines(study: CraterStudy) -> tuple[str, ...]:
    contact, parallel = study.contact, study.parallel
    if contact is None or parallel is None:
        return (f"no contact simulated: {study.no_contact}",)
    time = f"{1e6 * contact.compression_time:.4g} us"
    force = f"{parallel.peak_cutting_force:.2f} N"
    path, depth = (f"{1e6 * each:.0f} um" for each in (parallel.path, parallel.penetration))
    return (
        f"contact: tip at {contact.tip_speed:.2f} m/s, compressed for {time} by a spring as stiff as that needs; largest",
        f"  force along the path {force}, path {path}, deepest {depth}: the spring's, not the crater's",
        "contact depths: all of this force, or all of this energy, cuts a chip by Merchant's relation on a straight path,",
        "  its shear plane ending at a surface parallel to the path as in (4.28), or at the real one, inclined to it",
    )
