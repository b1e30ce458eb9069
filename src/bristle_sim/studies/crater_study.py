"""Compare chapter 4's crater depths with print and with those that follow from a contact simulated in time.

Chapter 4's depths are formulas and stand under theory; nothing of them is simulated. The simulated contact is the bristle's
in the scene, compression only, as long as the camera saw: its force and its energy give depths of their own, and its work is
compared with the energy given up.

(4.45), 2 eta + beta - alpha = C, leaves C to the work material; the dissertation takes that of least work, 90 degrees, and
its crater is deeper than measured. Less C makes a flatter shear plane and a shallower crater, until the shear plane no longer
comes out of the surface (4.35): then there is a C, but no chip.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, Values, amount, rows
from bristle_sim.dissertation.printed import printed_number
from bristle_sim.parameters import Bristle, Crater, Hub, Surface
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.timed_contact import contact_fields, timed_contact, work_row
from bristle_sim.theory.crater import (
    constant_for_crater_depth,
    energy_crater_depth,
    merchant_crater_depth,
    merchant_crater_depth_limit,
)
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

FORMULA_DEPTHS = {
    "merchant_crater_depth": ("depth by Merchant's plies", "m"),
    "merchant_crater_depth_limit": ("depth by plies without end", "m"),
    "energy_crater_depth": ("depth by work and energy", "m"),
}
CONTACT_DEPTHS = {
    "contact_force_depth": ("depth by the contact's force", "m"),
    "contact_energy_depth": ("depth by the contact's energy", "m"),
    "contact_energy_depth_inclined": ("depth by energy, inclined surface", "m"),
}

FRICTIONS = (0.461, 0.47, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 4.0)
IMPACT_ANGLES_DEG = (5.0, 10.0, 15.0, 20.0, 23.4)
"""Rows of the table: the ranges of figs. 4.14 and 4.15, closer where C runs from its least value to 90 degrees."""


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
    """Compute the crater's depth by every available method.

    Raises ValueError if the parameters leave a formula's range, or the contact of a tip that strikes cannot be simulated.
    """
    speed = float(tip_speed(bristle.length, hub.radius, hub.speed, crater.speed_ratio))
    study, printed = _study(hub, bristle, crater, settings, speed), dict[str, float]()
    if crater == Crater():  # 300 plies are called converged
        plies = 1e-6 * printed_number("fig. 4.13: crater depth with 300 plies")
        energy = printed_number("fig. 4.19: crater depth by work and energy")
        printed = dict(zip(FORMULA_DEPTHS, (plies, plies, energy), strict=True))
    cut, gamma, time = cut_of(crater), study.impact_angle, crater.compression_time
    depths = {"energy_crater_depth": float(energy_crater_depth(int(crater.plies), gamma, compression_time=time))}
    if not study.no_chip:
        depths["merchant_crater_depth"] = float(merchant_crater_depth(plies=crater.plies, **cut))
        depths["merchant_crater_depth_limit"] = float(merchant_crater_depth_limit(**cut))
    simulated, theory = _contact_depths(study, bristle, speed)
    words, constant = "C for the measured depth", _constant_deg(crater, MEASURED)
    remarks = [
        f"measured: {1e6 * MEASURED:.0f} um (fig. 4.13)",
        "energy_crater_depth grows with the plies, since the force begins near zero; (4.66) reads it as a ratio of two sums",
        *([f"no chip by (4.35): {study.no_chip}"] if study.no_chip else []),
        f"no contact simulated: {study.no_contact}"
        if study.no_contact
        else "contact depths: all of its force, or all of its energy, cuts a chip by Merchant's relation on a straight path,"
        " its shear plane ending at a surface parallel to the path as in (4.28), or at the real one, inclined to it",
    ]
    return Report(
        **contact_fields(study.contact),
        quantities=(
            *rows(FORMULA_DEPTHS, {}, depths, printed=printed),
            *(() if study.contact is None else (work_row(study.contact),)),
            *rows(CONTACT_DEPTHS, simulated, theory),
            Quantity("constant_for_measured_depth_deg", "deg", None, constant, label=words),
        ),
        remarks=tuple(remarks),
        extra={"measured_crater_depth": MEASURED, "shear_constants": constants_over(crater, MEASURED)},
        subject=study,
        answer=_answer(study, depths, simulated, printed),
    )


def _answer(study: CraterStudy, depths: Values, simulated: Values, printed: Values) -> str:

    def shown(name: str) -> str:
        beside = f" (printed {amount(printed[name] or 0.0, 'm')})" if name in printed else ""
        return f"{amount(depths[name] or 0.0, 'm')}{beside}"

    found = "Merchant's plies cut no chip"
    if "merchant_crater_depth" in depths:
        found = f"Merchant's plies cut {shown('merchant_crater_depth')}"
    own = [value for value in simulated.values() if value is not None]
    contact = f"there is no simulated contact ({study.no_contact})"
    if own:
        depths_of_contact = dict.fromkeys(amount(each, "m") for each in (min(own), max(own)))
        contact = f"the simulated contact {' to '.join(depths_of_contact)}"
    return f"{found}, work and energy {shown('energy_crater_depth')}, {contact}; measured {amount(MEASURED, 'm')}."


def _study(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings, speed: float) -> CraterStudy:
    """Simulate only the contact's compression: the tip cuts until it is deepest."""
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
    cut = {name: value for name, value in cut_of(crater).items() if name != "compression_time"}
    columns = contact.history.columns().values()
    craters = (crater_depth_from_contact(*columns, **cut, surface=kind) for kind in ("parallel", "inclined"))
    return CraterStudy(crater, angles, no_chip, contact, "", *craters)


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
    pairs = (
        (parallel.depth_from_force, float(depth_from_force(force, straight, gamma))),
        (parallel.depth_from_energy, float(depth_from_energy(energy, straight, gamma))),
        (inclined.depth_from_energy, float(depth_from_energy(energy, leaning, gamma))),
    )
    named = dict(list(zip(CONTACT_DEPTHS, pairs, strict=True))[0 if parallel.shear_plane_emerges else 2 :])
    return {name: each[0] for name, each in named.items()}, {name: each[1] for name, each in named.items()}


