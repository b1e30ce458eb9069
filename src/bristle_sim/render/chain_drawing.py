"""Draw a chain of rods at the instant of its impact, to scale: root, hinges, rods, surface, and the tip's velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle
from numpy.typing import NDArray

from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, LIGHT, PURPLE
from bristle_sim.render.drawing import View, moving_arrow, point_arrow

Array = NDArray[np.float64]

ARROW = 0.3
"""Length of the tip's velocity before the impact, as a fraction of the drawing's size."""


GROUND = 0.15
"""Fraction of the drawing's height below the surface."""


class ChainDrawing:
    """The chain in axes of its own; only the arrow of the tip's velocity moves."""

    def __init__(self, axes: Axes, centre_line: Array, hub_radius: float, fastest: float) -> None:
        """Draw the rods as they strike.

        Args:
            axes: of the drawing.
            centre_line: root, hinges and tip from the hub's centre, shape (corners, 2), m.
            hub_radius: zero for a fixed root, m.
            fastest: the tip's speed that the longest arrow shows, m/s.
        """
        points = centre_line - centre_line[-1]
        box = axes.get_window_extent()
        view = View.around([points], box.width / box.height, 0.2)
        height = view.top - view.bottom
        View(view.left, view.right, -GROUND * height, (1.0 - GROUND) * height).apply(axes)
        axes.set_axis_off()
        self._size = float(np.ptp(axes.get_ylim()))
        self._fastest = fastest
        _draw_surface(axes)
        _draw_root(axes, points[0], -centre_line[-1], hub_radius, self._size)
        axes.plot(*points.T, color=BLUE, linewidth=4.0, solid_capstyle="round", zorder=3, gid="rods")
        axes.plot(*points[1:-1].T, "o", color="white", markeredgecolor=BLACK, markersize=6, zorder=4)
        self.arrow = moving_arrow(axes, PURPLE, 2.0, 13.0)
        self.artists: list[Artist] = [self.arrow]

    def point(self, along: float, up: float) -> None:
        """Let the arrow show a velocity of the tip, m/s: towards the tip as it comes, from it as it leaves."""
        length = ARROW * self._size / self._fastest
        ahead = (along * length, up * length)
        start, end = ((-ahead[0], -ahead[1]), (0.0, 0.0)) if up < 0.0 else ((0.0, 0.0), ahead)
        point_arrow(self.arrow, start, end, shortest=0.02 * ARROW * self._size)


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
