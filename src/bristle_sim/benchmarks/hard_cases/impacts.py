"""Strikes where they are hard: extreme mass ratios, the edge of the jam, grazing tips, ends of the coefficients' ranges."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, refusal, row, within, worst
from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    MORE_ACCURATE,
    STRIKE_ACCURACY,
    Start,
    agrees_in_time,
    agrees_with_closed_form,
    agrees_with_reference,
    end_difference,
    impacts_of,
    is_finite,
    struck,
)
from bristle_sim.parameters import Belt, Tool, Workpart
from bristle_sim.scene.strike import Chain
from bristle_sim.scene.tool import START, simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.impulse_course import contact_inverse_mass
from bristle_sim.theory.monofilament import LEAST_ANGLE

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length
TIP = ROOT + LENGTH

EPSILON = 2.0**-52

RATE, RESTITUTION = 845.0, 0.42
"""A rod that strikes like the bristle; rad/s, 1."""

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


def mass_ratio() -> Iterator[HardCase]:
    """Yield a double pendulum's impacts, its first rod 1e-9 to 1e12 times as heavy as its second."""
    for ratio in (1e-9, 1e-6, 1e-3, 0.1, 1.0, 1e3, 1e6, 1e9, 1e12):
        place, case = f"n = {ratio:g}", partial(row, "mass_ratio", quick=ratio in (1e-9, 1e-3, 0.1, 1e3, 1e12))
        for motion, (rates, friction) in MOTIONS.items():
            chain = Chain((ratio, 1.0), (1.0, 1.0), ANGLES, rates)
            promise = f"phases of the closed form, its rates and impulse to {ROUNDING:g}, e* of 0, 0.5 and 1"
            strikes = [(chain, friction, e) for e in (0.0, 0.5, 1.0)]
            yield case(f"{place}, {motion}", promise, agrees_with_closed_form, strikes, ROUNDING)
            if ratio >= 0.1:
                sure, limit = motion != "stick" or ratio <= SURE, 10 * STRIKE_ACCURACY
                promise = f"the rigid-body limit's rates to {limit:g}" + ("" if sure else ", or refused in one line")
                timed = partial(agrees_in_time, chain, friction, 0.5, limit, may_refuse=not sure)
                yield case(f"{place}, {motion}, in time", promise, timed)
        if ratio < 1e-3:
            light = partial(struck, Chain((ratio, 1.0), (1.0, 1.0), ANGLES, (1.0, 0.2)), 0.2, 0.5, "compliant")
            words = ("contact = compliant", "1e-3")
            yield case(f"{place}, in time", "refused in one line", refusal, light, *words)


ROUNDINGS = 40
"""Roundings of friction, sine, cosine, their products and K, here and in the closed form: an impulse may be off by as many
epsilons, and near the jam by as many over the distance from it."""

TWO_RODS = Chain((5.0, 5.0), (1.0, 1.0), (math.radians(20.0), math.radians(-30.0)), (-0.8, 0.4))
"""Two rods whose slip drives the tip into the surface; it stops before restitution ends, so that little is magnified."""

TWO_RODS_LIMIT = ROUNDING + 0.5 * ROUNDINGS * EPSILON * float(np.linalg.cond(contact_inverse_mass(TWO_RODS)))
"""Ratio of the rods' speeds that their closed form takes for 0, and rounding times the condition of K."""

LEANING = Tool(belt=Belt(stiffness=0.0), bar=None, workpart=Workpart(penetration=0.0095))
"""A bristle thrown forward from ``THROWN``, so that its tip is pushed over the workpart."""

THROWN: Start = {"start_hub_angle": -0.7, "start_relative_angle": 1.2}


