"""Results of a sweep on the grid of its points, in memory and in a folder.

Finished points are written to the folder as they arrive. Every file holds some points as NumPy
arrays, which are data alone, and is named by the checksum of its content. A damaged file is
therefore noticed; its points are computed again, and the other files stay intact.
"""

import hashlib
import io
import logging
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.files import complete_or_absent
from bristle_sim.studies.sweep_point import FAILURE, Outcome, Point

NOT_COMPUTED = "not computed"  # Reason for failure of points that are still to be computed
# First words of the reason for failure of points that are not kept, so that the next call computes them again
LOST = "lost with its worker"
NUMBERS = "numbers"  # Name of the array of a file with the indices of its points in the grid
RESULT = "result/"  # First letters of the name of the array of a file with a result


class Results:
    """Results of a sweep: one array for each result, and one with the reasons of failures.

    The first axis of every array runs over the points of the grid, the last dimension fastest.

    Attributes:
        grid: coordinates of the points.
        shape: shape of the grid.
        folder: folder that keeps finished points; None if they are not kept.
        failure: reasons of failures, empty where a point has all results.
        arrays: the results, by name.
    """

    def __init__(self, grid: xr.Dataset, folder: Path | None) -> None:
        self.grid = grid
        self.shape = tuple(grid.sizes.values())
        self.folder = folder
        self.failure = np.full(math.prod(self.shape), NOT_COMPUTED, dtype=object)
        self.arrays: dict[str, Array] = {}
        if folder is not None:
            self._read(folder)

    def missing(self) -> NDArray[np.intp]:
        """Return the indices of the points that must be computed."""
        return np.flatnonzero(self.failure == NOT_COMPUTED)

    def write(self, outcomes: Sequence[tuple[Point, Outcome]]) -> None:
        """Write the outcomes of some points.

        Raises:
            ValueError: for a result with the name of a parameter, or with a name that is not
                permitted for an array.
            OSError: if the folder cannot be written.
        """
        for (number, _), (values, reason) in outcomes:
            self.failure[number] = reason
            for name, value in values.items():
                array = self._array(name, value.shape)
                inner = array.shape[1:]
                if value.shape == inner:
                    array[number] = value
                else:
                    self.failure[number] = (
                        f"{name} has the shape {value.shape}, at other points {inner}"
                    )
        if self.folder is not None:
            self._keep(self.folder, [number for (number, _), _ in outcomes])

    def dataset(self) -> xr.Dataset:
        """Return the grid as a Dataset with the results, ordered by name."""
        found = self.grid.copy()
        for name, array in sorted({**self.arrays, FAILURE: self.failure}.items()):
            own_axes = [f"{name}_{axis}" for axis in range(array.ndim - 1)]
            values = array.reshape((*self.shape, *array.shape[1:]))
            found[name] = ([*self.grid.sizes, *own_axes], values)
        return found

    def _array(self, name: str, inner: tuple[int, ...]) -> Array:
        """Return the array of a result; ``inner`` is its shape at a single point if it is new."""
        if name not in self.arrays:
            if name in {*self.grid.coords, *self.grid.sizes}:
                raise ValueError(
                    f"function: its result {name} must not have the name of a parameter or dimension"
                )
            check_name("function: its result", name)
            self.arrays[name] = np.full((self.failure.size, *inner), math.nan)
        return self.arrays[name]

    def _keep(self, folder: Path, numbers: list[int]) -> None:
        """Write a file with the points of given indices, except those that were lost."""
        kept = [number for number in numbers if not self.failure[number].startswith(LOST)]
        columns: dict[str, Any] = {
            NUMBERS: np.array(kept, dtype=int),
            FAILURE: self.failure[kept].astype(str),
            **{RESULT + name: array[kept] for name, array in self.arrays.items()},
        }
        stream = io.BytesIO()
        np.savez(stream, **columns)
        content = stream.getvalue()
        folder.mkdir(parents=True, exist_ok=True)
        with complete_or_absent(folder / f"{_checksum(content)}.npz") as partial:
            partial.write_bytes(content)

    def _read(self, folder: Path) -> None:
        """Read the points that the folder keeps; files that are damaged are logged."""
        damaged = 0
        for path in folder.glob("*.npz"):
            content = path.read_bytes()
            if path.stem != _checksum(content):
                damaged += 1
                continue
            with np.load(io.BytesIO(content), allow_pickle=False) as kept:
                numbers = kept[NUMBERS]
                self.failure[numbers] = kept[FAILURE]
                for key in set(kept) - {NUMBERS, FAILURE}:
                    values = kept[key]
                    self._array(key.removeprefix(RESULT), values.shape[1:])[numbers] = values
        if damaged:
            words = "%s: %d files are damaged; their points are computed again"
            logging.getLogger(__name__).warning(words, folder, damaged)


def check_name(what: str, name: str) -> None:
    """Check that a parameter or a result may have a name; ``what`` describes it in the message.

    Raises:
        ValueError: for a name that is empty, or cannot be a name in a file.
    """
    if not name or not name.isprintable() or "/" in name:
        raise ValueError(f"{what} {name!r} must have a name without / and unprintable letters")


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
