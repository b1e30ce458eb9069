"""The tool: hub, belt and bristle, with or without bar and workpart."""

from __future__ import annotations

import cmath
import dataclasses
import itertools
import math
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any

from bristle_sim.declared import Computed, Declared, declarations, quantity
from bristle_sim.parameters.parts import Bar, Belt, Bristle, Contact, Hub, Workpart
from bristle_sim.units import Choice, Range, displayed, likely_key, shown

# Hub angle at the start of a pass, rad: a quarter turn before the direction of the workpart.
START = -math.pi / 2.0
# Turn of the hub from an earlier start to the touch of the bar, rad: far more than the rounding of
# a gap.
CLEAR_OF_BAR = math.radians(5.0)


@dataclass(frozen=True, slots=True)
class Tool(Declared):
    """The bristle-blasting tool.

    A ``bar`` or ``workpart`` of None is absent. Gravity, m/s^2, acts along -y. The default is the
    dissertation's tool (Zhang 2020, eqs. 2.2 and 2.3), with its belt stiffness read per degree.
    Raises ValueError for a part of the wrong class.
    """

    hub: Hub = field(default_factory=Hub)
    belt: Belt = field(default_factory=Belt)
    bristle: Bristle = field(default_factory=Bristle)
    bar: Bar | None = field(default_factory=Bar)
    workpart: Workpart | None = field(default_factory=Workpart)
    contact: Contact = field(default_factory=Contact)
    gravity: float = quantity(
        0.0,
        "0 <= gravity <= 1e6 m/s^2: acceleration of gravity, towards the workpart"
        " [off: 1e-4 of the centrifugal acceleration]",
    )
    start_hub_angle_deg: float | None = quantity(
        None,
        "-360 <= start_hub_angle_deg <= 360 deg: hub angle at the start of a pass, from the direction of the workpart; none:"
        " -90, or earlier where the bar would stand in the wire or behind it [-90, or 5 before the wire would meet the bar]",
    )

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        for name, kinds in PARTS.items():
            if not isinstance(getattr(self, name), kinds):
                words = " or ".join(
                    "None" if kind is type(None) else f"a {kind.__name__}" for kind in kinds
                )
                raise ValueError(f"{name} = {shown(getattr(self, name))}: must be {words}")
        if self.workpart is not None and self.workpart_depth <= self.hub.radius:
            reach = self.workpart_depth + self.workpart.penetration - self.hub.radius
            raise ValueError(
                f"penetration = {self.workpart.penetration:g}: must be less than the bristle's reach beyond the hub's rim ="
                f" {reach:g}, or the rim would touch the workpart (in m)"
            )
        if self.bar is not None and self.bar_clearance <= self.hub.radius:
            beside = self.bar_clearance
            if beside + self.bar.radius <= self.hub.radius:  # no bar is thin enough
                raise ValueError(
                    f"hub_radius = {self.hub.radius:g}: must be less than the bar centre's distance minus bar_radius and half"
                    f" of wire_diameter = {beside:g}, or the bar would stand in the root circle (in m)"
                )
            raise ValueError(
                f"bar_radius = {self.bar.radius:g}: must be less than the bar centre's distance minus hub_radius and half"
                f" of wire_diameter = {self.bar_clearance + self.bar.radius - self.hub.radius:g}, or the bar"
                " would stand in the root circle (in m)"
            )

    def __repr__(self) -> str:
        """Return one line a part, in the units that an engineer reads."""
        return "\n".join(["Tool:", *(f"  {part}: {words}" for part, words in self._in_words())])

    def _repr_html_(self) -> str:
        """Return a table of the parts, which a notebook shows."""
        rows = (
            f"<tr><th>{part}</th><td style='text-align:left'>{escape(words)}</td></tr>"
            for part, words in self._in_words()
        )
        return f"<table>{''.join(rows)}</table>"

    def _in_words(self) -> list[tuple[str, str]]:
        """Return each part with the values of its fields; a field without a value is left out."""
        found = []
        for part, keys in tool_keys().items():
            owner = getattr(self, part) if part else self
            given = {
                field.removesuffix("_deg").replace("_", " "): displayed(declared, value)
                for field, declared in keys.values()
                if owner is not None and (value := getattr(owner, field)) is not None
            }
            words = ", ".join(f"{field} {value}" for field, value in given.items())
            found.append((part or "tool", words or "absent"))
        return [*found[1:], found[0]]

    def replace(self, **changes: Any) -> Tool:
        """Return a tool with other values, as in ``tool.replace(hub_speed="3000 rpm", friction=0.4,
        bar=None)``.

        Names are the keys of the command line, or those of whole parts; numbers are in SI units, or
        texts with a unit.

        Raises:
            ValueError: for an unknown name, a refused value, or a key of an absent part; the
            message is one line.
        """
        found = dict[str, Any]()
        places = {key: part for part, keys in tool_keys().items() for key in keys}
        for name, value in changes.items():
            if name in PARTS and (name not in places or isinstance(value, PARTS[name])):
                found[name] = value
            elif name not in places:
                raise ValueError(f"unknown key {name!r}; {likely_key(name, {*PARTS, *places})}")
        for part, keys in tool_keys().items():
            values = dict[str, Any]()
            for key, value in changes.items():
                if key in keys and key not in found:
                    values[keys[key][0]] = (
                        float(value) if isinstance(value, Computed) else value
                    )  # the copied mass is a given one
            owner: Any = found.get(part, getattr(self, part)) if part else self
            if values and owner is None:
                raise ValueError(f"{part} = None: must be present where one of its keys is given")
            if values:
                found |= {part: dataclasses.replace(owner, **values)} if part else values
        return dataclasses.replace(self, **found)

    @property
    def start_hub_angle(self) -> float:
        """Hub angle at the start of a pass, rad.

        By default it is -pi/2, if the wire is then clear of the bar and behind it. Otherwise the
        start is CLEAR_OF_BAR before the wire meets the bar.
        """
        if self.start_hub_angle_deg is not None:
            return math.radians(self.start_hub_angle_deg)
        meeting = self.bar_meeting_angle
        return START if meeting is None or meeting >= START else meeting - CLEAR_OF_BAR

    @property
    def bar_meeting_angle(self) -> float | None:
        """Hub angle at which the undeflected wire first touches the bar, rad; None if it passes
        under the bar.

        Seen from the hub's centre, with the root's direction as real axis, the bar's centre is S
        e^{i phi}, with phi falling. The bar touches a straight piece of direction e^{i eta}, at the
        distance h from the hub's centre, where S sin(phi - eta) = h + r_b + d/2. It touches a
        corner rho e^{i theta} where S^2 + rho^2 - 2 S rho cos(phi - theta) = (r_b + d/2)^2. The
        touch with the largest phi comes first.
        """
        if self.bar is None:
            return None
        corners = [complex(self.hub.radius - y, x) for x, y in ((0.0, 0.0), *self.bristle.path)]
        distance = math.hypot(*self.bar.centre)
        touches = list[float]()
        for start, end in itertools.pairwise(corners):
            along = (end - start) / abs(end - start)
            aside = (start / along).imag + self.bar_reach
            foot = math.sqrt(max(0.0, distance**2 - aside**2))
            if (start / along).real <= foot <= (end / along).real:
                touches.append(cmath.phase(along) + math.atan2(aside, foot))
            cosine = (distance**2 + abs(end) ** 2 - self.bar_reach**2) / (2.0 * distance * abs(end))
            if cosine <= 1.0:
                touches.append(cmath.phase(end) + math.acos(cosine))
        return (
            -math.atan2(self.bar.horizontal, self.bar.vertical) - max(touches) if touches else None
        )

    @property
    def workpart_depth(self) -> float:
        """Distance of the workpart's surface below the hub's centre, m: radius of the tip's circle
        less Delta.

        The tip's circle of an undeflected straight bristle has the radius r_h + L.
        """
        if self.workpart is None:
            raise ValueError("workpart = None: must be a Workpart where its depth is requested")
        x, y = self.bristle.tip
        return math.hypot(x, self.hub.radius - y) - self.workpart.penetration

    @property
    def bar_reach(self) -> float:
        """Distance from the bar's centre at which the wire's centre line touches the bar, r_b +
        d/2, m.
        """
        if self.bar is None:
            raise ValueError("bar = None: must be a Bar where its reach is requested")
        return self.bar.radius + self.bristle.wire_diameter / 2.0

    @property
    def bar_clearance(self) -> float:
        """Largest radius about the hub's centre that passes under the bar, S - r_b - d/2, m."""
        if self.bar is None:
            raise ValueError("bar = None: must be a Bar where its clearance is requested")
        return math.hypot(self.bar.horizontal, self.bar.vertical) - self.bar_reach

    @property
    def belt_damping(self) -> float:
        """Torsional damping c = 2 zeta sqrt(k_T I), N m s/rad; zeta is the damping ratio of the
        bristle on the belt.
        """
        return (
            2.0
            * self.belt.damping_ratio
            * math.sqrt(self.belt.stiffness * self.bristle.inertia_about_root)
        )


