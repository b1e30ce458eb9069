"""Rows of a comparison: the side that judges, agreement, the table, and the words of an answer."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

from bristle_sim.comparison import Quantity, Report, agreement, differences, rows, table
from bristle_sim.readable import amount
from bristle_sim.studies.strike_measures import beside_radial

INFINITE = math.inf
NAN = math.nan


def row(simulated: float | None, **sides: float | None) -> Quantity:
    return Quantity("speed", "m/s", simulated, **sides)


@pytest.mark.parametrize(
    ("sides", "judge", "name", "difference"),
    [
        ({"theory": 2.0, "reference": 4.0, "printed": 5.0}, 4.0, "reference", -1.5),
        ({"theory": -4.0, "printed": 5.0}, -4.0, "theory", 0.5),
        ({"printed": 5.0}, 5.0, "printed", -1.4),
        ({"theory": 0.0, "printed": 5.0}, 0.0, "theory", None),
        ({}, None, None, None),
    ],
)
def test_the_reference_judges_before_theory_and_theory_before_print(sides, judge, name, difference):
    """A difference is relative to the size of the other side."""
    found = row(-2.0, **sides)
    assert found.judge == (None if name is None else (name, judge))
    assert found.relative_difference == difference
    assert row(None, **sides).relative_difference is None


def test_without_a_contact_no_row_says_yes():
    quantities = (row(1.0, theory=1.0, tolerance=0.1), row(2.0, theory=1.0, tolerance=0.1))
    for outcome, verdicts in (("rebound", [True, False]), ("no contact", [None, False])):
        assert [each.ok for each in Report(outcome, quantities).quantities] == verdicts


@pytest.mark.parametrize(
    ("simulated", "theory", "tolerance", "ok"),
    [
        (1.125, 1.0, 0.125, True),
        (1.126, 1.0, 0.125, False),
        (0.874, 1.0, 0.125, False),
        (-8.0, -9.0, 0.125, True),
        (1e-9, 0.0, 1e-9, True),  # beside zero the tolerance is an absolute one
        (-2e-9, 0.0, 1e-9, False),
        (None, 1.0, 0.1, False),  # a number was requested and none came
        (None, 1.0, None, None),
        (1.0, None, 0.1, None),
        *((each, 1.0, 0.1, False) for each in (NAN, INFINITE)),
        *((each, each, 0.1, False) for each in (NAN, INFINITE)),
        (NAN, 0.0, 0.1, False),
        (
            np.float64(2.0),
            np.float64(0.0),
            0.1,
            False,
        ),  # the exit status asks for ``ok is False``, not NumPy's
    ],
)
def test_agreement(
    simulated: float | None, theory: float | None, tolerance: float | None, ok: bool | None
):
    found = row(simulated, theory=theory, tolerance=tolerance)
    assert found.ok is ok
    assert json.loads(json.dumps(found.as_dict(), allow_nan=False))["ok"] is ok


def test_a_table_has_no_empty_column_and_aligned_cells():
    assert table([row(1.0), row(2.0)]).splitlines()[0].split() == ["quantity", "unit", "simulated"]
    full = Quantity(
        "a_long_name_deg", "rad/s", 877.09181234, 833.8428, printed=845.6, tolerance=1e-3
    )
    head, rule, *lines = table([full, Quantity("t", "s", NAN, 0.0, tolerance=0.5)]).splitlines()
    titles = re.split(r"\s{2,}", head)
    assert titles == [
        "quantity",
        "unit",
        "simulated",
        "theory",
        "printed",
        "difference from",
        "within",
        "ok",
    ]
    assert set(rule) == {"-"}
    cells = [re.split(r"\s{2,}", line) for line in lines]
    assert cells[0] == [
        "a long name",
        "rad/s",
        "877.092",
        "833.843",
        "845.6",
        "+5.19 % theory",
        "0.1 %",
        "NO",
    ]
    column = head.index("theory") + len("theory")
    assert [line[:column].split()[-1] for line in lines] == ["833.843", "0"]


def test_a_narrow_terminal_leaves_the_reference_out_and_a_wide_one_shows_it():
    """All columns full and a long name take more than 100 columns; the difference still says from what."""
    sides = {"theory": -4.3219876, "reference": -4.3210988, "printed": -4.3, "tolerance": 1e-5}
    found = [Quantity("tangential_compressive_impulse", "rad/s", -4.3210987, **sides)]
    narrow = table(found)
    wide = table(found, 200)
    assert max(map(len, narrow.splitlines())) <= 100
    assert "  reference" not in narrow.splitlines()[0]
    assert "+2e-08 reference" in narrow
    assert "  reference" in wide.splitlines()[0]
    assert "within" not in table(found, 10).splitlines()[0]  # no terminal is too narrow for a table


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (0.00453001, "s", "4.53001  ms"),
        (0.0, "s", "0  s"),
        (1.3940e-4, "m", "139.4  µm"),
        (-2.5042e-3, "N s", "-2.5042  mN s"),
        (1.2e8, "Pa", "120  MPa"),
        (8.387e-5, "kg", "83.87  mg"),
        (1e-14, "m", "1e-05  nm"),
        (44.5, "deg", "44.5  deg"),
        (2e-5, "N s", "0.02  mN s"),
        (0.5, "1", "0.5  -"),
    ],
)
def test_units_that_an_engineer_reads(value: float, unit: str, shown: str):
    """The row's largest number has one to three digits before its point, as on an instrument."""
    cells = re.split(
        r"\s{2,}", table([Quantity("p_f", unit, value, label="impulse p_f")]).splitlines()[2]
    )
    assert cells == ["impulse p_f", *reversed(shown.split("  "))]


