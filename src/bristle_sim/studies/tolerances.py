"""Which tolerance matters: inputs spread about their values, and how the strike spreads with them.

Every input is uniform within its half-width about its value, independent of the others: an interval in which a dimension is
accepted. Sobol indices share the variance of every output among the inputs. For small spreads the standard deviation is that
of first-order error propagation, sqrt(sum (dy/dx_i sigma_i)^2).
"""

from __future__ import annotations

import dataclasses
import functools
import math
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Tool
from bristle_sim.quantity import ANY, Declared, Range, choice, count, quantity, validate
from bristle_sim.settings import Settings
from bristle_sim.studies.rounding import propagated, rounding_rows
from bristle_sim.studies.sobol import sobol_study
from bristle_sim.studies.strike_point import STRIKE_UNITS, declared_keys, keys_of, strike_of_keys

OUTPUTS = tuple(name for name in STRIKE_UNITS if name != "normal_compressive_work")

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
    rounding: str = choice(
        "yes",
        "rounding",
        ("yes", "no"),
        source="chosen",
        meaning="whether the rounding of the printed inputs is studied too",
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.samples & (self.samples - 1):
            raise ValueError(f"samples = {self.samples:g}: must be a power of 2 (dimensionless)")


def tolerances(tool: Tool, spreads: Spreads, sampling: Sampling, settings: Settings) -> Report:
    """Spread the inputs of a pass and report how its strike spreads, and which input causes it.

    Raises:
        ValueError: if somewhere in the intervals the bar cues no strike, or the extra ``sweep`` is not installed.
    """
    started = clock.perf_counter()
    values, intervals = keys_of(tool), _intervals(tool, spreads)
    fixed = {key: value for key, value in values.items() if key not in intervals}
    point = functools.partial(strike_of_keys, settings, **fixed)
    workers = None if sampling.workers == 1 else sampling.workers
    study = sobol_study(point, intervals, OUTPUTS, sampling.samples, seed=sampling.seed, workers=workers)
    middles = {key: 0.5 * (low + high) for key, (low, high) in intervals.items()}
    changes = propagated(point, middles, {key: 0.5 * (high - low) for key, (low, high) in intervals.items()})
    std = {name: math.sqrt(sum(each**2 for each in parts.values()) / 3.0) for name, parts in changes.items()}
    rows = study.rows(std)
    rounding = rounding_rows(tool, settings) if sampling.rounding == "yes" else []
    return Report(
        outcome=None,
        quantities=tuple(_quantities(rows)),
        wall_s=clock.perf_counter() - started,
        remarks=(*_remarks(rows, rounding), "", *_reasons(spreads)),
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


def _reasons(spreads: Spreads) -> list[str]:
    """Say how far each input is spread, and why."""
    lines = ["half-widths of the inputs' intervals:"]
    for each in dataclasses.fields(spreads):
        declared, half_width = each.metadata["declaration"], getattr(spreads, each.name)
        reason = declared.source if half_width == each.default else "as given"
        lines.append(f"{each.name:<20}{half_width:>9.3g} {declared.unit:<8} {reason}")
    return lines


def _remarks(rows: Sequence[Mapping[str, Any]], rounding: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    lines = ["theory: first-order error propagation; the inputs that matter most, by their total Sobol index:"]
    for row in rows:
        ranked = sorted(row["indices"].items(), key=lambda item: -item[1]["total"])[:3]
        told = ", ".join(f"{key} {each['total']:.2f}" for key, each in ranked)
        lines.append(f"{row['output']:<26} {told}")
    if rounding:
        head = (
            f"{'number':<18}{'by':<19}{'computed':>9}{'printed':>9}{'diff.':>8}{'at most':>9}{'std':>7}  {'mostly by'}"
        )
        lines += ["", "computed less printed, and how far the rounding of the printed inputs moves the computed:", head]
    for row in rounding:
        shares = (row["relative_difference"], row["relative_worst_case"], row["relative_std"])
        diff, most, std = (f"{100.0 * each:.1f} %" for each in shares)
        lines.append(
            f"{row['output']:<18}{row['by']:<19}{row['computed']:>9.4g}{row['printed']:>9.4g}{diff:>8}{most:>9}{std:>7}"
            f"  {row['largest']}"
        )
    return tuple(lines)