def checked_tool(tool: Any) -> Tool:
    """Return the tool. Raises ValueError for anything else, which for a path names ``read_tool``."""
    if not isinstance(tool, Tool):
        path = isinstance(tool, str | Path)
        advice = f"; read_tool({str(tool)!r}) reads one from a file" if path else ""
        raise ValueError(f"tool = {shown(tool)}: must be a Tool{advice}")
    return tool


PARTS: dict[str, tuple[type, ...]] = {
    "hub": (Hub,),
    "belt": (Belt,),
    "bristle": (Bristle,),
    "bar": (Bar, type(None)),
    "workpart": (Workpart, type(None)),
    "contact": (Contact,),
}
"""Classes of a tool's parts; NoneType means that the part may be absent."""


def tool_keys() -> dict[str, dict[str, tuple[str, Range | Choice]]]:
    """Return the keys of each part of a tool, each with its field and declaration.

    The part "" is the tool itself.
    """
    parts = {"": Tool, **{name: kinds[0] for name, kinds in PARTS.items()}}
    return {
        part: {each.key: (name, each) for name, each in declarations(of).items()}
        for part, of in parts.items()
    }


def key_unit(key: str) -> str:
    """Return the unit of a tool's key."""
    return next(keys[key][1].unit for keys in tool_keys().values() if key in keys)
