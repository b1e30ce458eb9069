"""Processes that compute for the bench, so that a run can be stopped and a fault ends a run but not
the server.

Their linear algebra has one thread. The systems of a run are of three rows, and threads that wait
for each other made a move take three times as long while the map is computed.

A worker reads jobs from its standard input, one in each line, and writes its progress and its
answer in one line each; all are JSON. A line with the number of a job stops that job. A worker ends
when its input ends, and therefore with the server, however that ends.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import queue
import signal
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Sequence
from typing import Any, BinaryIO

from bristle_sim.studies.sweep_workers import THREADS

TIME_LIMIT = 60.0
"""Longest time of an answer, s.

A run of the default tool takes 0.05 s, a run of a wire of four links some seconds."""

GRACE = 3.0  # longest time until a stopped job ends, s; after it the process is ended
REPORTED = 0.2  # shortest time between two reports on the progress of a job, s
STOPPED = "stopped by a newer run"

MOST_RUNNING = 4  # largest number of simultaneous answers; further requests wait up to TIME_LIMIT
MOST_IDLE = (
    3  # largest number of workers without a job, each of about 100 MB: for run, map, and one more
)

Answer = dict[str, Any]


class Worker:
    """A process that waits for jobs.

    Attributes:
        reason: reason why the server has ended the process, in one line; empty otherwise.
        progress: finished fraction of its job, as far as it is known.
    """

    def __init__(self) -> None:
        """Start the process, which imports its modules."""
        self.reason = ""
        self.progress = 0.0
        self._number = 0  # of its job
        self._process = subprocess.Popen(
            [sys.executable, "-c", f"from {__name__} import work; work()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=dict.fromkeys(THREADS, "1") | os.environ,
        )
        self._finalize = weakref.finalize(self, _end, self._process)

    def answer(self, kind: str, arguments: Sequence[Any]) -> Answer:
        """Return the answer to a job; ``error`` is the line of a refusal, or of the end of the
        process.
        """
        sent = self._process.stdin
        received = self._process.stdout
        assert sent is not None
        assert received is not None
        timer = threading.Timer(
            TIME_LIMIT,
            self.end,
            [f"not done in {TIME_LIMIT:g} s; take fewer links or a lower accuracy"],
        )
        timer.start()
        self.progress = 0.0
        try:
            sent.write(json.dumps([self._number, kind, arguments]).encode() + b"\n")
            sent.flush()
            while (line := received.readline())[:1].isdigit():
                self.progress = float(line)
        except OSError:  # the worker has ended
            line = b""
        finally:
            timer.cancel()
            self._number += 1
        if line.endswith(b"\n"):
            found: Answer = json.loads(line)
            return found
        status = self._process.wait()
        return {
            "error": self.reason
            or f"the process that computed this ended with status {status}; try other values"
        }

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process.poll() is None

    def stop(self) -> None:
        """Stop the job; end the process if the job does not stop in time."""
        number = self._number
        sent = self._process.stdin
        assert sent is not None
        with contextlib.suppress(OSError):  # the worker has ended
            sent.write(f"{number}\n".encode())
            sent.flush()
        late = threading.Timer(GRACE, self._end_late, [number])
        late.daemon = True
        late.start()

    def _end_late(self, number: int) -> None:
        if number == self._number:
            self.end(STOPPED)

    def end(self, reason: str = "") -> None:
        """End the process; the answer to its job then states the reason."""
        self.reason = reason
        self._process.kill()


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        with contextlib.suppress(OSError):  # a job that was never read
            pipe.close() if pipe is not None else None


class Workers:
    """The workers of a server; one always waits, so that a new one costs no time."""

    def __init__(self) -> None:
        """Start without workers; the first request starts one."""
        self._idle: list[Worker] = []
        self._running: dict[str, Worker] = {}
        self._lock = threading.Lock()
        self._free = threading.BoundedSemaphore(MOST_RUNNING)

    def answer(self, page: str, kind: str, *arguments: Any) -> Answer:
        """Return the answer to a job.

        A newer job of the same page stops the older one. A page "" has no other jobs.
        """
        with self._lock:
            if (older := self._running.get(page)) is not None:
                older.stop()
        if not self._free.acquire(timeout=TIME_LIMIT):
            return {"error": "the server is busy; try again in a minute"}
        try:
            with self._job(page) as worker:
                return worker.answer(kind, arguments)
        finally:
            self._free.release()

    def progress(self, page: str) -> float:
        """Return the finished fraction of the job of a page; 0 if it is unknown."""
        worker = self._running.get(page)
        return 0.0 if worker is None else worker.progress

    @contextlib.contextmanager
    def _job(self, page: str) -> Iterator[Worker]:
        with self._lock:
            self._idle = [each for each in self._idle if each.alive]
            worker = self._idle.pop() if self._idle else Worker()
            if not self._idle:
                self._idle.append(Worker())  # taken last, as it has to import what it needs
            if page:
                if (older := self._running.get(page)) is not None:
                    older.stop()
                self._running[page] = worker
        try:
            yield worker
        finally:
            with self._lock:
                if self._running.get(page) is worker:
                    del self._running[page]
                if not worker.reason and worker.alive and len(self._idle) < MOST_IDLE:
                    self._idle.append(worker)


def work() -> None:
    """Answer jobs until standard input ends, then end at once, even during a run."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C ends the server, and therefore standard input
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # for all other printed text
    jobs: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    watch = Watch(answers)

    def read() -> None:
        """Read jobs and stops from standard input until it ends."""
        for line in sys.stdin.buffer:
            if line.startswith(b"["):
                jobs.put(line)
            else:
                watch.stopped = int(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    from bristle_sim.cli.explore import bench
    from bristle_sim.cli.scripts import main_scenario

    kinds: dict[str, Callable[..., Answer]] = {
        "run": bench.run_of,
        "download": bench.download,
    }
    pass_of = main_scenario()
    bench.run_of(pass_of, [], [])  # imports the modules of a run
    logger = logging.getLogger("bristle_sim.scene.run")
    logger.addHandler(watch)
    logger.setLevel(logging.DEBUG)
    while True:
        watch.number, kind, arguments = json.loads(jobs.get())
        if kind not in kinds:  # the first search: what it imports takes as long as the start
            from bristle_sim.cli.explore import searches

            kinds |= searches.KINDS
        try:
            found = kinds[kind](pass_of, *arguments)
        except (ValueError, ArithmeticError, StoppedError) as error:
            found = {"error": " ".join(str(error).split())}
        answers.write(json.dumps(found).encode() + b"\n")
        answers.flush()


class StoppedError(Exception):
    """Error: the server has stopped the job."""


class Watch(logging.Handler):
    """Log handler that reports the progress of a run, and ends the run if its job is stopped.

    Attributes:
        number: number of the present job.
        stopped: number of the last stopped job.
    """

    def __init__(self, answers: BinaryIO) -> None:
        super().__init__(logging.DEBUG)
        self.number = -1
        self.stopped = -2
        self._answers = answers
        self._reported = 0.0

    def emit(self, record: logging.LogRecord) -> None:
        """Report the fraction in a log record.

        Raises:
            StoppedError: if the job is stopped.
        """
        if self.stopped == self.number:
            raise StoppedError(STOPPED)
        if time.monotonic() - self._reported > REPORTED:
            self._reported = time.monotonic()
            self._answers.write(f"{record.getMessage()}\n".encode())
            self._answers.flush()
