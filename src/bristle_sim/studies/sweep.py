"""Many points at once: a function of keyword arguments over named axes, on one core, on many or on a cluster.

joblib runs the points: in the calling process, in worker processes, or on the backend that ``joblib.parallel_config``
has made active, such as a Dask cluster; it sizes its batches by their measured duration. Its cache keeps finished points
on disk, each written whole by the process that computed it. xarray labels the results, which zarr stores.
"""

from __future__ import annotations

import functools
import itertools
import math
import os
import sys
from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import joblib
import numpy as np
import xarray as xr
import zarr
from joblib.parallel import AutoBatchingMixin, ParallelBackendBase, get_active_backend

from bristle_sim.studies.sweep_point import Outcome, check_arguments, described, evaluate_point, identity_of
from bristle_sim.studies.sweep_store import FAILURE, opened, write
from bristle_sim.units import shown

Outcomes = Generator[Outcome, None, None]

ATTEMPTS = 3
"""Losses of a worker in a row, with no result between them, after which it is the point's doing and not chance."""


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
    """Evaluate a function at every point of a space and return the labelled results.

    Args:
        function: takes keyword arguments and returns a number, a small array, or a mapping of names to such; None stands
            for NaN. ``functools.partial`` binds what is the same at every point. Other processes need it picklable.
        space: parameters as xarray takes coordinates. ``{"friction": [0.1, 0.2]}`` is an axis of its own;
            ``{"friction": ("sample", [...]), "restitution": ("sample", [...])}`` vary together, and an array with
            several dimensions, ``(("sample", "hub_speed"), array)``, varies along all of them. A number is one value for
            all points. The points are the product of all dimensions.
        units: of parameters and results, by name.
        workers: number of processes (-1: one a core), or a ``concurrent.futures.Executor``. By default the active joblib
            backend or, if none is, the calling process.
        store: folder, seen by all workers, that keeps finished points: the next call computes only what is missing. The
            results are written there block by block, and the Dataset returned reads them when they are used.
        version: tells results apart that differ by what is not seen in the function, its arguments, the functions and
            constants of its own module that it uses, and this package, e.g. the date of a file that it reads.
        progress: whether standard error shows a bar with the time left; by default where it is a terminal.

    Returns:
        float64 results on the grid of points, NaN where the function raised, and ``failure``, the exception in words. Its
        attributes say which function, with which settings and software. Neither the number of workers nor the order in
        which points are finished changes the results.

    Raises:
        ValueError: if the space is empty or holds anything but numbers and words, if the function does not take its
            names as arguments or cannot be pickled, or if workers is not a number or an executor.
        RuntimeError: if workers are killed time and again; finished points are kept.
    """
    grid, units = _grid(space), dict(units or {})
    number = isinstance(workers, int) and not isinstance(workers, bool) and workers != 0
    if not number and not isinstance(workers, Executor | None):
        raise ValueError(f"workers = {shown(workers)}: must be a whole number other than 0, an Executor or None")
    check_arguments(function, next(_points(grid)))
    grid.attrs = {**described(function), "version": version}
    identity = identity_of(function, version)
    if store is None:
        in_memory = zarr.storage.MemoryStore()
        outcomes = _outcomes(functools.partial(evaluate_point, function, identity), grid, workers)
        write(in_memory, grid, units, _counted(outcomes, grid, progress))
        return opened(in_memory).load()
    results = Path(store) / f"{joblib.hash((identity, grid.to_dict(), units))}.zarr"
    if not results.is_dir():
        cached = joblib.Memory(store, verbose=0).cache(evaluate_point, ignore=["function"])
        # The cache notes the source of evaluate_point here, before there are workers that would do so at the same time.
        cached.check_call_in_cache(function, identity, **next(_points(grid)))
        try:
            with TemporaryDirectory(dir=store, prefix="unfinished-") as folder:
                partial = Path(folder) / results.name
                outcomes = _outcomes(functools.partial(cached, function, identity), grid, workers)
                write(partial, grid, units, _counted(outcomes, grid, progress))
                if not results.is_dir():  # as another program that runs the same sweep may have made it
                    partial.rename(results)
        except KeyboardInterrupt:
            told = f"the points that are finished are kept in {store}; the same call computes the others"
            raise KeyboardInterrupt(told) from None
    return opened(results)


