"""Rows of a comparison: who judges, what agrees, and how it is shown."""

from __future__ import annotations

import math
import re

import pytest

from bristle_sim.comparison import Quantity, Report, rows, table


def row(simulated: float | None, **sides: float | None) -> Quantity:
    return Quantity("speed", "m/s", simulated, **sides)


def test_the_reference_judges_before_theory_and_theory_before_print():
    assert row(1.0, theory=2.0, reference=4.0, printed=5.0).judge == 4.0
    assert row(1.0, theory=2.0, printed=5.0).judge == 2.0
    assert row(1.0, printed=5.0).judge == 5.0
    assert row(1.0).judge is None
    sides = ({"reference": 4.0, "theory": 2.0}, {"theory": 2.0, "printed": 5.0}, {"printed": 5.0}, {})
    assert [row(1.0, **each).judge_name for each in sides] == ["reference", "theory", "print", None]
    assert row(1.0, theory=0.0, printed=5.0).judge == 0.0


def test_without_a_contact_no_row_says_yes():
    quantities = (row(1.0, theory=1.0, tolerance=0.1), row(2.0, theory=1.0, tolerance=0.1))
    verdicts = {
        outcome: [each.ok for each in Report(outcome, quantities).quantities] for outcome in ("rebound", "no contact")
    }
    assert verdicts == {"rebound": [True, False], "no contact": [None, False]}


def test_differences_are_relative_to_the_size_of_the_other_side():
    assert row(-3.0, theory=-4.0, printed=-2.0).relative_difference == 0.25
    assert row(-5.0, theory=4.0).relative_difference == -2.25
    for meaningless in (row(None, theory=1.0), row(1.0), row(1.0, theory=0.0)):
        assert meaningless.relative_difference is None


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
        (None, 1.0, 0.1, False),  # a number was requested and none came
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


def test_a_row_as_plain_values():
    values = row(math.inf, theory=2.0, reference=math.nan, tolerance=0.1).as_dict()
    assert values == {
        "name": "speed",
        "label": "speed",
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


def test_table_has_no_empty_column():
    assert table([row(1.0), row(2.0)]).splitlines()[0].split() == ["quantity", "unit", "simulated"]
    only_print = table([row(3.0, printed=2.0)]).splitlines()
    assert only_print[0].split() == ["quantity", "unit", "simulated", "printed", "difference", "from"]
    assert only_print[2].split() == ["speed", "m/s", "3", "2", "+50", "%", "print"]


def test_table_leaves_the_reference_out_rather_than_be_too_wide():
    """All columns full and a name of 40 letters take more than 100 columns; the difference still says from what."""
    sides = {"theory": -4.3219876, "reference": -4.3210988, "printed": -4.3, "tolerance": 1e-5}
    text = table([Quantity("tangential_compressive_impulse", "rad/s", -4.3210987, **sides)])
    assert max(map(len, text.splitlines())) <= 100
    assert "reference" not in text.splitlines()[0]
    assert "+2e-08 reference" in text


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (0.00453001, "s", "4.53001  ms"),
        (0.0, "s", "0  s"),
        (12.5, "s", "12.5  s"),
        (1.3940e-4, "m", "139.4  um"),
        (0.05037, "m", "50.37  mm"),
        (-2.5042e-3, "N s", "-2.5042  mN s"),
        (-0.0115725, "J", "-11.5725  mJ"),
        (1.2e8, "Pa", "120  MPa"),
        (8.387e-5, "kg", "83.87  mg"),
        (5.0, "kg", "5  kg"),
        (1e-14, "m", "1e-05  nm"),
        (1e-3, "s", "1  ms"),
        (44.5, "deg", "44.5  deg"),
        (2e-5, "N s", "0.02  mN s"),
    ],
)
def test_units_that_an_engineer_reads(value: float, unit: str, shown: str):
    """The row's largest number has one to three digits before its point, as on an instrument."""
    number, symbol = shown.split("  ")
    cells = re.split(r"\s{2,}", table([Quantity("name", unit, value)]).splitlines()[2])
    assert cells == ["name", symbol, number]


def test_a_row_is_shown_by_its_label_and_kept_by_its_key():
    (labelled, plain) = rows(
        {"normal_final_impulse": ("normal impulse p_f", "N s"), "lag_deg": "deg"}, {"lag_deg": 1.0}
    )
    assert [labelled.as_dict()[key] for key in ("name", "label")] == ["normal_final_impulse", "normal impulse p_f"]
    assert plain.label == "lag"
    lines = table([Quantity("p", "N s", 2e-5, label="normal impulse p_f"), Quantity("ratio", "1", 0.5)]).splitlines()
    assert re.split(r"  +", lines[2]) == ["normal impulse p_f", "mN s", "0.02"]
    assert re.split(r"  +", lines[3]) == ["ratio", "-", "0.5"]


def test_a_wide_terminal_shows_the_columns_that_a_narrow_one_leaves_out():
    found = [Quantity("a" * 60, "N", 1.23456, 1.23456, 1.23456, 1.23456, 1e-3)]
    assert "reference" not in table(found).splitlines()[0].replace("difference from", "")
    assert "reference" in table(found, 200).splitlines()[0]
