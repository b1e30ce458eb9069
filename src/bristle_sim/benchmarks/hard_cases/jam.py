"""Friction at the edge of the jam, from both sides.

The tip of a rod that stands at phi to the normal moves along (sin phi, cos phi), so that a normal impulse p with friction
mu against the slip s turns it by 3 p q/(m L), q = sin phi - mu s cos phi. Where q vanishes no impulse does: at
mu = tan gamma the rod that is pulled over the surface can no longer leave it (stiction), and the rod that is pushed over
it can no longer be stopped (jam). Sine, cosine and product are each rounded, so q is off by some roundings of sin phi
and what is divided by q by as much over the relative distance of mu from tan gamma. Two rods have no such edge: at each
critical friction of theirs one motion gives way to another that goes the same way there.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from functools import partial

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, worst
from bristle_sim.benchmarks.hard_cases.one_rod import RodStrike, rod_strike
from bristle_sim.parameters import Belt, Contact, Surface, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.compliant import LEAST_DURATION
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.impulse_course import contact_inverse_mass
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.pendulums import double_pendulum_impact, single_pendulum_impact
from bristle_sim.trajectory import ContactRecord, Trajectory

__all__ = ["cases", "critical_frictions"]

THEME = "jam"

EPSILON = sys.float_info.epsilon

ROUNDINGS = 16
"""Of sine, cosine, their products, K, and what is made of them: as many epsilons may an impulse be off, and as many over
the distance from the jam near it."""

MASS, LENGTH, RATE, RESTITUTION = 8e-5, 0.027, 845.0, 0.42
"""A rod like the bristle; kg, m, rad/s."""

ANGLES = (1.0, 23.4, 60.0, 89.0)
"""Of the rod to the normal, degrees."""

TWO_RODS = Chain((5.0, 5.0), (1.0, 1.0), (math.radians(20.0), math.radians(-30.0)), (-0.8, 0.4))
"""Two rods whose slip drives the tip into the surface; it stops before restitution ends, so that little is magnified."""

ACCURACY = 1e-10
"""Of a whole pass, and with it of the angle at which its tip strikes."""

LEANING = Tool(belt=Belt(stiffness=0.0), bar=None, workpart=Workpart(penetration=0.0095))
"""A bristle thrown forward, so that its tip is pushed over the workpart."""

START = -0.7
"""Hub angle at which it is thrown, rad."""

LEAN = 1.2
"""Its angle to the radial direction there, rad."""

DEFAULT = Tool()


def cases(full: bool) -> tuple[HardCase, ...]:
    """One rod pulled and pushed, two rods, in time, and whole passes."""
    distances = tuple(10.0**-power for power in range(1, 13)) if full else (1e-3, 1e-6, 1e-9, 1e-12)
    passes = distances if full else (1e-3, 1e-12)
    return (
        *(_pulled(distance) for distance in (*distances, 0.0)),
        *(_pushed(distance) for distance in (*distances, 0.0)),
        *(_two_rods(which, distance) for which in critical_frictions(TWO_RODS) for distance in (*distances, 0.0)),
        *(_in_time(distance) for distance in distances),
        *(_thrown_pass(distance) for distance in (*passes, 0.0)),
        *(_default_pass(distance) for distance in (*passes, 0.0)),
    )


def _near(angle: float, distance: float) -> tuple[float, ...]:
    """Frictions on both sides of the jam, or at it."""
    edge = math.tan(angle)
    return (edge * (1.0 - distance), edge * (1.0 + distance)) if distance else (edge,)


def _place(distance: float) -> str:
    return f"friction {distance:g} off the jam" if distance else "friction at the jam, to rounding"


TO_ROUNDING = f"impulse exact to {ROUNDINGS} roundings over that distance"

PLACES = 2
"""Roundings of the places of tip and root, in lengths, of which a root that is not the origin makes the tip's arm."""

OF_PLACE = f"{TO_ROUNDING}, and {PLACES} of the tip's place"


