"""The tool and its parts, in SI units and radians, with the dissertation's operating point as default.

Every default names its source. "Zhang 2020" is J. Zhang, *Analysis of Bristle-Tip Impact Crater for Wire Impact Tool*,
PhD dissertation, Marquette University, 2020.

Axes: the hub's centre is the origin, x runs along the workpart in the direction in which the tip travels, y is the
workpart's outward normal. Angles of hub and bristle are measured from the direction that points at the workpart (-y),
positive in the hub's sense of rotation; a bristle at angle phi points from its root along (sin phi, -cos phi).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

from bristle_sim.quantity import ANY, choice, quantity, shown, validate

__all__ = [
    "Bar",
    "Belt",
    "Bristle",
    "Comparison",
    "Contact",
    "DoublePendulum",
    "Hub",
    "Release",
    "SinglePendulum",
    "Strike",
    "Surface",
    "Tool",
    "Workpart",
    "operating_point",
]

Vector = tuple[float, float]

RETRACTION_AT_RELEASE = math.radians(44.5)
"""Retraction angle at release, theta_p (Zhang 2020, eq. 2.2)."""

PRINTED_BELT_STIFFNESS = 0.00041
"""Belt stiffness as printed, "N m/rad" (Zhang 2020, eq. 2.2); it can only be meant per degree."""


def _bar_radius() -> float:
    """Bar radius that makes the printed bar position touch the wire at the printed retraction angle."""
    hub_radius, length, wire_diameter = 0.0275, 0.027, 7.1e-4
    tip_radius = math.sqrt(hub_radius**2 + length**2 + 2.0 * hub_radius * length * math.cos(RETRACTION_AT_RELEASE))
    return math.hypot(0.05037, 0.0225) - wire_diameter / 2.0 - tip_radius


@dataclass(frozen=True, slots=True)
class Hub:
    """Rotating hub that keeps its speed."""

    speed: float = quantity(
        261.8,
        "hub_speed",
        "rad/s",
        at_least=0.0,
        at_most=1e6,
        source="Zhang 2020, eq. 2.2",
        meaning="speed of the hub's rotation",
        usual=(1.0, 1500.0),  # 10 to 14 000 rpm: a speed typed in rpm without saying so is larger
    )
    radius: float = quantity(
        0.0275,
        "hub_radius",
        "m",
        at_least=0.0,
        at_most=1e3,
        source="Zhang 2020, eq. 2.2: root circle",
        meaning="distance of the bristle's root from the hub's centre",
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, slots=True)
class Belt:
    """Flexible belt: a torsion spring, perhaps damped, at the bristle's root."""

    stiffness: float = quantity(
        math.degrees(PRINTED_BELT_STIFFNESS),
        "belt_stiffness",
        "N m/rad",
        at_least=0.0,
        at_most=1e9,
        source="Zhang 2020, eq. 2.2: 0.00041 N m read per degree",
        meaning="torsional stiffness of the belt at the bristle's root",
    )
    damping_ratio: float = quantity(
        0.0,
        "belt_damping_ratio",
        "1",
        at_least=0.0,
        at_most=1e3,
        source="undamped as in Zhang 2020",
        meaning="damping ratio of the bristle on its belt; 1 is critical",
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, slots=True)
class Bristle:
    """Rigid slender wire, straight or with one knee; a positive knee bends the tip forward, in the hub's sense."""

    length: float = quantity(
        0.027,
        "bristle_length",
        "m",
        at_least=1e-9,
        at_most=1e3,
        source="Zhang 2020, eq. 2.2",
        meaning="length of the wire from root to tip, along its centre line",
    )
    mass: float = quantity(
        8.387e-5,
        "bristle_mass",
        "kg",
        at_least=1e-30,
        at_most=1e6,
        source="Zhang 2020, caption of fig. 2.7",
        meaning="mass of one bristle",
    )
    wire_diameter: float = quantity(
        7.1e-4,
        "wire_diameter",
        "m",
        at_least=0.0,
        at_most=1e2,
        source="Zhang 2020, sec. 4.1: tip ellipse",
        meaning="thickness of the wire, half of which touches the bar",
    )
    knee_position: float = quantity(
        0.75,
        "knee_position",
        "1",
        at_least=0.01,
        at_most=0.99,
        source="assumed: share of the length; Zhang 2020, fig. 1.3",
        meaning="distance of the knee from the root, as a fraction of the length",
        needs="knee_angle_deg != 0",
    )
    knee_angle_deg: float = quantity(
        0.0,
        "knee_angle_deg",
        "deg",
        at_least=-90.0,
        at_most=90.0,
        source="straight as in Zhang 2020, fig. 2.5",
        meaning="bend at the knee; positive bends the tip forward, in the hub's sense",
    )
    links: int = quantity(1, "wire_links", "1", at_least=1, at_most=64, source="rigid as in Zhang 2020, sec. 2.3")
    modulus: float = quantity(2e11, "wire_modulus", "Pa", above=0.0, at_most=1e15, source="steel")
    bending_damping_ratio: float = quantity(
        0.0, "wire_damping_ratio", "1", at_least=0.0, at_most=1e3, source="undamped as in Zhang 2020"
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.links != int(self.links):
            raise ValueError(f"wire_links = {self.links:g}: must be a whole number from 1 to 64")
        object.__setattr__(self, "links", int(self.links))

    @property
    def path(self) -> tuple[Vector, ...]:
        """Corners of the centre line after the root, the tip last, seen from the root with the shank along (0, -1), m."""
        if self.knee_angle_deg == 0.0:
            return ((0.0, -self.length),)
        shank, bend = self.knee_position * self.length, math.radians(self.knee_angle_deg)
        rest = self.length - shank
        return ((0.0, -shank), (rest * math.sin(bend), -shank - rest * math.cos(bend)))

    @property
    def tip(self) -> Vector:
        """End of the centre line, seen from the root as in ``path``, m."""
        return self.path[-1]

    @property
    def centre(self) -> Vector:
        """Centre of mass, seen from the root as in ``path``, m."""
        x = y = 0.0
        for start, end, share in self._pieces():
            x += share * 0.5 * (start[0] + end[0])
            y += share * 0.5 * (start[1] + end[1])
        return (x, y)

    @property
    def inertia_about_centre(self) -> float:
        """Moment of inertia about the centre of mass, m L^2/12 (2.22) for a straight bristle, kg m^2."""
        if self.knee_angle_deg == 0.0:
            return self.mass * self.length**2 / 12.0
        centre, total = self.centre, 0.0
        for start, end, share in self._pieces():
            middle = (0.5 * (start[0] + end[0]) - centre[0], 0.5 * (start[1] + end[1]) - centre[1])
            own = ((end[0] - start[0]) ** 2 + (end[1] - start[1]) ** 2) / 12.0
            total += share * self.mass * (own + middle[0] ** 2 + middle[1] ** 2)
        return total

    @property
    def inertia_about_root(self) -> float:
        """Moment of inertia about the root, m L^2/3 for a straight bristle, kg m^2."""
        if self.knee_angle_deg == 0.0:
            return self.mass * self.length**2 / 3.0
        centre = self.centre
        return self.inertia_about_centre + self.mass * (centre[0] ** 2 + centre[1] ** 2)

    def _pieces(self) -> list[tuple[Vector, Vector, float]]:
        """Straight pieces of the centre line with their share of the length."""
        corners = ((0.0, 0.0), *self.path)
        return [
            (start, end, math.hypot(end[0] - start[0], end[1] - start[1]) / self.length)
            for start, end in itertools.pairwise(corners)
        ]


@dataclass(frozen=True, slots=True)
class Bar:
    """Accelerator bar: a fixed circle on the incoming side, rigid."""

    radius: float = quantity(
        _bar_radius(),
        "bar_radius",
        "m",
        above=0.0,
        at_most=1e3,
        source="from Zhang 2020, eqs. 2.1-2.3: touches the wire at a retraction of 44.5 deg",
        meaning="radius of the accelerator bar",
    )
    horizontal: float = quantity(
        0.05037,
        "bar_horizontal",
        "m",
        at_least=0.0,
        at_most=1e3,
        source="Zhang 2020, eq. 2.3: S_H",
        meaning="distance of the bar's centre from the hub's, along the workpart, on the incoming side",
    )
    vertical: float = quantity(
        0.0225,
        "bar_vertical",
        "m",
        at_least=-1e3,
        at_most=1e3,
        source="Zhang 2020, eq. 2.3: S_V",
        meaning="distance of the bar's centre below the hub's",
    )
    friction: float = quantity(
        0.0,
        "bar_friction",
        "1",
        at_least=0.0,
        at_most=1e6,
        source="frictionless as in Zhang 2020, sec. 2.2",
        meaning="coefficient of friction between wire and bar",
    )
    restitution: float = quantity(
        0.0,
        "bar_restitution",
        "1",
        at_least=0.0,
        at_most=1.0,
        source="assumed: the bar does not throw the wire back",
        meaning="energetic coefficient of restitution between wire and bar",
    )

    def __post_init__(self) -> None:
        validate(self)

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of the bar, (-S_H, -S_V), m."""
        return (-self.horizontal, -self.vertical)


@dataclass(frozen=True, slots=True)
class Surface:
    """How a tip rubs and rebounds on a flat, rigid surface."""

    friction: float = quantity(
        0.31,
        "friction",
        "1",
        at_least=0.0,
        at_most=1e9,
        source="Zhang 2020, caption of fig. 2.8: mu_1",
        meaning="coefficient of friction between tip and workpart during compression, mu_1",
    )
    restitution_friction: float | None = quantity(
        None,
        "restitution_friction",
        "1",
        at_least=0.0,
        at_most=1e9,
        source="Zhang 2020, case II: equal to friction",
        meaning="coefficient of friction during restitution, mu_2; none: equal to friction",
    )
    restitution: float = quantity(
        0.42,
        "restitution",
        "1",
        at_least=0.0,
        at_most=1.0,
        source="Zhang 2020, caption of fig. 2.13: energetic coefficient e*",
        meaning="energetic coefficient of restitution between tip and workpart, e*",
    )

    def __post_init__(self) -> None:
        validate(self)

    @property
    def friction_in_restitution(self) -> float:
        """mu_2, equal to mu_1 unless given."""
        return self.friction if self.restitution_friction is None else self.restitution_friction


@dataclass(frozen=True, slots=True)
class Workpart(Surface):
    """Flat, rigid workpart below the hub."""

    penetration: float = quantity(
        0.0045,
        "penetration",
        "m",
        at_least=-1e3,
        at_most=1e3,
        source="Zhang 2020, eq. 2.2: Delta = hub radius + bristle length - height of the hub's centre",
        meaning="depth by which the workpart cuts into the circle of undeflected tips, Delta",
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, slots=True)
class Contact:
    """How a contact is resolved: by the energetic impact law, in time as a compliance, or by the engine's own."""

    law: str = choice(
        "energetic",
        "contact",
        ("energetic", "compliant", "engine"),
        source="Stronge 1990: energetic restitution",
        meaning="law of impact: by energy, resolved in time on a spring, or the engine's own",
    )
    duration: float | None = quantity(
        None,
        "contact_duration",
        "s",
        at_least=1e-18,
        at_most=1.0,
        source="compliant law: time in touch; by default short enough for the rigid-body limit",
        meaning="time that a contact resolved in time lasts; none: short enough for the rigid-body limit",
        needs="contact = compliant",
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.duration is not None and self.law != "compliant":
            raise ValueError(
                f"contact_duration = {self.duration:g}: must be left out with contact = {self.law}, whose impacts are not"
                " resolved in time (in s)"
            )


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
    gravity: float = quantity(
        0.0,
        "gravity",
        "m/s^2",
        at_least=0.0,
        at_most=1e6,
        source="off: 1e-4 of the centrifugal acceleration",
        meaning="acceleration of gravity, towards the workpart",
    )

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
        """Distance of the workpart's surface below the hub's centre, tip circle less Delta, m.

        The tip circle of an undeflected straight bristle has the radius r_h + L.
        """
        if self.workpart is None:
            raise ValueError("workpart = None: must be a Workpart where its depth is requested")
        x, y = self.bristle.tip
        return math.hypot(x, self.hub.radius - y) - self.workpart.penetration

    @property
    def bar_reach(self) -> float:
        """Distance from the bar's centre at which the wire's centre line touches the bar, r_b + d/2, m."""
        if self.bar is None:
            raise ValueError("bar = None: must be a Bar where its reach is requested")
        return self.bar.radius + self.bristle.wire_diameter / 2.0

    @property
    def bar_clearance(self) -> float:
        """Largest radius from the hub's centre that passes under the bar, S - r_b - d/2, m."""
        if self.bar is None:
            raise ValueError("bar = None: must be a Bar where its clearance is requested")
        return math.hypot(self.bar.horizontal, self.bar.vertical) - self.bar_reach

    @property
    def belt_damping(self) -> float:
        """Torsional damping c = 2 zeta sqrt(k_T I), N m s/rad, zeta being the damping ratio of bristle on belt."""
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
    """The dissertation's tool (Zhang 2020, eqs. 2.2 and 2.3), belt stiffness read per degree."""
    return Tool()


@dataclass(frozen=True, slots=True)
class Release:
    """Release of the bristle from rest relative to the hub."""

    retraction_deg: float = quantity(
        44.5,
        "retraction_deg",
        "deg",
        at_least=1e-6,
        at_most=89.9,
        source="Zhang 2020, eq. 2.2: theta_p",
        meaning="angle by which the released bristle lags the radial direction",
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, slots=True)
class Strike:
    """State of a radial bristle at the instant of its strike."""

    speed_ratio: float = quantity(
        3.23,
        "speed_ratio",
        "1",
        at_least=0.0,
        at_most=1e6,
        source="Zhang 2020, caption of fig. 2.7: R, bristle rate over hub speed",
        meaning="bristle's rate over the hub's speed when it strikes, R",
    )
    impact_angle_deg: float = quantity(
        23.4,
        "impact_angle_deg",
        "deg",
        at_least=1e-30,
        at_most=90.0,
        source="Zhang 2020, sec. 2.3: gamma",
        meaning="angle between the radial bristle and the workpart's normal, gamma",
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, slots=True)
class SinglePendulum:
    """Stronge's single pendulum: a rod that swings about a fixed hinge and strikes with its end."""

    mass: float = quantity(
        8.387e-5,
        "rod_mass",
        "kg",
        at_least=1e-30,
        at_most=1e6,
        source="the bristle's: Zhang 2020, 2.4.1",
        meaning="mass of the rod",
    )
    length: float = quantity(
        0.027,
        "rod_length",
        "m",
        at_least=1e-9,
        at_most=1e3,
        source="the bristle's: Zhang 2020, 2.4.1",
        meaning="length of the rod",
    )
    impact_angle_deg: float = quantity(
        23.4,
        "impact_angle_deg",
        "deg",
        at_least=1e-30,
        at_most=90.0,
        source="Zhang 2020, fig. 2.25: rod to the normal",
        meaning="angle between the rod and the surface's normal, gamma",
    )
    rate: float = quantity(
        -845.6,
        "rate",
        "rad/s",
        at_least=-1e9,
        at_most=1e9,
        source="Zhang 2020, fig. 2.30; negative approaches",
        meaning="rate of the rod before the impact; negative approaches",
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, slots=True)
class DoublePendulum:
    """Stronge's double pendulum: rods of equal length, the first ``mass_ratio`` times as heavy as the second."""

    mass: float = quantity(
        5.0,
        "rod_mass",
        "kg",
        at_least=1e-30,
        at_most=1e6,
        source="Zhang 2020, fig. 2.28: m_2",
        meaning="mass of the second rod, whose end strikes, m_2",
    )
    mass_ratio: float = quantity(
        1.0,
        "mass_ratio",
        "1",
        at_least=1e-9,
        at_most=1e12,
        source="Zhang 2020, sec. 2.4.2.1: n = m_1/m_2",
        meaning="mass of the first rod over the second's, n",
        usual=ANY,
    )
    length: float = quantity(
        1.0,
        "rod_length",
        "m",
        at_least=1e-9,
        at_most=1e3,
        source="Zhang 2020, sec. 2.4.2: both rods",
        meaning="length of each rod",
    )
    angle_1_deg: float = quantity(
        20.0,
        "angle_1_deg",
        "deg",
        at_least=-90.0,
        at_most=90.0,
        source="Zhang 2020, fig. 2.28: theta_1, to the normal",
        meaning="angle of the first rod to the surface's normal",
    )
    angle_2_deg: float = quantity(
        30.0,
        "angle_2_deg",
        "deg",
        at_least=-90.0,
        at_most=90.0,
        source="Zhang 2020, fig. 2.28: theta_2, to the normal",
        meaning="angle of the second rod to the surface's normal",
    )
    rate_1: float = quantity(
        -0.1,
        "rate_1",
        "rad/s",
        at_least=-1e9,
        at_most=1e9,
        source="Zhang 2020, fig. 2.28; negative approaches",
        meaning="rate of the first rod before the impact; negative approaches",
    )
    rate_2: float = quantity(
        -0.2,
        "rate_2",
        "rad/s",
        at_least=-1e9,
        at_most=1e9,
        source="Zhang 2020, fig. 2.28; negative approaches",
        meaning="rate of the second rod before the impact; negative approaches",
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, slots=True)
class Comparison:
    """What a run is compared with."""

    reference: str = choice(
        "no",
        "reference",
        ("no", "yes"),
        source="chosen: the independent solution takes longer",
        meaning="whether the independent solution is computed too and judges the result",
    )

    def __post_init__(self) -> None:
        validate(self)
