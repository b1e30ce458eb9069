"""Draw error against CPU time, one panel a case: our methods and the best of each peer in colour, the others in grey."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.benchmarks.accuracy_cost.measure import OURS, Point, cheapest, package_of
from bristle_sim.benchmarks.accuracy_cost.results import AccuracyCost
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, ORANGE
from bristle_sim.render.panels import note
from bristle_sim.render.style import MILLISECONDS, axes_at, blank_figure, styled

WIDTH = 16.0
"""Printed width of the page's text, cm."""

PANEL = (6.3, 5.6)
HEAD, FOOT, LINE = 1.35, 1.45, 0.31
"""Size of a panel, heights of its title and verdict, of its scale, and of a line of its legend or notes, cm."""

COLORS = {OURS: BLUE, "scipy": ORANGE, "mujoco": GREEN}
MARKERS = "osD^vPX*"
OTHERS = "#c4c4c4"
"""Colour of peers' methods that are not their package's best."""

TARGETS = tuple(10.0**-power for power in range(6, -1, -1))
"""Errors, the first of which is compared; where a package does not reach it, the next that it reaches."""

LEAST = 1e-16
"""An error of less is drawn here: an answer that is right to the last digit has no logarithm."""


@styled()
def cost_figure(measured: AccuracyCost) -> Figure:
    """Draw every case of a study in two columns; points without a finite error are left out.

    Raises:
        ValueError: if there is no case.
    """
    if not measured.cases:
        raise ValueError("cases = (): must be one case or more")
    below = {case.name: _named_and_notes(case, measured.of(case.name)) for case in measured.cases}
    lines = [math.ceil(len(named) / 2) + len(notes) for named, notes in below.values()]
    heights = [PANEL[1] + HEAD + FOOT + LINE * max(lines[row : row + 2]) for row in range(0, len(lines), 2)]
    if measured.effects:
        heights.append(PANEL[1] + HEAD + FOOT + 2 * LINE)
    figure = blank_figure(WIDTH, sum(heights))
    for number, case in enumerate(measured.cases):
        row, column = divmod(number, 2)
        top = sum(heights[row:])
        axes = axes_at(figure, 1.45 + 8.2 * column, top - PANEL[1] - HEAD, *PANEL)
        _panel(axes, case, measured.of(case.name), *below[case.name])
    if measured.effects:
        _growth_panel(axes_at(figure, 1.45, heights[-1] - PANEL[1] - HEAD, *PANEL), measured)
    return figure


def _growth_panel(axes: Axes, measured: AccuracyCost) -> None:
    """Draw CPU time over the number of links and of bristles."""
    names = {"links": "a strike of a wire, its links", "bristles": "a row up to its strikes, its bristles"}
    for (what, label), color, marker in zip(names.items(), (BLUE, ORANGE), MARKERS, strict=False):
        rows = [row for row in measured.effects if row.what == what]
        numbers, times = [int(row.effect) for row in rows], [row.cpu_s * MILLISECONDS for row in rows]
        axes.loglog(numbers, times, color=color, marker=marker, markersize=3.6, linewidth=1.3, label=label)
    axes.set_title("cost over links and bristles", loc="left", pad=16.0)
    axes.set_xticks([1, 2, 4, 8, 16], labels=["1", "2", "4", "8", "16"])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("number", labelpad=1.0)
    axes.set_ylabel("CPU time (ms)", labelpad=2.0)
    axes.legend(loc="upper left", bbox_to_anchor=(-0.2, -1.05 / PANEL[1]), borderaxespad=0.0, fontsize=6.5)


def best_methods(points: Sequence[Point]) -> dict[str, str]:
    """Return by package its cheapest method at an error of 1e-6, or at the next power of ten that it reaches."""
    best = {}
    for package in dict.fromkeys(package_of(point.method) for point in points):
        own = [point for point in points if package_of(point.method) == package]
        found = next((point for target in TARGETS if (point := cheapest(own, target)) is not None), None)
        if found is not None:
            best[package] = found.method
    return best