def _share(expected: RodStrike, impulse: float, places: int) -> float:
    """Of the error allowed, the error of an impulse; a stiction is not magnified."""
    roundings = ROUNDINGS + places * expected.arms
    allowed = roundings * EPSILON * (1.0 if expected.outcome == "stiction" else 1.0 + 1.0 / expected.distance)
    return (impulse / expected.impulse - 1.0) / allowed


def _beside(tries: list[tuple[RodStrike, str, float]], equal: bool, places: int = PLACES) -> Finding:
    """Outcomes and impulses beside the exact ones; at the jam itself rounding decides, but the impulse is finite."""
    words = sorted({outcome for _, outcome, _ in tries})
    if equal:
        most = max(impulse for _, _, impulse in tries)
        finite = all(0.0 <= impulse < math.inf for _, _, impulse in tries)
        named = set(words) <= {"rebound", "stiction", "jam"}
        return Finding(f"{', '.join(words)}; impulse up to {most:.1g} N s", finite and named)
    off = worst([_share(expected, impulse, places) for expected, _, impulse in tries])
    wrong = [f"{outcome} for {expected.outcome}" for expected, outcome, _ in tries if outcome != expected.outcome]
    told = f"; {len(wrong)} wrong, first {wrong[0]}" if wrong else ""
    return Finding(f"{', '.join(words)}; {off:.2g} of the error allowed{told}", not wrong and off <= 1.0)


def _pulled(distance: float) -> HardCase:
    promise = f"rebound below, stiction above; {TO_ROUNDING}" if distance else "either, by name, with a finite impulse"
    return HardCase(THEME, f"rod pulled, {_place(distance)}", promise, partial(_pull, distance))


def _pull(distance: float) -> Finding:
    tries = []
    for angle in map(math.radians, ANGLES):
        for friction in _near(angle, distance):
            expected = rod_strike(MASS, -angle, _velocity(angle), friction, RESTITUTION)
            tries += [(expected, *found) for found in _pulled_by_all(angle, friction)]
    return _beside(tries, distance == 0.0, places=0)


def _velocity(angle: float) -> tuple[float, float]:
    return -LENGTH * RATE * math.sin(angle), LENGTH * RATE * math.cos(angle)


def _pulled_by_all(angle: float, friction: float) -> list[tuple[str, float]]:
    """Outcome and impulse by the scene, the pendulum's theory and the bristle's."""
    hit = strike(_rod(angle), Surface(friction, None, RESTITUTION), Contact(), Settings()).contact
    pendulum = single_pendulum_impact(MASS, LENGTH, angle, -RATE, friction, RESTITUTION)
    bristle = monofilament_impact(MASS, LENGTH, 0.0, RATE, 1.0, angle, friction, RESTITUTION)
    return [
        (hit.outcome, hit.impulse[0]),
        (pendulum.outcome, pendulum.normal_final_impulse),
        (bristle.outcome_name, float(bristle.normal_final_impulse)),
    ]


def _rod(angle: float) -> Chain:
    return Chain((MASS,), (LENGTH,), (-angle,), (RATE,))


def _pushed(distance: float) -> HardCase:
    promise = f"rebound below, jam above; {OF_PLACE}" if distance else "either, by name, with a finite impulse"
    return HardCase(THEME, f"rod pushed, {_place(distance)}", promise, partial(_push, distance))


def _push(distance: float) -> Finding:
    """On a hub that descends, the tip ahead of its root."""
    tries = []
    for angle in map(math.radians, ANGLES):
        chain = Chain((MASS,), (LENGTH,), (angle,), (0.0,), LENGTH, RATE, -1.0)
        for friction in _near(angle, distance):
            hit = strike(chain, Surface(friction, None, RESTITUTION), Contact(), Settings()).contact
            expected = rod_strike(MASS, angle, hit.velocity_before, friction, RESTITUTION)
            tries.append((expected, hit.outcome, hit.impulse[0]))
    return _beside(tries, distance == 0.0)


