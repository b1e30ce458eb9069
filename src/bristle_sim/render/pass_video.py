"""Film of a whole pass: the tool to scale in close-up, in slow motion around the strike."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from bristle_sim.parameters import Tool
from bristle_sim.render.motion import Course, Motion
from bristle_sim.render.readout import Readout
from bristle_sim.render.story import phase_at, phases, story_end
from bristle_sim.render.style import BLACK, BLUE, SKY, VERMILION, signed, styled
from bristle_sim.render.time_warp import TimeWarp, slow_motion
from bristle_sim.render.tool_drawing import (
    MILLIMETRES,
    View,
    WireDrawing,
    close_up,
    draw_bar,
    draw_hub,
    draw_workpart,
    name_parts,
)
from bristle_sim.render.video import Stage, check_film, checked_video_target, write_video
from bristle_sim.trajectory import Trajectory

__all__ = ["PassScene", "pass_video"]

Array = NDArray[np.float64]

HEADER = 0.13
"""Share of the picture's height above the drawing: caption and clock."""

CAPTION_SHOWN = 0.5
"""Film time for which the instant of the strike keeps its caption, s."""

LETTERS = 13.0
"""Letter height in a picture of 640 x 480, px."""

COLUMNS = (14, 13, 18, 19)
"""Characters of the read-outs: time, slow-down, retraction, tip speed."""


def pass_video(
    trajectory: Trajectory,
    tool: Tool,
    path: str | Path,
    *,
    fps: float = 30.0,
    width: int = 640,
    height: int = 480,
    duration: float = 8.0,
    slower: float = 4.0,
    until: float | None = None,
) -> Path:
    """Film a pass to an mp4 or gif file; needs no display.

    Args:
        trajectory, tool: the run and what was simulated.
        path: of the file, mp4 or gif.
        fps: frames per second of film.
        width, height: of the picture, px.
        duration: of the film, s.
        slower: how much slower the strike is shown than the rest.
        until: last instant shown, s; by default shortly after the tip has left the workpart.

    Raises:
        ValueError: for a file that cannot be written or settings out of range.
    """
    target = checked_video_target(path)
    check_film(target.suffix, (width, height), fps)
    scene = PassScene(trajectory, tool, width=width, height=height, duration=duration, slower=slower, until=until)
    total = max(2, math.ceil(duration * fps))
    return write_video(target, scene.frames(total), (width, height), fps, total)


