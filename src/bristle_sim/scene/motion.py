"""Smooth motion between two changes of contact, integrated interval by interval."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from bristle_sim.scene.contact import ActiveContact, RigidContacts, force_within, sums_of
from bristle_sim.scene.events import Event, Happening, Kind
from bristle_sim.scene.extrapolation import IntervalResult, SpringForce
from bristle_sim.scene.locate import Interval
from bristle_sim.scene.mechanism import cross
from bristle_sim.scene.pairs import ContactPair
from bristle_sim.scene.spring import SpringContact
from bristle_sim.scene.system import GAP_ROUNDING, MOST_GROWTH, System
from bristle_sim.settings import StopReason

# angle from the radial direction at which a bristle lies on the hub, rad
RETRACTION_LIMIT = math.pi / 2.0

FAR_FROM_THE_HUB = 1.0
"""Angle from the radial direction, at an interval's end, up to which a bristle does not lie on the
hub within the interval. In an interval of a radian it swings past both ends by at most 1 - cos(1/2)
of its amplitude, 0.2 rad."""

LONGEST_TURN = 1.0
"""Longest interval, in radians of the fastest motion. The value of most events changes sign at most
once in it, and the cubic polynomial through the states at its ends has an error of at most 1/384 of
the motion's amplitude."""

BEYOND_RELEASE = 1.02
"""Ratio of the next interval's length to the time until an expected release. The ratio exceeds 1,
so that the release lies within the interval."""

CORNERS = (Kind.KINK, Kind.HAND_OVER)  # kinds of events at which the motion of a wire has a kink
BEYOND_CORNER = 1.001
"""Ratio of the next interval's length to the estimated time of a kink that the rejected interval
contained. The kink is then located in an interval that is smooth but for its last thousandth."""

# Shortest interval, in engine time units. A shorter interval is not accurate: the motion in it is
# of the order of rounding error.
SHORTEST_INTERVAL = 1e-13

SHORTEST_CONTACT_INTERVAL = 1e-9
"""Shortest interval of a contact with a spring, as a fraction of the duration of the contact. In a
shorter interval rounding error exceeds the tolerance."""

SHORTEST_SAMPLED = 2e-3
"""Shortest interval with inner samples, in engine time units. In a shorter interval the cubic
polynomial is accurate enough: its error is proportional to the third power of the length."""

INNER_SAMPLES = (0.25, 0.5, 0.75)
"""Instants of a single link's inner samples in an interval of sustained contact, as fractions of
the interval. The motion at these instants follows from geometry alone, without integration."""

QUINTIC_RATE_ERROR = 2.4e-5
"""Error of the angular velocity of the quintic polynomial through an interval's ends and middle,
divided by the fifth power of the interval's length in radians of the fastest motion. The quotient
is 0.0174/6!, where 0.0174 is the largest slope of (s (s - 1/2) (s - 1))^2."""


@dataclass(slots=True, eq=False)
class Motion:
    """A smooth motion of the links, up to the next change of contact.

    Attributes:
        contacts: the active contacts, the rigid ones first once the motion has begun.
        separating: pairs that have been released but whose gaps are still closed.
        rigid: forces of the rigid contacts; None without rigid contacts.
        forces: forces of the contacts with springs.
        limit: upper bound of the next interval's length, in engine time units. The bound is small
            at the beginning of a contact, which may end at once.
        release_in: length that the next interval must have to contain the expected release of a
            rigid contact; infinite if no release is expected.
        before: result at the end of the last interval; None in the first interval.
        events: events that may end the motion, contact events first.
        ordered: the rigid contacts.
        springs: the contacts with springs.
    """

    contacts: tuple[ActiveContact, ...] = ()
    separating: tuple[ContactPair, ...] = ()
    rigid: RigidContacts | None = None
    forces: Sequence[SpringForce] = ()
    limit: float = math.inf
    release_in: float = math.inf
    before: IntervalResult | None = None
    events: tuple[Event, ...] = ()
    ordered: list[ActiveContact] = field(init=False)
    springs: list[SpringContact] = field(init=False)

    def __post_init__(self) -> None:
        """Select the rigid contacts and those with springs."""
        self.springs = [each for each in self.contacts if isinstance(each, SpringContact)]
        self.ordered = [each for each in self.contacts if each not in self.springs]


