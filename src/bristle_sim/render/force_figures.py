"""Figures of contact forces over time: a simulated contact, and the whole tool on its workpart."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.readable import MICROSECONDS, MILLISECONDS
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREY,
    SKY,
    VERMILION,
    add_right_scale,
    blank_figure,
    draw_zero,
    styled,
)
from bristle_sim.studies.force_comparison import ForceComparison
from bristle_sim.studies.whole_tool import BAND, WholeTool, load_cell_series
from bristle_sim.theory.force_history import BRISTLE

# Time shown before and after the contact, as a fraction of its duration, if the measured force has
# samples there
BESIDE = 0.25


@styled()
def force_figure(comparison: ForceComparison) -> Figure:
    """Draw the contact force (N) over time (us).

    One curve is the formula of Zhang (2020, chapter 3) or a fit to a measured force. Measured
    points are drawn if they exist. So are the resultant and the components of a simulated force.
    """
    curve = comparison.curve
    measured = comparison.measured
    contact = comparison.contact
    name = "force of chapter 3" if curve is BRISTLE else "fit to the measured force"
    simulated = "and a bristle's contact of the same impulse and compression time"
    figure = blank_figure(16.0, 7.9)
    axes = figure.subplots()
    axes.set_title(f"{name}, {simulated if contact else 'without a simulated contact'}")
    axes.set(xlabel="time since first touch (µs)", ylabel="force on the tip (N)")
    first, end = 0.0, curve.duration
    if measured is not None:
        time = MICROSECONDS * measured.time
        axes.plot(time, measured.force, ".-", color=GREY, ms=2.5, lw=0.4, label="measured")
        beside = BESIDE * curve.duration
        first, end = np.clip(measured.time[[0, -1]], -beside, end + beside)
    time = np.linspace(0.0, curve.duration, 301)
    label = f"{'fit' if measured else 'chapter 3'}: at most {curve.peak_force():.1f} N"
    axes.plot(MICROSECONDS * time, curve(time), color=BLUE, label=label)
    if contact is not None:
        history = contact.history
        time = MICROSECONDS * contact.time
        label = f"simulated: at most {contact.peak_force:.1f} N"
        for force, style, name in (
            (contact.force, "-", label),
            (history.normal_force, "--", "normal"),
            (history.tangential_force, ":", "tangential"),
        ):
            axes.plot(time, force, style, color=VERMILION, label=name)
        end = max(end, float(contact.time[-1]))
    axes.margins(y=0.1)
    draw_zero(axes)
    axes.set_xlim(MICROSECONDS * first, MICROSECONDS * end)
    axes.legend(loc="upper right")
    return figure


PASSES = 12  # number of consecutive passes of bristles in the second panel


@styled()
def whole_tool_figure(whole: WholeTool | None) -> Figure:
    """Draw the normal force of the whole tool on the workpart, and that of one bristle.

    One panel shows the sustained forces (N) and the impulses of the impacts (mN·s) of one bristle
    during a revolution of the hub. The other shows the force (N) of all bristles, as a load cell
    measures it.

    Raises:
        ValueError: if ``whole`` is None, because the bristle completes no revolution.
    """
    if whole is None:
        raise ValueError("whole_tool: the bristle completes no turn, so there is no force to draw")
    figure = blank_figure(16.0, 11.4)
    turn, axes = figure.subplots(2, height_ratios=(2, 3))
    turn.set_title("one bristle on the workpart, in a revolution of the hub")
    _draw_turn(turn, whole)
    assembly = whole.assembly
    axes.set_title(
        f"{assembly.bristles:g} bristles behind a load cell of {assembly.bandwidth:g} Hz"
    )
    axes.set(xlabel="time (ms)", ylabel="normal force (N)")
    series = load_cell_series(whole)
    force = series["normal_force (N)"]
    passes = whole.period * np.arange(PASSES)[:, np.newaxis]
    time = MILLISECONDS * (passes + series["time (s)"]).ravel()
    low, high = np.percentile(force, BAND)
    mean = force.mean()
    axes.axhspan(
        low, high, color=SKY, alpha=0.35, lw=0.0, label=f"5 to 95 %: {low:.2f} to {high:.2f} N"
    )
    axes.axhline(mean, color=BLACK, linewidth=0.8, label=f"mean: {mean:.2f} N")
    axes.plot(time, np.tile(force, PASSES), color=BLUE, label="force")
    axes.set_xlim(0.0, MILLISECONDS * PASSES * whole.period)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _draw_turn(axes: Axes, whole: WholeTool) -> None:
    """Draw sustained forces of one bristle on the workpart, and impulses of its impacts.

    The impulses have a scale on the right. The horizontal axis is the hub's angle of rotation.
    """
    turned = np.degrees(whole.tool.hub.speed)
    impulses = add_right_scale(axes)
    for scale in (axes, impulses):
        scale.yaxis.set_visible(False)
    for each in whole.forces[-1]:
        if each.obstacle != "workpart":
            continue
        if each.course:
            time = np.linspace(each.edges[0], each.edges[-1], 200)
            axes.fill_between(turned * time, each.course(time), facecolor=SKY, edgecolor=BLUE)
            axes.yaxis.set_visible(True)
        else:
            impulses.vlines(turned * each.edges[0], 0.0, 1e3 * each.integral[0], color=VERMILION)
            impulses.yaxis.set_visible(True)
    impulses.set_ylim(bottom=0.0)
    impulses.set_ylabel("impulse (mN·s)", color=VERMILION)
    draw_zero(axes)
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("sustained force (N)", color=BLUE)
    axes.set(xlabel="angle of rotation of the hub (°)", xlim=(0.0, 360.0), xticks=range(0, 361, 30))
