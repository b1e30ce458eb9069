"""Draw what a film of an impact shows: the rods to scale, the tip strongly enlarged at the surface, and panels over time.

The close-up has the tip's way along and into the surface and the forces on it; the panels have velocities and forces, shaded
phase by phase, with markers that move along.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon, Rectangle

from bristle_sim.arrays import Array
from bristle_sim.render.contact_motion import ContactMotion
from bristle_sim.render.drawing import View, draw_scale_bar, moving_arrow, point_arrow
from bristle_sim.render.impulse_plane import PHASE_COLOURS
from bristle_sim.render.style import BLACK, BLUE, GREEN, GREY, LIGHT, PURPLE, SKY, VERMILION, scale_for

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


NORMAL, TANGENTIAL = BLUE, VERMILION

ROUNDING = 1e-6
"""Velocities below this fraction of the fastest are drawn as zero."""

PANELS = (
    ("$v_t$, along\nthe surface", "m/s", (("tangential_velocity", TANGENTIAL),)),
    ("$v_n$, away\nfrom it", "m/s", (("normal_velocity", NORMAL),)),
    ("forces\non the tip", "N", (("normal_force", NORMAL), ("tangential_force", TANGENTIAL))),
)

GAP = 0.035
"""Between panels, as a fraction of the figure's height."""


class ContactPanels:
    """Panels one above the other.

    Attributes:
        clock: scale of the times shown.
        markers: each with the quantity it follows and the factor from SI to what is shown.
        artists: what moves.
    """

    def __init__(
        self, figure: Figure, motion: ContactMotion, box: tuple[float, float, float, float], letter_size: float
    ) -> None:
        """``box``: left, bottom, width and height, as shares of the figure."""
        self.motion, self.clock = motion, scale_for(motion.touch_end, "s")
        self.markers: list[tuple[Line2D, str, float]] = []
        self.hands: list[Line2D] = []
        left, bottom, width, height = box
        share = height / len(PANELS)
        for number, (title, unit, lines) in enumerate(PANELS):
            below = len(PANELS) - 1 - number
            axes = figure.add_axes((left, bottom + below * share, width, share - GAP))
            self._draw(axes, title, unit, lines, letter_size)
            axes.tick_params(labelsize=0.9 * letter_size, labelbottom=below == 0)
        axes.set_xlabel(f"time since the first touch ({self.clock.unit})", fontsize=letter_size)
        self.artists: list[Artist] = [*self.hands, *(marker for marker, _, _ in self.markers)]

    def show(self, time: float) -> None:
        """Move hands and markers to an instant, s."""
        shown = time * self.clock.factor
        for marker, name, factor in self.markers:
            marker.set_data([shown], [self.motion.at(name, time) * factor])
        for hand in self.hands:
            hand.set_xdata([shown, shown])

    def _draw(self, axes: Axes, title: str, unit: str, lines: tuple[tuple[str, str], ...], letter_size: float) -> None:
        largest = max(float(np.abs(getattr(self.motion, name)).max()) for name, _ in lines)
        least = ROUNDING * self.motion.fastest if unit == "m/s" else 0.0
        scale = scale_for(max(largest, least), unit)
        time = self.motion.time * self.clock.factor
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        for name, color in lines:
            axes.plot(time, getattr(self.motion, name) * scale.factor, color=color, linewidth=1.8)
            (marker,) = axes.plot([], [], "o", color=color, markersize=6, markeredgecolor="white")
            self.markers.append((marker, name, scale.factor))
        self.hands.append(axes.axvline(0.0, color=BLACK, linewidth=1.0))
        self._shade(axes)
        axes.set_xlim(time[0], time[-1])
        axes.margins(y=0.1)
        if largest < least:
            axes.set_ylim(-least * scale.factor, least * scale.factor)
        axes.set_ylabel(f"{title} ({scale.unit})", fontsize=letter_size)
        axes.locator_params(axis="y", nbins=5)

    def _shade(self, axes: Axes) -> None:
        ends = [*(phase.start for phase in self.motion.phases[1:]), float(self.motion.time[-1])]
        for phase, end in zip(self.motion.phases, ends, strict=True):
            color = PHASE_COLOURS.get(phase.caption, "white")
            axes.axvspan(phase.start * self.clock.factor, end * self.clock.factor, color=color, linewidth=0.0, zorder=0)
