"""The whole study: every case by every method that is installed, what each effect costs, and the report of it."""

from __future__ import annotations

import logging
import time as clock
from collections.abc import Callable
from typing import Any

from bristle_sim.benchmarks.accuracy_cost import cases, own_methods, peers, scipy_methods
from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.benchmarks.accuracy_cost.effects import effects
from bristle_sim.benchmarks.accuracy_cost.measure import OURS, Attempt, Effort, measure, package_of, plain, thinned
from bristle_sim.benchmarks.accuracy_cost.results import AccuracyCost, comparisons, tables
from bristle_sim.benchmarks.machine import PACKAGES, installed, surroundings
from bristle_sim.comparison import Quantity, Report, Unfinished, amount

Offers = dict[str, Callable[[Any], list[Attempt]]]

FLIGHT: Offers = {
    OURS: own_methods.flight_attempts,
    "scipy": scipy_methods.flight_attempts,
    "mujoco": peers.mujoco_flight,
    "exudyn": peers.exudyn_flight,
    "heyoka": peers.heyoka_flight,
}
STRIKE: Offers = {OURS: own_methods.strike_attempts, "scipy": scipy_methods.strike_attempts}
PASS: Offers = {OURS: own_methods.pass_attempts, "scipy": scipy_methods.pass_attempts, "mujoco": peers.mujoco_pass}

CASES: tuple[tuple[Callable[[], Case], Offers], ...] = (
    (cases.release_flight, FLIGHT),
    (cases.strike, STRIKE),
    (cases.double_pendulum, STRIKE),
    (cases.whole_pass, PASS),
)
"""Each case, and what each package offers at it."""

REQUESTED = {
    "release_flight": ("bristle_sim simulate", 1e-10),
    "strike": ("bristle_sim compliant", 1e-6),
    "double_pendulum": ("bristle_sim compliant", 1e-6),
    "whole_pass": ("bristle_sim simulate", 1e-9),
}
"""Methods that take a requested accuracy, and down to which: rounding, what positions leave of the penetrations of a
short contact, and the pass's reference are not far below."""


def accuracy_cost(effort: Effort) -> Report:
    """Measure everything and compare our cost with the cheapest peer's at the same error.

    Raises:
        Unfinished: with the curves of the cases measured so far, if the user interrupts.
    """
    begin, measured, interrupted = clock.perf_counter(), AccuracyCost(), False
    try:
        _measure(measured, effort)
    except KeyboardInterrupt:
        interrupted = True
    machine = {
        **surroundings(),
        "clock": f"process CPU time, the least of {effort.rounds} interleaved rounds",
        "command": f"python scenarios/accuracy_cost.py --set effort={effort.effort} --set peers={effort.peers}",
    }
    found, extra = tuple(tables(measured, machine)), {"curves": [plain(each) for each in measured.points]}
    if interrupted:
        raise Unfinished(Report(None, (), remarks=found, extra=extra | {"machine": machine}))
    return Report(
        outcome=None,
        quantities=tuple(_rows(measured)),
        wall_s=clock.perf_counter() - begin,
        steps=sum(point.steps for point in measured.points if package_of(point.method) == OURS),
        remarks=found,
        extra=extra
        | {
            "comparisons": [
                {"case": each.case, "target": each.target, "ratio": each.ratio}
                | {"ours": each.ours and each.ours.method, "peer": each.peer and each.peer.method}
                for each in comparisons(measured)
            ],
            "effects": [plain(row) for row in measured.effects],
            "machine": machine,
        },
        subject=measured,
        answer=_answer(measured),
    )


def _answer(measured: AccuracyCost) -> str:
    """Return our CPU time to each case's finest target error, beside the cheapest peer's."""
    finest = {each.case: each for each in sorted(comparisons(measured), key=lambda each: -each.target)}
    costs = []
    for case, each in finest.items():
        if each.ours is not None:
            peer = "" if each.peer is None else f" ({package_of(each.peer.method)} {amount(each.peer.cpu_s, 's')})"
            costs.append(
                f"{case.replace('_', ' ')} to an error of {each.target:.0e} takes {amount(each.ours.cpu_s, 's')}{peer}"
            )
    return f"In CPU time, {'; '.join(costs)}." if costs else "No method of ours reaches the target errors."


def _measure(measured: AccuracyCost, effort: Effort) -> None:
    here = installed()
    measured.missing = {name: "not installed" for name in PACKAGES if name not in here}
    taking_part = here if effort.peers == "all" else {OURS}
    for number, (build, offers) in enumerate(CASES, start=1):
        case, attempts = build(), list[Attempt]()
        logging.getLogger(__name__).info("%s (case %d of %d)", case.name, number, len(CASES))
        for name, offer in offers.items():
            if name in taking_part:
                attempts += _offered(name, offer, case, measured.missing)
        measured.points += tuple(measure(case, attempts if effort.effort == "full" else thinned(attempts, 2), effort))
        measured.cases += (case,)
    measured.effects = tuple(effects(effort))


def _offered(name: str, offer: Callable[[Any], list[Attempt]], case: Case, missing: dict[str, str]) -> list[Attempt]:
    """Return a package's attempts at a case: none of a peer that is installed but cannot be imported or set up."""
    try:
        return offer(case)
    except Exception as error:
        if name == OURS:
            raise
        missing[name] = f"installed, but {type(error).__name__}: {' '.join(str(error).split())}"
        return []


def _rows(measured: AccuracyCost) -> list[Quantity]:
    """Return our CPU time (simulated) with the cheapest peer's (reference), and errors over the requested accuracy."""
    rows = []
    for each in comparisons(measured):
        ours, peer = (None if point is None else point.cpu_s for point in (each.ours, each.peer))
        rows.append(Quantity(f"{each.case}_cpu_at_{each.target:.0e}", "s", ours, reference=peer))
    law = next(each for each in measured.of("strike") if each.method == "bristle_sim energetic")
    rows.append(Quantity("strike_cpu_energetic", "s", law.cpu_s))
    for case, (method, least) in REQUESTED.items():
        found = [(float(each.setting.split("=")[1]), each.error) for each in measured.of(case) if each.method == method]
        worst = max(error / accuracy for accuracy, error in found if accuracy >= 0.999 * least)
        rows.append(Quantity(f"{case}_error_over_accuracy", "1", worst, theory=0.0, tolerance=1.0))
    return rows
