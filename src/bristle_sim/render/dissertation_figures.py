"""Draws the dissertation's figures, each on a page of its own.

Closed forms are drawn as lines, numerical results that check them as points, and the operating
point as a dot.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from bristle_sim.dissertation.redrawn import SOURCES, Panel, Redrawn
from bristle_sim.files import complete_or_absent
from bristle_sim.render.style import (
    BLACK,
    GREY,
    SERIES,
    VERMILION,
    Look,
    blank_figure,
    save_figure,
    styled,
    write_key,
)

CELL = (8.25, 5.9)
PAGE_CELL = (15.0, 8.2)
"""Width and height (cm) of a panel with its scales.

``CELL`` is for a page with several panels, ``PAGE_CELL`` for a page with a single panel."""

REST = 2.2  # height of a page's title, note and legend of points, cm
NOTHING = 1e-12  # largest value, in the unit shown, that counts as rounding error of zero
OPERATING_POINT: Look = {
    "marker": "o", "color": "#1f4fff", "markersize": 6.5, "markeredgecolor": "white", "linestyle": "none",
}  # fmt: skip
"""Style of a mark without a label: a blue dot, as the dissertation marks its operating point."""

_SIDES = {"right": ((6, -9), "left"), "left": ((-5, -11), "right"), "above": ((0, 5), "center")}
"""Offset of a label from its mark (1/72 inch), and alignment of the label, by side."""

_OPEN: Look = {"marker": "o", "markersize": 3.8, "markerfacecolor": "white", "linestyle": "none"}
_CROSS: Look = {"marker": "x", "markersize": 4.0, "linestyle": "none"}
_JOINED: Look = {"markersize": 3.4, "linewidth": 0.7}
_LOOKS: dict[str, Look] = {
    **dict.fromkeys(("energetic", "printed", "motion"), _OPEN),
    "compliant": _CROSS,
    "engine": _JOINED | {"marker": "s", "color": VERMILION},
    "contact": _JOINED | {"marker": "x", "color": BLACK},
    "table": _OPEN | {"marker": "s"},
    "sampled": _CROSS | {"marker": ".", "color": GREY},
}


@styled()
def draw(figure: Redrawn) -> Figure:
    """Draw a figure or table on a page with its number, title and note at the top.

    There are at most three panels in a row. A legend of the points stands at the foot.
    """
    panels = figure.panels or (None,)
    columns = min(len(panels), 3)
    rows = -(-len(panels) // columns)
    width, height = PAGE_CELL if len(panels) == 1 else CELL
    page = blank_figure(columns * width, rows * height + REST)
    page.suptitle(f"{heading(figure)}\n{figure.note}", fontsize=8.0)
    for axes, panel in zip(page.subplots(rows, columns, squeeze=False).flat, panels, strict=True):
        draw_panel(axes, panel, figure.table)
    write_points_key(page, figure.panels)
    return page


def write_points_key(page: Figure, panels: Iterable[Panel]) -> None:
    """Write a legend of the points in the panels at the foot of a page."""
    key: dict[str, Look] = {}
    for panel in panels:
        for source in (source for curve in panel.curves for source in curve.points):
            key[SOURCES[source].words] = {"color": BLACK, **_LOOKS[source]}
        if not all(mark.label for mark in panel.marks):
            key["operating point"] = OPERATING_POINT
    if key:
        write_key(page, key, ncols=min(len(key), 4))


def save_figures(figures: Iterable[Redrawn], target: Path) -> list[Path]:
    """Draw figures and write them to a PDF or to a folder, and return the paths of the files.

    If ``target`` ends in .pdf, the PDF has one page for each figure. Otherwise ``target`` is a
    folder, created if necessary, and receives a file such as ``figure_2.7.png`` for each figure.

    Raises:
        OSError: if the folder cannot be created or a file cannot be written.
    """
    if target.suffix.lower() == ".pdf":
        undated = {"CreationDate": None}
        with (
            complete_or_absent(target) as partial,
            PdfPages(partial, metadata=undated) as pages,
            styled(),
        ):
            for figure in figures:
                pages.savefig(draw(figure))
        return [target]
    target.mkdir(exist_ok=True)
    return [save_figure(draw(figure), target / f"{figure.name}.png") for figure in figures]


def heading(figure: Redrawn) -> str:
    """Return a figure's heading for matplotlib: the number in bold letters, and the title."""
    number, _, title = figure.heading.partition(": ")
    shown = number.replace(" ", "\\ ")
    return f"$\\bf{{{shown}}}$  {title}"


def draw_panel(axes: Axes, panel: Panel | None, table: Sequence[Sequence[str]] = ()) -> None:
    """Draw a panel with a legend of its curves. If ``panel`` is None, draw a table.

    ``table`` holds the rows of the table: first its header, last the totals.
    """
    if panel is None:
        axes.set_axis_off()
        drawn = axes.table(table, bbox=Bbox.unit(), edges="horizontal", cellLoc="right")
        drawn.auto_set_font_size(False)
        drawn.set_fontsize(6.0)
        for cell in drawn.get_celld().values():
            cell.set_linewidth(0.4)
        return
    x, y = panel.x.factor, panel.y.factor
    for curve, color in zip(panel.curves, SERIES, strict=False):
        axes.plot(x * curve.x, y * curve.theory, color=color, label=curve.name)
        for source, (at, values) in curve.points.items():
            axes.plot(x * at, y * values, zorder=3, **{"color": color, **_LOOKS[source]})
    for number, level in enumerate(panel.levels):
        look: Look = {"color": GREY, "linewidth": 0.9, "zorder": 1, "label": level.label}
        if level.upright:
            axes.axvline(x * level.value, linestyle="--", **look)
        else:
            axes.axhline(y * level.value, linestyle=("--", ":")[number], **look)
    for mark in panel.marks:
        place = (x * mark.x, y * mark.y)
        offset, side = _SIDES[mark.side]
        dot: Look = {"color": BLACK, "marker": "o", "markersize": 4.5}
        axes.plot(*place, zorder=5, **(dot if mark.label else OPERATING_POINT))
        axes.annotate(mark.label, place, offset, textcoords="offset points", ha=side, zorder=5)
    axes.set(xscale="log" if panel.x.log else "linear", yscale="log" if panel.y.log else "linear")
    _limit(axes, panel)
    axes.set(xlabel=panel.x.label, ylabel=panel.y.label)
    named = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))  # each name once
    look = {"title": panel.family, "fontsize": 6.5, "frameon": True, "framealpha": 0.8}
    axes.legend(named.values(), named, handlelength=0.9, edgecolor="none", **look)


def _limit(axes: Axes, panel: Panel) -> None:
    """Set the range of the vertical axis.

    The range is so wide that a curve which varies only by rounding error looks constant. It leaves
    space for labels above marked points.
    """
    values = panel.y.factor * np.concatenate([curve.theory for curve in panel.curves])
    high = float(values.max())
    span = float(np.ptp(values))
    if span < max(1e-3 * abs(high), NOTHING):
        level = 1.3 * high if abs(high) > NOTHING else 1.0
        axes.set_ylim(min(level, 0.0), max(level, 0.0))
    if panel.top is not None:
        axes.set_ylim(0.0, panel.y.factor * panel.top or 1.0)
    if any(mark.side == "above" for mark in panel.marks):
        axes.set_ylim(top=high + 0.1 * span)
