"""Figures of several bristles: three shapes of wire at their strike, and a row whose wires touch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.render import style
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, LIGHT, SERIES, VERMILION
from bristle_sim.render.drawing import (
    draw_wires,
    show_points,
    touch_places,
)
from bristle_sim.studies.bent_bristles import SHAPES, BentBristles, against_film
from bristle_sim.studies.neighbours import NeighbourRow, root_pitch, strike_values
from bristle_sim.trajectory import ContactRecord, Trajectory

COLOURS = {"reverse": VERMILION, "straight": BLUE, "forward": GREEN}
"""Colour of each shape of wire."""

# Time shown before the first touch and after the last touch, s
BEFORE = 0.6e-3
AFTER = 1.1e-3
MARKS: dict[str, style.Look] = {
    "path before touch": {"linestyle": "--", "linewidth": 1.0},
    "in touch": {"linewidth": 2.6},
    "after touch": {"linewidth": 1.0},
}


@style.styled()
def bent_figure(bent: BentBristles) -> Figure:
    """Draw straight and bent wires at the strike, and the paths of their tips around the contact.

    These lengths are in mm. A further panel shows each tip's displacement along the workpart during
    the contact, in mm over time in us.
    """
    figure = style.blank_figure(16.0, 17.2)
    words = "to scale, from the point of strike"
    along = "along the workpart (mm)"
    title = "the wires as they strike"
    wires = style.add_panel(figure, (1.4, 9.2, 4.6, 5.6), title, words, xlabel=along)
    wires.set_ylabel("above the workpart (mm)")
    title = "the tips' paths before, in and after touch"
    paths = style.add_panel(figure, (7.6, 9.2, 8.0, 5.6), title, words, xlabel=along)
    slides = style.add_panel(
        figure,
        (1.4, 2.4, 14.2, 4.7),
        "displacement of the tips along the workpart while in touch",
        xlabel="time since the first touch (µs)",
        ylabel="displacement (mm)",
    )
    shapes: dict[str, style.Look] = {}
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
        style.draw_zero(axes)
    if drawn:
        style.draw_zero(slides)
    else:
        for axes in (wires, paths, slides):
            axes.set_axis_off()
            style.say(axes, "no tip strikes the workpart")
    tool = bent.trajectories["forward"].tool
    assert tool.workpart is not None
    left = 1.4 / 16.0
    what = f"knee bent back, straight and forward by {tool.bristle.knee_angle_deg:g}°, μ = {tool.workpart.friction:g}"
    figure.text(left, 1.0 - 0.65 / 17.2, f"Three bristles strike: {what}", fontsize=10.0)
    figure.text(left, 1.0 - 1.15 / 17.2, against_film(bent.slides), fontsize=8.0, color=GREY)
    marks = {name: {"color": BLACK, **look} for name, look in MARKS.items()}
    for height, looks in ((0.75, shapes), (0.25, marks)):
        style.write_key(figure, looks, bbox_to_anchor=(0.5, height / 17.2), borderaxespad=0.0)
    return figure


def _draw_strike(
    panels: Sequence[Axes], run: Trajectory, contact: ContactRecord, color: str
) -> tuple[Array, Array]:
    """Draw a wire, the path of its tip and its displacement in touch.

    Returns:
        The wire and the tip's path from the first touch on, mm from the point of strike.
    """
    wires, paths, slides = panels
    touch = contact.time
    end = touch + contact.duration
    struck = run.at(touch)
    wire = style.MILLIMETRES * (struck.centre_line - struck.tip)
    wires.plot(*wire.T, color=color, linewidth=1.8)
    shown = {
        "path before touch": (max(touch - BEFORE, run.time[0]), touch),
        "in touch": (touch, end),
        "after touch": (end, min(end + AFTER, run.time[-1])),
    }
    drawn = {}
    for mark, (first, last) in shown.items():
        time = np.linspace(first, last, 400)
        drawn[mark] = style.MILLIMETRES * (run.at(time).tip - struck.tip)
        paths.plot(*drawn[mark].T, color=color, **MARKS[mark])
    time = style.MICROSECONDS * np.linspace(0.0, contact.duration, 400)
    slides.plot(time, drawn["in touch"][:, 0], color=color)
    return wire, np.concatenate([drawn["in touch"], drawn["after touch"]])


BESIDE = 0.02  # distance, deg, from a least pitch to the pitches on either side at which the strike is simulated
STRIKES = ("relative_speed_at_contact", "lag_deg_at_contact", "normal_final_impulse")

LEAST = {
    "least_pitch_to_strike_deg": ("no touch until the one in front strikes", (1, 1)),
    "least_pitch_to_own_strike_deg": ("no touch until its own strike", (4, 2)),
    "least_pitch_whole_pass_deg": ("no touch in the whole pass", (9, 2)),
}
"""Label and dashes of the line at each least pitch. The label is true of all larger pitches."""


def pitches_to_draw(row: NeighbourRow) -> list[float]:
    """Return the angles between neighbouring bristles (deg) at which the strike is simulated.

    They extend from closely spaced bristles to beyond the least pitch without a touch in the whole
    pass.
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