def motion_events(system: System, contacts: Sequence[ActiveContact]) -> Iterator[Event]:
    """Yield the events that do not belong to a contact.

    The events are the largest retraction, the highest angular velocity, the retraction limit, and
    the instant at which the tip leaves the dent of an earlier contact. A wire in one of the active
    ``contacts`` has no highest angular velocity.
    """
    mechanism = system.mechanism
    touching = {wire for contact in contacts for wire in system.wires_of(contact.pair)}
    hub_speed = mechanism.hub_speed
    effects = system.scene.effects

    def relative_rate(link: int, at: IntervalResult) -> float:
        return at.state.rates[link] - hub_speed

    def acceleration(link: int, at: IntervalResult) -> float:
        """Return a rigid bristle's angular acceleration in flight by its equation of motion."""
        time, angles, rates = at.state
        pose = mechanism.poses(at.state)[link]
        arm = pose.to_centre
        moment = effects.stiffness * (mechanism.root_angle(time, link) - angles[link])
        moment += effects.damping * (hub_speed - rates[link])
        carried = hub_speed**2 * cross(arm, pose.joint) - effects.gravity * arm.real
        own = mechanism.links[link]
        return (moment + own.mass * carried) / own.inertia_about_joint

    def left(link: int, at: IntervalResult) -> float:
        """Return the angle (rad) that is left until a wire's first link lies on the hub.

        It is NaN where it is too large for the link to lie on the hub within the interval.
        """
        turned = abs(at.state.angles[link] - mechanism.root_angle(at.state.time, link))
        return RETRACTION_LIMIT - turned if turned > FAR_FROM_THE_HUB else math.nan

    def gap(pair: ContactPair, at: IntervalResult) -> float:
        return system.closest(pair, at.state).gap

    for wire in range(0 if system.plan.single_contact else mechanism.wires):
        link = wire * mechanism.wire_links
        yield Event(Kind.LARGEST_RETRACTION, wire, partial(relative_rate, link), 1)
        if not (wire in touching or mechanism.jointed):  # a wire of several links vibrates
            yield Event(Kind.HIGHEST_RELATIVE_SPEED, wire, partial(acceleration, link))
        yield Event(Kind.RETRACTION_LIMIT, wire, partial(left, link))
    for number, pair in enumerate(system.pairs):
        if pair.dent:
            yield Event(Kind.DENT_LEFT, number, partial(gap, replace(pair, dent=0.0)), 1)


def integrate(system: System, motion: Motion) -> tuple[Interval | None, Happening | None]:
    """Integrate the motion over its next interval.

    Returns:
        One of three pairs:
            The interval and None, if the interval is accepted.
            None and the event of a contact that begins to slip or is released at the start.
            None and None, if the interval is rejected; the next one will be shorter.
    """
    start = system.state
    first = motion.before is None
    for spring in motion.springs:
        spring.follow_bodies(system.scene, start)
    length = _proposed(system, motion)
    known: dict[float, IntervalResult] = {}

    def integrate_to(time: float) -> IntervalResult:
        """Return the result at a time after the interval's start, computed once for each time."""
        if time not in known:
            known[time] = system.stepper.advance(
                system.scene, start, time, motion.rigid, motion.forces
            )
        return known[time]

    result = integrate_to(length)
    rigid = motion.rigid
    if rigid is not None and first and result.failed:
        # The shortest interval shows whether the normal force is zero from the beginning.
        shortest = min(length, system.plan.shortest)
        at_once = integrate_to(shortest)
        if rigid.fails(at_once.totals):
            result = at_once
            length = shortest
    if rigid is not None and (result.failed or first):
        slipping = next(
            (
                index
                for index, contact in enumerate(rigid.closed)
                if contact.slip == 0 and rigid.spare_friction(result.totals, index) < 0.0
            ),
            None,
        )
        if slipping is not None or rigid.fails(result.totals):
            return None, _lost(system, motion, result, length, slipping)
    if system.stepper.accepts(result, length):
        before = (motion.before or IntervalResult(start))._replace(state=start)
        return Interval(before, result, integrate_to), None
    for event in motion.events if result.error < math.inf else ():
        if event.kind in CORNERS:
            left, right = (event.value(each) for each in (IntervalResult(start), result))
            if left * right < 0.0:
                motion.limit = min(motion.limit, BEYOND_CORNER * length * left / (left - right))
    durations = [SHORTEST_CONTACT_INTERVAL * spring.duration for spring in motion.springs]
    if length < min(durations, default=SHORTEST_INTERVAL):
        system.stop(StopReason.ACCURACY)
    return None, None


