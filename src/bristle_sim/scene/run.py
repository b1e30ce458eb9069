"""The loop of a run, and the decision after an event: which contacts begin, change and end.

:func:`decide` makes this decision for every kind of event: impacts, releases, passages of a contact
from link to link, changes of slip, phases of contact springs, and rest. Impulses change the angular
velocities. When a new motion begins, links in sustained contact are moved back exactly onto their
obstacles, because the integrator constrains only their velocities.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import replace

from bristle_sim.scene.collisions import (
    end_contacts,
    jam,
    lock,
    opens_without_force,
    resolve_impacts,
)
from bristle_sim.scene.contact import ActiveContact, Outcome, RigidContacts
from bristle_sim.scene.events import (
    SPRING_KINDS,
    Happening,
    Kind,
    contact_events,
)
from bristle_sim.scene.extrapolation import IntervalResult
from bristle_sim.scene.motion import Motion, accept, integrate, motion_events
from bristle_sim.scene.pairs import ContactPair
from bristle_sim.scene.spring import SpringContact, spring_forces
from bristle_sim.scene.spring_phases import begin_spring, change_spring, pressed_on
from bristle_sim.scene.system import GAP_ROUNDING, System
from bristle_sim.scene.touches import first_event
from bristle_sim.settings import StopReason

log = logging.getLogger(__name__)

# kinds of events that change no contact; the name of such an event is the name of its kind
EXTREMES = (Kind.LARGEST_RETRACTION, Kind.HIGHEST_RELATIVE_SPEED, Kind.RETRACTION_LIMIT)


def run(system: System) -> Iterator[tuple[Motion, Happening | None]]:
    """Run a system from the present state to the end of its plan, interval by interval.

    Yields:
        Pairs (motion, event). The first pair holds the motion with which the run starts. A pair at
        the end of each interval holds the motion in the interval and the event that has ended the
        interval. After an event a further pair holds the motion that follows the event. The last
        pair holds a motion without contacts. The event is None where no event has ended an
        interval.
    """
    plan = system.plan
    scene = system.scene
    budget = scene.work + plan.maximum_steps
    motion = first_motion(system)
    yield motion, None
    while system.recording.stop_reason is None:
        if system.state.time >= plan.end * (1.0 - 1e-15):
            system.stop(StopReason.END)
            break
        if scene.work >= budget:
            system.stop(StopReason.STEP_BUDGET)
            break
        interval, event = integrate(system, motion)
        if interval is not None:
            interval, event = first_event(system, motion, interval)
            accept(system, motion, interval)
        log.debug("%.4f", system.state.time / plan.end)  # fraction of the run that is done
        if interval is not None or event is not None:
            yield motion, event
        if event is not None:
            motion = decide(system, motion, event)
            yield motion, None
    end_contacts(system, motion.contacts, motion.contacts, str(system.recording.stop_reason))
    yield Motion(), None


def first_motion(system: System) -> Motion:
    """Return the motion with which a run starts.

    A pair whose gap is closed at the start, and does not open, touches at once.
    """
    motion = begin_motion(system, Motion())
    for pair in system.pairs:
        touch = system.closest(pair)
        closes = abs(touch.gap) <= GAP_ROUNDING and touch.velocity[0] <= 0.0
        if closes and system.recording.stop_reason is None:
            motion = decide(system, motion, Happening(Kind.TOUCH, pair))
    return motion


def decide(system: System, motion: Motion, event: Happening) -> Motion:
    """Return the motion that follows an event.

    An extreme of the motion changes no contact, so the same motion is returned. After any other
    event a new motion begins.

    Raises:
        ValueError: if the contact law cannot resolve the run's first contact.
    """
    kind = event.kind
    subject = event.subject
    active = motion.contacts
    if kind in EXTREMES:
        if kind is Kind.RETRACTION_LIMIT:
            system.stop(StopReason.RETRACTION_LIMIT)
        system.event(kind.replace("_", " "), (subject,))
        return motion
    if kind in (Kind.TOUCH, Kind.REST):
        pair = system.at_joint(subject)
        name = _touch_name(system, pair)
        rests = kind is Kind.REST
        try:
            motion = _contact_begun(system, motion, pair, name, rests) or resolve_impacts(
                system, motion, pair, name, rests=rests
            )
        except ValueError as error:
            if not system.recording.contacts:
                raise
            system.stop(StopReason.UNRESOLVED, str(error))
    elif kind is Kind.LOCKED:
        lock(system, [subject])
    elif kind in SPRING_KINDS:
        motion = _after_spring_event(system, motion, subject, kind)
    elif kind is Kind.RELEASE:
        separating = (*motion.separating, *(contact.pair for contact in subject))
        staying = end_contacts(system, active, subject, Outcome.RELEASE, released=True)
        motion = Motion(staying, separating)
    elif kind is Kind.HAND_OVER:
        contact, following = subject
        staying = end_contacts(system, active, [contact], following.name)
        motion = Motion((*staying, ActiveContact(following)), motion.separating)
    elif kind is Kind.DENT_LEFT:
        system.pairs[subject] = replace(system.pairs[subject], dent=0.0)
    elif kind is not Kind.KINK:
        subject.slip = _sense_after(motion, event)
    return motion if system.recording.stop_reason is not None else begin_motion(system, motion)


def _sense_after(motion: Motion, event: Happening) -> int:
    """Return the sense of slip (+1, -1, or 0 in stick) after an event of a rigid contact's slip."""
    contact: ActiveContact = event.subject
    if event.kind is Kind.BREAKS_AWAY:
        return -1 if contact.tangential > 0.0 else 1
    # A slip that geometry and hub determine does not stop but reverses.
    assert motion.rigid is not None
    return -(contact.slip or 0) if motion.rigid.prescribes_slip(contact) else 0


