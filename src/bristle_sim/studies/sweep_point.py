"""The evaluation of a sweep's points. Worker processes import only this module."""

import functools
import logging
import math
import pickle
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array

Function = Callable[..., Any]
Point = tuple[int, dict[str, Any]]  # index of a point in its grid, and its arguments
Outcome = tuple[
    dict[str, Array], str
]  # results of a point by name, and the reason why results are missing, or an empty text
FAILURE = "failure"  # Name of the variable with the reason why a point lacks results
# First words of the reason for failure of a point whose worker died. The next call with the same
# store computes such points again.
LOST = "lost with its worker"
# Environment variables that limit the number of threads which numerical libraries start
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
# Time after which a worker returns its finished points, s. If the worker is killed, points that it
# has not returned are lost.
TURN = 0.3


def evaluate_points(function: Function | bytes, points: bytes) -> list[Outcome]:
    """Evaluate points until TURN seconds have passed, and return the outcomes of the finished
    points.

    At least one point is evaluated. ``points`` are pickled, since Dask would search a list of
    points for futures. ``function`` may also be pickled.
    """
    called = _unpickled(function) if isinstance(function, bytes) else function
    end = time.perf_counter() + TURN
    outcomes = list[Outcome]()
    for _, arguments in pickle.loads(points):
        outcomes.append(outcome_of(called, arguments))
        if time.perf_counter() > end:
            break
    return outcomes


def evaluate_in_turn(function: Function, values: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """Evaluate a function of numbers at each entry of arrays, one entry after the other.

    Args:
        function: function of keyword arguments that returns numbers by name.
        values: array of each argument, by name. The arrays broadcast.

    Returns:
        Arrays of the results by name, NaN where they are missing. The array ``failure`` has the
            reasons.
    """
    points = np.broadcast(*values.values())
    found: dict[str, NDArray[Any]] = {FAILURE: np.full(points.shape, "", dtype=object)}
    for number, point in enumerate(points):
        arguments = dict(zip(values, map(float, point), strict=True))
        results, found[FAILURE].flat[number] = outcome_of(function, arguments)
        for name, value in results.items():
            found.setdefault(name, np.full(points.shape, math.nan)).flat[number] = value
        logging.getLogger(__name__).info("%d of %d points finished", number + 1, points.size)
    return found


@functools.lru_cache(maxsize=1)
def _unpickled(function: bytes) -> Any:
    """Return the function of a sweep from its pickled form.

    The last function is cached, so that a worker unpickles it only once.
    """
    return pickle.loads(function)


def outcome_of(function: Function, arguments: dict[str, Any]) -> Outcome:
    """Call a function, and return its results and the reason why results are missing.

    If the function raises an error, there are no results. The reason is then the error's message,
    preceded by the error's type unless it is a ValueError.
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
