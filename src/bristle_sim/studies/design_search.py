"""Search of the ranges of some parameters for the tool whose pass has wanted quantities, with
passes computed in arrays.

Every parameter is expressed as a fraction, from 0 to 1, of its range. Differential evolution (R.
Storn and K. Price, *Journal of Global Optimization* 11 (1997) 341-359) with an exact penalty on the
wants finds starting points. Least squares and sequential quadratic programming refine them.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import differential_evolution, least_squares, minimize
from scipy.stats.qmc import Sobol

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.passes.request import key_values
from bristle_sim.settings import Settings
from bristle_sim.studies.many_passes import OUTCOME, REASON, pass_quantities

SEED = 1
FIRST = 1024  # number of passes of the first survey of the ranges; fewer passes would take as long
POPULATION = 256
GENERATIONS = 30
STARTS = 4  # number of best points of a population that are refined
# Step of a fraction in a finite difference. The truncation error is some 1e-10, as large as the error
# of the passes.
DIFFERENCE = 1e-5
SETTINGS = Settings(accuracy=1e-10)  # accuracy of the passes
# Penalty for a miss of one standard deviation of the wanted quantity; a goal changes by only a few of
# its standard deviations.
PENALTY = 30.0
NO_STRIKE = 1e6  # value that is minimised, for a pass without the quantities
MET = 1e-6  # largest miss at which a want counts as met, in standard deviations of the quantity
MOST_STEPS = 60  # largest number of iterations of a refinement

Function = Callable[[Array], Array]
"""Function of fractions of the parameters' ranges, shape (parameters, points), that returns values at
the points."""


class NoSolutionError(ValueError):
    """Raised if no tool in the ranges has a pass with the wanted quantities."""


@dataclass(frozen=True, slots=True)
class Question:
    """The statement of a design: wanted values, upper limits, ranges of the varied parameters, and
    the goal.

    Attributes:
        tool: the tool that gives the values of all other parameters.
        vary: the two ends of each parameter's range.
        want: wanted values, by quantity.
        at_most: upper limits, by quantity.
        goal: quantity that is minimised if several tools meet the wants; without a goal the change
            of the parameters is minimised.
        sense: 1 to minimise the goal, -1 to maximise it.
        spread: standard deviation of each quantity over the ranges, in which misses are measured.
    """

    tool: Tool
    vary: dict[str, tuple[float, float]]
    want: dict[str, float]
    at_most: dict[str, float]
    goal: str = ""
    sense: float = 1.0
    spread: dict[str, float] = field(default_factory=dict)

    def keys_at(self, fractions: Array) -> dict[str, Array]:
        """Return the values of the varied parameters at fractions of their ranges, shape
        (parameters, points).
        """
        pairs = zip(self.vary.items(), fractions, strict=True)
        return {key: low + (high - low) * each for (key, (low, high)), each in pairs}

    def passes(self, fractions: Array) -> dict[str, Array]:
        """Compute one pass for each set of parameter values, and return the results by name.

        Each value is given as a fraction of its parameter's range, from 0 to 1.
        """
        return pass_quantities(self.tool, SETTINGS, **self.keys_at(fractions))

    def present(self) -> Array:
        """Return the tool's own values as fractions of the ranges; a value outside its range is
        moved to the nearest end.
        """
        own = key_values(self.tool)
        found = [(own[key] - low) / (high - low) for key, (low, high) in self.vary.items()]
        return np.asarray(np.nan_to_num(np.clip(found, 0.0, 1.0), nan=0.5))

    def misses(self, fractions: Array, wants: Collection[str]) -> Array:
        """Return by how much passes miss wants and exceed upper limits, in standard deviations of
        the quantities.

        A quantity below its limit gives 0. The shape is (wants and limits, points).
        """
        found = self.passes(fractions)
        missed = [(found[name] - self.want[name]) / self.spread[name] for name in wants]
        over = [(found[name] - most) / self.spread[name] for name, most in self.at_most.items()]
        both = [*missed, *np.maximum(over, 0.0)]
        return np.array(both) if both else np.zeros((0, fractions.shape[1]))

    def costs(self, fractions: Array) -> Array:
        """Return the goal, the misses of the wants, and the excesses over the upper limits, in
        standard deviations of the quantities.

        An excess is negative below the limit. The shape is (1 + wants and limits, points).
        """
        found = self.passes(fractions)
        goal = np.sum((fractions - self.present()[:, np.newaxis]) ** 2, axis=0)
        if self.goal:
            goal = self.sense * found[self.goal] / self.spread[self.goal]
        limits = self.want | self.at_most
        return np.array(
            [goal, *((found[name] - value) / self.spread[name] for name, value in limits.items())]
        )


def look_over(question: Question) -> Array:
    """Survey the ranges: store the standard deviations of the quantities in the question, and
    return the points whose passes have all quantities.

    Returns:
        Fractions of the ranges, shape (parameters, points).

    Raises:
        NoSolutionError: if no pass has all quantities, or a quantity does not depend on the
            parameters.
    """
    fractions = Sobol(len(question.vary), seed=SEED).random(FIRST).T
    found = question.passes(fractions)
    names = {*question.want, *question.at_most, *filter(None, (question.goal,))}
    known = np.all([np.isfinite(found[name]) for name in names], axis=0)
    if not known.any():
        words, numbers = np.unique(found[OUTCOME], return_counts=True)
        reason = found[REASON][found[OUTCOME] == words[numbers.argmax()]][0]
        raise NoSolutionError(
            f"no tool in these ranges has such a pass: it {words[numbers.argmax()]}; {reason}"
        )
    for name in names:
        values = found[name][known]
        question.spread[name] = float(values.std())
        if question.spread[name] <= 1e-9 * np.abs(values).max():
            raise NoSolutionError(
                f"{name}: does not depend on {', '.join(question.vary)}; vary another key"
            )
    return np.asarray(fractions[:, known])


def met(question: Question, start: Array, wants: Collection[str]) -> tuple[Array, float]:
    """Return the point near a start at which wants and limits are met best, as fractions, and its
    largest miss.
    """
    missed = functools.partial(question.misses, wants=wants)
    found = _least_squares(missed, start) if wants or question.at_most else start
    return found, float(np.abs(missed(found[:, np.newaxis])).max(initial=0.0))


def _least_squares(function: Function, start: Array) -> Array:
    """Return the point near a start at which the sum of squares of a function's values is least, as
    fractions.
    """
    at = with_derivatives(function)
    inside = np.clip(start, 1e-6, 1.0 - 1e-6)
    if not np.isfinite(at(inside)[0]).all():
        return start
    found = least_squares(
        lambda place: at(place)[0],
        inside,
        lambda place: at(place)[1],
        bounds=(0.0, 1.0),
        xtol=1e-13,
        ftol=1e-13,
        gtol=1e-13,
        max_nfev=MOST_STEPS,
    )
    return np.asarray(found.x)


def with_derivatives(function: Function) -> Callable[[Array], tuple[Array, Array]]:
    """Return a function of one point that returns the values of ``function`` and their derivatives.

    The derivatives are finite differences within the ranges; a derivative that is not finite is 0.
    The values have the shape (values,), the derivatives (values, parameters). One call of
    ``function`` computes both.
    """

    @functools.lru_cache(maxsize=2)
    def at(text: bytes) -> tuple[Array, Array]:
        place = np.frombuffer(text)[:, np.newaxis]
        steps = DIFFERENCE * np.eye(len(place))
        high = np.minimum(place + steps, 1.0)
        low = np.maximum(place - steps, 0.0)
        values = function(np.concatenate([place, low, high], axis=1))
        lows, highs = np.split(values[:, 1:], 2, axis=1)
        return values[:, 0], np.nan_to_num((highs - lows) / np.diagonal(high - low))

    return lambda place: at(place.tobytes())


def evolved(merit: Function, first: Array) -> Array:
    """Minimise a function by differential evolution from a first population.

    Returns:
        The best points of the last population as fractions, the best first, shape (parameters,
        STARTS).
    """
    order = np.argsort(merit(first))[:POPULATION]
    population = first[:, order].T
    if len(population) < POPULATION:
        random = np.random.default_rng(SEED).random((POPULATION - len(population), len(first)))
        population = np.concatenate([population, random])
    found = differential_evolution(
        merit,
        [(0.0, 1.0)] * len(first),
        init=population,
        maxiter=GENERATIONS,
        polish=False,
        seed=SEED,
        vectorized=True,
        updating="deferred",
    )
    best = np.argsort(found.population_energies)[:STARTS]
    return np.asarray(found.population[best].T)


def solution(question: Question, first: Array) -> Array | None:
    """Return the point at which all wants and limits are met and the goal is least, as fractions.

    It is None if they cannot all be met.
    """
    wants = len(question.want)

    def merit(fractions: Array) -> Array:
        """Return the value that is minimised: the goal plus the penalty for misses."""
        goal, *rest = question.costs(fractions)
        missed = np.abs(rest[:wants]).sum(axis=0) + np.maximum(rest[wants:], 0.0).sum(axis=0)
        return np.asarray(np.nan_to_num(goal + PENALTY * missed, nan=NO_STRIKE))

    best: tuple[float, Array] | None = None
    for start in evolved(merit, first).T:
        place, miss = met(question, start, question.want)
        if miss > MET:
            continue
        if question.goal or len(question.vary) > wants:
            place, miss = met(question, _least_goal(question, place), question.want)
        value = float(question.costs(place[:, np.newaxis])[0, 0])
        if miss <= MET and (best is None or value < best[0]):
            best = value, place
    return None if best is None else best[1]


def _least_goal(question: Question, start: Array) -> Array:
    """Return the point near a start at which the goal is least while wants and limits are met, as
    fractions.
    """
    wants = slice(1, 1 + len(question.want))
    limits = slice(1 + len(question.want), None)

    at = with_derivatives(lambda place: np.nan_to_num(question.costs(place), nan=NO_STRIKE))
    constraints = [
        {
            "type": kind,
            "fun": lambda place, part=part, sign=sign: sign * at(place)[0][part],
            "jac": lambda place, part=part, sign=sign: sign * at(place)[1][part],
        }
        for kind, part, sign in (("eq", wants, 1.0), ("ineq", limits, -1.0))
    ]
    found = minimize(
        lambda place: at(place)[0][0],
        start,
        jac=lambda place: at(place)[1][0],
        bounds=[(0.0, 1.0)] * start.size,
        constraints=constraints,
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": MOST_STEPS},
    )
    return np.asarray(np.clip(found.x, 0.0, 1.0))


def nearest(question: Question, first: Array, wants: Collection[str]) -> tuple[Array, float]:
    """Return the point at which wants and limits are missed least, as fractions, and its largest
    miss.
    """

    def merit(fractions: Array) -> Array:
        squares = (question.misses(fractions, wants) ** 2).sum(axis=0)
        return np.asarray(np.nan_to_num(squares, nan=NO_STRIKE))

    starts = first[:, np.argsort(merit(first))[:STARTS]]
    found = [met(question, start, wants) for start in starts.T]
    sums = [merit(place[:, np.newaxis])[0] for place, _ in found]
    return found[int(np.argmin(sums))]


CURVE_POINTS = 25
# Weight of the want that a point of the curve meets; its miss is then some 1e-6 of its standard deviation
STIFFNESS = 1e3


def trade_off(question: Question, start: Array, pair: tuple[str, str]) -> Array:
    """Return points of the curve of best compromises between two wants, as fractions, shape
    (parameters, points).

    The first want is met at the first point, the second want at the last point.
    """
    limits = [STIFFNESS] * len(question.at_most)
    held = question.want[pair[0]]
    spread = question.spread[pair[0]]

    def best(place: Array, value: float, weights: tuple[float, float]) -> Array:
        """Return the best compromise near a point if the first want had another value."""
        factors = np.array([*weights, *limits])[:, np.newaxis]
        shift = np.array([held - value, *[0.0] * (len(limits) + 1)])[:, np.newaxis] / spread
        return _least_squares(lambda each: (question.misses(each, pair) + shift) * factors, place)

    place = best(start, held, (1.0, STIFFNESS))
    end = float(question.passes(place[:, np.newaxis])[pair[0]][0])
    curve = [place]
    for value in np.linspace(end, held, CURVE_POINTS)[1:]:
        place = best(place, value, (STIFFNESS, 1.0))
        curve.append(place)
    return np.array(curve[::-1]).T
