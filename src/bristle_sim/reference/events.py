"""Events that end an interval of smooth motion: an extreme of a wire's angle or angular velocity
relative to the hub, the touch of an obstacle, or a change of a sustained contact."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from bristle_sim.reference.contacts import Point, follows
from bristle_sim.reference.decisions import (
    change_phase,
    close_contact,
    decide,
    end_compliant_contact,
    end_compression,
    stop_foot,
)
from bristle_sim.reference.forces import Compliant, State, Sustained, normal_response
from bristle_sim.reference.log import Finished, Record
from bristle_sim.reference.system import Instant, System
from bristle_sim.settings import LARGEST_RETRACTION, StopReason

Value = Callable[[Instant], Any]
Follow = Callable[
    [State], State
]  # consequence of an event: function of the state before it that returns the state after it
# Overlap at which a touch is located, as a fraction of hub radius plus wire length: 100 times the
# rounding error of a gap.
INSIDE = 1e-13
# Distance by which a contact must pass a corner, as a fraction of the wire's length. A shorter
# distance would let rounding error move the contact back.
PAST = 1e-13
ROUNDING = 1e-13  # rounding error of an event function, as a fraction of its size
GAP_ROUNDING = 1e-15  # rounding error of a gap, as a fraction of hub radius plus wire length
# Least maximum of the angular velocity relative to the hub that counts as an event, as a multiple
# of the rounding error of an angular velocity.
IDLE = 10.0
PEAK = "highest relative speed"

LOCKED = 1e-6
"""Ratio of the normal accelerations per unit normal force with and without friction, below which
friction is about to lock a contact.

The contact force grows without bound as this ratio falls to zero. From this value on, the ratio
falls to zero in so short a time that it is linear in time with an error of 1e-12."""


class Event(NamedTuple):
    """An event that ends an interval of smooth motion: a change of sign of an event function.

    Attributes:
        value: event function, a function of the state at one instant or at n instants.
        direction: sign of the event function after the event.
        resolution: magnitude below which a value of the event function is rounding error.
        follow: function that applies the consequence of the event to the state.
        extreme: whether the event is an extreme of a quantity, so that the event function is the
            quantity's rate of change. This rate may have either sign at the start of the interval.
            Any other event occurs at once if its event function already has the sign ``direction``
            at the start.
    """

    value: Value
    direction: int
    resolution: float
    follow: Follow
    extreme: bool = False

    def ahead(self, instant: Instant, zero: float = 0.0) -> Event:
        """Return the event with another level, so that it cannot occur at the interval's start.

        The event occurs when the event function passes the level in the event's direction. The
        level is ``zero``, or the function's value at the start (``instant``) if that is already
        beyond ``zero``. In either case the level is moved on by the event's resolution.
        """
        value = self.value
        passed = max(self.direction * (value(instant) - zero), 0.0)
        level = zero + self.direction * (passed + self.resolution)
        return self._replace(value=lambda at: value(at) - level)


def events_of(system: System, state: State) -> list[Event]:
    """Return all events that could end the interval of smooth motion that starts at a state."""
    instant = system.at(state)
    found = _touch_events(system, instant)
    for own in system.log.records:
        found += _wire_events(system, instant, own)
    for number, each in enumerate(system.sustained):
        if isinstance(each, Compliant):
            found += _spring_events(system, instant, each)
        else:
            found += _force_events(system, instant, number)
        if each.friction:
            found.append(_friction_event(system, instant, number))
        if each.point.obstacle == "bar":
            found += _place_events(system, instant, each)
    return found


def _wire_events(system: System, instant: Instant, own: Record) -> list[Event]:
    """Return the events of a wire's motion relative to the hub.

    They are the largest retraction, the highest relative angular velocity, and a retraction of 90
    degrees. The highest angular velocity is an event only for a wire of one link. In a chain the
    angular velocity of the first link has several maxima, because the hinges vibrate.
    """
    link = own.links.start
    rounding = system.rate_rounding(instant.state)

    def rate(at: Instant) -> Any:
        """Return the angular velocity of the wire's first link relative to the hub, rad/s."""
        return at.state.rates[..., link] - system.chain.speed

    def acceleration(at: Instant) -> Any:
        """Return the angular acceleration of the wire's first link, rad/s^2."""
        return at.balance.accelerations[..., link]

    def upright(at: Instant) -> Any:
        """Return (pi/2)^2 minus the square of the angle from the radial direction, rad^2."""
        return (0.5 * math.pi) ** 2 - own.relative(at.state) ** 2

    def extreme(name: str, state: State) -> State:
        """Record an extreme of the motion relative to the hub, unless it is a speed as small as
        rounding error.
        """
        if name == LARGEST_RETRACTION or rate(system.at(state)) > IDLE * rounding:
            own.event(name, state.time)
            system.check_stop(state)
        return state

    def lies_down(state: State) -> State:
        """End the run, because a wire has leaned over by 90 degrees and meets the hub."""
        own.event("retraction limit", state.time)
        raise Finished(StopReason.RETRACTION_LIMIT, state)

    found = [
        Event(upright, -1, ROUNDING, lies_down),
        Event(rate, 1, rounding, partial(extreme, LARGEST_RETRACTION), extreme=True),
    ]
    touched = any(each.touch.rows[0, link] for each in instant.contacts)
    if own.chain.links == 1 and not touched:
        resolution = rounding * system.fastest
        found.append(Event(acceleration, -1, resolution, partial(extreme, PEAK), extreme=True))
    return found


