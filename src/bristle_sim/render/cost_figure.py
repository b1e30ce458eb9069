"""Figure of error against CPU time, with one panel for each test case.

Each method of this project has its own colour. Each other package has one colour for all methods.
"""

from __future__ import annotations

import itertools
import math

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from bristle_sim.benchmarks.accuracy_cost.measure import (
    OURS,
    Point,
    by_method,
    package_of,
)
from bristle_sim.benchmarks.accuracy_cost.study import AccuracyCost, comparisons
from bristle_sim.readable import MILLISECONDS
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    Look,
    blank_figure,
    styled,
)

HEIGHT = 8.6  # height of a row of panels with their legends, cm
OWN = (BLUE, PURPLE, SKY, BLACK)  # colours of this project's methods, in order of drawing
PEERS = {"scipy": ORANGE, "mujoco": GREEN, "heyoka": "#7a5c00"}  # colours of other packages
HEAVY: Look = {"markersize": 3.8, "linewidth": 1.8, "zorder": 3}
PEER = HEAVY | {"markersize": 3.2, "markerfacecolor": "white", "linewidth": 0.8, "zorder": 2}
"""Styles of this project's curves, and of the curves of other packages."""

LEAST = 1e-16  # smallest error drawn: an error of 0 has no logarithm


@styled()
def cost_figure(measured: AccuracyCost) -> Figure:
    """Draw error against CPU time, one panel for each test case.

    Each point is one method with one setting of its accuracy. Failed computations are left out.

    Raises:
        ValueError: if no case was measured.
    """
    if not measured.cases:
        raise ValueError("cases = (): must be one case or more")
    rows = math.ceil(len(measured.cases) / 2)
    figure = blank_figure(16.0, rows * HEIGHT)
    places = figure.subplots(rows, 2, squeeze=False).ravel()
    for axes, case in itertools.zip_longest(places, measured.cases):
        if case is None:
            axes.remove()
            continue
        # CPU times are compared at the smallest target error that a method of this project reaches.
        _, target, *compared = min(
            (each for each in comparisons(measured) if each.case == case.name),
            key=lambda each: (each.ours is None, each.target),
        )
        axes.set_title(f"{case.title}\n{verdict(target, *compared)}", fontsize=7.5)
        axes.set(xlabel="CPU time (ms)", ylabel="relative error")
        colours = itertools.cycle(OWN)
        markers = itertools.cycle("osD^vPX*")
        points = [each for each in measured.of(case.name) if math.isfinite(each.error)]
        for own in by_method(points):
            method = own[0].method
            look = PEER | {"color": PEERS.get(package_of(method), GREY)}
            if package_of(method) == OURS:
                look = HEAVY | {"color": next(colours)}
            times = [MILLISECONDS * each.cpu_s for each in own]
            errors = [max(each.error, LEAST) for each in own]
            axes.loglog(times, errors, gid=method, label=method, marker=next(markers), **look)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(numticks=9))
            axis.set_minor_formatter(NullFormatter())
        place = {"loc": "upper center", "bbox_to_anchor": (0.45, -0.18), "ncols": 2}
        axes.legend(**place, fontsize=6.0, labelspacing=0.2)
    return figure


def verdict(target: float, own: Point | None, peer: Point | None) -> str:
    """Return a phrase that compares the CPU times of this project and of another package.

    Args:
        target: the target error, at which the times are compared.
        own: measured point of this project's fastest method; None if no method meets the target.
        peer: measured point of the fastest method of all other packages; None if none meets it.
    """
    if own is None:
        return "none of our methods that integrate in time reaches a target error"
    said = f"to $10^{{{round(math.log10(target))}}}$: {own.method.partition(' ')[2]} {_shown(own)}"
    return (
        f"{said}, {peer.method} {_shown(peer)}" if peer is not None else f"{said}; no other package"
    )


def _shown(point: Point) -> str:
    time = point.cpu_s * MILLISECONDS
    return f"{time:.0f} ms" if time >= 10.0 else f"{time:.2g} ms"
