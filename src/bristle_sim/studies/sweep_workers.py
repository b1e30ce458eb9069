"""Evaluation of a sweep's points in batches by processes, an executor or a Dask cluster.

Points that are lost with their worker are computed again.
"""

import itertools
import os
import pickle
import queue
from collections import Counter, deque
from collections.abc import Generator, Iterator
from concurrent.futures import BrokenExecutor, Executor, ThreadPoolExecutor
from typing import Any

import cloudpickle
import joblib
from joblib.externals.loky import ProcessPoolExecutor

from bristle_sim.studies.sweep_identity import name_of
from bristle_sim.studies.sweep_point import Function, Outcome, Point, evaluate_points, serially

LARGEST_BATCH = 4096  # Largest number of points that are sent to a worker at once
WAITING = 2  # Number of batches sent for each worker, so that no worker waits for its next batch
ATTEMPTS = 3  # Number of workers that a point alone in its batch must lose to count as the cause of the losses
# First words of the reason for failure of points that the next call on a store computes again
LOST = "lost with its worker"
# Environment variables of the libraries that start threads of their own
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


def evaluated(
    function: Function, points: Iterator[Point], workers: Any
) -> Generator[tuple[Point, Outcome], None, None]:
    """Yield points with their outcomes as they are finished.

    Only one batch runs until a point has returned results. This point fixes the shapes of the
    results, so they do not depend on which worker finishes first.

    Raises:
        ValueError: if the function cannot be pickled for the workers.
        RuntimeError: if the workers stop responding.
    """
    client = client_of(workers)
    own = client is None and not isinstance(workers, Executor)
    if own and joblib.effective_n_jobs(workers or 1) == 1:
        yield from serially(function, points)
        return
    pool: _Pool
    if client is not None:
        pool = _Cluster(client, getattr(workers, "_kwargs", {}))
    else:
        pool = _Processes(joblib.effective_n_jobs(workers)) if own else _Pool(workers)
    batches = _Batches(pool, _sent(function, workers), points)
    try:
        yield from batches.outcomes()
    finally:
        pool.stop([future for future, _ in batches.under_way.values()])


class _Pool:
    """Workers behind an executor of ``concurrent.futures``."""

    def __init__(self, executor: Any) -> None:
        self.executor = executor

    def submit(self, *call: Any) -> Any:
        """Start a call and return its future."""
        return self.executor.submit(*call)

    def workers(self) -> int:
        """Return the number of calls that run at the same time."""
        return getattr(self.executor, "_max_workers", None) or os.cpu_count() or 1

    def stop(self, futures: list[Any]) -> None:
        """Cancel the calls that are in progress."""
        for future in futures:
            future.cancel()


class _Processes(_Pool):
    """Worker processes that this sweep starts; if one of them is killed, all are replaced."""

    def __init__(self, number: int) -> None:
        threads = str(max(1, (os.cpu_count() or 1) // number))
        environment = {name: os.environ.get(name, threads) for name in THREADS}
        super().__init__(ProcessPoolExecutor(number, env=environment))

    def submit(self, *call: Any) -> Any:
        try:
            return self.executor.submit(*call)
        except BrokenExecutor:
            self.__init__(self.workers())  # type: ignore[misc]
            return self.executor.submit(*call)

    def stop(self, futures: list[Any]) -> None:
        self.executor.shutdown(kill_workers=bool(futures))


class _Cluster(_Pool):
    """Workers of a Dask client.

    The client is called directly, since its executor may lose the results of a worker that dies.
    """

    def __init__(self, client: Any, options: dict[str, Any]) -> None:
        super().__init__(client)
        self.options = {**options, "pure": False}

    def submit(self, *call: Any) -> Any:
        return self.executor.submit(*call, **self.options)

    def workers(self) -> int:
        threads: int = sum(self.executor.ncores().values())
        return max(1, threads)


def client_of(workers: Any) -> Any:
    """Return the Dask client if ``workers`` is a client or the executor of a client, else None."""
    client = getattr(workers, "_client", workers)
    return client if hasattr(client, "get_executor") and hasattr(client, "scheduler_info") else None


def _sent(function: Function, workers: Any) -> Function | bytes:
    """Return the function in the form in which it is sent to the workers: pickled, or as it is for
    threads.

    Raises:
        ValueError: if the function cannot be pickled.
    """
    if isinstance(workers, ThreadPoolExecutor):
        return function
    try:
        sent: bytes = cloudpickle.dumps(function)
    except Exception as error:
        words = f"function = {name_of(function)}: must be picklable, to be sent to the workers"
        raise ValueError(f"{words} ({_reason(error)})") from error
    return sent


class _Batches:
    """Batches of points on their way through the workers.

    A batch is in progress, left over because its worker ran out of time, or suspected of having
    killed its worker.
    """

    def __init__(self, pool: _Pool, function: Function | bytes, points: Iterator[Point]) -> None:
        self.pool = pool
        self.function = function
        self.points = points
        self.under_way = dict[int, tuple[Any, list[Point]]]()
        self.finished = queue.SimpleQueue[int]()
        self.left_over = deque[list[Point]]()
        self.suspects = deque[list[Point]]()
        self.keys = itertools.count()
        self.losses = Counter[int]()
        self.size = 1
        self.known = False

    def outcomes(self) -> Iterator[tuple[Point, Outcome]]:
        """Yield points with their outcomes until all points are finished."""
        while True:
            while batch := self._next():
                try:
                    self._start(batch)
                except Exception as error:
                    yield from self._lost(batch, error)
            if not self.under_way:
                return
            future, batch = self.under_way.pop(self.finished.get())
            try:
                outcomes = future.result()
            except Exception as error:
                yield from self._lost(batch, error)
            else:
                yield from zip(batch, outcomes, strict=False)
                if len(outcomes) < len(batch):
                    self.left_over.append(batch[len(outcomes) :])
                self.size = min(2 * len(outcomes), LARGEST_BATCH)
                self.known = self.known or any(values for values, _ in outcomes)

    def _next(self) -> list[Point]:
        """Return the next batch to send; empty if none can be sent now.

        A suspected batch is sent only while no other batch is in progress.
        """
        if self.suspects:
            return [] if self.under_way else self.suspects.popleft()
        if len(self.under_way) >= (WAITING * self.pool.workers() if self.known else 1):
            return []
        if self.left_over:
            return self.left_over.popleft()
        return list(itertools.islice(self.points, self.size))

    def _start(self, batch: list[Point]) -> None:
        key = next(self.keys)
        future = self.pool.submit(evaluate_points, self.function, pickle.dumps(batch))
        self.under_way[key] = future, batch
        future.add_done_callback(lambda _: self.finished.put(key))

    def _lost(self, batch: list[Point], error: Exception) -> Iterator[tuple[Point, Outcome]]:
        """Handle a batch that was lost with its worker.

        Its points become suspects and are tried again, each alone. A point that has lost its worker
        ATTEMPTS times alone counts as the cause and is yielded, with the reason.

        Raises:
            RuntimeError: if the workers do not evaluate an empty batch either.
        """
        if len(batch) > 1:
            self.suspects.extend([point] for point in batch)
            return
        number, arguments = batch[0]
        self.losses[number] += 1
        if self.losses[number] < ATTEMPTS:
            self.suspects.appendleft(batch)
            return
        try:
            self.pool.submit(evaluate_points, self.function, pickle.dumps([])).result()
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
