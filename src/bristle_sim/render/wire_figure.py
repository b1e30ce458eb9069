"""Draw what bending does to a strike: force over time, and ratios to the rigid bristle over contact stiffness and links."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bristle_sim.render.panels import note, panel_title
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    VERMILION,
    axes_at,
    blank_figure,
    scale_for,
    styled,
)
from bristle_sim.studies.flexible_wire import FlexibleWire, WireStudy, measures

WIDTH, HEIGHT = 16.0, 13.6
"""Printed size, cm."""

LOOKS = {
    "normal_final_impulse": ("impulse", BLUE, "o"),
    "peak_force": ("peak force", VERMILION, "s"),
    "time_in_touch": ("duration", GREEN, "^"),
    "crater_depth": ("crater", PURPLE, "D"),
}
"""Name, colour and marker of each measure."""

LINK_COLOURS = (ORANGE, GREEN, BLUE)

MICROSECONDS = 1e6


@styled()
def wire_figure(struck: FlexibleWire, study: WireStudy) -> Figure:
    """Draw the strike at hand, and what contact stiffness and number of links change."""
    figure = blank_figure(WIDTH, HEIGHT)
    _draw_force(axes_at(figure, 1.4, 8.1, 6.3, 4.2), struck)
    by_links = axes_at(figure, 9.4, 8.1, 6.3, 4.2)
    impulse, others = (axes_at(figure, left, 1.2, 6.3, 4.6) for left in (1.4, 9.4))
    panel_title(by_links, "b", "the strike settles with more links")
    for name, (words, color, marker) in LOOKS.items():
        look: dict[str, Any] = {"color": color, "marker": marker, "markersize": 3.4, "label": words}
        by_links.plot(study.links, study.by_links[name], **look)
        others.plot(study.durations * MICROSECONDS, study.by_duration[max(study.by_duration)][name], **look)
    panel_title(impulse, "c", "a stiff contact feels less of the wire")
    for color, (links, found) in zip(LINK_COLOURS[-len(study.by_duration) :], study.by_duration.items(), strict=True):
        shown = study.durations * MICROSECONDS, found["normal_final_impulse"]
        impulse.plot(*shown, "o-", color=color, markersize=3.0, label=f"{links} links")
    panel_title(others, "d", "a soft contact takes the wire for rigid")
    for axes in (impulse, others):
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.set_xlabel("contact of the rigid bristle, $T$ (µs)")
        _mark_duration(axes, struck)
    for axes in (by_links, impulse, others):
        axes.axhline(1.0, color=GREY, linewidth=0.8, dashes=(4, 2), zorder=1)
        axes.set_ylim(bottom=0.0)
    by_links.set_ylabel("wire / rigid bristle")
    impulse.set_ylabel("impulse, wire / rigid bristle")
    others.set_ylabel(f"wire of {max(study.by_duration)} links / rigid bristle")
    by_links.set_xlabel("number of links")
    by_links.xaxis.set_major_locator(MaxNLocator(integer=True))
    for axes in (by_links, impulse, others):
        place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (-0.05, 0.985), "ncols": 4}
        axes.legend(**place, handlelength=1.0, handletextpad=0.4, columnspacing=0.8)
    return figure


def _draw_force(axes: Axes, struck: FlexibleWire) -> None:
    """Draw the contact force of the rigid bristle and of the wire."""
    rigid, own = (measures(struck.strike, each.contact) for each in (struck.rigid, struck.wire))
    times = rigid["peak_force"] / own["peak_force"]
    panel_title(axes, "a", f"the rigid bristle pushes {times:.2g} times as hard")
    clock = scale_for(max(rigid["time_in_touch"], own["time_in_touch"]), "s")
    names = ("rigid bristle", f"wire of {struck.strike.tool.bristle.links} links")
    for run, color, name, values in zip((struck.rigid, struck.wire), (GREY, BLUE), names, (rigid, own), strict=True):
        history = run.contact.history
        assert history is not None
        shown = scale_for(values["normal_final_impulse"], "N s")
        label = f"{name}, {values['normal_final_impulse'] * shown.factor:.3g} {shown.unit}"
        time = (history.time - history.time[0]) * clock.factor
        axes.fill_between(time, history.normal_force, color=color, alpha=0.12, linewidth=0.0)
        axes.plot(time, history.normal_force, color=color, label=label)
    axes.set(xlabel=f"time since the first touch ({clock.unit})", ylabel="normal force (N)")
    axes.set_xlim(left=0.0)
    axes.set_ylim(0.0, 1.3 * max(rigid["peak_force"], own["peak_force"]))
    axes.legend(loc="upper right", labelspacing=0.3)


def _mark_duration(axes: Axes, struck: FlexibleWire) -> None:
    """Mark the contact at hand."""
    duration = struck.strike.contact.duration * MICROSECONDS
    low, high = axes.get_xlim()
    if not low < duration < high:
        return
    axes.axvline(duration, color=BLACK, linewidth=0.8, dashes=(2, 2), zorder=1)
    note(axes, "a, b", (duration, 0.0), (3.0, 5.0), color=BLACK)
