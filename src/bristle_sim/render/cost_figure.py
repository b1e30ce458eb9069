"""Error against CPU time, one panel a case: colour tells the package, marker and dashes the method."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, Protocol

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

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
    styled,
)

__all__ = ["cost_figure"]

WIDTH = 16.0
"""Printed width of the page's text, cm."""

PANEL_WIDTH, PANEL_HEIGHT = 6.3, 5.6
LEFT, COLUMN = 1.45, 8.2
LINE = 0.31
"""Height of a line of a legend or a note, cm."""

COLUMNS = 2
"""Of a panel's legend."""

COLORS = {"bristle_sim": BLUE, "scipy": ORANGE, "mujoco": GREEN, "exudyn": PURPLE, "pybullet": VERMILION}
MARKERS = "osD^vPX*"
LEAST = 1e-16
"""An error of less is drawn here: an answer that is right to the last digit has no logarithm."""

MILLISECONDS = 1e3


class _Point(Protocol):
    """What is drawn of a measured point."""

    @property
    def method(self) -> str:
        """The package's name and the method's."""

    @property
    def error(self) -> float:
        """Relative, infinite if there is none."""

    @property
    def cpu_s(self) -> float:
        """s."""


class _Case(Protocol):
    """What a panel says about its case."""

    @property
    def name(self) -> str:
        """Its word in tables."""

    @property
    def title(self) -> str:
        """The panel's title."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Lines below the panel."""


class _Measured(Protocol):
    """What a study measured."""

    @property
    def cases(self) -> Sequence[_Case]:
        """A panel each, in order."""

    def of(self, case: str) -> Sequence[_Point]:
        """The points of a case."""


def cost_figure(measured: _Measured) -> Figure:
    """Draw every case of a study in two columns; points without a finite error are left out.

    Raises:
        ValueError: if there is no case.
    """
    if not measured.cases:
        raise ValueError("cases = (): at least one case is allowed")
    rows = [measured.cases[index : index + 2] for index in range(0, len(measured.cases), 2)]
    heights = [max(_height(measured, case) for case in row) for row in rows]
    with styled():
        figure = blank_figure(WIDTH, sum(heights))
        top = sum(heights)
        for row, height in zip(rows, heights, strict=True):
            for column, case in enumerate(row):
                place = (LEFT + column * COLUMN, top - PANEL_HEIGHT - 0.75, PANEL_WIDTH, PANEL_HEIGHT)
                _panel(axes_at(figure, *place), case, measured.of(case.name))
            top -= height
    return figure


def _height(measured: _Measured, case: _Case) -> float:
    """Of a panel with its title, axis, legend and notes, cm."""
    lines = math.ceil(len(_methods(measured.of(case.name))) / COLUMNS) + len(case.notes)
    return PANEL_HEIGHT + 2.2 + LINE * lines


def _methods(points: Iterable[_Point]) -> list[str]:
    return list(dict.fromkeys(point.method for point in points if math.isfinite(point.error)))


def _panel(axes: Axes, case: _Case, points: Sequence[_Point]) -> None:
    methods = _methods(points)
    for method in methods:
        _curve(axes, method, _look(method, methods), points)
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(numticks=9))
        axis.set_minor_formatter(NullFormatter())
    axes.set_title(case.title, loc="left")
    axes.set_xlabel("CPU time (ms)", labelpad=1.0)
    axes.set_ylabel("relative error", labelpad=2.0)
    _legend(axes, methods, case.notes)


def _look(method: str, methods: Sequence[str]) -> dict[str, Any]:
    """Colour by package, marker by place among the package's methods; our own curves are heavier."""
    package = method.split(maxsplit=1)[0]
    place = [each for each in methods if each.split(maxsplit=1)[0] == package].index(method)
    own = package == "bristle_sim"
    return {
        "color": COLORS.get(package, BLACK),
        "marker": MARKERS[place % len(MARKERS)],
        "markersize": 3.6 if own else 2.8,
        "markerfacecolor": COLORS.get(package, BLACK) if own else "white",
        "markeredgewidth": 0.7,
        "linewidth": 1.2 if own else 0.8,
        "zorder": 3 if own else 2,
    }


def _curve(axes: Axes, method: str, look: dict[str, Any], points: Iterable[_Point]) -> None:
    drawn = [point for point in points if point.method == method and math.isfinite(point.error)]
    times = [point.cpu_s * MILLISECONDS for point in drawn]
    axes.plot(times, [max(point.error, LEAST) for point in drawn], label=method, gid=method, **look)


def _legend(axes: Axes, methods: Sequence[str], notes: Sequence[str]) -> None:
    """Names and notes below the panel."""
    below = -1.05 / PANEL_HEIGHT
    axes.legend(
        loc="upper left",
        bbox_to_anchor=(-0.2, below),
        ncols=COLUMNS,
        borderaxespad=0.0,
        columnspacing=0.8,
        labelspacing=0.25,
        handlelength=2.0,
        fontsize=6.5,
    )
    lines = math.ceil(len(methods) / COLUMNS)
    place = below - (LINE * lines + 0.12) / PANEL_HEIGHT
    axes.text(
        -0.19, place, "\n".join(notes), transform=axes.transAxes, fontsize=6.5, color=GREY, va="top", linespacing=1.35
    )
