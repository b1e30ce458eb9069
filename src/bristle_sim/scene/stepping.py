"""How a scene is carried over a smooth interval of motion: plain engine steps, or engine steps extrapolated to zero.

The engine moves positions by the old velocities and then changes the velocities, so its error over an interval without
events is smooth in the step h, of first order. Repeating the interval with n = 4, 5, 6, 7 ... steps and extrapolating the
results to h = 0 (Richardson; Bulirsch and Stoer 1966) removes one power of h per repetition. The difference between
the last two extrapolates estimates the error; step and number of repetitions follow from it as in Hairer, Norsett and
Wanner, *Solving Ordinary Differential Equations I*, sec. II.9.
"""

from __future__ import annotations

import math
from operator import mul
from typing import NamedTuple, Protocol

from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.repetitions import CLOSE, LEAST_ROWS, Repetitions

__all__ = ["Advance", "Extrapolation", "PlainSteps", "Stepper", "SymmetricSteps"]

INSTANT = 1e-6
"""Steps shorter than this, in a scene's time units, open joints by less than rounding matters."""


class Load(Protocol):
    """What acts on the links besides springs and joints, and what it adds up over an interval."""

    def begin(self) -> None:
        """A run over an interval begins: forget what was added up."""

    def apply(self, step: float) -> None:
        """Act on the bodies for the next engine step."""

    def totals(self, step: float) -> list[float]:
        """What was added up, as numbers that are smooth in the step."""

    def fails(self, totals: list[float]) -> bool:
        """Whether the load could not act as it should, so that the interval is of no use."""


class Advance(NamedTuple):
    """Result of carrying a scene over an interval.

    Attributes:
        state: at the end.
        accelerations: of the links at the end (extrapolated) or over the last step (plain).
        totals: what a load added up.
        error: estimated error of the state, of angles in rad and of rates per time unit; 0 where there is no estimate.
        failed: the load could not act as it should; the rest of the result is then of no use.
    """

    state: State
    accelerations: tuple[float, ...]
    totals: tuple[float, ...]
    error: float
    failed: bool = False


class Stepper(Protocol):
    """A way to carry a scene over an interval."""

    @property
    def noise(self) -> float:
        """Rates of the scene below this are not told from none."""

    def propose(self, remaining: float) -> float:
        """Length of the next interval, at most ``remaining``."""

    def advance(self, scene: Scene, state: State, duration: float, load: Load | None = None) -> Advance:
        """Carry the scene over exactly ``duration``; says nothing about events."""

    def accepts(self, result: Advance, duration: float) -> bool:
        """Whether the interval is accurate enough; adapts the next proposal either way."""

    def begin_afresh(self) -> None:
        """Forget what earlier intervals have taught: the next ones are of another length."""

    def interpolation_error(self, start: State, end: State) -> float:
        """How far a link's tip may be, within the interval, off the cubic through the states at its ends."""


class PlainSteps:
    """One engine step after the other, of a fixed length: first order.

    In flight the engine corrects the joints, which keeps the energy of the motion. It does so by velocities, which a load
    such as a held contact would take for a force; under a load each step starts from closed joints instead.
    """

    def __init__(self, step: float) -> None:
        """``step`` in engine units."""
        self.step = step
        self._left: tuple[State, int] | None = None

    @property
    def noise(self) -> float:
        """The error of first order."""
        return self.step

    def propose(self, remaining: float) -> float:
        """One step."""
        return min(self.step, remaining)

    def advance(self, scene: Scene, state: State, duration: float, load: Load | None = None) -> Advance:
        """One engine step of the given length, in flight from where the bodies are if they were left there.

        A correction divides what is open by the step. A step cut short therefore starts from closed joints, and one
        that is next to nothing is not corrected.
        """
        if load is not None or not _as_left(self._left, scene, state) or duration < self.step:
            scene.place(state)
        scene.correct_joints(completely=load is None and duration > INSTANT)
        values = _steps(scene, duration, 1, load)
        scene.correct_joints(completely=False)
        size = len(scene.links)
        failed = load is not None and load.fails(values[3 * size :])
        result = _unpack(scene, state, duration, values, 0.0, failed)
        self._left = (result.state, scene.motions)
        return result

    def accepts(self, result: Advance, duration: float) -> bool:
        """A plain step knows nothing of its error."""
        del result, duration
        return True

    def begin_afresh(self) -> None:
        """Nothing was learnt."""

    def interpolation_error(self, start: State, end: State) -> float:
        """The engine goes straight on at the old rates, which a cubic between old and new rates does not."""
        return _straight(start, end)


