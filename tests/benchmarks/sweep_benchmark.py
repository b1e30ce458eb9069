"""Measure how many passes a second a sweep computes. ``python tests/benchmarks/sweep_benchmark.py --passes 10000``

In one process, in two of joblib's and on two of a Dask cluster, without and with a store. A small sweep before starts the
processes. All sweeps must give the same bits. Where other programs use the cores, only the CPU time says anything.
"""

from __future__ import annotations

import argparse
import functools
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import psutil  # type: ignore[import-untyped]
import xarray as xr

from bristle_sim.benchmarks.machine import surroundings
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_point import strike_of_keys
from bristle_sim.studies.sweep import sweep

RANGES = {"hub_speed": (250.0, 275.0), "friction": (0.1, 0.5), "penetration": (0.004, 0.005)}
"""Ends of the inputs' intervals, in rad/s, 1 and m, in which the bar cues every pass."""


@contextmanager
def _dask() -> Iterator[Any]:
    from distributed import Client, LocalCluster

    cluster = LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=2, threads_per_worker=1, protocol="tcp://", dashboard_address=":0", silence_logs=50
    )
    with cluster, Client(cluster) as client:  # type: ignore[no-untyped-call]
        yield client.get_executor()


@contextmanager
def _processes(number: int | None) -> Iterator[Any]:
    yield number


WAYS: dict[str, Callable[[], Any]] = {
    "serial": functools.partial(_processes, None),
    "loky": functools.partial(_processes, 2),
    "dask": _dask,
}
"""What runs the points: each gives the argument ``workers`` of a sweep."""


def measured(way: str, passes: int, store: Path | None = None) -> tuple[float, float, xr.Dataset]:
    """Return wall time and CPU time of a sweep of passes with inputs uniform in their intervals, s, and its results."""
    rng = np.random.default_rng(0)
    space = {name: ("sample", rng.uniform(low, high, passes)) for name, (low, high) in RANGES.items()}
    point = functools.partial(strike_of_keys, Settings())
    with WAYS[way]() as workers:
        sweep(point, {name: ("sample", values[:8]) for name, (_, values) in space.items()}, workers=workers)
        started, cpu = time.perf_counter(), _cpu()
        found = sweep(point, space, workers=workers, store=store, progress=False).load()
        return time.perf_counter() - started, _cpu() - cpu, found


def _cpu() -> float:
    """CPU time of this process and of all that it has started and that are alive, s."""
    own = psutil.Process()
    times = [each.cpu_times() for each in (own, *own.children(recursive=True))]
    return float(sum(each.user + each.system for each in times))


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the cost of each way, and the machine; the status is 1 where bits differ."""
    parser = argparse.ArgumentParser(prog="sweep_benchmark", description="Passes a second of a sweep.")
    parser.add_argument("--passes", type=int, default=2000)
    parser.add_argument("--ways", nargs="+", choices=[*WAYS], default=[*WAYS])
    options = parser.parse_args(arguments)
    print(f"{'way':<8}{'store':<7}{'wall, s':>9}{'CPU, s':>9}{'passes/s':>10}  same bits")
    first, same = None, True
    for stored in (False, True):
        for way in options.ways:
            with TemporaryDirectory() as folder:
                wall, cpu, found = measured(way, options.passes, Path(folder, "store") if stored else None)
            first = found if first is None else first
            same = same and (identical := found.equals(first))
            row = f"{way:<8}{'yes' if stored else 'no':<7}{wall:9.1f}{cpu:9.1f}{options.passes / wall:10.1f}"
            print(f"{row}  {'yes' if identical else 'no'}", flush=True)
    print(*(f"{name}: {value}" for name, value in surroundings().items()), sep="\n")
    return 0 if same else 1


if __name__ == "__main__":
    raise SystemExit(main())
