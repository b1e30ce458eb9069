"""The monofilament's closed forms against print, against each other and against the integrals they solve."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.theory import monofilament as mono
from bristle_sim.theory.monofilament import monofilament_impact

MASS = 8.387e-5
LENGTH = 0.027
HUB_RADIUS = 0.0275
HUB_SPEED = 261.8
RATIO = 3.23
ANGLE = math.radians(23.4)
E = 0.42
TOOL = (MASS, LENGTH, HUB_RADIUS, HUB_SPEED, RATIO)

# mu, p_cy, p_fy, W_y, W_x, final rate, rebound ratio: evaluated from Zhang 2020, eqs. 2.37-2.65, apart from this program.
TABLE = np.array(
    [
        [0.0, 2.113995e-3, 3.001874e-3, -1.260658e-2, 0.0, -733.798, -0.867770],
        [0.1, 1.717179e-3, 2.629757e-3, -1.024021e-2, -2.366372e-3, -635.839, -0.751926],
        [0.31, 1.231668e-3, 2.504205e-3, -7.344917e-3, -5.261662e-3, -456.550, -0.539903],
        [0.4, 1.098553e-3, 3.425542e-3, -6.551100e-3, -6.055479e-3, -359.274, -0.424868],
    ]
)


def random_strikes(seed: int, size: int = 2000) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {
        "mass": 10.0 ** rng.uniform(-6, 2, size),
        "length": 10.0 ** rng.uniform(-3, 1, size),
        "hub_radius": 10.0 ** rng.uniform(-3, 1, size),
        "hub_speed": 10.0 ** rng.uniform(-1, 4, size),
        "speed_ratio": rng.uniform(0.1, 10, size),
        "impact_angle": rng.uniform(0.02, math.pi / 2, size),
        "friction": rng.uniform(0, 2, size),
        "restitution": rng.uniform(0, 1, size),
        "restitution_friction": rng.uniform(0, 2, size),
    }


def test_operating_point_table():
    result = monofilament_impact(*TOOL, ANGLE, TABLE[:, 0], E)
    computed = np.stack(
        [
            result.normal_compressive_impulse,
            result.normal_final_impulse,
            result.normal_compressive_work,
            result.tangential_compressive_work,
            result.final_bristle_rate,
            result.rebound_ratio,
        ],
        axis=-1,
    )
    # Seven digits, six in the last two columns: half a unit in the last place is at most 5e-7 and 1.4e-6.
    np.testing.assert_allclose(computed[:, :4], TABLE[:, 1:5], rtol=5e-7)
    np.testing.assert_allclose(computed[:, 4:], TABLE[:, 5:], rtol=1.5e-6)


def test_printed_compressive_impulse_needs_another_friction():
    """The 1.619e-3 N s of Zhang 2020, eq. 3.9, is |p_c| at mu = 0.1376 rather than 0.31 (1.2895e-3) or 0.5 (1.0965e-3)."""
    result = monofilament_impact(*TOOL, ANGLE, np.array([0.1376, 0.31, 0.5]), E)
    resultant = np.hypot(result.normal_compressive_impulse, result.tangential_compressive_impulse)
    # Half a unit of the fourth digit of mu changes p_c by 6e-5, that of p_c is 3e-4 and 5e-5.
    np.testing.assert_allclose(resultant, [1.619e-3, 1.2895e-3, 1.0965e-3], rtol=1e-4)


def test_compressive_work_is_the_kinetic_energy_of_the_approach():
    """W_x + W_y = -m v_C^2/6 whatever friction and angle, and W_x/W_y = mu cot gamma."""
    strikes = random_strikes(1)
    result = monofilament_impact(**strikes)
    speed = (strikes["speed_ratio"] * strikes["length"] + strikes["hub_radius"]) * strikes[
        "hub_speed"
    ]
    total = result.normal_compressive_work + result.tangential_compressive_work
    # A dozen roundings.
    np.testing.assert_allclose(total, -strikes["mass"] * speed**2 / 6.0, rtol=1e-14)
    ratio = strikes["friction"] / np.tan(strikes["impact_angle"])
    np.testing.assert_allclose(
        result.tangential_compressive_work, ratio * result.normal_compressive_work, rtol=1e-13
    )
    np.testing.assert_allclose(
        result.tangential_compressive_impulse,
        -strikes["friction"] * result.normal_compressive_impulse,
        rtol=1e-14,
    )


@pytest.mark.parametrize("mu_2", [math.tan(ANGLE), 0.5, 10.0, 1e9])
def test_stiction_ends_with_compression(mu_2):
    result = monofilament_impact(*TOOL, ANGLE, 0.31, E, mu_2)
    assert result.outcome_name == "stiction"
    assert result.normal_final_impulse == result.normal_compressive_impulse
    assert result.final_bristle_rate == -(HUB_RADIUS / LENGTH) * HUB_SPEED


def test_faint_restitution_and_slow_tips_count():
    assert monofilament_impact(*TOOL, ANGLE, 0.31, 1e-9).outcome_name == "rebound"
    slow = monofilament_impact(*TOOL[:4], -HUB_RADIUS / LENGTH + 1e-6, ANGLE, 0.31, E)
    assert slow.outcome_name == "rebound"
    # A difference of R and r_h/L of 1e-6 keeps ten digits.
    impulse = MASS * 1e-6 * HUB_SPEED * LENGTH / (3 * (math.sin(ANGLE) + 0.31 * math.cos(ANGLE)))
    assert slow.normal_compressive_impulse == pytest.approx(impulse, rel=1e-9)
    tip = LENGTH * slow.final_bristle_rate + HUB_RADIUS * HUB_SPEED
    assert -1e-6 * HUB_SPEED * LENGTH < tip < 0.0


def test_rebound_ratio_of_a_bristle_at_rest_is_refused():
    result = monofilament_impact(*TOOL[:4], 0.0, ANGLE, 0.31, E)
    assert result.normal_compressive_impulse > 0.0
    with pytest.raises(ValueError, match="rebound ratio"):
        _ = result.rebound_ratio


class TestEdges:
    def test_friction_of_restitution_is_that_of_compression_by_default(self) -> None:
        """Case 2 (2.59): p_fy = p_cy (1 + e* sqrt(s_1/s_2)), phi'_f = -(r_h/L) w - e* (v_C/L) sqrt(s_2/s_1), by hand."""
        gamma = 0.6
        mu = 0.3
        e = 0.5
        first, second = (
            math.sin(gamma) + mu * math.cos(gamma),
            math.sin(gamma) - mu * math.cos(gamma),
        )
        result = mono.monofilament_impact(
            3.0, 0.5, 0.25, 4.0, 0.5, gamma, mu, e
        )  # v_C = (R L + r_h) w = 2
        assert result.normal_final_impulse == pytest.approx(
            2.0 / first * (1.0 + e * math.sqrt(first / second)), rel=1e-14
        )
        assert result.final_bristle_rate == pytest.approx(
            -2.0 - e * 4.0 * math.sqrt(second / first), rel=1e-14
        )

    def test_a_tip_at_rest_does_not_touch(self) -> None:
        """R = -r_h/L: v_C = (R L + r_h) w = 0, which is no approach."""
        result = mono.monofilament_impact(1.0, 0.5, 0.25, 4.0, -0.5, 0.6, 0.3, 0.5)
        assert result.outcome_name == "no contact"
        assert result.final_bristle_rate == result.initial_bristle_rate == -2.0
