"""Any step, any speed: what stands in the way is met, however thin it is and however long the stretches are.

A straight bristle without gravity stays radial until it touches something, so the instant of the first touch is plain
geometry: the radial line meets the bar's circle, or the tip's circle meets bar or workpart. A bristle that is thrown
about a root at rest without a belt keeps its rate. Where it swings on its belt, the reference knows the instant.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, refusal, within, worst
from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.obstacles import LEAST_REACH
from bristle_sim.scene.tool import START, simulate, tool_units
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import Trajectory

__all__ = ["cases", "first_bar_touch", "first_strike", "with_bar_at"]

THEME = "tunnelling"

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length
TIP = ROOT + LENGTH
"""Radius of a radial bristle's tip, m."""

THINNEST = 1.001 * LEAST_REACH * LENGTH
"""Radius of the thinnest bar that an infinitely thin wire may meet, m."""

ACCURACIES = (0.1, 1e-3, 1e-6, 1e-9, 1e-11)

ONE_STEP = 1.0
"""Steps by which a fixed step may miss an instant."""

RUN_UP = 100.0
"""Steps before the touch at which a run of tiny steps begins."""

GIVES_UP = StopReason.ACCURACY


class Try(NamedTuple):
    """A touch that was found, by how much its instant is off, in the unit of its promise, and the engine steps."""

    found: bool
    error: float
    steps: int


def cases(full: bool) -> tuple[HardCase, ...]:
    """Every accuracy and step with every speed; thrown, grazing and swinging bristles; bars too thin to have a side."""
    shares = (1e-12, 1e-6, 1e-3, 0.01, 0.1, 0.25, 0.5, 1.0) if full else (1e-12, 1e-3, 0.1, 1.0)
    hairs = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9) if full else (1e-6, 1e-9)
    return (
        *(_extrapolated(accuracy, full) for accuracy in ACCURACIES),
        *(_stepped(share, full) for share in shares),
        *(_thrown(rate, 0.1) for rate in (1e3, 1e6, 1e9)),
        *(_thrown(rate, 1e-6) for rate in (1e3, 1e9)),
        *(_bar_grazed(hair) for hair in hairs),
        *(_workpart_grazed(hair) for hair in hairs),
        *(_swinging(accuracy, 40 if full else 4) for accuracy in ACCURACIES[:4]),
        *(_too_thin(radius) for radius in (0.9 * LEAST_REACH * LENGTH, 5e-324)),
    )


def with_bar_at(distance: float, radius: float, speed: float = TOOL.hub.speed, angle: float = 1.2) -> Tool:
    """A bar at a distance (m) from the hub's centre, ``angle`` before the workpart's direction, and a wire of no width."""
    bar = Bar(radius=radius, horizontal=distance * math.sin(angle), vertical=distance * math.cos(angle))
    return replace(TOOL, hub=Hub(speed=speed), bar=bar, bristle=replace(TOOL.bristle, wire_diameter=0.0))


def first_bar_touch(tool: Tool, start: float = START) -> float:
    """Time, s, at which a radial bristle meets the bar: its end on the reach (law of cosines) or its flank (tangent)."""
    assert tool.bar is not None
    distance, reach = math.hypot(tool.bar.horizontal, tool.bar.vertical), tool.bar_reach
    if distance * distance - reach * reach > TIP * TIP:
        between = math.acos((distance**2 + TIP**2 - reach**2) / (2.0 * distance * TIP))
    else:
        between = math.asin(reach / distance)
    return (-start - math.atan2(tool.bar.horizontal, tool.bar.vertical) - between) / tool.hub.speed


def first_strike(tool: Tool) -> float:
    """Time, s, at which a radial tip comes down on the workpart."""
    return (-START - math.acos(tool.workpart_depth / TIP)) / tool.hub.speed


def _all_met(tries: Iterable[Try], limit: float, what: str) -> Finding:
    found = list(tries)
    missed = sum(1 for each in found if not each.found)
    told = Finding(f"{len(found) - missed} of {len(found)} met", not missed, sum(each.steps for each in found))
    return both(told, within(worst([each.error for each in found if each.found]), limit, what))


def _beside(run: Trajectory, event: str, expected: float, unit: float) -> Try:
    at = run.event_time(event)
    return Try(at is not None, 0.0 if at is None else (at - expected) / unit, run.cost.steps)


