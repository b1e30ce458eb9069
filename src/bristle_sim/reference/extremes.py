"""Instants of a motion that are worth an event: largest retraction and highest relative speed of a rigid bristle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.reference.contacts import Bar
from bristle_sim.reference.crossing import crossings, of_one_sign
from bristle_sim.reference.log import LARGEST_RETRACTION, PEAK, STRIKE, Log, Record
from bristle_sim.reference.system import Instant, State, System

Motion = Callable[[Array], list[State]]
"""Times, s -> states."""

ROUNDING = 1e-13  # rounding of a rate, as a fraction of the fastest one
IDLE = 1e-12  # a highest relative rate below this fraction of the fastest one is no motion


def note_extremes(
    system: System, log: Log, own: Record, motion: Motion, instants: list[Instant], step: tuple[float, float]
) -> float | None:
    """Note where a wire's first link lags most and its highest relative rate; return the time at which the run ends there.

    ``own`` is the wire's record. The hinges of a wire of several links vibrate: its first link has no single highest rate, and none is noted.
    ``instants`` are those at the nodes of the integrator's step; the motion is looked at in ``step``, s.
    """
    chain, link = own.chain, own.first

    def rate(at: Instant) -> float:
        return float(at.state.rates[link] - chain.speed)

    def acceleration(at: Instant) -> float:
        return float(at.balance.accelerations[link])

    def changes(value: Callable[[Instant], float], resolution: float) -> list[tuple[float, int]]:
        if step[1] <= step[0] or of_one_sign(np.array([value(each) for each in instants]), resolution):
            return []
        along = lambda times: np.array([value(system.at(each)) for each in motion(times)])  # noqa: E731
        return crossings(along, *step, resolution)

    for time, direction in changes(rate, ROUNDING * system.fastest):
        if direction > 0:
            own.turned(motion(np.array([time]))[0])
            log.mark(time)
            if log.stop_after == LARGEST_RETRACTION:
                return time
    touched = any(each.touch.normal_row[link] for each in instants[0].contacts)
    if chain.links > 1 or touched or own.seen(PEAK) or own.seen(STRIKE) or _bar_ahead(system, own, step[0]):
        return None
    for time, direction in changes(acceleration, ROUNDING * system.fastest**2):
        if direction < 0 and rate(system.at(motion(np.array([time]))[0])) > IDLE * system.fastest:
            own.event(PEAK, time)
            log.mark(time)
            return time if log.stop_after == PEAK else None
    return None


def _bar_ahead(system: System, own: Record, time: float) -> bool:
    """Whether an untouched bar is still within half a turn ahead of the root: the bristle has not been thrown yet."""
    bar = system.obstacles.get("bar")
    if not isinstance(bar, Bar) or own.seen("bar touch") or not own.chain.speed:
        return False
    return bool((bar.centre / own.chain.root(time)).imag > 0.0)
