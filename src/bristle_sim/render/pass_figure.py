"""Draw the whole pass on one page: the tool to scale with the tip's path, and retraction, relative speed and energy over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Transform
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.story import CARRIED, key_events, story_end
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
    signed,
    styled,
)
from bristle_sim.render.tool_drawing import MILLIMETRES, WireDrawing, close_up, draw_tool, name_parts, toward
from bristle_sim.trajectory import Event, Trajectory
from bristle_sim.trajectory.sampled_motion import Course, SampledMotion

MILLISECONDS, MILLIJOULES = 1e3, 1e3

WIDTH, HEIGHT = 16.0, 20.0
"""Printed size, cm; the width is that of a page's text."""

DRAWING = (8.7, 6.6)
"""Width and height of the drawing of the tool, cm."""

PANEL = 13.4
"""Width of a panel over time, cm."""

LEGEND = 11.4
"""Height of the row that explains the drawing's colours, cm."""

BADGE_GAP = 0.035
"""Least distance between the numbers above a panel, as a fraction of its width."""

_GHOSTS = {"bar touch": ORANGE, "bar release": VERMILION, "strike": BLACK, "start": BLUE}


@dataclass(frozen=True, slots=True)
class _Mark:
    """A numbered instant, shown in every panel."""

    number: int
    event: Event
    color: str

    @property
    def has_ghost(self) -> bool:
        """Whether the drawing of the tool shows the wire at this instant."""
        return self.color != GREY


@styled()
def pass_figure(trajectory: Trajectory, tool: Tool, *, until: float | None = None) -> Figure:
    """Draw a pass: tool and tip path to scale (mm), and retraction, relative speed and energy over time (ms).

    ``until`` is the last instant shown, s; by default shortly after the tip has left the workpart.

    Raises:
        ValueError: if the trajectory has fewer than two instants.
    """
    motion = SampledMotion(trajectory)
    course = motion.course(story_end(trajectory) if until is None else until)
    end = float(course.time[-1])
    marks = _marks(trajectory, end)
    figure = blank_figure(WIDTH, HEIGHT)
    path, table = axes_at(figure, 1.4, 13.0, *DRAWING), axes_at(figure, 10.25, 13.0, 5.6, 6.6)
    _draw_path(path, course, tool, trajectory.event_time("strike"))
    _draw_ghosts(path, tool, motion, marks)
    _draw_table(table, motion, marks)
    _describe_strike(table, len(marks) + 1.6, trajectory)
    _explain_colours(figure, path)
    retraction = axes_at(figure, 2.0, 7.5, PANEL, 2.9)
    speed = axes_at(figure, 2.0, 4.3, PANEL, 2.9, sharex=retraction)
    energy = axes_at(figure, 2.0, 1.1, PANEL, 2.9, sharex=retraction)
    _draw_line(retraction, course.time, np.degrees(course.retraction), "retraction", "retraction (°)")
    _draw_line(speed, course.time, course.relative_speed, "relative speed", "relative\nspeed (rad/s)")
    _draw_energy(energy, course, trajectory, motion, "belt" if tool.gravity == 0.0 else "belt and gravity")
    path.yaxis.set_label_coords(-1.05 / DRAWING[0], 0.5)
    for axes in (retraction, speed, energy):
        axes.yaxis.set_label_coords(-1.05 / PANEL, 0.5)  # in line, however wide the numbers are
        for mark in marks:
            axes.axvline(mark.event.time * MILLISECONDS, color=mark.color, linewidth=0.7, dashes=(2, 2), zorder=1)
    retraction.set_xlim(course.time[0] * MILLISECONDS, end * MILLISECONDS)
    _number_instants(retraction, marks)
    return figure


