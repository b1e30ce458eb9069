"""Output of a scenario as text, JSON and CSV, its progress, and an orderly end after a signal."""

from __future__ import annotations

import _thread
import csv
import io
import json
import logging
import math
import os
import shutil
import signal
import sys
import textwrap
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from bristle_sim.comparison import Report, table
from bristle_sim.files import complete_or_absent
from bristle_sim.readable import WIDTH, finite
from bristle_sim.version import __version__, named_commit

# Time between two printed progress reports, s: on a terminal, and on any other stream
REFRESH = 0.5
SILENCE = 15.0
# Exit status that a shell reports for a command ended by a signal, minus the signal's number
SIGNALLED = 128
LATER = 1e-3  # delay, s, after which a signal that arrived within pymunk is repeated

USUAL: dict[int, Any] = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
if sys.platform != "win32":
    USUAL[signal.SIGHUP] = signal.SIG_DFL  # the terminal was closed
"""Python's default handlers, by signal, of the signals that end a computation in good order."""


@contextmanager
def progress(program: str) -> Iterator[None]:
    """Show the progress of a long computation on standard error while the context is active.

    Each line begins with ``program``, the name of the program. A terminal shows the progress in a
    single line that is overwritten. Any other stream gets a new line every SILENCE seconds.
    """
    if sys.stderr is None:
        yield
        return
    log = logging.getLogger("bristle_sim")
    ended = threading.Event()
    shown = _Progress(logging.INFO)
    shown.program = program
    reminder = threading.Thread(target=shown.remind, args=(ended,), daemon=True)
    level = log.level
    log.addHandler(shown)
    log.setLevel(logging.INFO)
    reminder.start()
    try:
        yield
    finally:
        ended.set()
        reminder.join()
        log.removeHandler(shown)
        log.setLevel(level)


class _Progress(logging.Handler):
    """Log handler that stores the latest progress report of a computation and prints warnings at
    once.
    """

    program = ""
    last = "computing"

    def emit(self, record: logging.LogRecord) -> None:
        """Store a progress report, or print a warning."""
        if record.levelno >= logging.WARNING:
            print_error(f"{self.program}: warning: {record.getMessage()}")
        else:
            self.last = record.getMessage()

    def remind(self, ended: threading.Event) -> None:
        """Print the elapsed time and the latest report at intervals until ``ended`` is set.

        Nothing is printed while a progress bar is shown.
        """
        started = time.monotonic()
        terminal = sys.stderr.isatty()
        line = "\r\x1b[K{}" if terminal else "{}\n"
        while not ended.wait(REFRESH if terminal else SILENCE):
            if not getattr(getattr(sys.modules.get("tqdm"), "tqdm", None), "_instances", ()):
                passed = f"{time.monotonic() - started:.0f} s"
                words = f"{self.program}: {passed}: {self.last}"
                print(line.format(words), end="", file=sys.stderr, flush=True)
        if terminal:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


@contextmanager
def ending_in_order() -> Iterator[None]:
    """While the context is active, let a signal end a long computation by an exception.

    The computation can then release its resources. SIGINT (Ctrl-C) raises KeyboardInterrupt;
    SIGTERM and SIGHUP raise SystemExit. If the caller has already set a handler of its own for a
    signal, that handler stays in force.
    """
    before = {}
    hook = sys.unraisablehook
    if threading.current_thread() is threading.main_thread():
        for number, handler in USUAL.items():
            if signal.getsignal(number) is handler:
                before[number] = signal.signal(number, _end)
                sys.unraisablehook = _end_again
    try:
        yield
    finally:
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)


def _end(number: int, frame: FrameType | None) -> None:
    """Handle a signal by raising the exception that ends the computation.

    If the signal arrives while pymunk runs, it is repeated a little later instead. Python would
    discard an exception raised in a callback of the physics engine, and an exception must not
    interrupt pymunk while it frees the engine's memory.
    """
    while frame is not None:
        module = frame.f_globals.get("__name__", "")
        if module.partition(".")[0] == "pymunk" or frame.f_code is _end_again.__code__:
            _try_again(number)
            return
        frame = frame.f_back
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    raise SystemExit(SIGNALLED + number)


