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
    obeys_law,
    struck,
)
from bristle_sim.parameters import Belt, Hub, Tool, Workpart
from bristle_sim.scene.strike import Chain
from bristle_sim.scene.tool import START, simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.impulse_course import contact_inverse_mass

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

MOTIONS = {"slip": ((1.0, 0.2), 0.2), "reverse slip": ((0.1, 0.2), 0.3), "stick": ((-1.0, 1.1), 5.0)}
"""Rates and friction with which the tip slips, reverses or sticks; the second and third as soon as slip has stopped."""


def mass_ratio() -> Iterator[HardCase]:
    """Yield a double pendulum's impacts, its first rod 1e-9 to 1e12 times as heavy as its second, and strikes of wires."""
    case = partial(row, "mass_ratio")
    for ratio, motion in ((1e-9, "slip"), (1e-3, "reverse slip"), (1e12, "stick")):
        rates, friction = MOTIONS[motion]
        strikes = [(Chain((ratio, 1.0), (1.0, 1.0), ANGLES, rates), friction, e) for e in (0.0, 0.5, 1.0)]
        promise = f"phases of the closed form, its rates and impulse to {ROUNDING:g}, e* of 0, 0.5 and 1"
        yield case(f"n = {ratio:g}, {motion}", promise, agrees_with_closed_form, strikes, ROUNDING)
    for ratio, motion in ((0.1, "slip"), (1e3, "reverse slip")):
        rates, friction = MOTIONS[motion]
        chain, limit = Chain((ratio, 1.0), (1.0, 1.0), ANGLES, rates), 10 * STRIKE_ACCURACY
        promise = f"the rigid-body limit's rates to {limit:g}"
        yield case(f"n = {ratio:g}, {motion}, in time", promise, agrees_in_time, chain, friction, 0.5, limit)
    light = partial(struck, Chain((1e-9, 1.0), (1.0, 1.0), ANGLES, (1.0, 0.2)), 0.2, 0.5, "compliant")
    yield case("n = 1e-09, in time", "refused in one line", refusal, light, "contact = compliant", "1e-3")
    law = "restitution returns e*^2 of the work of compression, no energy gained, to 1e-9"
    yield case("strike of rods of lengths 1, 1e-3, 1, 1e-3", law, _unequal, (1.0, 1e-3, 1.0, 1e-3))


def _unequal(lengths: tuple[float, ...]) -> Finding:
    """Strike with rods of masses in proportion to their lengths."""
    hit = struck(Chain(lengths, lengths, (-0.4, -0.7, -0.2, -0.5), (1.0, 0.5, 2.0, 1.0)), 0.3, 0.5)
    rebounds = Finding(hit.contact.outcome, hit.contact.outcome == "rebound", hit.steps)
    return all_of(obeys_law(hit.contact, 0.5, 1e-9), rebounds)


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

ROD_ANGLES = tuple(map(math.radians, (1.0, 23.4, 60.0, 89.0)))
"""Angles of the rod to the normal, rad."""


