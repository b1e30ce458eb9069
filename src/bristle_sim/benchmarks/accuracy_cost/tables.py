"""The study in words: a table a case, who is cheapest at which error, what each effect costs, and on what machine."""

from __future__ import annotations

from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.benchmarks.accuracy_cost.effects import Effect
from bristle_sim.benchmarks.accuracy_cost.measure import Point, cheapest
from bristle_sim.benchmarks.accuracy_cost.results import AccuracyCost, comparisons, milliseconds

__all__ = ["tables"]

DECADES = tuple(10.0**-power for power in range(1, 11))


def tables(measured: AccuracyCost, machine: dict[str, Any]) -> list[str]:
    """Lines to print below the comparison."""
    lines = ["", "reference = the cheapest peer; simulated = the cheapest of our methods that integrate in time"]
    for case in measured.cases:
        lines += _case(case, measured.of(case.name))
    lines += ["", *_verdicts(measured), "", *_effects(measured.effects), "", *_circumstances(machine)]
    if measured.missing:
        lines.append(f"not installed: {', '.join(measured.missing)}; pip install 'bristle-sim[peers]'")
    return lines


def _case(case: Case, points: list[Point]) -> list[str]:
    """CPU time of each method at each decade of error, ms; - where it does not get there."""
    head = "".join(f"{decade:>9.0e}" for decade in DECADES)
    lines = ["", f"{case.name}: {case.title}; CPU ms to an error of (exact: {case.source})", f"  {'method':<30}{head}"]
    for method in dict.fromkeys(point.method for point in points):
        own = [point for point in points if point.method == method]
        lines.append(f"  {method:<30}" + "".join(_cell(milliseconds(cheapest(own, decade))) for decade in DECADES))
        lines += [f"    {each.setting} failed: {each.failure}" for each in own if each.failure]
    return lines + [f"  {note}" for note in case.notes]


def _cell(time: float | None) -> str:
    return f"{'-' if time is None else f'{time:.3g}':>9}"


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
    lines = [f"{'what':<12} {'effect':<42} {'CPU us':>10} {'ratio':>7} {'steps':>7}  holds"]
    for row in rows:
        steps = "" if row.steps is None else str(row.steps)
        lines.append(
            f"{row.what:<12} {row.effect:<42} {1e6 * row.cpu_s:10.2f} {row.ratio:7.2f} {steps:>7}  {row.holds}"
        )
    return lines


def _circumstances(machine: dict[str, Any]) -> list[str]:
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    return [
        f"machine: {machine['processor']}, {machine['cores']} cores, {machine['system']}",
        f"times: {machine['clock']}",
        f"versions: {versions}",
        f"command: {machine['command']}",
    ]
