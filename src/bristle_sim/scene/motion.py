"""The smooth motion between two changes of contact: in flight, separating, in sustained contact, or several of these at once.

It integrates one interval up to its first event, and returns the change of the contacts that follows. What that leads to is
decided in :mod:`bristle_sim.scene.decisions`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

from bristle_sim.scene.contact.gaps import GAP_ROUNDING
from bristle_sim.scene.contact.laws import contact_at
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.rigid import TOTALS, RigidContacts, rigid_contacts, sense_of_slip
from bristle_sim.scene.contact.spring import ContactLoad, Spring
from bristle_sim.scene.contact.sustained import Sustained
from bristle_sim.scene.events.functions import Change, EventFunction, Release, Slip, SpringChange, SpringEvent, Touch
from bristle_sim.scene.events.locate import Interval, interpolate
from bristle_sim.scene.events.table import contact_events, motion_events
from bristle_sim.scene.events.touches import SHORTEST_INTERVAL, first_touch_of_all
from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.progress import GROWTH, Progress
from bristle_sim.stop_reason import StopReason

LONGEST_TURN = 1.0
"""Longest interval in radians of the fastest motion: within it each event function changes its sign once at most, and the
cubic through the ends is good to 1/384 of the motion."""

BEYOND_RELEASE = 1.02
"""Multiple of the time until a force is expected to vanish that the next interval takes: the release is within it then."""

SHORTEST_CONTACT_INTERVAL = 1e-9
"""Intervals shorter than this fraction of a contact with a spring mean that none is short enough: rounding exceeds the tolerance."""

PATIENCE = 10.0
"""Durations after which a contact in the rigid-body limit, or a single one, is no impact: something presses the point on."""

SHORTEST_SAMPLED = 2e-3
"""Intervals shorter than this, in the scene's time units, are left to the cubic: its error falls with their third power."""

CUBIC_RATE_ERROR = 0.1
"""Error of the cubic's rate, as a fraction of the requested one, above which the middle alone is not enough."""

Resolve = Callable[[], Change | None]
"""Resolves the event at an interval's end; returns the change of the contacts."""


