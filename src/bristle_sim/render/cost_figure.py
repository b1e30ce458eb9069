"""Draw error against CPU time, one panel a case: our methods and the best of each peer in colour, the others in grey."""

from __future__ import annotations

import itertools
import math
import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.benchmarks.accuracy_cost.measure import OURS, Point, cheapest, package_of
from bristle_sim.benchmarks.accuracy_cost.study import NOT_IN_TIME, AccuracyCost
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY
from bristle_sim.render.style import MILLISECONDS, axes_at, blank_figure, note, styled

WIDTH = 16.0  # printed width of the page's text, cm
PANEL, HEAD, ROW, NOTES = (6.3, 5.6), 1.35, 11.0, 2.75
"""Size of a panel, height of its title and verdict, height of a row of panels, and how far below a panel its notes are, cm."""

OWN = (BLUE, PURPLE, SKY, BLACK)  # colours of our methods, in their order
PEERS = {"scipy": ORANGE, "mujoco": GREEN, "heyoka": "#7a5c00"}
OTHERS = "#c4c4c4"  # colour of peers' methods that are not their package's best
HEAVY: dict[str, Any] = {"markersize": 3.8, "linewidth": 1.8, "zorder": 3, "markeredgewidth": 0.7}
LIGHT = HEAVY | {"markersize": 3.2, "markerfacecolor": "white", "linewidth": 1.0, "zorder": 2}
PALE: dict[str, Any] = {"color": OTHERS, "linewidth": 0.8, "marker": ".", "markersize": 2.0, "zorder": 1}
"""Our curves, the peers' best, and the others."""

TARGETS = tuple(10.0**-power for power in range(6, -1, -1))
"""Errors, the first of which is compared; where a package does not reach it, the next that it reaches."""

LEAST = 1e-16  # an error of less is drawn here: an answer that is right to the last digit has no logarithm


@styled()
def cost_figure(measured: AccuracyCost) -> Figure:
    """Draw every case of a study in two columns; points without a finite error are left out.

    Raises:
        ValueError: if there is no case.
    """
    if not measured.cases:
        raise ValueError("cases = (): must be one case or more")
    rows = math.ceil(len(measured.cases) / 2)
    figure = blank_figure(WIDTH, rows * ROW)
    for number, case in enumerate(measured.cases):
        row, column = divmod(number, 2)
        place = (1.45 + 8.2 * column, (rows - row) * ROW - PANEL[1] - HEAD)
        _panel(axes_at(figure, *place, *PANEL), case, measured.of(case.name))
    return figure


def best_methods(points: Sequence[Point]) -> dict[str, str]:
    """Return by package its cheapest method at an error of 1e-6, or at the next power of ten that it reaches."""
    best = {}
    for package in dict.fromkeys(package_of(point.method) for point in points):
        own = [point for point in points if package_of(point.method) == package]
        found = next((point for target in TARGETS if (point := cheapest(own, target)) is not None), None)
        if found is not None:
            best[package] = found.method
    return best


def compared(points: Sequence[Point]) -> tuple[float, Point | None, Point | None]:
    """Return the error that is compared, the cheapest of our points there and the cheapest of all peers."""
    for target in TARGETS:
        if own := cheapest([point for point in points if package_of(point.method) == OURS], target):
            return target, own, cheapest([point for point in points if package_of(point.method) != OURS], target)
    return 1.0, None, None


def verdict(points: Sequence[Point]) -> str:
    """Return the cheapest of ours and the cheapest of all peers at one error, in words."""
    target, own, peer = compared(points)
    if own is None:
        return "none of our methods is within 1"
    said = f"to $10^{{{round(math.log10(target))}}}$: {own.method.partition(' ')[2]} {_shown(own)}"
    return f"{said}, {peer.method} {_shown(peer)}" if peer is not None else f"{said}, no peer gets there"


def _shown(point: Point) -> str:
    time = point.cpu_s * MILLISECONDS
    return f"{time:.0f} ms" if time >= 10.0 else f"{time:.2g} ms"


def _panel(axes: Axes, case: Case, points: Sequence[Point]) -> None:
    """Draw a case; named in colour are all of our methods and the best of each peer, below them the others and the notes."""
    drawn = [point for point in points if math.isfinite(point.error)]
    best, grey, markers = best_methods(points).values(), dict[str, list[str]](), dict[str, Iterator[str]]()
    used: list[str] = []
    for method in dict.fromkeys(point.method for point in drawn):
        times = [point.cpu_s * MILLISECONDS for point in drawn if point.method == method]
        errors = [max(point.error, LEAST) for point in drawn if point.method == method]
        package, look = package_of(method), PALE
        if package == OURS or method in best:
            look = HEAVY if package == OURS else LIGHT
            marker = next(markers.setdefault(package, itertools.cycle("osD^vPX*")))
            own = OWN[len(used) % len(OWN)] if package == OURS else PEERS.get(package, GREY)
            used += [method] * (package == OURS)
            look = {**look, "color": own, "marker": marker, "label": method}
        else:
            grey.setdefault(package, []).append(method.partition(" ")[2])
        axes.loglog(times, errors, gid=method, **look)
    if grey:
        axes.plot([], [], **{**PALE, "linewidth": 1.6}, label="others, named below")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(numticks=9))
        axis.set_minor_formatter(NullFormatter())
    axes.set_title(case.title, loc="left", pad=16.0, fontweight="bold")
    axes.axhline(TARGETS[0], color=GREY, linewidth=0.7, dashes=(4, 2), zorder=0)
    in_time = [each for each in points if each.method not in NOT_IN_TIME]
    note(axes, verdict(in_time), (0.0, 1.0), (0.0, 5.0), xycoords="axes fraction", color=BLACK, fontsize=6.5)
    for each in compared(in_time)[1:]:
        if each is not None:
            ring: dict[str, Any] = {"color": BLACK, "markerfacecolor": "none", "markersize": 9.0, "zorder": 5}
            axes.plot([each.cpu_s * MILLISECONDS], [max(each.error, LEAST)], "o", label="compared above", **ring)
    axes.set_xlabel("CPU time (ms)", labelpad=1.0)
    axes.set_ylabel("relative error", labelpad=2.0)
    look = {"columnspacing": 0.8, "labelspacing": 0.25, "handlelength": 2.0, "fontsize": 6.5}
    handles, names = axes.get_legend_handles_labels()
    unique = dict(zip(names, handles, strict=True))
    place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (-0.2, -1.05 / PANEL[1]), "borderaxespad": 0.0}
    axes.legend(unique.values(), unique.keys(), ncols=2, **place, **look)
    words = "grey: " + "; ".join(f"{package} {', '.join(names)}" for package, names in grey.items())
    packages = {package_of(point.method) for point in drawn}
    notes = [each for each in case.notes if each.partition(":")[0] in packages]
    lines = [*(textwrap.wrap(words, 62) if grey else []), *notes]
    look = {"transform": axes.transAxes, "fontsize": 6.5, "va": "top", "linespacing": 1.35, "color": GREY}
    axes.text(-0.19, -NOTES / PANEL[1], "\n".join(lines), **look)
