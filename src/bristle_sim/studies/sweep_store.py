"""Results of a sweep as zarr arrays on its grid: written as they come, checked before more are computed, read by xarray.

In zarr a part of an array is a file of its own with a checksum, which is replaced as a whole: a crash leaves the others
intact, and xarray reads no more than is used.
"""

from __future__ import annotations

import json
import logging
import math
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from numpy.typing import NDArray
from zarr.codecs import Crc32cCodec, ZstdCodec

from bristle_sim.studies.sweep_point import FAILURE, Outcome, Point

NOT_COMPUTED = "not computed"  # The reason of points that are still to be computed
# Value of results that are not written yet, or that were lost: netCDF's for such numbers. xarray reads it as NaN.
UNWRITTEN = 9.969209968386869e36
ABANDONED = 60.0  # Age from which a half-written file counts as left by a killed program, s
BLOCK = 4096  # Most points of a chunk, which is a file


class SweepStore:
    """The arrays of a sweep in a folder or in memory, with the names and shapes of its results as attributes."""

    def __init__(self, target: Any, grid: xr.Dataset, units: Mapping[str, str]) -> None:
        self.target, self.grid, self.units, self.shape = target, grid, units, tuple(grid.sizes.values())
        words = {name: each.astype(str).astype(object) for name, each in grid.coords.items() if each.dtype == object}
        written, options = grid.assign_coords(words), dict[str, Any](zarr_format=3, consolidated=False)
        for each in target.rglob("*.partial") if isinstance(target, Path) else ():
            if time.time() - each.stat().st_mtime > ABANDONED:
                each.unlink()
        try:
            found = str(zarr.open_group(target, mode="r").attrs["results"])
            written.assign_attrs(results=found).to_zarr(target, mode="a", **options)
            self.shapes = dict[str, Any](json.loads(found))
        except Exception as error:  # of the many kinds that zarr raises for files that are absent or damaged
            if not isinstance(error, FileNotFoundError):
                logging.getLogger(__name__).warning("%s is damaged and computed again (%s)", target, error)
            written.assign_attrs(results="{}").to_zarr(target, mode="w", **options)
            self.shapes = {}
        self.group = zarr.open_group(target, mode="r+")
        self.arrays = {name: self._array(name, inner) for name, inner in {FAILURE: [], **self.shapes}.items()}

    def _array(self, name: str, inner: Sequence[int]) -> Any:
        """Return the array of a variable on the grid, followed by the variable's own axes; create it if it does not exist."""
        if name in self.group:
            return self.group[name]
        chunk, points = list[int](), BLOCK
        for size in reversed(self.shape):  # of points that follow each other
            chunk.insert(0, min(size, points))
            points //= chunk[0]
        return self.group.create_array(
            name,
            shape=(*self.shape, *inner),
            chunks=(*chunk, *inner),
            dtype=str if name == FAILURE else float,
            fill_value=NOT_COMPUTED if name == FAILURE else UNWRITTEN,
            compressors=[ZstdCodec(), Crc32cCodec()],
            dimension_names=[*map(str, self.grid.sizes), *(f"{name}_{axis}" for axis in range(len(inner)))],
            attributes={} if name == FAILURE else {"missing_value": UNWRITTEN},
            config={"write_empty_chunks": True},
        )

    def missing(self) -> NDArray[np.bool_]:
        """Return which points of the grid must be computed; damaged or lost parts are logged and cleared."""
        missing, lost = np.zeros(self.shape, bool), np.zeros(self.shape, bool)
        for name, array in self.arrays.items():
            for corner in np.ndindex(array.cdata_shape):
                region = tuple(slice(i * n, (i + 1) * n) for i, n in zip(corner, array.chunks, strict=True))
                points, own_axes = region[: len(self.shape)], tuple(range(len(self.shape), len(region)))
                try:
                    found = (np.asarray(array[region]) == array.fill_value).any(axis=own_axes)
                except Exception:  # of the many kinds that codecs raise for damaged bytes
                    array[region], found = array.fill_value, np.array(True)
                    lost[points] = True
                lost[points] |= found & ~missing[points] & (name != FAILURE)
                missing[points] |= found
        if lost.any():
            words = "%s: %d points were damaged or lost, and are computed again"
            logging.getLogger(__name__).warning(words, self.target, lost.sum())
        return missing

    def write(self, outcomes: Sequence[tuple[Point, Outcome]]) -> None:
        """Write the outcomes of some points, the reasons last: up to then a point counts as not computed.

        Raises ValueError for a result with the name of a parameter, or with a name that no array can have.
        """
        numbers = np.array([number for (number, _), _ in outcomes])
        for name, value in (item for _, (values, _) in outcomes for item in values.items()):
            if name not in self.arrays:
                self._add(name, list(value.shape))
        reasons = np.array([reason for _, (_, reason) in outcomes], dtype=object)
        for name, inner in self.shapes.items():
            column = np.full((len(outcomes), *inner), math.nan)
            for i, (_, (values, _)) in enumerate(outcomes):
                if name in values and values[name].shape == column.shape[1:]:
                    column[i] = values[name]
                elif name in values:
                    reasons[i] = f"{name} has the shape {values[name].shape}, at other points {column.shape[1:]}"
            self._put(name, numbers, column)
        self._put(FAILURE, numbers, reasons)

    def _add(self, name: str, inner: list[int]) -> None:
        """Add a result that points computed earlier do not have."""
        if name in {*self.grid.coords, *self.grid.sizes}:
            raise ValueError(f"function: its result {name} must not have the name of a parameter or dimension")
        check_name("function: its result", name)
        self.shapes[name] = inner
        self.group.attrs["results"] = json.dumps(self.shapes)
        self.arrays[name] = self._array(name, inner)
        computed = np.flatnonzero(self.arrays[FAILURE][...] != NOT_COMPUTED)
        self._put(name, computed, np.full((computed.size, *inner), math.nan))

    def _put(self, name: str, numbers: NDArray[np.intp], values: NDArray[Any]) -> None:
        """Write values of points by their numbers in the grid; zarr replaces the chunks that they are in."""
        array, inner = self.arrays[name], math.prod(values.shape[1:])
        if numbers.size and not array.shape:
            array[...] = values[0]
        elif numbers.size:
            places = (numbers[:, None] * inner + np.arange(inner)).ravel()
            array.vindex[np.unravel_index(places, array.shape)] = values.ravel()

    def dataset(self) -> xr.Dataset:
        """Return the results in the order of their names, loaded lazily by xarray without Dask."""
        found: xr.Dataset = xr.open_zarr(self.target, chunks=None, consolidated=False)
        found = found[sorted(map(str, found.data_vars))].assign_coords(self.grid.coords)
        for name, each in found.variables.items():
            each.attrs = {"units": self.units[str(name)]} if name in self.units else {}
        return found.assign_attrs(self.grid.attrs)


def check_name(what: str, name: str) -> None:
    """Raise ValueError for a name that an array in a folder cannot have."""
    if not name or "/" in name or name.startswith((".", "__")) or name == "zarr.json":
        raise ValueError(f"{what} {name!r} must have a name without /, that begins with neither . nor __")