def _marks(trajectory: Trajectory, until: float) -> list[_Mark]:
    """Number the key events from 1; a start away from the radial direction is number 0."""
    events = key_events(trajectory, until)
    first = 1
    if abs(trajectory.relative_angle[0]) > CARRIED:
        events, first = (Event("start", float(trajectory.time[0])), *events), 0
    ghosts = _GHOSTS if trajectory.event_time("strike") is not None else _GHOSTS | {"highest relative speed": BLACK}
    return [_Mark(number, event, ghosts.get(event.name, GREY)) for number, event in enumerate(events, start=first)]


def spread(positions: ArrayLike, gap: float, lowest: float, highest: float) -> Array:
    """Move ascending positions as little as a simple rule can until each is ``gap`` from the next, within the bounds.

    The mean of pushing all to the right and pushing all to the left keeps both the order and the gap.
    """
    wanted = np.asarray(positions, dtype=float)
    offsets = gap * np.arange(wanted.size)
    rightward = np.maximum.accumulate(wanted - offsets) + offsets
    leftward = np.minimum.accumulate((wanted - offsets)[::-1])[::-1] + offsets
    centred = 0.5 * (rightward + leftward)
    below_top = np.minimum(centred, highest - offsets[::-1])
    return np.asarray(np.maximum(below_top, lowest + offsets))


def _draw_line(axes: Axes, time: Array, values: Array, name: str, label: str) -> None:
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    axes.plot(time * MILLISECONDS, values, color=BLUE, gid=name)
    axes.set_ylabel(label, linespacing=1.4)
    axes.tick_params(labelbottom=False)


def _draw_energy(axes: Axes, course: Course, trajectory: Trajectory, motion: SampledMotion, potential: str) -> None:
    lines: tuple[tuple[str, Array, dict[str, Any]], ...] = (
        ("sum", trajectory.total_energy, {"color": GREY, "linewidth": 1.0, "dashes": (4, 2)}),
        ("bristle, kinetic", trajectory.kinetic_energy, {"color": BLUE}),
        (potential, trajectory.potential_energy, {"color": GREEN}),
    )
    for name, samples, look in lines:
        values = motion.along(course.time, samples) * MILLIJOULES
        axes.plot(course.time * MILLISECONDS, values, label=name, gid=f"energy, {name}", **look)
    axes.set_ylabel("energy (mJ)")
    axes.set_xlabel("time (ms)")
    axes.legend(loc="upper left", ncols=3, borderaxespad=0.2, columnspacing=1.2)
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.25 * (top - bottom))  # room for the legend


def _number_instants(axes: Axes, marks: Sequence[_Mark]) -> None:
    """Write the numbers of the table above the panel, each led to its instant."""
    first, last = axes.get_xlim()
    times = [mark.event.time * MILLISECONDS for mark in marks]
    above = axes.get_xaxis_transform()
    for mark, time, place in zip(marks, times, spread(times, BADGE_GAP * (last - first), first, last), strict=True):
        axes.plot([time, place], [1.0, 1.06], color=mark.color, linewidth=0.6, transform=above, clip_on=False)
        _badge(axes, (place, 1.12), str(mark.number), mark.color, above)


def _draw_path(axes: Axes, course: Course, tool: Tool, strike: float | None) -> None:
    view = close_up(course, tool, DRAWING[0] / DRAWING[1])
    axes.grid(visible=False)
    draw_tool(axes, tool, view)
    # The sample after an impact begins the second line, so that the two meet at the strike.
    after = int(np.searchsorted(course.time, course.time[-1] if strike is None else strike, side="right"))
    tip = course.tip * MILLIMETRES
    look: dict[str, Any] = {"linewidth": 1.0, "zorder": 3}
    until = "tip path" if strike is None else "tip path until the strike"
    axes.plot(*tip[:after].T, color=BLUE, gid="tip path", label=until, **look)
    if strike is not None:
        axes.plot(*tip[after - 1 :].T, color=PURPLE, gid="tip path after the strike", label="tip path after it", **look)
    view.apply(axes)
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    name_parts(axes, tool, 7.0)


