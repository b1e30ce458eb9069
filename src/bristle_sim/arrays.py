"""Types of arrays and numbers for annotations, and equality of results that contain arrays."""

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""An array of floats; docstrings give its shape and unit."""

Number = Any
"""A float if the arguments are floats; otherwise an array of their broadcast shape."""


class EqualByValue:
    """Base class that makes dataclasses with arrays comparable by ``==``.

    Two objects are equal if all their fields are equal; NaN in an array equals NaN. The dataclass
    must be declared with ``eq=False``.
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        """Return whether the other object has the same class and equal fields."""
        if type(other) is not type(self):
            return NotImplemented
        names = [each.name for each in dataclasses.fields(self)]  # type: ignore[arg-type]
        pairs = ((getattr(self, name), getattr(other, name)) for name in names)
        return all(_equal(one, two) for one, two in pairs)


def _equal(one: Any, two: Any) -> bool:
    if isinstance(one, np.ndarray):
        return np.array_equal(one, two, equal_nan=one.dtype.kind == "f")
    if isinstance(one, dict) and isinstance(two, dict):
        return one.keys() == two.keys() and all(_equal(each, two[key]) for key, each in one.items())
    return bool(one == two)
