"""A scenario's quantities as functions of one or two parameters, and sentences on them: how they
change, where the outcome changes, and which points lack results.

Whole passes of a straight rigid bristle are computed in arrays, all points at once. Other scenarios
run once for each point.
"""

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.comparison import Report
from bristle_sim.conversion import display_unit
from bristle_sim.parameters import Tool
from bristle_sim.passes.strike import OUTCOMES
from bristle_sim.readable import amount, plain_number
from bristle_sim.settings import Settings
from bristle_sim.studies.many_passes import (
    CHECKED_POINTS,
    OUTCOME,
    REASON,
    checked_by_scene,
    pass_quantities,
)
from bristle_sim.studies.sweep_point import FAILURE, evaluate_in_turn
from bristle_sim.studies.whole_pass import QUANTITIES

FORMULA = " by formula"  # suffix that marks the value of a quantity by formula


CODE = "outcome_code"  # name under which a run returns the index of its outcome in OUTCOMES


@dataclass(frozen=True, slots=True)
class Swept:
    """Quantities over one or two parameters, in SI units, or in degrees where a name ends in
    ``_deg``.

    Attributes:
        axes: values of each parameter, by its name.
        values: quantities by name, as arrays with one axis for each parameter; NaN where there is
            no value.
        units: units of parameters and quantities, by name.
        labels: names of quantities in words; a quantity without a label is shown by its name.
        failure: reason why a point lacks a quantity, for each point; empty where all are there.
        outcome: outcome of the pass at each point, in words; None if the scenario has no passes.
        check: sentence on the agreement with single simulations at some points; empty if every
            point is a simulation.
    """

    axes: dict[str, Array]
    values: dict[str, Array]
    units: dict[str, str]
    labels: dict[str, str]
    failure: NDArray[Any]
    outcome: NDArray[Any] | None = None
    check: str = ""

    @property
    def known(self) -> dict[str, Array]:
        """Return the quantities that have a value at one point or more."""
        return {name: each for name, each in self.values.items() if np.isfinite(each).any()}

    @property
    def changing(self) -> dict[str, Array]:
        """Return the quantities that change by more than rounding error over the points."""
        known = self.known
        return {name: each for name, each in known.items() if _spread(each) > ROUNDING}


ROUNDING = 1e-7
"""Largest relative range of a quantity's values at which it counts as constant: ten times the usual
accuracy of the passes."""


def _spread(values: Array) -> float:
    size = np.nanmax(np.abs(values))
    return float((np.nanmax(values) - np.nanmin(values)) / size) if size else 0.0


def sweep_in_arrays(tool: Tool, settings: Settings, axes: Mapping[str, Array]) -> Swept:
    """Compute whole passes of a straight rigid bristle over one or two parameters, all points at
    once.

    Some points are simulated one by one too; ``check`` of the result states how well they agree.
    """
    passes = pass_quantities(tool, settings, **_grids(axes))
    random = np.random.default_rng(1)
    chosen = {key: random.choice(values, CHECKED_POINTS + 1) for key, values in axes.items()}
    labels = {name: label for name, (label, _) in QUANTITIES.items()}
    units = {name: unit for name, (_, unit) in QUANTITIES.items()}
    values = {name: passes[name] for name in QUANTITIES}
    complete = np.all([np.isfinite(each) for each in values.values()], axis=0)
    reason = np.where(passes[REASON] == "", passes[OUTCOME].astype(object), passes[REASON])
    check = str(checked_by_scene(tool, settings, chosen))
    failure = np.where(complete, "", reason)
    return Swept({**axes}, values, units, labels, failure, passes[OUTCOME], check)


def _grids(axes: Mapping[str, Array]) -> dict[str, Array]:
    grids = np.meshgrid(*axes.values(), indexing="ij", sparse=True)
    return dict(zip(axes, grids, strict=True))


def sweep_of_runs(
    run: Callable[..., Report],
    axes: Mapping[str, Array],
    *,
    workers: Any = None,
    store: Any = None,
) -> Swept:
    """Run a scenario at every combination of the values of one or two parameters.

    Args:
        run: function that takes the parameters as keyword arguments and returns the scenario's
            report. If it raises ValueError, the message is the reason why the point lacks results.
        axes: values of each parameter, in SI units.
        workers: processes or cluster that compute the points, as for :func:`bristle_sim.sweep`,
            which raises the same errors.
        store: folder that keeps finished points, as for :func:`bristle_sim.sweep`. Without workers
            and store the points are computed one after the other.

    Returns:
        The simulated values of the report's quantities. A quantity that is not simulated at any
        point has its values by formula.
    """
    function = functools.partial(_quantities, run)
    shape = tuple(len(values) for values in axes.values())
    if workers is None and store is None:
        columns = evaluate_in_turn(function, _grids(axes))
    else:
        try:
            from bristle_sim.studies.sweep import sweep
        except ImportError as error:
            raise ValueError(
                f"--workers, --store: need the extra sweep: pip install bristle-sim[sweep] ({error})"
            ) from error
        found = sweep(function, axes, workers=workers, store=store).load()
        columns = {str(name): each.values for name, each in found.data_vars.items()}
    failure = columns.pop(FAILURE).astype(object)
    codes = columns.pop(CODE, np.full(shape, math.nan))
    finished = np.argwhere(np.any([np.isfinite(each) for each in columns.values()], axis=0))
    outcome = np.array([*OUTCOMES, ""])[np.nan_to_num(codes, nan=len(OUTCOMES)).astype(int)]
    swept = Swept({**axes}, {}, {}, {}, failure, outcome if np.isfinite(codes).any() else None)
    if not columns or not finished.size:
        return swept
    point = {
        key: float(values[i]) for (key, values), i in zip(axes.items(), finished[0], strict=True)
    }
    for each in run(**point).quantities:  # they have labels and units
        values = columns.get(each.name, np.full(shape, math.nan))
        formula = columns.get(each.name + FORMULA)
        if formula is not None and not np.isfinite(values).any():
            values = formula
        swept.values[each.name] = values
        swept.units[each.name] = each.unit
        swept.labels[each.name] = each.label
    complete = np.all([np.isfinite(each) for each in swept.values.values()], axis=0)
    failure[complete] = ""
    return swept


