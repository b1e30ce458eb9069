"""What follows a change of contact: which contacts stay closed, after impacts if there are any, and which leave."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bristle_sim.scene.contact.gaps import at_joint, opening_rate
from bristle_sim.scene.contact.laws import ENERGETIC, Coefficients
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.rigid import LEAST_SLIP
from bristle_sim.scene.contact.sustained import Outcome, Sustained
from bristle_sim.scene.events.functions import Change, HandOver, Kink, Slip, SpringChange, Touch
from bristle_sim.scene.motion import SmoothMotion
from bristle_sim.scene.progress import Progress
from bristle_sim.scene.spring_contact import after_impact, begin_spring, change_spring
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactRecord

MOST_AT_ONCE = 64
"""Impacts at one instant after which links are wedged, times the square of the number of contacts that pass them on."""


def first_motion(progress: Progress) -> SmoothMotion:
    """Return the motion with which a run starts."""
    motion = SmoothMotion(progress, None)
    for obstacle in progress.obstacles:
        if progress.stopped or not progress.touches(obstacle):
            continue
        if progress.gaps.closest(obstacle, progress.state).velocity[0] <= 0.0:
            motion = enter(motion, Touch(obstacle))
        elif not motion.sustained:
            motion = SmoothMotion(progress, progress.first_interval, (), [*motion.separating, obstacle])
    return motion


def enter(motion: SmoothMotion, change: Change) -> SmoothMotion:
    """Return the motion that follows a change of contact."""
    if isinstance(change, Touch):
        return _after_touch(motion, change)
    if isinstance(change, SpringChange):
        return _after_spring(motion, change)
    if isinstance(change, Slip):
        change.contact.turn(change.sense)
    if isinstance(change, Slip | Kink):
        return following(motion.progress, motion.sustained, motion.separating)
    leaving = [change.obstacle] if isinstance(change, HandOver) else list(change.obstacles)
    kept = [each for each in motion.sustained if each.obstacle not in leaving]
    separating = list(motion.separating)
    if isinstance(change, HandOver):
        end(motion, change.following.name, leaving)
        kept.append(Sustained(change.following))
    else:
        _release(motion, leaving)
        separating += leaving
    return following(motion.progress, kept, separating)


def following(progress: Progress, sustained: Sequence[Sustained], separating: Sequence[Obstacle]) -> SmoothMotion:
    """Return a motion with these contacts, or the end of the run after a touch whose contact is over."""
    if progress.ends_after_touch and not any(each.spring for each in sustained):
        progress.stop(StopReason.EVENT)
        return SmoothMotion(progress, progress.first_interval)
    return SmoothMotion(progress, progress.first_interval, sustained, separating)


def end(motion: SmoothMotion, outcome: str, obstacles: Sequence[Obstacle] | None = None) -> None:
    """End sustained contacts, all or those of some obstacles, and record them."""
    progress = motion.progress
    progress.scene.release()
    for each in motion.sustained:
        if obstacles is None or each.obstacle in obstacles:
            record = each.record(progress.gaps, progress.state, outcome)
            if record is not None:
                progress.contact(record, each.obstacle)


def _release(motion: SmoothMotion, obstacles: Sequence[Obstacle], outcome: str = Outcome.RELEASE) -> None:
    """Leave obstacles, whose forces have fallen to zero or which an impact has ended."""
    progress = motion.progress
    end(motion, outcome, obstacles)
    for each in obstacles:
        progress.event(f"{each.name} release", progress.state.time, progress.wires_of(each))


def _stopped(motion: SmoothMotion, lasting: Sequence[Sustained]) -> SmoothMotion:
    """Record the contacts of a run that an impact has stopped; return a motion without any."""
    end(motion, str(motion.progress.recording.stop_reason), [each.obstacle for each in lasting])
    return following(motion.progress, (), ())


def _after_spring(motion: SmoothMotion, change: SpringChange) -> SmoothMotion:
    """Return the motion after a phase of a contact with a spring, or after its end."""
    progress, contact = motion.progress, change.contact
    outcome = change_spring(motion, change)
    kept = [each for each in motion.sustained if each is not contact]
    if outcome is None:
        return following(progress, motion.sustained, motion.separating)
    if outcome is Outcome.REBOUND and contact.spring is not None:
        contact.spring.course.let_go()
    end(motion, outcome, [contact.obstacle])
    obstacle = progress.in_dent(contact.obstacle)
    if outcome is Outcome.JAM:
        progress.stop(StopReason.JAM)
        progress.sample()
        progress.event("jam", progress.state.time, progress.wires_of(obstacle))
        return following(progress, kept, motion.separating)
    # A spring without restitution pushes no more: where the tip is pressed on, it touches the ground of its dent.
    spent = outcome is Outcome.NO_REBOUND and contact.spring is not None and contact.spring.expected.moves
    if spent or (outcome is Outcome.REBOUND and progress.approach(obstacle) > progress.slow):
        progress.event(f"{obstacle.name} release", progress.state.time, progress.wires_of(obstacle))
        return following(progress, kept, [*motion.separating, obstacle])
    return following(progress, [*kept, Sustained(obstacle)], motion.separating)


def _after_touch(motion: SmoothMotion, touch: Touch) -> SmoothMotion:
    """Begin a contact, with a spring or at rest, or resolve impacts; return the motion after it."""
    progress, obstacle = motion.progress, at_joint(motion.progress, touch.obstacle)
    name = f"{obstacle.name} touch" if progress.touched(obstacle) else obstacle.first_touch
    takes_over = any(each.obstacle is obstacle for each in motion.sustained)
    if not (obstacle.law.at_once or touch.rests or takes_over) and -progress.approach(obstacle) > progress.slow:
        try:
            spring = obstacle.law.spring(progress.scene, progress.state, obstacle)
        except ValueError as error:
            return _given_up(motion, motion.sustained, error)
        if spring is not None:
            contact = begin_spring(motion, obstacle, spring)
            progress.event(name, progress.state.time, progress.wires_of(obstacle), lasts=True)
            return _with(motion, contact)
    if touch.rests and not (takes_over or progress.mechanism.lone):
        # Coupled links would pass a hop on to each other for ever: all that touches is at rest together.
        progress.event(name, progress.state.time, progress.wires_of(obstacle))
        return _with(motion, Sustained(obstacle))
    return _after_impact(motion, obstacle, name, rests=touch.rests)


def _given_up(motion: SmoothMotion, lasting: Sequence[Sustained], error: ValueError) -> SmoothMotion:
    """End the run at a contact that its law cannot resolve, with the law's advice; the first contact must be resolved."""
    if not motion.progress.recording.contacts:
        raise error
    motion.progress.stop(StopReason.UNRESOLVED, str(error))
    return _stopped(motion, lasting)


