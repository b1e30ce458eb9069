"""Results of a sweep as zarr arrays on its grid, written block by block and read by xarray."""

from __future__ import annotations

import itertools
import math
from collections.abc import Generator, Iterator, Mapping
from contextlib import closing
from typing import Any, cast

import numpy as np
import xarray as xr
import zarr
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.studies.sweep_point import Outcome

FAILURE = "failure"
"""Variable that says why a point has no results."""

BLOCK = 4096
"""Points that are written to disk together, and so held in memory at most; some megabytes for small arrays."""


def opened(store: Any) -> xr.Dataset:
    """The stored results in the order of their names, read when they are used; without chunks Dask has no part in it."""
    found: xr.Dataset = xr.open_zarr(store, chunks=None, consolidated=False)
    return found[sorted(map(str, found.data_vars))]


def write(target: Any, grid: xr.Dataset, units: Mapping[str, str], outcomes: Generator[Outcome, None, None]) -> None:
    """Write the outcomes of all points to a zarr store, one chunk of the grid after the other.

    Regions of xarray's to_zarr need all variables at first; here each is created when its first result comes.
    """
    for name, coordinate in grid.coords.items():
        coordinate.attrs = {"units": units[str(name)]} if name in units else {}
    grid.to_zarr(target, mode="w", zarr_format=3, consolidated=False)
    group, shape = zarr.open_group(target, mode="r+"), tuple(grid.sizes.values())
    chunk = chunk_shape(shape)
    group.create_array(
        FAILURE, shape=shape, chunks=chunk, dtype=str, fill_value="", dimension_names=[*map(str, grid.sizes)]
    )
    with closing(outcomes):
        for region in regions(shape, chunk):
            points = math.prod(part.stop - part.start for part in region)
            block = list(itertools.islice(outcomes, points))
            for name in dict.fromkeys(name for values, _ in block for name in values):
                if name in {*grid.coords, *grid.sizes, FAILURE}:
                    raise ValueError(
                        f"function: its result {name} must not be named as a parameter, dimension or {FAILURE}"
                    )
                if name not in group:
                    inner = next(values[name].shape for values, _ in block if name in values)
                    _create(group, name, inner, {"units": units[name]} if name in units else {}, grid.sizes)
                array = cast("zarr.Array[Any]", group[name])
                _put(array, region, _column(name, block, array.shape[len(shape) :]))
            _put(group[FAILURE], region, np.array([reason for _, reason in block], dtype=object))
        next(outcomes, None)  # lets workers and progress come to their end


def _create(
    group: Any, name: str, inner: tuple[int, ...], attributes: Mapping[str, str], sizes: Mapping[Any, int]
) -> None:
    """Create the array of one result on the grid, with the axes of its own at the end."""
    shape = tuple(sizes.values())
    group.create_array(
        name,
        shape=shape + inner,
        chunks=chunk_shape(shape) + inner,
        dtype=float,
        fill_value=math.nan,
        dimension_names=[*sizes, *(f"{name}_{axis}" for axis in range(len(inner)))],
        attributes=attributes,
    )


def _column(name: str, block: list[Outcome], inner: tuple[int, ...]) -> Array:
    """One result at every point of a block; a point whose array has another shape than at the first point has failed."""
    column = np.full((len(block), *inner), math.nan)
    for number, (values, _) in enumerate(block):
        if name in values and values[name].shape == inner:
            column[number] = values[name]
        elif name in values:
            reason = f"ValueError: {name} has the shape {values[name].shape}, at other points {inner}"
            block[number] = (values, reason)
    return column


def _put(array: Any, region: tuple[slice, ...], values: NDArray[Any]) -> None:
    size = tuple(part.stop - part.start for part in region)
    array[region] = values.reshape(size + array.shape[len(region) :])


def chunk_shape(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Shape of a chunk: of at most BLOCK points that follow each other."""
    sizes, room = [], BLOCK
    for size in reversed(shape):
        sizes.append(min(size, room))
        room //= sizes[-1]
    return tuple(reversed(sizes))


def regions(shape: tuple[int, ...], chunk: tuple[int, ...]) -> Iterator[tuple[slice, ...]]:
    """Where the chunks lie, in the order of their points."""
    edges = [range(0, size, step) for size, step in zip(shape, chunk, strict=True)]
    for corner in itertools.product(*edges):
        yield tuple(slice(i, min(i + n, size)) for i, n, size in zip(corner, chunk, shape, strict=True))
