"""Impacts that hardly are any: along the surface, square to it, without speed, and tips that just touch or just miss.

A radial bristle that turns with its hub keeps its tip on the circle of radius R = r_h + L, on a hub at rest it swings as
cos(omega_n t): where it meets an obstacle set d further in than it reaches is known in closed form. A path that dips d
into an obstacle enters it at an angle of the order of the square root of d, so the instant keeps half the digits and the
gap keeps all: the promise is about the gap at that instant.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, refusal, within, worst
from bristle_sim.benchmarks.hard_cases.jam import EPSILON, ROUNDINGS, WHOLE
from bristle_sim.benchmarks.hard_cases.tip_paths import (
    LEAN,
    LENGTH,
    REACH,
    SIDE,
    SWING,
    TOOL,
    bar_at,
    gap_of_circle,
    lowest_place,
    swinging,
    workpart_at,
)
from bristle_sim.parameters import Contact, Surface, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.compliant import LEAST_DURATION
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.theory.monofilament import LEAST_ANGLE as SMALLEST
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.trajectory import Trajectory

__all__ = ["cases"]

THEME = "grazing"

MASS, RATE, RESTITUTION = TOOL.bristle.mass, 845.0, 0.42

TO_ROUNDING = ROUNDINGS * EPSILON

RIGHT = math.pi / 2.0

LEAST_ANGLE = 1e-30
"""Least impact angle that a scenario allows, degrees."""

MOST_FRICTION = 1e9
"""The largest allowed."""

ACCURACY = 1e-10

GAP = 1e-12
"""Share of the length to which a touch must lie on the obstacle: ten times the engine's own for a path that is exact."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Angles, approach, and tips at bar and workpart."""
    small = tuple(10.0**-power for power in range(1, 13)) if full else (1e-3, 1e-4, 1e-6, 1e-9)
    depths = tuple(10.0**-power for power in range(2, 13)) if full else (1e-6, 1e-9, 1e-12)
    return (
        *(_angle(f"{angle:g} rad", angle) for angle in small),
        _angle(f"{LEAST_ANGLE:g} deg, the least allowed", math.radians(LEAST_ANGLE)),
        _angle(f"{SMALLEST:g} rad, the least that the theory allows", SMALLEST),
        *(_angle(f"a right angle less {angle:g} rad", RIGHT - angle) for angle in small),
        _angle("a right angle", RIGHT),
        _no_angle(),
        *(_in_time(f"{angle:g} rad", angle) for angle in small),
        *(_in_time(f"a right angle less {angle:g} rad", RIGHT - angle) for angle in small),
        *(_slow(share) for share in dict.fromkeys((*small, 1e-12, 1e-15))),
        *(_at_rest(share) for share in (0.0, 1e-15, 1e-3)),
        *(_dips(what, sign * depth) for what in ("bar", "workpart") for depth in depths for sign in (1.0, -1.0)),
        *(_swings(depth * sign) for depth in depths if depth >= LEAST_SWING for sign in (1.0, -1.0)),
        *(_leans(depth * sign) for depth in depths if depth >= LEAST_SWING for sign in (1.0, -1.0)),
    )


def _angle(words: str, angle: float) -> HardCase:
    promise = f"monofilament's outcome; impulse, rate and energy finite and the same to {TO_ROUNDING:.0e}"
    return HardCase(THEME, f"strike at {words}", promise, partial(_strikes_at, angle))


def _strikes_at(angle: float) -> Finding:
    """With no friction, half and twice that of the jam, and more than any; on a hinge and on a hub."""
    edge = math.tan(angle)
    frictions = [mu for mu in (0.0, 0.5 * edge, 2.0 * edge, 0.3, 1e6) if mu <= MOST_FRICTION]
    found = [_beside(angle, mu, radius) for mu in frictions for radius in (0.0, TOOL.hub.radius)]
    return both(
        within(worst([off for off, _ in found]), TO_ROUNDING, "off by"),
        Finding("outcomes the same", True) if all(same for _, same in found) else Finding("outcomes differ", False),
    )


