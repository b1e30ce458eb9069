"""Draw maps of the strike over the bar's position, with the printed, the formula's and the best positions on them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.parameters import Bar
from bristle_sim.render.panels import panel_title
from bristle_sim.render.style import BLACK, BLUE, GREY, VERMILION, axes_at, blank_figure, styled
from bristle_sim.studies.cue_map import CueMap

if TYPE_CHECKING:
    import xarray as xr

MILLIMETRES = 1e3
PANELS: tuple[tuple[str, str, str, float, str], ...] = (
    ("lag_deg_at_contact", "lag at the strike", "°", 1.0, "RdBu"),
    ("tip_speed_at_contact", "tip speed at the strike", "m/s", 1.0, "viridis"),
    ("normal_compressive_work", "normal work of compression", "mJ", -1e3, "viridis"),
    ("crater_depth", "crater depth", "µm", 1e6, "viridis"),
)
"""Result, title, unit shown, factor to it, colours."""

HIGHEST = 97.0
"""Percentile of the values at which the colours end."""

AXES = {
    "hub_speed": ("hub speed (rad/s)", 1.0),
    "belt_stiffness": ("belt stiffness (mN·m/rad)", 1e3),
    "belt_damping_ratio": ("belt damping ratio", 1.0),
}


@styled()
def map_figure(found: CueMap, maps: xr.Dataset) -> Figure:
    """Draw lag, tip speed, normal work and crater depth over the bar's position, and how the best direction moves.

    ``maps`` is what :func:`bristle_sim.studies.cue_map.position_map` computes.
    """
    figure = blank_figure(16.0, 19.4)
    for number, (name, title, unit, factor, colors) in enumerate(PANELS):
        axes = axes_at(figure, 1.5 + 7.9 * (number % 2), 13.1 - 6.6 * (number // 2), 5.2, 4.9)
        _draw_map(figure, axes, maps, name, unit, factor, colors)
        _mark_places(axes, found)
        panel_title(axes, "abcd"[number], title, "white: the bar cues no strike")
        if number % 2 == 0:
            axes.set_ylabel("S_V, normal to the workpart (mm)")
        if number >= 2:
            axes.set_xlabel("S_H, along the workpart (mm)")
    for number, key in enumerate(AXES):
        _draw_moves(axes_at(figure, 1.5 + 4.95 * number, 1.7, 4.0, 2.5), found, key, first=number == 0)
    _explain(figure, found)
    return figure


def _draw_map(figure: Figure, axes: Axes, maps: xr.Dataset, name: str, unit: str, factor: float, colors: str) -> None:
    x, y = (maps[each].values * MILLIMETRES for each in ("bar_horizontal", "bar_vertical"))
    values = np.full((y.size, x.size), math.nan)
    if name in maps:
        values = factor * maps[name].values
    low, high = _limits(values, symmetric=colors == "RdBu")
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


def _limits(values: np.ndarray, *, symmetric: bool) -> tuple[float, float]:
    """Return the limits of the colours; the few points next to a jam, where work grows without bound, lie beyond."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return 0.0, 1.0
    low, high = float(finite.min()), float(np.percentile(finite, HIGHEST))
    most = max(-low, float(finite.max()))
    return (-most, most) if symmetric else (low, max(high, low + 1e-12))


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
    places["fastest tip"] = (found.fastest.direction, look | {"marker": "+", "markersize": 7.0})
    return places


def _mark_places(axes: Axes, found: CueMap) -> None:
    """Mark the places on the circle of the bar's distance; the map's limits stay."""
    assert found.tool.bar is not None
    limits = axes.get_xlim(), axes.get_ylim()
    distance = math.hypot(*found.tool.bar.centre) * MILLIMETRES
    turn = np.linspace(0.0, np.pi, 721)
    axes.plot(distance * np.sin(turn), distance * np.cos(turn), color=GREY, linewidth=0.7, dashes=(3, 2))
    for name, (direction, look) in _places(found).items():
        axes.plot([distance * math.sin(direction)], [distance * math.cos(direction)], gid=name, zorder=5, **look)
    axes.set(xlim=limits[0], ylim=limits[1])


def _draw_moves(axes: Axes, found: CueMap, key: str, *, first: bool) -> None:
    """Draw the direction for a radial strike over one parameter, simulated and by the formula."""
    own = {"hub_speed": found.tool.hub.speed, "belt_stiffness": found.tool.belt.stiffness}
    label, factor = AXES[key]
    rows = [
        (row["value"], row["bar_direction_for_radial_strike_deg"], row["theory"])
        for row in found.moves
        if row["key"] == key
    ]
    formula = None if found.formula is None else math.degrees(found.formula)
    rows.append((own.get(key, found.tool.belt.damping_ratio), math.degrees(found.radial.direction), formula))
    rows.sort(key=lambda row: row[0])
    value, simulated, theory = (np.array(each, dtype=float) for each in zip(*rows, strict=True))
    axes.plot(factor * value, simulated, "o-", color=VERMILION, markersize=3.0, gid=f"simulated {key}")
    axes.plot(factor * value, theory, "^--", color=BLUE, markersize=3.0, gid=f"formula {key}")
    axes.set_xlabel(label)
    if first:
        axes.set_ylabel("bar direction (°)")
        panel_title(axes, "e", "the bar direction for a radial strike moves with hub speed, stiffness and damping")


def _explain(figure: Figure, found: CueMap) -> None:
    """Explain the marks at the foot."""
    handles = [Line2D([], [], **look) for _, look in _places(found).values()]
    names = [f"{name}, {math.degrees(direction):.2f}°" for name, (direction, _) in _places(found).items()]
    handles.append(Line2D([], [], color=BLACK, linewidth=0.9))
    names.append("lag zero")
    figure.legend(handles, names, loc="lower center", ncols=5, columnspacing=1.0, handletextpad=0.3)
