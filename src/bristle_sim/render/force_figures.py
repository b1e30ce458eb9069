"""Figures of contact forces over time: a simulated contact, and the whole tool on its workpart."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREY, SKY, VERMILION
from bristle_sim.render.style import (
    MICROSECONDS,
    MILLISECONDS,
    Look,
    add_panel,
    add_right_scale,
    blank_figure,
    note,
    styled,
)
from bristle_sim.studies.force_comparison import ForceComparison
from bristle_sim.studies.whole_tool import BAND, WholeTool, load_cell_series
from bristle_sim.theory.force_history import BRISTLE

MOST_DOTS = 400  # largest number of points drawn as dots; more points are drawn as a line
# Time shown before and after the contact, as a fraction of its duration, where the file has
# samples.
BESIDE = 0.25


@styled()
def force_figure(comparison: ForceComparison) -> Figure:
    """Draw contact force over time (us): chapter 3's curve, measured points, simulated force.

    The simulated force is shown as the resultant and its components.
    """
    curve = comparison.curve
    measured = comparison.measured
    contact = comparison.contact
    name = "force of chapter 3" if curve is BRISTLE else "fit to the measured force"
    simulated = "and a bristle's contact of the same impulse and compression time"
    title = f"{name}, {simulated if contact else 'without a simulated contact'}"
    figure = blank_figure(16.0, 7.9)
    axes = add_panel(figure, (1.3, 1.2, 14.2, 5.4), title)
    time = np.linspace(0.0, curve.duration, 301)
    first = 0.0
    longest = curve.duration
    peaks = [(curve.peak_time(), curve.peak_force(), BLUE)]
    if measured is not None:
        dots = "." if measured.time.size <= MOST_DOTS else "-"
        axes.plot(
            MICROSECONDS * measured.time,
            measured.force,
            dots,
            color=GREY,
            markersize=3,
            linewidth=0.6,
            label="measured",
        )
        first = max(float(measured.time[0]), -BESIDE * curve.duration)
        longest = min(float(measured.time[-1]), (1.0 + BESIDE) * curve.duration)
    axes.plot(
        MICROSECONDS * time, curve(time), color=BLUE, label="fit" if measured else "chapter 3"
    )
    if contact is not None:
        shown = np.linspace(0.0, float(contact.time[-1]), 1001)
        history = contact.history
        axes.plot(
            MICROSECONDS * shown,
            contact.resultant(shown),
            color=VERMILION,
            label="simulated: resultant",
        )
        for name, force, dashes in (
            ("normal", history.normal_force, (4, 2)),
            ("tangential", history.tangential_force, (1, 1.5)),
        ):
            look: Look = {"color": VERMILION, "linewidth": 0.8, "dashes": dashes}
            axes.plot(MICROSECONDS * contact.time, force, label=name, **look)
        longest = max(longest, float(contact.time[-1]))
        peaks.append((contact.compression_time, contact.peak_force, VERMILION))
    for instant, peak, color in peaks:
        place = (MICROSECONDS * instant, peak)
        axes.plot(*place, "o", color=color, markersize=3.6, zorder=4)
        note(axes, f"{peak:.1f} N", place, (0.0, 4.0), color=color, ha="center", fontsize=8.0)
    axes.margins(y=0.1)
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set(xlabel="time since first touch (µs)", ylabel="force on the tip (N)")
    axes.set_xlim(MICROSECONDS * first, MICROSECONDS * longest)
    axes.legend(loc="upper right", labelspacing=0.3)
    return figure


PASSES = 12  # number of bristles that pass in the second panel


@styled()
def whole_tool_figure(whole: WholeTool | None) -> Figure:
    """Draw the normal forces of the tool on the workpart, N, and the impulses of its impacts, mN·s.

    Raises:
        ValueError: if ``whole`` is None, since the bristle completes no turn.
    """
    if whole is None:
        raise ValueError("whole_tool: the bristle completes no turn, there is nothing to draw")
    figure = blank_figure(16.0, 12.8)
    _one_bristle(
        add_panel(figure, (1.5, 8.4, 12.8, 3.4), "one bristle in a turn, on the workpart"), whole
    )
    title = f"{whole.assembly.bristles:g} bristles behind a load cell of {whole.assembly.bandwidth:g} Hz"
    labels = {"xlabel": "time (ms)", "ylabel": "normal force (N)"}
    axes = add_panel(figure, (1.5, 1.2, 12.8, 4.7), title, **labels)
    series = load_cell_series(whole)
    force = series["normal_force (N)"]
    end = MILLISECONDS * PASSES * whole.period
    time = np.concatenate([series["time (s)"] + number * whole.period for number in range(PASSES)])
    low, high = np.percentile(force, BAND)
    axes.axhspan(low, high, color=SKY, alpha=0.35, linewidth=0.0)
    axes.plot(MILLISECONDS * time, np.tile(force, PASSES), color=BLUE)
    axes.axhline(force.mean(), color=BLACK, linewidth=0.8)
    for level, name in ((high, "95 %"), (float(force.mean()), "mean"), (low, "5 %")):
        note(axes, f"{name}:\n{level:.2f} N", (end, level), (3.0, 0.0), ha="left", va="center")
    axes.set_xlim(0.0, end)
    axes.margins(y=0.15)
    return figure


def _one_bristle(axes: Axes, whole: WholeTool) -> None:
    turned = np.degrees(whole.tool.hub.speed)
    impulses = add_right_scale(axes)
    for each in (each for each in whole.forces[-1] if each.obstacle == "workpart"):
        if each.course:
            time = np.linspace(each.begin, each.end, 200)
            force = each.course(time)
            angle = turned * time
            axes.fill_between(angle, force, color=SKY, linewidth=0.0)
            axes.plot([angle[0], *angle], [0.0, *force], color=BLUE)
        else:
            angle = 2 * [turned * each.begin]
            impulses.plot(angle, [0.0, 1e3 * each.integral[0]], color=VERMILION, linewidth=1.4)
    for scale, label, color in (
        (axes, "sustained force (N)", BLUE),
        (impulses, "impulse (mN·s)", VERMILION),
    ):
        scale.set_ylabel(label, color=color)
        scale.set_ylim(0.0, 1.15 * max(scale.get_ylim()[1], 1e-9))
        scale.yaxis.set_visible(bool(scale.lines))
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    axes.set(xlabel="turn of the hub (°)", xlim=(0.0, 360.0), xticks=np.linspace(0.0, 360.0, 13))