def jam() -> Iterator[HardCase]:
    """Yield a rod that is pulled or pushed, two rods, and passes, with friction on both sides of an edge.

    At mu = tan gamma a rod that is pulled over the surface can no longer leave it (stiction), and one that is pushed over
    it can no longer be stopped (jam). At each critical friction of two rods one motion gives way to another.
    """
    case = partial(row, "jam")
    for distance in (1e-3, 1e-9):
        place = f"friction {distance:g} off the jam"
        promise = f"outcome and numbers of the closed form, to {ROUNDINGS} roundings over that distance"
        sides = [(angle, math.tan(angle) * (1.0 + side)) for angle in ROD_ANGLES for side in (-distance, distance)]
        strikes = [(_rod(angle), friction, RESTITUTION) for angle, friction in sides]
        limit = ROUNDINGS * EPSILON * (1.0 + 1.0 / distance) / math.sin(2.0 * ROD_ANGLES[0])
        yield case(f"rod pulled, {place}", promise, agrees_with_closed_form, strikes, limit)
        yield case(f"rod pushed, {place}", promise, _pushed, distance, limit)
    (normal, coupling), (_, tangential) = contact_inverse_mass(TWO_RODS).tolist()
    promise = f"rebound; phases, impulse and rates of the closed form to {TWO_RODS_LIMIT:.0e}"
    for which, edge in (("sticks", abs(coupling) / tangential), ("presses on", normal / abs(coupling))):
        near = [(TWO_RODS, edge * (1.0 + side), RESTITUTION) for side in (-1e-6, 1e-6)]
        name = f"two rods, 1e-06 off the friction that {which}"
        yield case(name, promise, agrees_with_closed_form, near, TWO_RODS_LIMIT)
    for tool, name, start in ((TOOL, "default pass", {}), (LEANING, "pass, tip pushed", THROWN)):
        promise = "strike and end as in the reference to 1e-7; jams, by name, above it if the tip is pushed"
        yield case(f"{name}, friction 0.001 off the jam", promise, _passes_near_jam, tool, start, 1e-3)


def _rod(angle: float) -> Chain:
    return Chain((TOOL.bristle.mass,), (LENGTH,), (-angle,), (RATE,))


def _pushed(distance: float, limit: float) -> Finding:
    """Compare rods that a descending hub pushes ahead of its root with the closed form.

    With friction tan(gamma) (1 + d) slip lasts while it can: above the jam it stops at p = m v_t/(3 sin cos d), without a
    rebound; below, compression ends at p_c = -v_n m/(3 sin^2 (-d)), and restitution at (1 + e*) p_c.
    """
    off, words = [], set()
    for angle in ROD_ANGLES:
        for side in (-distance, distance):
            chain = Chain((TOOL.bristle.mass,), (LENGTH,), (angle,), (0.0,), LENGTH, RATE, -1.0)
            hit = struck(chain, math.tan(angle) * (1.0 + side), RESTITUTION).contact
            sine, cosine, (normal, along) = math.sin(angle), math.cos(angle), hit.velocity_before
            compressive, stop = normal / (3.0 * sine**2 * side), abs(along) / (3.0 * sine * cosine * side)
            exact = stop if side > 0.0 else (1.0 + RESTITUTION) * compressive
            off.append(hit.impulse[0] / (TOOL.bristle.mass * exact) - 1.0)
            words.add((side > 0.0, hit.outcome))
    named = Finding(", ".join(sorted(word for _, word in words)), words == {(False, "rebound"), (True, "jam")})
    return all_of(named, within(worst(off), limit, "off by"))


def _passes_near_jam(tool: Tool, start: Start, distance: float) -> Finding:
    """Nothing before the strike knows its friction, so that a first run finds its angle."""
    assert tool.workpart is not None
    first = impacts_of(simulate(tool, Settings(1e-10), stop_after="strike", **start), "workpart")[0]
    edge = math.tan(abs(first.angles[0]))
    rough = [replace(tool, workpart=replace(tool.workpart, friction=edge * (1.0 + d))) for d in (-distance, distance)]
    return all_of(*(agrees_with_reference(each, 1e-7, start=start, stop_after="strike") for each in rough))


NAMES = {"bar": ("bar touch", "bar not touched"), "workpart": ("strike", "workpart not reached")}

GAP = 1e-12
"""Ratio to the length to which a touch must lie on the obstacle: ten times the engine's own for a path that is exact."""