def critical_frictions(chain: Chain) -> dict[str, float]:
    """Those at which the tip no longer reverses its slip, and at which slip no longer slows the approach."""
    (normal, coupling), (_, tangential) = contact_inverse_mass(chain).tolist()
    return {"sticks": abs(coupling) / tangential, "presses on": normal / abs(coupling)}


CONDITION = float(np.linalg.cond(contact_inverse_mass(TWO_RODS)))

NONE = 1e-12
"""Share of the rods' speeds that their closed form takes for none."""

RODS_LIMIT = NONE + ROUNDINGS * EPSILON * CONDITION
"""Rounding by the condition of K, and nothing of the distance."""


def _two_rods(which: str, distance: float) -> HardCase:
    place = f"{distance:g} off" if distance else "at"
    promise = f"rebound; impulse and rates of the closed form to {RODS_LIMIT:.0e}, finite"
    return HardCase(
        THEME, f"two rods, {place} the friction that {which}", promise, partial(_two_rods_beside, which, distance)
    )


def _two_rods_beside(which: str, distance: float) -> Finding:
    """Also with half that friction in compression, so that the critical one begins with restitution."""
    edge, off, words = critical_frictions(TWO_RODS)[which], [], set()
    for friction in {edge * (1.0 - distance), edge * (1.0 + distance)}:
        for earlier in (friction, 0.5 * friction):
            surface = Surface(earlier, friction, RESTITUTION)
            hit = strike(TWO_RODS, surface, Contact(), Settings()).contact
            off += _off_theory(hit, surface)
            words.add(hit.outcome)
    return Finding(
        f"{', '.join(sorted(words))}; off by {worst(off):.1g}", worst(off) <= RODS_LIMIT and words == {"rebound"}
    )


def _off_theory(hit: ContactRecord, surface: Surface) -> list[float]:
    theory = double_pendulum_impact(
        rod_mass=TWO_RODS.masses[1],
        mass_ratio=1.0,
        rod_length=TWO_RODS.lengths[1],
        angle_1=-TWO_RODS.angles[0],
        angle_2=-TWO_RODS.angles[1],
        rate_1=-TWO_RODS.rates[0],
        rate_2=-TWO_RODS.rates[1],
        friction=surface.friction,
        restitution=surface.restitution,
        restitution_friction=surface.restitution_friction,
    )
    fastest = max(map(abs, hit.rates_before))
    return [
        hit.impulse[0] / theory.normal_final_impulse - 1.0,
        (hit.rates_after[0] + theory.final_rate_1) / fastest,
        (hit.rates_after[1] + theory.final_rate_2) / fastest,
    ]


def _in_time(distance: float) -> HardCase:
    promise = (
        "the rigid-body limit to its duration in radians over sin gamma cos gamma, below the jam over the distance, too;"
        " where that is no digit, an end by name without gain of energy, or a refusal in a line"
    )
    return HardCase(THEME, f"rod in time, {_place(distance)}", promise, partial(_resolve, distance))


def _resolve(distance: float) -> Finding:
    """The rod turns while it is in touch, and with it its distance from the jam."""
    found = []
    for angle in map(math.radians, ANGLES):
        for friction in _near(angle, distance):
            expected = rod_strike(MASS, -angle, _velocity(angle), friction, RESTITUTION)
            turned = LEAST_DURATION / math.sqrt(RESTITUTION) / (math.sin(angle) * math.cos(angle))
            limit = turned if expected.outcome == "stiction" else turned / expected.distance
            found.append(_in_time_beside(angle, friction, expected, limit))
    words = sorted({each.reached for each in found})
    return Finding("; ".join(words), all(each.ok for each in found))


