"""Search for a tool, with some parameters in given ranges, whose pass attains target values.

A pass is the trip of one bristle past bar and workpart; many passes are computed at once, in
arrays. Every parameter is expressed as a fraction of its range, from 0 to 1. The passes at the
points of a Sobol sequence are computed first, and the best of these points start the search.
Differential evolution (R. Storn and K. Price, *Journal of Global Optimization* 11 (1997) 341-359),
with an exact penalty on deviations from the conditions, gives further starting points. From each
starting point the method of least squares finds a point that meets the conditions. Sequential
quadratic programming then minimises the objective subject to the conditions.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy  # imports scipy.stats, which takes half a second, only where it is used
from scipy.optimize import differential_evolution, least_squares, minimize

from bristle_sim.arrays import Array, Number
from bristle_sim.parameters import Tool
from bristle_sim.passes.request import key_values
from bristle_sim.passes.strike import OUTCOMES, REFUSED
from bristle_sim.settings import Settings
from bristle_sim.studies.many_passes import (
    OUTCOME,
    Function,
    pass_quantities,
    values_at,
    with_derivatives,
)
from bristle_sim.studies.sweep_point import FAILURE

SEED = 1
SURVEYED = 1024  # number of sampled points; the passes of fewer points would take as long
POPULATION = 256  # number of points in each generation of the differential evolution
GENERATIONS = 30
STARTS = 4  # number of the best sampled points that are refined, and of the best evolved ones
NEAR = 2  # decimals of the fractions; of points that agree to these decimals only one is refined
SETTINGS = Settings(accuracy=1e-10)  # accuracy of the passes
# Penalty that is added to the objective if a quantity deviates from its condition by one standard
# deviation. The objective itself varies by only a few of its standard deviations.
PENALTY = 30.0
NO_STRIKE = 1e6  # value that replaces the objective where a pass lacks a quantity
MET = 1e-6  # largest deviation at which a condition counts as met, in standard deviations
DIGITS = 12  # decimals of a parameter's fraction of its range; further ones are rounding error
MOST_STEPS = 60  # largest number of evaluations in the search for a point that meets the conditions
TOLERANCES = {"xtol": 1e-13, "ftol": 1e-13, "gtol": 1e-13}  # relative, of that search
# Largest number of iterations of a minimisation. Three to ten are needed where the objective is
# smooth. Where it jumps, no number suffices.
MOST_ITERATIONS = 20
CURVE_POINTS = 25
END = 1e-4  # largest deviation, in standard deviations, of the condition met at an end of the curve
# Weight of the conditions that every point on the curve of compromises must meet, to about 1e-6;
# the condition that is sacrificed has the weight 1
STIFFNESS = 1e3


@dataclass(slots=True)
class Search:
    """The search for a tool: its conditions, the ranges of the varied parameters, and the
    objective.

    A condition is a target value (``want``) or an upper limit (``at_most``) of a quantity. A point
    of the search is a set of parameters, each as a fraction of its range from 0 to 1. The objective
    is minimised among the points that meet all conditions. It is the quantity ``goal`` if ``goal``
    is to be minimised, and its negative if ``goal`` is to be maximised. If ``goal`` is empty, the
    objective is the sum of the squared changes of the parameters from those of ``tool``, as
    fractions of their ranges.

    Attributes:
        tool: the tool that gives the values of all other parameters.
        vary: lower and upper bound of each varied parameter.
        want: target values, by quantity.
        at_most: upper limits, by quantity.
        goal: name of the quantity to minimise or maximise; empty if there is none.
        sense: 1 to minimise the quantity ``goal``, -1 to maximise it.
        surveyed: sampled points at which the quantities of all conditions and of the objective
            exist, shape (parameters, points).
        spread: standard deviation of each quantity among the sampled points. Deviations from the
            conditions are divided by it.
        present: parameters of ``tool`` as a point, shape (parameters, 1). A parameter outside its
            range is moved to the nearest bound.
    """

    tool: Tool
    vary: dict[str, tuple[float, float]]
    want: dict[str, float]
    at_most: dict[str, float]
    goal: str
    sense: float
    surveyed: Array = field(init=False)
    spread: dict[str, float] = field(init=False)
    present: Array = field(init=False)

    def __post_init__(self) -> None:
        """Sample the ranges, and compute the standard deviation of each quantity.

        Raises:
            ValueError: if no pass has all quantities, or a quantity does not depend on the
                parameters.
        """
        fractions = scipy.stats.qmc.Sobol(len(self.vary), seed=SEED).random(SURVEYED).T
        found = self.passes(fractions)
        names = {*self.conditions, *filter(None, [self.goal])}
        known = np.all([np.isfinite(found[name]) for name in names], axis=0)
        if not known.any():
            words, numbers = np.unique(found[OUTCOME], return_counts=True)
            most = words[numbers.argmax()]
            reason = found[FAILURE][found[OUTCOME] == most][0]
            most = "is refused" if most == OUTCOMES[REFUSED] else most
            raise ValueError(f"no tool in these ranges has such a pass: it {most}; {reason}")
        self.surveyed = fractions[:, known]
        self.spread = {name: float(found[name][known].std()) for name in names}
        for name, spread in self.spread.items():
            if spread <= 1e-9 * np.abs(found[name][known]).max():
                raise ValueError(
                    f"{name}: does not depend on {', '.join(self.vary)}; vary another key"
                )
        own = key_values(self.tool)
        present = [[(own[key] - low) / (high - low)] for key, (low, high) in self.vary.items()]
        self.present = np.nan_to_num(np.clip(present, 0.0, 1.0), nan=0.5)

    @property
    def conditions(self) -> dict[str, float]:
        """Target value or upper limit of each quantity that has one, by name."""
        return self.want | self.at_most

    def keys_at(self, fractions: Array) -> dict[str, Array]:
        """Return the values of the varied parameters at given points, by name.

        ``fractions`` holds the parameters as fractions of their ranges, shape (parameters, points).
        """
        return values_at(self.vary, fractions)

    def passes(self, fractions: Array) -> dict[str, Array]:
        """Compute the pass of the tool at each point, and return the results by name.

        ``fractions`` holds the parameters as fractions of their ranges, shape (parameters, points).
        """
        return pass_quantities(self.tool, SETTINGS, **self.keys_at(fractions))

    def costs(self, fractions: Array) -> Array:
        """Return the objective and the signed deviations from the conditions at each point.

        A deviation is the quantity's value minus its target value or upper limit, divided by the
        quantity's standard deviation. The shape is (1 + conditions, points), with the objective in
        the first row.
        """
        found = self.passes(fractions)
        goal = np.sum((fractions - self.present) ** 2, axis=0)
        if self.goal:
            goal = self.sense * found[self.goal] / self.spread[self.goal]
        excesses = [
            (found[name] - value) / self.spread[name] for name, value in self.conditions.items()
        ]
        return np.array([goal, *excesses])

    def misses(self, fractions: Array) -> Array:
        """Return the deviations from the target values, then the excesses above the upper limits.

        Each is divided by its quantity's standard deviation. An excess is 0 below the limit. The
        result has the shape (conditions, points), ``fractions`` the shape (parameters, points).
        """
        return self._beyond(self.costs(fractions))

    def _beyond(self, costs: Array) -> Array:
        """Return the deviations and excesses of ``misses``, given the result of ``costs``."""
        deviations, excesses = np.split(costs[1:], [len(self.want)])
        return np.concatenate([deviations, np.maximum(excesses, 0.0)])

    def solution(self) -> tuple[Array, bool]:
        """Return the point with the least objective among those that meet all conditions.

        Returns:
            The point, as fractions of the ranges. If no point meets all conditions, it is the point
                of least deviation.
            Whether all conditions are met.
        """

        def merit(fractions: Array) -> Array:
            """Return the objective plus a penalty on deviations; NO_STRIKE for missing quantities."""
            found = self.costs(fractions)
            found = found[0] + PENALTY * np.abs(self._beyond(found)).sum(axis=0)
            return np.asarray(np.nan_to_num(found, nan=NO_STRIKE))

        population = np.resize(np.argsort(merit(self.surveyed)), POPULATION)
        evolved = differential_evolution(
            merit,
            [(0.0, 1.0)] * len(self.surveyed),
            init=self.surveyed[:, population].T,
            maxiter=GENERATIONS,
            polish=False,
            seed=SEED,
            vectorized=True,
            updating="deferred",
        )
        best = np.argsort(evolved.population_energies)[:STARTS]
        places = [self._closest(start, self.misses) for start in evolved.population[best]]
        if self.conditions:
            places.append(self.nearest(np.ones(len(self.conditions))))
        met = [each for each in places if self.largest_miss(each) <= MET]
        if not met:
            return places[-1], False
        distinct = np.sort(np.unique(np.round(met, NEAR), axis=0, return_index=True)[1])
        found = np.transpose([self._improved(met[each]) for each in distinct])
        return found[:, self.costs(found)[0].argmin()], True

    def nearest(
        self,
        weights: Array,
        missed: Number = 0.0,
        starts: Sequence[Array] = (),
        sampled: int = STARTS,
    ) -> Array:
        """Return the point with the least sum of squared weighted deviations from the conditions.

        A point holds the parameters as fractions of their ranges.

        Args:
            weights: weight of each condition.
            missed: accepted deviations, subtracted before weighting, shape (conditions, 1).
            starts: starting points of the search.
            sampled: number of the best sampled points that are starting points too.
        """

        def weighted(fractions: Array) -> Array:
            """Return the weighted deviations beyond the accepted ones, shape (conditions, points)."""
            return np.asarray(weights[:, np.newaxis] * (self.misses(fractions) - missed))

        def merit(fractions: Array) -> Array:
            """Return the sum of squares of the weighted deviations."""
            return np.asarray((weighted(fractions) ** 2).sum(axis=0))

        if sampled:
            starts = (*starts, *self.surveyed[:, np.argsort(merit(self.surveyed))[:sampled]].T)
        places = [self._closest(start, weighted) for start in starts]
        return places[int(np.argmin(merit(np.transpose(places))))]

    def conflict(self) -> tuple[str, ...]:
        """Return the smallest set of conditions that cannot be met together."""
        names = tuple(self.conditions)
        for number in range(1, len(names)):
            for chosen in itertools.combinations(names, number):
                weights = np.array([float(name in chosen) for name in names])
                if self.largest_miss(self.nearest(weights), weights) > MET:
                    return chosen
        return names

    def trade_off(self, pair: tuple[str, ...], place: Array) -> Array:
        """Return points on the curve of best compromises between two conditions.

        The shape is (parameters, points). The first condition is met at the first point, the second
        at the last, unless upper limits prevent it. No point misses both by more than another does.

        Args:
            pair: names of the two conditions.
            place: the point of least deviation. The curve is a narrow valley of the sum of squares,
                along which a search that starts elsewhere moves slowly.
        """
        names = tuple(self.conditions)
        first, second = (names.index(name) for name in pair)
        only = np.eye(len(names))
        weights = np.where(np.arange(len(names)) < len(self.want), 0.0, STIFFNESS)
        weights[[first, second]] = 1.0, STIFFNESS
        curve = [self.nearest(weights, starts=[place], sampled=1)]
        if self.largest_miss(curve[0], only[second]) > END:
            curve = [self.nearest(weights, starts=curve)]
        missed = only[:, [first]] * self.misses(curve[0][:, np.newaxis])
        weights[[first, second]] = STIFFNESS, 1.0
        parts = np.linspace(1.0, 0.0, CURVE_POINTS)
        for part in parts[1:]:
            curve.append(self.nearest(weights, part * missed, curve[-1:], sampled=0))
        if self.largest_miss(curve[-1], only[first]) > END:
            # The curve jumps where the outcome changes; beyond the jump it starts at its other end.
            curve[-1] = self.nearest(weights, 0.0 * missed, curve[-1:])
            for index in range(CURVE_POINTS - 2, 0, -1):
                starts = curve[index : index + 2]
                curve[index] = self.nearest(weights, parts[index] * missed, starts, sampled=0)
        points = np.array(curve[::-1]).T
        miss = np.abs(self.misses(points)[[first, second]])
        beaten = np.all(miss[:, :, np.newaxis] > miss[:, np.newaxis], axis=0).any(axis=1)
        return points[:, ~beaten]

    def largest_miss(self, place: Array, weights: Number = 1.0) -> float:
        """Return the largest magnitude of weighted deviations from the conditions at ``place``."""
        return float(np.max(np.abs(weights * self.misses(place[:, np.newaxis])[:, 0]), initial=0.0))

    def _closest(self, start: Array, function: Function) -> Array:
        """Return the point near ``start`` of the least sum of squares of a function's values."""
        if not self.conditions:
            return start
        value, slopes = with_derivatives(function)
        found = least_squares(
            value,
            start,
            slopes,
            bounds=(0.0, 1.0),
            method="dogbox",
            max_nfev=MOST_STEPS,
            **TOLERANCES,
        )
        return np.asarray(found.x)

    def _improved(self, start: Array) -> Array:
        """Return the point near ``start`` of least objective, subject to the conditions.

        Where the outcome of a pass changes, objective and conditions jump. The minimisation may
        then end at a point that violates a condition or is not the best. In that case the best of
        all evaluated points that meet the conditions is returned.
        """
        way = [start]
        value, slopes = with_derivatives(
            lambda place: np.nan_to_num(self.costs(place), nan=NO_STRIKE)
        )
        wants = slice(1, 1 + len(self.want))
        conditions = [
            {
                "type": kind,
                "fun": lambda place, rows=rows: -value(place)[rows],
                "jac": lambda place, rows=rows: -slopes(place)[rows],
            }
            for kind, rows in (("eq", wants), ("ineq", slice(wants.stop, None)))
        ]

        def objective(place: Array) -> float:
            """Return the objective at a point, and keep the point."""
            way.append(place.copy())
            return float(value(place)[0])

        found = minimize(
            objective,
            start,
            jac=lambda place: slopes(place)[0],
            bounds=[(0.0, 1.0)] * start.size,
            constraints=conditions,
            method="SLSQP",
            options={"ftol": 1e-12, "maxiter": MOST_ITERATIONS},
        )
        places = np.clip(np.transpose([*way, found.x]).round(DIGITS), 0.0, 1.0)
        costs = self.costs(places)
        met = np.max(np.abs(self._beyond(costs)), axis=0, initial=0.0) <= MET
        costs = np.where(met, costs[0], np.nan)
        best = int(np.nanargmin(costs))
        # A violation of a condition by up to MET lowers the objective by a few MET. The last point
        # is therefore kept if its objective exceeds the lowest one by at most 10 MET.
        last = costs[-1] <= costs[best] + 10.0 * MET
        return np.asarray(places[:, -1 if last else best])