def cut_of(crater: Crater) -> dict[str, Any]:
    """Return arguments of the theory's functions of the crater by their names; SI and rad."""
    names = ("friction", "shear_yield_stress", "compression_time")
    return {name: getattr(crater, name) for name in names} | {"impact_angle": math.radians(crater.impact_angle_deg)}


def merchant_depth_course(crater: Crater) -> Array:
    """Return the depth after each ply, 0 first, m, by (4.57) as printed, in degrees; shape (plies + 1,)."""
    time = np.linspace(0.0, crater.compression_time, int(crater.plies) + 1)
    steep, gamma = math.degrees(math.atan2(1.0, crater.friction)), crater.impact_angle_deg
    shear = math.radians(45.0 - steep / 2.0 + gamma / 2.0)
    resultant, leaning = math.radians(45.0 + steep / 2.0 - gamma / 2.0), math.radians(steep - gamma)
    growth = np.diff(_printed_force(time) * math.cos(leaning))
    ratio = math.sin(shear) * math.cos(resultant) * math.cos(math.radians(gamma)) / math.cos(leaning)
    width = 2.0 * np.sqrt(3.55e-4**2 - (1.39e-4 + 2.16e-4 * np.exp(-92400.0 * time[1:])) ** 2)
    return np.concatenate([[0.0], np.cumsum(growth * ratio / (width * crater.shear_yield_stress))])


def energy_depth_course(crater: Crater) -> Array:
    """Return the depth after each ply by work and energy (4.58, 4.62-4.65), m, from the printed motion (4.6, 4.7)."""
    time, wire = np.linspace(0.0, crater.compression_time, int(crater.plies) + 1), Bristle()
    left = np.exp(-92400.0 * time)
    rate, centre = 1111.0 * left - 266.65, 15.0 * left + 3.615
    energy = 0.5 * wire.mass * centre**2 + 0.5 * wire.inertia_about_centre * rate**2
    depth = np.cumsum(-np.diff(energy) / _printed_force(time[1:]))
    return np.concatenate([[0.0], depth * math.cos(math.radians(crater.impact_angle_deg))])


def _printed_force(time: Array) -> Array:
    """Return the force (3.19), N."""
    turning = np.cos(2.0 * np.pi * (time + 0.00001) / 0.00012)
    return np.asarray(1.0160 * np.exp(-5.4990 * time) * (26.0 - 30.0 * turning))


def constants_over(
    crater: Crater,
    depth: float,
    frictions: Iterable[float] = FRICTIONS,
    impact_angles_deg: Iterable[float] = IMPACT_ANGLES_DEG,
) -> list[dict[str, Any]]:
    """Return C and shear angle over friction and impact angle, degrees; None where no C gives the depth."""
    found = []
    for gamma, friction in product(impact_angles_deg, frictions):
        tried = dataclasses.replace(crater, friction=friction, impact_angle_deg=gamma)
        row: dict[str, Any] = {"friction": friction, "impact_angle_deg": gamma}
        constant, shear = _constant_deg(tried, depth), None
        if constant is not None:  # C = 2 eta + beta - alpha
            shear = 0.5 * (constant - math.degrees(math.atan2(1.0, friction) - math.radians(gamma)))
        emerges = None if shear is None else shear >= gamma - 1e-9  # (4.35)
        found.append(row | {"constant_deg": constant, "shear_angle_deg": shear, "shear_plane_emerges": emerges})
    return found


def _constant_deg(crater: Crater, depth: float) -> float | None:
    """Return C, degrees; None where there is none."""
    try:
        return math.degrees(float(constant_for_crater_depth(depth, plies=int(crater.plies), **cut_of(crater))))
    except ValueError:
        return None
