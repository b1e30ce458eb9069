"""Draw panels of curves: closed forms as lines, what checks them as points, levels, and the case at hand."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.render.style import BLACK, BLUE, GREY, ORANGE, SERIES, VERMILION
from bristle_sim.studies.curves import SOURCES, Curve, Level, Mark, Panel
from bristle_sim.studies.law_convergence import EngineEnergy

CREATED = "#fbe3d6"
NOTHING = 1e-12
"""Less than this, in the unit shown, is rounding of zero."""

MANY = 6
"""Curves whose names need closer spacing to fit in the row above a panel."""

MARKS: dict[str, dict[str, Any]] = {
    "operating point": {
        "marker": "o",
        "color": "#1f4fff",
        "markersize": 6.5,
        "markeredgecolor": "white",
        "markeredgewidth": 0.7,
    },
    "the impact at hand": {
        "marker": "*",
        "color": BLACK,
        "markersize": 9.0,
        "markerfacecolor": ORANGE,
        "markeredgewidth": 0.6,
    },
}
"""What a mark without a label may be; the dissertation marks its operating point with a blue round dot."""

_DASHES = ((4.0, 2.0), (1.0, 1.5))
"""Dashes of level lines, in their order."""

_SIDES = {"right": (6, -9, "left"), "left": (-5, -11, "right"), "above": (0, 5, "center")}
"""Where a mark's label goes: offsets in points, and alignment."""

_LOOKS: dict[str, dict[str, Any]] = {
    "energetic": {"marker": "o", "markersize": 3.8, "markerfacecolor": "white"},
    "compliant": {"marker": "x", "markersize": 4.2},
    "contact": {"marker": "x", "markersize": 3.4, "color": BLACK, "linestyle": "-", "linewidth": 0.7},
    "printed": {"marker": "o", "markersize": 3.8, "markerfacecolor": "white"},
    "motion": {"marker": "o", "markersize": 3.8, "markerfacecolor": "white"},
    "table": {"marker": "s", "markersize": 3.6, "markerfacecolor": "white"},
    "sampled": {"marker": ".", "markersize": 4.0, "color": GREY},
}


def panel_title(axes: Axes, letter: str, words: str, subtitle: str = "") -> None:
    """Write a title at the panel's left edge, led by its letter, above a row for a subtitle or a family's names."""
    axes.set_title(f"$\\bf{{{letter}}}$  {words}", loc="left", fontsize=8.5, pad=17.0)
    note(axes, subtitle, (0.0, 1.0), (0.0, 4.5), xycoords="axes fraction")


def explain_marks(figure: Figure, *kinds: str) -> None:
    """Explain lines and points in a row at the foot of a figure: sources of points, and marks."""
    lines = [Line2D([], [], color=BLACK, label="closed form")]
    for kind in kinds:
        lines.append(_own(kind) if kind in MARKS else source(kind))
    figure.legend(
        handles=lines, loc="lower center", ncols=len(lines), borderaxespad=0.2, columnspacing=1.0, handletextpad=0.4
    )


def draw_energy(axes: Axes, energy: EngineEnergy) -> None:
    """Draw kinetic energy after over before, over the iterations of the engine's solver; beyond 1 energy is created."""
    top = 1.15 * max(1.3, float(energy.engine.max()))
    axes.axhspan(1.0, top, color=CREATED, linewidth=0.0, zorder=0)
    axes.axhline(energy.energetic, color=BLUE, gid="energetic")
    axes.semilogx(energy.iterations, energy.engine, "o-", color=VERMILION, markersize=3.2, gid="engine")
    axes.axvline(10.0, color=GREY, linewidth=0.7, dashes=(2, 2), zorder=1)
    axes.set_ylim(0.0, top)
    right = float(energy.iterations[-1])
    note(axes, "energy created", (right, 1.0), (0.0, 3.0), ha="right", va="bottom", color=BLACK)
    note(axes, "energetic law", (right, energy.energetic), (0.0, -3.0), ha="right", va="top", color=BLUE)
    note(axes, "engine's own contact", (10.0, 0.9 * top), (4.0, 0.0), va="center", color=VERMILION)
    note(axes, "engine's default", (10.0, 0.03 * top), (4.0, 0.0))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("iterations of the engine's solver")
    axes.set_ylabel("kinetic energy, after / before")


def note(axes: Axes, words: str, place: tuple[float, float], offset: tuple[float, float], **look: Any) -> None:
    """Write small words beside a place, ``offset`` in points."""
    axes.annotate(words, place, offset, **{"textcoords": "offset points", "fontsize": 7.0, "color": GREY, **look})


