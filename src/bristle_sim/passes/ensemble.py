"""Passes of many tools at once, computed in blocks to limit the size of the arrays in memory."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.parameters import Tool
from bristle_sim.passes.flight import fly
from bristle_sim.passes.request import Request, passes_of, request_of
from bristle_sim.passes.result import QUANTITIES, Ensemble
from bristle_sim.passes.state import (
    BAR,
    FLIES,
    FOLDS,
    LIES,
    LOCKED,
    MISSED,
    TOO_MANY,
    WORKPART,
    Passes,
    joined,
)
from bristle_sim.passes.strike import JAMS, MISSES, OUTCOMES, REFUSED, strike
from bristle_sim.passes.touch import lie, touch_bar
from bristle_sim.settings import Settings

HUB_TURN = Settings().hub_turn

BLOCK = 1 << 14
"""Number of passes that begin together.

With fewer passes the overhead of a call exceeds its arithmetic. With more passes the arrays take
more memory, and little time is saved."""

LEAST_FLYING = BLOCK // 4
"""Number of passes under way below which the next block of passes begins.

It is also the number of ended passes that are evaluated together."""

ENDED = WORKPART  # smallest code of a pass that has ended

UNCERTAIN = 1.0
"""Error estimate of a pass for which an error as small as the accuracy could alter the number of
touches or the outcome."""

REASONS = {
    MISSED: "its tip stays above the workpart",
    LOCKED: "friction locks the wire on the bar",
    FOLDS: "it folds back by more than a quarter turn",
    TOO_MANY: "it taps the bar thousands of times",
}
UNTOUCHED = "the wire does not touch the bar"
OTHERWISE = "a change within the accuracy gives it another course or outcome"

STEPS = {FLIES: fly, BAR: touch_bar, LIES: lie}

Columns = dict[str, NDArray[Any]]
"""Arrays by name, with an entry for each pass of a request: its results, the code of its outcome,
and the reason why it has no strike or no valid result."""


def ensemble(
    tool: Tool | None = None,
    *,
    accuracy: float = 1e-8,
    hub_turn: float = HUB_TURN,
    progress: Callable[[float], None] | None = None,
    **values: Any,
) -> Ensemble:
    """Compute passes of straight rigid bristles for arrays of parameter values.

    A pass is computed up to and including the impact on the workpart.

    The law of impact is the energetic one. Between contacts the wire's angle alpha from the radial
    direction obeys

        I alpha'' + c alpha' + k_T alpha + m r_h (L/2) omega^2 sin alpha
            + m g (L/2) sin(psi + alpha) = 0,

    with the wire's mass m, length L and moment of inertia I about its root, the belt's stiffness
    k_T and damping c, the hub's radius r_h, angular velocity omega and angle psi, and gravity g.
    While the wire lies on the bar, its angle follows from the geometry. The wire leaves the bar
    where the normal force falls to zero. The method needs neither a physics engine nor a compiler.

    >>> import bristle_sim as bs
    >>> many = bs.ensemble(hub_speed=["2000 rpm", "2500 rpm", "3000 rpm"])
    >>> many.tip_speed_at_contact.round(1).tolist()
    [34.5, 37.9, 41.1]

    Args:
        tool: tool that supplies the values of all keys that are not among ``values``; by default
            the dissertation's tool.
        accuracy: requested relative accuracy, from 1e-11 to 0.1.
        hub_turn: rotation of the hub after which a pass ends, rad.
        progress: function that is called with the fraction of finished passes.
        values: values of the tool's keys, such as ``friction=[0.2, 0.3]`` or ``bar_horizontal="50
            mm"``. A value is a number in SI units or a text with a unit. The shapes of the arrays
            must broadcast against each other.

    Returns:
        The passes, in arrays of the broadcast shape. A tool whose values are out of range, or whose
        pass this method cannot compute, has the outcome *refused*, a reason, and NaN in place of
        numbers.

    Raises:
        ValueError: for an unknown key, a text that cannot be read as a value of its key, or shapes
            that do not broadcast.
    """
    checked = Settings(accuracy=accuracy, hub_turn=hub_turn)
    request = request_of(Tool() if tool is None else tool, values, checked.hub_turn)
    columns: Columns = {name: np.full(request.size, np.nan) for name in QUANTITIES}
    columns["outcome"] = np.full(request.size, REFUSED, dtype=np.int8)
    columns["reason"] = np.full(request.size, "", dtype=object)
    groups: dict[int, list[Passes]] = {code: [] for code in (*STEPS, ENDED)}
    sizes = dict.fromkeys(groups, 0)
    begun = 0
    while begun < request.size or any(sizes.values()):
        under_way = sum(sizes[code] for code in STEPS)
        if begun < request.size and under_way < LEAST_FLYING:
            last = min(begun + BLOCK, request.size)
            some, columns["reason"][begun:last] = passes_of(request, np.arange(begun, last))
            begun = last
        elif under_way and sizes[ENDED] < LEAST_FLYING:
            # the largest group goes on: calls for few passes cost as much as for many
            turn = max(STEPS, key=sizes.__getitem__)
            some = joined(groups[turn])
            groups[turn].clear()
            some.code[:] = STEPS[turn](some, checked.accuracy)
        else:
            some = joined(groups[ENDED])
            groups[ENDED].clear()
            _record(request, checked.accuracy, some, columns)
            some = some.take(np.arange(0))
        for code, group in groups.items():
            group.append(some.take(np.flatnonzero(np.minimum(some.code, ENDED) == code)))
            sizes[code] = sum(each.size for each in group)
        if progress is not None:
            progress((begun - sum(sizes[code] for code in STEPS)) / request.size)
    columns["outcome"] = np.array(OUTCOMES)[columns["outcome"]]
    shaped = {name: each.reshape(request.shape) for name, each in columns.items()}
    return Ensemble(keys=request.given, **shaped)


def _record(request: Request, accuracy: float, passes: Passes, columns: Columns) -> None:
    """Evaluate passes that have ended, and store their results in ``columns``."""
    reason = columns["reason"]
    for code, text in REASONS.items():
        reason[passes.number[passes.code == code].astype(int)] = text
    done = passes.take(np.flatnonzero(np.isin(passes.code, (MISSED, LOCKED, WORKPART))))
    numbers = done.number.astype(int)
    values = request.at(numbers)
    found = {
        "release_time": (done.release - done.start) / values["hub_speed"],
        "release_retraction": -done.release_angle,
        "largest_retraction": -done.lowest,
        "error_estimate": np.minimum(done.error, UNCERTAIN),
        "outcome": np.where(done.code == LOCKED, JAMS, MISSES),
    }
    for name, each in found.items():
        columns[name][numbers] = each
    struck = np.flatnonzero(done.code == WORKPART)
    if struck.size:
        own = {key: each[struck] for key, each in values.items()}
        for name, each in strike(done.take(struck), own, accuracy).items():
            columns[name][numbers[struck]] = each
    uncertain = columns["error_estimate"][numbers] >= UNCERTAIN
    for where, text in ((np.isnan(done.release), UNTOUCHED), (uncertain, OTHERWISE)):
        reason[numbers[where & (reason[numbers] == "")]] = text
