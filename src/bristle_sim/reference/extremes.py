"""Instants of a motion that are worth an event: largest retraction and highest relative speed of a rigid bristle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bristle_sim.reference.contacts import Bar
from bristle_sim.reference.crossing import crossings, nodes, of_one_sign
from bristle_sim.reference.log import LARGEST_RETRACTION, PEAK, STRIKE, Log
from bristle_sim.reference.system import State, System

__all__ = ["note_extremes"]

Reals = NDArray[np.float64]

ROUNDING = 1e-13


def note_extremes(
    system: System, log: Log, motion: Callable[[float], State], step: tuple[float, float], tolerance: float
) -> float | None:
    """Note where the first link lags most and its highest relative rate; return the time at which the run ends there.

    The hinges of a wire of several links vibrate: its first link has no single highest rate, and none is noted.
    """
    chain = system.chain

    def at(time: float) -> State:
        return system.closed(motion(time))

    def rate(times: Reals) -> Reals:
        return np.array([at(time).rates[0] - chain.speed for time in times.tolist()])

    def acceleration(times: Reals) -> Reals:
        return np.array([system.at(at(time)).balance.accelerations[0] for time in times.tolist()])

    for time, direction in _changes(rate, step, ROUNDING * system.fastest):
        if direction > 0:
            log.turned(at(time))
            if log.stop_after == LARGEST_RETRACTION:
                return time
    if chain.links > 1 or system.sustained or log.seen(PEAK) or log.seen(STRIKE) or _bar_ahead(system, log, step[0]):
        return None
    for time, direction in _changes(acceleration, step, ROUNDING * system.fastest**2):
        if direction < 0 and rate(np.array([time]))[0] > tolerance * system.fastest:
            log.event(PEAK, time)
            log.mark(time)
            return time if log.stop_after == PEAK else None
    return None


def _bar_ahead(system: System, log: Log, time: float) -> bool:
    """Whether an untouched bar is still within half a turn ahead of the root: the bristle has not been thrown yet."""
    bar = system.obstacles.get("bar")
    if not isinstance(bar, Bar) or log.seen("bar touch") or not system.chain.speed:
        return False
    return bool((bar.centre / system.chain.root(time)).imag > 0.0)


def _changes(
    function: Callable[[Reals], Reals], step: tuple[float, float], resolution: float
) -> list[tuple[float, int]]:
    """Return the changes of sign on a step; most steps have none, which the values at the nodes tell at once."""
    start, end = step
    if end <= start or of_one_sign(function(nodes(start, end)), resolution):
        return []
    return crossings(function, start, end, resolution)
