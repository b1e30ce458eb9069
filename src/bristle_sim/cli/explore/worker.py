"""Processes that compute for the bench, the interactive page of a tool.

Separate processes let the server stop a computation, and a crash ends only that computation.

Linear algebra runs in one thread in each process. The systems of equations of a run have only three
rows. With several threads, which wait for each other, a run took three times as long while a map
was computed.

Server and process exchange pickled objects. The process reads computations, and requests to stop
the present one, from its standard input. It writes its progress, a float, and its answer to its
standard output. It ends when its standard input ends, and therefore with the server, however the
server ends. Unlike a process of multiprocessing, it does not import the program that started the
server.
"""

from __future__ import annotations

import contextlib
import logging
import os
import pickle
import pkgutil
import queue
import signal
import subprocess
import sys
import threading
import time
import warnings
import weakref
from typing import Any, BinaryIO

from bristle_sim.studies.sweep_point import THREADS

TIME_LIMIT = 60.0
"""Time (s) after which a computation is ended.

A pass of the default tool takes 0.05 s to simulate, a pass of a wire of four links several seconds."""

GRACE = 3.0  # time, s, in which a stopped computation must end; then its process is ended
REPORTED = 0.2  # shortest time between two reports on the progress of a computation, s
STOPPED = "stopped by a newer run"

MOST_RUNNING = 4  # largest number of simultaneous computations; further ones wait up to TIME_LIMIT
# Largest number of idle processes: one for a run, one for a map and a spare, each of about 100 MB
MOST_IDLE = 3

KINDS = {
    "run": "bench:run_of",
    "download": "bench:download",
    "map": "searches:map_of",
    "limits": "searches:limits_of",
    "design": "searches:design_of",
    "radial": "searches:radial_bar",
    "surface": "searches:surface_of",
}
"""Module and name of the function that answers a request, by the name of the request.

A module is imported only when a request needs it, since ``searches`` imports as many further
modules as ``bench``."""

Answer = dict[str, Any]


