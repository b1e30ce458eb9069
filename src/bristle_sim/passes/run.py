"""The loop over steps: flight, touches of the bar, motion on it, and release, until each pass ends."""

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
"""Local tolerance over the accuracy: the errors of a thousand steps may add up.

The length of a step depends weakly on it."""

MOST_TOLERANCE = 1e-9
"""Largest local tolerance: taps magnify errors a thousandfold. At this order a larger tolerance
saves little."""

LEAST_TOLERANCE = 1e-14  # smallest local tolerance; rounding is of this size

LOWEST_REBOUND = 1e-10
"""Lowest hop, over the bristle's length; after a lower one the wire stays on the bar."""

MOST_TOUCHES = 3000  # most touches of the bar; a restitution near 1 gives endlessly many

# least speed over the bristle's length, per radian, against a division by zero
LEAST_SPEED = 1e-300
ROUNDING = 1e-15  # error of a state that follows from geometry, rad

FLIES, STRUCK, MISSED, LOCKED, TOO_MANY, FOLDS, TOUCHES = range(7)
"""Codes of passes: in flight, ended by a strike, by the end of the hub's turn, by friction on the
bar, by endless taps or by a fold, and those that touch the bar."""


def advance(passes: Passes, accuracy: float) -> Chosen:
    """Advance flights by one step, and return the codes of the passes."""
    tolerance = max(min(LOCAL_FRACTION * accuracy, MOST_TOLERANCE), LEAST_TOLERANCE)
    kind, margin = fly(passes, tolerance)
    passes.error = np.where(margin < accuracy, 1.0, passes.error)
    missed = (kind == NOTHING) & (passes.hub_angle >= passes.end)
    return np.select(
        [_folds(passes) | (kind == HUB), kind == WORKPART, kind == BAR, missed],
        [FOLDS, STRUCK, TOUCHES, MISSED],
        FLIES,
    )


def _folds(passes: Passes) -> Chosen:
    """Return whether wires fold back, or have folded back, by more than a quarter turn."""
    return np.maximum(passes.angle, -passes.lowest) > 0.5 * math.pi


def touch_bar(passes: Passes, accuracy: float) -> Chosen:
    """Resolve impacts on the bar, follow the wires that stay on it to their release, and return the
    codes of the passes.
    """
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
        hit.outcome == JAM, LOCKED, np.where(passes.touches > MOST_TOUCHES, TOO_MANY, FLIES)
    )

    sides = touch.side
    at_end = touch_at_end(passes, passes.hub_angle)
    held = lying(passes, passes.hub_angle, sides, at_end)
    parting = np.maximum(hit.velocity_normal, 0.0)
    pressed = np.abs(touch.normal) * held.pressure
    approach = np.maximum(-touch.normal_velocity, LEAST_SPEED)
    amplified = np.abs(pressed) / approach
    passes.error = passes.error * (1.0 + (1.0 + passes.bar_restitution) * amplified)
    # Without the bar the overlap would stay within the accuracy, and the gap would open again.
    grazes = touch.normal_velocity**2 < -2.0 * pressed * accuracy
    passes.error = np.where(grazes, 1.0, passes.error)
    low = parting**2 < 2.0 * pressed * LOWEST_REBOUND
    low |= comes_to_rest(passes, sides, at_end, pressed, parting, parting / approach)
    stays = np.flatnonzero((ending == FLIES) & (pressed > 0.0) & low)
    if stays.size:
        some = passes.take(stays)
        some.rate = held.rate[stays]
        locked = locks(some, some.hub_angle, some.angle, some.rate)
        how = slide(some, sides[stays])
        some.error = np.where(some.error >= 1.0, 1.0, ROUNDING)
        passes.put(stays, some)
        how[locked] = JAMMED
        ending[stays] = np.select(
            [how == JAMMED, how == STRIKES, how == FOLDED], [LOCKED, STRUCK, FOLDS], FLIES
        )
        ending[_folds(passes)] = FOLDS
    return ending


def comes_to_rest(
    passes: Passes, sides: Array, at_end: Chosen, pressed: Array, parting: Array, returned: Array
) -> Chosen:
    """Return whether hops come to rest while the wire is still pressed onto the bar.

    The wire then lies on the bar as if it had never hopped. Hops with the initial speed v and the
    restitution e last 2 v/(a (1 - e)) in all at an acceleration a. The pressure after twice that
    time must be within a factor of two of the present one.
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
    """Return whether wires that lie on the bar at given hub angles touch it with their ends, D^2 >
    1 + R^2.
    """
    chi = hub_angle - passes.bar_angle
    square = (
        passes.bar_distance**2
        + passes.radius**2
        - 2.0 * passes.radius * passes.bar_distance * np.cos(chi)
    )
    return np.asarray(square > 1.0 + passes.reach**2)
