"""The smooth motion between two changes of contact: in flight, separating, in sustained contact, or several of these at once.

It integrates one interval up to its first event, and says what that changes about the contacts. What follows a change is in
:mod:`bristle_sim.scene.transitions`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

from bristle_sim.scene.contact.gaps import GAP_ROUNDING
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.sustained import Sustained, SustainedContacts
from bristle_sim.scene.events.contact_events import (
    extremes,
    inner_states,
    limits,
    sustained_contact_events,
    until_release,
)
from bristle_sim.scene.events.functions import Change, EventFunction, Release, Slip, Touch
from bristle_sim.scene.events.touch_search import SHORTEST_INTERVAL, Interval, first_touch_of_all
from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.progress import GROWTH, Progress
from bristle_sim.stop_reason import StopReason

LONGEST = 1.0
"""Longest interval in radians of the fastest motion: within it each event function changes its sign once at most, and the
cubic through the ends is good to 1/384 of the motion."""

Resolve = Callable[[], Change | None]
"""Resolves the event at an interval's end; returns what it changes about the contacts."""


class SmoothMotion:
    """One smooth motion of the links, up to the next change of contact.

    Attributes:
        progress: of the run.
        sustained: contacts that are kept closed until their forces have fallen to zero.
        separating: pairs that have left each other but whose gaps are not open yet.
        contacts: what keeps them closed; None where there is none.
        before: the last interval of this motion, if there is one.
        limit: longest interval that may follow; None before the first contact of a run, when nothing limits it.
    """

    def __init__(
        self,
        progress: Progress,
        limit: float | None,
        sustained: Sequence[Sustained] = (),
        separating: Sequence[Obstacle] = (),
    ) -> None:
        """Begin a motion: accelerations and signs of the last one are forgotten."""
        self.progress = progress
        self.sustained, self.separating = tuple(sustained), tuple(separating)
        self.before: Advance | None = None
        self.limit = limit
        self.contacts: SustainedContacts | None = None
        for each in self.sustained:
            each.look_up_slip(progress.gaps, progress.state, progress.slip_error)
        self._extremes, self._contact_events = extremes(progress, self.sustained), list[EventFunction]()
        progress.changes.begin(progress.state, [*self._extremes, *limits(self.progress)])
        if self.sustained:
            self._contact_events = self._begin_contact()

    def proceed(self) -> Change | None:
        """Integrate to the next event, and return what that changes about the contacts, if anything."""
        progress, plan = self.progress, self.progress.plan
        left = plan.end - progress.state.time
        limit = math.inf if self.limit is None else self.limit
        length = min(progress.stepper.propose(left), plan.longest_interval, limit, LONGEST * plan.time_scale)
        result = self.advance(length)
        if self.contacts is not None:
            forces = self.contacts.forces.normal(result.totals)
            first = self.before is None
            gone = result.failed or (first and min(forces) <= 0.0)
            slip = self.contacts.breaks_away(result.totals) if first and not gone else None
            if gone or slip is not None:
                if first and length > progress.instant:
                    # Whether it is so from the beginning shows in an instant.
                    self.limit = progress.instant
                    return None
                return slip or self._approach_release(forces, length)
        if not progress.stepper.accepts(result, length):
            if not math.isfinite(result.error) or length < SHORTEST_INTERVAL:
                progress.stop(StopReason.ACCURACY)
            return None
        result, resolve = self.first_event(result)
        self.commit(result)
        return None if resolve is None else resolve()

    def advance(self, length: float) -> Advance:
        """Integrate over an interval from the state that was reached."""
        load = None if self.contacts is None else self.contacts.forces
        return self.progress.stepper.advance(self.progress.scene, self.progress.state, length, load)

    def _approach_release(self, forces: Sequence[float], length: float) -> Change | None:
        """Come closer to where a force vanishes, or release what it was on; stick that would pull is no stick."""
        for each in self.sustained:
            if self.before is None and each.stopped:
                return Slip(each.obstacle, -each.stopped)
        alone = len(self.progress.mechanism.links) == 1
        if (self.before is None and alone) or length <= self.progress.shortest:
            lost = zip(self.sustained, forces, strict=True)
            return Release(tuple(each.obstacle for each, force in lost if force <= 0.0))
        self.limit = max(
            min(0.5 * length if self.before else length / GROWTH, until_release(self.sustained)),
            0.5 * self.progress.shortest,
        )
        return None

    def commit(self, result: Advance) -> None:
        """Take over an interval's end; links in sustained contact are set back onto what they touch."""
        progress, start = self.progress, self.progress.state
        length = result.state.time - start.time
        force: float | tuple[float, ...] = 0.0
        progress.state = result.state
        if self.contacts is not None:
            self.contacts.forces.share_out(result.totals, self.sustained, length)
            progress.state = self.contacts.set_back(progress.gaps, result.state)
            progress.recording.inner += inner_states(progress, self.contacts, start)
        self.before = result
        if self.contacts is not None:
            _engage(progress, self.contacts)
            # A release is located to rounding, on either side.
            forces = [max(0.0, each) for each in self.contacts.forces.normal(result.totals)]
            force = progress.force_of_wires(forces, self.contacts.obstacles)
        progress.recording.error += result.error
        progress.sample(force)
        if self.limit is not None:
            grown = max(GROWTH * length, progress.first_interval)
            self.limit = min(grown, max(until_release(self.sustained), self.progress.shortest))
        if self.separating:
            gaps, state = progress.gaps, progress.state
            self.separating = tuple(each for each in self.separating if gaps.gap(each, state) <= GAP_ROUNDING)

    def _begin_contact(self) -> list[EventFunction]:
        """Let the engine's contacts act from here on, if they can; return the events that end them."""
        progress = self.progress
        obstacles, slips = [each.obstacle for each in self.sustained], [each.slip for each in self.sustained]
        self.contacts = SustainedContacts(progress.scene, obstacles, slips)
        progress.state = self.contacts.set_back(progress.gaps, progress.state)
        for each in self.sustained:
            each.begin(progress.state)
        _engage(progress, self.contacts)
        return sustained_contact_events(progress, self.contacts)

    def first_event(self, result: Advance) -> tuple[Advance, Resolve | None]:
        """Return the interval up to its first event, and how that is resolved."""
        progress, changes, whole = self.progress, self.progress.changes, result
        functions = [*self._extremes, *limits(progress)]
        if self.before is None and self.limit is None and self.contacts is None:
            changes.look_back(self.interval_to(result), functions)
        known = dict(changes.signs)
        # What changes a contact comes first: a link that slides onto its neighbour does not touch before that.
        result, happens = changes.find_first(self._contact_events, self.interval_to(result), self.before)
        active, touch = [each.obstacle for each in self.sustained], None
        cut, found = first_touch_of_all(progress, self.interval_to(result), active, self.separating)
        if cut is not result:
            result, happens, touch = cut, None, found
        cut, later = changes.find_first(functions, self.interval_to(result), self.before)
        if later is not None:
            result, happens = cut, later
        if result is not whole:
            # What changes its sign later has not done so yet.
            changes.return_to(known, [*self._contact_events, *functions], result, happens)
        if happens is not None:
            return result, partial(self.note, happens)
        return result, None if touch is None else partial(Touch, *touch)

    def interval_to(self, end: Advance) -> Interval:
        """Return the interval from the state that was reached to its end."""
        return Interval(self.progress.state, end, self.advance)

    def note(self, function: EventFunction) -> Change | None:
        """Record what an event function found, and return what it changes about the contacts."""
        progress = self.progress
        if function.event is not None:
            progress.event(function.event, progress.state.time, (function.wire,))
        if function.final is not None:
            progress.stop(function.final)
        return None if function.act is None else function.act()


def _engage(progress: Progress, contacts: SustainedContacts) -> None:
    """Let sustained contacts act from the state that was reached; stop where no force keeps them closed."""
    grip = contacts.engage(progress.gaps, progress.state)
    if grip <= 0.0 and not any(each.friction for each in contacts.obstacles):
        progress.stop(StopReason.NO_GRIP)
    elif grip <= 0.0:
        wires = {wire for each in contacts.obstacles for wire in progress.wires_of(each)}
        progress.event("jam", progress.state.time, sorted(wires))
        progress.stop(StopReason.JAM)
    elif not contacts.solvable:
        progress.stop(StopReason.FRICTION)
