"""Events that end an interval of smooth motion: the touch of an obstacle, or a change of a
sustained contact."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from scipy.optimize import newton

from bristle_sim.reference.contacts import Bar, Point, Spring, Workpart, follows
from bristle_sim.reference.decisions import (
    change_phase,
    close_contact,
    decide,
    end_compliant_contact,
    end_compression,
    move_contact,
)
from bristle_sim.reference.forces import normal_response
from bristle_sim.reference.log import Finished, Log, Record
from bristle_sim.reference.system import Instant, State, Sustained, System
from bristle_sim.settings import StopReason

Value = Callable[[Instant], float]
Follow = Callable[
    [State], State
]  # consequence of an event: function of the state before it that returns the state after it
# Overlap at a located touch, over hub radius plus length: 100 times the rounding error of a gap.
INSIDE = 1e-13
# Distance by which a contact must pass a corner, over the wire's length, so that rounding error
# does not move it back.
PAST = 1e-13
ROUNDING = 1e-13  # rounding error of an event function, as a fraction of its size
GAP_ROUNDING = 1e-15  # rounding error of a gap, over hub radius plus length

LOCKED = 1e-6
"""Normal acceleration per unit normal force with friction, over its value without friction, below
which friction is about to lock a contact.

The contact force grows without bound as this ratio falls to zero."""


class Event(NamedTuple):
    """An event that ends an interval of smooth motion: a function of the state changes its sign.

    Attributes:
        value: the function.
        direction: sign of the function after the event.
        resolution: magnitude below which the function is rounding error.
        follow: function that applies the consequence of the event to the state.
        place: obstacle and piece whose gap the function is, or None. A gap is not evaluated while
            it is far from closing.
    """

    value: Value
    direction: int
    resolution: float
    follow: Follow
    place: tuple[str, int] | None = None


def events_of(system: System, log: Log, state: State) -> list[Event]:
    """Return the events that can end the interval that begins at a state."""

    def upright(own: Record, instant: Instant) -> float:
        return (0.5 * math.pi) ** 2 - own.relative(instant.state) ** 2

    def lies_down(own: Record, state: State) -> State:
        """End the run where a wire leans over by 90 degrees and meets the hub."""
        own.event("retraction limit", state.time)
        raise Finished(StopReason.RETRACTION_LIMIT, state)

    found = _touch_events(system, log, state)
    found += [
        Event(partial(upright, own), -1, ROUNDING, partial(lies_down, own)) for own in log.records
    ]
    for number, each in enumerate(system.sustained):
        if each.spring is None:
            found += _force_events(system, log, number)
        else:
            found += _spring_events(system, log, each, each.spring)
        found += _friction_events(system, log, state, number)
        if isinstance(system.obstacles[each.point.obstacle], Bar):
            found += _place_events(system, state, each)
    return found


def _touch_events(system: System, log: Log, state: State) -> list[Event]:
    """Return the events at which a wire touches an obstacle or leaves the dent of a contact."""
    inside = INSIDE * system.size
    found = []

    def gap(name: str, piece: int, level: float, instant: Instant) -> float:
        return float(instant.gaps(name)[piece]) - level

    for name in system.obstacles:
        for piece, now in enumerate(system.at(state).gaps(name).tolist()):
            if _shadowed(system, name, piece):
                continue
            place = (name, piece)
            value = partial(gap, name, piece, min(now, 0.0) - inside)
            found.append(
                Event(
                    value, -1, 0.1 * inside, partial(close_contact, system, log, name, piece), place
                )
            )
            if now < -10.0 * inside and name == "workpart" and system.stiffness:
                found.append(Event(partial(gap, name, piece, 0.0), 1, inside, lambda at: at, place))
    return found


def _shadowed(system: System, obstacle: str, piece: int) -> bool:
    """Return whether a straight piece is in contact already where it could touch an obstacle."""
    points = [each.point for each in system.sustained if each.point.obstacle == obstacle]
    if isinstance(system.obstacles[obstacle], Workpart):
        return any(point.piece == system.chain.corners[piece] for point in points)
    before = piece - 1 if follows(system.chain, piece) else None
    return any(point.piece == piece or (point.corner and point.piece == before) for point in points)


def _force_events(system: System, log: Log, number: int) -> list[Event]:
    """Return the events of a rigid sustained contact's force.

    The normal force falls to zero, or friction locks the contact. ``number`` is the index of the
    contact.
    """
    acceleration = ROUNDING * system.size * system.fastest**2

    def pressing(at: Instant) -> float:
        """Return the normal acceleration that the normal force causes, m/s^2.

        It has the sign of the normal force, and stays bounded where friction locks the contact.
        """
        acting = at.contacts[number]
        response = normal_response(at.mass, acting.touch, 0.0 if acting.sticks else acting.ratio)
        # Beyond zero by rounding, so that the decision that follows finds the contact open.
        return float(at.balance.normal[number]) * response + acceleration

    def free(at: Instant) -> float:
        """Return the normal acceleration per unit force, with friction over without friction."""
        touch = at.contacts[number].touch
        ratio = at.contacts[number].ratio
        return normal_response(at.mass, touch, ratio) / normal_response(at.mass, touch, 0.0)

    def lock(state: State) -> State:
        """Find the time at which friction locks the contact, and end the run at that time."""

        def ahead(time: float) -> State:
            return State(state.time + time, state.angles + time * state.rates, state.rates)

        scale = LOCKED / system.fastest
        time = float(
            newton(
                lambda time: free(system.at(ahead(time))),
                0.0,
                x1=scale,
                tol=1e-6 * scale,
                disp=False,
            )
        )
        raise log.jam(ahead(time) if 0.0 <= time <= 1e3 * scale else state)

    found = [Event(pressing, -1, acceleration, partial(decide, system, log))]
    if system.sustained[number].slip and system.friction(system.sustained[number].point):
        found.append(Event(lambda at: free(at) - LOCKED, -1, 1e-3 * LOCKED, lock))
    return found


def _spring_events(system: System, log: Log, each: Sustained, spring: Spring) -> list[Event]:
    """Return the events of a compliant contact's normal spring.

    In loading, compression ends. In unloading, the force falls to zero or the spring loads again.
    """
    speed = ROUNDING * system.size * system.fastest
    depth = max(ROUNDING * spring.deepest, GAP_ROUNDING * system.size)

    def opening(instant: Instant) -> float:
        return instant.touch(each.point).velocity[0]

    def above(level: float, instant: Instant) -> float:
        return spring.surface - instant.touch(each.point).gap - level

    def reload(state: State) -> State:
        change_phase(system, each, spring, state)
        return decide(system, log, state)

    if spring.loading:
        return [Event(opening, 1, speed, partial(end_compression, system, log, each, spring))]
    # The margin exceeds the rounding of a gap; otherwise the contact would unload and load at one
    # instant.
    deeper = partial(above, spring.deepest + ROUNDING * system.size)
    return [
        Event(
            partial(above, spring.left),
            -1,
            depth,
            partial(end_compliant_contact, system, log, each),
        ),
        Event(deeper, 1, depth, reload),
    ]


def _friction_events(system: System, log: Log, state: State, number: int) -> list[Event]:
    """Return the event at which the slip of a sustained contact stops or, in stick, begins.

    ``number`` is the index of the contact. Without friction there is no event.
    """
    each = system.sustained[number]
    go_on = partial(decide, system, log)
    mu = system.friction(each.point, each.spring)
    slip = each.slip
    speed = system.size * system.fastest
    force = ROUNDING * system.size * system.fastest**2 * system.chain.masses.sum()
    if each.spring is not None:
        law = each.spring.law
        steepest = law.stiffness / min(1.0, law.restitution**2 or 1.0, law.compliance or 1.0)
        force += steepest * GAP_ROUNDING * system.size

    def sliding(at: Instant) -> float:
        touch = at.contacts[number].touch
        return each.spring.foot(touch, slip) if each.spring else slip * touch.velocity[1]

    def cone(at: Instant) -> float:
        return float(mu * at.balance.normal[number] - abs(at.balance.tangential[number]))

    def beyond(value: Value, rounding: float) -> Value:
        """Return a function shifted so that it begins above zero by its rounding error or more."""
        level = min(value(system.at(state)), 0.0) - rounding
        return lambda at: value(at) - level

    if not mu:
        return []
    if slip:  # slip after stick starts from a velocity that is rounding, of either sign
        return [Event(beyond(sliding, 1e-3 * system.still(state)), -1, ROUNDING * speed, go_on)]
    return [Event(beyond(cone, force) if each.spring else cone, -1, force, go_on)]


def _place_events(system: System, state: State, each: Sustained) -> list[Event]:
    """Return the events at which a contact with the bar passes from flank to corner or back."""
    (name, index, corner), feet = each.point, system.at(state).feet
    length = float(system.chain.pieces.lengths[index])
    past = PAST * system.chain.length

    def event(piece: int, end: float, direction: int, point: Point) -> Event:
        """Return the event at which the contact passes an end of a straight piece.

        ``end`` is the distance of this end from the piece's start, m. ``direction`` is 1 or -1
        along the piece. ``point`` is the location of the contact after the event.
        """
        # A contact beyond the end by rounding passes it only when it has moved on by the margin.
        level = direction * (max(direction * end, direction * float(feet[piece])) + past)
        foot = lambda instant: float(instant.feet[piece]) - level  # noqa: E731
        return Event(
            foot,
            direction,
            ROUNDING * system.chain.length,
            partial(move_contact, system, each, point),
        )

    if corner:
        passes = [
            (index, length, -1, Point(name, index, False)),
            (index + 1, 0.0, 1, Point(name, index + 1, False)),
        ]
    else:
        passes = [
            (index, length, 1, Point(name, index, True)),
            (index, 0.0, -1, Point(name, index - 1, True)),
        ]
    # Nothing precedes a wire's root or follows its tip.
    return [event(*each) for each in passes[: 2 if follows(system.chain, index + corner) else 1]]
