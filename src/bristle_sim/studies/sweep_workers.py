"""Evaluation of a sweep's points in batches by processes, an executor or a Dask cluster.

Points that are lost with their worker are computed again.
"""

import itertools
import logging
import os
import pickle
import queue
from collections import Counter, deque
from collections.abc import Generator, Iterator
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from numbers import Integral
from typing import Any

import cloudpickle
import joblib
from joblib.externals.loky import ProcessPoolExecutor

from bristle_sim.studies.sweep_identity import name_of
from bristle_sim.studies.sweep_point import (
    LOST,
    THREADS,
    Function,
    Outcome,
    Point,
    evaluate_points,
    outcome_of,
)

LARGEST_BATCH = 4096  # Largest number of points that are sent to a worker at once
WAITING = (
    2  # Number of batches in progress per worker; with two, no worker waits for its next batch
)
WITHOUT_WORKER = (
    60.0  # Time without a finished batch after which the workers of a cluster are counted, s
)
# Number of workers that must be lost while they evaluate a point, alone in its batch, before the
# point counts as the cause.
ATTEMPTS = 3

Outcomes = Generator[tuple[Point, Outcome], None, None]


def evaluated(function: Function, points: Iterator[Point], workers: Any) -> Outcomes:
    """Evaluate points, and yield each point with its outcome as soon as it is finished.

    Raises:
        ValueError: if the function cannot be pickled for the workers.
        RuntimeError: if the workers stop responding.
    """
    own = isinstance(workers, Integral | None)
    number = joblib.effective_n_jobs(workers or 1) if own else 0
    if number == 1:
        for point in points:
            yield point, outcome_of(function, point[1])
        return
    sent: Function | bytes = function
    if not isinstance(workers, ThreadPoolExecutor):
        try:
            sent = cloudpickle.dumps(function)
        except Exception as error:
            words = f"function = {name_of(function)}: must be picklable, to be sent to the workers"
            raise ValueError(f"{words} ({_reason(error)})") from error
    executor = _Processes(number) if own else client_of(workers) or workers
    batches = _Batches(executor, sent, points)
    try:
        yield from batches.outcomes()
    finally:
        for future in batches.under_way:
            future.cancel()
        if own:
            executor.shutdown(kill_workers=bool(batches.under_way))


class _Processes(ProcessPoolExecutor):  # type: ignore[misc]
    """Pool of worker processes; if one of them is killed, all are replaced."""

    def __init__(self, number: int) -> None:
        threads = str(max(1, (os.cpu_count() or 1) // number))
        environment = {name: os.environ.get(name, threads) for name in THREADS}
        super().__init__(number, env=environment)

    def submit(self, *call: Any) -> Any:
        try:
            return super().submit(*call)
        except BrokenExecutor:
            self.__init__(self._max_workers)  # type: ignore[misc]
            return super().submit(*call)


def client_of(workers: Any) -> Any:
    """Return the Dask client if ``workers`` is a client or a client's executor, otherwise None.

    The client is preferred to the executor, since the executor may lose results of a worker that
    dies.
    """
    client = getattr(workers, "_client", workers)
    return client if hasattr(client, "get_executor") and hasattr(client, "scheduler_info") else None


class _Batches:
    """Batches of points that are sent to the workers.

    If a batch is lost with its worker, each of its points is suspected of having killed the worker.
    Batches are sent one at a time until a point has returned results. These first results fix the
    shapes of all results, which therefore do not depend on which worker finishes first.
    """

    def __init__(self, executor: Any, function: Function | bytes, points: Iterator[Point]) -> None:
        self.executor = executor
        self.function = function
        self.points = points
        self.options = {"pure": False} if client_of(executor) else {}
        self.under_way = dict[Any, list[Point]]()
        self.finished = queue.SimpleQueue[Any]()
        self.suspects = deque[Point]()
        self.losses = Counter[int]()
        self.size = 1  # of the next batch; larger as soon as a point has returned results

    def outcomes(self) -> Iterator[tuple[Point, Outcome]]:
        """Yield points with their outcomes until all points are finished."""
        while True:
            while batch := self._next():
                self._send(batch)
            if not self.under_way:
                return
            future = self._next_finished()
            batch = self.under_way.pop(future)
            try:
                outcomes = future.result()
            except Exception as error:
                yield from self._lost(batch, error)
                continue
            yield from zip(batch, outcomes, strict=False)
            if len(outcomes) < len(batch):  # the worker ran out of time
                self._send(batch[len(outcomes) :])
            if self.size > 1 or any(values for values, _ in outcomes):
                self.size = min(2 * len(outcomes), LARGEST_BATCH)

    def _next(self) -> list[Point]:
        """Return the next batch to send; it is empty if no batch can be sent yet.

        A point that is suspected of having killed its worker is sent alone, while no other batch is
        in progress.
        """
        most = 1 if self.size == 1 or self.suspects else WAITING * self._workers()
        if self.under_way and len(self.under_way) >= most:
            return []
        if self.suspects:
            return [self.suspects.popleft()]
        return list(itertools.islice(self.points, self.size))

    def _next_finished(self) -> Any:
        """Wait for a batch to finish, and return its future.

        A warning is logged while a cluster has no worker.
        """
        while True:
            try:
                return self.finished.get(timeout=WITHOUT_WORKER)
            except queue.Empty:
                if not self._workers():
                    words = "workers = %s: no worker for %.3g s; the sweep continues as soon as one is started"
                    logging.getLogger(__name__).warning(words, self.executor, WITHOUT_WORKER)

    def _workers(self) -> int:
        """Return the number of batches that can run at the same time.

        In a cluster this number may change.
        """
        if client_of(self.executor):
            return sum(self.executor.ncores().values())
        return getattr(self.executor, "_max_workers", None) or os.cpu_count() or 1

    def _send(self, batch: list[Point]) -> None:
        """Send a batch to the workers; if they refuse, the batch's future raises the error."""
        try:
            future = self._submitted(batch)
        except Exception as error:
            future = Future[Any]()
            future.set_exception(error)
        self.under_way[future] = batch
        future.add_done_callback(self.finished.put)

    def _submitted(self, batch: list[Point]) -> Any:
        call = (evaluate_points, self.function, pickle.dumps(batch))
        return self.executor.submit(*call, **self.options)

    def _lost(self, batch: list[Point], error: Exception) -> Iterator[tuple[Point, Outcome]]:
        """Queue the points of a lost batch again, or yield a point that has lost too many workers.

        Each point of the batch is tried again in a batch of its own. If a point, alone in its
        batch, has lost ATTEMPTS workers, it is given up and yielded with the reason. An empty batch
        tests beforehand whether any worker is left.

        Raises:
            RuntimeError: if no worker evaluates the empty batch.
        """
        number, arguments = batch[0]
        self.losses[number] += len(batch) == 1
        if self.losses[number] < ATTEMPTS:
            self.suspects.extendleft(batch[::-1])
            return
        try:
            self._submitted([]).result()
        except Exception as gone:
            words = f"workers: lost at the point {arguments}, and none answers any more ({_reason(gone)})"
            advice = (
                "if memory is short use fewer workers, if the point ends its process leave it out"
            )
            raise RuntimeError(f"{words}; {advice}") from error
        words = f"{LOST} {ATTEMPTS} times ({_reason(error)}); if memory is short use fewer workers"
        yield batch[0], ({}, words)


def _reason(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]
