"""A touch of the bar: the impacts of many wires, and the motion of wires on the bar up to release.

Geometry gives the motion of a wire that lies on the bar. It leaves the bar where the contact force
falls to zero.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import Lying, half_turn, levers, locks, lying
from bristle_sim.passes.crossing import root
from bristle_sim.passes.flight import BOTH_ENDS, Samples, advance
from bristle_sim.passes.motion import FRACTIONS, Function
from bristle_sim.passes.state import (
    BAR,
    FLIES,
    FOLDS,
    LEAST,
    LOCKED,
    TOO_MANY,
    Chosen,
    Passes,
)
from bristle_sim.theory.impact_phases import JAM, resolve_phases

LOWEST_REBOUND = 1e-10
"""Height of a rebound from the bar, divided by the bristle's length, below which the wire stays on
the bar."""

MOST_TOUCHES = 3000  # most touches of the bar in a pass; a restitution near 1 gives endlessly many

ROUNDING = 1e-15  # rounding error of an angle that follows from geometry, rad


def touch_bar(passes: Passes, accuracy: float) -> Chosen:
    """Resolve the impacts of wires on the bar, and return the code of each pass's new state.

    If a wire stays on the bar, its motion is computed until it leaves the bar or the pass ends.
    """
    state = passes.hub_angle, passes.angle, passes.rate
    normal, tangential, approach, slip, side = levers(passes, *state)
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
    stays = (ending == FLIES) & (pressed > 0.0) & low
    ending[stays] = BAR
    passes.rate[stays] = held.rate[stays]
    slide(passes, side, ending, accuracy)
    passes.error[stays & (passes.error < 1.0)] = ROUNDING
    return ending


def comes_to_rest(
    passes: Passes, side: Array, at_end: Chosen, pressure: Array, lasting: Array
) -> Chosen:
    """Return whether each wire's rebounds from the bar die out while the wire is still pressed onto
    it.

    Such a wire is then treated as if it had never rebounded. Two conditions must hold when the hub
    has rotated by ``lasting``: the wire would touch the bar with the same part, flank or end, and
    the pressure has changed by less than a factor of two.

    Args:
        passes: passes of the wires.
        side: 1 for a wire behind the bar, and -1 for a wire ahead of it.
        at_end: whether a wire touches with its end rather than its flank.
        pressure: ``Lying.pressure`` at the present hub angle.
        lasting: upper bound of the hub's rotation during the rebounds, rad.
    """
    ahead = passes.hub_angle + np.minimum(lasting, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = lying(passes, ahead, side, at_end).pressure / pressure
    same = touch_at_end(passes, ahead) == at_end
    return np.asarray(same & (ratio > 0.5) & (ratio < 2.0) & (lasting < 1.0))


def touch_at_end(passes: Passes, hub_angle: Array) -> Chosen:
    """Return whether each wire that lies on the bar touches it with its end rather than its flank."""
    return np.abs(half_turn(hub_angle - passes.bar_angle)) > passes.flank


def slide(passes: Passes, side: Array, code: Chosen, accuracy: float) -> None:
    """Advance the wires that lie on the bar to the end of the contact.

    Args:
        passes: passes of the wires.
        side: 1 for a wire behind the bar, and -1 for a wire ahead of it.
        code: code of each pass's state, ``BAR`` for the wires that lie on the bar; the state after
            the contact replaces it.
        accuracy: requested accuracy.
    """
    chi = half_turn(passes.hub_angle - passes.bar_angle)
    begin = passes.hub_angle - chi
    fresh = np.ones(passes.size, dtype=bool)
    for last, at_end in ((-passes.flank, True), (passes.flank, False), (passes.window, True)):
        going = np.flatnonzero((code == BAR) & (chi < last))
        if going.size:
            some = passes.take(going)
            some.hub_angle[:] = (begin + chi)[going]
            length = (last - chi)[going]
            code[going] = _lie(some, length, side[going], at_end, fresh[going], accuracy)
            passes.table[:, going] = some.table
            chi[going] = last[going]
            fresh[going] = False
    code[code == BAR] = FOLDS


def _lie(
    passes: Passes, length: Array, side: Array, at_end: bool, fresh: Chosen, accuracy: float
) -> Chosen:
    """Advance wires on the bar while they touch it either with their flanks alone or with their ends
    alone.

    If the pressure falls to zero within a segment, it is assumed not to rise above zero later in
    the same segment.

    Args:
        passes: passes of the wires; their states advance.
        length: rotation of the hub, rad.
        side: 1 for a wire behind the bar, and -1 for a wire ahead of it.
        at_end: whether the wires touch with their ends.
        fresh: whether the contact begins here. Its pressure is then known to be positive.
        accuracy: requested accuracy.

    Returns:
        The code of each pass's state, ``BAR`` for a contact that continues.
    """
    turns = FRACTIONS * length
    found = lying(passes, passes.hub_angle + turns, side, at_end)
    stops = found.pressure <= 0.0
    stops[0] &= ~fresh
    jams = np.zeros_like(stops)
    if passes.bar_friction.any():
        jams = locks(passes, passes.hub_angle + turns, found.angle, found.rate) & ~stops
    halts = stops | jams
    columns = np.arange(passes.size)
    at = np.where(halts.any(axis=0), halts.argmax(axis=0), len(turns) - 1)
    code = np.select([jams[at, columns], stops[at, columns]], [LOCKED, FLIES], BAR)
    place = turns[at, columns]

    def lying_of(numbers: Chosen) -> Callable[[Array], Lying]:
        some, own_side = passes.take(numbers), side[numbers]
        return lambda turn: lying(some, some.hub_angle + turn, own_side, at_end)

    released = np.flatnonzero((code == FLIES) & (at > 0))
    if released.size:

        def pressure_of(numbers: Chosen) -> Function:
            lies = lying_of(released[numbers])
            return lambda turn: (bounded_pressure(lies(turn)), None)

        ends = at[released] - 1 + BOTH_ENDS
        begin, end = turns[ends, released]
        before, after = bounded_pressure(found)[ends, released]
        guess = begin + (end - begin) * before / (before - after)
        place[released] = root(pressure_of, (begin, end), after, guess)

    samples = Samples(turns, found.angle, found.rate)
    advance(passes, lying_of, samples, np.arange(0), place, code, accuracy)
    passes.release[:] = passes.hub_angle
    passes.release_angle[:] = passes.angle
    return code


def bounded_pressure(motion: Lying) -> Array:
    """Return the pressure divided by 1 + |acceleration|, a bounded function with the same zeros.

    The pressure itself grows without bound where the wire points at the bar's centre.
    """
    return motion.pressure / (1.0 + np.abs(motion.acceleration))
