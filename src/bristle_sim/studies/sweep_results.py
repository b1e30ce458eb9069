"""Results of a sweep in blocks of points, in memory and in a store's folder.

A block in a folder is one file that is never changed, and its name is the digest of its content: two programs may add to
one folder, a killed one leaves the blocks that it had written, and a damaged file is left out.
"""

from __future__ import annotations

import hashlib
import io
import logging
import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.files import complete_or_absent
from bristle_sim.studies.sweep_point import FAILURE, Outcome, Point

NOT_COMPUTED = "not computed"  # The reason of points that are still to be computed


class Block(NamedTuple):
    """Points whose results have the same names and shapes.

    Attributes:
        numbers: of the points in their grid, shape (n,).
        reasons: why a point has no results, or lacks some; shape (n,).
        results: by name, shape (n, ...).
    """

    numbers: NDArray[np.intp]
    reasons: NDArray[np.str_]
    results: dict[str, Array]


def blocks_of(outcomes: Iterable[tuple[Point, Outcome]], grid: xr.Dataset) -> list[Block]:
    """Return outcomes in blocks. Raises ValueError for a result with the name of a parameter or dimension of the grid."""
    alike = defaultdict[Any, list[tuple[int, Outcome]]](list)
    for (number, _), outcome in outcomes:
        alike[tuple((name, value.shape) for name, value in outcome[0].items())].append(
            (number, outcome)
        )
    blocks = []
    for shapes, points in alike.items():
        for name, _ in shapes:
            if name in grid.coords or name in grid.sizes:
                raise ValueError(
                    f"function: its result {name} must not have the name of a parameter or dimension"
                )
        numbers = np.array([number for number, _ in points])
        reasons = np.array([reason for _, (_, reason) in points])
        columns = {
            name: np.stack([values[name] for _, (values, _) in points]) for name, _ in shapes
        }
        blocks.append(Block(numbers, reasons, columns))
    return blocks


def write_block(folder: Path, block: Block) -> None:
    """Write a block to a new file of a folder."""
    content = io.BytesIO()
    columns = block.results.values()
    names = np.array([*block.results], dtype=str)
    np.savez_compressed(
        content, *columns, numbers=block.numbers, reasons=block.reasons, names=names
    )
    written = content.getvalue()
    folder.mkdir(parents=True, exist_ok=True)
    with complete_or_absent(folder / f"{hashlib.sha1(written).hexdigest()}.npz") as partial:
        partial.write_bytes(written)


def read_blocks(folder: Path, again: str) -> list[Block]:
    """Return the blocks in a folder, without the points whose reason begins with the word ``again``.

    A damaged file is logged and left out. Raises OSError if a file cannot be read.
    """
    blocks = []
    for path in folder.glob("*.npz"):
        content = path.read_bytes()
        if hashlib.sha1(content).hexdigest() != path.stem:
            logging.getLogger(__name__).warning(
                "%s: damaged and left out; its points are computed again", path
            )
            continue
        with np.load(io.BytesIO(content)) as found:
            kept = ~np.strings.startswith(found["reasons"], again)
            results = {str(name): found[f"arr_{i}"][kept] for i, name in enumerate(found["names"])}
            blocks.append(Block(found["numbers"][kept], found["reasons"][kept], results))
    return blocks


def labelled(blocks: Sequence[Block], grid: xr.Dataset, units: Mapping[str, str]) -> xr.Dataset:
    """Return the grid with the results of blocks, NaN where there are none, and ``failure``, the reasons.

    The first point of the grid that has a result decides its shape, in whatever order points were finished.
    """
    shape = tuple(grid.sizes.values())
    size = math.prod(shape)
    reasons = np.full(size, NOT_COMPUTED, dtype=object)
    arrays = dict[str, Array]()
    for block in sorted(blocks, key=lambda block: block.numbers.min(initial=size)):
        reasons[block.numbers] = block.reasons
        for name, column in block.results.items():
            array = arrays.setdefault(name, np.full((size, *column.shape[1:]), math.nan))
            if array.shape[1:] == column.shape[1:]:
                array[block.numbers] = column
            else:
                reasons[block.numbers] = (
                    f"{name} has the shape {column.shape[1:]}, at other points {array.shape[1:]}"
                )
    found = grid.copy()
    for name, values in sorted({**arrays, FAILURE: reasons}.items()):
        own_axes = [f"{name}_{axis}" for axis in range(values.ndim - 1)]
        found[name] = ([*grid.sizes, *own_axes], values.reshape(shape + values.shape[1:]))
    for name in units.keys() & found.variables.keys():
        found[name].attrs["units"] = units[name]
    return found
