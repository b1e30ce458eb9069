"""Events of a run: their kinds, and the functions whose change of sign ends a smooth motion.

Every event has a function of time, its *value*. An event *triggers* in an interval (0, h] of a
smooth motion if its value begins with the sign opposite to ``direction`` and has the sign
``direction`` at a later instant of the interval. The event happens at the first zero of its value
before that later instant. With ``direction`` 0, both changes of sign trigger the event.

At the beginning of a motion, a value that is no larger than its rounding error has no sign. An
event of a kind in :data:`BEGINS_POSITIVE` then begins with a positive sign. Any other event begins
with the first sign that its value has at the end of an interval. Only a pair in contact has an event
for a touch, at a second point; :mod:`bristle_sim.scene.touches` finds the touches of open pairs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum, auto
from functools import lru_cache, partial
from typing import Any, NamedTuple

from bristle_sim.scene.contact import ActiveContact, RigidContacts, sums_of
from bristle_sim.scene.extrapolation import IntervalResult
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.pairs import SAME_GAP, BarPair, ClosestApproach, WirePair
from bristle_sim.scene.spring import SpringContact
from bristle_sim.scene.system import System

# Least compliance of a slipping contact, as a fraction of the compliance of a free link. Below it
# the link jams, because the force that keeps the contact closed grows without bound.
LEAST_COMPLIANCE_IN_SLIP = 1e-3
# The same fraction for a single link, whose motion the geometry alone determines
LEAST_OF_SINGLE_LINK = 1e-6
PLACE_ROUNDING = 4e-16  # rounding error of a tip's position, in engine units
LOCATED_VELOCITY = 0.1
"""Largest value (a velocity) of a contact spring's event at its located instant, as a fraction of
the velocity error permitted in an interval."""

OVERDUE_DURATIONS = 10.0
"""Longest duration of a contact in the rigid-body limit, as a multiple of its expected duration. A
longer contact is pressed on by other forces and is no impact."""

ROUNDED_TOLERANCES = 10.0
"""Largest magnitude of an event's value that counts as a located zero, as a multiple of the
tolerance, if rounding error keeps all iterates outside the tolerance."""


class Kind(StrEnum):
    """The kinds of events; the comment on each kind states its subject."""

    TOUCH = auto()  # pair: its gap closes
    REST = auto()  # pair: its gap closes, and the impact has no restitution
    RELEASE = auto()  # a tuple of contacts: their normal forces fall to zero
    HAND_OVER = auto()  # contact, and the pair of the neighbouring link onto which it slides
    SLIP_STOPS = auto()  # rigid contact: its slip velocity falls to zero
    BREAKS_AWAY = auto()  # rigid contact that sticks: its tangential force exceeds friction
    KINK = auto()  # contact: it passes a joint, a knee or the tip of the wire
    LOCKED = auto()  # rigid contact: no force keeps it closed
    DENT_LEFT = auto()  # index of a pair: the tip leaves the dent of an earlier compliant contact
    COMPRESSION_ENDS = auto()  # contact with a spring: the approach falls to zero
    UNLOADED = auto()  # contact with a spring: its force falls to zero
    # contact with a spring that unloads: the penetration exceeds its earlier maximum
    PRESSED_ON = auto()
    # contact with a spring that slips at constant penetration: friction no longer holds it there
    REST_ENDS = auto()
    # contact with a spring that slips: the attachment of its tangential spring stops sliding
    FOOT_STOPS = auto()
    # contact with a spring that sticks: its tangential force reaches the friction cone
    CONE_REACHED = auto()
    # contact with a spring, of a link that jams: the tangential acceleration that its forces give
    # the contact point is stationary
    BALANCED = auto()
    # contact with a spring in the rigid-body limit: it lasts too long to be an impact
    OVERDUE = auto()
    LARGEST_RETRACTION = auto()  # wire: its first link begins to catch up with the hub
    HIGHEST_RELATIVE_SPEED = auto()  # wire: the angular velocity of its only link is highest
    RETRACTION_LIMIT = auto()  # wire: it lies on the hub


SPRING_KINDS = frozenset(
    {
        Kind.COMPRESSION_ENDS,
        Kind.UNLOADED,
        Kind.PRESSED_ON,
        Kind.REST_ENDS,
        Kind.FOOT_STOPS,
        Kind.CONE_REACHED,
        Kind.BALANCED,
        Kind.OVERDUE,
    }
)
BEGINS_POSITIVE = SPRING_KINDS - {Kind.OVERDUE, Kind.BALANCED} | {
    Kind.LOCKED,
    Kind.RETRACTION_LIMIT,
}
"""Kinds whose value is positive at the beginning of a motion, or rises from zero there. The
decision after the previous event chooses the new motion accordingly."""

TURNS = SPRING_KINDS - {Kind.OVERDUE} | {
    Kind.DENT_LEFT,
    Kind.SLIP_STOPS,
    Kind.BREAKS_AWAY,
    Kind.RETRACTION_LIMIT,
}
"""Kinds whose value may change sign twice within an interval."""

DIFFERENCES = frozenset({Kind.RELEASE, Kind.BREAKS_AWAY})
"""Kinds whose value is a force, with the rounding error of a difference of angular velocities."""


@dataclass(slots=True, eq=False)
class Event:
    """An event that may happen: a function of the motion whose change of sign marks the event.

    Attributes:
        kind: kind of the event.
        subject: contact, pair or wire of the event, as its kind states.
        value: the function; its argument is a result of the integrator, which includes the state.
        direction: -1 if the value falls through zero at the event, +1 if it rises, 0 for both.
        tolerance: magnitude of the value below which the event counts as located; None for the
            run's own tolerance.
        noise: magnitude of the value up to which its sign is unknown. If a tolerance is given, the
            magnitude is the value's rounding error, otherwise the possible error of the run.
        sign: the last sign of the value; None while it is unknown.
        known: the last result for which the value was computed, and the value.
    """

    kind: Kind
    subject: Any
    value: Callable[[IntervalResult], float]
    direction: int = -1
    tolerance: float | None = None
    noise: float = math.ulp(1.0)
    sign: float | None = None
    known: tuple[IntervalResult | None, float] = (None, math.nan)

    def at(self, result: IntervalResult) -> float:
        """Return the event's value for a result of the integrator; the last value is cached."""
        if self.known[0] is not result:
            self.known = (result, self.value(result))
        return self.known[1]

    def begin(self, start: IntervalResult, noise: float) -> None:
        """Set the sign of the value at the start of a smooth motion.

        A change of sign in the first interval then counts as an event.

        Args:
            start: result at the start of the motion.
            noise: magnitude up to which angular velocities and accelerations have no sign.
        """
        if self.tolerance is None:
            self.noise = noise
        least = max(self.noise, ROUNDED_TOLERANCES * (self.tolerance or 0.0))
        if self.kind in BEGINS_POSITIVE and not self.at(start) < -least:  # also where it is NaN
            self.sign = 1.0
        else:
            self.follow(start)

    def follow(self, end: IntervalResult) -> None:
        """Update the sign from the value at an interval's end.

        If the value is too small to have a sign, the last sign remains. If the change of sign would
        be an event, the last sign remains too, so that the event triggers in the next interval.
        """
        value = self.at(end)
        sign = math.copysign(1.0, value) if abs(value) > self.noise else self.sign
        if self.sign in (None, sign) or self.direction == self.sign:
            self.sign = sign


