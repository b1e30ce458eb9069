"""Which tolerance matters: inputs spread about their values, and how the strike spreads with them.

Every input is uniform within its half-width about its value, independent of the others. For small spreads the standard
deviation is that of first-order error propagation, sqrt(sum (dy/dx_i sigma_i)^2).

Sobol indices divide the variance of every output among the inputs. Two samples A and B of a scrambled Sobol sequence, and A
with the columns of B one at a time, give Saltelli's estimate of the first-order index V(E(y|x_i))/V(y), the fraction of the
variance that would vanish if x_i were known, and of the total index E(V(y|all but x_i))/V(y), the fraction in which x_i has a
part (``scipy.stats.sobol_indices``).
"""

from __future__ import annotations

import dataclasses
import functools
import math
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import sobol_indices
from scipy.stats.qmc import Sobol

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, Unfinished, amount
from bristle_sim.parameters import Sampling, Spreads, Tool, tool_keys
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_measures import IMPACT, STATE
from bristle_sim.studies.strike_point import STRIKE_UNITS, strike_of_keys
from bristle_sim.units import Range

Measures = Mapping[str, float | None]

OUTPUTS = tuple(name for name in STRIKE_UNITS if name != "normal_compressive_work")

# Percentiles between which outputs and indices lie with a probability of 95 %
ENDS = (50.0 * (1.0 - 0.95), 50.0 * (1.0 + 0.95))
RESAMPLES = 200  # Bootstrap resamples; the ends of a 95 % interval then rest on five of them each


@dataclass(frozen=True, slots=True)
class Study:
    """Outputs of all samples, shape (outputs, 2 samples), their indices, (outputs, inputs), and intervals, (outputs, inputs, 2)."""

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    values: Array
    first_order: Array
    total: Array
    first_order_interval: Array
    total_interval: Array

    def rows(self, propagated_std: Mapping[str, float]) -> list[dict[str, Any]]:
        """Return one row an output, in plain numbers."""
        names = ("first_order", "first_order_interval", "total", "total_interval")
        found = []
        for number, (output, values) in enumerate(zip(self.outputs, self.values, strict=True)):
            low, high = np.percentile(values, ENDS).tolist()
            row = {"output": output, "mean": float(values.mean()), "std": float(values.std(ddof=1))}
            row |= {"std_first_order": propagated_std.get(output), "low": low, "high": high}
            columns = (getattr(self, name)[number].tolist() for name in names)
            indices = [dict(zip(names, each, strict=True)) for each in zip(*columns, strict=True)]
            found.append(row | {"indices": dict(zip(self.inputs, indices, strict=True))})
        return found


def tolerances(tool: Tool, spreads: Spreads, sampling: Sampling, settings: Settings) -> Report:
    """Spread the inputs of a pass, and report the spread of its strike and the inputs that cause it.

    Raises:
        ValueError: if somewhere in the intervals the bar cues no strike, or the extra ``sweep`` is not installed.
        Unfinished: with mean and standard deviation of the passes that are finished, if the user interrupts.
    """
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: must both be parts of the tool")
    started = clock.perf_counter()
    intervals = _intervals(tool, spreads)
    point = functools.partial(strike_of_keys, settings, tool)
    options: dict[str, Any] = {
        "seed": sampling.seed,
        "workers": None if sampling.workers == 1 else sampling.workers,
    }
    try:
        study = sobol_study(point, intervals, OUTPUTS, sampling.samples, **options)
    except KeyboardInterrupt as ended:
        raise Unfinished(
            _unfinished(getattr(ended, "results", {}), (len(intervals) + 2) * sampling.samples)
        ) from None
    middles = {key: 0.5 * (low + high) for key, (low, high) in intervals.items()}
    changes = propagated(
        point, middles, {key: high - middles[key] for key, (_, high) in intervals.items()}
    )
    std = {
        name: math.sqrt(sum(each**2 for each in parts.values()) / 3.0)
        for name, parts in changes.items()
    }
    rows = study.rows(std)
    quantities = []
    for row in rows:
        name = row["output"]
        unit = STRIKE_UNITS[row["output"]]
        quantities.append(Quantity(f"{name}_mean", unit, row["mean"]))
        quantities.append(Quantity(f"{name}_std", unit, row["std"], row["std_first_order"]))
    return Report(
        quantities=tuple(quantities),
        wall_s=clock.perf_counter() - started,
        remarks=_remarks(rows),
        extra={"rows": rows},
        subject=study,
        answer=answer(rows),
    )


def _unfinished(results: Mapping[str, Any], total: int) -> Report:
    """Return mean and standard deviation of the outputs at the points that are finished."""
    known = {name: results[name].values for name in OUTPUTS if name in results}
    finished = np.isfinite(list(known.values())).all(axis=0)
    number = int(finished.sum()) if known else 0
    found = list[Quantity]()
    for name, each in known.items() if number > 1 else ():
        found.append(Quantity(f"{name}_mean", STRIKE_UNITS[name], float(each[finished].mean())))
        found.append(Quantity(f"{name}_std", STRIKE_UNITS[name], float(each[finished].std(ddof=1))))
    return Report(
        None,
        tuple(found),
        remarks=(f"{number} of {total} passes are finished; indices need all of them",),
    )