def say(axes: Axes, words: str) -> None:
    """Write words in the middle of a panel that has nothing to show, without scales."""
    axes.set(xticks=[], yticks=[])
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", color=GREY)


def draw_panel(axes: Axes, panel: Panel, own: str = "operating point") -> None:
    """Draw one panel without its legend; ``own`` says what its marks without a label are, see MARKS."""
    for curve, color in zip(panel.curves, SERIES, strict=False):
        _draw_curve(axes, panel, curve, color)
    _draw_levels(axes, panel)
    for mark in panel.marks:
        _draw_mark(axes, panel, mark, own)
    axes.set_xlabel(panel.x.label)
    axes.set_ylabel(panel.y.label)
    if panel.x.log:
        axes.set_xscale("log")
    if panel.y.log:
        axes.set_yscale("log")
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


def _draw_curve(axes: Axes, panel: Panel, curve: Curve, color: str) -> None:
    axes.plot(panel.x.factor * curve.x, panel.y.factor * curve.theory, color=color, gid=f"curve {curve.name}")
    for law, (at, y) in curve.points.items():
        look = {"color": color, "linestyle": "none", "markeredgewidth": 0.9, **_LOOKS[law]}
        axes.plot(panel.x.factor * at, panel.y.factor * y, **look, zorder=3, gid=f"{law} {curve.name}")


def _draw_levels(axes: Axes, panel: Panel) -> None:
    for level, dashes in _level_looks(panel):
        draw, factor = (axes.axvline, panel.x.factor) if level.upright else (axes.axhline, panel.y.factor)
        draw(factor * level.value, color=GREY, linewidth=0.9, dashes=dashes, zorder=1, gid=level.label)


def _level_looks(panel: Panel) -> list[tuple[Level, tuple[float, float]]]:
    """Return the levels with their dashes: flat ones by their order, upright ones alike."""
    flat = [level for level in panel.levels if not level.upright]
    upright = [(level, (3.0, 2.0)) for level in panel.levels if level.upright]
    return [*zip(flat, _DASHES, strict=False), *upright]


def _draw_mark(axes: Axes, panel: Panel, mark: Mark, own: str) -> None:
    place = (panel.x.factor * mark.x, panel.y.factor * mark.y)
    if not mark.label:
        axes.plot(*place, linestyle="none", zorder=5, gid=own, **MARKS[own])
        return
    axes.plot(*place, "o", color=BLACK, markersize=4.5, zorder=5)
    right, up, aligned = _SIDES[mark.side]
    axes.annotate(mark.label, place, (right, up), textcoords="offset points", ha=aligned, fontsize=7.0, zorder=5)


def name_curves(axes: Axes, panel: Panel) -> None:
    """Name a panel's curves in a row above it that begins with the family's symbol."""
    names = _names(panel)
    crowded = len(panel.curves) >= MANY
    axes.legend(
        handles=names,
        loc="lower left",
        bbox_to_anchor=(-0.08, 0.985),
        ncols=len(names),
        handlelength=0.7 if crowded else 1.0,
        handletextpad=0.4,
        columnspacing=0.5 if crowded else 0.9,
    )


def point_entries(panel: Panel) -> list[Line2D]:
    """Return entries of a legend that say what the points and the dot of the operating point are."""
    laws = dict.fromkeys(law for curve in panel.curves for law in curve.points)
    dot = [_own("operating point")] if any(not mark.label for mark in panel.marks) else []
    return [*(source(law) for law in laws), *dot]


def line_entries(panel: Panel) -> list[Line2D]:
    """Return entries of a legend for the curves, led by their symbol, and for the levels."""
    lines = [Line2D([], [], color=GREY, dashes=dashes, label=level.label) for level, dashes in _level_looks(panel)]
    return [*_names(panel), *{line.get_label(): line for line in lines}.values()]


def _names(panel: Panel) -> list[Line2D]:
    """Return entries of a legend for the curves, led by the family's symbol."""
    symbol = [Line2D([], [], linestyle="none", label=f"{panel.family}:")] if panel.family else []
    lines = [Line2D([], [], color=color, label=curve.name) for curve, color in zip(panel.curves, SERIES, strict=False)]
    return [*symbol, *lines]


def source(law: str) -> Line2D:
    """Return an entry of a legend that says what a source's points look like and what they are."""
    look = {"color": BLACK, "markeredgewidth": 0.9, "linestyle": "none", **_LOOKS[law]}
    return Line2D([], [], label=SOURCES[law].words, **look)


def _own(kind: str) -> Line2D:
    return Line2D([], [], linestyle="none", label=kind, **MARKS[kind])
