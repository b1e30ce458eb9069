"""Draw the dissertation's figures, one a page or all on one sheet.

Closed forms are lines, what checks them points, and the operating point a dot.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from bristle_sim.dissertation.redrawn import Panel, Redrawn
from bristle_sim.files import complete_or_absent
from bristle_sim.render.colours import BLACK, GREY, LIGHT
from bristle_sim.render.panels import draw_named_panel, explain_points
from bristle_sim.render.style import axes_at, blank_figure, save_figure, styled

SHEET_DOTS_PER_INCH = 100.0
"""A sheet is 1300 pixels wide: it is read on a screen as it is, without zooming in."""

CELL, PAGE_CELL = (8.25, 5.9), (15.0, 8.2)
"""Width and height of a panel with its scales, of several on a page and of the only one, cm."""

PANEL = (1.7, 1.2, 2.15, 1.7)
"""Left and lower edge of a panel within its cell, and by how much it is narrower and lower than the cell, cm."""

FOOT, HEAD, TITLES = 1.0, 1.2, 1.2
"""Heights of the key of points, of a page's title and note, and of the titles in a sheet's row, cm."""

TABLE_MARGIN = 1.2
"""By how much a table is wider than a panel, which has its scale there, cm."""


@styled()
def draw(figure: Redrawn) -> Figure:
    """Draw one figure or table on a page, its number, title and note at the head."""
    cells = [(figure, panel) for panel in figure.panels or (None,)]
    page = _page(cells, min(len(cells), 3), PAGE_CELL if len(cells) == 1 else CELL, 0.0, 200.0)
    width, height = page.get_size_inches() * 2.54
    left = (PANEL[0] - (0.0 if figure.panels else TABLE_MARGIN)) / width
    page.text(left, 1.0 - 0.6 / height, _bold(figure), fontsize=9.0)
    page.text(left, 1.0 - 1.02 / height, figure.note, fontsize=7.0, color=GREY)
    return page


@styled()
def contact_sheet(figures: Iterable[Redrawn]) -> Figure:
    """Draw all figures on one sheet, a panel a cell."""
    cells = [(figure, panel) for figure in figures for panel in figure.panels or (None,)]
    sheet = _page(cells, 4, CELL, TITLES, SHEET_DOTS_PER_INCH)
    for (figure, _), axes in zip(cells, sheet.axes, strict=True):
        axes.set_title("\n".join(textwrap.wrap(_bold(figure), 50)), loc="left", fontsize=8.0, pad=15.0)
    return sheet


def save_figures(figures: Iterable[Redrawn], target: Path) -> list[Path]:
    """Draw each figure: on the pages of one PDF if the target ends in .pdf, else into a folder, ``figure_2.7.png``.

    The folder is made if it is not there.

    Raises:
        OSError: if the folder cannot be made or the target cannot be written.
    """
    if target.suffix.lower() == ".pdf":
        undated = {"CreationDate": None}
        with complete_or_absent(target) as partial, PdfPages(partial, metadata=undated) as pages, styled():
            for figure in figures:
                pages.savefig(draw(figure))
        return [target]
    target.mkdir(exist_ok=True)
    return [save_figure(draw(figure), target / f"{figure.name}.png") for figure in figures]


Cells = Sequence[tuple[Redrawn, Panel | None]]


def _page(cells: Cells, columns: int, size: tuple[float, float], titles: float, dots_per_inch: float) -> Figure:
    """Draw panels and tables in rows of cells with room for titles (cm) above each, and a key of points at the foot."""
    rows = -(-len(cells) // columns)
    width, height = size[0], size[1] + titles
    page = blank_figure(columns * width, rows * height + FOOT + (0.0 if titles else HEAD), dots_per_inch)
    for number, (figure, panel) in enumerate(cells):
        row, column = divmod(number, columns)
        left, bottom = column * width, FOOT + (rows - 1 - row) * height
        wider = TABLE_MARGIN if panel is None else 0.0
        space = (size[0] - PANEL[2] + wider, size[1] - PANEL[3])
        axes = axes_at(page, left + PANEL[0] - wider, bottom + PANEL[1], *space)
        if panel is None:
            _draw_table(axes, figure.table)
        else:
            draw_named_panel(axes, panel)
    explain_points(page, [panel for _, panel in cells if panel is not None])
    return page


def _bold(figure: Redrawn) -> str:
    """Return number and title, the number in bold letters."""
    number, _, title = figure.heading.partition(": ")
    shown = number.replace(" ", "\\ ")
    return f"$\\bf{{{shown}}}$  {title}"


def _draw_table(axes: Axes, table: Sequence[Sequence[str]]) -> None:
    """Draw rows that fill the axes, the head first and the sums last."""
    last = len(table) - 1
    axes.set_axis_off()
    axes.set(xlim=(0.0, len(table[0])), ylim=(len(table), 0.0))
    for line, row in enumerate(table):
        if line % 2:
            axes.axhspan(line, line + 1, color=LIGHT, alpha=0.45, linewidth=0.0)
        if line in (1, last):
            axes.axhline(line, color=BLACK, linewidth=0.8)
        weight = "bold" if line in (0, last) else "normal"
        for right, cell in enumerate(row, start=1):
            axes.text(right - 0.1, line + 0.5, cell, ha="right", va="center", fontweight=weight, fontsize=6.0)
