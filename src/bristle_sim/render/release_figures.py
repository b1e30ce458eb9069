"""Figures of bristles that swing freely on the belt, released from rest or driven by their inertia."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.readable import MILLIMETRES, MILLISECONDS
from bristle_sim.render.drawing import WireDrawing, draw_circle, draw_tool, show_points
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREY,
    VERMILION,
    Look,
    blank_figure,
    draw_zero,
    styled,
)
from bristle_sim.studies.cue_timing import CueTiming
from bristle_sim.studies.inertia_driven import InertiaDriven
from bristle_sim.theory.cueing import released_motion

POINTS = 400  # number of points of the formula's curve


@styled()
def cue_figure(timing: CueTiming) -> Figure:
    """Draw the motion of a bristle released from rest, and the bar positions that follow from it.

    Panels over time show the retraction and the angular velocity relative to the hub, up to the
    highest angular velocity. The bar positions are drawn to scale (mm).

    Raises:
        ValueError: if the trajectory has no duration.
    """
    figure = blank_figure(16.0, 9.2)
    panels = figure.subplot_mosaic(
        [["retraction", "plan"], ["speed", "plan"]], width_ratios=(1.0, 1.2)
    )
    retraction, plan, speed = panels.values()
    retraction.set(title="released from rest", ylabel="retraction (°)")
    speed.sharex(retraction)
    speed.set(xlabel="time since release (ms)", ylabel="relative speed (rad/s)")
    _draw_motion(retraction, speed, timing)
    plan.set(title="required bar positions; grey: given", xlabel="x (mm)", ylabel="y (mm)")
    _draw_plan(plan, timing)
    figure.legend(*speed.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _draw_motion(retraction: Axes, speed: Axes, timing: CueTiming) -> None:
    course = timing.trajectory.course()
    lines = {"simulated": (BLUE, "-", course.time, course.retraction, course.relative_rate)}
    if timing.formula is not None:
        instants = np.linspace(0.0, timing.formula.cue_time, POINTS)
        motion = released_motion(timing.tool, timing.retraction, instants)
        lines["quasi-static formula"] = (VERMILION, "--", instants, *motion)
    for name, (color, style, instants, angle, rate) in lines.items():
        time = instants * MILLISECONDS
        label = f"{name}: {rate[-1]:.1f} rad/s after {time[-1]:.4g} ms"
        for axes, values in ((retraction, np.degrees(angle)), (speed, rate)):
            axes.plot(time, values, style, color=color, label=label)
    draw_zero(retraction)
    speed.set(xlim=(0.0, None), ylim=(0.0, None))


def _draw_plan(axes: Axes, timing: CueTiming) -> None:
    tool = replace(timing.tool, bar=None)
    given = timing.bar
    bars: dict[str, tuple[tuple[float, float], Look]] = {"bar as given": (given.centre, {})}
    for name, cue, color, style in (
        ("bar, simulated", timing.simulated, BLUE, "-"),
        ("bar, formula", timing.formula, VERMILION, "--"),
    ):
        if cue is not None:
            centre = (-cue.bar_horizontal, -cue.bar_vertical)  # on the incoming side, m
            look = {"edgecolor": color, "linewidth": 1.3, "linestyle": style, "fill": False}
            bars[name] = (centre, look | {"zorder": 5})
    rims = [
        np.add(centre, rim) for centre, _ in bars.values() for rim in (-given.radius, given.radius)
    ]
    surface = np.array([[0.4 * tool.hub.radius, 0.0], [0.0, -1.06 * tool.workpart_depth]])
    show_points(axes, [MILLIMETRES * each for each in (*rims, *timing.wires, surface)], 0.06)
    axes.grid(visible=False)
    draw_tool(axes, tool)
    for name, (centre, look) in bars.items():
        draw_circle(axes, centre, given.radius, gid=name, **look)
    for line, name, color in zip(timing.wires, ("released", "fastest"), (GREY, BLACK), strict=True):
        drawing = WireDrawing(axes, tool, color=color)
        drawing.place(line)
        drawing.wire.set_gid(f"wire {name}")
        along = math.atan2(*(line[-1] - line[0])[::-1])
        upright = (along + 0.5 * math.pi) % math.pi - 0.5 * math.pi
        axes.annotate(
            name,
            MILLIMETRES * 0.5 * (line[0] + line[-1]),
            (-3.0 * math.sin(upright), 3.0 * math.cos(upright)),  # beside the wire
            textcoords="offset points",
            color=color,
            rotation=math.degrees(upright),
            rotation_mode="anchor",
            ha="center",
            va="bottom",
        )


@styled()
def inertia_figure(driven: InertiaDriven) -> Figure:
    """Draw the motion of a bristle that a bar holds back, and of one thrown by its own inertia.

    One panel shows the retraction (degrees) over the hub's angle of rotation. The other shows the
    angular velocity relative to the hub (rad/s) over the retraction.
    """
    figure = blank_figure(16.0, 8.0)
    turn, phase = figure.subplots(1, 2)
    turn.set(xlabel="angle of rotation of the hub (°)", ylabel="retraction (°)")
    phase.set(xlabel="retraction (°)", ylabel="angular velocity relative to the hub (rad/s)")
    contact = driven.pass_with_bar.first_contact("workpart")
    end = "no strike"
    if contact is not None:
        end = f"{math.hypot(*contact.velocity_before):.1f} m/s at the strike"
    runs = [(driven.pass_with_bar, BLUE, f"bar-cued: {end}")]
    if driven.radial is not None:
        end = f"{driven.radial.tip_speed[-1]:.1f} m/s when radial"
        runs.append((driven.radial, VERMILION, f"thrown by its inertia: {end}"))
    look: Look = {"marker": "o", "markevery": [-1], "markersize": 4.0}
    for run, color, name in runs:
        course = run.course()
        turned, retraction = np.degrees([course.hub_angle - run.hub_angle[0], course.retraction])
        turn.plot(turned, retraction, color=color, label=name, **look)
        phase.plot(retraction, course.relative_rate, color=color, **look)
    for axes in (turn, phase):
        draw_zero(axes)
    figure.legend(handles=turn.lines[: len(runs)], loc="outside lower center", ncols=2)
    return figure
