"""Smooth motion where it is hard: belts, damping, sizes, hub speeds, thin bars, long runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, refusal, row, within
from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    RELEASED,
    agrees_with_energy_integral,
    agrees_with_reference,
    meets,
    spends_budget,
)
from bristle_sim.parameters import Bar, Belt, Hub, Tool
from bristle_sim.scene.contact.obstacles import LEAST_REACH
from bristle_sim.scene.tool import START, simulate, tool_units
from bristle_sim.settings import Settings
from bristle_sim.theory.cueing import centrifugal_stiffness

TOOL, FREE = Tool(), Tool(bar=None, workpart=None)

FINE = 1e-9
"""Accuracy of runs that are requested a thousand times more accurate."""

BUDGET = 20_000
"""Engine steps of a run that is to spend them."""

REFUSED = "refused in one line: the step, and what it must be"
CLOSED_FORM = "highest speed and its time as by the energy integral to {:g}, the requested accuracy"
AS_REFERENCE = f"strike and end as in the reference to {ACCURACY:g}, the requested accuracy"
SPENT = "says that its step budget is spent"


def belt_stiffness() -> Iterator[HardCase]:
    """Yield the release, whole pass and fixed steps, over nine decades of stiffness."""
    for factor in (1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6):
        place, belt, ends = f"belt x {factor:g}", Belt(factor * Belt().stiffness), factor in (1e-3, 1.0, 1e6)
        case, whole = partial(row, "belt_stiffness"), Tool(belt=belt)
        for accuracy in (ACCURACY, FINE):
            name, promise = f"{place}: released, accuracy {accuracy:g}", CLOSED_FORM.format(accuracy)
            free = replace(FREE, belt=belt)
            yield case(name, promise, agrees_with_energy_integral, free, accuracy, quick=ends)
        if factor <= 1e3:
            quick = factor in (1e-3, 10.0)
            yield case(f"{place}: whole pass", AS_REFERENCE, agrees_with_reference, whole, quick=quick)
        else:
            name, promise = f"{place}: pass up to the strike", f"{AS_REFERENCE}, or up to a loss of grip"
            upto = partial(agrees_with_reference, whole, stop_after="strike", may_lose_grip=True)
            yield case(name, promise, upto, quick=False)
        for step in (2.5, 100.0, 1e5) if ends else ():
            yield case(f"{place}: fixed step of {step:g} rad", REFUSED, _refuses_step, whole, step)
    yield row("belt_stiffness", "belt x 1e+06: whole pass", SPENT, spends_budget, whole, BUDGET)


def _refuses_step(tool: Tool, radians: float) -> Finding:
    """Past 2 rad of the fastest motion the engine's springs are unstable."""
    bristle, hub = tool.bristle, tool.hub
    field = centrifugal_stiffness(bristle.mass, hub.radius, bristle.length, hub.speed)
    fastest = max(math.sqrt((tool.belt.stiffness + field) / bristle.inertia_about_root), hub.speed)
    return refusal(lambda: simulate(tool, Settings(step=radians / fastest)), "step =", "in s")


def damping() -> Iterator[HardCase]:
    """Yield whole passes, for ratios up to 1000."""
    for ratio in (1e-9, 1e-3, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 10.0, 100.0):
        place, tool = f"ratio {ratio:.10g}", Tool(belt=Belt(damping_ratio=ratio))
        quick = ratio in (0.5, 10.0)
        yield row("damping", f"{place}: whole pass", AS_REFERENCE, agrees_with_reference, tool, quick=quick)
    highest = Tool(belt=Belt(damping_ratio=1e3))
    yield row("damping", "ratio 1000: whole pass", SPENT, spends_budget, highest, BUDGET)


def hub_speed() -> Iterator[HardCase]:
    """Yield the release and the whole pass on hubs at rest and up to 1e5 rad/s, with a belt and without."""
    case = partial(row, "hub_speed")
    for speed in (0.0, 1e-3, 1.0, 100.0, 1e3, 1e4, 1e5):
        place, hub = f"{speed:g} rad/s", Hub(speed=speed)
        for accuracy in (ACCURACY, FINE):
            name, promise = f"{place}: released, accuracy {accuracy:g}", CLOSED_FORM.format(accuracy)
            free, quick = replace(FREE, hub=hub), speed in (0.0, 1e-3, 1e5)
            yield case(name, promise, agrees_with_energy_integral, free, accuracy, quick=quick)
        if speed >= 100.0:
            name, quick = f"{place}: whole pass", speed in (1e3, 1e5)
            yield case(name, AS_REFERENCE, agrees_with_reference, Tool(hub=hub), quick=quick)
        if speed in (1e-3, 1.0, 1e3, 1e5):
            bare, quick = Tool(hub=hub, belt=Belt(stiffness=0.0)), speed in (1e-3, 1e5)
            yield case(f"{place}: whole pass, no belt", AS_REFERENCE, agrees_with_reference, bare, quick=quick)
    for speed, belt in ((1e-3, Belt()), (1e-300, Belt()), (1e-300, Belt(stiffness=0.0))):
        name = f"{speed:g} rad/s: whole pass" + ("" if belt.stiffness else ", no belt; budget")
        yield case(name, SPENT, spends_budget, Tool(hub=Hub(speed=speed), belt=belt), BUDGET)


