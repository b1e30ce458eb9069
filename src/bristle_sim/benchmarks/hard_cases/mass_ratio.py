"""A double pendulum whose first rod is up to 1e12 times as heavy, or 1e9 times as light, as the second."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, refusal, within, worst
from bristle_sim.parameters import Contact, DoublePendulum, Surface
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.stepping import PlainSteps
from bristle_sim.scene.strike import Chain, ChainStrike, strike
from bristle_sim.settings import Settings
from bristle_sim.theory.pendulums import double_pendulum_impact

__all__ = ["MOTIONS", "cases", "chain"]

THEME = "mass_ratio"

LIMIT = 1e-12
"""Of rates and impulses: rounding, some 1e-15 over a contact, times 30 = 1/sin^2 of the rods' 10 degrees, times 30 more
for what the phases make of it."""

GAIN = 1e-12
"""Of energy."""

ACCURACY = 1e-6
"""Asked for where a contact is resolved in time; its outcome is the rigid one to ten times that."""

FLIGHT = 1e-10
"""Accuracy of a stretch in flight; energy is kept to a hundred times that."""

RATIOS = (1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12)

ANGLES = (math.radians(-20.0), math.radians(-30.0))

MOTIONS = {
    "slip": ((1.0, 0.2), 0.2),
    "reverse slip": ((0.1, 0.2), 0.3),
    "stick": ((-1.0, 1.1), 5.0),
}
"""Rates and friction with which the tip slips, reverses or sticks; the second and third as soon as slip has stopped."""

DRAWS = 60
"""Random pendulums at a ratio."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Impacts, limits, laws and flight at every ratio, or at both ends and between."""
    ratios = RATIOS if full else (1e-9, 1e-3, 1e3, 1e12)
    heavy = (1e3, 1e6, 1e9, 1e12) if full else (1e3, 1e12)
    return (
        *(_beside_closed_form(word, ratio) for word in MOTIONS for ratio in ratios),
        *(_never_gained(ratio) for ratio in ratios),
        *(_on_heavy_rod(ratio) for ratio in heavy),
        *(_in_time(word, ratio) for word in MOTIONS for ratio in (0.1, *heavy)),
        *(_too_light(ratio) for ratio in (1e-9, 1e-6)),
        *(_flight(ratio) for ratio in ((1e-3,) if full else ()) + (1e-2, *heavy)),
        *(_plain_flight(ratio) for ratio in (1e-2, *heavy)),
        *(
            HardCase(THEME, f"n = {n!r}", "refused in one line", partial(_refused, n))
            for n in (9e-10, 1.1e12, math.nan)
        ),
    )


def chain(ratio: float, rates: tuple[float, float], angles: tuple[float, float] = ANGLES) -> Chain:
    """Two rods of 1 m, the second of 1 kg."""
    return Chain((ratio, 1.0), (1.0, 1.0), angles, rates)


def _case(name: str, promise: str, measure: Callable[[], Finding]) -> HardCase:
    return HardCase(THEME, name, promise, measure)


def _hit(pendulum: Chain, friction: float, restitution: float, law: str = "energetic") -> ChainStrike:
    return strike(pendulum, Surface(friction, None, restitution), Contact(law), Settings(accuracy=ACCURACY))


def _beside_closed_form(word: str, ratio: float) -> HardCase:
    promise = f"closed form's phases, its rates and impulses to {LIMIT:g}, e* of 0, 0.5 and 1"
    return _case(f"n = {ratio:g}, {word}", promise, partial(_difference, word, ratio))


def _difference(word: str, ratio: float) -> Finding:
    rates, friction = MOTIONS[word]
    angle_1, angle_2 = ANGLES
    off, same = [], True
    for e in (0.0, 0.5, 1.0):
        contact = _hit(chain(ratio, rates), friction, e).contact
        form = double_pendulum_impact(1.0, ratio, 1.0, -angle_1, -angle_2, -rates[0], -rates[1], friction, e)
        same &= (contact.phases, contact.outcome) == (form.phases, form.outcome)
        expected = (-form.final_rate_1, -form.final_rate_2)
        size = max(map(abs, (*rates, *expected)))
        off += [(found - value) / size for found, value in zip(contact.rates_after, expected, strict=True)]
        off += [contact.impulse[0] / form.normal_final_impulse - 1.0]
    return both(within(worst(off), LIMIT, "off by"), Finding(f"phases {'the same' if same else 'different'}", same))


