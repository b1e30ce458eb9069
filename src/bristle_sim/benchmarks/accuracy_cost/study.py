"""Error against CPU time: every case is solved by every installed method.

The tables compare the CPU time of this project with that of the fastest other package (peer).
"""

from __future__ import annotations

import dataclasses
import logging
import textwrap
import time as clock
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from bristle_sim.benchmarks.accuracy_cost import Effort, cases, methods, peers
from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.benchmarks.accuracy_cost.measure import (
    OURS,
    Attempt,
    Point,
    by_method,
    cheapest,
    measure,
    package_of,
)
from bristle_sim.benchmarks.machine import PACKAGES, installed, surroundings
from bristle_sim.comparison import Quantity, Report, Unfinished
from bristle_sim.readable import WIDTH, amount, finite

Offers = dict[str, Callable[[Any], list[Attempt]]]
"""Functions that return a package's attempts at a case, by the name of the package."""

FLIGHT: Offers = {
    OURS: methods.own_flight,
    "scipy": methods.scipy_flight,
    "mujoco": peers.mujoco_flight,
    "heyoka": peers.heyoka_flight,
}
STRIKE: Offers = {OURS: methods.own_strike}
PASS: Offers = {
    OURS: methods.own_pass,
    "scipy": methods.scipy_pass,
    "mujoco": peers.mujoco_pass,
}

CASES: tuple[tuple[Callable[[], Case], Offers], ...] = (
    (cases.release_flight, FLIGHT),
    (cases.strike, STRIKE),
    (cases.double_pendulum, STRIKE),
    (cases.whole_pass_case, PASS),
)
"""The functions that build the cases.

Beside each are the functions that return the attempts of the packages at the case."""

TARGETS = {
    "release_flight": (1e-3, 1e-6, 1e-9),
    "strike": (1e-3, 1e-6),
    "double_pendulum": (1e-3, 1e-6),
    "whole_pass": (1e-4, 1e-6),
}
"""Errors at which CPU times are compared, by case."""

NOT_IN_TIME = ("bristle_sim energetic", "bristle_sim engine", "bristle_sim ensemble")
"""This project's impact laws without time steps, and its computation of many passes at once.

They are not compared with methods that integrate one pass in time."""

REQUESTED = {
    "release_flight": ("bristle_sim simulate", 1e-10),
    "strike": ("bristle_sim compliant", 1e-6),
    "double_pendulum": ("bristle_sim compliant", 1e-6),
    "whole_pass": ("bristle_sim simulate", 1e-9),
}
"""By case: the method whose error is compared with the accuracy requested of it, and the finest
requested accuracy at which they are compared.

At finer accuracies other errors prevail: rounding errors in the flight and in the penetrations of a
short contact, and the error of the pass's reference."""

ROUNDS = {"full": 7, "quick": 2}
"""Number of rounds of timing, by effort."""

QUICK_SETTINGS = 2
"""Largest number of settings of each method at quick effort; the coarsest setting is among them."""


@dataclasses.dataclass(slots=True)
class AccuracyCost:
    """Results of the measurements of accuracy and CPU time.

    Attributes:
        cases: the cases measured so far.
        points: the measured points, in the order of measurement.
        missing: reason why a package was not measured, by the package's name.
    """

    cases: tuple[Case, ...] = ()
    points: tuple[Point, ...] = ()
    missing: dict[str, str] = dataclasses.field(default_factory=dict)

    def of(self, case: str) -> list[Point]:
        """Return the measured points of the case with this name."""
        return [point for point in self.points if point.case == case]


class Comparison(NamedTuple):
    """The fastest method of this project and the fastest of all other packages, at one target
    error.

    Attributes:
        case: name of the case.
        target: the target error.
        ours: measured point of this project's fastest method that integrates in time. It is None if
            no method meets the target.
        peer: measured point of the fastest method of all other packages. It is None if no method
            meets the target.
    """

    case: str
    target: float
    ours: Point | None
    peer: Point | None


