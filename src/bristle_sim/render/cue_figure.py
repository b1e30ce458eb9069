"""Draw the released bristle and the quasi-static formula, and the bar that each reading of the belt stiffness needs."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.parameters import PRINTED_BELT_STIFFNESS
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION
from bristle_sim.render.drawing import View, WireDrawing, draw_bar, draw_tool, name_parts
from bristle_sim.render.panels import add_panel, note
from bristle_sim.render.style import MILLIMETRES, MILLISECONDS, axes_at, blank_figure, signed, styled
from bristle_sim.studies.cue_places import BarPlace, FullPass, Release
from bristle_sim.studies.cue_timing import OWN, CueTiming
from bristle_sim.trajectory.sampled_motion import SampledMotion

NEARBY = math.radians(25.0)
"""The plan shows bars within this of the tool's own, rad; the others are in the table alone."""

READINGS = {
    OWN: ("{stiffness:.4g} N·m/rad", SKY),
    "per_radian": (f"{PRINTED_BELT_STIFFNESS:g} N·m per radian", ORANGE),
    "per_degree": (f"{PRINTED_BELT_STIFFNESS:g} N·m per degree", GREEN),
    "from_254_hz": ("another tool, 254 Hz", PURPLE),
}
"""Name and colour of each reading of the belt stiffness."""


@styled()
def cue_figure(timing: CueTiming) -> Figure:
    """Draw retraction and relative speed over time with their cue times, and the bars' places to scale (mm).

    Args:
        timing: a release from rest, up to the highest relative speed, with the places that were computed from it.

    Raises:
        ValueError: if the trajectory lasts no time.
    """
    figure = blank_figure(16.0, 12.6)
    retraction = add_panel(figure, (1.5, 7.1, 5.8, 4.3), "released from rest: retraction")
    below = "up to the cue time, at which it is highest"
    speed = add_panel(figure, (1.5, 1.2, 5.8, 4.4), "released from rest: relative speed", below, sharex=retraction)
    _draw_motion(retraction, speed, timing)
    plan = add_panel(figure, (8.6, 5.2, 7.2, 6.2), "where the bar must stand", "to scale, with this tool's wire")
    shown = _draw_plan(plan, timing)
    _draw_table(axes_at(figure, 7.9, 0.3, 7.9, 3.7), timing, shown)
    return figure


def _draw_motion(retraction: Axes, speed: Axes, timing: CueTiming) -> None:
    """Draw the simulated release and the formula's, each up to its own cue time, which is marked and named."""
    course = SampledMotion(timing.trajectory).course()
    lines = [("simulated", BLUE, "-", Release(course.time, course.retraction, course.relative_speed))]
    if timing.formula is not None:
        lines.append(("quasi-static formula", VERMILION, "--", timing.formula))
    latest = max(float(line.time[-1]) for *_, line in lines)
    for name, color, style, line in lines:
        time, cued = line.time * MILLISECONDS, float(line.time[-1]) * MILLISECONDS
        look: dict[str, Any] = {"color": color, "linestyle": style, "label": name}
        retraction.plot(time, np.degrees(line.retraction), gid=f"retraction, {name}", **look)
        speed.plot(time, line.relative_speed, gid=f"relative speed, {name}", **look)
        for axes in (retraction, speed):
            axes.axvline(cued, color=color, linewidth=0.8, linestyle=":", gid=f"cue, {name}")
        highest = float(line.relative_speed[-1])
        speed.plot([cued], [highest], "o", color=color, markersize=3.5, gid=f"highest, {name}")
        # The earlier cue is named on its left, the later on its right.
        side, ha = (4.0, "left") if line.time[-1] == latest else (-4.0, "right")
        words = f"cue time\n{cued:.4g} ms,\n{highest:.1f} rad/s"
        note(speed, words, (cued, 0.0), (side, 4.0), color=color, ha=ha, va="bottom")
    retraction.set_xlim(0.0, 1.38 * latest * MILLISECONDS)
    retraction.legend(loc="lower left", bbox_to_anchor=(-0.04, 0.98), ncols=2, columnspacing=1.2)
    retraction.axhline(0.0, color=GREY, linewidth=0.6)
    retraction.set_ylabel("retraction (°)")
    retraction.tick_params(labelbottom=False)
    speed.set(xlabel="time since release (ms)", ylabel="relative speed (rad/s)")
    speed.set_ylim(bottom=0.0)


