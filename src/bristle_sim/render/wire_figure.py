"""Draw the effect of bending on a strike: force over time, and ratios to the rigid bristle over contact stiffness and links."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION
from bristle_sim.render.style import MICROSECONDS, add_panel, blank_figure, note, scale_for, styled
from bristle_sim.studies.flexible_wire import FlexibleWire, WireStudy, measures
from bristle_sim.studies.timed_contact import cubics

LOOKS = {
    "normal_final_impulse": ("impulse", BLUE, "o"),
    "peak_force": ("peak force", VERMILION, "s"),
    "time_in_touch": ("duration", GREEN, "^"),
    "crater_depth": ("crater", PURPLE, "D"),
}
"""Name, colour and marker of each measure."""

LINK_COLOURS = (ORANGE, GREEN, BLUE)


@styled()
def wire_figure(struck: FlexibleWire, study: WireStudy) -> Figure:
    """Draw the strike at hand, and the effects of contact stiffness and number of links."""
    figure, size = blank_figure(16.0, 13.6), (6.3, 4.6)
    _draw_force(figure, struck)
    by_links = add_panel(figure, (9.4, 8.1, 6.3, 4.2), "measures over the number of links")
    impulse = add_panel(figure, (1.4, 1.2, *size), "impulse over the contact's duration")
    others = add_panel(figure, (9.4, 1.2, *size), "measures over the contact's duration")
    durations, most = study.durations * MICROSECONDS, max(study.by_duration)
    for name, (words, color, marker) in LOOKS.items():
        look: dict[str, Any] = {"color": color, "marker": marker, "markersize": 3.4, "label": words}
        by_links.plot(study.links, study.by_links[name], **look, linestyle="none")
        others.plot(durations, study.by_duration[most][name], **look)
    for color, (links, found) in zip(LINK_COLOURS[-len(study.by_duration) :], study.by_duration.items(), strict=True):
        ratio = found["normal_final_impulse"]
        impulse.plot(durations, ratio, "o-", color=color, markersize=3.0, label=f"{links} links")
    own = struck.strike.contact.duration * MICROSECONDS
    for axes in (impulse, others):
        axes.set(xscale="log", xlabel="contact of the rigid bristle, $T$ (µs)")
        axes.xaxis.set_major_formatter("{x:g}")
        if axes.get_xlim()[0] < own < axes.get_xlim()[1]:
            axes.axvline(own, color=BLACK, linewidth=0.8, dashes=(2, 2), zorder=1)
            note(axes, "as in a, b", (own, 0.0), (3.0, 5.0), color=BLACK)
    by_links.set(xlabel="number of links", ylabel="wire / rigid bristle")
    impulse.set_ylabel("impulse, wire / rigid bristle")
    others.set_ylabel(f"wire of {most} links / rigid bristle")
    by_links.xaxis.set_major_locator(MaxNLocator(integer=True))
    for axes in (by_links, impulse, others):
        axes.axhline(1.0, color=GREY, linewidth=0.8, dashes=(4, 2), zorder=1)
        axes.set_ylim(bottom=0.0)
        place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (-0.05, 0.985), "ncols": 4}
        axes.legend(**place, handlelength=1.0, handletextpad=0.4, columnspacing=0.8)
    return figure


def _draw_force(figure: Figure, struck: FlexibleWire) -> Axes:
    rigid, own = (measures(struck.strike, each.contact) for each in (struck.rigid, struck.wire))
    times = rigid["peak_force"] / own["peak_force"]
    axes = add_panel(figure, (1.4, 8.1, 6.3, 4.2), f"the rigid bristle pushes {times:.2g} times as hard")
    clock = scale_for(max(rigid["time_in_touch"], own["time_in_touch"]), "s")
    names = ("rigid bristle", f"wire of {struck.strike.tool.bristle.links} links")
    for run, color, name, values in zip((struck.rigid, struck.wire), (GREY, BLUE), names, (rigid, own), strict=True):
        history = run.contact.history
        assert history is not None
        shown = scale_for(values["normal_final_impulse"], "N s")
        label = f"{name}, {values['normal_final_impulse'] * shown.factor:.3g} {shown.unit}"
        time = (history.time - history.time[0]) * clock.factor
        force = cubics(time, history.normal_force)(shown_time := np.linspace(0.0, time[-1], 300))
        axes.fill_between(shown_time, force, color=color, alpha=0.12, linewidth=0.0)
        axes.plot(shown_time, force, color=color, label=label)
    axes.set(xlabel=f"time since the first touch ({clock.unit})", ylabel="normal force (N)")
    axes.set_xlim(left=0.0)
    axes.set_ylim(0.0, 1.3 * max(rigid["peak_force"], own["peak_force"]))
    axes.legend(loc="upper right", labelspacing=0.3)
    return axes
