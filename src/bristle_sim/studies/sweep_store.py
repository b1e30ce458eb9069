"""Results of a sweep on the grid of its points, kept as zarr arrays in memory or in a folder.

Points are written to a folder as they are finished. The folder is checked before a sweep
continues. zarr divides an array into chunks. Each chunk is a file with a checksum, and is replaced
as a whole. A crash can therefore damage only the chunk that is being written. xarray opens the
folder, and reads only the chunks that are requested. Damaged metadata and coordinates can be
restored, so that no point is lost.
"""

import json
import logging
import math
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

from bristle_sim.files import complete_or_absent
from bristle_sim.studies.sweep_point import FAILURE, LOST, Outcome, Point

# Value that stands for a result that is not written yet or was lost. It is netCDF's fill value,
# which xarray reads as NaN.
UNWRITTEN = 9.969209968386869e36
ABANDONED = 60.0  # Age (s) at which an incomplete file counts as left behind by a killed program
BLOCK = 4096  # Largest number of points in a chunk, which is one file
GROUP = "zarr.json"  # Name of the file that describes a group or an array, in its folder

NOT_COMPUTED = "not computed"  # Reason for failure of points that are still to be computed

Shapes = Mapping[str, tuple[int, ...]]


class Results:
    """Results of a sweep: one array for each result, and one array with the reasons of failures.

    The first axes of every array are those of the grid of points. A point counts as computed when
    its reason is written; the reason is empty for a success.

    Attributes:
        grid: coordinates of the points.
        folder: folder in which the arrays are stored; None to keep them in memory.
        shapes: shape of each result at a single point, by name.
        arrays: the arrays, by name.
    """

    def __init__(self, grid: xr.Dataset, folder: Path | None) -> None:
        self.grid = grid
        self.folder = folder
        self.shapes: Shapes = {}
        self.arrays: dict[str, Any] = {}
        self._memory: dict[str, Any] = {}
        self._store = zarr.storage.MemoryStore(self._memory) if folder is None else folder
        if folder is not None:
            for partial in folder.rglob("*.partial"):
                with suppress(OSError):
                    if time.time() - partial.stat().st_mtime > ABANDONED:
                        partial.unlink()
            self.shapes = _described(folder)
        self._create({})

    def missing(self) -> NDArray[np.bool_]:
        """Return which points of the grid must be computed, as an array of booleans.

        They are the points that have not been computed, those whose worker was lost, and those
        whose stored data are damaged or absent. The number of points with damaged or absent data is
        logged.

        Raises:
            OSError: if a file cannot be read.
        """
        axes = len(self.grid.sizes)
        missing = np.zeros([*self.grid.sizes.values()], bool)
        lost = np.zeros_like(missing)
        for name, array in self.arrays.items():
            for corner in np.ndindex(array.cdata_shape):
                starts = np.multiply(corner, array.chunks)
                region = tuple(map(slice, starts, starts + array.chunks))
                points = region[:axes]
                try:
                    values = np.asarray(array[region])
                except (OSError, MemoryError):
                    raise
                except Exception:  # of the many kinds that codecs raise for damaged bytes
                    array[region] = array.fill_value
                    missing[points] = lost[points] = True
                    continue
                if name == FAILURE:
                    missing[points] = (values == NOT_COMPUTED) | np.strings.startswith(values, LOST)
                    continue
                absent = (values == UNWRITTEN).any(axis=tuple(range(axes, values.ndim)))
                lost[points] |= absent & ~missing[points]
                missing[points] |= absent
        if lost.any():
            words = "%s: number of damaged or lost points that are computed again: %d"
            logging.getLogger(__name__).warning(words, self.folder, lost.sum())
        return missing

    def write(self, outcomes: Sequence[tuple[Point, Outcome]]) -> None:
        """Write the results of some points, and after them the reasons of their failures.

        Raises:
            ValueError: if a result has the name of a parameter, or a name that an array must not
                have.
        """
        numbers = np.array([number for (number, _), _ in outcomes])
        reasons = np.array([reason for _, (_, reason) in outcomes], dtype=object)
        for _, (values, _) in outcomes:
            if new := {name: values[name].shape for name in values.keys() - self.shapes.keys()}:
                self._add(new)
        for name, inner in self.shapes.items():
            column = np.full((len(outcomes), *inner), math.nan)
            for i, (_, (values, _)) in enumerate(outcomes):
                value = values.get(name, column[i])
                if value.shape == inner:
                    column[i] = value
                else:
                    reasons[i] = f"{name} has the shape {value.shape}, at other points {inner}"
            self._put(name, numbers, column)
        self._put(FAILURE, numbers, reasons)

    def dataset(self, units: Mapping[str, str]) -> xr.Dataset:
        """Return the results on the grid as a Dataset.

        xarray reads the results when they are used, without Dask. The variables are sorted by name.
        ``units`` are the units of variables, by name.
        """
        stored: xr.Dataset = xr.open_zarr(self._store, chunks=None, consolidated=False)
        text = stored[FAILURE].astype(object)  # versions of xarray differ in the type they read
        found = stored.assign({FAILURE: text}).assign_coords(self.grid.coords)
        found = found[sorted(map(str, found.data_vars))]
        for name, each in found.variables.items():
            each.attrs = {"units": units[str(name)]} if name in units else {}
        found.attrs = self.grid.attrs
        return found

    def _add(self, new: Shapes) -> None:
        """Add arrays for new results; they are NaN at all points that were computed before."""
        for name in new:
            if name in {*self.grid.coords, *self.grid.sizes}:
                raise ValueError(
                    f"function: its result {name} must not have the name of a parameter or dimension"
                )
            check_name("function: its result", name)
        self._create(new)
        for name in new:
            self.arrays[name][...] = math.nan

    def _create(self, new: Shapes) -> None:
        """Write the metadata files that are absent or damaged, and open the arrays.

        ``new`` holds the shapes of results that are added, by name.

        Raises:
            OSError: if a file cannot be written. An error is ignored if the file exists already,
                since a folder on a full or read-only disk may hold all points.
        """
        self.shapes = dict(sorted({**self.shapes, **new}.items()))
        contents = self._contents()
        if self.folder is None:
            self._memory.update(contents)
        else:
            for name, content in contents.items():
                path = self.folder / name
                before = path.read_bytes() if path.exists() else None
                if before == content.to_bytes():
                    continue
                try:
                    path.parent.mkdir(parents=True, exist_ok=True)
                    with complete_or_absent(path) as partial:
                        partial.write_bytes(content.to_bytes())
                except OSError:
                    if before is None or new:
                        raise
        group = zarr.open_group(self._store, mode="r+")
        self.arrays = {name: group[name] for name in (FAILURE, *self.shapes)}

    def _contents(self) -> dict[str, Any]:
        """Return the contents of the metadata and coordinate files, by file name.

        The results themselves are not included. The shapes of all results and a checksum of these
        shapes are written twice: to the metadata of the folder, and to the metadata of the array
        that holds the reasons of failures.
        """
        contents = dict[str, Any]()
        memory = zarr.storage.MemoryStore(contents)
        shapes = json.dumps(self.shapes)
        attributes: dict[str, Any] = {"results": shapes, "checksum": zlib.crc32(shapes.encode())}
        words = {
            name: each.astype(str).astype(object)
            for name, each in self.grid.coords.items()
            if each.dtype == object
        }
        written = self.grid.assign_coords(words).assign_attrs(attributes)
        written.to_zarr(memory, mode="w", zarr_format=3, consolidated=False)
        group = zarr.open_group(memory, mode="r+")
        sizes = [*self.grid.sizes.values()]
        # A chunk holds consecutive points: all values of the last axes, a part of the axis before
        # them, and a single value of each earlier axis.
        after = [math.prod(sizes[axis + 1 :]) for axis in range(len(sizes))]
        chunk = [min(size, max(1, BLOCK // n)) for size, n in zip(sizes, after, strict=True)]
        for name, inner in {FAILURE: (), **self.shapes}.items():
            group.create_array(
                name,
                shape=(*sizes, *inner),
                chunks=(*chunk, *(max(1, size) for size in inner)),
                dtype=str if name == FAILURE else float,
                fill_value=NOT_COMPUTED if name == FAILURE else UNWRITTEN,
                compressors=[ZstdCodec(), Crc32cCodec()],
                dimension_names=[
                    *map(str, self.grid.sizes),
                    *(f"{name}_{axis}" for axis in range(len(inner))),
                ],
                attributes=attributes if name == FAILURE else {"missing_value": UNWRITTEN},
            )
        return contents

    def _put(self, name: str, numbers: NDArray[np.intp], values: NDArray[Any]) -> None:
        """Write the values of a result at some points.

        ``numbers`` are the indices of the points in the grid. zarr rewrites all chunks that hold
        these points.
        """
        array = self.arrays[name]
        inner = math.prod(values.shape[1:])
        if not array.shape:
            array[...] = values[0]
        elif values.size:
            places = (numbers[:, None] * inner + np.arange(inner)).ravel()
            array.vindex[np.unravel_index(places, array.shape)] = values.ravel()


def _described(folder: Path) -> Shapes:
    """Return the shapes of the results that a folder already holds, by name.

    Two files hold the shapes. They differ if a program was killed while it added a result. The file
    with more results is then right.
    """
    found: list[Shapes] = [{}]
    for path in (*folder.glob(GROUP), *folder.glob(f"{FAILURE}/{GROUP}")):
        try:
            attributes = json.loads(path.read_bytes())["attributes"]
            if zlib.crc32(attributes["results"].encode()) != attributes["checksum"]:
                raise ValueError(attributes["checksum"])
            shapes = json.loads(attributes["results"])
            found.append({name: tuple(inner) for name, inner in shapes.items()})
        except (ValueError, TypeError, KeyError, AttributeError):
            logging.getLogger(__name__).warning(
                "%s: its description was damaged and is made anew", path.parent
            )
    return max(found, key=len)


def check_name(role: str, name: str) -> None:
    """Check that a name is permitted for an array in a folder.

    ``role`` describes the name in the message.

    Raises:
        ValueError: for a name that is empty, unprintable or reserved.
    """
    reserved = name in ("", GROUP) or name.startswith((".", "__"))
    if reserved or "/" in name or not name.isprintable():
        rule = (
            "must have a name without / and unprintable letters, that begins with neither . nor __"
        )
        raise ValueError(f"{role} {name!r} {rule}")
