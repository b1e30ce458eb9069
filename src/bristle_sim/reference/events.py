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
INSIDE = 1e-13  # overlap at a located touch, over hub radius plus length: 100 roundings of a gap
# distance of a contact beyond a passed corner, over the length, against its return by rounding
PAST = 1e-13
ROUNDING = 1e-13  # rounding of an event function, as a fraction of its size
GAP_ROUNDING = 1e-15  # rounding of a gap, over hub radius plus length

LOCKED = 1e-6
"""Response to a normal force with friction, over that without, at which friction is about to lock a
contact.

The force then grows without bound."""


class Event(NamedTuple):
    """A function of an instant whose change of sign in one direction ends an interval.

    Attributes:
        value: the function.
        direction: sign of the function after the event.
        resolution: magnitude below which the function is rounding.
        follow: consequence of the event.
        place: obstacle and piece of a gap. A gap is not evaluated while it is far from closing.
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
    """Return the events at which a piece touches an obstacle, or leaves the dent of an earlier
    compliant contact.
    """
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
            if now < -10.0 * inside and name == "workpart" and system.stiffnesses:
                found.append(Event(partial(gap, name, piece, 0.0), 1, inside, lambda at: at, place))
    return found


def _shadowed(system: System, obstacle: str, piece: int) -> bool:
    """Return whether the nearest point of a piece, or its corner, is in contact already."""
    points = [each.point for each in system.sustained if each.point.obstacle == obstacle]
    if isinstance(system.obstacles[obstacle], Workpart):
        return any(point.piece == system.chain.corners[piece] for point in points)
    before = piece - 1 if follows(system.chain, piece) else None
    return any(point.piece == piece or (point.corner and point.piece == before) for point in points)


def _force_events(system: System, log: Log, number: int) -> list[Event]:
    """Return the events of a rigid sustained contact: its force falls to zero, or friction locks
    it.
    """
    acceleration = ROUNDING * system.size * system.fastest**2

    def pressing(at: Instant) -> float:
        """Return the normal force times the contact's normal response to it, m/s^2.

        The product stays bounded where friction locks the contact.
        """
        acting = at.contacts[number]
        response = normal_response(at.mass, acting.touch, 0.0 if acting.sticks else acting.ratio)
        # Beyond zero by rounding, so that the decision that follows finds the contact open.
        return float(at.balance.normal[number]) * response + acceleration

    def free(at: Instant) -> float:
        """Return the response to a normal force with friction over the response without
        friction."""
        touch = at.contacts[number].touch
        ratio = at.contacts[number].ratio
        return normal_response(at.mass, touch, ratio) / normal_response(at.mass, touch, 0.0)

    def lock(state: State) -> State:
        """Follow the motion to the instant at which friction locks the contact, and end the run there."""

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
    """Return the events of a spring: the end of compression, of the force in unloading, or of
    unloading itself.
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
    """Return the events at which the slip of a sustained contact stops or begins."""
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
        """Return a function minus its rounding and minus its initial value if that is negative."""
        level = min(value(system.at(state)), 0.0) - rounding
        return lambda at: value(at) - level

    if not mu:
        return []
    if slip:  # slip after stick starts from a velocity that is rounding, of either sign
        return [Event(beyond(sliding, 1e-3 * system.still(state)), -1, ROUNDING * speed, go_on)]
    return [Event(beyond(cone, force) if each.spring else cone, -1, force, go_on)]


def _place_events(system: System, state: State, each: Sustained) -> list[Event]:
    """Return the events at which a contact with the bar passes from a flank to a corner or back."""
    (name, index, corner), feet = each.point, system.at(state).feet
    length = float(system.chain.pieces.lengths[index])
    past = PAST * system.chain.length

    def event(piece: int, end: float, direction: int, point: Point) -> Event:
        """Return the event at which the foot of the bar's centre on a piece passes an end of the
        piece.
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