def _never_gained(ratio: float) -> HardCase:
    promise = f"energy ratio at most 1 + {GAIN:g}, rates those of the closed form to 1e-9"
    return _case(f"n = {ratio:g}, {DRAWS} random pendulums", promise, partial(_gain, ratio))


def _gain(ratio: float) -> Finding:
    rng = np.random.default_rng(1)
    gains, off = [0.0], []
    for draw in range(DRAWS):
        angles, rates = _approaching(rng, near_stick=draw % 2 == 1)
        friction, e = float(rng.uniform(0.0, 4.0)), float(rng.choice([0.5, 1.0]))
        hit = _hit(chain(ratio, rates, angles), friction, e)
        assert hit.kinetic_energy_ratio is not None
        gains.append(max(hit.kinetic_energy_ratio - 1.0, 0.0))
        form = double_pendulum_impact(1.0, ratio, 1.0, -angles[0], -angles[1], -rates[0], -rates[1], friction, e)
        expected = (-form.final_rate_1, -form.final_rate_2)
        size = max(map(abs, (*rates, *expected)))
        off += [(one - two) / size for one, two in zip(hit.contact.rates_after, expected, strict=True)]
    return both(within(worst(gains), GAIN, "gained"), within(worst(off), 1e-9, "rates off by"))


def _approaching(rng: np.random.Generator, *, near_stick: bool) -> tuple[tuple[float, float], tuple[float, float]]:
    """Angles and rates of a tip that approaches, perhaps nearly without slip."""
    first, second = (float(each) for each in rng.uniform(-1.3, 1.3, size=2))
    one, two = (float(each) for each in rng.normal(size=2))
    if near_stick:
        one = -two * math.cos(second) / math.cos(first) * (1.0 + 0.1 * one)
    if math.sin(first) * one + math.sin(second) * two > 0.0:
        one, two = -one, -two
    return (first, second), (one, two)


def _on_heavy_rod(ratio: float) -> HardCase:
    promise = f"the second rod's on a support that keeps its motion, to 6 p/(n m L) and {LIMIT:g}"
    return _case(f"n = {ratio:g}, the limit of a rod on a support", promise, partial(_support, ratio))


def _support(ratio: float) -> Finding:
    """In lasting slip v_n after is -e* times v_n before.

    The joint passes on no more than the impulse p, of which the first rod's rate changes by 3 p/(n m L) at most, and the
    second's by less; another factor of 2 is for the impulse, which has an error of order 1/n itself.
    """
    (one, two), friction = MOTIONS["slip"]
    (first, second), e = ANGLES, 0.3
    approach = -(math.sin(first) * one + math.sin(second) * two)
    rise = (1.0 + e) * approach
    levers = math.sin(second) - friction * math.cos(second)
    impulse = rise / (3.0 * math.sin(second) * levers) * math.hypot(1.0, friction)
    expected = (one, two + rise / math.sin(second))
    contact = _hit(chain(ratio, (one, two)), friction, e).contact
    off = worst([found - value for found, value in zip(contact.rates_after, expected, strict=True)])
    return within(off, 6.0 * impulse / ratio + LIMIT, "off by")


def _in_time(word: str, ratio: float) -> HardCase:
    sure = word != "stick" or ratio <= SURE
    promise = f"the rigid-body limit's rates to {10.0 * ACCURACY:g}" + ("" if sure else ", or one line that refuses")
    return _case(f"n = {ratio:g}, {word}, in time", promise, partial(_resolved, word, ratio, sure))


SURE = 1e3
"""With a heavier first rod a tip that sticks takes so much longer to compress than one that slips that rounding of the
penetration may hide the slip."""


def _resolved(word: str, ratio: float, sure: bool) -> Finding:
    rates, friction = MOTIONS[word]
    limit = _hit(chain(ratio, rates), friction, 0.5).contact

    def resolve() -> ChainStrike:
        return _hit(chain(ratio, rates), friction, 0.5, "compliant")

    if not sure:
        refused = refusal(resolve, "contact", "allowed")
        if refused.ok:
            return refused
    hit = resolve()
    size = max(map(abs, (*rates, *limit.rates_after)))
    off = [(found - value) / size for found, value in zip(hit.contact.rates_after, limit.rates_after, strict=True)]
    return both(
        within(worst(off), 10.0 * ACCURACY, "off by", hit.steps),
        Finding(hit.contact.outcome, hit.contact.outcome == limit.outcome),
    )


