"""Results of a sweep on the grid of its points, kept in memory or as zarr arrays in a folder.

Points are written to a folder as they are finished. The folder is checked before more points are
computed, and read by xarray. In zarr a chunk of an array is a file of its own with a checksum,
which is replaced as a whole. A crash therefore leaves the other chunks intact, and xarray reads
only the chunks in use. Descriptions and coordinates can be restored, so that a damaged one costs no
point.
"""

import json
import logging
import math
import os
import time
import zlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from numpy.typing import NDArray
from zarr.codecs import Crc32cCodec, ZstdCodec

from bristle_sim.studies.sweep_point import FAILURE, Outcome, Point

# Value of results that are not written yet or were lost: netCDF's fill value. xarray reads it as NaN.
UNWRITTEN = 9.969209968386869e36
ABANDONED = 60.0  # Age at which a half-written file counts as left behind by a killed program, s
BLOCK = 4096  # Largest number of points in a chunk, which is one file
GROUP = "zarr.json"  # Name of the file that describes a group or an array, in its folder


NOT_COMPUTED = "not computed"  # Reason for failure of points that are still to be computed


class Results:
    """Results of a sweep in memory: one array for each result, and one with the reasons of
    failures.

    The first axes of every array are those of the grid.

    Attributes:
        grid: coordinates of the points.
        shape: shape of the grid.
        taken: names of parameters and dimensions, which a result must not have.
        shapes: shape of each result at a single point, by name.
        arrays: the arrays, by name.
    """

    def __init__(self, grid: xr.Dataset) -> None:
        self.grid = grid
        self.shape = tuple(grid.sizes.values())
        self.taken = {*map(str, grid.coords), *map(str, grid.sizes)}
        self.shapes: dict[str, tuple[int, ...]] = {}
        self.arrays: dict[str, Any] = {FAILURE: np.full(self.shape, NOT_COMPUTED, dtype=object)}

    def missing(self, again: str = "") -> NDArray[np.bool_]:  # noqa: ARG002
        """Return which points of the grid must be computed, as an array of booleans.

        ``again`` has an effect in a store alone.
        """
        return np.asarray(self.arrays[FAILURE] == NOT_COMPUTED)

    def write(self, outcomes: Sequence[tuple[Point, Outcome]]) -> None:
        """Write the results of some points, and then their reasons for failure.

        A point counts as not computed until its reason, which may be empty, is written.

        Raises:
            ValueError: for a result with the name of a parameter, or with a name that is not
                permitted for an array.
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
        """Add arrays for results that the earlier points did not have.

        Raises:
            ValueError: for a result with the name of a parameter, or with a name that is not
                permitted for an array.
        """
        for name in shapes:
            if name in self.taken:
                raise ValueError(
                    f"function: its result {name} must not have the name of a parameter or dimension"
                )
            check_name("function: its result", name)
        self._create(shapes)
        self.shapes.update(shapes)

    def _create(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        """Create arrays filled with NaN; ``shapes`` has the shape of each result at a single point."""
        self.arrays.update(
            (name, np.full((*self.shape, *inner), math.nan)) for name, inner in shapes.items()
        )

    def _put(self, name: str, numbers: NDArray[np.intp], values: NDArray[Any]) -> None:
        """Write values of a result at points that are given by their indices in the grid."""
        if values.size:
            self.arrays[name].reshape(-1, *values.shape[1:])[numbers] = values

    def dataset(self) -> xr.Dataset:
        """Return the grid as a Dataset with the results."""
        found = self.grid.copy()
        for name, array in self.arrays.items():
            own_axes = [f"{name}_{axis}" for axis in range(array.ndim - len(self.shape))]
            values = array.astype(object) if name == FAILURE else array
            found[name] = ([*self.grid.sizes, *own_axes], values)
        return found


def check_name(what: str, name: str) -> None:
    """Check that an array in a folder may have a name; ``what`` describes it in the message.

    Raises:
        ValueError: for a name that is empty, unprintable or reserved.
    """
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


class SweepStore(Results):
    """Results of a sweep in a folder.

    The folder's attributes repeat the names and shapes of the results, with a checksum.
    """

    def __init__(self, folder: Path, grid: xr.Dataset) -> None:
        super().__init__(grid)
        self.folder = folder
        for partial in folder.rglob("*.partial"):
            with suppress(OSError):
                if time.time() - partial.stat().st_mtime > ABANDONED:
                    partial.unlink()
        self._create({})

    def missing(self, again: str = "") -> NDArray[np.bool_]:
        """Return which points of the grid must be computed, as an array of booleans.

        If ``again`` is not empty, points whose reason for failure begins with it are included.
        Points that were damaged or lost are logged.

        Raises:
            OSError: if a file cannot be read.
        """
        missing = np.zeros(self.shape, bool)
        lost = np.zeros(self.shape, bool)
        for name, array in self.arrays.items():
            for corner in np.ndindex(array.cdata_shape):
                region = tuple(
                    slice(i * n, (i + 1) * n) for i, n in zip(corner, array.chunks, strict=True)
                )
                points = region[: len(self.shape)]
                own_axes = tuple(range(len(self.shape), len(region)))
                try:
                    values = np.asarray(array[region])
                    absent = (values == array.fill_value).any(axis=own_axes)
                except (OSError, MemoryError):
                    raise
                except Exception:  # of the many kinds that codecs raise for damaged bytes
                    array[region], absent = array.fill_value, np.array(True)
                    lost[points] = True
                else:
                    if name == FAILURE and again:
                        absent |= np.strings.startswith(values, again)
                lost[points] |= absent & ~missing[points] & (name != FAILURE)
                missing[points] |= absent
        if lost.any():
            words = "%s: %d points were damaged or lost, and are computed again"
            logging.getLogger(__name__).warning(words, self.folder, lost.sum())
        return missing

    def _add(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        super()._add(shapes)
        computed = np.flatnonzero(self.arrays[FAILURE][...] != NOT_COMPUTED)
        for name, inner in shapes.items():
            self._put(name, computed, np.full((computed.size, *inner), math.nan))

    def _create(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        """Write the descriptions and coordinates that are absent or damaged, and open the arrays.

        The description of the whole folder is written last.

        Raises:
            OSError: if an absent file cannot be written.
        """
        self.shapes = dict(sorted({**self._described(), **shapes}.items()))
        for name, content in sorted(self._files().items(), key=lambda item: item[0] == GROUP):
            path = self.folder / name
            before = path.read_bytes() if path.exists() else None
            if before != content:
                try:
                    _replace(path, content)
                except OSError:  # a disk that is full or read-only may hold all points
                    if before is None:
                        raise
        group = zarr.open_group(self.folder, mode="r+")
        self.arrays = {name: group[name] for name in (FAILURE, *self.shapes)}

    def _described(self) -> dict[str, tuple[int, ...]]:
        """Return the shapes of the results that the folder already holds, by name.

        They are read from the descriptions of the arrays, and from the folder's description if it
        is intact.
        """
        shapes = dict[str, tuple[int, ...]]()
        for path in self.folder.glob(f"*/{GROUP}"):
            with suppress(ValueError, TypeError, KeyError):
                shape = tuple(json.loads(path.read_bytes())["shape"])
                if (
                    path.parent.name not in {*self.taken, FAILURE}
                    and shape[: len(self.shape)] == self.shape
                ):
                    shapes[path.parent.name] = shape[len(self.shape) :]
        with suppress(FileNotFoundError):
            content = (self.folder / GROUP).read_bytes()
            try:
                attributes = json.loads(content)["attributes"]
                if zlib.crc32(attributes["results"].encode()) != attributes["checksum"]:
                    raise ValueError(attributes["checksum"])
                shapes |= {
                    name: tuple(inner) for name, inner in json.loads(attributes["results"]).items()
                }
            except (ValueError, TypeError, KeyError, AttributeError):
                logging.getLogger(__name__).warning(
                    "%s: its description was damaged and is made anew", self.folder
                )
        return shapes

    def _files(self) -> dict[str, bytes]:
        """Return the contents of the descriptions and coordinates, by the name of their file.

        The chunks of results are not included.
        """
        content = dict[str, Any]()
        results = json.dumps(self.shapes)
        memory = zarr.storage.MemoryStore(content)
        words = {
            name: each.astype(str).astype(object)
            for name, each in self.grid.coords.items()
            if each.dtype == object
        }
        written = self.grid.assign_coords(words).assign_attrs(
            results=results, checksum=zlib.crc32(results.encode())
        )
        written.to_zarr(memory, mode="w", zarr_format=3, consolidated=False)
        group = zarr.open_group(memory, mode="r+")
        chunk = list[int]()
        points = BLOCK
        for size in reversed(self.shape):  # of points that follow each other
            chunk.insert(0, min(size, points))
            points //= chunk[0]
        for name, inner in {FAILURE: (), **self.shapes}.items():
            group.create_array(
                name,
                shape=(*self.shape, *inner),
                chunks=(*chunk, *(max(1, size) for size in inner)),
                dtype=str if name == FAILURE else float,
                fill_value=NOT_COMPUTED if name == FAILURE else UNWRITTEN,
                compressors=[ZstdCodec(), Crc32cCodec()],
                dimension_names=[
                    *map(str, self.grid.sizes),
                    *(f"{name}_{axis}" for axis in range(len(inner))),
                ],
                attributes={} if name == FAILURE else {"missing_value": UNWRITTEN},
                config={"write_empty_chunks": True},
            )
        return {name: each.to_bytes() for name, each in content.items()}

    def _put(self, name: str, numbers: NDArray[np.intp], values: NDArray[Any]) -> None:
        """Write values of a result at points that are given by their indices in the grid.

        zarr replaces the chunks that hold these points.
        """
        array = self.arrays[name]
        inner = math.prod(values.shape[1:])
        if not values.size:
            return
        if not array.shape:
            array[...] = values[0]
            return
        places = (numbers[:, None] * inner + np.arange(inner)).ravel()
        array.vindex[np.unravel_index(places, array.shape)] = values.ravel()

    def dataset(self) -> xr.Dataset:
        """Return the grid as a Dataset with the results, which xarray loads lazily without Dask."""
        stored: xr.Dataset = xr.open_zarr(self.folder, chunks=None, consolidated=False)
        text = stored[FAILURE].astype(object)  # versions of xarray differ in the type they read
        return stored.assign({FAILURE: text}).assign_coords(self.grid.coords)


def _replace(path: Path, content: bytes) -> None:
    """Write a file completely or, if that fails, leave the old one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f"{path.name}.{os.urandom(8).hex()}.partial")
    try:
        partial.write_bytes(content)
        partial.replace(path)
    except OSError:
        with suppress(OSError):
            partial.unlink()
        raise