class SymmetricSteps:
    """Engine steps started and read half a drift off, which makes undamped free motion of second order.

    The engine drifts, then kicks; shifting the positions back by half a drift before and on by half a drift after turns
    the sequence into a symmetric one (leapfrog). It needs joints that the engine corrects at every step.
    """

    COUNT = 8
    """Steps in an interval."""

    def __init__(self, step: float) -> None:
        """``step`` in engine units."""
        self.step = step
        self._left: tuple[State, int] | None = None
        self._shift = 0.0

    @property
    def noise(self) -> float:
        """The error of second order."""
        return self.step**2

    def propose(self, remaining: float) -> float:
        """Some steps, or what is left in as many steps as it takes."""
        return min(self.COUNT * self.step, remaining)

    def advance(self, scene: Scene, state: State, duration: float, load: Load | None = None) -> Advance:
        """Go on from where the bodies were left, or shift them back to begin; read the state shifted on."""
        count = max(1, math.ceil(duration / self.step - 1e-9))
        step = duration / count
        scene.correct_joints(completely=True)
        if _as_left(self._left, scene, state):
            scene.drift(self._shift - 0.5 * step)
        else:
            scene.place(state, -0.5 * step)
        values = _steps(scene, step, count, load)
        size = len(scene.links)
        values[:size] = [angle + 0.5 * step * rate for angle, rate in zip(values, values[size:], strict=False)][:size]
        scene.correct_joints(completely=False)
        failed = load is not None and load.fails(values[3 * size :])
        result = _unpack(scene, state, duration, values, 0.0, failed)
        self._left, self._shift = (result.state, scene.motions), 0.5 * step
        return result

    def accepts(self, result: Advance, duration: float) -> bool:
        """A fixed step knows nothing of its error."""
        del result, duration
        return True

    def begin_afresh(self) -> None:
        """Nothing was learnt."""

    def interpolation_error(self, start: State, end: State) -> float:
        """As for plain steps."""
        return _straight(start, end)


def _as_left(left: tuple[State, int] | None, scene: Scene, state: State) -> bool:
    """Whether a stepper left the bodies in this state and nobody has moved them since."""
    return left is not None and left[0] is state and left[1] == scene.motions


