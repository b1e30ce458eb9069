"""The state in which the engine's contact keeps a link on an obstacle, until its force has fallen to zero."""

from __future__ import annotations

from bristle_sim.scene.contact_states import Change, ContactState, Opening, Release, Resolve, Touch
from bristle_sim.scene.engine_contact import (
    ELBOW,
    MOST_GRIP,
    EngineContact,
    elbow,
    locking,
    set_back,
    sustained_contact_record,
)
from bristle_sim.scene.event_functions import EventFunction, in_touch
from bristle_sim.scene.events import interpolate
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.progress import Progress
from bristle_sim.scene.stepping import Advance
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactAtEnd

__all__ = ["InSustainedContact"]

SHORTEST_SAMPLED = 2e-3
"""Intervals shorter than this, in the scene's time units, are left to the cubic: its error falls with their third power."""

SHY = 0.95
"""Fraction of the time until a force vanishes, by its slope, that the next interval takes: a force that bends is met later."""

CUBIC = 0.1
"""Error of the cubic's rate, as a fraction of the requested one, above which the middle alone is not enough."""


class InSustainedContact(ContactState):
    """The engine's contact keeps the link on an obstacle, until its force has fallen to zero.

    Attributes:
        obstacle: that the link is on.
        contact: the engine's contact as a load.
        start, sums: state at which it began; impulses and friction's work since.
        slope: rate of the normal force over the last interval.
        ending: whether the force is known to vanish within the next interval of full length.
    """

    def __init__(self, progress: Progress, obstacle: Obstacle) -> None:
        """Let the engine's contact act from here on, if it can."""
        self.obstacle = obstacle
        super().__init__(progress, progress.first_interval)
        progress.state = set_back(progress.mechanism, obstacle, progress.state)
        self.contact = EngineContact(progress.scene, obstacle)
        self.start = progress.state
        self.sums: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.slope, self.ending = 0.0, False
        self._engage()

    def summary(self) -> ContactAtEnd:
        """Name the obstacle that the link is on."""
        return ContactAtEnd("sustained contact", self.obstacle.name)

    def advance(self, length: float) -> Advance:
        """Integrate under the contact's force."""
        return self.progress.stepper.advance(self.progress.scene, self.progress.state, length, self.contact)

    def ends_within(self, result: Advance) -> bool:
        """Whether the force vanishes within the interval."""
        return result.failed or result.totals[0] <= 0.0

    def approach_end(self, length: float) -> Change | None:
        """Come closer to where the force vanishes, or release the link."""
        if self.before is None or length <= self._shortest:
            self.release()
            return Release(self.obstacle)
        self.ending = True
        predicted = -self.before.totals[0] / self.slope if self.slope < 0.0 else 0.0
        self.limit = max(min(0.5 * length, max(SHY * predicted, length / 16.0)), 0.5 * self._shortest)
        return None

    @property
    def _shortest(self) -> float:
        """Length of an interval within which a force that vanishes has vanished at once."""
        return max(1e-9, 0.1 * self.progress.plan.accuracy)

    def commit(self, result: Advance) -> Opening | None:
        """Set the link back onto the obstacle, add up what the contact did, and let it act from there."""
        progress = self.progress
        length = result.state.time - progress.state.time
        self.sums = tuple(a + b for a, b in zip(self.sums, result.totals[1:], strict=True))
        if self.before is not None and length > 0.0:
            self.slope = (result.totals[0] - self.before.totals[0]) / length
        start, piece = progress.state, self.contact.piece
        progress.state = set_back(progress.mechanism, self.obstacle, result.state, piece)
        self._sample_between(start, progress.state, piece)
        self.before = result
        self._engage()
        progress.recording.error += result.error
        progress.sample(result.totals[0])
        if self.ending and 0.0 < -self.slope * 4.0 * length > result.totals[0]:
            # Close to the release; once less than the shortest interval is left, that one passes it.
            self.limit = max(SHY * result.totals[0] / -self.slope, self._shortest)
        else:
            self.limit = max(2.0 * length, 0.0 if self.ending else progress.first_interval)
        return None

    def _sample_between(self, start: State, end: State, piece: int | None) -> None:
        """Record states within an interval: those of a single link in touch follow from the geometry alone."""
        length, progress = end.time - start.time, self.progress
        if length < SHORTEST_SAMPLED or len(start.angles) > 1:
            return

        def state_at(fraction: float) -> State:
            return set_back(progress.mechanism, self.obstacle, interpolate(start, end, fraction), piece)

        guess, middle = interpolate(start, end, 0.5).angles[-1], state_at(0.5)
        # An error e of the angle that grows from one end and falls to the other is one of 8 e/length in the rate.
        near = 8.0 * abs(middle.angles[-1] - guess) <= CUBIC * progress.plan.accuracy * length * abs(middle.rates[-1])
        progress.recording.inner += [middle] if near else [state_at(0.25), middle, state_at(0.75)]

    def _engage(self) -> None:
        """Have the engine's contact act from the state that was reached; stop where no force keeps the link on it."""
        progress, grip = self.progress, self.contact.engage(self.progress.state)
        if grip <= 0.0:
            progress.event("jam", progress.state.time)
            progress.stop(StopReason.JAM)
        elif grip > MOST_GRIP:
            progress.stop(StopReason.FRICTION)

    def search_touch(
        self, obstacle: Obstacle, result: Advance, resolve: Resolve | None
    ) -> tuple[Advance, Resolve | None]:
        """Search the other obstacles, which may be touched all along."""
        progress = self.progress
        if obstacle is self.obstacle or progress.gaps.rests(obstacle, progress.state, result.state):
            return result, resolve
        return super().search_touch(obstacle, result, resolve)

    def _shared_functions(self) -> list[EventFunction]:
        """Return extremes and kinks of the sustained motion."""
        progress = self.progress
        return [*in_touch(progress.mechanism, self.obstacle, progress.state), *self.limits()]

    def event_functions(self) -> list[EventFunction]:
        """Return extremes and kinks, and what ends the contact besides its force."""
        progress = self.progress
        found = in_touch(progress.mechanism, self.obstacle, progress.state)
        return [*found, locking(self.contact), elbow(self.contact), *self.limits()]

    def meet(self, obstacle: Obstacle, rests: bool = False) -> Touch:
        """Leave the obstacle before another is met."""
        self.release()
        return super().meet(obstacle, rests)

    def note(self, function: EventFunction) -> Change | None:
        """Let another piece of a bent wire take over by an impact."""
        super().note(function)
        if function.name != ELBOW:
            return None
        self.end(self.obstacle.name)
        return Touch(self.obstacle)

    def release(self) -> None:
        """Leave the obstacle, whose force has fallen to zero."""
        self.end("release")
        self.progress.event(f"{self.obstacle.name} release", self.progress.state.time)

    def end(self, outcome: str) -> None:
        """End the engine's contact and record it."""
        progress = self.progress
        progress.scene.release(self.obstacle)
        if progress.state.time > self.start.time:
            record = sustained_contact_record(
                progress.mechanism, self.obstacle, self.start, progress.state, self.sums, outcome
            )
            progress.recording.contacts.append(record)
