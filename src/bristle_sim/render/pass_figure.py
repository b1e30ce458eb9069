"""Draw the whole pass on one page: the tool to scale with the tip's path, and retraction, relative speed and energy over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Transform
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION
from bristle_sim.render.drawing import WireDrawing, close_up, draw_tool, name_parts, toward
from bristle_sim.render.story import CARRIED, key_events, story_end
from bristle_sim.render.style import MICROSECONDS, MILLIMETRES, MILLISECONDS, axes_at, blank_figure, signed, styled
from bristle_sim.trajectory import ContactRecord, Event, Motion, Trajectory

DRAWING, PANEL, ROW = (8.1, 6.6), (13.4, 2.9), 3.2
"""Width and height of the drawing of the tool and of a panel over time, and the distance of the panels, cm."""

BADGE_GAP = 0.035  # least distance between the numbers above a panel, as a fraction of its width
_GHOSTS = {"bar touch": ORANGE, "bar release": VERMILION, "strike": BLACK, "start": BLUE}
"""Events at which the drawing of the tool shows the wire, with its colour; other events are grey."""


class _Mark(NamedTuple):
    """A numbered instant, shown in every panel."""

    number: int
    event: Event
    color: str


@styled()
def pass_figure(trajectory: Trajectory, tool: Tool, *, until: float | None = None) -> Figure:
    """Draw a pass: tool and tip path to scale (mm), and retraction, relative speed and energy over time (ms).

    ``until`` is the last instant shown, s; by default shortly after the tip has left the workpart.

    Raises:
        ValueError: if the trajectory has fewer than two instants.
    """
    course = trajectory.course(story_end(trajectory) if until is None else until)
    marks = _marks(trajectory, float(course.time[-1]))
    forced = bool(course.normal_force.any())
    figure = blank_figure(16.0, 20.0 + forced * ROW)
    base = 13.0 + forced * ROW
    path = axes_at(figure, 1.4, base, *DRAWING)
    _draw_path(path, course, tool, trajectory.event_time("strike"))
    _draw_ghosts(path, tool, trajectory, marks)
    handles = [
        *path.get_legend_handles_labels()[0],
        Line2D([], [], color=GREY, linewidth=3.0, label="wire, in the colour of its instant"),
        Line2D([], [], color=GREEN, linestyle="none", marker="o", markersize=4.5, label="root in the belt"),
    ]
    anchor = (0.5, (base - 1.6) / (20.0 + forced * ROW))
    figure.legend(handles=handles, loc="center", bbox_to_anchor=anchor, ncols=len(handles), columnspacing=1.6)
    _draw_table(axes_at(figure, 9.65, base, 6.2, 6.6), marks, trajectory)
    potential = "belt" if tool.gravity == 0.0 else "belt and gravity"
    rows: list[tuple[str, list[tuple[str, Array, dict[str, Any]]]]] = [
        ("retraction (°)", [("retraction", np.degrees(course.retraction), {})]),
        ("relative\nspeed (rad/s)", [("relative speed", course.relative_rate, {})]),
        ("energy (mJ)", [
            ("sum", 1e3 * course.total_energy, {"color": GREY, "linewidth": 1.0, "dashes": (4, 2)}),
            ("bristle, kinetic", 1e3 * course.kinetic_energy, {}),
            (potential, 1e3 * course.potential_energy, {"color": GREEN}),
        ]),
    ]  # fmt: skip
    if forced:
        rows.append(("normal\nforce (N)", [("normal force", course.normal_force, {"color": VERMILION})]))
    panels: list[Axes] = []
    struck = trajectory.first_contact("workpart")
    for number, (label, lines) in enumerate(rows):
        place = (2.0, 1.1 + (len(rows) - 1 - number) * ROW, *PANEL)
        panels.append(axes_at(figure, *place, sharex=panels[0] if panels else None))
        _draw_lines(panels[-1], label, course.time, lines, marks)
        panels[-1].tick_params(labelbottom=number == len(rows) - 1)
    if forced and struck is not None and struck.history is not None:
        _draw_strike(axes_at(figure, 11.6, 1.1 + 0.42 * PANEL[1], 3.7, 0.5 * PANEL[1]), trajectory, struck)
    panels[0].set_xlim(course.time[0] * MILLISECONDS, course.time[-1] * MILLISECONDS)
    panels[-1].set_xlabel("time (ms)")
    _number_instants(panels[0], marks)
    return figure


def _marks(trajectory: Trajectory, until: float) -> list[_Mark]:
    """Number the key events from 1; a start away from the radial direction is number 0."""
    events, first = key_events(trajectory, until), 1
    if abs(trajectory.relative_angle[0]) > CARRIED:
        events, first = (Event("start", float(trajectory.time[0])), *events), 0
    ghosts = dict(_GHOSTS) if trajectory.event_time("strike") else _GHOSTS | {"highest relative speed": BLACK}
    colors = [ghosts.pop(event.name, GREY) for event in events]  # of several of a name the first shows the wire
    return [
        _Mark(first + number, event, color) for number, (event, color) in enumerate(zip(events, colors, strict=True))
    ]


def spread(positions: ArrayLike, gap: float, lowest: float, highest: float) -> Array:
    """Move ascending positions as little as a simple rule can until each is ``gap`` from the next, within the bounds.

    The mean of pushing all to the right and pushing all to the left keeps both the order and the gap.
    """
    wanted = np.asarray(positions, dtype=float)
    offsets = gap * np.arange(wanted.size)
    rightward = np.maximum.accumulate(wanted - offsets) + offsets
    leftward = np.minimum.accumulate((wanted - offsets)[::-1])[::-1] + offsets
    below_top = np.minimum(0.5 * (rightward + leftward), highest - offsets[::-1])
    return np.asarray(np.maximum(below_top, lowest + offsets))


def _draw_lines(
    axes: Axes, label: str, time: Array, lines: list[tuple[str, Array, dict[str, Any]]], marks: Sequence[_Mark]
) -> None:
    for name, values, look in lines:
        axes.plot(time * MILLISECONDS, values, label=name, gid=name, **{"color": BLUE, **look})
    for mark in marks:
        axes.axvline(mark.event.time * MILLISECONDS, color=mark.color, linewidth=0.7, dashes=(2, 2), zorder=1)
    axes.set_ylabel(label, linespacing=1.4)
    axes.yaxis.set_label_coords(-1.05 / PANEL[0], 0.5)  # in line, however wide the numbers are
    if len(lines) > 1:
        axes.legend(loc="upper left", ncols=3, borderaxespad=0.2, columnspacing=1.2)
        bottom, top = axes.get_ylim()
        axes.set_ylim(bottom, top + 0.25 * (top - bottom))  # room for the legend
    else:
        axes.axhline(0.0, color=GREY, linewidth=0.6)


def _draw_strike(axes: Axes, run: Trajectory, struck: ContactRecord) -> None:
    time = np.linspace(struck.time, struck.time + struck.duration, 200)
    axes.plot(MICROSECONDS * (time - struck.time), run.at(time).normal_force, color=VERMILION)
    axes.set_title("in the strike, over µs", fontsize=6.5, loc="left", pad=2.0)
    axes.patch.set_alpha(0.9)
    axes.set_ylim(bottom=0.0)
    axes.tick_params(labelsize=6.0)


def _number_instants(axes: Axes, marks: Sequence[_Mark]) -> None:
    first, last = axes.get_xlim()
    times = [mark.event.time * MILLISECONDS for mark in marks]
    above = axes.get_xaxis_transform()
    for mark, time, place in zip(marks, times, spread(times, BADGE_GAP * (last - first), first, last), strict=True):
        axes.plot([time, place], [1.0, 1.06], color=mark.color, linewidth=0.6, transform=above, clip_on=False)
        _badge(axes, (place, 1.12), mark, above)


def _draw_path(axes: Axes, course: Motion, tool: Tool, strike: float | None) -> None:
    view = close_up(course.centre_line, tool, DRAWING[0] / DRAWING[1])
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
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    axes.yaxis.set_label_coords(-1.05 / DRAWING[0], 0.5)
    name_parts(axes, tool, 7.0)


def _draw_ghosts(axes: Axes, tool: Tool, run: Trajectory, marks: Sequence[_Mark]) -> None:
    ghosts = [mark for mark in marks if mark.color != GREY]
    height = float(np.ptp(axes.get_ylim()))
    radius = max(tool.hub.radius * MILLIMETRES - 0.045 * height, 0.0)
    shown = run.at([mark.event.time for mark in ghosts])
    places = spread(shown.hub_angle, 0.065 * height / max(radius, 1e-9), -np.inf, np.inf)
    for mark, line, place in zip(ghosts, shown.centre_line, places, strict=True):
        ghost = WireDrawing(axes, tool, color=mark.color, alpha=0.75)
        ghost.wire.set_gid(f"wire {mark.number}")
        ghost.place(line)
        _badge(axes, radius * toward(place), mark)


def _badge(axes: Axes, place: ArrayLike, mark: _Mark, transform: Transform | None = None) -> None:
    x, y = np.asarray(place, dtype=float)
    box = {"boxstyle": "circle,pad=0.18", "facecolor": "white", "edgecolor": mark.color, "linewidth": 0.8}
    look: dict[str, Any] = {"fontsize": 6.5, "ha": "center", "va": "center", "bbox": box, "zorder": 6}
    axes.text(x, y, str(mark.number), color=mark.color, transform=transform or axes.transData, **look)


def _draw_table(axes: Axes, marks: Sequence[_Mark], trajectory: Trajectory) -> None:
    """List the numbered instants, and below them the strike's speeds, or why there is none."""
    axes.set_axis_off()
    axes.set(xlim=(0.0, 1.0), ylim=(-14.5, 1.0))
    for x, heading in {0.08: "event", 0.75: "time\n(ms)", 1.0: "retraction\n(°)"}.items():
        axes.text(x, 0.4, heading, ha="left" if x < 0.5 else "right", va="center", fontsize=7.0, color=GREY)
    for row, mark in enumerate(marks, start=1):
        retraction = float(np.degrees(trajectory.at(mark.event.time).retraction))
        _badge(axes, (0.03, 0.12 - row), mark)
        name = mark.event.name  # of the motion up to the strike; the picture may swing farther after it
        if name == "largest retraction" and retraction < float(np.degrees(trajectory.retraction.max())) - 0.01:
            name = "largest retraction so far"
        axes.text(0.08, -row, name, fontsize=7.0)
        axes.text(0.75, -row, f"{mark.event.time * MILLISECONDS:.3f}", fontsize=7.0, ha="right")
        axes.text(1.0, -row, signed(retraction, 2), fontsize=7.0, ha="right")
    contact = trajectory.first_contact("workpart")
    lines = ["no strike; the run ended:", str(trajectory.stop_reason)]
    if contact is not None:
        lines = [
            f"strike: {contact.rates_before[0] - trajectory.hub_speed:.1f} rad/s relative to the hub,",
            f"tip arrives at {math.hypot(*contact.velocity_before):.2f} m/s",
            f"and leaves at {math.hypot(*contact.velocity_after):.2f} m/s ({contact.outcome})",
        ]
    for number, line in enumerate(lines):
        axes.text(0.0, -len(marks) - 1.6 - 0.9 * number, line, fontsize=7.0)