def answer(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the input that ranks first for most outputs, and by how much speed and impulse of the strike spread."""
    ranked = [_ranked(row)[0] for row in rows]
    spreads = []
    most = max(ranked, key=ranked.count)
    for row, first in zip(rows, ranked, strict=True):
        if row["output"] in STATE | IMPACT:
            label, unit = (STATE | IMPACT)[row["output"]]
            spreads.append(
                f"{label} {amount(row['mean'], unit)} by {amount(row['std'], unit, 2)} (mostly {first})"
            )
    ranks = f"{most} matters most: it ranks first for {ranked.count(most)} of {len(rows)} measures of the strike"
    return f"{ranks[0].upper()}{ranks[1:]}. Standard deviations: {'; '.join(spreads)}."


def propagated(
    function: Callable[..., Measures], values: Mapping[str, float], half_widths: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    """Return half the change of every output between both ends of each input's interval, the others at their values.

    For small half-widths h_i it is dy/dx_i h_i; uniform inputs then give the standard deviation sqrt(sum (.)^2/3).
    """
    changes: dict[str, dict[str, float]] = {}
    for key, half_width in half_widths.items():
        low, high = (
            function(**{**values, key: values[key] + sign * half_width}) for sign in (-1.0, 1.0)
        )
        for name, value in high.items():
            if value is not None and (other := low[name]) is not None:
                changes.setdefault(name, {})[key] = 0.5 * (value - other)
    return changes


def _intervals(tool: Tool, spreads: Spreads) -> dict[str, tuple[float, float]]:
    """Return the ends of every input's interval, cut off at the bounds of its range."""
    found = dict[str, tuple[float, float]]()
    places = {
        key: (part, *place) for part, keys in tool_keys().items() for key, place in keys.items()
    }
    for key, half_width in dataclasses.asdict(spreads).items():
        part, name, declared = places[key]
        if half_width:
            assert isinstance(declared, Range)
            middle = float(getattr(getattr(tool, part) if part else tool, name))
            found[key] = (
                max(declared.lowest, middle - half_width),
                min(declared.highest, middle + half_width),
            )
    if not found:
        raise ValueError("spread_...: at least one must be more than 0, or nothing is spread")
    return found


def _remarks(rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    lines = [
        "theory: first-order error propagation; the inputs that matter most, by their total Sobol index:"
    ]
    for row in rows:
        first = ", ".join(f"{key} {row['indices'][key]['total']:.2f}" for key in _ranked(row)[:3])
        lines.append(f"{row['output']:<26} {first}")
    return tuple(lines)


def _ranked(row: Mapping[str, Any]) -> list[str]:
    """Return the inputs, that of the largest total index first."""
    return sorted(row["indices"], key=lambda key: -float(row["indices"][key]["total"]))


def sobol_study(
    function: Callable[..., Measures],
    intervals: Mapping[str, tuple[float, float]],
    outputs: Sequence[str],
    samples: int,
    *,
    seed: int = 1,
    workers: int | None = None,
) -> Study:
    """Evaluate a function of keyword arguments on Saltelli's samples and estimate the Sobol indices of its outputs.

    Function and workers are those of ``sweep``; each argument is uniform in its interval, and there are at least two outputs.
    The number of samples is a power of 2. The seed sets the sequence's scrambling and the bootstrap; scipy's own bootstrap
    takes none.

    Raises:
        ValueError: if the function has no result somewhere in the intervals, or the extra ``sweep`` is not installed.
        SweepInterrupted: if the user interrupts, with the points that are finished.
    """
    inputs = len(intervals)
    random = np.random.default_rng(seed)
    low, high = np.array(list(intervals.values())).T[:, :, np.newaxis]
    fractions = (
        Sobol(2 * inputs, seed=random, bits=64).random(samples).T.reshape(2, inputs, samples)
    )
    first, second = low + (high - low) * fractions
    mixed = np.tile(first, (inputs, 1, 1))
    mixed[np.arange(inputs), np.arange(inputs)] = second
    points = dict(zip(intervals, np.concatenate([first, second, *mixed], axis=1), strict=True))
    values = _swept(function, points, outputs, workers).reshape(len(outputs), inputs + 2, samples)

    def indices(chosen: NDArray[np.intp]) -> list[Array]:
        """Return first-order and total indices by some points of each sample, shape (outputs, inputs)."""
        of_mixed = np.moveaxis(values[:, 2:, chosen], 1, 0)
        func = {"f_A": values[:, 0, chosen], "f_B": values[:, 1, chosen], "f_AB": of_mixed}
        found = sobol_indices(func=func, n=samples)
        return [
            np.reshape(each, (len(outputs), inputs))
            for each in (found.first_order, found.total_order)
        ]

    resampled = [indices(chosen) for chosen in random.integers(0, samples, (RESAMPLES, samples))]
    ends: Array = np.moveaxis(np.percentile(resampled, ENDS, axis=0), 0, -1)
    both = values[:, :2].reshape(len(outputs), -1)
    return Study(tuple(intervals), tuple(outputs), both, *indices(np.arange(samples)), *ends)


def _swept(
    function: Callable[..., Measures],
    inputs: Mapping[str, Array],
    outputs: Sequence[str],
    workers: int | None,
) -> Array:
    """Return the outputs, shape (outputs, points), for inputs of shape (points)."""
    try:
        from bristle_sim.studies.sweep import sweep
    except ImportError as error:
        raise ValueError(
            f"tolerances need the extra sweep: pip install bristle-sim[sweep] ({error})"
        ) from error
    found = sweep(
        function, {name: ("sample", values) for name, values in inputs.items()}, workers=workers
    )
    unknown = np.full(found.sizes["sample"], math.nan)
    values = np.array([found[name].values if name in found else unknown for name in outputs])
    lost = ~np.isfinite(values).all(axis=0)
    if lost.any():
        where = int(np.argmax(lost))
        reason = (
            str(found["failure"].values[where])
            or f"no {', '.join(set(outputs) - {*found}) or 'number'}"
        )
        point = ", ".join(f"{name} = {column[where]:.6g}" for name, column in inputs.items())
        raise ValueError(
            f"spreads: must be smaller, {int(lost.sum())} of {lost.size} points have no result; at {point}: {reason}"
        )
    return values
