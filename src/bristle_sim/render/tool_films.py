"""Films of the tool to scale, in slow motion: a whole pass, a row of bristles, and two tools side by side."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.colours import BLACK, BLUE, SERIES, SKY, VERMILION
from bristle_sim.render.drawing import WireDrawing, close_up, draw_film_tool, touch_places
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.story import Phase, phase_at, phases, story_end
from bristle_sim.render.style import MILLIMETRES, signed, styled
from bristle_sim.trajectory import Interpolation, Trajectory

if TYPE_CHECKING:
    from bristle_sim.studies.inertia_driven import InertiaDriven
    from bristle_sim.studies.neighbours import NeighbourRow

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
        self.motion = Interpolation(trajectory)
        course = self.motion.course(story_end(trajectory) if until is None else until)
        strike = trajectory.event_time("strike")
        focus = () if strike is None else (strike,)
        warp = slow_motion(float(trajectory.time[0]), float(course.time[-1]), duration, focus, slower=slower)
        super().__init__(warp, width, height, (BLACK, BLACK))
        shown = 0.0 if strike is None else float(warp.physical_time(warp.film_time(strike) + CAPTION_SHOWN)) - strike
        self._phases = phases(trajectory, shown)
        self._trail_time, self._trail = course.time, course.tip * MILLIMETRES
        with styled():
            axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0 - HEADER))
            view = close_up(course.centre_line, tool, width / (height * (1.0 - HEADER)), margin=0.04)
            draw_film_tool(axes, tool, view, 0.75 * self.letters)
            struck = self.motion(trajectory.time[-1] if strike is None else strike).tip[None] * MILLIMETRES
            (self.trail,) = axes.plot([], [], color=SKY, linewidth=1.6, zorder=3)
            self.wire = WireDrawing(axes, tool, details=True)
            (self.mark,) = axes.plot(*struck.T, "*", color=VERMILION, markersize=22, markeredgecolor="white", zorder=3)
        self.moving = [self.trail, *self.wire.artists, self.mark]

    def move(self, time: float) -> tuple[str, ...]:
        """Move wire and path to an instant, s; a star marks the strike while it is new."""
        now, caption = self.motion(time), phase_at(self._phases, time).caption
        past = self._trail[: np.searchsorted(self._trail_time, time, side="right")]
        self.wire.place(now.centre_line)
        self.trail.set_data(*np.vstack([past, now.tip * MILLIMETRES]).T)
        self.mark.set_visible(caption == "strike")
        retraction = math.degrees(float(now.retraction))
        return caption, f"retraction {signed(retraction, 1, 6)}°", f"tip speed {now.tip_speed:5.1f} m/s"


SLOWER = 10.0
"""How much slower touches and strikes are shown than the rest."""

AFTER = 0.15
"""How long the film goes on after the last bristle's strike, as a fraction of the time before."""


class RowFilm(Film):
    """The drawing that a film of a row shows, at any film time."""

    def __init__(self, row: NeighbourRow, width: int = 640, height: int = 480, duration: float = 12.0) -> None:
        self.motions = [Interpolation(run) for run in row.bristles]
        strike, end = row.bristles[-1].event_time("strike"), float(row.bristles[-1].time[-1])
        begin = min(row.bristles[0].event_time("bar touch") or 0.0, 0.8 * end)
        until = end if strike is None else min(end, strike + AFTER * (strike - begin))
        touches = [each for each in row.touches if begin <= each <= until]
        strikes = [each for run in row.bristles if (each := run.event_time("strike")) is not None and each <= until]
        colors = (SERIES * 2)[: len(row.bristles)]
        warp = slow_motion(begin, until, duration, (*touches, *strikes), slower=SLOWER, width=0.012)
        super().__init__(warp, width, height, (colors[-1],))
        self._phases, self._diameter = _phases(row), row.tool.bristle.wire_diameter
        with styled():
            axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0 - HEADER))
            times = np.linspace(begin, until, 200)
            paths = np.concatenate([motion(times).centre_line for motion in self.motions])
            view = close_up(paths, row.tool, width / (height * (1.0 - HEADER)), margin=0.08)
            draw_film_tool(axes, row.tool, view, 0.75 * self.letters)
            self.wires = [WireDrawing(axes, row.tool, color=color) for color in colors]
            (self.ring,) = axes.plot([], [], "o", markersize=26, markerfacecolor="none", color=BLACK, zorder=6)
        self.moving = [*(artist for wire in self.wires for artist in wire.artists), self.ring]

    def move(self, time: float) -> tuple[str, ...]:
        """Move wires to an instant, s, and rings to where they touch."""
        now = [motion(time) for motion in self.motions]
        lines = [each.centre_line for each in now]
        for wire, line in zip(self.wires, lines, strict=True):
            wire.place(line)
        self.ring.set_data(*touch_places(lines, self._diameter).T)
        retraction = math.degrees(float(now[-1].retraction))
        return phase_at(
            self._phases, time
        ).caption, f"retraction of bristle {len(self.wires)} {signed(retraction, 1, 6)}°"


