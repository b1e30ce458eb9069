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
    draw_zero,
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
    axes = add_panel(
        figure,
        (1.3, 1.2, 14.2, 5.4),
        title,
        xlabel="time since first touch (µs)",
        ylabel="force on the tip (N)",
    )
    end = curve.duration
    if measured is not None:
        dots = "." if measured.time.size <= MOST_DOTS else "-"
        time = MICROSECONDS * measured.time
        axes.plot(
            time, measured.force, dots, color=GREY, markersize=3, linewidth=0.6, label="measured"
        )
        end = min(float(measured.time[-1]), (1.0 + BESIDE) * end)
    time = np.linspace(0.0, curve.duration, 301)
    label = f"{'fit' if measured else 'chapter 3'}: at most {curve.peak_force():.1f} N"
    axes.plot(MICROSECONDS * time, curve(time), color=BLUE, label=label)
    if contact is not None:
        time = np.linspace(0.0, float(contact.time[-1]), 1001)
        label = f"simulated: at most {contact.peak_force:.1f} N"
        axes.plot(MICROSECONDS * time, contact.resultant(time), color=VERMILION, label=label)
        look: Look = {"color": VERMILION, "linewidth": 0.8}
        for name, dashes in {"normal": (4, 2), "tangential": (1, 1.5)}.items():
            force = getattr(contact.history, f"{name}_force")
            axes.plot(MICROSECONDS * contact.time, force, dashes=dashes, label=name, **look)
        end = max(end, float(contact.time[-1]))
    axes.margins(y=0.1)
    draw_zero(axes)
    first = 0.0 if measured is None else max(float(measured.time[0]), -BESIDE * curve.duration)
    axes.set_xlim(MICROSECONDS * first, MICROSECONDS * end)
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
    title = "one bristle in a turn, on the workpart"
    _draw_turn(add_panel(figure, (1.5, 8.4, 12.8, 3.4), title), whole)
    title = f"{whole.assembly.bristles:g} bristles behind a load cell of {whole.assembly.bandwidth:g} Hz"
    place = (1.5, 1.2, 12.8, 4.7)
    axes = add_panel(figure, place, title, xlabel="time (ms)", ylabel="normal force (N)")
    series = load_cell_series(whole)
    force = series["normal_force (N)"]
    passes = whole.period * np.arange(PASSES)[:, np.newaxis]
    time = MILLISECONDS * (passes + series["time (s)"]).ravel()
    low, high = np.percentile(force, BAND)
    levels = {"5 %": low, "mean": force.mean(), "95 %": high}
    axes.axhspan(low, high, color=SKY, alpha=0.35, linewidth=0.0)
    axes.plot(time, np.tile(force, PASSES), color=BLUE)
    axes.axhline(levels["mean"], color=BLACK, linewidth=0.8)
    words = [f"{name}:\n{level:.2f} N" for name, level in levels.items()]
    axes.secondary_yaxis("right").set_yticks(list(levels.values()), words)
    axes.set_xlim(0.0, MILLISECONDS * PASSES * whole.period)
    axes.margins(y=0.15)
    return figure


def _draw_turn(axes: Axes, whole: WholeTool) -> None:
    """Draw sustained forces of a bristle on the workpart, and impulses on the right scale."""
    turned = np.degrees(whole.tool.hub.speed)
    pushes = [each for each in whole.forces[-1] if each.obstacle == "workpart"]
    brief = [(turned * each.edges[0], 1e3 * each.integral[0]) for each in pushes if not each.course]
    for each in pushes:
        if each.course:
            time = np.linspace(each.edges[0], each.edges[-1], 200)
            force = each.course(time)
            axes.fill_between(turned * time, force, facecolor=SKY, edgecolor=BLUE)
    impulses = add_right_scale(axes)
    angles, sizes = np.reshape(brief, (-1, 2)).T
    impulses.vlines(angles, 0.0, sizes, color=VERMILION, linewidth=1.4)
    impulses.set_ylabel("impulse (mN·s)", color=VERMILION)
    axes.set_ylabel("sustained force (N)", color=BLUE)
    axes.set_xlabel("turn of the hub (°)")
    for scale, count in ((axes, len(pushes) - len(brief)), (impulses, len(brief))):
        scale.margins(y=0.15)
        scale.set_ylim(bottom=0.0)
        scale.yaxis.set_visible(count > 0)
    draw_zero(axes)
    axes.set(xlim=(0.0, 360.0), xticks=np.linspace(0.0, 360.0, 13))
