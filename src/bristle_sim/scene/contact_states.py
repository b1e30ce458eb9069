"""The states of contact that a link passes through besides sustained contact: in flight, separating from an obstacle.

Each state integrates one interval up to its first event, and says what that changes about the contact. It knows its event
functions, and which obstacles it searches for touches. What follows a change is in :mod:`bristle_sim.scene.transitions`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from bristle_sim.scene.event_functions import EventFunction, freedom, in_flight
from bristle_sim.scene.gaps import GAP_ROUNDING
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.progress import Progress
from bristle_sim.scene.stepping import Advance
from bristle_sim.scene.touch_search import SHORTEST, Interval, find_touch
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactAtEnd

__all__ = ["Change", "ContactState", "InFlight", "Opening", "Release", "Separating", "Touch"]

LONGEST = 1.0
"""Longest interval in the scene's time units: within a radian of the fastest motion each event function changes its sign
once at most, and the cubic through the ends is good to 1/384 of the motion."""

LEAST_HOP = 1e-6
"""Fraction of an interval within which a rebound that is shorter is taken for none."""


class Touch(NamedTuple):
    """The link meets an obstacle; ``rests`` takes what is left of the approach."""

    obstacle: Obstacle
    rests: bool = False


class Release(NamedTuple):
    """The link leaves an obstacle, whose gap is still closed."""

    obstacle: Obstacle


class Opening(NamedTuple):
    """The gap of the obstacle that the link leaves is open; the motion continues after the interval ``before``."""

    before: Advance
    limit: float


Change = Touch | Release | Opening
"""What an event changes about the contact."""

Resolve = Callable[[], Change | None]
"""Resolves the event at an interval's end; returns what it changes about the contact."""


class ContactState:
    """One smooth motion of the link, up to its next change of contact.

    Attributes:
        progress: of the run.
        before: the last interval of this motion, if there is one.
        limit: longest interval that may follow; None before the first contact of a run, when nothing limits it.
    """

    def __init__(self, progress: Progress, limit: float | None) -> None:
        """Begin a motion: accelerations and signs of the last one are forgotten."""
        self.progress = progress
        self.before: Advance | None = None
        self.limit = limit
        progress.changes.begin(progress.state, self._shared_functions())

    def proceed(self) -> Change | None:
        """Integrate to the next event, and return what that changes about the contact, if anything."""
        progress, plan = self.progress, self.progress.plan
        left = plan.end - progress.state.time
        limit = math.inf if self.limit is None else self.limit
        length = min(progress.stepper.propose(left), plan.longest_interval, limit, LONGEST)
        result = self.advance(length)
        if self.ends_within(result):
            return self.approach_end(length)
        if not progress.stepper.accepts(result, length):
            if not math.isfinite(result.error) or length < SHORTEST:
                progress.stop(StopReason.ACCURACY)
            return None
        result, resolve = self.first_event(result)
        opening = self.commit(result)
        return (None if resolve is None else resolve()) or opening

    def advance(self, length: float) -> Advance:
        """Integrate over an interval from the state that was reached."""
        return self.progress.stepper.advance(self.progress.scene, self.progress.state, length)

    def ends_within(self, result: Advance) -> bool:
        """Whether this motion ends within an interval by itself."""
        del result
        return False

    def approach_end(self, length: float) -> Change | None:
        """Return what changes where the motion ends by itself within an interval of that length."""
        raise NotImplementedError

    def commit(self, result: Advance) -> Opening | None:
        """Take over an interval's end; returns an opening of the gap that the interval has brought."""
        progress = self.progress
        length = result.state.time - progress.state.time
        progress.state, self.before = result.state, result
        progress.recording.error += result.error
        progress.sample(0.0)
        if self.limit is not None:
            self.limit = max(2.0 * length, progress.first_interval)
        return None

    def first_event(self, result: Advance) -> tuple[Advance, Resolve | None]:
        """Return the interval up to its first event, and how that is resolved."""
        resolve: Resolve | None = None
        for obstacle in self.progress.scene.effects.obstacles:
            result, resolve = self.search_touch(obstacle, result, resolve)
        for function in self.event_functions():
            changed = self.progress.changes.find(function, self.interval_to(result), self.before)
            if changed is not None:
                result, resolve = changed, partial(self.note, function)
        return result, resolve

    def search_touch(
        self, obstacle: Obstacle, result: Advance, resolve: Resolve | None
    ) -> tuple[Advance, Resolve | None]:
        """Return the interval cut short where it comes nearest to an obstacle, and the impact if it touches."""
        progress = self.progress
        error = progress.stepper.interpolation_error(progress.state, result.state)
        found = find_touch(self.interval_to(result), progress.gaps, obstacle, error)
        if found is None:
            return result, resolve
        reached, closed = found
        return reached, partial(self.meet, obstacle) if closed else None

    def interval_to(self, end: Advance) -> Interval:
        """Return the interval from the state that was reached to its end."""
        return Interval(self.progress.state, end, self.advance)

    def event_functions(self) -> list[EventFunction]:
        """Return functions whose change of sign is an event of this motion, besides touches."""
        return self._shared_functions()

    def _shared_functions(self) -> list[EventFunction]:
        """Return the event functions whose signs are known when the motion begins."""
        return [*in_flight(self.progress.scene), *self.limits()]

    def limits(self) -> list[EventFunction]:
        """Return the angle at which the bristle lies on the hub, if there is one."""
        limit = self.progress.plan.retraction_limit
        return [freedom(self.progress.mechanism, limit, self.progress.state)] if math.isfinite(limit) else []

    def meet(self, obstacle: Obstacle, rests: bool = False) -> Touch:
        """Return the touch of an obstacle at the state that was reached."""
        return Touch(obstacle, rests)

    def note(self, function: EventFunction) -> Change | None:
        """Record what an event function found."""
        progress = self.progress
        if function.event is not None:
            progress.event(function.event, progress.state.time)
        if function.final is not None:
            progress.stop(function.final)
        return None

    def summary(self) -> ContactAtEnd:
        """Return what a run that ends here is resumed from."""
        return ContactAtEnd()

    def end(self, outcome: str) -> None:
        """Leave the state at the run's end."""


