"""Draw the tip at the surface, strongly enlarged: its way along and into the surface, and the forces on it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from bristle_sim.render.colours import BLUE, GREY, LIGHT, SKY, VERMILION
from bristle_sim.render.contact_motion import ContactMotion
from bristle_sim.render.drawing import draw_scale_bar, moving_arrow, point_arrow

Array = NDArray[np.float64]

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
        self._start = 0.5 - 0.5 * self.scale * float(motion.along.max() + motion.along.min())
        self._strongest = float(np.hypot(motion.normal_force, motion.tangential_force).max()) or 1.0
        self._way = np.stack(self._place(motion.along, motion.depth), axis=-1)
        # Flatter at its bottom than the tip is round.
        deepest = self.scale * self.stretch * max(0.0, float(motion.depth.max()))
        self._dent_width = max(2.2 * TIP_RADIUS, 1.8 * math.sqrt(TIP_RADIUS * deepest))
        _frame(axes)
        self._add_moving(axes, _rod_outline(last_rod))
        self.artists += _force_names(axes, letter_size)
        leftwards = bool(last_rod[0] >= 0.0)  # the rod leaves this upper corner free
        draw_scale_bar(
            axes, 1.0 / self.scale, (0.96 if leftwards else 0.04, ABOVE - 0.09), letter_size, leftwards=leftwards
        )

    def show(self, time: float) -> None:
        """Move everything to an instant, s."""
        x, y = map(float, self._place(self.motion.at("along", time), self.motion.at("depth", time)))
        self.rod.set_xy(self._outline + np.array([x, y]))
        self.trail.set_data(*self._way[: np.searchsorted(self.motion.time, time, side="right")].T)
        self.block.set_xy(self._dented(min(time, self.motion.touch_end)))
        unit = LONGEST_FORCE / self._strongest
        normal, tangential = (self.motion.at(f"{name}_force", time) * unit for name in ("normal", "tangential"))
        # The normal arrow ends at the tip: above it is the rod.
        point_arrow(self.normal, (x, y - normal), (x, y), shortest=0.02)
        point_arrow(self.friction, (x, y), (x + tangential, y), shortest=0.02)

    def _place(self, along: Array | float, depth: Array | float) -> tuple[Array, Array]:
        return np.asarray(self._start + self.scale * along), np.asarray(-self.scale * self.stretch * depth)

    def _dented(self, time: float) -> Array:
        """The block's outline: pressed in under the tip, and left so after it."""
        x, y = self._place(self.motion.at("along", time), max(0.0, self.motion.at("depth", time)))
        across = np.linspace(-0.1, 1.1, 121)
        surface = y * np.exp(-(((across - x) / self._dent_width) ** 2))
        top = np.stack([across, surface], axis=-1)
        return np.concatenate([[[-0.1, -2.0]], top, [[1.1, -2.0]]])

    def _add_moving(self, axes: Axes, outline: Array) -> None:
        self._outline = outline
        self.block = Polygon(np.zeros((3, 2)), facecolor=LIGHT, edgecolor=GREY, linewidth=1.0)
        self.rod = Polygon(outline, facecolor="#bcd9ec", edgecolor=BLUE, linewidth=1.2, alpha=0.95)
        (self.trail,) = axes.plot([], [], color=SKY, linewidth=2.0)
        axes.add_patch(self.block)
        axes.add_patch(self.rod)
        self.normal, self.friction = (moving_arrow(axes, color, 3.0, 16.0) for color in (BLUE, VERMILION))
        self.artists: list[Artist] = [self.block, self.rod, self.trail, self.normal, self.friction]


def _frame(axes: Axes) -> None:
    """One unit wide, with the undisturbed surface as a dashed line."""
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(-BELOW, ABOVE)
    axes.set_aspect("equal", adjustable="box", anchor="C")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(True)
    axes.axhline(0.0, color=GREY, linewidth=0.8, dashes=(4, 3))


def _rod_outline(last_rod: Array) -> Array:
    """A round-ended rod that touches the origin from above and leans as the last rod does."""
    towards_hinge = -last_rod / math.hypot(*last_rod)
    across = np.array([-towards_hinge[1], towards_hinge[0]])
    centre = np.array([0.0, TIP_RADIUS])
    turn = np.linspace(0.0, np.pi, 40)[:, None]
    end = centre + TIP_RADIUS * (np.cos(turn) * across - np.sin(turn) * towards_hinge)
    return np.concatenate([end, end[[-1, 0]] + 3.0 * towards_hinge])


def _force_names(axes: Axes, letter_size: float) -> list[Artist]:
    """Drawn with every frame: they stand in the block, which moves."""
    look: dict[str, Any] = {"fontsize": letter_size, "va": "bottom"}
    return [
        axes.text(0.03, 0.02 - BELOW, "normal force on the tip", color=BLUE, ha="left", **look),
        axes.text(0.97, 0.02 - BELOW, "friction on the tip", color=VERMILION, ha="right", **look),
    ]
