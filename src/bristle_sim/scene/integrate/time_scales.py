"""The time scales of a tool's scene, and the integrator for the requested accuracy.

In a scene's units the fastest of belt, hub and gravity has the rate 1. A bristle's own motion relative to the hub may be far
smaller and slower than that; the requested accuracy is that of this motion.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from bristle_sim.scene.build import Scene
from bristle_sim.scene.integrate.extrapolation import LEAST_NOISE, Extrapolation, PlainSteps, lagrange_weights
from bristle_sim.scene.mechanism import State
from bristle_sim.settings import Settings

if TYPE_CHECKING:
    from bristle_sim.scene.progress import Plan

MOST_DAMPING = 8.0
"""Most time constants of the engine's damping in an interval: two in each of the four steps of the coarsest repetition. In far
longer steps damping removes all of a rate, whatever their length. Such steps agree with each other on a belt that does not
move, and no error estimate shows it."""


DAMPED_STEPS = (
    27  # in the longest damped interval: the least number from which repetitions differ by the error of rates
)

LARGEST_STEP = 1.0
"""Largest engine step, in radians of the fastest motion or time constants of its damping; from 2 on its explicit springs are
unstable, and its damping has half the right value."""

LOCAL_FRACTION, SOME_INTERVALS = 0.05, 50.0
"""Each interval may use this fraction of the accuracy, enough for some twenty intervals. If damping forces more than the latter
within the time in which the belt forgets an error, c/k, the fraction shrinks in proportion."""


def damping_rate(scene: Scene) -> float:
    """Return the engine's damping rate: it treats links as free, about their centres, before the joints correct them."""
    links, hinges = scene.mechanism.links, scene.effects.hinges
    belt = scene.effects.damping / links[0].inertia
    joints = zip(hinges, links, links[1:], strict=False)
    return max([belt, *(damping * (1.0 / a.inertia + 1.0 / b.inertia) for (_, damping), a, b in joints)])


def damped_interval(scene: Scene) -> float:
    """Return the longest interval in which the engine's steps resolve the damping; infinite without damping."""
    rate = damping_rate(scene)
    return MOST_DAMPING / rate if rate else math.inf


def time_scale(scene: Scene) -> float:
    """Return the time of one radian of the fastest hinge mode of a straight chain; 1 if none is faster than that."""
    if not (hinges := scene.effects.hinges):
        return 1.0
    wire = scene.mechanism.wire(0)
    links = len(wire.links)
    twists = np.eye(links)[1:] - np.eye(links)[:-1]
    stiffness = twists.T @ np.diag([each for each, _ in hinges[: links - 1]]) @ twists
    mass = wire.mass_matrix(wire.poses(State(0.0, (0.0,) * links, (0.0,) * links)))
    return 1.0 / math.sqrt(max(1.0, np.abs(np.linalg.eigvals(np.linalg.solve(mass, stiffness))).max()))


def motion_scale(scene: Scene, start: State) -> float:
    """The scale of errors, a rate relative to the hub: the one that a free bristle reaches, at most 1.

    A bristle released at the angle a, at rest, on a belt of its own rate w reaches a w. It is 1 at rest, for several links, and
    with an obstacle, because the bar turns the hub's speed into the bristle's.
    """
    mechanism, effects, link = scene.mechanism, scene.effects, scene.mechanism.links[0]
    if effects.obstacles or not mechanism.lone:
        return 1.0
    field = mechanism.hub_radius * mechanism.hub_speed**2 + effects.gravity
    stiffness = (effects.stiffness or 0.0) + link.mass * math.hypot(*link.centre) * field
    swing = abs(start.angles[0] - mechanism.hub_angle(start.time)) * math.sqrt(stiffness / link.inertia_about_joint)
    return min(max(swing, abs(start.rates[0] - mechanism.hub_speed)), 1.0) or 1.0


def stepper_for(scene: Scene, settings: Settings, start: State, plan: Plan) -> Extrapolation:
    """Return extrapolation to the accuracy.

    Raises:
        ValueError: if rounding would hide the accuracy of so small a motion.
    """
    scale, fraction = motion_scale(scene, start), LOCAL_FRACTION
    least = LEAST_NOISE / (LOCAL_FRACTION * scale)
    if settings.accuracy < least:
        raise ValueError(
            f"accuracy = {settings.accuracy:g}: must be at least {least:.3g} for a motion as small and slow as this one,"
            " whose rest rounding hides (dimensionless)"
        )
    damping, stiffness, rate = scene.effects.damping, scene.effects.stiffness, damping_rate(scene)
    if not scene.mechanism.lone:
        fraction *= min(1.0, SOME_INTERVALS * MOST_DAMPING / (plan.end * max(rate, 1.0 / plan.time_scale)))
    elif damping and stiffness:
        fraction *= min(1.0, SOME_INTERVALS * MOST_DAMPING / (min(plan.end, damping / stiffness) * rate))
    longest = min(2.0 * plan.longest_interval, plan.damped_interval)
    damped_step = plan.damped_interval / DAMPED_STEPS
    return Extrapolation(fraction * settings.accuracy, scale, longest=longest, damped_step=damped_step)


def plain_steps_for(scene: Scene, settings: Settings, step: float, unit: float) -> PlainSteps:
    """Return plain steps of a length, s, in a scene with that unit of time. Raises ValueError if they are too long."""
    fastest = max(1.0 / time_scale(scene), damping_rate(scene))
    largest = min(2.0 * math.pi / settings.samples, LARGEST_STEP) / fastest * unit
    if not 0.0 < step <= largest:
        raise ValueError(f"step = {step:g}: must be at most {largest:g} with this belt, hub speed and bristle (in s)")
    return PlainSteps(step / unit)


LONGEST_PROBE = 0.3
"""Longest step of a probed acceleration, in the scene's time units and time constants of the engine's damping. Measured:
rounding and the error left by extrapolation are then both some 1e-12 times the rate of the damping."""

PROBES = (1, 2, 3, 4, 5, 6, 8, 10, 12)  # its steps are this many times shorter

PROBE_WEIGHTS = lagrange_weights(PROBES)


def acceleration(scene: Scene, state: State, link: int = 0) -> float:
    """Return the acceleration of a link without contact, engine units: that of the second step, extrapolated to zero step."""
    longest, found = LONGEST_PROBE / (1.0 + damping_rate(scene)), []
    for count, weight in zip(PROBES, PROBE_WEIGHTS, strict=True):
        scene.place(state)
        found.append(weight * scene.step(longest / count, 2)[2 * len(scene.links) + link])
    return math.fsum(found)