def jam() -> Iterator[HardCase]:
    """Yield a rod that is pulled, two rods, and passes, with friction on both sides of an edge.

    At mu = tan gamma a rod that is pulled over the surface can no longer leave it (stiction), and one that is pushed over
    it can no longer be stopped (jam). At each critical friction of two rods one motion gives way to another.
    """
    (normal, coupling) = contact_inverse_mass(TWO_RODS)[0].tolist()
    critical = {
        "sticks": abs(coupling) / float(contact_inverse_mass(TWO_RODS)[1, 1]),
        "presses on": normal / abs(coupling),
    }
    for distance in (10.0**-power for power in range(1, 13)):
        case = partial(row, "jam", quick=distance in (1e-3, 1e-6, 1e-9, 1e-12))
        place = f"friction {distance:g} off the jam"
        promise = f"outcome and numbers of the closed form, to {ROUNDINGS} roundings over that distance"
        strikes = [
            (_rod(a), math.tan(a) * (1.0 + side), RESTITUTION) for a in ROD_ANGLES for side in (-distance, distance)
        ]
        limit = ROUNDINGS * EPSILON * (1.0 + 1.0 / distance) / math.sin(2.0 * ROD_ANGLES[0])
        yield case(f"rod pulled, {place}", promise, agrees_with_closed_form, strikes, limit)
        promise = f"rebound; phases, impulse and rates of the closed form to {TWO_RODS_LIMIT:.0e}"
        for which, edge in critical.items():
            near = [(TWO_RODS, edge * (1.0 + side * distance), RESTITUTION) for side in (-1.0, 1.0)]
            name = f"two rods, {distance:g} off the friction that {which}"
            yield case(name, promise, agrees_with_closed_form, near, TWO_RODS_LIMIT)
    for tool, name, start in ((TOOL, "default pass", {}), (LEANING, "pass, tip pushed", THROWN)):
        promise = "strike and end as in the reference to 1e-7; jams, by name, above it if the tip is pushed"
        for side in (-1e-3, 1e-3):
            where = f"{name}, friction {abs(side):g} {'below' if side < 0 else 'above'} the jam"
            yield row("jam", where, promise, _passes_near_jam, tool, start, side)


ROD_ANGLES = tuple(map(math.radians, (1.0, 23.4, 60.0, 89.0)))
"""Angles of the rod to the normal, rad."""


def _rod(angle: float) -> Chain:
    return Chain((TOOL.bristle.mass,), (LENGTH,), (-angle,), (RATE,))


def _passes_near_jam(tool: Tool, start: Start, side: float) -> Finding:
    """Nothing before the strike knows its friction, so that a first run finds its angle."""
    assert tool.workpart is not None
    first = impacts_of(simulate(tool, Settings(1e-10), stop_after="strike", **start), "workpart")[0]
    friction = math.tan(abs(first.angles[0])) * (1.0 + side)
    rough = replace(tool, workpart=replace(tool.workpart, friction=friction))
    return agrees_with_reference(rough, 1e-7, start=start, stop_after="strike")


NAMES = {"bar": ("bar touch", "bar not touched"), "workpart": ("strike", "workpart not reached")}

GAP = 1e-12
"""Ratio to the length to which a touch must lie on the obstacle: ten times the engine's own for a path that is exact."""


