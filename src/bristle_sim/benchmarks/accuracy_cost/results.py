"""What the study found, and its tables: a case each, who is cheapest at which error, what an effect costs, on what machine."""

from __future__ import annotations

import textwrap
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


def comparisons(measured: AccuracyCost) -> list[Comparison]:
    """Return our cost and the cheapest peer's for each case and target."""
    found = []
    for case in measured.cases:
        points = [each for each in measured.of(case.name) if each.method not in NOT_IN_TIME]
        ours = [each for each in points if package_of(each.method) == OURS]
        peers = [each for each in points if package_of(each.method) != OURS]
        for target in TARGETS[case.name]:
            found.append(Comparison(case.name, target, cheapest(ours, target), cheapest(peers, target)))
    return found


DECADES = tuple(10.0**-power for power in range(1, 11))


def tables(measured: AccuracyCost, machine: dict[str, Any]) -> list[str]:
    """Return lines to print below the comparison, none wider than a terminal."""
    lines = ["", "reference = the cheapest peer; simulated = the cheapest of our methods that integrate in time"]
    for case in measured.cases:
        lines += _case(case, measured.of(case.name))
    lines += ["", *_verdicts(measured), "", *_effects(measured.effects), "", *_circumstances(machine)]
    lines += [f"does not take part: {name}, {why}" for name, why in measured.missing.items()]
    if measured.missing:
        lines.append("pip install 'bristle-sim[peers]' installs every peer")
    return [part for line in lines for part in _wrapped(line)]


def _wrapped(line: str) -> list[str]:
    indent = " " * (len(line) - len(line.lstrip()) + 4)
    return [line] if len(line) <= WIDTH else textwrap.wrap(line, WIDTH, subsequent_indent=indent, drop_whitespace=True)


def _case(case: Case, points: list[Point]) -> list[str]:
    """Return CPU time in ms of each method at each decade of error; - where it does not get there."""
    head = "".join(f"{decade:>7.0e}" for decade in DECADES)
    lines = ["", f"{case.name}: {case.title}; CPU ms to an error of (exact: {case.source})", f"  {'method':<28}{head}"]
    for method in dict.fromkeys(point.method for point in points):
        own = [point for point in points if point.method == method]
        lines.append(f"  {method:<28}" + "".join(_cell(cheapest(own, decade)) for decade in DECADES))
        lines += [f"    {each.setting} failed: {each.failure}" for each in own if each.failure]
    return lines + [f"  {note}" for note in case.notes]


def _cell(point: Point | None) -> str:
    if point is None:
        return f"{'-':>7}"
    time = 1e3 * point.cpu_s
    return f"{time:>7.0f}" if time >= 100.0 else f"{time:>7.2g}"


def _verdicts(measured: AccuracyCost) -> list[str]:
    lines = ["ratio of our CPU time to the cheapest peer's:"]
    for each in comparisons(measured):
        words = f"  {each.case:<16} {each.target:.0e}  "
        if each.ours is None or each.peer is None:
            lines.append(words + f"reached by {'no peer' if each.ours else 'none of ours in time'}")
        else:
            lines.append(words + f"{each.ratio:6.2f}  {_named(each.ours)} against {_named(each.peer)}")
    return lines


def _named(point: Point) -> str:
    return f"{point.method} ({point.setting}, {1e3 * point.cpu_s:.3g} ms)"


def _effects(rows: tuple[Effect, ...]) -> list[str]:
    lines = [f"{'what':<12}{'effect':<40}{'CPU us':>9}{'ratio':>7}{'steps':>7}"]
    for row in rows:
        steps = "" if row.steps is None else str(row.steps)
        lines.append(f"{row.what:<12}{row.effect:<40}{1e6 * row.cpu_s:9.2f}{row.ratio:7.2f}{steps:>7}")
        lines.append(f"{'':<14}{row.holds}")
    return lines


def _circumstances(machine: dict[str, Any]) -> list[str]:
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    return [
        f"machine: {machine['processor']}, {machine['cores']} cores, {machine['system']}",
        f"times: {machine['clock']}",
        f"versions: {versions}",
        f"command: {machine['command']}",
    ]
