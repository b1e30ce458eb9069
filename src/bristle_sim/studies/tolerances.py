"""Which tolerance matters: inputs spread about their values, and how the strike spreads with them.

Every input is uniform within its half-width about its value, independent of the others: an interval in which a dimension is
accepted. For small spreads the standard deviation is that of first-order error propagation, sqrt(sum (dy/dx_i sigma_i)^2).

Sobol indices share the variance of every output among the inputs. Two samples A and B of a scrambled Sobol sequence, and A
with the columns of B one at a time, give Saltelli's estimate of the first-order index V(E(y|x_i))/V(y), the fraction of the
variance that would vanish if x_i were known, and of the total index E(V(y|all but x_i))/V(y), the fraction that x_i has a
part in (``scipy.stats.sobol_indices``).
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
from scipy.stats import sobol_indices, uniform

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.printed_rounding import Measures, propagated, rounding_remarks, rounding_rows
from bristle_sim.studies.strike_point import STRIKE_UNITS, keys_of, strike_of_keys
from bristle_sim.tool_file import tool_keys
from bristle_sim.units import ANY, Declared, Range, count, quantity, validate

OUTPUTS = tuple(name for name in STRIKE_UNITS if name != "normal_compressive_work")

ENDS = (50.0 * (1.0 - 0.95), 50.0 * (1.0 + 0.95))
"""Percentiles between which outputs and indices lie with a probability of 95 %."""

RESAMPLES = 200
"""Bootstrap resamples; the ends of a 95 % interval then rest on five of them each."""

FINE, MEDIUM = "ISO 2768-1 fine", "ISO 2768-1 medium"


def _spread(default: float, key: str, unit: str, source: str) -> Any:
    meaning = f"half-width of the interval of {key}"
    return quantity(
        default, f"spread_{key}", unit, at_least=0.0, at_most=1e6, source=source, meaning=meaning, usual=ANY
    )


@dataclass(frozen=True, slots=True)
class Spreads(Declared):
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


@dataclass(frozen=True, slots=True)
class Sampling:
    """Size and seed of the samples; a study takes samples (d + 2) passes for d inputs.

    In a Sobol sequence of 26 dimensions, two for each of 13 inputs, the first 64 points leave pairs of dimensions correlated:
    indices are then off by up to 0.4, which no bootstrap sees; with 128 by 0.2, with 256 by 0.1, with 512 by 0.03 (tried on
    a linear model).
    """

    samples: int = count(
        256,
        "samples",
        at_least=2,
        at_most=2**24,
        source="chosen; fewer give poor indices",
        meaning="points of the Sobol sequence, a power of 2",
    )
    seed: int = count(1, "seed", at_least=0, at_most=2**32 - 1, source="chosen", meaning="of the sequence's scrambling")
    workers: int = count(
        1, "workers", at_least=1, at_most=64, source="chosen", meaning="processes that simulate the passes"
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.samples & (self.samples - 1):
            raise ValueError(f"samples = {self.samples:g}: must be a power of 2 (dimensionless)")


@dataclass(frozen=True, slots=True)
class Study:
    """Outputs of all samples, shape (outputs, 2 samples), their indices, (outputs, inputs), and intervals, with a last axis of 2."""

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    values: Array
    first_order: Array
    total: Array
    first_order_interval: Array
    total_interval: Array

    def rows(self, propagated_std: Mapping[str, float]) -> list[dict[str, Any]]:
        """Return one row an output, in plain numbers."""
        names, found = ("first_order", "first_order_interval", "total", "total_interval"), []
        for number, (output, values) in enumerate(zip(self.outputs, self.values, strict=True)):
            low, high = np.percentile(values, ENDS).tolist()
            row = {"output": output, "mean": float(values.mean()), "std": float(values.std(ddof=1))}
            row |= {"std_first_order": propagated_std.get(output), "low": low, "high": high}
            columns = (getattr(self, name)[number].tolist() for name in names)
            indices = [dict(zip(names, each, strict=True)) for each in zip(*columns, strict=True)]
            found.append(row | {"indices": dict(zip(self.inputs, indices, strict=True))})
        return found


def tolerances(tool: Tool, spreads: Spreads, sampling: Sampling, settings: Settings) -> Report:
    """Spread the inputs of a pass and report how its strike spreads, and which input causes it.

    Raises:
        ValueError: if somewhere in the intervals the bar cues no strike, or the extra ``sweep`` is not installed.
    """
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: must both be parts of the tool")
    started = clock.perf_counter()
    values, intervals = keys_of(tool), _intervals(tool, spreads)
    fixed = {key: value for key, value in values.items() if key not in intervals}
    point = functools.partial(strike_of_keys, settings, **fixed)
    workers = None if sampling.workers == 1 else sampling.workers
    study = sobol_study(point, intervals, OUTPUTS, sampling.samples, seed=sampling.seed, workers=workers)
    middles = {key: 0.5 * (low + high) for key, (low, high) in intervals.items()}
    changes = propagated(point, middles, {key: 0.5 * (high - low) for key, (low, high) in intervals.items()})
    std = {name: math.sqrt(sum(each**2 for each in parts.values()) / 3.0) for name, parts in changes.items()}
    rows, rounding = study.rows(std), rounding_rows(tool, settings)
    return Report(
        outcome=None,
        quantities=tuple(
            Quantity(
                f"{row['output']}_{name}",
                STRIKE_UNITS[row["output"]],
                row[name],
                row["std_first_order"] if name == "std" else None,
            )
            for row in rows
            for name in ("mean", "std")
        ),
        wall_s=clock.perf_counter() - started,
        remarks=(*_remarks(rows), *rounding_remarks(rounding)),
        extra={"rows": rows, "rounding": rounding},
        subject=study,
    )


def _intervals(tool: Tool, spreads: Spreads) -> dict[str, tuple[float, float]]:
    """Ends of every input's interval, cut off at the bounds of what the input may be."""
    values, found = keys_of(tool), dict[str, tuple[float, float]]()
    declared_keys = {key: declared for keys in tool_keys().values() for key, (_, declared) in keys.items()}
    for each in dataclasses.fields(spreads):
        half_width = getattr(spreads, each.name)
        if half_width:
            declared = declared_keys[each.name]
            assert isinstance(declared, Range)
            middle = float(values[each.name])
            low = max(declared.lowest, middle - half_width)
            found[each.name] = (low, min(declared.highest, middle + half_width))
    if not found:
        raise ValueError("spread_...: at least one must be more than 0, or nothing is spread")
    return found


