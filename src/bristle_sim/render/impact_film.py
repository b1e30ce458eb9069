"""Film of one impact in slow motion: the rods to scale, the tip enlarged, and curves over time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch, Rectangle
from matplotlib.patheffects import withStroke

from bristle_sim.arrays import Array
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, LIGHT, PURPLE, SKY, VERMILION
from bristle_sim.render.contact_motion import ContactMotion, contact_motion
from bristle_sim.render.drawing import GROUND, HUB_COLOUR, View, moving_arrow, point_arrow
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.impact_figure import PHASE_COLOURS
from bristle_sim.render.story import phase_at
from bristle_sim.render.style import scale_for, signed, styled
from bristle_sim.studies.contact_laws import Impacts

NORMAL = BLUE
TANGENTIAL = VERMILION
PANELS = (
    ("$v_t$, along\nthe surface", "m/s", {"tangential_velocity": TANGENTIAL}),
    ("$v_n$, away\nfrom it", "m/s", {"normal_velocity": NORMAL}),
    ("forces\non the tip", "N", {"normal_force": NORMAL, "tangential_force": TANGENTIAL}),
)
MOTIONS = {"slip": "the tip slips", "reverse slip": "the tip slips back", "stick": "the tip sticks"}

STILL = 1e-6  # largest velocity that is drawn as zero, over the largest velocity
ARROW = 0.13  # length of the arrow of the largest velocity, over the height of the drawing
# length of the arrow of the largest force, as a fraction of the drawing's height
LONGEST_FORCE = 0.28
LETTERS = 15.0  # height of the letters in a picture of default size, px
# Least depth at separation for which the picture has an explanation, over the largest depth.
CRATER = 0.02
# Radius and length of the enlarged end of the rod, not to scale, points in a picture of default
# size.
TIP_RADIUS = 9.0
ROD_LENGTH = 300.0


class TipDrawing:
    """Drawing of the enlarged tip: surface and path to scale, the rod's end and the forces not to
    scale.

    ``moving`` holds the moving artists.
    """

    def __init__(self, axes: Axes, motion: ContactMotion, last_rod: Array, letters: float) -> None:
        along = motion.samples["along"]
        depth = motion.samples["depth"]
        self._motion = motion
        box = axes.get_window_extent()
        size = 0.62 * letters
        self.scale = scale_for(max(float(np.ptp(along)), float(np.ptp(depth))), "m")
        self._path = np.stack([along, -depth], axis=-1) * self.scale.factor
        view = View.around([self._path], box.width / box.height, 0.5)
        height = view.top - view.bottom
        view.apply(axes)
        axes.grid(visible=False)
        axes.axhspan(
            2.0 * view.bottom, 0.0, facecolor=LIGHT, edgecolor=GREY, linewidth=1.0, zorder=0
        )
        axes.set_xlabel(
            f"the tip's displacement along the surface ({self.scale.unit})", fontsize=size
        )
        axes.set_ylabel(f"away from it ({self.scale.unit})", fontsize=size)
        axes.tick_params(labelsize=0.9 * size)
        (self.trail,) = axes.plot([], [], color=SKY, linewidth=2.0)
        outline = _rod_outline(last_rod) * letters / LETTERS
        look: dict[str, Any] = {
            "markerfacecolor": "#bcd9ec",
            "markeredgecolor": BLUE,
            "alpha": 0.95,
        }
        (self.rod,) = axes.plot(
            [], [], marker=outline, markersize=2.0 * np.abs(outline).max(), **look
        )
        self.forces = [moving_arrow(axes, color, 3.0, 16.0) for color in (NORMAL, TANGENTIAL)]
        self.moving = [self.trail, self.rod, *self.forces]
        strongest = motion.largest("normal_force", "tangential_force") or 1.0
        self._newton = LONGEST_FORCE / strongest * height
        self._shortest = 0.02 * height
        words: dict[str, Any] = {"transform": axes.transAxes, "fontsize": size}
        left = motion.at("depth", motion.touch_end)
        if left > CRATER * depth.max():
            crater = scale_for(left, "m")
            deep = f"{left * crater.factor:.3g} {crater.unit}"
            why = f"It unloads more\nstiffly than it loads:\nthe tip leaves a crater\nof {deep}, below\nthe old surface."
            axes.text(0.03, 0.1, why, color=BLACK, **words | {"fontsize": 0.92 * size})
        axes.text(0.03, 0.02, "normal force", color=NORMAL, **words)
        axes.text(0.97, 0.02, "friction on the tip", color=TANGENTIAL, ha="right", **words)

    def move(self, time: float) -> None:
        """Move the rod's end, its path so far and the arrows of the forces to a time, s."""
        motion = self._motion
        factor = self.scale.factor
        x = motion.at("along", time) * factor
        y = -motion.at("depth", time) * factor
        past = self._path[: np.searchsorted(motion.time, time, side="right")]
        self.trail.set_data(*np.vstack([past, [x, y]]).T)
        self.rod.set_data([x], [y])
        up, aside = (
            motion.at(f"{name}_force", time) * self._newton for name in ("normal", "tangential")
        )
        # The normal arrow ends at the tip, since the rod is above the tip.
        point_arrow(self.forces[0], (x, y - up), (x, y), shortest=self._shortest)
        point_arrow(self.forces[1], (x, y), (x + aside, y), shortest=self._shortest)


