"""Design: the tool in given ranges whose pass has wanted quantities, and the sensitivity of the
quantities to the parameters.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Report
from bristle_sim.parameters import Tool, tool_keys
from bristle_sim.studies.design_search import (
    MET,
    Function,
    Question,
    look_over,
    nearest,
    solution,
    trade_off,
    with_derivatives,
)
from bristle_sim.studies.design_words import (
    conflict_in_words,
    curve_in_words,
    kept_in_words,
    tool_in_words,
)
from bristle_sim.studies.many_passes import (
    CHECKED_POINTS,
    SCENE,
    Check,
    checked_by_scene,
    unable,
)
from bristle_sim.studies.whole_pass import QUANTITIES, whole_pass
from bristle_sim.units import Choice, Range, likely_key, shown

KEPT = 0.01  # largest relative deviation of a kept quantity from its wanted value
KEPT_DEG = 1.0  # largest deviation of a kept angle from its wanted value, deg
STEPS = 64  # number of values of a parameter on either side at which the deviations are computed
# Number of iterations; each refines the interval up to the first value at which a want is not met
KEPT_ROUNDS = 3
MOST = 1e12  # largest magnitude of a wanted value, in the quantity's unit

DRAWN_BY = "bristle_sim.render.sweep_figures"  # in a higher layer, imported only when a picture is requested


@dataclass(frozen=True, slots=True)
class Want:
    """A wanted quantity.

    Attributes:
        name: name of the quantity.
        wanted: wanted value.
        reached: value in the simulated pass of the tool found; None without a strike.
    """

    name: str
    wanted: float
    reached: float | None


@dataclass(frozen=True, slots=True)
class Design:
    """The result of a design, in SI units, and in degrees where a name ends in ``_deg``.

    Attributes:
        answer: the result in a sentence, with the agreement of single simulations.
        remarks: sentences on compromises between two wants and on the tolerances of the parameters.
        tool: the tool found; if wants conflict, the tool that comes nearest.
        given: the tool from which the search began.
        varied: values found, by parameter.
        wants: wanted and reached values.
        report: report of the simulated pass of the tool found.
        before: simulated quantities of the given tool; None for a quantity that it does not have.
        sensitivity: derivatives of the quantities with respect to each parameter.
        kept: lowest and highest value of each parameter, changed alone, at which all wants stay met
            to 1 % or 1 deg.
        conflict: names of the wants that cannot be met together; empty if all are met.
        trade_off: values of two conflicting wants, and of the parameters, along the curve of best
            compromises.
        check: agreement of the passes in arrays with single simulations.
    """

    answer: str
    remarks: tuple[str, ...]
    tool: Tool
    given: Tool
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
        """Return a matplotlib figure of the trade-off between two wanted quantities that conflict.

        Raises:
            ValueError: if no two wanted quantities conflict.
        """
        if not self.trade_off:
            raise ValueError("plot: must have two conflicting wants; all are met here")
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
    """Find the tool in given ranges whose pass has wanted quantities.

    The bristle must be straight and rigid, with the energetic law of impact. If several tools meet
    the wants, a goal is minimised or maximised. Without a goal the parameters change least,
    relative to their ranges. Simulations confirm the result for the tool found and for eight random
    tools.

    >>> import bristle_sim as bs
    >>> found = bs.design(
    ...     want={"tip_speed_at_contact": "36 m/s", "lag_deg_at_contact": 0},
    ...     vary={"hub_speed": ("2000 rpm", "3000 rpm"), "bar_horizontal": ("47 mm", "54 mm")},
    ... )
    >>> print(f"{found.varied['hub_speed']:.2f} rad/s, {1e3 * found.varied['bar_horizontal']:.3f} mm")
    251.63 rad/s, 50.878 mm

    Args:
        tool: the tool that gives the values of all other parameters; by default the dissertation's.
        want: wanted values of quantities of ``bristle-sim cue_and_impact``, as numbers in its units
            or texts with a unit.
        vary: the two ends of the range of each parameter to vary.
        at_most: upper limits of quantities, or of varied parameters.
        minimize: name of the quantity to minimise.
        maximize: name of the quantity to maximise; only one of the two may be given.

    Returns:
        The tool found and its pass; if the wants conflict, the tool that comes nearest.

    Raises:
        ValueError: in one line, for an unknown name or a refused value, a wire that bends, another
            law of impact, or ranges in which no pass has the quantities.
    """
    question = _question(Tool() if tool is None else tool, want, vary, at_most, minimize, maximize)
    first = look_over(question)
    place = solution(question, first)
    conflict: tuple[str, ...] = ()
    curve: Array | None = None
    if place is None:
        conflict = _conflict(question, first)
        place, _ = nearest(question, first, question.want)
        if len(conflict) == 2:
            curve = trade_off(question, place, (conflict[0], conflict[1]))
    return _result(question, place, conflict, curve)


def quantity_range(name: str) -> Range:
    """Return the declaration of a quantity, with its unit and range, by which a wanted value is
    read.

    Raises:
        ValueError: for an unknown name.
    """
    if name not in QUANTITIES:
        raise ValueError(f"unknown quantity {shown(name)}; {likely_key(name, QUANTITIES)}")
    return Range(name, QUANTITIES[name][1], -MOST, MOST, True, "")


def _question(
    tool: Tool,
    want: Mapping[str, Any] | None,
    vary: Mapping[str, Any],
    at_most: Mapping[str, Any] | None,
    minimize: str,
    maximize: str,
) -> Question:
    """Check the arguments of a design and return them as a question for the search.

    Raises:
        ValueError: for an argument that is refused.
    """
    if reason := unable(tool):
        raise ValueError(f"{reason}: must be a straight rigid bristle with the energetic law")
    if minimize and maximize:
        raise ValueError("minimize, maximize: must be one quantity")
    keys = {key: each for part in tool_keys().values() for key, (_, each) in part.items()}
    ranges = {}
    for key, ends in vary.items():
        if key not in keys:
            raise ValueError(f"unknown key {shown(key)}; {likely_key(key, keys)}")
        ranges[key] = _ends(keys[key], ends)
    if not ranges:
        raise ValueError("vary: must have at least one key with the ends of its range")
    limits = {}
    for name, value in (at_most or {}).items():
        if name in ranges:
            low, high = ranges[name]
            most = _number(keys[name], value)
            if not most > low:
                raise ValueError(f"{name} = {shown(value)}: must be above the range's lower end")
            ranges[name] = (low, min(high, most))
        else:
            limits[name] = _number(quantity_range(name), value)
    wants = {name: _number(quantity_range(name), value) for name, value in (want or {}).items()}
    goal = minimize or maximize
    if goal:
        quantity_range(goal)
    if not (goal or wants or limits):
        raise ValueError("want: must be given, or a quantity to minimize or maximize")
    return Question(tool, ranges, wants, limits, goal, -1.0 if maximize else 1.0)


def _ends(declared: Range | Choice, ends: Any) -> tuple[float, float]:
    if isinstance(declared, Choice) or declared.whole:
        raise ValueError(f"{declared.key}: must be a key with a continuous range, to be varied")
    if not isinstance(ends, list | tuple) or len(ends) != 2:
        raise ValueError(f"{declared.key} = {shown(ends)}: must be the two ends of a range")
    low, high = sorted(_number(declared, each) for each in ends)
    if low == high:
        raise ValueError(f"{declared.key} = {shown(ends)}: must be two different ends of a range")
    return low, high


def _number(declared: Any, value: Any) -> float:
    return float(declared.parse(value) if isinstance(value, str) else declared.check(value))


def _conflict(question: Question, first: Array) -> tuple[str, ...]:
    """Return the smallest set of wants that cannot be met together."""
    wants = tuple(question.want)
    for number in range(len(wants)):
        for chosen in itertools.combinations(wants, number):
            if nearest(question, first, chosen)[1] > MET:
                return chosen
    return wants


def _result(
    question: Question, place: Array, conflict: tuple[str, ...], curve: Array | None
) -> Design:
    """Return the design at a point of the search, confirmed by simulations.

    ``place`` has the parameters as fractions of their ranges.
    """
    varied = {key: float(each[0]) for key, each in question.keys_at(place[:, np.newaxis]).items()}
    found = question.tool.replace(**varied)
    report = whole_pass(found, SCENE)
    reached = {each.name: each.simulated for each in report.quantities}
    try:
        before = whole_pass(question.tool, SCENE).quantities
    except ValueError:  # the given tool's parts may overlap although those of the found tool do not
        before = ()
    random = np.random.default_rng(1).random((place.size, CHECKED_POINTS))
    points = question.keys_at(np.concatenate([place[:, np.newaxis], random], axis=1))
    _, slopes = with_derivatives(_quantities_of(question))(place)
    widths = [high - low for low, high in question.vary.values()]
    sensitivity = {
        key: dict(zip(QUANTITIES, (slopes[:, i] / widths[i]).tolist(), strict=True))
        for i, key in enumerate(varied)
    }
    curves: dict[str, Array] = {}
    if curve is not None:
        passes = question.passes(curve)
        curves = {name: passes[name] for name in conflict} | question.keys_at(curve)
    check = checked_by_scene(question.tool, SCENE, points)
    words = tool_in_words(question, varied, reached)
    remarks = list[str]()
    kept = {}
    if conflict:
        words = f"{conflict_in_words(question, conflict)}; the nearest: {words}"
        remarks += [curve_in_words(curves, conflict)] if curves else []
    elif question.want:
        kept = _kept(question, place)
        remarks.append(kept_in_words(kept))
    return Design(
        answer=f"{words[0].upper()}{words[1:]}; {check}.",
        remarks=tuple(remarks),
        tool=found,
        given=question.tool,
        varied=varied,
        wants=tuple(Want(name, value, reached[name]) for name, value in question.want.items()),
        report=report,
        before={each.name: each.simulated for each in before},
        sensitivity=sensitivity,
        kept=kept,
        conflict=conflict,
        trade_off=curves,
        check=check,
    )


def _quantities_of(question: Question) -> Function:
    """Return the function that computes all quantities at given fractions of the parameters'
    ranges.
    """

    def quantities(fractions: Array) -> Array:
        passes = question.passes(fractions)
        return np.array([passes[name] for name in QUANTITIES])

    return quantities


def _kept(question: Question, place: Array) -> dict[str, tuple[float, float]]:
    """Return the interval of each parameter in which all wants stay met while the other parameters
    do not change.

    An end of the parameter's range is an end of the interval if the wants are met at STEPS equal
    steps up to it.
    """
    allowed = {
        name: KEPT_DEG if "_deg" in name else KEPT * abs(value)
        for name, value in question.want.items()
    }
    allowed = {name: each for name, each in allowed.items() if each}
    found = {}
    for number, (key, (low, high)) in enumerate(question.vary.items()):
        ends = []
        for end in (0.0, 1.0):
            far = end
            # each round is finer, so that a narrow range is resolved too
            for _ in range(KEPT_ROUNDS):
                along = np.tile(place[:, np.newaxis], STEPS + 1)
                along[number] = np.linspace(place[number], far, STEPS + 1)
                passes = question.passes(along)
                off = [
                    np.abs(passes[name] - question.want[name]) / most
                    for name, most in allowed.items()
                ]
                off = np.nan_to_num(np.max(off, axis=0, initial=0.0), nan=np.inf)
                if not (off > 1.0).any():
                    break
                far = along[number, int(np.argmax(off > 1.0))]
            ends.append(low + (high - low) * far)
        found[key] = (ends[0], ends[1])
    return found
