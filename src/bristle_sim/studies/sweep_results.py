"""Results of a sweep on the grid of its points, in memory; a store has the same methods and keeps them in a folder."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.studies.sweep_point import FAILURE, Outcome, Point

NOT_COMPUTED = "not computed"  # The reason of points that are still to be computed


class Results:
    """The reasons of failures and an array for each result, whose first axes are those of the grid.

    ``shapes`` has the shape of a single point's result by name. ``taken`` has the names of parameters and dimensions.
    """

    def __init__(self, shape: Sequence[int], taken: Iterable[str] = ()) -> None:
        self.shape = tuple(shape)
        self.taken = frozenset(taken)
        self.shapes: dict[str, tuple[int, ...]] = {}
        self.arrays: dict[str, Any] = {FAILURE: np.full(self.shape, NOT_COMPUTED, dtype=object)}

    def missing(self, again: str = "") -> NDArray[np.bool_]:  # noqa: ARG002
        """Return which points of the grid must be computed; a store computes some reasons of failure again."""
        return np.asarray(self.arrays[FAILURE] == NOT_COMPUTED)

    def write(self, outcomes: Sequence[tuple[Point, Outcome]]) -> None:
        """Write the outcomes of some points, the reasons last: up to then a point counts as not computed.

        Raises ValueError for a result with the name of a parameter, or with a name that no array can have.
        """
        numbers = np.array([number for (number, _), _ in outcomes])
        results = [values for _, (values, _) in outcomes]
        reasons = np.array([reason for _, (_, reason) in outcomes], dtype=object)
        new = dict[str, tuple[int, ...]]()
        for values in results:
            for name in values.keys() - self.shapes.keys():
                new.setdefault(name, values[name].shape)
        if new:
            self._add(new)
        for name, inner in self.shapes.items():
            column = np.full((len(outcomes), *inner), math.nan)
            for i, values in enumerate(results):
                value = values.get(name)
                if value is not None and value.shape == inner:
                    column[i] = value
                elif value is not None:
                    reasons[i] = f"{name} has the shape {value.shape}, at other points {inner}"
            self._put(name, numbers, column)
        self._put(FAILURE, numbers, reasons)

    def _add(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        """Add results that points computed earlier do not have."""
        for name in shapes:
            if name in self.taken:
                raise ValueError(
                    f"function: its result {name} must not have the name of a parameter or dimension"
                )
            check_name("function: its result", name)
        self._create(shapes)
        self.shapes.update(shapes)

    def _create(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        """Create arrays of NaN by name and shape of a point's result."""
        self.arrays.update(
            (name, np.full((*self.shape, *inner), math.nan)) for name, inner in shapes.items()
        )

    def _put(self, name: str, numbers: NDArray[np.intp], values: NDArray[Any]) -> None:
        """Write values of points by their numbers in the grid."""
        if values.size:
            self.arrays[name].reshape(-1, *values.shape[1:])[numbers] = values


def check_name(what: str, name: str) -> None:
    """Raise ValueError for a name that an array in a folder cannot have."""
    if (
        not name.isprintable()
        or not name
        or "/" in name
        or name.startswith((".", "__"))
        or name == "zarr.json"
    ):
        rule = (
            "must have a name without / and unprintable letters, that begins with neither . nor __"
        )
        raise ValueError(f"{what} {name!r} {rule}")
