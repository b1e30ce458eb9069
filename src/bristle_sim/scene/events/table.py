"""The table of events: every function that can end an interval of smooth motion, but for the gaps to what may be touched."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from bristle_sim.scene.contact.gaps import neighbour
from bristle_sim.scene.contact.obstacles import BarObstacle, ClosestApproach, Obstacle, dented
from bristle_sim.scene.contact.rigid import TOTALS, RigidContacts
from bristle_sim.scene.contact.spring import Spring
from bristle_sim.scene.contact.sustained import Sustained
from bristle_sim.scene.events.functions import (
    Change,
    EventFunction,
    HandOver,
    Kink,
    Release,
    Slip,
    SpringChange,
    SpringEvent,
    Touch,
)
from bristle_sim.scene.events.locate import turns
from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.integrate.time_scales import acceleration
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.stop_reason import LARGEST_RETRACTION, StopReason

if TYPE_CHECKING:
    from bristle_sim.scene.build import Scene
    from bristle_sim.scene.contact.gaps import Gaps
    from bristle_sim.scene.progress import Progress

LEAST_GRIP = 1e-3
"""With less, the force that keeps a contact closed grows beyond bounds: a jam."""

LOCATED_VELOCITY = 0.1
"""Fraction of an interval's error in velocity to which the events of a spring are located."""


def motion_events(progress: Progress, sustained: Sequence[Sustained]) -> list[EventFunction]:
    """Return the events of the motion as a whole: extremes, kinks of sustained contact, limits."""
    found = [] if progress.plan.single_contact else retraction(progress.mechanism)
    if not progress.plan.single_contact and not sustained:
        found += highest_speed(progress.scene)
    found += [each for contact in sustained if contact.spring is None for each in _kinks(progress, contact)]
    if math.isfinite(progress.plan.retraction_limit):
        found += retraction_limit(progress)
    return found + [_out_of_dent(progress, number) for number in progress.dents()]


def contact_events(
    progress: Progress, contacts: Sequence[Sustained], rigid: RigidContacts | None
) -> list[EventFunction]:
    """Return the events that change or end contacts: the rigid ones', in the order of ``rigid``, and those of springs."""
    found: list[EventFunction] = []
    ordered = [each for each in contacts if each.spring is None]
    for index, contact in enumerate(ordered):
        assert rigid is not None
        obstacle = contact.obstacle
        found += [_locking(rigid, progress.gaps, index), _parting(rigid, index)]
        if obstacle.corner is None and progress.mechanism.links[obstacle.link].knees:
            found += _elbow(progress, rigid, index)
        found += _hand_overs(progress, obstacle)
        if rigid.slips[index] == 0:
            found.append(_sticking(rigid, index, contact))
    springs = [(contact, contact.spring) for contact in contacts if contact.spring is not None]
    for number, (contact, spring) in enumerate(springs):
        found += _spring_events(progress, contact, spring, TOTALS * len(ordered) + 6 * number)
    return found


def retraction(mechanism: Mechanism) -> list[EventFunction]:
    """Return the event functions of each wire's turns relative to the hub."""

    def relative_rate(link: int, at: Advance) -> float:
        return at.state.rates[link] - mechanism.hub_speed

    event, size = LARGEST_RETRACTION, mechanism.wire_links
    return [
        EventFunction(f"{event} of wire {wire}", partial(relative_rate, wire * size), False, event, wire=wire)
        for wire in range(mechanism.wires)
    ]


def highest_speed(scene: Scene) -> list[EventFunction]:
    """Return the event functions of each rigid wire's highest relative speed; a wire of several links vibrates."""
    event = "highest relative speed"

    def value(link: int, at: Advance) -> float:
        return at.accelerations[link]

    return [
        EventFunction(
            f"{event} of wire {wire}",
            partial(value, wire),
            True,
            event,
            exact=partial(acceleration, scene, link=wire),
            wire=wire,
            difference=True,
        )
        for wire in range(scene.mechanism.wires)
        if scene.mechanism.wire_links == 1
    ]