def _extrapolated(accuracy: float, full: bool) -> HardCase:
    speeds = (1.0, 261.8, 1e3, 1e5) if full else (1.0, 1e5)
    name = f"accuracy {accuracy:g}, hub 1 to 1e5 rad/s, bars from {THINNEST:.1g} m and the workpart"
    promise = f"all met, their instants right to {accuracy:g} of them, as asked"
    return HardCase(THEME, name, promise, partial(_at_accuracy, accuracy, speeds))


def _at_accuracy(accuracy: float, speeds: tuple[float, ...]) -> Finding:
    settings = Settings(accuracy=accuracy, samples_per_period=1)
    tries = []
    for speed in speeds:
        for radius in (THINNEST, 1e-6, 1e-3):
            tool = with_bar_at(0.9 * TIP, radius, speed)
            expected = first_bar_touch(tool)
            tries.append(_beside(simulate(tool, settings, stop_after="bar touch"), "bar touch", expected, expected))
        bare = replace(TOOL, hub=Hub(speed=speed), bar=None)
        expected = first_strike(bare)
        tries.append(_beside(simulate(bare, settings, stop_after="strike"), "strike", expected, expected))
    return _all_met(tries, accuracy, "instant off by")


def _stepped(share: float, full: bool) -> HardCase:
    step = "1e-12 s" if share == 1e-12 else f"{share:g} of the longest"
    promise = f"all met, their instants right to {ONE_STEP:g} step"
    radii = (THINNEST, 1e-6, 1e-3) if full else (THINNEST, 1e-3)
    return HardCase(THEME, f"step {step}, bars from {THINNEST:.1g} m", promise, partial(_at_step, share, radii))


def _at_step(share: float, radii: tuple[float, ...]) -> Finding:
    tries = []
    for speed in (1.0, 261.8, 1e5):
        for radius in radii:
            for distance in (0.6, 0.97):
                tool = with_bar_at(distance * TIP, radius, speed)
                step = max(1e-12, share * tool_units(tool).time)
                start = START + max(0.0, first_bar_touch(tool) - RUN_UP * step) * speed
                run = simulate(
                    tool,
                    Settings(step=step, samples_per_period=1),
                    start_hub_angle=start,
                    stop_after="bar touch",
                )
                tries.append(_beside(run, "bar touch", first_bar_touch(tool, start), step))
    return _all_met(tries, ONE_STEP, "instant off by, in steps,")


def _thrown(rate: float, accuracy: float) -> HardCase:
    name = f"accuracy {accuracy:g}, bristle thrown at {rate:g} rad/s, hub at rest, no belt, wire of no width"
    promise = f"bars met, their instants right to {accuracy:g}, or says that {GIVES_UP}"
    return HardCase(THEME, name, promise, partial(_throw, rate, accuracy))


def _throw(rate: float, accuracy: float) -> Finding:
    """The root is a hub's radius beside the centre; the bar stands 0.9 rad behind the bristle, at 0.8 of its length."""
    behind, along = 0.9, 0.8 * LENGTH
    direction = START - behind
    settings = Settings(accuracy=accuracy, samples_per_period=1, maximum_steps=50_000)
    tries = []
    for radius in (THINNEST, 1e-3):
        bar = Bar(radius, horizontal=ROOT - along * math.sin(direction), vertical=along * math.cos(direction))
        tool = replace(with_bar_at(TIP, radius), hub=Hub(speed=0.0), belt=Belt(stiffness=0.0), bar=bar, workpart=None)
        run = simulate(tool, settings, start_hub_angle=START, start_relative_rate=-rate, stop_after="bar touch")
        if run.stop_reason == GIVES_UP:
            return Finding(f"says that {GIVES_UP}", not run.contacts, run.cost.steps)
        expected = (behind - math.asin(radius / along)) / rate
        tries.append(_beside(run, "bar touch", expected, expected))
    return _all_met(tries, accuracy, "instant off by")


def _bar_grazed(hair: float) -> HardCase:
    promise = f"met where it overlaps, instant right to {ACCURACIES[0]:g}; not met where it is off"
    return HardCase(THEME, f"accuracy 0.1, tip grazes a bar by {hair:g} m", promise, partial(_graze_bar, hair))


