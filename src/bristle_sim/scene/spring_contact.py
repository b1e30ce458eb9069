"""What a contact with a spring does at its events: it begins, passes into another phase, or ends."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.rigid import TOTALS
from bristle_sim.scene.contact.spring import ContactLoad, Spring, SpringPhase
from bristle_sim.scene.contact.sustained import Outcome, Sustained
from bristle_sim.scene.events.functions import SpringChange, SpringEvent
from bristle_sim.scene.motion import SmoothMotion, follow_bodies

STOPS_TOGETHER = 1e-5
"""Fraction of the approach with which slip and compression of one degree of freedom stop together."""

OPENED = 1e-5
"""A contact is over with less than this fraction of its spring's unloading left where slip starts or stops: 1e-10 of its
impulse is left, and the force is so small that rounding of the tip's place would start and stop slip without end."""

PROBE = 0.02
"""Fraction of a contact over which the force that stick takes is extrapolated back to the instant at which slip stops."""

CONE_ROUNDING = 1e-9
"""Fraction of friction's limit by which rounding may lead the force in stick beyond it."""


def begin_spring(motion: SmoothMotion, obstacle: Obstacle, spring: Spring) -> Sustained:
    """Return a contact that begins at the state that was reached."""
    progress = motion.progress
    contact = Sustained(obstacle, spring, progress.state)
    slip = progress.gaps.closest(obstacle, progress.state).velocity[1]
    if abs(slip) > progress.slip_error:
        spring.slip = int(math.copysign(1.0, slip))
    else:
        _settle_slip(motion, contact)
    _note_phase(contact)
    return contact


def after_impact(motion: SmoothMotion, contacts: Sequence[Sustained]) -> list[Sustained]:
    """Return contacts with springs after an impact elsewhere, which changes the sense of their motion."""
    progress = motion.progress
    for each in contacts:
        spring = each.spring
        if spring is None:
            continue
        touch = progress.gaps.closest(each.obstacle, progress.state)
        if spring.loading and touch.velocity[0] > 0.0:
            _unload(motion, each)
        if abs(touch.velocity[1]) > progress.slip_error:
            spring.slip = int(math.copysign(1.0, touch.velocity[1]))
        else:
            _settle_slip(motion, each)
        _note_phase(each)
    return list(contacts)


def change_spring(motion: SmoothMotion, change: SpringChange) -> Outcome | None:
    """Pass a contact into its next phase; return its outcome if it is over."""
    contact, spring = change.contact, change.contact.spring
    assert spring is not None
    before = spring.loading, spring.slip
    outcome = _change(motion, contact, spring, change.event)
    if outcome is None and _opened(motion, contact, spring):
        outcome = Outcome.REBOUND
    if outcome is None and before != (spring.loading, spring.slip):
        _note_phase(contact)
        jams = spring.expected.outcome == Outcome.JAM and spring.loading and not spring.slip
        if jams and not spring.expected.moves:
            return Outcome.JAM
        course = spring.course
        if jams and course.stopped is None:
            # Bodies that move meanwhile may still get out.
            course.stopped = motion.progress.state, contact.sums, len(course.rows), len(course.phases)
    return outcome


def _change(motion: SmoothMotion, contact: Sustained, spring: Spring, event: SpringEvent) -> Outcome | None:
    """Follow an event; return the contact's outcome if it is over."""
    expected, progress = spring.expected, motion.progress
    match event:
        case SpringEvent.COMPRESSION_ENDS:
            return _end_compression(motion, contact, spring)
        case SpringEvent.UNLOADED:
            return Outcome.REBOUND
        case SpringEvent.OVERDUE:
            if spring.course.stopped is not None:
                progress.state, contact.sums, rows, phases = spring.course.stopped
                del spring.course.rows[rows:], spring.course.phases[phases:]
                spring.course.compression = None
            stuck = expected.outcome in (Outcome.JAM, Outcome.STICTION)
            return Outcome(expected.outcome) if stuck else Outcome.NO_REBOUND
        case SpringEvent.PRESSED_ON:
            spring.loading = True
            if not spring.slip:
                _settle_slip(motion, contact)
        case SpringEvent.STICK_BREAKS:
            spring.slip = -1 if spring.stick_force > 0.0 else 1
        case SpringEvent.SLIP_STOPS:
            _settle_slip(motion, contact)
            stopped = expected.outcome == Outcome.STICTION and not spring.slip and _halts(motion, spring)
            # Slip and compression of one degree of freedom stop together, up to the motion during the contact.
            together = -progress.approach(contact.obstacle) <= STOPS_TOGETHER * spring.course.approach
            if spring.loading and (stopped or together):
                return _end_compression(motion, contact, spring)
    return None


