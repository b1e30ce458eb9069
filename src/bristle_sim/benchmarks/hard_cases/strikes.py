"""Hard cases of strikes: extreme mass ratios, friction near the jam, grazing tips, and coefficients
at the ends of their ranges.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    Finding,
    HardCase,
    Start,
    agrees_with_reference,
    all_of,
    hard_case,
    impacts_of,
    within,
    worst,
)
from bristle_sim.parameters import Belt, Contact, Surface, Tool, Workpart
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_laws import contact_inverse_mass
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.pendulums import double_pendulum_impact

TOOL = Tool()
ROOT = TOOL.hub.radius
LENGTH = TOOL.bristle.length
TIP = ROOT + LENGTH

EPSILON = 2.0**-52

RATE = 845.0
RESTITUTION = 0.42
"""Angular velocity (rad/s) and coefficient of restitution in the strike of a single rod.

They are close to those of the bristle."""

TWO_ROD_ROUNDING = 1e-12
"""Largest permitted relative error of angular velocities and impulses of two rods.

It is a rounding error of 1e-15, magnified 1/sin^2(10 deg) = 33 times by the small angle between the
rods, and 30 times by the phases of the impact."""

ANGLES = (math.radians(-20.0), math.radians(-30.0))
"""Angles of two rods from the surface's normal, rad."""

MOTIONS = {
    "slip": ((1.0, 0.2), 0.2),
    "reverse slip": ((0.1, 0.2), 0.3),
    "stick": ((-1.0, 1.1), 5.0),
}
"""Angular velocities of two rods (rad/s) and coefficient of friction, by the motion of the tip.

In the impact the tip slips to the end (slip), or it stops and then slips back (reverse slip) or
sticks (stick)."""


def mass_ratio() -> Iterator[HardCase]:
    """Yield impacts of two rods whose ratio of masses is 1e-9, 1e-3 or 1e12."""
    promise = (
        f"phases, rates and impulse of the closed form, to {TWO_ROD_ROUNDING:g}; e* = 0, 0.5 and 1"
    )
    for ratio, motion in ((1e-9, "slip"), (1e-3, "reverse slip"), (1e12, "stick")):
        rates, friction = MOTIONS[motion]
        rods = Chain((ratio, 1.0), (1.0, 1.0), ANGLES, rates)
        strikes = [(rods, friction, e) for e in (0.0, 0.5, 1.0)]
        name = f"n = {ratio:g}, {motion}"
        yield hard_case(name, promise, _agrees_with_closed_form, strikes, TWO_ROD_ROUNDING)


def _agrees_with_closed_form(strikes: list[tuple[Chain, float, float]], limit: float) -> Finding:
    """Check simulated strikes of one or two rods against the closed forms (Zhang 2020, ch. 2).

    Args:
        strikes: for each strike, the rods, the coefficient of friction and that of restitution.
        limit: largest permitted relative difference.
    """
    off = []
    alike = True
    for chain, friction, e in strikes:
        contact = strike(chain, Surface(friction, None, e), Contact(), Settings()).contact
        rates, impulse, outcome = _closed_form(chain, friction, e)
        alike &= contact.outcome == outcome
        off += [
            worst(np.subtract(contact.rates_after, rates)) / worst((*chain.rates, *rates)),
            contact.impulse[0] / impulse - 1.0,
        ]
    return all_of(
        within(worst(off), limit, "off by"),
        Finding(f"outcomes {'equal' if alike else 'different'}", alike),
    )


def _closed_form(
    chain: Chain, friction: float, restitution: float
) -> tuple[tuple[float, ...], float, str]:
    """Return the closed-form result of a strike of one or two rods.

    Returns:
        Angular velocities after the impact (rad/s), normal impulse (N s) and name of the outcome.
    """
    mass = chain.masses[-1]
    length = chain.lengths[0]
    if len(chain.masses) == 1:
        radial = (0.0, chain.rates[0], 1.0, -chain.angles[0])
        one = monofilament_impact(mass, length, *radial, friction, restitution)
        return (float(one.final_bristle_rate),), float(one.normal_final_impulse), one.outcome_name
    angle_1, angle_2, rate_1, rate_2 = (-each for each in (*chain.angles, *chain.rates))
    motion = (angle_1, angle_2, rate_1, rate_2)
    ratio = chain.masses[0] / mass
    two = double_pendulum_impact(mass, ratio, length, *motion, friction, restitution)
    return (
        (-float(two.final_rate_1), -float(two.final_rate_2)),
        float(two.normal_final_impulse),
        two.outcome,
    )


