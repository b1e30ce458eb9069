"""Batches of a sweep's points on processes, an executor or a Dask cluster; points that are lost are computed again."""

import itertools
import logging
import os
import pickle
import queue
import time
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import suppress
from functools import lru_cache
from typing import Any

import cloudpickle
import joblib
from joblib.externals.loky import ProcessPoolExecutor as LokyExecutor
from joblib.externals.loky.process_executor import ShutdownExecutorError
from joblib.parallel import get_active_backend

from bristle_sim.studies.sweep_identity import name_of
from bristle_sim.studies.sweep_point import Function, Outcome, Point, evaluate_points, serially

LARGEST_BATCH = 4096  # Most points that are sent to a worker at once
WAITING = 2  # Batches for each worker that are under way, so that none waits for the next one
ATTEMPTS = 3  # Losses of a point alone in its batch after which the point is taken for the cause
PIECES = 16  # Number of batches into which a lost one is divided
LOOK_EVERY = 5.0  # Interval between counts of a cluster's workers, s
WITHOUT_WORKER = 60.0  # Time without any worker of a cluster after which it is said, s
IDLE = 300.0  # Time after which processes that have nothing to do end, s
LOST = "lost with its worker"  # Begin of the reason of points that the next call on a store computes again


def evaluated(
    function: Function, points: Iterator[Point], workers: Any
) -> Generator[tuple[Point, Outcome], None, None]:
    """Yield points with their outcomes as they are finished.

    Until a point has results one batch is under way at a time, so that their shapes do not depend on the workers.

    Raises:
        ValueError: if the function cannot be pickled for the workers.
        RuntimeError: if the workers do not answer any more.
    """
    pool = _pool(workers)
    if pool is None:
        yield from serially(function, points)
        return
    batches = _Batches(pool, _sent(function, pool.executor), points)
    try:
        yield from batches.outcomes()
    finally:
        pool.stop([future for future, _ in batches.under_way.values()])


class _Pool:
    """An executor of ``concurrent.futures``."""

    def __init__(self, executor: Any) -> None:
        self.executor = executor

    def submit(self, *call: Any) -> Any:
        """Start a call and return its future."""
        return self.executor.submit(*call)

    def result(self, future: Any) -> Any:
        """Return the result of a finished call."""
        return future.result()

    def workers(self) -> int:
        """Return the number of calls that run at the same time."""
        return getattr(self.executor, "_max_workers", None) or os.cpu_count() or 1

    def look(self) -> None:
        """Say what a user should know while no batch returns."""

    def stop(self, futures: list[Any]) -> None:
        """Give up the calls that are under way."""
        for future in futures:
            future.cancel()