def _end_compression(motion: SmoothMotion, contact: Sustained, spring: Spring) -> Outcome | None:
    """Begin unloading, and settle slip that has stopped; without restitution the contact is over."""
    _unload(motion, contact)
    if spring.coefficients.restitution == 0.0:
        return Outcome.NO_REBOUND
    if spring.expected.outcome == Outcome.STICTION and _halts(motion, spring):
        return Outcome.STICTION
    if not spring.slip:
        _settle_slip(motion, contact)
    return None


def _unload(motion: SmoothMotion, contact: Sustained) -> None:
    assert contact.spring is not None
    contact.spring.course.compression = contact.sums
    contact.spring.unload(contact.spring.surface - motion.progress.gaps.gap(contact.obstacle, motion.progress.state))


def _note_phase(contact: Sustained) -> None:
    """Record the phase that begins."""
    spring = contact.spring
    assert spring is not None
    spring.course.phases.append(SpringPhase(spring.loading, spring.slip, contact.sums[0]))


def _halts(motion: SmoothMotion, spring: Spring) -> bool:
    """Whether a contact is over where the rigid-body law stops: in its limit, and where a single rigid link alone is of interest."""
    single = motion.progress.plan.single_contact and motion.progress.mechanism.lone
    return single or not spring.expected.moves


def _opened(motion: SmoothMotion, contact: Sustained, spring: Spring) -> bool:
    """Whether the spring has unloaded to within ``OPENED`` of its residual penetration where nothing vibrates."""
    if spring.loading or (spring.expected.moves and not motion.progress.mechanism.lone):
        return False
    penetration = spring.surface - motion.progress.gaps.gap(contact.obstacle, motion.progress.state)
    return penetration - spring.residual < OPENED * (spring.deepest - spring.residual)


def _settle_slip(motion: SmoothMotion, contact: Sustained) -> None:
    """Let the point stick where slip has stopped if friction suffices, else slip the way it is driven."""
    progress, spring = motion.progress, contact.spring
    assert spring is not None
    spring.slip, others = 0, [each for each in motion.sustained if each is not contact]
    follow_bodies(progress, contact.obstacle, spring)
    springs = [contact, *(each for each in others if each.spring is not None)]
    load = ContactLoad(progress.scene, motion.rigid, springs)
    length = PROBE * min(spring.expected.duration, _quickest(spring))
    probe = spring.expected.stepper.advance(progress.scene, progress.state, length, load)
    rigid = 0 if motion.rigid is None else TOTALS * len(motion.rigid.obstacles)
    spring.stick_force, later = probe.totals[rigid + 4 : rigid + 6]
    state, force = progress.state, spring.stick_force
    if spring.loading and not contact.sums[0]:
        # Both forces are zero at the first touch.
        state, force = probe.state, later
    penetration = spring.surface - progress.gaps.gap(contact.obstacle, state)
    limit = CONE_ROUNDING * spring.friction * spring.present_stiffness * (penetration - spring.residual)
    if spring.compliance_in_stick and spring.spare_friction(penetration, force) < -limit:
        spring.slip = -1 if force > 0.0 else 1


def _quickest(spring: Spring) -> float:
    """Return the time scale of slip: pi/sqrt(k K). With a heavy last link it is far shorter than the contact."""
    most = float(spring.inverse_mass[0, 0]) + spring.friction * abs(float(spring.inverse_mass[0, 1]))
    most *= spring.present_stiffness
    return math.pi / math.sqrt(most) if most else math.inf
