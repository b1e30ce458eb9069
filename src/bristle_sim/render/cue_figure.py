"""The released bristle beside the quasi-static formula, and the bar that each reading of the belt stiffness needs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from bristle_sim.parameters import PRINTED_BELT_STIFFNESS, Bar, Tool
from bristle_sim.render.motion import Motion, wire_ends
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    VERMILION,
    axes_at,
    blank_figure,
    styled,
)
from bristle_sim.render.sweep_panels import note, panel_title
from bristle_sim.render.tool_drawing import MILLIMETRES, View, WireDrawing, draw_bar, draw_hub, draw_workpart
from bristle_sim.studies.cue_places import BarPlace, ReadingPlaces, bar_places, formula_motion
from bristle_sim.theory.cueing import cue, impact_angle, tip_lag
from bristle_sim.trajectory import Trajectory

__all__ = ["cue_figure"]

Array = NDArray[np.float64]

MILLISECONDS = 1e3
POINTS = 400

NAMES = {
    "per_radian": f"{PRINTED_BELT_STIFFNESS:g} N·m per radian",
    "per_degree": f"{PRINTED_BELT_STIFFNESS:g} N·m per degree",
    "from_254_hz": "another tool, 254 Hz",
}
COLOURS = {"per_radian": ORANGE, "per_degree": GREEN, "from_254_hz": PURPLE}


@dataclass(frozen=True, slots=True)
class _Line:
    """One side of the comparison over time, up to its highest rate; s, rad, rad/s."""

    name: str
    color: str
    time: Array
    angle: Array
    rate: Array


@styled()
def cue_figure(trajectory: Trajectory, tool: Tool, retraction: float) -> Figure:
    """Relative angle and rate over time with their cue times, and the bar's place in plan view, to scale (mm).

    Args:
        trajectory: a release from rest, up to the highest relative speed.
        tool, retraction: what was released, and from where, rad.

    Raises:
        ValueError: if the tool has no bar or no workpart, or the trajectory lasts no time.
    """
    places = bar_places(tool, retraction)
    figure = blank_figure(16.0, 12.3)
    angle = axes_at(figure, 1.6, 6.7, 6.8, 4.5)
    rate = axes_at(figure, 1.6, 1.2, 6.8, 4.9, sharex=angle)
    _draw_motion(angle, rate, trajectory, tool, retraction)
    plan = axes_at(figure, 9.5, 4.7, 6.3, 6.5)
    _draw_plan(plan, tool, retraction, places)
    _draw_table(axes_at(figure, 8.9, 0.7, 6.9, 2.9), tool, places)
    return figure


def _draw_motion(angle: Axes, rate: Axes, trajectory: Trajectory, tool: Tool, retraction: float) -> None:
    """Simulated and by formula, each up to its own cue time."""
    course = Motion(trajectory).course()
    lines = [_Line("simulated", BLUE, course.time, course.relative_angle, course.relative_rate)]
    if tool.belt.stiffness > 0.0:
        time = np.linspace(0.0, cue(tool, retraction).cue_time, POINTS)
        lines.append(_Line("quasi-static formula", VERMILION, time, *formula_motion(tool, retraction, time)))
    for line in lines:
        look: dict[str, Any] = {
            "color": line.color,
            "linestyle": "-" if line.color == BLUE else "--",
            "label": line.name,
        }
        angle.plot(line.time * MILLISECONDS, np.degrees(line.angle), gid=f"angle, {line.name}", **look)
        rate.plot(line.time * MILLISECONDS, line.rate, gid=f"rate, {line.name}", **look)
    last = max(float(line.time[-1]) for line in lines) * MILLISECONDS
    angle.set_xlim(0.0, 1.32 * last)
    _mark_cues(angle, rate, lines)
    _label_motion(angle, rate)


def _label_motion(angle: Axes, rate: Axes) -> None:
    panel_title(angle, "a", "released from rest at the retraction angle")
    angle.legend(loc="lower left", bbox_to_anchor=(-0.04, 0.98), ncols=2, columnspacing=1.2)
    angle.axhline(0.0, color=GREY, linewidth=0.6)
    angle.set_ylabel("relative angle (°)")
    angle.tick_params(labelbottom=False)
    rate.set_ylabel("relative rate (rad/s)")
    rate.set_xlabel("time since release (ms)")
    rate.set_ylim(bottom=0.0)


def _mark_cues(angle: Axes, rate: Axes, lines: Sequence[_Line]) -> None:
    """Where each line ends, at its highest rate; the earlier cue is named on its left, the later on its right."""
    latest = max(lines, key=lambda line: float(line.time[-1]))
    for line in lines:
        cued, speed = float(line.time[-1]), float(line.rate[-1])
        for axes in (angle, rate):
            axes.axvline(cued * MILLISECONDS, color=line.color, linewidth=0.8, linestyle=":", gid=f"cue, {line.name}")
        rate.plot([cued * MILLISECONDS], [speed], "o", color=line.color, markersize=3.5, gid=f"highest, {line.name}")
        words = f"cue time\n{cued * MILLISECONDS:.4g} ms,\n{speed:.1f} rad/s"
        side = 1.0 if line is latest else -1.0
        place, offset = (cued * MILLISECONDS, 0.0), (4.0 * side, 4.0)
        note(rate, words, place, offset, color=line.color, ha="left" if side > 0.0 else "right", va="bottom")


def _draw_plan(axes: Axes, tool: Tool, retraction: float, places: Sequence[ReadingPlaces]) -> None:
    """Hub, workpart and bar to scale, the wire as released and as it should strike, and the bars that are needed."""
    assert tool.bar is not None
    reach = (math.hypot(*tool.bar.centre) + 1.8 * tool.bar.radius) * MILLIMETRES
    view = View(-reach, reach, -reach, reach)
    axes.grid(visible=False)
    draw_hub(axes, tool)
    draw_workpart(axes, tool, view)
    draw_bar(axes, tool)
    _draw_wires(axes, tool, retraction)
    for place in places:
        color = COLOURS[place.reading]
        _draw_needed(axes, tool, place.simulated, color, "-", f"simulated {place.reading}")
        _draw_needed(axes, tool, place.formula, color, ":", f"formula {place.reading}")
    view.apply(axes)
    axes.set_xlabel("x (mm)", labelpad=1.0)
    axes.set_ylabel("y (mm)", labelpad=1.0)
    panel_title(axes, "b", "where the bar must stand", "to scale; directions from the workpart's normal")


def _draw_wires(axes: Axes, tool: Tool, retraction: float) -> None:
    """The wire as it slips off the tool's bar, and radial at the strike."""
    assert tool.bar is not None
    assert tool.workpart is not None
    geometry = (tool.hub.radius, tool.bristle.length)
    root = float(tip_lag(*geometry, retraction)) - math.atan2(tool.bar.horizontal, tool.bar.vertical)
    struck = -float(impact_angle(*geometry, tool.workpart.penetration))
    poses = (("released", root, root - retraction, GREY, (0.0, 4.0)), ("strike", struck, struck, BLACK, (6.0, -3.0)))
    for name, hub_angle, angle, color, offset in poses:
        WireDrawing(axes, tool, color=color).place(hub_angle, angle)
        x, y = np.mean(wire_ends(tool, hub_angle, angle), axis=0) * MILLIMETRES
        note(axes, name, (float(x), float(y)), offset, color=color, ha="center" if color == GREY else "left")


