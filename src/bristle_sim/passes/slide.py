"""Motion of wires that lie on the bar. Geometry gives the motion, and the wire leaves the bar where
the contact force falls to zero.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import Lying, flank_window, half_turn, locks, lying
from bristle_sim.passes.crossing import root
from bristle_sim.passes.flight import (
    BOTH_ENDS,
    Samples,
    first_closing,
    low,
    note_retraction,
)
from bristle_sim.passes.motion import FRACTIONS, Function
from bristle_sim.passes.state import (
    BAR,
    FLIES,
    FOLDS,
    LOCKED,
    QUARTER_TURN,
    WORKPART,
    Chosen,
    Passes,
)


def slide(passes: Passes, side: Array) -> Chosen:
    """Advance wires that lie on the bar to the end of the contact, and return the code of each
    pass's state there.
    """
    chi = half_turn(passes.hub_angle - passes.bar_angle)
    flank = flank_window(passes)
    ending = np.full(passes.size, BAR)
    fresh = np.ones(passes.size, dtype=bool)
    begin = passes.hub_angle - chi
    for first, last, at_end in (
        (chi, -flank, True),
        (np.maximum(chi, -flank), flank, False),
        (np.maximum(chi, flank), passes.window, True),
    ):
        going = np.flatnonzero((ending == BAR) & (first < last))
        if going.size:
            some = passes.take(going)
            some.hub_angle[:] = (begin + first)[going]
            ending[going] = _piece(some, (last - first)[going], side[going], at_end, fresh[going])
            fresh[going] = False
            passes.put(going, some)
    return np.where(ending == BAR, FOLDS, ending)


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
        The code of each pass's state, ``BAR`` for a contact that continues.
    """
    turns = FRACTIONS * length
    found = lying(passes, passes.hub_angle + turns, side, at_end)
    samples = Samples(turns, found.angle, found.rate)
    stops = found.pressure <= 0.0
    stops[0] &= ~fresh
    folds = np.abs(found.angle) > QUARTER_TURN
    jams = np.zeros_like(stops)
    if passes.bar_friction.any():
        jams = locks(passes, passes.hub_angle + turns, found.angle, found.rate)
        jams &= found.pressure > 0.0
    halts = stops | folds | jams
    columns = np.arange(passes.size)
    at = np.where(halts.any(axis=0), halts.argmax(axis=0), len(turns) - 1)
    how = np.select(
        [each[at, columns] for each in (jams, folds, stops)], [LOCKED, FOLDS, FLIES], BAR
    )
    place = turns[at, columns]

    def lying_of(numbers: Chosen) -> Callable[[Array], Lying]:
        some, own_side = passes.take(numbers), side[numbers]
        return lambda turn: lying(some, some.hub_angle + turn, own_side, at_end)

    released = np.flatnonzero((how == FLIES) & (at > 0))
    if released.size:

        def pressure_of(numbers: Chosen) -> Function:
            lies = lying_of(released[numbers])
            return lambda turn: (bounded_pressure(lies(turn)), None)

        ends = at[released] - 1 + BOTH_ENDS
        begin, end = turns[ends, released]
        before, after = bounded_pressure(found)[ends, released]
        guess = begin + (end - begin) * before / (before - after)
        place[released] = root(pressure_of, (begin, end), after, guess)

    leaving = np.zeros(passes.size, dtype=bool)
    strike, _ = first_closing(WORKPART, passes, lying_of, samples, low(passes, samples), leaving)
    how[strike <= place] = WORKPART
    place = np.minimum(place, strike)
    note_retraction(passes, lying_of, samples, place)
    passes.angle[:], passes.rate[:] = lying_of(columns)(place)[:2]
    np.minimum(passes.lowest, passes.angle, out=passes.lowest)
    passes.hub_angle += place
    passes.release[:] = passes.hub_angle
    passes.release_angle[:] = passes.angle
    return how


def bounded_pressure(motion: Lying) -> Array:
    """Return the pressure over the acceleration, which grows without bound where the wire points at
    the bar's centre.
    """
    return motion.pressure / (1.0 + np.abs(motion.acceleration))
