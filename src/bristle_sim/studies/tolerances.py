"""Which tolerance matters: the inputs of a pass vary about their values, and the study shows how
much the strike varies.

Every input x_i is uniformly distributed in an interval about its value, independently of the other
inputs. In small intervals the standard deviation of an output y is that of first-order error
propagation, sqrt(sum_i (dy/dx_i sigma_i)^2), where sigma_i is the standard deviation of x_i.

Sobol indices divide the variance V(y) of every output among the inputs. The first-order index
V(E(y|x_i))/V(y) is the fraction of the variance that would vanish if x_i alone were known. The
total index E(V(y|all but x_i))/V(y) is the fraction that would remain if all other inputs were
known. Saltelli's method estimates both from two samples A and B of a scrambled Sobol sequence, and
from copies of A in which one column is replaced by that of B (``scipy.stats.sobol_indices``).
Several sequences with independent scramblings are used; the scatter of their estimates gives the
confidence intervals.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import os
import time as clock
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import sobol_indices, t
from scipy.stats.qmc import Sobol

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import KEYS, Sampling, Spreads, Tool
from bristle_sim.passes.request import key_values
from bristle_sim.readable import amount
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import bar_of
from bristle_sim.studies.many_passes import checked_by_scene, values_at
from bristle_sim.studies.strike_measures import IMPACT, STATE
from bristle_sim.studies.strike_point import STRIKE_UNITS, strikes_of_keys
from bristle_sim.studies.sweep_point import FAILURE

Measures = Mapping[str, NDArray[Any]]

OUTPUTS = tuple(name for name in STRIKE_UNITS if name != "normal_compressive_work")

# The two percentiles between which an output lies with a probability of 95 %
ENDS = (50.0 * (1.0 - 0.95), 50.0 * (1.0 + 0.95))
# Number of independently scrambled sequences. Student's t makes the confidence interval of their
# mean 9 % wider than it would be if the variance were known exactly.
SEQUENCES = 16
# Number of passes that are computed in one call. Their arrays fit into the processor's cache. In
# calls of twice this size each pass takes a fifth longer.
BATCH = 8192


@dataclass(frozen=True, slots=True)
class Study:
    """Sobol indices of a function's outputs, with the sampled outputs.

    Attributes:
        inputs: names of the inputs.
        outputs: names of the outputs.
        values: outputs at the n points of sample A, followed by those of sample B, shape (outputs,
            2 n).
        first_order, total: first-order and total Sobol indices, shape (outputs, inputs).
        first_order_interval, total_interval: bounds of their 95 % confidence intervals, shape
            (outputs, inputs, 2).
    """

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    values: Array
    first_order: Array
    total: Array
    first_order_interval: Array
    total_interval: Array

    def rows(self, changes: Mapping[str, Mapping[str, float]]) -> list[dict[str, Any]]:
        """Return one dictionary for each output: mean, standard deviation, 95 % range and indices.

        ``changes`` are the effects of each input on each output by first-order error propagation,
        as returned by :func:`propagated`.
        """
        names = ("first_order", "first_order_interval", "total", "total_interval")
        found = []
        for number, (output, values) in enumerate(zip(self.outputs, self.values, strict=True)):
            low, high = np.percentile(values, ENDS).tolist()
            parts = changes.get(output)
            indices = {
                key: {name: getattr(self, name)[number, place].tolist() for name in names}
                for place, key in enumerate(self.inputs)
            }
            found.append(
                {
                    "output": output,
                    "mean": float(values.mean()),
                    "std": float(values.std(ddof=1)),
                    "std_first_order": parts and math.hypot(*parts.values()) / math.sqrt(3.0),
                    "low": low,
                    "high": high,
                    "indices": indices,
                }
            )
        return found


def tolerances(tool: Tool, spreads: Spreads, sampling: Sampling, settings: Settings) -> Report:
    """Vary the inputs of a pass randomly, and report how much the strike varies and which inputs
    cause it.

    ``spreads`` holds the half-widths of the inputs' intervals, ``sampling`` the number of samples.

    Raises:
        ValueError: if for some inputs in the intervals the bristle does not strike after leaving
            the bar.
    """
    bar_of(tool)
    started = clock.perf_counter()
    intervals = _intervals(tool, spreads)
    function = functools.partial(strikes_of_keys, settings, tool)
    study = sobol_study(function, intervals, OUTPUTS, sampling.samples, seed=sampling.seed)
    rows = study.rows(propagated(function, intervals))
    quantities = []
    for row in rows:
        name = row["output"]
        unit = STRIKE_UNITS[name]
        quantities.append(Quantity(f"{name}_mean", unit, row["mean"]))
        quantities.append(Quantity(f"{name}_std", unit, row["std"], row["std_first_order"]))
    values_of = functools.partial(values_at, intervals)
    check = checked_by_scene(tool, settings, np.full(len(intervals), 0.5), values_of)
    return Report(
        quantities=tuple(quantities),
        wall_s=clock.perf_counter() - started,
        remarks=_remarks(rows),
        extra={"rows": rows},
        subject=study,
        answer=f"{answer(rows)}; {check}.",
    )


def answer(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return in words how much each measure of the strike varies, and which input matters most for
    it.
    """
    measures = STATE | IMPACT
    leading = dict[str, list[str]]()
    spreads = []
    for row in rows:
        if row["output"] in measures:
            label, unit = measures[row["output"]]
            leading.setdefault(_ranked(row)[0], []).append(label)
            spreads.append(f"{label} {amount(row['mean'], unit)} ± {amount(row['std'], unit, 2)}")
    ordered = sorted(leading.items(), key=lambda item: -len(item[1]))
    ranks = "; ".join(f"{key} matters most for {', '.join(labels)}" for key, labels in ordered)
    return f"{ranks[0].upper()}{ranks[1:]}. Mean ± standard deviation: {'; '.join(spreads)}"


