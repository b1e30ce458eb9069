"""One look for every picture: letters, lines and sizes, units with readable prefixes, and files.

Figures are built on :class:`matplotlib.figure.Figure` alone: no display, no global state, and pyplot is not imported.
Sizes are printed centimetres; a full-width figure is 16 cm wide with 7 to 8 point text.
"""

from __future__ import annotations

import io
import math
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.files import complete_or_absent

BLACK, GREY, LIGHT = "#1a1a1a", "#6b6b6b", "#e4e4e4"
BLUE, ORANGE, GREEN, VERMILION = "#0072b2", "#e69f00", "#009e73", "#d55e00"
PURPLE, SKY = "#b8578e", "#56b4e9"
SERIES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)


FIGURE_SUFFIXES = (".png", ".svg", ".pdf")
CENTIMETRES_PER_INCH = 2.54

_SETTINGS: dict[Any, Any] = {
    "font.family": "DejaVu Sans",  # carried by matplotlib: the same letters on every machine
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "axes.titlesize": 9.0,
    "axes.linewidth": 0.6,
    "axes.edgecolor": GREY,
    "axes.labelcolor": BLACK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": cycler(color=SERIES),
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": BLACK,
    "ytick.labelcolor": BLACK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "grid.color": LIGHT,
    "grid.linewidth": 0.5,
    "axes.grid": True,
    "axes.axisbelow": True,
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "hatch.linewidth": 0.5,
    "savefig.facecolor": "white",
    "svg.hashsalt": "bristle_sim",  # same picture, same bytes
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}


@contextmanager
def styled() -> Iterator[None]:
    """Apply the look: a context in which to build or save figures, or a decorator of functions that do."""
    with mpl.rc_context(_SETTINGS):
        yield


class NotebookFigure(Figure):
    """A figure that a notebook shows without pyplot: matplotlib registers its own pictures only where that is imported."""

    def _repr_png_(self) -> bytes:
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=100)
        return picture.getvalue()


def blank_figure(width_cm: float, height_cm: float, dots_per_inch: float = 200.0) -> Figure:
    """Return an empty figure of a printed size in cm."""
    size = (width_cm / CENTIMETRES_PER_INCH, height_cm / CENTIMETRES_PER_INCH)
    with styled():
        return NotebookFigure(figsize=size, dpi=dots_per_inch)


def axes_at(figure: Figure, left: float, bottom: float, width: float, height: float, **options: Any) -> Axes:
    """Add axes at a place given in cm from the figure's lower left corner; ``options`` as for ``Figure.add_axes``."""
    inches = figure.get_size_inches() * CENTIMETRES_PER_INCH
    place = (left / inches[0], bottom / inches[1], width / inches[0], height / inches[1])
    with styled():
        return figure.add_axes(place, **options)


def signed(value: float, decimals: int, width: int = 0) -> str:
    """Format a number, with a real minus sign unless it rounds to zero."""
    return f"{round(value, decimals) + 0.0:{width}.{decimals}f}".replace("-", "\N{MINUS SIGN}")


_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


@dataclass(frozen=True, slots=True)
class Scale:
    """Numbers shown in ``unit`` are ``factor`` times those in the plain unit."""

    factor: float
    unit: str


def scale_for(largest: float, unit: str) -> Scale:
    """Return the scale on which a number of that size lies between 1 and 1000: 1.2e-3 N s is 1.2 mN·s."""
    size = abs(largest)
    if not 0.0 < size < math.inf:
        return Scale(1.0, unit)
    # A hair above: 999.9996 should not be written as 1000 of the smaller unit.
    exponent = 3 * math.floor(math.log10(size * (1.0 + 1e-6)) / 3.0)
    exponent = min(max(exponent, min(_PREFIXES)), max(_PREFIXES))
    return Scale(10.0**-exponent, _PREFIXES[exponent] + unit)


def checked_target(path: str | Path, suffixes: Collection[str]) -> Path:
    """Return the path of a file that can be written, or raise ValueError in one line.

    Raises:
        ValueError: if the suffix is none of ``suffixes``, or the folder does not exist.
    """
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        raise ValueError(f"{target}: must be a file name that ends in {', '.join(sorted(suffixes))}")
    if not target.parent.is_dir():
        raise ValueError(f"{target}: must be a file name in an existing folder; {target.parent} does not exist")
    if target.is_dir():
        raise ValueError(f"{target}: must be a file name, not a folder")
    return target


def save_figure(figure: Figure, path: str | Path) -> Path:
    """Write a figure as png, svg or pdf by the path's suffix; equal figures give equal bytes.

    Raises:
        ValueError: for another suffix or a missing folder.
    """
    target = checked_target(path, FIGURE_SUFFIXES)
    kind = target.suffix.lower().removeprefix(".")
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    with complete_or_absent(target) as partial, styled():
        figure.savefig(partial, format=kind, metadata=undated)
    return target
