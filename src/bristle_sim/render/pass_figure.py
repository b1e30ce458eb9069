"""The whole pass on one page: the tool to scale with the tip's path, and retraction, relative speed and energy over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import ArrayLike, NDArray

from bristle_sim.parameters import Tool
from bristle_sim.render.motion import Course, Motion
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
from bristle_sim.render.tool_drawing import (
    MILLIMETRES,
    WireDrawing,
    close_up,
    draw_bar,
    draw_hub,
    draw_workpart,
    name_parts,
    toward,
)
from bristle_sim.trajectory import Event, Trajectory

__all__ = ["pass_figure", "spread"]

Array = NDArray[np.float64]

MILLISECONDS = 1e3
MILLIJOULES = 1e3

WIDTH = 16.0
"""Printed width of the page's text, cm."""

DRAWING = (8.7, 6.6)
"""Width and height of the drawing of the tool, cm."""

PANEL = 12.5
"""Width of a panel over time, cm."""

LEGEND = 13.0
"""Height of the row that explains the drawing's colours, cm."""

LABEL_SLANT = 35.0
"""Slope of the labels, degrees."""

LABEL_GAP = 0.045
"""Least distance between slanted labels, as a share of the panel's width."""

LABEL_ROOM = 0.07
"""Share of the panel's width that labels keep free on the right, so that the longest ends on the page."""

_GHOSTS = {"bar touch": ORANGE, "bar release": VERMILION, "strike": BLACK, "start": BLUE}
REBOUND_SHOWN = 0.35
"""The ghost of the rebound stands at this share of the time from the strike to the next turning point."""


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


def pass_figure(trajectory: Trajectory, tool: Tool, *, until: float | None = None) -> Figure:
    """Draw a pass: tool and tip path to scale (mm), and retraction, relative speed and energy over time (ms).

    ``until`` is the last instant shown, s; by default shortly after the tip has left the workpart.

    Raises:
        ValueError: if the trajectory has fewer than two instants.
    """
    with styled():
        return _compose(trajectory, tool, until)


def _compose(trajectory: Trajectory, tool: Tool, until: float | None) -> Figure:
    motion = Motion(trajectory)
    course = motion.course(story_end(trajectory) if until is None else until)
    marks = _marks(trajectory, float(course.time[-1]))
    figure = blank_figure(WIDTH, 21.4)
    path = axes_at(figure, 1.4, 14.4, *DRAWING)
    _draw_path(path, course, tool, trajectory.event_time("strike"))
    rebound = _rebound_instant(trajectory, float(course.time[-1]))
    _draw_ghosts(path, tool, motion, marks, rebound)
    table = axes_at(figure, 10.25, 14.4, 5.6, 6.6)
    _draw_table(table, motion, marks)
    _describe_strike(table, len(marks) + 1.6, trajectory, rebound)
    _explain_colours(figure, path)
    retraction = axes_at(figure, 2.0, 7.5, PANEL, 2.9)
    speed = axes_at(figure, 2.0, 4.3, PANEL, 2.9, sharex=retraction)
    energy = axes_at(figure, 2.0, 1.1, PANEL, 2.9, sharex=retraction)
    _draw_retraction(retraction, course)
    _draw_speed(speed, course)
    _draw_energy(energy, course, trajectory, motion, "belt" if tool.gravity == 0.0 else "belt and gravity")
    path.yaxis.set_label_coords(-1.05 / DRAWING[0], 0.5)
    for axes in (retraction, speed, energy):
        axes.yaxis.set_label_coords(-1.05 / PANEL, 0.5)  # in line, however wide the numbers are
        _draw_instants(axes, course, marks)
    _label_instants(retraction, marks)
    return figure


def _marks(trajectory: Trajectory, until: float) -> list[_Mark]:
    """The key events numbered from 1; a start away from the radial direction is number 0."""
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


def _draw_retraction(axes: Axes, course: Course) -> None:
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    axes.plot(course.time * MILLISECONDS, np.degrees(course.retraction), color=BLUE, gid="retraction")
    axes.set_ylabel("retraction (°)", linespacing=1.4)
    axes.tick_params(labelbottom=False)


def _draw_speed(axes: Axes, course: Course) -> None:
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    axes.plot(course.time * MILLISECONDS, course.relative_speed, color=BLUE, gid="relative speed")
    axes.set_ylabel("relative\nspeed (rad/s)", linespacing=1.4)
    axes.tick_params(labelbottom=False)


def _draw_energy(axes: Axes, course: Course, trajectory: Trajectory, motion: Motion, potential: str) -> None:
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


def _draw_instants(axes: Axes, course: Course, marks: Sequence[_Mark]) -> None:
    axes.set_xlim(course.time[0] * MILLISECONDS, course.time[-1] * MILLISECONDS)
    for mark in marks:
        axes.axvline(mark.event.time * MILLISECONDS, color=mark.color, linewidth=0.7, dashes=(2, 2), zorder=1)