# Least span of an axis over its largest value; a smaller span would show rounding error as scatter.
LEAST_SPAN = 0.02


@style.styled()
def neighbours_figure(
    row: NeighbourRow, pitches: Sequence[float], strikes: Mapping[str, Array]
) -> Figure:
    """Draw a row of bristles at two instants, and the strike of its last bristle over the pitch.

    Args:
        row: the row of bristles.
        pitches: angles between neighbouring bristles, deg.
        strikes: quantities of the last bristle's strike by name, with one value for each pitch.
    """
    figure = style.blank_figure(16.0, 13.4)
    last = f"bristle {len(row.bristles)}"
    for left, (title, time) in zip((0.2, 8.2), instants(row), strict=True):
        words = f"pitch {row.neighbours.pitch_deg:g}°, {1e3 * time:.3f} ms"
        _draw_row(style.add_panel(figure, (left, 6.4, 7.6, 5.8), title, words), row, time)
    alone = strike_values(row.tool, row.lone)
    for left, name in zip((1.5, 6.8, 12.0), STRIKES, strict=True):
        title, unit, factor = style.STRIKE_LOOKS[name]
        place = (left, 1.9, 3.7, 3.2)
        axes = style.add_panel(figure, place, title, f"of {last}", xlabel="pitch (°)", ylabel=unit)
        if (value := alone[name]) is not None:
            axes.axhline(factor * value, color=BLUE, linewidth=1.0, zorder=2, label="bristle alone")
        shown = factor * strikes[name]
        label = f"{last} of the row"
        axes.plot(pitches, shown, "o", color=VERMILION, markersize=2.6, label=label)
        for each in row.least:
            if (least := each.by_theory) is not None:
                words, dashes = LEAST[each.name]
                label = f"{least:.2f}°: {words}"
                axes.axvline(least, color=BLACK, linewidth=0.8, dashes=dashes, label=label)
        axes.set_xlim(left=0.0)
        style.span_at_least(axes, LEAST_SPAN)
        if np.isnan(strikes[name]).all():
            style.say(axes, "no strike at any pitch")
    handles, _ = axes.get_legend_handles_labels()
    figure.legend(handles=handles, loc="lower center", ncols=3, borderaxespad=0.2)
    return figure


def _draw_row(axes: Axes, row: NeighbourRow, time: float) -> None:
    lines = [run.at(time).centre_line for run in row.bristles]
    colors = (SERIES * 2)[: len(lines)]
    drawings = draw_wires(axes, row.tool, lines, colors)
    for number, (drawing, line) in enumerate(zip(drawings, lines, strict=True), 1):
        drawing.place(line)
        x, y = 0.9 * style.MILLIMETRES * line[0]
        axes.text(x, y, str(number), color=colors[number - 1], ha="center", va="center")
    places = touch_places(lines, row.tool.bristle.wire_diameter)
    axes.plot(*places.T, "o", markersize=13.0, markerfacecolor="none", color=BLACK, zorder=6)


def instants(row: NeighbourRow) -> list[tuple[str, float]]:
    """Return the two instants at which the row is drawn, each as a name and a time, s.

    They are the first touch between wires, and the last touch before the last bristle strikes.
    Where a touch is missing, the strike of the first or of the last bristle takes its place.
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
