"""The common style of pictures: colours, fonts, panels, readable units, and files.

Figures are objects of :class:`matplotlib.figure.Figure`. They need no display, no global state and
no pyplot. matplotlib's constrained layout places panels and legends. Sizes are in centimetres on
paper. A full-width figure is 16 cm wide with text of 7 to 8 points.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import EngFormatter

from bristle_sim.files import checked_target, complete_or_absent

# Colours that the colour-blind can distinguish
BLACK = "#1a1a1a"
GREY = "#6b6b6b"
LIGHT = "#e4e4e4"
BLUE = "#0072b2"
ORANGE = "#e69f00"
GREEN = "#009e73"
VERMILION = "#d55e00"
PURPLE = "#b8578e"
SKY = "#56b4e9"
OUTCOMES = {
    "rebounds": BLUE,
    "reverses its slip": GREEN,
    "sticks and rebounds": ORANGE,
    "stays": PURPLE,
    "jams": VERMILION,
    "does not strike": GREY,
    "refused": LIGHT,
}
"""Colour of each outcome of a strike on pages and maps.

The keys are the outcomes as they are worded in sentences."""

SERIES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
"""Colours of curves, in their order."""

Look = dict[str, Any]
"""Options of a drawing function of matplotlib, by name."""

FIGURE_SUFFIXES = (".png", ".svg", ".pdf")
CENTIMETRES_PER_INCH = 2.54

_LOOK = mpl.rc_params_from_file(
    Path(__file__).with_name("look.mplstyle"), use_default_template=False
)

STRIKE_LOOKS: dict[str, tuple[str, str, float]] = {
    "lag_deg_at_contact": ("lag at the strike", "degrees", 1.0),
    "relative_speed_at_contact": ("speed relative to the hub", "rad/s", 1.0),
    "tip_speed_at_contact": ("tip speed at the strike", "m/s", 1.0),
    "normal_final_impulse": ("normal impulse", "mN·s", 1e3),
    "normal_compressive_work": ("normal work of compression", "mJ", -1e3),
    "crater_depth": ("crater depth", "µm", 1e6),
}
"""Title, unit shown, and factor from the SI unit to the unit shown, for quantities of a strike.

The work of compression is negative. Its factor is negative too, so that the value shown is
positive."""


@contextmanager
def styled() -> Iterator[None]:
    """Apply the common style of figures, as a context manager or a decorator."""
    with mpl.rc_context(_LOOK):
        yield


class NotebookFigure(Figure):
    """A figure that a notebook shows although pyplot is not imported.

    matplotlib's own figures are shown only if pyplot is imported.
    """

    def _repr_png_(self) -> bytes:
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=100)
        return picture.getvalue()


def blank_figure(width_cm: float, height_cm: float) -> Figure:
    """Return an empty figure of a given printed width and height, cm."""
    size = (width_cm / CENTIMETRES_PER_INCH, height_cm / CENTIMETRES_PER_INCH)
    return NotebookFigure(figsize=size, dpi=200.0, layout="constrained")


def write_key(figure: Figure, looks: Mapping[str, Look], **place: Any) -> None:
    """Add a legend to a figure, by default in one row at the foot.

    ``looks`` holds the style of each entry by its name; ``place`` are options of matplotlib's
    ``legend``.
    """
    handles = [Line2D([], [], label=name, **look) for name, look in looks.items()]
    figure.legend(
        handles=handles, **{"loc": "outside lower center", "ncols": len(handles), **place}
    )


def add_right_scale(axes: Axes) -> Axes:
    """Add a second vertical scale on the right of a panel, and return its axes."""
    right = axes.twinx()
    right.grid(visible=False)
    right.spines["right"].set_visible(True)
    return right


def draw_zero(axes: Axes) -> None:
    """Draw a grey line where y is zero."""
    axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=1)


def say(axes: Axes, words: str) -> None:
    """Write a text in the middle of an empty panel, for example why it is empty."""
    axes.set(xticks=[], yticks=[])
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", color=GREY)


def signed(value: float, decimals: int, width: int = 0) -> str:
    """Return a number as text with a typographic minus sign.

    A number that rounds to zero has no sign. ``decimals`` is the number of decimals, ``width`` the
    least number of characters.
    """
    return f"{round(value, decimals) + 0.0:{width}.{decimals}f}".replace("-", "\N{MINUS SIGN}")


class Scale(NamedTuple):
    """A unit in which numbers are shown.

    ``factor`` converts a number to this unit.
    """

    factor: float
    unit: str


def scale_for(largest: float, unit: str) -> Scale:
    """Return the scale whose unit prefix makes the number ``largest`` lie between 1 and 1000.

    For example, 1.2e-3 with the unit N·s is shown as 1.2 mN·s.
    """
    size = abs(largest)
    if not 0.0 < size < math.inf:
        return Scale(1.0, unit)
    # The margin keeps 999.9996 from being written as 1000 of the smaller unit.
    exponent = 3 * math.floor(math.log10(size * (1.0 + 1e-6)) / 3.0)
    exponent = min(max(exponent, -15), 12)
    return Scale(10.0**-exponent, EngFormatter.ENG_PREFIXES[exponent] + unit)


def save_figure(figure: Figure, path: str | Path) -> Path:
    """Write a figure to a png, svg or pdf file, according to the suffix of the path.

    Equal figures give identical files.

    Raises:
        ValueError: if the suffix is not png, svg or pdf, or the folder does not exist.
    """
    target = checked_target(path, FIGURE_SUFFIXES)
    kind = target.suffix.lower().removeprefix(".")
    stated = {"svg": ("Creator", "Date", "Format", "Type"), "pdf": ("CreationDate",)}
    none = dict.fromkeys(stated.get(kind, ()))
    with complete_or_absent(target) as partial, styled():
        layout = figure.get_layout_engine()
        if layout is not None:
            layout.execute(figure)
        figure.set_layout_engine("none")  # a second layout would move panels a little
        figure.savefig(partial, format=kind, metadata=none)
    return target


def span_at_least(axes: Axes, fraction: float) -> None:
    """Widen the range of the vertical axis to at least ``fraction`` times its largest magnitude.

    Rounding error in a constant quantity then does not look like scatter. The tick labels show full
    values instead of differences from an offset.
    """
    low, high = axes.get_ylim()
    missing = fraction * max(abs(low), abs(high)) - (high - low)
    if missing > 0.0:
        axes.set_ylim(low - 0.5 * missing, high + 0.5 * missing)
    axes.ticklabel_format(axis="y", useOffset=False)
