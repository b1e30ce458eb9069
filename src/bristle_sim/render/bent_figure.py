"""Draw a reverse bent, a straight and a forward bent bristle at their strike: wires, tip paths, slip over time."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.render.drawing import View
from bristle_sim.render.panels import panel_title, say
from bristle_sim.render.style import BLACK, BLUE, GREEN, GREY, LIGHT, VERMILION, axes_at, blank_figure, styled
from bristle_sim.studies.bent_bristles import BentBristles, Slide, against_film, slide_path
from bristle_sim.trajectory import ContactRecord
from bristle_sim.trajectory.sampled_motion import SampledMotion

WIDTH, HEIGHT = 16.0, 17.2
"""Printed size, cm."""

COLOURS = {"reverse": VERMILION, "straight": BLUE, "forward": GREEN}
NAMES = {"reverse": "reverse bent", "straight": "straight", "forward": "forward bent"}
MILLIMETRES, MICROSECONDS = 1e3, 1e6

BEFORE, AFTER = 0.6e-3, 1.1e-3
"""Time shown before the first touch and after the last, s."""

STEPS = 120
"""Instants at which a free path is drawn."""

IN_TOUCH = 2.6
"""Width of a tip's path while it touches the workpart, points."""


@styled()
def bent_figure(bent: BentBristles) -> Figure:
    """Draw wires at the strike and tip paths (mm), slip and displacement along the workpart in touch (us)."""
    figure = blank_figure(WIDTH, HEIGHT)
    wires, paths = axes_at(figure, 1.4, 9.2, 4.6, 5.6), axes_at(figure, 7.6, 9.2, 8.0, 5.6)
    speeds, slides = axes_at(figure, 1.4, 2.4, 6.2, 4.7), axes_at(figure, 9.4, 2.4, 6.2, 4.7)
    panel_title(wires, "a", "the wires as they strike", "to scale, from the point of strike")
    panel_title(paths, "b", "the tips' paths before, in and after touch", "to scale, from the point of strike")
    panel_title(speeds, "c", "slip while in touch", "the tip's speed along the workpart")
    panel_title(slides, "d", "distance slid while in touch", "the tip's displacement along the workpart")
    struck = {shape: run.first_contact("workpart") for shape, run in bent.trajectories.items()}
    for shape, contact in struck.items():
        if contact is not None:
            _draw_places(wires, paths, bent, shape, contact)
            _draw_in_touch(speeds, slides, shape, contact, bent.slides[shape])
    if any(struck.values()):
        _finish_places(wires, paths)
        _finish_times(speeds, slides)
    else:
        for axes in (wires, paths, speeds, slides):
            axes.set_axis_off()
            say(axes, "no tip strikes the workpart")
    _head(figure, bent)
    _explain(figure, struck)
    return figure


def _head(figure: Figure, bent: BentBristles) -> None:
    """Write what was simulated and what came out."""
    tool = bent.tools["forward"]
    assert tool.workpart is not None
    what = f"knee bent back, straight and forward by {tool.bristle.knee_angle_deg:g}°, μ = {tool.workpart.friction:g}"
    left = 1.4 / WIDTH
    figure.text(left, 1.0 - 0.65 / HEIGHT, f"Three bristles strike: {what}", fontsize=10.0)
    figure.text(left, 1.0 - 1.15 / HEIGHT, against_film(bent.slides), fontsize=8.0, color=GREY)


def _draw_places(wires: Axes, paths: Axes, bent: BentBristles, shape: str, contact: ContactRecord) -> None:
    """Draw the wire at the strike, and the tip's path from before it to after it."""
    run, colour = bent.trajectories[shape], COLOURS[shape]
    motion = SampledMotion(run)
    end = contact.time + contact.duration
    origin = run.tip[np.searchsorted(run.time, contact.time)]
    wires.plot(
        *(MILLIMETRES * (motion.centre_line(contact.time) - origin)).T, color=colour, linewidth=1.8, gid=f"wire {shape}"
    )
    for first, last, style in ((contact.time - BEFORE, contact.time, "--"), (end, end + AFTER, "-")):
        tips = motion.centre_line(np.linspace(first, last, STEPS))[:, -1]
        paths.plot(*(MILLIMETRES * (tips - origin)).T, style, color=colour, linewidth=1.0, gid=f"path {shape}")
    if contact.history is not None:
        along, above = slide_path(contact.history), -contact.history.penetration
        paths.plot(MILLIMETRES * along, MILLIMETRES * above, color=colour, linewidth=IN_TOUCH, gid=f"touch {shape}")