def _beside(angle: float, friction: float, radius: float) -> tuple[float, bool]:
    """Worst share by which the scene is off the closed form, over what nearness to the jam magnifies; same outcome?"""
    speed = TOOL.hub.speed
    theory = monofilament_impact(MASS, LENGTH, radius, speed, RATE / speed, angle, friction, RESTITUTION)
    chain = Chain((MASS,), (LENGTH,), (-angle,), (RATE,), radius, speed, -angle)
    hit = strike(chain, Surface(friction, None, RESTITUTION), Contact(), Settings())
    off = worst(
        [
            hit.contact.impulse[0] / theory.normal_final_impulse - 1.0,
            (hit.contact.rates_after[0] - theory.final_bristle_rate) / RATE,
        ]
    )
    sine, rubbing = math.sin(angle), friction * math.cos(angle)
    magnified = max(1.0, (sine + rubbing) / abs(sine - rubbing)) if theory.outcome_name == "rebound" else 1.0
    return off / magnified, hit.contact.outcome == theory.outcome_name


def _in_time(words: str, angle: float) -> HardCase:
    promise = (
        "monofilament's outcome, and its impulse and rate to twice the duration in radians over sin gamma cos gamma;"
        " where that is no digit, an end by name or a refusal in a line"
    )
    return HardCase(THEME, f"strike in time at {words}", promise, partial(_strikes_in_time, angle))


def _strikes_in_time(angle: float) -> Finding:
    """The rod turns while it is in touch, which half the friction of the jam magnifies twice."""
    limit = 2.0 * LEAST_DURATION / math.sqrt(RESTITUTION) / (math.sin(angle) * math.cos(angle))
    frictions = [mu for mu in (0.0, 0.5 * math.tan(angle), 2.0 * math.tan(angle)) if mu <= MOST_FRICTION]
    found = [_in_time_beside(angle, friction, limit) for friction in frictions]
    return Finding("; ".join(dict.fromkeys(each.reached for each in found)), all(each.ok for each in found))


def _in_time_beside(angle: float, friction: float, limit: float) -> Finding:
    theory = monofilament_impact(MASS, LENGTH, 0.0, RATE, 1.0, angle, friction, RESTITUTION)
    chain, surface = Chain((MASS,), (LENGTH,), (-angle,), (RATE,)), Surface(friction, None, RESTITUTION)
    try:
        hit = strike(chain, surface, Contact("compliant"), Settings()).contact
    except ValueError as error:
        return Finding(f"refused: {error}", limit > WHOLE and "\n" not in str(error))
    off = worst(
        [hit.impulse[0] / theory.normal_final_impulse - 1.0, (hit.rates_after[0] - theory.final_bristle_rate) / RATE]
    )
    if limit > WHOLE:
        return Finding(hit.outcome, hit.outcome in ("rebound", "no rebound", "stiction") and math.isfinite(off))
    return Finding(
        f"{hit.outcome}, off by {off:.1g} of {limit:.1g}", off <= limit and hit.outcome == theory.outcome_name
    )


def _no_angle() -> HardCase:
    promise = "theory refuses it, and what it cannot tell from it, in a line; the scene has no contact"
    return HardCase(THEME, "strike at 0", promise, _refused)


def _refused() -> Finding:
    hit = strike(Chain((MASS,), (LENGTH,), (0.0,), (RATE,)), Surface(), Contact(), Settings()).contact
    return both(
        *(
            refusal(partial(monofilament_impact, MASS, LENGTH, 0.0, RATE, 1.0, angle, 0.3, RESTITUTION), "impact_angle")
            for angle in (0.0, math.ulp(0.0))
        ),
        Finding(hit.outcome, hit.outcome == "no contact" and hit.impulse == (0.0, 0.0)),
    )


TILT = math.radians(30.0)


