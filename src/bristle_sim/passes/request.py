"""Arrays of parameter values of a tool, checked and converted to passes block by block."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.declared import Choice, Computed, Range
from bristle_sim.parameters import FIELDS, KEYS, Tool
from bristle_sim.parameters.parts import mass_of_volume
from bristle_sim.parameters.tool import CLEAR_OF_BAR, START, checked_tool
from bristle_sim.passes.bar import closest, half_window, meeting_angle
from bristle_sim.passes.state import ROWS, Chosen, Passes
from bristle_sim.units import likely_key

MOST_RADIANS = 1e5
"""Largest phase angle by which the fastest oscillation may advance in a pass, rad. A step of the
integration covers some 2 rad of it."""

OVERLAP_ROUNDING = 1e-11
"""Largest overlap of bristle and obstacle at the start of a pass that counts as rounding error,
divided by the bristle's length."""

Values = dict[str, Array]


@dataclass(slots=True)
class Request:
    """The parameter arrays of a request, and the shape to which they broadcast.

    Attributes:
        tool: tool that supplies the values of all keys that are not in ``given``.
        given: requested values by key, in arrays.
        shape: shape to which the arrays broadcast.
        hub_turn: rotation of the hub after which a pass ends, rad.
    """

    tool: Tool
    given: Values
    shape: tuple[int, ...]
    hub_turn: float

    @property
    def size(self) -> int:
        """Number of passes."""
        return math.prod(self.shape)

    def at(self, numbers: Chosen) -> Values:
        """Return the values of all keys for the passes with the given indices.

        The keys of an absent part have the value 0.
        """
        own = dict.fromkeys(KEYS, 0.0) | key_values(self.tool)
        values = {key: np.full(len(numbers), value) for key, value in own.items()}
        places = np.unravel_index(numbers, self.shape or (1,))
        for key, array in self.given.items():
            values[key] = np.broadcast_to(array, self.shape or (1,))[places]
        with np.errstate(over="ignore", invalid="ignore"):  # refused tools have arbitrary numbers
            mass = mass_of_volume(
                values["bristle_length"], values["wire_diameter"], values["wire_density"]
            )
        given = values["bristle_mass"]
        values["bristle_mass"] = np.where(np.isnan(given), mass, given)
        return values


def request_of(tool: Tool, values: Mapping[str, Any], hub_turn: float) -> Request:
    """Check the values of the given keys, and return the request.

    Args:
        tool: tool that supplies the values of all keys that are not in ``values``.
        values: values or arrays of values by key.
        hub_turn: rotation of the hub after which a pass ends, rad.

    Raises:
        ValueError: for an unknown key, a text that is not a number with a unit of the key, or
            shapes that do not broadcast.
    """
    tool = checked_tool(tool)
    places = {each.key: part for part, fields in FIELDS.items() for each in fields.values()}
    given = Values()
    for key, value in values.items():
        if key not in places:
            raise ValueError(f"unknown key {key!r}; {likely_key(key, places)}")
        part = places[key]
        declared = KEYS[key]
        if part and getattr(tool, part) is None:
            raise ValueError(f"{part} = None: must be present where one of its keys is given")
        if isinstance(declared, Choice):
            tool = tool.replace(**{key: value})
        else:
            given[key] = _array(declared, value)
    try:
        shape = np.broadcast_shapes(*(each.shape for each in given.values()))
    except ValueError:
        shapes = ", ".join(f"{key} of shape {each.shape}" for key, each in given.items())
        raise ValueError(f"{shapes}: must be shapes that broadcast against each other") from None
    return Request(tool, given, shape, hub_turn)


def _array(declared: Range, value: Any) -> Array:
    """Return the values of a key as numbers in the key's unit; the value None becomes NaN.

    ``declared`` is the declaration of the key. An array of numbers is not checked against the key's
    range.
    """
    if hasattr(value, "dimensionality"):  # a quantity of pint, which would lose its unit
        raise declared.refusal(value)
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        raise declared.refusal(value) from None
    if array.dtype.kind not in "iuf":
        numbers = [declared.read(each) for each in array.flat]
        return np.array(numbers, dtype=float).reshape(array.shape)
    with np.errstate(over="ignore"):  # a number of a longer type may overflow
        return array.astype(float)


def key_values(tool: Tool) -> dict[str, float]:
    """Return the numerical values of a tool's keys.

    A value that is absent, or computed from other values, becomes NaN.
    """
    found = {}
    for part, fields in FIELDS.items():
        owner = getattr(tool, part) if part else tool
        for name, declared in fields.items():
            if owner is not None and isinstance(declared, Range):
                value = getattr(owner, name)
                found[declared.key] = (
                    math.nan if isinstance(value, Computed | None) else float(value)
                )
    return found


def passes_of(request: Request, numbers: Chosen) -> tuple[Passes, NDArray[np.object_]]:
    """Return the passes with the indices ``numbers`` that are not refused, and the reasons of the
    refusals.

    There is a reason for each index. The reason is empty for a pass that is not refused.
    """
    values = request.at(numbers)
    law = request.tool.contact.law
    reasons = np.full(len(numbers), "", dtype=object)
    if law != "energetic":
        reasons[:] = f"contact = {law}: must be energetic"
    with np.errstate(all="ignore"):  # numbers of refused tools
        passes = _built(request, values, numbers)
        for where, key, rule in _refusals(request, values, passes):
            for number in np.flatnonzero(where & (reasons == "")):
                reasons[number] = f"{key} = {values[key][number]:g}: {rule}"
    return passes.take(np.flatnonzero(reasons == "")), reasons


