"""The smooth motion between two changes of contact: in flight, separating, in sustained contact, or several of these at once.

It integrates one interval up to its first event, and returns the resulting change of the contacts. :mod:`bristle_sim.scene.run`
decides how the run continues.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

from bristle_sim.scene.contact.gaps import GAP_ROUNDING
from bristle_sim.scene.contact.laws import contact_at
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.rigid import TOTALS, RigidContacts, rigid_contacts, sense_of_slip
from bristle_sim.scene.contact.spring import SPRING_TOTALS, ContactLoad, Spring
from bristle_sim.scene.contact.sustained import Sustained
from bristle_sim.scene.events.locate import Interval, at_state, first_change
from bristle_sim.scene.events.table import (
    Change,
    Release,
    Slip,
    SpringChange,
    SpringEvent,
    contact_events,
    motion_events,
)
from bristle_sim.scene.events.touches import SHORTEST_INTERVAL, first_touch_of_all
from bristle_sim.scene.extrapolation import Advance
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.progress import MOST_GROWTH, Progress
from bristle_sim.settings import StopReason

LONGEST_TURN = 1.0
"""Longest interval in radians of the fastest motion: within it each event function changes its sign once at most, and the
cubic through the ends is good to 1/384 of the motion."""

BEYOND_RELEASE = 1.02  # multiple of the time to an expected release that the next interval takes, to contain it
BEFORE_RELEASE = (
    0.95  # of the time to a release located by the steps of one repetition: an interval that ends before it
)
SHORTEST_CONTACT_INTERVAL = 1e-9  # fraction of a contact with a spring in which rounding exceeds the tolerance
OVERDUE_DURATIONS = 10.0  # after which a contact in the rigid-body limit is no impact: it is pressed on
SHORTEST_SAMPLED = 2e-3  # shorter intervals are left to the cubic: its error falls with their third power
CUBIC_RATE_ERROR = 0.1  # fraction of the requested error of the rate above which the middle alone is not enough

QUINTIC_RATE_ERROR = 2.4e-5
"""Error of the rate on the quintic through an interval's ends and middle, per fifth power of its length in radians of the fastest
motion: the largest slope of (s (s - 1/2) (s - 1))^2, 0.0174, over 6!."""


class SmoothMotion:
    """One smooth motion of the links, up to the next change of contact.

    Attributes:
        sustained: the sustained contacts; ``ordered`` are the rigid ones, ``springs`` those with springs.
        separating: pairs that have been released but whose gaps are not open yet.
        rigid, load: the object that keeps rigid contacts closed, and the forces of all contacts; None without any.
        before: the last interval of this motion, if there is one.
        limit: longest permitted next interval: a contact may be over as soon as it begins.
        events: those of the contacts, and of the motion as a whole.
    """

    def __init__(
        self,
        progress: Progress,
        sustained: Sequence[Sustained] = (),
        separating: Sequence[Obstacle] = (),
    ) -> None:
        """Begin a motion; accelerations and signs of the last one are discarded."""
        soon_over = sustained or progress.mechanism.wire_links > 1
        self.progress, self.limit = progress, progress.plan.first_interval if soon_over else math.inf
        self.sustained, self.separating = tuple(sustained), tuple(separating)
        self.ordered = [each for each in sustained if each.spring is None]
        self.springs = [(each, each.spring) for each in sustained if each.spring is not None]
        self.before: Advance | None = None
        self.rigid: RigidContacts | None = None
        self.load: ContactLoad | RigidContacts | None = None
        if sustained:
            self._begin_contact()
        shortest = min((each.expected for _, each in self.springs), key=lambda each: each.longest, default=None)
        progress.stepper = progress.flight if shortest is None else shortest.stepper
        self.events = contact_events(progress, sustained, self.rigid), motion_events(progress, sustained)
        for each in (*self.events[0], *self.events[1]):
            each.begin(progress.state, progress.noise)

    def _begin_contact(self) -> None:
        """Activate the contacts, if they can act."""
        progress, gaps = self.progress, self.progress.gaps
        for each in self.ordered:
            if each.slip is None and each.obstacle.friction:
                each.slip = sense_of_slip(gaps, each.obstacle, progress.state, progress.slip_error(progress.state))
        if self.ordered:
            obstacles, slips = [each.obstacle for each in self.ordered], [each.slip for each in self.ordered]
            self.rigid = rigid_contacts(progress.scene, obstacles, slips, paired=not self.springs)
            progress.state = self.rigid.set_back(gaps, progress.state)
            if progress.mechanism.lone and not self.springs:
                # From here on the geometry gives angle and rate, whatever their errors before.
                progress.recording.error = progress.recording.summed
        for each in self.sustained:
            each.begin(progress.state)
        self._engage()
        self.load = self.rigid
        if self.springs:
            self.load = ContactLoad(progress.scene, self.rigid, [each for each, _ in self.springs])
        progress.sample({each: each.sample(gaps, progress.state) for each, _ in self.springs})

    def _engage(self) -> None:
        """Activate rigid contacts at the present state; stop the run if no force keeps them closed."""
        progress = self.progress
        if self.rigid is None or self.rigid.engage(progress.gaps, progress.state) > 0.0:
            return
        if any(each.friction for each in self.rigid.obstacles):
            progress.stop(StopReason.JAM)
            progress.event("jam", sorted({wire for each in self.rigid.obstacles for wire in progress.wires_of(each)}))
        progress.stop(StopReason.NO_GRIP)

    def integrate(self) -> Interval | Change | None:
        """Integrate over an interval; return it, or a change of contacts if their forces have vanished, or None to retry."""
        progress, start, instant = self.progress, self.progress.state, self.progress.plan.instant
        first = self.before is None
        for function in self.events[0] if first else ():
            if function.is_due and function.act is not None:
                return function.act()
        for each, spring in self.springs:
            follow_bodies(progress, each.obstacle, spring)
        length = _proposed(self)
        again = functools.cache(functools.partial(progress.stepper.advance, progress.scene, start, load=self.load))
        result = again(length)
        if self.rigid is not None:
            forces = self.rigid.normal(result.totals)
            gone = result.failed or (first and min(forces) <= 0.0)
            slipping = self.rigid.breaks_away(result.totals) if first and not gone else None
            if (gone or slipping is not None) and first and length > instant:
                # Whether it is so from the beginning shows in an instant.
                self.limit = instant
                return None
            if slipping is not None:
                return Slip(self.ordered[slipping], -1 if result.totals[TOTALS * slipping + 1] > 0.0 else 1)
            if gone:
                return self._approach_release(forces, length)
        if progress.stepper.accepts(result, length):
            before = (self.before or at_state(start))._replace(state=start)
            return Interval(before, result, again)
        durations = [SHORTEST_CONTACT_INTERVAL * spring.expected.duration for _, spring in self.springs]
        if not math.isfinite(result.error) or length < min(durations, default=SHORTEST_INTERVAL):
            progress.stop(StopReason.ACCURACY)
        return None

    def _approach_release(self, forces: Sequence[float], length: float) -> Change | None:
        """Shorten the interval towards the instant at which a force vanishes, or release the contact or its stick."""
        plan, first = self.progress.plan, self.before is None
        for each in self.ordered:
            if first and each.stopped:
                return Slip(each, -each.stopped)
        if (first and self.progress.mechanism.lone) or length <= plan.shortest:
            lost = zip(self.ordered, forces, strict=True)
            return Release(tuple(each.obstacle for each, force in lost if force <= 0.0))
        assert self.rigid is not None
        shorter = length / MOST_GROWTH if first else BEFORE_RELEASE * length * self.rigid.lasts()
        self.limit = max(min(shorter, self._until_release()), 0.5 * plan.shortest)
        return None

    def _until_release(self) -> float:
        """Return an interval that ends just after the first force vanishes, extrapolated from the last one."""
        return BEYOND_RELEASE * min((each.vanishes_in for each in self.sustained), default=math.inf)

    def up_to_first_event(self, interval: Interval) -> Change | None:
        """Accept an interval up to its first event, and return the change of the contacts, if any."""
        progress, whole, (of_contacts, of_motion) = self.progress, interval, self.events
        # Changes of contact come first: a link that slides onto its neighbour does not touch before that.
        interval, happens = first_change(progress, of_contacts, interval)
        active, changed = [each.obstacle for each in self.sustained], interval
        interval, touch = first_touch_of_all(progress, interval, active, self.separating)
        happens = happens if interval is changed else None
        interval, later = first_change(progress, of_motion, interval)
        happens = later or happens
        for each in (*of_contacts, *of_motion):
            # The function that is zero at a new end has changed its sign; the later ones have not yet.
            known = interval is whole or each is happens
            each.sign = each.sign_of(each.reached if known else each.value(interval.end))
        self._commit(interval)
        if happens is None:
            return touch or _overdue(self)
        if happens.final is not None:
            progress.stop(happens.final)
        if happens.event is not None:
            progress.event(happens.event, (happens.wire,))
        return None if happens.act is None else happens.act()

    def _commit(self, interval: Interval) -> None:
        """Accept an interval's end; links in sustained contact are set back onto their obstacles.

        The first interval of a flight after a contact, which may be the only one, gets one more sample where the polynomial through
        three is less accurate than the run.
        """
        progress, gaps, result, length = self.progress, self.progress.gaps, interval.end, interval.length
        progress.state = result.state if self.rigid is None else self.rigid.set_back(gaps, result.state)
        progress.recording.error += result.error
        progress.recording.summed += result.error
        if self.sustained:
            self._add(interval)
        else:
            turned = length / progress.plan.time_scale
            hops = self.before is None and progress.recording.contacts
            if hops and result.middle and QUINTIC_RATE_ERROR * turned**5 > progress.plan.accuracy:
                progress.sample(state=interval.again(0.5 * length).middle)
            if result.middle is not None and (self.before is None or length > progress.plan.longest_interval):
                progress.sample(state=result.middle)
            progress.sample()
        self.before = result
        if self.limit < math.inf:
            self.limit = max(MOST_GROWTH * length, progress.plan.first_interval)
        if self.ordered:
            self.limit = min(self.limit, max(self._until_release(), progress.plan.shortest))
        if self.separating:
            self.separating = tuple(each for each in self.separating if gaps.gap(each, progress.state) <= GAP_ROUNDING)

    def _add(self, interval: Interval) -> None:
        """Add the contacts' impulses and work in an interval, and record their forces at its end."""
        progress, totals, length, ends, begins = self.progress, interval.end.totals, interval.length, {}, {}
        for index, each in enumerate(self.ordered):
            normal, _, push, rub, work = totals[TOTALS * index : TOTALS * (index + 1)]
            # A release is located to rounding, on either side.
            begins[each] = max(0.0, each.add(normal, (push, rub, 0.0, work), length))
            ends[each] = max(0.0, normal)
        for number, (each, _) in enumerate(self.springs):
            each.add_spring(totals[TOTALS * len(self.ordered) + SPRING_TOTALS * number :][:SPRING_TOTALS])
            ends[each] = each.sample(progress.gaps, progress.state)
        if self.rigid is not None:
            if self.before is None and not self.springs:
                progress.sample(begins, again=True)
            if progress.mechanism.lone and length >= SHORTEST_SAMPLED:
                progress.recording.inner += _inner_states(progress, self.rigid, interval)
            self._engage()
        progress.sample(ends)