def _lost(
    system: System, motion: Motion, result: IntervalResult, length: float, slipping: int | None
) -> Happening | None:
    """Return the event that ends a rigid contact or its stick; None if the interval is too long.

    A contact that would have to pull is released. A sticking contact whose tangential force exceeds
    the friction limit begins to slip. If both occur, the contact begins to slip and no contact is
    released: the normal forces in stick depend on friction, and in slip all contacts may push.

    Args:
        system: the run.
        motion: the motion, with rigid contacts.
        result: result of the interval.
        length: length of the interval.
        slipping: index of a sticking contact whose tangential force exceeds the friction limit;
            None without such a contact.
    """
    plan = system.plan
    first = motion.before is None
    if first and length > plan.instant:
        # An interval of the length ``instant`` shows whether the force is zero from the beginning.
        motion.limit = plan.instant
        return None
    lost = [
        contact
        for index, contact in enumerate(motion.ordered)
        if sums_of(result.totals, index).normal <= 0.0
    ]
    if lost and length > plan.shortest:
        shorter = length / MOST_GROWTH if first else 0.5 * length
        motion.limit = max(min(shorter, motion.release_in), 0.5 * plan.shortest)
        return None
    if slipping is None:
        return Happening(Kind.RELEASE, tuple(lost))
    contact = motion.contacts[slipping]
    contact.tangential = sums_of(result.totals, slipping).tangential
    return Happening(Kind.BREAKS_AWAY, contact)


def accept(system: System, motion: Motion, interval: Interval) -> None:
    """Advance the run to the end of an interval, and record samples of the motion in it.

    Links in sustained contact are moved back onto their obstacles. The first interval after a
    contact may be the whole flight. In that interval a further sample is recorded if the error of
    the polynomial through the states at its ends and in its middle exceeds the run's accuracy.
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
            pair for pair in motion.separating if system.closest(pair).gap <= GAP_ROUNDING
        )


def _add(system: System, motion: Motion, interval: Interval) -> None:
    """Add the contacts' impulses and work in an interval, and record samples with their forces.

    The normal force of a spring at an inner instant of the interval follows from its penetration;
    other forces are those of ``force_within``.
    """
    motion.release_in = math.inf
    length = interval.length
    courses: dict[ActiveContact, tuple[float, float, float]] = {}
    for index, contact in enumerate(motion.contacts):
        sums = sums_of(interval.end.totals, index)
        if isinstance(contact, SpringContact):
            mean = sums.impulse_tangential / length
            courses[contact] = (sums.tangential_at_start, sums.tangential, mean)
        else:
            first, left = contact.expect_release(sums, length)
            courses[contact] = (first, sums.normal, sums.impulse_normal / length)
            motion.release_in = min(motion.release_in, BEYOND_RELEASE * left)
        contact.add(sums)

    rigid = motion.rigid
    instants = []
    if rigid is not None and motion.before is None and not motion.springs:
        instants.append((0.0, interval.start))
    if interval.end.middle is not None:
        instants.append((0.5, interval.end.middle))
    elif rigid is not None and system.mechanism.single_link and length >= SHORTEST_SAMPLED:
        for part in INNER_SAMPLES:
            state = interval.at(part * length)
            instants.append((part, system.scene.joint_solver.set_back(state)))
    for part, state in (*instants, (1.0, system.state)):
        forces = {}
        for contact, (first, last, mean) in courses.items():
            force = force_within(part, first, last, mean)
            if isinstance(contact, SpringContact):
                contact.stick_force = force
                force = contact.sample(system.closest, state)
            forces[contact] = max(0.0, force)  # rounding error at a located release
        system.sample(forces, state=state)
    if rigid is not None:
        rigid.engage(system.state)


def _proposed(system: System, motion: Motion) -> float:
    """Return the length of the next interval of a motion."""
    plan = system.plan
    stepper = system.stepper
    left = plan.end - system.state.time
    # In a flight of rigid bristles the middle of an interval is a sample too.
    samples = 2.0 if not motion.contacts and not system.mechanism.jointed else 1.0
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