def accuracy_cost(effort: Effort) -> Report:
    """Measure all cases, and compare CPU times at the same error.

    The time of this project is compared with that of the fastest other package.

    Raises:
        Unfinished: if the user interrupts the measurement. The exception carries a report of the
            cases measured so far.
    """
    begin = clock.perf_counter()
    measured = AccuracyCost()
    interrupted = False
    try:
        _measure(measured, effort)
    except KeyboardInterrupt:
        interrupted = True
    machine = {
        **surroundings(),
        "clock": f"process CPU time, the least of {ROUNDS[effort.effort]} interleaved rounds",
        "command": f"python scenarios/accuracy_cost.py --set effort={effort.effort} --set peers={effort.peers}",
    }
    curves = [
        dataclasses.asdict(each) | {"error": finite(each.error), "cpu_s": finite(each.cpu_s)}
        for each in measured.points
    ]
    found = tuple(_tables(measured, machine))
    extra = {"curves": curves, "machine": machine}
    if interrupted:
        raise Unfinished(Report(None, (), remarks=found, extra=extra))
    return Report(
        outcome=None,
        quantities=tuple(_rows(measured)),
        wall_s=clock.perf_counter() - begin,
        steps=sum(point.steps for point in measured.points if package_of(point.method) == OURS),
        remarks=found,
        extra=extra,
        subject=measured,
        answer=_answer(measured),
    )


