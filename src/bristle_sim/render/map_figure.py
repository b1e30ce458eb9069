"""Draw maps of the strike over the bar's position, with the printed, the formula's and the best positions on them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.arrays import Array
from bristle_sim.parameters import Bar
from bristle_sim.render.colours import BLACK, BLUE, GREY, VERMILION
from bristle_sim.render.style import MILLIMETRES, QUANTITIES, add_panel, axes_at, blank_figure, styled
from bristle_sim.studies.cue_map import MOVES, CueMap

if TYPE_CHECKING:
    import xarray as xr

MAPS = ("lag_deg_at_contact", "tip_speed_at_contact", "normal_compressive_work", "crater_depth")

ARC: dict[str, Any] = {"color": GREY, "linewidth": 0.7, "dashes": (3, 2)}  # of the bar's places at its distance
COLOUR_PERCENTILE = 97.0
"""Percentile of the values at which the colours end: the few points next to a jam, where work has no bound, lie beyond."""


@styled()
def map_figure(found: CueMap, maps: xr.Dataset) -> Figure:
    """Draw lag, tip speed, normal work and crater depth over the bar's position, and how the best direction moves.

    ``maps`` is what :func:`bristle_sim.studies.cue_map.position_map` computes.
    """
    lower = 5.4 if found.moves else 0.0
    figure, places = blank_figure(16.0, 15.3 + lower), _places(found)
    for number, name in enumerate(MAPS):
        title, unit, factor = QUANTITIES[name]
        place = (1.5 + 7.9 * (number % 2), lower + 9.0 - 6.6 * (number // 2), 5.2, 4.9)
        axes = add_panel(figure, place, title, "white: the bar cues no strike")
        values = factor * maps[name].values if name in maps else None
        _draw_map(figure, axes, maps, values, unit, "viridis" if number else "RdBu")
        axes.autoscale_view()  # matplotlib puts it off until something asks for the limits
        axes.autoscale(enable=False)
        axes.plot(*_places_at(found, np.linspace(0.0, np.pi, 721)), **ARC)
        for direction, look in places.values():
            axes.plot(*_places_at(found, np.array([direction])), zorder=5, **look)
        axes.set_ylabel("" if number % 2 else "S_V, normal to the workpart (mm)")
        axes.set_xlabel("S_H, along the workpart (mm)" if number >= 2 else "")
    words = "Arrows on the scales: cells beside a jam, where the work has no bound, lie beyond the colours."
    figure.text(1.5 / 16.0, (lower + 1.1) / (15.3 + lower), words, fontsize=7.0, color=GREY)
    if found.moves:
        _draw_moves(figure, found)
    named = {f"{name}, {math.degrees(direction):.2f}°": look for name, (direction, look) in places.items()}
    named |= {"lag zero": {"color": BLACK, "linewidth": 0.9}, "bar at its distance from the hub": ARC}
    handles = [Line2D([], [], label=name, **look) for name, look in named.items()]
    figure.legend(handles=handles, loc="lower center", ncols=3, columnspacing=1.0, handletextpad=0.3)
    return figure


def _draw_map(figure: Figure, axes: Axes, maps: xr.Dataset, values: np.ndarray | None, unit: str, colors: str) -> None:
    x, y = (maps[each].values * MILLIMETRES for each in ("bar_horizontal", "bar_vertical"))
    values = np.full((y.size, x.size), math.nan) if values is None else values
    finite = values[np.isfinite(values)]
    low, high = 0.0, 1.0
    if finite.size and colors == "RdBu":
        high = float(np.abs(finite).max())
        low = -high
    elif finite.size:
        low = float(finite.min())
        high = max(float(np.percentile(finite, COLOUR_PERCENTILE)), low + 1e-12)
    axes.grid(visible=False)
    image = axes.pcolormesh(x, y, values, cmap=colors, shading="nearest", rasterized=True, vmin=low, vmax=high)
    left, bottom, width, height = axes.get_position().bounds
    scale = figure.add_axes((left + 1.03 * width, bottom, 0.04 * width, height))
    figure.colorbar(image, cax=scale, extend="max" if np.nanmax(values, initial=high) > high else "neither")
    scale.set_title(unit, fontsize=7.0, color=GREY)
    axes.set_aspect("equal")
    lag = maps.get("lag_deg_at_contact")
    if lag is not None and np.nanmin(lag.values) < 0.0 < np.nanmax(lag.values):
        axes.contour(x, y, lag.values, levels=[0.0], colors=[BLACK], linewidths=0.9)


def _places(found: CueMap) -> dict[str, tuple[float, dict[str, Any]]]:
    """Return directions of the bar by name, with their marks."""
    assert found.tool.bar is not None
    own = math.atan2(found.tool.bar.horizontal, found.tool.bar.vertical)
    bar = "printed position" if found.tool.bar == Bar() else "the tool's bar"
    look = {"linestyle": "none", "markeredgecolor": BLACK, "markeredgewidth": 0.7, "markersize": 5.5}
    places = {bar: (own, look | {"marker": "s", "markersize": 4.5, "markerfacecolor": "white"})}
    if found.formula is not None:
        places["by the formula"] = (found.formula, look | {"marker": "^", "markerfacecolor": BLUE})
    places["radial strike"] = (found.radial.direction, look | {"marker": "o", "markerfacecolor": VERMILION})
    places["fastest tip at this distance"] = (found.fastest.direction, look | {"marker": "+", "markersize": 7.0})
    return places


def _places_at(found: CueMap, directions: Array) -> Array:
    """Return the bar's places at its distance from the hub's centre in some directions, shape (2, n), mm."""
    assert found.tool.bar is not None
    return math.hypot(*found.tool.bar.centre) * MILLIMETRES * np.stack([np.sin(directions), np.cos(directions)])


def _draw_moves(figure: Figure, found: CueMap) -> None:
    """Draw the direction for a radial strike over each of three parameters, simulated and by the formula."""
    hub, belt = found.tool.hub, found.tool.belt
    own = [(hub.speed, "hub speed (rad/s)"), (belt.stiffness, "belt stiffness (N·m/rad)")]
    own.append((belt.damping_ratio, "belt damping ratio"))
    formula = None if found.formula is None else math.degrees(found.formula)
    title = "the bar direction for a radial strike over hub speed, stiffness and damping"
    for number, (key, (value, label)) in enumerate(zip(MOVES, own, strict=True)):
        spot = (1.5 + 4.95 * number, 2.1, 4.0, 2.5)
        axes = axes_at(figure, *spot) if number else add_panel(figure, spot, title)
        moved = [list(row.values())[1:4] for row in found.moves if row["key"] == key]
        rows = sorted([*moved, [value, math.degrees(found.radial.direction), formula]], key=lambda row: row[0])
        values, simulated, theory = np.array(rows, dtype=float).T
        axes.plot(values, simulated, "o-", color=VERMILION, markersize=3.0)
        axes.plot(values, theory, "^--", color=BLUE, markersize=3.0)
        axes.locator_params("x", nbins=4)
        axes.set(xlabel=label, ylabel="" if number else "bar direction (°)")
