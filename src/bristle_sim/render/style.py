"""The common look of pictures: fonts, panels with titles and notes, readable units, and files.

Figures are built on :class:`matplotlib.figure.Figure` alone: no display, no global state, and
pyplot is not imported. Sizes are printed centimetres. A full-width figure is 16 cm wide with text
of 7 to 8 points.
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
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import EngFormatter
from numpy.typing import ArrayLike

from bristle_sim.files import checked_target, complete_or_absent
from bristle_sim.render.colours import GREY

MILLIMETRES = 1e3
MILLISECONDS = 1e3
MICROSECONDS = 1e6
"""Millimetres in a metre, milliseconds and microseconds in a second."""

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
"""Quantities of a strike: title, unit shown, and the factor that converts SI units to it."""


@contextmanager
def styled() -> Iterator[None]:
    """Apply the common look of pictures, as a context or as a decorator of drawing functions."""
    with mpl.rc_context(_LOOK):
        yield


class NotebookFigure(Figure):
    """Figure that a notebook shows although pyplot is not imported.

    matplotlib itself makes figures visible to a notebook only if pyplot is imported.
    """

    def _repr_png_(self) -> bytes:
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=100)
        return picture.getvalue()


def blank_figure(width_cm: float, height_cm: float) -> Figure:
    """Return an empty figure with the given printed size, cm."""
    size = (width_cm / CENTIMETRES_PER_INCH, height_cm / CENTIMETRES_PER_INCH)
    return NotebookFigure(figsize=size, dpi=200.0)


def axes_at(
    figure: Figure, left: float, bottom: float, width: float, height: float, **options: Any
) -> Axes:
    """Add axes at a position (cm) from the figure's lower left corner.

    ``options`` are those of ``Figure.add_axes``.
    """
    across, up = figure.get_size_inches() * CENTIMETRES_PER_INCH
    return figure.add_axes((left / across, bottom / up, width / across, height / up), **options)


def add_panel(
    figure: Figure,
    place: tuple[float, float, float, float],
    title: str,
    subtitle: str = "",
    **options: Any,
) -> Axes:
    """Add axes with a title. Where a figure has several panels, letters precede their titles.

    ``place`` is (left, bottom, width, height), cm. ``subtitle`` is a smaller line of the title.
    """
    titled = [axes for axes in figure.axes if axes.get_title(loc="left")]
    if len(titled) == 1:
        _set_title(titled[0], titled[0].get_title(loc="left"), "a")
    axes = axes_at(figure, *place, **options)
    _set_title(axes, title, "abcdefghij"[len(titled) % 10] if titled else "")
    note(axes, subtitle, (0.0, 1.0), (0.0, 4.5), xycoords="axes fraction")
    return axes


def _set_title(axes: Axes, title: str, letter: str) -> None:
    """Set the title of a panel, with a bold letter before it; the letter may be empty."""
    text = f"$\\bf{{{letter}}}$  {title}" if letter else title
    axes.set_title(text, loc="left", fontsize=8.5, pad=17.0)


def write_key(target: Figure | Axes, looks: Mapping[str, Mapping[str, Any]], **place: Any) -> None:
    """Add a legend, by default in one row at the foot.

    ``looks`` holds the style of each entry by name. ``place`` are options of matplotlib's
    ``legend``.
    """
    handles = [Line2D([], [], label=name, **look) for name, look in looks.items()]
    target.legend(handles=handles, **{"loc": "lower center", "ncols": len(handles), **place})


def draw_colours(axes: Axes, x: ArrayLike, y: ArrayLike, values: ArrayLike, **look: Any) -> Axes:
    """Draw a map of coloured cells, and return the axes of its colour bar on the right."""
    axes.grid(visible=False)
    image = axes.pcolormesh(
        x, y, values, shading="nearest", rasterized=True, **{"cmap": "viridis", **look}
    )
    return add_colour_bar(axes, image, "neither")


def add_colour_bar(axes: Axes, image: ScalarMappable, extend: str) -> Axes:
    """Draw the colour bar of an image on the right of its axes, and return the axes of the bar."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    left, bottom, width, height = axes.get_position().bounds
    scale = figure.add_axes((left + 1.03 * width, bottom, 0.1 / figure.get_figwidth(), height))
    figure.colorbar(image, cax=scale, extend=extend)
    scale.tick_params(labelsize=6.0, colors=GREY)
    return scale


