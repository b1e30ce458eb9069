"""Changes of a contact with a spring at its events: it begins, passes into another phase, or ends."""

from __future__ import annotations

import math

from bristle_sim.scene.contact.course import SpringPhase
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.rigid import TOTALS
from bristle_sim.scene.contact.spring import ContactLoad, Spring
from bristle_sim.scene.contact.sustained import Outcome, Sustained
from bristle_sim.scene.events.table import SpringChange, SpringEvent
from bristle_sim.scene.motion import SmoothMotion, follow_bodies

STOPS_TOGETHER = 1e-5  # fraction of the approach with which slip and compression of one freedom stop together

LEAST_UNLOADING = 1e-5
"""Where slip starts or stops, a contact ends if less than this fraction of its spring's unloading is left. Only 1e-10 of its
impulse is left, and the force is so small that rounding of the tip's place would start and stop slip endlessly."""

PROBED_FRACTION = 0.02  # of a contact: from here the force of stick is extrapolated back to where slip stops
CONE_ROUNDING = 1e-9  # fraction of friction's limit by which rounding may lead the force in stick beyond it


def begin_spring(motion: SmoothMotion, obstacle: Obstacle, spring: Spring) -> Sustained:
    """Return a contact that begins at the present state."""
    contact = Sustained(obstacle, spring, motion.progress.state)
    _look_up_slip(motion, contact, spring)
    return contact


def pressed_on(motion: SmoothMotion, obstacle: Obstacle) -> Sustained | None:
    """Return the contact that follows at once where the last one has left a lone link's tip at rest; None if it is not pressed.

    A spring at rest is pressed in by its load over its stiffness, which is more than the accuracy where the load is that of a
    belt and the contact is not very short; without restitution it is pressed in again and again.
    """
    progress, instant = motion.progress, motion.progress.plan.instant
    if not progress.mechanism.lone or motion.sustained or progress.had_last_event:
        return None
    ahead = progress.flight.advance(progress.scene, progress.state, instant).state
    press = (progress.approach(obstacle) - progress.gaps.gap_and_rate(obstacle, ahead)[1]) / instant
    spring = obstacle.law.spring(progress.scene, progress.state, obstacle, press) if press > 0.0 else None
    return None if spring is None else begin_spring(motion, obstacle, spring)


def after_impact(motion: SmoothMotion) -> list[Sustained]:
    """Return a motion's contacts with springs after an impact elsewhere, which changes the sense of their motion."""
    for each, spring in motion.springs:
        if spring.loading and motion.progress.approach(each.obstacle) > 0.0:
            _unload(motion, each, spring)
        _look_up_slip(motion, each, spring)
    return [each for each, _ in motion.springs]


def _look_up_slip(motion: SmoothMotion, contact: Sustained, spring: Spring) -> None:
    """Let a point slip in the sense of its motion, or stick, and record the new phase."""
    slip = motion.progress.gaps.closest(contact.obstacle, motion.progress.state).velocity[1]
    if abs(slip) > _slip_error(motion, contact) and not spring.elastic:
        spring.slip = int(math.copysign(1.0, slip))
    else:
        _settle_slip(motion, contact, spring)
    _note_phase(contact, spring)


def _note_phase(contact: Sustained, spring: Spring) -> None:
    spring.course.phases.append(SpringPhase(spring.loading, spring.slip, contact.sums[0]))


def change_spring(motion: SmoothMotion, change: SpringChange) -> Outcome | None:
    """Pass a contact into its next phase; return its outcome if it is over."""
    contact, spring, progress = change.contact, change.contact.spring, motion.progress
    assert spring is not None
    before, penetration = (spring.loading, spring.slip), _penetration(motion, contact, spring)
    if spring.elastic:
        spring.stick_force = spring.forces(penetration)[1]
    outcome = _change(motion, contact, spring, change.event)
    # Bodies that vibrate meanwhile may press the point on again.
    quiet = not spring.loading and (progress.mechanism.lone or not spring.expected.moves)
    least = LEAST_UNLOADING * ((spring.deepest or 0.0) - spring.residual)
    if outcome is None and quiet and penetration - spring.residual < least:
        return Outcome.REBOUND
    if outcome is not None or before == (spring.loading, spring.slip):
        return outcome
    _note_phase(contact, spring)
    course = spring.course
    if spring.expected.outcome == Outcome.JAM and spring.loading and not spring.slip and not spring.elastic:
        if not spring.expected.moves:
            return Outcome.JAM
        if course.stopped is None:
            # Bodies that move meanwhile may still get out.
            course.stopped = progress.state, contact.sums, len(course.rows), len(course.phases)
    return None


