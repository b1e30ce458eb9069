"""Which tolerance matters: inputs spread about their values, and the shares of the outputs' variance that they cause.

Every input is uniform within its half-width about its value, independent of the others: an interval in which a dimension is
accepted, or in which a printed number was rounded. Two samples A and B of a scrambled Sobol sequence, and A with the columns
of B one at a time, give Saltelli's estimate of the first-order index V(E(y|x_i))/V(y), the share of the variance that would
vanish if x_i were known, and of the total index E(V(y|all but x_i))/V(y), the share that x_i has a part in
(``scipy.stats.sobol_indices``). For small spreads the standard deviation is that of first-order error propagation,
sqrt(sum (dy/dx_i sigma_i)^2).
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
from scipy.stats import sobol_indices, uniform

from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Tool
from bristle_sim.quantity import Range, choice, quantity, validate
from bristle_sim.settings import Settings
from bristle_sim.studies.rounding import propagated, rounding_rows
from bristle_sim.studies.strike_point import STRIKE_UNITS, declared_keys, keys_of, strike_of_keys

__all__ = ["Sampling", "Spreads", "Study", "sobol_study", "tolerances"]

Array = NDArray[np.float64]

OUTPUTS = tuple(name for name in STRIKE_UNITS if name != "normal_compressive_work")

CONFIDENCE = 0.95
"""Of the intervals of outputs and of indices."""

RESAMPLES = 200
"""Bootstrap resamples; the ends of a 95 % interval then rest on five of them each."""

FINE, MEDIUM = "ISO 2768-1 fine", "ISO 2768-1 medium"


def _spread(default: float, key: str, unit: str, source: str) -> Any:
    return quantity(default, f"spread_{key}", unit, at_least=0.0, at_most=1e6, source=source)


@dataclass(frozen=True, slots=True)
class Spreads:
    """Half-widths of the inputs' intervals, in the inputs' units; an input with 0 stays at its value."""

    hub_speed: float = _spread(2.618, "hub_speed", "rad/s", "assumed: 1 %, a hand-held drive under load")
    hub_radius: float = _spread(1e-4, "hub_radius", "m", f"{FINE}, 6 to 30 mm: a turned part")
    bristle_length: float = _spread(2e-4, "bristle_length", "m", f"{MEDIUM}, 6 to 30 mm: cut wire")
    bristle_mass: float = _spread(2.4e-6, "bristle_mass", "kg", "of a wire drawn to 0.01 mm: 2.8 %")
    wire_diameter: float = _spread(1e-5, "wire_diameter", "m", "assumed: wire drawn to 0.01 mm")
    belt_stiffness: float = _spread(1.2e-3, "belt_stiffness", "N m/rad", "assumed: 5 % between belts")
    belt_damping_ratio: float = _spread(0.01, "belt_damping_ratio", "1", "assumed: 0.018 explains the printed speed")
    bar_radius: float = _spread(5e-5, "bar_radius", "m", f"{FINE}, 3 to 6 mm: a turned part")
    bar_horizontal: float = _spread(1.5e-4, "bar_horizontal", "m", f"{FINE}, 30 to 120 mm")
    bar_vertical: float = _spread(1e-4, "bar_vertical", "m", f"{FINE}, 6 to 30 mm")
    penetration: float = _spread(5e-4, "penetration", "m", "assumed: a tool guided by hand")
    friction: float = _spread(0.05, "friction", "1", "assumed: dry steel on steel")
    restitution: float = _spread(0.05, "restitution", "1", "assumed: between places of a workpart")

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, slots=True)
class Sampling:
    """Size and seed of the samples; a study takes samples (d + 2) passes for d inputs.

    In a Sobol sequence of 26 dimensions, two for each of 13 inputs, the first 64 points leave pairs of dimensions correlated:
    indices are then off by up to 0.4, which no bootstrap sees; with 128 by 0.2, with 256 by 0.1, with 512 by 0.03 (tried on
    a linear model).
    """

    samples: float = quantity(
        256.0, "samples", "1", at_least=2.0, at_most=2.0**24, source="chosen: a power of 2; fewer give poor indices"
    )
    seed: float = quantity(1.0, "seed", "1", at_least=0.0, at_most=2.0**32 - 1, source="chosen: of the scrambling")
    workers: float = quantity(1.0, "workers", "1", at_least=1.0, at_most=4096.0, source="chosen: processes")
    rounding: str = choice(
        "yes", "rounding", ("yes", "no"), source="chosen: whether the printed inputs are looked at too"
    )

    def __post_init__(self) -> None:
        validate(self)
        for key in ("samples", "seed", "workers"):
            if getattr(self, key) != int(getattr(self, key)):
                raise ValueError(f"{key} = {getattr(self, key)!r}: must be a whole number (dimensionless)")
        if int(self.samples) & (int(self.samples) - 1):
            raise ValueError(f"samples = {self.samples:g}: must be a power of 2 (dimensionless)")


@dataclass(frozen=True, slots=True)
class Study:
    """Outputs of all samples, and what they say: arrays of shape (outputs, inputs), intervals with a last axis of 2.

    Attributes:
        inputs, outputs: names, in order.
        values: of the outputs in the two independent samples, shape (outputs, 2 samples).
        first_order, total: Sobol indices.
        first_order_interval, total_interval: their bootstrap intervals.
    """

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    values: Array
    first_order: Array
    total: Array
    first_order_interval: Array
    total_interval: Array

    def rows(self, propagated_std: Mapping[str, float]) -> list[dict[str, Any]]:
        """One row an output, in plain numbers."""
        ends = 50.0 * (1.0 - CONFIDENCE), 50.0 * (1.0 + CONFIDENCE)
        rows = []
        for number, (name, values) in enumerate(zip(self.outputs, self.values, strict=True)):
            low, high = np.percentile(values, ends)
            indices = {
                key: {
                    "first_order": float(self.first_order[number, at]),
                    "first_order_interval": self.first_order_interval[number, at].tolist(),
                    "total": float(self.total[number, at]),
                    "total_interval": self.total_interval[number, at].tolist(),
                }
                for at, key in enumerate(self.inputs)
            }
            rows.append(
                {
                    "output": name,
                    "mean": float(values.mean()),
                    "std": float(values.std(ddof=1)),
                    "std_first_order": propagated_std.get(name),
                    "low": float(low),
                    "high": float(high),
                    "indices": indices,
                }
            )
        return rows


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

    Args:
        function: point function as ``sweep`` takes it.
        intervals: of each argument, uniform in between.
        outputs: names of the results that are looked at, at least two.
        samples: of each of the two independent samples, a power of 2.
        seed: of the sequence's scrambling and of the bootstrap.
        workers: processes, as ``sweep`` takes them.

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
    ends = 50.0 * (1.0 - CONFIDENCE), 50.0 * (1.0 + CONFIDENCE)
    both: Array = np.moveaxis(np.percentile(found, ends, axis=0), 0, -1)
    return both[0], both[1]


def tolerances(tool: Tool, spreads: Spreads, sampling: Sampling, settings: Settings) -> Report:
    """Spread the inputs of a pass and report how its strike spreads, and which input is to blame.

    Raises:
        ValueError: if somewhere in the intervals the bar cues no strike, or the extra ``sweep`` is not installed.
    """
    started = clock.perf_counter()
    values, intervals = keys_of(tool), _intervals(tool, spreads)
    fixed = {key: value for key, value in values.items() if key not in intervals}
    point = functools.partial(strike_of_keys, settings, **fixed)
    workers = None if sampling.workers == 1.0 else int(sampling.workers)
    study = sobol_study(point, intervals, OUTPUTS, int(sampling.samples), seed=int(sampling.seed), workers=workers)
    middles = {key: 0.5 * (low + high) for key, (low, high) in intervals.items()}
    changes = propagated(point, middles, {key: 0.5 * (high - low) for key, (low, high) in intervals.items()})
    std = {name: math.sqrt(sum(each**2 for each in parts.values()) / 3.0) for name, parts in changes.items()}
    rows = study.rows(std)
    rounding = rounding_rows(tool, settings) if sampling.rounding == "yes" else []
    return Report(
        outcome=None,
        quantities=tuple(_quantities(rows)),
        wall_s=clock.perf_counter() - started,
        remarks=_remarks(rows, rounding),
        extra={"rows": rows, "rounding": rounding},
        subject=study,
    )


def _intervals(tool: Tool, spreads: Spreads) -> dict[str, tuple[float, float]]:
    """Ends of every input's interval, cut off at the bounds of what the input may be."""
    values, found = keys_of(tool), dict[str, tuple[float, float]]()
    for each in dataclasses.fields(spreads):
        half_width = getattr(spreads, each.name)
        if half_width:
            declared = declared_keys()[each.name]
            assert isinstance(declared, Range)
            middle = float(values[each.name])
            low = max(declared.lowest, middle - half_width)
            found[each.name] = (low, min(declared.highest, middle + half_width))
    if not found:
        raise ValueError("spread_...: at least one must be more than 0, or nothing is spread")
    return found


