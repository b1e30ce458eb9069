"""Draw what a film of an impact shows: the rods to scale, and the tip strongly enlarged at the surface.

The close-up has the tip's way along and into the surface, and the forces on it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle

from bristle_sim.arrays import Array
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, LIGHT, PURPLE, SKY, VERMILION
from bristle_sim.render.contact_motion import ContactMotion
from bristle_sim.render.drawing import GROUND, HUB_COLOUR, View, draw_scale_bar, moving_arrow, point_arrow

DEPTH = 0.15
"""Fraction of the drawing's height below the surface."""

NORMAL, TANGENTIAL = BLUE, VERMILION


def draw_chain(axes: Axes, centre_line: Array, hub_radius: float) -> FancyArrowPatch:
    """Draw the rods as they strike, the tip at the origin, and return the arrow of the tip's velocity.

    Args:
        axes: of the drawing.
        centre_line: root, hinges and tip from the hub's centre, shape (corners, 2), m.
        hub_radius: zero for a fixed root, m.
    """
    points, centre = centre_line - centre_line[-1], -centre_line[-1]
    box = axes.get_window_extent()
    view = View.around([points], box.width / box.height, 0.2)
    size, width, (x, y) = view.top - view.bottom, view.right - view.left, points[0]
    View(view.left, view.right, -DEPTH * size, (1.0 - DEPTH) * size).apply(axes)
    axes.set_axis_off()
    axes.add_patch(Rectangle((view.left - width, -2.0 * DEPTH * size), 3.0 * width, 2.0 * DEPTH * size, **GROUND))
    if hub_radius > 0.0:
        axes.add_patch(Circle((centre[0], centre[1]), hub_radius, facecolor=HUB_COLOUR, edgecolor=GREY))
        axes.text(x, y + 0.1 * size, "hub", color=GREY, ha="right", fontsize=9.0, clip_on=True)
    else:
        axes.add_patch(Rectangle((x - 0.04 * size, y), 0.08 * size, 0.04 * size, **GROUND))
    axes.plot([x], [y], "o", color=GREEN, markersize=7, markeredgecolor="white", zorder=4)
    axes.plot(*points.T, color=BLUE, linewidth=4.0, solid_capstyle="round", zorder=3, gid="rods")
    axes.plot(*points[1:-1].T, "o", color="white", markeredgecolor=BLACK, markersize=6, zorder=4)
    return moving_arrow(axes, PURPLE, 2.0, 13.0)


WAY_ALONG, WAY_DOWN = 0.5, 0.26
"""The most that the tip's displacements along and into the surface may take of the drawing's width."""

LEAST_DOWN = 0.08
"""The depth of a grazing tip is stretched until it takes this much."""

TIP_RADIUS, LONGEST_FORCE = 0.07, 0.3
"""Sizes that are not to scale, as fractions of the drawing's width."""

ABOVE, BELOW = 0.55, 0.62
"""How far the drawing reaches above and below the surface."""


