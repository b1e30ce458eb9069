"""Impacts of many wires on the bar, and their motion on the bar up to the release.

Geometry gives the motion of a wire that lies on the bar. The wire leaves the bar where the contact
force falls to zero.
"""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import Lying, half_turn, levers, locks, lying
from bristle_sim.passes.crossing import root
from bristle_sim.passes.flight import BOTH_ENDS, EDGE, advance
from bristle_sim.passes.motion import FRACTIONS
from bristle_sim.passes.state import (
    FLIES,
    FOLDS,
    LEAST,
    LIES,
    LOCKED,
    TOO_MANY,
    Chosen,
    Passes,
)
from bristle_sim.theory.impact_phases import JAM, resolve_phases

# Largest number of touches of the bar in a pass. With a restitution near 1 there is no other bound.
MOST_TOUCHES = 3000

HEIGHT_ROUNDING = 1e-14
"""Height of the lowest rebound whose gap exceeds rounding error, divided by the bristle's length."""

ROUNDING = 1e-15  # rounding error of an angle that follows from geometry, rad


def touch_bar(passes: Passes, accuracy: float) -> Chosen:
    """Resolve the impacts of wires on the bar, and return the code of each pass's new state."""
    state = passes.hub_angle, passes.angle, passes.rate
    normal, tangential, approach, slip, passes.side[:] = levers(passes, *state)
    friction, restitution = passes.bar_friction, passes.bar_restitution
    inverse_mass = (normal * normal, normal * tangential, tangential * tangential)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        hit = resolve_phases(*inverse_mass, approach, slip, friction, restitution, friction)
    passes.rate += normal * hit.impulse_normal + tangential * hit.impulse_tangential
    passes.touches += 1.0
    passes.release[:], passes.release_angle[:] = passes.hub_angle, passes.angle
    ending = np.where(passes.touches > MOST_TOUCHES, TOO_MANY, FLIES)
    ending[hit.outcome == JAM] = LOCKED

    at_end = touch_at_end(passes, passes.hub_angle)
    on_bar = lying(passes, passes.hub_angle, at_end)
    parting = np.maximum(hit.velocity_normal, 0.0)
    pressed = np.abs(normal) * on_bar.pressure
    speed = np.maximum(-approach, LEAST)
    # An error of the angle shifts the touch, and so changes the rate.
    amplified = (1.0 + restitution) * np.abs(pressed) / (speed * passes.rate_scale)
    passes.error[:] = np.minimum(passes.error * (1.0 + amplified), 1.0)  # 1: any uncertainty
    # Without the bar the overlap would stay within the accuracy, and the gap would open again.
    passes.error[approach**2 < -2.0 * pressed * accuracy] = 1.0
    # A rebound with the speed v is v^2/(2 a) high and lasts 2 v/a.
    hops = (pressed > 0.0) & (parting**2 > 2.0 * HEIGHT_ROUNDING * pressed)
    passes.hop[:] = np.inf
    np.divide(2.0 * parting, pressed, out=passes.hop, where=hops)
    # All rebounds that follow last 2 v/(a (1 - e)) together, here twice that time.
    lost = pressed * (1.0 - parting / speed)
    lasting = np.divide(4.0 * parting, lost, out=np.ones_like(lost), where=lost > 0.0)
    stays = comes_to_rest(passes, at_end, on_bar.pressure, lasting)
    stays &= (ending == FLIES) & (pressed > 0.0)
    ending[stays] = LIES
    passes.rate[stays] = on_bar.rate[stays]
    return ending


def comes_to_rest(passes: Passes, at_end: Chosen, pressure: Array, lasting: Array) -> Chosen:
    """Return whether each wire's rebounds die out while the wire is still pressed onto the bar.

    A wire whose rebounds die out is treated as if it had never rebounded. The rotation ``lasting``
    must be less than 1 rad. After this rotation a wire that lies on the bar must touch it with the
    same part, flank or end, and the pressure must have changed by less than a factor of two.

    Args:
        passes: passes of the wires.
        at_end: whether a wire touches with its end rather than its flank.
        pressure: ``Lying.pressure`` at the present hub angle.
        lasting: upper bound of the hub's rotation during the rebounds, rad.
    """
    ahead = passes.hub_angle + np.minimum(lasting, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = lying(passes, ahead, at_end).pressure / pressure
    same = touch_at_end(passes, ahead) == at_end
    return np.asarray(same & (ratio > 0.5) & (ratio < 2.0) & (lasting < 1.0))


def touch_at_end(passes: Passes, hub_angle: Array) -> Chosen:
    """Return whether each wire on the bar touches the bar with its end rather than its flank."""
    return np.abs(half_turn(hub_angle - passes.bar_angle)) > passes.flank


def lie(passes: Passes, accuracy: float) -> Chosen:
    """Advance wires that lie on the bar until the contact ends, or the bar touches another part of
    the wire.

    The pressure between wire and bar is computed at the ends of the contact's segments. Where the
    pressure is positive at both ends of a segment, it is assumed to be positive between them.

    Returns:
        The code of each pass's state after the advance. The code is ``LIES`` if another part of the
        wire now lies on the bar.
    """
    columns = np.arange(passes.size)
    chi = half_turn(passes.hub_angle - passes.bar_angle)
    # the bar touches the wire's end, then its flank, then its end again
    ends = np.array([-passes.flank, passes.flank, passes.window])
    part = np.minimum((ends <= chi + EDGE).sum(axis=0), 2)
    at_end = part != 1
    turns = FRACTIONS * np.maximum(ends[part, columns] - chi, 0.0)
    found = lying(passes, passes.hub_angle + turns, at_end)
    stops = found.pressure <= 0.0
    jams = np.zeros_like(stops)
    if passes.bar_friction.any():
        jams = locks(passes, passes.hub_angle + turns, found.angle, found.rate) & ~stops
    halts = stops | jams
    at = np.where(halts.any(axis=0), halts.argmax(axis=0), len(turns) - 1)
    going_on = np.where(part == 2, FOLDS, LIES)
    code = np.select([jams[at, columns], stops[at, columns]], [LOCKED, FLIES], going_on)
    place = turns[at, columns]

    def lying_at(turn: Array, numbers: Chosen) -> Lying:
        some = passes.take(numbers)
        return lying(some, some.hub_angle + turn, at_end[numbers])

    def pressure_at(turn: Array, numbers: Chosen) -> tuple[Array, None]:
        return lying_at(turn, released[numbers]).pressure, None

    released = np.flatnonzero((code == FLIES) & (at > 0))
    if released.size:
        sides = at[released] - 1 + BOTH_ENDS
        begin, end = turns[sides, released]
        before, after = found.pressure[sides, released]
        guess = begin + (end - begin) * before / (before - after)
        place[released] = root(pressure_at, (begin, end), after, guess)

    samples = np.array([turns, found.angle, found.rate])
    advance(passes, lying_at, samples, np.arange(0), place, code, accuracy)
    passes.release[:] = passes.hub_angle
    passes.release_angle[:] = passes.angle
    passes.hop[:] = np.inf
    passes.error[passes.error < 1.0] = ROUNDING
    return code
