"""Figure of a whole pass: the tool to scale with the tip's path, and curves over time.

The curves are retraction, relative rate and energy.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Transform
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION
from bristle_sim.render.drawing import WireDrawing, draw_tool, show_wires, toward
from bristle_sim.render.story import CARRIED, key_events, story_end
from bristle_sim.render.style import (
    MILLIMETRES,
    MILLISECONDS,
    Look,
    axes_at,
    blank_figure,
    draw_zero,
    name_above,
    signed,
    styled,
    write_key,
)
from bristle_sim.trajectory import Event, Motion, Trajectory

DRAWING = (8.1, 6.6)
PANEL = (13.2, 2.9)
ROW = 3.2
"""Lengths in cm: width and height of the tool's drawing, width and height of a panel over time, and
distance from one panel to the next."""

BADGE_GAP = 0.035  # least distance between the numbers above a panel, as a fraction of its width
_WIRES = {"bar touch": ORANGE, "bar release": VERMILION, "strike": BLACK, "start": BLUE}
"""Events at which the tool's drawing shows the wire, with their colour. Other events are grey."""

_LOOKS: dict[str, Look] = {
    "wire, in the colour of its instant": {"color": GREY, "linewidth": 3.0},
    "root in the belt": {"color": GREEN, "linestyle": "none", "marker": "o", "markersize": 4.5},
}

Rows = dict[str, dict[str, tuple[Array, Look]]]
"""The curves of panels over time, by the label of the panel and the name of the curve: values and
plot options."""


class _Mark(NamedTuple):
    """An event of the pass that every panel marks, with its number and colour."""

    number: int
    event: Event
    color: str


@styled()
def pass_figure(trajectory: Trajectory, tool: Tool, *, until: float | None = None) -> Figure:
    """Draw a pass: tool and tip path to scale (mm), and curves over time (ms).

    The curves are retraction, relative rate and energy. ``until`` is the last time shown, s; by
    default shortly after the tip has left the workpart.

    Raises:
        ValueError: if the trajectory has fewer than two samples.
    """
    course = trajectory.course(story_end(trajectory) if until is None else until)
    marks = _marks(trajectory, float(course.time[-1]))
    rows = _rows(course, tool)
    height = 10.4 + len(rows) * ROW
    figure = blank_figure(16.0, height)
    base = height - 7.0
    paths = _draw_tool(axes_at(figure, 1.4, base, *DRAWING), course, tool, trajectory, marks)
    write_key(figure, paths | _LOOKS, loc="center", bbox_to_anchor=(0.5, (base - 1.6) / height))
    _draw_table(axes_at(figure, 9.65, base, 6.2, 6.6), marks, trajectory)
    panels = _panels(figure, list(rows))
    for axes, lines in zip(panels, rows.values(), strict=True):
        _draw_lines(axes, course.time, lines, marks)
    panels[0].set_xlim(course.time[0] * MILLISECONDS, course.time[-1] * MILLISECONDS)
    _number_instants(panels[0], marks)
    return figure


@styled()
def pair_figure(names: Sequence[str], runs: Sequence[Trajectory]) -> Figure:
    """Draw retraction, relative rate and tip speed of two passes over time (ms).

    A dashed line marks each strike. ``names`` are the labels of the two passes.
    """
    figure = blank_figure(16.0, 11.6)
    end = max(story_end(run) for run in runs)
    labels = ["retraction (°)", "relative\nspeed (rad/s)", "tip speed\n(m/s)"]
    panels = _panels(figure, labels)
    for name, run, color in zip(names, runs, (BLUE, VERMILION), strict=True):
        course = run.course(min(end, float(run.time[-1])))
        quantities = (np.degrees(course.retraction), course.relative_rate, course.tip_speed)
        for axes, values in zip(panels, quantities, strict=True):
            axes.plot(MILLISECONDS * course.time, values, color=color, label=name)
            if (strike := run.event_time("strike")) is not None:
                axes.axvline(MILLISECONDS * strike, color=color, linewidth=0.8, dashes=(4, 2))
    name_above(panels[0])
    panels[-1].set_xlabel("time (ms); dashed: strike")
    return figure