def _touch_events(system: System, instant: Instant) -> list[Event]:
    """Return the events at which a wire touches an obstacle or rises out of a dent.

    A dent is the indentation that an earlier compliant contact has left in the workpart.
    """
    inside = INSIDE * system.size
    found = []

    def gap(name: str, piece: int, at: Instant) -> Any:
        """Return the gap between an obstacle and a straight piece, m."""
        return at.gaps(name)[..., piece]

    def leave_dent(piece: int, state: State) -> State:
        """Discard the dent, because the corner of a wire has risen to the original surface."""
        del system.dents[piece]
        return state

    for name in system.obstacles:
        dents = system.dents if name == "workpart" else {}
        for piece in np.flatnonzero(np.isfinite(instant.gaps(name))).tolist():
            if _shadowed(system, name, piece):
                continue
            own = partial(gap, name, piece)
            touch = Event(own, -1, inside, partial(close_contact, system, name, piece))
            found.append(touch.ahead(instant, dents.get(piece, 0.0)))
            if piece in dents:
                found.append(Event(own, 1, inside, partial(leave_dent, piece)))
    return found


def _shadowed(system: System, obstacle: str, piece: int) -> bool:
    """Return whether a straight piece already touches an obstacle, so that no touch can occur.

    A contact of the bar at the end of the preceding piece counts as a contact of this piece too.
    """
    before = piece - 1 if obstacle == "bar" and follows(system.chain, piece) else None
    points = [each.point for each in system.sustained if each.point.obstacle == obstacle]
    return any(point.piece == piece or (point.corner and point.piece == before) for point in points)


def _force_events(system: System, instant: Instant, number: int) -> list[Event]:
    """Return the events of the force of a rigid sustained contact.

    The contact opens where the normal force falls to zero. If the contact slips, friction can also
    lock it. ``number`` is the index of the contact.
    """
    acceleration = ROUNDING * system.size * system.fastest**2
    acting = instant.contacts[number]

    def pressing(at: Instant) -> Any:
        """Return the normal acceleration that the contact force causes at the contact, m/s^2.

        It has the sign of the normal force. Unlike the force, it stays bounded where friction locks
        the contact.
        """
        touch = at.contacts[number].touch
        ratio = 0.0 if acting.sticks else acting.ratio
        return at.balance.pushes[..., number, 0] * normal_response(at.mass, touch, ratio)

    def freedom(at: Instant) -> Any:
        """Return the normal acceleration per unit normal force, over its value without friction."""
        touch = at.contacts[number].touch
        with_friction = normal_response(at.mass, touch, acting.ratio)
        return with_friction / normal_response(at.mass, touch, 0.0)

    def lock(state: State) -> State:
        """End the run at the instant at which friction locks the contact.

        The instant is extrapolated linearly from the present state.
        """

        def ahead(time: float) -> State:
            """Return the state extrapolated linearly by a time in s."""
            return State(state.time + time, state.angles + time * state.rates, state.rates)

        step = LOCKED / system.fastest
        first, second = (freedom(system.at(ahead(time))) for time in (0.0, step))
        raise system.log.jam(ahead(step * first / (first - second)) if second < first else state)

    # Located beyond zero by rounding error, so that the contact is open at the event.
    found = [Event(pressing, -1, acceleration, partial(decide, system)).ahead(instant)]
    if acting.slip and acting.friction:
        found.append(Event(lambda at: freedom(at) - LOCKED, -1, ROUNDING, lock))
    return found