class ImpactFilm(Film):
    """Film of an impact that the compliant law of contact resolves in time.

    :func:`bristle_sim.studies.timed_contact.with_visible_contact` returns impacts that can be
    filmed.

    Raises:
        ValueError: if no contact is resolved in time.
    """

    size = (960, 540)
    letter_size = LETTERS

    @styled()
    def __init__(
        self, impacts: Impacts, *, width: int = 960, height: int = 540, duration: float = 10.0
    ) -> None:
        if "compliant" not in impacts.strikes:
            raise ValueError(
                "contact: not resolved in time for these values; there is no motion to film"
            )
        struck = impacts.strikes["compliant"]
        surface = impacts.surface
        self.motion = motion = contact_motion(struck.contact)
        warp = slow_motion(float(motion.time[0]), float(motion.time[-1]), duration)
        super().__init__(
            warp, width, height, (NORMAL, TANGENTIAL), scale_for(motion.touch_end, "s")
        )
        self.fastest = motion.largest("normal_velocity", "tangential_velocity")
        top = 1.0 - HEADER
        self.chain = self.figure.add_axes((0.01, 0.02, 0.2, top - 0.03))
        self.arrow = draw_chain(
            self.chain, struck.centre_line, impacts.chain.hub_radius, 0.62 * self.letters
        )
        close_up = self.figure.add_axes((0.285, 0.1, 0.31, top - 0.11))
        self.tip = TipDrawing(
            close_up, motion, struck.centre_line[-1] - struck.centre_line[-2], self.letters
        )
        self.markers: list[tuple[Line2D, str, float]] = []
        for number, row in enumerate(PANELS):
            self._draw_panel(number, *row)
        self.moving = [
            *self.tip.moving,
            self.arrow,
            *self.hands,
            *(each for each, *_ in self.markers),
        ]
        source = f" ({impacts.timing})" if impacts.timing else ""
        compressed = f"{motion.compression_end * self.clock.factor:.4g} {self.clock.unit}"
        touched = f"{motion.touch_end * self.clock.factor:.4g} {self.clock.unit}"
        words = f"compression {compressed}{source}\nin touch for {touched}, μ = {surface.friction:.4g}, e* = {surface.restitution:.4g}"
        look: dict[str, Any] = {
            "ha": "right",
            "va": "top",
            "fontsize": 0.66 * self.letters,
            "color": GREY,
        }
        self.figure.text(0.98, 0.985, words, **look)

    def move(self, time: float) -> tuple[str, ...]:
        """Move drawings and markers to a time, s.

        The arrow of the velocity ends at the tip while the tip arrives, and begins at the tip when
        it leaves.
        """
        motion = self.motion
        height = float(np.ptp(self.chain.get_ylim()))
        tangential = motion.at("tangential_velocity", time)
        normal = motion.at("normal_velocity", time)
        x, y = ARROW * height / self.fastest * np.array([tangential, normal])
        start, end = ((-x, -y), (0.0, 0.0)) if normal < 0.0 else ((0.0, 0.0), (x, y))
        point_arrow(self.arrow, start, end, shortest=0.006 * height)
        self.tip.move(time)
        for marker, name, factor in self.markers:
            marker.set_data([time * self.clock.factor], [motion.at(name, time) * factor])
        speed = scale_for(self.fastest, "m/s")
        words = (("away", normal), ("along", tangential))
        texts = (
            f"{name} {signed(value * speed.factor, 2, 7)} {speed.unit}" for name, value in words
        )
        half, _, sliding = (phase := phase_at(motion.phases, time).caption).partition(" ")
        return f"{half}: {MOTIONS[sliding]}" if sliding in MOTIONS else phase, *texts

    def _draw_panel(self, number: int, title: str, unit: str, lines: dict[str, str]) -> None:
        motion = self.motion
        letters = 0.6 * self.letters
        height = (1.0 - HEADER - 0.13) / len(PANELS)
        lowest = number == len(PANELS) - 1
        clock = self.clock.factor
        bottom = 0.10 + (len(PANELS) - 1 - number) * height
        axes = self.add_timeline((0.685, bottom, 0.305, height - 0.035), 0.9 * letters)
        largest = max(motion.largest(name) for name in lines)
        least = STILL * self.fastest if unit == "m/s" else 0.0
        scale = scale_for(max(largest, least), unit)
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        for name, color in lines.items():
            axes.plot(
                motion.time * clock, motion.samples[name] * scale.factor, color=color, linewidth=1.8
            )
            (marker,) = axes.plot([], [], "o", color=color, markersize=6, markeredgecolor="white")
            self.markers.append((marker, name, scale.factor))
        ends = [*(phase.start for phase in motion.phases[1:]), float(motion.time[-1])]
        for phase, end in zip(motion.phases, ends, strict=True):
            color = PHASE_COLOURS.get(phase.caption, "white")
            axes.axvspan(phase.start * clock, end * clock, color=color, linewidth=0.0, zorder=0)
        axes.margins(y=0.1)
        if largest < least:
            axes.set_ylim(-least * scale.factor, least * scale.factor)
        axes.set_ylabel(f"{title} ({scale.unit})", fontsize=letters)
        axes.locator_params(axis="y", nbins=5)
        axes.tick_params(labelbottom=lowest)
        axes.set_xlabel(
            f"time since the first touch ({self.clock.unit})" if lowest else "", fontsize=letters
        )


