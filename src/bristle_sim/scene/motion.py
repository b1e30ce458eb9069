"""The smooth motion between two changes of contact; each link is in flight or in contact.

The motion is integrated interval by interval.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

from bristle_sim.scene.contact import ActiveContact, RigidContacts, sums_of
from bristle_sim.scene.events import Event, Happening, Kind
from bristle_sim.scene.extrapolation import IntervalResult, Load
from bristle_sim.scene.locate import Interval
from bristle_sim.scene.mechanism import cross
from bristle_sim.scene.pairs import ContactPair
from bristle_sim.scene.spring import SpringContact
from bristle_sim.scene.spring_force import follow_bodies
from bristle_sim.scene.system import GAP_ROUNDING, MOST_GROWTH, System
from bristle_sim.settings import StopReason

LONGEST_TURN = 1.0
"""Longest interval, in radians of the fastest motion. Within it each event's function changes sign
at most once, and the cubic polynomial between the interval's ends deviates by at most 1/384 of the
motion."""

BEYOND_RELEASE = 1.02
"""Length of the next interval over the time until an expected release. It exceeds 1, so that the
release lies within the interval."""

# shortest interval, in engine time units: a shorter one is not accurate, and a motion of this
# length counts as an instant
SHORTEST_INTERVAL = 1e-13

SHORTEST_CONTACT_INTERVAL = 1e-9
"""Shortest interval of a contact with a spring, over the duration of the contact. In a shorter
interval rounding error exceeds the tolerance."""

SHORTEST_SAMPLED = 2e-3
"""Shortest interval with inner samples, in engine time units. In a shorter interval the cubic
polynomial is accurate enough: its error falls with the third power of the interval."""

INNER_SAMPLES = (0.25, 0.5, 0.75)
"""Instants of a single link's inner samples in an interval of sustained contact, as fractions of
the interval. At these instants the motion follows from geometry alone."""

QUINTIC_RATE_ERROR = 2.4e-5
"""Error of the angular velocity on the quintic polynomial through an interval's ends and middle,
over the fifth power of the interval in radians of the fastest motion. It is 0.0174/6!, where 0.0174
is the largest slope of (s (s - 1/2) (s - 1))^2."""


@dataclass(slots=True, eq=False)
class Motion:
    """A smooth motion of the links, up to the next change of contact.

    Attributes:
        contacts: the active contacts, the rigid ones first once the motion has begun.
        separating: pairs that have been released but whose gaps are still closed.
        rigid: solver that keeps rigid contacts closed; None without rigid contacts.
        load: forces of all contacts; None without contacts.
        limit: longest next interval, in engine time units; it is short where a contact may end as
            soon as it begins.
        release_in: time from now until just after the normal force of a rigid contact is expected to
            reach zero.
        before: result at the end of the last interval; None in the first interval.
        events: events that may end the motion, contact events first.
    """

    contacts: tuple[ActiveContact, ...] = ()
    separating: tuple[ContactPair, ...] = ()
    rigid: RigidContacts | None = None
    load: Load | None = None
    limit: float = math.inf
    release_in: float = math.inf
    before: IntervalResult | None = None
    events: tuple[Event, ...] = ()

    @property
    def ordered(self) -> list[ActiveContact]:
        """The rigid contacts."""
        return [each for each in self.contacts if not isinstance(each, SpringContact)]

    @property
    def springs(self) -> list[SpringContact]:
        """The contacts with springs."""
        return [each for each in self.contacts if isinstance(each, SpringContact)]


def motion_events(system: System, *, in_contact: bool) -> Iterator[Event]:
    """Yield the events of the motion as a whole: largest retraction, highest speed, retraction
    limit, and the tip's exit from a dent.
    """
    mechanism = system.mechanism
    hub_speed = mechanism.hub_speed
    effects = system.scene.effects
    plan = system.plan

    def relative_rate(link: int, at: IntervalResult) -> float:
        return at.state.rates[link] - hub_speed

    def acceleration(link: int, at: IntervalResult) -> float:
        """Return the acceleration of a rigid bristle in flight, by its equation of motion."""
        time, angles, rates = at.state
        pose = mechanism.poses(at.state)[link]
        arm = pose.to_centre
        moment = (effects.stiffness or 0.0) * (mechanism.root_angle(time, link) - angles[link])
        moment += effects.damping * (hub_speed - rates[link])
        carried = hub_speed**2 * cross(arm, pose.joint) - effects.gravity * arm.real
        own = mechanism.links[link]
        return (moment + own.mass * carried) / own.inertia_about_joint

    def left(link: int, at: IntervalResult) -> float:
        """Return the angle by which a wire's first link may still turn before it lies on the hub,
        rad.
        """
        turned = at.state.angles[link] - mechanism.root_angle(at.state.time, link)
        return plan.retraction_limit - abs(turned)

    def gap(pair: ContactPair, at: IntervalResult) -> float:
        return system.closest(pair, at.state).gap

    for wire in range(mechanism.wires):
        link = wire * mechanism.wire_links
        if not plan.single_contact:
            yield Event(Kind.LARGEST_RETRACTION, wire, partial(relative_rate, link), 1)
            if not (in_contact or mechanism.jointed):  # a wire of several links vibrates
                yield Event(Kind.HIGHEST_SPEED, wire, partial(acceleration, link))
        if math.isfinite(plan.retraction_limit):
            yield Event(Kind.RETRACTION_LIMIT, wire, partial(left, link))
    for number, pair in enumerate(system.pairs):
        if pair.dent:
            yield Event(Kind.DENT_LEFT, number, partial(gap, replace(pair, dent=0.0)), 1)


def integrate(system: System, motion: Motion) -> tuple[Interval | None, Happening | None]:
    """Integrate the motion over its next interval.

    Returns:
        The interval and None, or None and the event of a contact that slips or whose force has
        fallen to zero. If both are None, the next interval must be shorter.
    """
    start = system.state
    first = motion.before is None
    for spring in motion.springs:
        follow_bodies(system.scene, start, spring)
    length = _proposed(system, motion)
    known: dict[float, IntervalResult] = {}

    def integrate_to(time: float) -> IntervalResult:
        """Return the result at a time after the interval's start; each time is integrated once."""
        if time not in known:
            known[time] = system.stepper.advance(system.scene, start, time, motion.load)
        return known[time]

    result = integrate_to(length)
    rigid = motion.rigid
    if rigid is not None and first and result.failed:
        # The shortest interval shows whether the force is gone from the beginning.
        shortest = min(length, system.plan.shortest)
        at_once = integrate_to(shortest)
        if rigid.fails(at_once.totals):
            result = at_once
            length = shortest
    if rigid is not None and (result.failed or first):
        slipping = rigid.breaks_away(result.totals)
        if slipping is not None or rigid.fails(result.totals):
            return None, _lost(system, motion, result, length, slipping)
    if system.stepper.accepts(result, length):
        before = (motion.before or IntervalResult(start))._replace(state=start)
        return Interval(before, result, integrate_to), None
    durations = [SHORTEST_CONTACT_INTERVAL * spring.duration for spring in motion.springs]
    if length < min(durations, default=SHORTEST_INTERVAL):
        system.stop(StopReason.ACCURACY)
    return None, None