def verdict(points: Sequence[Point]) -> str:
    """Return the cheapest of ours and the cheapest of all peers at one error, in words."""
    ours = [point for point in points if package_of(point.method) == OURS]
    peers = [point for point in points if package_of(point.method) != OURS]
    for target in TARGETS:
        own, peer = cheapest(ours, target), cheapest(peers, target)
        if own is not None:
            said = f"to $10^{{{round(math.log10(target))}}}$: {own.method.partition(' ')[2]} {_shown(own)}"
            return f"{said}, {peer.method} {_shown(peer)}" if peer is not None else f"{said}, no peer gets there"
    return "none of our methods is within 1"


def _shown(point: Point) -> str:
    return f"{point.cpu_s * MILLISECONDS:.2g} ms"


def _named_and_notes(case: Case, points: Sequence[Point]) -> tuple[list[str], list[str]]:
    """Return the methods that have a colour and a name, all of ours and the best of each peer, and the lines below."""
    best = best_methods(points).values()
    methods = dict.fromkeys(point.method for point in points if math.isfinite(point.error))
    named = [method for method in methods if package_of(method) == OURS or method in best]
    grey: dict[str, list[str]] = {}
    for method in methods:
        if method not in named:
            package, _, name = method.partition(" ")
            grey.setdefault(package, []).append(name)
    words = "; ".join(f"{package} {', '.join(names)}" for package, names in grey.items())
    return named, [*(textwrap.wrap(f"grey: {words}", 62) if grey else []), *case.notes]


def _panel(axes: Axes, case: Case, points: Sequence[Point], named: Sequence[str], notes: Sequence[str]) -> None:
    """Draw a case, the names of its methods and its notes below it."""
    drawn = [point for point in points if math.isfinite(point.error)]
    for method in dict.fromkeys(point.method for point in drawn):
        times = [point.cpu_s * MILLISECONDS for point in drawn if point.method == method]
        errors = [max(point.error, LEAST) for point in drawn if point.method == method]
        axes.loglog(times, errors, gid=method, **_look(method, named))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(numticks=9))
        axis.set_minor_formatter(NullFormatter())
    axes.set_title(case.title, loc="left", pad=16.0)
    note(axes, verdict(points), (0.0, 1.0), (0.0, 5.0), xycoords="axes fraction", fontsize=6.5)
    axes.set_xlabel("CPU time (ms)", labelpad=1.0)
    axes.set_ylabel("relative error", labelpad=2.0)
    below = -1.05 / PANEL[1]
    look: dict[str, Any] = {"columnspacing": 0.8, "labelspacing": 0.25, "handlelength": 2.0, "fontsize": 6.5}
    axes.legend(loc="upper left", bbox_to_anchor=(-0.2, below), ncols=2, borderaxespad=0.0, **look)
    place = (-0.19, below - (LINE * math.ceil(len(named) / 2) + 0.12) / PANEL[1])
    look = {"transform": axes.transAxes, "fontsize": 6.5, "va": "top", "linespacing": 1.35}
    axes.text(*place, "\n".join(notes), color=GREY, **look)


def _look(method: str, named: Sequence[str]) -> dict[str, Any]:
    """Return the colour of the package and the marker by place among its named methods; our own curves are heavier."""
    if method not in named:
        return {"color": OTHERS, "linewidth": 0.8, "marker": ".", "markersize": 2.0, "zorder": 1}
    package = package_of(method)
    place = [each for each in named if package_of(each) == package].index(method)
    color = COLORS.get(package, BLACK)
    heavy = {"markersize": 3.6, "markerfacecolor": color, "linewidth": 1.3, "zorder": 3}
    light = {"markersize": 3.2, "markerfacecolor": "white", "linewidth": 1.0, "zorder": 2}
    marker = {"marker": MARKERS[place % len(MARKERS)], "markeredgewidth": 0.7}
    return {"label": method, "color": color, **marker, **(heavy if package == OURS else light)}