def _label_instants(axes: Axes, marks: Sequence[_Mark]) -> None:
    """Slanted labels above the panel, each led to its instant."""
    first, last = axes.get_xlim()
    times = [mark.event.time * MILLISECONDS for mark in marks]
    rightmost = last - LABEL_ROOM * (last - first)
    places = spread(times, LABEL_GAP * (last - first), first, rightmost)
    above = axes.get_xaxis_transform()
    look: dict[str, Any] = {"rotation": LABEL_SLANT, "rotation_mode": "anchor", "ha": "left", "va": "bottom"}
    for mark, time, place in zip(marks, times, places, strict=True):
        axes.plot([time, place], [1.0, 1.09], color=mark.color, linewidth=0.6, transform=above, clip_on=False)
        label = f"{mark.number} {mark.event.name}"
        axes.text(place, 1.1, label, color=mark.color, fontsize=7.0, transform=above, **look)


def _draw_path(axes: Axes, course: Course, tool: Tool, strike: float | None) -> None:
    view = close_up(course, tool, DRAWING[0] / DRAWING[1])
    axes.grid(visible=False)
    draw_hub(axes, tool)
    draw_bar(axes, tool)
    draw_workpart(axes, tool, view)
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
    """What the lines of the drawing are, in a row below it."""
    handles = [*path.get_legend_handles_labels()[0]]
    handles.append(Line2D([], [], color=GREY, linewidth=3.0, label="wire, in the colour of its instant"))
    handles.append(Line2D([], [], color=GREEN, linestyle="none", marker="o", markersize=4.5, label="root in the belt"))
    place = (0.5, LEGEND / (figure.get_size_inches()[1] * 2.54))
    figure.legend(handles=handles, loc="center", bbox_to_anchor=place, ncols=len(handles), columnspacing=1.6)


def _draw_ghosts(axes: Axes, tool: Tool, motion: Motion, marks: Sequence[_Mark], rebound: float | None) -> None:
    """The wire at the first touch, the release, the strike and during the rebound, numbered at its root."""
    ghosts = [(mark.event.time, mark.color, str(mark.number)) for mark in marks if mark.has_ghost]
    if rebound is not None:
        ghosts = sorted([*ghosts, (rebound, PURPLE, "R")])
    radius = max(tool.hub.radius * MILLIMETRES - 0.045 * np.ptp(axes.get_ylim()), 0.0)
    apart = 0.065 * np.ptp(axes.get_ylim()) / max(radius, 1e-9)
    roots = motion.hub_angle([time for time, _, _ in ghosts])
    for (time, color, badge), place in zip(ghosts, spread(roots, apart, -np.inf, np.inf), strict=True):
        ghost = WireDrawing(axes, tool, color=color, alpha=0.75)
        ghost.wire.set_gid(f"wire {badge}")
        ghost.place(motion.centre_line(time))
        _badge(axes, radius * toward(place), badge, color)


def _badge(axes: Axes, place: ArrayLike, text: str, color: str, **options: Any) -> Text:
    x, y = np.asarray(place, dtype=float)
    box = {"boxstyle": "circle,pad=0.18", "facecolor": "white", "edgecolor": color, "linewidth": 0.8}
    return axes.text(x, y, text, color=color, fontsize=6.5, ha="center", va="center", bbox=box, zorder=6, **options)


def _rebound_instant(trajectory: Trajectory, until: float) -> float | None:
    """An instant part of the way from a rebound to the next event or the end, s."""
    contact, strike = trajectory.first_contact("workpart"), trajectory.event_time("strike")
    if contact is None or strike is None or contact.velocity_after[0] <= 0.0:
        return None
    parted = strike + contact.duration
    following = (event.time for event in trajectory.events if event.time > parted)
    flight = next(following, float(trajectory.time[-1])) - parted
    shown = parted + REBOUND_SHOWN * flight
    return shown if parted < shown <= until else None


def _draw_table(axes: Axes, motion: Motion, marks: Sequence[_Mark]) -> None:
    """The numbered instants with their figures."""
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


def _describe_strike(axes: Axes, row: float, trajectory: Trajectory, rebound: float | None) -> None:
    """Speeds before and after the first strike, or why there is none."""
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
        if rebound is not None:
            shown = f"wire {(rebound - contact.time) * MILLISECONDS:.2f} ms after the strike"
            axes.text(0.08, -row, shown, fontsize=7.0)
            _badge(axes, (0.03, 0.12 - row), "R", PURPLE)
            row += 1.5
    for number, line in enumerate(lines):
        axes.text(0.0, -row - 0.9 * number, line, fontsize=7.0)
