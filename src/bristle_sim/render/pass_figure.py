"""Figure of a whole pass: the tool to scale with the tip's path, and curves over time.

The curves are the retraction, the angular velocity relative to the hub, and the energy.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.readable import MILLIMETRES, MILLISECONDS
from bristle_sim.render.drawing import WireDrawing, draw_tool, show_wires
from bristle_sim.render.story import CARRIED, key_events, story_end
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    VERMILION,
    Look,
    blank_figure,
    draw_zero,
    signed,
    styled,
)
from bristle_sim.trajectory import Event, Motion, Trajectory

_WIRES = {"bar touch": ORANGE, "bar release": VERMILION, "strike": BLACK, "start": BLUE}
"""Events at which the wire is drawn, with the wire's colour. The marks of other events are grey."""

Rows = dict[str, dict[str, tuple[Array, Look]]]
"""Values and plot options of the curves over time.

The keys are the label of the panel and the name of the curve."""


class _Mark(NamedTuple):
    """An event of the pass that is marked in every panel, with its number and colour."""

    number: int
    event: Event
    color: str

    @property
    def look(self) -> Look:
        """Style with which the event's number is drawn as a marker."""
        return {"marker": f"${self.number}$", "color": self.color, "linestyle": "none", "zorder": 6}


@styled()
def pass_figure(trajectory: Trajectory, tool: Tool, *, until: float | None = None) -> Figure:
    """Draw a pass: the tool with the tip's path to scale (mm), and curves over time (ms).

    The curves are the retraction, the angular velocity relative to the hub and the energy. The
    normal force of contacts also has a panel, unless it is zero throughout.

    Args:
        trajectory: motion of the pass.
        tool: the tool.
        until: last time shown, s; by default shortly after the tip has left the workpart.

    Raises:
        ValueError: if the trajectory has fewer than two samples.
    """
    course = trajectory.course(story_end(trajectory) if until is None else until)
    marks = _marks(trajectory, float(course.time[-1]))
    rows = _rows(course, tool)
    figure = blank_figure(16.0, 7.5 + 2.8 * len(rows))
    places: list[Any] = [["tool", "events"], *([name, name] for name in rows)]
    ratios = (2.5, *(1.0 for _ in rows))
    drawing, events, *panels = figure.subplot_mosaic(places, height_ratios=ratios).values()
    paths = _draw_tool(drawing, course, tool, trajectory, marks)
    for axes, (label, lines) in zip(panels, rows.items(), strict=True):
        axes.sharex(panels[-1])
        axes.set_ylabel(label)
        _draw_lines(axes, course.time, lines, marks)
        axes.label_outer()
    panels[-1].set_xlim(course.time[0] * MILLISECONDS, course.time[-1] * MILLISECONDS)
    panels[-1].set_xlabel("time (ms)")
    figure.align_ylabels(panels)
    _list_events(events, panels[0], paths, marks, trajectory)
    return figure


@styled()
def pair_figure(names: Sequence[str], runs: Sequence[Trajectory]) -> Figure:
    """Draw two passes over time (ms) for comparison.

    The panels show the retraction, the angular velocity relative to the hub and the tip speed.
    Dashed lines mark the strikes. ``names`` are the labels of the two passes.
    """
    figure = blank_figure(16.0, 11.6)
    end = max(story_end(run) for run in runs)
    panels = figure.subplots(3, sharex=True)
    for axes, label in zip(
        panels, ("retraction (°)", "relative speed (rad/s)", "tip speed (m/s)"), strict=True
    ):
        axes.set_ylabel(label)
    for name, run, color in zip(names, runs, (BLUE, VERMILION), strict=True):
        course = run.course(min(end, float(run.time[-1])))
        quantities = (np.degrees(course.retraction), course.relative_rate, course.tip_speed)
        for axes, values in zip(panels, quantities, strict=True):
            axes.plot(MILLISECONDS * course.time, values, color=color, label=name)
            if (strike := run.event_time("strike")) is not None:
                axes.axvline(MILLISECONDS * strike, color=color, linewidth=0.8, linestyle="--")
    figure.legend(
        handles=panels[0].get_legend_handles_labels()[0], loc="outside upper center", ncols=2
    )
    panels[-1].set_xlabel("time (ms); dashed: strike")
    return figure


def _rows(course: Motion, tool: Tool) -> Rows:
    bends = tool.bristle.links > 1
    whose = "first link's\n" if bends else ""
    potential = "belt" + " and joints" * bends + " and gravity" * (tool.gravity != 0.0)
    rows: Rows = {
        f"{whose}retraction (°)": {"retraction": (np.degrees(course.retraction), {})},
        f"{whose or 'relative'}{' relative' * bends}\nspeed (rad/s)": {
            "relative speed": (course.relative_rate, {})
        },
        "energy (mJ)": {
            "sum": (1e3 * course.total_energy, {"color": GREY, "linestyle": "--"}),
            "bristle, kinetic": (1e3 * course.kinetic_energy, {}),
            potential: (1e3 * course.potential_energy, {"color": GREEN}),
        },
    }
    if course.normal_force.any():
        rows["normal force (N)"] = {"normal force": (course.normal_force, {"color": VERMILION})}
    return rows


