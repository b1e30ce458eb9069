"""Draw panels of curves: closed forms as lines, what checks them as points, levels, and the case at hand."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.dissertation.redrawn import SOURCES, Level, Panel
from bristle_sim.render.colours import BLACK, GREY, SERIES, VERMILION
from bristle_sim.render.style import axes_at

NOTHING = 1e-12
"""Less than this, in the unit shown, is rounding of zero."""

OPERATING_POINT: dict[str, Any] = {"marker": "o", "color": "#1f4fff", "markersize": 6.5, "markeredgecolor": "white"}
"""A mark without a label: the dissertation marks its operating point with a blue round dot."""

_DASHES = ((4.0, 2.0), (1.0, 1.5))
"""Dashes of level lines, in their order."""

_SIDES = {"right": (6, -9, "left"), "left": (-5, -11, "right"), "above": (0, 5, "center")}
"""Where a mark's label goes: offsets in points, and alignment."""

_CIRCLE: dict[str, Any] = {"marker": "o", "markersize": 3.8, "markerfacecolor": "white"}
_LOOKS: dict[str, dict[str, Any]] = {
    **dict.fromkeys(("energetic", "printed", "motion"), _CIRCLE),
    "compliant": {"marker": "x", "markersize": 4.2},
    "engine": {"marker": "s", "markersize": 3.4, "color": VERMILION, "linestyle": "-", "linewidth": 0.7},
    "contact": {"marker": "x", "markersize": 3.4, "color": BLACK, "linestyle": "-", "linewidth": 0.7},
    "table": {"marker": "s", "markersize": 3.6, "markerfacecolor": "white"},
    "sampled": {"marker": ".", "markersize": 4.0, "color": GREY},
}


def add_panel(
    figure: Figure, place: tuple[float, float, float, float], title: str, subtitle: str = "", **options: Any
) -> Axes:
    """Add axes at a place (left, bottom, width, height) in cm, with a title that the next letter of the figure leads."""
    letter = "abcdefghij"[sum(bool(axes.get_title(loc="left")) for axes in figure.axes) % 10]
    axes = axes_at(figure, *place, **options)
    axes.set_title(f"$\\bf{{{letter}}}$  {title}", loc="left", fontsize=8.5, pad=17.0)
    note(axes, subtitle, (0.0, 1.0), (0.0, 4.5), xycoords="axes fraction")
    return axes


def note(axes: Axes, words: str, place: tuple[float, float], offset: tuple[float, float], **look: Any) -> None:
    """Write small words beside a place, ``offset`` in points."""
    axes.annotate(words, place, offset, **{"textcoords": "offset points", "fontsize": 7.0, "color": GREY, **look})


def say(axes: Axes, words: str) -> None:
    """Write words in the middle of a panel that has nothing to show, without scales."""
    axes.set(xticks=[], yticks=[])
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", color=GREY)


def draw_named_panel(axes: Axes, panel: Panel) -> None:
    """Draw a panel; its curves are named in a row above it, or inside it where the names are long."""
    draw_panel(axes, panel)
    axes.set_xlabel(panel.x.label, fontsize=7.0, labelpad=2.0)
    axes.set_ylabel(panel.y.label, fontsize=7.0, labelpad=2.0)
    lines = [line for line in line_entries(panel) if str(line.get_label()).strip()]
    look: dict[str, Any] = {"fontsize": 6.5, "handlelength": 1.1, "handletextpad": 0.4, "labelspacing": 0.25}
    if panel.family:
        look |= {"loc": "lower left", "bbox_to_anchor": (-0.12, 0.985), "ncols": len(lines), "columnspacing": 0.7}
    else:
        look |= {"loc": "best", "frameon": True, "framealpha": 0.8, "edgecolor": "none"}
    axes.legend(handles=lines, **look)


def explain_points(figure: Figure, panels: Iterable[Panel], dot: str = "operating point") -> None:
    """Say at the foot of a figure what the points of its panels and the dot are."""
    key = {line.get_label(): line for panel in panels for line in point_entries(panel, dot)}
    if key:
        look: dict[str, Any] = {"ncols": min(len(key), 4), "fontsize": 7.0, "columnspacing": 1.4}
        figure.legend(handles=list(key.values()), loc="lower center", **look)