def _graze_bar(hair: float) -> Finding:
    settings, radius = Settings(accuracy=ACCURACIES[0], samples_per_period=1), 1e-3
    grazed, clear = (replace(with_bar_at(TIP + radius + gap, radius), workpart=None) for gap in (-hair, hair))
    expected = first_bar_touch(grazed)
    touch = _beside(simulate(grazed, settings, stop_after="bar touch"), "bar touch", expected, expected)
    return both(_all_met([touch], ACCURACIES[0], "instant off by"), _passes(clear, settings, "bar not touched"))


def _workpart_grazed(hair: float) -> HardCase:
    promise = f"struck where it overlaps, instant right to {ACCURACIES[0]:g}; not struck where it is off"
    return HardCase(
        THEME, f"accuracy 0.1, tip grazes the workpart by {hair:g} m", promise, partial(_graze_workpart, hair)
    )


def _graze_workpart(hair: float) -> Finding:
    settings = Settings(accuracy=ACCURACIES[0], samples_per_period=1)
    grazed, clear = (replace(TOOL, bar=None, workpart=Workpart(penetration=depth)) for depth in (hair, -hair))
    expected = first_strike(grazed)
    touch = _beside(simulate(grazed, settings, stop_after="strike"), "strike", expected, expected)
    return both(_all_met([touch], ACCURACIES[0], "instant off by"), _passes(clear, settings, "workpart not reached"))


def _passes(tool: Tool, settings: Settings, absence: str) -> Finding:
    run = simulate(tool, settings)
    names = [event.name for event in run.events]
    return Finding(f"beside it: {', '.join(names)}", names == [absence] and not run.contacts, run.cost.steps)


def _swinging(accuracy: float, draws: int) -> HardCase:
    name = f"accuracy {accuracy:g}, {draws} swinging bristles at random"
    promise = f"the first touch is the reference's, in place to {accuracy:g} of the tip circle, as asked"
    return HardCase(THEME, name, promise, partial(_swing, accuracy, draws))


def _swing(accuracy: float, draws: int) -> Finding:
    drawn = random.Random(f"swinging {accuracy:g}")
    return _all_met((_one_swing(drawn, accuracy) for _ in range(draws)), accuracy, "place off by")


def _one_swing(drawn: random.Random, accuracy: float) -> Try:
    """Hub, belt, damping, bar and workpart, and the start of the swing, all drawn; whatever is touched first counts."""
    speed = 10.0 ** drawn.uniform(0.0, 5.0)
    belt = Belt(TOOL.belt.stiffness * (speed / 261.8) ** 2 * drawn.choice((0.1, 1.0, 10.0)), drawn.choice((0.0, 0.1)))
    bar = with_bar_at(
        TIP * drawn.uniform(0.65, 0.98), 10.0 ** drawn.uniform(-6.0, -3.0), speed, drawn.uniform(0.6, 1.2)
    )
    tool = replace(bar, belt=belt, workpart=Workpart(penetration=drawn.uniform(0.001, 0.02)))
    start = {
        "start_hub_angle": drawn.uniform(-2.1, -1.8),
        "start_relative_angle": drawn.uniform(-0.5, 0.5),
        "start_relative_rate": drawn.uniform(-1.0, 1.0) * speed,
    }
    run = simulate(tool, Settings(accuracy=accuracy, samples_per_period=1, hub_turn=2.5), **start)
    # The reference need not go far past the touch that it is to confirm.
    duration = 1.01 * run.contacts[0].time if run.contacts else float(run.time[-1])
    referred = simulate_reference(tool, accuracy=1e-10, duration=duration, **start)
    if not (run.contacts and referred.contacts):
        return Try(bool(run.contacts) == bool(referred.contacts), 0.0, run.cost.steps)
    one, other = run.contacts[0], referred.contacts[0]
    off = (one.time - other.time) * other.velocity_before[0] / TIP
    return Try(one.obstacle == other.obstacle, off, run.cost.steps)


def _too_thin(radius: float) -> HardCase:
    name = f"bar of {radius:.2g} m, wire of no width"
    tool = with_bar_at(0.9 * TIP, radius)
    words = ("bar_radius + wire_diameter / 2", f"at least {LEAST_REACH:g}", "allowed")
    return HardCase(THEME, name, "refused in one clear line", lambda: refusal(lambda: simulate(tool), *words))
