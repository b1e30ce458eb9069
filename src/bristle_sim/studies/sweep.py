"""Evaluate a function of keyword arguments over named axes, on one core, on many, or on a cluster.

The points are evaluated in the calling process, in joblib's processes (loky), in threads or on a
Dask cluster. The calling process alone writes the results of finished points to a store, as data
and never as pickles. xarray labels and reads these results.
"""

import inspect
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import closing
from importlib import metadata
from numbers import Integral
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import xarray as xr
from numpy.typing import NDArray
from tqdm import tqdm

from bristle_sim.studies.sweep_identity import identity_of, name_of
from bristle_sim.studies.sweep_point import FAILURE, Outcome, Point
from bristle_sim.studies.sweep_store import BLOCK, Results, check_name
from bristle_sim.studies.sweep_workers import Outcomes, client_of, evaluated
from bristle_sim.units import shown

# Time between two writes of finished points, s. A killed program loses the points finished since
# the last write.
WRITTEN_EVERY = 1.0
# Time after which a sweep shows its progress, s; if standard error is no terminal, also the time
# between two lines
PATIENCE = 5.0
MOST_WORKERS = 1024  # Largest number of processes: more than a computer has cores


def sweep(
    function: Callable[..., Any],
    space: Mapping[str, Any],
    *,
    units: Mapping[str, str] | None = None,
    workers: int | Executor | None = None,
    store: str | Path | None = None,
    version: str = "",
    progress: bool | None = None,
) -> xr.Dataset:
    """Evaluate a function at every point of a parameter space and return the labelled results.

    Args:
        function: takes keyword arguments and returns a number, a small array, or a mapping of names
            to these. None means NaN; ``failure`` in a mapping is the reason for missing results.
            ``functools.partial`` binds constant arguments. The function must be picklable if other
            processes evaluate it.
        space: parameters in the form of xarray's coordinates. ``{"friction": [0.1, 0.2]}`` is an
            axis of its own. ``{"friction": ("sample", [...]), "restitution": ("sample", [...])}``
            vary together. An array with several dimensions, ``(("sample", "hub_speed"), array)``,
            varies along all of them. A number is one value for all points. The points are the
            product of all dimensions.
        units: units of parameters and results, by name.
        workers: number of processes (-1: one per core), a Dask client or its executor, or another
            ``concurrent.futures.Executor``. By default the calling process evaluates the points.
        store: folder that keeps finished points. The same call later computes only the points that
            are missing, damaged or lost. The returned Dataset loads results lazily. The folder
            holds data alone: reading another person's folder runs no code.
        version: any word. Change it when results change for a reason that a store does not notice.
            A store notices changes of the function's module or package, of the values bound to the
            function, and of this package, NumPy, SciPy and pymunk. It does not notice changes of
            other modules, of files that the function reads, or of globals set as the program runs.
        progress: whether to show a bar with the time left on standard error. By default it appears
            after five seconds.

    Returns:
        The results on the grid of points, as float64, and the variable ``failure``. Where the
        function raised an error, the results are NaN and ``failure`` has the reason in words. The
        attributes of the Dataset name the function, its bound values and the software. The results
        do not depend on the number of workers or the order in which points finish.

    Raises:
        ValueError: if the space is empty or holds anything but numbers and words; if the function
            does not take the names of the space as arguments, is bound to objects whose changes a
            store cannot notice, or cannot be sent to the workers; if a name is not permitted for an
            array; or if ``workers`` or ``store`` is invalid.
        OSError: if the store cannot be read or written. Stored points are kept.
        RuntimeError: if the workers do not answer any more. Finished points are kept. A point whose
            worker is lost repeatedly is a failure; the next call on the same store computes it
            again.
    """
    grid = _grid(space)
    _check(function, next(_points(grid, np.zeros(1, int)))[1], workers, store)
    software = ", ".join(
        f"{name} {metadata.version(name)}" for name in ("bristle_sim", "numpy", "pymunk", "scipy")
    )
    bound = {name: str(value) for name, value in getattr(function, "keywords", {}).items()}
    grid.attrs = {"function": name_of(function), **bound, "software": software, "version": version}
    folder = None
    if store is not None:
        coordinates = {name: (each.dims, each.values) for name, each in grid.coords.items()}
        identity = (identity_of(function, version), coordinates, dict(grid.sizes))
        folder = Path(store) / f"{joblib.hash(identity, 'sha1')}.zarr"
    results = Results(grid, folder)
    numbers = np.flatnonzero(results.missing())
    if numbers.size:
        outcomes = evaluated(function, _points(grid, numbers), workers)
        _write(results, outcomes, numbers.size, progress)
    found = results.dataset(units or {})
    return found.load() if folder is None else found