def _draw_plan(axes: Axes, timing: CueTiming) -> set[str]:
    """Draw the tool and the bars it needs, with the wire as released and fastest; return which stiffnesses' bars are shown."""
    tool, given, radius = replace(timing.tool, bar=None), BarPlace.of(timing.bar), timing.bar.radius
    own = timing.places[timing.own].simulated or given
    bars: dict[str, dict[str, BarPlace]] = {}
    for name, each in timing.places.items():
        sides = {side: found for side in ("simulated", "formula") if (found := getattr(each, side)) is not None}
        if sides and all(abs(place.direction - own.direction) < NEARBY for place in sides.values()):
            bars[name] = sides
    wires = [line for line in (timing.released, timing.fastest) if line is not None]
    corners = radius * np.array([[-1.0, -1.0], [1.0, 1.0]])
    surface = np.array([[0.4 * tool.hub.radius, 0.0], [0.0, -1.06 * tool.workpart_depth]])
    centres = [_centre(given), *(_centre(place) for sides in bars.values() for place in sides.values())]
    points = [*(np.array(each) + corners for each in centres), *wires, surface]
    view = View.around([MILLIMETRES * each for each in points], 7.2 / 6.2, 0.06)
    axes.grid(visible=False)
    draw_tool(axes, tool, view)
    draw_bar(axes, *_centre(given), radius, gid="bar as given")
    for name, sides in bars.items():
        for side, place in sides.items():
            look: dict[str, Any] = {"edgecolor": READINGS[name][1], "linewidth": 1.3, "zorder": 5, "fill": False}
            style = "-" if side == "simulated" else ":"
            draw_bar(axes, *_centre(place), radius, gid=f"{side} {name}", linestyle=style, **look)
    view.apply(axes)
    name_parts(axes, tool, 7.0)
    names = (("released", GREY, (0.0, 4.0), "right", "bottom"), ("fastest", BLACK, (6.0, -2.0), "left", "top"))
    for line, (name, color, offset, ha, va) in zip(wires, names, strict=False):
        drawing = WireDrawing(axes, tool, color=color)
        drawing.place(line)
        drawing.wire.set_gid(f"wire {name}")
        x, y = (0.65 * line[0] + 0.35 * line[-1]) * MILLIMETRES  # the bars are about the tips
        note(axes, name, (float(x), float(y)), offset, color=color, ha=ha, va=va)
    axes.set_xlabel("x (mm)", labelpad=1.0)
    axes.set_ylabel("y (mm)", labelpad=1.0)
    return set(bars)


def _centre(place: BarPlace) -> tuple[float, float]:
    return -place.horizontal, -place.vertical  # on the incoming side, m


def _draw_table(axes: Axes, timing: CueTiming, shown: set[str]) -> None:
    """List directions of the bars from the workpart's normal, in the colours of the drawing, and a whole pass's strike."""
    last = len(timing.places) + 1
    axes.set_axis_off()
    axes.set(xlim=(0.0, 1.0), ylim=(-max(last, 5) - 1.6, 1.0))
    # The narrow columns' headings have two lines each.
    heads = ("bar for a belt\nstiffness of", "simulated\n—", "formula\n····", "full pass with —:\nretraction at strike")
    rows = [(*heads, GREY)]
    for name, each in timing.places.items():
        words, color = READINGS[name]
        title = words.format(stiffness=each.stiffness) + ("" if name in shown else " *")
        rows.append((title, _direction(each.simulated), _direction(each.formula), _strike(each.passed), color))
    own = timing.places[timing.own]
    rows.append(("bar as given (grey)", _direction(BarPlace.of(timing.bar)), "", _strike(own.passed_as_given), BLACK))
    for row, (*cells, color) in enumerate(rows):
        for x, words in zip((0.0, 0.52, 0.68, 1.0), cells, strict=True):
            look: dict[str, Any] = {"ha": "right" if x else "left", "va": "center", "fontsize": 7.0}
            axes.text(x, -row - (0.4 if row else 0.0), words, color=color, **look)
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