def _with(motion: SmoothMotion, contact: Sustained) -> SmoothMotion:
    """Return a motion with a further contact."""
    others = [each for each in motion.separating if each is not contact.obstacle]
    return following(motion.progress, [*motion.sustained, contact], others)


def _after_impact(motion: SmoothMotion, obstacle: Obstacle, name: str, *, rests: bool) -> SmoothMotion:
    """Resolve an impact and those that follow it at the same instant; return the motion after it."""
    progress, lasting, lone = motion.progress, list(motion.sustained), motion.progress.mechanism.lone
    if any(each.obstacle is obstacle for each in lasting):
        # Another piece of the same link takes over.
        end(motion, obstacle.name, [obstacle])
        lasting = [each for each in lasting if each.obstacle is not obstacle]
    elif lone:
        _release(motion, [each.obstacle for each in lasting if each.spring is None])
        lasting = [each for each in lasting if each.spring is not None]
    left = least_opening_rate(progress, obstacle)
    progress.scene.release()
    try:
        record = _resolve(progress, obstacle, rests=rests or left <= LEAST_SLIP)
    except ValueError as error:
        return _given_up(motion, lasting, error)
    jams = record.outcome == Outcome.JAM or left < -LEAST_SLIP
    if jams:
        progress.stop(StopReason.JAM)
    progress.event(name, record.time, progress.wires_of(obstacle))
    if jams:
        progress.event("jam", progress.state.time, progress.wires_of(obstacle))
        return _stopped(motion, lasting)
    if not lone:
        return _after_all_touches(motion, obstacle, lasting)
    springs = after_impact(motion, lasting)
    if record.outcome != Outcome.REBOUND or record.velocity_after[0] <= progress.slow:
        return following(progress, [*springs, Sustained(obstacle)], ())
    return following(progress, springs, [obstacle])


def _after_all_touches(motion: SmoothMotion, touched: Obstacle, before: Sequence[Sustained]) -> SmoothMotion:
    """Resolve what the impact makes of other closed contacts, the fastest approach first; return the motion after it."""
    progress = motion.progress
    lasting = {each.obstacle: each for each in before if each.spring is None}
    closed = list(dict.fromkeys([touched, *lasting, *motion.separating]))
    jams = False
    for _ in range(MOST_AT_ONCE * len(closed) ** 2):
        rates = {each: progress.approach(each) for each in closed}
        fastest = min(rates, key=rates.__getitem__)
        if rates[fastest] >= -progress.slow:
            break
        if jams := _resolve(progress, fastest, rests=False).outcome == Outcome.JAM:
            break
    else:
        jams = True
    if jams:
        progress.stop(StopReason.JAM)
        progress.event("jam", progress.state.time, progress.wires_of(fastest))
        return _stopped(motion, before)
    leaving = [each for each in closed if rates[each] > progress.slow]
    staying = [each for each in closed if each not in leaving]
    _release(motion, [each for each in lasting if each in leaving], touched.name)
    for contact in lasting.values():
        contact.slip = None
    springs = after_impact(motion, [each for each in before if each.spring is not None])
    return following(progress, [*(lasting.get(each) or Sustained(each) for each in staying), *springs], leaving)


def _resolve(progress: Progress, obstacle: Obstacle, *, rests: bool) -> ContactRecord:
    """Carry the run through the impact by the obstacle's law, or one that leaves no approach."""
    law, coefficients = obstacle.law, Coefficients.of(obstacle)
    if rests or -progress.approach(obstacle) <= progress.slow:
        law, coefficients = ENERGETIC, Coefficients(obstacle.friction, obstacle.restitution_friction, 0.0)
    after, record = law.resolve(progress.scene, progress.state, obstacle, coefficients)
    progress.contact(record, obstacle)
    progress.state = after
    progress.sample()
    return record


def least_opening_rate(progress: Progress, obstacle: Obstacle) -> float:
    """Return how fast the gap between an obstacle that a lone link touches and another one that it touches opens."""
    if not progress.mechanism.lone:
        return math.inf
    gaps, state = progress.gaps, progress.state
    touch = gaps.closest(obstacle, state)
    closed = [each for each in progress.obstacles if each is not obstacle and progress.touches(each)]
    return min((opening_rate(touch, gaps.closest(each, state)) for each in closed), default=math.inf)
