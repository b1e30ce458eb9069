"""Crater depths by the formulas of Zhang 2020, chapter 4, compared with the printed values and with
the depths that a simulated contact gives.

The simulated contact is that of the bristle's tip in compression alone. It lasts for the
compression time that the camera saw. One depth follows from its force, another from its energy.

Equation (4.45), 2 eta + beta - alpha = C with the shear angle eta, the friction angle beta and the
rake angle alpha, leaves the constant C to the work material. The dissertation takes the C of least
work, 90 degrees, and its crater is deeper than measured. A smaller C makes a flatter shear plane
and a shallower crater. Below some C the shear plane no longer comes out of the surface (4.35): such
a C may fit the depth, but makes no chip.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
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
    ContactCrater,
    crater_depth_from_contact,
    depth_from_energy,
    depth_from_force,
)
from bristle_sim.theory.crater_kinematics import (
    TipFace,
)
from bristle_sim.theory.merchant import (
    CuttingAngles,
    ShearAngleError,
    oblique_angles,
    specific_cutting_energy,
)
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


@dataclass(frozen=True, slots=True)
class CraterStudy:
    """Results of the study, from which its figures are drawn.

    Attributes:
        crater: parameters of the crater.
        wire_diameter: diameter of the wire, m.
        angles: angles of the cut; None if the shear plane does not come out of the surface.
        no_chip: reason why there are no angles.
        contact: the simulated contact; None if the tip does not approach the surface.
        no_contact: reason why there is no contact.
        craters: craters that the contact cuts, by the surface at which the shear plane ends: one
            ``parallel`` to the tip's path, or the real surface, ``inclined`` to the path. Empty
            without a contact.
    """

    crater: Crater
    wire_diameter: float
    angles: CuttingAngles | None
    no_chip: str
    contact: TimedContact | None = None
    no_contact: str = ""
    craters: Mapping[str, ContactCrater] = field(default_factory=dict)

    @property
    def impact_angle(self) -> float:
        """Return the angle gamma between the tip's path and the surface, rad."""
        return math.radians(self.crater.impact_angle_deg)


def crater_study(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings) -> Report:
    """Compute the crater's depth by every formula of chapter 4 and from a simulated contact.

    Raises:
        ValueError: if the parameters leave a formula's range, or the contact of a tip that strikes
            cannot be simulated.
    """
    study = _study(hub, bristle, crater, settings)
    printed: Values = {}
    if crater == Crater() and bristle == Bristle():  # 300 plies are called converged
        plies = 1e-6 * printed_number("fig. 4.13: crater depth with 300 plies")
        energy = printed_number("fig. 4.19: crater depth by work and energy")
        printed = dict(zip(FORMULA_DEPTHS, (plies, plies, energy), strict=True))
    cut = cut_of(crater, bristle.wire_diameter)
    plies = int(crater.plies)
    of_energy = {name: cut[name] for name in ("impact_angle", "compression_time")}
    depths = {"energy_crater_depth": float(chapter_4.energy_crater_depth(plies, **of_energy))}
    remarks = [
        f"measured: {1e6 * MEASURED:.0f} µm (fig. 4.13)",
        "The depth by work and energy grows with the number of plies, because the force begins near zero. In its"
        " place (4.66) prints a ratio of two sums.",
    ]
    if study.no_chip:
        remarks.append(f"no chip by (4.35): {study.no_chip}")
    else:
        depths["merchant_crater_depth"] = float(chapter_4.merchant_crater_depth(plies=plies, **cut))
        depths["merchant_crater_depth_limit"] = float(chapter_4.merchant_crater_depth_limit(**cut))
    if study.contact is None:
        fields: dict[str, Any] = {"outcome": "no contact"}
        remarks.append(f"no contact simulated: {study.no_contact}")
    else:
        fields = contact_fields(study.contact)
        remarks.append(
            "The contact's depths assume that all of its force, or all of its energy, cuts a chip by Merchant's relation on a"
            " straight path. The shear plane ends at a surface parallel to the path, as in (4.28), or at the real surface, inclined to it."
        )
    simulated, theory = _contact_depths(study, bristle)
    try:
        angle = chapter_4.constant_for_crater_depth(MEASURED, plies=plies, **cut)
        constant = math.degrees(angle)
    except ValueError:  # no C gives the measured depth
        constant = None
    words = "C for the measured depth"
    return Report(
        **fields,
        quantities=(
            *rows(FORMULA_DEPTHS, {}, depths, printed=printed),
            *rows(CONTACT_DEPTHS, simulated, theory),
            Quantity("constant_for_measured_depth_deg", "deg", None, constant, label=words),
        ),
        remarks=tuple(remarks),
        extra={"measured_crater_depth": MEASURED},
        subject=study,
        answer=_answer(study, depths, simulated, printed),
    )