class Happening(NamedTuple):
    """An event that has happened.

    Attributes:
        kind: kind of the event.
        subject: contact, pair or wire of the event, as its kind states.
    """

    kind: Kind
    subject: Any


def contact_events(
    system: System, contacts: Sequence[ActiveContact], rigid: RigidContacts | None
) -> Iterator[Event]:
    """Yield the events that change or end contacts.

    Args:
        system: the run.
        contacts: the active contacts, the rigid ones first.
        rigid: forces of the rigid contacts; None without rigid contacts.
    """
    for index, contact in enumerate(contacts):
        if isinstance(contact, SpringContact):
            yield from _spring_events(system, contact, index)
            continue
        assert rigid is not None
        yield from _rigid_events(system, contact, rigid, index)
        if isinstance(contact.pair, BarPair):
            piece = rigid.closed[index].piece or 0
            yield from _bar_events(system, contact, contact.pair, piece)
        elif isinstance(contact.pair, WirePair):
            yield from _wire_events(system, contact, contact.pair)


def _rigid_events(
    system: System, contact: ActiveContact, rigid: RigidContacts, index: int
) -> Iterator[Event]:
    """Yield the events of a rigid contact: it locks, is released, begins to slip or stops slipping.

    A contact locks when its compliance in slip becomes too small: no force then keeps it closed.
    With friction the link jams; without friction the link meets the obstacle end-on.
    """
    pair = contact.pair
    single = system.mechanism.single_link
    least = LEAST_OF_SINGLE_LINK if single else LEAST_COMPLIANCE_IN_SLIP

    yield Event(Kind.LOCKED, contact, lambda at: rigid.compliance_in_slip(at.state, index) - least)
    yield Event(Kind.RELEASE, (contact,), lambda at: sums_of(at.totals, index).normal)
    if contact.slip == 0:
        yield Event(Kind.BREAKS_AWAY, contact, lambda at: rigid.spare_friction(at.totals, index))
    elif sense := contact.slip:
        yield Event(
            Kind.SLIP_STOPS,
            contact,
            lambda at: sense * system.closest(pair, at.state).velocity[1],
        )


