"""Film of the tool to scale, in slow motion: a whole pass, a row of bristles, or two tools side by side."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.colours import BLACK, BLUE, SERIES, SKY, VERMILION
from bristle_sim.render.drawing import WireDrawing, close_up, draw_film_tool, touch_places
from bristle_sim.render.film import HEADER, Film, TimeWarp, slow_motion
from bristle_sim.render.story import Phase, phase_at, phases, story_end
from bristle_sim.render.style import MILLIMETRES, signed, styled
from bristle_sim.trajectory import Interpolation, Motion, Trajectory

if TYPE_CHECKING:
    from bristle_sim.studies.inertia_driven import InertiaDriven
    from bristle_sim.studies.neighbours import NeighbourRow

CAPTION_SHOWN = 0.5  # film time for which the instant of the strike keeps its caption, s
ROW_SLOWER, ROW_AFTER = 10.0, 0.15
"""How much slower touches and strikes in a row are shown than the rest; how long a film of a row goes on after the last
bristle's strike, as a fraction of the time before."""


class Stage(NamedTuple):
    """A tool with its wires, in a drawing of its own.

    Attributes:
        tool: with hub, bar and workpart as drawn.
        wires: of each the motion at an instant of the film's clock, s, and its colour.
        shown: centre lines that the view must contain, m.
        details: whether the radial line and a ring of roots are drawn.
        trail: motion whose tip leaves a trail.
        strike: where a star marks the strike, m.
    """

    tool: Tool
    wires: Sequence[tuple[Callable[[float], Motion], str]]
    shown: Array
    details: bool = False
    trail: Motion | None = None
    strike: Array | None = None


class ToolFilm(Film):
    """Tools side by side with any number of wires and links, and rings where wires of one tool touch."""

    @styled()
    def __init__(
        self,
        stages: Sequence[Stage],
        warp: TimeWarp,
        story: Sequence[Phase],
        readings: Callable[[Sequence[Motion]], Sequence[str]],
        colours: Sequence[str],
        pixels: tuple[int, int],
        margin: float = 0.04,
    ) -> None:
        """``readings`` writes the read-outs, in these colours, from the motion of all wires in their order."""
        self.size = (960, 480) if len(stages) > 1 else (640, 480)
        super().__init__(warp, *pixels, colours)
        self.stages, self.story, self._readings = stages, tuple(story), readings
        self.wires: list[list[WireDrawing]] = []
        width, height = 1.0 / len(stages), 1.0 - HEADER
        lines = np.concatenate([np.reshape(each.shown, (-1, 2)) for each in stages])
        view = close_up(lines, stages[0].tool, width * pixels[0] / (height * pixels[1]), margin)
        for number, stage in enumerate(stages):
            axes = self.figure.add_axes((number * width, 0.0, width, height))
            draw_film_tool(axes, stage.tool, view, 0.75 * self.letters)
            (self.trail,) = axes.plot([], [], color=SKY, linewidth=1.6, zorder=3)
            wires = [WireDrawing(axes, stage.tool, color=each, details=stage.details) for _, each in stage.wires]
            (self.star,) = axes.plot([], [], "*", color=VERMILION, markersize=22, markeredgecolor="white", zorder=3)
            (self.rings,) = axes.plot([], [], "o", markersize=26, markerfacecolor="none", color=BLACK, zorder=6)
            self.wires.append(wires)
            self.moving += [self.trail, *(each for wire in wires for each in wire.artists), self.star, self.rings]

    def move(self, time: float) -> tuple[str, ...]:
        """Move wires, trails, stars and rings to an instant of the film's clock, s."""
        every, caption = [], phase_at(self.story, time).caption
        for stage, drawings in zip(self.stages, self.wires, strict=True):
            now = [motion(time) for motion, _ in stage.wires]
            for drawing, each in zip(drawings, now, strict=True):
                drawing.place(each.centre_line)
            if stage.trail is not None:
                past = stage.trail.tip[: np.searchsorted(stage.trail.time, time, side="right")]
                self.trail.set_data(*(MILLIMETRES * np.vstack([past, now[0].tip])).T)
            if stage.strike is not None:
                self.star.set_data(*(MILLIMETRES * stage.strike[:, np.newaxis]))
                self.star.set_visible(caption == "strike")
            lines = [each.centre_line for each in now]
            self.rings.set_data(*touch_places(lines, stage.tool.bristle.wire_diameter).T)
            every += now
        return caption, *self._readings(every)


