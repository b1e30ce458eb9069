"""Limits: the values of a key at which the outcome of a pass changes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.passes.result import Ensemble
from bristle_sim.studies.many_passes import SCENE, scene_pass, unable
from bristle_sim.units import shown

POINTS = 2000
"""Values at which the outcome is looked up first: a change and its return within a 2000th of the range are not seen."""

PARTS = 32  # of an interval with a change, in each round of the search

BESIDE = 1e-4  # distance from a change at which the scene confirms it, over the range

MOST_CHANGES = 200  # beyond which the outcome changes almost everywhere in the range


@dataclass(frozen=True, slots=True)
class Change:
    """A change of the outcome at the value ``at`` of a key, with the outcomes below and above it.

    ``confirmed``: whether the scene has these outcomes a ten-thousandth of the range below and
    above.
    """

    at: float
    below: str
    above: str
    confirmed: bool


def limits(
    tool: Tool | None = None, *, accuracy: float = 1e-8, **between: Any
) -> tuple[Change, ...]:
    """Return all values of a key, ascending, at which the outcome of the pass changes.

    From which friction on does the tip stick?

    >>> import bristle_sim as bs
    >>> [(round(change.at, 4), change.above) for change in bs.limits(friction=(0.1, 0.6))]
    [(0.4619, 'sticks and rebounds')]

    Args:
        tool: has the values of the other keys; by default the dissertation's tool.
        accuracy: of the passes, and of the limits as a fraction of the range.
        between: one key with the two ends of the range, numbers in SI units or texts with a unit.

    Raises:
        ValueError: for a tool whose passes are not computed in arrays, for anything but one key
            with two different ends, a key or value that is refused, or more than 200 changes.
    """
    tool = Tool() if tool is None else tool
    if reason := unable(tool):
        raise ValueError(f"{reason}: must be a straight rigid bristle with the energetic law")
    if len(between) != 1:
        raise ValueError(f"limits of {', '.join(between) or 'no key'}: must be those of one key")
    ((key, ends),) = between.items()
    if not isinstance(ends, list | tuple) or len(ends) != 2:
        raise ValueError(f"{key} = {shown(ends)}: must be the two ends of a range")

    def passes(values: Any) -> Ensemble:
        given: dict[str, Any] = {key: values}
        return ensemble(tool, accuracy=accuracy, **given)

    first, last = np.sort(passes(list(ends)).keys[key]).tolist()
    if not first < last < math.inf or first == -math.inf:
        raise ValueError(f"{key} = {shown(ends)}: must be two different finite ends of a range")
    points = np.linspace(first, last, POINTS + 1)[np.newaxis]
    while True:
        lows, highs, words = _changes(points, passes(points).outcome)
        if len(lows) > MOST_CHANGES:
            raise ValueError(
                f"{key} = {shown(ends)}: must be a range with at most {MOST_CHANGES} changes of the outcome"
            )
        width = np.maximum(accuracy * (last - first), np.spacing(np.abs(highs)) * PARTS)
        if (highs - lows <= width).all():
            middles = 0.5 * (lows + highs)
            beside = _beside(middles, first, last)
            found = []
            for at, pair, sides in zip(middles.tolist(), words, beside.tolist(), strict=True):
                own = [scene_pass(tool.replace(**{key: each}), SCENE)[0] for each in sides]
                found.append(Change(at, *pair, confirmed=own == list(pair)))
            return tuple(found)
        points = lows[:, np.newaxis] + (highs - lows)[:, np.newaxis] * np.linspace(
            0.0, 1.0, PARTS + 1
        )


def _beside(places: Array, first: float, last: float) -> Array:
    """Return values below and above each place, BESIDE of the range away, nearer where the next
    place is near."""
    gaps = np.diff(places, prepend=first, append=last)
    steps = np.minimum(BESIDE * (last - first), 0.25 * np.stack([gaps[:-1], gaps[1:]]))
    return np.asarray((places + steps * [[-1.0], [1.0]]).T)


def _changes(points: Array, outcome: Any) -> tuple[Array, Array, list[tuple[str, str]]]:
    """Return the neighbouring points of each row whose outcomes differ, lower and upper ones, and those outcomes."""
    row, place = np.nonzero(outcome[:, 1:] != outcome[:, :-1])
    pairs = zip(outcome[row, place].tolist(), outcome[row, place + 1].tolist(), strict=True)
    return points[row, place], points[row, place + 1], list(pairs)
