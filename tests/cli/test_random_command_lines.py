"""Random values anywhere in each key's range: an answer or one line that refuses, in bounded time, for every scenario.

A handful of command lines for each scenario belongs to the suite. ``BRISTLE_SIM_COMMAND_LINES=300`` in the environment
runs so many, and ``BRISTLE_SIM_SEED`` draws others.
"""

from __future__ import annotations

import contextlib
import io
import json
import logging
import math
import os
import random
import re
import signal
import traceback
from collections.abc import Iterator
from typing import NamedTuple

import pytest

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import load_scenario, script_paths
from bristle_sim.declared import Choice, Declaration, Range

NUMBER = int(os.environ.get("BRISTLE_SIM_COMMAND_LINES", "2"))
SEED = os.environ.get("BRISTLE_SIM_SEED", "1")

LONGEST_RUN = 30.0
"""CPU time after which a command line is ended, s; before it the progress must have said which part is done."""

FIXED_WORK = {"accuracy_cost", "dissertation_audit", "dissertation_figures", "hard_cases"}
"""Scenarios whose keys choose among fixed work, of minutes in all; the suite runs them elsewhere, by their quick parts."""

SMALL = {
    "tolerances": ("samples=2",),
    "cue_map": ("map_points=2", "accuracy=0.0001", "reference=no"),
    "neighbours": ("search=no",),
    "surface": ("ground_width=0.5mm", "ground_length=1mm"),
    "bent_bristles": ("wire_links=1",),
    "film": ("map_durations=2", "map_dampings=2", "wire_links=2", "workers=1"),
}
"""Settings that keep scenarios short that take many passes, with progress and time left, by default."""

PROGRESS = re.compile(r"\s*\d+%\|")
"""A progress bar, which long work may show before it is refused."""

SCENARIOS = {
    name: load_scenario(path) for name, path in script_paths().items() if name not in FIXED_WORK
}

needs_timer = pytest.mark.skipif(
    not hasattr(signal, "setitimer"), reason="this system has no timer to stop a run by"
)


class Answer(NamedTuple):
    """The result of a command line, and whether its progress said which part was done; the status is None if it raised."""

    status: int | None
    out: str
    err: str
    forecast: bool = False


def value(chance: random.Random, declared: Declaration) -> str:
    """A value of a key's declared range: anywhere in it, near the default, or at one of its ends."""
    if isinstance(declared, Choice):
        return chance.choice(declared.options)
    if declared.unit in ("file", "column"):
        return "missing.mat" if declared.unit == "file" else chance.choice(("1", "2", "force"))
    assert isinstance(declared, Range)
    default = declared.default
    low, high = declared.lowest, declared.highest
    kind = chance.choice(("near", "near", "even", "decade", "end"))
    if kind == "near" and isinstance(default, float) and default:
        found = default * math.exp(chance.gauss(0.0, 1.0))
    elif kind == "end":
        found = chance.choice((low, high))
    elif kind == "decade":
        size = 10.0 ** chance.uniform(
            math.log10(max(abs(low), 1e-12)), math.log10(max(abs(high), 1e-12))
        )
        found = size * (chance.choice((-1.0, 1.0)) if low < 0.0 else 1.0)
    else:
        found = chance.uniform(low, high)
    found = min(max(found, low), high)
    return f"{found:.0f}" if declared.whole else f"{found:.4g}"


def command_line(scenario: Scenario, number: int) -> list[str]:
    """One to four keys with random values; the same for the same number."""
    chance = random.Random(f"{SEED} {scenario.name} {number}")
    small = SMALL.get(scenario.name, ())
    keys = {
        key: each
        for key, each in scenario.keys().items()
        if not any(one.startswith(f"{key}=") for one in small)
    }
    chosen = chance.sample(sorted(keys), min(chance.choice((1, 1, 2, 3, 4)), len(keys)))
    drawn = (
        f"{key}={value(chance, keys[key])}" for key in chosen if not key.endswith(("_csv", "store"))
    )
    return ["--json", "-", *(f"--set={setting}" for setting in (*small, *drawn))]


class TooLong(BaseException):
    """Beyond the time limit; not an Exception, which nothing on the way may catch."""


@contextlib.contextmanager
def cpu_limit(seconds: float) -> Iterator[None]:
    """Raise TooLong once this process has computed for so long."""

    def stop(*_: object) -> None:
        raise TooLong

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


class Forecast(logging.Handler):
    """Notes whether progress says which part of a command line's work is done."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self.given = False

    def emit(self, record: logging.LogRecord) -> None:
        if "%" in record.getMessage():
            self.given = True


def answer(scenario: Scenario, arguments: list[str]) -> Answer:
    """Run a command line in this process, listening to its progress as a terminal does."""
    out = io.StringIO()
    err = io.StringIO()
    forecast = Forecast()
    log = logging.getLogger("bristle_sim")
    status = None
    log.addHandler(forecast)
    log.setLevel(logging.INFO)
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            with cpu_limit(LONGEST_RUN):
                status = main(scenario, arguments)
        except TooLong:
            print("too long", end="", file=err)
        except Exception:  # whatever a person would see as a traceback
            traceback.print_exc(file=err)
    log.removeHandler(forecast)
    log.setLevel(logging.NOTSET)
    return Answer(status, out.getvalue(), err.getvalue(), forecast.given)


def fault(given: Answer) -> str:
    """The fault of an answer; empty if it keeps to the contract."""
    if given.status is None:
        return (
            ""
            if given.err.endswith("too long") and given.forecast
            else f"no exit status: {given.err[-600:]}"
        )
    if given.status == 2:
        said = [line for line in given.err.splitlines() if line and not PROGRESS.match(line)]
        one_line = not given.out and len(said) == 1 and given.err.endswith("\n")
        return (
            ""
            if one_line and "Traceback" not in given.err
            else f"not one line: {given.out[:200]} {given.err[:600]}"
        )
    if given.status not in (0, 1) or "Traceback" in given.err:
        return f"exit status {given.status}: {given.err[:600]}"

    try:
        numbers = json.loads(given.out, parse_constant=lambda word: word)
    except ValueError as error:
        return f"JSON: {error}"
    return "no finite number" if any(word in str(numbers) for word in ("NaN", "Infinity")) else ""


@needs_timer
@pytest.mark.parametrize("name", SCENARIOS)
def test_an_answer_or_one_line(name: str) -> None:
    lines = [command_line(SCENARIOS[name], number) for number in range(NUMBER)]
    faults = {" ".join(line): fault(answer(SCENARIOS[name], line)) for line in lines}
    assert {line: found for line, found in faults.items() if found} == {}


FAULTY = [
    Answer(None, "", "Traceback ..."), Answer(None, "", "too long"), Answer(2, "", "one\ntwo\n"),
    Answer(2, "{}", "one\n"), Answer(3, "{}", ""), Answer(0, '{"x": NaN}', ""), Answer(0, "", ""),
]  # fmt: skip
GOOD = [
    Answer(0, "{}", ""), Answer(None, "", "too long", forecast=True), Answer(1, '{"x": null}', "warning\n"),
    Answer(2, "", "one line\n"),
]  # fmt: skip


def test_each_fault_is_noticed() -> None:
    assert all(map(fault, FAULTY))
    assert not any(map(fault, GOOD))