def _proposed(motion: SmoothMotion) -> float:
    """Return the length of a motion's next interval."""
    progress, plan = motion.progress, motion.progress.plan
    left = plan.end - progress.state.time
    longest = min(plan.longest_interval, plan.damped_interval, LONGEST_TURN * plan.time_scale)
    if motion.springs:
        longest = min(longest, *(spring.expected.longest for _, spring in motion.springs))
        return progress.stepper.propose(min(left, longest, math.inf if motion.rigid is None else motion.limit))
    if progress.stepper.halves(progress.scene, motion.load):
        longest = min(2.0 * plan.longest_interval, plan.damped_interval, LONGEST_TURN * plan.time_scale)
    return min(progress.stepper.propose(left), longest, motion.limit)


def _inner_states(progress: Progress, rigid: RigidContacts, interval: Interval) -> list[State]:
    """Return states within the last interval; for a lone link in contact they follow from geometry alone."""
    length, gaps = interval.length, progress.gaps
    guess = interval.at(0.5 * length)
    middle = rigid.set_back(gaps, guess)
    # An error e of the angle that grows from one end and falls to the other is one of 8 e/length in the rate.
    error = 8.0 * abs(middle.angles[-1] - guess.angles[-1])
    if error <= CUBIC_RATE_ERROR * progress.plan.accuracy * length * abs(middle.rates[-1]):
        return [middle]
    before, after = (rigid.set_back(gaps, interval.at(part * length)) for part in (0.25, 0.75))
    return [before, middle, after]


def _overdue(motion: SmoothMotion) -> Change | None:
    """Return the event that ends a contact lasting over ``OVERDUE_DURATIONS`` times as long as expected.

    Only a contact in the rigid-body limit, or a single one of rigid links, is ended so: nothing else would end it.
    """
    progress = motion.progress
    single = progress.plan.single_contact and not progress.scene.effects.hinges
    for each, spring in motion.springs:
        since = 0.0 if each.start is None else progress.state.time - each.start.time
        if since > OVERDUE_DURATIONS * spring.expected.duration and (single or not spring.expected.moves):
            return SpringChange(each, SpringEvent.OVERDUE)
    return None


def follow_bodies(progress: Progress, obstacle: Obstacle, spring: Spring) -> None:
    """In stick update K from the bodies' positions, except in the rigid-body limit, where K is constant."""
    if spring.expected.moves and not spring.slip:
        spring.inverse_mass = contact_at(progress.scene, progress.state, obstacle)[1].inverse_mass
