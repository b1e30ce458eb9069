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
from bristle_sim.parameters import Tool
from bristle_sim.passes.strike import OUTCOMES, REFUSED
from bristle_sim.readable import plain_number, readable_unit
from bristle_sim.settings import Settings
from bristle_sim.studies.many_passes import (
    OUTCOME,
    checked_by_scene,
    pass_quantities,
    values_at,
)
from bristle_sim.studies.sweep_point import FAILURE, evaluate_in_turn
from bristle_sim.studies.whole_pass import QUANTITIES
from bristle_sim.units import display_unit

FORMULA = " by formula"  # suffix that marks the value of a quantity by formula

CODE = "outcome_code"  # name of the result that holds the index of an outcome in OUTCOMES

ROUNDING = 1e-7
"""Largest difference between a quantity's values, divided by their magnitude, at which the quantity
counts as constant. It is ten times the usual accuracy of the passes."""


@dataclass(frozen=True, slots=True)
class Series:
    """Values of a swept parameter, or of a quantity at all points of a sweep.

    Attributes:
        label: name of the parameter, or the quantity in words.
        unit: unit of the values: an SI unit, or deg.
        values: values of the parameter, or an array of the quantity with one axis for each
            parameter. A missing value is NaN.
        is_key: whether the series is a parameter. A parameter is shown in its customary unit.
    """

    label: str
    unit: str
    values: Array
    is_key: bool = False

    @property
    def display(self) -> tuple[str, float]:
        """Unit in which the values are shown, and its size in the unit of ``values``.

        The shown unit is empty for pure numbers.
        """
        if self.is_key:
            unit, size = display_unit(self.label, self.unit)
        else:
            unit, size = readable_unit(self.unit, self.values.ravel().tolist())
        return {"deg": "°", "1": ""}.get(unit, unit), size

    @property
    def heading(self) -> str:
        """Label of the series, with its customary unit."""
        unit = self.display[0]
        return f"{self.label} ({unit})" if unit else self.label

    @property
    def finite(self) -> Array:
        """All values that are not missing."""
        return self.values[np.isfinite(self.values)]

    @property
    def changes(self) -> bool:
        """Whether the values at the points differ by more than rounding error."""
        known = self.finite
        return bool(known.size and np.ptp(known) > ROUNDING * np.abs(known).max())

    def in_words(self, value: float, digits: int = 4) -> str:
        """Return a value of the series as text with its readable unit."""
        unit, size = self.display
        number = plain_number(float(value) / size + 0.0, digits)
        return number + unit if unit == "°" else f"{number} {unit}".rstrip()


@dataclass(frozen=True, slots=True)
class Swept:
    """Quantities as functions of one or two parameters.

    Attributes:
        axes: values of each parameter, by its name.
        quantities: values of each quantity, by its name.
        failure: for each point the reason why quantities are missing; empty where none is missing.
        outcome: outcome of the pass at each point, in words; None if the scenario has no passes.
        check: sentence on the agreement with simulations at some points; empty if every point is a
            simulation.
    """

    axes: dict[str, Series]
    quantities: dict[str, Series]
    failure: NDArray[Any]
    outcome: NDArray[Any] | None = None
    check: str = ""

    @property
    def complete(self) -> NDArray[np.bool_]:
        """For each point of the sweep, whether all its quantities are known."""
        return np.isfinite([each.values for each in self.quantities.values()]).all(axis=0)  # type: ignore[return-value]


def sweep_in_arrays(tool: Tool, settings: Settings, axes: dict[str, Series]) -> Swept:
    """Compute the passes of a straight rigid bristle at all points of a sweep at once.

    ``axes`` holds the values of each parameter, by its name. Some points are also simulated one by
    one. The attribute ``check`` of the result states how well both methods agree.
    """
    passes = pass_quantities(tool, settings, **_grids(axes))
    ranges = {key: (axis.values[0], axis.values[-1]) for key, axis in axes.items()}
    values_of = functools.partial(values_at, ranges)
    quantities = {
        name: Series(label, unit, passes[name]) for name, (label, unit) in QUANTITIES.items()
    }
    reason = np.where(passes[FAILURE] == "", passes[OUTCOME].astype(object), passes[FAILURE])
    check = str(checked_by_scene(tool, settings, np.zeros(len(axes)), values_of))
    swept = Swept(axes, quantities, reason, passes[OUTCOME], check)
    reason[swept.complete] = ""
    return swept


