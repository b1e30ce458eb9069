"""Error and time of attempts at a case, in separate passes.

First every attempt is run once and its error noted, which also warms it up. Then all attempts are timed in rounds, each
round going through all of them in turn, so that other work on the machine disturbs all of them alike. Times are CPU times
of the process. The cost of an attempt is the least time of the rounds. The median shows the machine's noise above it.
"""

from __future__ import annotations

import dataclasses
import math
import statistics
import time as clock
import timeit
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.units import Declared, choice

OURS = "bristle_sim"
"""This package among those that are measured."""


@dataclass(frozen=True, slots=True)
class Effort(Declared):
    """How much to measure."""

    effort: str = choice(
        *("full", "effort", ("full", "quick"), "how many settings are timed and how often"),
        source="chosen: quick measures too little to compare",
    )
    peers: str = choice(
        *("all", "peers", ("all", "none"), "whether other packages are timed too"),
        source="chosen: every installed peer takes part",
    )

    @property
    def rounds(self) -> int:
        """Return how often each attempt is timed."""
        return 7 if self.effort == "full" else 2


@dataclass(frozen=True, slots=True)
class Run:
    """What an attempt returns: the case's numbers, and its steps (or right-hand sides)."""

    values: tuple[float, ...]
    steps: int


@dataclass(frozen=True, slots=True)
class Attempt:
    """One method with one setting; ``run`` does all that is timed. ``method`` begins with the package's name."""

    method: str
    setting: str
    run: Callable[[], Run]


def attempts(method: str, setting: str, run: Callable[[Any], Run], values: Iterable[Any]) -> list[Attempt]:
    """Return an attempt for each value of a method's setting, which go from coarse to fine."""
    return [Attempt(method, setting.format(value), partial(run, value)) for value in values]


@dataclass(frozen=True, slots=True)
class Point:
    """What an attempt reached and cost; error infinite and ``failure`` said if it broke down.

    ``cpu_s`` is the least and ``cpu_s_median`` the median of the rounds, s.
    """

    case: str
    method: str
    setting: str
    error: float
    cpu_s: float
    cpu_s_median: float
    steps: int
    failure: str = ""


@dataclass(frozen=True, slots=True)
class Effect:
    """An addition to a scene, its cost (CPU s), and the ratio of that cost to the first row of its kind.

    ``what`` is ``engine step``, or ``links`` or ``bristles``, whose number the effect is; ``holds`` counts what the scene has.
    """

    what: str
    effect: str
    cpu_s: float
    ratio: float
    holds: str


def plain(record: Point | Effect) -> dict[str, Any]:
    """Return the record as plain values, None for numbers that are not finite."""
    values = dataclasses.asdict(record).items()
    return {key: None if isinstance(each, float) and not math.isfinite(each) else each for key, each in values}


def package_of(method: str) -> str:
    """Return the package that a method belongs to."""
    return method.split(maxsplit=1)[0]


def thinned(all_of_them: Sequence[Attempt], settings: int) -> list[Attempt]:
    """Return at most a number of settings of each method, evenly spread, the coarsest among them."""
    methods = dict.fromkeys(each.method for each in all_of_them)
    own = [[each for each in all_of_them if each.method == method] for method in methods]
    return [each for group in own for each in group[:: -(-len(group) // settings)]]


def measure(case: Case, tried: Iterable[Attempt], effort: Effort) -> list[Point]:
    """Find errors first, then times, of every attempt; whatever a tool raises is its result and not the study's failure."""
    points, working = list[Point](), list[Callable[[], Run]]()
    for attempt in tried:
        error, steps, failure = math.inf, 0, ""
        try:
            run = attempt.run()
            error, steps = case.error(run.values), run.steps
            working.append(attempt.run)
        except Exception as raised:
            failure = " ".join(str(raised).split()) or type(raised).__name__
        points.append(Point(case.name, attempt.method, attempt.setting, error, math.nan, math.nan, steps, failure))
    times = iter(cpu_times(working, effort))
    for i, point in enumerate(points):
        if not point.failure:
            least, median = next(times)
            points[i] = dataclasses.replace(point, cpu_s=least, cpu_s_median=median)
    return points


BLOCK = 4e-3
"""CPU time that one timing of an attempt should take at least, by repetition, s."""


def cpu_times(actions: Sequence[Callable[[], Any]], effort: Effort) -> list[tuple[float, float]]:
    """Return (least, median) CPU time in s of each action, timed in turn over the rounds, with caches warm."""
    timers = [timeit.Timer(action, timer=clock.process_time) for action in actions]
    counts = [_repetitions(each, BLOCK if effort.effort == "full" else 0.0) for each in timers]
    rounds: list[list[float]] = [[] for _ in actions]
    for _ in range(effort.rounds):
        for timer, count, own in zip(timers, counts, rounds, strict=True):
            if count > 1:
                timer.timeit(1)
            own.append(timer.timeit(count) / count)
    return [(min(own), statistics.median(own)) for own in rounds]


def _repetitions(timer: timeit.Timer, block_s: float) -> int:
    """Return the repetitions of an action that fill a block; its first call is slow and says little."""
    first = timer.timeit(1)
    usual = first if first > block_s else timer.timeit(2) / 2.0
    return max(1, math.ceil(block_s / max(usual, 1e-7)))


def cheapest(points: Iterable[Point], target: float) -> Point | None:
    """Return the cheapest point within a target error whose method's next finer setting is within it too.

    That a setting is right by luck, where its error changes sign, does not count. Points of one method go from coarse to
    fine.
    """
    working = [point for point in points if not point.failure]
    candidates = []
    for method in dict.fromkeys(point.method for point in working):
        own = [point for point in working if point.method == method]
        pairs = zip(own, [*own[1:], own[-1]], strict=True)
        candidates += [point for point, finer in pairs if max(point.error, finer.error) <= target]
    return min(candidates, key=lambda each: each.cpu_s, default=None)
