"""The integrator of intervals without events: engine steps, extrapolated to zero step length.

In a step the engine moves positions by the old velocities and then changes the velocities. The
error after an interval without events is therefore a smooth function of the step h, of first order.
The interval is integrated repeatedly, with n = 4, 5, 6, 7 ... steps, and the results are
extrapolated to h = 0 (Richardson; Bulirsch and Stoer 1966). Each repetition removes one power of h
from the error. The difference of two extrapolated results, with and without the coarsest
repetition, estimates the error. The length of the next interval and the number of repetitions
follow from this estimate as in Hairer, Norsett and Wanner, *Solving Ordinary Differential Equations
I*, sec. II.9.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect
from collections.abc import Callable, Mapping, Sequence
from operator import mul
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact import RigidContacts
from bristle_sim.scene.mechanism import State

PLACING_COST = 6.0
"""Cost of setting and reading all positions and velocities once, as a number of engine steps. The
choice of the interval's length takes account of it."""

# Rounding error of an angle of a few radians, rad. The weights of extrapolation amplify it.
ANGLE_ROUNDING = 4e-16

FEW_REPETITIONS = 1e-6
"""Tolerance of an interval, in scene units, above which the error is first estimated after three
repetitions. At a smaller tolerance, three repetitions of steps that are not symmetric hardly ever
suffice, and an estimate after the third would take 3 % of the time."""

EARLY_FRACTION = 0.25
"""Error estimate after three repetitions in flight, as a fraction of the permitted error, up to
which no fourth repetition follows.

With steps of a quarter radian the error is a quarter of the estimate, and a fourth repetition would
reduce it tenfold. An interval without a fourth contributes a sixteenth of the permitted error."""

MOST_DAMPING = 8.0
"""Longest interval, in time constants of the engine's damping: two time constants for each of the
four steps of the coarsest repetition. In a far longer step damping reduces the angular velocity to
zero, whatever the length of the step. All repetitions would then agree that the belt does not move,
and the error estimate would miss the error."""

# Least ratio of an error estimate to the estimate of the previous repetition, with damping. A
# smaller estimate, which may be too small by chance, is raised to this ratio.
LEAST_GAIN = 0.1


SpringForce = Callable[[float], tuple[Callable[[], None], Callable[[], list[float]]]]
"""Function that begins the force of a contact with a spring, for steps of a given length.

This function returns two functions. The first is called before each step, and applies the force.
The second is called after the last step, and returns the values of
:class:`bristle_sim.scene.contact.Sums`."""


class IntervalResult(NamedTuple):
    """Result of integrating over an interval.

    Attributes:
        state: the state at the interval's end.
        accelerations: the links' angular accelerations at the interval's end.
        totals: the values of :class:`bristle_sim.scene.contact.Sums` of all contacts in one list;
            empty where the contact forces are unknown.
        error: largest estimated error of an angle (rad) or angular velocity (rad per engine unit of
            time); 0 without an estimate.
        failed: whether a contact would have had to pull. The result is then meaningless except for
            ``totals``.
        errors: estimated error after each repetition of the interval; the key is the repetition's
            index.
        middle: the state in the middle of the interval; None if the integrator does not compute it.
    """

    state: State
    accelerations: tuple[float, ...] = ()
    totals: tuple[float, ...] = ()
    error: float = 0.0
    failed: bool = False
    errors: Mapping[int, float] = MappingProxyType({})
    middle: State | None = None

    def moved(self, time: float) -> IntervalResult:
        """Return the result with its state advanced by a short time at constant accelerations."""
        return self._replace(state=self.state.moved(time, self.accelerations))


