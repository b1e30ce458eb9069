"""Pairs of links of two wires: distances and velocities by hand, impacts of free chains, and what the engine touches."""

import numpy as np
import pytest

from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact.laws import EnergeticLaw
from bristle_sim.scene.contact.obstacles import WirePair, wire_pairs
from bristle_sim.scene.mechanism import Link, Mechanism, State

ROW = Mechanism((Link.rod(1.0, 1.0), Link.rod(1.0, 1.0)), hub_radius=1.0, hub_speed=0.3, wires=2, pitch=0.4)
PAIR = WirePair(0, 0, 1, 0, 0.05, 0.0, 0.5)
"""The first rod has fallen back, the second come forward: its end is near the first one's flank."""


def test_velocity_is_the_gaps_rate() -> None:
    """Normal velocity by the difference of gaps of states a little before and after."""
    step = 1e-6
    middle = State(0.0, (-0.3, -0.1), (-0.4, 0.9))
    gaps = []
    for time in (-step, step):
        angles = tuple(a + time * r for a, r in zip(middle.angles, middle.rates, strict=True))
        state = State(time, angles, middle.rates)
        gaps.append(PAIR.closest(ROW.poses(state), state.rates).gap)
    found = PAIR.closest(ROW.poses(middle), middle.rates)
    assert found.velocity[0] == pytest.approx((gaps[1] - gaps[0]) / (2.0 * step), rel=1e-8)


def touching() -> State:
    """The second rod's end on the first one's flank, by bisection of its angle."""
    low, high = -0.3, 0.3
    for _ in range(60):
        middle = 0.5 * (low + high)
        state = State(0.0, (-0.35, middle), (0.0, 0.0))
        low, high = (middle, high) if PAIR.closest(ROW.poses(state), state.rates).gap > 0.0 else (low, middle)
    return State(0.0, (-0.35, low), (-0.2, 1.5))


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_impact_of_two_rods_on_a_hub(friction: float) -> None:
    """Each rod's rate changes by the moment of its impulse about its root over 1/3; the partner's impulse is the opposite."""
    pair = WirePair(0, 0, 1, 0, 0.05, friction, 0.5)
    scene, state = Scene(ROW, Effects(obstacles=(pair,))), touching()
    touch = pair.closest(ROW.poses(state), state.rates)
    assert touch.velocity[0] < 0.0
    after, record = EnergeticLaw().resolve(scene, state, pair)
    impulse = record.impulse[0] * np.array(touch.normal) + record.impulse[1] * np.array(touch.tangent)
    assert touch.partner_arm is not None
    for number, (arm, sign) in enumerate(((touch.arm, 1.0), (touch.partner_arm, -1.0))):
        moment = sign * (arm[0] * impulse[1] - arm[1] * impulse[0])
        assert after.rates[number] - state.rates[number] == pytest.approx(3.0 * moment, rel=1e-11)
    if not friction:
        assert record.velocity_after[0] == pytest.approx(-0.5 * record.velocity_before[0], rel=1e-12)
    assert record.velocity_before == pytest.approx(touch.velocity, rel=1e-12)


def test_pairs_are_of_different_wires() -> None:
    bent = Link(0.5, 0.01, (0.0, -0.2), (0.1, -0.5), ((0.0, -0.3),))
    row = Mechanism((Link.rod(0.5, 0.5), bent) * 2, wires=2, pitch=0.3, hub_radius=1.0)
    pairs = list(wire_pairs(row, 0.01, 0.1, 0.2))
    # One piece of the straight link and two of the bent one, on either side.
    assert len(pairs) == 9
    assert {(each.link // 2, each.partner // 2) for each in pairs} == {(0, 1)}
