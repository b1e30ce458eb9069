"""The events of a smooth motion: those of the motion as a whole, of rigid contacts, and of contacts with springs.

Gaps to pairs that may touch are searched in :mod:`bristle_sim.scene.touches`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache, partial

from bristle_sim.scene.contact import ActiveContact
from bristle_sim.scene.extrapolation import IntervalResult
from bristle_sim.scene.happening import Event, Kind
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.pairs import BarPair, ClosestApproach, ContactPair, dented
from bristle_sim.scene.rigid import RigidContacts
from bristle_sim.scene.spring import Spring
from bristle_sim.scene.system import System

LEAST_COMPLIANCE_IN_SLIP = 1e-3  # of a free link's; with less, the force that keeps a contact closed grows beyond bounds: a jam
PLACE_ROUNDING = 4e-16  # of a tip's place, in the scene's unit of length
LOCATED_VELOCITY = (
    0.1  # fraction of an interval's error in velocity to which a spring's events are located
)


def motion_events(system: System, *, in_contact: bool) -> Iterator[Event]:
    """Yield the events of the motion as a whole: extremes, limits, dents that are left."""
    mechanism = system.mechanism
    plan = system.plan

    def relative_rate(link: int, at: IntervalResult) -> float:
        return at.state.rates[link] - mechanism.hub_speed

    def acceleration_of(link: int, at: IntervalResult) -> float:
        return at.accelerations[link]

    def left(link: int, at: IntervalResult) -> float:
        return plan.retraction_limit - abs(
            at.state.angles[link] - mechanism.root_angle(link, at.state.time)
        )

    for wire in range(mechanism.wires):
        link = wire * mechanism.wire_links
        if not plan.single_contact:
            yield Event(partial(relative_rate, link), 1, Kind.LARGEST_RETRACTION, wire)
        if not (plan.single_contact or in_contact or mechanism.wire_links > 1):
            # A wire of several links vibrates.
            yield Event(partial(acceleration_of, wire), -1, Kind.HIGHEST_SPEED, wire)
        if math.isfinite(plan.retraction_limit):
            yield Event(partial(left, link), -1, Kind.RETRACTION_LIMIT, wire)
    for number, pair in enumerate(system.pairs):
        if pair.dent:
            yield Event(partial(_gap, system, dented(pair, 0.0)), 1, Kind.DENT_LEFT, number)


def _gap(system: System, pair: ContactPair, at: IntervalResult) -> float:
    return system.gaps.gap(pair, at.state)


def contact_events(
    system: System, contacts: Sequence[ActiveContact], rigid: RigidContacts | None
) -> Iterator[Event]:
    """Yield the events that change or end contacts, which are numbered as in the load: the rigid ones come first."""
    for index, contact in enumerate(contacts):
        if contact.spring is not None:
            yield from _spring_events(system, contact, contact.spring, index)
            continue
        assert rigid is not None
        yield from _rigid_events(system, contact, rigid, index)
        if isinstance(contact.pair, BarPair):
            yield from _bar_events(system, contact, contact.pair, rigid.pieces[index] or 0)


def _rigid_events(
    system: System, contact: ActiveContact, rigid: RigidContacts, index: int
) -> Iterator[Event]:
    """Yield the events of a rigid contact: it locks, its force vanishes, it sticks or slips otherwise, it passes a corner.

    With too little compliance in slip friction locks the link, or a frictionless link meets the obstacle end-on.
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
    """Yield the events at which a contact slides over a joint, or another piece of a bent link meets the same bar.

    Contact passes to the other piece by an impact.
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
    """Yield the events of a spring: compression ends, unloading ends at zero force or by reloading, its foot stops or slips.

    Each function is a velocity, or a penetration over the contact's duration.
    """
    pair = contact.pair
    gaps = system.gaps
    duration = spring.expected.duration
    tolerance = max(LOCATED_VELOCITY * spring.expected.stepper.noise, math.ulp(1.0))

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
        if not at.totals:
            return math.nan
        penetration = spring.surface - touch(at.state).gap
        margins = spring.rest_margins(penetration, at.sums(index).tangential)
        return margins[which] / (spring.law.stiffness * duration)

    def spare(at: IntervalResult) -> float:
        if spring.elastic:
            force = spring.elastic_force(gaps.along(pair, at.state))
        elif at.totals:
            force = at.sums(index).tangential
        else:
            return math.nan
        return spring.spare_friction(spring.surface - touch(at.state).gap, force) / (
            spring.law.stiffness * duration
        )

    # It rises from zero and may come back at once: nothing but rounding of a place counts as zero.
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
    elif spring.compliance_in_stick:
        yield Event(spare, -1, Kind.CONE_REACHED, contact, tolerance)
