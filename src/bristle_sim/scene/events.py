"""Events of a run: functions whose change of sign ends a smooth motion, and the kinds of events.

An event *triggers* in an interval (0, h] of a smooth motion if its value begins with the sign
opposite to ``direction`` and has the sign ``direction`` at a later instant of the interval. The
instant of the event is the first zero before that later instant. A value within its rounding at the
beginning of a motion has no sign. It takes the sign that its kind states in
:data:`BEGINS_POSITIVE`, or else the first sign that it has at the end of an interval. A
``direction`` of 0 stands for both signs. :mod:`bristle_sim.scene.touches` searches for gaps that
close.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto
from functools import lru_cache, partial
from typing import Any, NamedTuple

from bristle_sim.scene.contact import ActiveContact
from bristle_sim.scene.interval import IntervalResult
from bristle_sim.scene.mechanism import State, cross
from bristle_sim.scene.pairs import BarPair, ClosestApproach, ContactPair
from bristle_sim.scene.rigid import RigidContacts
from bristle_sim.scene.spring import Spring
from bristle_sim.scene.system import System

# least compliance in slip, over that of a free link: with less, the force that keeps a contact
# closed grows without bound, a jam
LEAST_COMPLIANCE_IN_SLIP = 1e-3
PLACE_ROUNDING = 4e-16  # rounding of a tip's place, in the scene's unit of length
LOCATED_VELOCITY = 0.1
"""Tolerance to which a spring's events are located, over the error in velocity that an interval may
have."""

OVERDUE_DURATIONS = 10.0
"""Duration of a contact in the rigid-body limit, over the expected one, above which it counts as
pressed on, not as an impact."""


class Kind(Enum):
    """The kinds of events, with the subject of each."""

    TOUCH = auto()  # pair: its gap closes
    REST = auto()  # pair: its gap closes, and the impact has no restitution
    RELEASE = auto()  # contacts: their normal forces fall to zero
    HAND_OVER = auto()  # contact, and the pair of the neighbouring link onto which it slides
    SLIP_STOPS = auto()  # rigid contact: its slip velocity falls to zero
    BREAKS_AWAY = auto()  # rigid contact that sticks: its tangential force exceeds friction
    SLIPS = auto()  # rigid contact, and the sense in which it slips from now on
    # contact: it passes a corner of the wire, or its slip changes its sense without friction's
    KINK = auto()
    LOCKED = auto()  # rigid contact: no force keeps it closed
    # number of a pair: the tip comes out of the dent that a contact in time has left
    DENT_LEFT = auto()
    COMPRESSION_ENDS = auto()  # contact with a spring: the approach falls to zero
    UNLOADED = auto()  # contact with a spring: its force falls to zero
    # contact with a spring that unloads: the penetration exceeds the deepest one
    PRESSED_ON = auto()
    RELOADING_ENDS = auto()  # contact with a spring pressed on from rest at its deepest point: its approach falls to zero again
    REST_ENDS = auto()  # contact with a spring in slip at rest: friction no longer keeps it at rest
    FOOT_STOPS = auto()  # contact with a spring that slips: its foot stops
    # contact with a spring that sticks: its tangential force reaches the friction cone
    CONE_REACHED = auto()
    # contact with a spring in the rigid-body limit: it lasts too long to be an impact
    OVERDUE = auto()
    LARGEST_RETRACTION = auto()  # wire: its first link turns back towards the hub's direction
    HIGHEST_SPEED = auto()  # wire: the rate of its only link is highest
    RETRACTION_LIMIT = auto()  # wire: it lies on the hub


SPRING_KINDS = frozenset(
    {
        Kind.COMPRESSION_ENDS,
        Kind.UNLOADED,
        Kind.PRESSED_ON,
        Kind.RELOADING_ENDS,
        Kind.REST_ENDS,
        Kind.FOOT_STOPS,
        Kind.CONE_REACHED,
        Kind.OVERDUE,
    }
)
BEGINS_POSITIVE = frozenset(
    {
        Kind.LOCKED,
        Kind.RETRACTION_LIMIT,
        Kind.COMPRESSION_ENDS,
        Kind.UNLOADED,
        Kind.PRESSED_ON,
        Kind.RELOADING_ENDS,
        Kind.REST_ENDS,
        Kind.FOOT_STOPS,
        Kind.CONE_REACHED,
    }
)
"""Kinds whose value, by the decision at the last event, is positive where a motion begins or rises
from zero there."""

TURNS = SPRING_KINDS - {Kind.OVERDUE} | {Kind.DENT_LEFT}
"""Kinds whose value may change its sign twice within an interval."""

DIFFERENCES = frozenset({Kind.RELEASE, Kind.BREAKS_AWAY})
"""Kinds whose value contains a difference of rates over a step, with its rounding."""


@dataclass(frozen=True, slots=True)
class Event:
    """A function of an interval's result whose change of sign is an event.

    Attributes:
        value: the function.
        direction: -1 for a fall through zero, +1 for a rise, 0 for both.
        kind: kind of the event.
        subject: contact, pair or wire of the event, as its kind states.
        tolerance: value to which the zero is located; None for the run's own tolerance. With a
            tolerance, every value above rounding has a sign.
    """

    value: Callable[[IntervalResult], float]
    direction: int
    kind: Kind
    subject: Any
    tolerance: float | None = None


class Happening(NamedTuple):
    """An event that has happened: its kind, its subject, and a detail such as the new sense of
    slip.
    """

    kind: Kind
    subject: Any
    detail: Any = None


def motion_events(system: System, *, in_contact: bool) -> Iterator[Event]:
    """Yield the events of the motion as a whole: extremes, limits, and dents that the tip
    leaves."""
    mechanism = system.mechanism
    effects = system.scene.effects
    plan = system.plan

    def relative_rate(link: int, at: IntervalResult) -> float:
        return at.state.rates[link] - mechanism.hub_speed

    def acceleration(link: int, at: IntervalResult) -> float:
        """Return the acceleration of a rigid bristle in flight, by its equation of motion."""
        time, angles, rates = at.state
        pose = system.gaps.poses(at.state)[link]
        arm = (pose.centre[0] - pose.joint[0], pose.centre[1] - pose.joint[1])
        moment = (effects.stiffness or 0.0) * (mechanism.root_angle(link, time) - angles[link])
        moment += effects.damping * (mechanism.hub_speed - rates[link])
        carried = mechanism.hub_speed**2 * cross(arm, pose.joint) - effects.gravity * arm[0]
        own = mechanism.links[link]
        return (moment + own.mass * carried) / own.inertia_about_joint

    def left(link: int, at: IntervalResult) -> float:
        """Return the angle left until a wire's first link lies on the hub, rad."""
        return plan.retraction_limit - abs(
            at.state.angles[link] - mechanism.root_angle(link, at.state.time)
        )

    for wire in range(mechanism.wires):
        link = wire * mechanism.wire_links
        if not plan.single_contact:
            yield Event(partial(relative_rate, link), 1, Kind.LARGEST_RETRACTION, wire)
        if not (plan.single_contact or in_contact or mechanism.wire_links > 1):
            # A wire of several links vibrates.
            yield Event(partial(acceleration, wire), -1, Kind.HIGHEST_SPEED, wire)
        if math.isfinite(plan.retraction_limit):
            yield Event(partial(left, link), -1, Kind.RETRACTION_LIMIT, wire)
    for number, pair in enumerate(system.pairs):
        if pair.dent:
            yield Event(partial(_gap, system, replace(pair, dent=0.0)), 1, Kind.DENT_LEFT, number)


