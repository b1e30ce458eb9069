"""The dissertation's figures in one style: closed forms as lines, what checks them as points, the operating point."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.dissertation.redrawn import Redrawn
from bristle_sim.render.style import (
    BLACK,
    GREY,
    LIGHT,
    SERIES,
    axes_at,
    blank_figure,
    complete_or_absent,
    save_figure,
    styled,
)
from bristle_sim.studies.curves import SOURCES, Curve, Level, Mark, Panel

__all__ = ["draw", "draw_panel", "draw_table", "handles", "save_figures"]

_OPERATING: dict[str, Any] = {
    "marker": "o",
    "color": "#1f4fff",
    "markersize": 6.5,
    "markeredgecolor": "white",
    "markeredgewidth": 0.7,
}
"""The dissertation marks its operating point with a blue round dot."""

PANEL = (9.0, 6.4)
"""Width and height of a single panel, cm; the legend stands to its right."""

SMALL = (4.3, 3.4)
"""The same where a figure has several."""

TABLE_WIDTH = 12.0
"""cm."""

COLUMNS = 3
_DASHES = ((4.0, 2.0), (1.0, 1.5))
"""Of level lines, in their order."""

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


@styled()
def draw(figure: Redrawn) -> Figure:
    """Draw a figure or table."""
    if figure.table:
        return _draw_table(figure)
    return _draw_one(figure) if len(figure.panels) == 1 else _draw_several(figure)


def save_figures(figures: Iterable[Redrawn], target: Path) -> list[Path]:
    """Draw each figure: on the pages of one PDF if the target ends in .pdf, else into a folder, ``figure_2.7.png``.

    The folder is made if it is not there.

    Raises:
        OSError: if the folder cannot be made or the target cannot be written.
    """
    if target.suffix.lower() == ".pdf":
        with (
            complete_or_absent(target) as partial,
            PdfPages(partial, metadata={"CreationDate": None}) as pages,
            styled(),
        ):
            for figure in figures:
                pages.savefig(draw(figure))
        return [target]
    target.mkdir(exist_ok=True)
    return [save_figure(draw(figure), target / f"{figure.name}.png") for figure in figures]


def draw_panel(axes: Axes, panel: Panel) -> None:
    """Draw one panel without its legend."""
    for curve, color in zip(panel.curves, SERIES, strict=False):
        _draw_curve(axes, panel, curve, color)
    _draw_levels(axes, panel)
    for mark in panel.marks:
        _draw_mark(axes, panel, mark)
    axes.set_xlabel(panel.x.label)
    axes.set_ylabel(panel.y.label)
    if panel.x.log:
        axes.set_xscale("log")
    if panel.y.log:
        axes.set_yscale("log")
    _limit(axes, panel)


def _limit(axes: Axes, panel: Panel) -> None:
    """Values that differ by rounding alone are drawn as equal, down to zero; room for labels above."""
    values = np.concatenate([panel.y.factor * curve.theory for curve in panel.curves])
    low, high = float(values.min()), float(values.max())
    if high - low < 1e-3 * max(abs(low), abs(high)):
        axes.set_ylim(min(1.3 * low, 0.0), max(1.3 * high, 0.0))
    if panel.top is not None:
        axes.set_ylim(0.0, panel.y.factor * panel.top)
    if any(mark.side == "above" for mark in panel.marks):
        axes.set_ylim(top=high + 0.1 * (high - low))


def _draw_curve(axes: Axes, panel: Panel, curve: Curve, color: str) -> None:
    axes.plot(panel.x.factor * curve.x, panel.y.factor * curve.theory, color=color, gid=f"curve {curve.name}")
    for law, (at, y) in curve.points.items():
        look = {"color": color, "linestyle": "none", "markeredgewidth": 0.9, **_LOOKS[law]}
        axes.plot(panel.x.factor * at, panel.y.factor * y, **look, zorder=3, gid=f"{law} {curve.name}")


def _draw_levels(axes: Axes, panel: Panel) -> None:
    for level in (level for level in panel.levels if level.upright):
        axes.axvline(panel.x.factor * level.value, color=GREY, linewidth=0.8, dashes=(3, 2), zorder=1)
    for level, dashes in zip(_flat(panel), _DASHES, strict=False):
        axes.axhline(panel.y.factor * level.value, color=GREY, linewidth=1.0, dashes=dashes, zorder=1)


def _flat(panel: Panel) -> list[Level]:
    return [level for level in panel.levels if not level.upright]


def _draw_mark(axes: Axes, panel: Panel, mark: Mark) -> None:
    place = (panel.x.factor * mark.x, panel.y.factor * mark.y)
    if not mark.label:
        axes.plot(*place, zorder=5, **_OPERATING)
        return
    axes.plot(*place, "o", color=BLACK, markersize=4.5, zorder=5)
    right, up, aligned = _SIDES[mark.side]
    axes.annotate(mark.label, place, (right, up), textcoords="offset points", ha=aligned, fontsize=7.0, zorder=5)


def _draw_one(figure: Redrawn) -> Figure:
    page = blank_figure(PANEL[0] + 5.6, PANEL[1] + 2.7)
    axes = axes_at(page, 1.5, 1.2, *PANEL)
    panel = figure.panels[0]
    draw_panel(axes, panel)
    _head(page, figure, 1.5)
    axes.legend(
        handles=handles(panel), loc="upper left", bbox_to_anchor=(1.02, 1.02), labelspacing=0.45, handlelength=1.8
    )
    return page


def _draw_several(figure: Redrawn) -> Figure:
    rows = -(-len(figure.panels) // COLUMNS)
    height = rows * (SMALL[1] + 1.3)
    page = blank_figure(0.5 + COLUMNS * (SMALL[0] + 1.8), height + 2.1)
    for number, panel in enumerate(figure.panels):
        row, column = divmod(number, COLUMNS)
        place = (1.5 + column * (SMALL[0] + 1.8), 1.9 + (rows - 1 - row) * (SMALL[1] + 1.3))
        axes = axes_at(page, *place, *SMALL)
        draw_panel(axes, panel)
        axes.legend(handles=handles(panel)[:1], loc="best")
    _head(page, figure, 1.5)
    laws = dict.fromkeys(law for panel in figure.panels for curve in panel.curves for law in curve.points)
    page.legend(handles=[_source(law) for law in laws], loc="lower center", ncols=len(laws))
    return page


def _draw_table(figure: Redrawn) -> Figure:
    page = blank_figure(TABLE_WIDTH + 1.6, 0.5 * len(figure.table) + 2.6)
    draw_table(axes_at(page, 0.8, 0.7, TABLE_WIDTH, 0.5 * len(figure.table)), figure.table)
    _head(page, figure, 0.8)
    return page


def draw_table(axes: Axes, table: Sequence[Sequence[str]], fontsize: float = 8.0) -> None:
    """Draw rows that fill the axes, the head first and the sums last."""
    head, *rows = table
    rights = np.linspace(0.0, 1.0, len(head) + 1)[1:]
    axes.set_axis_off()
    axes.set(xlim=(0.0, 1.0), ylim=(len(table), 0.0))
    for line, row in enumerate((head, *rows)):
        if line % 2:
            axes.axhspan(line, line + 1, color=LIGHT, alpha=0.45, linewidth=0.0)
        weight = "bold" if line in (0, len(rows)) else "normal"
        for right, cell in zip(rights, row, strict=True):
            axes.text(right - 0.02, line + 0.5, cell, ha="right", va="center", fontweight=weight, fontsize=fontsize)
    for line in (1, len(rows)):
        axes.axhline(line, color=BLACK, linewidth=0.8)


def _head(page: Figure, figure: Redrawn, left: float) -> None:
    """Number and title, and the note below them."""
    width, height = page.get_size_inches() * 2.54
    number, _, title = figure.heading.partition(": ")
    shown = number.replace(" ", "\\ ")
    page.text(left / width, 1.0 - 0.6 / height, f"$\\bf{{{shown}}}$   {title}", fontsize=9.0, va="baseline")
    page.text(left / width, 1.0 - 1.02 / height, figure.note, fontsize=7.0, color=GREY, va="baseline")


def handles(panel: Panel, *, key: bool | None = None) -> list[Line2D]:
    """Entries of a legend: curves, led by the family's symbol, and levels; then what the points and the dot are.

    ``key``: False for the curves and levels alone, True for points and dot alone, None for all.
    """
    own = [Line2D([], [], linestyle="none", label=f"{panel.family}:")] if panel.family else []
    own += [Line2D([], [], color=color, label=curve.name) for curve, color in zip(panel.curves, SERIES, strict=False)]
    levels = [
        Line2D([], [], color=GREY, linewidth=1.0, dashes=dashes, label=level.label)
        for level, dashes in zip(_flat(panel), _DASHES, strict=False)
    ]
    upright = dict.fromkeys(level.label for level in panel.levels if level.upright)
    levels += [Line2D([], [], color=GREY, linewidth=0.8, dashes=(3, 2), label=label) for label in upright]
    laws = dict.fromkeys(law for curve in panel.curves for law in curve.points)
    points = [_source(law) for law in laws]
    dot = [Line2D([], [], linestyle="none", label="operating point", **_OPERATING)]
    dot = dot if any(not mark.label for mark in panel.marks) else []
    if key is not None:
        return [*points, *dot] if key else [*own, *levels]
    gap = [Line2D([], [], linestyle="none", label=" ")] if len(panel.curves) > 1 and laws else []
    return [*own, *gap, *points, *levels, *dot]


def _source(law: str) -> Line2D:
    look = {"color": BLACK, "markeredgewidth": 0.9, "linestyle": "none", **_LOOKS[law]}
    return Line2D([], [], label=_folded(SOURCES[law].words), **look)


def _folded(words: str) -> str:
    """On two lines at its comma, where it has one."""
    return words.replace(", ", ",\n", 1)
