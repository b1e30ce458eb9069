"""A chain of rods at the instant of its impact, to scale: root, hinges, rods, surface, and the tip's velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Rectangle
from numpy.typing import NDArray

from bristle_sim.render.style import BLACK, BLUE, GREEN, GREY, LIGHT, PURPLE
from bristle_sim.scene.strike import ChainStrike

__all__ = ["ChainDrawing"]

Array = NDArray[np.float64]

ARROW = 0.3
"""Length of the tip's velocity before the impact, as a share of the drawing's size."""


class ChainDrawing:
    """The chain in axes of its own; only the arrow of the tip's velocity moves."""

    def __init__(self, axes: Axes, struck: ChainStrike, hub_radius: float, fastest: float) -> None:
        """Draw the rods as they strike; ``fastest`` is the tip's speed that the longest arrow shows, m/s."""
        points = struck.centre_line - struck.centre_line[-1]
        box = axes.get_window_extent()
        _frame(axes, points, box.width / box.height)
        self._size = float(np.ptp(axes.get_ylim()))
        self._fastest = fastest
        _draw_surface(axes)
        _draw_root(axes, points[0], -struck.centre_line[-1], hub_radius, self._size)
        axes.plot(*points.T, color=BLUE, linewidth=4.0, solid_capstyle="round", zorder=3, gid="rods")
        axes.plot(*points[1:-1].T, "o", color="white", markeredgecolor=BLACK, markersize=6, zorder=4)
        self.arrow = FancyArrowPatch(
            (0.0, 0.0),
            (0.0, 0.0),
            arrowstyle="-|>",
            mutation_scale=13.0,
            shrinkA=0.0,
            shrinkB=0.0,
            color=PURPLE,
            zorder=5,
        )
        self.arrow.set_linewidth(2.0)
        axes.add_patch(self.arrow)
        self.artists: list[Artist] = [self.arrow]

    def point(self, along: float, up: float) -> None:
        """Let the arrow show a velocity of the tip, m/s: towards the tip as it comes, from it as it leaves."""
        length = ARROW * self._size / self._fastest
        ends = [(0.0, 0.0), (along * length, up * length)]
        if up < 0.0:
            ends = [(-along * length, -up * length), (0.0, 0.0)]
        self.arrow.set_visible(np.hypot(along, up) > 0.02 * self._fastest)
        self.arrow.set_positions(*ends)


def _frame(axes: Axes, points: Array, aspect: float) -> None:
    """The chain with a margin for the arrow, at equal scales."""
    left, bottom = points.min(axis=0)
    right, top = points.max(axis=0)
    size = max(top - bottom, (right - left) / aspect)
    margin = 0.2 * size
    height = top - bottom + 2.0 * margin
    height = max(height, (right - left + 2.0 * margin) / aspect)
    middle = 0.5 * (left + right)
    axes.set_xlim(middle - 0.5 * height * aspect, middle + 0.5 * height * aspect)
    axes.set_ylim(bottom - margin, bottom - margin + height)
    axes.set_axis_off()


def _draw_surface(axes: Axes) -> None:
    (left, right), (bottom, _) = axes.get_xlim(), axes.get_ylim()
    width = right - left
    look: dict[str, Any] = {"facecolor": LIGHT, "edgecolor": GREY, "linewidth": 0.8, "hatch": "////"}
    axes.add_patch(Rectangle((left - width, 2.0 * bottom), 3.0 * width, -2.0 * bottom, **look))


def _draw_root(axes: Axes, root: Array, centre: Array, hub_radius: float, size: float) -> None:
    """A hub's rim through the root, or a fixed hinge."""
    if hub_radius > 0.0:
        axes.add_patch(Circle((centre[0], centre[1]), hub_radius, facecolor="#f3f3f3", edgecolor=GREY))
        axes.text(root[0], root[1] + 0.1 * size, "hub", color=GREY, ha="right", fontsize=9.0, clip_on=True)
    else:
        half = 0.04 * size
        look: dict[str, Any] = {"facecolor": LIGHT, "edgecolor": GREY, "hatch": "////"}
        axes.add_patch(Rectangle((root[0] - half, root[1]), 2.0 * half, half, **look))
    axes.plot([root[0]], [root[1]], "o", color=GREEN, markersize=7, markeredgecolor="white", zorder=4)
