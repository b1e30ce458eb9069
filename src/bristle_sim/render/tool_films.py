"""Films of the tool to scale, in slow motion: one bristle, or a row of bristles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.readable import MILLIMETRES
from bristle_sim.render.drawing import draw_wires, touch_places
from bristle_sim.render.film import HEADER, Film, TimeWarp, slow_motion
from bristle_sim.render.story import Phase, phase_at, phases, story_end
from bristle_sim.render.style import BLACK, SERIES, SKY, signed, styled
from bristle_sim.trajectory import Interpolation, Trajectory

if TYPE_CHECKING:
    from bristle_sim.studies.neighbours import NeighbourRow

CAPTION_SHOWN = 0.5  # time in the film for which the caption of the strike is shown, s
ROW_SLOWER = 10.0
ROW_AFTER = 0.15
"""In the film of a row: the slow-down at touches and strikes, divided by that at other times; and
the time shown after the last bristle's strike, divided by the time shown before this strike."""


class ToolFilm(Film):
    """Film of a tool with one or several wires.

    A single wire is shown with the path of its tip and the radial line through its root. Rings mark
    the points at which several wires touch each other.
    """

    @styled()
    def __init__(
        self,
        tool: Tool,
        runs: Sequence[Trajectory],
        warp: TimeWarp,
        story: Sequence[Phase],
        size: tuple[int, int],
    ) -> None:
        """Draw the parts that do not move.

        Args:
            tool: tool with the hub, bar and workpart to draw.
            runs: motions of the wires. The read-outs are those of the last wire.
            warp: map between the time of the run and the time in the film.
            story: phases of the run with their captions.
            size: width and height of the picture, px.
        """
        colors = (SERIES * 2)[: len(runs)]
        self.single = len(runs) == 1
        super().__init__(warp, *size, (BLACK if self.single else colors[-1], BLACK))
        self.tool = tool
        self.story = tuple(story)
        self._motions = [Interpolation(run, run.contacts) for run in runs]
        courses = [motion.course(float(warp.physical[-1])) for motion in self._motions]
        self._past = courses[0]
        axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0 - HEADER))
        shown = [each.centre_line[each.time >= warp.physical[0]] for each in courses]
        margin = 0.04 if self.single else 0.08
        self.wires = draw_wires(
            axes, tool, np.concatenate(shown), colors, margin=margin, radial=self.single
        )
        (self.trail,) = axes.plot([], [], color=SKY, linewidth=1.6, zorder=3)
        (self.rings,) = axes.plot([], [], "o", markersize=26, markerfacecolor="none", color=BLACK)
        artists = [each for wire in self.wires for each in wire.artists]
        self.moving = [self.trail, *artists, self.rings]

    def move(self, time: float) -> tuple[str, ...]:
        """Move wires, path and rings to a time in the run, s."""
        now = [motion(time) for motion in self._motions]
        caption = phase_at(self.story, time).caption
        lines = [each.centre_line for each in now]
        for drawing, line in zip(self.wires, lines, strict=True):
            drawing.place(line)
        self.rings.set_data(*touch_places(lines, self.tool.bristle.wire_diameter).T)
        retraction = signed(math.degrees(float(now[-1].retraction)), 1, 6)
        if not self.single:
            return caption, f"retraction of bristle {len(now)} {retraction}°"
        past = self._past.tip[: np.searchsorted(self._past.time, time, side="right")]
        self.trail.set_data(*(MILLIMETRES * np.vstack([past, now[0].tip])).T)
        tip = f"tip {now[0].tip_speed:5.1f} m/s {now[0].normal_force:5.1f} N"
        return caption, f"retraction {retraction}°", tip


def pass_film(
    run: Trajectory, tool: Tool, *, width: int = 640, height: int = 480, duration: float = 8.0, slower: float = 4.0,
    until: float | None = None,
) -> ToolFilm:  # fmt: skip
    """Return a film of a pass.

    Args:
        run: motion of the bristle.
        tool: tool with the hub, bar and workpart to draw.
        width, height: size of the picture, px.
        duration: duration of the film, s.
        slower: slow-down at the strike, divided by the slow-down far from it.
        until: last time of the run shown, s; by default shortly after the tip has left the
            workpart.
    """
    end = story_end(run) if until is None else until
    strike = run.event_time("strike")
    focus = () if strike is None else (strike,)
    warp = slow_motion(
        float(run.time[0]), min(end, float(run.time[-1])), duration, focus, slower=slower
    )
    shown = 0.0
    if strike is not None:
        shown = float(warp.physical_time(warp.film_time(strike) + CAPTION_SHOWN)) - strike
    return ToolFilm(tool, [run], warp, phases(run, shown), (width, height))


def row_film(
    row: NeighbourRow, *, width: int = 640, height: int = 480, duration: float = 12.0
) -> ToolFilm:
    """Return a film of a row of bristles that is slowest where wires touch or strike.

    The film lasts from the first bristle's touch of the bar until shortly after the strike of the
    last bristle.

    Args:
        row: the row of bristles.
        width, height: size of the picture, px.
        duration: duration of the film, s.
    """
    strikes = [run.event_time("strike") for run in row.bristles]
    last = strikes[-1]
    end = float(row.bristles[-1].time[-1])
    begin = min(row.bristles[0].event_time("bar touch") or 0.0, 0.8 * end)
    until = end if last is None else min(end, last + ROW_AFTER * (last - begin))
    instants = [*row.touches, *(each for each in strikes if each is not None)]
    focus = [each for each in instants if begin <= each <= until]
    warp = slow_motion(begin, until, duration, focus, slower=ROW_SLOWER, width=0.012)
    return ToolFilm(row.tool, row.bristles, warp, _story(row), (width, height))


def _story(row: NeighbourRow) -> list[Phase]:
    found = [Phase(-math.inf, "turning with the hub")]
    found += [Phase(each, "wires touch each other") for each in row.touches]
    for number, run in enumerate(row.bristles, 1):
        name = f"bristle {number}"
        contact = run.first_contact("workpart")
        strike = math.inf if contact is None else contact.time
        if contact is not None:
            rate = signed(contact.rates_before[0] - run.hub_speed, 0)
            found.append(Phase(strike, f"{name} strikes at {rate} rad/s relative to the hub"))
        for event, last, caption in (
            ("bar touch", False, f"{name} meets the bar"),
            ("bar release", True, f"the belt throws {name}"),
        ):
            if (time := run.event_time(event, last=last, before=strike)) is not None:
                found.append(Phase(time, caption))
    return sorted(found)