class Repetitions:
    """A sequence of numbers of steps for extrapolation, and the weights of the results.

    An interval is integrated once with each number of steps; each integration is a repetition. The
    attributes from ``costs`` on have one entry for each repetition. The entry belongs to the
    extrapolation from this and all earlier repetitions.

    Attributes:
        counts: number of steps of each repetition.
        power: power p of the step length h; the error of a result is a polynomial in h^p.
        costs: total cost, as a number of engine steps.
        first_order: weights for results whose error is a polynomial in h.
        weights: weights for results whose error is a polynomial in h^p.
        differences: weights of the error estimate. The estimate is the extrapolated result minus
            the result extrapolated without the coarsest repetition.
        noise: rounding error of an extrapolated angle, rad; it grows with the number of
            repetitions.
    """

    def __init__(self, *counts: int, power: int = 1) -> None:
        """Compute all weights from the numbers of steps, which must be ascending."""
        rows = range(1, len(counts) + 1)
        self.counts = counts
        self.power = power
        self.costs = [PLACING_COST * row + sum(counts[:row]) for row in rows]
        self.first_order = [lagrange_weights(counts[:row]) for row in rows]
        self.weights = [lagrange_weights(counts[:row], power) for row in rows]
        without = [(0.0, *lagrange_weights(counts[1:row], power)) for row in rows]
        both = zip(self.weights, without, strict=True)
        self.differences = [tuple(a - b for a, b in zip(*each, strict=True)) for each in both]
        self.noise = [ANGLE_ROUNDING * sum(map(abs, weights)) for weights in self.weights]

    def extrapolated(self, columns: Sequence[Sequence[float]], links: int) -> list[float]:
        """Return the values at zero step length.

        The error of symmetric steps is a polynomial in h^2 for the motion and for the sums of
        impulse and work. Accelerations and forces are those of the last steps, and their error is a
        polynomial in h.

        Args:
            columns: the results of the repetitions for each value: angles, angular velocities,
                accelerations, then the values of ``Sums`` for each contact.
            links: number of links.
        """
        row = len(columns[0]) - 1
        sums = self.weights[row]
        ends = self.first_order[row]
        of_motion = [*[sums] * (2 * links), *[ends] * links]
        of_contacts = itertools.cycle((ends, ends, sums, sums, sums, sums, ends))
        used = zip(itertools.chain(of_motion, of_contacts), columns, strict=False)
        return [sum(map(mul, weights, each)) for weights, each in used]


def lagrange_weights(counts: tuple[int, ...], power: int = 1) -> tuple[float, ...]:
    """Return the weights by which results for several steps are extrapolated to zero step length.

    The weights are the values at h = 0 of the Lagrange polynomials in h^power for the nodes h =
    1/n, where n are the numbers of steps in ``counts``.
    """
    return tuple(
        math.prod(n**power / (n**power - other**power) for other in counts if other != n)
        for n in counts
    )


HALVED = Repetitions(
    4, 6, 8, 10, 12, 14, 18, 22, 26, 30, 34, 40
)  # in flight; even numbers of steps, so that the state in the middle of the interval is computed too
CLOSE = Repetitions(
    4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 24
)  # in rigid contact; fewest steps for a given order
WIDE = Repetitions(
    4, 6, 8, 12, 16, 24, 32, 48
)  # with spring forces, which have the rounding error of a small penetration; even, small weights
EVEN = Repetitions(
    2, 4, 6, 8, 10, 12, 16, 20, 24, power=2
)  # for time-symmetric steps; the error of odd numbers of steps is a different polynomial
LEAST_NOISE = HALVED.noise[3]  # least error of an interval, limited by rounding
CUT_SHORT = 0.25
"""Least ratio of an interval's length to the proposed length at which the interval may shorten the
next proposal. A shorter interval, which an event may have ended, leaves the proposal unchanged.
From this ratio on, the usual rule leads back to the proposed length, because the next interval may
be four times as long."""


