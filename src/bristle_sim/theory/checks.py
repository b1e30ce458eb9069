"""Check arguments that may be arrays, each in the range of its name, and refuse them in one line."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable
from numbers import Real
from typing import Any, ParamSpec, TypeVar

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.units import Range, shown

P = ParamSpec("P")
T = TypeVar("T")


SINGLE = ("float", "int", "float | None")  # annotations of arguments that must be single numbers


def ranges(*declared: Range) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorate a function to check its arguments before it runs, and to get them as numbers or arrays of floats.

    A range is for the argument of its key; an argument that is None by default may be None.
    """
    by_key = {each.key: each for each in declared}

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        """Return the function with its arguments checked."""
        signature = inspect.signature(function)
        checked_ones = {
            name: (by_key[name], each.default is None, each.annotation in SINGLE)
            for name, each in signature.parameters.items()
            if name in by_key
        }

        @functools.wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            """Check the arguments, and call the function with numbers or arrays of floats."""
            bound = signature.bind(*args, **kwargs)
            for name, value in bound.arguments.items():
                if name in checked_ones:
                    own, optional, single = checked_ones[name]
                    if single and np.ndim(value):
                        raise ValueError(f"{name} = {shown(value)}: must be a single number")
                    if not (value is None and optional):
                        bound.arguments[name] = checked(own, value)
            return function(*bound.args, **bound.kwargs)

        return call

    return decorate


def checked(declared: Range, value: Any) -> Any:
    """Return the value as a number or an array of floats, or raise ValueError for the first that is out of range."""
    number = _floats(value)
    if number is None or value is None:
        raise declared.refusal(value)
    above = number >= declared.lowest if declared.lowest_allowed else number > declared.lowest
    outside = ~(above & (number <= declared.highest) & ((number == np.floor(number)) | (not declared.whole)))
    if outside.any():
        raise declared.refusal(float(number[outside].flat[0]))
    return int(number) if declared.whole and not number.ndim else number[()]


def numbers(name: str, value: Any, rule: str) -> Array:
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


def _floats(value: Any) -> Array | None:
    """Return an array of floats; None for what does not consist of real numbers: text, truth values, complex numbers, ragged lists."""
    if _has_truth_value(value):
        return None
    try:
        array = np.asarray(value)
        if array.dtype.kind == "O" and not all(isinstance(each, Real | None) for each in array.flat):
            return None
        with np.errstate(over="ignore"):  # whole numbers beyond 64 bits and fractions are objects
            return array.astype(float, copy=False) if array.dtype.kind in "iufO" else None
    except (ValueError, OverflowError):
        return None


def _has_truth_value(value: Any) -> bool:
    """Tell whether True or False is among the values; an array of NumPy would turn them into 1 and 0 beside numbers."""
    if isinstance(value, list | tuple):
        return any(map(_has_truth_value, value))
    return isinstance(value, bool) or (isinstance(value, np.ndarray | np.generic) and value.dtype.kind == "b")


def _in(unit: str) -> str:
    return "dimensionless" if unit == "1" else f"in {unit}"


RIGHT, TURN = 0.5 * math.pi, 2.0 * math.pi

