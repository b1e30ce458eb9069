"""The whole study: every case by every method that is installed, what each effect costs, and the report of it."""

from __future__ import annotations

import logging
import time as clock
from collections.abc import Callable
from typing import Any

from bristle_sim.benchmarks.accuracy_cost import cases, mujoco_methods, other_peers, our_methods, scipy_methods
from bristle_sim.benchmarks.accuracy_cost.cases import Case, StrikeCase
from bristle_sim.benchmarks.accuracy_cost.effects import effects
from bristle_sim.benchmarks.accuracy_cost.machine import PACKAGES, installed, machine
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Effort, Point, measure, package_of, thinned
from bristle_sim.benchmarks.accuracy_cost.results import OURS, AccuracyCost, comparisons, milliseconds
from bristle_sim.benchmarks.accuracy_cost.tables import tables
from bristle_sim.comparison import Quantity, Report, Unfinished

__all__ = ["accuracy_cost"]

Offers = dict[str, Callable[[Any], list[Attempt]]]

FLIGHT: Offers = {
    OURS: our_methods.flight_attempts,
    "scipy": scipy_methods.flight_attempts,
    "mujoco": mujoco_methods.flight_attempts,
    "exudyn": other_peers.exudyn_flight_attempts,
    "pybullet": other_peers.pybullet_flight_attempts,
}
STRIKE: Offers = {
    OURS: our_methods.strike_attempts,
    "scipy": scipy_methods.strike_attempts,
    "mujoco": mujoco_methods.strike_attempts,
}
PASS: Offers = {
    OURS: our_methods.pass_attempts,
    "scipy": scipy_methods.pass_attempts,
    "mujoco": mujoco_methods.pass_attempts,
}
CASES: tuple[tuple[Callable[[], Case], Offers], ...] = (
    (cases.release_flight, FLIGHT),
    (cases.strike, STRIKE),
    (cases.double_pendulum, STRIKE),
    (cases.whole_pass, PASS),
)
"""Each case, and what each package offers at it."""

ASKED = {
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
    begin = clock.perf_counter()
    measured, circumstances = _measured(effort), machine(effort)
    return Report(
        outcome=None,
        quantities=tuple(_rows(measured)),
        wall_s=clock.perf_counter() - begin,
        steps=sum(point.steps for point in measured.points if package_of(point.method) == OURS),
        remarks=tuple(tables(measured, circumstances)),
        extra={
            "curves": [point.as_dict() for point in measured.points],
            "comparisons": [each.as_dict() for each in comparisons(measured)],
            "effects": [row.as_dict() for row in measured.effects],
            "machine": circumstances,
        },
        subject=measured,
    )


def _measured(effort: Effort) -> AccuracyCost:
    here = installed()
    taking_part = here if effort.peers == "all" else {OURS}
    made: list[Case] = []
    points: list[Point] = []
    try:
        for build, offers in CASES:
            case = build()
            logging.getLogger(__name__).info("%s (case %d of %d)", case.name, len(made) + 1, len(CASES))
            attempts = [each for name, offer in offers.items() if name in taking_part for each in offer(case)]
            points += measure(case, thinned(attempts, effort.settings), effort)
            made.append(case)
    except KeyboardInterrupt:
        raise Unfinished(Report(None, (), extra={"curves": [point.as_dict() for point in points]})) from None
    struck = next(case for case in made if isinstance(case, StrikeCase))
    missing = tuple(name for name in PACKAGES if name not in here)
    return AccuracyCost(tuple(made), tuple(points), tuple(effects(struck, effort)), missing)


def _rows(measured: AccuracyCost) -> list[Quantity]:
    """Return our CPU time (simulated) with the cheapest peer's (reference), and errors over the requested accuracy."""
    rows = []
    for each in comparisons(measured):
        name = f"{each.case}_cpu_at_{each.target:.0e}"
        rows.append(Quantity(name, "ms", milliseconds(each.ours), reference=milliseconds(each.peer)))
    law = next(each for each in measured.of("strike") if each.method == "bristle_sim energetic")
    rows.append(Quantity("strike_cpu_energetic", "ms", milliseconds(law)))
    return [*rows, *(_reached(measured, case) for case in ASKED)]


def _reached(measured: AccuracyCost, case: str) -> Quantity:
    """Return the largest ratio of error to requested accuracy, which must be at most 1."""
    method, least = ASKED[case]
    asked = [(float(each.setting.split("=")[1]), each.error) for each in measured.of(case) if each.method == method]
    worst = max(error / accuracy for accuracy, error in asked if accuracy >= 0.999 * least)
    return Quantity(f"{case}_error_over_accuracy", "1", worst, theory=0.0, tolerance=1.0)
