"""Check arguments that may be arrays, and refuse them in one line."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable
from numbers import Real
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from bristle_sim.quantity import Range, shown

P = ParamSpec("P")
T = TypeVar("T")


def ranges(*declared: Range) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorate a function to check its arguments before it runs, and to get them as floats or arrays of floats.

    A range is for the argument of its key; an argument that is None by default may be None, and one that is a function by
    default, such as a force over time, is no number and is left as it is.
    """
    by_key = {each.key: each for each in declared}

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        signature = inspect.signature(function)
        defaults = {name: parameter.default for name, parameter in signature.parameters.items()}
        numeric = {
            name for name, default in defaults.items() if default is inspect.Parameter.empty or not callable(default)
        }
        given = {name: by_key[name] for name in numeric if name in by_key}
        optional = {name for name in given if defaults[name] is None}

        @functools.wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            bound = signature.bind(*args, **kwargs)
            for name, value in bound.arguments.items():
                if name in given and not (value is None and name in optional):
                    bound.arguments[name] = checked(given[name], value)
            return function(*bound.args, **bound.kwargs)

        return call

    return decorate


def checked(declared: Range, value: Any) -> Any:
    """Return the value as a float or an array of floats, or raise ValueError for the first that is out of range."""
    number = _floats(value)
    if number is None or value is None:
        raise declared.refusal(value)
    above = number >= declared.lowest if declared.lowest_allowed else number > declared.lowest
    outside = ~(above & (number <= declared.highest))
    if outside.any():
        raise declared.refusal(float(number[outside].flat[0]))
    return number[()]


def numbers(name: str, value: Any, rule: str) -> NDArray[np.float64]:
    """Return the value as an array of floats, infinities and NaN included, or raise ValueError with the rule."""
    found = _floats(value)
    if found is None:
        raise ValueError(f"{name} = {shown(value)}: {rule}")
    return found


def require(name: str, value: Any, holds: Any, rule: str) -> None:
    """Raise ValueError with the rule and the first value for which ``holds`` is false; value and holds broadcast."""
    values, passed = np.broadcast_arrays(numbers(name, value, rule), np.asarray(holds, dtype=bool))
    if not passed.all():
        raise ValueError(f"{name} = {values[~passed][0]:g}: {rule}")


def finite(name: str, value: Any, unit: str) -> None:
    """Refuse infinities and NaN."""
    rule = f"must be finite ({_in(unit)})"
    array = numbers(name, value, rule)
    require(name, array, np.isfinite(array), rule)


def positive(name: str, value: Any, unit: str) -> None:
    """Refuse what is not finite and above zero."""
    rule = f"must be a finite number with {name} > 0 ({_in(unit)})"
    array = numbers(name, value, rule)
    require(name, array, np.isfinite(array) & (array > 0.0), rule)


def single(name: str, value: Any) -> float:
    """Return the value as a float, or refuse what is not one number."""
    if np.ndim(value):
        raise ValueError(f"{name} = {shown(value)}: must be a single number")
    return float(np.asarray(value).item())


def whole(name: str, value: Any, highest: int) -> None:
    """Refuse what is not a whole number from 1 on."""
    rule = f"must be a whole number with 1 <= {name} <= {highest}"
    array = numbers(name, value, rule)
    holds = (array >= 1) & (array <= highest) & (array == np.floor(array))
    require(name, array, holds, rule)


def _floats(value: Any) -> NDArray[np.float64] | None:
    """Return an array of floats; None for what does not consist of real numbers: text, truth values, complex numbers, ragged lists."""
    if _has_truth_value(value):
        return None
    try:
        array = np.asarray(value)
    except ValueError:
        return None
    if array.dtype.kind == "O":  # whole numbers beyond 64 bits, fractions, nothing at all
        known = all(isinstance(each, Real | None) and not isinstance(each, bool) for each in array.flat)
        return np.array([_float(each) for each in array.flat], dtype=float).reshape(array.shape) if known else None
    if array.dtype == np.float64:
        return array
    with np.errstate(over="ignore"):
        return array.astype(float) if array.dtype.kind in "iuf" else None


def _has_truth_value(value: Any) -> bool:
    """Tell whether True or False is among the values; an array of NumPy would turn them into 1 and 0 beside numbers."""
    if isinstance(value, list | tuple):
        return any(map(_has_truth_value, value))
    return isinstance(value, bool) or (isinstance(value, np.ndarray | np.generic) and value.dtype.kind == "b")


def _float(number: Any) -> float:
    try:
        return math.nan if number is None else float(number)
    except OverflowError:
        return -math.inf if number < 0 else math.inf


def _in(unit: str) -> str:
    return "dimensionless" if unit == "1" else f"in {unit}"