def _sliding(share: float) -> Chain:
    """A rod 30 degrees behind its root, which slides along the surface: the tip approaches with a share of its speed."""
    # Root and rod together: (v_n, v_t) = u (sin(hub), cos(hub)) + L w (-sin 30, cos 30), and w follows from v_n.
    speed = TOOL.hub.speed
    rate = share * TOOL.hub.radius / LENGTH * speed / math.sin(TILT)
    return Chain((MASS,), (LENGTH,), (-TILT,), (rate,), TOOL.hub.radius, speed, 0.0)


def _slow(share: float) -> HardCase:
    promise = f"one freedom's impulse and rebound to {TO_ROUNDING:.0e}, in time the same outcome"
    return HardCase(THEME, f"approach {share:g} of the tip's speed", promise, partial(_approaches, share))


SLIDING_FRICTION = 0.3


def _approaches(share: float) -> Finding:
    """Slip lasts: v_n = -u leaves with e* u after p = u (1 + e*) m/(3 sin (sin + mu cos))."""
    surface, found = Surface(SLIDING_FRICTION, None, RESTITUTION), []
    chain = _sliding(share)
    approach = LENGTH * chain.rates[0] * math.sin(TILT)
    lever = math.sin(TILT) + SLIDING_FRICTION * math.cos(TILT)
    impulse = approach * (1.0 + RESTITUTION) * MASS / (3.0 * math.sin(TILT) * lever)
    hit = strike(chain, surface, Contact(), Settings()).contact
    found = [hit.impulse[0] / impulse - 1.0, hit.velocity_after[0] / (RESTITUTION * approach) - 1.0]
    other = strike(chain, surface, Contact("compliant"), Settings()).contact
    named = hit.outcome == other.outcome == "rebound"
    return both(within(worst(found), TO_ROUNDING, "off by"), Finding(f"{hit.outcome}, {other.outcome}", named))


def _at_rest(share: float) -> HardCase:
    name = f"tip parting with {share:g} of its speed" if share else "tip sliding without approach"
    return HardCase(THEME, name, "no contact by each law, not a bit of the rate changed", partial(_parts, share))


def _parts(share: float) -> Finding:
    chain = _sliding(-share)
    hits = [strike(chain, Surface(), Contact(law), Settings()).contact for law in ("energetic", "compliant", "engine")]
    same = all(hit.rates_after == hit.rates_before and hit.impulse == (0.0, 0.0) for hit in hits)
    words = {hit.outcome for hit in hits}
    return Finding(
        f"{', '.join(sorted(words))}; rate {'kept' if same else 'changed'}", same and words == {"no contact"}
    )


MAKERS: dict[str, Callable[[float], Tool]] = {"bar": bar_at, "workpart": workpart_at}

NAMES = {"bar": ("bar touch", "bar not touched"), "workpart": ("strike", "workpart not reached")}


def _dips(what: str, depth: float) -> HardCase:
    way = "into" if depth > 0.0 else "past"
    promise = f"touches, there to {GAP:g} of the length; " if depth > 0.0 else "no touch; "
    return HardCase(
        THEME,
        f"tip's circle {abs(depth):g} {way} the {what}",
        f"{promise}the reference's touches",
        partial(_dip, what, depth),
    )


def _dip(what: str, depth: float) -> Finding:
    tool = MAKERS[what](depth)
    run, exact = simulate(tool, Settings(accuracy=ACCURACY)), simulate_reference(tool)
    gap = gap_of_circle(tool)
    return both(_touched(run, what, depth, lambda at: gap(at) / LENGTH, GAP), _agree(run, exact, what))


def _touched(run: Trajectory, what: str, depth: float, gap: Callable[[float], float], limit: float) -> Finding:
    """Touched or not as it must be, and where; the gap is a share of the length."""
    touch, absence = NAMES[what]
    times = [event.time for event in run.events if event.name == touch]
    missed = any(event.name == absence for event in run.events)
    if depth <= 0.0 or not times:
        told = Finding("touched" if times else absence, not times and missed and depth <= 0.0, run.cost.steps)
        return both(told, _finite(run))
    return both(within(gap(times[0]), limit, "touches, gap", run.cost.steps), _finite(run))


