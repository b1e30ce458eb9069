"""The tool: hub, belt and bristle, with or without bar and workpart."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from bristle_sim.parameters.bristle import Bristle
from bristle_sim.parameters.surroundings import Bar, Contact, Workpart
from bristle_sim.quantity import Declared, quantity, shown, validate

PRINTED_BELT_STIFFNESS = 0.00041
"""Belt stiffness as printed, "N m/rad" (Zhang 2020, eq. 2.2); it can only be meant per degree."""

USUAL_HUB_SPEEDS = (1.0, 1500.0)
"""10 to 14 000 rpm in rad/s: a speed typed in rpm without saying so is larger."""


@dataclass(frozen=True, slots=True)
class Hub(Declared):
    """Rotating hub that keeps its speed."""

    speed: float = quantity(261.8, "hub_speed", source="Zhang 2020, eq. 2.2", usual=USUAL_HUB_SPEEDS)
    radius: float = quantity(0.0275, "hub_radius", source="Zhang 2020, eq. 2.2: root circle")


@dataclass(frozen=True, slots=True)
class Belt(Declared):
    """Flexible belt: a torsion spring, perhaps damped, at the bristle's root."""

    stiffness: float = quantity(
        math.degrees(PRINTED_BELT_STIFFNESS),
        "belt_stiffness",
        source="Zhang 2020, eq. 2.2: 0.00041 N m read per degree",
    )
    damping_ratio: float = quantity(0.0, "belt_damping_ratio", source="undamped as in Zhang 2020")


@dataclass(frozen=True, slots=True)
class Tool:
    """The bristle-blasting tool; ``bar`` and ``workpart`` are absent when None, gravity (m/s^2, along -y) when 0.

    Raises:
        ValueError: if a part stands where another one is.
    """

    hub: Hub = field(default_factory=Hub)
    belt: Belt = field(default_factory=Belt)
    bristle: Bristle = field(default_factory=Bristle)
    bar: Bar | None = field(default_factory=Bar)
    workpart: Workpart | None = field(default_factory=Workpart)
    contact: Contact = field(default_factory=Contact)
    gravity: float = quantity(0.0, "gravity", source="off: 1e-4 of the centrifugal acceleration")

    def __post_init__(self) -> None:
        validate(self)
        for name, kinds in PARTS.items():
            if not isinstance(getattr(self, name), kinds):
                words = " or ".join("None" if kind is type(None) else f"a {kind.__name__}" for kind in kinds)
                raise ValueError(f"{name} = {shown(getattr(self, name))}: must be {words}")
        if self.workpart is not None and self.workpart_depth <= self.hub.radius:
            reach = self.workpart_depth + self.workpart.penetration - self.hub.radius
            raise ValueError(
                f"penetration = {self.workpart.penetration:g}: must be less than the bristle's reach beyond the hub's rim ="
                f" {reach:g}, or the rim would touch the workpart (in m)"
            )
        if self.bar is not None and self.bar_clearance <= self.hub.radius:
            raise ValueError(
                f"bar_radius = {self.bar.radius:g}: must be less than the bar centre's distance minus hub_radius and half"
                f" of wire_diameter = {self.bar_clearance + self.bar.radius - self.hub.radius:g}, or the bar"
                " would stand in the root circle (in m)"
            )

    @property
    def workpart_depth(self) -> float:
        """Return the distance of the workpart's surface below the hub's centre, tip circle less Delta, m.

        The tip circle of an undeflected straight bristle has the radius r_h + L.
        """
        if self.workpart is None:
            raise ValueError("workpart = None: must be a Workpart where its depth is requested")
        x, y = self.bristle.tip
        return math.hypot(x, self.hub.radius - y) - self.workpart.penetration

    @property
    def bar_reach(self) -> float:
        """Return the distance from the bar's centre at which the wire's centre line touches the bar, r_b + d/2, m."""
        if self.bar is None:
            raise ValueError("bar = None: must be a Bar where its reach is requested")
        return self.bar.radius + self.bristle.wire_diameter / 2.0

    @property
    def bar_clearance(self) -> float:
        """Return the largest radius from the hub's centre that passes under the bar, S - r_b - d/2, m."""
        if self.bar is None:
            raise ValueError("bar = None: must be a Bar where its clearance is requested")
        return math.hypot(self.bar.horizontal, self.bar.vertical) - self.bar_reach

    @property
    def belt_damping(self) -> float:
        """Return the torsional damping c = 2 zeta sqrt(k_T I), N m s/rad, with the bristle's damping ratio on the belt."""
        return 2.0 * self.belt.damping_ratio * math.sqrt(self.belt.stiffness * self.bristle.inertia_about_root)


PARTS: dict[str, tuple[type, ...]] = {
    "hub": (Hub,),
    "belt": (Belt,),
    "bristle": (Bristle,),
    "bar": (Bar, type(None)),
    "workpart": (Workpart, type(None)),
    "contact": (Contact,),
}
"""What a tool is made of."""


def operating_point() -> Tool:
    """Return the dissertation's tool (Zhang 2020, eqs. 2.2 and 2.3), belt stiffness read per degree."""
    return Tool()
