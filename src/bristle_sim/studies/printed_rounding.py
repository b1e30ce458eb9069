"""How far the rounding of the printed inputs explains where printed and computed numbers differ.

Each printed input stands for any value within half a unit of its last digit. A computed number may move by the sum of what
these half units move it, and its standard deviation is that of inputs uniform within them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from bristle_sim.parameters import RETRACTION_AT_RELEASE, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import placed, radial_place, simulation
from bristle_sim.studies.cue_timing import PRINTED
from bristle_sim.studies.strike_point import keys_of, tool_of_keys
from bristle_sim.theory import cueing

Measures = Mapping[str, float | None]

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

STEP = math.radians(0.5)
"""Turn of the bar over which the slope of the lag is taken: about what rounding turns it by."""


def propagated(
    function: Callable[..., Measures], values: Mapping[str, float], half_widths: Mapping[str, float]
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


def rounding_rows(tool: Tool, settings: Settings) -> list[dict[str, Any]]:
    """Return a row for each printed number and way to compute it; none for a tool that is not the printed one."""
    if tool != Tool():
        return []
    values = {key: float(value) for key, value in keys_of(tool).items() if key in HALF_UNITS}
    values["retraction_deg"] = math.degrees(RETRACTION_AT_RELEASE)
    ways: dict[str, Callable[..., dict[str, float]]] = {
        "formula": lambda **keys: _by_formula(cueing.cue, keys),
        "stiffened formula": lambda **keys: _by_formula(cueing.stiffened_cue, keys),
        "simulated pass": _simulation(tool, settings),
    }
    rows = []
    for way, function in ways.items():
        changes, computed = propagated(function, values, HALF_UNITS), function(**values)
        for name, printed in PRINTED.items():
            moved = changes[name]
            row = {
                "output": name.removeprefix("highest_"),
                "by": way,
                "computed": computed[name],
                "printed": printed,
                "relative_difference": (computed[name] - printed) / printed,
                "relative_worst_case": sum(map(abs, moved.values())) / printed,
                "relative_std": math.sqrt(sum(each**2 for each in moved.values()) / 3.0) / printed,
                "largest": max(moved, key=lambda key: abs(moved[key])),
            }
            rows.append(row)
    return rows


def rounding_remarks(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Say what of each difference from print the rounding explains at most, as a table."""
    columns = "{:<18}{:<18}{:>8}{:>8}{:>7}{:>8}{:>6}{:>10}  {}"
    heads = ("number", "by", "computed", "printed", "diff.", "at most", "std", "explained", "mostly by")
    title = "computed less printed, how far rounding of the printed inputs moves the computed, and what that explains at most:"
    lines = ["", title, columns.format(*heads)] if rows else []
    for row in rows:
        difference, most, std = (row[f"relative_{name}"] for name in ("difference", "worst_case", "std"))
        parts = (f"{difference:.1%}", f"{most:.1%}", f"{std:.1%}", f"{min(1.0, most / abs(difference)):.0%}")
        numbers = (f"{row[side]:.4g}" for side in ("computed", "printed"))
        lines.append(columns.format(row["output"], row["by"], *numbers, *parts, row["largest"]))
    return lines


def _split(keys: Mapping[str, float]) -> tuple[Tool, float]:
    """Return tool and retraction, rad; the bar's radius, which is not printed, lets the wire slip off at that retraction."""
    own = dict(keys)
    retraction = math.radians(own.pop("retraction_deg"))
    tip = float(cueing.tip_radius(own["hub_radius"], own["bristle_length"], retraction))
    distance = math.hypot(own["bar_horizontal"], own["bar_vertical"])
    return tool_of_keys(**own, bar_radius=distance - tip - 0.5 * own["wire_diameter"]), retraction


def _by_formula(cue: Callable[[Tool, float], cueing.Cue], keys: Mapping[str, float]) -> dict[str, float]:
    found = cue(*_split(keys))
    place = (math.degrees(found.bar_direction), found.bar_horizontal, found.bar_vertical)
    return dict(zip(PRINTED, (found.highest_relative_speed, *place), strict=True))


def _simulation(tool: Tool, settings: Settings) -> Callable[..., dict[str, float]]:
    """Return the strike where the bar stands, and where it would have to stand for a radial one.

    The latter by one step of Newton's method from the printed tool's own direction; the lag is nearly linear in it.
    """
    strike = simulation(settings)
    direction = radial_place(tool, strike).direction
    ahead = strike(placed(tool, direction + STEP))["lag_deg_at_contact"] or math.nan

    def by_simulation(**keys: float) -> dict[str, float]:
        """Return the printed quantities of the tool with these key values."""
        other, _ = _split(keys)
        lag = strike(placed(other, direction))["lag_deg_at_contact"] or 0.0
        bar = placed(other, turned := direction - lag * STEP / ahead).bar
        speed = strike(other)["relative_speed_at_contact"]
        assert bar is not None
        assert speed is not None
        return dict(zip(PRINTED, (speed, math.degrees(turned), bar.horizontal, bar.vertical), strict=True))

    return by_simulation
