"""Figures of several bristles: three shapes of wire at their strike, and a row whose wires touch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.readable import MICROSECONDS, MILLIMETRES, MILLISECONDS
from bristle_sim.render.drawing import (
    draw_wires,
    show_points,
    touch_places,
)
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    LIGHT,
    SERIES,
    STRIKE_LOOKS,
    VERMILION,
    Look,
    blank_figure,
    draw_zero,
    say,
    span_at_least,
    styled,
    write_key,
)
from bristle_sim.studies.bent_bristles import SHAPES, BentBristles, against_film
from bristle_sim.studies.neighbours import NeighbourRow, root_pitch, strike_values
from bristle_sim.trajectory import ContactRecord, Trajectory

COLOURS = {"reverse": VERMILION, "straight": BLUE, "forward": GREEN}
"""Colour of each shape of wire."""

# Durations shown before the first touch and after the end of the contact, s.
BEFORE = 0.6e-3
AFTER = 1.1e-3
MARKS: dict[str, Look] = {
    "path before the contact": {"linestyle": "--", "linewidth": 1.0},
    "during the contact": {"linewidth": 2.6},
    "after the contact": {"linewidth": 1.0},
}


@styled()
def bent_figure(bent: BentBristles) -> Figure:
    """Draw the strikes of straight and bent wires.

    Panels show the wires at the strike, and the paths of their tips around the contact. A further
    panel shows each tip's displacement along the workpart over the time since its first touch.
    Lengths are in mm, times in us.
    """
    figure = blank_figure(16.0, 15.5)
    panels = figure.subplot_mosaic([["wires", "paths"], ["slides", "slides"]], width_ratios=(1, 2))
    wires, paths, slides = panels.values()
    along = "along the workpart (mm)"
    wires.set(title="the wires at the strike", xlabel=along, ylabel="above the workpart (mm)")
    paths.set(title="the tips' paths, from the point of strike", xlabel=along)
    slides.set(title="during the contact", xlabel="time since the first touch (µs)")
    slides.set_ylabel("displacement of the tip\nalong the workpart (mm)")
    shapes: dict[str, Look] = {}
    drawn = []
    for shape, run in bent.trajectories.items():
        contact = run.first_contact("workpart")
        name, _ = SHAPES[shape]
        color = COLOURS[shape]
        shapes[name + " (never strikes)" * (contact is None)] = {"color": color}
        if contact is not None:
            drawn.append(_draw_strike((wires, paths, slides), run, contact, color))
    for axes, points in zip((wires, paths), zip(*drawn, strict=True), strict=False):
        ground = (0.0, -0.05 * float(np.ptp(np.concatenate(points)[:, 1])))
        show_points(axes, [*points, ground], 0.08)
        axes.axhspan(axes.get_ylim()[0], 0.0, color=LIGHT, linewidth=0.0, zorder=0)
    for axes in (wires, paths, slides):
        if drawn:
            draw_zero(axes)
        else:
            axes.set_axis_off()
            say(axes, "no tip strikes the workpart")
    tool = bent.trajectories["forward"].tool
    assert tool.workpart is not None
    shape = f"knee bent back, straight and forward by {tool.bristle.knee_angle_deg:g}°, μ = {tool.workpart.friction:g}"
    figure.suptitle(f"Three bristles strike: {shape}\n{against_film(bent.slides)}", fontsize=9.0)
    marks = {name: {"color": BLACK, **look} for name, look in MARKS.items()}
    write_key(figure, shapes | marks, ncols=3)
    return figure


def _draw_strike(
    panels: Sequence[Axes], run: Trajectory, contact: ContactRecord, color: str
) -> tuple[Array, Array]:
    """Draw a wire at its strike, the path of its tip, and the tip's displacement during the
    contact.

    Args:
        panels: axes for the wire, for the path, and for the displacement over time.
        run: motion of the wire.
        contact: the wire's first contact with the workpart.
        color: colour of all lines.

    Returns:
        Points of the wire at the first touch, and of the tip's path from then on. Coordinates are
        in mm from the place of the first touch.
    """
    wires, paths, slides = panels
    touch = contact.time
    end = touch + contact.duration
    struck = run.at(touch)
    wire = MILLIMETRES * (struck.centre_line - struck.tip)
    wires.plot(*wire.T, color=color, linewidth=1.8)
    edges = (max(touch - BEFORE, run.time[0]), touch, end, min(end + AFTER, run.time[-1]))
    before, during, after = (
        MILLIMETRES * (run.at(np.linspace(*each, 400)).tip - struck.tip) for each in pairwise(edges)
    )
    for points, look in zip((before, during, after), MARKS.values(), strict=True):
        paths.plot(*points.T, color=color, **look)
    time = MICROSECONDS * np.linspace(0.0, contact.duration, 400)
    slides.plot(time, during[:, 0], color=color)
    return wire, np.concatenate([during, after])


# Distance (deg) from each least pitch to the simulated pitches just below and just above it. They
# show how the strike changes at the least pitch.
BESIDE = 0.02
STRIKES = ("relative_speed_at_contact", "lag_deg_at_contact", "normal_final_impulse")

LEAST = {
    "least_pitch_to_strike_deg": ("no touch until the preceding bristle strikes", ":"),
    "least_pitch_to_own_strike_deg": ("no touch until the bristle itself strikes", "--"),
    "least_pitch_whole_pass_deg": ("no touch in the whole pass", "-."),
}
"""Label and line style of each least pitch, by name.