_ROWS = (
    # The tool and the wire.
    ("mass rod_mass", "kg", 1e-30, 1e6, "rounding: m v^2 and v/m of the extremes are floats"),
    ("length rod_length", "m", 1e-9, 1e3, "rounding: m L^2 of the extremes is a float"),
    ("hub_radius", "m", 0.0, 1e3, "physics; rounding: r_h/L keeps L's digits up to 1e12"),
    ("hub_speed", "rad/s", 0.0, 1e6, "physics: the hub turns forward; rounding: r_h omega^2"),
    ("speed_ratio", "1", -1e9, 1e9, "rounding: R + r_h/L keeps either's digits"),
    ("inertia", "kg m^2", 1e-60, 1e100, "physics: positive; rounding: k/I"),
    ("stiffness", "N m/rad", 0.0, 1e100, "physics: no negative spring; rounding: k/I"),
    ("centrifugal", "N m/rad", 0.0, 1e100, "physics: m r_h omega^2 L/2 is not negative; rounding as a stiffness"),
    ("natural_rate", "rad/s", 1e-150, 1e150, "physics: positive; rounding: its square is a float"),
    ("damping_ratio", "1", 0.0, 1e9, "physics: no damper drives; rounding: sqrt(zeta^2 - 1)"),
    ("diameter", "m", 1e-30, 1e2, "physics: positive; rounding: d^4"),
    ("modulus", "Pa", 1e-30, 1e15, "physics: positive, at most a thousand times diamond's"),
    ("root_stiffness", "N m/rad", 0.0, 1e9, "physics: no negative spring; rounding: beyond it a clamp"),
    # Where the bar stands.
    ("retraction", "rad", -TURN, TURN, "physics: a turn either way"),
    ("penetration", "m", -2e3, 2e3, "physics: within the reach of hub and bristle"),
    ("bar_reach", "m", 0.0, 1e4, "physics: a radius; rounding: S keeps the bristle's digits"),
    ("bar_horizontal bar_vertical", "m", -1e4, 1e4, "rounding: S keeps the bristle's digits"),
    ("speed_share", "1", 0.0, 1.0, "physics: damping slows"),
    # Impacts.
    ("impact_angle", "rad", 0.0, RIGHT, "physics: from along the surface to straight down"),
    ("friction restitution_friction", "1", 0.0, 1e9, "physics: Coulomb's; rounding: 1 + mu^2"),
    ("restitution", "1", 0.0, 1.0, "physics: no energy is gained"),
    ("tip_speed", "m/s", -1e12, 1e12, "rounding: m v^2"),
    ("impulse", "N s", -1e30, 1e30, "rounding: p^2/m"),
    ("relative_speed", "rad/s", -1e15, 1e15, "rounding: its square is a float"),
    ("mass_ratio", "1", 1e-30, 1e12, "physics: positive; rounding: n + 3 keeps either's digits"),
    ("angle_1 angle_2", "rad", -RIGHT, RIGHT, "physics: the rods reach the surface from above"),
    ("rate rate_1 rate_2", "rad/s", -1e9, 1e9, "rounding: L^2 rate^2 keeps its digits"),
    # Force histories.
    ("time start", "s", -1e30, 1e30, "rounding: any clock; its square is a float"),
    ("compression_time", "s", 1e-30, 1e3, "physics: positive; rounding: F^(n) t^n"),
    ("duration", "s", 1e-30, 1e30, "physics: positive; rounding: its square is a float"),
    ("peak_force", "N", 1e-30, 1e30, "physics: positive; rounding: squares of residuals"),
    # Cutting.
    ("decay", "1/s", 0.0, 1e15, "physics: the motion slows; rounding: decay times compression_time"),
    ("depth", "m", 0.0, 1e6, "physics: not above the surface; rounding: a force over a width"),
    ("shear_yield_stress", "Pa", 1e-30, 1e30, "physics: positive; rounding: a force over a stress and a width"),
    ("force", "N", -1e30, 1e30, "rounding: a force over a stress and a width"),
    ("cutting_force", "N", 0.0, 1e30, "physics: the chip resists; rounding: a force over a stress and a width"),
    ("path", "m", 0.0, 1e30, "physics: the tip dives; rounding: its square is a float"),
    ("energy", "J", 0.0, 1e30, "physics: the work takes energy; rounding: a volume"),
    ("specific_energy", "J/m^3", 1e-60, 1e60, "physics: positive; rounding: a volume"),
    ("speed", "m/s", 1e-60, 1e15, "physics: the tip moves; rounding: m v^2"),
    ("effective_mass", "kg", 1e-60, 1e30, "physics: positive; rounding: m v^2"),
    ("normal_force tangential_force", "N", -1e30, 1e30, "rounding: a work"),
    ("normal_velocity tangential_velocity", "m/s", -1e30, 1e30, "rounding: a work"),
)

_WHOLE = (
    ("plies", 10_000_000, "rounding: summed in one array"),
    ("segments", 10_000_000, "rounding: integrated in one array"),
    ("modes", 50, "rounding: cosh(lambda) overflows beyond the 220th, and no contact here excites so many"),
    ("links", 1000, "rounding: eigenvalues of dense matrices of this size"),
)

RANGES: dict[str, Range] = {
    **{key: Range(key, unit, low, high, True, why) for keys, unit, low, high, why in _ROWS for key in keys.split()},
    **{key: Range(key, "1", 1, most, True, reason, whole=True) for key, most, reason in _WHOLE},
}
"""By the argument's name; the source of each is the reason of its bounds."""

checked_arguments = ranges(*RANGES.values())
"""Decorate a function to check the arguments whose names are in the table, and to get them as floats or arrays of floats."""


def checked_numbers(**values: float) -> list[float]:
    """Return single numbers as plain floats, each in the range of its name, or raise ValueError."""
    return [RANGES[name].check(value) for name, value in values.items()]
