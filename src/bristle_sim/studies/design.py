"""Design of a tool: search for parameters in given ranges with which a pass attains target values.

A pass is the trip of one bristle past bar and workpart. The design also states how sensitive the
pass is to each parameter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Report
from bristle_sim.declared import Range
from bristle_sim.parameters import Tool
from bristle_sim.studies.design_search import Search
from bristle_sim.studies.design_words import (
    conflict_in_words,
    curve_in_words,
    kept_in_words,
    tool_in_words,
)
from bristle_sim.studies.many_passes import (
    SCENE,
    Check,
    checked_by_scene,
    checked_range,
    with_derivatives,
)
from bristle_sim.studies.whole_pass import QUANTITIES, whole_pass
from bristle_sim.units import likely_key, shown

# Largest deviation from a target value at which the target still counts as met. For angles it is
# KEPT_DEG, in deg; for other quantities it is the fraction KEPT of the target value, or of the
# quantity's standard deviation in the ranges if the target value is 0.
KEPT = 0.01
KEPT_DEG = 1.0
# Changes of a parameter at which the deviations from the target values are computed, as fractions
# of the distance from the designed value to the end of the range. Consecutive ones differ by 0.7 %.
DISTANCES = np.geomspace(1e-6, 1.0, 2000)
# A quantity counts as jumping if two difference quotients differ by more than the fraction SMOOTH.
# One has the step COARSE_DIFFERENCE (a fraction of the parameter's range), the other a finer step.
# Changes over the range of less than LEAST_CHANGE times the quantity count as rounding error.
COARSE_DIFFERENCE = 1e-4
SMOOTH = 0.1
LEAST_CHANGE = 1e-4
MOST = 1e12  # largest permitted magnitude of a target value, in the quantity's unit

DRAWN_BY = "bristle_sim.render.sweep_figures"  # in a higher layer, imported only when a picture is requested


@dataclass(frozen=True, slots=True)
class Want:
    """The target value of a quantity.

    Attributes:
        name: name of the quantity.
        wanted: target value.
        reached: value in the simulated pass of the designed tool; None if there is no strike.
    """

    name: str
    wanted: float
    reached: float | None


@dataclass(frozen=True, slots=True)
class Design:
    """The result of a design, in SI units, and in degrees where a name ends in ``_deg``.

    Attributes:
        answer: the result in a sentence. It states how well the fast computation agrees with
            simulations.
        remarks: sentences on compromises between two conflicting conditions, and on the tolerances
            of the parameters.
        tool: the designed tool; if conditions conflict, the tool that comes nearest to meeting
            them.
        varied: designed values of the varied parameters, by name.
        wants: target values, and the values that the designed tool reaches.
        report: report of the simulated pass of the designed tool.
        before: simulated quantities of the given tool, before the design. A quantity that the given
            tool's pass lacks is None.
        sensitivity: derivatives of the quantities with respect to each parameter; NaN if the
            quantity jumps at the designed tool.
        kept: lowest and highest value of each parameter at which all quantities stay within 1 %
            (angles within 1 deg) of their target values, while the other parameters do not change.
        conflict: names of the quantities whose target values or upper limits cannot be met
            together; empty if all are met.
        trade_off: values of two conflicting quantities, and of the varied parameters, along the
            curve of best compromises between the two quantities. The keys are the names of
            quantities and parameters. Empty unless exactly two quantities conflict.
        check: agreement between simulations and the fast vectorised passes of the search.
    """

    answer: str
    remarks: tuple[str, ...]
    tool: Tool
    varied: dict[str, float]
    wants: tuple[Want, ...]
    report: Report
    before: dict[str, float | None]
    sensitivity: dict[str, dict[str, float]]
    kept: dict[str, tuple[float, float]]
    conflict: tuple[str, ...]
    trade_off: dict[str, Array]
    check: Check

    def plot(self) -> Any:
        """Return a matplotlib figure of the trade-off between two conflicting conditions.

        Raises:
            ValueError: if no two conditions conflict.
        """
        if not self.trade_off:
            raise ValueError("plot: must have two conflicting wants or limits; there are none here")
        return import_module(DRAWN_BY).trade_off_figure(self)


def design(
    tool: Tool | None = None,
    *,
    want: Mapping[str, Any] | None = None,
    vary: Mapping[str, Any],
    at_most: Mapping[str, Any] | None = None,
    minimize: str = "",
    maximize: str = "",
) -> Design:
    """Find a tool, with parameters in the given ranges, whose pass attains the target values.

    The bristle must be straight and rigid, with the energetic law of impact. If several tools meet
    the targets and limits, the result is the one with the lowest value of the quantity
    ``minimize``, or the highest value of the quantity ``maximize``. If neither is given, it is the
    tool whose parameters differ least from those of ``tool``, relative to their ranges. The search
    computes passes in arrays. Simulations of the tool found and of eight random tools check these
    passes.

    >>> import bristle_sim as bs
    >>> found = bs.design(
    ...     want={"tip_speed_at_contact": "36 m/s", "lag_deg_at_contact": 0},
    ...     vary={"hub_speed": ("2000 rpm", "3000 rpm"), "bar_horizontal": ("47 mm", "54 mm")},
    ... )
    >>> print(f"{found.varied['hub_speed']:.2f} rad/s, {1e3 * found.varied['bar_horizontal']:.3f} mm")
    251.63 rad/s, 50.878 mm

    Args:
        tool: the tool, whose parameters keep their values unless ``vary`` names them; by default
            the dissertation's.
        want: target values of quantities of ``bristle-sim cue_and_impact``, as numbers in its units
            or texts with a unit.
        vary: lower and upper bound of each parameter to vary.
        at_most: upper limits of quantities, or of varied parameters.
        minimize: name of a quantity to minimise.
        maximize: name of a quantity to maximise. At most one of ``minimize`` and ``maximize`` may
            be given.

    Returns:
        The tool found and its pass. If targets and limits conflict, it is the tool that comes
        nearest to meeting them.

    Raises:
        ValueError: for an unknown name or an invalid value, a wire that bends, another law of
            impact, or ranges in which no pass has all quantities. The message is one line.
    """
    if minimize and maximize:
        raise ValueError("minimize, maximize: must be one quantity")
    if not vary:
        raise ValueError("vary: must have at least one key with the ends of its range")
    given = Tool() if tool is None else tool
    ranges = {key: checked_range(given, key, ends) for key, ends in vary.items()}
    limits = dict(at_most or {})
    for key in ranges.keys() & limits.keys():
        low, high = ranges[key]
        lowest, most = checked_range(given, key, (low, limits[key]))
        if lowest < low:
            raise ValueError(f"{key} = {shown(limits[key])}: must be above the range's lower end")
        ranges[key] = (low, min(high, most))
        del limits[key]
    wants = {name: _declared(name).parse(value) for name, value in (want or {}).items()}
    highest = {name: _declared(name).parse(value) for name, value in limits.items()}
    for name in wants.keys() & highest.keys():
        most = highest.pop(name)
        if wants[name] > most:
            raise ValueError(f"{name} = {wants[name]:g}: must be at most its upper limit, {most:g}")
    goal = minimize or maximize
    if goal:
        _declared(goal)
    if not (goal or wants or highest):
        raise ValueError("want: must be given, or a quantity to minimize or maximize")
    return _found(Search(given, ranges, wants, highest, goal, -1.0 if maximize else 1.0))


def _declared(name: str) -> Range:
    """Return the unit and the permitted range of a quantity's target value.

    Raises:
        ValueError: for an unknown name.
    """
    if name not in QUANTITIES:
        raise ValueError(f"unknown quantity {shown(name)}; {likely_key(name, QUANTITIES)}")
    return Range(name, QUANTITIES[name][1], -MOST, MOST)


def _found(search: Search) -> Design:
    """Run the search, simulate the pass of the tool found, and return the design."""
    place, met = search.solution()
    conflict: tuple[str, ...] = ()
    curves: dict[str, Array] = {}
    remarks = list[str]()
    kept = {}
    if not met:
        conflict = search.conflict()
        if len(conflict) == 2:
            points = search.trade_off(conflict, place)
            passes = search.passes(points)
            curves = {name: passes[name] for name in conflict} | search.keys_at(points)
            free = [name for name in search.want if name not in conflict]
            remarks.append(curve_in_words(curves, conflict, free))
    elif search.want:
        kept = _kept(search, place)
        remarks.append(kept_in_words(kept))
    varied = {key: float(each) for key, each in search.keys_at(place).items()}
    tool = search.tool.replace(**varied)
    report = whole_pass(tool, SCENE)
    reached = {each.name: each.simulated for each in report.quantities}
    try:
        before = whole_pass(search.tool, SCENE).quantities
    except ValueError:  # the given tool's parts may overlap although those of the found tool do not
        before = ()
    check = checked_by_scene(search.tool, SCENE, place, search.keys_at)
    words = tool_in_words(search, varied, report, met)
    if conflict:
        words = f"{conflict_in_words(search, conflict)}; the nearest: {words}"
    return Design(
        answer=f"{words[0].upper()}{words[1:]}; {check}.",
        remarks=tuple(remarks),
        tool=tool,
        varied=varied,
        wants=tuple(Want(name, value, reached[name]) for name, value in search.want.items()),
        report=report,
        before={each.name: each.simulated for each in before},
        sensitivity=_sensitivity(search, place),
        kept=kept,
        conflict=conflict,
        trade_off=curves,
        check=check,
    )


def _sensitivity(search: Search, place: Array) -> dict[str, dict[str, float]]:
    """Return the derivatives of the quantities with respect to each parameter, in SI units.

    A derivative is NaN if the quantity jumps at the designed tool. A jump is recognised by
    difference quotients that depend on their step.

    ``place`` holds the parameters of the designed tool as fractions of their ranges.
    """

    def quantities(fractions: Array) -> Array:
        passes = search.passes(fractions)
        return np.array([passes[name] for name in QUANTITIES])

    values, slopes = (each(place) for each in with_derivatives(quantities))
    coarse = with_derivatives(quantities, COARSE_DIFFERENCE)[1](place)
    scale = LEAST_CHANGE * np.abs(values[:, np.newaxis])
    slopes = np.where(np.abs(slopes - coarse) <= SMOOTH * np.abs(slopes) + scale, slopes, np.nan)
    found = {}
    for column, (key, (low, high)) in enumerate(search.vary.items()):
        changes = slopes[:, column] / (high - low)
        found[key] = dict(zip(QUANTITIES, changes.tolist(), strict=True))
    return found


def _kept(search: Search, place: Array) -> dict[str, tuple[float, float]]:
    """Return the lowest and highest value of each parameter at which all targets stay met.

    A target is met within the deviation KEPT or KEPT_DEG. The other parameters do not change.
    ``place`` holds the parameters of the designed tool as fractions of their ranges.
    """
    fractions = np.tile(place[:, np.newaxis], 2)  # lower and upper end
    for row, side in np.ndindex(fractions.shape):
        points = np.tile(place[:, np.newaxis], DISTANCES.size)
        points[row] += (side - place[row]) * DISTANCES
        passes = search.passes(points)
        lost = DISTANCES == 1.0  # at the end of the range at the latest
        for name, wanted in search.want.items():
            allowed = KEPT_DEG if "_deg" in name else KEPT * (abs(wanted) or search.spread[name])
            lost |= ~(np.abs(passes[name] - wanted) <= allowed)
        fractions[row, side] = points[row, lost.argmax()]
    return {key: tuple(ends.tolist()) for key, ends in search.keys_at(fractions).items()}