def grazing() -> Iterator[HardCase]:
    """Yield strikes at any angle, tips that just reach an obstacle or just miss it, and three contacts at one instant."""
    case = partial(row, "grazing")
    for words, angle in (("1e-09 rad", 1e-9), ("0.1 rad", 0.1), ("a right angle less 1e-09 rad", math.pi / 2 - 1e-9)):
        # None, half and twice the friction of the jam; half magnifies a rounding by (1 + 1/2)/(1 - 1/2).
        frictions = [mu for mu in (0.0, 0.5 * math.tan(angle), 2.0 * math.tan(angle)) if mu <= 1e9]
        limit = 3.0 * 16.0 * EPSILON
        promise = f"outcome of the monofilament's formulas, impulse and rate to {limit:.0e}"
        strikes = [(_rod(angle), mu, RESTITUTION) for mu in frictions]
        yield case(f"strike at {words}", promise, agrees_with_closed_form, strikes, limit)
    promise = f"impulse and rebound of one degree of freedom to {16 * EPSILON:.0e}"
    yield case("approach 1e-12 of the tip's speed", promise, _approaches, 1e-12)
    for what, depth in (("workpart", 1e-9), ("workpart", -1e-9), ("bar", 1e-12), ("bar", -1e-12)):
        promise = f"touches, there to {GAP:g} of the length" if depth > 0.0 else "no touch"
        name = f"tip's circle {abs(depth):g} {'into' if depth > 0.0 else 'past'} the {what}"
        yield case(name, promise, _dips, what, depth)
    promise = "touches where the tip comes to rest, to 1e-9 of the length, and as the reference does"
    yield case("swing that ends 1e-09 into the workpart", promise, _swings, 1e-9)
    for e in (0.0, RESTITUTION):
        name = f"three contacts at one instant: bar at a wire's joint, tip at the workpart; bar's restitution {e:g}"
        yield case(name, f"state 30 deg later as in the reference, to {ACCURACY:g}", _three_at_once, e)


TILT = math.radians(30.0)


def _approaches(part: float) -> Finding:
    """Compare a tip that slides along the surface with lasting slip.

    v_n = -u leaves with e* u after p = u (1 + e*) m/(3 sin (sin + mu cos)). Root and rod together give (v_n, v_t) =
    u (sin(hub), cos(hub)) + L w (-sin 30, cos 30), and the rate w follows from v_n.
    """
    rate, friction = part * ROOT / LENGTH * TOOL.hub.speed / math.sin(TILT), 0.3
    chain = Chain((TOOL.bristle.mass,), (LENGTH,), (-TILT,), (rate,), ROOT, TOOL.hub.speed, 0.0)
    approach, lever = LENGTH * rate * math.sin(TILT), math.sin(TILT) + friction * math.cos(TILT)
    impulse = approach * (1.0 + RESTITUTION) * TOOL.bristle.mass / (3.0 * math.sin(TILT) * lever)
    hit = struck(chain, friction, RESTITUTION).contact
    off = worst([hit.impulse[0] / impulse - 1.0, hit.velocity_after[0] / (RESTITUTION * approach) - 1.0])
    return all_of(within(off, 16 * EPSILON, "off by"), Finding(hit.outcome, hit.outcome == "rebound"))


def _swings(depth: float) -> Finding:
    """Let a bristle on a hub at rest swing as cos(w t) to where its tip just touches: no speed is left for an impact."""
    from bristle_sim.reference import simulate_reference

    side, swing = math.radians(40.0), math.radians(25.0)
    lowest = ROOT * math.cos(side) + LENGTH * math.cos(side - swing)
    tool = replace(TOOL, hub=Hub(speed=0.0), bar=None, workpart=Workpart(penetration=TIP - lowest + depth * LENGTH))
    start: Start = {"start_hub_angle": -side, "start_relative_angle": -swing}
    run = simulate(tool, Settings(accuracy=1e-10), **start)
    one, other = run.event_time("strike"), simulate_reference(tool, accuracy=1e-12, **start).event_time("strike")
    if one is None or other is None:
        return Finding("no touch", False, run.cost.steps)
    tip = -side - swing * math.cos(math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root) * one)
    gap = (tool.workpart_depth - ROOT * math.cos(side)) / LENGTH - math.cos(tip)
    return all_of(Finding("touch", is_finite(run)), within(gap, 1e-9, "gap", run.cost.steps))


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