class PassScene:
    """The drawing that a film of a pass shows, at any film time."""

    def __init__(
        self,
        trajectory: Trajectory,
        tool: Tool,
        *,
        width: int = 640,
        height: int = 480,
        duration: float = 8.0,
        slower: float = 4.0,
        until: float | None = None,
    ) -> None:
        self.tool, self.motion = tool, Motion(trajectory)
        strike = trajectory.event_time("strike")
        course = self.motion.course(story_end(trajectory) if until is None else until)
        focus = () if strike is None else (strike,)
        self.warp = slow_motion(self.motion.start, float(course.time[-1]), duration, focus, slower=slower)
        self._strike = self.motion.end if strike is None else strike
        self._phases = phases(trajectory, _shown(self.warp, strike))
        self._trail_time = course.time
        self._trail = course.tip * MILLIMETRES
        self.stage = Stage(width, height)
        self._letters = LETTERS * min(width / 640.0, height / 480.0)
        with styled():
            self._furnish(course)

    def _furnish(self, course: Course) -> None:
        tool, (width, height) = self.tool, self.stage.size
        axes = self.stage.figure.add_axes((0.0, 0.0, 1.0, 1.0 - HEADER))
        view = close_up(course, tool, width / (height * (1.0 - HEADER)), margin=0.04)
        _draw_still(axes, tool, view, 0.75 * self._letters)
        self._add_moving(axes)
        self._add_words()

    def _add_moving(self, axes: Axes) -> None:
        struck = self.motion.centre_line(self._strike)[-1]
        (self.trail,) = axes.plot([], [], color=SKY, linewidth=1.6, zorder=3)
        self.wire = WireDrawing(axes, self.tool, color=BLUE, details=True)
        (self.mark,) = axes.plot(
            *(struck[:, None] * MILLIMETRES), "*", color=VERMILION, markersize=22, markeredgecolor="white", zorder=3
        )
        self.stage.add(self.trail, *self.wire.artists, self.mark)

    def _add_words(self) -> None:
        """Caption and, below it, a row of read-outs."""
        width, height = self.stage.size
        letters = self._letters
        left = 0.025
        self.caption = self.stage.figure.text(
            left, 1.0 - 0.34 * HEADER, "", va="center", fontsize=letters, weight="bold", color=BLACK
        )
        self.readouts = tuple(Readout(0, 0, letters) for _ in COLUMNS)
        row = [readout.width(characters) for readout, characters in zip(self.readouts, COLUMNS, strict=True)]
        gap = ((1.0 - 2.0 * left) * width - sum(row)) / (len(row) - 1)
        for number, readout in enumerate(self.readouts):
            readout.left = round(left * width + sum(row[:number]) + number * gap)
            readout.top = round(0.78 * HEADER * height - 0.5 * readout.height)
        self.stage.write(*self.readouts)

    def frames(self, total: int) -> Iterator[memoryview]:
        """The film in ``total`` pictures evenly spaced in film time, the first and the last instant included."""
        for film_time in np.linspace(0.0, self.warp.film[-1], total):
            self.show(float(film_time))
            yield self.stage.frame()

    def show(self, film_time: float) -> None:
        """Move everything to a film time, s."""
        time = float(self.warp.physical_time(film_time))
        centre_line = self.motion.centre_line(time)
        self.wire.place(centre_line)
        self._show_trail(time, centre_line[-1])
        self._show_words(film_time, time)

    def _show_words(self, film_time: float, time: float) -> None:
        caption = phase_at(self._phases, time).caption
        if caption != self.caption.get_text():
            self.caption.set_text(caption)
            self.stage.refresh()
        retraction = math.degrees(float(self.motion.retraction(time)))
        texts = (
            f"time {time * 1e3:6.3f} ms",
            f"slowed {float(self.warp.slow_down_at(film_time)):5.0f}\N{MULTIPLICATION SIGN}",
            f"retraction {signed(retraction, 1, 6)}°",
            f"tip speed {float(self.motion.tip_speed(time)):5.1f} m/s",
        )
        for readout, text in zip(self.readouts, texts, strict=True):
            readout.text = text

    def _show_trail(self, time: float, tip: Array) -> None:
        """The path so far ends at the tip, and a star marks the strike while it is new."""
        past = self._trail[: np.searchsorted(self._trail_time, time, side="right")]
        self.trail.set_data(*np.vstack([past, tip * MILLIMETRES]).T)
        self.mark.set_visible(phase_at(self._phases, time).caption == "strike")


def _shown(warp: TimeWarp, strike: float | None) -> float:
    """Physical time that passes while the strike's caption stands, s."""
    if strike is None:
        return 0.0
    return float(warp.physical_time(warp.film_time(strike) + CAPTION_SHOWN)) - strike


def _draw_still(axes: Axes, tool: Tool, view: View, letter_size: float) -> None:
    """Everything that does not move: hub, bar, workpart, their names and a scale bar."""
    view.apply(axes)
    axes.set_axis_off()
    draw_hub(axes, tool)
    draw_bar(axes, tool)
    draw_workpart(axes, tool, view)
    name_parts(axes, tool, letter_size)
    _draw_scale_bar(axes, view, letter_size)


def _draw_scale_bar(axes: Axes, view: View, letter_size: float) -> None:
    length = 10.0 ** math.floor(math.log10(0.3 * (view.right - view.left)))
    right = view.right - 0.025 * (view.right - view.left)
    base = view.bottom + 0.03 * (view.top - view.bottom)
    halo = [withStroke(linewidth=4.0, foreground="white")]
    axes.plot([right - length, right], [base, base], "|-", color=BLACK, linewidth=1.5, path_effects=halo)
    axes.text(
        right - 1.1 * length, base, f"{length:g} mm", ha="right", va="center", fontsize=letter_size, path_effects=halo
    )
