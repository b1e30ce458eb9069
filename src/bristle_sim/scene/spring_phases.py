"""The phases of a contact with springs: touch, loading and unloading, stick and slip, release.

Only :func:`bristle_sim.scene.run.decide` calls these functions.
"""

from __future__ import annotations

import math
from dataclasses import replace

from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.contact import Outcome, Sums, sums_of
from bristle_sim.scene.events import Kind
from bristle_sim.scene.extrapolation import IntervalResult
from bristle_sim.scene.motion import Motion
from bristle_sim.scene.pairs import ContactPair
from bristle_sim.scene.spring import SpringContact, spring_forces
from bristle_sim.scene.system import System

STOPS_TOGETHER = 1e-5
"""Approach speed at the end of slip, as a fraction of the approach speed at the first touch, up to
which compression ends together with slip. Slip and approach of a link with one degree of freedom
end at the same instant, except for the effect of its motion during the contact."""

LEAST_UNLOADING = 1e-5
"""Fraction of the unloading that remains when slip starts or stops, below which the contact ends.
Only 1e-10 of the impulse then remains, and the force is so small that rounding error of the tip's
position would start and stop slip endlessly."""

LEAST_REMAINDER = 1e-14
"""Remaining unloading (engine units) below which the contact ends likewise. The position of the tip
of a wire of links has rounding errors of this order."""

PROBED_FRACTION = 0.02
"""Length of the trial interval from which the force in stick is computed when slip stops, as a
fraction of the contact's duration."""

CONE_ROUNDING = 1e-9
"""Largest excess of a force in stick over the friction limit, as a fraction of the limit, that
counts as rounding error."""


def begin_spring(
    system: System, motion: Motion, pair: ContactPair, press: float = 0.0
) -> SpringContact | None:
    """Return the contact with a spring that begins with a touch; None if the touch is an impact.

    Args:
        system: the run.
        motion: the motion before the touch.
        pair: the link and the obstacle that touch.
        press: acceleration (engine units) at which the contact point, if it were at rest, would
            approach the obstacle.
    """
    law = system.law_of(pair)
    assert isinstance(law, CompliantLaw)
    spring = law.spring(system.scene, system.state, pair, press)
    if spring is not None:
        look_up_slip(system, motion, spring)
    return spring


def pressed_on(system: System, motion: Motion, pair: ContactPair) -> SpringContact | None:
    """Return a new contact with a spring for a tip that rests on the surface after a contact.

    Return None if no force presses the tip against the surface, or if the wire has another contact.
    A static load F compresses a spring of stiffness k by F/k. For the load of the belt and a
    contact that is not very short, this compression exceeds the requested accuracy. The tip then
    cannot be treated as a rigid contact. Without restitution, a new contact with a spring follows
    each one that ends.
    """
    own = set(system.wires_of(pair))
    coupled = any(own & set(system.wires_of(contact.pair)) for contact in motion.contacts)
    if coupled or not system.waiting:
        return None
    instant = system.plan.instant
    ahead = system.flight.advance(system.scene, system.state, instant).state
    press = (system.approach(pair) - system.closest(pair, ahead).velocity[0]) / instant
    return begin_spring(system, motion, pair, press) if press > 0.0 else None


def look_up_slip(system: System, motion: Motion, spring: SpringContact) -> None:
    """Set whether a contact point slips or sticks, and the sense of slip; record the new phase."""
    slip = system.closest(spring.pair).velocity[1]
    if abs(slip) > system.slip_error(spring.start) and not spring.elastic:
        spring.slip = int(math.copysign(1.0, slip))
    else:
        _settle_slip(system, motion, spring)
    spring.begin_phase()