def begin_motion(system: System, given: Motion) -> Motion:
    """Close the gaps of rigid contacts exactly; return a new motion with the contacts of ``given``.

    A contact that no force can keep closed is released if it opens without force; if it stays
    closed, the run stops. The run also stops if every wire has had the event ``stop_after`` and no
    contact has a spring.
    """
    springs = given.springs
    if not (system.waiting or springs):
        system.stop(StopReason.EVENT)
        return Motion()
    ordered = given.ordered
    active = (*ordered, *springs)
    motion = Motion(active, given.separating)
    if ordered or (system.mechanism.jointed and not springs):
        motion.limit = system.plan.first_interval
    if ordered:
        motion.rigid = _closed_contacts(system, ordered)
        if system.mechanism.single_link and not springs:
            # The geometry alone determines angle and angular velocity from here on, so their
            # earlier errors have no effect.
            system.recording.error = system.recording.summed
    for contact in active:
        contact.start = contact.start or system.state
        contact.force = None
    if springs:
        motion.forces = spring_forces(system.scene, springs)
        system.sample({spring: spring.sample(system.closest, system.state) for spring in springs})
    steppers = [spring.stepper for spring in springs]
    system.stepper = min(steppers, key=lambda each: each.longest, default=system.flight)
    rigid = motion.rigid
    locked = [
        contact
        for index, contact in enumerate(ordered)
        if rigid is not None and rigid.compliance_in_slip(system.state, index) <= 0.0
    ]
    parting = tuple([contact for contact in locked if opens_without_force(system, motion, contact)])
    if parting:
        return decide(system, motion, Happening(Kind.RELEASE, parting))
    if locked:
        lock(system, ordered)
    motion.events = (
        *contact_events(system, active, motion.rigid),
        *motion_events(system, active),
    )
    start = IntervalResult(system.state)
    for event in motion.events:
        event.begin(start, system.noise)
    return motion


def _closed_contacts(system: System, contacts: list[ActiveContact]) -> RigidContacts:
    """Close the gaps of the rigid contacts exactly, and return the solver of their forces.

    The links are moved as little as possible. The sense of slip of each contact is set too.
    """
    rigid = RigidContacts(system.scene, contacts)
    rigid.engage(system.state)
    for contact in contacts:
        if contact.slip is None and contact.pair.friction:
            rigid.set_slip(system.state, contact, system.slip_error(system.state))
    system.state = system.scene.joint_solver.set_back(system.state)
    rigid.engage(system.state)
    return rigid


