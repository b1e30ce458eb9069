"""Draw the released bristle and the quasi-static formula, and the bars that they need for each reading of the stiffness."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREY, VERMILION
from bristle_sim.render.drawing import View, WireDrawing, draw_bar, draw_tool, name_parts
from bristle_sim.render.style import MILLIMETRES, MILLISECONDS, add_panel, axes_at, blank_figure, note, signed, styled
from bristle_sim.studies.cue_timing import CueTiming
from bristle_sim.theory.cueing import released_motion

POINTS = 400  # instants of the formula's curve


@styled()
def cue_figure(timing: CueTiming) -> Figure:
    """Draw retraction and relative speed over time with their cue times, and the bars' places to scale (mm).

    Args:
        timing: a release from rest, up to the highest relative speed, with the places that were computed from it.

    Raises:
        ValueError: if the trajectory lasts no time.
    """
    figure = blank_figure(16.0, 12.6)
    retraction = add_panel(figure, (1.5, 7.1, 5.8, 4.3), "released from rest: retraction")
    below = "up to the cue time, at which it is highest"
    speed = add_panel(figure, (1.5, 1.2, 5.8, 4.4), "released from rest: relative speed", below, sharex=retraction)
    _draw_motion(retraction, speed, timing)
    _draw_plan(add_panel(figure, (8.6, 5.2, 7.2, 6.2), "where the bar must stand", "to scale; grey: as given"), timing)
    _draw_table(axes_at(figure, 7.9, 0.6, 7.9, 3.4), timing)
    return figure


def _draw_motion(retraction: Axes, speed: Axes, timing: CueTiming) -> None:
    course = timing.trajectory.course()
    lines = [("simulated", BLUE, "-", (course.time, course.retraction, course.relative_rate))]
    if timing.formula is not None:
        instants = np.linspace(0.0, timing.formula.cue_time, POINTS)
        formula = (instants, *released_motion(timing.tool, timing.retraction, instants))
        lines.append(("quasi-static formula", VERMILION, "--", formula))
    latest = max(float(time[-1]) for *_, (time, *_) in lines)
    for name, color, style, (instants, angle, rate) in lines:
        time, cued, highest = instants * MILLISECONDS, float(instants[-1]) * MILLISECONDS, float(rate[-1])
        for axes, values in ((retraction, np.degrees(angle)), (speed, rate)):
            axes.plot(time, values, color=color, linestyle=style, label=name)
            axes.axvline(cued, color=color, linewidth=0.8, linestyle=":")
        speed.plot([cued], [highest], "o", color=color, markersize=3.5)
        # The earlier cue is named on its left, the later on its right.
        side, ha = (4.0, "left") if instants[-1] == latest else (-4.0, "right")
        words = f"cue time\n{cued:.4g} ms,\n{highest:.1f} rad/s"
        note(speed, words, (cued, 0.0), (side, 4.0), color=color, ha=ha, va="bottom")
    retraction.set_xlim(0.0, 1.38 * latest * MILLISECONDS)
    retraction.legend(loc="lower left", bbox_to_anchor=(-0.04, 0.98), ncols=2, columnspacing=1.2)
    retraction.axhline(0.0, color=GREY, linewidth=0.6)
    retraction.set_ylabel("retraction (°)")
    retraction.tick_params(labelbottom=False)
    speed.set(xlabel="time since release (ms)", ylabel="relative speed (rad/s)")
    speed.set_ylim(bottom=0.0)


def _draw_plan(axes: Axes, timing: CueTiming) -> None:
    tool, (released, fastest), given = replace(timing.tool, bar=None), timing.wires, timing.bar
    cues = {"bar, simulated": (timing.simulated, BLUE, "-"), "bar, formula": (timing.formula, VERMILION, "--")}
    bars: list[tuple[str, tuple[float, float], dict[str, Any]]] = [("bar as given", given.centre, {})]
    for name, (cue, color, style) in cues.items():
        look: dict[str, Any] = {"edgecolor": color, "linewidth": 1.3, "zorder": 5, "fill": False, "linestyle": style}
        if cue is not None:
            bars.append((name, (-cue.bar_horizontal, -cue.bar_vertical), look))  # on the incoming side, m
    corners = given.radius * np.array([[-1.0, -1.0], [1.0, 1.0]])
    surface = np.array([[0.4 * tool.hub.radius, 0.0], [0.0, -1.06 * tool.workpart_depth]])
    points = [*(np.array(centre) + corners for _, centre, _ in bars), released, fastest, surface]
    view = View.around([MILLIMETRES * each for each in points], 7.2 / 6.2, 0.06)
    axes.grid(visible=False)
    draw_tool(axes, tool, view)
    for name, centre, own in bars:
        draw_bar(axes, *centre, given.radius, gid=name, **own)
    view.apply(axes)
    name_parts(axes, tool, 7.0)
    names = (("released", GREY, (0.0, 4.0), "right", "bottom"), ("fastest", BLACK, (6.0, -2.0), "left", "top"))
    for line, (name, color, offset, ha, va) in zip((released, fastest), names, strict=True):
        drawing = WireDrawing(axes, tool, color=color)
        drawing.place(line)
        drawing.wire.set_gid(f"wire {name}")
        x, y = (0.65 * line[0] + 0.35 * line[-1]) * MILLIMETRES  # the bars are about the tips
        note(axes, name, (float(x), float(y)), offset, color=color, ha=ha, va=va)
    axes.set_xlabel("x (mm)", labelpad=1.0)
    axes.set_ylabel("y (mm)", labelpad=1.0)


def _draw_table(axes: Axes, timing: CueTiming) -> None:
    """List where each belt stiffness needs the bar, and the lag at the strike of whole passes with the bar there and as given."""
    axes.set_axis_off()
    lines = []
    for name, each in timing.readings.items():
        cues = [f"{math.degrees(cue.bar_direction):.2f}°" if cue else "none" for cue in (each.simulated, each.formula)]
        lags = [None, *(row["lag_deg_at_contact"] for row in each.passes)][-2:]
        strikes = ["no strike" if lag is None else f"{signed(lag, 2)}°" for lag in lags]
        lines.append([f"{name}: {1e3 * each.tool.belt.stiffness:.3g}", *cues, *strikes])
    given = f"{timing.passes[-1]['bar_direction_deg']:.2f}°"
    bars = ("bar,\nsimulated", "bar,\nformula", "lag with\nbar there", f"lag with\nbar at {given}")
    heads, widths = ("belt stiffness\n(mN·m/rad)", *bars), (0.29, 0.17, 0.15, 0.17, 0.22)
    table = axes.table(lines, colLabels=heads, colWidths=widths, edges="open", loc="center")
    table.auto_set_font_size(False)
    table.set_fontsize(7.0)
    table.scale(1.0, 1.5)
    for column, color in ((1, BLUE), (2, VERMILION)):
        table[0, column].get_text().set_color(color)
    words = "bars from the workpart's normal;\nlags at the strikes of full passes"
    note(axes, words, (0.0, 0.0), (-12.0, 2.0), va="top")
