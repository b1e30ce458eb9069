"""Chapter 4's crater depths compared with print, and what a contact simulated in time says of the crater.

Chapter 4's depths are formulas and stand under theory; nothing of them is simulated. The simulated contact is the bristle's
in the scene, compression only, as long as the camera saw: its force and its energy give depths of their own, and its work is
held against the energy given up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from bristle_sim.comparison import Report, Values, rows
from bristle_sim.parameters import Bristle, Hub, Surface
from bristle_sim.parameters.experiments import Crater
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.crater_sums import constant_row, constants_over, cut_of
from bristle_sim.studies.timed_contact import reported, timed_contact, work_row
from bristle_sim.theory.crater import energy_crater_depth, merchant_crater_depth, merchant_crater_depth_limit
from bristle_sim.theory.crater_cutting import (
    ContactCrater,
    crater_depth_from_contact,
    depth_from_energy,
    depth_from_force,
)
from bristle_sim.theory.merchant import CuttingAngles, ShearAngleError, oblique_angles, specific_cutting_energy
from bristle_sim.theory.monofilament import tip_speed

MEASURED = 1.3e-4
"""Depth of the crater on the micrograph, m (Zhang 2020, fig. 4.13)."""

PRINTED = {"merchant_crater_depth": 1.4e-4, "merchant_crater_depth_limit": 1.4e-4, "energy_crater_depth": 7.58e-5}
"""m; Zhang 2020, fig. 4.13, where 300 plies are called converged, and fig. 4.19."""

CONTACT_DEPTHS = ("contact_force_depth", "contact_energy_depth", "contact_energy_depth_inclined")


@dataclass(frozen=True, slots=True)
class CraterStudy:
    """Results of the study, from which its figures are drawn.

    There are no angles of the cut where the shear plane does not come out of the surface, as ``no_chip`` says, and no contact
    where the tip does not approach (``no_contact``). The craters that follow from the contact are those of a shear plane that
    ends at a surface parallel to the path, or inclined to it.
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
    speed = float(tip_speed(bristle.length, hub.radius, hub.speed, crater.speed_ratio))
    study = _study(hub, bristle, crater, settings, speed)
    simulated, theory = _contact_depths(study, bristle, speed)
    printed = {**PRINTED, **dict.fromkeys(CONTACT_DEPTHS, MEASURED)} if crater == Crater() else {}
    formulas = rows(dict.fromkeys(PRINTED, "m"), {}, _formula_depths(study), printed=printed)
    contact = rows(dict.fromkeys(CONTACT_DEPTHS, "m"), simulated, theory, printed=printed)
    works = () if study.contact is None else (work_row(study.contact),)
    report = Report(
        outcome="no contact",
        quantities=(*formulas, *works, *contact, constant_row(crater, MEASURED)),
        remarks=_remarks(study),
        extra={"measured_crater_depth": MEASURED, "shear_constants": constants_over(crater, MEASURED)},
        subject=study,
    )
    return report if study.contact is None else reported(report, study.contact)


def _study(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings, speed: float) -> CraterStudy:
    """Simulate the contact's compression only: what the tip cuts, it cuts until it is deepest."""
    gamma, angles, no_chip = math.radians(crater.impact_angle_deg), None, ""
    try:
        angles = oblique_angles(crater.friction, gamma)
    except ShearAngleError as error:
        no_chip = str(error)
    surface, rate = Surface(friction=crater.friction, restitution=0.0), crater.speed_ratio * hub.speed
    timed = {"compression_time": crater.compression_time, "rate": rate}
    try:
        contact = timed_contact(hub, bristle, surface, gamma, settings, **timed)
    except ValueError as error:
        if speed > 0.0:
            raise
        return CraterStudy(crater, angles, no_chip, no_contact=str(error))
    craters = (
        crater_depth_from_contact(
            *contact.history.columns().values(),
            impact_angle=gamma,
            shear_yield_stress=crater.shear_yield_stress,
            friction=crater.friction,
            surface=kind,
        )
        for kind in ("parallel", "inclined")
    )
    return CraterStudy(crater, angles, no_chip, contact, "", *craters)


def _formula_depths(study: CraterStudy) -> dict[str, float | None]:
    """Return chapter 4's depths; none by Merchant's circle where there is no chip."""
    crater, time = study.crater, study.crater.compression_time
    energy = float(energy_crater_depth(int(crater.plies), study.impact_angle, compression_time=time))
    if study.no_chip:
        return {"energy_crater_depth": energy}
    cut = cut_of(crater)
    depths = (merchant_crater_depth(plies=crater.plies, **cut), merchant_crater_depth_limit(**cut), energy)
    return dict(zip(PRINTED, map(float, depths), strict=True))


def _contact_depths(study: CraterStudy, bristle: Bristle, speed: float) -> tuple[Values, Values]:
    """Return the simulated contact's depths, and those of a rigid-body impact whose force is a quarter of a sine wave.

    The latter gives up m v/3 along the path and the energy m v^2/6.
    """
    crater, gamma, parallel, inclined = study.crater, study.impact_angle, study.parallel, study.inclined
    if parallel is None or inclined is None:
        return {}, {}
    force = 0.5 * math.pi * bristle.mass * speed / 3.0 / crater.compression_time
    energy = bristle.mass * speed**2 / 6.0
    cut = (crater.friction, gamma, crater.shear_yield_stress)
    straight, leaning = (specific_cutting_energy(*cut, kind) for kind in ("parallel", "inclined"))
    simulated = (parallel.depth_from_force, parallel.depth_from_energy, inclined.depth_from_energy)
    theory = (
        float(depth_from_force(force, straight, gamma)),
        float(depth_from_energy(energy, straight, gamma)),
        float(depth_from_energy(energy, leaning, gamma)),
    )
    shown = slice(None) if parallel.shear_plane_emerges else slice(2, None)
    first, second = (dict([*zip(CONTACT_DEPTHS, side, strict=True)][shown]) for side in (simulated, theory))
    return first, second


def _remarks(study: CraterStudy) -> tuple[str, ...]:
    """Say what is missing and why, and how the contact's depths are meant."""
    lines = [
        f"measured: {1e6 * MEASURED:.0f} um (fig. 4.13), shown as printed where the dissertation has no number",
        "energy_crater_depth grows with the plies, since the force begins near zero; (4.66) reads it as a ratio of two sums",
    ]
    if study.no_chip:
        lines.append(f"no chip by (4.35): {study.no_chip}")
    lines.append(
        f"no contact simulated: {study.no_contact}"
        if study.no_contact
        else "contact depths: all of its force, or all of its energy, cuts a chip by Merchant's relation on a straight path,"
        " its shear plane ending at a surface parallel to the path as in (4.28), or at the real one, inclined to it"
    )
    return ("", *lines)