def propagated(
    function: Callable[..., Measures], intervals: Mapping[str, tuple[float, float]]
) -> dict[str, dict[str, float]]:
    """Return the effect of each input on each output, by name of the output and of the input.

    The effect is half the change of the output y from the lower to the upper bound of the input's
    interval, with the other inputs in the middle of their intervals. For a small half-width h_i the
    effect is h_i dy/dx_i. The standard deviation of y for uniformly distributed inputs is then the
    square root of a third of the sum of the squared effects. An output without a value is left out.
    """
    fractions = np.full((len(intervals), len(intervals), 2), 0.5)
    for number in range(len(intervals)):
        fractions[number, number] = (0.0, 1.0)
    found = function(**values_at(intervals, fractions))
    return {
        name: dict(zip(intervals, (0.5 * np.diff(values)[:, 0]).tolist(), strict=True))
        for name, values in found.items()
        if values.dtype.kind == "f" and np.isfinite(values).all()
    }


def _intervals(tool: Tool, spreads: Spreads) -> dict[str, tuple[float, float]]:
    """Return the lower and upper bound of each input, by name.

    The bounds do not exceed the permitted range of the input.
    """
    found = {}
    for key, half_width in dataclasses.asdict(spreads).items():
        if half_width:
            middle = key_values(tool)[key]
            bounds = KEYS[key]
            found[key] = (
                max(bounds.lowest, middle - half_width),
                min(bounds.highest, middle + half_width),
            )
    if not found:
        raise ValueError("spread_...: at least one must be more than 0, or nothing varies")
    return found