ROUNDINGS = 40
"""Largest permitted relative error of an impulse, in units of machine epsilon.

It counts the rounding errors of the friction coefficient, of sine, cosine and their products, and
of the inverse mass matrix at the contact, in the scene and in the closed form. Near the jam it is
divided by the relative distance of the friction coefficient from the jam."""

TWO_RODS = Chain((5.0, 5.0), (1.0, 1.0), (math.radians(20.0), math.radians(-30.0)), (-0.8, 0.4))
"""Two rods whose slip drives the tip into the surface.

The slip stops before restitution ends, so that rounding errors are little magnified."""

TWO_RODS_LIMIT = TWO_ROD_ROUNDING + 0.5 * ROUNDINGS * EPSILON * float(
    np.linalg.cond(contact_inverse_mass(TWO_RODS))
)
"""Largest permitted relative error of an impact of two rods near a critical friction.

It is the fraction of a speed that the closed form treats as 0, plus rounding error times the
condition number of the inverse mass matrix at the contact."""

LEANING = Tool(belt=Belt(stiffness=0.0), bar=None, workpart=Workpart(penetration=0.0095))
"""Tool of a bristle that leans forward when it strikes, so that its tip is pushed over the
workpart."""

THROWN: Start = {"start_hub_angle": -0.7, "start_relative_angle": 1.2}
"""State at the start of the bristle of ``LEANING``: it is ahead of the radial direction."""

ROD_ANGLES = tuple(map(math.radians, (1.0, 23.4, 60.0, 89.0)))
"""Angles between the rod and the workpart's normal, rad."""


def jam() -> Iterator[HardCase]:
    """Yield strikes and passes with friction just below and just above a critical value.

    The critical coefficient of friction of one rod is tan(gamma), where gamma is the angle between
    the rod and the normal. With at least this friction, a rod that is pulled over the surface does
    not leave it (stiction), and a rod that is pushed is not stopped by the normal impulse (jam).

    Two rods have two critical coefficients. Above the first, the tip sticks once its slip has
    stopped. Above the second, the slip drives the tip into the surface.
    """
    for distance in (1e-3, 1e-9):
        strikes = [
            (_rod(angle), math.tan(angle) * (1.0 + side), RESTITUTION)
            for angle in ROD_ANGLES
            for side in (-distance, distance)
        ]
        limit = ROUNDINGS * EPSILON * (1.0 + 1.0 / distance) / math.sin(2.0 * ROD_ANGLES[0])
        name = f"rod pulled, friction {distance:g} off the jam"
        promise = f"outcome and numbers of the closed form, to {ROUNDINGS} rounding errors divided by that distance"
        yield hard_case(name, promise, _agrees_with_closed_form, strikes, limit)
    (normal, coupling), (_, tangential) = contact_inverse_mass(TWO_RODS).tolist()
    edges = {"sticks": abs(coupling) / tangential, "presses on": normal / abs(coupling)}
    for motion, edge in edges.items():
        strikes = [(TWO_RODS, edge * (1.0 + side), RESTITUTION) for side in (-1e-6, 1e-6)]
        name = f"two rods, 1e-06 off the friction that {motion}"
        promise = f"rebound; phases, impulse and rates of the closed form to {TWO_RODS_LIMIT:.0e}"
        yield hard_case(name, promise, _agrees_with_closed_form, strikes, TWO_RODS_LIMIT)
    promise = "strike and last state as in the reference, to 1e-7; above it a pushed tip jams"
    for name, tool, start in (("default pass", TOOL, {}), ("pass, tip pushed", LEANING, THROWN)):
        yield hard_case(
            f"{name}, friction 0.001 off the jam", promise, _passes_near_jam, tool, start
        )


def _rod(angle: float) -> Chain:
    return Chain((TOOL.bristle.mass,), (LENGTH,), (-angle,), (RATE,))


def _passes_near_jam(tool: Tool, start: Start) -> Finding:
    """Check two passes against the reference, one with friction just below the jam, one just above.

    A preliminary run gives the angle of the strike, which determines the friction at the jam.
    """
    first = impacts_of(simulate(tool, Settings(1e-10), stop_after="strike", **start), "workpart")[0]
    edge = math.tan(abs(first.angles[0]))
    rough = [tool.replace(friction=edge * (1.0 + side)) for side in (-1e-3, 1e-3)]
    return all_of(
        *(agrees_with_reference(each, 1e-7, start=start, stop_after="strike") for each in rough)
    )


TOUCH_GAP = 1e-12
"""Largest permitted gap at the time of a touch, as a fraction of the bristle's length.

It is ten times the tolerance to which the simulation locates a touch."""


