"""Which tolerance matters: inputs spread about their values, and how the strike spreads with them.

Every input is uniform within its half-width about its value, independent of the others: an interval in which a dimension is
accepted. Sobol indices share the variance of every output among the inputs. For small spreads the standard deviation is that
of first-order error propagation, sqrt(sum (dy/dx_i sigma_i)^2).

Rounding of the printed inputs explains some of what printed and computed numbers differ by: each printed input stands for any
value within half a unit of its last digit. A computed number may move by the sum of what these half units move it, and its
standard deviation is that of inputs uniform within them.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Tool
from bristle_sim.quantity import ANY, Declared, Range, choice, count, quantity, validate
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import Measures, placed, radial_place, simulation
from bristle_sim.studies.sobol import sobol_study
from bristle_sim.studies.strike_point import STRIKE_UNITS, declared_keys, keys_of, strike_of_keys, tool_of_keys
from bristle_sim.theory import cueing

RETRACTION_DEG = 44.5
"""theta_p (Zhang 2020, eq. 2.2)."""

HALF_UNITS = {
    "hub_speed": 0.05,
    "hub_radius": 5e-5,
    "bristle_length": 5e-4,
    "bristle_mass": 5e-9,
    "wire_diameter": 5e-6,
    "belt_stiffness": math.degrees(5e-6),
    "penetration": 5e-5,
    "bar_horizontal": 5e-6,
    "bar_vertical": 5e-5,
    "retraction_deg": 0.05,
}
"""Half a unit of the last digit of 261.8 rad/s, 27.5 mm, 0.027 m, 8.387e-5 kg, 0.71 mm, 0.00041 N m (per degree), 4.5 mm,
50.37 mm, 22.5 mm and 44.5 degrees (Zhang 2020, eqs. 2.2 and 2.3, captions of figs. 2.7 and 4.13)."""

PRINTED = {
    "relative_speed": 845.6,
    "bar_direction_deg": math.degrees(math.atan2(0.05037, 0.0225)),
    "bar_horizontal": 0.05037,
    "bar_vertical": 0.0225,
}

STEP = math.radians(0.5)
"""Turn of the bar over which the slope of the lag is taken: about what rounding turns it by."""


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


def rounding_rows(tool: Tool, settings: Settings) -> list[dict[str, Any]]:
    """One row for each printed number and way to compute it; none for a tool that is not the printed one."""
    if tool != Tool():
        return []
    values = {key: float(value) for key, value in keys_of(tool).items() if key in HALF_UNITS}
    values["retraction_deg"] = RETRACTION_DEG
    ways: dict[str, Callable[..., Measures]] = {
        "formula": lambda **keys: _by_formula(cueing.cue, keys),
        "stiffened formula": lambda **keys: _by_formula(cueing.stiffened_cue, keys),
        "simulated pass": _simulation(tool, settings),
    }
    rows = []
    for way, function in ways.items():
        changes = propagated(function, values, HALF_UNITS)
        computed = function(**values)
        rows += [_row(name, way, computed[name], changes[name]) for name in PRINTED if name in changes]
    return rows


def propagated(
    function: Callable[..., Measures], values: Mapping[str, float], half_widths: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    """Half the change of every output between both ends of each input's interval, the others at their values.

    For small half-widths h_i it is dy/dx_i h_i; uniform inputs then give the standard deviation sqrt(sum (.)^2/3) and, at
    worst, the deviation sum |.|.
    """
    changes: dict[str, dict[str, float]] = {}
    for key, half_width in half_widths.items():
        low, high = (function(**{**values, key: values[key] + sign * half_width}) for sign in (-1.0, 1.0))
        for name, value in high.items():
            other = low[name]
            if value is not None and other is not None:
                changes.setdefault(name, {})[key] = 0.5 * (value - other)
    return changes


def _row(name: str, way: str, computed: float | None, changes: Mapping[str, float]) -> dict[str, Any]:
    printed = PRINTED[name]
    assert computed is not None
    return {
        "output": name,
        "by": way,
        "computed": computed,
        "printed": printed,
        "relative_difference": (computed - printed) / printed,
        "relative_worst_case": sum(map(abs, changes.values())) / printed,
        "relative_std": math.sqrt(sum(each**2 for each in changes.values()) / 3.0) / printed,
        "largest": max(changes, key=lambda key: abs(changes[key])),
    }


def _split(keys: Mapping[str, float]) -> tuple[Tool, float]:
    """Tool and retraction (rad); the bar's radius, which is not printed, lets the wire slip off at that retraction."""
    own = dict(keys)
    retraction = math.radians(own.pop("retraction_deg"))
    tip = float(cueing.tip_radius(own["hub_radius"], own["bristle_length"], retraction))
    distance = math.hypot(own["bar_horizontal"], own["bar_vertical"])
    return tool_of_keys(**own, bar_radius=distance - tip - 0.5 * own["wire_diameter"]), retraction


def _by_formula(cue: Callable[[Tool, float], cueing.Cue], keys: Mapping[str, float]) -> Measures:
    found = cue(*_split(keys))
    place = (math.degrees(found.bar_direction), found.bar_horizontal, found.bar_vertical)
    return dict(zip(PRINTED, (found.highest_relative_speed, *place), strict=True))


def _simulation(tool: Tool, settings: Settings) -> Callable[..., Measures]:
    """The strike where the bar stands, and where it would have to stand for a radial one.

    The latter by one step of Newton's method from the printed tool's own direction; the lag is nearly linear in it.
    """
    strike = simulation(settings)
    direction = radial_place(tool, strike).direction
    ahead = strike(placed(tool, direction + STEP))["lag_deg_at_contact"] or math.nan

    def by_simulation(**keys: float) -> Measures:
        other, _ = _split(keys)
        lag = strike(placed(other, direction))["lag_deg_at_contact"] or 0.0
        turned = direction - lag * STEP / ahead
        bar = placed(other, turned).bar
        assert bar is not None
        speed = strike(other)["relative_speed_at_contact"]
        return dict(zip(PRINTED, (speed, math.degrees(turned), bar.horizontal, bar.vertical), strict=True))

    return by_simulation