def _lost(
    system: System, motion: Motion, result: IntervalResult, length: float, slipping: int | None
) -> Happening | None:
    """Return the event at which rigid contacts that would have to pull, or to stick against too
    large a force, are released or begin to slip; None if the next interval must be shorter.

    Only a contact that does not stick is released: its normal force falls to zero where its gap
    begins to open. In stick the normal force depends on friction too. Friction ends with the normal
    force, and without friction the gap may still close.

    Args:
        system: the run.
        motion: the motion, with rigid contacts.
        result: result of the interval.
        length: length of the interval.
        slipping: index of a sticking contact whose tangential force exceeds friction.
    """
    assert motion.rigid is not None
    plan = system.plan
    first = motion.before is None
    if first and length > plan.instant:
        # An interval of an instant shows whether the force is gone from the beginning.
        motion.limit = plan.instant
        return None
    lost = [
        contact
        for index, contact in enumerate(motion.ordered)
        if sums_of(result.totals, index).normal <= 0.0
    ]
    if lost:
        for contact in motion.ordered:
            if first and contact.stopped:
                return Happening(Kind.SLIPS, contact, -contact.stopped)
        if length > plan.shortest:
            shorter = length / MOST_GROWTH if first else 0.5 * length
            motion.limit = max(min(shorter, motion.release_in), 0.5 * plan.shortest)
            return None
    if slipping is None:
        return Happening(Kind.RELEASE, tuple(lost))
    sense = -1 if sums_of(result.totals, slipping).tangential > 0.0 else 1
    return Happening(Kind.SLIPS, motion.contacts[slipping], sense)


