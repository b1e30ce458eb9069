"""Draw chapter 3: the assumed force over time, and a simulated contact's."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLUE, GREY, VERMILION
from bristle_sim.render.style import MICROSECONDS, add_panel, blank_figure, note, styled
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.force_comparison import ForceComparison
from bristle_sim.theory.force_history import BRISTLE

MOST_DOTS = 400
"""Points drawn one by one: between the samples of an oscilloscope there is nothing to see, a line stands for more."""

MARGIN = 0.25  # part of the contact's duration shown before its start and after its end, where a file holds them


@styled()
def force_figure(comparison: ForceComparison) -> Figure:
    """Draw forces over time (us)."""
    figure = blank_figure(16.0, 7.9)
    name = "force of chapter 3" if comparison.curve is BRISTLE else "fit to the measured force"
    simulated = ", and a bristle's contact of the same impulse and compression time"
    title = name + (simulated if comparison.contact else ", without a simulated contact")
    _draw_forces(add_panel(figure, (1.3, 1.2, 14.2, 5.4), title), comparison)
    return figure


def _draw_forces(axes: Axes, comparison: ForceComparison) -> None:
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
    shown = np.linspace(0.0, float(contact.time[-1]), 1001)
    axes.plot(
        MICROSECONDS * shown, contact.resultant(shown), color=VERMILION, label="simulated: resultant", gid="simulated"
    )
    history, thin = contact.history, dict[str, Any](color=VERMILION, linewidth=0.8)
    axes.plot(MICROSECONDS * contact.time, history.normal_force, dashes=(4, 2), label="normal", **thin)
    axes.plot(MICROSECONDS * contact.time, history.tangential_force, dashes=(1, 1.5), label="tangential", **thin)