def _spring_events(system: System, instant: Instant, each: Compliant) -> list[Event]:
    """Return the events of the normal spring of a compliant contact.

    A spring in loading has one event, the end of compression. A spring in unloading has two: its
    force falls to zero, or it is loaded beyond the deepest penetration.
    """
    speed = ROUNDING * system.size * system.fastest
    # This exceeds the rounding of a gap; otherwise the contact would unload and load at one instant.
    deeper = ROUNDING * system.size

    def opening(at: Instant) -> Any:
        """Return the normal velocity of the contact, m/s."""
        return at.touch(each.point).velocity[..., 0]

    def excess(depth: float, at: Instant) -> Any:
        """Return the penetration minus ``depth``, m."""
        return each.level - at.touch(each.point).gap - depth

    deepest = each.law.deepest
    if deepest is None:
        return [Event(opening, 1, speed, partial(end_compression, system, each))]
    depth = max(ROUNDING * deepest, GAP_ROUNDING * system.size)
    residual = partial(excess, each.law.residual)
    follow = partial(change_phase, system, each, None)
    loads = Event(partial(excess, deepest), 1, deeper, follow)
    return [
        Event(residual, -1, depth, partial(end_compliant_contact, system, each)),
        loads.ahead(instant),
    ]


def _friction_event(system: System, instant: Instant, number: int) -> Event:
    """Return the event at which a sustained contact changes from slip to stick or back.

    ``number`` is the index of the contact.
    """
    each = system.sustained[number]
    force = ROUNDING * system.size * system.fastest**2 * system.chain.masses.sum()
    if isinstance(each, Compliant):
        force += each.steepest * GAP_ROUNDING * system.size
    # The contact may change during an event, but the slip of the interval is that at its start.
    slip = each.slip

    def sliding(at: Instant) -> Any:
        """Return the slip velocity (m/s), positive in the sense of ``slip``.

        With a tangential spring it is the velocity of the spring's foot.
        """
        touch = at.contacts[number].touch
        if isinstance(each, Compliant):
            return each.foot(touch, slip)
        return slip * touch.velocity[..., 1]

    def cone(at: Instant) -> Any:
        """Return the largest friction force minus the present friction force, N."""
        normal, tangential = at.balance.pushes[..., number, :].T
        return each.friction * normal - np.abs(tangential)

    event = Event(cone, -1, force, partial(decide, system))
    if slip:  # slip after stick starts from a velocity that is rounding, of either sign
        event = event._replace(value=sliding, resolution=system.slip_rounding(instant.state))
        if isinstance(each, Compliant) and each.law.compliance:
            event = event._replace(follow=partial(stop_foot, system, each))
    return event.ahead(instant)


def _place_events(system: System, instant: Instant, each: Sustained) -> list[Event]:
    """Return the events at which a contact with the bar passes from a flank to a corner or back."""
    name, index, corner = each.point
    length = float(system.chain.pieces.lengths[index])
    past = PAST * system.chain.length

    def foot(piece: int, at: Instant) -> Any:
        """Return the coordinate of the bar's centre along a straight piece, m."""
        return at.feet[..., piece]

    def move(point: Point, state: State) -> State:
        """Let the contact act at another point of the wire, and return the state."""
        # Decide anew: the curvature of the path jumps, and the force with it.
        each.point = point
        return decide(system, system.closed(state))

    # For each change: the piece; the distance from its start to the end at which the contact changes;
    # the direction of the contact along the piece; and the point of the contact after the event.
    if corner:
        passages = [
            (index, length, -1, Point(name, index, False)),
            (index + 1, 0.0, 1, Point(name, index + 1, False)),
        ]
    else:
        passages = [
            (index, length, 1, Point(name, index, True)),
            (index, 0.0, -1, Point(name, index - 1, True)),
        ]
    if not follows(system.chain, index + corner):  # nothing precedes a root or follows a tip
        passages.pop()
    return [
        Event(partial(foot, piece), direction, past, partial(move, point)).ahead(instant, end)
        for piece, end, direction, point in passages
    ]