def accept(system: System, motion: Motion, interval: Interval) -> None:
    """Accept an interval: advance the run to its end and move links in sustained contact back onto
    their obstacles.

    The first interval of a flight after a contact may be the only interval of this flight. It is
    sampled once more in its middle if the polynomial through three samples would be less accurate
    than the run.
    """
    solver = system.scene.joint_solver
    recording = system.recording
    result = interval.end
    length = interval.length
    if length <= 0.0:
        return
    system.state = result.state if motion.rigid is None else solver.set_back(result.state)
    recording.error += result.error
    recording.summed += result.error
    if motion.contacts:
        _add(system, motion, interval)
    else:
        turned = length / system.plan.time_scale
        hops = motion.before is None and recording.contacts
        if hops and result.middle and QUINTIC_RATE_ERROR * turned**5 > system.plan.accuracy:
            system.sample(state=interval.integrate_to(0.5 * length).middle)
        if result.middle is not None and (
            motion.before is None or length > system.plan.longest_interval
        ):
            system.sample(state=result.middle)
        system.sample()
    motion.before = result
    if motion.limit < math.inf:
        motion.limit = max(MOST_GROWTH * length, system.plan.first_interval)
    if motion.rigid is not None:
        motion.limit = min(motion.limit, max(motion.release_in, system.plan.shortest))
    if motion.separating:
        motion.separating = tuple(
            pair
            for pair in motion.separating
            if system.closest(pair, system.state).gap <= GAP_ROUNDING
        )


def _add(system: System, motion: Motion, interval: Interval) -> None:
    """Add the impulses and the work of the contacts in an interval, and record the contact forces
    at its end.
    """
    motion.release_in = math.inf
    ends: dict[ActiveContact, float] = {}
    begins: dict[ActiveContact, float] = {}
    for index, contact in enumerate(motion.contacts):
        sums = sums_of(interval.end.totals, index)
        if not isinstance(contact, SpringContact):
            # At a located release, rounding error may make the force negative.
            first, bend, left = contact.expect_release(sums, interval.length)
            contact.add(sums)
            motion.release_in = min(motion.release_in, BEYOND_RELEASE * left)
            begins[contact] = max(0.0, first)
            ends[contact] = max(0.0, sums.normal)
        else:
            contact.add(sums)
            contact.stick_force = sums.tangential
            ends[contact] = contact.sample(system.closest, system.state)
    if motion.rigid is not None:
        if motion.before is None and len(begins) == len(ends):
            system.sample(begins, again=True)
        if system.mechanism.single_link and len(ends) == 1 and interval.length >= SHORTEST_SAMPLED:
            for part in INNER_SAMPLES:
                guess = interval.at(part * interval.length)
                force = first + part * (sums.normal - first) - part * (1.0 - part) * bend
                system.sample({contact: force}, state=system.scene.joint_solver.set_back(guess))
        motion.rigid.engage(system.state)
    system.sample(ends)


def _proposed(system: System, motion: Motion) -> float:
    """Return the length of a motion's next interval."""
    plan = system.plan
    stepper = system.stepper
    left = plan.end - system.state.time
    # A flight of rigid bristles is sampled in the middle of its intervals too.
    samples = 2.0 if motion.load is None and not system.mechanism.jointed else 1.0
    longest = min(
        samples * plan.longest_interval,
        plan.damped_interval,
        LONGEST_TURN * plan.time_scale,
        motion.limit,
    )
    lengths = [spring.stepper.longest for spring in motion.springs]
    if lengths:
        return stepper.propose(min(left, longest, *lengths))
    return min(stepper.propose(left), longest)
