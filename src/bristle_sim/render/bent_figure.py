"""Draw a reverse bent, a straight and a forward bent bristle at their strike: wires, tip paths, displacement over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, LIGHT, VERMILION
from bristle_sim.render.drawing import View
from bristle_sim.render.style import MICROSECONDS, MILLIMETRES, add_panel, blank_figure, say, styled, write_key
from bristle_sim.studies.bent_bristles import BentBristles, against_film
from bristle_sim.trajectory import ContactRecord

SHAPES = {"reverse": VERMILION, "straight": BLUE, "forward": GREEN}
NAMES = {"reverse": "reverse bent", "straight": "straight", "forward": "forward bent"}

BEFORE, AFTER = 0.6e-3, 1.1e-3  # time shown before the first touch and after the last, s
MARKS: dict[str, dict[str, Any]] = {
    "path before touch": {"linestyle": "--", "linewidth": 1.0},
    "in touch": {"linewidth": 2.6},
    "after touch": {"linewidth": 1.0},
    "compression ends": {"linestyle": "none", "marker": "o", "markersize": 4.5, "zorder": 3},
    "slip turns back": {"linestyle": "none", "marker": "D", "markersize": 5.5, "markerfacecolor": "none", "zorder": 4},
}


@styled()
def bent_figure(bent: BentBristles) -> Figure:
    """Draw wires at the strike and tip paths (mm), and displacement along the workpart in touch (mm, us)."""
    figure, words = blank_figure(16.0, 17.2), "to scale, from the point of strike"
    wires = add_panel(figure, (1.4, 9.2, 4.6, 5.6), "the wires as they strike", words)
    paths = add_panel(figure, (7.6, 9.2, 8.0, 5.6), "the tips' paths before, in and after touch", words)
    slides = add_panel(figure, (1.4, 2.4, 14.2, 4.7), "displacement of the tips along the workpart while in touch")
    struck = {shape: run.first_contact("workpart") for shape, run in bent.trajectories.items()}
    for shape, contact in struck.items():
        if contact is not None:
            _draw_strike((wires, paths, slides), bent, shape, contact)
    if any(struck.values()):
        _finish(wires, paths, slides)
    else:
        for axes in (wires, paths, slides):
            axes.set_axis_off()
            say(axes, "no tip strikes the workpart")
    tool, left = bent.tools["forward"], 1.4 / 16.0
    assert tool.workpart is not None
    what = f"knee bent back, straight and forward by {tool.bristle.knee_angle_deg:g}°, μ = {tool.workpart.friction:g}"
    figure.text(left, 1.0 - 0.65 / 17.2, f"Three bristles strike: {what}", fontsize=10.0)
    figure.text(left, 1.0 - 1.15 / 17.2, against_film(bent.slides), fontsize=8.0, color=GREY)
    never = {shape: "" if contact is not None else " (never strikes)" for shape, contact in struck.items()}
    shapes = {NAMES[shape] + never[shape]: {"color": color} for shape, color in SHAPES.items()}
    marks = {name: {"color": BLACK, **look} for name, look in MARKS.items()}
    for height, looks in ((0.75, shapes), (0.25, marks)):
        write_key(figure, looks, bbox_to_anchor=(0.5, height / 17.2), borderaxespad=0.0)
    return figure


def _draw_strike(panels: Sequence[Axes], bent: BentBristles, shape: str, contact: ContactRecord) -> None:
    (wires, paths, slides), run, color = panels, bent.trajectories[shape], SHAPES[shape]
    slide, history, end = bent.slides[shape], contact.history, contact.time + contact.duration
    origin = run.tip[np.searchsorted(run.time, contact.time)]
    wire = MILLIMETRES * (run.at(contact.time).centre_line - origin)
    wires.plot(*wire.T, color=color, linewidth=1.8)
    shown = {"path before touch": (contact.time - BEFORE, contact.time), "after touch": (end, end + AFTER)}
    for mark, (first, last) in shown.items():
        tips = run.at(np.linspace(max(first, run.time[0]), min(last, run.time[-1]), 120)).tip
        paths.plot(*(MILLIMETRES * (tips - origin)).T, color=color, **MARKS[mark])
    if history is None:
        return
    time = np.linspace(contact.time, end, 400)
    path, above = (MILLIMETRES * (run.at(time).tip - origin)).T
    time = MICROSECONDS * (time - contact.time)
    paths.plot(path, above, color=color, **MARKS["in touch"])
    slides.plot(time, path, color=color)
    compressed, turned = int(np.argmin(above)), int(np.argmax(path))
    slides.plot(time[compressed], path[compressed], color=color, **MARKS["compression ends"])
    if slide is not None and slide.ending == "turns":
        slides.plot(time[turned], path[turned], color=color, **MARKS["slip turns back"])


def _finish(wires: Axes, paths: Axes, slides: Axes) -> None:
    after = [line for line in paths.lines if line.get_linestyle() != "--"]
    for axes, lines, shape in ((wires, list(wires.lines), 4.6 / 5.6), (paths, after, 8.0 / 5.6)):
        points = np.concatenate([np.column_stack(line.get_data()) for line in lines] or [np.zeros((1, 2))])
        ground = [(0.0, -0.05 * float(np.ptp(points[:, 1])))]
        View.around([points, ground], shape, 0.08).apply(axes)
        axes.axhspan(axes.get_ylim()[0], 0.0, color=LIGHT, linewidth=0.0, zorder=0)
        axes.axhline(0.0, color=GREY, linewidth=1.0, zorder=1)
        axes.set_xlabel("along the workpart (mm)")
    wires.set_ylabel("above the workpart (mm)")
    paths.annotate("workpart", (1.0, 0.0), (-3.0, 3.0), "axes fraction", "offset points", color=GREY, ha="right")
    slides.axhline(0.0, color=GREY, linewidth=0.8)
    slides.set(xlabel="time since the first touch (µs)", ylabel="displacement (mm)")
