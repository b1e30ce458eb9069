"""Draw the released bristle and the quasi-static formula, and the bar that each reading of the belt stiffness needs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.parameters import PRINTED_BELT_STIFFNESS
from bristle_sim.render.drawing import View
from bristle_sim.render.panels import note, panel_title
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    axes_at,
    blank_figure,
    signed,
    styled,
)
from bristle_sim.render.tool_drawing import MILLIMETRES, WireDrawing, draw_bar, draw_hub, draw_workpart, name_parts
from bristle_sim.studies.cue_places import BarPlace, FullPass, ReadingPlaces, Release
from bristle_sim.studies.cue_timing import OWN, CueTiming
from bristle_sim.trajectory.sampled_motion import SampledMotion

MILLISECONDS = 1e3

PLAN = (7.2, 6.2)
"""Width and height of the plan view, cm."""

NEARBY = math.radians(25.0)
"""The plan shows bars within this of the tool's own, rad; the others are in the table alone."""

NAMES = {
    OWN: "{stiffness:.4g} N·m/rad",
    "per_radian": f"{PRINTED_BELT_STIFFNESS:g} N·m per radian",
    "per_degree": f"{PRINTED_BELT_STIFFNESS:g} N·m per degree",
    "from_254_hz": "another tool, 254 Hz",
}
COLOURS = {OWN: SKY, "per_radian": ORANGE, "per_degree": GREEN, "from_254_hz": PURPLE}

COLUMNS = (0.52, 0.68, 1.0)
"""Right edges of the table's numbers, as fractions of its width."""


@styled()
def cue_figure(timing: CueTiming) -> Figure:
    """Draw retraction and relative speed over time with their cue times, and the bars' places to scale (mm).

    Args:
        timing: a release from rest, up to the highest relative speed, with the places that were computed from it.

    Raises:
        ValueError: if the trajectory lasts no time.
    """
    figure = blank_figure(16.0, 12.6)
    retraction = axes_at(figure, 1.5, 7.1, 5.8, 4.3)
    speed = axes_at(figure, 1.5, 1.2, 5.8, 4.4, sharex=retraction)
    _draw_motion(retraction, speed, timing)
    plan = axes_at(figure, 8.6, 5.2, *PLAN)
    shown = _draw_plan(plan, timing)
    _draw_table(axes_at(figure, 7.9, 0.3, 7.9, 3.7), timing, shown)
    return figure


def _draw_motion(retraction: Axes, speed: Axes, timing: CueTiming) -> None:
    """Draw the simulated release and the formula's, each up to its own cue time."""
    course = SampledMotion(timing.trajectory).course()
    lines = [("simulated", BLUE, Release(course.time, course.retraction, course.relative_speed))]
    if timing.formula is not None:
        lines.append(("quasi-static formula", VERMILION, timing.formula))
    for name, color, line in lines:
        look: dict[str, Any] = {"color": color, "linestyle": "-" if color == BLUE else "--", "label": name}
        time = line.time * MILLISECONDS
        retraction.plot(time, np.degrees(line.retraction), gid=f"retraction, {name}", **look)
        speed.plot(time, line.relative_speed, gid=f"relative speed, {name}", **look)
    retraction.set_xlim(0.0, 1.38 * max(float(line.time[-1]) for _, _, line in lines) * MILLISECONDS)
    _mark_cues(retraction, speed, lines)
    panel_title(retraction, "a", "released from rest: retraction")
    retraction.legend(loc="lower left", bbox_to_anchor=(-0.04, 0.98), ncols=2, columnspacing=1.2)
    retraction.axhline(0.0, color=GREY, linewidth=0.6)
    retraction.set_ylabel("retraction (°)")
    retraction.tick_params(labelbottom=False)
    panel_title(speed, "b", "released from rest: relative speed", "up to the cue time, at which it is highest")
    speed.set_ylabel("relative speed (rad/s)")
    speed.set_xlabel("time since release (ms)")
    speed.set_ylim(bottom=0.0)


def _mark_cues(retraction: Axes, speed: Axes, lines: Sequence[tuple[str, str, Release]]) -> None:
    """Mark where each line ends, at its highest speed; the earlier cue is named on its left, the later on its right."""
    latest = max(float(line.time[-1]) for _, _, line in lines)
    for name, color, line in lines:
        cued, highest = float(line.time[-1]) * MILLISECONDS, float(line.relative_speed[-1])
        for axes in (retraction, speed):
            axes.axvline(cued, color=color, linewidth=0.8, linestyle=":", gid=f"cue, {name}")
        speed.plot([cued], [highest], "o", color=color, markersize=3.5, gid=f"highest, {name}")
        words = f"cue time\n{cued:.4g} ms,\n{highest:.1f} rad/s"
        side = 1.0 if line.time[-1] == latest else -1.0
        look: dict[str, Any] = {"color": color, "ha": "left" if side > 0.0 else "right", "va": "bottom"}
        note(speed, words, (cued, 0.0), (4.0 * side, 4.0), **look)


