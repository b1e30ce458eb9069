"""An outcome in words, the same from a single pass and from many, and an impulse that is outside the law's model."""

from __future__ import annotations

import math

import pytest

import bristle_sim as bs
from bristle_sim.parameters import Bristle as Wire
from bristle_sim.parameters import Contact, Hub, Strike, Surface
from bristle_sim.passes.strike import OUTCOMES
from bristle_sim.render.style import OUTCOMES as COLOURS
from bristle_sim.settings import Settings
from bristle_sim.studies.impacts import oblique_impact
from bristle_sim.studies.whole_pass import whole_pass

RADIAL = {"bar_horizontal": "51.2 mm", "bar_vertical": "20.54 mm"}
"""A bar that lets the wire strike within 0.01 degrees of radial."""


@pytest.mark.parametrize("restitution", [0.0, 0.42])
@pytest.mark.parametrize("friction", [0.0, 0.31, 0.46, 0.47, 2.0])
def test_a_pass_and_an_ensemble_use_the_same_word(friction: float, restitution: float):
    tool = bs.Tool().replace(friction=friction, restitution=restitution)
    strike = bs.simulate(tool, bs.Settings(accuracy=1e-8)).first_contact("workpart")
    assert strike is not None
    assert strike.outcome_in_words == str(bs.ensemble(tool, friction=friction).outcome)


def test_an_elastic_tip_that_sticks_at_once_has_no_slip_to_reverse():
    """It slips only near the end of restitution, whose friction is smaller, and backwards."""
    tool = bs.Tool().replace(
        friction=2.0, restitution=0.5, restitution_friction=0.1, tangential_compliance=1.21
    )
    strike = bs.simulate(tool, bs.Settings(accuracy=1e-8), stop_after="strike").first_contact(
        "workpart"
    )
    assert strike is not None
    assert strike.phases[0] == "compression stick"
    assert strike.outcome_in_words == "sticks and rebounds"
    assert str(bs.ensemble(tool).outcome) == "sticks and rebounds"


@pytest.mark.parametrize("tangential_compliance", [0.0, 0.03, 1.21])
def test_a_smooth_tip_whose_slip_and_approach_end_together_reverses_its_slip(
    tangential_compliance: float,
):
    """Without friction a tangential spring has no force, so the word does not depend on it."""
    tool = bs.Tool(bar=None).replace(
        friction=0.0, penetration="0.1 um", tangential_compliance=tangential_compliance
    )
    strike = bs.simulate(tool, bs.Settings(accuracy=1e-8), stop_after="strike").first_contact(
        "workpart"
    )
    assert strike is not None
    assert strike.outcome_in_words == "reverses its slip"
    assert str(bs.ensemble(tool).outcome) == "reverses its slip"


def test_every_word_has_a_colour_of_its_own():
    assert {*COLOURS} == {*OUTCOMES}
    assert len({*COLOURS.values()}) == len(OUTCOMES)


def strike_at(friction: float) -> bs.ContactRecord:
    state = Strike(speed_ratio=3.23, impact_angle_deg=23.4)
    report = oblique_impact(Hub(), Wire(), state, Surface(friction=friction), Contact(), Settings())
    found: bs.ContactRecord = report.subject.strikes["energetic"].contact
    return found


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.2])
def test_friction_magnifies_the_impulse_of_a_rod_by_its_wedge(friction: float):
    """dv_n = K_nn (p_n - p_t/tan(gamma)) of a rod at the angle -gamma, whose K is c (sin, -cos)(sin, -cos)."""
    contact = strike_at(friction)
    normal, tangential = contact.impulse
    expected = 1.0 / (1.0 - tangential / normal / math.tan(math.radians(23.4)))
    assert contact.friction_magnification == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({**RADIAL, "friction": 0.44}, "the rigid law breaks down"),
        ({**RADIAL, "friction": 1.0, "restitution": 0.1}, "the rigid law breaks down"),
        ({"wire_links": 2}, "depends on the duration"),
        ({**RADIAL, "friction": 0.3}, ""),
        ({**RADIAL, "friction": 0.44, "tangential_compliance": 1.21}, ""),
        ({}, ""),
    ],
)
def test_an_impulse_outside_the_model_says_so_in_the_answer(changes: dict[str, object], words: str):
    answer = whole_pass(bs.Tool().replace(**changes), Settings(accuracy=1e-4)).answer
    assert ("not to be trusted" in answer) is bool(words)
    assert words in answer


def test_an_estimate_above_the_requested_accuracy_is_said():
    """Without friction the wire touches again and again; with it the estimate is below the accuracy."""
    for friction in (0.0, 0.31):
        report = whole_pass(bs.Tool().replace(friction=friction), Settings())
        estimate = report.subject.trajectory.cost.error_estimate
        said = any("above the requested accuracy" in each for each in report.remarks)
        assert said is (estimate > 1e-6)