def draw_panel(axes: Axes, panel: Panel) -> None:
    """Draw one panel without its legend."""
    x, y = panel.x.factor, panel.y.factor
    for curve, color in zip(panel.curves, SERIES, strict=False):
        axes.plot(x * curve.x, y * curve.theory, color=color, gid=f"curve {curve.name}")
        for source, (at, values) in curve.points.items():
            look = {"color": color, "linestyle": "none", "markeredgewidth": 0.9, **_LOOKS[source]}
            axes.plot(x * at, y * values, **look, zorder=3, gid=f"{source} {curve.name}")
    for level, dashes in _level_looks(panel):
        draw, factor = (axes.axvline, x) if level.upright else (axes.axhline, y)
        draw(factor * level.value, color=GREY, linewidth=0.9, dashes=dashes, zorder=1, gid=level.label)
    for mark in panel.marks:
        place = (x * mark.x, y * mark.y)
        if mark.label:
            axes.plot(*place, "o", color=BLACK, markersize=4.5, zorder=5)
            right, up, side = _SIDES[mark.side]
            note(axes, mark.label, place, (right, up), ha=side, color=BLACK, zorder=5)
        else:
            axes.plot(
                *place, linestyle="none", zorder=5, gid="operating point", markeredgewidth=0.65, **OPERATING_POINT
            )
    axes.set(xlabel=panel.x.label, ylabel=panel.y.label)
    axes.set_xscale("log" if panel.x.log else "linear")
    axes.set_yscale("log" if panel.y.log else "linear")
    _limit(axes, panel)


def _limit(axes: Axes, panel: Panel) -> None:
    """Draw values that differ by rounding alone as equal, down to zero; leave room for labels above."""
    values = np.concatenate([panel.y.factor * curve.theory for curve in panel.curves])
    low, high = float(values.min()), float(values.max())
    if high - low < max(1e-3 * max(abs(low), abs(high)), NOTHING):
        bottom, top = min(1.3 * low, 0.0), max(1.3 * high, 0.0)
        axes.set_ylim(bottom, top if top - bottom > NOTHING else 1.0)
    if panel.top is not None:
        axes.set_ylim(0.0, panel.y.factor * panel.top or 1.0)
    if any(mark.side == "above" for mark in panel.marks):
        axes.set_ylim(top=high + 0.1 * (high - low))


def _level_looks(panel: Panel) -> list[tuple[Level, tuple[float, float]]]:
    """Return the levels with their dashes: flat ones by their order, upright ones alike."""
    flat = [level for level in panel.levels if not level.upright]
    upright = [(level, (3.0, 2.0)) for level in panel.levels if level.upright]
    return [*zip(flat, _DASHES, strict=False), *upright]


def point_entries(panel: Panel, dot: str) -> list[Line2D]:
    """Return entries of a legend that say what the points and the dot, a mark without a label, are."""
    entries = [_entry(source) for source in dict.fromkeys(source for curve in panel.curves for source in curve.points)]
    if any(not mark.label for mark in panel.marks):
        entries.append(Line2D([], [], linestyle="none", label=dot, markeredgewidth=0.65, **OPERATING_POINT))
    return entries


def line_entries(panel: Panel) -> list[Line2D]:
    """Return entries of a legend for the curves, led by their symbol, and for the levels."""
    lines = [Line2D([], [], color=GREY, dashes=dashes, label=level.label) for level, dashes in _level_looks(panel)]
    return [*_names(panel), *{line.get_label(): line for line in lines}.values()]


def _names(panel: Panel) -> list[Line2D]:
    symbol = [Line2D([], [], linestyle="none", label=f"{panel.family}:")] if panel.family else []
    lines = [Line2D([], [], color=color, label=curve.name) for curve, color in zip(panel.curves, SERIES, strict=False)]
    return [*symbol, *lines]


def _entry(kind: str) -> Line2D:
    """Return an entry of a legend that says what a source's points look like and what they are."""
    look = {"color": BLACK, "markeredgewidth": 0.9, "linestyle": "none", **_LOOKS[kind]}
    return Line2D([], [], label=SOURCES[kind].words, **look)
