"""Measurement of the error and the CPU time of attempts at a case, in separate passes.

Each attempt first runs once for its error; this run also warms up the caches. Then all attempts are
timed in turn, round after round, so that other work on the machine disturbs all of them alike. The
cost of an attempt is the least CPU time of the process in all rounds.
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
    """The answer that an attempt found for a case, and the number of its steps.

    For a method without fixed steps, ``steps`` counts the evaluations of the right-hand side.
    """

    values: tuple[float, ...]
    steps: int


@dataclass(frozen=True, slots=True)
class Attempt:
    """One method with one setting.

    ``run`` is the timed part. ``method`` begins with the name of the package. ``passes`` is the
    number of answers that one run computes, among which its time is divided.
    """

    method: str
    setting: str
    run: Callable[[], Run]
    passes: int = 1


@dataclass(frozen=True, slots=True)
class Point:
    """Error, CPU time (s) and number of steps of an attempt.

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
    """Return one attempt for each value of a method's setting; the values go from coarse to
    fine."""
    return [Attempt(method, setting.format(value), partial(run, value)) for value in values]


def package_of(method: str) -> str:
    """Return the name of the package of a method."""
    return method.split(maxsplit=1)[0]


def by_method(tried: Iterable[Tried]) -> list[list[Tried]]:
    """Return attempts or points grouped by method, one list for each method."""
    methods: dict[str, list[Tried]] = {}
    for each in tried:
        methods.setdefault(each.method, []).append(each)
    return list(methods.values())


def measure(case: Case, tried: Iterable[Attempt], rounds: int) -> list[Point]:
    """Measure the error of every attempt, then the CPU time of each attempt that raised no
    exception.
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
"""Least CPU time of one timing, s; a shorter action is repeated."""


def cpu_times(actions: Sequence[Callable[[], Any]], rounds: int) -> list[float]:
    """Return the least CPU time of each action, s.

    The actions are timed in turn, with warm caches, in a number of rounds.
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
    """Return the cheapest point that meets a target error, if the method's next finer setting does
    too.

    Without this condition a setting would count that is accurate only because its error changes
    sign there. The points of one method must go from coarse to fine.
    """
    candidates = []
    for own in by_method(point for point in points if not point.failure):
        pairs = zip(own, [*own[1:], own[-1]], strict=True)
        candidates += [point for point, finer in pairs if max(point.error, finer.error) <= target]
    return min(candidates, key=lambda each: each.cpu_s, default=None)