def _gap(system: System, pair: ContactPair, at: IntervalResult) -> float:
    return system.gaps.gap(pair, at.state)


def contact_events(
    system: System, contacts: Sequence[ActiveContact], rigid: RigidContacts | None
) -> Iterator[Event]:
    """Yield the events that change or end contacts; contacts are numbered as in the load, the rigid
    ones first.
    """
    for index, contact in enumerate(contacts):
        if contact.spring is not None:
            yield from _spring_events(system, contact, contact.spring, index)
            continue
        assert rigid is not None
        yield from _rigid_events(system, contact, rigid, index)
        if isinstance(contact.pair, BarPair):
            yield from _bar_events(system, contact, contact.pair, rigid.closed[index].piece or 0)


def _rigid_events(
    system: System, contact: ActiveContact, rigid: RigidContacts, index: int
) -> Iterator[Event]:
    """Yield the events of a rigid contact: it locks, is released, slips, sticks, or passes a
    corner.

    A contact locks when its compliance in slip is too small: friction then jams the link, or a
    frictionless link meets the obstacle end-on.
    """
    pair = contact.pair
    gaps = system.gaps

    def compliance(at: IntervalResult) -> float:
        return rigid.compliance_in_slip(gaps, at.state, index) - LEAST_COMPLIANCE_IN_SLIP

    def push(at: IntervalResult) -> float:
        return at.sums(index).normal if at.totals else math.nan

    def spare(at: IntervalResult) -> float:
        return rigid.spare_friction(at.totals, index) if at.totals else math.nan

    def slip(at: IntervalResult) -> float:
        return (contact.slip or 1) * gaps.closest(pair, at.state).velocity[1]

    def kink(number: int, at: IntervalResult) -> float:
        return gaps.closest(pair, at.state).kinks[number]

    yield Event(compliance, -1, Kind.LOCKED, contact)
    yield Event(push, -1, Kind.RELEASE, (contact,))
    if contact.slip == 0:
        yield Event(spare, -1, Kind.BREAKS_AWAY, contact)
    elif contact.slip:
        yield Event(slip, -1, Kind.SLIP_STOPS, contact)
    elif pair.friction:
        yield Event(slip, 0, Kind.KINK, contact)
    for number in range(len(gaps.closest(pair, system.state).kinks)):
        yield Event(partial(kink, number), 0, Kind.KINK, contact)