ROOT, TIP = TOOL.hub.radius, TOOL.hub.radius + TOOL.bristle.length
"""Radii of the circles of a radial bristle's root and tip, m."""

THINNEST = 1.001 * LEAST_REACH * TOOL.bristle.length
"""Radius of the thinnest bar that an infinitely thin wire may meet, m."""


def tunnelling() -> Iterator[HardCase]:
    """Yield every accuracy and step with every speed, and bars too thin to have a side.

    A straight bristle without gravity remains radial until it touches something, so that the instant is plain geometry.
    """
    case = partial(row, "tunnelling")
    for accuracy in (0.1, 1e-3, 1e-6, 1e-9, 1e-11):
        name = f"accuracy {accuracy:g}, hub 1 to 1e5 rad/s, bars from {THINNEST:.1g} m and the workpart"
        promise = f"all met, their instants right to {accuracy:g} of them, the requested accuracy"
        yield case(name, promise, _meets_at_accuracy, accuracy)
    for part in (1e-12, 1e-6, 1e-3, 0.1, 0.5, 1.0):
        name = f"steps of {part:g} of the longest or 1e-12 s, bars from {THINNEST:.1g} m"
        quick = part in (1e-12, 0.1, 1.0)
        yield case(name, "all met, their instants right to a step", _meets_at_step, part, quick=quick)
    words = ("bar_radius + wire_diameter / 2", f"{LEAST_REACH:g}")
    for radius in (0.9 * LEAST_REACH * TOOL.bristle.length, 5e-324):
        thin = partial(simulate, with_bar_at(0.9 * TIP, radius))
        yield case(f"bar of {radius:.2g} m, wire of no width", "refused in one line", refusal, thin, *words)


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


def all_met(met: list[Finding]) -> Finding:
    """Join findings of many runs into one, which names the first that missed."""
    missed = [each.reached for each in met if not each.ok]
    told = f"{len(met) - len(missed)} of {len(met)} met" + (f"; {missed[0]}" if missed else "")
    return Finding(told, not missed, sum(each.steps for each in met))


def _meets_at_accuracy(accuracy: float) -> Finding:
    settings, met = Settings(accuracy=accuracy, samples_per_period=1), []
    for speed in (1.0, 261.8, 1e5):
        for radius in (THINNEST, 1e-6, 1e-3):
            tool = with_bar_at(0.9 * TIP, radius, speed)
            expected = first_bar_touch(tool)
            met.append(meets(tool, settings, "bar touch", expected, accuracy * expected))
        bare = replace(TOOL, hub=Hub(speed=speed), bar=None)
        expected = (-START - math.acos(bare.workpart_depth / TIP)) / speed
        met.append(meets(bare, settings, "strike", expected, accuracy * expected))
    return all_met(met)


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
                met.append(meets(tool, settings, "bar touch", expected, step, {"start_hub_angle": angle}))
    return all_met(met)


def long_run() -> Iterator[HardCase]:
    """Yield free swings over up to a thousand turns of the hub, at two accuracies."""
    promise = "energy in the hub's frame changes by {0:g} a turn at most, the requested accuracy"
    for n in (10, 100, 1000):
        for e in (1e-6, 1e-9):
            name = f"{n} hub turns, accuracy {e:g}"
            yield row("long_run", name, promise.format(e), _swings, e, n, quick=n == 10)


def jacobi_energy(tool: Tool, angle: Array, rate: Array) -> Array:
    """Return I alpha'^2/2 + k alpha^2/2 + m r_h l Omega^2 (1 - cos alpha) in J, from relative angle (rad) and rate (rad/s).

    It is Jacobi's integral of the rotating frame, with the inertia I about the root and the centre of mass at l from there.
    """
    bristle, hub = tool.bristle, tool.hub
    field = bristle.mass * hub.radius * math.hypot(*bristle.centre) * hub.speed**2
    elastic = bristle.inertia_about_root * rate**2 + tool.belt.stiffness * angle**2
    return np.asarray(0.5 * elastic + field * (1.0 - np.cos(angle)))


def _swings(accuracy: float, turns: int) -> Finding:
    settings = Settings(accuracy, maximum_steps=10**9, hub_turn=turns * math.tau, samples_per_period=6)
    run = simulate(FREE, settings, **RELEASED)
    energy = jacobi_energy(FREE, run.relative_angle, run.relative_rate)
    return all_of(
        within((energy[-1] / energy[0] - 1.0) / turns, accuracy, "change a turn", run.cost.steps),
        Finding(f"{run.hub_angle[-1] - run.hub_angle[0]:.9g} rad turned", run.stop_reason == "end of the planned time"),
    )