def retraction_limit(progress: Progress) -> list[EventFunction]:
    """Return the event functions of the retraction limit, which a wire reaches within an interval or at its end."""
    mechanism, limit = progress.mechanism, progress.plan.retraction_limit

    def left(link: int, at: Advance) -> float:
        states = (at.state, *turns(mechanism, progress.state, at.state, link))
        return limit - max(abs(each.angles[link] - mechanism.root_angle(link, each.time)) for each in states)

    name, size, final = "retraction limit", mechanism.wire_links, StopReason.RETRACTION_LIMIT
    return [
        EventFunction(f"{name} of wire {wire}", partial(left, wire * size), True, name, final, wire=wire)
        for wire in range(mechanism.wires)
    ]


def _out_of_dent(progress: Progress, number: int) -> EventFunction:
    """A tip comes out of the dent that a contact resolved in time has left it in."""
    outside = dented(progress.obstacles[number], 0.0)

    def gap(at: Advance) -> float:
        return progress.gaps.gap(outside, at.state)

    return EventFunction(f"dent {number}", gap, falling=False, act=lambda: progress.leave_dent(number))


def _kinks(progress: Progress, contact: Sustained) -> list[EventFunction]:
    """A sustained contact passes a corner, or its slip turns."""
    obstacle, gaps, mechanism = contact.obstacle, progress.gaps, progress.mechanism

    def kink(index: int, at: Advance) -> float:
        return gaps.closest(obstacle, at.state).kinks[index]

    def slip(sense: int, at: Advance) -> float:
        return sense * gaps.closest(obstacle, at.state).velocity[1]

    where = _label(obstacle)
    functions = [
        EventFunction(f"corner {index} of {where}", partial(kink, index), act=Kink)
        for index in range(len(gaps.closest(obstacle, progress.state).kinks))
    ]
    if obstacle.friction and contact.slip is None:
        functions.append(EventFunction(f"slip of {where}", partial(slip, 1), act=Kink))
    elif contact.slip:
        # Geometry and hub alone tell how a lone link slips: it turns back where several may stick.
        following = partial(Slip, contact, -contact.slip if mechanism.lone else 0)
        functions.append(EventFunction(f"slip of {where}", partial(slip, contact.slip), True, act=following))
    return functions


def _locking(rigid: RigidContacts, gaps: Gaps, index: int) -> EventFunction:
    """The grip gets too small: friction locks the link, or without it the link meets the obstacle end-on."""
    obstacle = rigid.obstacles[index]
    jams = obstacle.friction > 0.0
    final = StopReason.JAM if jams else StopReason.NO_GRIP

    def spare(at: Advance) -> float:
        return rigid.grip(gaps, at.state, index) - LEAST_GRIP

    wire = obstacle.link % len(gaps.mechanism.links) // gaps.mechanism.wire_links
    event = "jam" if jams else None
    return EventFunction(f"locking of {_label(obstacle)}", spare, True, event, final=final, wire=wire)


def _elbow(progress: Progress, rigid: RigidContacts, index: int) -> list[EventFunction]:
    """Another piece of a bent link meets the bar that this one is on: it takes over by an impact."""
    obstacle, gaps = rigid.obstacles[index], progress.gaps
    if not isinstance(obstacle, BarObstacle):
        return []

    def beside(at: Advance) -> float:
        return obstacle.gap_beside(gaps.poses(at.state)[obstacle.link], rigid.pieces[index] or 0)

    touch = partial(Touch, obstacle)
    return [EventFunction(f"other piece of {_label(obstacle)}", beside, True, act=touch)]


def _hand_overs(progress: Progress, obstacle: Obstacle) -> list[EventFunction]:
    """The contact slides over a joint onto a neighbouring link."""
    gaps, found = progress.gaps, []

    def before(own: BarObstacle, at: Advance) -> float:
        return own.foot(gaps.poses(at.state)[own.link])[0]

    def after(own: BarObstacle, following: BarObstacle, at: Advance) -> float:
        poses = gaps.poses(at.state)
        return min(own.foot(poses[own.link])[1], following.foot(poses[following.link])[0])

    if not isinstance(obstacle, BarObstacle):
        return []
    where = _label(obstacle)
    if (lower := neighbour(progress, obstacle, -1)) is not None:
        act = partial(HandOver, obstacle, lower)
        found.append(EventFunction(f"start of {where}", partial(before, obstacle), True, act=act))
    if (upper := neighbour(progress, obstacle, 1)) is not None:
        act = partial(HandOver, obstacle, upper)
        found.append(EventFunction(f"end of {where}", partial(after, obstacle, upper), False, act=act))
    return found