def grazing() -> Iterator[HardCase]:
    """Yield strikes at extreme angles, tips that just reach or just miss an obstacle, and a triple
    contact.

    In the triple contact three points touch their obstacles at the same time.
    """
    limit = 3.0 * 16.0 * EPSILON
    promise = f"outcome of the monofilament's formulas, impulse and rate to {limit:.0e}"
    # ``parts`` are friction coefficients divided by that of the jam. At the part 1/2 rounding
    # errors are magnified by (1 + 1/2)/(1 - 1/2).
    for name, angle, parts in (
        ("strike at 1e-12 rad", 1e-12, (0.0, 0.5, 2.0)),
        ("strike at a right angle less 1e-09 rad", math.pi / 2 - 1e-9, (0.0, 0.5)),
    ):
        strikes = [(_rod(angle), part * math.tan(angle), RESTITUTION) for part in parts]
        yield hard_case(name, promise, _agrees_with_closed_form, strikes, limit)
    for obstacle, depth in (("workpart", 1e-9), ("bar", 1e-12)):
        name = f"tip's circle {depth:g} into the {obstacle}"
        promise = f"touches; the gap is then at most {TOUCH_GAP:g} of the bristle's length"
        yield hard_case(name, promise, _touches, obstacle, depth)
    yield hard_case("tip's circle 1e-12 past the bar", "no touch", _misses, 1e-12)
    name = "three contacts at one instant: bar at a wire's joint, tip at the workpart"
    promise = f"state 30 deg later as in the reference, to {ACCURACY:g}"
    yield hard_case(name, promise, _three_at_once)


def _dips(obstacle: str, depth: float) -> Tool:
    """Return a tool with one obstacle, which the circle of the undeflected tip enters.

    ``depth`` is the depth of entry as a fraction of the bristle's length. If it is negative, the
    circle misses the obstacle.
    """
    if obstacle == "workpart":
        return TOOL.replace(bar=None, penetration=depth * LENGTH)
    assert TOOL.bar is not None
    away = (TIP + TOOL.bar_reach - depth * LENGTH) / math.hypot(*TOOL.bar.centre)
    bar = replace(
        TOOL.bar, horizontal=TOOL.bar.horizontal * away, vertical=TOOL.bar.vertical * away
    )
    return TOOL.replace(bar=bar, workpart=None)


def _touches(obstacle: str, depth: float) -> Finding:
    """Check that the gap is almost zero when the simulation reports the touch of a grazing tip.

    ``depth`` is the depth to which the tip's circle enters the obstacle, as a fraction of the
    bristle's length. The exact gap follows from the circular path. The time is not checked, because
    rounding error affects half of its digits: the path meets the obstacle at an angle of the order
    of sqrt(depth).
    """
    tool = _dips(obstacle, depth)
    run = simulate(tool, Settings(accuracy=1e-10))
    at = run.event_time("strike" if obstacle == "workpart" else "bar touch") or 0.0
    angle = tool.hub.speed * at + tool.start_hub_angle
    tip = (TIP * math.sin(angle), -TIP * math.cos(angle))
    gap = (
        tool.workpart_depth + tip[1]
        if tool.bar is None
        else math.dist(tip, tool.bar.centre) - tool.bar_reach
    )
    return within(gap / LENGTH, TOUCH_GAP, "gap", run.cost.steps)


def _misses(distance: float) -> Finding:
    """Check that a tip whose circle just misses the bar does not touch it.

    ``distance`` is the distance between circle and bar as a fraction of the bristle's length.
    """
    run = simulate(_dips("bar", -distance), Settings(accuracy=1e-10))
    missed = run.event_time("bar not touched") is not None and not run.contacts
    return Finding("bar not touched" if missed else "touched", missed, run.cost.steps)


LATER = 1e-13
"""Gap between tip and workpart when the wire meets the bar, m.

The simulation treats so small a gap as closed. The gap is larger than rounding error, which would
otherwise decide which impact comes first."""


def _three_at_once() -> Finding:
    """Check a pass with three simultaneous contacts against the reference.

    The two links of a radial wire both touch the bar at their joint while the tip strikes the
    workpart. The bar has restitution.
    """
    cos = TOOL.workpart_depth / TIP
    reach = TOOL.bar_reach
    sin = math.sqrt(1.0 - cos**2)
    joint = ROOT + 0.5 * LENGTH
    bar = {"bar_horizontal": joint * sin - reach * cos, "bar_vertical": joint * cos + reach * sin}
    depth = TIP - TOOL.workpart_depth - LATER
    tool = TOOL.replace(wire_links=2, penetration=depth, bar_restitution=RESTITUTION, **bar)
    return agrees_with_reference(tool, hub_turn=0.5 * math.pi - math.acos(cos) + math.radians(30.0))
