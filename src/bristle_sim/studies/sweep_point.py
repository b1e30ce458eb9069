"""The outcome of a sweep's points; worker processes import this module alone."""

import functools
import pickle
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from bristle_sim.arrays import Array

Function = Callable[..., Any]
Point = tuple[int, dict[str, Any]]  # index of a point in its grid, and its arguments
Outcome = tuple[
    dict[str, Array], str
]  # results of a point by name, and the reason why results are missing, or an empty text
FAILURE = "failure"  # Name of the variable with the reason why a point lacks results

# Time after which a worker returns the points that it has finished, s. If it is killed, the points that it has not
# returned are lost.
TURN = 0.3


def evaluate_points(function: Function | bytes, points: bytes) -> list[Outcome]:
    """Evaluate points for TURN seconds, at least one point, and return the outcomes of the finished
    points.

    The points are pickled, since Dask would search a list of points for its futures. The function
    may be pickled too.
    """
    called = _unpickled(function) if isinstance(function, bytes) else function
    end = time.perf_counter() + TURN
    outcomes = list[Outcome]()
    for _, arguments in pickle.loads(points):
        outcomes.append(outcome_of(called, arguments))
        if time.perf_counter() > end:
            break
    return outcomes


@functools.lru_cache(maxsize=1)
def _unpickled(function: bytes) -> Any:
    """Return the unpickled function of a sweep; a worker unpickles it once for all its batches."""
    return pickle.loads(function)


def outcome_of(function: Function, arguments: dict[str, Any]) -> Outcome:
    """Return the results of a function, or the reason why it raised an error.

    The reason is the message of a ValueError; the message of another error follows its type.
    """
    try:
        result = function(**arguments)
        named = dict(result) if isinstance(result, Mapping) else {"result": result}
        reason = _readable(named.pop(FAILURE, ""))
        return {str(name): np.asarray(value, dtype=float) for name, value in named.items()}, reason
    except (Exception, SystemExit) as error:
        reason = _readable(error)
        if isinstance(error, AttributeError) and error.obj is None:
            reason = f"{error.name} was read of None; first_contact is None in a run without that contact"
        elif not reason or not isinstance(error, ValueError):
            reason = f"{type(error).__name__}: {reason}"
        return {}, reason


def _readable(reason: Any) -> str:
    """Return a reason as one line that every file and terminal can encode."""
    try:
        return " ".join(str(reason).encode(errors="backslashreplace").decode().split())
    except Exception:
        return "its message cannot be read"
