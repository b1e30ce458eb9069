"""Bad input is refused in one clear line; input in range gives finite results, to the ends of all ranges."""

from __future__ import annotations

import dataclasses
import math
import os
import subprocess
import sys
import warnings

import numpy as np
import pytest

from bristle_sim.declared import Range
from bristle_sim.parameters import Belt, Bristle, Hub, Tool, Workpart
from bristle_sim.scene import impacts as contact_laws
from bristle_sim.units import shown
from promises.attempts import Tally
from promises.bad_input import trials


@pytest.mark.parametrize("name", trials())
def test_refused_in_one_line_or_answered_with_numbers(name: str) -> None:
    tally = trials()[name]()
    assert not tally.faults
    assert tally.refused + tally.taken > 0


def measured(name: str) -> bool:
    return not trials()[name]().faults


def test_a_range_that_lets_everything_pass_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        Range, "check", lambda self, number, _=None: int(number) if self.whole else float(number)
    )
    assert not measured("every value of Hub")
    assert not measured("every argument of EnergeticContact")


@pytest.mark.parametrize(
    "line", ["hub_speed\nhub_radius: must be less", "must be less", "hub_speed, hub_radius"]
)
def test_a_refusal_that_is_not_clear_is_noticed(line: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two lines, no name, no word of what it must be."""
    monkeypatch.setattr(Range, "refusal", lambda *_: ValueError(line))
    assert not measured("every value of Hub")


def test_a_number_of_another_kind_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """NumPy's numbers are kept as plain ones: a repr, a file or JSON would tell them apart."""
    monkeypatch.setattr(Range, "check", lambda _self, value, _typed=None: value)
    assert not measured("every value of Belt")


def test_a_result_that_is_no_number_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    law = contact_laws.resolve_phases

    def broken(*arguments: object, **named: object) -> object:
        return dataclasses.replace(law(*arguments, **named), impulse_normal=math.nan)  # type: ignore[arg-type]

    monkeypatch.setattr(contact_laws, "resolve_phases", broken)
    assert not measured("ends of all ranges, a strike, energetic")


@pytest.mark.parametrize(
    "error", [ZeroDivisionError("no"), OverflowError("no"), TypeError("no"), RuntimeWarning("no")]
)
def test_any_other_error_is_noticed(error: Exception) -> None:
    def call() -> None:
        raise error

    tally = Tally()
    tally.attempt("call", call, lambda _: True)
    assert type(error).__name__ in tally.faults[0]


def test_a_warning_is_noticed() -> None:
    tally = Tally()
    tally.attempt(
        "call", lambda: warnings.warn("rounding", RuntimeWarning, stacklevel=1), lambda _: True
    )
    assert tally.faults


def test_refusals_stay_without_asserts() -> None:
    """Everything again in a process that leaves asserts out, where the engine would end the process for a bad mass."""
    program = (
        "from promises.bad_input import trials\n"
        "for name, trial in trials().items():\n"
        "    if 'every' in name and 'laws' not in name: print(not trial().faults)\n"
    )
    done = subprocess.run(
        [sys.executable, "-O", "-c", program],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) == {"True"}


HUGE = 10**5000
"""Python does not write it out."""


def test_any_value_is_shown_in_one_short_line() -> None:
    for value in (
        HUGE,
        [HUGE],
        "x" * 1000,
        np.eye(3),
        object(),
        "one\nline",
        np.arange(1e4),
        {"a": HUGE},
        1j,
    ):
        line = shown(value)
        assert line.isprintable()
        assert 0 < len(line) <= 103  # a hundred characters and three dots


def test_parts_keep_their_kind() -> None:
    with pytest.raises(ValueError, match=r"^bar = Workpart\(.*: must be a Bar or None$"):
        Tool(bar=Workpart())  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"^belt = None: must be a Belt$"):
        Tool(belt=None)  # type: ignore[arg-type]
    assert Tool(Hub(), Belt(), Bristle(), None, None).bar is None
