"""Stronge's pendulums: the tables, the single pendulum's formula, and momentum, work and energy at random."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.pendulums import (
    double_pendulum_impact,
    single_pendulum_impact,
)
from bristle_sim.theory.two_rods import stick_friction

PAIR = {"angle_1": math.radians(20), "angle_2": math.radians(30), "rate_1": -0.1, "rate_2": -0.2}
RODS = {"rod_mass": 5.0, "rod_length": 1.0, "restitution": 0.5} | PAIR

# n, mu, phi'_1, phi'_2 after the impact, p_c, p_f: evaluated from Zhang 2020, eqs. 2.66-2.108, apart from this program.
TABLE = [
    (1, 0.0, -0.23050263, 0.29187510, 0.66465577, 0.99698365),
    (1, 0.3, -0.20819052, 0.24586736, 0.45772963, 0.70237711),
    (1, 0.5, -0.19893234, 0.22313679, 0.37905577, 0.59199844),
    (1, 0.7, -0.19260193, 0.20898534, 0.32345998, 0.51199185),
    (2, 0.5, -0.16850436, 0.19167816, 0.40948661, 0.65767170),
    (10, 0.5, -0.12013221, 0.14180543, 0.45902648, 0.79306389),
    (100, 0.5, -0.10226865, 0.12350185, 0.47717864, 0.85758897),
    (1e4, 0.5, -0.10002302, 0.12120826, 0.47943454, 0.86644492),
]


@pytest.mark.parametrize(("ratio", "mu", "rate_1", "rate_2", "p_c", "p_f"), TABLE)
def test_tabulated_impacts(ratio, mu, rate_1, rate_2, p_c, p_f):
    result = double_pendulum_impact(mass_ratio=ratio, friction=mu, **RODS)
    computed = (
        result.final_rate_1,
        result.final_rate_2,
        result.normal_compressive_impulse,
        result.normal_final_impulse,
    )
    # Eight decimals, some cut rather than rounded.
    assert computed == pytest.approx((rate_1, rate_2, p_c, p_f), rel=0, abs=1e-8)


def test_a_small_restitution_keeps_its_digits():
    """p_f = p_c + e* sqrt(2 W_c/(dv_n/dp)) in one slip, 50 digits: 0.379055774120665038... at e* = 1.93e-9.

    1 - (1 - e*^2) would leave none of the second term, 7e-10.
    """
    for restitution, expected in ((1.93e-9, 0.37905577412066503815), (0.0, 0.37905577338908739551)):
        result = double_pendulum_impact(
            mass_ratio=1, friction=0.5, **(RODS | {"restitution": restitution})
        )
        assert result.normal_final_impulse == pytest.approx(expected, rel=1e-13, abs=0.0)


def test_tabulated_phases():
    slips_back = ("compression slip", "restitution slip", "restitution reverse slip")
    sticks = ("compression slip", "restitution slip", "restitution stick")
    for mu, phases in ((0.3, slips_back), (0.5, slips_back), (0.7, sticks)):
        result = double_pendulum_impact(mass_ratio=1, friction=mu, **RODS)
        assert result.phases == phases
        assert (
            result.normal_compressive_impulse
            < result.slip_stop_impulse
            < result.normal_final_impulse
        )


@pytest.mark.parametrize("angle", [0.0123, 0.3, 0.8, 1.2, 1.5])
def test_a_single_pendulum_at_the_threshold_of_stiction_stays(angle):
    """At mu = tan(gamma) itself no impulse can part the tip; sin(gamma) - mu cos(gamma) may round to more than 0."""
    impact = single_pendulum_impact(1.0, 1.0, angle, -2.0, math.tan(angle), 0.5)
    assert impact.outcome == "stiction"
    assert impact.normal_final_impulse == impact.normal_compressive_impulse
    assert (impact.final_rate, impact.rebound_ratio) == (0.0, 0.0)


def test_stick_friction_of_identical_rods():
    first, second = PAIR["angle_1"], PAIR["angle_2"]
    c = math.cos(first - second)
    above = math.sin(2 * first) + 4 * math.sin(2 * second) - 3 * math.sin(first + second) * c
    below = (
        2 * math.cos(first) ** 2
        + 8 * math.cos(second) ** 2
        - 6 * math.cos(first) * math.cos(second) * c
    )
    # Six printed digits, then eq. 2.90 as printed.
    assert stick_friction(1, first, second) == pytest.approx(0.623401, abs=5e-7)
    assert stick_friction(1, first, second) == pytest.approx(above / below, rel=1e-14)


def test_figure_2_30_at_the_operating_friction():
    angle = math.radians(23.4)
    result = double_pendulum_impact(8.387e-5, 700, 0.027, angle, angle, -261.8, -845.6, 0.31, 0.42)
    # Eight printed digits.
    assert result.normal_final_impulse == pytest.approx(2.4923689e-3, rel=2e-8)


def test_single_pendulum_is_the_monofilament_on_a_point():
    """r_h = 0 (2.4.1), for any friction on either side of tan gamma."""
    angles = np.radians([5.0, 23.4, 60.0, 90.0])
    for angle in angles:
        for mu in (0.0, 0.05, 0.31, 0.8, 3.0):
            single = single_pendulum_impact(0.2, 0.5, angle, -3.0, mu, 0.42)
            mono = monofilament_impact(0.2, 0.5, 0.0, 3.0, 1.0, angle, mu, 0.42)
            assert single.outcome == mono.outcome_name
            assert single.rebound_ratio == pytest.approx(mono.rebound_ratio, rel=1e-13, abs=1e-300)
            assert single.normal_compressive_impulse == pytest.approx(
                mono.normal_compressive_impulse, rel=1e-14
            )
            assert single.normal_final_impulse == pytest.approx(
                mono.normal_final_impulse, rel=1e-13
            )


def test_single_pendulum_formula():
    """-e* sqrt((1 - mu cot gamma)/(1 + mu cot gamma)) with numbers that make it rational: mu cot gamma = 3/5 gives 1/2."""
    angle = math.atan(0.5)
    result = single_pendulum_impact(1.0, 1.0, angle, -2.0, 0.3, 0.5)
    assert result.rebound_ratio == pytest.approx(-0.25, rel=1e-15)
    assert result.final_rate == pytest.approx(0.5, rel=1e-15)
    # p_c = m L |phi'|/(3 (sin gamma + mu cos gamma)) with sin gamma = 1/sqrt 5.
    assert result.normal_compressive_impulse == pytest.approx(
        2 * math.sqrt(5) / (3 * 1.6), rel=1e-15
    )
    # p_f = p_c (1 + e* sqrt(s_1/s_2)) = p_c (1 + e* 2).
    assert result.normal_final_impulse == pytest.approx(
        2 * result.normal_compressive_impulse, rel=1e-15
    )


BAD = {
    "rod_mass": 0.0, "mass_ratio": -1.0, "rod_length": math.nan, "angle_1": 2.0, "angle_2": -2.0, "rate_1": math.inf,
    "rate_2": math.nan, "friction": -0.1, "restitution": 1.5, "restitution_friction": -1.0,
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_named_in_one_line(name):
    arguments = (
        {"mass_ratio": 1.0, "friction": 0.3, "restitution_friction": 0.2} | RODS | {name: BAD[name]}
    )
    with pytest.raises(ValueError, match=f"^{name} = ") as refusal:
        double_pendulum_impact(**arguments)
    assert "\n" not in str(refusal.value)
    with pytest.raises(ValueError, match=r"^impact_angle = .*rad"):
        single_pendulum_impact(1.0, 1.0, 0.0, -1.0, 0.3, 0.5)


class TestEdges:
    @pytest.mark.parametrize(
        ("friction", "restitution", "outcome"),
        [
            (0.1, 0.0, "no rebound"),
            (9.0, 0.0, "no rebound"),
            (9.0, 0.5, "stiction"),
            (math.tan(0.6), 0.5, "stiction"),
        ],
    )
    def test_why_a_rod_stays(self, friction: float, restitution: float, outcome: str) -> None:
        """Without restitution nothing drives the rod back; with it, friction of tan gamma or more holds it."""
        result = single_pendulum_impact(3.0, 0.5, 0.6, -2.0, friction, restitution)
        assert (result.outcome, result.final_rate, result.rebound_ratio) == (outcome, 0.0, 0.0)

    @pytest.mark.parametrize("rate", [0.0, 2.0])
    def test_a_rod_that_does_not_approach_keeps_its_rate(self, rate: float) -> None:
        result = single_pendulum_impact(3.0, 0.5, 0.6, rate, 0.3, 0.5)
        assert (result.outcome, result.final_rate, result.normal_final_impulse) == (
            "no contact",
            rate,
            0.0,
        )

    @pytest.mark.parametrize("apart", [0.0, 1e-10, -1e-10, 5e-9])
    def test_rods_parallel_up_to_rounding_are_held_by_friction(self, apart: float) -> None:
        """Their tip moves along one line, so above tan theta no impulse parts it: energy lost is all but a drift."""
        result = double_pendulum_impact(
            1.0, 2.0, 1.0, 0.4, 0.4 + apart, -1.0, -2.0, 1.5 * math.tan(0.4), 0.5
        )
        assert result.outcome == "stiction"
        # All the tip's approach is stopped by m_eff v/(sin + mu cos); restitution adds nothing to that.
        assert result.normal_final_impulse == pytest.approx(
            result.normal_compressive_impulse, rel=1e-6
        )

    def test_friction_of_the_threshold_itself_sticks(self) -> None:
        """Zhang 2020, eq. 2.90: mu >= mu_bar sticks."""
        threshold = float(stick_friction(1.0, 0.35, 0.52))
        result = double_pendulum_impact(5.0, 1.0, 1.0, 0.35, 0.52, -0.1, -0.2, threshold, 0.5)
        assert result.phases[-1] == "restitution stick"

    def test_no_slip_has_stopped_at_once(self) -> None:
        """Rods at 0.5 and -0.5 with opposite rates come straight down: p_s = 0."""
        result = double_pendulum_impact(1.0, 1.0, 1.0, 0.5, -0.5, -1.0, 1.0, 0.9, 0.5)
        assert result.slip_stop_impulse == 0.0
        assert result.phases == ("compression stick", "restitution stick")
