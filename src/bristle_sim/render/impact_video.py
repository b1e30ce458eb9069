"""Film of one impact in ultra slow motion: the rods to scale, the tip enlarged, velocities and forces over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import ConnectionPatch, Rectangle

from bristle_sim.render.colours import BLACK, GREY
from bristle_sim.render.contact_motion import ContactMotion, caption, contact_motion
from bristle_sim.render.drawing import point_arrow
from bristle_sim.render.film_scene import BORDER, HEADER, FilmScene, TimeWarp, slow_motion, write_film
from bristle_sim.render.impact_drawings import NORMAL, TANGENTIAL, CloseUp, draw_chain
from bristle_sim.render.impact_figure import PHASE_COLOURS
from bristle_sim.render.story import Phase, phase_at
from bristle_sim.render.style import scale_for, signed, styled
from bristle_sim.studies.impacts import Impacts

CAPTION_SHOWN = 0.9
"""Film time for which the end of slip keeps its caption, s."""

ARROW = 0.3
"""Length of the tip's velocity before the impact, as a fraction of the drawing's size."""

ROUNDING = 1e-6
"""Velocities below this fraction of the fastest are drawn as zero."""

PANELS = (
    ("$v_t$, along\nthe surface", "m/s", (("tangential_velocity", TANGENTIAL),)),
    ("$v_n$, away\nfrom it", "m/s", (("normal_velocity", NORMAL),)),
    ("forces\non the tip", "N", (("normal_force", NORMAL), ("tangential_force", TANGENTIAL))),
)


def impact_video(impacts: Impacts, path: str | Path, *, fps: float = 30.0, **options: Any) -> Path:
    """Film an impact as the compliant law resolves it in time, to an mp4 or gif file; needs no display.

    Options are those of :class:`ImpactScene`: width and height (px), duration of the film (s), and how much ``slower`` the
    end of slip is shown than the rest. :func:`bristle_sim.studies.timed_contact.with_visible_contact` makes a contact
    visible.

    Raises:
        ValueError: for a tip that does not approach, a file that cannot be written or settings out of range.
    """
    return write_film(path, lambda: ImpactScene(impacts, **options), fps)


class ImpactScene(FilmScene):
    """The drawing that a film of an impact shows, at any film time."""

    size, letter_size = (960, 540), 15.0

    @styled()
    def __init__(
        self, impacts: Impacts, *, width: int = 960, height: int = 540, duration: float = 10.0, slower: float = 3.0
    ) -> None:
        if "compliant" not in impacts.strikes:
            raise ValueError("contact: not resolved in time for these values; there is no motion to film")
        self.motion = motion = contact_motion(impacts.strikes["compliant"].contact)
        focus = () if motion.slip_stop is None else (motion.slip_stop,)
        start, end = float(motion.time[0]), float(motion.time[-1])
        warp = slow_motion(start, end, duration, focus, slower=slower, width=0.05)
        super().__init__(warp, width, height, ((18, NORMAL), (18, TANGENTIAL)), scale_for(motion.touch_end, "s"))
        self._phases = _captions(motion, warp)
        self.markers: list[tuple[Line2D, str, float]] = []
        self._draw_tip(impacts)
        for number, row in enumerate(PANELS):
            self._draw_panel(number, *row)
        self.stage.add(*self.hands, *(marker for marker, _, _ in self.markers))
        self._describe(impacts)

    def move(self, time: float) -> tuple[str, ...]:
        """Move drawings and markers to an instant, s; the arrow ends at a tip that comes, and begins at one that leaves."""
        tangential, normal = (self.motion.at(f"{name}_velocity", time) for name in ("tangential", "normal"))
        self.close_up.show(time)
        size = ARROW * float(np.ptp(self.chain.get_ylim()))
        ahead = np.array([tangential, normal]) * size / self.motion.fastest
        start, end = (-ahead, 0.0 * ahead) if normal < 0.0 else (0.0 * ahead, ahead)
        point_arrow(self.arrow, (start[0], start[1]), (end[0], end[1]), shortest=0.02 * size)
        for marker, name, factor in self.markers:
            marker.set_data([time * self.clock.factor], [self.motion.at(name, time) * factor])
        speed = scale_for(self.motion.fastest, "m/s")
        words = (("away", normal), ("along", tangential))
        texts = (f"{way} {signed(value * speed.factor, 2, 7)} {speed.unit}" for way, value in words)
        return caption(phase_at(self._phases, time).caption), *texts

    def _draw_tip(self, impacts: Impacts) -> None:
        """Draw the chain to scale on the left, and beside it the tip at the surface with its enlargement."""
        top, figure = 1.0 - HEADER, self.stage.figure
        self.chain = figure.add_axes((0.01, 0.02, 0.2, top - 0.03))
        near = figure.add_axes((0.22, 0.075, 0.36, top - 0.085))
        line = impacts.strikes["compliant"].centre_line
        self.arrow = draw_chain(self.chain, line, impacts.chain.hub_radius)
        self.close_up = close_up = CloseUp(near, self.motion, line[-1] - line[-2], 0.62 * self.letters)
        half = 0.025 * float(np.ptp(self.chain.get_ylim()))  # the tip is framed, and a line leads to its close-up
        self.chain.add_patch(Rectangle((-half, -half), 2.0 * half, 2.0 * half, fill=False, edgecolor=GREY, zorder=6))
        ends: dict[str, Any] = {"coordsA": self.chain.transData, "coordsB": near.transAxes}
        figure.add_artist(ConnectionPatch((half, 0.0), (0.0, 0.2), **ends, color=GREY, linewidth=0.8))
        forces = (close_up.normal, close_up.friction)
        self.stage.add(close_up.block, close_up.rod, close_up.trail, *forces, *close_up.names, self.arrow)
        rods = self.chain.get_window_extent().height / float(np.ptp(self.chain.get_ylim()))
        ways = near.get_window_extent().width * close_up.scale
        deeper = f", depth {close_up.stretch:.2g} times more" if close_up.stretch > 1.0 else ""
        words = f"the tip's displacements are drawn {ways / rods:.3g} times larger than the rods{deeper}"
        figure.text(near.get_position().x0, 0.028, words, fontsize=0.58 * self.letters, color=GREY)

    def _draw_panel(self, number: int, title: str, unit: str, lines: tuple[tuple[str, str], ...]) -> None:
        """Draw quantities over time, shaded phase by phase, one panel below the other."""
        motion, letters, height = self.motion, 0.6 * self.letters, (1.0 - HEADER - 0.13) / len(PANELS)
        bottom = 0.10 + (len(PANELS) - 1 - number) * height
        axes = self.stage.figure.add_axes((0.685, bottom, 0.305, height - 0.035))
        largest = max(float(np.abs(getattr(motion, name)).max()) for name, _ in lines)
        least = ROUNDING * motion.fastest if unit == "m/s" else 0.0
        scale, time = scale_for(max(largest, least), unit), motion.time * self.clock.factor
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        for name, color in lines:
            axes.plot(time, getattr(motion, name) * scale.factor, color=color, linewidth=1.8)
            (marker,) = axes.plot([], [], "o", color=color, markersize=6, markeredgecolor="white")
            self.markers.append((marker, name, scale.factor))
        self.hands.append(axes.axvline(0.0, color=BLACK, linewidth=1.0))
        ends = [*(phase.start for phase in motion.phases[1:]), float(motion.time[-1])]
        for phase, end in zip(motion.phases, ends, strict=True):
            look: dict[str, Any] = {"color": PHASE_COLOURS.get(phase.caption, "white"), "linewidth": 0.0, "zorder": 0}
            axes.axvspan(phase.start * self.clock.factor, end * self.clock.factor, **look)
        axes.set_xlim(time[0], time[-1])
        axes.margins(y=0.1)
        if largest < least:
            axes.set_ylim(-least * scale.factor, least * scale.factor)
        axes.set_ylabel(f"{title} ({scale.unit})", fontsize=letters)
        axes.locator_params(axis="y", nbins=5)
        axes.tick_params(labelsize=0.9 * letters, labelbottom=number == len(PANELS) - 1)
        if number == len(PANELS) - 1:
            axes.set_xlabel(f"time since the first touch ({self.clock.unit})", fontsize=letters)

    def _describe(self, impacts: Impacts) -> None:
        """Write durations and coefficients in the upper right corner."""
        clock, surface = self.clock, impacts.surface
        source = f" ({impacts.timing})" if impacts.timing else ""
        words = (
            f"compression {self.motion.compression_end * clock.factor:.4g} {clock.unit}{source}\n"
            f"in touch for {self.motion.touch_end * clock.factor:.4g} {clock.unit},"
            f" μ = {surface.friction:.4g}, e* = {surface.restitution:.4g}"
        )
        place = (1.0 - BORDER, 1.0 - 0.33 * HEADER)
        self.stage.figure.text(*place, words, ha="right", va="center", fontsize=0.65 * self.letters, color=GREY)


def _captions(motion: ContactMotion, warp: TimeWarp) -> tuple[Phase, ...]:
    """Return the motion's phases, with the end of slip as one of its own for the time its caption stands."""
    stop = motion.slip_stop
    if stop is None:
        return motion.phases
    middle = float(warp.film_time(stop))
    start, end = map(float, warp.physical_time(middle + 0.5 * CAPTION_SHOWN * np.array([-1.0, 1.0])))
    before = [phase for phase in motion.phases if phase.start < stop]
    after = [Phase(max(phase.start, end), phase.caption) for phase in motion.phases[len(before) :]]
    return (*before, Phase(max(start, before[-1].start), "slip stops"), *after)
