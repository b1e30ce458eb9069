"""Friction at the edge of the jam, from both sides.

The tip of a rod that stands at phi to the normal moves along (sin phi, cos phi), so that a normal impulse p with friction
mu against the slip s turns it by 3 p q/(m L), q = sin phi - mu s cos phi. Where q vanishes no impulse does: at
mu = tan gamma the rod that is pulled over the surface can no longer leave it (stiction), and the rod that is pushed over
it can no longer be stopped (jam). Sine, cosine and product are each rounded, so q is off by some roundings of sin phi
and what is divided by q by as much over the relative distance of mu from tan gamma. Two rods have no such edge: at each
critical friction of theirs one motion gives way to another that is equal to it there.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from functools import partial

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, row, within, worst
from bristle_sim.benchmarks.hard_cases.impacts import LEANING, THROWN
from bristle_sim.benchmarks.hard_cases.measures import (
    LEAST_DIGIT,
    Start,
    agrees_in_time,
    impacts_of,
    is_finite,
    struck,
)
from bristle_sim.parameters import Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.contact.compliant import LEAST_DURATION
from bristle_sim.scene.strike import Chain
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord

EPSILON = sys.float_info.epsilon

ROUNDINGS = 20
"""Roundings of friction, sine, cosine, their products and K: an impulse may be off by as many epsilons, and near the jam by
as many over the distance from it."""

PLACES = 2
"""Roundings of the places of tip and root, in lengths, from which a root on a hub makes the tip's arm."""

MASS, LENGTH, RATE, RESTITUTION = 8e-5, 0.027, 845.0, 0.42
"""A rod like the bristle; kg, m, rad/s."""

ANGLES = tuple(map(math.radians, (1.0, 23.4, 60.0, 89.0)))
"""Angles of the rod to the normal, rad."""

ACCURACY = 1e-10
"""Requested accuracy of a whole pass, and with it of the angle at which its tip strikes."""

EXACT = f"; impulse exact to {ROUNDINGS} roundings over that distance"
NAMED = "either end, by name, with a finite impulse"


def jam() -> list[HardCase]:
    """Return one rod pulled and pushed, contacts in time, and whole passes, with friction on both sides of the jam."""
    rows = []
    for distance in (1e-3, 1e-6, 1e-9, 1e-12, 0.0):
        case = partial(row, "jam")
        place = f"friction {distance:g} off the jam" if distance else "friction at the jam, to rounding"
        promise = f"rebound below, jam above{EXACT}" if distance else NAMED
        rows.append(case(f"rod pushed, {place}", promise, _one_rod, True, distance))
        if not distance:
            rows.append(case(f"rod pulled, {place}", promise, _one_rod, False, distance))
        if distance:
            promise = "the rigid-body limit to what the rod turns meanwhile over the distance; else refused in one line"
            rows.append(case(f"rod in time, {place}", promise, _in_time, distance))
        if distance in (1e-3, 1e-12, 0.0):
            promise, limit = (
                f"the reference's impulse to {ACCURACY:g} over the distance",
                ACCURACY / (distance or 1e-99),
            )
            rows.append(case(f"pass, tip pushed, {place}", promise, _passes, LEANING, THROWN, distance, limit))
            promise = f"the reference's impulse to {10.0 * ACCURACY:g}: its tip does not move along the rod's own line"
            rows.append(case(f"default pass, {place}", promise, _passes, Tool(), {}, distance, 10.0 * ACCURACY))
    return rows


def rod_near_jam(angle: float, velocity: tuple[float, float], distance: float, restitution: float) -> tuple[str, float]:
    """Return outcome and impulse over mass (m/s) of one rod's strike with the friction tan(angle) (1 + distance).

    Its tip arrives with (v_n, v_t > 0) in m/s; the angle to the normal (rad) is positive for a tip ahead of its root. With
    the distance d put into q by hand, no digit is lost to the difference. Pulled, slip and compression stop together, and
    p_c = -v_n/(3 sin^2 (2 + d)); pushed, slip lasts while it can, and p_c = v_n/(3 sin^2 d).
    """
    sine, cosine = abs(math.sin(angle)), math.cos(angle)
    if angle > 0.0:
        if distance >= 0.0:
            return "jam", velocity[1] / (3.0 * sine * cosine * distance)
        return "rebound", velocity[0] / (3.0 * sine**2 * distance) * (1.0 + restitution)
    compressive = -velocity[0] / (3.0 * sine**2 * (2.0 + distance))
    if distance >= 0.0:
        return "stiction", compressive
    return "rebound", compressive * (1.0 + restitution * math.sqrt(-(2.0 + distance) / distance))


