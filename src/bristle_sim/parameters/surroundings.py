"""What a bristle touches: the accelerator bar, the workpart, and how a contact is resolved."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bristle_sim.quantity import Declared, choice, quantity, validate

RETRACTION_AT_RELEASE = math.radians(44.5)
"""Retraction angle at release, theta_p (Zhang 2020, eq. 2.2)."""


def _bar_radius() -> float:
    """Return the bar radius that makes the printed bar position touch the wire at the printed retraction angle."""
    hub_radius, length, wire_diameter = 0.0275, 0.027, 7.1e-4
    tip_radius = math.sqrt(hub_radius**2 + length**2 + 2.0 * hub_radius * length * math.cos(RETRACTION_AT_RELEASE))
    return math.hypot(0.05037, 0.0225) - wire_diameter / 2.0 - tip_radius


@dataclass(frozen=True, slots=True)
class Bar(Declared):
    """Accelerator bar: a fixed circle on the incoming side, rigid."""

    radius: float = quantity(
        _bar_radius(),
        "bar_radius",
        above=0.0,
        at_most=1e3,
        source="from Zhang 2020, eqs. 2.1-2.3: touches the wire at a retraction of 44.5 deg",
    )
    horizontal: float = quantity(0.05037, "bar_horizontal", source="Zhang 2020, eq. 2.3: S_H")
    vertical: float = quantity(0.0225, "bar_vertical", source="Zhang 2020, eq. 2.3: S_V")
    friction: float = quantity(0.0, "bar_friction", source="frictionless as in Zhang 2020, sec. 2.2")
    restitution: float = quantity(0.0, "bar_restitution", source="assumed: the bar does not throw the wire back")

    @property
    def centre(self) -> tuple[float, float]:
        """Return the centre of the bar, (-S_H, -S_V), m."""
        return (-self.horizontal, -self.vertical)


@dataclass(frozen=True, slots=True)
class Surface(Declared):
    """How a tip rubs and rebounds on a flat, rigid surface."""

    friction: float = quantity(0.31, "friction", source="Zhang 2020, caption of fig. 2.8: mu_1")
    restitution_friction: float | None = quantity(
        None, "restitution_friction", source="Zhang 2020, case II: equal to friction"
    )
    restitution: float = quantity(
        0.42, "restitution", source="Zhang 2020, caption of fig. 2.13: energetic coefficient e*"
    )

    @property
    def friction_in_restitution(self) -> float:
        """Return mu_2, equal to mu_1 unless given."""
        return self.friction if self.restitution_friction is None else self.restitution_friction


@dataclass(frozen=True, slots=True)
class Workpart(Surface):
    """Flat, rigid workpart below the hub."""

    penetration: float = quantity(
        0.0045,
        "penetration",
        source="Zhang 2020, eq. 2.2: Delta = hub radius + bristle length - height of the hub's centre",
    )


@dataclass(frozen=True, slots=True)
class Contact:
    """How a contact is resolved: by the energetic impact law, in time as a compliance, or by the engine's own."""

    law: str = choice(
        "energetic", "contact", ("energetic", "compliant", "engine"), source="Stronge 1990: energetic restitution"
    )
    duration: float | None = quantity(
        None,
        "contact_duration",
        source="compliant law: time in touch; by default short enough for the rigid-body limit",
        needs="contact = compliant",
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.duration is not None and self.law != "compliant":
            raise ValueError(
                f"contact_duration = {self.duration:g}: must be left out with contact = {self.law}, whose impacts are not"
                " resolved in time (in s)"
            )
