"""Draw chapter 3 on one page: the assumed force and a simulated contact's, the ten segments, and the fit's trial."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, LIGHT, VERMILION
from bristle_sim.render.panels import add_panel, note
from bristle_sim.render.style import MICROSECONDS, blank_figure, styled
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.force_comparison import SEGMENTS, ForceComparison, segment_table
from bristle_sim.theory.force_history import BRISTLE, TABLE_3_1, segment_impulses

MOST_DOTS = 400
"""Points drawn one by one: between the samples of an oscilloscope there is nothing to see, a line stands for more."""

MARGIN = 0.25
"""Part of the contact's duration shown before its start and after its end, where a file holds them."""


@styled()
def force_figure(comparison: ForceComparison) -> Figure:
    """Draw forces over time (us), impulses of the ten segments, and points with their fit."""
    figure = blank_figure(16.0, 14.4)
    name = "force of chapter 3" if comparison.curve is BRISTLE else "fit to the measured force"
    simulated = ", and a bristle's contact of the same impulse and compression time"
    title = name + (simulated if comparison.contact else ", without a simulated contact")
    _draw_forces(add_panel(figure, (1.3, 7.9, 14.2, 5.4), title), comparison)
    _draw_segments(add_panel(figure, (1.3, 1.1, 6.3, 4.5), "impulse of each tenth of the compression"), comparison)
    _draw_fit(add_panel(figure, (9.2, 1.1, 6.3, 4.5), "the fit, tried on points of the curve"), comparison)
    return figure


def _draw_forces(axes: Axes, comparison: ForceComparison) -> None:
    """Draw force over time: curve, simulated resultant and its components, and the compression's ten segments."""
    curve, measured, contact = comparison.curve, comparison.measured, comparison.contact
    time = np.linspace(0.0, curve.duration, 301)
    first, longest = 0.0, curve.duration
    if measured is not None:
        look: dict[str, Any] = {"color": GREY, "markersize": 3, "linewidth": 0.6, "label": "measured"}
        style = "." if measured.time.size <= MOST_DOTS else "-"
        axes.plot(MICROSECONDS * measured.time, measured.force, style, gid="measured", **look)
        first = max(float(measured.time[0]), -MARGIN * curve.duration)
        longest = min(float(measured.time[-1]), (1.0 + MARGIN) * curve.duration)
    axes.plot(MICROSECONDS * time, curve(time), color=BLUE, label="fit" if measured else "curve", gid="curve")
    peaks = [(curve.peak_time(), curve.peak_force(), BLUE)]
    if contact is not None:
        _draw_contact(axes, contact)
        longest = max(longest, float(contact.time[-1]))
        peaks.append((contact.compression_time, contact.peak_force, VERMILION))
    for instant, force, color in peaks:
        axes.plot([MICROSECONDS * instant], [force], "o", color=color, markersize=3.6, zorder=4)
        note(
            axes, f"{force:.1f} N", (MICROSECONDS * instant, force), (0.0, 4.0), color=color, ha="center", fontsize=8.0
        )
    axes.margins(y=0.1)
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set_xlim(MICROSECONDS * first, MICROSECONDS * longest)
    axes.set(xlabel="time since first touch (µs)", ylabel="force on the tip (N)")
    axes.legend(loc="upper right", labelspacing=0.3)


def _draw_contact(axes: Axes, contact: TimedContact) -> None:
    """Draw the simulated force, its components, and the ten segments of its compression."""
    edges = MICROSECONDS * np.linspace(0.0, contact.compression_time, SEGMENTS + 1)
    for low, high in zip(edges[::2], edges[1::2], strict=False):
        axes.axvspan(low, high, color=LIGHT, alpha=0.45, linewidth=0.0, zorder=0)
    middle = (0.5 * float(edges[-1]), 0.015)
    look: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "ha": "center", "va": "bottom"}
    note(axes, "ten segments of the compression", middle, (0.0, 0.0), **look)
    shown, force = contact.smooth_resultant()
    axes.plot(MICROSECONDS * shown, force, color=VERMILION, label="simulated: resultant", gid="simulated")
    history, thin = contact.history, dict[str, Any](color=VERMILION, linewidth=0.8)
    axes.plot(MICROSECONDS * contact.time, history.normal_force, dashes=(4, 2), label="normal", **thin)
    axes.plot(MICROSECONDS * contact.time, history.tangential_force, dashes=(1, 1.5), label="tangential", **thin)


def _draw_segments(axes: Axes, comparison: ForceComparison) -> None:
    """Draw impulses of the ten segments, 1e-4 N s: table 3.1, the curve, and the simulated contact."""
    curve, number = comparison.curve, np.arange(1, SEGMENTS + 1)
    shares = 1e4 * segment_impulses(curve, float(curve.impulse(curve.peak_time())))
    if comparison.contact is not None:
        axes.bar(number, 1e4 * segment_table(comparison.contact), 0.7, color=VERMILION, alpha=0.55, label="simulated")
    axes.plot(number, shares, "o", color=BLUE, markersize=3.6, markerfacecolor="white", label="curve")
    if curve is BRISTLE:
        axes.plot(number, [float(each) for each in TABLE_3_1], "_", color=BLACK, markersize=9, label="table 3.1")
    axes.set(xticks=number, xlabel="segment", ylabel="impulse (0.1 mN·s)")
    axes.grid(visible=False, axis="x")
    axes.legend(loc="upper left", labelspacing=0.3)


def _draw_fit(axes: Axes, comparison: ForceComparison) -> None:
    """Draw the difference of fits to exact and noisy points from the curve of which the points are samples."""
    curve, (exact, noisy) = comparison.curve, comparison.trials
    time = np.linspace(0.0, curve.duration, 301)
    look: dict[str, Any] = {"color": GREY, "markersize": 1.8, "markeredgewidth": 0.0}
    off = noisy.force - curve(noisy.time)
    axes.plot(MICROSECONDS * noisy.time, off, "o", label=f"points, noise {noisy.noise:g} N", **look)
    for trial, color in ((noisy, GREEN), (exact, BLACK)):
        if trial.fit is not None:
            peak = "no peak" if trial.peak_force is None else f"peak {trial.peak_force:.2f} N"
            label = f"fit to {trial.name} points, {peak}"
            axes.plot(MICROSECONDS * time, trial.fit.curve(time) - curve(time), color=color, label=label)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.5 * (high - low))
    axes.set(xlabel="time since first touch (µs)", ylabel="difference from the curve (N)")
    axes.legend(loc="upper center", labelspacing=0.3)