def _explain_colours(figure: Figure, path: Axes) -> None:
    """Explain the lines of the drawing in a row below it."""
    handles = [*path.get_legend_handles_labels()[0]]
    handles.append(Line2D([], [], color=GREY, linewidth=3.0, label="wire, in the colour of its instant"))
    handles.append(Line2D([], [], color=GREEN, linestyle="none", marker="o", markersize=4.5, label="root in the belt"))
    place = (0.5, LEGEND / HEIGHT)
    figure.legend(handles=handles, loc="center", bbox_to_anchor=place, ncols=len(handles), columnspacing=1.6)


def _draw_ghosts(axes: Axes, tool: Tool, motion: SampledMotion, marks: Sequence[_Mark]) -> None:
    """Draw the wire at the first touch, the release and the strike, numbered at its root."""
    ghosts = [mark for mark in marks if mark.has_ghost]
    radius = max(tool.hub.radius * MILLIMETRES - 0.045 * np.ptp(axes.get_ylim()), 0.0)
    apart = 0.065 * np.ptp(axes.get_ylim()) / max(radius, 1e-9)
    roots = motion.hub_angle([mark.event.time for mark in ghosts])
    for mark, place in zip(ghosts, spread(roots, apart, -np.inf, np.inf), strict=True):
        ghost = WireDrawing(axes, tool, color=mark.color, alpha=0.75)
        ghost.wire.set_gid(f"wire {mark.number}")
        ghost.place(motion.centre_line(mark.event.time))
        _badge(axes, radius * toward(place), str(mark.number), mark.color)


def _badge(axes: Axes, place: ArrayLike, text: str, color: str, transform: Transform | None = None) -> None:
    x, y = np.asarray(place, dtype=float)
    box = {"boxstyle": "circle,pad=0.18", "facecolor": "white", "edgecolor": color, "linewidth": 0.8}
    look: dict[str, Any] = {"fontsize": 6.5, "ha": "center", "va": "center", "bbox": box, "zorder": 6}
    axes.text(x, y, text, color=color, transform=transform or axes.transData, **look)


def _draw_table(axes: Axes, motion: SampledMotion, marks: Sequence[_Mark]) -> None:
    """List the numbered instants with their figures."""
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(-14.5, 1.0)
    columns = {0.08: "event", 0.765: "time\n(ms)", 1.0: "retraction\n(°)"}
    for x, heading in columns.items():
        axes.text(x, 0.4, heading, ha="left" if x < 0.5 else "right", va="center", fontsize=7.0, color=GREY)
    for row, mark in enumerate(marks, start=1):
        retraction = np.degrees(motion.retraction(mark.event.time))
        _badge(axes, (0.03, 0.12 - row), str(mark.number), mark.color)
        axes.text(0.08, -row, mark.event.name, fontsize=7.0)
        axes.text(0.765, -row, f"{mark.event.time * MILLISECONDS:.3f}", fontsize=7.0, ha="right")
        axes.text(1.0, -row, signed(float(retraction), 2), fontsize=7.0, ha="right")


def _describe_strike(axes: Axes, row: float, trajectory: Trajectory) -> None:
    """Write speeds before and after the first strike, or why there is none."""
    contact = trajectory.first_contact("workpart")
    if contact is None:
        lines = ["no strike; the run ended:", trajectory.stop_reason]
    else:
        arriving, leaving = math.hypot(*contact.velocity_before), math.hypot(*contact.velocity_after)
        lines = [
            f"strike: {contact.rates_before[0] - trajectory.hub_speed:.1f} rad/s relative to the hub,",
            f"tip arrives at {arriving:.2f} m/s",
            f"and leaves at {leaving:.2f} m/s ({contact.outcome})",
        ]
    for number, line in enumerate(lines):
        axes.text(0.0, -row - 0.9 * number, line, fontsize=7.0)
