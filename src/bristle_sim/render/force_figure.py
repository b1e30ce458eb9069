"""Draw chapter 3 on one page: the assumed force and a simulated contact's, the ten segments, and the fit's trial."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.panels import note, panel_title
from bristle_sim.render.style import BLACK, BLUE, GREY, LIGHT, SERIES, VERMILION, axes_at, blank_figure, styled
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.force_comparison import SEGMENTS, ForceComparison, segment_table
from bristle_sim.studies.force_fits import FitTrial
from bristle_sim.theory.force_history import BRISTLE, TABLE_3_1, segment_impulses

WIDTH, HEIGHT = 16.0, 14.4
"""Printed size, cm."""

MICRO = 1e6

MOST_DOTS = 400
"""Points drawn one by one."""

MARGIN = 0.25
"""Part of the contact's duration shown before its start and after its end, where a file holds them."""


@styled()
def force_figure(comparison: ForceComparison) -> Figure:
    """Draw forces over time (us), impulses of the ten segments, and points with their fit."""
    figure = blank_figure(WIDTH, HEIGHT)
    forces = axes_at(figure, 1.3, 7.9, 14.2, 5.4)
    segments = axes_at(figure, 1.3, 1.1, 6.3, 4.5)
    fit = axes_at(figure, 9.2, 1.1, 6.3, 4.5)
    name = "force of chapter 3" if comparison.curve is BRISTLE else "fit to the measured force"
    simulated = "a bristle's contact" if comparison.contact else "no contact of a bristle"
    panel_title(forces, "a", f"{name}, and {simulated} of the same impulse and compression time")
    draw_forces(forces, comparison)
    panel_title(segments, "b", "impulse of each tenth of the compression")
    draw_segments(segments, comparison)
    panel_title(fit, "c", "the fit, tried on points of the curve")
    _draw_fit(fit, comparison)
    return figure


def draw_forces(axes: Axes, comparison: ForceComparison) -> None:
    """Draw force over time: curve, simulated resultant and its components, and the compression's ten segments."""
    curve = comparison.curve
    time = np.linspace(0.0, curve.duration, 301)
    first, longest = 0.0, curve.duration
    measured = comparison.measured
    if measured is not None:
        # Between the samples of an oscilloscope there is nothing to see: a line stands for more than a few hundred.
        style = "." if measured.time.size <= MOST_DOTS else "-"
        look: dict[str, Any] = {
            "color": GREY,
            "markersize": 3,
            "linewidth": 0.6,
            "label": "measured",
            "gid": "measured",
        }
        axes.plot(MICRO * measured.time, measured.force, style, **look)
        first = max(float(measured.time[0]), -MARGIN * curve.duration)
        longest = min(float(measured.time[-1]), (1.0 + MARGIN) * curve.duration)
    axes.plot(MICRO * time, curve(time), color=BLUE, label="fit" if measured else "curve", gid="curve")
    _mark_peak(axes, MICRO * curve.peak_time(), curve.peak_force(), BLUE)
    if comparison.contact is not None:
        _draw_contact(axes, comparison.contact)
        longest = max(longest, float(comparison.contact.time[-1]))
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set_xlim(MICRO * first, MICRO * longest)
    axes.set_xlabel("time since first touch (µs)")
    axes.set_ylabel("force on the tip (N)")
    axes.legend(loc="upper right", labelspacing=0.3)


def _draw_contact(axes: Axes, contact: TimedContact) -> None:
    _shade_segments(axes, contact.compression_time)
    shown, force = contact.smooth_resultant()
    axes.plot(MICRO * shown, force, color=VERMILION, label="simulated: resultant", gid="simulated")
    parts = (
        (contact.history.normal_force, "normal", (4, 2)),
        (contact.history.tangential_force, "tangential", (1, 1.5)),
    )
    for values, name, dashes in parts:
        axes.plot(MICRO * contact.time, values, color=VERMILION, linewidth=0.8, dashes=dashes, label=name)
    _mark_peak(axes, MICRO * contact.compression_time, contact.peak_force, VERMILION)


def _shade_segments(axes: Axes, compression_time: float) -> None:
    edges = MICRO * np.linspace(0.0, compression_time, SEGMENTS + 1)
    for low, high in zip(edges[::2], edges[1::2], strict=False):
        axes.axvspan(low, high, color=LIGHT, alpha=0.45, linewidth=0.0, zorder=0)
    words, middle = "ten segments of the compression", (0.5 * float(edges[-1]), 0.015)
    note(axes, words, middle, (0.0, 0.0), xycoords=("data", "axes fraction"), ha="center", va="bottom")


def _mark_peak(axes: Axes, time: float, force: float, color: str) -> None:
    axes.plot([time], [force], "o", color=color, markersize=3.6, zorder=4)
    note(axes, f"{force:.1f} N", (time, force), (0.0, 4.0), color=color, ha="center", fontsize=8.0)
    axes.margins(y=0.1)


def draw_segments(axes: Axes, comparison: ForceComparison) -> None:
    """Draw impulses of the ten segments, 1e-4 N s: table 3.1, the curve, and the simulated contact."""
    curve = comparison.curve
    number = np.arange(1, SEGMENTS + 1)
    shares = 1e4 * segment_impulses(curve, float(curve.impulse(curve.peak_time())))
    if comparison.contact is not None:
        axes.bar(number, 1e4 * segment_table(comparison.contact), 0.7, color=VERMILION, alpha=0.55, label="simulated")
    axes.plot(number, shares, "o", color=BLUE, markersize=3.6, markerfacecolor="white", label="curve")
    if curve is BRISTLE:
        axes.plot(number, [float(each) for each in TABLE_3_1], "_", color=BLACK, markersize=9, label="table 3.1")
    axes.set_xticks(number)
    axes.set_xlabel("segment")
    axes.set_ylabel("impulse (0.1 mN·s)")
    axes.grid(visible=False, axis="x")
    axes.legend(loc="upper left", labelspacing=0.3)


def _draw_fit(axes: Axes, comparison: ForceComparison) -> None:
    """Draw the difference of fits to exact and noisy points from the curve of which the points are samples."""
    curve, (exact, noisy) = comparison.curve, comparison.trials
    time = np.linspace(0.0, curve.duration, 301)
    look: dict[str, Any] = {"color": GREY, "markersize": 1.8, "markeredgewidth": 0.0}
    axes.plot(
        MICRO * noisy.time, noisy.force - curve(noisy.time), "o", label=f"points, noise {noisy.noise:g} N", **look
    )
    for trial, color in ((noisy, SERIES[2]), (exact, BLACK)):
        if trial.fit is not None:
            axes.plot(MICRO * time, trial.fit.curve(time) - curve(time), color=color, label=_name(trial))
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.5 * (high - low))
    axes.set_xlabel("time since first touch (µs)")
    axes.set_ylabel("difference from the curve (N)")
    axes.legend(loc="upper center", labelspacing=0.3)


def _name(trial: FitTrial) -> str:
    peak = "no peak" if trial.peak_force is None else f"peak {trial.peak_force:.2f} N"
    return f"fit to {trial.name} points, {peak}"