def _bar_events(
    system: System, contact: ActiveContact, pair: BarPair, piece: int
) -> Iterator[Event]:
    """Yield the events at which a contact slides over a joint, or another piece of the same bent
    link touches the bar.

    The contact passes to the other piece by an impact.
    """
    gaps = system.gaps
    lower, upper = system.neighbour(pair, -1), system.neighbour(pair, 1)

    def beside(at: IntervalResult) -> float:
        return pair.gap_beside(gaps.poses(at.state)[pair.link], piece)

    def before(at: IntervalResult) -> float:
        return pair.foot(gaps.poses(at.state)[pair.link])[0]

    def after(following: BarPair, at: IntervalResult) -> float:
        poses = gaps.poses(at.state)
        return min(pair.foot(poses[pair.link])[1], following.foot(poses[following.link])[0])

    if system.mechanism.links[pair.link].knees:
        yield Event(beside, -1, Kind.TOUCH, pair)
    if lower is not None:
        yield Event(before, -1, Kind.HAND_OVER, (contact, lower))
    if upper is not None:
        yield Event(partial(after, upper), 1, Kind.HAND_OVER, (contact, upper))


def _spring_events(
    system: System, contact: ActiveContact, spring: Spring, index: int
) -> Iterator[Event]:
    """Yield the events of a spring: it is compressed, unloads or reloads, and its foot stops or
    slips.

    The value of each event is a velocity, or a penetration or force scaled to a velocity by the
    contact's duration.
    """
    pair = contact.pair
    gaps = system.gaps
    duration = spring.duration
    tolerance = max(LOCATED_VELOCITY * spring.stepper.noise, math.ulp(1.0))

    @lru_cache(maxsize=1)
    def touch(state: State) -> ClosestApproach:
        return gaps.closest(pair, state)

    def closing(at: IntervalResult) -> float:
        return -touch(at.state).velocity[0]

    def slip(at: IntervalResult) -> float:
        return spring.slip * spring.foot_speed(touch(at.state).velocity)

    def slip_at_rest(at: IntervalResult) -> float:
        return slip(at) - spring.least_slip_at_rest

    def beyond(level: float, at: IntervalResult) -> float:
        return (spring.surface - touch(at.state).gap - level) / duration

    def above_deepest(at: IntervalResult) -> float:
        return -beyond(spring.deepest or 0.0, at)

    def rest_margin(which: int, at: IntervalResult) -> float:
        """Return one of the two margins of friction in slip at rest, scaled to a velocity."""
        if not at.totals:
            return math.nan
        penetration = spring.surface - touch(at.state).gap
        margins = spring.rest_margins(penetration, at.sums(index).tangential)
        return margins[which] / (spring.law.stiffness * duration)

    def spare(at: IntervalResult) -> float:
        """Return the margin of the tangential force to the friction limit, scaled to a velocity."""
        if spring.elastic:
            force = spring.law.tangential_force(gaps.along(pair, at.state), spring.foot)
        elif at.totals:
            force = at.sums(index).tangential
        else:
            return math.nan
        return spring.spare_friction(spring.surface - touch(at.state).gap, force) / (
            spring.law.stiffness * duration
        )

    def left(at: IntervalResult) -> float:
        """Return the time left until the contact is overdue, over its expected duration."""
        since = at.state.time - (contact.start or at.state).time
        return OVERDUE_DURATIONS - since / duration

    # It ends only contacts that follow the impact law, which would not end otherwise.
    if system.follows_law(spring):
        yield Event(left, -1, Kind.OVERDUE, contact, tolerance)
    # This value rises from zero and may fall back at once: only values within the rounding of a
    # place count as zero.
    at_deepest = min(tolerance, PLACE_ROUNDING / duration)
    if spring.at_rest:
        yield Event(slip_at_rest, -1, Kind.FOOT_STOPS, contact, tolerance)
        yield Event(partial(rest_margin, 0), -1, Kind.REST_ENDS, contact, tolerance)
        yield Event(partial(rest_margin, 1), -1, Kind.PRESSED_ON, contact, at_deepest)
        return
    if spring.deepest is None:
        ends = Kind.RELOADING_ENDS if spring.pressed_on else Kind.COMPRESSION_ENDS
        yield Event(closing, -1, ends, contact, tolerance)
    else:
        yield Event(partial(beyond, spring.residual), -1, Kind.UNLOADED, contact, tolerance)
        yield Event(above_deepest, -1, Kind.PRESSED_ON, contact, at_deepest)
    if spring.slip:
        yield Event(slip, -1, Kind.FOOT_STOPS, contact, tolerance)
    elif spring.elastic or spring.compliance_in_stick:
        yield Event(spare, -1, Kind.CONE_REACHED, contact, tolerance)