def swept_crater(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings) -> SweptTip:
    """Return the crater as a three-dimensional body, the volume that the tip sweeps.

    It is as deep as the energy of the simulated contact cuts if the shear plane ends at the real
    surface, inclined to the tip's path.

    Raises:
        ValueError: if the tip does not approach, the parameters leave a formula's range, or the
            contact cannot be simulated.
    """
    study = _study(hub, bristle, crater, settings)
    if study.no_contact:
        raise ValueError(study.no_contact)
    face = TipFace(short_axis=bristle.wire_diameter)
    return SweptTip(study.craters["inclined"].depth_from_energy, study.impact_angle, face)


def _answer(study: CraterStudy, depths: Values, simulated: Values, printed: Values) -> str:
    chip = "no chip"
    if (depth := depths.get("merchant_crater_depth")) is not None:
        chip = amount(depth, "m")
    if (said := printed.get("merchant_crater_depth")) is not None:
        chip += f" (printed {amount(said, 'm')})"
    own = sorted(value for value in simulated.values() if value is not None)
    contact = f"No contact is simulated ({study.no_contact})"
    if own:
        contact = f"The simulated contact cuts {' to '.join(dict.fromkeys(amount(each, 'm') for each in (own[0], own[-1])))}"
    ratio = chapter_4.energy_crater_depth_ratio(
        5, study.impact_angle, compression_time=study.crater.compression_time
    )
    return (
        f"{contact} and Merchant's plies cut {chip}; measured are {amount(MEASURED, 'm')}. Work and energy give"
        f" {amount(depths['energy_crater_depth'] or 0.0, 'm')}, the ratio of sums printed in their place (eq. 4.66)"
        f" {amount(float(ratio), 'm')}."
    )


def _study(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings) -> CraterStudy:
    """Simulate the contact and compute the craters that it cuts.

    Only compression is simulated, since the tip cuts until it is deepest.
    """
    if bristle.wire_diameter == 0.0:
        raise ValueError("wire_diameter = 0: must be more than 0, or the tip cuts nothing (in m)")
    cut = cut_of(crater, bristle.wire_diameter)
    angles = None
    no_chip = ""
    try:
        angles = oblique_angles(cut["friction"], cut["impact_angle"])
    except ShearAngleError as error:
        no_chip = str(error)
    found = CraterStudy(crater, bristle.wire_diameter, angles, no_chip)
    surface = Surface(friction=crater.friction, restitution=0.0)
    timed = {
        "compression_time": cut.pop("compression_time"),
        "rate": crater.speed_ratio * hub.speed,
    }
    try:
        contact = timed_contact(hub, bristle, surface, cut["impact_angle"], settings, **timed)
    except ValueError as error:
        if tip_speed(bristle.length, hub.radius, hub.speed, crater.speed_ratio) > 0.0:
            raise
        return dataclasses.replace(found, no_contact=str(error))
    columns = contact.history.columns().values()
    craters = {
        kind: crater_depth_from_contact(*columns, **cut, surface=kind)
        for kind in ("parallel", "inclined")
    }
    return dataclasses.replace(found, contact=contact, craters=craters)


def _contact_depths(study: CraterStudy, bristle: Bristle) -> tuple[Values, Values]:
    """Return the crater depths by the simulated contact, and the same depths by theory.

    In theory the contact is a rigid-body impact whose force is a quarter of a sine wave. Along the
    path the tip, of speed v, gives up the momentum m v/3 and the energy m v^2/6.
    """
    simulated = dict[str, float]()
    theory = dict[str, float]()
    if study.contact is None:
        return simulated, theory
    crater = study.crater
    speed = study.contact.tip_speed
    energy = bristle.mass * speed**2 / 6.0
    force = 0.5 * math.pi * bristle.mass * speed / 3.0 / crater.compression_time
    depths: tuple[tuple[ShearSurface, Callable[..., Any], float], ...] = (
        ("parallel", depth_from_force, force),
        ("parallel", depth_from_energy, energy),
        ("inclined", depth_from_energy, energy),
    )
    face = TipFace(short_axis=bristle.wire_diameter)
    for name, (kind, depth, load) in zip(CONTACT_DEPTHS, depths, strict=True):
        found = study.craters[kind]
        if kind == "inclined" or found.shear_plane_emerges:
            cutting = (crater.friction, study.impact_angle, crater.shear_yield_stress)
            specific = specific_cutting_energy(*cutting, kind)
            simulated[name] = float(getattr(found, depth.__name__))
            theory[name] = float(depth(load, specific, study.impact_angle, face))
    return simulated, theory


def cut_of(crater: Crater, wire_diameter: float) -> dict[str, Any]:
    """Return the keyword arguments of the crater formulas for these parameters, in SI units and
    rad.
    """
    names = ("friction", "shear_yield_stress", "compression_time")
    return {name: getattr(crater, name) for name in names} | {
        "impact_angle": math.radians(crater.impact_angle_deg),
        "wire_diameter": wire_diameter,
    }
