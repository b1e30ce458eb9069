"""Processes that simulate for the bench, the interactive page of a tool.

A process of its own lets the server stop a simulation, and a crash ends that simulation alone.

Linear algebra runs in one thread in each process. The systems of equations of a run have three
rows; several threads, which wait for each other, made a run take three times as long while a map
was computed.

A process reads computations to do from its standard input, one in each line. It writes its progress
and its answer in one line each. All lines are JSON. A line with the number of a computation stops
that computation. The process ends when its input ends, and therefore with the server, however the
server ends.
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
import warnings
import weakref
from collections.abc import Callable, Iterator, Sequence
from typing import Any, BinaryIO

from bristle_sim.studies.sweep_workers import THREADS

TIME_LIMIT = 60.0
"""Time, s, after which a computation is ended.

A pass of the default tool takes 0.05 s to simulate, a pass of a wire of four links some seconds."""

GRACE = 3.0  # time, s, in which a stopped computation must end; then its process is ended
REPORTED = 0.2  # shortest time between two reports on the progress of a computation, s
STOPPED = "stopped by a newer run"

MOST_RUNNING = 4  # largest number of simultaneous computations; further ones wait up to TIME_LIMIT
# Largest number of waiting processes, each of about 100 MB: for a run, a map and a spare
MOST_IDLE = 3

Answer = dict[str, Any]


class Worker:
    """A process that waits for computations from the server and does one at a time.

    Attributes:
        reason: reason why the server has ended the process, in one line; otherwise empty.
        progress: finished fraction of the present computation, as last reported.
    """

    def __init__(self) -> None:
        """Start the process, which then imports the modules that it needs."""
        self.reason = ""
        self.progress = 0.0
        self._number = 0  # of the present computation
        self._process = subprocess.Popen(
            [sys.executable, "-c", f"from {__name__} import work; work()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=dict.fromkeys(THREADS, "1") | os.environ,
        )
        self._finalize = weakref.finalize(self, _end, self._process)

    def answer(self, kind: str, arguments: Sequence[Any]) -> Answer:
        """Let the process do a computation, and return its result.

        A result with the entry ``error`` gives the reason why the input was refused or why the
        process ended.
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
        """Whether the process still runs."""
        return self._process.poll() is None

    def stop(self) -> None:
        """Stop the present computation; end the process if the computation does not stop in time."""
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
        """End the process; the present computation then returns the reason as its error."""
        self.reason = reason
        self._process.kill()


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        with contextlib.suppress(OSError):  # a request that was never read
            pipe.close() if pipe is not None else None


class Workers:
    """The processes that compute for a server; a spare one is always started in advance."""

    def __init__(self) -> None:
        """Begin without processes; the first request starts one."""
        self._idle: list[Worker] = []
        self._running: dict[str, Worker] = {}
        self._lock = threading.Lock()
        self._free = threading.BoundedSemaphore(MOST_RUNNING)

    def answer(self, page: str, kind: str, *arguments: Any) -> Answer:
        """Do a computation for a page in a browser, and return its result.

        A new computation stops the earlier computation of the same page. An empty ``page`` stops
        nothing.
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
        """Return the finished fraction of a page's present computation; 0 if no progress is
        reported.
        """
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
    """Do computations until standard input ends; then end the process at once, even during a run."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C ends the server, and therefore standard input
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # for all other printed text
    jobs: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    watch = Watch(answers)

    def read() -> None:
        """Read requests for computations, and for their stop, until standard input ends."""
        for line in sys.stdin.buffer:
            if line.startswith(b"["):
                jobs.put(line)
            else:
                watch.stopped = int(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    warnings.simplefilter("ignore")  # the page shows what the user has to know
    from bristle_sim.cli.explore import bench
    from bristle_sim.cli.scenario import main_scenario

    kinds: dict[str, Callable[..., Answer]] = {
        "run": bench.run_of,
        "download": bench.download,
    }
    pass_of = main_scenario()
    bench.run_of(pass_of, [], [])  # imports the modules of a run
    logger = logging.getLogger("bristle_sim.scene.simulate")
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
    """Raised when the server has stopped the present computation."""


class Watch(logging.Handler):
    """Log handler that reports the progress of a computation and raises an error if it is stopped.

    Attributes:
        number: number of the present computation.
        stopped: number of the computation that was stopped last.
    """

    def __init__(self, answers: BinaryIO) -> None:
        super().__init__(logging.DEBUG)
        self.number = -1
        self.stopped = -2
        self._answers = answers
        self._reported = 0.0

    def emit(self, record: logging.LogRecord) -> None:
        """Report the progress in a log record to the server.

        Raises:
            StoppedError: if the present computation is stopped.
        """
        if self.stopped == self.number:
            raise StoppedError(STOPPED)
        if time.monotonic() - self._reported > REPORTED:
            self._reported = time.monotonic()
            self._answers.write(f"{record.getMessage()}\n".encode())
            self._answers.flush()