def _draw_in_touch(speeds: Axes, slides: Axes, shape: str, contact: ContactRecord, slide: Slide | None) -> None:
    """Draw speed along the workpart and its integral, with the end of compression and the turn of the slip marked."""
    history, colour = contact.history, COLOURS[shape]
    if history is None:
        return
    time = MICROSECONDS * (history.time - history.time[0])
    path = MILLIMETRES * slide_path(history)
    deepest, farthest = int(np.argmax(history.penetration)), int(np.argmax(path))
    for axes, values in ((speeds, history.tangential_velocity), (slides, path)):
        axes.plot(time, values, color=colour, gid=f"in touch {shape}")
        axes.plot(time[deepest], values[deepest], "o", color=colour, markersize=4.5, zorder=3)
        if slide is not None and slide.ending == "turns":
            axes.plot(
                time[farthest], values[farthest], "D", color=colour, markersize=5.5, markerfacecolor="none", zorder=4
            )


def _finish_places(wires: Axes, paths: Axes) -> None:
    """Give both panels equal scales and the workpart below their zero."""
    _frame(wires, list(wires.lines), 4.6 / 5.6)
    _frame(paths, [line for line in paths.lines if line.get_linestyle() != "--"], 8.0 / 5.6)
    for axes in (wires, paths):
        axes.axhspan(axes.get_ylim()[0], 0.0, color=LIGHT, linewidth=0.0, zorder=0)
        axes.axhline(0.0, color=GREY, linewidth=1.0, zorder=1)
        axes.set_xlabel("along the workpart (mm)")
    wires.set_ylabel("above the workpart (mm)")
    paths.annotate("workpart", (1.0, 0.0), (-3.0, 3.0), "axes fraction", "offset points", color=GREY, ha="right")


def _frame(axes: Axes, lines: list[Line2D], shape: float) -> None:
    """Set equal scales around lines in a panel ``shape`` times as wide as high, some of the workpart included."""
    points = np.concatenate([np.column_stack(line.get_data()) for line in lines] or [np.zeros((1, 2))])
    ground = [(0.0, -0.05 * float(np.ptp(points[:, 1])))]
    View.around([points, ground], shape, 0.08).apply(axes)


def _finish_times(speeds: Axes, slides: Axes) -> None:
    for axes in (speeds, slides):
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        axes.set_xlabel("time since the first touch (µs)")
    speeds.set_ylabel("speed along the workpart (m/s)")
    slides.set_ylabel("displacement (mm)")


def _explain(figure: Figure, struck: dict[str, ContactRecord | None]) -> None:
    """Explain colours, line styles and marks in two rows at the foot."""
    shapes = [Line2D([], [], color=COLOURS[shape], linewidth=2.0) for shape in struck]
    names = [NAMES[shape] + ("" if contact is not None else " (never strikes)") for shape, contact in struck.items()]
    place: dict[str, Any] = {"loc": "lower center", "ncols": 5, "columnspacing": 1.6, "borderaxespad": 0.0}
    figure.legend(shapes, names, bbox_to_anchor=(0.5, 0.75 / HEIGHT), **place)
    marks = [
        Line2D([], [], color=BLACK, linestyle="--", linewidth=1.0),
        Line2D([], [], color=BLACK, linewidth=IN_TOUCH),
        Line2D([], [], color=BLACK, linewidth=1.0),
        Line2D([], [], color=BLACK, linestyle="none", marker="o", markersize=4.5),
        Line2D([], [], color=BLACK, linestyle="none", marker="D", markersize=5.5, markerfacecolor="none"),
    ]
    words = ["path before touch", "in touch", "after touch", "compression ends", "slip turns back"]
    figure.legend(marks, words, bbox_to_anchor=(0.5, 0.25 / HEIGHT), **place)