def _bar_events(
    system: System, contact: ActiveContact, pair: BarPair, piece: int
) -> Iterator[Event]:
    """Yield the events at which a contact with the bar leaves the straight segment it touches.

    The contact point slides over a knee, a joint or the tip, or another segment of a bent link
    touches the bar. In the latter case the contact passes to that segment by an impact.

    ``piece`` is the index of the link's straight segment in contact.
    """
    mechanism = system.mechanism
    lower, upper = system.neighbour(pair, -1), system.neighbour(pair, 1)

    def beside(at: IntervalResult) -> float:
        """Return the other segments' gap where that of the contact is closed exactly."""
        state = system.scene.joint_solver.set_back(at.state)
        return pair.gap_beside(mechanism.poses(state)[pair.link], piece)

    def passed(end: int, at: IntervalResult) -> float:
        return pair.ends_passed(mechanism.poses(at.state)[pair.link])[end]

    def after(following: BarPair, at: IntervalResult) -> float:
        pose = mechanism.poses(at.state)[following.link]
        return min(passed(-1, at), following.ends_passed(pose)[0])

    ends = 2 * len(mechanism.links[pair.link].corners) - 2
    for end in range(1, ends):
        yield Event(Kind.KINK, contact, partial(passed, end), 0)
    if ends > 2:
        yield Event(Kind.TOUCH, pair, beside, tolerance=0.1 * SAME_GAP)
    if lower is not None:
        yield Event(Kind.HAND_OVER, (contact, lower), partial(passed, 0))
    if upper is not None:
        yield Event(Kind.HAND_OVER, (contact, upper), partial(after, upper), 1)


def _wire_events(system: System, contact: ActiveContact, pair: WirePair) -> Iterator[Event]:
    """Yield the events at which a corner slides over an end of the other wire's segment.

    Where two corners touch, the pair whose corner slides onto its segment takes over the contact.
    """

    def beyond(other: Any, at: IntervalResult) -> Any:
        return abs(other.foot(system.mechanism.poses(at.state)) - 0.5) - 0.5

    yield Event(Kind.KINK, contact, partial(beyond, pair), 0)
    for other in system.pairs:
        if other is not pair and system.coincide(pair, [other], system.state):
            yield Event(Kind.HAND_OVER, (contact, other), partial(beyond, other), sign=1.0)


def _spring_events(system: System, spring: SpringContact, index: int) -> Iterator[Event]:
    """Yield the events that change the phase of a contact with a spring.

    The spring changes between loading, unloading and rest. The contact point changes between slip
    and stick. The value of each event except ``Kind.OVERDUE`` is a velocity. A penetration d is
    converted to the velocity d/T, a force F to F/(k T), with the contact's duration T and its
    normal stiffness k.
    """
    pair = spring.pair
    duration = spring.duration
    tolerance = max(LOCATED_VELOCITY * spring.stepper.noise, math.ulp(1.0))

    @lru_cache(maxsize=8)
    def touch(state: State) -> ClosestApproach:
        return system.closest(pair, state)

    def slip(at: IntervalResult) -> float:
        return spring.slip * spring.law.foot_velocity(touch(at.state).velocity, spring.slip)

    def depth(at: IntervalResult) -> float:
        return spring.surface - touch(at.state).gap

    def rest_margin(which: int, at: IntervalResult) -> float:
        """Return entry ``which`` (0 or 1) of ``SpringContact.rest_margins``, as a velocity."""
        margins = spring.rest_margins(depth(at), sums_of(at.totals, index).tangential)
        return margins[which] / (spring.law.stiffness * duration)

    def spare(at: IntervalResult) -> float:
        """Return the friction limit minus the tangential force's magnitude, as a velocity."""
        force = sums_of(at.totals, index).tangential
        if spring.elastic:
            force = spring.law.tangential_force(system.along(pair, at.state), spring.foot)
        return spring.spare_friction(depth(at), force) / (spring.law.stiffness * duration)

    falls = partial(Event, subject=spring, tolerance=tolerance)
    # A contact in the rigid-body limit that other forces press on would not end without this event.
    if system.follows_law:
        end = spring.start.time + OVERDUE_DURATIONS * duration
        yield falls(Kind.OVERDUE, value=lambda at: (end - at.state.time) / duration)
    # The depth below the earlier maximum rises from zero and may fall back at once: only values
    # within the rounding error of a position count as zero.
    at_deepest = min(tolerance, PLACE_ROUNDING / duration)
    if spring.at_rest:
        yield falls(Kind.FOOT_STOPS, value=lambda at: slip(at) - spring.least_slip_at_rest)
        yield falls(Kind.REST_ENDS, value=partial(rest_margin, 0))
        yield falls(Kind.PRESSED_ON, value=partial(rest_margin, 1), tolerance=at_deepest)
        return
    deepest = spring.law.deepest
    if deepest is None:
        yield falls(Kind.COMPRESSION_ENDS, value=lambda at: -touch(at.state).velocity[0])
    else:
        yield falls(Kind.UNLOADED, value=lambda at: (depth(at) - spring.law.residual) / duration)
        yield falls(
            Kind.PRESSED_ON,
            value=lambda at: (deepest - depth(at)) / duration,
            tolerance=at_deepest,
        )
    if spring.slip:
        yield falls(Kind.FOOT_STOPS, value=slip)
    elif spring.elastic or spring.compliance_in_stick:
        yield falls(Kind.CONE_REACHED, value=spare)
        if spring.elastic and spring.jams:
            yield falls(
                Kind.BALANCED,
                value=lambda at: spring.off_balance(touch(at.state).velocity),
                direction=0,
            )
