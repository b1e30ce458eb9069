"""The cue: printed geometry, elliptic integrals, an energy balance and a fine march as referees."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipk

from bristle_sim.parameters import Tool
from bristle_sim.theory import cueing

HUB_RADIUS = 0.0275
LENGTH = 0.027
MASS = 8.387e-5
HUB_SPEED = 261.8
INERTIA = MASS * LENGTH**2 / 3
RETRACTION = math.radians(44.5)
PRINTED_PER_RADIAN = 0.00041
PRINTED_PER_DEGREE = math.degrees(0.00041)
CENTRIFUGAL = cueing.centrifugal_stiffness(MASS, HUB_RADIUS, LENGTH, HUB_SPEED)


def march(
    stiffness: float, centrifugal: float, damping: float, steps: int
) -> tuple[float, float, float]:
    """Time and speed where the bristle is fastest, and its speed at the radial direction, by steps of Runge-Kutta 4.

    Unit inertia, released from rest at -RETRACTION. The highest speed is read off a parabola through three steps.
    """

    def slope(state: np.ndarray) -> np.ndarray:
        angle, rate = state
        return np.array([rate, -damping * rate - stiffness * angle - centrifugal * math.sin(angle)])

    step = 4.0 / math.sqrt(stiffness + centrifugal) / steps
    states = [np.array([-RETRACTION, 0.0])]
    for _ in range(steps):
        state = states[-1]
        first = slope(state)
        second = slope(state + step / 2 * first)
        third = slope(state + step / 2 * second)
        fourth = slope(state + step * third)
        states.append(state + step / 6 * (first + 2 * second + 2 * third + fourth))
    angle, rate = np.array(states).T
    top = int(np.argmax(rate))
    low, middle, high = rate[top - 1 : top + 2]
    shift = 0.5 * (low - high) / (low - 2 * middle + high)
    crossing = int(np.argmax(angle >= 0.0))
    share = -angle[crossing - 1] / (angle[crossing] - angle[crossing - 1])
    at_radial = rate[crossing - 1] + share * (rate[crossing] - rate[crossing - 1])
    return (top + shift) * step, middle - 0.25 * (low - high) * shift, at_radial


def test_impact_angle_from_penetration():
    angle = cueing.impact_angle(HUB_RADIUS, LENGTH, 0.0045)
    # Five printed digits; the dissertation rounds it to 23.4 deg.
    assert math.degrees(angle) == pytest.approx(23.447, abs=5e-4)
    assert math.cos(angle) == pytest.approx(50.0 / 54.5, rel=1e-15)
    # gamma ~ sqrt(2 Delta/(r_h + L)), with a relative error of Delta/(12 (r_h + L)).
    assert cueing.impact_angle(HUB_RADIUS, LENGTH, 1e-18) == pytest.approx(
        math.sqrt(2e-18 / 0.0545), rel=1e-15
    )
    assert cueing.impact_angle(HUB_RADIUS, LENGTH, 0.0) == 0.0


def test_printed_release_geometry():
    """r_tip = 50.442 mm and A = 22.035 deg at 44.5 deg; the printed bar position is at S = 55.167 mm and 65.93 deg."""
    assert cueing.tip_radius(HUB_RADIUS, LENGTH, RETRACTION) == pytest.approx(0.050442, abs=5e-7)
    assert math.degrees(cueing.tip_lag(HUB_RADIUS, LENGTH, RETRACTION)) == pytest.approx(
        22.035, abs=5e-4
    )
    rest = math.radians(65.93) - cueing.tip_lag(HUB_RADIUS, LENGTH, RETRACTION)
    gamma = cueing.impact_angle(HUB_RADIUS, LENGTH, 0.0045)
    placed = cueing.placed_cue(Tool(), RETRACTION, (rest - gamma) / HUB_SPEED, 0.0)
    # Printed to 10 and 100 micrometres; direction and distance are rounded to 1e-4 and 1e-5 of themselves.
    assert placed.bar_distance == pytest.approx(0.055167, abs=5e-7)
    assert placed.bar_horizontal == pytest.approx(0.05037, abs=5e-6)
    assert placed.bar_vertical == pytest.approx(0.0225, abs=5e-6)


def test_retraction_at_bar_inverts_the_geometry():
    retraction = np.radians([0.001, 1.0, 20.0, 44.5, 90.0, 150.0])
    distance = 0.004725 + cueing.tip_radius(HUB_RADIUS, LENGTH, retraction)
    place = (distance * math.sin(1.15), distance * math.cos(1.15))
    back = cueing.retraction_at_bar(*place, 0.004725, HUB_RADIUS, LENGTH)
    # The tip radius is even in the angle: its rounding, 1e-16 of 55 mm, costs 1e-16/theta_p.
    assert np.all(np.abs(back - retraction) < 1e-15 / retraction + 1e-14)
    bar = Tool().bar
    printed = cueing.retraction_at_bar(bar.horizontal, bar.vertical, 0.0047246, HUB_RADIUS, LENGTH)
    # r_b + d/2 = 4.725 mm was rounded from 4.7246 mm: 1e-4 mm of radius is 1e-5 rad.
    assert printed == pytest.approx(RETRACTION, abs=1e-5)


def test_printed_stiffness_cannot_be_per_radian():
    """0.00041 N m/rad: 22.6 Hz; the hub turns 166 deg in a quarter period, 69 deg with centrifugal stiffening."""
    plain = cueing.natural_rate(PRINTED_PER_RADIAN, INERTIA)
    assert plain / (2 * math.pi) == pytest.approx(22.6, abs=0.05)
    assert math.degrees(HUB_SPEED * cueing.damped_cue_time(plain, 0.0)) == pytest.approx(
        166.12, abs=0.01
    )
    stiffened = cueing.stiffened_cue_time(RETRACTION, PRINTED_PER_RADIAN, CENTRIFUGAL, INERTIA)
    assert stiffened == pytest.approx(4.6e-3, abs=5e-5)
    assert math.degrees(HUB_SPEED * stiffened) == pytest.approx(69, abs=0.5)


def test_cue_of_the_Tool():
    """Per degree: 170.9 Hz. Stiffened: 1.4052 ms, 21.08 deg, 869.1 rad/s, bar at 66.56 deg, each to its last digit."""
    tool = Tool()
    rate = cueing.natural_rate(PRINTED_PER_DEGREE, INERTIA)
    assert rate / (2 * math.pi) == pytest.approx(170.9, abs=0.05)
    stiffened = cueing.stiffened_cue(tool)
    assert stiffened.cue_time == pytest.approx(1.4052e-3, abs=5e-8)
    assert math.degrees(stiffened.hub_turn) == pytest.approx(21.08, abs=5e-3)
    assert stiffened.highest_relative_speed == pytest.approx(869.1, abs=0.05)
    assert math.degrees(stiffened.bar_direction) == pytest.approx(66.56, abs=5e-3)

    plain = cueing.cue(tool)
    # A quarter of the period of 170.870 Hz, and theta_p times its rate.
    assert plain.cue_time == pytest.approx(0.25 / (rate / (2 * math.pi)), rel=1e-14)
    assert plain.highest_relative_speed == pytest.approx(RETRACTION * rate, rel=1e-14)
    assert math.hypot(plain.bar_horizontal, plain.bar_vertical) == pytest.approx(
        plain.bar_distance, rel=1e-15
    )
    assert math.atan2(plain.bar_horizontal, plain.bar_vertical) == pytest.approx(
        plain.bar_direction, rel=1e-14
    )
    # The bar's radius is chosen so that S is that of the printed position.
    assert plain.bar_distance == pytest.approx(math.hypot(0.05037, 0.0225), rel=1e-14)
    assert plain.bar_direction - plain.hub_turn == pytest.approx(
        plain.tip_lag + plain.impact_angle, rel=1e-14
    )


def test_stiffened_cue_time_without_a_belt_is_the_pendulums():
    """k = 0 is a pendulum: a quarter period K(sin^2(theta_p/2)) sqrt(I/g), K from scipy."""
    retraction = np.radians([1e-6, 1.0, 44.5, 90.0, 120.0, 150.0])
    time = cueing.stiffened_cue_time(retraction, 0.0, 3.0, 2.0)
    # Rounding of 64 terms; the quadrature itself is exact to 1e-15 up to 150 deg.
    np.testing.assert_allclose(
        time, ellipk(np.sin(retraction / 2) ** 2) * math.sqrt(2.0 / 3.0), rtol=3e-15
    )


@pytest.mark.parametrize("zeta", [0.0, 0.018, 0.3, 0.6])
def test_damped_motion_against_a_march(zeta):
    time, speed, _ = march(stiffness=1.0, centrifugal=0.0, damping=2 * zeta, steps=4000)
    # With steps of 1e-3 the parabola misses the top by (1e-3)^2/6, and a chord the speed at the crossing by (1e-3)^2/8.
    assert cueing.damped_cue_time(1.0, zeta) == pytest.approx(time, rel=1e-6)
    assert cueing.damped_highest_speed(RETRACTION, 1.0, zeta) == pytest.approx(speed, rel=1e-9)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: cueing.impact_angle(0.03, 0.03, -1e-3),
            r"^penetration = -0.001: must be 0 to hub_radius \+ length .*\(in m\)",
        ),
        (
            lambda: cueing.impact_angle(0.03, 0.03, np.array([0.0, 0.07])),
            r"^penetration = 0.07: must be 0 to",
        ),
        (
            lambda: cueing.retraction_at_bar(0.2, 0.2, 0.005, 0.03, 0.03),
            r"tip radius = 0.277843: .* \(in m\)",
        ),
        (lambda: cueing.cue(Tool(bar=None)), "^bar, workpart: must both be there"),
    ],
)
def test_bad_input_is_named_in_one_line(call, message):
    with pytest.raises(ValueError, match=message) as refusal:
        call()
    assert "\n" not in str(refusal.value)


class TestEdges:
    def test_a_bar_at_the_ends_of_the_tips_reach(self) -> None:
        """Hub 3, bristle 4: a tip 7 from the centre is not retracted at all, one 1 from it half a turn."""
        assert cueing.retraction_at_bar(7.0, 0.0, 0.0, 3.0, 4.0) == 0.0
        assert cueing.retraction_at_bar(0.0, 1.0, 0.0, 3.0, 4.0) == math.pi


def test_critical_and_overdamped_release():
    """At zeta = 1, alpha' = theta_p Omega^2 t e^(-Omega t): 1/Omega and theta_p Omega/e; the limit far beyond."""
    assert cueing.damped_cue_time(3.0, 1.0) == pytest.approx(1 / 3, rel=1e-15)
    assert cueing.damped_highest_speed(0.5, 3.0, 1.0) == pytest.approx(1.5 / math.e, rel=1e-15)
    # The fast root -2 zeta Omega dies and leaves alpha' = theta_p Omega/(2 zeta), up to order (ln zeta)/zeta^2.
    assert cueing.damped_highest_speed(0.5, 3.0, 1e4) == pytest.approx(0.5 * 3.0 / 2e4, rel=1e-6)
