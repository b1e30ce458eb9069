"""The dissertation's figures in one style: closed forms as lines, what checks them as points, the operating point."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from bristle_sim.dissertation.redrawn import Redrawn
from bristle_sim.files import complete_or_absent
from bristle_sim.render.style import BLACK, GREY, LIGHT, axes_at, blank_figure, save_figure, styled
from bristle_sim.render.sweep_panels import draw_panel, handles, source

__all__ = ["draw", "draw_table", "save_figures"]

PANEL = (9.0, 6.4)
"""Width and height of a single panel, cm; the legend stands to its right."""

SMALL = (4.3, 3.4)
"""The same where a figure has several."""

TABLE_WIDTH = 12.0
"""cm."""

COLUMNS = 3


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
    page.legend(handles=[source(law) for law in laws], loc="lower center", ncols=len(laws))
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