def _draw_needed(axes: Axes, tool: Tool, place: BarPlace | None, color: str, style: str, name: str) -> None:
    """The outline of a bar at a place."""
    if place is None or tool.bar is None:
        return
    centre, radius = (-place.horizontal * MILLIMETRES, -place.vertical * MILLIMETRES), tool.bar.radius * MILLIMETRES
    axes.add_patch(
        Circle(centre, radius, fill=False, edgecolor=color, linewidth=1.2, linestyle=style, gid=name, zorder=5)
    )


def _draw_table(axes: Axes, tool: Tool, places: Sequence[ReadingPlaces]) -> None:
    """Directions of the needed bars from the workpart's normal, in the colours of the drawing."""
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(-4.4, 0.4)
    rows = [("belt stiffness", "simulated —", "formula ····", GREY)]
    for each in places:
        rows.append((NAMES[each.reading], _direction(each.simulated), _direction(each.formula), COLOURS[each.reading]))
    for row, (name, simulated, formula, color) in enumerate(rows):
        for x, words in ((0.0, name), (0.74, simulated), (1.0, formula)):
            axes.text(x, -row, words, color=color, fontsize=7.0, va="center", ha="right" if x else "left")
    assert tool.bar is not None
    own = math.degrees(math.atan2(tool.bar.horizontal, tool.bar.vertical))
    name = "the printed bar (grey)" if tool.bar == Bar() else "the tool's bar (grey)"
    axes.text(0.0, -4.0, name, fontsize=7.0, va="center")
    axes.text(0.74, -4.0, f"{own:.2f}°", fontsize=7.0, va="center", ha="right")


def _direction(place: BarPlace | None) -> str:
    return "none" if place is None else f"{math.degrees(place.direction):.2f}°"