The label states what is true at all larger pitches."""


def pitches_to_draw(row: NeighbourRow) -> list[float]:
    """Return the pitches (deg) at which the strike of the row's last bristle is simulated.

    A pitch is the angle between neighbouring bristles. At the smallest pitch the bristles stand
    close together; at the largest no wires touch during the whole pass.
    """
    least = [each.by_theory for each in row.least if each.by_theory is not None]
    if not least:
        return [fraction * row.neighbours.pitch_deg for fraction in (0.5, 0.75, 1.0, 1.5, 2.0)]
    close = 2.5 * root_pitch(row.tool)
    even = [
        *np.linspace(close, 1.2 * min(least), 17),
        *np.linspace(1.2 * min(least), 1.1 * max(least), 6),
    ]
    return sorted([*even, *(each + side for each in least for side in (-BESIDE, BESIDE))])


# Least range of a vertical axis, as a fraction of its largest value. In a smaller range rounding
# error would look like scatter.
LEAST_SPAN = 0.02


@styled()
def neighbours_figure(
    row: NeighbourRow, pitches: Sequence[float], strikes: Mapping[str, Array]
) -> Figure:
    """Draw a row of bristles at two times, and quantities of its last bristle's strike over the
    pitch.

    Args:
        row: the row of bristles.
        pitches: angles between neighbouring bristles, deg.
        strikes: quantities of the last bristle's strike, by name. Each array has one value for each
            pitch.
    """
    figure = blank_figure(16.0, 12.5)
    above, below = figure.subfigures(2, squeeze=False, height_ratios=(1.4, 1.0)).flat
    last = f"bristle {len(row.bristles)}"
    for axes, (title, time) in zip(above.subplots(1, 2), instants(row), strict=True):
        axes.set_title(f"{title}, {MILLISECONDS * time:.3f} ms")
        _draw_row(axes, row, time)
    alone = strike_values(row.tool, row.lone)
    for axes, name in zip(below.subplots(1, 3), STRIKES, strict=True):
        title, unit, factor = STRIKE_LOOKS[name]
        axes.set(title=title, xlabel="pitch (°)", ylabel=unit)
        if (value := alone[name]) is not None:
            axes.axhline(factor * value, color=BLUE, linewidth=1.0, zorder=2, label="bristle alone")
        shown = factor * strikes[name]
        label = f"{last} of the row"
        axes.plot(pitches, shown, "o", color=VERMILION, markersize=2.6, label=label)
        for each in row.least:
            if (least := each.by_theory) is not None:
                words, dashes = LEAST[each.name]
                label = f"{least:.2f}°: {words}"
                axes.axvline(least, color=BLACK, linewidth=0.8, linestyle=dashes, label=label)
        axes.set_xlim(left=0.0)
        span_at_least(axes, LEAST_SPAN)
        if np.isnan(strikes[name]).all():
            say(axes, "no strike at any pitch")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _draw_row(axes: Axes, row: NeighbourRow, time: float) -> None:
    lines = [run.at(time).centre_line for run in row.bristles]
    colors = (SERIES * 2)[: len(lines)]
    drawings = draw_wires(axes, row.tool, lines, colors)
    for number, (drawing, line) in enumerate(zip(drawings, lines, strict=True), 1):
        drawing.place(line)
        x, y = 0.93 * MILLIMETRES * line[0]
        axes.text(x, y, str(number), color=colors[number - 1], ha="center", va="center", zorder=8)
    places = touch_places(lines, row.tool.bristle.wire_diameter)
    axes.plot(*places.T, "o", markersize=13.0, markerfacecolor="none", color=BLACK, zorder=6)


def instants(row: NeighbourRow) -> list[tuple[str, float]]:
    """Return names and times (s) of the two moments at which the row is drawn.

    Only touches between wires before the last bristle's strike count. The first moment is the first
    touch, or the strike of the first bristle if there is no touch. The second moment is the last
    touch, or the strike of the last bristle if there is no second touch.
    """
    front = row.bristles[0].event_time("strike")
    strike = row.bristles[-1].event_time("strike")
    until = float(row.bristles[-1].time[-1]) if strike is None else strike
    name = f"bristle {len(row.bristles)}"
    touches = [each for each in row.touches if each <= until]
    first = ("start", 0.0) if front is None else ("bristle 1 strikes", front)
    last = ("end of the pass" if strike is None else f"{name} strikes", until)
    if touches:
        first = ("first touch", touches[0])
    if len(touches) > 1:
        last = (f"last touch before {name} strikes" if strike else "last touch", touches[-1])
    return [first, last]
