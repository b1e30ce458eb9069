"""Error and time of attempts at a case, in separate passes.

First every attempt is run once and its error noted, which also warms it up. Then all attempts are timed in rounds, each
round going through all of them in turn, so that whatever else the machine is doing hits all alike. Times are CPU times
of the process. The least of the rounds is what the attempt costs; what is above it is the machine's noise, which the
median shows.
"""

from __future__ import annotations

import dataclasses
import math
import statistics
import time as clock
import timeit
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.units import Declared, choice

OURS = "bristle_sim"
"""This package among those that are measured."""


@dataclass(frozen=True, slots=True)
class Effort(Declared):
    """How much to measure."""

    effort: str = choice(
        "full",
        "effort",
        ("full", "quick"),
        source="chosen: quick measures too little to compare",
        meaning="how many settings are timed and how often",
    )
    peers: str = choice(
        "all",
        "peers",
        ("all", "none"),
        source="chosen: every installed peer takes part",
        meaning="whether other packages are timed too",
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
    """One method with one setting; ``run`` does all that is timed, and what it needs beforehand is made before.

    Settings of one method go from coarse to fine. ``method`` begins with the package's name.
    """

    method: str
    setting: str
    run: Callable[[], Run]


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
    """What was added to a scene, what it cost (CPU s) and how that compares with the first row of its kind.

    ``what`` is ``engine step``, ``pass``, ``strike``, or ``links`` or ``bristles``, whose number the effect is; ``holds``
    counts what the scene has; ``steps`` are engine steps taken.
    """

    what: str
    effect: str
    cpu_s: float
    ratio: float
    holds: str
    steps: int | None = None


def plain(record: Point | Effect) -> dict[str, Any]:
    """Return the record as plain values, None for what is not finite."""
    values = dataclasses.asdict(record).items()
    return {key: None if isinstance(each, float) and not math.isfinite(each) else each for key, each in values}


def package_of(method: str) -> str:
    """Return the package that a method belongs to."""
    return method.split(maxsplit=1)[0]


def thinned(attempts: Sequence[Attempt], settings: int) -> list[Attempt]:
    """Return at most a number of settings of each method, evenly spread, the coarsest among them."""
    methods = dict.fromkeys(each.method for each in attempts)
    own = [[each for each in attempts if each.method == method] for method in methods]
    return [each for group in own for each in group[:: -(-len(group) // settings)]]


def measure(case: Case, attempts: Iterable[Attempt], effort: Effort) -> list[Point]:
    """Find errors first, then times, of every attempt."""
    tried = [(attempt, _tried(case, attempt)) for attempt in attempts]
    times = iter(cpu_times([attempt.run for attempt, point in tried if not point.failure], effort))
    found = []
    for _, point in tried:
        least, median = (math.nan, math.nan) if point.failure else next(times)
        found.append(dataclasses.replace(point, cpu_s=least, cpu_s_median=median))
    return found


def _tried(case: Case, attempt: Attempt) -> Point:
    """Run an attempt once; whatever a tool raises, and each has kinds of its own, is its result and not the study's failure."""
    error, steps, failure = math.inf, 0, ""
    try:
        run = attempt.run()
        error, steps = case.error(run.values), run.steps
    except Exception as raised:
        failure = " ".join(str(raised).split()) or type(raised).__name__
    return Point(case.name, attempt.method, attempt.setting, error, math.nan, math.nan, steps, failure)


BLOCK = 4e-3
"""CPU time that one timing of an attempt should take at least, by repetition, s."""


def cpu_times(actions: Sequence[Callable[[], Any]], effort: Effort) -> list[tuple[float, float]]:
    """Return (least, median) CPU time in s of each action, timed in turn over the rounds, with caches warm."""
    counts = [_repetitions(action, BLOCK if effort.effort == "full" else 0.0) for action in actions]
    rounds: list[list[float]] = [[] for _ in actions]
    for _ in range(effort.rounds):
        for action, count, own in zip(actions, counts, rounds, strict=True):
            if count > 1:
                action()
            own.append(_timed(action, count) / count)
    return [(min(own), statistics.median(own)) for own in rounds]


def _repetitions(action: Callable[[], Any], block_s: float) -> int:
    """Return the repetitions of an action that fill a block; its first call is slow and tells nothing."""
    first = _timed(action, 1)
    usual = first if first > block_s else _timed(action, 2) / 2.0
    return max(1, math.ceil(block_s / max(usual, 1e-7)))


def _timed(action: Callable[[], Any], count: int) -> float:
    return timeit.timeit(action, timer=clock.process_time, number=count)


def cheapest(points: Iterable[Point], target: float) -> Point | None:
    """Return the cheapest point within a target error whose method's next finer setting is within it too.

    That a setting is right by luck, where its error changes sign, does not count. Points of one method go from coarse to
    fine.
    """
    methods: dict[str, list[Point]] = {}
    for point in points:
        if not point.failure:
            methods.setdefault(point.method, []).append(point)
    candidates = [
        point
        for own in methods.values()
        for point, finer in zip(own, [*own[1:], own[-1]], strict=True)
        if point.error <= target and finer.error <= target
    ]
    return min(candidates, key=lambda each: each.cpu_s, default=None)
