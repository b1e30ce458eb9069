"""The tool and its parts: hub, belt and bristle, with or without bar and workpart, and how a contact is resolved."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

from bristle_sim.units import Declared, choice, count, quantity, shown, validate

Vector = tuple[float, float]

PRINTED_BELT_STIFFNESS = 0.00041  # as printed, "N m/rad" (Zhang 2020, eq. 2.2); it can only be meant per degree
USUAL_HUB_SPEEDS = (1.0, 1500.0)  # 10 to 14 000 rpm in rad/s: a speed typed in rpm without saying so is larger

RETRACTION_AT_RELEASE = math.radians(44.5)  # theta_p (Zhang 2020, eq. 2.2)
WIRE_KEYS = ("wire_links", "wire_modulus", "wire_damping_ratio")  # keys of a wire that bends
SHAPE_KEYS = ("knee_position", "knee_angle_deg", *WIRE_KEYS)  # keys of a wire that is not one straight rod


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
        mistaken=(
            PRINTED_BELT_STIFFNESS,
            "the number in print, which is per degree: belt_stiffness='0.00041 N m/deg'",
        ),
    )
    damping_ratio: float = quantity(0.0, "belt_damping_ratio", source="undamped as in Zhang 2020")


@dataclass(frozen=True, slots=True)
class Bristle(Declared):
    """Slender wire, straight or with one knee: one rigid rod, or a chain of equal rigid links that bends."""

    length: float = quantity(0.027, "bristle_length", source="Zhang 2020, eq. 2.2")
    mass: float = quantity(8.387e-5, "bristle_mass", source="Zhang 2020, caption of fig. 2.7")
    wire_diameter: float = quantity(7.1e-4, "wire_diameter", source="Zhang 2020, sec. 4.1: tip ellipse")
    knee_position: float = quantity(
        0.75,
        "knee_position",
        source="assumed: fraction of the length; Zhang 2020, fig. 1.3",
        needs="knee_angle_deg != 0",
    )
    knee_angle_deg: float = quantity(0.0, "knee_angle_deg", source="straight as in Zhang 2020, fig. 2.5")
    links: int = count(1, "wire_links", source="rigid as in Zhang 2020, sec. 2.3")
    modulus: float = quantity(2e11, "wire_modulus", source="steel: E = 2e11 Pa", needs="wire_links != 1")
    bending_damping_ratio: float = quantity(
        0.0, "wire_damping_ratio", source="undamped as in Zhang 2020", needs="wire_links != 1"
    )

    @property
    def path(self) -> tuple[Vector, ...]:
        """Return the centre line's corners from root to tip, seen from the root with the shank along (0, -1), m."""
        if self.knee_angle_deg == 0.0:
            return ((0.0, -self.length),)
        shank, bend = self.knee_position * self.length, math.radians(self.knee_angle_deg)
        rest = self.length - shank
        return ((0.0, -shank), (rest * math.sin(bend), -shank - rest * math.cos(bend)))

    @property
    def tip(self) -> Vector:
        """Return the end of the centre line, seen from the root as in ``path``, m."""
        return self.path[-1]

    @property
    def centre(self) -> Vector:
        """Return the centre of mass, seen from the root as in ``path``, m."""
        pieces = self._pieces()
        x, y = (sum(part * 0.5 * (start[axis] + end[axis]) for start, end, part in pieces) for axis in (0, 1))
        return (x, y)

    @property
    def inertia_about_centre(self) -> float:
        """Return the moment of inertia about the centre of mass, m L^2/12 (2.22) for a straight bristle, kg m^2."""
        if self.knee_angle_deg == 0.0:
            return self.mass * self.length**2 / 12.0
        centre, total = self.centre, 0.0
        for start, end, fraction in self._pieces():
            middle = (0.5 * (start[0] + end[0]) - centre[0], 0.5 * (start[1] + end[1]) - centre[1])
            own = ((end[0] - start[0]) ** 2 + (end[1] - start[1]) ** 2) / 12.0
            total += fraction * self.mass * (own + middle[0] ** 2 + middle[1] ** 2)
        return total

    @property
    def inertia_about_root(self) -> float:
        """Return the moment of inertia about the root, m L^2/3 for a straight bristle, kg m^2."""
        if self.knee_angle_deg == 0.0:
            return self.mass * self.length**2 / 3.0
        centre = self.centre
        return self.inertia_about_centre + self.mass * (centre[0] ** 2 + centre[1] ** 2)

    def _pieces(self) -> list[tuple[Vector, Vector, float]]:
        """Return the straight pieces of the centre line with their fractions of the length."""
        corners = ((0.0, 0.0), *self.path)
        return [
            (start, end, math.hypot(end[0] - start[0], end[1] - start[1]) / self.length)
            for start, end in itertools.pairwise(corners)
        ]


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
        source="short enough for the rigid-body limit",
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

    Raises ValueError if a part stands where another one is.
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