def _change(motion: SmoothMotion, contact: Sustained, spring: Spring, event: SpringEvent) -> Outcome | None:
    """Apply an event; return the contact's outcome if it is over."""
    expected, progress, course = spring.expected, motion.progress, spring.course
    match event:
        case SpringEvent.COMPRESSION_ENDS:
            return _end_compression(motion, contact, spring)
        case SpringEvent.UNLOADED:
            return Outcome.REBOUND
        case SpringEvent.OVERDUE:
            if course.stopped is not None:
                progress.state, contact.sums, rows, phases = course.stopped
                del course.rows[rows:], course.phases[phases:]
                course.compression = None
            stuck = expected.outcome in (Outcome.JAM, Outcome.STICTION)
            return Outcome(expected.outcome) if stuck else Outcome.NO_REBOUND
        case SpringEvent.PRESSED_ON:
            spring.deepest = None
            if spring.elastic or not spring.slip:
                _settle_slip(motion, contact, spring)
        case SpringEvent.STICK_BREAKS:
            spring.slip = -1 if spring.stick_force > 0.0 else 1
        case SpringEvent.SLIP_STOPS:
            _settle_slip(motion, contact, spring)
            stopped = not spring.slip and _ends_in_stiction(motion, spring)
            # Slip and compression of one degree of freedom stop together, up to the motion during the contact.
            together = -progress.approach(contact.obstacle) <= STOPS_TOGETHER * course.approach
            if spring.loading and not spring.elastic and (stopped or together):
                return _end_compression(motion, contact, spring)
    return None


def _end_compression(motion: SmoothMotion, contact: Sustained, spring: Spring) -> Outcome | None:
    """Begin unloading, and decide on slip that has stopped; without restitution the contact is over."""
    _unload(motion, contact, spring)
    if spring.obstacle.restitution == 0.0:
        return Outcome.NO_REBOUND
    if _ends_in_stiction(motion, spring):
        return Outcome.STICTION
    if spring.elastic or not spring.slip:
        _settle_slip(motion, contact, spring)
    return None


def _unload(motion: SmoothMotion, contact: Sustained, spring: Spring) -> None:
    spring.course.compression, spring.deepest = contact.sums, _penetration(motion, contact, spring)


def _penetration(motion: SmoothMotion, contact: Sustained, spring: Spring) -> float:
    return spring.surface - motion.progress.gaps.gap(contact.obstacle, motion.progress.state)


def _ends_in_stiction(motion: SmoothMotion, spring: Spring) -> bool:
    """Whether a rigid-body limit ends where that law stops, if only a lone link's single contact is of interest."""
    halts = not spring.expected.moves or (motion.progress.plan.single_contact and motion.progress.mechanism.lone)
    return halts and spring.expected.outcome == Outcome.STICTION


def _slip_error(motion: SmoothMotion, contact: Sustained) -> float:
    """Return the error of a slip velocity, from the speed at the first touch: a lone rod comes to rest where slip stops."""
    return motion.progress.slip_error(contact.start or motion.progress.state)


def _settle_slip(motion: SmoothMotion, contact: Sustained, spring: Spring) -> None:
    """Let the point stick where slip has stopped if friction suffices, else slip the way it is driven."""
    progress, obstacle = motion.progress, contact.obstacle
    if spring.elastic:
        touch, joint = progress.gaps.closest(obstacle, progress.state), progress.gaps.poses(progress.state)
        spring.settle(touch, joint[obstacle.link].joint[0] + touch.arm[0], _slip_error(motion, contact))
        return
    spring.slip = 0
    follow_bodies(progress, obstacle, spring)
    others = [each for each, _ in motion.springs if each is not contact]
    load = ContactLoad(progress.scene, motion.rigid, [contact, *others])
    # The time scale of slip, pi/sqrt(k K), is far below the contact's where the last link is heavy.
    normal, coupling = spring.inverse_mass[0].tolist()
    most = (normal + spring.friction * abs(coupling)) * spring.present_stiffness
    length = PROBED_FRACTION * min(spring.expected.duration, math.pi / math.sqrt(most) if most else math.inf)
    probe = spring.expected.stepper.advance(progress.scene, progress.state, length, load)
    first = 0 if motion.rigid is None else TOTALS * len(motion.rigid.obstacles)
    spring.stick_force, later = probe.totals[first + 4 : first + 6]
    force, penetration = spring.stick_force, _penetration(motion, contact, spring)
    if spring.loading and not contact.sums[0]:
        # Both forces are zero at the first touch.
        force, penetration = later, spring.surface - progress.gaps.gap(obstacle, probe.state)
    limit = CONE_ROUNDING * spring.spare_friction(penetration, 0.0)
    if spring.compliance_in_stick and spring.spare_friction(penetration, force) < -limit:
        spring.slip = -1 if force > 0.0 else 1