def _one_rod(pushed: bool, distance: float) -> Finding:
    """Compare the strikes of rods at several angles with the closed form; at the jam rounding decides."""
    off, words, wrong = [], set(), []
    for angle in ANGLES:
        for side in {-distance, distance}:
            hit = _strike(pushed, angle, math.tan(angle) * (1.0 + side))
            words.add(hit.outcome)
            if not distance:
                wrong += [] if 0.0 <= hit.impulse[0] < math.inf else [f"impulse {hit.impulse[0]:g}"]
                continue
            outcome, exact = rod_near_jam(angle if pushed else -angle, hit.velocity_before, side, RESTITUTION)
            roundings = ROUNDINGS + PLACES / (math.sin(angle) * math.cos(angle))
            magnified = 1.0 if outcome == "stiction" else 1.0 + 1.0 / distance
            off.append((hit.impulse[0] / (MASS * exact) - 1.0) / (roundings * EPSILON * magnified))
            wrong += [] if hit.outcome == outcome else [f"{hit.outcome} instead of {outcome}"]
    told = f"{', '.join(sorted(words))}{'; ' + wrong[0] if wrong else ''}"
    named = not wrong and words <= {"rebound", "stiction", "jam"}
    return all_of(Finding(told, named), within(worst(off), 1.0, "off by, of the limit,"))


def _strike(pushed: bool, angle: float, friction: float) -> ContactRecord:
    """Return the strike of a rod on a hinge, or of one that a descending hub pushes ahead of its root."""
    pushing = Chain((MASS,), (LENGTH,), (angle,), (0.0,), LENGTH, RATE, -1.0)
    return struck(pushing if pushed else _pulled(angle), friction, RESTITUTION).contact


def _pulled(angle: float) -> Chain:
    return Chain((MASS,), (LENGTH,), (-angle,), (RATE,))


def _in_time(distance: float) -> Finding:
    """The rod turns while it is in touch, and with it its distance from the jam."""
    found = []
    for angle in ANGLES:
        for side in (-distance, distance):
            turned = LEAST_DURATION / math.sqrt(RESTITUTION) / (math.sin(angle) * math.cos(angle))
            limit = turned if side > 0.0 else turned / distance
            found.append(agrees_in_time(_pulled(angle), math.tan(angle) * (1.0 + side), RESTITUTION, limit))
    words = sorted({each.reached.split(";")[0] for each in found})
    return Finding(", ".join(words), all(each.ok for each in found), sum(each.steps for each in found))


def _passes(tool: Tool, start: Start, distance: float, limit: float) -> Finding:
    """Compare the impulse of a pass's strike with the reference's, with friction on both sides of the jam at its angle.

    Nothing before the strike knows its friction, so that one run tells the angle of them all.
    """
    settings = Settings(accuracy=ACCURACY)
    assert tool.workpart is not None
    first = impacts_of(simulate(tool, settings, stop_after="strike", **start), "workpart")[0]
    angle, found = abs(first.angles[0]), []
    limit /= math.sin(angle) * math.cos(angle)
    for side in sorted({-distance, distance}):
        rough = replace(tool, workpart=replace(tool.workpart, friction=math.tan(angle) * (1.0 + side)))
        run = simulate(rough, settings, **start)
        hit = impacts_of(run, "workpart")[0]
        named = (hit.outcome == "jam") == (run.stop_reason == "jam")
        found.append(Finding(f"{hit.outcome}, {run.stop_reason}", named and is_finite(run), run.cost.steps))
        if limit < LEAST_DIGIT:
            exact = simulate_reference(rough, accuracy=1e-12, stop_after="strike", **start)
            other = impacts_of(exact, "workpart")[0]
            off = worst(a / b - 1.0 for a, b in zip(hit.impulse, other.impulse, strict=True))
            found.append(within(off if hit.outcome == other.outcome else math.nan, limit, "off the reference by"))
    return all_of(*found)
