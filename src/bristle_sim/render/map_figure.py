"""Maps of the quantities of a strike over the bar's position, with marked positions.

The marks are the printed position, the position by the formula, and the best positions.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.parameters import Bar
from bristle_sim.render.colours import BLACK, BLUE, GREY, VERMILION
from bristle_sim.render.style import (
    MILLIMETRES,
    QUANTITIES,
    add_panel,
    blank_figure,
    draw_colours,
    styled,
    write_key,
)
from bristle_sim.studies.cue_map import CueMap

MAPS = ("lag_deg_at_contact", "tip_speed_at_contact", "normal_compressive_work", "crater_depth")

ARC: dict[str, Any] = {
    "color": GREY,
    "linewidth": 0.7,
    "dashes": (3, 2),
}  # style of the arc of bar positions at the bar's distance from the hub's centre
ZERO: dict[str, Any] = {"color": BLACK, "linewidth": 0.9}  # style of the line of zero lag
COLOUR_PERCENTILE = 97.0
"""Percentile of the values at the end of the colour scale.

The few values beyond it belong to points near a jam, where the work grows without bound."""


@styled()
def map_figure(found: CueMap, x: Array, y: Array, maps: Mapping[str, Array]) -> Figure:
    """Draw lag, tip speed, normal work of compression and crater depth over the bar's position.

    ``x``, ``y`` and ``maps`` are the result of :func:`bristle_sim.studies.cue_map.position_map`.
    """
    figure = blank_figure(16.0, 15.3)
    places = _places(found)
    lags = maps["lag_deg_at_contact"]
    for number, name in enumerate(MAPS):
        title, unit, factor = QUANTITIES[name]
        place = (1.5 + 7.9 * (number % 2), 9.0 - 6.6 * (number // 2), 5.2, 4.9)
        axes = add_panel(figure, place, title, "white: the bar cues no strike")
        places_shown = (x * MILLIMETRES, y * MILLIMETRES)
        _draw_map(axes, places_shown, factor * maps[name], unit, signed=number == 0)
        if np.nanmin(lags) < 0.0 < np.nanmax(lags):
            axes.contour(*places_shown, lags, levels=[0.0], colors=BLACK, linewidths=0.9)
        axes.autoscale_view()  # matplotlib puts it off until the limits are read
        axes.autoscale(enable=False)
        axes.plot(*_places_at(found, np.linspace(0.0, np.pi, 721)), **ARC)
        for direction, look in places.values():
            axes.plot(*_places_at(found, np.array([direction])), zorder=5, **look)
        if number % 2 == 0:
            axes.set_ylabel("S_V, normal to the workpart (mm)")
        if number >= 2:
            axes.set_xlabel("S_H, along the workpart (mm)")
    words = "Arrows on the scales: cells beside a jam, where the work has no bound, lie beyond the colours."
    figure.text(1.5 / 16.0, 1.1 / 15.3, words, fontsize=7.0, color=GREY)
    named = {
        f"{name}, {math.degrees(direction):.2f}°": look
        for name, (direction, look) in places.items()
    }
    named |= {"lag zero": ZERO, "bar at its distance from the hub": ARC}
    write_key(figure, named, ncols=3, columnspacing=1.0, handletextpad=0.3)
    return figure


def _draw_map(
    axes: Axes, places: tuple[Array, Array], values: Array, unit: str, *, signed: bool
) -> None:
    finite = values[np.isfinite(values)] if np.isfinite(values).any() else np.array([0.0, 1.0])
    low, high = float(finite.min()), float(np.percentile(finite, COLOUR_PERCENTILE))
    if signed:
        high = float(np.abs(finite).max())
        low = -high
    look: dict[str, Any] = {
        "cmap": "RdBu" if signed else "viridis",
        "vmin": low,
        "vmax": max(high, low + 1e-12),
    }
    extend = "max" if finite.max() > high else "neither"
    scale = draw_colours(axes, *places, values, extend, **look)
    scale.set_title(unit, fontsize=7.0, color=GREY)
    axes.set_aspect("equal")


def _places(found: CueMap) -> dict[str, tuple[float, dict[str, Any]]]:
    """Return the marked directions of the bar from the hub's centre, rad, by name, each with its
    look.
    """
    assert found.tool.bar is not None
    own = math.atan2(found.tool.bar.horizontal, found.tool.bar.vertical)
    bar = "printed position" if found.tool.bar == Bar() else "the tool's bar"
    look = {
        "linestyle": "none",
        "markeredgecolor": BLACK,
        "markeredgewidth": 0.7,
        "markersize": 5.5,
    }
    places = {bar: (own, look | {"marker": "s", "markersize": 4.5, "markerfacecolor": "white"})}
    if found.formula is not None:
        places["by the formula"] = (found.formula, look | {"marker": "^", "markerfacecolor": BLUE})
    places["radial strike"] = (
        found.radial.direction,
        look | {"marker": "o", "markerfacecolor": VERMILION},
    )
    places["fastest tip at this distance"] = (
        found.fastest.direction,
        look | {"marker": "+", "markersize": 7.0},
    )
    return places


def _places_at(found: CueMap, directions: Array) -> Array:
    """Return positions of the bar in given directions from the hub's centre, rad.

    The distance from the hub's centre is that of the tool's bar. The result is in mm and has the
    shape (2, n).
    """
    assert found.tool.bar is not None
    return (
        math.hypot(*found.tool.bar.centre)
        * MILLIMETRES
        * np.stack([np.sin(directions), np.cos(directions)])
    )