def pass_film(
    run: Trajectory, tool: Tool, *, width: int = 640, height: int = 480, duration: float = 8.0, slower: float = 4.0,
    until: float | None = None,
) -> ToolFilm:  # fmt: skip
    """Return a film of a pass, by default until shortly after the tip has left the workpart.

    Args:
        run, tool: the pass.
        width, height: px.
        duration: of the film, s.
        slower: how much slower the strike is shown than the rest.
        until: the last instant shown, s.
    """
    motion, contact = Interpolation(run), run.first_contact("workpart")
    course = motion.course(story_end(run) if until is None else until)
    focus = () if (strike := run.event_time("strike")) is None else (strike,)
    warp = slow_motion(float(run.time[0]), float(course.time[-1]), duration, focus, slower=slower)
    shown = 0.0 if strike is None else float(warp.physical_time(warp.film_time(strike) + CAPTION_SHOWN)) - strike
    place = None if strike is None else motion(strike).tip
    stage = Stage(tool, [(motion, BLUE)], course.centre_line, details=True, trail=course, strike=place)
    in_time = contact is not None and contact.history is not None

    def readings(now: Sequence[Motion]) -> tuple[str, str]:
        speed = f"tip {now[0].tip_speed:5.1f} m/s"
        force = f"{speed} {now[0].normal_force:5.1f} N" if in_time else f"tip speed {now[0].tip_speed:5.1f} m/s"
        return _retraction(now[0]), force

    return ToolFilm([stage], warp, phases(run, shown), readings, (BLACK, BLACK), (width, height))


def _retraction(motion: Motion, whose: str = "") -> str:
    return f"retraction {whose}{signed(math.degrees(float(motion.retraction)), 1, 6)}°"


def row_film(row: NeighbourRow, *, width: int = 640, height: int = 480, duration: float = 12.0) -> ToolFilm:
    """Return a film of a row of bristles, from the first touch of the bar until after the last strike."""
    motions, colors = [Interpolation(run) for run in row.bristles], (SERIES * 2)[: len(row.bristles)]
    last, strikes = row.bristles[-1], [run.event_time("strike") for run in row.bristles]
    end = float(last.time[-1])
    begin = min(row.bristles[0].event_time("bar touch") or 0.0, 0.8 * end)
    until = end if strikes[-1] is None else min(end, strikes[-1] + ROW_AFTER * (strikes[-1] - begin))
    focus = [each for each in (*row.touches, *strikes) if each is not None and begin <= each <= until]
    warp = slow_motion(begin, until, duration, focus, slower=ROW_SLOWER, width=0.012)
    shown = np.concatenate([motion(np.linspace(begin, until, 200)).centre_line for motion in motions])

    def readings(now: Sequence[Motion]) -> tuple[str]:
        return (_retraction(now[-1], f"of bristle {len(now)} "),)

    stage = Stage(row.tool, list(zip(motions, colors, strict=True)), shown)
    return ToolFilm([stage], warp, _story(row), readings, colors[-1:], (width, height), margin=0.08)


def _story(row: NeighbourRow) -> tuple[Phase, ...]:
    found = [Phase(-math.inf, "turning with the hub"), *(Phase(each, "wires touch each other") for each in row.touches)]
    for number, run in enumerate(row.bristles, 1):
        name, contact = f"bristle {number}", run.first_contact("workpart")
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


def inertia_film(driven: InertiaDriven, *, width: int = 960, height: int = 480, duration: float = 8.0) -> ToolFilm:
    """Return a film of the tool with its bar beside the same tool without, each up to its strike or radial instant, time 0.

    Raises ValueError unless the bristle strikes with the bar, and becomes radial again without it.
    """
    contact, radial = driven.pass_with_bar.first_contact("workpart"), driven.radial
    if contact is None or radial is None:
        raise ValueError("film of both tools: the bristle must strike with the bar, and come back to radial without")
    cued, thrown = Interpolation(driven.pass_with_bar), Interpolation(radial.trajectory)
    # Without gravity the pulley may be entered anywhere: where the bristle is radial at the other one's strike.
    touch, root = cued(contact.time).centre_line[0], thrown(radial.time).centre_line[0]
    angle = math.atan2(touch[1], touch[0]) - math.atan2(root[1], root[0])
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    entered = thrown(0.0).centre_line[0] @ turn
    belt = driven.tool.hub.speed * np.array([-entered[1], entered[0]])

    def with_bar(time: float) -> Motion:
        return cued(min(max(time + contact.time, 0.0), contact.time), "before")

    def without(time: float) -> Motion:
        """Return the motion of the bristle without a bar; before it enters the pulley it moves straight with the belt."""
        now, early = thrown(min(max(time + radial.time, 0.0), radial.time)), min(time + radial.time, 0.0)
        velocity = now.centre_line_velocity @ turn if early == 0.0 else np.broadcast_to(belt, now.centre_line.shape)
        return dataclasses.replace(
            now, centre_line=now.centre_line @ turn + early * belt, centre_line_velocity=velocity
        )

    def readings(now: Sequence[Motion]) -> tuple[str, str]:
        return f"bar-cued tip {now[0].tip_speed:5.1f} m/s", f"thrown by inertia {now[1].tip_speed:5.1f} m/s"

    words = "with the bar, and without it, "
    story = (Phase(-math.inf, f"{words}still on the straight belt"), Phase(-radial.time, f"{words}round the pulley"))
    shown, bare = cued.course(contact.time).centre_line, dataclasses.replace(driven.tool, bar=None)
    stages = [Stage(driven.tool, [(with_bar, BLUE)], shown, details=True), Stage(bare, [(without, VERMILION)], shown)]
    warp = slow_motion(-contact.time, 0.0, duration)
    return ToolFilm(stages, warp, story, readings, (BLUE, VERMILION), (width, height))
