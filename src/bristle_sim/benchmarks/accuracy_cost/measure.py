"""Error and time of attempts at a case, in separate passes.

Every attempt is first run once for its error, which also warms up caches. Then all attempts are timed in turn, round after
round, so that other work on the machine disturbs all of them alike. The cost of an attempt is the least CPU time of the
process in all rounds.
"""

from __future__ import annotations

import dataclasses
import math
import time as clock
import timeit
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import Case

OURS = "bristle_sim"
"""This package among those that are measured."""


@dataclass(frozen=True, slots=True)
class Run:
    """An attempt's answer to a case, and its number of steps (or right-hand sides)."""

    values: tuple[float, ...]
    steps: int


@dataclass(frozen=True, slots=True)
class Attempt:
    """One method with one setting; ``run`` is the timed part, and ``method`` begins with the package's name."""

    method: str
    setting: str
    run: Callable[[], Run]


@dataclass(frozen=True, slots=True)
class Point:
    """Error, CPU time (s) and steps of an attempt; a failed one has an infinite error and its reason in ``failure``."""

    case: str
    method: str
    setting: str
    error: float
    cpu_s: float
    steps: int
    failure: str = ""


def attempts(
    method: str, setting: str, run: Callable[[Any], Run], values: Iterable[Any]
) -> list[Attempt]:
    """Return an attempt for each value of a method's setting, which go from coarse to fine."""
    return [Attempt(method, setting.format(value), partial(run, value)) for value in values]


def package_of(method: str) -> str:
    """Return the package that a method belongs to."""
    return method.split(maxsplit=1)[0]


def by_method(points: Iterable[Point]) -> list[list[Point]]:
    """Return the points of each method."""
    methods: dict[str, list[Point]] = {}
    for point in points:
        methods.setdefault(point.method, []).append(point)
    return [*methods.values()]


def measure(case: Case, tried: Iterable[Attempt], rounds: int) -> list[Point]:
    """Measure the error of every attempt, then the CPU time of those that raise no exception."""
    points = list[Point]()
    working = list[Callable[[], Run]]()
    for attempt in tried:
        error = math.inf
        steps = 0
        failure = ""
        try:
            run = attempt.run()
            error = case.error(run.values)
            steps = run.steps
            working.append(attempt.run)
        except Exception as raised:
            failure = " ".join(str(raised).split()) or type(raised).__name__
        points.append(
            Point(case.name, attempt.method, attempt.setting, error, math.nan, steps, failure)
        )
    times = iter(cpu_times(working, rounds))
    return [
        each if each.failure else dataclasses.replace(each, cpu_s=next(times)) for each in points
    ]


BLOCK = 4e-3
"""CPU time that one timing of an attempt should take at least, by repetition, s."""


def cpu_times(actions: Sequence[Callable[[], Any]], rounds: int) -> list[float]:
    """Return the least CPU time of each action, s, timed in turn over the rounds, with caches warm."""
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
    """Return the cheapest point within a target error whose method's next finer setting is within it too.

    A setting that is accurate only because its error changes sign there does not count. Points of one method go from coarse
    to fine.
    """
    candidates = []
    for own in by_method(point for point in points if not point.failure):
        pairs = zip(own, [*own[1:], own[-1]], strict=True)
        candidates += [point for point, finer in pairs if max(point.error, finer.error) <= target]
    return min(candidates, key=lambda each: each.cpu_s, default=None)
