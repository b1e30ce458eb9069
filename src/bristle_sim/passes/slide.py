"""Motion of wires on the bar: geometry gives it, and it ends where the contact force falls to zero."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import Lying, locks, lying
from bristle_sim.passes.crossing import Function, root
from bristle_sim.passes.flight import WORKPART, clearance
from bristle_sim.passes.motion import pose_of
from bristle_sim.passes.state import Chosen, Passes

SAMPLES = 12
"""Number of equal parts of the turn in which a wire lies on the bar with its flank, or with its
end.

In one part a pressure that falls to zero does not rise again, by assumption."""

FRACTIONS = np.linspace(0.0, 1.0, SAMPLES + 1)[:, np.newaxis]

RELEASED, STRIKES, JAMMED, FOLDED = range(4)
"""Codes of the ends of a contact: no force is left, the tip reaches the workpart, friction locks
it, the wire folds back."""

Measure = Callable[[Passes, Array, Lying], Array]


def slide(passes: Passes, side: Array) -> Chosen:
    """Advance wires that lie on the bar to the end of the contact, and return the code of this end."""
    chi = np.remainder(passes.hub_angle - passes.bar_angle + np.pi, 2.0 * np.pi) - np.pi
    turned = passes.hub_angle - chi
    flank = _flank(passes)
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
            hub = turned[going] + first[going] + FRACTIONS * (last[going] - first[going])
            ending[going] = _piece(some, hub, side[going], at_end, fresh[going])
            fresh[going] = False
            passes.put(going, some)
    return np.where(ending < 0, FOLDED, ending)


def _flank(passes: Passes) -> Array:
    """Return the largest |chi| at which the bar touches the flank, D^2 = 1 + R^2, rad."""
    room = passes.radius**2 + passes.bar_distance**2 - 1.0 - passes.reach**2
    double = 2.0 * passes.radius * passes.bar_distance
    cosine = np.divide(room, double, out=np.where(room > 0.0, 1.0, -1.0), where=double > 0.0)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _piece(passes: Passes, hub: Array, side: Array, at_end: bool, fresh: Chosen) -> Chosen:
    """Follow wires over hub angles up to the end of the contact.

    The contact of a ``fresh`` wire has just been found to press.

    Returns:
        Codes of the ends of the contacts; -1 for a contact that continues.
    """
    ends = np.full(passes.size, at_end)
    motion = lying(passes, hub, side, ends)
    stops = motion.pressure <= 0.0
    stops[0] &= ~fresh
    folds = np.abs(motion.angle) > 0.5 * np.pi
    heights = _height(passes, hub, motion)
    strikes = heights <= 0.0
    jams = np.zeros_like(stops)
    if passes.bar_friction.any():
        jams = locks(passes, hub, motion.angle, motion.rate) & (motion.pressure > 0.0)
    halts = stops | folds | strikes | jams
    ended = halts.any(axis=0)
    at = np.where(ended, halts.argmax(axis=0), SAMPLES)
    columns = np.arange(passes.size)
    how = np.select([jams[at, columns], folds[at, columns]], [JAMMED, FOLDED], RELEASED)
    place = hub[at, columns]
    for ending, reached, values, measure in (
        (RELEASED, stops, motion.pressure, _pressure),
        (STRIKES, strikes, heights, _height),
    ):
        between = np.flatnonzero(ended & (how < JAMMED) & reached[at, columns])
        inside = between[at[between] > 0]

        def measure_of(
            numbers: Chosen, chosen: Chosen = inside, measure: Measure = measure
        ) -> Function:
            """Return the measure of the wires with some numbers as a function of the hub angle."""
            some, own_side, own_end = _some(passes, side, ends, chosen[numbers])
            return lambda where: measure(some, where, lying(some, where, own_side, own_end))

        part = at[inside]
        brackets = (hub[part - 1, inside], hub[part, inside])
        located = place.copy()
        located[inside] = root(
            measure_of, brackets, (values[part - 1, inside], values[part, inside])
        )
        first = between[
            (located[between] < place[between]) | ~(stops & strikes)[at[between], between]
        ]
        how[first] = ending
        place[first] = located[first]
    _note_retraction(passes, hub, motion.rate, place, side, ends)
    found = lying(passes, place, side, ends)
    passes.hub_angle = place
    passes.angle = found.angle
    passes.rate = found.rate
    passes.release = place.copy()
    passes.release_angle = found.angle.copy()
    passes.lowest = np.minimum(passes.lowest, found.angle)
    return np.where(ended, how, -1)


def _pressure(_passes: Passes, _hub_angle: Array, motion: Lying) -> Array:
    return motion.pressure


def _height(passes: Passes, hub_angle: Array, motion: Lying) -> Array:
    """Return the height of the tip above the workpart, over the bristle's length."""
    return clearance(WORKPART, passes, pose_of(hub_angle, motion.angle, motion.rate))[0]


def _note_retraction(
    passes: Passes, hub: Array, rates: Array, place: Array, side: Array, ends: Chosen
) -> None:
    """Record the least angle at a minimum on the bar before the contact ends."""
    turning = (rates[:-1] < 0.0) & (rates[1:] > 0.0) & (hub[:-1] < place)
    number = np.flatnonzero(turning.any(axis=0))
    if number.size:
        part = turning[:, number].argmax(axis=0)

        def rate_of(numbers: Chosen) -> Function:
            some, own_side, own_end = _some(passes, side, ends, number[numbers])
            return lambda place: lying(some, place, own_side, own_end).rate

        brackets = (hub[part, number], hub[part + 1, number])
        values = (rates[part, number], rates[part + 1, number])
        at = np.minimum(root(rate_of, brackets, values), place[number])
        some, own_side, own_end = _some(passes, side, ends, number)
        least = lying(some, at, own_side, own_end).angle
        passes.lowest[number] = np.minimum(passes.lowest[number], least)


def _some(
    passes: Passes, side: Array, ends: Chosen, chosen: Chosen
) -> tuple[Passes, Array, Chosen]:
    """Return the chosen wires on the bar, with their sides and ends."""
    return passes.take(chosen), side[chosen], ends[chosen]
