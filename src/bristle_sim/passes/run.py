"""The loop over steps: flight, touches of the bar, motion on it, release, until each pass has its strike or its end."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import levers, locks, lying
from bristle_sim.passes.flight import BAR, HUB, NOTHING, WORKPART, fly
from bristle_sim.passes.motion import pose_of
from bristle_sim.passes.slide import FOLDED, JAMMED, STRIKES, slide
from bristle_sim.passes.state import Chosen, Passes
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.impact_phases import JAM

LOCAL_FRACTION = 1e-3
"""Local tolerance over the accuracy: a thousand steps may add up, and a step's length depends on it weakly."""

MOST_TOLERANCE = 1e-9
"""Largest local tolerance: taps magnify errors a thousandfold, and a hundred times longer steps save little at this order."""

LEAST_TOLERANCE = 1e-14  # local tolerance below which rounding is larger

LOWEST_REBOUND = 1e-10
"""Height of a hop, over the bristle's length, below which the wire stays on the bar."""

MOST_TOUCHES = (
    3000  # of the bar, after which a pass is refused: a restitution near 1 has no end of them
)

LEAST_SPEED = 1e-300  # over the bristle's length, per radian; a lower one has no reciprocal

ROUNDING = 1e-15  # error of a state that geometry gives, rad

STRUCK, MISSED, LOCKED, TOO_MANY, FOLDS = range(1, 6)
"""The ends of a pass: strike, end of the hub's turn, friction on the bar, taps without end, a fold."""


def advance(passes: Passes, accuracy: float) -> Chosen:
    """Advance every pass by one step and its consequences; return how it ends, 0 where it goes on."""
    tolerance = max(min(LOCAL_FRACTION * accuracy, MOST_TOLERANCE), LEAST_TOLERANCE)
    kind, margin = fly(passes, tolerance)
    ending = np.zeros(passes.size, dtype=int)
    passes.error = np.where(margin < accuracy, 1.0, passes.error)
    ending[(kind == HUB) | (np.abs(passes.angle) > 0.5 * math.pi)] = FOLDS
    ending[(passes.hub_angle >= passes.end) & (kind == NOTHING) & (ending == 0)] = MISSED
    ending[(kind == WORKPART) & (ending == 0)] = STRUCK
    touching = np.flatnonzero((kind == BAR) & (ending == 0))
    if touching.size:
        some = passes.take(touching)
        ending[touching] = touch_bar(some, accuracy)
        passes.put(touching, some)
    return ending


def touch_bar(passes: Passes, accuracy: float) -> Chosen:
    """Resolve impacts on the bar, and follow the wires that stay on it to their release; return how the passes end, 0 if they go on."""
    touch = levers(passes, pose_of(passes.hub_angle, passes.angle, passes.rate))
    rows = np.array([touch.normal, touch.tangential])
    inverse_mass = (rows[:, np.newaxis] * rows).transpose(2, 0, 1)
    velocity = np.array([touch.normal_velocity, touch.tangential_velocity]).T
    hit = energetic_impact(inverse_mass, velocity, passes.bar_friction, passes.bar_restitution)
    passes.rate = passes.rate + rows[0] * hit.impulse_normal + rows[1] * hit.impulse_tangential
    passes.touches = passes.touches + 1
    passes.touching = np.ones(passes.size, dtype=bool)
    passes.release, passes.release_angle = passes.hub_angle.copy(), passes.angle.copy()
    ending = np.where(
        hit.outcome == JAM, LOCKED, np.where(passes.touches > MOST_TOUCHES, TOO_MANY, 0)
    )

    sides = touch.side
    at_end = touch_at_end(passes, passes.hub_angle)
    held = lying(passes, passes.hub_angle, sides, at_end)
    parting = np.maximum(hit.velocity_normal, 0.0)
    pressed = np.abs(touch.normal) * held.pressure
    approach = np.maximum(-touch.normal_velocity, LEAST_SPEED)
    amplified = np.abs(pressed) / approach
    passes.error = passes.error * (1.0 + (1.0 + passes.bar_restitution) * amplified)
    grazes = (
        touch.normal_velocity**2 < -2.0 * pressed * accuracy
    )  # the gap would open again by itself
    passes.error = np.where(grazes, 1.0, passes.error)
    low = parting**2 < 2.0 * pressed * LOWEST_REBOUND
    low |= comes_to_rest(passes, sides, at_end, pressed, parting, parting / approach)
    stays = np.flatnonzero((ending == 0) & (pressed > 0.0) & low)
    if stays.size:
        some = passes.take(stays)
        some.rate = held.rate[stays]
        locked = locks(some, some.hub_angle, some.angle, some.rate)
        how = slide(some, sides[stays])
        some.error = np.where(some.error >= 1.0, 1.0, ROUNDING)
        passes.put(stays, some)
        how[locked] = JAMMED
        ending[stays] = np.select(
            [how == JAMMED, how == STRIKES, how == FOLDED], [LOCKED, STRUCK, FOLDS], 0
        )
    return ending


def comes_to_rest(
    passes: Passes, sides: Array, at_end: Chosen, pressed: Array, parting: Array, returned: Array
) -> Chosen:
    """Return whether hops come to rest while the wire is still pressed onto the bar, so that it lies there as if it never hopped.

    Hops of an initial speed v that keep a fraction e of it last 2 v/(a (1 - e)) in all at an acceleration a. Twice that time is
    looked ahead, and the pressure must stay within a factor of two.
    """
    lost = pressed * (1.0 - returned)
    lasting = np.divide(4.0 * parting, lost, out=np.ones_like(lost), where=lost > 0.0)
    ahead = passes.hub_angle + np.minimum(lasting, 1.0)
    same = touch_at_end(passes, ahead) == at_end
    now = lying(passes, passes.hub_angle, sides, at_end).pressure
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = lying(passes, ahead, sides, at_end).pressure / now
    return np.asarray(same & (ratio > 0.5) & (ratio < 2.0) & (ahead < passes.hub_angle + 1.0))


def touch_at_end(passes: Passes, hub_angle: Array) -> Chosen:
    """Return whether wires that lie on the bar at hub angles touch it with their ends, D^2 > 1 + R^2."""
    chi = hub_angle - passes.bar_angle
    square = (
        passes.bar_distance**2
        + passes.radius**2
        - 2.0 * passes.radius * passes.bar_distance * np.cos(chi)
    )
    return np.asarray(square > 1.0 + passes.reach**2)
