"""Motion of wires that lie on the bar. Geometry gives the motion, and the wire leaves the bar where
the contact force falls to zero.
"""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import flank_window, half_turn, locks, lying
from bristle_sim.passes.crossing import Function, root
from bristle_sim.passes.flight import WORKPART, Gap, clearance, first_closing
from bristle_sim.passes.motion import FRACTIONS, INTERVALS, pose_of
from bristle_sim.passes.state import Chosen, Passes

RELEASED, STRIKES, JAMMED, FOLDED = range(4)
"""Codes of the cause that ends a contact with the bar: the force falls to zero, the tip reaches the
workpart, friction locks the wire, or the wire folds by a quarter turn."""


def slide(passes: Passes, side: Array) -> Chosen:
    """Advance wires that lie on the bar to the end of the contact, and return the code of the cause
    of this end.
    """
    chi = half_turn(passes.hub_angle - passes.bar_angle)
    flank = flank_window(passes)
    ending = np.full(passes.size, -1)
    fresh = np.ones(passes.size, dtype=bool)
    pieces = (
        (chi, -flank, True),
        (np.maximum(chi, -flank), flank, False),
        (np.maximum(chi, flank), passes.window, True),
    )
    for first, last, at_end in pieces:
        going = np.flatnonzero((ending < 0) & (first < last))
        if going.size:
            some = passes.take(going)
            some.hub_angle += (first - chi)[going]
            length = (last - first)[going]
            ending[going] = _piece(some, length, side[going], at_end, fresh[going])
            fresh[going] = False
            chi[going] += some.hub_angle - passes.hub_angle[going]
            passes.put(going, some)
    return np.where(ending < 0, FOLDED, ending)


def _piece(passes: Passes, length: Array, side: Array, at_end: bool, fresh: Chosen) -> Chosen:
    """Follow wires on the bar over a turn of the hub in which they touch with their flanks alone or
    with their ends alone.

    In one segment of the turn a pressure that falls to zero is assumed not to rise again.

    Args:
        passes: passes of the wires; their states advance.
        length: turn of the hub, rad.
        side: 1 for a wire behind the bar, and -1 for a wire ahead of it.
        at_end: whether the wires touch with their ends.
        fresh: whether a wire begins here, where its pressure is known to be positive.

    Returns:
        The code of the cause that ends each contact, or -1 for a contact that continues.
    """
    start = passes.hub_angle
    turns = FRACTIONS * length
    hub = start + turns
    motion = lying(passes, hub, side, at_end)
    stops = motion.pressure <= 0.0
    stops[0] &= ~fresh
    folds = np.abs(motion.angle) > 0.5 * np.pi
    jams = np.zeros_like(stops)
    if passes.bar_friction.any():
        jams = locks(passes, hub, motion.angle, motion.rate) & (motion.pressure > 0.0)
    halts = stops | folds | jams
    columns = np.arange(passes.size)
    at = np.where(halts.any(axis=0), halts.argmax(axis=0), INTERVALS)
    how = np.select(
        [each[at, columns] for each in (jams, folds, stops)], [JAMMED, FOLDED, RELEASED], -1
    )
    place = turns[at, columns]

    released = np.flatnonzero((how == RELEASED) & (at > 0))
    if released.size:

        def pressure_of(numbers: Chosen) -> Function:
            chosen = released[numbers]
            some, own_side = passes.take(chosen), side[chosen]
            return lambda turn: (
                lying(some, some.hub_angle + turn, own_side, at_end).pressure,
                None,
            )

        part = at[released]
        low, high = turns[part - 1, released], turns[part, released]
        before, after = motion.pressure[part - 1, released], motion.pressure[part, released]
        guess = low + (high - low) * before / (before - after)
        place[released] = root(pressure_of, (low, high), after, guess)

    def height_of(numbers: Chosen) -> Gap:
        some, own_side = passes.take(numbers), side[numbers]

        def height(turn: Array) -> tuple[Array, Array]:
            angle = some.hub_angle + turn
            own = lying(some, angle, own_side, at_end)
            return clearance(WORKPART, some, pose_of(angle, own.angle, own.rate))

        return height

    heights = clearance(WORKPART, passes, pose_of(hub, motion.angle, motion.rate))
    strike = first_closing(height_of, *heights, length, np.zeros(passes.size, dtype=bool))
    strikes = strike.place <= place
    how[strikes] = STRIKES
    place[strikes] = strike.place[strikes]

    _note_retraction(passes, turns, motion.rate, place, side, at_end)
    found = lying(passes, start + place, side, at_end)
    passes.hub_angle = start + place
    passes.angle = found.angle
    passes.rate = found.rate
    passes.release = passes.hub_angle.copy()
    passes.release_angle = found.angle.copy()
    passes.lowest = np.minimum(passes.lowest, found.angle)
    return how


def _note_retraction(
    passes: Passes, turns: Array, rates: Array, place: Array, side: Array, at_end: bool
) -> None:
    """Update the least relative angle of each pass by its minimum on the bar before the contact
    ends.
    """
    turning = (rates[:-1] < 0.0) & (rates[1:] > 0.0) & (turns[:-1] < place)
    number = np.flatnonzero(turning.any(axis=0))
    if number.size:
        part = turning[:, number].argmax(axis=0)
        low, high = turns[part, number], turns[part + 1, number]
        before, after = rates[part, number], rates[part + 1, number]

        def turning_of(numbers: Chosen) -> Function:
            chosen = number[numbers]
            some, own_side = passes.take(chosen), side[chosen]

            def rate(turn: Array) -> tuple[Array, Array]:
                motion = lying(some, some.hub_angle + turn, own_side, at_end)
                return motion.rate, motion.acceleration

            return rate

        guess = low + (high - low) * before / (before - after)
        at = np.minimum(root(turning_of, (low, high), after, guess), place[number])
        some = passes.take(number)
        least = lying(some, some.hub_angle + at, side[number], at_end).angle
        passes.lowest[number] = np.minimum(passes.lowest[number], least)