def _grids(axes: Mapping[str, Series]) -> dict[str, Array]:
    grids = np.meshgrid(*(axis.values for axis in axes.values()), indexing="ij", sparse=True)
    return dict(zip(axes, grids, strict=True))


def sweep_of_runs(
    run: Callable[..., Report],
    axes: dict[str, Series],
    *,
    workers: Any = None,
    store: Any = None,
) -> Swept:
    """Run a scenario at every combination of the values of one or two parameters.

    Args:
        run: function that takes the parameters as keyword arguments and returns the scenario's
            report. If it raises ValueError, the message is the reason why the point lacks results.
        axes: values of each parameter, by its name.
        workers: processes or cluster that compute the points, as for :func:`bristle_sim.sweep`.
            Without workers and store the points are computed one after the other.
        store: folder in which finished points are stored, as for :func:`bristle_sim.sweep`.

    Returns:
        The simulated values of the report's quantities. If a quantity is not simulated at any
            point, the values are those of its formula.

    Raises:
        ValueError: if the workers are lost, or the extra ``sweep`` is needed and not installed.
        OSError: if the store cannot be read or written.
    """
    function = functools.partial(_quantities, run)
    if workers is None and store is None:
        columns = evaluate_in_turn(function, _grids(axes))
    else:
        columns = _with_workers(function, axes, workers, store)
    failure = columns.pop(FAILURE).astype(object)
    unknown = np.full(failure.shape, math.nan)
    codes = columns.pop(CODE, unknown)
    words = np.array(OUTCOMES)[np.nan_to_num(codes, nan=REFUSED).astype(int)]
    swept = Swept(axes, {}, failure, words if np.isfinite(codes).any() else None)
    finished = np.argwhere(np.isfinite([unknown, *columns.values()]).any(axis=0))
    if finished.size:
        point = {key: float(axes[key].values[i]) for key, i in zip(axes, finished[0], strict=True)}
        for each in run(**point).quantities:  # they have labels and units
            simulated = Series(each.label, each.unit, columns.get(each.name, unknown))
            formula = columns.get(each.name + FORMULA, unknown)
            by_formula = Series(each.label, each.unit, formula)
            swept.quantities[each.name] = simulated if simulated.finite.size else by_formula
        failure[swept.complete] = ""
    return swept


def _with_workers(
    function: Callable[..., Any], axes: Mapping[str, Series], workers: Any, store: Any
) -> dict[str, NDArray[Any]]:
    """Return arrays of a function's results at all points, by name.

    ``workers`` are the processes or cluster that evaluate the points, ``store`` the folder of
    finished points.
    """
    try:
        from bristle_sim.studies.sweep import sweep
    except ImportError as error:
        raise ValueError(
            f"--workers, --store: need the extra sweep: pip install bristle-sim[sweep] ({error})"
        ) from error
    space = {key: axis.values for key, axis in axes.items()}
    try:
        found = sweep(function, space, workers=workers, store=store)
    except RuntimeError as error:
        raise ValueError(f"--{error}") from error
    except OSError as error:
        if store is None:
            raise
        rule = f"must be a folder that can be read and written ({error.strerror or error})"
        raise OSError(f"--store = {store!r}: {rule}") from error
    return {str(name): each.values for name, each in found.data_vars.items()}


def _quantities(run: Callable[..., Report], /, **keys: float) -> dict[str, float | str | None]:
    """Run a scenario at one point, and return its simulated values by name.

    If a quantity has no simulated value, the value of its formula is added, by the quantity's name
    followed by FORMULA. The entry ``failure`` is the reason why simulated values are missing.
    """
    report = run(**keys)
    values: dict[str, Any] = {each.name: each.simulated for each in report.quantities}
    failure = (report.answer or report.outcome) if None in values.values() else ""
    for each in report.quantities:
        if each.simulated is None:
            values[each.name + FORMULA] = each.theory
    if report.outcome_in_words in OUTCOMES:
        values[CODE] = OUTCOMES.index(report.outcome_in_words)
    return values | {FAILURE: failure}


FIRST = ("tip_speed_at_contact", "normal_final_impulse", "lag_deg_at_contact")
"""Quantities that the answer of a sweep describes first, in this order."""