def _end_again(lost: sys.UnraisableHookArgs) -> None:
    """Repeat the signal whose exception Python discarded in a destructor or callback.

    Any other discarded exception is reported as Python usually does.
    """
    if issubclass(lost.exc_type, KeyboardInterrupt):
        _try_again(signal.SIGINT)
    elif isinstance(lost.exc_value, SystemExit) and isinstance(lost.exc_value.code, int):
        _try_again(lost.exc_value.code - SIGNALLED)
    else:
        sys.__unraisablehook__(lost)


def _try_again(number: int) -> None:
    threading.Timer(LATER, _thread.interrupt_main, (number,)).start()


def document(name: str, values: Mapping[str, Any], report: Report, **further: Any) -> str:
    """Return the results of a scenario as JSON, in SI units at full precision.

    ``name`` is the scenario's name, ``values`` are its parameters, ``further`` additional entries.
    """
    found = {
        "outcome": report.outcome,
        "quantities": [row.as_dict() for row in report.quantities],
        "phases": list(report.phases),
        "events": [{"name": event, "time": at} for event, at in report.events if math.isfinite(at)],
        "cost": {"wall_s": report.wall_s, "steps": report.steps},
    }
    return json_of(name, report.answer, values, **found | report.extra | further)


def json_of(name: str, answer: str, values: Mapping[str, Any], **results: Any) -> str:
    """Return results as JSON text, headed by the answer, the version and the parameter values."""
    head = {
        "scenario": name,
        "answer": answer,
        "version": __version__,
        **named_commit(),
        "parameters": dict(values),
    }
    return json.dumps(plain(head | results), indent=1, allow_nan=False)


def plain(value: Any) -> Any:
    """Convert a value, and all values within it, to types that JSON can hold.

    A number that is not finite becomes null.
    """
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if hasattr(value, "tolist"):  # NumPy's scalars and arrays
        return plain(value.tolist())
    return finite(value) if isinstance(value, float) else value


def csv_text(columns: Mapping[str, Sequence[Any]]) -> str:
    """Return a time series as CSV text at full precision.

    The first row has the names with units; each further row is one sample. The text does not end
    with a line break.
    """
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(plain(list(column)) for column in columns.values()), strict=True))
    return text.getvalue().removesuffix("\n")


def in_words(report: Report) -> str:
    """Return a report as text: answer, table of quantities, outcome of the impact, and remarks."""
    width = (
        max(WIDTH, shutil.get_terminal_size((WIDTH, 0)).columns) if sys.stdout.isatty() else WIDTH
    )
    lines = [*_wrapped(report.answer), ""] if report.answer else []
    shown = table(report.quantities, width)
    lines.append(shown)
    if " within" in shown.partition("\n")[0]:
        lines += ["", "within: the largest relative difference that counts as agreement"]
    if report.outcome is not None:
        phases = f" ({', '.join(report.phases)})" if report.phases else ""
        lines += ["", *_wrapped(f"outcome: {report.outcome_in_words or report.outcome}{phases}")]
    elif report.remarks and report.remarks[0]:
        lines.append("")
    for remark in report.remarks:
        lines += _wrapped(remark)
    for each in report.tables:
        lines += ["", str(each)]
    return "\n".join(lines)


def _wrapped(remark: str) -> list[str]:
    """Return a remark as lines of limited width.

    A remark with columns or several lines is not wrapped.
    """
    if len(remark) <= WIDTH or "\n" in remark or "  " in remark.strip():
        return [remark]
    return textwrap.wrap(remark, WIDTH, subsequent_indent="  ")


def write_text(target: Path, text: str) -> None:
    """Write a text file; the file appears only when it is complete."""
    with complete_or_absent(target) as partial:
        partial.write_text(text + "\n", encoding="utf-8", newline="")


def print_line(text: str) -> None:
    """Print a text on standard output.

    Characters that the output's encoding lacks are printed as ``?``. If the reader closes the
    output early, as ``head`` does, there is no error.
    """
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    try:
        print(text.encode(encoding, "replace").decode(encoding), flush=True)
    except OSError as error:
        # Python flushes once more at exit; the rest of the text goes to the null device.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise OSError(f"standard output: {error.strerror}") from None


def print_error(text: str) -> None:
    """Print text to standard error, or do nothing if there is no standard error stream."""
    if sys.stderr is not None:
        print(text, file=sys.stderr, flush=True)
