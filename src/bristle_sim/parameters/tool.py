"""Parameters of the whole tool: hub, belt and bristle, with or without bar and workpart."""

from __future__ import annotations

import cmath
import dataclasses
import itertools
import math
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any

from bristle_sim.declared import Computed, Declared, declarations
from bristle_sim.fields import quantity
from bristle_sim.parameters.parts import Bar, Belt, Bristle, Contact, Hub, Workpart
from bristle_sim.units import likely_key, shown

# Default hub angle at the start of a pass, rad: a quarter of a revolution before the direction of
# the workpart.
START = -math.pi / 2.0
# Rotation of the hub, rad, from the start of a pass to the touch of the bar if this touch is before
# START. The gap at the start is then far larger than its rounding error.
CLEAR_OF_BAR = math.radians(5.0)


@dataclass(frozen=True, slots=True)
class Tool(Declared):
    """The bristle-blasting tool.

    A tool with ``bar=None`` or ``workpart=None`` has no such part. The defaults are those of the
    dissertation (Zhang 2020, eqs. 2.2 and 2.3). The belt stiffness printed there in N m/rad is
    taken to be in N m/deg.

    Raises ValueError for a part of the wrong class, for a workpart that would touch the hub's rim,
    and for a bar that would touch the root circle.
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
        beside = math.inf
        if self.bar is not None:
            beside = math.hypot(*self.bar.centre) - self.bar_reach
        if self.bar is not None and beside <= self.hub.radius:
            if beside + self.bar.radius <= self.hub.radius:  # no bar is thin enough
                raise ValueError(
                    f"hub_radius = {self.hub.radius:g}: must be less than the bar centre's distance minus bar_radius and half"
                    f" of wire_diameter = {beside:g}, or the bar would stand in the root circle (in m)"
                )
            raise ValueError(
                f"bar_radius = {self.bar.radius:g}: must be less than the bar centre's distance minus hub_radius and half"
                f" of wire_diameter = {beside + self.bar.radius - self.hub.radius:g}, or the bar"
                " would stand in the root circle (in m)"
            )

    def __repr__(self) -> str:
        """Return a text of one line per part, in customary units such as mm and rpm."""
        return "\n".join(["Tool:", *(f"  {part}: {words}" for part, words in self._in_words())])

    def _repr_html_(self) -> str:
        """Return an HTML table of the parts for display in a notebook."""
        rows = (
            f"<tr><th>{part}</th><td style='text-align:left'>{escape(words)}</td></tr>"
            for part, words in self._in_words()
        )
        return f"<table>{''.join(rows)}</table>"

    def _in_words(self) -> list[tuple[str, str]]:
        """Return the name and the values of each part as text.

        Fields without a value are left out.
        """
        found = []
        for part, fields in FIELDS.items():
            owner = getattr(self, part) if part else self
            given = {
                name.removesuffix("_deg").replace("_", " "): declared.displayed(value)
                for name, declared in fields.items()
                if owner is not None and (value := getattr(owner, name)) is not None
            }
            words = ", ".join(" ".join(each) for each in given.items())
            found.append((part or "tool", words or "absent"))
        return [*found[1:], found[0]]

    def replace(self, **changes: Any) -> Tool:
        """Return a copy of the tool in which some values are changed.

        An example is ``tool.replace(hub_speed="3000 rpm", friction=0.4, bar=None)``.

        Args:
            changes: new values by key of the command line, or whole parts by name. A value is a
                number in SI units, or a text with a unit.

        Raises:
            ValueError: for an unknown name, a refused value, or a key of an absent part; the
                message is one line.
        """
        found = dict[str, Any]()
        given = dict[str, Any]()
        for name, value in changes.items():
            if name in PARTS and (name not in KEYS or isinstance(value, PARTS[name])):
                found[name] = value
            elif name not in KEYS:
                raise ValueError(f"unknown key {name!r}; {likely_key(name, {*PARTS, *KEYS})}")
            else:  # a copied mass is a given one
                given[name] = float(value) if isinstance(value, Computed) else value
        for part, fields in FIELDS.items():
            values = {name: given[each.key] for name, each in fields.items() if each.key in given}
            if values and not part:
                found |= values
            elif values:
                owner = found.get(part, getattr(self, part))
                if owner is None:
                    raise ValueError(
                        f"{part} = None: must be present where one of its keys is given"
                    )
                found[part] = dataclasses.replace(owner, **values)
        return dataclasses.replace(self, **found)

    @property
    def start_hub_angle(self) -> float:
        """Hub angle at the start of a pass, rad.

        By default the angle is -pi/2 if the undeflected wire first touches the bar at a later hub
        angle. Otherwise the pass starts 5 deg before this first touch.

        The touch is computed in complex numbers, with the hub's centre as origin and the root's
        direction as real axis. There the bar's centre is S e^{i phi}, and phi decreases as the hub
        rotates. The bar's radius is r_b and the wire's diameter d. The bar touches a straight
        segment of the wire, of direction e^{i eta} and at the distance h from the hub's centre, if
        S sin(phi - eta) = h + r_b + d/2. The bar touches a corner of the wire at rho e^{i theta} if
        S^2 + rho^2 - 2 S rho cos(phi - theta) = (r_b + d/2)^2. The first touch has the largest phi.
        """
        if self.start_hub_angle_deg is not None:
            return math.radians(self.start_hub_angle_deg)
        if self.bar is None:
            return START
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
        meeting = -math.atan2(self.bar.horizontal, self.bar.vertical) - max(
            touches, default=-math.inf
        )
        return START if meeting >= START else meeting - CLEAR_OF_BAR

    @property
    def workpart_depth(self) -> float:
        """Distance of the workpart's surface below the hub's centre, m.

        The distance is the radius of the circle on which the undeflected tip moves, minus the
        penetration Delta. For a straight bristle this radius is the hub's radius plus the bristle's
        length.
        """
        if self.workpart is None:
            raise ValueError("workpart = None: must be a Workpart where its depth is requested")
        x, y = self.bristle.path[-1]
        return math.hypot(x, self.hub.radius - y) - self.workpart.penetration

    @property
    def bar_reach(self) -> float:
        """Distance of the wire's centre line from the bar's centre in contact, m.

        The distance is the bar's radius plus half the wire's diameter.
        """
        if self.bar is None:
            raise ValueError("bar = None: must be a Bar where its reach is requested")
        return self.bar.radius + self.bristle.wire_diameter / 2.0

    @property
    def belt_damping(self) -> float:
        """Torsional damping of the belt, c = 2 zeta sqrt(k_T I), N m s/rad.

        zeta is the damping ratio of the bristle on the belt, k_T the belt's stiffness, and I the
        bristle's moment of inertia about its root.
        """
        return (
            2.0
            * self.belt.damping_ratio
            * math.sqrt(self.belt.stiffness * self.bristle.inertia_about_root)
        )


def checked_tool(tool: Any) -> Tool:
    """Check that an object is a ``Tool``, and return it.

    Raises:
        ValueError: for any other object; for a file name the message advises ``read_tool``.
    """
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
"""Classes of which each part of a tool must be; NoneType means that the part may be absent."""


FIELDS = {
    "": declarations(Tool),
    **{part: declarations(kinds[0]) for part, kinds in PARTS.items()},
}
"""Declarations of the fields of each part of a tool, by part and field. The part "" is the tool
itself."""

KEYS = {each.key: each for fields in FIELDS.values() for each in fields.values()}
"""Declaration of each key of a tool."""