def add_right_scale(axes: Axes) -> Axes:
    """Return further axes of the same panel, whose scale is on the right."""
    right = axes.twinx()
    right.grid(visible=False)
    right.spines["right"].set_visible(True)
    return right


def note(
    axes: Axes, words: str, place: tuple[float, float], offset: tuple[float, float], **look: Any
) -> None:
    """Write a short text in small letters beside a point; ``offset`` from the point is in points."""
    axes.annotate(
        words,
        place,
        offset,
        **{"textcoords": "offset points", "fontsize": 7.0, "color": GREY, **look},
    )


def draw_zero(axes: Axes) -> None:
    """Draw a grey line where y is zero."""
    axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=1)


def name_above(axes: Axes, left: float = -0.04, **look: Any) -> None:
    """Add a legend in one row above a panel; ``left`` is its left edge over the panel's width."""
    handles, names = axes.get_legend_handles_labels()
    named = dict(zip(names, handles, strict=True))  # lines of one name share an entry
    place = (left, 0.985)
    axes.legend(
        list(named.values()),
        list(named),
        loc="lower left",
        bbox_to_anchor=place,
        ncols=len(named),
        **look,
    )


def say(axes: Axes, words: str) -> None:
    """Write a text in the middle of an empty panel, for example the reason why it is empty."""
    axes.set(xticks=[], yticks=[])
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", color=GREY)


def signed(value: float, decimals: int, width: int = 0) -> str:
    """Return a number as text with a true minus sign; a number that rounds to zero has no sign."""
    return f"{round(value, decimals) + 0.0:{width}.{decimals}f}".replace("-", "\N{MINUS SIGN}")


class Scale(NamedTuple):
    """Unit in which numbers are shown, and the factor that converts to it."""

    factor: float
    unit: str


def scale_for(largest: float, unit: str) -> Scale:
    """Return the unit prefix and factor with which a number lies between 1 and 1000.

    For example, 1.2e-3 N s becomes 1.2 mN·s.
    """
    size = abs(largest)
    if not 0.0 < size < math.inf:
        return Scale(1.0, unit)
    # The margin keeps 999.9996 from being written as 1000 of the smaller unit.
    exponent = 3 * math.floor(math.log10(size * (1.0 + 1e-6)) / 3.0)
    exponent = min(max(exponent, -15), 12)
    return Scale(10.0**-exponent, EngFormatter.ENG_PREFIXES[exponent] + unit)


def save_figure(figure: Figure, path: str | Path) -> Path:
    """Write a figure to a png, svg or pdf file, chosen by the suffix of the path.

    Equal figures give identical files.

    Raises:
        ValueError: for another suffix or a missing folder.
    """
    target = checked_target(path, FIGURE_SUFFIXES)
    kind = target.suffix.lower().removeprefix(".")
    stated = {"svg": ("Creator", "Date", "Format", "Type"), "pdf": ("CreationDate",)}
    none = dict.fromkeys(stated.get(kind, ()))
    with complete_or_absent(target) as partial, styled():
        figure.savefig(partial, format=kind, metadata=none)
    return target


def span_at_least(axes: Axes, fraction: float) -> None:
    """Widen the range of the y axis to at least a fraction of its largest value.

    Rounding error in a constant then does not look like scatter. The tick labels have no common
    offset.
    """
    low, high = axes.get_ylim()
    missing = fraction * max(abs(low), abs(high)) - (high - low)
    if missing > 0.0:
        axes.set_ylim(low - 0.5 * missing, high + 0.5 * missing)
    axes.ticklabel_format(axis="y", useOffset=False)
