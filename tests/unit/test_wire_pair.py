"""Pairs of links of two wires: distances and velocities by hand, impacts of free chains, and what the engine touches."""

import math

import numpy as np
import pymunk
import pytest

from bristle_sim.contact_space.impulse import contact_space
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact.laws import Coefficients, EnergeticLaw
from bristle_sim.scene.contact.obstacles import WirePair, wire_pairs
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.theory.impact import energetic_impact

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
    after, record = EnergeticLaw().resolve(scene, state, pair, Coefficients.of(pair))
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


def free_chain(space: pymunk.Space, rng: np.random.Generator, links: int) -> list[pymunk.Body]:
    """Rods of random masses and places, hinged end to end, with random velocities that the hinges allow."""
    bodies: list[pymunk.Body] = []
    end, velocity = rng.normal(size=2), rng.normal(size=2)
    for _ in range(links):
        mass, length, angle, rate = 10.0 ** rng.uniform(-1, 1), rng.uniform(0.2, 2.0), rng.uniform(-3, 3), rng.normal()
        body = pymunk.Body(mass, mass * length**2 / 12.0)
        half = 0.5 * length * np.array([math.sin(angle), -math.cos(angle)])
        turned = np.array([-half[1], half[0]])
        body.angle, body.position = angle, tuple(end + half)
        body.velocity, body.angular_velocity = tuple(velocity + rate * turned), float(rate)
        space.add(body)
        if bodies:
            space.add(pymunk.PivotJoint(bodies[-1], body, tuple(end)))
        bodies.append(body)
        end, velocity = end + 2.0 * half, velocity + 2.0 * rate * turned
    return bodies


def momenta(bodies: list[pymunk.Body]) -> np.ndarray:
    """Momentum and angular momentum about the origin."""
    found = np.zeros(3)
    for body in bodies:
        (x, y), (u, v) = body.position, body.velocity
        found += body.mass * np.array([u, v, x * v - y * u]) + np.array([0.0, 0.0, body.moment * body.angular_velocity])
    return found


def energy(bodies: list[pymunk.Body]) -> float:
    return sum(0.5 * (b.mass * b.velocity.dot(b.velocity) + b.moment * b.angular_velocity**2) for b in bodies)


@pytest.mark.parametrize("seed", range(25))
def test_free_chains_that_collide_keep_their_momentum(seed: int) -> None:
    """And never gain energy, with any friction and restitution."""
    rng = np.random.default_rng(seed)
    space = pymunk.Space()
    first, second = (free_chain(space, rng, int(rng.integers(1, 6))) for _ in range(2))
    angle = rng.uniform(0.0, math.tau)
    point, normal = tuple(rng.normal(size=2)), (math.cos(angle), math.sin(angle))
    contact = contact_space(first[-1], point, normal, second[int(rng.integers(len(second)))])
    if contact.velocity[0] > 0.0:
        normal = (-normal[0], -normal[1])
        contact = contact_space(first[-1], point, normal, second[-1])
    before, kinetic = momenta(first + second), energy(first + second)
    friction, restitution = rng.uniform(0.0, 1.0, 2)
    impact = energetic_impact(
        contact.inverse_mass, contact.velocity, friction, restitution, friction, contact.stick_compliance
    )
    contact.apply((impact.impulse_normal, impact.impulse_tangential))
    size = float(np.abs(before).max()) + abs(impact.impulse_normal) * (1.0 + math.hypot(*point))
    # Rounding of the sum over up to ten bodies, whose joints' impulses are larger than the contact's by mass ratios up to 100.
    assert momenta(first + second) == pytest.approx(before, abs=1e-12 * size)
    assert energy(first + second) <= kinetic * (1.0 + 1e-12)
