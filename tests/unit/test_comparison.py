"""Rows of a comparison: who judges, what agrees, and how it is shown."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

from bristle_sim.comparison import Quantity, Report, finite, table


def row(simulated: float | None, **sides: float | None) -> Quantity:
    return Quantity("speed", "m/s", simulated, **sides)


def test_the_reference_judges_before_theory_and_theory_before_print():
    assert row(1.0, theory=2.0, reference=4.0, printed=5.0).judge == 4.0
    assert row(1.0, theory=2.0, printed=5.0).judge == 2.0
    assert row(1.0, printed=5.0).judge == 5.0
    assert row(1.0).judge is None
    assert row(1.0, theory=0.0, printed=5.0).judge == 0.0


def test_differences_are_relative_to_the_size_of_the_other_side():
    both = row(-3.0, theory=-4.0, printed=-2.0)
    assert both.relative_difference == 0.25
    assert both.difference_from_print == -0.5
    assert row(-5.0, theory=4.0).relative_difference == -2.25
    for meaningless in (row(None, theory=1.0), row(1.0), row(1.0, theory=0.0)):
        assert meaningless.relative_difference is None
    assert row(1.0, theory=2.0).difference_from_print is None


@pytest.mark.parametrize(
    ("simulated", "theory", "tolerance", "ok"),
    [
        (1.0, 1.0, 0.0, True),
        (1.125, 1.0, 0.125, True),
        (0.875, 1.0, 0.125, True),
        (1.126, 1.0, 0.125, False),
        (0.874, 1.0, 0.125, False),
        (-1.0, 1.0, 1.0, False),
        (-8.0, -9.0, 0.125, True),
        (0.0, 0.0, 1e-9, True),
        (1e-9, 0.0, 1e-9, True),  # beside zero the tolerance is an absolute one
        (-2e-9, 0.0, 1e-9, False),
        (None, 1.0, 0.1, False),  # a number was asked for and none came
        (None, 1.0, None, None),
        (5.0, 1.0, None, None),
        (1.0, None, 0.1, None),
        (None, None, 0.1, None),
        (math.nan, 1.0, 0.1, False),
        (math.inf, 1.0, 0.1, False),
        (1.0, math.nan, 0.1, False),
        (math.nan, math.nan, 0.1, False),
        (math.inf, math.inf, 0.1, False),
        (math.nan, 0.0, 0.1, False),
    ],
)
def test_what_agrees(simulated: float | None, theory: float | None, tolerance: float | None, ok: bool | None):
    assert row(simulated, theory=theory, tolerance=tolerance).ok is ok


@pytest.mark.parametrize("theory", [1.0, 0.0])
def test_a_verdict_on_numpy_numbers_is_a_plain_one(theory: float):
    """The exit status asks for ``ok is False``, which NumPy's False is not."""
    far = row(np.float64(2.0), theory=np.float64(theory), tolerance=0.1)
    assert far.ok is False
    assert json.loads(json.dumps(far.as_dict()))["ok"] is False


def test_a_row_as_plain_values():
    values = row(math.inf, theory=2.0, reference=math.nan, tolerance=0.1).as_dict()
    assert values == {
        "name": "speed",
        "unit": "m/s",
        "simulated": None,
        "theory": 2.0,
        "reference": None,
        "printed": None,
        "relative_difference": None,
        "tolerance": 0.1,
        "ok": False,
    }
    sides = row(3.0, theory=1.0, reference=2.0, printed=4.0).as_dict()
    assert (sides["theory"], sides["reference"], sides["printed"], sides["relative_difference"]) == (1.0, 2.0, 4.0, 0.5)


def test_finite():
    assert [finite(value) for value in (None, math.nan, math.inf, -math.inf)] == [None] * 4
    assert finite(np.float64(2.5)) == 2.5
    assert type(finite(np.float64(2.5))) is float
    assert finite(0) == 0.0


def test_table_is_aligned():
    rows = [
        Quantity("a_long_name", "rad/s", 877.09181234, 833.8428, printed=845.6, tolerance=1e-3),
        Quantity("short", "1", None, 0.0),
        Quantity("t", "s", math.nan, math.inf, tolerance=0.5),
    ]
    head, rule, *lines = table(rows).splitlines()
    assert re.split(r"\s{2,}", head) == [
        *("quantity", "unit", "simulated", "theory", "rel. diff.", "tolerance", "ok", "printed", "diff. from print")
    ]
    assert set(rule) == {"-"}
    assert len(rule) == max(map(len, [head, *lines]))
    assert lines[0].split() == [
        "a_long_name",
        "rad/s",
        "877.0918",
        "833.8428",
        "5.2e-02",
        "1.0e-03",
        "NO",
        "845.6",
        "3.7e-02",
    ]
    assert lines[1].split() == ["short", "1", "-", "0", "-", "-", "-", "-", "-"]
    assert lines[2].split() == ["t", "s", "-", "-", "-", "5.0e-01", "NO", "-", "-"]
    column = head.index("theory") + len("theory")
    assert [line[:column].split()[-1] for line in lines] == ["833.8428", "0", "-"]
    assert all(line == line.rstrip() for line in lines)


def test_table_shows_the_reference_if_any_row_has_one():
    head, _, first, second = table([row(1.0, reference=2.0, tolerance=1.0), row(1.0)]).splitlines()
    assert head.split()[:6] == ["quantity", "unit", "simulated", "theory", "reference", "rel."]
    assert first.split() == ["speed", "m/s", "1", "-", "2", "-5.0e-01", "1.0e+00", "yes", "-", "-"]
    assert second.split()[3:5] == ["-", "-"]


def test_table_of_nothing_has_a_head():
    assert table([]).splitlines()[0].startswith("quantity")


def test_a_report_needs_an_outcome_and_quantities_only():
    report = Report("rebound", ())
    assert (report.phases, report.events, report.remarks, report.extra, report.subject) == ((), (), (), {}, None)
    assert report.extra is not Report("rebound", ()).extra
