"""The first sentence of a report: numbers in a person's units, and the verdict that follows from the rows."""

from __future__ import annotations

import pytest

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase
from bristle_sim.benchmarks.hard_cases.report import answer as hard_cases_answer
from bristle_sim.comparison import Quantity, agreement, amount, differences
from bristle_sim.studies.strike_point import beside_radial
from bristle_sim.studies.tolerances import answer as tolerances_answer


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [(2.751e-3, "N s", "2.75 mN s"), (2.7431, "deg", "2.74°"), (-0.43652, "1", "-0.437"), (1.3e-4, "m", "130 um")],
)
def test_amounts_are_in_a_person_s_units(value: float, unit: str, words: str) -> None:
    assert amount(value, unit) == words


def test_a_lag_is_short_of_radial_or_beyond_it() -> None:
    assert [beside_radial(each) for each in (2.743, -2.0, 1e-4)] == [
        "2.74° short of radial",
        "2° beyond radial",
        "radial",
    ]


def test_the_largest_relative_difference_of_each_side_is_named() -> None:
    """10 % of the impulse's formula, 26 % of the printed tip speed; a theory of 0 has no relative difference."""
    rows = [
        Quantity("a", "N s", 2.75e-3, 3.06e-3, label="impulse"),
        Quantity("b", "m/s", 37.9, 36.8, printed=30.0, label="tip speed"),
        Quantity("c", "deg", 2.74, 0.0, label="lag"),
    ]
    assert differences(rows) == (
        " What differs most: impulse 2.75 mN s, by formula 3.06 mN s; tip speed 37.9 m/s, printed 30 m/s."
    )
    assert differences([Quantity("d", "1", 1.0)]) == ""


def test_agreement_follows_from_the_rows() -> None:
    near, far = Quantity("a", "N", 1.0 + 1e-12, 1.0, tolerance=1e-9), Quantity("b", "N", 2.0, 1.0, tolerance=0.1)
    assert agreement([near]) == "Yes, to 1e-12"
    assert agreement([near, far]) == "No (b 2 N, by formula 1 N)"
    assert agreement([Quantity("c", "N", 1.5, 1.0)]) == "Not exactly (c 1.5 N, by formula 1 N)"
    assert agreement([Quantity("c", "N", 1.5)]) == "There is no closed form"


def test_hard_cases_that_break_their_promise_are_named() -> None:
    case = HardCase("chatter", "a ball", "rests", lambda: Finding("rests", True))
    assert hard_cases_answer([(case, Finding("rests", True))]) == "Yes: all 1 hard cases keep their promise."
    broken = hard_cases_answer([(case, Finding("rests", True)), (case, Finding("sinks", False))])
    failing = HardCase("chatter", "a ball", "rests", lambda: Finding(str(1 / 0), True))
    assert failing.run() == Finding("ZeroDivisionError: division by zero", False)
    assert broken == "No: 1 of 2 hard cases break their promise: chatter: a ball (sinks)."


def test_the_tolerance_that_matters_most_ranks_first_for_most_outputs() -> None:
    speed, friction = ({"total": 0.9}, {"total": 0.1})
    rows = [
        {"output": "tip_speed_at_contact", "mean": 37.9, "std": 0.6, "indices": {"speed": speed, "friction": friction}},
        {
            "output": "normal_final_impulse",
            "mean": 2.75e-3,
            "std": 3e-4,
            "indices": {"speed": friction, "friction": speed},
        },
        {"output": "lag_deg_at_contact", "mean": 2.7, "std": 1.5, "indices": {"speed": speed, "friction": friction}},
    ]
    found = tolerances_answer(rows)
    assert found.startswith("Speed matters most: it ranks first for 2 of 3 measures of the strike.")
    assert "normal impulse p_fy 2.75 mN s by 0.3 mN s (mostly friction)" in found
