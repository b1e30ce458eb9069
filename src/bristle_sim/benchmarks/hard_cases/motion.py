"""Hard cases of motion: extreme belts, damping and hub speeds, thin bars, and long runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    AS_REFERENCE,
    RELEASED,
    Finding,
    HardCase,
    agrees_with_reference,
    all_of,
    hard_case,
    within,
    worst,
)
from bristle_sim.parameters import Bar, Belt, Tool
from bristle_sim.scene.pairs import LEAST_REACH
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings, StopReason
from bristle_sim.theory.cueing import stiffened_cue

TOOL = Tool()
FREE = Tool(bar=None, workpart=None)
STIFFNESS = Belt().stiffness

FINE = 1e-9
"""Requested accuracy of the more accurate runs."""

BUDGET = 20_000
"""Permitted number of engine steps, at which the pass with the stiffest belt must stop."""


def released(name: str, accuracy: float, **changes: float) -> HardCase:
    """Return a case that checks the release of a bristle against the energy integral.

    ``changes`` are the tool's parameters that differ from their defaults, by key.
    """
    return hard_case(
        f"{name}: released, accuracy {accuracy:g}",
        f"highest speed and its time as by the energy integral to {accuracy:g}, the requested accuracy",
        _agrees_with_energy_integral,
        FREE.replace(**changes),
        accuracy,
    )


def _agrees_with_energy_integral(tool: Tool, accuracy: float) -> Finding:
    """Check the highest angular velocity after an undamped release from rest, and when it occurs.

    The expected velocity and time follow from the energy integral.
    """
    run = simulate(
        tool, Settings(accuracy=accuracy), **RELEASED, stop_after="highest relative speed"
    )
    expected = stiffened_cue(replace(tool, bar=TOOL.bar, workpart=TOOL.workpart))
    late = float(run.time[-1]) / expected.cue_time - 1.0
    fast = float(run.relative_rate[-1]) / expected.highest_relative_speed - 1.0
    return within(worst([late, fast]), accuracy, "off by", run.cost.steps)


def whole(name: str, **changes: float) -> HardCase:
    """Return a case that checks a simulated pass against the reference solution.

    ``changes`` are the tool's parameters that differ from their defaults, by key.
    """
    promise = AS_REFERENCE.format(ACCURACY)
    return hard_case(f"{name}: whole pass", promise, agrees_with_reference, TOOL.replace(**changes))


def belt_stiffness() -> Iterator[HardCase]:
    """Yield cases whose belt stiffness ranges from 1e-3 to 1e6 times the default.

    In some cases a deflected bristle is released from rest; the others are whole passes.
    """
    for factor, accuracy in ((1e-3, ACCURACY), (1.0, ACCURACY), (1e6, FINE)):
        yield released(f"belt x {factor:g}", accuracy, belt_stiffness=factor * STIFFNESS)
    for factor in (1e-3, 10.0):
        yield whole(f"belt x {factor:g}", belt_stiffness=factor * STIFFNESS)
    yield hard_case(
        "belt x 1e+06: whole pass", "stops, with the reason 'step budget spent'", _spends_budget
    )


def _spends_budget() -> Finding:
    """Check that the pass with the stiffest belt stops at its permitted number of steps."""
    tool = TOOL.replace(belt_stiffness=1e6 * STIFFNESS)
    run = simulate(tool, Settings(maximum_steps=BUDGET))
    spent = run.stop_reason is StopReason.STEP_BUDGET and bool(np.isfinite(run.rates).all())
    return Finding(run.stop_reason, spent, run.cost.steps)


def damping() -> Iterator[HardCase]:
    """Yield free decays with damping ratios up to 100, and a whole pass with ratio 0.5.

    A decay is compared with the reference solution at a time at which the bristle still moves.
    """
    promise = AS_REFERENCE.format(ACCURACY)
    for ratio, turn in ((0.5, 0.5), (1.0, 0.5), (100.0, 0.2)):
        free = FREE.replace(belt_damping_ratio=ratio)
        given = {"start": RELEASED, "hub_turn": turn}
        yield hard_case(f"ratio {ratio:g}: decay", promise, agrees_with_reference, free, **given)
    yield whole("ratio 0.5", belt_damping_ratio=0.5)


def hub_speed() -> Iterator[HardCase]:
    """Yield cases with hub speeds from 0 to 1e5 rad/s.

    They are a release on a resting hub, whole passes, and a slow pass without belt stiffness.
    """
    yield released("0 rad/s", FINE, hub_speed=0.0)
    for speed in (0.0, 1e3, 1e5):
        yield whole(f"{speed:g} rad/s", hub_speed=speed)
    yield whole("0.001 rad/s, no belt", hub_speed=1e-3, belt_stiffness=0.0)


TIP = TOOL.hub.radius + TOOL.bristle.length
"""Radius of the circle on which the tip of a radial bristle moves, m."""

THINNEST = 1.001 * LEAST_REACH * TOOL.bristle.length
"""Radius of a thin bar, m: 0.1 % larger than the smallest that a wire of zero diameter permits."""


def tunnelling() -> Iterator[HardCase]:
    """Yield passes in which the tip moves in one step much farther than the bar is thick.

    A straight bristle without gravity remains radial until it touches an obstacle. The exact time
    of the touch therefore follows from geometry.
    """
    for accuracy in (0.1, 1e-6, 1e-11):
        name = f"accuracy {accuracy:g}, hub 1 to 1e5 rad/s, bars from {THINNEST:.1g} m and the workpart"
        promise = (
            f"all met, relative error of the times at most {accuracy:g}, the requested accuracy"
        )
        yield hard_case(name, promise, _meets, accuracy)


BAR_DISTANCE = 0.9 * TIP
BAR_ANGLE = 1.2
"""Position of the bar: distance from the hub's axis (m), and angle from the workpart's normal
towards the arriving bristle (rad)."""


def with_bar(radius: float) -> Tool:
    """Return a tool with a wire of zero diameter and a bar of this radius (m).

    The bar stands inside the circle on which the tip moves.
    """
    bar = Bar(radius, BAR_DISTANCE * math.sin(BAR_ANGLE), BAR_DISTANCE * math.cos(BAR_ANGLE))
    return TOOL.replace(bar=bar, wire_diameter=0.0, bristle_mass=TOOL.bristle.mass)


def _meets(accuracy: float) -> Finding:
    """Check the times at which bristles first touch the bar or the workpart.

    The exact times follow from geometry. ``accuracy`` is requested of the simulations, and is the
    largest permitted relative error of a time.
    """
    settings = Settings(accuracy=accuracy, samples_per_period=1)
    # Angles of a radial bristle to the workpart's normal at the touch, rad.
    touches = [(TOOL.replace(bar=None), "strike", -math.acos(TOOL.workpart_depth / TIP))]
    for radius in (THINNEST, 1e-6, 1e-3):
        angle = -BAR_ANGLE - math.asin(radius / BAR_DISTANCE)  # the wire is tangent to the bar
        touches.append((with_bar(radius), "bar touch", angle))
    late = list[float]()
    steps = 0
    for speed in (1.0, 261.8, 1e5):
        for tool, event, angle in touches:
            run = simulate(tool.replace(hub_speed=speed), settings, stop_after=event)
            at = run.event_time(event)
            expected = (angle - tool.start_hub_angle) / speed
            late.append(math.inf if at is None else at / expected - 1.0)
            steps += run.cost.steps
    met = Finding(f"{sum(map(math.isfinite, late))} of {len(late)} met", True)
    return all_of(met, within(worst(late), accuracy, "off by", steps))


def long_run() -> Iterator[HardCase]:
    """Yield free oscillations during 10 and 1000 revolutions of the hub."""
    promise = (
        "energy in the hub's frame changes by at most {0:g} per revolution, the requested accuracy"
    )
    for turns, accuracy in ((10, 1e-9), (1000, 1e-6)):
        name = f"{turns} hub turns, accuracy {accuracy:g}"
        yield hard_case(name, promise.format(accuracy), _swings, accuracy, turns)


def _swings(accuracy: float, turns: int) -> Finding:
    """Check that a free oscillation conserves the energy in the hub's frame, Jacobi's integral.

    This energy is I alpha'^2/2 + k_T alpha^2/2 + m r_h (L/2) omega^2 (1 - cos alpha). Its relative
    change per revolution, in ``turns`` revolutions of the hub, must be at most ``accuracy``.
    alpha is the bristle's angle relative to the hub, I its moment of inertia about the root, k_T
    the belt's stiffness. m and L are the bristle's mass and length, r_h is the hub's radius and
    omega its angular velocity.
    """
    settings = Settings(
        accuracy, maximum_steps=10**9, hub_turn=turns * math.tau, samples_per_period=6
    )
    run = simulate(FREE, settings, **RELEASED)
    bristle = FREE.bristle
    hub = FREE.hub
    field = bristle.mass * hub.radius * bristle.length * hub.speed**2
    turning = (
        bristle.inertia_about_root * run.relative_rate**2
        + FREE.belt.stiffness * run.relative_angle**2
    )
    energy = turning + field * (1.0 - np.cos(run.relative_angle))
    return all_of(
        within(
            (energy[-1] / energy[0] - 1.0) / turns,
            accuracy,
            "change per revolution",
            run.cost.steps,
        ),
        Finding(
            f"{run.hub_angle[-1] - run.hub_angle[0]:.9g} rad turned",
            run.stop_reason is StopReason.END,
        ),
    )
