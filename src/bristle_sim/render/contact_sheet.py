"""Draw all redrawn figures on one sheet: ``python -m bristle_sim.render.contact_sheet media/contact_sheet.png``."""

from __future__ import annotations

import argparse
import io
import sys
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from bristle_sim.dissertation.figures import NUMBERS, redrawn
from bristle_sim.dissertation.redrawn import Redrawn
from bristle_sim.files import complete_or_absent
from bristle_sim.render.dissertation_figures import draw_table
from bristle_sim.render.style import axes_at, blank_figure, styled
from bristle_sim.render.sweep_panels import draw_panel, handles
from bristle_sim.studies.curves import Panel

__all__ = ["contact_sheet", "main"]

DOTS_PER_INCH = 100.0
"""A sheet is 1300 pixels wide: it is read on a screen as it is, without zooming in."""

COLUMNS = 4
CELL = (8.25, 7.1)
PANEL = (1.7, 1.2, 6.1, 4.2)
"""Left, bottom, width and height of a panel within its cell, cm."""

FOOT = 1.3
"""Height of the rows that says what points are, cm."""

TABLE_MARGIN = 1.2
"""By how much a table is wider than a panel, which has its scale there, cm."""

TITLE = 42
"""Characters of a title that fit in a line of a cell."""


def contact_sheet(figures: Iterable[Redrawn]) -> Figure:
    """Draw the figures in rows, one panel a cell, each with its number, axes and curves named, and a key at the foot."""
    cells = [(figure, panel) for figure in figures for panel in figure.panels or (None,)]
    rows = -(-len(cells) // COLUMNS)
    with styled():
        sheet = blank_figure(COLUMNS * CELL[0], rows * CELL[1] + FOOT, DOTS_PER_INCH)
        for number, (figure, panel) in enumerate(cells):
            row, column = divmod(number, COLUMNS)
            left, bottom = column * CELL[0], FOOT + (rows - 1 - row) * CELL[1]
            wider = TABLE_MARGIN if panel is None else 0.0
            axes = axes_at(sheet, left + PANEL[0] - wider, bottom + PANEL[1], PANEL[2] + wider, PANEL[3])
            axes.set_title(_title(figure), loc="left", fontsize=8.0, pad=15.0)
            if panel is None:
                draw_table(axes, figure.table, fontsize=6.0)
            else:
                _draw(axes, panel)
        _explain(sheet, [panel for _, panel in cells if panel is not None])
    return sheet


def _title(figure: Redrawn) -> str:
    """Number and title, on two lines where one is too short."""
    lines = textwrap.wrap(figure.heading, TITLE)
    number = figure.heading.partition(":")[0]
    return "\n".join(lines).replace(f"{number}:", f"$\\bf{{{number}}}$ ".replace(" ", "\\ ", 1), 1)


def _draw(axes: Axes, panel: Panel) -> None:
    """Draw the panel; its curves are named in a row above it, or inside it where the names are long."""
    draw_panel(axes, panel)
    axes.set_xlabel(panel.x.label, fontsize=7.0, labelpad=2.0)
    axes.set_ylabel(panel.y.label, fontsize=7.0, labelpad=2.0)
    lines = [line for line in handles(panel, key=False) if str(line.get_label()).strip()]
    look: dict[str, Any] = {"fontsize": 6.5, "handlelength": 1.1, "handletextpad": 0.4, "labelspacing": 0.25}
    if panel.family:
        place: dict[str, Any] = {
            "loc": "lower left",
            "bbox_to_anchor": (-0.12, 0.985),
            "ncols": len(lines),
            "columnspacing": 0.7,
        }
        axes.legend(handles=lines, **place, **look)
    else:
        axes.legend(handles=lines, loc="best", frameon=True, framealpha=0.8, edgecolor="none", **look)


def _explain(sheet: Figure, panels: Sequence[Panel]) -> None:
    """Say at the foot what points and the round dot are."""
    key = {line.get_label(): line for panel in panels for line in handles(panel, key=True)}
    sheet.legend(handles=list(key.values()), labels=[str(name).replace("\n", " ") for name in key], loc="lower center",
                 ncols=4, fontsize=7.5, columnspacing=1.5)  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the sheet to the file named; 2 where that cannot be done."""
    parser = argparse.ArgumentParser(prog="python -m bristle_sim.render.contact_sheet", description=__doc__)
    parser.add_argument("target", type=Path, metavar="FILE.png")
    target = parser.parse_args(arguments).target
    if target.suffix != ".png" or not target.parent.is_dir():
        rule = "must be a file name that ends in .png, in an existing folder"
        print(f"{parser.prog}: error: {target}: {rule}", file=sys.stderr)
        return 2
    sheet = contact_sheet(redrawn(number) for number in NUMBERS)
    with complete_or_absent(target) as partial:
        _with_palette(_picture(sheet)).save(partial, format="png", optimize=True)
    return 0


def _with_palette(sheet: Image.Image) -> Image.Image:
    """The same in 256 colours, which nobody sees and takes a fifth of the bytes."""
    return sheet.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)


def _picture(figure: Figure) -> Image.Image:
    """The figure's pixels."""
    stream = io.BytesIO()
    with styled():
        figure.savefig(stream, format="png")
    return Image.open(stream).convert("RGB")


if __name__ == "__main__":
    sys.exit(main())
