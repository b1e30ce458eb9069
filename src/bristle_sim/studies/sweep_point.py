"""Points of a sweep: the outcome of one, and many by joblib's scheduler; worker processes import no more than this module."""

from __future__ import annotations

import dataclasses
import itertools
import os
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import BrokenExecutor, CancelledError, Executor
from contextlib import closing
from typing import Any

import joblib
import numpy as np
from joblib.externals.loky.process_executor import BrokenProcessPool
from joblib.parallel import get_active_backend

from bristle_sim.arrays import Array
from bristle_sim.studies.sweep_identity import name_of
from bristle_sim.trajectory.records import ContactRecord

Function = Callable[..., Any]
Point = tuple[int, dict[str, Any]]  # number of a point in its grid, and its arguments
Outcome = tuple[dict[str, Array], str]  # results of a point by name, and the reason why there are none, or empty
FAILURE = "failure"  # Variable that says why a point has no results, or lacks some

CONTACT_FIELDS = {each.name for each in dataclasses.fields(ContactRecord)}

# Time after which a worker returns the points that it has finished, s; those that it has not returned are lost with
# it
TURN = 0.3
LARGEST_BATCH = 4096  # Most points that are sent to a worker at once
# Successive losses of a worker without a result between them, after which the point is taken for the cause
ATTEMPTS = 3


def evaluate_points(function: Function, points: list[Point]) -> list[tuple[Point, Outcome]]:
    """Return the points that are finished within a turn with their outcomes, the first one in any case."""
    end, found = time.perf_counter() + TURN, list[tuple[Point, Outcome]]()
    for point in points:
        found.append((point, _outcome(function, point[1])))
        if time.perf_counter() > end:
            break
    return found


def _outcome(function: Function, arguments: dict[str, Any]) -> Outcome:
    """Return the results of a function, or the reason why it raised: a ValueError's message, other errors with their type."""
    try:
        result = function(**arguments)
        named = dict(result) if isinstance(result, Mapping) else {"result": result}
        reason = str(named.pop(FAILURE, ""))
        return {str(name): np.asarray(value, dtype=float) for name, value in named.items()}, reason
    except Exception as error:
        reason = " ".join(str(error).split())
        if isinstance(error, AttributeError) and error.obj is None and error.name in CONTACT_FIELDS:
            return {}, f"no strike: {error.name} was read of None, the first_contact of a run without that contact"
        return {}, reason if reason and isinstance(error, ValueError) else f"{type(error).__name__}: {reason}"


def evaluated(
    function: Function, points: Iterator[Point], workers: int | Executor | None
) -> Generator[tuple[Point, Outcome], None, None]:
    """Yield points with their outcomes as they are finished; points that lost a worker come last, one by one.

    Until a point has results one batch is under way at a time, so that their shapes do not depend on the workers.

    Raises:
        ValueError: if the workers cannot receive the function.
        RuntimeError: if workers are killed time and again.
    """
    left_over, suspects, under_way = deque[list[Point]](), deque[list[Point]](), dict[int, list[Point]]()
    size, lost, known = 1, 0, False

    def tasks() -> Iterator[Any]:
        """Yield points left over from a turn, then new ones, and last those of lost workers, one at a time."""
        while batch := left_over.popleft() if left_over else list(itertools.islice(points, size)):
            under_way[batch[0][0]] = batch
            yield joblib.delayed(call)(function, batch)
        if suspects and not under_way:
            under_way[suspects[0][0][0]] = suspects[0]
            yield joblib.delayed(call)(function, suspects.popleft())

    while True:
        scheduler, call = _scheduler(workers)  # anew, as one that has lost a worker returns results of its old tasks
        if not (first := next(others := tasks(), None)):
            return
        try:
            with closing(scheduler(itertools.chain([first], others if known else []))) as results:
                for found in results:
                    batch = under_way.pop(found[0][0][0])
                    left_over.extend([batch[len(found) :]] if len(found) < len(batch) else [])
                    lost, size = 0, min(2 * len(found), LARGEST_BATCH)
                    known = known or any(values for _, (values, _) in found)
                    yield from found
        except (Exception, CancelledError) as error:
            reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
            gone = isinstance(error, (BrokenExecutor, CancelledError)) or type(error).__name__ == "KilledWorker"
            if type(error) is BrokenProcessPool or not gone:  # loky's class, of tasks that a worker could not read
                words = f"function = {name_of(function)}: must be picklable, to be sent to the workers ({reason})"
                raise ValueError(words) from error
            lost += 1
            if lost == ATTEMPTS or (isinstance(workers, Executor) and isinstance(error, BrokenExecutor)):
                raise RuntimeError(
                    f"workers were lost {lost} times near the point {next(iter(under_way.values()))[0][1]}; if memory is"
                    f" short try fewer workers, if the point crashes its process leave it out ({reason})"
                ) from error
            suspects.extend([point] for batch in under_way.values() for point in batch)
            under_way.clear()


def _scheduler(workers: int | Executor | None) -> tuple[joblib.Parallel, Callable[..., Any]]:
    """Return joblib's scheduler and the function that it calls: in its own workers, or in threads that wait for an executor."""
    # joblib's own backend for Dask would wait for ever for points that the cluster has given up.
    client = getattr(get_active_backend()[0], "client", None) if workers is None else getattr(workers, "_client", None)
    executor = client.get_executor(pure=False) if client and workers is None else workers
    options = {"return_as": "generator_unordered", "batch_size": 1}
    if not isinstance(executor, Executor):
        return joblib.Parallel(workers, **options), evaluate_points
    number = sum(client.ncores().values()) if client else getattr(executor, "_max_workers", None) or os.cpu_count()
    pure: dict[str, Any] = {"pure": False} if client else {}

    def call(*arguments: Any) -> Any:
        """Wait for the points that an executor evaluates, as impure calls: Dask would recall pure ones that lost a worker."""
        return executor.submit(evaluate_points, *arguments, **pure).result()

    return joblib.Parallel(2 * int(number or 1), backend="threading", **options), call