class Extrapolation:
    """Engine steps extrapolated to zero step, to a tolerance for each interval.

    Args:
        tolerance: of the error of an interval, relative to ``scale``.
        scale: size of the motion: angles in rad and rates per time unit.
        repetitions: in how many steps an interval is repeated.
        longest: no interval will be longer, whatever is proposed; more accuracy than that needs is then not paid for.
    """

    def __init__(
        self, tolerance: float, scale: float = 1.0, repetitions: Repetitions = CLOSE, longest: float = math.inf
    ) -> None:
        """Start with an interval of about a radian of the scene's motion."""
        self.repetitions = repetitions
        self.longest = longest
        self.limit = max(tolerance * scale, repetitions.noise[LEAST_ROWS - 1])
        # More repetitions amplify rounding beyond the tolerance.
        self.most_rows = sum(1 for noise in repetitions.noise if noise <= self.limit)
        self.rows = LEAST_ROWS
        self.length = 1.5
        self._errors: dict[int, float] = {}

    @property
    def noise(self) -> float:
        """The error that an interval may have."""
        return self.limit

    def propose(self, remaining: float) -> float:
        """The interval that costs least per time; what is left is cut evenly rather than into a stub."""
        return remaining / max(1, math.ceil(remaining / self.length - 0.1))

    def advance(self, scene: Scene, state: State, duration: float, load: Load | None = None) -> Advance:
        """Repeat the interval with finer steps until the estimate is within the tolerance."""
        runs: list[list[float]] = []
        self._errors = {}
        size, table = len(scene.links), self.repetitions
        error = math.inf
        for row, count in enumerate(table.counts[: self.most_rows]):
            runs.append(_run(scene, state, duration, count, load))
            if load is not None and load.fails(runs[-1][3 * size :]):
                return _unpack(scene, state, duration, runs[-1], math.inf, failed=True)
            if row + 2 >= self.rows and row:
                columns = list(zip(*runs, strict=True))[: 2 * size]
                differences = table.differences[row]
                errors = [abs(sum(map(mul, differences, column))) for column in columns]
                # The largest of numbers one of which is NaN depends on their order.
                error = self._errors[row] = max(errors) if sum(errors) < math.inf else math.inf
                if row + 1 >= self.rows and error <= self.limit:
                    break
        best = [sum(map(mul, table.weights[len(runs) - 1], column)) for column in zip(*runs, strict=True)]
        return _unpack(scene, state, duration, best, error)

    def accepts(self, result: Advance, duration: float) -> bool:
        """Whether the estimate is within the tolerance; chooses next interval and repetitions by cost per time."""
        costs = self.repetitions.costs
        lengths, prices = {}, {}
        for row, error in self._errors.items():
            ratio = 0.5 * self.limit / max(error, 1e-3 * self.limit)
            lengths[row] = min(self.longest, duration * min(4.0, max(0.1, 0.9 * ratio ** (1.0 / (row + 1)))))
            prices[row] = costs[row] / lengths[row]
        last = max(prices)
        best = min((row for row in prices if row > 1), key=prices.__getitem__, default=last)
        self.length, self.rows = lengths[best], best + 1
        if best == last < self.most_rows - 1 and prices[best] < 0.9 * prices.get(best - 1, math.inf):
            # Still getting cheaper: one more repetition, with the interval that would keep the price.
            self.length *= costs[best + 1] / costs[best]
            self.rows += 1
        if not result.error <= self.limit:
            self.length = min(self.length, 0.5 * duration)
            return False
        return True

    def begin_afresh(self) -> None:
        """Begin with few repetitions again, whose weights amplify rounding least."""
        self.rows = LEAST_ROWS

    def interpolation_error(self, start: State, end: State) -> float:
        """Nothing to speak of beside the cubic's own error."""
        del start, end
        return 0.0


def _straight(start: State, end: State) -> float:
    """Largest distance of a straight line from the cubic that has the rates of both ends, times two for safety."""
    changes = (abs(b - a) for a, b in zip(start.rates, end.rates, strict=True))
    return 0.3 * (end.time - start.time) * sum(changes)


def _run(scene: Scene, state: State, duration: float, count: int, load: Load | None) -> list[float]:
    """Angles, rates, accelerations and the load's totals after ``count`` engine steps from a state."""
    scene.place(state)
    return _steps(scene, duration / count, count, load)


def _steps(scene: Scene, step: float, count: int, load: Load | None) -> list[float]:
    """The same from where the bodies are."""
    act = None
    if load is not None:
        load.begin()
        act = load.apply
    if count > 1:
        scene.step(step, count - 1, act)
    before = scene.rates()
    scene.step(step, 1, act)
    rates = scene.rates()
    values = scene.angles() + rates + [(b - a) / step for a, b in zip(before, rates, strict=True)]
    return values if load is None else values + load.totals(step)


def _unpack(
    scene: Scene, state: State, duration: float, values: list[float], error: float, failed: bool = False
) -> Advance:
    size = len(scene.links)
    angles = tuple(angle + scene.turned for angle in values[:size])
    end = State(state.time + duration, angles, tuple(values[size : 2 * size]))
    return Advance(end, tuple(values[2 * size : 3 * size]), tuple(values[3 * size :]), error, failed)
