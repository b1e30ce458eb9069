"""Steppers integrate a scene over a smooth interval of motion; those of a fixed engine step are here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple, Protocol

from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import State

INSTANT = 1e-6
"""Steps shorter than this, in a scene's time units, open joints by less than rounding matters."""


NONE: Mapping[int, float] = MappingProxyType({})
"""No repetitions, no estimates."""


class Load(Protocol):
    """What acts on the links besides springs and joints, and what it adds up over an interval.

    Attributes:
        symmetric: whether it acts alike forwards and backwards in time, so that steps may be symmetric.
    """

    symmetric: bool

    def begin(self, step: float) -> Callable[[], None]:
        """Begin a run over an interval in steps of one length; return what acts on the bodies before each of them."""

    def totals(self) -> list[float]:
        """Return what was added up since, as numbers that are smooth in the step."""

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
        errors: estimated error after each repetition by its number, where a stepper repeats the interval.
    """

    state: State
    accelerations: tuple[float, ...]
    totals: tuple[float, ...]
    error: float
    failed: bool = False
    errors: Mapping[int, float] = NONE


class Stepper(Protocol):
    """A way to carry a scene over an interval."""

    @property
    def noise(self) -> float:
        """Rates of the scene below this cannot be distinguished from 0."""

    def propose(self, remaining: float) -> float:
        """Return the length of the next interval, at most ``remaining``."""

    def advance(self, scene: Scene, state: State, duration: float, load: Load | None = None) -> Advance:
        """Carry the scene over exactly ``duration``; says nothing about events."""

    def accepts(self, result: Advance, duration: float) -> bool:
        """Whether the interval is accurate enough; adapts the next proposal either way."""

    def begin_afresh(self) -> None:
        """Forget what earlier intervals have taught: the next ones are of another length."""

    def interpolation_error(self, start: State, end: State) -> float:
        """Return how far a link's tip may be, within the interval, off the cubic through the states at its ends."""


class PlainSteps:
    """One engine step after the other, of a fixed length, which knows nothing of its error: first order.

    In flight the engine corrects the joints, which keeps the energy of the motion. It does so by velocities, which a load
    such as a sustained contact would take for a force; under a load each step starts from closed joints instead.
    """

    def __init__(self, step: float) -> None:
        """``step`` in engine units."""
        self.step = step
        self._left: tuple[State, int] | None = None

    def accepts(self, result: Advance, duration: float) -> bool:
        """Return that every interval is accepted."""
        del result, duration
        return True

    def begin_afresh(self) -> None:
        """Nothing was learnt."""

    def interpolation_error(self, start: State, end: State) -> float:
        """Return twice the largest distance of a straight line from the cubic that has the rates of both ends.

        The engine goes straight on at the old rates, which a cubic between old and new rates does not.
        """
        changes = (abs(b - a) for a, b in zip(start.rates, end.rates, strict=True))
        return 0.3 * (end.time - start.time) * sum(changes)

    def _left_at(self, scene: Scene, state: State) -> bool:
        """Whether the bodies were left in this state and nobody has moved them since."""
        return self._left is not None and self._left[0] is state and self._left[1] == scene.motions

    @property
    def noise(self) -> float:
        """The error of first order."""
        return self.step

    def propose(self, remaining: float) -> float:
        """Return one step, or what is left."""
        return min(self.step, remaining)

    def advance(self, scene: Scene, state: State, duration: float, load: Load | None = None) -> Advance:
        """Take one engine step of the given length, in flight from where the bodies are if they were left there.

        A correction divides what is open by the step. A step cut short therefore starts from closed joints, and one
        that is next to nothing is not corrected.
        """
        if load is not None or not self._left_at(scene, state) or duration < self.step:
            scene.place(state)
        scene.correct_joints(completely=load is None and duration > INSTANT)
        values = (
            scene.step(duration, 1) if load is None else scene.step(duration, 1, load.begin(duration)) + load.totals()
        )
        scene.correct_joints(completely=False)
        size = len(scene.links)
        failed = load is not None and load.fails(values[3 * size :])
        result = unpack(scene, state, duration, values, 0.0, failed)
        self._left = (result.state, scene.motions)
        return result


def unpack(
    scene: Scene,
    state: State,
    duration: float,
    values: list[float],
    error: float,
    failed: bool = False,
    errors: Mapping[int, float] = NONE,
) -> Advance:
    """Return the angles, rates, accelerations and totals as the result of an interval."""
    size, turned = len(scene.links), scene.turned
    angles = tuple([angle + turned for angle in values[:size]])
    end = State(state.time + duration, angles, tuple(values[size : 2 * size]))
    return Advance(end, tuple(values[2 * size : 3 * size]), tuple(values[3 * size :]), error, failed, errors)