def _refusals(
    request: Request, values: Values, passes: Passes
) -> Iterator[tuple[Chosen, str, str]]:
    """Yield, for each requirement, the mask of the passes that violate it, a key and a message.

    The message says which requirement the value of the key must meet. A value is refused if it is
    outside the range of its key, if this method cannot compute a pass with it, or if it contradicts
    another dimension. A pass is also refused if the bristle overlaps an obstacle at the start (key:
    ``penetration`` or ``bar_horizontal``), or if the motion needs too many steps (key:
    ``belt_stiffness``).
    """
    for key, declared in KEYS.items():
        if key in request.given and isinstance(declared, Range):
            good = declared.holds(values[key]) | (declared.optional & np.isnan(values[key]))
            yield ~good, key, str(declared.refusal(0.0)).partition(": ")[2]
    yield values["wire_links"] != 1.0, "wire_links", "must be 1, a rigid bristle"
    yield values["knee_angle_deg"] != 0.0, "knee_angle_deg", "must be 0, a straight one"
    given = ~np.isnan(values["contact_duration"])
    yield given, "contact_duration", "must be left out with contact = energetic (in s)"
    yield values["hub_speed"] == 0.0, "hub_speed", "must be greater than 0 (in rad/s)"
    if request.tool.workpart:
        rule = "must be less than the bristle's reach beyond the hub's rim (in m)"
        yield ~(passes.depth > passes.radius), "penetration", rule
        gap = passes.depth - (passes.radius + 1.0) * np.cos(passes.start)
        rule = "the workpart must be clear of the bristle at the start (in m)"
        yield gap < -OVERLAP_ROUNDING, "penetration", rule
    if request.tool.bar:
        inside = ~(passes.bar_distance - passes.reach > passes.radius)
        yield inside, "bar_radius", "must leave the bar outside the root circle (in m)"
        gap = closest(passes, passes.start, passes.angle, passes.rate).gap
        rule = "the bar must be clear of the bristle at the start (in m)"
        yield gap < -OVERLAP_ROUNDING, "bar_horizontal", rule
    fastest = np.sqrt(passes.stiffness + passes.centrifugal) + passes.damping + 1.0
    rule = f"must be one whose pass lasts at most {MOST_RADIANS:g} radians of the fastest motion (in N m/rad)"
    yield ~(fastest * (passes.end - passes.start) <= MOST_RADIANS), "belt_stiffness", rule


def _built(request: Request, values: Values, numbers: Chosen) -> Passes:
    """Return the dimensionless passes with the given indices, each at its start."""
    tool = request.tool
    length = values["bristle_length"]
    speed = values["hub_speed"]
    stiffness = values["belt_stiffness"] / (values["bristle_mass"] * (length * speed) ** 2 / 3.0)
    radius = values["hub_radius"] / length
    distance = np.hypot(values["bar_horizontal"], values["bar_vertical"]) / length
    bar_angle = np.arctan2(-values["bar_horizontal"], values["bar_vertical"])
    wire_radius = 0.5 * values["wire_diameter"] / length
    reach = values["bar_radius"] / length + wire_radius
    depth = radius + 1.0 - values["penetration"] / length
    met = -np.arccos(np.clip(depth / (radius + 1.0), -1.0, 1.0))
    start = values["start_hub_angle_deg"]
    start = np.where(np.isnan(start), START, np.radians(start))
    if tool.bar:
        bar_met = bar_angle + meeting_angle(radius, distance, reach)
        early = np.isnan(values["start_hub_angle_deg"]) & (bar_met < START)
        start = np.where(early, bar_met - CLEAR_OF_BAR, start)
        met = np.minimum(met, bar_met)
    gravity = 1.5 * values["gravity"] / (length * speed**2)
    # without weight a wire stays radial until it meets bar or workpart; its flight begins just before
    resting = (gravity == 0.0) & (met - CLEAR_OF_BAR > start) & (start > met - np.pi)
    rows = {
        "number": numbers,
        "radius": radius,
        "stiffness": stiffness,
        "damping": 2.0 * values["belt_damping_ratio"] * np.sqrt(stiffness),
        "centrifugal": 1.5 * radius,
        "gravity": gravity,
        "rate_scale": 1.0 + np.sqrt(stiffness),
        "bar_distance": distance,
        "bar_angle": bar_angle,
        "reach": reach,
        "wire_radius": wire_radius,
        "bar_friction": values["bar_friction"],
        "bar_restitution": values["bar_restitution"],
        "flank": np.maximum(half_window(radius, distance, 1.0 + reach**2), 0.0),
        "window": half_window(radius, distance, (1.0 + reach) ** 2) if tool.bar else -1.0,
        "depth": depth if tool.workpart else np.inf,
        "start": start,
        "end": start + request.hub_turn,
        "hub_angle": np.where(resting, met - CLEAR_OF_BAR, start),
        "release": np.nan,
        "release_angle": np.nan,
    }
    passes = Passes(np.zeros((len(ROWS), len(numbers))))
    for name, row in rows.items():
        getattr(passes, name)[:] = row
    return passes
