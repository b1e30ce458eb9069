"""The processes that compute for the bench, so that a run can be ended, and a fault ends a run and not the server.

A worker reads one job a line from its standard input, and writes its progress and its answer, a line each, all JSON. A line with
a job's number stops that job. A worker ends when its input ends, and so with the server, however that ends.
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

TIME_LIMIT = 60.0
"""Longest time that an answer may take, s. A run of the default tool takes 0.05 s, that of a wire of four links some seconds."""

GRACE = 3.0  # longest time in which a stopped job must end, s; its process is ended then
REPORTED = 0.2  # shortest time between two reports on a job's progress, s
STOPPED = "stopped by a newer run"

MOST_RUNNING = 4  # answers computed at once; further requests wait for as long as TIME_LIMIT

MOST_IDLE = 2  # workers kept without a job; each holds about 100 MB

Answer = dict[str, Any]


class Worker:
    """A process that waits for jobs.

    Attributes:
        reason: the line that says why it was ended, if the server has ended it.
        progress: the fraction of its job that is done, as far as it is known.
    """

    def __init__(self) -> None:
        """Start the process, which begins to import what it needs."""
        self.reason = ""
        self.progress = 0.0
        self._number = 0  # of its job
        command = [sys.executable, "-c", f"from {__name__} import work; work()"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._finalize = weakref.finalize(self, _end, self._process)

    def answer(self, kind: str, arguments: Sequence[Any]) -> Answer:
        """Return the answer to a job; ``error`` is the one line of a refusal, or of the worker's end."""
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
        """Stop the job, and end the process if it has not stopped in time."""
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
        """End the process, for a reason that its answer then gives."""
        self.reason = reason
        self._process.kill()


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        with contextlib.suppress(OSError):  # a job that was never read
            pipe.close() if pipe is not None else None


class Workers:
    """The workers of a server, one of which always waits, so that replacing one costs no time."""

    def __init__(self) -> None:
        """Start no worker before the first request."""
        self._idle: list[Worker] = []
        self._running: dict[str, Worker] = {}
        self._lock = threading.Lock()
        self._free = threading.BoundedSemaphore(MOST_RUNNING)

    def answer(self, page: str, kind: str, *arguments: Any) -> Answer:
        """Return the answer to a job. A newer job of the same page ends its older one; a page "" has no other jobs."""
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
        """Return the fraction of a page's job that is done; 0 if it is not known."""
        worker = self._running.get(page)
        return 0.0 if worker is None else worker.progress

    @contextlib.contextmanager
    def _job(self, page: str) -> Iterator[Worker]:
        with self._lock:
            self._idle = [each for each in self._idle if each.alive]
            worker = self._idle.pop() if self._idle else Worker()
            if not self._idle:
                self._idle.append(Worker())
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
                    self._idle.insert(0, worker)


def work() -> None:
    """Answer jobs until standard input ends, then end at once, in the middle of a run too."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C ends the server, and with it standard input
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # where anything printed goes
    jobs: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    watch = Watch(answers)

    def read() -> None:
        for line in sys.stdin.buffer:
            if line.startswith(b"["):
                jobs.put(line)
            else:
                watch.stopped = int(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    from bristle_sim.cli.explore import bench, searches
    from bristle_sim.cli.scripts import main_scenario

    kinds: dict[str, Callable[..., Answer]] = {
        "run": bench.run_of,
        "radial": searches.radial_bar,
        "map": searches.map_of,
        "limits": searches.limits_of,
        "design": searches.design_of,
        "download": bench.download,
    }
    pass_of = main_scenario()
    bench.run_of(pass_of, [], [])  # imports what a run needs
    logger = logging.getLogger("bristle_sim.scene.run")
    logger.addHandler(watch)
    logger.setLevel(logging.DEBUG)
    while True:
        watch.number, kind, arguments = json.loads(jobs.get())
        try:
            found = kinds[kind](pass_of, *arguments)
        except (ValueError, ArithmeticError, StoppedError) as error:
            found = {"error": " ".join(str(error).split())}
        answers.write(json.dumps(found).encode() + b"\n")
        answers.flush()


class StoppedError(Exception):
    """The server has stopped the job."""


class Watch(logging.Handler):
    """Reports the progress that a run logs, and ends the run if its job is stopped.

    Attributes:
        number: of the present job.
        stopped: number of the last job that was stopped.
    """

    def __init__(self, answers: BinaryIO) -> None:
        super().__init__(logging.DEBUG)
        self.number = -1
        self.stopped = -2
        self._answers = answers
        self._reported = 0.0

    def emit(self, record: logging.LogRecord) -> None:
        """Report the fraction that is the record's argument. Raises StoppedError."""
        if self.stopped == self.number:
            raise StoppedError(STOPPED)
        if time.monotonic() - self._reported > REPORTED:
            self._reported = time.monotonic()
            self._answers.write(f"{record.getMessage()}\n".encode())
            self._answers.flush()