def change_spring(
    system: System, motion: Motion, spring: SpringContact, kind: Kind
) -> Outcome | None:
    """Change the phase of a contact with a spring after an event of the given kind.

    Returns:
        The contact's outcome if it ends; None if it continues.
    """
    before = (spring.law.loading, spring.slip)
    penetration = system.penetration(spring)
    if spring.elastic:
        spring.stick_force = spring.forces(penetration)[1]
    outcome = _change(system, motion, spring, kind)
    if outcome is not None:
        return outcome
    # Bodies that vibrate may press the contact point in a second time, so their contact is not
    # ended early.
    law = spring.law
    quiet = not law.loading and (system.mechanism.single_link or system.follows_law)
    least = max(LEAST_UNLOADING * ((law.deepest or 0.0) - law.residual), LEAST_REMAINDER)
    if quiet and penetration - law.residual < least:
        return Outcome.REBOUND
    turned = before != (law.loading, spring.slip)
    if turned:
        spring.begin_phase()
    if spring.jams and (kind is Kind.BALANCED if spring.elastic else turned and not spring.slip):
        if not system.law.finite_duration:
            return Outcome.JAM
        # The bodies move during the contact, so it may still end with a rebound.
        counts = (len(spring.rows), len(spring.phases))
        spring.stopped_at = (system.state, spring.impulse, spring.work, *counts)
    return None


def _change(system: System, motion: Motion, spring: SpringContact, kind: Kind) -> Outcome | None:
    """Apply an event to a contact; return the contact's outcome, or None if it continues."""
    penetration = system.penetration(spring)
    if spring.at_rest and kind in (Kind.REST_ENDS, Kind.FOOT_STOPS):
        # The force of a tangential spring begins its next oscillation at the friction of compression.
        spring.at_rest = False
        spring.law = replace(spring.law, deepest=penetration)
        spring.stick_force = -spring.slip * spring.law.friction * spring.law.stiffness * penetration
    match kind:
        case Kind.COMPRESSION_ENDS:
            return _end_compression(system, motion, spring)
        case Kind.UNLOADED:
            return Outcome.REBOUND
        case Kind.OVERDUE:
            if spring.stopped_at is not None:
                system.state, spring.impulse, spring.work, rows, phases = spring.stopped_at
                system.clearances.clear()
                del spring.rows[rows:], spring.phases[phases:]
                spring.compression = None
            # The law predicts a rebound, but the force at the root presses the tip on: it stays.
            rebounds = spring.predicted == Outcome.REBOUND
            return Outcome.STICTION if rebounds else Outcome(spring.predicted)
        case Kind.PRESSED_ON:
            spring.at_rest = False
            spring.law = replace(spring.law, deepest=None)
            if spring.elastic or not spring.slip:
                _settle_slip(system, motion, spring)
        case Kind.CONE_REACHED:
            spring.slip = -1 if spring.stick_force > 0.0 else 1
        case Kind.FOOT_STOPS:
            sense = spring.slip
            _settle_slip(system, motion, spring)
            if spring.elastic:
                # The foot's velocity falls through zero, so the force returns from the cone's edge
                # into the cone. Without friction the cone is a line, and the slip is reversed.
                spring.slip = 0 if spring.law.coefficient else -sense
            stopped = not (spring.elastic or spring.slip) and _ends_in_stiction(system, spring)
            # With one degree of freedom slip and compression end together, except for the effect of
            # the motion during the contact.
            at_touch = -system.closest(spring.pair, spring.start).velocity[0]
            together = -system.approach(spring.pair) <= STOPS_TOGETHER * at_touch
            if spring.law.loading and (stopped or together):
                return _end_compression(system, motion, spring)
    return None


def _end_compression(system: System, motion: Motion, spring: SpringContact) -> Outcome | None:
    """Begin unloading, and return the contact's outcome if it ends; None if it continues.

    A contact without restitution ends when compression ends. In a contact that continues, a contact
    point that sticks may start to slip again.
    """
    spring.unload(system.penetration(spring))
    if spring.law.restitution == 0.0:
        return Outcome.NO_REBOUND
    if _ends_in_stiction(system, spring):
        return Outcome.STICTION
    spring.at_rest = _slips_at_rest(system, motion, spring)
    if not spring.at_rest and (spring.elastic or not spring.slip):
        _settle_slip(system, motion, spring)
    return None


