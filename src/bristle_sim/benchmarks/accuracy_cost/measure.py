"""Measurement of the error and the CPU time of attempts at a case, in separate runs.

Each attempt first runs once for its error; this run also warms up the caches. Then all attempts are
timed one after the other in several rounds, so that other work on the machine disturbs all of them
alike. The cost of an attempt is its least CPU time in all rounds.
"""

from __future__ import annotations

import dataclasses
import math
import time as clock
import timeit
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

from bristle_sim.benchmarks.accuracy_cost.cases import Case

OURS = "bristle_sim"
"""Name of this package in the tables."""


@dataclass(frozen=True, slots=True)
class Run:
    """The computed answer of a case, and the number of integration steps that it took.

    For the integrators of SciPy's ``solve_ivp`` and ``ode``, ``steps`` is the number of evaluations
    of the right-hand side.
    """

    values: tuple[float, ...]
    steps: int


@dataclass(frozen=True, slots=True)
class Attempt:
    """A method with one value of its accuracy setting, to be run on one case.

    Attributes:
        method: name of the method; it begins with the name of the package.
        setting: the setting as text, for example ``accuracy=1e-06``.
        run: function that computes the answer; its CPU time is measured.
        passes: number of passes that one run computes. The measured CPU time is divided by it.
    """

    method: str
    setting: str
    run: Callable[[], Run]
    passes: int = 1


@dataclass(frozen=True, slots=True)
class Point:
    """Error, CPU time (s) and number of steps that were measured for one attempt.

    A failed attempt has an infinite error, and ``failure`` states the reason.
    """

    case: str
    method: str
    setting: str
    error: float
    cpu_s: float
    steps: int
    failure: str = ""


Tried = TypeVar("Tried", Attempt, Point)


def attempts(
    method: str, setting: str, run: Callable[[Any], Run], values: Iterable[Any]
) -> list[Attempt]:
    """Return one attempt for each value of a method's accuracy setting.

    Args:
        method: name of the method.
        setting: format of the setting's text, for example ``accuracy={:g}``.
        run: function that computes the answer with a value of the setting.
        values: values of the setting, from coarse to fine.
    """
    return [Attempt(method, setting.format(value), partial(run, value)) for value in values]


def package_of(method: str) -> str:
    """Return the name of the package to which a method belongs."""
    return method.split(maxsplit=1)[0]


def by_method(tried: Iterable[Tried]) -> list[list[Tried]]:
    """Group attempts or points by method, and return one list for each method."""
    methods: dict[str, list[Tried]] = {}
    for each in tried:
        methods.setdefault(each.method, []).append(each)
    return list(methods.values())


def measure(case: Case, tried: Iterable[Attempt], rounds: int) -> list[Point]:
    """Measure the error and the CPU time of every attempt at a case.

    An attempt that raises an exception is not timed. Every other attempt is timed in each of the
    ``rounds``, and its least time counts.
    """
    points = list[Point]()
    working = list[Attempt]()
    for attempt in tried:
        error = math.inf
        steps = 0
        failure = ""
        try:
            run = attempt.run()
            error = case.error(run.values)
            steps = run.steps
            working.append(attempt)
        except Exception as raised:
            failure = " ".join(str(raised).split()) or type(raised).__name__
        points.append(
            Point(case.name, attempt.method, attempt.setting, error, math.nan, steps, failure)
        )
    totals = cpu_times([each.run for each in working], rounds)
    times = iter([total / each.passes for total, each in zip(totals, working, strict=True)])
    return [
        each if each.failure else dataclasses.replace(each, cpu_s=next(times)) for each in points
    ]


BLOCK = 4e-3
"""Least CPU time of one timing, s; a shorter action is repeated until it takes this time."""


def cpu_times(actions: Sequence[Callable[[], Any]], rounds: int) -> list[float]:
    """Return the CPU time of each action (s), the least of several measurements.

    In each of the ``rounds`` all actions are timed one after the other, with warm caches.
    """
    timers = [timeit.Timer(action, timer=clock.process_time) for action in actions]
    counts = [math.ceil(BLOCK / max(timer.timeit(1), 1e-7)) for timer in timers]
    times = [math.inf] * len(actions)
    for _ in range(rounds):
        for number, (timer, count) in enumerate(zip(timers, counts, strict=True)):
            if count > 1:
                timer.timeit(1)
            times[number] = min(times[number], timer.timeit(count) / count)
    return times


def cheapest(points: Iterable[Point], target: float) -> Point | None:
    """Return the point with the least CPU time among those whose error is at most ``target``.

    A point qualifies only if the next finer setting of its method also meets the target. A single
    accurate point may be an accident, since the error may change sign there. The points of one
    method must go from coarse to fine. The result is None if no point qualifies.
    """
    candidates = []
    for own in by_method(point for point in points if not point.failure):
        pairs = zip(own, [*own[1:], own[-1]], strict=True)
        candidates += [point for point, finer in pairs if max(point.error, finer.error) <= target]
    return min(candidates, key=lambda each: each.cpu_s, default=None)