def _remarks(rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    lines = ["theory: first-order error propagation; the inputs that matter most, by their total Sobol index:"]
    for row in rows:
        ranked = sorted(row["indices"].items(), key=lambda item: -item[1]["total"])[:3]
        told = ", ".join(f"{key} {each['total']:.2f}" for key, each in ranked)
        lines.append(f"{row['output']:<26} {told}")
    return tuple(lines)


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

    The point function is one as ``sweep`` takes it, and so are the workers; each argument is uniform in its interval. There are
    at least two outputs, and samples, a power of 2, of each of the two independent samples. The seed is that of the sequence's
    scrambling and of the bootstrap; scipy's own bootstrap takes none.

    Raises:
        ValueError: if the function has no result somewhere in the intervals, or the extra ``sweep`` is not installed.
    """
    evaluated: list[Array] = []

    def evaluate(inputs: Array) -> Array:
        evaluated.append(_swept(function, dict(zip(intervals, inputs, strict=True)), outputs, workers))
        return evaluated[-1].copy()  # scipy subtracts the mean in place

    dists = [uniform(loc=low, scale=high - low) for low, high in intervals.values()]
    random, shape = np.random.default_rng(seed), (len(outputs), len(intervals))
    # The keyword rng has this name since scipy 1.15.
    found = sobol_indices(func=evaluate, n=samples, dists=dists, random_state=random)
    first, second, mixed = evaluated
    mixed = np.moveaxis(mixed.reshape(len(outputs), samples, -1), -1, 0)
    resampled = []
    for chosen in random.integers(0, samples, (RESAMPLES, samples)):
        func = {"f_A": first[:, chosen], "f_B": second[:, chosen], "f_AB": mixed[..., chosen]}
        again = sobol_indices(func=func, n=samples)
        resampled.append([np.reshape(each, shape) for each in (again.first_order, again.total_order)])
    both = (np.reshape(each, shape) for each in (found.first_order, found.total_order))
    ends: Array = np.moveaxis(np.percentile(resampled, ENDS, axis=0), 0, -1)
    return Study(tuple(intervals), tuple(outputs), np.concatenate([first, second], axis=1), *both, *ends)


def _swept(
    function: Callable[..., Measures],
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