def _panels(figure: Figure, labels: Sequence[str]) -> list[Axes]:
    """Add panels over time at the foot of a figure, one above the other, from top to bottom."""
    panels: list[Axes] = []
    for number, label in enumerate(reversed(labels)):
        above = panels[0] if panels else None
        panels.insert(0, axes_at(figure, 2.2, 1.1 + number * ROW, *PANEL, sharex=above))
        panels[0].set_ylabel(label, linespacing=1.4)
        panels[0].yaxis.set_label_coords(-1.2 / PANEL[0], 0.5)  # in line, whatever the numbers
        panels[0].tick_params(labelbottom=number == 0)
    panels[-1].set_xlabel("time (ms)")
    return panels


def _rows(course: Motion, tool: Tool) -> Rows:
    bends = tool.bristle.links > 1
    potential = "belt" + " and joints" * bends + " and gravity" * (tool.gravity != 0.0)
    total: Look = {"color": GREY, "linewidth": 1.0, "dashes": (4, 2)}
    rows: Rows = {
        "retraction of\nthe first link (°)" if bends else "retraction (°)": {
            "retraction": (np.degrees(course.retraction), {})
        },
        "its relative\nspeed (rad/s)" if bends else "relative\nspeed (rad/s)": {
            "relative speed": (course.relative_rate, {})
        },
        "energy (mJ)": {
            "sum": (1e3 * course.total_energy, total),
            "bristle, kinetic": (1e3 * course.kinetic_energy, {}),
            potential: (1e3 * course.potential_energy, {"color": GREEN}),
        },
    }
    if course.normal_force.any():
        rows["normal\nforce (N)"] = {"normal force": (course.normal_force, {"color": VERMILION})}
    return rows


def _marks(trajectory: Trajectory, until: float) -> list[_Mark]:
    """Return the events to mark, numbered from 1.

    If the bristle starts away from the radial direction, the start is marked too, with the number
    0.
    """
    events = key_events(trajectory, until)
    first = 1
    if abs(trajectory.relative_angle[0]) > CARRIED:
        events = (Event("start", float(trajectory.time[0])), *events)
        first = 0
    wires = dict(_WIRES)
    if trajectory.event_time("strike") is None:
        wires["highest relative speed"] = BLACK
    # The first of several events of one name shows the wire.
    return [
        _Mark(number, event, wires.pop(event.name, GREY))
        for number, event in enumerate(events, first)
    ]


def _spread(positions: Iterable[float], gap: float) -> list[float]:
    """Move ascending positions up, where necessary, until neighbours are ``gap`` apart."""
    return list(accumulate(positions, lambda last, place: max(place, last + gap)))


def _draw_lines(
    axes: Axes, time: Array, lines: dict[str, tuple[Array, Look]], marks: Sequence[_Mark]
) -> None:
    for name, (values, look) in lines.items():
        axes.plot(time * MILLISECONDS, values, label=name, gid=name, **{"color": BLUE, **look})
    for mark in marks:
        instant = mark.event.time * MILLISECONDS
        axes.axvline(instant, color=mark.color, linewidth=0.7, dashes=(2, 2), zorder=1)
    if len(lines) > 1:
        axes.legend(loc="upper left", ncols=3, borderaxespad=0.2, columnspacing=1.2)
        bottom, top = axes.get_ylim()
        axes.set_ylim(bottom, top + 0.25 * (top - bottom))  # room for the legend
    else:
        draw_zero(axes)


def _number_instants(axes: Axes, marks: Sequence[_Mark]) -> None:
    first, last = axes.get_xlim()
    times = [mark.event.time * MILLISECONDS for mark in marks]
    places = _spread(times, BADGE_GAP * (last - first))
    above = axes.get_xaxis_transform()
    for mark, time, place in zip(marks, times, places, strict=True):
        look: Look = {"color": mark.color, "linewidth": 0.6, "transform": above, "clip_on": False}
        axes.plot([time, place], [1.0, 1.06], **look)
        _badge(axes, (place, 1.12), mark, above)