def grazing() -> Iterator[HardCase]:
    """Yield strikes at any angle, tips that just reach an obstacle or just miss it, and three contacts at one instant."""
    case = partial(row, "grazing")
    right = {f"a right angle less {10.0**-power:g} rad": math.pi / 2 - 10.0**-power for power in (3, 6, 9)}
    angles = {f"{angle:g} rad": angle for angle in (LEAST_ANGLE, 1e-30, 1e-9, 1e-6, 1e-4, 1e-3, 0.1)} | right
    for words, angle in angles.items():
        # None, half and twice the friction of the jam; half magnifies a rounding by (1 + 1/2)/(1 - 1/2).
        frictions = [mu for mu in (0.0, 0.5 * math.tan(angle), 2.0 * math.tan(angle)) if mu <= 1e9]
        limit = 3.0 * 16.0 * EPSILON
        promise = f"outcome of the monofilament's formulas, impulse and rate to {limit:.0e}"
        strikes = [(_rod(angle), mu, RESTITUTION) for mu in frictions]
        yield case(f"strike at {words}", promise, agrees_with_closed_form, strikes, limit)
    for depth in (sign * 10.0**-power for power in range(2, 13) for sign in (1.0, -1.0)):
        for what in NAMES:
            promise = f"touches, there to {GAP:g} of the length" if depth > 0.0 else "no touch"
            name = f"tip's circle {abs(depth):g} {'into' if depth > 0.0 else 'past'} the {what}"
            yield case(name, promise, _dips, what, depth, quick=abs(depth) in (1e-6, 1e-9, 1e-12))
    for e in (0.0, RESTITUTION, 1.0):
        name = f"three contacts at one instant: bar at a wire's joint, tip at the workpart; bar's restitution {e:g}"
        yield case(name, f"state 30 deg later as in the reference, to {ACCURACY:g}", _three_at_once, e)


def _dips(what: str, depth: float) -> Finding:
    """Move an obstacle until the tip's circle dips ``depth`` lengths into it; the gap there is known in closed form.

    A path that dips d into an obstacle enters it at an angle of the order of the square root of d, so the instant keeps
    half the digits and the gap keeps all of them.
    """
    tool = replace(TOOL, bar=None, workpart=Workpart(penetration=depth * LENGTH))
    if what == "bar":
        assert TOOL.bar is not None
        away = (TIP + TOOL.bar_reach - depth * LENGTH) / math.hypot(*TOOL.bar.centre)
        bar = replace(TOOL.bar, horizontal=TOOL.bar.horizontal * away, vertical=TOOL.bar.vertical * away)
        tool = replace(TOOL, bar=bar, workpart=None)
    run = simulate(tool, Settings(accuracy=1e-10))
    touch, absence = NAMES[what]
    at = run.event_time(touch)
    if at is None or depth < 0.0:
        missed = at is None and run.event_time(absence) is not None and depth < 0.0
        return Finding(absence if at is None else touch, missed and is_finite(run), run.cost.steps)
    angle = tool.hub.speed * at + START
    tip = (TIP * math.sin(angle), -TIP * math.cos(angle))
    gap = tool.workpart_depth + tip[1] if tool.bar is None else math.dist(tip, tool.bar.centre) - tool.bar_reach
    return all_of(within(gap / LENGTH, GAP, "gap", run.cost.steps), Finding(run.stop_reason, is_finite(run)))


LATER = 1e-13
"""Gap at the workpart when the bar is met, m: closed, but of a hundred roundings, which would decide on the first impact."""


def _three_at_once(restitution: float) -> Finding:
    """Have a radial wire of two links meet the bar with both, and the workpart with its tip."""
    from bristle_sim.reference import simulate_reference

    assert TOOL.bar is not None
    assert TOOL.workpart is not None
    cos = TOOL.workpart_depth / TIP
    sin, joint, reach = math.sqrt(1.0 - cos**2), ROOT + 0.5 * LENGTH, TOOL.bar_reach
    bar = replace(
        TOOL.bar,
        horizontal=joint * sin - reach * cos,
        vertical=joint * cos + reach * sin,
        restitution=restitution,
    )
    part = replace(TOOL.workpart, penetration=TOOL.workpart.penetration - LATER)
    tool, turn = (
        replace(TOOL, bristle=replace(TOOL.bristle, links=2), bar=bar, workpart=part),
        0.5 * math.pi - math.acos(cos),
    )
    run = simulate(tool, Settings(ACCURACY, hub_turn=turn + math.radians(30.0)))
    other = simulate_reference(tool, accuracy=MORE_ACCURATE * ACCURACY, hub_turn=turn + math.radians(30.0))
    return within(worst(end_difference(run, other)), ACCURACY, "off by", run.cost.steps)
