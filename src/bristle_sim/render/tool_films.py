"""Films of the tool to scale, in slow motion: one bristle, or a row of bristles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.colours import BLACK, BLUE, SERIES, SKY, VERMILION
from bristle_sim.render.drawing import View, WireDrawing, close_up, draw_film_tool, touch_places
from bristle_sim.render.film import HEADER, Film, TimeWarp, slow_motion
from bristle_sim.render.story import Phase, phase_at, phases, story_end
from bristle_sim.render.style import MILLIMETRES, signed, styled
from bristle_sim.trajectory import Interpolation, Motion, Trajectory

if TYPE_CHECKING:
    from bristle_sim.studies.neighbours import NeighbourRow

CAPTION_SHOWN = 0.5  # time in the film for which the caption of the strike is shown, s
ROW_SLOWER = 10.0
ROW_AFTER = 0.15
"""Film of a row: slow-down at touches and strikes over the slow-down elsewhere; and time shown after
the last bristle's strike, as a fraction of the time before."""


class ToolFilm(Film):
    """Film of a tool with one or several wires; rings mark where wires touch each other."""

    @styled()
    def __init__(
        self,
        tool: Tool,
        wires: Sequence[tuple[Callable[[float], Motion], str]],
        view: View,
        warp: TimeWarp,
        story: Sequence[Phase],
        readings: Callable[[Sequence[Motion]], Sequence[str]],
        size: tuple[int, int],
        *,
        trail: Motion | None = None,
        strike: Array | None = None,
    ) -> None:
        """Draw the parts that do not move.

        Args:
            tool: tool with hub, bar and workpart as drawn.
            wires: for each wire the function that returns its motion at a time (s), and its colour.
            view: rectangle that is shown, mm.
            warp: map between the time of the run and the time in the film.
            story: phases of the run with their captions.
            readings: function that returns the read-outs from the motions of all wires. With
                several wires, the read-outs have the colour of the last wire.
            size: width and height of the picture, px.
            trail: motion of a single wire, whose tip leaves a trail; the wire's radial line and
                other roots are shown too.
            strike: position of the star that marks the strike, m.
        """
        super().__init__(warp, *size, (wires[-1][1] if len(wires) > 1 else BLACK, BLACK))
        self.tool = tool
        self.story = tuple(story)
        self._readings = readings
        self._motions = [motion for motion, _ in wires]
        self._past = trail
        self._place = strike
        axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0 - HEADER))
        draw_film_tool(axes, tool, view, 0.75 * self.letters)
        (self.trail,) = axes.plot([], [], color=SKY, linewidth=1.6, zorder=3)
        self.wires = [
            WireDrawing(axes, tool, color=color, details=trail is not None) for _, color in wires
        ]
        (self.star,) = axes.plot(
            [], [], "*", color=VERMILION, markersize=22, markeredgecolor="white", zorder=3
        )
        (self.rings,) = axes.plot(
            [], [], "o", markersize=26, markerfacecolor="none", color=BLACK, zorder=6
        )
        artists = [each for wire in self.wires for each in wire.artists]
        self.moving = [self.trail, *artists, self.star, self.rings]

    def move(self, time: float) -> tuple[str, ...]:
        """Move wires, trail, star and rings to a time in the run, s."""
        now = [motion(time) for motion in self._motions]
        caption = phase_at(self.story, time).caption
        lines = [each.centre_line for each in now]
        for drawing, line in zip(self.wires, lines, strict=True):
            drawing.place(line)
        if self._past is not None:
            past = self._past.tip[: np.searchsorted(self._past.time, time, side="right")]
            self.trail.set_data(*(MILLIMETRES * np.vstack([past, now[0].tip])).T)
        if self._place is not None:
            self.star.set_data(*(MILLIMETRES * self._place[:, np.newaxis]))
            self.star.set_visible(caption == "strike")
        self.rings.set_data(*touch_places(lines, self.tool.bristle.wire_diameter).T)
        return caption, *self._readings(now)


def _view(tool: Tool, shown: Array, size: tuple[int, int], margin: float) -> View:
    return close_up(shown, tool, size[0] / (size[1] * (1.0 - HEADER)), margin)