def _parting(rigid: RigidContacts, index: int) -> EventFunction:
    """The normal force falls to zero: the link leaves the obstacle."""
    obstacle = rigid.obstacles[index]

    def push(at: Advance) -> float:
        return rigid.normal(at.totals)[index] if at.totals else math.nan

    act = partial(Release, (obstacle,))
    return EventFunction(f"force of {_label(obstacle)}", push, True, act=act, difference=True)


def _sticking(rigid: RigidContacts, index: int, contact: Sustained) -> EventFunction:
    """The force of stick reaches what friction gives: slip begins against it."""
    reached = [0.0]

    def spare(at: Advance) -> float:
        if not at.totals:
            return math.nan
        reached[0] = at.totals[TOTALS * index + 1]
        return rigid.spare_friction(at.totals, index)

    def act() -> Change:
        return Slip(contact, -1 if reached[0] > 0.0 else 1)

    return EventFunction(f"stick of {_label(contact.obstacle)}", spare, True, act=act, difference=True)


def _spring_events(progress: Progress, contact: Sustained, spring: Spring, first: int) -> list[EventFunction]:
    """Compression ends; unloading the force falls to zero, or the point is pressed on beyond the deepest; slip stops or begins.

    The contact's totals begin at the index ``first``. Each function is a velocity: a penetration over the contact's duration.
    """
    obstacle, gaps, duration = contact.obstacle, progress.gaps, spring.expected.duration
    tolerance = max(LOCATED_VELOCITY * spring.expected.stepper.noise, math.ulp(1.0))

    known: list[tuple[State, ClosestApproach]] = []

    def touch(at: Advance) -> ClosestApproach:
        if not known or known[0][0] is not at.state:
            known[:] = [(at.state, gaps.closest(obstacle, at.state))]
        return known[0][1]

    def opening(at: Advance) -> float:
        return touch(at).velocity[0]

    def slip(at: Advance) -> float:
        return spring.slip * touch(at).velocity[1]

    def beyond(level: float, at: Advance) -> float:
        return (spring.surface - touch(at).gap - level) / duration

    def spare(at: Advance) -> float:
        if not at.totals:
            return math.nan
        penetration = spring.surface - touch(at).gap
        return spring.spare_friction(penetration, at.totals[first + 5]) / (spring.stiffness * duration)

    several = not progress.mechanism.lone

    def event(
        what: SpringEvent, value: Callable[[Advance], float], falling: bool, *, positive: bool = False
    ) -> EventFunction:
        name, act = f"{what.name} of {_label(obstacle)}", partial(SpringChange, contact, what)
        turns = several or what is SpringEvent.UNLOADED
        return EventFunction(name, value, falling, act=act, tolerance=tolerance, turns=turns, positive=positive)

    if spring.loading:
        found = [event(SpringEvent.COMPRESSION_ENDS, opening, False)]
    else:
        found = [
            event(SpringEvent.UNLOADED, partial(beyond, spring.residual), True),
            event(SpringEvent.PRESSED_ON, partial(beyond, spring.deepest), False),
        ]
    if spring.slip:
        found.append(event(SpringEvent.SLIP_STOPS, slip, True))
    elif spring.compliance_in_stick:
        found.append(event(SpringEvent.STICK_BREAKS, spare, True, positive=True))
    return found


def _label(obstacle: Obstacle) -> str:
    corner = "" if obstacle.corner in (None, -1) else f" knee {obstacle.corner}"
    return f"{obstacle.name} at link {obstacle.link}{corner}" + (
        "" if obstacle.partner is None else f" and {obstacle.partner}"
    )