def _phases(row: NeighbourRow) -> tuple[Phase, ...]:
    """Return what happens from when on, in order."""
    found = [Phase(-math.inf, "turning with the hub"), *(Phase(each, "wires touch each other") for each in row.touches)]
    for number, run in enumerate(row.bristles, 1):
        name, contact = f"bristle {number}", run.first_contact("workpart")
        strike = math.inf if contact is None else contact.time
        if (met := run.event_time("bar touch", before=strike)) is not None:
            found.append(Phase(met, f"{name} meets the bar"))
        if (thrown := run.event_time("bar release", last=True, before=strike)) is not None:
            found.append(Phase(thrown, f"the belt throws {name}"))
        if contact is not None:
            rate = contact.rates_before[0] - run.hub_speed
            found.append(Phase(strike, f"{name} strikes at {signed(rate, 0)} rad/s relative to the hub"))
    return tuple(sorted(found, key=lambda phase: (phase.start, phase.caption)))


class InertiaFilm(Film):
    """A film of both tools; its time is zero at its end, where the bar-cued bristle strikes and the other one is radial."""

    size = (960, 480)

    def __init__(self, driven: InertiaDriven, *, width: int = 960, height: int = 480, duration: float = 8.0) -> None:
        contact, radial = driven.pass_with_bar.first_contact("workpart"), driven.radial
        if contact is None or radial is None:
            raise ValueError(
                "film of both tools: the bristle must strike with the bar, and come back to radial without"
            )
        self.cued, self.thrown = Interpolation(driven.pass_with_bar), Interpolation(radial.trajectory)
        self.ends, speed = (contact.time, radial.time), driven.tool.hub.speed
        touch = self.cued(contact.time).centre_line[0]
        root = self.thrown(radial.time).centre_line[0]
        # Without gravity the pulley may be entered anywhere: where the bristle is radial at the other one's strike.
        turn = math.atan2(touch[1], touch[0]) - math.atan2(root[1], root[0])
        self._turn = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
        entered = self._turn @ self.thrown(0.0).centre_line[0]
        self._belt = speed * np.array([-entered[1], entered[0]])
        super().__init__(slow_motion(-contact.time, 0.0, duration), width, height, (BLUE, VERMILION))
        with styled():
            course = self.cued.course(contact.time)
            view = close_up(course.centre_line, driven.tool, 0.5 * width / (height * (1.0 - HEADER)), margin=0.04)
            self.wires = []
            for number, color in enumerate((BLUE, VERMILION)):
                axes = self.figure.add_axes((0.5 * number, 0.0, 0.5, 1.0 - HEADER))
                tool = dataclasses.replace(driven.tool, bar=None) if number else driven.tool
                draw_film_tool(axes, tool, view, 0.75 * self.letters)
                self.wires.append(WireDrawing(axes, tool, color=color, details=True))
        self.wires[1].ring.set_visible(False)  # on the straight belt, roots are not on the hub
        self.moving = [artist for wire in self.wires for artist in wire.artists]

    def move(self, time: float) -> tuple[str, ...]:
        """Move both wires to an instant, s; the one without a bar translates on its belt until it enters the pulley."""
        cued, thrown = self.cued(max(time + self.ends[0], 0.0), "before"), time + self.ends[1]
        self.wires[0].place(cued.centre_line)
        self.wires[1].place(self._without_bar(thrown))
        on_belt = thrown < 0.0
        speed = float(np.hypot(*self._belt)) if on_belt else float(self.thrown(thrown).tip_speed)
        place = "still on the straight belt" if on_belt else "round the pulley"
        bar, without = f"bar-cued tip {cued.tip_speed:5.1f} m/s", f"thrown by inertia {speed:5.1f} m/s"
        return f"with the bar, and without it, {place}", bar, without

    def _without_bar(self, time: float) -> Array:
        line = self.thrown(max(time, 0.0)).centre_line @ self._turn.T
        return np.asarray(line + min(time, 0.0) * self._belt)
