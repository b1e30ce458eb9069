"""Double pendulums whose first rod is up to 1e12 times as heavy, or 1e9 times as light, as the second."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, row, within, worst
from bristle_sim.benchmarks.hard_cases.impacts import ANGLES, ROUNDING
from bristle_sim.benchmarks.hard_cases.measures import rate_difference, struck
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.integrate.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.strike import Chain
from bristle_sim.theory.pendulums import DoublePendulumImpact, double_pendulum_impact

DRAWS = 60

FLIGHT = 1e-10
"""Accuracy of each interval of a flight; energy is kept to a hundred times that."""


def mass_ratio() -> list[HardCase]:
    """Return random impacts and a flight of double pendulums, the first rod 1e-9 to 1e12 times as heavy as the second."""
    rows = []
    for ratio in (1e-9, 1e-3, 0.1, 1e3, 1e12):
        promise = f"energy ratio at most 1 + {ROUNDING:g}, rates of the closed form to 1e-9"
        rows.append(row("mass_ratio", f"n = {ratio:g}, {DRAWS} random pendulums", promise, _random_pendulums, ratio))
        if ratio >= 0.1:
            promise = f"energy and angular momentum kept to {100 * FLIGHT:g}, a hundred times the requested accuracy"
            rows.append(row("mass_ratio", f"n = {ratio:g}, flight", promise, _flies, ratio))
    return rows


def two_rods(ratio: float, rates: tuple[float, float], angles: tuple[float, float] = ANGLES) -> Chain:
    """Return two rods of 1 m, the second of 1 kg."""
    return Chain((ratio, 1.0), (1.0, 1.0), angles, rates)


def _closed_form(chain: Chain, friction: float, restitution: float) -> DoublePendulumImpact:
    (first, second), (one, two) = chain.angles, chain.rates
    mass, ratio = chain.masses[1], chain.masses[0] / chain.masses[1]
    return double_pendulum_impact(mass, ratio, chain.lengths[0], -first, -second, -one, -two, friction, restitution)


def _random_pendulums(ratio: float) -> Finding:
    rng = np.random.default_rng(1)
    gains, off = [], []
    for draw in range(DRAWS):
        chain = approaching(rng, ratio, near_stick=draw % 2 == 1)
        friction, e = float(rng.uniform(0.0, 4.0)), float(rng.choice([0.5, 1.0]))
        hit = struck(chain, friction, e)
        gains.append(max((hit.kinetic_energy_ratio or 0.0) - 1.0, 0.0))
        form = _closed_form(chain, friction, e)
        off.append(rate_difference(hit.contact.rates_after, (-form.final_rate_1, -form.final_rate_2), chain.rates))
    return all_of(within(worst(gains), ROUNDING, "gained"), within(worst(off), 1e-9, "rates off by"))


def approaching(rng: np.random.Generator, ratio: float, *, near_stick: bool) -> Chain:
    """Return random rods whose tip approaches the surface, nearly without slip if requested."""
    first, second = (float(each) for each in rng.uniform(-1.3, 1.3, size=2))
    one, two = (float(each) for each in rng.normal(size=2))
    if near_stick:
        one = -two * math.cos(second) / math.cos(first) * (1.0 + 0.1 * one)
    if math.sin(first) * one + math.sin(second) * two > 0.0:
        one, two = -one, -two
    return two_rods(ratio, (one, two), (first, second))


def _flies(ratio: float) -> Finding:
    """Carry two rods for 3 s, half a turn of the second, and compare energy and angular momentum about the root."""
    mechanism = Mechanism((Link.rod(ratio, 1.0), Link.rod(1.0, 1.0)))
    start = state = State(0.0, (0.6, -0.4), (0.5, -1.0))
    scene, stepper, off = Scene(mechanism, Effects()), Extrapolation(FLIGHT), []
    while state.time < 3.0:
        length = stepper.propose(3.0 - state.time)
        result = stepper.advance(scene, state, length)
        if stepper.accepts(result, length):
            state = result.state
            off.append(mechanism.kinetic_energy(state) / mechanism.kinetic_energy(start) - 1.0)
            off.append((_angular_momentum(ratio, state) - _angular_momentum(ratio, start)) / (ratio + 1.0))
    return within(worst(off), 100.0 * FLIGHT, "off by", scene.steps)


def _angular_momentum(ratio: float, state: State) -> float:
    """Return the angular momentum about the root, for m = L = 1."""
    (first, second), (one, two) = state.angles, state.rates
    return (ratio / 3.0 + 1.0) * one + two / 3.0 + math.cos(first - second) * (one + two) / 2.0