def _too_light(ratio: float) -> HardCase:
    def refused() -> Finding:
        rates, friction = MOTIONS["slip"]
        scene = Scene(_mechanism(ratio), Effects())
        told = refusal(lambda: _hit(chain(ratio, rates), friction, 0.5, "compliant"), "contact = compliant", "1e-3")
        return both(told, Finding(f"scene solves joints: {scene.solves_joints}", not scene.solves_joints))

    return _case(
        f"n = {ratio:g}, in time", "refused in one line; the scene says that it does not solve joints", refused
    )


def _mechanism(ratio: float) -> Mechanism:
    return Mechanism((Link.rod(ratio, 1.0), Link.rod(1.0, 1.0)))


START = State(0.0, (0.6, -0.4), (0.5, -1.0))
"""Of a flight: a turn of the second rod is half done in its 3 s."""

END = 3.0


def _flight(ratio: float) -> HardCase:
    limit = 100.0 * FLIGHT
    promise = f"energy and angular momentum kept to {limit:g}, the light rod's own to {limit:g} and 10/n"
    return _case(f"n = {ratio:g}, flight", promise, partial(_flown, ratio))


def _flown(ratio: float) -> Finding:
    mechanism = _mechanism(ratio)
    scene, stepper, state = Scene(mechanism, Effects()), Extrapolation(FLIGHT), START
    off, own = [0.0], [0.0]
    while state.time < END:
        length = stepper.propose(END - state.time)
        result = stepper.advance(scene, state, length)
        if stepper.accepts(result, length):
            state = result.state
            off.append(mechanism.kinetic_energy(state) / mechanism.kinetic_energy(START) - 1.0)
            off.append((_momentum(ratio, state) - _momentum(ratio, START)) / (ratio + 1.0))
            own.append(_relative(state) - _relative(START))
    kept = within(worst(off), 100.0 * FLIGHT, "energy, momentum off by", scene.steps)
    if ratio < SURE:
        return kept
    return both(kept, within(worst(own), 100.0 * FLIGHT + 10.0 / ratio, "light rod's by"))


def _momentum(ratio: float, state: State) -> float:
    """Angular momentum about the root, for m = L = 1."""
    (first, second), (one, two) = state.angles, state.rates
    return (ratio / 3.0 + 1.0) * one + two / 3.0 + math.cos(first - second) * (one + two) / 2.0


def _relative(state: State) -> float:
    """What a rod keeps on a support that turns at an even rate w: (a')^2/2 - 3/2 w^2 cos a, a being its angle to it."""
    (first, second), (one, two) = state.angles, state.rates
    return (two - one) ** 2 / 2.0 - 1.5 * one**2 * math.cos(second - first)


STEP = 1e-3
"""Of plain steps, s."""


def _plain_flight(ratio: float) -> HardCase:
    return _case(
        f"n = {ratio:g}, 1000 plain steps", "joints open by no more than (w h)^2 L in a step", partial(_opened, ratio)
    )


def _opened(ratio: float) -> Finding:
    """A joint that goes straight on for a step of h is off its circle by (w h)^2 L/2; the next step closes that."""
    scene, stepper, state = Scene(_mechanism(ratio), Effects()), PlainSteps(STEP), START
    gaps = []
    for _ in range(1000):
        state = stepper.advance(scene, state, STEP).state
        for joint in scene.joints:
            gap = joint.a.local_to_world(joint.anchor_a) - joint.b.local_to_world(joint.anchor_b)
            gaps.append(gap.length / STEP**2 / sum(rate**2 for rate in state.rates))
    return within(worst(gaps), 1.0, "gap over (w h)^2 L", scene.steps)


def _refused(ratio: float) -> Finding:
    words = ("mass_ratio", "1e-09 <= mass_ratio <= 1e+12")
    theory = refusal(lambda: double_pendulum_impact(1.0, ratio, 1.0, 0.3, 0.5, -0.1, -0.2, 0.3, 0.5), "mass_ratio")
    parameters = refusal(lambda: DoublePendulum(mass_ratio=ratio), *words)
    return parameters if ratio < 1.0 else both(parameters, Finding("theory too", theory.ok))
