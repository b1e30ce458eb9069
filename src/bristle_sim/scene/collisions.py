"""Impacts at one instant, the contacts that follow, and the growth of the run's error by impacts.

:func:`bristle_sim.scene.run.decide` calls the functions of this module.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from bristle_sim.scene.contact import (
    LEAST_ACCELERATION,
    LEAST_SLIP,
    ActiveContact,
    Outcome,
    RigidContacts,
)
from bristle_sim.scene.impacts import ENERGETIC, EnergeticLaw
from bristle_sim.scene.mechanism import State, cross
from bristle_sim.scene.motion import Motion
from bristle_sim.scene.pairs import ClosestApproach, ContactPair
from bristle_sim.scene.spring import SpringContact
from bristle_sim.scene.spring_phases import look_up_slip
from bristle_sim.scene.system import GAP_ROUNDING, System
from bristle_sim.settings import StopReason
from bristle_sim.trajectory import ContactRecord

MOST_IMPACTS_AT_ONCE = 64
"""Largest number of impacts at one instant, divided by the square of the number of closed contacts.
After more impacts the links count as jammed."""

MOST_CHANGED_APPROACH = 0.5
"""Largest relative change of an impact's velocity jumps, caused by the run's error, at which the
growth of the error in the impact is assumed to be linear."""


def end_contacts(
    system: System,
    contacts: Sequence[ActiveContact],
    ending: Sequence[ActiveContact],
    outcome: str,
    *,
    released: bool = False,
) -> tuple[ActiveContact, ...]:
    """Record the contacts in ``ending`` as ended, and return the other contacts.

    Args:
        system: the run.
        contacts: the active contacts.
        ending: the contacts that end.
        outcome: outcome that their records state.
        released: whether the end of each contact is also recorded as an event, the release. The
            sense of slip of the other rigid contacts is then found anew.
    """
    system.scene.keep_closed(())
    for contact in ending:
        if record := contact.record(system.closest, system.state, outcome):
            system.recording.contacts.append((record, system.links_of(contact.pair)))
        if released:
            system.event(f"{contact.pair.name} release", system.wires_of(contact.pair))
    staying = tuple([contact for contact in contacts if contact not in ending])
    for contact in staying:
        if released and not isinstance(contact, SpringContact):
            # Without slip velocity, its sense may have been due to the contacts that end.
            contact.slip = None
    return staying


def jam(system: System, *pairs: ContactPair) -> None:
    """Record a jam of the links at the given pairs, and stop the run."""
    system.stop(StopReason.JAM)
    system.event("jam", sorted({wire for pair in pairs for wire in system.wires_of(pair)}))


def opens_without_force(system: System, motion: Motion, contact: ActiveContact) -> bool:
    """Return whether a closed contact opens if it exerts no force, while all others stay closed."""
    others = [each for each in motion.ordered if each is not contact]
    rigid = RigidContacts(system.scene, others) if others else None
    system.scene.keep_closed(())
    if rigid is not None:
        rigid.engage(system.state)
    time = system.plan.shortest
    later = system.stepper.advance(system.scene, system.state, time, rigid, motion.forces)
    return system.closest(contact.pair, later.state).velocity[0] > LEAST_ACCELERATION * time


def lock(system: System, contacts: list[ActiveContact]) -> None:
    """Stop a run in which no force can keep a contact closed.

    With friction the link jams. Without friction the link meets its obstacle end-on. ``contacts``
    are the contacts of the link.
    """
    pairs = [contact.pair for contact in contacts]
    if any(pair.friction for pair in pairs):
        jam(system, *pairs)
    system.stop(StopReason.NO_GRIP)


def resolve_impacts(
    system: System, motion: Motion, pair: ContactPair, name: str, *, rests: bool
) -> Motion:
    """Resolve an impact, and further impacts that the first one causes at the same instant.

    Args:
        system: the run.
        motion: the motion before the impact.
        pair: the link and the obstacle that touch.
        name: name under which the touch is recorded as an event.
        rests: whether the impact is perfectly plastic, so that the contact point does not rebound.

    Returns:
        The motion after the impacts, with its contacts.
    """
    single_link = system.mechanism.single_link
    contacts = motion.contacts
    # The contact passes to another straight segment of the same link, or the link leaves the others.
    ending = [contact for contact in contacts if contact.pair is pair]
    if single_link and not ending:
        ending = list(motion.ordered)
    contacts = end_contacts(system, contacts, ending, pair.name)
    opening = _least_opening_rate(system, pair) if single_link else math.inf
    record = _resolve(system, pair, rests=rests or opening <= LEAST_SLIP)
    approaches = record.velocity_after[0] < -system.slow
    if single_link and approaches and record.outcome != Outcome.JAM:
        # The engine's iterations have not ended the approach. The energetic law ends it.
        record = _resolve(system, pair, rests=True)
    jams = record.outcome == Outcome.JAM or opening < -LEAST_SLIP
    system.event(name, system.wires_of(pair), lasts=jams)
    if jams:
        jam(system, pair)
        return Motion(contacts)
    after = Motion(contacts, motion.separating)
    if not single_link:
        after = _after_all_touches(system, after, pair, rests=rests)
    else:
        springs = _springs_after_impact(system, after)
        rests = record.outcome != Outcome.REBOUND or record.velocity_after[0] <= system.slow
        after = Motion((*springs, ActiveContact(pair))) if rests else Motion(springs, (pair,))
    if system.recording.stop_reason is StopReason.JAM:
        return after
    staying = [contact.pair for contact in after.contacts]
    for left in (contact.pair for contact in ending if contact.pair not in staying):
        system.event(f"{left.name} release", system.wires_of(left))
    return after


def _least_opening_rate(system: System, pair: ContactPair) -> float:
    """Return the least opening rate of a single link that touches two obstacles.

    Let v_1 and v_2 be the normal velocities of the two contact points, and l_1 and l_2 the levers
    of the normals about the joint. For either contact v = u + l w, where w is the link's angular
    velocity and u is due to the motion of the joint. If the levers have opposite signs, w cancels
    in the opening rate v_1/abs(l_1) + v_2/abs(l_2). If the rate is negative, no w opens both
    contacts, so the link is wedged. Contacts whose levers have the same sign cannot wedge a link.

    Returns:
        The least opening rate of ``pair`` with any other closed pair, an angular velocity in engine
        units. The rate is infinite if no other closed pair has a lever of the opposite sign.
    """
    touch = system.closest(pair)
    lever = cross(touch.arm, touch.normal)
    rates = [math.inf]
    for other in system.pairs:
        if other is not pair:
            second = system.closest(other)
            second_lever = cross(second.arm, second.normal)
            if abs(second.gap) <= GAP_ROUNDING and lever * second_lever < 0.0:
                drift = touch.velocity[0] / abs(lever)
                rates.append(drift + second.velocity[0] / abs(second_lever))
    return min(rates)


def _after_all_touches(
    system: System, motion: Motion, touched: ContactPair, *, rests: bool
) -> Motion:
    """Resolve the impacts at all closed contacts of several links until no contact approaches.

    The contact with the fastest approach is always resolved first.

    Args:
        system: the run.
        motion: the motion after the first impact.
        touched: the pair of the first impact.
        rests: whether all impacts are perfectly plastic. Otherwise links that come to rest would
            excite each other's small rebounds without end.

    Returns:
        The motion after the impacts, with its contacts.
    """
    lasting = {contact.pair: contact for contact in motion.ordered}
    closed = list(dict.fromkeys([touched, *lasting, *motion.separating]))
    slow = system.slow  # of the motion before further impacts, which may bring all links to rest
    for _ in range(MOST_IMPACTS_AT_ONCE * len(closed) ** 2):
        rates = {pair: system.approach(pair) for pair in closed}
        fastest = min(rates, key=rates.__getitem__)
        still = rates[fastest] >= -slow
        if still or _resolve(system, fastest, rests=rests).outcome == Outcome.JAM:
            break
    else:
        _forget_impacts(system)
    if not still:
        jam(system, *closed)
        return Motion(motion.contacts)
    leaving = tuple(pair for pair in closed if rates[pair] > slow)
    released = [contact for pair, contact in lasting.items() if pair in leaving]
    end_contacts(system, motion.contacts, released, touched.name, released=True)
    for contact in lasting.values():
        contact.slip = None
    springs = _springs_after_impact(system, motion)
    staying = [lasting.get(pair) or ActiveContact(pair) for pair in closed if pair not in leaving]
    return Motion((*staying, *springs), leaving)


def _forget_impacts(system: System) -> None:
    """Return to the state before the impacts at this instant, and record the first of them as a jam.

    The impacts at wedged links have no end, so their impulses have no sum.
    """
    recording = system.recording
    time = system.state.time
    while len(recording.contacts) > 1 and recording.contacts[-2][0].time == time:
        recording.contacts.pop()
    first, links = recording.contacts.pop()
    recording.contacts.append((replace(first, outcome=str(Outcome.JAM)), links))
    while len(recording.states) > 1 and recording.states[-2].time == time:
        recording.states.pop()
        recording.forces.pop()
    system.state = recording.states[-1]


def _springs_after_impact(system: System, motion: Motion) -> tuple[SpringContact, ...]:
    """Return the contacts with springs after an impact elsewhere on the wire.

    The phase of each contact is set anew from the new velocity of its contact point.
    """
    for spring in motion.springs:
        spring.at_rest = False
        if spring.law.loading and system.approach(spring.pair) > 0.0:
            spring.unload(system.penetration(spring))
        look_up_slip(system, motion, spring)
    return tuple(motion.springs)


def _resolve(system: System, pair: ContactPair, *, rests: bool) -> ContactRecord:
    """Resolve an impact by the contact law of the pair, record it, and return the record.

    ``rests`` states whether the impact is perfectly plastic: the contact point does not rebound.
    """
    before = system.state
    touched = pair
    law = system.law_of(pair)
    recording = system.recording
    if isinstance(law, EnergeticLaw) and recording.lost is None:
        law = replace(law, accuracy=min(law.accuracy, recording.error))
    if rests or -system.approach(pair) <= system.slow:
        law = ENERGETIC
        touched = replace(pair, restitution=0.0)
    record = law.resolve(system.scene, before, touched)
    system.state = before._replace(rates=record.rates_after)
    propagate_error(system, pair, before, record)
    system.recording.contacts.append((record, system.links_of(pair)))
    system.sample()
    return record


def propagate_error(
    system: System, pair: ContactPair, before: State, record: ContactRecord
) -> None:
    """Update the run's error estimate after an impact.

    Two neighbouring motions are compared with the simulated motion. In both, the estimated error is
    added to the angles. In one it is added to the angular velocities too, in the other it is
    subtracted from them. The neighbouring motions have other instants of touch, approach speeds and
    levers of the normal, and hence other velocity jumps. The error is recorded as unknown in two
    cases. The jumps of a neighbouring motion may differ by more than ``MOST_CHANGED_APPROACH``. Or
    the law has corrected the slip velocity so that slip and approach end together, and it is
    uncertain whether the contact sticks or jams.

    Args:
        system: the run, in the state after the impact.
        pair: the link and the obstacle that touch.
        before: state before the impact.
        record: record of the impact.
    """
    recording = system.recording
    if recording.lost is not None:
        return
    error = recording.error
    touch = system.closest(pair, before)
    approach, slip = touch.velocity
    earlier = next((each for each in reversed(recording.states) if each.time < before.time), before)
    span = before.time - earlier.time or math.inf
    accelerations = [(b - a) / span for a, b in zip(earlier.rates, before.rates, strict=True)]
    jumps = [b - a for a, b in zip(before.rates, record.rates_after, strict=True)]
    snap = abs(slip - record.velocity_before[1])
    jams = pair.friction * abs(slip) >= abs(approach)
    undecided = snap > (0.0 if jams else error)
    previous = recording.contacts[-1][0].time if recording.contacts else None

    def neighbour(off: float, late: float) -> ClosestApproach:
        """Return gap, contact point and velocity of the pair in a slightly different motion.

        In this motion every link's angular velocity at the touch is greater by ``off`` than in the
        simulated motion. The result is that at the time ``late`` after the touch.
        """
        moving = [rate + off for rate in before.rates]
        angles = [a + error + late * u for a, u in zip(before.angles, moving, strict=True)]
        rates = [u + late * b for u, b in zip(moving, accelerations, strict=True)]
        state = State(before.time + late, tuple(angles), tuple(rates))
        return system.closest(pair, state)

    for off in (error, -error):
        early = neighbour(off, 0.0)
        late = -early.gap / (early.velocity[0] or math.inf)
        other = neighbour(off, late)
        pressed = (other.velocity[0] - early.velocity[0]) * late <= 0.0
        # No acceleration acts between impacts at one instant.
        if (pressed or previous == before.time) and record.velocity_after[0] <= system.slow:
            # The contact stays closed, and its force cancels what the acceleration adds to the
            # approach speed of a later touch.
            other = early
        # A jump is proportional to the approach speed. That of a single link is also proportional
        # to 1/lever.
        expected = approach
        changed = other.velocity[0]
        if system.mechanism.single_link:
            expected *= cross(other.arm, other.normal)
            changed *= cross(touch.arm, touch.normal)
        part = changed / (expected or math.nan) - 1.0
        if undecided or not abs(part) < MOST_CHANGED_APPROACH:
            recording.lost = before.time
            return
        changes = [
            abs(change) for jump in jumps for change in (error - late * jump, off + part * jump)
        ]
        recording.error = max(recording.error, *changes)