def _measure(measured: AccuracyCost, effort: Effort) -> None:
    here = installed()
    measured.missing = {name: "not installed" for name in PACKAGES if name not in here}
    taking_part = here if effort.peers == "all" else {OURS}
    for number, (build, offers) in enumerate(CASES, start=1):
        case = build()
        tried = list[Attempt]()
        logging.getLogger(__name__).info("%s (case %d of %d)", case.name, number, len(CASES))
        for name, offer in offers.items():
            if name in taking_part:
                tried += _offered(name, offer, case, measured.missing)
        if effort.effort == "quick":
            tried = [
                each for own in by_method(tried) for each in own[:: -(-len(own) // QUICK_SETTINGS)]
            ]
        measured.points += tuple(measure(case, tried, ROUNDS[effort.effort]))
        measured.cases += (case,)


def _offered(
    name: str, offer: Callable[[Any], list[Attempt]], case: Case, missing: dict[str, str]
) -> list[Attempt]:
    """Return a package's attempts at a case, which the function ``offer`` makes.

    Another package may be installed and still fail at its import or when it builds its model. The
    list is then empty, and ``missing`` receives the reason under the package's name.
    """
    try:
        return offer(case)
    except Exception as error:
        if name == OURS:
            raise
        missing[name] = f"installed, but {type(error).__name__}: {' '.join(str(error).split())}"
        return []


def comparisons(measured: AccuracyCost) -> list[Comparison]:
    """Compare the fastest methods, one comparison for each case and each of its target errors."""
    found = []
    for case in measured.cases:
        points = [each for each in measured.of(case.name) if each.method not in NOT_IN_TIME]
        ours = [each for each in points if package_of(each.method) == OURS]
        others = [each for each in points if package_of(each.method) != OURS]
        found += [
            Comparison(case.name, target, cheapest(ours, target), cheapest(others, target))
            for target in TARGETS[case.name]
        ]
    return found


def _rows(measured: AccuracyCost) -> list[Quantity]:
    """Return the quantities of the report: CPU times, and errors divided by the requested accuracy.

    In the entry of a CPU time, ``simulated`` is the time of this project, and ``reference`` is the
    time of the fastest other package.
    """
    rows = []
    for each in comparisons(measured):
        ours, peer = (None if point is None else point.cpu_s for point in (each.ours, each.peer))
        rows.append(Quantity(f"{each.case}_cpu_at_{each.target:.0e}", "s", ours, reference=peer))
    law = next(each for each in measured.of("strike") if each.method == "bristle_sim energetic")
    rows.append(Quantity("strike_cpu_energetic", "s", law.cpu_s))
    for case, (method, least) in REQUESTED.items():
        found = {
            float(each.setting.split("=")[1]): each.error
            for each in measured.of(case)
            if each.method == method
        }
        worst = max(error / asked for asked, error in found.items() if asked >= 0.999 * least)
        rows.append(Quantity(f"{case}_error_over_accuracy", "1", worst, theory=0.0, tolerance=1.0))
    return rows


def _answer(measured: AccuracyCost) -> str:
    """Return a sentence with the CPU times at the smallest target error of each case.

    The times are those of this project and of the fastest other package.
    """
    costs = []
    for each in comparisons(measured):
        if each.ours is not None and each.target == min(TARGETS[each.case]):
            peer = (
                ""
                if each.peer is None
                else f" ({package_of(each.peer.method)} {amount(each.peer.cpu_s, 's')})"
            )
            reached = f"to an error of {each.target:.0e} takes {amount(each.ours.cpu_s, 's')}"
            costs.append(f"{each.case.replace('_', ' ')} {reached}{peer}")
    return (
        f"In CPU time, {'; '.join(costs)}."
        if costs
        else "No method of this project reaches the target errors."
    )


DECADES = tuple(10.0**-power for power in range(1, 11))
"""Errors for which a case's table lists CPU times, one in each column."""


def _tables(measured: AccuracyCost, machine: dict[str, Any]) -> Iterator[str]:
    """Yield the lines printed below the report's quantities, wrapped to the terminal's width."""
    for line in _lines(measured, machine):
        indent = " " * (len(line) - len(line.lstrip()) + 4)
        yield from textwrap.wrap(line, WIDTH, subsequent_indent=indent) or [""]


def _lines(measured: AccuracyCost, machine: dict[str, Any]) -> Iterator[str]:
    yield ""
    yield "simulated: our fastest method that integrates in time; reference: the fastest other package"
    for case in measured.cases:
        yield ""
        yield f"{case.name}: {case.title}; CPU time (ms) for each error (exact answer: {case.source})"
        yield f"  {'method':<28}" + "".join(f"{decade:>7.0e}" for decade in DECADES)
        for own in by_method(measured.of(case.name)):
            cells = "".join(_cell(cheapest(own, decade)) for decade in DECADES)
            yield f"  {own[0].method:<28}{cells}"
            failed = [each for each in own if each.failure]
            yield from (f"    {each.setting} failed: {each.failure}" for each in failed)
        yield from (f"  {note}" for note in case.notes)
    yield ""
    yield "our CPU time divided by that of the fastest other package, at each error:"
    for each in comparisons(measured):
        verdict = f"not reached by {'another package' if each.ours else 'our methods in time'}"
        if each.ours is not None and each.peer is not None:
            ratio = each.ours.cpu_s / each.peer.cpu_s
            verdict = f"{ratio:6.2f}  {_named(each.ours)} against {_named(each.peer)}"
        yield f"  {each.case:<16} {each.target:.0e}  {verdict}"
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    yield ""
    yield f"machine: {machine['processor']}, {machine['cores']} cores, {machine['system']}"
    yield f"times: {machine['clock']}"
    yield f"versions: {versions}"
    yield f"command: {machine['command']}"
    for name, why in measured.missing.items():
        yield f"does not take part: {name}, {why}"
    if measured.missing:
        yield "pip install 'bristle-sim[peers]' installs every compared package"


def _cell(point: Point | None) -> str:
    time = 0.0 if point is None else 1e3 * point.cpu_s
    return f"{'-':>7}" if point is None else f"{time:>7.0f}" if time >= 100.0 else f"{time:>7.2g}"


def _named(point: Point) -> str:
    return f"{point.method} ({point.setting}, {1e3 * point.cpu_s:.3g} ms)"
