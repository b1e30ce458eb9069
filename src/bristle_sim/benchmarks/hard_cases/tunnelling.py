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

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, refusal, within
from bristle_sim.benchmarks.hard_cases.measures import Start, impacts_of
from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.obstacles import LEAST_REACH
from bristle_sim.scene.tool import START, simulate, tool_units
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason

__all__ = ["THINNEST", "TIP", "first_bar_touch", "first_strike", "tunnelling", "with_bar_at"]

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length
TIP = ROOT + LENGTH
"""Radius of the circle of a radial bristle's tip, m."""

THINNEST = 1.001 * LEAST_REACH * LENGTH
"""Radius of the thinnest bar that an infinitely thin wire may meet, m."""


def tunnelling() -> list[HardCase]:
    """Return every accuracy and step with every speed, thrown and swinging bristles, and bars too thin to have a side."""
    rows = []
    for accuracy in (0.1, 1e-3, 1e-6, 1e-9, 1e-11):
        name = f"accuracy {accuracy:g}, hub 1 to 1e5 rad/s, bars from {THINNEST:.1g} m and the workpart"
        promise = f"all met, their instants right to {accuracy:g} of them, the requested accuracy"
        rows.append(HardCase("tunnelling", name, promise, partial(_meets_at_accuracy, accuracy)))
        for draws in (4, 40) if accuracy >= 1e-9 else ():
            promise = f"the first touch is the reference's, in place to {accuracy:g} of the tip's circle"
            measure = partial(_swinging_bristles_meet, accuracy, draws)
            name = f"accuracy {accuracy:g}, {draws} swinging bristles at random"
            rows.append(HardCase("tunnelling", name, promise, measure, draws == 4))
    for part in (1e-12, 1e-6, 1e-3, 0.1, 0.5, 1.0):
        name = f"steps of {part:g} of the longest or 1e-12 s, bars from {THINNEST:.1g} m"
        measure, quick = partial(_meets_at_step, part), part in (1e-12, 0.1, 1.0)
        rows.append(HardCase("tunnelling", name, "all met, their instants right to a step", measure, quick))
    for rate, accuracy in ((1e3, 0.1), (1e6, 0.1), (1e9, 0.1), (1e3, 1e-6), (1e9, 1e-6)):
        name = f"accuracy {accuracy:g}, bristle thrown at {rate:g} rad/s, hub at rest, no belt"
        promise = f"bars met, their instants right to {accuracy:g}, or says that {StopReason.ACCURACY}"
        rows.append(HardCase("tunnelling", name, promise, partial(_meets_when_thrown, rate, accuracy)))
    words = ("bar_radius + wire_diameter / 2", f"{LEAST_REACH:g}")
    for radius in (0.9 * LEAST_REACH * LENGTH, 5e-324):
        thin = partial(refusal, partial(simulate, with_bar_at(0.9 * TIP, radius)), *words)
        rows.append(HardCase("tunnelling", f"bar of {radius:.2g} m, wire of no width", "refused in one line", thin))
    return rows


def with_bar_at(distance: float, radius: float, speed: float = TOOL.hub.speed, angle: float = 1.2) -> Tool:
    """Return a tool with a bar at a distance (m), ``angle`` before the workpart's direction, and a wire of no width."""
    bar = Bar(radius=radius, horizontal=distance * math.sin(angle), vertical=distance * math.cos(angle))
    return replace(TOOL, hub=Hub(speed=speed), bar=bar, bristle=replace(TOOL.bristle, wire_diameter=0.0))


def first_bar_touch(tool: Tool, start: float = START) -> float:
    """Return when a radial bristle meets the bar, s: its end on the reach (law of cosines) or its flank (tangent)."""
    assert tool.bar is not None
    distance, reach = math.hypot(tool.bar.horizontal, tool.bar.vertical), tool.bar_reach
    if distance * distance - reach * reach > TIP * TIP:
        between = math.acos((distance**2 + TIP**2 - reach**2) / (2.0 * distance * TIP))
    else:
        between = math.asin(reach / distance)
    return (-start - math.atan2(tool.bar.horizontal, tool.bar.vertical) - between) / tool.hub.speed


def first_strike(tool: Tool) -> float:
    """Return when a radial tip comes down on the workpart, s."""
    return (-START - math.acos(tool.workpart_depth / TIP)) / tool.hub.speed


def _meets(
    tool: Tool, settings: Settings, event: str, expected: float, unit: float, start: Start | None = None
) -> Finding:
    """Return whether an event happens at its instant to a unit."""
    run = simulate(tool, settings, stop_after=event, **(start or {}))
    at = run.event_time(event)
    return within(
        math.inf if at is None else (at - expected) / unit, 1.0, "instant off by, of the limit,", run.cost.steps
    )


def _all_met(met: list[Finding]) -> Finding:
    missed = [each.reached for each in met if not each.ok]
    told = f"{len(met) - len(missed)} of {len(met)} met" + (f"; {missed[0]}" if missed else "")
    return Finding(told, not missed, sum(each.steps for each in met))


def _meets_at_accuracy(accuracy: float) -> Finding:
    settings, met = Settings(accuracy=accuracy, samples_per_period=1), []
    for speed in (1.0, 261.8, 1e5):
        for radius in (THINNEST, 1e-6, 1e-3):
            tool = with_bar_at(0.9 * TIP, radius, speed)
            expected = first_bar_touch(tool)
            met.append(_meets(tool, settings, "bar touch", expected, accuracy * expected))
        bare = replace(TOOL, hub=Hub(speed=speed), bar=None)
        met.append(_meets(bare, settings, "strike", first_strike(bare), accuracy * first_strike(bare)))
    return _all_met(met)


def _meets_at_step(part: float) -> Finding:
    """Runs of tiny steps begin a hundred steps before the touch."""
    met = []
    for speed in (1.0, 261.8, 1e5):
        for radius in (THINNEST, 1e-3):
            for distance in (0.6, 0.97):
                tool = with_bar_at(distance * TIP, radius, speed)
                step = max(1e-12, part * tool_units(tool).time)
                angle = START + max(0.0, first_bar_touch(tool) - 100.0 * step) * speed
                settings = Settings(step=step, samples_per_period=1)
                expected = first_bar_touch(tool, angle)
                met.append(_meets(tool, settings, "bar touch", expected, step, {"start_hub_angle": angle}))
    return _all_met(met)


def _meets_when_thrown(rate: float, accuracy: float) -> Finding:
    """The root is a hub's radius beside the centre; the bar stands 0.9 rad behind the bristle, at 0.8 of its length."""
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
        met.append(_meets(tool, settings, "bar touch", expected, accuracy * expected, start))
    return _all_met(met)


def _swinging_bristles_meet(accuracy: float, draws: int) -> Finding:
    drawn = random.Random(f"swinging {accuracy:g}")
    return _all_met([_swinging_bristle_meets(drawn, accuracy) for _ in range(draws)])


def _swinging_bristle_meets(drawn: random.Random, accuracy: float) -> Finding:
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