def _marks(trajectory: Trajectory, until: float) -> list[_Mark]:
    """Return the events up to the time ``until`` (s) that are marked, numbered from 1.

    If the bristle does not start in the radial direction, the start is also marked, as number 0.
    """
    events = key_events(trajectory, until)
    first = 1
    if abs(trajectory.relative_angle[0]) > CARRIED:
        events = (Event("start", float(trajectory.time[0])), *events)
        first = 0
    wires = dict(_WIRES)
    if trajectory.event_time("strike") is None:
        wires["highest relative speed"] = BLACK
    # If several events have one name, the wire is drawn at the first of them.
    return [
        _Mark(number, event, wires.pop(event.name, GREY))
        for number, event in enumerate(events, first)
    ]


def _draw_lines(
    axes: Axes, time: Array, lines: dict[str, tuple[Array, Look]], marks: Sequence[_Mark]
) -> None:
    for name, (values, look) in lines.items():
        axes.plot(time * MILLISECONDS, values, label=name, gid=name, **{"color": BLUE, **look})
    for mark in marks:
        instant = mark.event.time * MILLISECONDS
        axes.axvline(instant, color=mark.color, linewidth=0.7, linestyle=":", zorder=1)
    if len(lines) > 1:
        axes.margins(y=0.3)  # room for the legend
        axes.legend(loc="upper left", ncols=3)
    else:
        draw_zero(axes)


def _draw_tool(
    axes: Axes, course: Motion, tool: Tool, run: Trajectory, marks: Sequence[_Mark]
) -> list[Artist]:
    """Draw the tool, the tip's path, and the wire at some of the marked events.

    Args:
        axes: axes of the drawing.
        course: the part of the motion that the figure shows.
        tool: the tool.
        run: the whole motion.
        marks: the marked events.

    Returns:
        The lines of the path and a dot of a root, for the legend.
    """
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    axes.grid(visible=False)
    show_wires(axes, tool, course.centre_line)
    draw_tool(axes, tool)
    strike = run.event_time("strike")
    paths = {"tip path": (slice(None), BLUE)}
    if strike is not None:
        # The sample after an impact begins the second line, so that the two lines meet at the strike.
        after = int(np.searchsorted(course.time, strike, side="right"))
        paths = {
            "tip path until the strike": (slice(after), BLUE),
            "tip path after the strike": (slice(after - 1, None), PURPLE),
        }
    shown: list[Artist] = []
    for name, (part, color) in paths.items():
        points = MILLIMETRES * course.tip[part].T
        shown += axes.plot(*points, gid=name, label=name, color=color, linewidth=1.0)
    for mark in marks:
        if mark.color != GREY:
            line = run.at(mark.event.time).centre_line
            drawing = WireDrawing(axes, tool, color=mark.color, alpha=0.75)
            drawing.wire.set_gid(f"wire {mark.number}")
            drawing.place(line)
            # The number stands inside the hub, alternately nearer to the rim and farther from it,
            # since roots may be close together.
            inward = 0.87 - 0.15 * (mark.number % 2)
            axes.plot(*(inward * MILLIMETRES * line[0]), **mark.look)
    return [*shown, drawing.root] if marks else shown


def _list_events(
    axes: Axes, panel: Axes, paths: list[Artist], marks: Sequence[_Mark], trajectory: Trajectory
) -> None:
    """Write the numbers of the marked events above a panel, and list the events.

    The list also states the velocities at the strike or, without a strike, the reason why the run
    ended.

    Args:
        axes: empty axes that receive the list.
        panel: panel over time above which the numbers stand.
        paths: further entries of the list: the lines of the tip's path.
        marks: the marked events.
        trajectory: motion of the pass.
    """
    largest = float(np.degrees(trajectory.retraction.max()))
    above = panel.get_xaxis_transform()
    handles = paths
    for mark in marks:
        time = mark.event.time
        retraction = float(np.degrees(trajectory.at(time).retraction))
        name = mark.event.name
        # The event is the largest retraction before the strike. Afterwards the wire may lag more.
        if name == "largest retraction" and retraction < largest - 0.01:
            name = "largest retraction so far"
        words = f"{name}: {time * MILLISECONDS:.3f} ms, {signed(retraction, 2)}°"
        place = (time * MILLISECONDS, 1.06 + 0.12 * (mark.number % 2))
        handles += panel.plot(*place, **mark.look, label=words, transform=above, clip_on=False)
    axes.set_axis_off()
    contact = trajectory.first_contact("workpart")
    words = f"no strike; the run ended:\n{trajectory.stop_reason}"
    if contact is not None:
        whose = "" if len(contact.rates_before) == 1 else "first link at "
        words = (
            f"strike: {whose}{signed(contact.rates_before[0] - trajectory.hub_speed, 1)} rad/s relative to the hub,\n"
            f"{contact.point or 'tip'} arrives at {math.hypot(*contact.velocity_before):.2f} m/s\n"
            f"and leaves at {math.hypot(*contact.velocity_after):.2f} m/s ({contact.outcome_in_words})"
        )
    title = f"{words}\n\nevents: time, retraction"
    axes.legend(handles=handles, loc="upper left", title=title, alignment="left")
