"""Film of a whole pass: the tool to scale in close-up, in slow motion around the strike."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from bristle_sim.parameters import Tool
from bristle_sim.render.drawing import draw_scale_bar
from bristle_sim.render.film_scene import HEADER, FilmScene, TimeWarp, slow_motion, write_film
from bristle_sim.render.story import phase_at, phases, story_end
from bristle_sim.render.style import BLACK, BLUE, SKY, VERMILION, signed, styled
from bristle_sim.render.tool_drawing import MILLIMETRES, WireDrawing, close_up, draw_tool, name_parts
from bristle_sim.trajectory import Trajectory
from bristle_sim.trajectory.sampled_motion import Course, SampledMotion

CAPTION_SHOWN = 0.5
"""Film time for which the instant of the strike keeps its caption, s."""

LETTERS = 13.0
"""Letter height in a picture of 640 x 480, px."""

COLUMNS = ((14, BLACK), (13, BLACK), (18, BLACK), (19, BLACK))
"""Characters and colour of the read-outs: time, slow-down, retraction, tip speed."""


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

    def build() -> PassScene:
        return PassScene(trajectory, tool, width=width, height=height, duration=duration, slower=slower, until=until)

    return write_film(path, build, (width, height), fps, duration)


class PassScene(FilmScene):
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
        self.motion = SampledMotion(trajectory)
        strike = trajectory.event_time("strike")
        course = self.motion.course(story_end(trajectory) if until is None else until)
        focus = () if strike is None else (strike,)
        warp = slow_motion(self.motion.start, float(course.time[-1]), duration, focus, slower=slower)
        super().__init__(warp, width, height, LETTERS * min(width / 640.0, height / 480.0), COLUMNS)
        self._phases = phases(trajectory, _shown(warp, strike))
        self._trail_time, self._trail = course.time, course.tip * MILLIMETRES
        with styled():
            axes = self.stage.figure.add_axes((0.0, 0.0, 1.0, 1.0 - HEADER))
            _draw_still(axes, tool, course, width / (height * (1.0 - HEADER)), 0.75 * self.letters)
            self._add_moving(axes, tool, self.motion.end if strike is None else strike)

    def show(self, film_time: float) -> None:
        """Move wire, path and read-outs to a film time, s; a star marks the strike while it is new."""
        time = float(self.warp.physical_time(film_time))
        centre_line = self.motion.centre_line(time)
        caption = phase_at(self._phases, time).caption
        past = self._trail[: np.searchsorted(self._trail_time, time, side="right")]
        self.wire.place(centre_line)
        self.trail.set_data(*np.vstack([past, centre_line[-1] * MILLIMETRES]).T)
        self.mark.set_visible(caption == "strike")
        retraction = math.degrees(float(self.motion.retraction(time)))
        texts = (
            f"time {time * 1e3:6.3f} ms",
            f"slowed {float(self.warp.slow_down_at(film_time)):5.0f}\N{MULTIPLICATION SIGN}",
            f"retraction {signed(retraction, 1, 6)}°",
            f"tip speed {float(self.motion.tip_speed(time)):5.1f} m/s",
        )
        self.write_words(caption, texts)

    def _add_moving(self, axes: Axes, tool: Tool, strike: float) -> None:
        struck = self.motion.centre_line(strike)[-1:] * MILLIMETRES
        (self.trail,) = axes.plot([], [], color=SKY, linewidth=1.6, zorder=3)
        self.wire = WireDrawing(axes, tool, color=BLUE, details=True)
        (self.mark,) = axes.plot(*struck.T, "*", color=VERMILION, markersize=22, markeredgecolor="white", zorder=3)
        self.stage.add(self.trail, *self.wire.artists, self.mark)


def _shown(warp: TimeWarp, strike: float | None) -> float:
    """Return the physical time that passes while the strike's caption stands, s."""
    if strike is None:
        return 0.0
    return float(warp.physical_time(warp.film_time(strike) + CAPTION_SHOWN)) - strike


def _draw_still(axes: Axes, tool: Tool, course: Course, aspect: float, letter_size: float) -> None:
    """Draw what does not move: hub, bar, workpart, their names and a scale bar."""
    view = close_up(course, tool, aspect, margin=0.04)
    view.apply(axes)
    axes.set_axis_off()
    draw_tool(axes, tool, view)
    name_parts(axes, tool, letter_size)
    width, height = view.right - view.left, view.top - view.bottom
    place = (view.right - 0.025 * width, view.bottom + 0.03 * height)
    draw_scale_bar(axes, 1.0 / MILLIMETRES, place, letter_size, leftwards=True)