def _check(
    function: Callable[..., Any], arguments: Mapping[str, Any], workers: Any, store: Any
) -> None:
    """Check the arguments of a sweep.

    Raises:
        ValueError: if ``workers`` or ``store`` is invalid, or if ``function`` does not take the
            names in ``arguments`` as keywords.
    """
    pool = isinstance(workers, Executor | None) or client_of(workers) is not None
    number = isinstance(workers, Integral) and not isinstance(workers, bool)
    if not pool and not (number and workers and workers <= MOST_WORKERS):
        allowed = f"a whole number other than 0 of at most {MOST_WORKERS}, an Executor, a Dask client or None"
        raise ValueError(f"workers = {shown(workers)}: must be {allowed}")
    if store is not None and (
        not str(store) or not isinstance(store, str | Path) or Path(store).is_file()
    ):
        raise ValueError(f"store = {shown(store)}: must be the name of a folder")
    if not callable(function):
        raise ValueError(f"function = {shown(function)}: must be callable")
    try:
        inspect.signature(function).bind(**arguments)
    except ValueError:  # some built-in functions have no signature
        return
    except TypeError as error:
        raise ValueError(
            f"space: must have the arguments of {name_of(function)} ({error})"
        ) from error


def _grid(space: Mapping[str, Any]) -> xr.Dataset:
    """Return the grid of a sweep's points as the coordinates of a Dataset.

    ``space`` holds the parameters, as for :func:`sweep`. A list that mixes numbers and words keeps
    their types, unlike a NumPy array.
    """

    def typed(values: Any) -> Any:
        """Return a list of numbers and words as an array of objects, any other value unchanged."""
        if isinstance(values, tuple) and len(values) > 1:
            return (values[0], typed(values[1]), *values[2:])
        words = isinstance(values, list) and np.asarray(values).dtype.kind == "U"
        return np.array(values, dtype=object) if words else values

    try:
        grid = xr.Dataset(coords={name: typed(values) for name, values in space.items()})
    except (AttributeError, TypeError, ValueError) as error:
        raise ValueError(
            f"space: must be coordinates as xarray.Dataset takes them ({error})"
        ) from error
    for name, values in grid.coords.items():
        check_name("space: its parameter", str(name))
        if FAILURE in (name, *values.dims):
            raise ValueError(f"space: {FAILURE} must not be a parameter, it is a result")
        if not all(isinstance(each, str | int | float) for each in values.values.ravel().tolist()):
            raise ValueError(
                f"space: {name} must hold numbers or words; functools.partial binds other arguments"
            )
        if values.size == 0:
            raise ValueError(f"space: {name} must hold at least one value")
        if values.dtype.kind in "UT":  # zarr has no standard for words of a fixed width
            grid = grid.assign_coords({name: values.astype(object)})
    return grid


def _points(grid: xr.Dataset, numbers: NDArray[np.intp]) -> Iterator[Point]:
    """Yield some points of the grid, each with its index and its arguments.

    ``numbers`` are the indices. The last dimension of the grid varies fastest.
    """
    columns = {
        str(name): each.variable.set_dims(dict(grid.sizes)).values
        for name, each in grid.coords.items()
    }
    for number in map(int, numbers):
        yield number, {name: values.item(number) for name, values in columns.items()}


def _write(results: Results, outcomes: Outcomes, total: int, progress: bool | None) -> None:
    """Collect the outcomes of points as they arrive, and write them to ``results`` periodically.

    ``total`` is the number of points; ``progress`` is the argument of :func:`sweep`. If the
    evaluation ends with an error, the outcomes that arrived before the error are also written.
    """
    finished = list[tuple[Point, Outcome]]()
    written = time.perf_counter()
    options = {
        "disable": progress is False,
        "delay": 0.0 if progress else PATIENCE,
        "mininterval": 0.1 if sys.stderr.isatty() else PATIENCE,
    }
    with closing(outcomes), tqdm(total=total, unit="point", **options) as bar:
        try:
            for outcome in outcomes:
                finished.append(outcome)
                bar.update()
                if len(finished) == BLOCK or time.perf_counter() - written > WRITTEN_EVERY:
                    results.write(finished)
                    # The list is emptied only now, so that an interrupted write is repeated below.
                    finished = []
                    written = time.perf_counter()
        finally:
            if finished:
                results.write(finished)
