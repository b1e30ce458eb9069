"""Types that annotations share, and equality of results that hold arrays."""

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""An array of floats; docstrings give its shape and unit."""

Number = Any
"""A float where the arguments are, else an array of their broadcast shape."""


class EqualByValue:
    """Equality of dataclasses that hold arrays, which Python's own cannot compare: all fields equal, NaN as itself.

    Such a dataclass is declared with ``eq=False``.
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        """Whether the other one is of the same class and has the same values."""
        if type(other) is not type(self):
            return NotImplemented
        names = [each.name for each in dataclasses.fields(self)]  # type: ignore[arg-type]
        pairs = ((getattr(self, name), getattr(other, name)) for name in names)
        return all(
            np.array_equal(one, two, equal_nan=True) if isinstance(one, np.ndarray) else bool(one == two)
            for one, two in pairs
        )
