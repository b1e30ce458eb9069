"""The decision after an event: which contacts begin, which change, and which end.

:func:`decide` makes this decision for every kind of event: impacts, releases, passages of a contact
from link to link, changes of slip, phases of contact springs, and rest. Impulses change the angular
velocities. Links in contact are also moved back onto their obstacles, because an integrator
constrains only velocities.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from bristle_sim.scene.collisions import (
    Contacts,
    end_contacts,
    given_up,
    name_releases,
    resolve_impacts,
)
from bristle_sim.scene.compliant import ContactLoad
from bristle_sim.scene.contact import ActiveContact, Outcome
from bristle_sim.scene.events import (
    SPRING_KINDS,
    Happening,
    Kind,
    contact_events,
)
from bristle_sim.scene.extrapolation import IntervalResult
from bristle_sim.scene.motion import Motion, motion_events
from bristle_sim.scene.pairs import ClosedPair, ContactPair
from bristle_sim.scene.rigid import RigidContacts, sense_of_slip
from bristle_sim.scene.spring import Spring
from bristle_sim.scene.spring_phases import begin_spring, change_spring, pressed_on
from bristle_sim.scene.system import System
from bristle_sim.settings import LARGEST_RETRACTION, StopReason


def first_motion(system: System) -> Motion:
    """Return the motion with which a run starts."""
    motion = begin_motion(system, Contacts())
    for pair in system.pairs:
        if system.recording.stop_reason is not None or not system.touches(pair):
            continue
        if system.approach(pair) <= 0.0:
            motion = decide(system, motion, Happening(Kind.TOUCH, pair))
    return motion


def decide(system: System, motion: Motion, event: Happening) -> Motion:
    """Return the motion that follows an event. If no contact changes, it is the same motion."""
    kind = event.kind
    subject = event.subject
    if kind in (Kind.LARGEST_RETRACTION, Kind.HIGHEST_SPEED):
        system.event(
            LARGEST_RETRACTION if kind is Kind.LARGEST_RETRACTION else "highest relative speed",
            (subject,),
        )
        return motion
    if kind is Kind.RETRACTION_LIMIT:
        system.stop(StopReason.RETRACTION_LIMIT)
        system.event("retraction limit", (subject,))
        return motion
    contacts = Contacts(motion.contacts, motion.separating)
    if kind in (Kind.TOUCH, Kind.REST):
        pair = system.at_joint(subject)
        rests = kind is Kind.REST
        name = _touch_name(system, pair)
        contacts = _contact_begun(system, motion, pair, name, rests=rests) or resolve_impacts(
            system, motion, pair, name, rests=rests
        )
    elif kind is Kind.LOCKED:
        _locked(system, [subject])
    elif kind in SPRING_KINDS:
        contacts = _spring_changed(system, motion, subject, kind)
    elif kind is Kind.RELEASE:
        staying = end_contacts(system, motion.contacts, subject, Outcome.RELEASE)
        name_releases(system, subject)
        contacts = Contacts(staying, [*motion.separating, *(contact.pair for contact in subject)])
    elif kind is Kind.HAND_OVER:
        contact, following = subject
        staying = end_contacts(system, motion.contacts, [contact], following.name)
        contacts = Contacts([*staying, ActiveContact(following)], motion.separating)
    elif kind is Kind.DENT_LEFT:
        system.pairs[subject] = replace(system.pairs[subject], dent=0.0)
    elif kind is not Kind.KINK:
        subject.turn(_sense_after(system, event))
    if system.recording.stop_reason is not None:
        return replace(motion, contacts=tuple(contacts.active))
    return begin_motion(system, contacts)


def _sense_after(system: System, event: Happening) -> int:
    """Return the sense of slip of a rigid contact after an event that changes its slip: +1, -1, or
    0 for stick.
    """
    contact: ActiveContact = event.subject
    if event.kind is Kind.SLIPS:
        return int(event.detail)
    if event.kind is Kind.BREAKS_AWAY:
        return -1 if contact.tangential > 0.0 else 1
    # Geometry and hub alone determine how a single link slips: its slip reverses where several links may stick.
    return -(contact.slip or 0) if system.mechanism.single_link else 0


def begin_motion(system: System, contacts: Contacts) -> Motion:
    """Return the motion with the given contacts, after their gaps have been closed exactly.

    The run stops in two cases: if its last event has happened and no contact has a spring, or if no
    force can keep a rigid contact closed.
    """
    springs = [contact.spring for contact in contacts.active if contact.spring is not None]
    if system.recording.stop_reason is None and system.had_last_event and not springs:
        system.stop(StopReason.EVENT)
        return Motion()
    ordered = [contact for contact in contacts.active if contact.spring is None]
    active = [*ordered, *(contact for contact in contacts.active if contact.spring is not None)]
    motion = Motion(tuple(active), tuple(contacts.separating))
    if ordered or (system.mechanism.wire_links > 1 and not springs):
        motion.limit = system.plan.first_interval
    if ordered:
        _engage(system, motion, ordered, paired=not springs)
    for contact in active:
        contact.start = contact.start or system.state
        contact.force = None
        contact.vanishes_in = math.inf
    if active:
        motion.load = ContactLoad(system.scene, motion.rigid, springs) if springs else motion.rigid
        system.sample(
            {
                contact: contact.sample(system.gaps, system.state)
                for contact in active
                if contact.spring is not None
            }
        )
    steppers = [spring.stepper for spring in springs]
    system.stepper = min(steppers, key=lambda each: each.longest, default=system.flight)
    motion.events = (
        *contact_events(system, active, motion.rigid),
        *motion_events(system, in_contact=bool(active)),
    )
    start = IntervalResult(system.state)
    for event in motion.events:
        event.begin(start, system.noise)
    return motion


def _engage(
    system: System, motion: Motion, ordered: Sequence[ActiveContact], *, paired: bool
) -> None:
    """Move the links to the nearest state in which all rigid contacts are closed, and set each
    contact's sense of slip.

    ``ordered``: the rigid contacts. ``paired``: whether no contact has a spring.
    """
    gaps = system.gaps
    for contact in ordered:
        if contact.slip is None and contact.pair.friction:
            contact.slip = sense_of_slip(
                gaps, contact.pair, system.state, system.slip_error(system.state)
            )
    closed = [ClosedPair(contact.pair, None, contact.slip) for contact in ordered]
    rigid = motion.rigid = RigidContacts(system.scene, closed, paired=paired)
    system.state = rigid.set_back(gaps, system.state)
    if system.mechanism.single_link and paired:
        # From here on the geometry gives angle and rate, whatever their errors before.
        system.recording.error = system.recording.summed
    rigid.engage(system.state)
    compliances = (
        rigid.compliance_in_slip(gaps, system.state, index) for index in range(len(closed))
    )
    if min(compliances) <= 0.0:
        _locked(system, ordered)


def _locked(system: System, contacts: Sequence[ActiveContact]) -> None:
    """Stop a run in which no force can keep a contact closed: friction jams the link, or a
    frictionless link meets its obstacle end-on.
    """
    if any(contact.pair.friction for contact in contacts):
        system.stop(StopReason.JAM)
        system.event(
            "jam", sorted({wire for contact in contacts for wire in system.wires_of(contact.pair)})
        )
    system.stop(StopReason.NO_GRIP)


def _contact_begun(
    system: System, motion: Motion, pair: ContactPair, name: str, *, rests: bool
) -> Contacts | None:
    """Return the contacts after a touch that begins a contact with a spring or a contact at rest;
    None if the touch is an impact.
    """
    law = system.law_of(pair)
    known = [contact for contact in motion.contacts if contact.pair is pair]
    began = None
    if not known and rests and not system.mechanism.single_link:
        # Coupled links would excite each other's small rebounds for ever: all touching links come to rest together.
        began = ActiveContact(pair)
    elif not known and not law.instantaneous and -system.approach(pair) > system.slow:
        try:
            spring = law.spring(system.scene, system.state, pair)
        except ValueError as error:
            return given_up(system, motion, error)
        began = None if spring is None else begin_spring(system, motion, pair, spring)
    if began is None:
        return None
    system.event(name, system.wires_of(pair), lasts=began.spring is not None)
    return Contacts(
        [*motion.contacts, began], [other for other in motion.separating if other is not pair]
    )


def _touch_name(system: System, pair: ContactPair) -> str:
    """Return the event name of a touch: ``strike`` for a wire's first touch of the workpart;
    otherwise ``bar touch``, ``workpart touch`` or ``wire touch``.
    """
    wire = system.wires_of(pair)[0]
    size = system.mechanism.wire_links
    for contact, links in system.recording.contacts:
        if contact.obstacle == pair.name and wire in [link // size for link in links]:
            return f"{pair.name} touch"
    return pair.first_touch


def _spring_changed(system: System, motion: Motion, contact: ActiveContact, kind: Kind) -> Contacts:
    """Return the contacts after an event of a contact spring, which changes the spring's phase or
    ends its contact.
    """
    spring = contact.spring
    pair = contact.pair
    assert spring is not None
    outcome = change_spring(system, motion, contact, spring, kind)
    if outcome is None:
        return Contacts(motion.contacts, motion.separating)
    if outcome is Outcome.REBOUND:
        spring.course.release()
        _add_limit_error(system, contact, spring)
    staying = end_contacts(system, motion.contacts, [contact], outcome)
    gap = system.gaps.gap(pair, system.state)
    if gap < -system.plan.accuracy:
        # The tip is left in a dent, whose ground is the surface from here on.
        ground = replace(pair, dent=pair.dent - gap)
        system.pairs[system.pairs.index(pair)] = ground
        pair = ground
    wires = system.wires_of(pair)
    if outcome is Outcome.JAM:
        system.stop(StopReason.JAM)
        system.sample()
        system.event("jam", wires)
        return Contacts(staying)
    # A spring without restitution pushes no more: where the tip is pressed on, it touches the ground of its dent.
    spent = outcome is Outcome.NO_REBOUND and not system.follows_law(spring)
    leaves = outcome is Outcome.REBOUND and system.approach(pair) > system.slow
    again = None if leaves else pressed_on(system, replace(motion, contacts=tuple(staying)), pair)
    if again is not None:
        system.event(f"{pair.name} release", wires)
        system.event(_touch_name(system, pair), wires, lasts=True)
        return Contacts([again], motion.separating)
    if spent or leaves:
        system.event(f"{pair.name} release", wires)
        return Contacts(staying, [*motion.separating, pair])
    return Contacts([*staying, ActiveContact(pair)], motion.separating)


def _add_limit_error(system: System, contact: ActiveContact, spring: Spring) -> None:
    """Add to the run's error the difference between a contact with a spring and the impact law that
    it stands for.

    This applies only to contacts that represent the rigid-body limit.
    """
    if contact.start is None or not system.follows_law(spring):
        return
    limit, _ = system.law_of(contact.pair).resolve(system.scene, contact.start, contact.pair)
    system.recording.error += max(
        abs(a - b) for a, b in zip(system.state.rates, limit.rates, strict=True)
    )