def _draw_tool(
    axes: Axes, course: Motion, tool: Tool, run: Trajectory, marks: Sequence[_Mark]
) -> dict[str, Look]:
    """Draw the tool, the tip's path, and the wire at some events.

    Return the styles of the parts of the path by name, for the legend.
    """
    show_wires(axes, tool, course.centre_line)
    axes.grid(visible=False)
    draw_tool(axes, tool)
    tip = course.tip * MILLIMETRES
    strike = run.event_time("strike")
    paths = {"tip path": (tip, BLUE)}
    if strike is not None:
        # The sample after an impact begins the second line, so that the two lines meet at the strike.
        after = int(np.searchsorted(course.time, strike, side="right"))
        paths = {
            "tip path until the strike": (tip[:after], BLUE),
            "tip path after the strike": (tip[after - 1 :], PURPLE),
        }
    looks: dict[str, Look] = {}
    for name, (points, color) in paths.items():
        looks[name] = {"color": color, "linewidth": 1.0}
        axes.plot(*points.T, gid=name, zorder=3, **looks[name])
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    axes.yaxis.set_label_coords(-1.05 / DRAWING[0], 0.5)
    drawn = [mark for mark in marks if mark.color != GREY]
    height = float(np.ptp(axes.get_ylim()))
    radius = max(tool.hub.radius * MILLIMETRES - 0.045 * height, 0.0)
    shown = run.at([mark.event.time for mark in drawn])
    angles = _spread(shown.hub_angle.tolist(), 0.065 * height / max(radius, 1e-9))
    for mark, line, place in zip(drawn, shown.centre_line, radius * toward(angles), strict=True):
        drawing = WireDrawing(axes, tool, color=mark.color, alpha=0.75)
        drawing.wire.set_gid(f"wire {mark.number}")
        drawing.place(line)
        _badge(axes, place, mark)
    return looks


def _badge(axes: Axes, place: ArrayLike, mark: _Mark, transform: Transform | None = None) -> None:
    x, y = np.asarray(place, dtype=float)
    edge = {"boxstyle": "circle,pad=0.18", "facecolor": "white", "edgecolor": mark.color}
    text = axes.text(x, y, str(mark.number), color=mark.color, fontsize=6.5, ha="center")
    text.set(va="center", bbox=edge | {"linewidth": 0.8}, zorder=6)
    text.set_transform(transform or axes.transData)


def _draw_table(axes: Axes, marks: Sequence[_Mark], trajectory: Trajectory) -> None:
    """Write the list of the marked events, and below them the velocities at the strike.

    Without a strike, write the reason instead.
    """
    axes.set_axis_off()
    axes.set(xlim=(0.0, 1.0), ylim=(-14.5, 1.0))
    columns = ((0.08, "left"), (0.75, "right"), (1.0, "right"))
    for (x, side), heading in zip(columns, ("event", "time\n(ms)", "retraction\n(°)"), strict=True):
        axes.text(x, 0.4, heading, ha=side, va="center", fontsize=7.0, color=GREY)
    largest = float(np.degrees(trajectory.retraction.max()))
    for row, mark in enumerate(marks, start=1):
        time = mark.event.time
        retraction = float(np.degrees(trajectory.at(time).retraction))
        name = mark.event.name
        # It is the largest up to the strike; after the strike the wire may swing farther.
        if name == "largest retraction" and retraction < largest - 0.01:
            name = "largest retraction so far"
        cells = (name, f"{time * MILLISECONDS:.3f}", signed(retraction, 2))
        _badge(axes, (0.03, 0.12 - row), mark)
        for (x, side), cell in zip(columns, cells, strict=True):
            axes.text(x, -row, cell, ha=side, fontsize=7.0)
    contact = trajectory.first_contact("workpart")
    words = f"no strike; the run ended:\n{trajectory.stop_reason}"
    if contact is not None:
        whose = "" if len(contact.rates_before) == 1 else "first link at "
        words = (
            f"strike: {whose}{signed(contact.rates_before[0] - trajectory.hub_speed, 1)} rad/s relative to the hub,\n"
            f"{contact.point or 'tip'} arrives at {math.hypot(*contact.velocity_before):.2f} m/s\n"
            f"and leaves at {math.hypot(*contact.velocity_after):.2f} m/s ({contact.outcome_in_words})"
        )
    axes.text(0.0, -len(marks) - 1.3, words, fontsize=7.0, va="top", linespacing=1.6)
