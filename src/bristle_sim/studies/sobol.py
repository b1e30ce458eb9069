"""Sobol indices: the fractions of the variance of a function's outputs that its inputs cause.

Every input is uniform in an interval, independent of the others. Two samples A and B of a scrambled Sobol sequence, and A
with the columns of B one at a time, give Saltelli's estimate of the first-order index V(E(y|x_i))/V(y), the fraction of the
variance that would vanish if x_i were known, and of the total index E(V(y|all but x_i))/V(y), the share that x_i has a part
in (``scipy.stats.sobol_indices``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import sobol_indices, uniform

from bristle_sim.arrays import Array

ENDS = (50.0 * (1.0 - 0.95), 50.0 * (1.0 + 0.95))
"""Percentiles between which outputs and indices lie with a probability of 95 %."""

RESAMPLES = 200
"""Bootstrap resamples; the ends of a 95 % interval then rest on five of them each."""


@dataclass(frozen=True, slots=True)
class Study:
    """Outputs of all samples, and what they say: indices of shape (outputs, inputs), intervals with a last axis of 2.

    Values are those of the outputs in the two independent samples, shape (outputs, 2 samples).
    """

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
        arrays = {name: getattr(self, name) for name in names}
        return [
            {
                "output": name,
                "mean": float(values.mean()),
                "std": float(values.std(ddof=1)),
                "std_first_order": propagated_std.get(name),
                **dict(zip(("low", "high"), np.percentile(values, ENDS).tolist(), strict=True)),
                "indices": {
                    key: {index: array[number, at].tolist() for index, array in arrays.items()}
                    for at, key in enumerate(self.inputs)
                },
            }
            for number, (name, values) in enumerate(zip(self.outputs, self.values, strict=True))
        ]


def sobol_study(
    function: Callable[..., Mapping[str, float | None]],
    intervals: Mapping[str, tuple[float, float]],
    outputs: Sequence[str],
    samples: int,
    *,
    seed: int = 1,
    workers: int | None = None,
) -> Study:
    """Evaluate a function of keyword arguments on Saltelli's samples and estimate the Sobol indices of its outputs.

    The point function is one as ``sweep`` takes it, and so are the workers; each argument is uniform in its interval. There are
    at least two outputs, and samples, a power of 2, of each of the two independent samples. The seed is that of the sequence's
    scrambling and of the bootstrap.

    Raises:
        ValueError: if the function has no result somewhere in the intervals, or the extra ``sweep`` is not installed.
    """
    evaluated: list[Array] = []

    def evaluate(inputs: Array) -> Array:
        evaluated.append(_swept(function, dict(zip(intervals, inputs, strict=True)), outputs, workers))
        return evaluated[-1].copy()  # scipy subtracts the mean in place

    dists = [uniform(loc=low, scale=high - low) for low, high in intervals.values()]
    random = np.random.default_rng(seed)
    # The keyword rng has this name since scipy 1.15.
    found = sobol_indices(func=evaluate, n=samples, dists=dists, random_state=random)
    shape = (len(outputs), len(intervals))
    first, second, mixed = evaluated
    resampled = _resampled(first, second, mixed.reshape(len(outputs), samples, -1), random)
    return Study(
        inputs=tuple(intervals),
        outputs=tuple(outputs),
        values=np.concatenate([first, second], axis=1),
        first_order=np.reshape(found.first_order, shape),
        total=np.reshape(found.total_order, shape),
        first_order_interval=resampled[0],
        total_interval=resampled[1],
    )


def _swept(
    function: Callable[..., Mapping[str, float | None]],
    inputs: Mapping[str, Array],
    outputs: Sequence[str],
    workers: int | None,
) -> Array:
    """Outputs of shape (outputs, points) for inputs of shape (points)."""
    try:
        from bristle_sim.studies.sweep import sweep
    except ImportError as error:
        raise ValueError(f"tolerances need the extra sweep: pip install bristle-sim[sweep] ({error})") from error
    found = sweep(function, {name: ("sample", values) for name, values in inputs.items()}, workers=workers)
    missing = [name for name in outputs if name not in found]
    values = np.array([found[name].values for name in outputs if name in found])
    lost = np.ones(found.sizes["sample"], bool) if missing else ~np.isfinite(values).all(axis=0)
    if lost.any():
        where = int(np.argmax(lost))
        reason = str(found["failure"].values[where]) or f"no {', '.join(missing) or 'number'}"
        point = ", ".join(f"{name} = {column[where]:.6g}" for name, column in inputs.items())
        raise ValueError(
            f"spreads: must be smaller, {int(lost.sum())} of {lost.size} points have no result; at {point}: {reason}"
        )
    return values


def _resampled(first: Array, second: Array, mixed: Array, random: np.random.Generator) -> tuple[Array, Array]:
    """Bootstrap intervals of first-order and total indices, each of shape (outputs, inputs, 2).

    ``mixed`` has the shape (outputs, samples, inputs), as scipy calls for the outputs. The result's own bootstrap takes no
    seed, so the same inputs would not give the same numbers.
    """
    outputs, samples, inputs = mixed.shape
    found = []
    for _ in range(RESAMPLES):
        chosen = random.integers(0, samples, samples)
        func = {"f_A": first[:, chosen], "f_B": second[:, chosen], "f_AB": np.moveaxis(mixed[:, chosen], -1, 0)}
        again = sobol_indices(func=func, n=samples)
        found.append([np.reshape(each, (outputs, inputs)) for each in (again.first_order, again.total_order)])
    both: Array = np.moveaxis(np.percentile(found, ENDS, axis=0), 0, -1)
    return both[0], both[1]