def _in_time_beside(angle: float, friction: float, expected: RodStrike, limit: float) -> Finding:
    try:
        hit = strike(_rod(angle), Surface(friction, None, RESTITUTION), Contact("compliant"), Settings())
    except ValueError as error:
        line = str(error)
        return Finding("refused", limit > WHOLE and "\n" not in line and "allowed" in line)
    off, ratio = hit.contact.impulse[0] / expected.impulse - 1.0, hit.kinetic_energy_ratio
    assert ratio is not None
    lossy = 0.0 <= ratio <= 1.0 and math.isfinite(off)
    if limit > WHOLE:
        return Finding(hit.contact.outcome, lossy and hit.contact.outcome in ("rebound", "no rebound", "stiction"))
    right = hit.contact.outcome == expected.outcome and abs(off) <= limit
    return Finding(f"{hit.contact.outcome} to {'within' if right else 'more than'} that", lossy and right)


WHOLE = 0.1
"""An error that leaves no digit."""


def _hit(run: Trajectory) -> ContactRecord:
    """The first impact on the workpart."""
    return next(each for each in run.contacts if each.obstacle == "workpart" and each.law != "hold")


def _thrown_pass(distance: float) -> HardCase:
    promise = f"as the rod pushed; the reference's impulse to {ACCURACY:g} over the distance, where that is a digit"
    return HardCase(THEME, f"pass, tip pushed, {_place(distance)}", promise, partial(_throw, distance))


def _throw(distance: float) -> Finding:
    """Nothing before the strike knows its friction, so that one run tells the angle of them all."""
    settings = Settings(accuracy=ACCURACY)
    assert LEANING.workpart is not None
    angle = _hit(simulate(LEANING, settings, start_hub_angle=START, start_relative_angle=LEAN)).angles[0]
    found = []
    for friction in _near(angle, distance):
        tool = replace(LEANING, workpart=replace(LEANING.workpart, friction=friction))
        run = simulate(tool, settings, start_hub_angle=START, start_relative_angle=LEAN)
        hit = _hit(run)
        expected = rod_strike(tool.bristle.mass, hit.angles[0], hit.velocity_before, friction, RESTITUTION)
        found += [_beside([(expected, hit.outcome, hit.impulse[0])], distance == 0.0), _whole(run)]
        limit = ACCURACY / (math.sin(angle) * math.cos(angle)) / distance if distance else math.inf
        if limit < WHOLE:
            found.append(
                _beside_reference(
                    run,
                    simulate_reference(tool, accuracy=1e-12, start_hub_angle=START, start_relative_angle=LEAN),
                    limit,
                )
            )
    return both(*found)


def _whole(run: Trajectory) -> Finding:
    """Every number finite; after a jam the run stops by that name."""
    numbers = (run.angles, run.rates, run.tip, run.kinetic_energy, run.normal_force)
    finite = all(bool(np.isfinite(each).all()) for each in numbers)
    jams = _hit(run).outcome == "jam"
    named = jams == (run.stop_reason == "jam") == ("jam" in {each.name for each in run.events})
    return Finding(run.stop_reason, finite and named, run.cost.steps)


def _beside_reference(run: Trajectory, exact: Trajectory, limit: float) -> Finding:
    one, other = _hit(run), _hit(exact)
    off = worst([a / b - 1.0 for a, b in zip(one.impulse, other.impulse, strict=True)])
    return Finding(f"off the reference by {off:.1g}", off <= limit and one.outcome == other.outcome)


NEARLY = 10.0 * ACCURACY
"""Of the default tool's strike: its tip does not move along the rod's own line, so that nothing is magnified."""


def _default_pass(distance: float) -> HardCase:
    promise = f"rebound on both sides; the reference's impulse to {NEARLY:g}"
    return HardCase(THEME, f"default pass, {_place(distance)}", promise, partial(_passes, distance))


def _passes(distance: float) -> Finding:
    settings, found = Settings(accuracy=ACCURACY), []
    angle = -_hit(simulate(DEFAULT, settings, stop_after="strike")).angles[0]
    for friction in _near(angle, distance):
        tool = replace(DEFAULT, workpart=Workpart(friction=friction))
        run = simulate(tool, settings)
        exact = simulate_reference(tool, accuracy=1e-12, stop_after="strike")
        found += [_whole(run), _beside_reference(run, exact, NEARLY)]
    return both(*found)