def _finite(run: Trajectory) -> Finding:
    fine = all(bool(np.isfinite(each).all()) for each in (run.angles, run.rates, run.tip, run.normal_force))
    return Finding(run.stop_reason, fine and run.stop_reason == "end of the planned time")


def _agree(run: Trajectory, exact: Trajectory, what: str, until: float = math.inf) -> Finding:
    """The same touches of the obstacle, or none, and the same word for the first."""
    one, other = (_of(each, what, until) for each in (run, exact))
    return Finding("touches as the reference's" if one == other else f"{one}, reference's {other}", one == other)


def _of(run: Trajectory, what: str, until: float) -> tuple[list[str], list[str]]:
    words = (*NAMES[what], f"{what} touch", "jam")
    hits = [each for each in run.contacts if each.obstacle == what and each.law != "hold"]
    early = [each.name for each in run.events if each.name in words and (each.time < until or "not" in each.name)]
    return early, [each.outcome for each in hits[:1]]


LEAST_SWING = 1e-9
"""Depth that a run of accuracy 1e-10 must see."""

SWUNG = 10.0 * ACCURACY


def _swings(depth: float) -> HardCase:
    way = "reaches" if depth > 0.0 else "stops short of"
    promise = f"touches, there to {SWUNG:g} of the length" if depth > 0.0 else "no touch"
    name = f"swing that {way} the workpart by {abs(depth):g}"
    return HardCase(THEME, name, f"{promise}; the reference's touches", partial(_swing, depth))


def _swing(depth: float) -> Finding:
    """The tip comes to rest where it just touches: no speed is left for an impact."""
    tool = swinging(depth)
    rate = math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)

    def gap(time: float) -> float:
        angle = -SIDE - SWING * math.cos(rate * time)
        return (tool.workpart_depth - TOOL.hub.radius * math.cos(SIDE)) / LENGTH - math.cos(angle)

    run = simulate(tool, Settings(accuracy=ACCURACY), start_hub_angle=-SIDE, start_relative_angle=-SWING)
    exact = simulate_reference(tool, accuracy=1e-12, start_hub_angle=-SIDE, start_relative_angle=-SWING)
    # Held there and let go, the bristle comes back to the very place one swing later: whether it touches, rounding tells.
    return both(_touched(run, "workpart", depth, gap, SWUNG), _agree(run, exact, "workpart", 1.25 * math.pi / rate))


def _leans(depth: float) -> HardCase:
    way = "into" if depth > 0.0 else "past"
    promise = (
        f"{'touches' if depth > 0.0 else 'no touch'}; the reference's touches, its depth at that instant to {SWUNG:g}"
    )
    return HardCase(THEME, f"swinging bristle's tip {abs(depth):g} {way} the workpart", promise, partial(_lean, depth))


def _lean(depth: float) -> Finding:
    """On the turning hub, free of the bar: where its tip is lowest only an independent solution tells."""
    tool = replace(TOOL, bar=None, workpart=Workpart(penetration=REACH - lowest_place() + depth * LENGTH))
    run = simulate(tool, Settings(accuracy=ACCURACY), start_relative_angle=LEAN)
    exact = simulate_reference(tool, accuracy=1e-12, start_relative_angle=LEAN)
    return both(_touched(run, "workpart", depth, partial(_deep, tool), SWUNG), _agree(run, exact, "workpart"))


def _deep(tool: Tool, time: float) -> float:
    """Gap that the reference's tip would have there if there were no workpart, as a share of the length."""
    free = simulate_reference(replace(tool, workpart=None), accuracy=1e-12, start_relative_angle=LEAN, duration=time)
    return (tool.workpart_depth + float(free.tip[-1, 1])) / LENGTH
