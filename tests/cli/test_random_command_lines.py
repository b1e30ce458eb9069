"""Random values anywhere in each key's range: an answer or one line that refuses, in bounded time, for every scenario.

A handful of command lines for each scenario belongs to the suite. ``BRISTLE_SIM_COMMAND_LINES=300`` in the environment
runs so many, and ``BRISTLE_SIM_SEED`` draws others.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import itertools
import json
import logging
import math
import os
import random
import signal
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from bristle_sim.cli import Scenario, main
from bristle_sim.units import Choice, Range

ROOT = Path(__file__).parents[2]

NUMBER = int(os.environ.get("BRISTLE_SIM_COMMAND_LINES", "0"))
SEED = os.environ.get("BRISTLE_SIM_SEED", "1")

LIMIT = 30.0
"""CPU time that a command line may take, s."""

EARLY = 10.0
"""CPU time by which the progress of a longer one must say how long it will take, s."""

LONG = {"accuracy_cost", "dissertation_audit", "dissertation_figures", "hard_cases"}
"""Scenarios whose keys choose among fixed work, of minutes in all; the suite runs them elsewhere, by their quick parts."""

SMALL = {
    "tolerances": ("samples=2",),
    "cue_map": ("map_points=2", "accuracy=0.0001", "reference=no"),
    "neighbours": ("search=no",),
}
"""Settings that keep scenarios short that take many passes, with progress and time left, by default."""

FEW = 2
"""Command lines of each scenario in the suite."""


class Answer(NamedTuple):
    """What a command line gave; ``status`` is None where it raised or took too long.

    ``told_at`` is the CPU time at which its progress first said how long it would take, s.
    """

    status: int | None
    out: str
    err: str
    cpu_s: float
    told_at: float = math.inf


def scenarios() -> dict[str, Scenario]:
    """Every scenario that a script declares, but for the long ones, by its name."""
    found = {}
    for path in sorted((ROOT / "scenarios").glob("*.py")):
        if path.stem not in LONG:
            spec = importlib.util.spec_from_file_location(f"random_{path.stem}", path)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            found[path.stem] = module.SCENARIO
    return found


SCENARIOS = scenarios()


def value(chance: random.Random, declared: Range | Choice, default: object) -> str:
    """A value of a key's declared range: anywhere in it, near the default, or at one of its ends."""
    if isinstance(declared, Choice):
        return chance.choice(declared.options)
    if declared.unit == "file":
        return "missing.mat"
    if declared.unit == "column":
        return chance.choice(("1", "2", "force"))
    low, high = declared.lowest, declared.highest
    kind = chance.choice(("near", "near", "even", "decade", "end"))
    if kind == "near" and isinstance(default, float) and default:
        found = default * math.exp(chance.gauss(0.0, 1.0))
    elif kind == "end":
        found = chance.choice((low, high))
    elif kind == "decade":
        size = 10.0 ** chance.uniform(math.log10(max(abs(low), 1e-12)), math.log10(max(abs(high), 1e-12)))
        found = size * (chance.choice((-1.0, 1.0)) if low < 0.0 else 1.0)
    else:
        found = chance.uniform(low, high)
    found = min(max(found, low), high)
    return f"{found:.0f}" if declared.whole else f"{found:.4g}"


def command_line(scenario: Scenario, number: int) -> list[str]:
    """One to four keys with random values; the same for the same number."""
    chance = random.Random(f"{SEED} {scenario.name} {number}")
    keys = scenario.keys()
    small = SMALL.get(scenario.name, ())
    keys = {key: each for key, each in keys.items() if not any(one.startswith(f"{key}=") for one in small)}
    chosen = chance.sample(sorted(keys), min(chance.choice((1, 1, 2, 3, 4)), len(keys)))
    settings = [*small, *(f"{key}={value(chance, *keys[key])}" for key in chosen if not reads_a_file(key))]
    return ["--json", "-", *(part for setting in settings for part in ("--set", setting))]


