"""Crater depths that the formulas of Zhang 2020, chapter 4, give, compared with the printed values
and with the depths that a simulated contact gives.

Only the compression phase of the tip's contact is simulated. The phase lasts as long as in the
high-speed film. One depth follows from the contact's force, another from the contact's energy.

Equation (4.45) is 2 eta + beta - alpha = C, with the shear angle eta, the friction angle beta and
the rake angle alpha. The constant C depends on the work material. The dissertation uses 90 degrees,
the value of least work; the crater is then deeper than the measured one. A smaller C makes a
flatter shear plane and a shallower crater. Below a certain C the shear plane no longer reaches the
surface (4.35). Such a C may fit the measured depth, but no chip forms.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from bristle_sim.comparison import Quantity, Report, Values, rows
from bristle_sim.dissertation.printed import printed_number
from bristle_sim.parameters import Bristle, Crater, Hub, Surface
from bristle_sim.readable import amount
from bristle_sim.settings import Settings
from bristle_sim.studies.timed_contact import TimedContact, contact_fields, timed_contact
from bristle_sim.theory import crater as chapter_4
from bristle_sim.theory.crater_body import SweptTip
from bristle_sim.theory.crater_cutting import (
    crater_depth_from_contact,
    depth_from_energy,
    depth_from_force,
)
from bristle_sim.theory.crater_kinematics import TipFace
from bristle_sim.theory.merchant import ShearAngleError, specific_cutting_energy
from bristle_sim.theory.merchant import Surface as ShearSurface
from bristle_sim.theory.monofilament import tip_speed

MEASURED = 1.3e-4  # Measured depth of the crater on the micrograph, m (Zhang 2020, fig. 4.13)

FORMULA_DEPTHS = {
    "merchant_crater_depth": ("depth by Merchant's plies", "m"),
    "merchant_crater_depth_limit": ("depth by infinitely many plies", "m"),
    "energy_crater_depth": ("depth by work and energy", "m"),
}
CONTACT_DEPTHS = {
    "contact_force_depth": ("depth by the contact's force", "m"),
    "contact_energy_depth": ("depth by the contact's energy", "m"),
    "contact_energy_depth_inclined": ("depth by energy, inclined surface", "m"),
}


PLIES_OF_RATIO = 5  # number of plies with which the dissertation computes (4.66)


@dataclass(frozen=True, slots=True)
class CraterStudy:
    """Results of the crater study, from which its figure is drawn.

    Attributes:
        crater: parameters of the crater.
        depths: estimates of the crater depth (m), by name. The names are those of FORMULA_DEPTHS
            and CONTACT_DEPTHS, and ``ratio_of_sums`` for eq. 4.66 of the dissertation. An estimate
            is missing if its formula does not apply.
        contact: the simulated contact; None if the tip does not approach the surface.
        no_contact: reason why there is no contact.
    """

    crater: Crater
    depths: dict[str, float]
    contact: TimedContact | None
    no_contact: str


def crater_study(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings) -> Report:
    """Compute the crater's depth by every formula of the dissertation's chapter 4, and by
    simulation.

    Raises:
        ValueError: if the parameters leave a formula's range, or the contact of a tip that strikes
            cannot be simulated.
    """
    printed: Values = {}
    if crater == Crater() and bristle == Bristle():  # 300 plies are called converged
        plies = 1e-6 * printed_number("fig. 4.13: crater depth with 300 plies")
        energy = printed_number("fig. 4.19: crater depth by work and energy")
        printed = dict(zip(FORMULA_DEPTHS, (plies, plies, energy), strict=True))
    remarks = [
        f"measured: {1e6 * MEASURED:.0f} µm (fig. 4.13)",
        "The depth by work and energy grows with the number of plies, because the force begins near zero. In its"
        " place (4.66) prints a ratio of two sums.",
    ]
    contact = None
    no_contact = ""
    simulated = dict[str, float]()
    theory = dict[str, float]()
    fields: dict[str, Any] = {"outcome": "no contact"}
    try:
        contact = _compression(hub, bristle, crater, settings)
    except ValueError as error:
        if tip_speed(bristle.length, hub.radius, hub.speed, crater.speed_ratio) > 0.0:
            raise
        no_contact = str(error)
    cut = _cut(crater, bristle) | {"compression_time": crater.compression_time}
    plies = int(crater.plies)
    of_energy = {name: cut[name] for name in ("impact_angle", "compression_time")}
    depths = {"energy_crater_depth": float(chapter_4.energy_crater_depth(plies, **of_energy))}
    try:
        for name, count in (
            ("merchant_crater_depth", plies),
            ("merchant_crater_depth_limit", math.inf),
        ):
            depths[name] = float(chapter_4.merchant_crater_depth(plies=count, **cut))
    except ShearAngleError as error:
        remarks.append(f"no chip by (4.35): {error}")
    if contact is None:
        remarks.append(f"no contact simulated: {no_contact}")
    else:
        simulated, theory = _contact_depths(contact, crater, bristle)
        fields = contact_fields(contact)
        remarks.append(
            "The contact's depths assume that all of its force, or all of its energy, cuts a chip by Merchant's relation on a"
            " straight path. The shear plane ends at a surface parallel to the path, as in (4.28), or at the real surface, inclined to it."
        )
    try:
        angle = chapter_4.constant_for_crater_depth(MEASURED, plies=plies, **cut)
        constant = math.degrees(angle)
    except ValueError:  # no C gives the measured depth
        constant = None
    ratio = float(chapter_4.energy_crater_depth_ratio(PLIES_OF_RATIO, **of_energy))
    words = "C for the measured depth"
    found = depths | simulated | {"ratio_of_sums": ratio}
    return Report(
        **fields,
        quantities=(
            *rows(FORMULA_DEPTHS, {}, depths, printed=printed),
            *rows(CONTACT_DEPTHS, simulated, theory),
            Quantity("constant_for_measured_depth_deg", "deg", None, constant, label=words),
        ),
        remarks=tuple(remarks),
        extra={"measured_crater_depth": MEASURED},
        subject=CraterStudy(crater, found, contact, no_contact),
        answer=_answer(found, printed, no_contact),
    )


def swept_crater(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings) -> SweptTip:
    """Return the crater as the volume that the tip sweeps along its path.

    The energy of the simulated contact determines the depth. The shear plane ends at the real
    surface, which is inclined to the tip's path.

    Raises:
        ValueError: if the tip does not approach, the parameters leave a formula's range, or the
            contact cannot be simulated.
    """
    contact = _compression(hub, bristle, crater, settings)
    depths, _ = _contact_depths(contact, crater, bristle)
    face = TipFace(short_axis=bristle.wire_diameter)
    angle = math.radians(crater.impact_angle_deg)
    return SweptTip(depths["contact_energy_depth_inclined"], angle, face)


def _answer(depths: Mapping[str, float], printed: Values, no_contact: str) -> str:
    names = ("merchant_crater_depth", "energy_crater_depth", "ratio_of_sums")
    plies, energy, ratio = (
        amount(depths[name], "m") if name in depths else "no chip" for name in names
    )
    if (said := printed.get("merchant_crater_depth")) is not None:
        plies += f" (printed {amount(said, 'm')})"
    contact = f"No contact is simulated ({no_contact})"
    if own := sorted(depths[name] for name in CONTACT_DEPTHS if name in depths):
        contact = f"The simulated contact cuts {' to '.join(dict.fromkeys(amount(each, 'm') for each in (own[0], own[-1])))}"
    return (
        f"{contact} and Merchant's plies cut {plies}; measured are {amount(MEASURED, 'm')}. Work and energy give"
        f" {energy}, the ratio of sums printed in their place (eq. 4.66) {ratio}."
    )


def _compression(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings) -> TimedContact:
    """Simulate the compression phase of the tip's contact, in which the tip cuts the crater.

    Raises:
        ValueError: if the tip does not approach, the wire has no diameter, or no contact has the
            requested compression time.
    """
    if bristle.wire_diameter == 0.0:
        raise ValueError("wire_diameter = 0: must be more than 0, or the tip cuts nothing (in m)")
    return timed_contact(
        hub,
        bristle,
        Surface(friction=crater.friction, restitution=0.0),
        math.radians(crater.impact_angle_deg),
        settings,
        compression_time=crater.compression_time,
        rate=crater.speed_ratio * hub.speed,
    )


def _contact_depths(
    contact: TimedContact, crater: Crater, bristle: Bristle
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the crater depths (m) that follow from the simulated contact, and from theory.

    Each depth assumes that the shear plane ends at one of two surfaces: a surface parallel to the
    tip's path, or the real surface, which is inclined to the path.

    The theory assumes a rigid-body impact whose force over time is a quarter of a sine wave. A
    bristle of mass m and tip speed v then loses the momentum m v/3 and the energy m v^2/6 along the
    path.

    Returns:
        The simulated depths and the theoretical depths, by the names of CONTACT_DEPTHS. A depth is
            missing if the shear plane does not reach the surface.
    """
    cut = _cut(crater, bristle)
    face = TipFace(short_axis=bristle.wire_diameter)
    energy = bristle.mass * contact.tip_speed**2 / 6.0
    force = 0.5 * math.pi * bristle.mass * contact.tip_speed / 3.0 / crater.compression_time
    depths: tuple[tuple[ShearSurface, Callable[..., Any], float], ...] = (
        ("parallel", depth_from_force, force),
        ("parallel", depth_from_energy, energy),
        ("inclined", depth_from_energy, energy),
    )
    simulated = dict[str, float]()
    theory = dict[str, float]()
    for name, (surface, depth, load) in zip(CONTACT_DEPTHS, depths, strict=True):
        found = crater_depth_from_contact(
            *contact.history.columns().values(), **cut, surface=surface
        )
        if found.shear_plane_emerges:
            angle = cut["impact_angle"]
            specific = specific_cutting_energy(
                crater.friction, angle, crater.shear_yield_stress, surface
            )
            simulated[name] = float(getattr(found, depth.__name__))
            theory[name] = float(depth(load, specific, angle, face))
    return simulated, theory


def _cut(crater: Crater, bristle: Bristle) -> dict[str, Any]:
    """Return the keyword arguments of the crater formulas, in SI units and rad."""
    return {
        "friction": crater.friction,
        "shear_yield_stress": crater.shear_yield_stress,
        "impact_angle": math.radians(crater.impact_angle_deg),
        "wire_diameter": bristle.wire_diameter,
    }