class InFlight(ContactState):
    """Nothing touches the link."""

    @classmethod
    def after(cls, progress: Progress, opening: Opening) -> InFlight:
        """Resume in flight the motion that an opened gap does not interrupt."""
        flight = cls.__new__(cls)
        flight.progress, flight.before, flight.limit = progress, opening.before, opening.limit
        return flight

    def first_event(self, result: Advance) -> tuple[Advance, Resolve | None]:
        """Return the interval up to its first event; signs at the very start of a run are looked at exactly."""
        at_start = self.before is None and self.limit is None
        if at_start and self.progress.changes.look_back(self.interval_to(result), self.event_functions()):
            # The bodies are no longer where the interval has left them.
            result = self.advance(self.interval_to(result).length)
        return super().first_event(result)


class Separating(ContactState):
    """The link has left an obstacle whose gap is not open yet."""

    def __init__(self, progress: Progress, obstacle: Obstacle) -> None:
        """Begin at the instant at which the link leaves."""
        super().__init__(progress, progress.first_interval)
        self.obstacle = obstacle

    def summary(self) -> ContactAtEnd:
        """Name the obstacle that the link leaves."""
        return ContactAtEnd("separating", self.obstacle.name)

    def search_touch(
        self, obstacle: Obstacle, result: Advance, resolve: Resolve | None
    ) -> tuple[Advance, Resolve | None]:
        """Search a touch; the obstacle that the link leaves is touched again only by coming back within the interval."""
        if obstacle is not self.obstacle:
            return super().search_touch(obstacle, result, resolve)
        gap, rate = self.progress.gaps.gap_and_rate(obstacle, result.state)
        if gap >= -GAP_ROUNDING or rate >= 0.0:
            return result, resolve
        # A contact resolved in time leaves the link in a crater, from which there is no rise.
        if (
            gap < -self.progress.plan.accuracy
            and self.progress.gaps.gap(obstacle, self.progress.state) >= -GAP_ROUNDING
        ):
            result = self._rise(result)
            if self.progress.gaps.gap(obstacle, result.state) > GAP_ROUNDING:
                return result, None
        # It is back within the shortest interval: too low a rebound to follow.
        return result, partial(self.meet, obstacle, True)

    def _rise(self, result: Advance) -> Advance:
        """Return the part of an interval that ends deep inside the obstacle in which the rebound is still above it."""
        interval = self.interval_to(result)
        span = interval.length
        while (
            span > LEAST_HOP * interval.length and self.progress.gaps.gap(self.obstacle, result.state) < -GAP_ROUNDING
        ):
            span *= 0.5
            result = interval.again(span)
        return result

    def commit(self, result: Advance) -> Opening | None:
        """Notice once the gap is open."""
        super().commit(result)
        opens = self.progress.gaps.gap(self.obstacle, self.progress.state) > GAP_ROUNDING
        return Opening(result, self.limit or 0.0) if opens else None
