"""Slow motion: from the seconds of a film to the instants of a run, slower still around what matters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["TimeWarp", "slow_motion"]

Array = NDArray[np.float64]

LONGEST = 3600.0
"""Longest film, s."""

NODES = 4001
"""Enough for a bump of a thousandth of the run to be smooth."""


@dataclass(frozen=True, slots=True)
class TimeWarp:
    """Film time and physical time at the same nodes, both ascending, s; ``slow_down`` is the one's rate by the other."""

    film: Array
    physical: Array
    slow_down: Array

    def physical_time(self, film_time: ArrayLike) -> Array:
        """The run's instant that the film shows at a film time, s."""
        return np.asarray(np.interp(np.asarray(film_time), self.film, self.physical))

    def film_time(self, physical_time: ArrayLike) -> Array:
        """The film time at which an instant of the run is shown, s."""
        return np.asarray(np.interp(np.asarray(physical_time), self.physical, self.film))

    def slow_down_at(self, film_time: ArrayLike) -> Array:
        """How many seconds of film one second of the run takes, d film/d physical."""
        return np.asarray(np.interp(np.asarray(film_time), self.film, self.slow_down))


def slow_motion(
    start: float, end: float, duration: float, focus: Sequence[float] = (), *, slower: float = 4.0, width: float = 0.04
) -> TimeWarp:
    """Stretch a run from ``start`` to ``end`` over ``duration`` seconds of film.

    The slow-down is s(t) = s_0 (1 + (slower - 1) max_i exp(-((t - t_i)/w)^2/2)), with w = ``width`` (end - start) about
    each instant t_i of ``focus``, and s_0 such that its integral over the run is the duration.

    Raises:
        ValueError: if the run or the film lasts no time, or ``slower`` is less than 1.
    """
    if not end > start:
        raise ValueError(f"film of a run from {start:g} to {end:g}: a run that lasts some time is needed (in s)")
    if not 0.0 < duration <= LONGEST:
        raise ValueError(f"duration = {duration:g}: 0 < duration <= {LONGEST:g} is allowed (in s)")
    if not 1.0 <= slower < np.inf:
        raise ValueError(f"slower = {slower:g}: a finite factor of at least 1 is allowed (dimensionless)")
    physical = np.linspace(start, end, NODES)
    bump = np.zeros_like(physical)
    for instant in focus:
        bump = np.maximum(bump, np.exp(-0.5 * ((physical - instant) / (width * (end - start))) ** 2))
    shape = 1.0 + (slower - 1.0) * bump
    steps = 0.5 * (shape[1:] + shape[:-1]) * np.diff(physical)
    elapsed = np.concatenate([[0.0], np.cumsum(steps)])
    return TimeWarp(elapsed * (duration / elapsed[-1]), physical, shape * (duration / elapsed[-1]))