def _draw_plan(axes: Axes, timing: CueTiming) -> set[str]:
    """Draw hub, workpart and bars to scale, with the wire as released and at its highest speed.

    Returns the names of the stiffnesses whose bars the view shows.
    """
    tool, given = timing.tool, BarPlace.of(timing.bar)
    near = {name for name, each in timing.places.items() if _near(each, timing)}
    bars = [given, *(place for name in near for place in _places(timing.places[name]))]
    wires = [line for line in (timing.released, timing.fastest) if line is not None]
    view = _view(timing, bars, wires)
    axes.grid(visible=False)
    draw_hub(axes, tool)
    draw_workpart(axes, tool.workpart_depth, view)
    draw_bar(axes, *_centre(given), timing.bar.radius, gid="bar as given")
    for name in near:
        for side, style in (("simulated", "-"), ("formula", ":")):
            place = getattr(timing.places[name], side)
            if place is not None:
                look: dict[str, Any] = {"edgecolor": COLOURS[name], "linewidth": 1.3, "linestyle": style, "zorder": 5}
                draw_bar(axes, *_centre(place), timing.bar.radius, fill=False, gid=f"{side} {name}", **look)
    view.apply(axes)
    name_parts(axes, replace(tool, bar=None), 7.0)
    for line, color, name in zip(wires, (GREY, BLACK), ("released", "fastest"), strict=False):
        drawing = WireDrawing(axes, tool, color=color)
        drawing.place(line)
        drawing.wire.set_gid(f"wire {name}")
        x, y = 0.5 * (line[0] + line[-1]) * MILLIMETRES
        sides = {"ha": "right", "va": "bottom"} if name == "released" else {"ha": "left", "va": "top"}
        offset = (0.0, 4.0) if name == "released" else (6.0, -2.0)
        note(axes, name, (float(x), float(y)), offset, color=color, **sides)
    axes.set_xlabel("x (mm)", labelpad=1.0)
    axes.set_ylabel("y (mm)", labelpad=1.0)
    panel_title(axes, "c", "where the bar must stand", "to scale, with this tool's wire")
    return near


def _near(places: ReadingPlaces, timing: CueTiming) -> bool:
    """Return whether a stiffness's bars stand near enough to the tool's own to be drawn."""
    own = timing.places[timing.own].simulated or BarPlace.of(timing.bar)
    directions = [place.direction for place in _places(places)]
    return bool(directions) and all(abs(each - own.direction) < NEARBY for each in directions)


def _places(places: ReadingPlaces) -> list[BarPlace]:
    return [place for place in (places.simulated, places.formula) if place is not None]


def _centre(place: BarPlace) -> tuple[float, float]:
    """Return the bar's centre on the incoming side, m."""
    return -place.horizontal, -place.vertical


def _view(timing: CueTiming, bars: Sequence[BarPlace], wires: Sequence[Array]) -> View:
    """Return the smallest view of bars, wires, the workpart's surface and the arrow in the hub, mm."""
    corners = timing.bar.radius * np.array([[-1.0, -1.0], [1.0, 1.0]])
    surface = np.array([[0.4 * timing.tool.hub.radius, 0.0], [0.0, -1.06 * timing.tool.workpart_depth]])
    points = [*(np.array(_centre(place)) + corners for place in bars), *wires, surface]
    return View.around([MILLIMETRES * each for each in points], PLAN[0] / PLAN[1], 0.06)


def _draw_table(axes: Axes, timing: CueTiming, shown: set[str]) -> None:
    """List directions of the bars from the workpart's normal, in the colours of the drawing, and a whole pass's strike."""
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    last = len(timing.places) + 1
    axes.set_ylim(-max(last, 5) - 1.6, 1.0)
    # The narrow columns' headings have two lines each.
    heads = ("bar for a belt\nstiffness of", "simulated\n—", "formula\n····", "full pass with —:\nretraction at strike")
    rows = [(*heads, GREY)]
    for name, each in timing.places.items():
        title = NAMES[name].format(stiffness=each.stiffness) + ("" if name in shown else " *")
        directions = (_direction(each.simulated), _direction(each.formula))
        rows.append((title, *directions, _strike(each.passed), COLOURS[name]))
    own = timing.places[timing.own]
    rows.append(("bar as given (grey)", _direction(BarPlace.of(timing.bar)), "", _strike(own.passed_as_given), BLACK))
    for row, (name, *numbers, color) in enumerate(rows):
        below = row + (0.4 if row else 0.0)
        look: dict[str, Any] = {"color": color, "fontsize": 7.0, "va": "center"}
        axes.text(0.0, -below, name, ha="left", **look)
        for x, words in zip(COLUMNS, numbers, strict=True):
            axes.text(x, -below, words, ha="right", **look)
    foot = "directions from the workpart's normal"
    if not shown >= set(timing.places):
        foot += "; * bars not in the drawing"
    axes.text(0.0, -last - 1.3, foot, color=GREY, fontsize=6.5, va="center")


def _direction(place: BarPlace | None) -> str:
    return "none" if place is None else f"{math.degrees(place.direction):.2f}°"


def _strike(passed: FullPass | None) -> str:
    if passed is None or passed.retraction is None:
        return "no strike"
    return f"{signed(math.degrees(passed.retraction), 2)}°"