class _Processes(_Pool):
    """Processes that stay for the next sweep; they are replaced if one of them is killed."""

    def __init__(self, number: int) -> None:
        threads = str(max(1, (os.cpu_count() or 1) // number))
        names = (
            "OMP_NUM_THREADS",
            "OPENBLAS_NUM_THREADS",
            "MKL_NUM_THREADS",
            "VECLIB_MAXIMUM_THREADS",
        )
        self.number = number
        self.environment = tuple((name, os.environ.get(name, threads)) for name in names)
        super().__init__(_kept_processes(number, self.environment))

    def submit(self, *call: Any) -> Any:
        """Start a call and return its future, on new processes if the last ones were lost."""
        try:
            return self.executor.submit(*call)
        except (BrokenExecutor, ShutdownExecutorError):
            _kept_processes.cache_clear()
            self.executor = _kept_processes(self.number, self.environment)
            return self.executor.submit(*call)

    def workers(self) -> int:
        return self.number

    def stop(self, futures: list[Any]) -> None:
        if futures:
            _kept_processes.cache_clear()
            self.executor.shutdown(kill_workers=True)


@lru_cache(maxsize=1)
def _kept_processes(number: int, environment: tuple[tuple[str, str], ...]) -> Any:
    """Return processes that stay for the next sweep. They are not those that joblib keeps, which need its own set-up."""
    return LokyExecutor(number, timeout=IDLE, env=dict(environment))


class _OwnThreads(_Pool):
    """Threads of this process, which end with the sweep."""

    def stop(self, futures: list[Any]) -> None:
        self.executor.shutdown(wait=not futures, cancel_futures=True)


class _Cluster(_Pool):
    """The workers of a Dask client, called without its executor: that one may lose results of a worker that dies."""

    def __init__(self, client: Any, options: dict[str, Any]) -> None:
        super().__init__(client)
        self.options = {**options, "pure": False}
        self.number = 0
        self.counted = -LOOK_EVERY
        self.seen = time.monotonic()
        self.said = False

    def submit(self, *call: Any) -> Any:
        return self.executor.submit(*call, **self.options)

    def result(self, future: Any) -> Any:
        """Return a result, which is computed again if its worker died before it was fetched."""
        while True:
            try:
                return future.result(timeout=LOOK_EVERY)
            except TimeoutError:
                if future.status == "error":
                    raise
                self.look()

    def workers(self) -> int:
        if time.monotonic() >= self.counted + LOOK_EVERY:
            self.look()
        return max(1, self.number)

    def look(self) -> None:
        """Count the cluster's threads, and say once that there has been none for a while."""
        self.number = 0
        with suppress(Exception):  # a scheduler that does not answer has no workers
            self.number = sum(self.executor.ncores().values())
        self.counted = time.monotonic()
        if self.number:
            self.seen = self.counted
            self.said = False
        elif not self.said and self.counted - self.seen >= WITHOUT_WORKER:
            self.said = True
            words = (
                "workers = %s: no worker for %.0f s; the sweep goes on as soon as one is started"
            )
            logging.getLogger(__name__).warning(words, self.executor, self.counted - self.seen)


def client_of(workers: Any) -> Any:
    """Return the Dask client that ``workers`` is, or whose executor it is, else None."""
    client = getattr(workers, "_client", workers)
    return client if hasattr(client, "get_executor") and hasattr(client, "scheduler_info") else None


def _pool(workers: Any) -> _Pool | None:
    """Return the workers; None stands for the calling process."""
    if client := client_of(
        workers if workers is not None else getattr(get_active_backend()[0], "client", None)
    ):
        return _Cluster(client, getattr(workers, "_kwargs", {}))
    if isinstance(workers, Executor):
        return _Pool(workers)
    number = joblib.effective_n_jobs(workers)
    if number == 1:
        return None
    if workers is None and get_active_backend()[0].uses_threads:
        return _OwnThreads(ThreadPoolExecutor(number))
    return _Processes(number)


def _sent(function: Function, executor: Any) -> Function | bytes:
    """Return the function as it is sent to the workers, pickled but for threads. Raises ValueError if it cannot be pickled."""
    if isinstance(executor, ThreadPoolExecutor):
        return function
    dumps: Callable[..., bytes] = (
        pickle.dumps if isinstance(executor, ProcessPoolExecutor) else cloudpickle.dumps
    )
    try:
        return dumps(function)
    except Exception as error:
        words = f"function = {name_of(function)}: must be picklable, to be sent to the workers"
        raise ValueError(f"{words} ({_reason(error)})") from error


class _Batches:
    """Batches of points that are under way, left over from a turn, or suspected of the loss of a worker."""

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
        """Yield points with their outcomes until all are finished."""
        while True:
            while self._has_room() and (batch := self._next()):
                try:
                    self._start(batch)
                except Exception as error:
                    yield from self._lost(batch, error)
            if not self.under_way:
                return
            future, batch = self.under_way.pop(self._wait())
            try:
                outcomes = self.pool.result(future)
            except Exception as error:
                yield from self._lost(batch, error)
            else:
                yield from zip(batch, outcomes, strict=False)
                self._took(batch, outcomes)

    def _has_room(self) -> bool:
        return len(self.under_way) < (WAITING * self.pool.workers() if self.known else 1)

    def _next(self) -> list[Point]:
        """Return the next batch, suspects one at a time while nothing else is under way."""
        if self.suspects:
            return [] if self.under_way else self.suspects.popleft()
        if self.left_over:
            return self.left_over.popleft()
        return list(itertools.islice(self.points, self.size))

    def _start(self, batch: list[Point]) -> None:
        key = next(self.keys)
        future = self.pool.submit(evaluate_points, self.function, pickle.dumps(batch))
        self.under_way[key] = future, batch
        future.add_done_callback(lambda _: self.finished.put(key))

    def _wait(self) -> int:
        """Return the key of a batch that is finished or lost."""
        while True:
            try:
                return self.finished.get(timeout=LOOK_EVERY)
            except queue.Empty:
                self.pool.look()

    def _took(self, batch: list[Point], outcomes: list[Outcome]) -> None:
        """Keep the rest of a batch for another turn, and choose the size of the next ones."""
        if len(outcomes) < len(batch):
            self.left_over.append(batch[len(outcomes) :])
        self.size = min(2 * len(outcomes), LARGEST_BATCH)
        self.known = self.known or any(values for values, _ in outcomes)

    def _lost(self, batch: list[Point], error: Exception) -> Iterator[tuple[Point, Outcome]]:
        """Keep a lost batch in pieces for another attempt; yield a point that is the cause, with the reason.

        Raises RuntimeError if the workers do not evaluate an empty batch either.
        """
        if len(batch) > 1:
            step = -(-len(batch) // PIECES)
            self.suspects.extend(batch[i : i + step] for i in range(0, len(batch), step))
            return
        number, arguments = batch[0]
        self.losses[number] += 1
        if self.losses[number] < ATTEMPTS:
            self.suspects.appendleft(batch)
            return
        try:
            self._start([])
            self.pool.result(self.under_way.pop(self._wait())[0])
        except Exception as gone:
            words = f"workers: lost at the point {arguments}, and none answers any more ({_reason(gone)})"
            advice = (
                "if memory is short use fewer workers, if the point ends its process leave it out"
            )
            raise RuntimeError(f"{words}; {advice}") from error
        yield (
            batch[0],
            (
                {},
                f"{LOST} {ATTEMPTS} times ({_reason(error)}); if memory is short use fewer workers",
            ),
        )


def _reason(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]
