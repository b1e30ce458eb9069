"""Impacts that hardly are any: along the surface, square to it, without speed, and tips that just touch or just miss."""

from __future__ import annotations

import math
from dataclasses import replace

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, row, within, worst
from bristle_sim.benchmarks.hard_cases.measures import Start, agrees_in_time, is_finite, struck
from bristle_sim.parameters import Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.contact.compliant import LEAST_DURATION
from bristle_sim.scene.strike import Chain
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length
TIP = ROOT + LENGTH
"""Radius of the circle of a radial bristle's tip, m."""

RATE, RESTITUTION = 845.0, 0.42

ROUNDING = 16 * 2.0**-52
"""Sixteen roundings of sine, cosine, their products and K."""

ACCURACY = 1e-10


def grazing() -> list[HardCase]:
    """Return strikes at any angle, slow approaches, and swings that just reach the workpart or just miss it."""
    rows = []
    for angle in (1e-9, 1e-6, 1e-4, 1e-3, 0.1, *(math.pi / 2 - 10.0**-power for power in (3, 6, 9))):
        promise = "the rigid-body limit to twice what the rod turns meanwhile; where that is no digit, or refused"
        rows.append(row("grazing", f"strike in time at {angle:.12g} rad", promise, _strikes_in_time, angle))
    for part in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15):
        promise = f"impulse and rebound of one degree of freedom to {ROUNDING:.0e}"
        rows.append(row("grazing", f"approach {part:g} of the tip's speed", promise, _approaches, part))
    for part in (0.0, 1e-15, 1e-3):
        promise = "no contact by each law, not a bit of the rate changed"
        rows.append(row("grazing", f"tip parts with {part:g} of its speed", promise, _parts, part))
    for depth in (sign * size for size in (1e-6, 1e-9) for sign in (1.0, -1.0)):
        promise = "touches as the reference does, where the tip comes to rest" if depth > 0.0 else "no touch"
        name = f"swing that ends {abs(depth):g} {'into' if depth > 0.0 else 'past'} the workpart"
        rows.append(row("grazing", name, promise, _swings, depth))
    return rows


def _rod(angle: float) -> Chain:
    return Chain((TOOL.bristle.mass,), (LENGTH,), (-angle,), (RATE,))


def _frictions(angle: float) -> list[float]:
    """Return no friction, half and twice that of the jam; only what a surface may have."""
    return [mu for mu in (0.0, 0.5 * math.tan(angle), 2.0 * math.tan(angle)) if mu <= 1e9]


def _strikes_in_time(angle: float) -> Finding:
    """The rod turns while it is in touch, which half the friction of the jam magnifies twice."""
    limit = 2.0 * LEAST_DURATION / math.sqrt(RESTITUTION) / (math.sin(angle) * math.cos(angle))
    return all_of(*(agrees_in_time(_rod(angle), mu, RESTITUTION, limit) for mu in _frictions(angle)))


TILT = math.radians(30.0)


def _sliding(part: float) -> Chain:
    """Return a rod 30 degrees behind its root that slides along the surface, its tip approaching with a part of its speed."""
    # Root and rod together: (v_n, v_t) = u (sin(hub), cos(hub)) + L w (-sin 30, cos 30), and w follows from v_n.
    rate = part * ROOT / LENGTH * TOOL.hub.speed / math.sin(TILT)
    return Chain((TOOL.bristle.mass,), (LENGTH,), (-TILT,), (rate,), ROOT, TOOL.hub.speed, 0.0)


def _approaches(part: float) -> Finding:
    """Compare with lasting slip: v_n = -u leaves with e* u after p = u (1 + e*) m/(3 sin (sin + mu cos))."""
    chain, friction = _sliding(part), 0.3
    approach = LENGTH * chain.rates[0] * math.sin(TILT)
    lever = math.sin(TILT) + friction * math.cos(TILT)
    impulse = approach * (1.0 + RESTITUTION) * TOOL.bristle.mass / (3.0 * math.sin(TILT) * lever)
    hit = struck(chain, friction, RESTITUTION).contact
    off = worst([hit.impulse[0] / impulse - 1.0, hit.velocity_after[0] / (RESTITUTION * approach) - 1.0])
    return all_of(within(off, ROUNDING, "off by"), Finding(hit.outcome, hit.outcome == "rebound"))


def _parts(part: float) -> Finding:
    hits = [struck(_sliding(-part), 0.3, 0.4, law).contact for law in ("energetic", "compliant", "engine")]
    kept = all(hit.rates_after == hit.rates_before and hit.impulse == (0.0, 0.0) for hit in hits)
    return Finding(hits[0].outcome, kept and {hit.outcome for hit in hits} == {"no contact"})


def _swings(depth: float) -> Finding:
    """Let a bristle on a hub at rest swing as cos(w t) to where its tip just touches: no speed is left for an impact."""
    side, swing = math.radians(40.0), math.radians(25.0)
    lowest = ROOT * math.cos(side) + LENGTH * math.cos(side - swing)
    tool = replace(TOOL, hub=Hub(speed=0.0), bar=None, workpart=Workpart(penetration=TIP - lowest + depth * LENGTH))
    start: Start = {"start_hub_angle": -side, "start_relative_angle": -swing}
    run, exact = simulate(tool, Settings(accuracy=ACCURACY), **start), simulate_reference(tool, accuracy=1e-12, **start)
    one, other = run.event_time("strike"), exact.event_time("strike")
    if one is None or other is None:
        return Finding("touch" if one else "no touch", one is other and depth < 0.0 and is_finite(run), run.cost.steps)
    rate = math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)
    tip = -side - swing * math.cos(rate * one)
    gap = (tool.workpart_depth - ROOT * math.cos(side)) / LENGTH - math.cos(tip)
    return all_of(Finding("touch", depth > 0.0), within(gap, 10.0 * ACCURACY, "gap", run.cost.steps))