def reads_a_file(key: str) -> bool:
    return key.endswith("_csv")


TOO_LONG = "too long"


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


class Told(logging.Handler):
    """Notes when progress first says how long a command line will take."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self.start = time.process_time()
        self.told_at = math.inf

    def emit(self, record: logging.LogRecord) -> None:
        if record.getMessage().endswith("s left"):
            self.told_at = min(self.told_at, time.process_time() - self.start)


@contextlib.contextmanager
def progress() -> Iterator[Told]:
    """Listen to the package's progress, as a terminal does."""
    log, told = logging.getLogger("bristle_sim"), Told()
    level = log.level
    log.addHandler(told)
    log.setLevel(logging.INFO)
    try:
        yield told
    finally:
        log.removeHandler(told)
        log.setLevel(level)


def answer(scenario: Scenario, arguments: list[str]) -> Answer:
    """What a command line gives in this process."""
    out, err, start, status = io.StringIO(), io.StringIO(), time.process_time(), None
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), progress() as told:
        try:
            with cpu_limit(LIMIT):
                status = main(scenario, arguments)
        except TooLong:
            print(TOO_LONG, end="", file=err)
        except Exception:  # whatever a person would see as a traceback
            traceback.print_exc(file=err)
    return Answer(status, out.getvalue(), err.getvalue(), time.process_time() - start, told.told_at)


def fault(given: Answer) -> str:
    """What is wrong with an answer; nothing if it keeps to the contract."""
    if given.status is None and given.err.endswith(TOO_LONG) and given.told_at < EARLY:
        return ""
    if given.status is None:
        return f"no exit status after {given.cpu_s:.1f} s: {given.err[-600:]}"
    if given.status == 2:
        one_line = not given.out and given.err.count("\n") == 1 and given.err.endswith("\n")
        return "" if one_line and "Traceback" not in given.err else f"not one line: {given.out[:200]} {given.err[:600]}"
    if given.status not in (0, 1) or "Traceback" in given.err:
        return f"exit status {given.status}: {given.err[:600]}"
    try:
        json.loads(given.out, parse_constant=refuse)
    except ValueError as error:
        return f"JSON: {error}"
    return ""


def refuse(word: str) -> float:
    raise ValueError(f"{word} is no number")


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timer to stop a run by")
@pytest.mark.parametrize("name", SCENARIOS)
def test_an_answer_or_one_line(name: str) -> None:
    faults = {}
    for number in range(NUMBER or FEW):
        arguments = command_line(SCENARIOS[name], number)
        found = fault(answer(SCENARIOS[name], arguments))
        if found:
            faults[" ".join(arguments)] = found
    assert not faults, "\n".join(f"{line}: {what}" for line, what in faults.items())


class TestWhatIsNoticed:
    """Each fault that the test is there for."""

    def test_faults(self) -> None:
        assert fault(Answer(None, "", "Traceback ...", 1.0))
        assert fault(Answer(None, "", TOO_LONG, 30.0, told_at=20.0))
        assert fault(Answer(2, "", "one\ntwo\n", 1.0))
        assert fault(Answer(2, "{}", "one\n", 1.0))
        assert fault(Answer(3, "{}", "", 1.0))
        assert fault(Answer(0, '{"x": NaN}', "", 1.0))
        assert fault(Answer(0, "", "", 1.0))

    def test_no_faults(self) -> None:
        assert not fault(Answer(0, "{}", "", 1.0))
        assert not fault(Answer(None, "", TOO_LONG, 30.0, told_at=2.0))
        assert not fault(Answer(1, '{"x": null}', "warning\n", 1.0))
        assert not fault(Answer(2, "", "one line\n", 1.0))

    @pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timer to stop a run by")
    def test_a_run_without_end_is_stopped(self) -> None:
        with pytest.raises(TooLong), cpu_limit(0.05):
            for _ in itertools.count():
                pass
