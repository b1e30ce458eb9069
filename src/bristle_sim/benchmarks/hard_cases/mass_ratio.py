"""Double pendulums whose first rod is up to 1e12 times as heavy, or 1e9 times as light, as the second."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, refusal, within, worst
from bristle_sim.benchmarks.hard_cases.impacts import ACCURACY, agrees_in_time, rate_difference, struck
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.strike import Chain
from bristle_sim.theory.pendulums import DoublePendulumImpact, double_pendulum_impact

__all__ = ["agrees_with_closed_form", "approaching", "mass_ratio", "two_rods"]

ROUNDING = 1e-12
"""Limit of rates and impulses of two rods: rounding, some 1e-15, times 30 = 1/sin^2 of the 10 degrees between them, times 30
more for what the phases make of it; and limit of energies."""

ANGLES = (math.radians(-20.0), math.radians(-30.0))

MOTIONS = {
    "slip": ((1.0, 0.2), 0.2),
    "reverse slip": ((0.1, 0.2), 0.3),
    "stick": ((-1.0, 1.1), 5.0),
}
"""Rates and friction with which the tip slips, reverses or sticks; the second and third as soon as slip has stopped."""

SURE = 1e3
"""Mass ratio up to which a contact in time is followed whatever it does: with a heavier first rod a tip that sticks takes
so much longer to compress than one that slips that rounding of the penetration may hide the slip."""

DRAWS = 60

FLIGHT = 1e-10
"""Accuracy of each interval of a flight; energy is kept to a hundred times that."""


def mass_ratio() -> list[HardCase]:
    """Return a double pendulum's impacts and flight, its first rod 1e-9 to 1e12 times as heavy as its second."""
    rows = []
    for ratio in (1e-9, 1e-6, 1e-3, 0.1, 1.0, 1e3, 1e6, 1e9, 1e12):
        few = partial(_row, f"n = {ratio:g}", quick=ratio in (1e-9, 1e-3, 0.1, 1e3, 1e12))
        for motion, (rates, friction) in MOTIONS.items():
            promise = f"phases of the closed form, its rates and impulse to {ROUNDING:g}, e* of 0, 0.5 and 1"
            chains = [(two_rods(ratio, rates), friction, e) for e in (0.0, 0.5, 1.0)]
            rows.append(few(motion, promise, partial(agrees_with_closed_form, chains, ROUNDING)))
            if ratio >= 0.1:
                sure = motion != "stick" or ratio <= SURE
                timed = partial(
                    agrees_in_time, two_rods(ratio, rates), friction, 0.5, 10 * ACCURACY, may_refuse=not sure
                )
                promise = f"the rigid-body limit's rates to {10 * ACCURACY:g}" + (
                    "" if sure else ", or refused in one line"
                )
                rows.append(few(f"{motion}, in time", promise, timed))
        promise = f"energy ratio at most 1 + {ROUNDING:g}, rates of the closed form to 1e-9"
        rows.append(few(f"{DRAWS} random pendulums", promise, partial(_random_pendulums, ratio)))
        if ratio >= 0.1:
            promise = f"energy and angular momentum kept to {100 * FLIGHT:g}, a hundred times the requested accuracy"
            rows.append(few("flight", promise, partial(_flies, ratio)))
        if ratio < 1e-3:
            rows.append(few("in time", "refused in one line", partial(_refuses_light_rod, ratio)))
    return rows


def _row(place: str, name: str, promise: str, measure: Callable[[], Finding], *, quick: bool) -> HardCase:
    return HardCase("mass_ratio", f"{place}, {name}", promise, measure, quick)


def two_rods(ratio: float, rates: tuple[float, float], angles: tuple[float, float] = ANGLES) -> Chain:
    """Return two rods of 1 m, the second of 1 kg."""
    return Chain((ratio, 1.0), (1.0, 1.0), angles, rates)


def agrees_with_closed_form(strikes: list[tuple[Chain, float, float]], limit: float) -> Finding:
    """Compare strikes of two rods, each with friction and restitution, with Zhang's closed form (2020, sec. 2.4.2)."""
    off, alike = [], True
    for chain, friction, e in strikes:
        contact = struck(chain, friction, e).contact
        form = _closed_form(chain, friction, e)
        alike &= (contact.phases, contact.outcome) == (form.phases, form.outcome)
        off.append(rate_difference(contact.rates_after, (-form.final_rate_1, -form.final_rate_2), chain.rates))
        off.append(contact.impulse[0] / form.normal_final_impulse - 1.0)
    return all_of(within(worst(off), limit, "off by"), Finding(f"phases {'equal' if alike else 'different'}", alike))


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


def _refuses_light_rod(ratio: float) -> Finding:
    rates, friction = MOTIONS["slip"]
    return refusal(lambda: struck(two_rods(ratio, rates), friction, 0.5, "compliant"), "contact = compliant", "1e-3")


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