def _grid(space: Mapping[str, Any]) -> xr.Dataset:
    """The parameters as coordinates that span the grid."""
    try:
        grid = xr.Dataset(coords=getattr(space, "variables", space))
    except (TypeError, ValueError) as error:
        raise ValueError(f"space: must be coordinates as xarray.Dataset takes them ({error})") from error
    for name, values in grid.coords.items():
        if name == FAILURE:
            raise ValueError(f"space: {FAILURE} must not be a parameter, it is a result")
        if values.dtype.kind not in "biufUT":
            raise ValueError(f"space: {name} must hold numbers or words; functools.partial binds other arguments")
        if values.size == 0:
            raise ValueError(f"space: {name} must hold at least one value")
        if values.dtype.kind in "UT":  # zarr has no standard for words of a fixed width
            grid = grid.assign_coords({name: values.astype(object)})
    return grid


def _points(grid: xr.Dataset, start: int = 0) -> Iterator[dict[str, Any]]:
    """Arguments of every point from a start on, the last dimension running fastest."""
    dimensions = list(grid.sizes)
    parameters = [
        (str(name), coordinate.values, [dimensions.index(each) for each in coordinate.dims])
        for name, coordinate in grid.coords.items()
    ]
    for index in itertools.islice(np.ndindex(*grid.sizes.values()), start, None):
        yield {name: values.item(*(index[axis] for axis in axes)) for name, values, axes in parameters}


def _outcomes(call: Callable[..., Outcome], grid: xr.Dataset, workers: int | Executor | None) -> Outcomes:
    """Outcomes in the order of the points; after the loss of a worker, those still missing are requested again."""
    done, lost, total = 0, 0, math.prod(grid.sizes.values())
    while done < total:
        tasks = (joblib.delayed(call)(**arguments) for arguments in _points(grid, done))
        try:
            with closing(_parallel(workers)(tasks)) as outcomes:
                for outcome in outcomes:
                    done, lost = done + 1, 0
                    yield outcome
        except Exception as error:  # of joblib, executor or cluster; what a point raises is part of its outcome
            lost += 1
            if lost == ATTEMPTS:
                raise RuntimeError(
                    f"workers were lost {lost} times near the point {next(_points(grid, done))}; if memory is short try"
                    " fewer workers, if the point crashes its process leave it out"
                    f" ({' '.join(f'{type(error).__name__}: {error}'.split())[:200]})"
                ) from error


def _parallel(workers: int | Executor | None) -> joblib.Parallel:
    """joblib's scheduler for that many processes, for an executor or, for None, for the active backend.

    It puts as many points into a batch as take some tenths of a second.
    """
    client = getattr(get_active_backend()[0], "client", None) if workers is None else None
    if client is not None:  # joblib's backend for Dask would wait for ever for points that the cluster has given up
        workers = client.get_executor()
    if not isinstance(workers, Executor):
        return joblib.Parallel(n_jobs=workers, return_as="generator")
    # Calls that an executor runs at a time, as far as it says so; joblib would not use it for a single one.
    own = getattr(workers, "_client", None)
    told = getattr(workers, "_max_workers", 0) if own is None else sum(own.ncores().values())
    slots = max(2, int(told or os.cpu_count() or 2))
    backend = _ExecutorBackend(workers)
    return joblib.Parallel(slots, backend=backend, return_as="generator", pre_dispatch="4 * n_jobs")


class _ExecutorBackend(AutoBatchingMixin, ParallelBackendBase):  # type: ignore[misc]
    """An executor of concurrent.futures as a backend of joblib."""

    supports_retrieve_callback = True

    MIN_IDEAL_BATCH_DURATION, MAX_IDEAL_BATCH_DURATION = 2.0, 10.0
    """Duration that the size of batches aims at, s; it includes the wait for the batches before, four to a process."""

    def __init__(self, executor: Executor) -> None:
        super().__init__()
        self.executor = executor

    def effective_n_jobs(self, n_jobs: int) -> int:
        """Calls that run at the same time."""
        return n_jobs

    def submit(self, func: Callable[[], Any], callback: Callable[[Any], None]) -> Any:
        """Submit a batch of calls."""
        future = self.executor.submit(func)
        future.add_done_callback(callback)
        return future

    def retrieve_result_callback(self, out: Any) -> Any:
        """Results of a batch, or its exception."""
        return out.result()


def _counted(outcomes: Outcomes, grid: xr.Dataset, progress: bool | None) -> Outcomes:
    """Yield the outcomes, counted on standard error with the time left."""
    if not (sys.stderr.isatty() if progress is None else progress):
        return outcomes
    from tqdm import tqdm

    total = math.prod(grid.sizes.values())
    return (each for each in tqdm(outcomes, total=total, unit="point", file=sys.stderr))