class Worker:
    """A process that waits for computations from the server and does one at a time.

    Attributes:
        progress: finished fraction of the present computation, as last reported.
        reason: reason why the server has ended the process, in one line; otherwise empty.
    """

    def __init__(self) -> None:
        """Start the process, which then imports the modules that it needs."""
        self.progress = 0.0
        self.reason = ""
        self._timers: list[threading.Timer] = []
        self._process: Any = subprocess.Popen(
            [sys.executable, "-c", f"from {__name__} import work; work()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=dict.fromkeys(THREADS, "1") | os.environ,
        )
        weakref.finalize(self, _end, self._process)

    def begin(self, kind: str, arguments: tuple[Any, ...]) -> None:
        """Let the process begin a computation; call :meth:`answer` and :meth:`rest` afterwards.

        Args:
            kind: kind of computation, a key of ``KINDS``.
            arguments: arguments of the function that computes.
        """
        late = f"not done in {TIME_LIMIT:g} s; take fewer links or a lower accuracy"
        self._end_after(TIME_LIMIT, late)
        self.progress = 0.0
        with contextlib.suppress(OSError):  # the process has ended
            self._send((kind, arguments))

    def answer(self) -> Answer:
        """Return the result of the computation.

        If the input was refused or the process ended, the entry ``error`` of the result states the
        reason.
        """
        try:
            while isinstance(found := pickle.load(self._process.stdout), float):
                self.progress = found
        except (EOFError, OSError, pickle.UnpicklingError):
            words = f"the process that computed this ended with status {self._process.wait()}; try other values"
            return {"error": self.reason or words}
        return dict(found)

    def stop(self) -> None:
        """Stop the present computation; if it still runs after GRACE seconds, end the process."""
        with contextlib.suppress(OSError):  # the process has ended
            self._send(None)
        self._end_after(GRACE, STOPPED)

    def rest(self) -> bool:
        """Cancel the time limits of the finished computation; return whether the process runs."""
        while self._timers:
            self._timers.pop().cancel()
        return self._process.poll() is None

    def _send(self, message: Any) -> None:
        self._process.stdin.write(pickle.dumps(message))
        self._process.stdin.flush()

    def _end_after(self, seconds: float, reason: str) -> None:
        def end() -> None:
            """End the process; :meth:`answer` then returns the reason."""
            self.reason = reason
            self._process.kill()

        timer = threading.Timer(seconds, end)
        timer.daemon = True
        timer.start()
        self._timers.append(timer)


def _end(process: Any) -> None:
    process.kill()
    process.communicate()


class Workers:
    """The processes that compute for a server. One idle process is always started in advance."""

    def __init__(self) -> None:
        """Begin without processes. The first request starts one."""
        self._idle: list[Worker] = []
        self._running: dict[str, Worker] = {}
        self._lock = threading.RLock()
        self._free = threading.BoundedSemaphore(MOST_RUNNING)

    def answer(self, page: str, kind: str, *arguments: Any) -> Answer:
        """Do a computation for a page in a browser, and return its result.

        A new computation stops the earlier computation of the same page. An empty ``page`` stops
        nothing. ``kind`` and ``arguments`` are those of :meth:`Worker.begin`.
        """
        self._stop(page)
        if not self._free.acquire(timeout=TIME_LIMIT):
            return {"error": "the server is busy; try again in a minute"}
        with self._lock:
            self._stop(page)
            self._idle = [each for each in self._idle if each.rest()]
            worker = self._idle.pop() if self._idle else Worker()
            if not self._idle:
                self._idle.append(Worker())  # a spare process, which now imports its modules
            if page:
                self._running[page] = worker
            worker.begin(kind, arguments)  # within the lock, before a newer computation can stop it
        try:
            return worker.answer()
        finally:
            self._free.release()
            with self._lock:
                if self._running.get(page) is worker:
                    del self._running[page]
                if worker.rest() and len(self._idle) < MOST_IDLE:
                    self._idle.append(worker)

    def progress(self, page: str) -> float:
        """Return the finished fraction of a page's present computation.

        It is 0 without a computation or without a report on its progress.
        """
        worker = self._running.get(page)
        return 0.0 if worker is None else worker.progress

    def _stop(self, page: str) -> None:
        with self._lock:
            if page in self._running:
                self._running[page].stop()


def work() -> None:
    """Do the computations that arrive on standard input.

    When standard input ends, the process ends at once, even during a computation.
    """
    # Ctrl-C is ignored here. It ends the server, and thereby standard input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # other prints go to standard error
    jobs: queue.SimpleQueue[Any] = queue.SimpleQueue()
    watch = Watch(answers)

    def read() -> None:
        """Read messages from standard input until it ends.

        A message is a computation, or None to stop the present computation.
        """
        with contextlib.suppress(EOFError, OSError):
            while True:
                message = pickle.load(sys.stdin.buffer)
                watch.stopped = message is None
                if message is not None:
                    jobs.put(message)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    warnings.simplefilter("ignore")  # warnings reach the user by the page
    from bristle_sim.cli.explore import bench
    from bristle_sim.cli.scenario import main_scenario

    pass_of = main_scenario()
    bench.run_of(pass_of, {}, {})  # imports the modules of a run
    logger = logging.getLogger("bristle_sim")
    logger.addHandler(watch)
    logger.setLevel(logging.DEBUG)
    while True:
        kind, arguments = jobs.get()
        try:
            function = pkgutil.resolve_name(f"{__package__}.{KINDS[kind]}")
            found = function(pass_of, *arguments)
        except (ValueError, ArithmeticError, StoppedError) as error:
            found = {"error": " ".join(str(error).split())}
        pickle.dump(found, answers)
        answers.flush()


class StoppedError(Exception):
    """Raised when the server has stopped the present computation."""


class Watch(logging.Handler):
    """Log handler that reports the progress of a computation, and stops the computation on request.

    Attributes:
        stopped: whether the present computation is to be stopped.
    """

    def __init__(self, answers: BinaryIO) -> None:
        super().__init__(logging.DEBUG)
        self.stopped = False
        self._answers = answers
        self._reported = 0.0

    def emit(self, record: logging.LogRecord) -> None:
        """Report to the server the progress that a log record states.

        Raises:
            StoppedError: if the present computation is to be stopped.
        """
        if self.stopped:
            raise StoppedError(STOPPED)
        if record.name.endswith("scene.run") and time.monotonic() - self._reported > REPORTED:
            self._reported = time.monotonic()
            pickle.dump(float(record.getMessage()), self._answers)
            self._answers.flush()
