"""How far the rounding of the printed inputs explains where printed and computed numbers differ.

Each printed input stands for any value within half a unit of its last digit. A computed number may move by the sum of what
these half units move it, and its standard deviation is that of inputs uniform within them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import placed, radial_place, simulation
from bristle_sim.studies.strike_point import keys_of, tool_of_keys
from bristle_sim.theory import cueing

RETRACTION_DEG = 44.5
"""theta_p (Zhang 2020, eq. 2.2)."""

HALF_UNITS = {
    "hub_speed": 0.05,
    "hub_radius": 5e-5,
    "bristle_length": 5e-4,
    "bristle_mass": 5e-9,
    "wire_diameter": 5e-6,
    "belt_stiffness": math.degrees(5e-6),
    "penetration": 5e-5,
    "bar_horizontal": 5e-6,
    "bar_vertical": 5e-5,
    "retraction_deg": 0.05,
}
"""Half a unit of the last digit of 261.8 rad/s, 27.5 mm, 0.027 m, 8.387e-5 kg, 0.71 mm, 0.00041 N m (per degree), 4.5 mm,
50.37 mm, 22.5 mm and 44.5 degrees (Zhang 2020, eqs. 2.2 and 2.3, captions of figs. 2.7 and 4.13)."""

PRINTED = {
    "relative_speed": 845.6,
    "bar_direction_deg": math.degrees(math.atan2(0.05037, 0.0225)),
    "bar_horizontal": 0.05037,
    "bar_vertical": 0.0225,
}

STEP = math.radians(0.5)
"""Turn of the bar over which the slope of the lag is taken: about what rounding turns it by."""

Outputs = dict[str, float | None]


def rounding_rows(tool: Tool, settings: Settings) -> list[dict[str, Any]]:
    """One row for each printed number and way to compute it; none for a tool that is not the printed one."""
    if tool != Tool():
        return []
    values = {key: float(value) for key, value in keys_of(tool).items() if key in HALF_UNITS}
    values["retraction_deg"] = RETRACTION_DEG
    ways: dict[str, Callable[..., Outputs]] = {
        "formula": lambda **keys: _by_formula(cueing.cue, keys),
        "stiffened formula": lambda **keys: _by_formula(cueing.stiffened_cue, keys),
        "simulated pass": _simulation(tool, settings),
    }
    rows = []
    for way, function in ways.items():
        changes = propagated(function, values, HALF_UNITS)
        computed = function(**values)
        rows += [_row(name, way, computed[name], changes[name]) for name in PRINTED if name in changes]
    return rows


def propagated(
    function: Callable[..., Outputs], values: Mapping[str, float], half_widths: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    """Half the change of every output between both ends of each input's interval, the others at their values.

    For small half-widths h_i it is dy/dx_i h_i; uniform inputs then give the standard deviation sqrt(sum (.)^2/3) and, at
    worst, the deviation sum |.|.
    """
    changes: dict[str, dict[str, float]] = {}
    for key, half_width in half_widths.items():
        low, high = (function(**{**values, key: values[key] + sign * half_width}) for sign in (-1.0, 1.0))
        for name, value in high.items():
            other = low[name]
            if value is not None and other is not None:
                changes.setdefault(name, {})[key] = 0.5 * (value - other)
    return changes


def _row(name: str, way: str, computed: float | None, changes: Mapping[str, float]) -> dict[str, Any]:
    printed = PRINTED[name]
    assert computed is not None
    return {
        "output": name,
        "by": way,
        "computed": computed,
        "printed": printed,
        "relative_difference": (computed - printed) / printed,
        "relative_worst_case": sum(map(abs, changes.values())) / printed,
        "relative_std": math.sqrt(sum(each**2 for each in changes.values()) / 3.0) / printed,
        "largest": max(changes, key=lambda key: abs(changes[key])),
    }


def _split(keys: Mapping[str, float]) -> tuple[Tool, float]:
    """Tool and retraction (rad); the bar's radius, which is not printed, lets the wire slip off at that retraction."""
    own = dict(keys)
    retraction = math.radians(own.pop("retraction_deg"))
    tip = float(cueing.tip_radius(own["hub_radius"], own["bristle_length"], retraction))
    distance = math.hypot(own["bar_horizontal"], own["bar_vertical"])
    return tool_of_keys(**own, bar_radius=distance - tip - 0.5 * own["wire_diameter"]), retraction


def _by_formula(cue: Callable[[Tool, float], cueing.Cue], keys: Mapping[str, float]) -> Outputs:
    found = cue(*_split(keys))
    place = (math.degrees(found.bar_direction), found.bar_horizontal, found.bar_vertical)
    return dict(zip(PRINTED, (found.highest_relative_speed, *place), strict=True))


def _simulation(tool: Tool, settings: Settings) -> Callable[..., Outputs]:
    """The strike where the bar stands, and where it would have to stand for a radial one.

    The latter by one step of Newton's method from the printed tool's own direction; the lag is nearly linear in it.
    """
    strike = simulation(settings)
    direction = radial_place(tool, strike).direction
    ahead = strike(placed(tool, direction + STEP))["lag_deg_at_contact"] or math.nan

    def by_simulation(**keys: float) -> Outputs:
        other, _ = _split(keys)
        lag = strike(placed(other, direction))["lag_deg_at_contact"] or 0.0
        turned = direction - lag * STEP / ahead
        bar = placed(other, turned).bar
        assert bar is not None
        speed = strike(other)["relative_speed_at_contact"]
        return dict(zip(PRINTED, (speed, math.degrees(turned), bar.horizontal, bar.vertical), strict=True))

    return by_simulation