class SmoothMotion:
    """One smooth motion of the links, up to the next change of contact.

    Attributes:
        progress: of the run.
        sustained: contacts that last.
        separating: pairs that have left each other but whose gaps are not open yet.
        rigid: what keeps the rigid ones of them closed; None where there is none.
        load: the forces of all of them; None where there is none.
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
        self.rigid: RigidContacts | None = None
        self.load: ContactLoad | None = None
        self._contact_events: list[EventFunction] = []
        if self.sustained:
            self._begin_contact()
        springs = [each.spring for each in self.sustained if each.spring is not None]
        progress.stepper = (
            min((each.expected for each in springs), key=lambda each: each.longest).stepper
            if springs
            else progress.flight
        )
        progress.signs.stepper = progress.stepper
        self._events = motion_events(progress, self.sustained)
        progress.signs.begin(progress.state, [*self._contact_events, *self._events])

    def proceed(self) -> Change | None:
        """Integrate to the next event, and return what that changes about the contacts, if anything."""
        progress = self.progress
        for each in self.sustained:
            if each.spring is not None:
                follow_bodies(progress, each.obstacle, each.spring)
        length = self._proposed()
        result = self.advance(length)
        if self.rigid is not None:
            first = self.before is None
            gone = result.failed or (first and min(self.rigid.normal(result.totals)) <= 0.0)
            slipping = self.rigid.breaks_away(result.totals) if first and not gone else None
            if gone or slipping is not None:
                if first and length > progress.instant:
                    # Whether it is so from the beginning shows in an instant.
                    self.limit = progress.instant
                    return None
                return self._slip(slipping, result) or self._approach_release(self.rigid.normal(result.totals), length)
        if not progress.stepper.accepts(result, length):
            if not math.isfinite(result.error) or length < self._shortest():
                progress.stop(StopReason.ACCURACY)
            return None
        result, resolve = self.first_event(result)
        self.commit(result)
        return self._overdue() if resolve is None else resolve()

    def _proposed(self) -> float:
        """Return the length of the next interval."""
        progress, plan = self.progress, self.progress.plan
        left = plan.end - progress.state.time
        limit = math.inf if self.limit is None else self.limit
        longest = min(plan.longest_interval, LONGEST_TURN * plan.time_scale)
        if progress.stepper is progress.flight:
            return min(progress.stepper.propose(left), longest, limit)
        longest = min(longest, *(self._longest(each) for each in self.sustained))
        return progress.stepper.propose(min(left, longest, math.inf if self.rigid is None else limit))

    def _longest(self, contact: Sustained) -> float:
        return math.inf if contact.spring is None else contact.spring.expected.longest

    def _shortest(self) -> float:
        """Return the length of an interval below which none is short enough."""
        springs = [each.spring.expected.duration for each in self.sustained if each.spring is not None]
        return min((SHORTEST_CONTACT_INTERVAL * each for each in springs), default=SHORTEST_INTERVAL)

    def advance(self, length: float) -> Advance:
        """Integrate over an interval from the state that was reached."""
        progress = self.progress
        return progress.stepper.advance(progress.scene, progress.state, length, self.load)

    def _slip(self, index: int | None, result: Advance) -> Slip | None:
        """Return the slip of a contact that cannot stick, by its number."""
        if index is None:
            return None
        contact = [each for each in self.sustained if each.spring is None][index]
        return Slip(contact, -1 if result.totals[TOTALS * index + 1] > 0.0 else 1)

    def _approach_release(self, forces: Sequence[float], length: float) -> Change | None:
        """Come closer to where a force vanishes, or release what it was on; stick that would pull is no stick."""
        rigid = [each for each in self.sustained if each.spring is None]
        for each in rigid:
            if self.before is None and each.stopped:
                return Slip(each, -each.stopped)
        if (self.before is None and self.progress.mechanism.lone) or length <= self.progress.shortest:
            lost = zip(rigid, forces, strict=True)
            return Release(tuple(each.obstacle for each, force in lost if force <= 0.0))
        self.limit = max(
            min(0.5 * length if self.before else length / GROWTH, self._until_release()),
            0.5 * self.progress.shortest,
        )
        return None

    def _until_release(self) -> float:
        """Return the length of an interval in which the first force vanishes, by the last interval."""
        return BEYOND_RELEASE * min((each.vanishes_in for each in self.sustained), default=math.inf)

    def commit(self, result: Advance) -> None:
        """Take over an interval's end; links in sustained contact are set back onto what they touch."""
        progress, start = self.progress, self.progress.state
        length = result.state.time - start.time
        progress.state = result.state if self.rigid is None else self.rigid.set_back(progress.gaps, result.state)
        if self.sustained:
            self._add(result, start, length)
        else:
            progress.sample()
        self.before = result
        progress.recording.error += result.error
        if self.limit is not None:
            grown = max(GROWTH * length, progress.first_interval)
            self.limit = min(grown, max(self._until_release(), progress.shortest))
        if self.separating:
            gaps, state = progress.gaps, progress.state
            self.separating = tuple(each for each in self.separating if gaps.gap(each, state) <= GAP_ROUNDING)

    def _add(self, result: Advance, start: State, length: float) -> None:
        """Add what the contacts did in an interval, and record their forces at its end."""
        progress, totals = self.progress, result.totals
        ordered = [each for each in self.sustained if each.spring is None]
        ends, begins = {}, {}
        for index, each in enumerate(ordered):
            normal, _, *sums = totals[TOTALS * index : TOTALS * (index + 1)]
            first = each.add(normal, (sums[0], sums[1], 0.0, sums[2]), length)
            # A release is located to rounding, on either side.
            ends[each], begins[each] = max(0.0, normal), max(0.0, first)
        for number, each in enumerate(each for each in self.sustained if each.spring is not None):
            each.add_spring(totals[TOTALS * len(ordered) + 6 * number :][:6])
            ends[each] = each.sample(progress.gaps, progress.state)
        if self.rigid is not None:
            if self.before is None and len(begins) == len(self.sustained):
                progress.sample(list(begins.values()), list(begins), again=True)
            progress.recording.inner += self._inner_states(start)
            self._engage()
        progress.sample(list(ends.values()), list(ends))

    def _begin_contact(self) -> None:
        """Let the contacts act from here on, if they can; find the events that end them."""
        progress = self.progress
        rigid = [each for each in self.sustained if each.spring is None]
        for each in rigid:
            if each.slip is None and each.obstacle.friction:
                each.slip = sense_of_slip(progress.gaps, each.obstacle, progress.state, progress.slip_error)
        obstacles, slips = [each.obstacle for each in rigid], [each.slip for each in rigid]
        if rigid:
            paired = len(rigid) == len(self.sustained)
            self.rigid = rigid_contacts(progress.scene, obstacles, slips, paired=paired)
            progress.state = self.rigid.set_back(progress.gaps, progress.state)
        for each in self.sustained:
            each.begin(progress.state)
        if self.rigid is not None:
            self._engage()
        self.load = ContactLoad(
            progress.scene, self.rigid, [each for each in self.sustained if each.spring is not None]
        )
        forces = [0.0 if each.spring is None else each.sample(progress.gaps, progress.state) for each in self.sustained]
        progress.sample(forces, self.sustained)
        self._contact_events = contact_events(progress, self.sustained, self.rigid)

    def _engage(self) -> None:
        """Let rigid contacts act from the state that was reached; stop where no force keeps them closed."""
        progress, rigid = self.progress, self.rigid
        assert rigid is not None
        grip = rigid.engage(progress.gaps, progress.state)
        if grip <= 0.0 and not any(each.friction for each in rigid.obstacles):
            progress.stop(StopReason.NO_GRIP)
        elif grip <= 0.0:
            wires = {wire for each in rigid.obstacles for wire in progress.wires_of(each)}
            progress.event("jam", progress.state.time, sorted(wires))
            progress.stop(StopReason.JAM)

    def _overdue(self) -> Change | None:
        """Return the end of a contact that lasts ``PATIENCE`` times as long as expected.

        That is one in the rigid-body limit, or a single one of rigid links, which nothing would end.
        """
        progress, single = self.progress, self.progress.plan.single_contact and not self.progress.scene.effects.hinges
        for each in self.sustained:
            if each.spring is None or each.start is None or (each.spring.expected.moves and not single):
                continue
            if progress.state.time - each.start.time > PATIENCE * each.spring.expected.duration:
                return SpringChange(each, SpringEvent.OVERDUE)
        return None

    def first_event(self, result: Advance) -> tuple[Advance, Resolve | None]:
        """Return the interval up to its first event, and how that is resolved."""
        progress, signs, whole = self.progress, self.progress.signs, result
        functions = self._events
        if self.before is None and self.limit is None and not self.sustained:
            signs.look_back(self.interval_to(result), functions)
        known = dict(signs.signs)
        # What changes a contact comes first: a link that slides onto its neighbour does not touch before that.
        moving = any(each.spring is not None and each.spring.expected.moves for each in self.sustained)
        result, happens = signs.find_first(self._contact_events, self.interval_to(result), self.before, turns=moving)
        active, touch = [each.obstacle for each in self.sustained], None
        cut, found = first_touch_of_all(progress, self.interval_to(result), active, self.separating)
        if cut is not result:
            result, happens, touch = cut, None, found
        cut, later = signs.find_first(functions, self.interval_to(result), self.before)
        if later is not None:
            result, happens = cut, later
        if result is not whole:
            # What changes its sign later has not done so yet.
            signs.return_to(known, [*self._contact_events, *functions], result, happens)
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

    def _inner_states(self, start: State) -> list[State]:
        """Return states within an interval that has ended: those of a lone link in touch follow from the geometry alone."""
        progress, end, rigid = self.progress, self.progress.state, self.rigid
        length = end.time - start.time
        if length < SHORTEST_SAMPLED or not progress.mechanism.lone or rigid is None:
            return []

        def state_at(fraction: float) -> State:
            """Return the state that touches, nearest to the cubic's."""
            return rigid.set_back(progress.gaps, interpolate(start, end, fraction))

        guess, middle = interpolate(start, end, 0.5).angles[-1], state_at(0.5)
        # An error e of the angle that grows from one end and falls to the other is one of 8 e/length in the rate.
        error = 8.0 * abs(middle.angles[-1] - guess)
        near = error <= CUBIC_RATE_ERROR * progress.plan.accuracy * length * abs(middle.rates[-1])
        return [middle] if near else [state_at(0.25), middle, state_at(0.75)]


def follow_bodies(progress: Progress, obstacle: Obstacle, spring: Spring) -> None:
    """Let stick use the K of the bodies as they stand; in a contact short enough for the rigid limit it is constant."""
    if spring.expected.moves and not spring.slip:
        spring.inverse_mass = contact_at(progress.scene, progress.state, obstacle)[1].inverse_mass
