"""Draw chapter 3: the assumed force over time, and a simulated contact's."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLUE, GREY, VERMILION
from bristle_sim.render.style import MICROSECONDS, add_panel, blank_figure, note, styled
from bristle_sim.studies.force_comparison import ForceComparison
from bristle_sim.theory.force_history import BRISTLE

MOST_DOTS = 400  # points drawn one by one; a line stands for more, between which there is nothing to see
BESIDE = 0.25  # part of the contact's duration shown before its start and after its end, where a file holds them


@styled()
def force_figure(comparison: ForceComparison) -> Figure:
    """Draw force over time (us): curve, measured points, simulated resultant and its components."""
    curve, measured, contact = comparison.curve, comparison.measured, comparison.contact
    name = "force of chapter 3" if curve is BRISTLE else "fit to the measured force"
    simulated = "and a bristle's contact of the same impulse and compression time"
    title = f"{name}, {simulated if contact else 'without a simulated contact'}"
    figure = blank_figure(16.0, 7.9)
    axes = add_panel(figure, (1.3, 1.2, 14.2, 5.4), title)
    time, first, longest = np.linspace(0.0, curve.duration, 301), 0.0, curve.duration
    peaks = [(curve.peak_time(), curve.peak_force(), BLUE)]
    if measured is not None:
        look: dict[str, Any] = {"color": GREY, "markersize": 3, "linewidth": 0.6, "label": "measured"}
        axes.plot(MICROSECONDS * measured.time, measured.force, "." if measured.time.size <= MOST_DOTS else "-", **look)
        first = max(float(measured.time[0]), -BESIDE * curve.duration)
        longest = min(float(measured.time[-1]), (1.0 + BESIDE) * curve.duration)
    axes.plot(MICROSECONDS * time, curve(time), color=BLUE, label="fit" if measured else "chapter 3")
    if contact is not None:
        shown, history = np.linspace(0.0, float(contact.time[-1]), 1001), contact.history
        axes.plot(MICROSECONDS * shown, contact.resultant(shown), color=VERMILION, label="simulated: resultant")
        dashed: dict[str, Any] = {"color": VERMILION, "linewidth": 0.8}
        axes.plot(MICROSECONDS * contact.time, history.normal_force, dashes=(4, 2), label="normal", **dashed)
        axes.plot(MICROSECONDS * contact.time, history.tangential_force, dashes=(1, 1.5), label="tangential", **dashed)
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