def _contact_begun(
    system: System, motion: Motion, pair: ContactPair, name: str, rests: bool
) -> Motion | None:
    """Return the motion after a touch that begins a contact with a spring; None for an impact.

    Args:
        system: the run.
        motion: the motion before the touch.
        pair: the link and the obstacle that touch.
        name: name under which the touch is recorded as an event.
        rests: whether the link comes to rest.
    """
    law = system.law_of(pair)
    if law.instantaneous or (rests and not law.finite_duration):
        return None
    began = None
    if -system.approach(pair) > system.slow:
        began = begin_spring(system, motion, pair)
    elif rests and not system.mechanism.single_link:
        began = pressed_on(system, motion, pair)
    if began is None:
        return None
    system.event(name, system.wires_of(pair), lasts=True)
    separating = tuple(other for other in motion.separating if other is not pair)
    return Motion((*motion.contacts, began), separating)


def _touch_name(system: System, pair: ContactPair) -> str:
    """Return the name of a touch as an event.

    The name is ``strike`` for a wire's first touch of the workpart, and otherwise ``bar touch``,
    ``workpart touch`` or ``wire touch``.
    """
    wire = system.wires_of(pair)[0]
    struck = any(
        event.name == "strike" and wire in wires for event, wires in system.recording.events
    )
    return f"{pair.name} touch" if pair.name != "workpart" or struck else "strike"


def _after_spring_event(
    system: System, motion: Motion, spring: SpringContact, kind: Kind
) -> Motion:
    """Return the motion after an event of a contact with a spring.

    The contact continues in another phase, or it ends.
    """
    pair: ContactPair = spring.pair
    outcome = change_spring(system, motion, spring, kind)
    if outcome is None:
        return motion
    if outcome is Outcome.REBOUND:
        time, _, _, *velocity = spring.rows[-1]
        spring.rows[-1] = (time, 0.0, 0.0, *velocity)
        _add_limit_error(system, spring)
    staying = end_contacts(system, motion.contacts, [spring], outcome)
    gap = system.closest(pair).gap
    least = system.plan.accuracy if system.law.finite_duration else GAP_ROUNDING
    if gap < -least:
        # The tip remains in a dent. The bottom of the dent is the surface from here on. With a given
        # duration, a tip in a dent shallower than the accuracy would sink by many small contacts.
        ground = replace(pair, dent=pair.dent - gap)
        system.pairs[system.pairs.index(pair)] = ground
        pair = ground
    wires = system.wires_of(pair)
    if outcome is Outcome.JAM:
        system.sample()
        jam(system, pair)
        return Motion(staying)
    # A spring without restitution exerts no force after compression. A tip that is pressed on then
    # touches the bottom of its dent.
    spent = outcome is Outcome.NO_REBOUND and not system.follows_law
    leaves = outcome is Outcome.REBOUND and system.approach(pair) > system.slow
    again = None if leaves else pressed_on(system, Motion(staying), pair)
    if again is not None:
        system.event(f"{pair.name} release", wires)
        system.event(_touch_name(system, pair), wires, lasts=True)
        return Motion((*staying, again), motion.separating)
    if spent or leaves:
        system.event(f"{pair.name} release", wires)
        return Motion(staying, (*motion.separating, pair))
    return Motion((*staying, ActiveContact(pair)), motion.separating)


def _add_limit_error(system: System, spring: SpringContact) -> None:
    """Add the difference between a contact with a spring and the impact law to the run's error.

    For each link the angular velocities after the contact are compared; the largest difference
    counts. The difference is added only where the impact law predicts how the contact ends.
    """
    if system.follows_law:
        law = system.law_of(spring.pair)
        limit = law.resolve(system.scene, spring.start, spring.pair)
        system.recording.error += max(
            abs(a - b) for a, b in zip(system.state.rates, limit.rates_after, strict=True)
        )