class CloseUp:
    """A drawing one unit wide, in which the tip's displacements are ``scale`` units a metre, in depth ``stretch`` times more.

    Ways are to scale; rod and dent are not.
    """

    def __init__(self, axes: Axes, motion: ContactMotion, last_rod: Array, letter_size: float) -> None:
        """``last_rod``: from its hinge to the tip, (x, y) in any unit."""
        self.motion = motion
        way, depth = float(np.ptp(motion.along)), float(motion.depth.max() - min(0.0, motion.depth.min()))
        self.scale = min(WAY_ALONG / max(way, 1e-300), WAY_DOWN / max(depth, 1e-300))
        self.stretch = max(1.0, LEAST_DOWN / max(self.scale * depth, 1e-300))
        axes.set(xlim=(0.0, 1.0), ylim=(-BELOW, ABOVE), xticks=[], yticks=[])
        axes.set_aspect("equal", adjustable="box", anchor="C")
        axes.spines[:].set_visible(True)
        axes.axhline(0.0, color=GREY, linewidth=0.8, dashes=(4, 3))  # the undisturbed surface
        self.block = Polygon(np.zeros((3, 2)), facecolor=LIGHT, edgecolor=GREY, linewidth=1.0)
        self._outline = _rod_outline(last_rod)
        self.rod = Polygon(self._outline, facecolor="#bcd9ec", edgecolor=BLUE, linewidth=1.2, alpha=0.95)
        (self.trail,) = axes.plot([], [], color=SKY, linewidth=2.0)
        axes.add_patch(self.block)
        axes.add_patch(self.rod)
        self.normal, self.friction = (moving_arrow(axes, color, 3.0, 16.0) for color in (NORMAL, TANGENTIAL))
        look: dict[str, Any] = {"fontsize": letter_size, "va": "bottom"}
        # Drawn with every frame: they stand in the block, which moves.
        self.names = [
            axes.text(0.03, 0.02 - BELOW, "normal force on the tip", color=NORMAL, ha="left", **look),
            axes.text(0.97, 0.02 - BELOW, "friction on the tip", color=TANGENTIAL, ha="right", **look),
        ]
        leftwards = bool(last_rod[0] >= 0.0)  # the rod leaves this upper corner free
        corner = (0.96 if leftwards else 0.04, ABOVE - 0.09)
        draw_scale_bar(axes, 1.0 / self.scale, corner, letter_size, leftwards=leftwards)

    def show(self, time: float) -> None:
        """Move everything to an instant, s."""
        motion = self.motion
        x, y = map(float, self._place(motion.at("along", time), motion.at("depth", time)))
        past = slice(np.searchsorted(motion.time, time, side="right"))
        self.rod.set_xy(self._outline + np.array([x, y]))
        self.trail.set_data(*self._place(motion.along[past], motion.depth[past]))
        self.block.set_xy(self._dented(min(time, motion.touch_end)))
        strongest = float(np.hypot(motion.normal_force, motion.tangential_force).max()) or 1.0
        normal, tangential = (
            LONGEST_FORCE * motion.at(f"{name}_force", time) / strongest for name in ("normal", "tangential")
        )
        # The normal arrow ends at the tip: above it is the rod.
        point_arrow(self.normal, (x, y - normal), (x, y), shortest=0.02)
        point_arrow(self.friction, (x, y), (x + tangential, y), shortest=0.02)

    def _place(self, along: Array | float, depth: Array | float) -> tuple[Array, Array]:
        middle = 0.5 * float(self.motion.along.max() + self.motion.along.min())
        return np.asarray(0.5 + self.scale * (along - middle)), np.asarray(-self.scale * self.stretch * depth)

    def _dented(self, time: float) -> Array:
        """The block's outline: pressed in under the tip, and left so after it; flatter at its bottom than the tip is round."""
        x, y = self._place(self.motion.at("along", time), max(0.0, self.motion.at("depth", time)))
        deepest = self.scale * self.stretch * max(0.0, float(self.motion.depth.max()))
        width = max(2.2 * TIP_RADIUS, 1.8 * math.sqrt(TIP_RADIUS * deepest))
        across = np.linspace(-0.1, 1.1, 121)
        top = np.stack([across, y * np.exp(-(((across - x) / width) ** 2))], axis=-1)
        return np.concatenate([[[-0.1, -2.0]], top, [[1.1, -2.0]]])


def _rod_outline(last_rod: Array) -> Array:
    """A round-ended rod that touches the origin from above and leans as the last rod does."""
    towards_hinge = -last_rod / math.hypot(*last_rod)
    across = np.array([-towards_hinge[1], towards_hinge[0]])
    turn = np.linspace(0.0, np.pi, 40)[:, None]
    end = np.array([0.0, TIP_RADIUS]) + TIP_RADIUS * (np.cos(turn) * across - np.sin(turn) * towards_hinge)
    return np.concatenate([end, end[[-1, 0]] + 3.0 * towards_hinge])