def _quantities(run: Callable[..., Report], /, **keys: float) -> dict[str, float | str | None]:
    """Run a scenario at one point and return its values by name: simulated ones, else those by
    formula.

    The entry ``failure`` is the reason why some values may be missing.
    """
    report = run(**keys)
    values: dict[str, Any] = {each.name: each.simulated for each in report.quantities}
    if report.outcome_in_words in OUTCOMES:
        values[CODE] = OUTCOMES.index(report.outcome_in_words)
    formulas = {
        each.name + FORMULA: each.theory for each in report.quantities if each.simulated is None
    }
    return (
        values
        | formulas
        | {FAILURE: (report.answer or report.outcome) if None in values.values() else ""}
    )


FIRST = ("tip_speed_at_contact", "normal_final_impulse", "lag_deg_at_contact")
"""Quantities that are described first."""

NAMED = 3  # largest number of quantities, and of reasons, in an answer


def sweep_in_words(found: Swept, chosen: Sequence[str]) -> str:
    """Return a sweep's answer in words: how the first few chosen quantities change, where the
    outcome changes, why some points have no results, and how far the simulation agrees.
    """
    over = " and ".join(
        f"{key} from {shown_value(found, key, values[0])} to {shown_value(found, key, values[-1])}"
        for key, values in found.axes.items()
    )
    points = f"Over {over} ({' x '.join(str(len(each)) for each in found.axes.values())} points)"
    run = _along if len(found.axes) == 1 else _between
    parts = [run(found, name) for name in chosen[:NAMED] if np.isfinite(found.values[name]).any()]
    if not parts:
        parts = ["no quantity changes"]
    if found.outcome is not None:
        parts.append(_outcomes(found))
    reasons, numbers = np.unique(found.failure[found.failure != ""].astype(str), return_counts=True)
    parts += [
        f"{number} points lack results: {reason.rstrip('.')}"
        for reason, number in zip(reasons.tolist(), numbers.tolist(), strict=True)
    ][:NAMED]
    return f"{points} {'; '.join([*parts, *filter(None, [found.check])])}."


def shown_value(found: Swept, name: str, value: float) -> str:
    """Return a value in words with its unit; a parameter is converted to the unit in which it is
    displayed.
    """
    if name in found.axes:
        unit, size = display_unit(name, found.units[name])
        return f"{plain_number(float(value) / size, 4)} {unit}".rstrip()
    return amount(float(value) + 0.0, found.units[name], 4)


def _along(found: Swept, name: str) -> str:
    """Return in words how a quantity changes along the parameter: it is constant, rises, falls, or
    has extremes in between. A negative quantity "changes", because its magnitude does the opposite.
    """
    (key,) = found.axes
    values = found.values[name]
    known = np.flatnonzero(np.isfinite(values))
    first, last = values[known[0]], values[known[-1]]
    changes = np.diff(values[known])
    if name not in found.changing:
        return f"the {found.labels.get(name, name)} stays {shown_value(found, name, first)}"
    ends = f"from {shown_value(found, name, first)} to {shown_value(found, name, last)}"
    label = found.labels.get(name, name)
    if (changes >= 0.0).all() or (changes <= 0.0).all():
        verb = "rises" if last > first else "falls"
        return f"the {label} {verb if max(first, last) > 0.0 else 'changes'} {ends}"
    low, high = (known[each(values[known])] for each in (np.argmin, np.argmax))
    places = [
        f"{shown_value(found, name, values[at])} at {shown_value(found, key, found.axes[key][at])}"
        for at in (low, high)
    ]
    return f"the {label} is lowest, {places[0]}, and highest, {places[1]}"


def _between(found: Swept, name: str) -> str:
    values = found.values[name]
    ends = [shown_value(found, name, each(values)) for each in (np.nanmin, np.nanmax)]
    return f"the {found.labels.get(name, name)} lies between {ends[0]} and {ends[1]}"


def _outcomes(found: Swept) -> str:
    """Return the outcomes in words: along one parameter, the values at which the outcome changes;
    over two parameters, the fraction of points with each outcome.
    """
    assert found.outcome is not None
    words = found.outcome.ravel()
    if len(found.axes) > 1:
        kinds, numbers = np.unique(words, return_counts=True)
        order = np.argsort(-numbers)
        parts = [f"{kinds[each]} in {100.0 * numbers[each] / words.size:.3g} %" for each in order]
        return f"the tip {', '.join(parts)} of them"
    (key,) = found.axes
    starts = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1).tolist()]
    parts = [f"{words[0]}"]
    parts += [
        f"then {words[at]} from {shown_value(found, key, found.axes[key][at])}" for at in starts[1:]
    ]
    if len(parts) > 2 * NAMED:
        parts = [*parts[:NAMED], f"changes {len(starts) - NAMED} more times"]
    return f"the tip {', '.join(parts)}"


def constants_in_words(found: Swept) -> list[str]:
    """Return a phrase for each quantity that is constant over the points, with its value."""
    shown = []
    for name, values in found.known.items():
        if name not in found.changing:
            value = float(values[np.isfinite(values)][0])
            shown.append(f"{found.labels.get(name, name)} {amount(value, found.units[name], 5)}")
    return shown