def pass_film(
    run: Trajectory, tool: Tool, *, width: int = 640, height: int = 480, duration: float = 8.0, slower: float = 4.0,
    until: float | None = None,
) -> ToolFilm:  # fmt: skip
    """Return a film of a pass, by default until shortly after the tip has left the workpart.

    Args:
        run, tool: the pass.
        width, height: size of the picture, px.
        duration: duration of the film, s.
        slower: slow-down at the strike over the slow-down elsewhere.
        until: last time of the run shown, s.
    """
    motion = Interpolation(run)
    contact = run.first_contact("workpart")
    course = motion.course(story_end(run) if until is None else until)
    focus = () if (strike := run.event_time("strike")) is None else (strike,)
    warp = slow_motion(float(run.time[0]), float(course.time[-1]), duration, focus, slower=slower)
    shown = 0.0
    if strike is not None:
        shown = float(warp.physical_time(warp.film_time(strike) + CAPTION_SHOWN)) - strike
    place = None if strike is None else motion(strike).tip
    in_time = contact is not None and contact.history is not None

    def readings(now: Sequence[Motion]) -> tuple[str, str]:
        speed = float(now[0].tip_speed)
        read = f"tip speed {speed:5.1f} m/s"
        if in_time:
            read = f"tip {speed:5.1f} m/s {now[0].normal_force:5.1f} N"
        return _retraction(now[0]), read

    size = (width, height)
    view = _view(tool, course.centre_line, size, 0.04)
    story = phases(run, shown)
    return ToolFilm(
        tool, [(motion, BLUE)], view, warp, story, readings, size, trail=course, strike=place
    )


def _retraction(motion: Motion, whose: str = "") -> str:
    return f"retraction {whose}{signed(math.degrees(float(motion.retraction)), 1, 6)}°"


def row_film(
    row: NeighbourRow, *, width: int = 640, height: int = 480, duration: float = 12.0
) -> ToolFilm:
    """Return a film of a row of bristles, in slow motion at touches and strikes.

    It lasts from the first bristle's touch of the bar to shortly after the last bristle's strike.
    ``width`` and ``height`` are in px, ``duration`` is in s.
    """
    motions = [Interpolation(run) for run in row.bristles]
    colors = (SERIES * 2)[: len(row.bristles)]
    last = row.bristles[-1]
    strikes = [run.event_time("strike") for run in row.bristles]
    end = float(last.time[-1])
    begin = min(row.bristles[0].event_time("bar touch") or 0.0, 0.8 * end)
    until = (
        end if strikes[-1] is None else min(end, strikes[-1] + ROW_AFTER * (strikes[-1] - begin))
    )
    focus = [
        each for each in (*row.touches, *strikes) if each is not None and begin <= each <= until
    ]
    warp = slow_motion(begin, until, duration, focus, slower=ROW_SLOWER, width=0.012)
    shown = np.concatenate(
        [motion(np.linspace(begin, until, 200)).centre_line for motion in motions]
    )

    def readings(now: Sequence[Motion]) -> tuple[str]:
        return (_retraction(now[-1], f"of bristle {len(now)} "),)

    wires = list(zip(motions, colors, strict=True))
    size = (width, height)
    return ToolFilm(
        row.tool, wires, _view(row.tool, shown, size, 0.08), warp, _story(row), readings, size
    )


def _story(row: NeighbourRow) -> tuple[Phase, ...]:
    found = [
        Phase(-math.inf, "turning with the hub"),
        *(Phase(each, "wires touch each other") for each in row.touches),
    ]
    for number, run in enumerate(row.bristles, 1):
        name = f"bristle {number}"
        contact = run.first_contact("workpart")
        strike = math.inf if contact is None else contact.time
        captions = {
            f"{name} meets the bar": run.event_time("bar touch", before=strike),
            f"the belt throws {name}": run.event_time("bar release", last=True, before=strike),
        }
        if contact is not None:
            rate = signed(contact.rates_before[0] - run.hub_speed, 0)
            captions[f"{name} strikes at {rate} rad/s relative to the hub"] = strike
        found += [Phase(time, caption) for caption, time in captions.items() if time is not None]
    return tuple(sorted(found))