def test_a_row_is_shown_by_its_label_and_kept_by_its_key():
    labels = {"normal_final_impulse": ("normal impulse p_f", "N s"), "lag_deg": ("", "deg")}
    (labelled, plain) = rows(labels, {"lag_deg": 1.0})
    assert [labelled.as_dict()[key] for key in ("name", "label")] == [
        "normal_final_impulse",
        "normal impulse p_f",
    ]
    assert plain.label == "lag"


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        (2.751e-3, "N s", "2.75 mN s"),
        (2.7431, "deg", "2.74°"),
        (-0.43652, "1", "-0.437"),
        (1.3e-4, "m", "130 µm"),
    ],
)
def test_amounts_are_in_a_person_s_units(value: float, unit: str, words: str) -> None:
    assert amount(value, unit) == words


def test_a_lag_is_short_of_radial_or_beyond_it() -> None:
    words = ["2.74° short of radial", "2° beyond radial", "radial"]
    assert [beside_radial(each) for each in (2.743, -2.0, 1e-4)] == words


def test_the_largest_relative_difference_of_each_side_is_named() -> None:
    """10 % of the impulse's formula, 26 % of the printed tip speed; a theory of 0 has no relative difference."""
    compared = [
        Quantity("a", "N s", 2.75e-3, 3.06e-3, label="impulse"),
        Quantity("b", "m/s", 37.9, 36.8, printed=30.0, label="tip speed"),
        Quantity("c", "deg", 2.74, 0.0, label="lag"),
    ]
    assert differences(compared) == (
        " Largest differences: impulse 2.75 mN s, by formula 3.06 mN s; tip speed 37.9 m/s, printed in the dissertation 30 m/s."
    )
    assert differences([Quantity("d", "1", 1.0)]) == ""


def test_agreement_follows_from_the_rows() -> None:
    near = Quantity("a", "N", 1.0 + 1e-12, 1.0, tolerance=1e-9)
    far = Quantity("b", "N", 2.0, 1.0, tolerance=0.1)
    assert agreement([near]) == "the closed form agrees to 1e-12"
    assert agreement([near, far]) == "the closed form differs (b 2 N, by formula 1 N)"
    assert (
        agreement([Quantity("c", "N", 1.5, 1.0)])
        == "the closed form differs (c 1.5 N, by formula 1 N)"
    )
    assert agreement([Quantity("c", "N", 1.5)]) == "there is no closed form"