def _quantities(rows: Sequence[Mapping[str, Any]]) -> list[Quantity]:
    """Mean and standard deviation of each output; theory: first-order error propagation."""
    found = []
    for row in rows:
        unit = STRIKE_UNITS[row["output"]]
        found.append(Quantity(f"{row['output']}_mean", unit, row["mean"]))
        found.append(Quantity(f"{row['output']}_std", unit, row["std"], row["std_first_order"]))
    return found


def _remarks(rows: Sequence[Mapping[str, Any]], rounding: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    lines = ["theory: first-order error propagation. Total Sobol indices (95 % interval), the largest of each output:"]
    for row in rows:
        ranked = sorted(row["indices"].items(), key=lambda item: -item[1]["total"])[:3]
        told = ", ".join(
            f"{key} {each['total']:.2f} ({each['total_interval'][0]:.2f} to {each['total_interval'][1]:.2f})"
            for key, each in ranked
        )
        lines.append(f"  {row['output']}: {told}")
    if rounding:
        lines += ["", "how far the rounding of the printed inputs explains where printed and computed numbers differ:"]
    for row in rounding:
        lines.append(
            f"  {row['output']}, {row['by']}: {row['computed']:.5g}, printed {row['printed']:.5g}"
            f" ({100.0 * row['relative_difference']:+.1f} %); rounding: at most {100.0 * row['relative_worst_case']:.1f} %,"
            f" mostly {row['largest']}, std {100.0 * row['relative_std']:.1f} %"
        )
    return tuple(lines)
