"""Limits: the values of a parameter at which the outcome of a pass changes, for example from a
rebound to a miss. A pass is the trip of one bristle past bar and workpart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.parameters import KEYS, Tool
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.studies.many_passes import SCENE, checked_range, scene_pass
from bristle_sim.units import shown

POINTS = 2000
"""Number of intervals into which the range is divided first. Two opposite changes of the outcome
within one interval are not found."""

PARTS = 32  # number of parts into which an interval with a change is divided in each iteration

# Distance from a change at which simulations confirm it, as a fraction of the searched range.
BESIDE = 1e-4

MOST_CHANGES = 200  # largest number of changes; with more, the outcome changes almost everywhere


@dataclass(frozen=True, slots=True)
class Change:
    """A change of the outcome of a bristle's pass at a value of a parameter.

    Attributes:
        at: the value of the parameter, in SI units.
        below: outcome below the value.
        above: outcome above the value.
        confirmed: whether simulations just below and just above the value have these outcomes. The
            simulated values differ from ``at`` by a ten-thousandth of the searched range, or by
            less if another change is near.
    """

    at: float
    below: str
    above: str
    confirmed: bool


def limits(
    tool: Tool | None = None, *, accuracy: float = 1e-8, **between: Any
) -> tuple[Change, ...]:
    """Return all values of a parameter at which the outcome of a bristle's pass changes, in
    ascending order.

    At which coefficient of friction does the tip begin to stick?

    >>> import bristle_sim as bs
    >>> [(round(change.at, 4), change.above) for change in bs.limits(friction=(0.1, 0.6))]
    [(0.4619, 'sticks and rebounds')]

    Args:
        tool: the tool that gives the values of all other parameters; by default the dissertation's.
        accuracy: relative accuracy of the passes. The changes are located to within this fraction
            of the range.
        between: one parameter by name, with the lower and upper bound of its range, as numbers in
            SI units or texts with a unit.

    Returns:
        The changes of the outcome.

    Raises:
        ValueError: if the tool's passes cannot be computed as arrays; if not exactly one parameter
            with two different bounds is given; if the name or a value is invalid; or for more than
            200 changes.
    """
    tool = Tool() if tool is None else tool
    if len(between) != 1:
        raise ValueError(f"limits of {', '.join(between) or 'no key'}: must be those of one key")
    ((key, ends),) = between.items()
    first, last = checked_range(tool, key, ends)
    points = np.linspace(first, last, POINTS + 1)[np.newaxis]
    while True:
        given: dict[str, Any] = {key: points}
        outcome = ensemble(tool, accuracy=accuracy, **given).outcome
        row, place = np.nonzero(outcome[:, 1:] != outcome[:, :-1])
        lows = points[row, place]
        highs = points[row, place + 1]
        if len(lows) > MOST_CHANGES:
            raise ValueError(
                f"{key} = {shown(ends)}: must be a range with at most {MOST_CHANGES} changes of the outcome"
            )
        width = np.maximum(accuracy * (last - first), np.spacing(np.abs(highs)) * PARTS)
        if (highs - lows <= width).all():
            break
        points = np.linspace(lows, highs, PARTS + 1, axis=1)
    # Changes that are closer to each other than the accuracy count as one.
    begins = lows - np.append(-np.inf, highs)[:-1] > width
    ends_here = np.append(begins, True)[1:]
    lows = lows[begins]
    highs = highs[ends_here]
    below = outcome[row, place][begins].tolist()
    above = outcome[row, place + 1][ends_here].tolist()
    places = 0.5 * (lows + highs)
    gaps = np.diff(places, prepend=first, append=last)
    steps = np.minimum(BESIDE * (last - first), 0.25 * np.stack([gaps[:-1], gaps[1:]]))
    sides = np.minimum(places - steps[0], lows), np.maximum(places + steps[1], highs)
    found = []
    for at, pair, beside in zip(
        places.tolist(), zip(below, above, strict=True), np.transpose(sides), strict=True
    ):
        own = tuple(scene_pass(tool, SCENE, {key: float(each)})[0] for each in beside)
        found.append(Change(at, *pair, confirmed=own == pair))
    return tuple(found)


def limits_in_words(
    tool: Tool, key: str, ends: Any, accuracy: float = 1e-8
) -> tuple[str, tuple[Change, ...]]:
    """Return a sentence on the changes of the outcome between two values of a parameter.

    Args:
        tool: the tool that gives the values of all other parameters.
        key: name of the parameter.
        ends: lower and upper bound of its range, or a text ``FROM:TO``.
        accuracy: relative accuracy of the passes.

    Returns:
        The sentence.
        The changes, in ascending order.
    """
    between: dict[str, Any] = {key: checked_range(tool, key, ends)}
    changes = limits(tool, accuracy=accuracy, **between)
    declared = KEYS[key]
    low, high = map(declared.displayed, between[key])
    places = [
        f"at {declared.displayed(each.at)} (below: {each.below}, above: {each.above})"
        for each in changes
    ]
    doubtful = [declared.displayed(each.at) for each in changes if not each.confirmed]
    scene = f"does not confirm {', '.join(doubtful)}" if doubtful else "agrees on both sides"
    words = f"changes {', '.join(places)}; the time-domain simulation {scene}"
    words = words if places else "does not change"
    return f"For {key} from {low} to {high} the outcome {words}.", changes