class Extrapolation:
    """Integrates intervals without events by engine steps, extrapolated to zero step length.

    Args:
        tolerance: largest permitted error of an interval, in scene units.
        longest: longest interval that is proposed. The first interval may be longer. Any interval
            may be a tenth longer, to avoid a short remainder.
        damped_step: longest step whose error estimate is reliable with damping.

    Attributes:
        noise: largest permitted error of an interval: the tolerance, or the rounding error if that
            is larger.
        length: length proposed for the next interval.
        table: sequence of numbers of steps that the last interval used.
    """

    def __init__(
        self, tolerance: float, longest: float = math.inf, damped_step: float = math.inf
    ) -> None:
        """Set the length of the first interval, in which a link rotates by about one radian."""
        self.table = CLOSE
        self.longest = longest
        self.damped_step = damped_step
        self.length = 1.5
        self.noise = max(tolerance, CLOSE.noise[3])

    def propose(self, remaining: float) -> float:
        """Return the next interval's length; a whole number of such intervals fills the time left.

        ``remaining`` is the time to the end of the motion.
        """
        return remaining / max(1, math.ceil(remaining / self.length - 0.1))

    @np.errstate(over="ignore", invalid="ignore")
    def advance(
        self,
        scene: Scene,
        state: State,
        duration: float,
        rigid: RigidContacts | None = None,
        springs: Sequence[SpringForce] = (),
    ) -> IntervalResult:
        """Integrate over an interval, with ever smaller steps until its error is permitted.

        The repetitions with smaller steps end before their rounding error would exceed the
        permitted error. A result that overflows has an infinite error, and no warning is issued.

        Args:
            scene: the scene.
            state: state at the interval's start.
            duration: length of the interval.
            rigid: the rigid contacts; None without rigid contacts.
            springs: forces of the contacts with springs. These forces differ forwards and backwards
                in time, so steps with them are not symmetric.
        """
        symmetric = scene.couples_links and not springs
        table = EVEN if symmetric else WIDE if springs else CLOSE if rigid else HALVED
        self.table = table
        halved = table is HALVED or table is WIDE
        least = 3 if symmetric or self.noise > FEW_REPETITIONS else 4
        early = EARLY_FRACTION * self.noise if table is HALVED else self.noise
        known: dict[int, float] = {}
        links = len(scene.links)
        results: list[list[float]] = []
        halves: list[list[float]] = []
        error = math.inf
        failed = False
        for row, count in enumerate(table.counts[: bisect(table.noise, self.noise)]):
            step = duration / count
            scene.place(state, -0.5 * step if symmetric else 0.0)
            acts = []
            reads = []
            for spring in springs:
                act, read = spring(step)
                acts.append(act)
                reads.append(read)
            values = scene.step(
                step, count, acts, symmetric=symmetric, middle=halves if halved else None
            )
            results.append(values)
            if rigid is not None:
                values += rigid.totals(step, symmetric=symmetric)
                failed = rigid.fails(values[3 * links :])
                if failed:
                    break
            for read in reads:
                values += read()
            if row + 1 >= least:
                columns = [*zip(*results, strict=True)]
                differences = table.differences[row]
                errors = [abs(sum(map(mul, differences, each))) for each in columns[: 2 * links]]
                # If one error is NaN, the result of max depends on the order.
                error = known[row] = max(errors) if sum(errors) < math.inf else math.inf
                limit = early if row == 2 else self.noise
                if error <= limit and step <= self.damped_step:
                    if self.damped_step < math.inf:
                        error = min(max(error, LEAST_GAIN * known.get(row - 1, 0.0)), self.noise)
                    break
        middle = None
        if failed:
            error = math.inf
        else:
            if error == math.inf:
                scene.recover()
            values = table.extrapolated(columns, links)
            if halved:
                best = table.extrapolated([*zip(*halves, strict=True)], links)
                middle = scene.state_at(state.time + 0.5 * duration, best)
        return IntervalResult(
            state=scene.state_at(state.time + duration, values),
            accelerations=tuple(values[2 * links : 3 * links]),
            totals=tuple(values[3 * links :]),
            error=error,
            failed=failed,
            errors=known,
            middle=middle,
        )

    def accepts(self, result: IntervalResult, duration: float) -> bool:
        """Return whether a result's estimated error is permitted, and propose the next length.

        Each error estimate in ``result`` belongs to a number of repetitions. The longest permitted
        interval with this number of repetitions follows from the estimate, and so does the cost per
        simulated time. The interval of least cost is proposed. An accepted interval that was much
        shorter than proposed does not shorten the next proposal.

        Args:
            result: result of an interval.
            duration: length of this interval.
        """
        table = self.table
        limit = self.noise
        lengths = {}
        prices = {}
        for row, error in result.errors.items():
            least = error if error > 1e-3 * limit else 1e-3 * limit
            change = 0.9 * (0.5 * limit / least) ** (1.0 / (table.power * row + 1))
            length = duration * (4.0 if change > 4.0 else 0.1 if change < 0.1 else change)
            lengths[row] = length = length if length < self.longest else self.longest
            prices[row] = table.costs[row] / length
        best = min(prices, key=prices.__getitem__)
        length = lengths[best]
        more = best == max(prices) and best + 1 < bisect(table.noise, limit)
        if more and prices[best] < 0.9 * prices.get(best - 1, math.inf):
            # The cost still falls with the number of repetitions: try one more repetition, with the
            # interval at which it has the same cost per time.
            length *= table.costs[best + 1] / table.costs[best]
        accurate = result.error <= limit
        if not accurate:
            length = min(length, 0.5 * duration)
        elif duration < CUT_SHORT * self.length:
            length = max(length, self.length)
        self.length = length
        return accurate


def damped_interval(scene: Scene) -> float:
    """Return the longest interval in which the engine's steps resolve the damping.

    The interval is infinite without damping, and otherwise ``MOST_DAMPING`` time constants of
    damping. The time constant is that of links without joints, because the engine damps the links
    before the joints correct their velocities.
    """
    links = scene.mechanism.links[: scene.mechanism.wire_links]
    damping = scene.effects.hinge[1]
    bending = [damping * (1.0 / a.inertia + 1.0 / b.inertia) for a, b in itertools.pairwise(links)]
    rate = max([scene.effects.damping / links[0].inertia, *bending])
    return MOST_DAMPING / rate if rate else math.inf
