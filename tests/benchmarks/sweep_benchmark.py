"""Measure how many passes a second a sweep computes. ``python tests/benchmarks/sweep_benchmark.py --passes 10000``

In one process, in two that joblib starts (loky), and on two of a Dask cluster behind TCP; with and without a store. A first
small sweep starts the processes and imports what they need; it is timed by itself. All sweeps must give the same bits.

Where other programs use the cores, wall time depends on them, the processors' time hardly. Two idle cores can be faster than
one by at most ``2 * serial CPU time / CPU time of all processes``, this one included.
"""

from __future__ import annotations

import argparse
import functools
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import psutil  # type: ignore[import-untyped]
import xarray as xr

from bristle_sim.benchmarks.machine import surroundings
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_point import STRIKE_UNITS, strike_of_keys
from bristle_sim.studies.sweep import sweep

PROCESSES = 2

WARM_UP = 8
"""Passes of the first sweep, enough for a batch in each process."""

RANGES = {"hub_speed": (250.0, 275.0), "friction": (0.1, 0.5), "penetration": (0.004, 0.005)}
"""Ends of the inputs' intervals, in rad/s, 1 and m, in which the bar cues every pass."""


class Cost(NamedTuple):
    """Durations in s of a sweep: of its first points, of all of them, and the CPU time of its processes; its results."""

    start_up: float
    wall: float
    cpu: float
    found: xr.Dataset


@contextmanager
def _serial() -> Iterator[Any]:
    yield None


@contextmanager
def _loky() -> Iterator[Any]:
    from joblib.externals.loky import get_reusable_executor

    yield PROCESSES
    get_reusable_executor().shutdown(wait=True)


@contextmanager
def _dask() -> Iterator[Any]:
    from distributed import Client, LocalCluster

    cluster = LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=PROCESSES, threads_per_worker=1, protocol="tcp://", dashboard_address=":0", silence_logs=50
    )
    with cluster, Client(cluster) as client:  # type: ignore[no-untyped-call]
        yield client.get_executor()


WAYS: dict[str, Callable[[], Any]] = {"serial": _serial, "loky": _loky, "dask": _dask}
"""What runs the points: each gives the argument ``workers`` of a sweep, and ends its processes."""


def space(passes: int) -> dict[str, Any]:
    """Inputs of so many passes, uniform in their intervals."""
    rng = np.random.default_rng(0)
    return {name: ("sample", rng.uniform(low, high, passes)) for name, (low, high) in RANGES.items()}


def measured(way: str, passes: int, store: Path | None = None) -> Cost:
    """Sweep a number of passes by a way, and return what it cost."""
    run = functools.partial(sweep, functools.partial(strike_of_keys, Settings()), units=STRIKE_UNITS, progress=False)
    begin = time.perf_counter()
    with WAYS[way]() as workers:
        run(space(WARM_UP), workers=workers)
        started, cpu = time.perf_counter(), _cpu()
        found = run(space(passes), workers=workers, store=store)
        wall = time.perf_counter() - started
        return Cost(started - begin, wall, _cpu() - cpu, found.load())


def _cpu() -> float:
    """CPU time of this process and of all that it has started and that are alive, s."""
    own = psutil.Process()
    times = [each.cpu_times() for each in (own, *own.children(recursive=True))]
    return float(sum(each.user + each.system for each in times))


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what was measured, on what, and how to measure it again; the status is 1 where bits differ."""
    parser = argparse.ArgumentParser(prog="sweep_benchmark", description="Passes a second of a sweep.")
    parser.add_argument("--passes", type=int, default=2000)
    parser.add_argument("--ways", nargs="+", choices=[*WAYS], default=[*WAYS], help="serial is always measured first")
    parser.add_argument("--no-store", action="store_true", help="without the sweeps that keep their points on disk")
    options = parser.parse_args(arguments)
    if options.passes < 1:
        parser.error(f"--passes = {options.passes}: must be at least 1")
    ways = ["serial", *(each for each in options.ways if each != "serial")]
    print(f"{'way':<8}{'store':<7}{'start-up, s':>12}{'wall, s':>9}{'CPU, s':>9}{'passes/s':>10}", end="")
    print(f"{'ratio, wall':>13}{'ratio, CPU':>12}  same bits")
    first, same = None, True
    for stored in (False,) if options.no_store else (False, True):
        serial = None
        for way in ways:
            with TemporaryDirectory() as folder:
                cost = measured(way, options.passes, Path(folder, "store") if stored else None)
            first, serial = first or cost, serial or cost
            same = same and (identical := cost.found.identical(first.found))
            at_best = (1 if way == "serial" else PROCESSES) * serial.cpu / cost.cpu
            print(f"{way:<8}{'yes' if stored else 'no':<7}{cost.start_up:12.1f}{cost.wall:9.1f}{cost.cpu:9.1f}", end="")
            print(f"{options.passes / cost.wall:10.1f}{serial.wall / cost.wall:13.2f}{at_best:12.2f}", end="  ")
            print("yes" if identical else "no", flush=True)
    for name, value in surroundings().items():
        print(f"{name}: {value}")
    print(", ".join(f"{each} {metadata.version(each)}" for each in ("joblib", "distributed", "xarray", "zarr")))
    print(f"command: python tests/benchmarks/sweep_benchmark.py --passes {options.passes}")
    return 0 if same else 1


if __name__ == "__main__":
    raise SystemExit(main())