NAMED = 3  # largest number of quantities in an answer, and of reasons for missing results


def sweep_in_words(found: Swept, chosen: Sequence[str]) -> str:
    """Return the result of a sweep in words.

    The text states how the first few chosen quantities change, where the outcome changes, why
    points have no results, and how well simulations agree.
    """
    over = " and ".join(
        f"{key} from {axis.in_words(axis.values[0])} to {axis.in_words(axis.values[-1])}"
        for key, axis in found.axes.items()
    )
    points = f"Over {over} ({' x '.join(map(str, found.failure.shape))} points)"
    axes = [*found.axes.values()]
    parts = [_change(found.quantities[name], axes) for name in chosen[:NAMED]]
    parts = parts or ["no quantity changes"]
    if found.outcome is not None:
        parts.append(_outcomes(found.outcome, axes))
    reasons, numbers = np.unique(found.failure[found.failure != ""].astype(str), return_counts=True)
    parts += [
        f"no results at {number} of {found.failure.size} points: {reason.rstrip('.')}"
        for reason, number in zip(reasons.tolist(), numbers.tolist(), strict=True)
    ][:NAMED]
    return f"{points} {'; '.join([*parts, *filter(None, [found.check])])}."


def _change(quantity: Series, axes: Sequence[Series]) -> str:
    """Return a phrase on how a quantity changes with the parameters.

    With two parameters it states the lowest and the highest value. With one parameter it states
    whether the quantity is constant, rises, falls, or has its extremes in between. Negative values
    that become more positive or more negative "change", because "rise" and "fall" might be read as
    statements on their magnitude.
    """
    values = quantity.finite
    changes = np.diff(values)
    low, high = map(quantity.in_words, (values.min(), values.max()))
    if low == high:
        return f"the {quantity.label} stays {low}"
    if len(axes) > 1:
        return f"the {quantity.label} lies between {low} and {high}"
    if (changes >= 0.0).all() or (changes <= 0.0).all():
        verb = "rises" if values[-1] > values[0] else "falls"
        ends = f"from {quantity.in_words(values[0])} to {quantity.in_words(values[-1])}"
        return f"the {quantity.label} {verb if values.max() > 0.0 else 'changes'} {ends}"
    lowest, highest = extremes(quantity, axes)
    return f"the {quantity.label} is lowest, {lowest}, and highest, {highest}"


def extremes(quantity: Series, axes: Sequence[Series]) -> list[str]:
    """Return the lowest and the highest value of a quantity with the place of each, as texts."""
    found = []
    for extreme in (np.nanargmin, np.nanargmax):
        place = np.unravel_index(extreme(quantity.values), quantity.values.shape)
        where = [axis.in_words(axis.values[i]) for axis, i in zip(axes, place, strict=True)]
        found.append(f"{quantity.in_words(quantity.values[place])} at {', '.join(where)}")
    return found


def _outcomes(outcome: NDArray[Any], axes: Sequence[Series]) -> str:
    """Return a phrase on the outcomes of the passes.

    With one parameter it states the values at which the outcome changes, with two parameters the
    percentage of points with each outcome.
    """
    if len(axes) > 1:
        kinds, numbers = np.unique(outcome, return_counts=True)
        order = np.argsort(-numbers)
        parts = [
            f"{_verb(kinds[each])} in {100.0 * numbers[each] / outcome.size:.3g} %"
            for each in order
        ]
        return f"the tip {', '.join(parts)} of them"
    (axis,) = axes
    starts = np.flatnonzero(outcome[1:] != outcome[:-1]) + 1
    parts = [_verb(outcome[0])]
    parts += [f"then {_verb(outcome[at])} from {axis.in_words(axis.values[at])}" for at in starts]
    if len(parts) > 2 * NAMED:
        parts = [*parts[:NAMED], f"changes {len(parts) - NAMED} more times"]
    return f"the tip {', '.join(parts)}"


def _verb(outcome: str) -> str:
    return "is refused" if outcome == OUTCOMES[REFUSED] else outcome


def constants_in_words(found: Swept) -> list[str]:
    """Return a phrase with name and value for each quantity that is the same at all points."""
    return [
        f"{each.label} {each.in_words(each.finite[0], 5)}"
        for each in found.quantities.values()
        if each.finite.size and not each.changes
    ]
