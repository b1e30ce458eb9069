"""A scenario's quantities over one or two of its keys: one table, with a reason at every point that has no result."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bristle_sim.comparison import Report
from bristle_sim.studies.sweep import sweep
from bristle_sim.studies.sweep_point import FAILURE

FORMULA = " by formula"  # Suffix of the name of a quantity's value by formula, within a sweep


def sweep_scenario(
    run: Callable[..., Report],
    axes: Mapping[str, Sequence[float]],
    *,
    units: Mapping[str, str] | None = None,
    workers: int | Executor | None = None,
    store: str | Path | None = None,
    progress: bool | None = None,
) -> xr.Dataset:
    """Run a scenario at every combination of the values of one or two keys, and return its quantities as one table.

    Args:
        run: takes the keys as keyword arguments and returns the scenario's report; the ValueError of a point is its reason.
        axes: the values of each key, in SI units; one key can be drawn as lines, two as maps.
        units: of the keys; those of the quantities come from the report.
        workers, store, progress: those of :func:`bristle_sim.sweep`, which raises the same errors.

    Returns:
        The simulated values of the report's quantities by name (by formula if never simulated; NaN if missing), with ``units``
        and ``long_name``; and ``failure``, the reason why a point lacks some: the error, or the report's answer."""
    if len(axes) not in (1, 2):
        raise ValueError(f"axes = {', '.join(axes) or 'none'}: must be one key or two")
    space = {key: np.asarray(values, dtype=float) for key, values in axes.items()}
    options: dict[str, Any] = {"units": units, "workers": workers, "store": store, "progress": progress}
    found = sweep(functools.partial(_quantities, run), space, **options).load()
    known = [np.isfinite(each.values) for name, each in found.data_vars.items() if name != FAILURE]
    finished = np.argwhere(np.any(known, axis=0))
    if finished.size:  # a report there knows labels and units
        point = {key: float(values[i]) for (key, values), i in zip(space.items(), finished[0], strict=True)}
        quantities = run(**point).quantities
        for each in quantities:
            if each.name + FORMULA in found and not np.isfinite(found[each.name]).any():
                found[each.name] = found[each.name + FORMULA]
            found[each.name].attrs = {"units": each.unit, "long_name": each.label}
        found = found[[*(each.name for each in quantities), FAILURE]]
        complete = np.all([np.isfinite(found[each.name].values) for each in quantities], axis=0)
        found[FAILURE] = found[FAILURE].where(~complete, "")
    return found


def _quantities(run: Callable[..., Report], /, **keys: float) -> dict[str, float | str | None]:
    """Return the values of a report, those by formula of quantities that are not simulated, and why some may be missing."""
    report = run(**keys)
    values: dict[str, Any] = {each.name: each.simulated for each in report.quantities}
    formulas = {each.name + FORMULA: each.theory for each in report.quantities if each.simulated is None}
    return values | formulas | {FAILURE: (report.answer or report.outcome) if None in values.values() else ""}
