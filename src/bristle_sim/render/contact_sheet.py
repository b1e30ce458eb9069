"""All redrawn figures on one sheet: ``python -m bristle_sim.render.contact_sheet media/contact_sheet.png``."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from bristle_sim.files import complete_or_absent
from bristle_sim.render.dissertation_figures import draw
from bristle_sim.render.style import styled
from bristle_sim.studies.dissertation_curves import NUMBERS, redrawn
from bristle_sim.studies.dissertation_curves.model import Redrawn

__all__ = ["contact_sheet", "main"]

CELL = (440, 275)
"""Width and height of a figure on the sheet, pixels: titles can be read."""

COLUMNS = 5


def contact_sheet(figures: Iterable[Redrawn]) -> Image.Image:
    """The figures in rows, each scaled to fit its cell."""
    cells = [_picture(draw(figure)) for figure in figures]
    rows = -(-len(cells) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * CELL[0], rows * CELL[1]), "white")
    for number, cell in enumerate(cells):
        row, column = divmod(number, COLUMNS)
        cell.thumbnail(CELL, Image.Resampling.LANCZOS)
        sheet.paste(cell, (column * CELL[0], row * CELL[1] + (CELL[1] - cell.height) // 2))
    return sheet


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the sheet to the file named; 2 where that cannot be done."""
    parser = argparse.ArgumentParser(prog="python -m bristle_sim.render.contact_sheet", description=__doc__)
    parser.add_argument("target", type=Path, metavar="FILE.png")
    target = parser.parse_args(arguments).target
    if target.suffix != ".png" or not target.parent.is_dir():
        allowed = "a file name that ends in .png, in an existing folder, is allowed"
        print(f"{parser.prog}: error: {target}: {allowed}", file=sys.stderr)
        return 2
    sheet = contact_sheet(redrawn(number) for number in NUMBERS)
    with complete_or_absent(target) as partial:
        _with_palette(sheet).save(partial, format="png", optimize=True)
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
