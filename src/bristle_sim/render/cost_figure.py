"""Draw error against CPU time, one panel a case: our methods and the best of each peer in colour, the others in grey."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.benchmarks.accuracy_cost.measure import OURS, Point, cheapest, package_of
from bristle_sim.benchmarks.accuracy_cost.results import AccuracyCost
from bristle_sim.render.panels import note
from bristle_sim.render.style import BLACK, BLUE, GREEN, GREY, ORANGE, axes_at, blank_figure, styled

WIDTH = 16.0
"""Printed width of the page's text, cm."""

PANEL_WIDTH, PANEL_HEIGHT = 6.3, 5.6
LEFT, COLUMN = 1.45, 8.2
HEAD = 1.35
"""Height of a panel's title and verdict, cm."""

LINE = 0.31
"""Height of a line of a legend or a note, cm."""

NOTE = 62
"""Characters in a line of a note."""

COLUMNS = 2
"""Columns of a panel's legend."""

COLORS = {OURS: BLUE, "scipy": ORANGE, "mujoco": GREEN}
MARKERS = "osD^vPX*"
OTHERS = "#c4c4c4"
"""Colour of peers' methods that are not their package's best."""

TARGETS = tuple(10.0**-power for power in range(6, -1, -1))
"""Errors, the first of which is compared; where a package does not reach it, the next that it reaches."""

LEAST = 1e-16
"""An error of less is drawn here: an answer that is right to the last digit has no logarithm."""

MILLISECONDS = 1e3


def cost_figure(measured: AccuracyCost) -> Figure:
    """Draw every case of a study in two columns; points without a finite error are left out.

    Raises:
        ValueError: if there is no case.
    """
    if not measured.cases:
        raise ValueError("cases = (): must be one case or more")
    rows = [measured.cases[index : index + 2] for index in range(0, len(measured.cases), 2)]
    heights = [max(_height(measured, case) for case in row) for row in rows]
    growth = PANEL_HEIGHT + HEAD + 2.2 if measured.effects else 0.0
    with styled():
        figure = blank_figure(WIDTH, sum(heights) + growth)
        top = sum(heights) + growth
        for row, height in zip(rows, heights, strict=True):
            for column, case in enumerate(row):
                place = (LEFT + column * COLUMN, top - PANEL_HEIGHT - HEAD, PANEL_WIDTH, PANEL_HEIGHT)
                _panel(axes_at(figure, *place), case, measured.of(case.name))
            top -= height
        if growth:
            _growth_panel(axes_at(figure, LEFT, 2.2, PANEL_WIDTH, PANEL_HEIGHT), measured)
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
    axes.legend(loc="upper left", bbox_to_anchor=(-0.2, -1.05 / PANEL_HEIGHT), borderaxespad=0.0, fontsize=6.5)


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
            error = f"$10^{{{round(math.log10(target))}}}$"
            said = f"to {error}: {own.method.partition(' ')[2]} {_shown(own)}"
            return f"{said}, {peer.method} {_shown(peer)}" if peer is not None else f"{said}, no peer gets there"
    return "none of our methods is within 1"


def _shown(point: Point) -> str:
    return f"{point.cpu_s * MILLISECONDS:.2g} ms"


def _height(measured: AccuracyCost, case: Case) -> float:
    """Return the height of a panel with its title, axis, legend and notes, cm."""
    named, notes = _named_and_notes(case, measured.of(case.name))
    return PANEL_HEIGHT + HEAD + 1.45 + LINE * (math.ceil(len(named) / COLUMNS) + len(notes))


def _methods(points: Iterable[Point]) -> list[str]:
    return list(dict.fromkeys(point.method for point in points if math.isfinite(point.error)))


def _named_and_notes(case: Case, points: Sequence[Point]) -> tuple[list[str], list[str]]:
    """Return the methods that have a colour and a name, all of ours and the best of each peer, and the lines below."""
    best = best_methods(points).values()
    named = [method for method in _methods(points) if package_of(method) == OURS or method in best]
    grey: dict[str, list[str]] = {}
    for method in _methods(points):
        if method not in named:
            package, _, name = method.partition(" ")
            grey.setdefault(package, []).append(name)
    words = "; ".join(f"{package} {', '.join(names)}" for package, names in grey.items())
    return named, [*(textwrap.wrap(f"grey: {words}", NOTE) if grey else []), *case.notes]


def _panel(axes: Axes, case: Case, points: Sequence[Point]) -> None:
    named, notes = _named_and_notes(case, points)
    for method in _methods(points):
        drawn = [point for point in points if point.method == method and math.isfinite(point.error)]
        errors = [max(point.error, LEAST) for point in drawn]
        times = [point.cpu_s * MILLISECONDS for point in drawn]
        axes.loglog(times, errors, gid=method, **_look(method, named))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(numticks=9))
        axis.set_minor_formatter(NullFormatter())
    axes.set_title(case.title, loc="left", pad=16.0)
    note(axes, verdict(points), (0.0, 1.0), (0.0, 5.0), xycoords="axes fraction", fontsize=6.5)
    axes.set_xlabel("CPU time (ms)", labelpad=1.0)
    axes.set_ylabel("relative error", labelpad=2.0)
    _legend(axes, len(named), notes)


def _look(method: str, named: Sequence[str]) -> dict[str, Any]:
    """Return the colour of the package and the marker by place among its named methods; our own curves are heavier."""
    if method not in named:
        return {"color": OTHERS, "linewidth": 0.8, "marker": ".", "markersize": 2.0, "zorder": 1}
    package = package_of(method)
    place = [each for each in named if package_of(each) == package].index(method)
    own = package == OURS
    return {
        "label": method,
        "color": COLORS.get(package, BLACK),
        "marker": MARKERS[place % len(MARKERS)],
        "markersize": 3.6 if own else 3.2,
        "markerfacecolor": COLORS.get(package, BLACK) if own else "white",
        "markeredgewidth": 0.7,
        "linewidth": 1.3 if own else 1.0,
        "zorder": 3 if own else 2,
    }


def _legend(axes: Axes, named: int, notes: Sequence[str]) -> None:
    """Write names and notes below the panel."""
    below = -1.05 / PANEL_HEIGHT
    look: dict[str, Any] = {"columnspacing": 0.8, "labelspacing": 0.25, "handlelength": 2.0, "fontsize": 6.5}
    axes.legend(loc="upper left", bbox_to_anchor=(-0.2, below), ncols=COLUMNS, borderaxespad=0.0, **look)
    lines = math.ceil(named / COLUMNS)
    place = below - (LINE * lines + 0.12) / PANEL_HEIGHT
    axes.text(
        -0.19, place, "\n".join(notes), transform=axes.transAxes, fontsize=6.5, color=GREY, va="top", linespacing=1.35
    )
