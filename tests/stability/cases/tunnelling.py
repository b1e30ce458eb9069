"""Any step, any speed: an obstacle in the way is met, however thin it is and however long the steps are.

A straight bristle without gravity remains radial until it touches something, so the instant of the first touch is plain
geometry: the radial line meets the bar's circle, or the tip's circle meets bar or workpart. A bristle that is thrown
about a root at rest without a belt keeps its rate. Where it swings on its belt, the reference knows the instant.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace
from functools import partial

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, row, within
from bristle_sim.benchmarks.hard_cases.measures import Start, impacts_of, meets
from bristle_sim.benchmarks.hard_cases.motion import THINNEST, TIP, all_met, with_bar_at
from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.tool import START, simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length


def tunnelling() -> list[HardCase]:
    """Return thrown and swinging bristles."""
    rows, case = [], partial(row, "tunnelling")
    for accuracy in (0.1, 1e-3, 1e-6, 1e-9):
        promise = f"the first touch is the reference's, in place to {accuracy:g} of the tip's circle"
        name = f"accuracy {accuracy:g}, 4 swinging bristles at random"
        rows.append(case(name, promise, _swinging_bristles_meet, accuracy, 4))
    for rate, accuracy in ((1e3, 0.1), (1e6, 0.1), (1e9, 0.1), (1e3, 1e-6), (1e9, 1e-6)):
        name = f"accuracy {accuracy:g}, bristle thrown at {rate:g} rad/s, hub at rest, no belt"
        promise = f"bars met, their instants right to {accuracy:g}, or says that {StopReason.ACCURACY}"
        rows.append(case(name, promise, _meets_when_thrown, rate, accuracy))
    return rows


def _meets_when_thrown(rate: float, accuracy: float) -> Finding:
    """Throw a bristle whose root is a hub's radius off the centre; the bar stands 0.9 rad behind the bristle, at 0.8 of its length."""
    behind, along, met = 0.9, 0.8 * LENGTH, []
    settings = Settings(accuracy=accuracy, samples_per_period=1, maximum_steps=50_000)
    start: Start = {"start_relative_rate": -rate}
    for radius in (THINNEST, 1e-3):
        x, y = ROOT - along * math.sin(START - behind), along * math.cos(START - behind)
        thrown = replace(with_bar_at(TIP, radius), hub=Hub(speed=0.0), belt=Belt(stiffness=0.0), workpart=None)
        tool = replace(thrown, bar=Bar(radius, horizontal=x, vertical=y))
        if simulate(tool, settings, stop_after="bar touch", **start).stop_reason is StopReason.ACCURACY:
            return Finding(f"says that {StopReason.ACCURACY}", True)
        expected = (behind - math.asin(radius / along)) / rate
        met.append(meets(tool, settings, "bar touch", expected, accuracy * expected, start))
    return all_met(met)


def _swinging_bristles_meet(accuracy: float, draws: int) -> Finding:
    drawn = random.Random(f"swinging {accuracy:g}")
    return all_met([_swinging_bristlemeets(drawn, accuracy) for _ in range(draws)])


def _swinging_bristlemeets(drawn: random.Random, accuracy: float) -> Finding:
    """Draw hub, belt, damping, bar, workpart and the start of the swing; whatever is touched first counts."""
    speed = 10.0 ** drawn.uniform(0.0, 5.0)
    belt = Belt(TOOL.belt.stiffness * (speed / 261.8) ** 2 * drawn.choice((0.1, 1.0, 10.0)), drawn.choice((0.0, 0.1)))
    distance, radius = TIP * drawn.uniform(0.65, 0.98), 10.0 ** drawn.uniform(-6.0, -3.0)
    tool = with_bar_at(distance, radius, speed, drawn.uniform(0.6, 1.2))
    tool = replace(tool, belt=belt, workpart=Workpart(penetration=drawn.uniform(0.001, 0.02)))
    start: Start = {
        "start_hub_angle": drawn.uniform(-2.1, -1.8),
        "start_relative_angle": drawn.uniform(-0.5, 0.5),
        "start_relative_rate": drawn.uniform(-1.0, 1.0) * speed,
    }
    run = simulate(tool, Settings(accuracy=accuracy, samples_per_period=1, hub_turn=2.5), **start)
    # The reference need not go far past the touch that it is to confirm.
    duration = 1.01 * run.contacts[0].time if run.contacts else float(run.time[-1])
    exact = simulate_reference(tool, accuracy=1e-10, duration=duration, **start)
    if not run.contacts or not exact.contacts:
        return Finding("touch or none", not run.contacts and not exact.contacts, run.cost.steps)
    one, other = impacts_of(run)[0], impacts_of(exact)[0]
    off = (one.time - other.time) * other.velocity_before[0] / TIP
    return within(off if one.obstacle == other.obstacle else math.inf, accuracy, "place off by", run.cost.steps)