def _remarks(rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    lines = [
        "theory: first-order error propagation; the inputs that matter most, by their total Sobol index with its 95 % interval:"
    ]
    for row in rows:
        first = []
        for key in _ranked(row)[:3]:
            index = row["indices"][key]
            low, high = index["total_interval"]
            first.append(f"{key} {index['total']:.2f}±{0.5 * (high - low):.2f}")
        lines.append(f"{row['output'].removesuffix('_at_contact'):<20} {', '.join(first)}")
    return tuple(lines)


def _ranked(row: Mapping[str, Any]) -> list[str]:
    """Return the names of the inputs in descending order of the total index."""
    return sorted(row["indices"], key=lambda key: -float(row["indices"][key]["total"]))


def sobol_study(
    function: Callable[..., Measures],
    intervals: Mapping[str, tuple[float, float]],
    outputs: Sequence[str],
    samples: int,
    *,
    seed: int = 1,
) -> Study:
    """Estimate the Sobol indices of a function's outputs from Saltelli's samples.

    Args:
        function: function of arrays of the inputs that returns arrays of the outputs, by name.
        intervals: interval of each input, in which it is uniformly distributed.
        outputs: names of the outputs, at least two.
        samples: number of samples, a power of 2 and at least twice SEQUENCES.
        seed: seed of the scramblings.

    Raises:
        ValueError: if the function has no result somewhere in the intervals.
    """
    inputs = len(intervals)
    each = samples // SEQUENCES
    sequences = [
        Sobol(2 * inputs, seed=random, bits=64).random(each)
        for random in np.random.default_rng(seed).spawn(SEQUENCES)
    ]
    fractions = np.concatenate(sequences).T.reshape(2, inputs, samples)
    first, second = fractions
    mixed = np.tile(first, (inputs, 1, 1))
    mixed[np.arange(inputs), np.arange(inputs)] = second

    def at(batch: Array) -> Array:
        """Return the outputs at points given as fractions of the intervals, shape (outputs, points)."""
        points = values_at(intervals, batch)
        found = function(**points)
        _require_results(found, points, outputs)
        return np.array([found[name] for name in outputs])

    every = np.concatenate([first, second, *mixed], axis=1)
    batches = np.array_split(every, math.ceil(every.shape[1] / BATCH), axis=1)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        values = np.concatenate([*pool.map(at, batches)], axis=1)
    values = values.reshape(len(outputs), inputs + 2, samples)

    def indices(chosen: slice) -> Array:
        """Return the first-order Sobol indices, then the total ones, shape (2, outputs, inputs).

        They are estimated from the points ``chosen`` of the samples A and B, and of the copies of A
        in which one column is that of B.
        """
        own = values[:, :, chosen].copy()  # SciPy 1.14 subtracts the mean from the arrays it gets
        func = {"f_A": own[:, 0], "f_B": own[:, 1], "f_AB": np.moveaxis(own[:, 2:], 1, 0)}
        estimate = sobol_indices(func=func, n=own.shape[-1])
        return np.reshape([estimate.first_order, estimate.total_order], (2, len(outputs), inputs))

    middle = indices(slice(None))
    parts = [indices(slice(start, start + each)) for start in range(0, samples, each)]
    half = t.ppf(0.975, SEQUENCES - 1) * np.std(parts, axis=0, ddof=1) / math.sqrt(SEQUENCES)
    ends = np.stack([middle - half, middle + half], axis=-1)
    both = values[:, :2].reshape(len(outputs), -1)
    return Study(tuple(intervals), tuple(outputs), both, *middle, *ends)


def _require_results(found: Measures, inputs: Mapping[str, Array], outputs: Sequence[str]) -> None:
    """Check that the results ``found`` of a function are complete at all points.

    ``inputs`` holds the values of the inputs, by name; ``outputs`` names the required results.

    Raises:
        ValueError: if points have no result. The message has the reason at one of them.
    """
    lost = ~np.all([np.isfinite(found[name]) for name in outputs], axis=0)
    if not lost.any():
        return
    where = int(np.argmax(lost))
    unknown = [name for name in outputs if not np.isfinite(found[name][where])]
    reason = found[FAILURE][where] or f"no {', '.join(unknown)}"
    point = ", ".join(f"{name} = {column[where]:.6g}" for name, column in inputs.items())
    raise ValueError(
        f"spreads: must be smaller, no result at {int(lost.sum())} of {lost.size} points; at {point}: {reason}"
    )
