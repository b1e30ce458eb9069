"""What the study found, and its tables: a case each, who is cheapest at which error, what an effect costs, on what machine."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.benchmarks.accuracy_cost.measure import OURS, Effect, Point, cheapest, package_of
from bristle_sim.comparison import WIDTH

TARGETS = {
    "release_flight": (1e-3, 1e-6, 1e-9),
    "strike": (1e-3, 1e-6),
    "double_pendulum": (1e-3, 1e-6),
    "whole_pass": (1e-4, 1e-6),
}
"""Errors at which costs are compared."""

NOT_IN_TIME = ("bristle_sim energetic", "bristle_sim engine")
"""Our impact laws that take no steps in time; they are not compared with integrators."""

DECADES = tuple(10.0**-power for power in range(1, 11))
"""Errors in the head of a case's table."""


class Comparison(NamedTuple):
    """Our cheapest point in time within a target error and the cheapest peer's; None where there is none."""

    case: str
    target: float
    ours: Point | None
    peer: Point | None

    @property
    def ratio(self) -> float | None:
        """Ratio of our CPU time to the peer's."""
        return None if self.ours is None or self.peer is None else self.ours.cpu_s / self.peer.cpu_s


@dataclass(slots=True)
class AccuracyCost:
    """All that was measured, for tables and pictures.

    Attributes:
        cases: in order.
        points: of all cases and methods.
        effects: what each effect costs.
        missing: packages that do not take part, and why.
    """

    cases: tuple[Case, ...] = ()
    points: tuple[Point, ...] = ()
    effects: tuple[Effect, ...] = ()
    missing: dict[str, str] = field(default_factory=dict)

    def of(self, case: str) -> list[Point]:
        """Return the points of a case."""
        return [point for point in self.points if point.case == case]


def comparisons(measured: AccuracyCost) -> list[Comparison]:
    """Return our cost and the cheapest peer's for each case and target."""
    found = []
    for case in measured.cases:
        points = [each for each in measured.of(case.name) if each.method not in NOT_IN_TIME]
        sides = [[each for each in points if (package_of(each.method) == OURS) is ours] for ours in (True, False)]
        found += [Comparison(case.name, e, *(cheapest(side, e) for side in sides)) for e in TARGETS[case.name]]
    return found


def tables(measured: AccuracyCost, machine: dict[str, Any]) -> list[str]:
    """Return lines to print below the comparison, none wider than a terminal."""
    lines = list[str]()
    for line in _lines(measured, machine):
        indent = " " * (len(line) - len(line.lstrip()) + 4)
        lines += textwrap.wrap(line, WIDTH, subsequent_indent=indent) if len(line) > WIDTH else [line]
    return lines


def _lines(measured: AccuracyCost, machine: dict[str, Any]) -> Iterator[str]:
    yield from ("", "reference = the cheapest peer; simulated = the cheapest of our methods that integrate in time")
    for case in measured.cases:
        yield from _case(case, measured.of(case.name))
    yield from ("", "ratio of our CPU time to the cheapest peer's:")
    for each in comparisons(measured):
        verdict = f"reached by {'no peer' if each.ours else 'none of ours in time'}"
        if each.ours is not None and each.peer is not None:
            verdict = f"{each.ratio:6.2f}  {_named(each.ours)} against {_named(each.peer)}"
        yield f"  {each.case:<16} {each.target:.0e}  {verdict}"
    yield from ("", f"{'what':<12}{'effect':<24}{'CPU us':>12}{'ratio':>8}  scene")
    for row in measured.effects:
        yield f"{row.what:<12}{row.effect:<24}{1e6 * row.cpu_s:12.2f}{row.ratio:8.2f}  {row.holds}"
    yield from ("", f"machine: {machine['processor']}, {machine['cores']} cores, {machine['system']}")
    yield f"times: {machine['clock']}"
    yield "versions: " + ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    yield f"command: {machine['command']}"
    for name, why in measured.missing.items():
        yield f"does not take part: {name}, {why}"
    if measured.missing:
        yield "pip install 'bristle-sim[peers]' installs every peer"


def _case(case: Case, points: list[Point]) -> Iterator[str]:
    """Yield CPU time in ms of each method at each decade of error; - where it does not get there."""
    yield from ("", f"{case.name}: {case.title}; CPU ms to an error of (exact: {case.source})")
    yield f"  {'method':<28}" + "".join(f"{decade:>7.0e}" for decade in DECADES)
    for method in dict.fromkeys(point.method for point in points):
        own = [point for point in points if point.method == method]
        yield f"  {method:<28}" + "".join(_cell(cheapest(own, decade)) for decade in DECADES)
        yield from (f"    {each.setting} failed: {each.failure}" for each in own if each.failure)
    yield from (f"  {note}" for note in case.notes)


def _cell(point: Point | None) -> str:
    time = 0.0 if point is None else 1e3 * point.cpu_s
    return f"{'-':>7}" if point is None else f"{time:>7.0f}" if time >= 100.0 else f"{time:>7.2g}"


def _named(point: Point) -> str:
    return f"{point.method} ({point.setting}, {1e3 * point.cpu_s:.3g} ms)"
