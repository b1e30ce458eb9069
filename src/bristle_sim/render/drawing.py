"""Draw to scale: views of equal scales around points, a bar of round length, and arrows that move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike

from bristle_sim.render.style import BLACK, scale_for

LONGEST_BAR = 0.28
"""Longest scale bar as a fraction of the axes' width."""


@dataclass(frozen=True, slots=True)
class View:
    """The rectangle that a drawing shows, in the unit of its points."""

    left: float
    right: float
    bottom: float
    top: float

    @classmethod
    def around(cls, points: Sequence[ArrayLike], aspect: float, margin: float) -> View:
        """Return the smallest view of that ratio of width to height around arrays of points, shape (..., 2).

        ``margin`` is the free border as a fraction of the points' larger extent.
        """
        every = np.concatenate([np.reshape(each, (-1, 2)) for each in points])
        (left, bottom), (right, top) = every.min(axis=0).tolist(), every.max(axis=0).tolist()
        border = margin * max(right - left, top - bottom, 1e-300)
        width, height = right - left + 2.0 * border, top - bottom + 2.0 * border
        across, up = max(0.0, height * aspect - width) / 2.0 + border, max(0.0, width / aspect - height) / 2.0 + border
        return cls(left - across, right + across, bottom - up, top + up)

    def apply(self, axes: Axes) -> None:
        """Show this rectangle with equal scales."""
        axes.set(xlim=(self.left, self.right), ylim=(self.bottom, self.top))
        axes.set_aspect("equal", adjustable="box")


def draw_scale_bar(
    axes: Axes, metres: float, place: tuple[float, float], letter_size: float, *, leftwards: bool = False
) -> None:
    """Draw a round length from a place in the axes, of which one unit is so many metres, with the length above it."""
    left, right = axes.get_xlim()
    most = LONGEST_BAR * (right - left) * metres
    decade = 10.0 ** math.floor(math.log10(most))
    length = decade * max(step for step in (1.0, 2.0, 5.0) if step * decade <= most * (1.0 + 1e-9))
    shown, halo = scale_for(length, "m"), [withStroke(linewidth=4.0, foreground="white")]
    ends = sorted([place[0], place[0] + (-length if leftwards else length) / metres])
    axes.plot(ends, [place[1], place[1]], "|-", color=BLACK, linewidth=1.5, path_effects=halo)
    axes.annotate(
        f"{length * shown.factor:g} {shown.unit}",
        (0.5 * sum(ends), place[1]),
        (0.0, 5.0),
        textcoords="offset points",
        ha="center",
        fontsize=letter_size,
        path_effects=halo,
    )


def moving_arrow(axes: Axes, color: str, linewidth: float, head: float) -> FancyArrowPatch:
    """Add an arrow of no length, see point_arrow; ``head`` in points."""
    arrow = FancyArrowPatch((0.0, 0.0), (0.0, 0.0), arrowstyle="-|>", mutation_scale=head, shrinkA=0.0, shrinkB=0.0)
    arrow.set(color=color, linewidth=linewidth, zorder=5)
    axes.add_patch(arrow)
    return arrow


def point_arrow(arrow: FancyArrowPatch, start: tuple[float, float], end: tuple[float, float], shortest: float) -> None:
    """Show an arrow from start to end, unless it is shorter than ``shortest``, where its head would hide it."""
    arrow.set_visible(math.dist(start, end) > shortest)
    arrow.set_positions(start, end)
