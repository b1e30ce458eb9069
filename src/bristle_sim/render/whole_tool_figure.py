"""The whole tool's force: one bristle's in a turn, and all bristles' behind the load cell."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREY, SKY, VERMILION
from bristle_sim.render.style import MILLISECONDS, add_panel, blank_figure, note, styled
from bristle_sim.studies.whole_tool import BAND, WholeTool, load_cell_series

PASSES = 12  # bristles that pass in the second panel


@styled()
def whole_tool_figure(whole: WholeTool | None) -> Figure:
    """Draw normal forces on the workpart in N, and the impulses of impacts in mN s.

    Raises:
        ValueError: for a tool whose bristle completes no turn.
    """
    if whole is None:
        raise ValueError("whole_tool: the bristle completes no turn, there is nothing to draw")
    figure = blank_figure(16.0, 12.8)
    _one_bristle(add_panel(figure, (1.5, 8.4, 12.8, 3.4), "one bristle in a turn, on the workpart"), whole)
    title = f"{whole.assembly.bristles:g} bristles behind a load cell of {whole.assembly.bandwidth:g} Hz"
    labels = {"xlabel": "time (ms)", "ylabel": "normal force (N)"}
    axes, series = add_panel(figure, (1.5, 1.2, 12.8, 4.7), title, **labels), load_cell_series(whole)
    force, end = series["normal_force (N)"], MILLISECONDS * PASSES * whole.period
    time = np.concatenate([series["time (s)"] + number * whole.period for number in range(PASSES)])
    low, high = np.percentile(force, BAND)
    axes.axhspan(low, high, color=SKY, alpha=0.35, linewidth=0.0)
    axes.plot(MILLISECONDS * time, np.tile(force, PASSES), color=BLUE)
    axes.axhline(force.mean(), color=BLACK, linewidth=0.8)
    for level, words in ((high, f"95 %:\n{high:.2f} N"), (low, f"5 %:\n{low:.2f} N")):
        note(axes, words, (end, level), (3.0, 0.0), ha="left", va="center")
    axes.set_xlim(0.0, end)
    axes.margins(y=0.15)
    return figure


def _one_bristle(axes: Axes, whole: WholeTool) -> None:
    turned = np.degrees(whole.tool.hub.speed)
    impulses = axes.twinx()
    impulses.grid(visible=False)
    impulses.spines["right"].set_visible(True)
    for each in (each for each in whole.forces[-1] if each.obstacle == "workpart"):
        if each.course:
            time = np.linspace(each.begin, each.end, 200)
            force, angle = each.course(time)[:, 0], turned * time
            axes.fill_between(angle, force, color=SKY, linewidth=0.0)
            axes.plot([angle[0], *angle], [0.0, *force], color=BLUE)
        else:
            angle = 2 * [turned * each.begin]
            impulses.plot(angle, [0.0, 1e3 * each.integral[0]], color=VERMILION, linewidth=1.4)
    for scale, label, color in ((axes, "sustained force (N)", BLUE), (impulses, "impulse (mN s)", VERMILION)):
        scale.set_ylabel(label, color=color)
        scale.set_ylim(0.0, 1.15 * max(scale.get_ylim()[1], 1e-9))
        scale.yaxis.set_visible(bool(scale.lines))
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    axes.set(xlabel="turn of the hub (°)", xlim=(0.0, 360.0), xticks=np.linspace(0.0, 360.0, 13))
