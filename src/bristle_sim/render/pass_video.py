"""Film of a whole pass: the tool to scale in close-up, in slow motion around the strike."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.render.colours import BLACK, SKY, VERMILION
from bristle_sim.render.drawing import WireDrawing, close_up, draw_film_tool
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.story import phase_at, phases, story_end
from bristle_sim.render.style import MILLIMETRES, signed, styled
from bristle_sim.trajectory import Trajectory
from bristle_sim.trajectory.sampled_motion import SampledMotion

CAPTION_SHOWN = 0.5
"""Film time for which the instant of the strike keeps its caption, s."""


class PassFilm(Film):
    """The drawing that a film of a pass shows, by default until shortly after the tip has left the workpart.

    Options are width and height (px), duration of the film (s), how much ``slower`` the strike is shown than the rest, and
    the last instant shown, ``until`` (s).
    """

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
        course = self.motion.course(story_end(trajectory) if until is None else until)
        strike = trajectory.event_time("strike")
        focus = () if strike is None else (strike,)
        warp = slow_motion(self.motion.start, float(course.time[-1]), duration, focus, slower=slower)
        super().__init__(warp, width, height, (BLACK, BLACK))
        shown = 0.0 if strike is None else float(warp.physical_time(warp.film_time(strike) + CAPTION_SHOWN)) - strike
        self._phases = phases(trajectory, shown)
        self._trail_time, self._trail = course.time, course.tip * MILLIMETRES
        with styled():
            axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0 - HEADER))
            view = close_up(course.centre_line, tool, width / (height * (1.0 - HEADER)), margin=0.04)
            draw_film_tool(axes, tool, view, 0.75 * self.letters)
            struck = self.motion.centre_line(self.motion.end if strike is None else strike)[-1:] * MILLIMETRES
            (self.trail,) = axes.plot([], [], color=SKY, linewidth=1.6, zorder=3)
            self.wire = WireDrawing(axes, tool, details=True)
            (self.mark,) = axes.plot(*struck.T, "*", color=VERMILION, markersize=22, markeredgecolor="white", zorder=3)
        self.moving = [self.trail, *self.wire.artists, self.mark]

    def move(self, time: float) -> tuple[str, ...]:
        """Move wire and path to an instant, s; a star marks the strike while it is new."""
        centre_line, caption = self.motion.centre_line(time), phase_at(self._phases, time).caption
        past = self._trail[: np.searchsorted(self._trail_time, time, side="right")]
        self.wire.place(centre_line)
        self.trail.set_data(*np.vstack([past, centre_line[-1] * MILLIMETRES]).T)
        self.mark.set_visible(caption == "strike")
        retraction = math.degrees(float(self.motion.retraction(time)))
        return caption, f"retraction {signed(retraction, 1, 6)}°", f"tip speed {self.motion.tip_speed(time):5.1f} m/s"
