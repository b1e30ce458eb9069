"""A step of every pass: flight, or a touch of the bar with the motion on the bar up to release."""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import flank_window, half_turn, levers, lying
from bristle_sim.passes.flight import fly
from bristle_sim.passes.motion import pose_of
from bristle_sim.passes.slide import slide
from bristle_sim.passes.state import (
    FLIES,
    FOLDS,
    LEAST,
    LOCKED,
    MISSED,
    QUARTER_TURN,
    TOO_MANY,
    Chosen,
    Passes,
)
from bristle_sim.theory.impact_phases import JAM, resolve_phases

LOCAL_FRACTION = 1e-3
"""Local tolerance of a step over the requested accuracy, as the errors of a thousand steps may add
up.

The length of a step depends only weakly on its tolerance."""

MOST_TOLERANCE = 1e-9
"""Largest local tolerance, as repeated impacts on the bar magnify errors a thousandfold.

At the high order of the series a larger tolerance saves little time."""

LEAST_TOLERANCE = 1e-14  # smallest local tolerance, the size of rounding error

LOWEST_REBOUND = 1e-10
"""Height of a rebound from the bar, over the bristle's length, below which the wire stays on the
bar."""

MOST_TOUCHES = 3000  # most touches of the bar in a pass; a restitution near 1 gives endlessly many

ROUNDING = 1e-15  # rounding error of an angle that follows from geometry, rad


def advance(passes: Passes, accuracy: float) -> Chosen:
    """Advance bristles in flight by one step, and return the code of each pass's new state."""
    tolerance = max(min(LOCAL_FRACTION * accuracy, MOST_TOLERANCE), LEAST_TOLERANCE)
    codes, margin = fly(passes, tolerance)
    passes.error[margin < accuracy] = 1.0
    codes[(codes == FLIES) & (passes.hub_angle >= passes.end)] = MISSED
    codes[_folds(passes)] = FOLDS
    return codes


def _folds(passes: Passes) -> Chosen:
    """Return whether each wire is ahead by more than a quarter turn, or was ever behind by more."""
    return np.maximum(passes.angle, -passes.lowest) > QUARTER_TURN


def touch_bar(passes: Passes, accuracy: float) -> Chosen:
    """Resolve the impacts of wires on the bar, and return the code of each pass's new state.

    A wire that stays on the bar is followed until it leaves the bar or the pass ends.
    """
    normal, tangential, approach, slip, side = levers(
        passes, pose_of(passes.hub_angle, passes.angle, passes.rate)
    )
    friction, restitution = passes.bar_friction, passes.bar_restitution
    inverse_mass = (normal * normal, normal * tangential, tangential * tangential)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        hit = resolve_phases(*inverse_mass, approach, slip, friction, restitution, friction)
    passes.rate += normal * hit.impulse_normal + tangential * hit.impulse_tangential
    passes.touches += 1.0
    passes.touching[:] = 1.0
    passes.release[:], passes.release_angle[:] = passes.hub_angle, passes.angle
    ending = np.where(passes.touches > MOST_TOUCHES, TOO_MANY, FLIES)
    ending[hit.outcome == JAM] = LOCKED

    at_end = touch_at_end(passes, passes.hub_angle)
    held = lying(passes, passes.hub_angle, side, at_end)
    parting = np.maximum(hit.velocity_normal, 0.0)
    pressed = np.abs(normal) * held.pressure
    speed = np.maximum(-approach, LEAST)
    # An error of the angle shifts the touch, and so changes the rate.
    amplified = (1.0 + restitution) * np.abs(pressed) / (speed * passes.rate_scale)
    passes.error[:] = np.minimum(passes.error * (1.0 + amplified), 1.0)  # 1: any uncertainty
    # Without the bar the overlap would stay within the accuracy, and the gap would open again.
    passes.error[approach**2 < -2.0 * pressed * accuracy] = 1.0
    low = parting**2 < 2.0 * pressed * LOWEST_REBOUND
    # Rebounds that begin with the speed v last 2 v/(a (1 - e)) in all, here twice that time.
    lost = pressed * (1.0 - parting / speed)
    lasting = np.divide(4.0 * parting, lost, out=np.ones_like(lost), where=lost > 0.0)
    low |= comes_to_rest(passes, side, at_end, held.pressure, lasting)
    stays = np.flatnonzero((ending == FLIES) & (pressed > 0.0) & low)
    if stays.size:
        some = passes.take(stays)
        some.rate[:] = held.rate[stays]
        ending[stays] = slide(some, side[stays])
        some.error[some.error < 1.0] = ROUNDING
        passes.put(stays, some)
        ending[_folds(passes)] = FOLDS
    return ending


def comes_to_rest(
    passes: Passes, side: Array, at_end: Chosen, pressure: Array, lasting: Array
) -> Chosen:
    """Return whether each wire's rebounds from the bar die out while the wire is still pressed onto
    the bar.

    The wire then lies on the bar as if it had never rebounded. After the time ``lasting`` it must
    touch with the same part, flank or end, and the pressure must have changed by less than a factor
    of two.
    """
    ahead = passes.hub_angle + np.minimum(lasting, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = lying(passes, ahead, side, at_end).pressure / pressure
    same = touch_at_end(passes, ahead) == at_end
    return np.asarray(same & (ratio > 0.5) & (ratio < 2.0) & (lasting < 1.0))


def touch_at_end(passes: Passes, hub_angle: Array) -> Chosen:
    """Return whether a wire that lies on the bar at a given hub angle touches it with its end
    rather than its flank.
    """
    return np.abs(half_turn(hub_angle - passes.bar_angle)) > flank_window(passes)