def _slips_at_rest(system: System, motion: Motion, spring: SpringContact) -> bool:
    """Return whether the contact point continues to slip at its greatest depth ("slip at rest").

    In this phase the contact point slips while its normal velocity stays zero. Compression and
    restitution have different coefficients of friction, hence different friction forces. The phase
    begins if the friction of restitution would drive the contact point deeper while the friction of
    compression would lift it. Neither unloading nor further loading is then possible. The friction
    force takes the value between the two that keeps the normal velocity at zero.

    If friction presses the point into the surface, the friction of restitution is the greater one.
    If friction lifts the point, which other bodies press in, the friction of restitution is the
    smaller one. With a tangential spring the force oscillates between the two; the mean of a fast
    oscillation is the same friction force.
    """
    coupling = spring.inverse_mass[0][1]
    law = spring.law
    if (law.restitution_friction - law.friction) * spring.slip * coupling <= 0.0:
        return False
    slip = system.closest(spring.pair).velocity[1]
    if spring.slip * slip <= spring.least_slip_at_rest:
        return False
    before = spring.stick_force
    spring.at_rest = True
    spring.follow_bodies(system.scene, system.state)
    mean = _probe(system, motion, spring)[1].tangential_at_start
    holds = min(spring.rest_margins(law.deepest or 0.0, mean)) > 0.0
    spring.stick_force = mean if holds else before
    return holds


def _ends_in_stiction(system: System, spring: SpringContact) -> bool:
    """Return whether the impact law applies to a contact and predicts stiction."""
    return system.follows_law and spring.predicted == Outcome.STICTION


def _settle_slip(system: System, motion: Motion, spring: SpringContact) -> None:
    """Decide whether the contact point sticks after its slip has stopped.

    The point sticks if the force in stick is within the friction limit. Otherwise the point slips
    in the sense in which the other forces drive it.
    """
    if spring.elastic:
        _settle_foot(system, motion, spring)
        return
    spring.slip = 0
    spring.follow_bodies(system.scene, system.state)
    probe, sums = _probe(system, motion, spring)
    spring.stick_force = force = sums.tangential_at_start
    penetration = system.penetration(spring)
    if spring.law.loading and not spring.impulse[0]:
        # Both forces are zero at the first touch.
        force = sums.tangential
        penetration = system.penetration(spring, probe.state)
    limit = CONE_ROUNDING * spring.spare_friction(penetration, 0.0)
    if not spring.compliance_in_stick:  # the probe is free of friction
        slip = system.closest(spring.pair, probe.state).velocity[1]
        spring.slip = int(math.copysign(1.0, slip)) if slip else 0
    elif spring.spare_friction(penetration, force) < -limit:
        spring.slip = -1 if force > 0.0 else 1


def _settle_foot(system: System, motion: Motion, spring: SpringContact) -> None:
    """Decide whether the foot of the tangential spring, the end on the surface, slides.

    The foot slides if the spring's force is at the friction limit and would otherwise exceed it.
    The force would exceed the limit if the foot's velocity has the sense that the force opposes. If
    this velocity is smaller than its error, a short trial integration with the force at the limit
    gives the sense in which the velocity grows.
    """
    pair = spring.pair
    touch = system.closest(pair)
    at_edge = spring.set_foot(spring.surface - touch.gap, system.along(pair, system.state))
    force = spring.stick_force
    smooth = not spring.law.coefficient
    driven = -force or touch.velocity[1]
    spring.slip = int(math.copysign(1.0, driven))
    speed = spring.slip * spring.law.foot_velocity(touch.velocity, spring.slip)
    if at_edge and not smooth and abs(speed) <= system.slip_error(spring.start):
        probe, _ = _probe(system, motion, spring)
        later = system.closest(pair, probe.state)
        speed = spring.slip * spring.law.foot_velocity(later.velocity, spring.slip) - speed
    if not (smooth or (at_edge and speed > 0.0)):
        spring.slip = 0


def _probe(system: System, motion: Motion, spring: SpringContact) -> tuple[IntervalResult, Sums]:
    """Integrate over a short trial interval, with the contact in its present phase.

    Returns:
        The result of the interval.
        The contact's forces, impulses and work in the interval.
    """
    others = [other for other in motion.springs if other is not spring]
    forces = spring_forces(system.scene, [spring, *others])
    # If the last link is heavy, the time scale of slip, pi/sqrt(k K), is far below the contact's
    # duration.
    normal, coupling = spring.inverse_mass[0]
    law = spring.law
    most = (normal + law.coefficient * abs(coupling)) * law.stiffness * law.steepness
    length = PROBED_FRACTION * min(spring.duration, math.pi / math.sqrt(most) if most else math.inf)
    probe = spring.stepper.advance(system.scene, system.state, length, motion.rigid, forces)
    index = 0 if motion.rigid is None else len(motion.rigid.closed)
    return probe, sums_of(probe.totals, index)