def draw_chain(
    axes: Axes, centre_line: Array, hub_radius: float, letters: float
) -> FancyArrowPatch:
    """Draw the rods at the strike, with the tip at the origin.

    Args:
        axes: axes of the drawing.
        centre_line: root, hinges and tip from the hub's centre, shape (corners, 2), m.
        hub_radius: the hub's radius, m; zero for a fixed root.
        letters: size of the letters.

    Returns:
        The arrow of the tip's velocity.
    """
    points = centre_line - centre_line[-1]
    centre = -centre_line[-1]
    box = axes.get_window_extent()
    view = View.around([points], box.width / box.height, 0.35)
    size = view.top - view.bottom
    width = view.right - view.left
    x, y = points[0]
    View(view.left, view.right, -0.15 * size, 0.85 * size).apply(axes)
    axes.set_axis_off()
    axes.add_patch(Rectangle((view.left - width, -0.3 * size), 3.0 * width, 0.3 * size, **GROUND))
    if hub_radius > 0.0:
        axes.add_patch(
            Circle((centre[0], centre[1]), hub_radius, facecolor=HUB_COLOUR, edgecolor=GREY)
        )
        axes.text(x, y + 0.1 * size, "hub", color=GREY, ha="right", fontsize=letters, clip_on=True)
    else:
        axes.add_patch(Rectangle((x - 0.04 * size, y), 0.08 * size, 0.04 * size, **GROUND))
    axes.plot([x], [y], "o", color=GREEN, markersize=7, markeredgecolor="white", zorder=4)
    axes.plot(*points.T, color=BLUE, linewidth=4.0, solid_capstyle="round", zorder=3)
    axes.plot(*points[1:-1].T, "o", color="white", markeredgecolor=BLACK, markersize=6, zorder=4)
    halo = [withStroke(linewidth=3.0, foreground="white")]
    look: dict[str, Any] = {"color": PURPLE, "fontsize": letters, "path_effects": halo}
    axes.text(0.5, 0.02, "velocity of the tip", ha="center", transform=axes.transAxes, **look)
    return moving_arrow(axes, PURPLE, 2.0, 13.0)


def _rod_outline(last_rod: Array) -> Array:
    """Return the outline of the last rod's end, in points, for the enlarged drawing of the tip.

    The rod has a round end, which touches the origin from above, and the inclination of the last
    rod.
    """
    towards_hinge = -last_rod / math.hypot(*last_rod)
    across = np.array([-towards_hinge[1], towards_hinge[0]])
    turn = np.linspace(0.0, np.pi, 40)[:, None]
    end = np.array([0.0, TIP_RADIUS]) + TIP_RADIUS * (
        np.cos(turn) * across - np.sin(turn) * towards_hinge
    )
    return np.concatenate([end, end[[-1, 0]] + ROD_LENGTH * towards_hinge, end[:1]])
