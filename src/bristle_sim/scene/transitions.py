"""What follows a change of contact: after a touch the impact law, and then sustained contact, separation or the end."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bristle_sim.scene.contact.gaps import opening_rate
from bristle_sim.scene.contact.laws import Coefficients, EnergeticLaw
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.sustained import STILL, Sustained
from bristle_sim.scene.contact.wire_joints import at_joint
from bristle_sim.scene.events.functions import Change, HandOver, Slip, Touch
from bristle_sim.scene.progress import Progress, Rebound
from bristle_sim.scene.smooth_motion import SmoothMotion
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactAtEnd, ContactRecord

LOSSLESS = 1e-12
"""Fraction of the speed that an impact may lose by rounding."""

MOST_AT_ONCE = 64
"""Impacts at one instant after which links are wedged, times the square of the number of contacts that pass them on."""


def first_motion(progress: Progress) -> SmoothMotion:
    """Return the motion with which a run starts."""
    motion = SmoothMotion(progress, None)
    if (known := progress.plan.contact) is not None:
        for each in progress.obstacles:
            if known.obstacle == each.name:
                lasts = known.state == "sustained contact"
                return _next(progress, [Sustained(each)] if lasts else (), () if lasts else [each])
    for obstacle in progress.obstacles:
        if progress.stopped or not progress.touches(obstacle):
            continue
        if progress.gaps.touch(obstacle, progress.state).velocity[0] <= 0.0:
            motion = enter(motion, Touch(obstacle))
        elif not motion.sustained:
            motion = SmoothMotion(progress, progress.first_interval, (), [*motion.separating, obstacle])
    return motion


def enter(motion: SmoothMotion, change: Change) -> SmoothMotion:
    """Return the motion that follows a change of contact."""
    if isinstance(change, Touch):
        return _after_touch(motion, change)
    if isinstance(change, Slip):
        for each in motion.sustained:
            if each.obstacle is change.obstacle:
                each.turn(change.sense)
        return _next(motion.progress, motion.sustained, motion.separating)
    leaving = [change.obstacle] if isinstance(change, HandOver) else list(change.obstacles)
    kept = [each for each in motion.sustained if each.obstacle not in leaving]
    separating = list(motion.separating)
    if isinstance(change, HandOver):
        end(motion, change.following.name, leaving)
        kept.append(Sustained(change.following))
    else:
        _release(motion, leaving)
        separating += leaving
    return _next(motion.progress, kept, separating)


def contact_at_end(motion: SmoothMotion) -> ContactAtEnd:
    """Return what a run that ends here is resumed from."""
    if motion.sustained:
        return ContactAtEnd("sustained contact", motion.sustained[-1].obstacle.name)
    return ContactAtEnd("separating", motion.separating[-1].name) if motion.separating else ContactAtEnd()


def end(motion: SmoothMotion, outcome: str, obstacles: Sequence[Obstacle] | None = None) -> None:
    """End sustained contacts, all or those of some obstacles, and record them."""
    progress = motion.progress
    progress.scene.release()
    for each in motion.sustained:
        if obstacles is None or each.obstacle in obstacles:
            record = each.record(progress.gaps, progress.state, outcome)
            if record is not None:
                progress.contact(record, each.obstacle)


def _release(motion: SmoothMotion, obstacles: Sequence[Obstacle], outcome: str = "release") -> None:
    """Leave obstacles, whose forces have fallen to zero or which an impact has ended."""
    progress = motion.progress
    end(motion, outcome, obstacles)
    for each in obstacles:
        progress.event(f"{each.name} release", progress.state.time, progress.wires_of(each))


def _next(progress: Progress, sustained: Sequence[Sustained], separating: Sequence[Obstacle]) -> SmoothMotion:
    return SmoothMotion(progress, progress.first_interval, sustained, separating)


def _stopped(motion: SmoothMotion) -> SmoothMotion:
    """Record the sustained contacts of a run that an impact has stopped; return a motion without any."""
    if len(motion.progress.mechanism.links) > 1:  # a single link's have been released before the impact
        end(motion, str(motion.progress.recording.stop_reason))
    return _next(motion.progress, (), ())


def _after_touch(motion: SmoothMotion, touch: Touch) -> SmoothMotion:
    """Resolve an impact and those that follow it at the same instant; return the motion after it."""
    progress, obstacle = motion.progress, at_joint(motion.progress, touch.obstacle)
    if any(each.obstacle is obstacle for each in motion.sustained):
        # Another piece of the same link takes over.
        end(motion, obstacle.name, [obstacle])
    elif len(progress.mechanism.links) == 1:
        _release(motion, [each.obstacle for each in motion.sustained])
    elif touch.rests:
        # Coupled links would pass a hop on to each other for ever: all that touches is at rest together.
        progress.event(f"{obstacle.name} touch", progress.state.time, progress.wires_of(obstacle))
        others = [each for each in motion.separating if each is not obstacle]
        return _next(progress, [*motion.sustained, Sustained(obstacle)], others)
    left = least_opening_rate(progress, obstacle)
    first = not progress.touched(obstacle)
    progress.scene.release()
    try:
        record = _resolve(progress, obstacle, rests=touch.rests or left <= STILL)
    except ValueError as error:
        if first:
            raise
        progress.stop(StopReason.UNRESOLVED, str(error))
        return _stopped(motion)
    jams = record.outcome == "jam" or left < -STILL
    if jams:
        progress.stop(StopReason.JAM)
    progress.event(touch_event(obstacle.name, first), record.time, progress.wires_of(obstacle))
    if jams:
        progress.event("jam", progress.state.time, progress.wires_of(obstacle))
        return _stopped(motion)
    if record.duration:
        obstacle = progress.in_dent(obstacle)
    if len(progress.mechanism.links) > 1:
        return _after_all_touches(motion, obstacle, record)
    if record.outcome != "rebound" or _stays(progress, obstacle, record):
        return _next(progress, [Sustained(obstacle)], ())
    progress.rebound = Rebound(obstacle, progress.state.time, record.velocity_after[0])
    return _next(progress, (), [obstacle])


def _after_all_touches(motion: SmoothMotion, touched: Obstacle, record: ContactRecord) -> SmoothMotion:
    """Resolve what the impact makes of other closed contacts, the fastest approach first; return the motion after it."""
    progress = motion.progress
    lasting = {each.obstacle: each for each in motion.sustained}
    closed = list(dict.fromkeys([touched, *lasting, *motion.separating]))
    jams = False
    for _ in range(MOST_AT_ONCE * len(closed) ** 2):
        rates = {each: progress.gaps.touch(each, progress.state).velocity[0] for each in closed}
        fastest = min(rates, key=rates.__getitem__)
        if rates[fastest] >= -progress.slow:
            break
        record = _resolve(progress, fastest, rests=False)
        if record.duration:
            closed = [progress.in_dent(each) if each is fastest else each for each in closed]
        if jams := record.outcome == "jam":
            break
    else:
        jams = True
    if jams:
        progress.stop(StopReason.JAM)
        progress.event("jam", progress.state.time, progress.wires_of(fastest))
        return _stopped(motion)
    leaving = [each for each in closed if rates[each] > progress.slow]
    staying = [each for each in closed if each not in leaving]
    _release(motion, [each for each in lasting if each in leaving], touched.name)
    for contact in lasting.values():
        contact.slip = None
    return _next(progress, [lasting.get(each) or Sustained(each) for each in staying], leaving)


def _resolve(progress: Progress, obstacle: Obstacle, *, rests: bool) -> ContactRecord:
    """Carry the run through the impact by the obstacle's law, or one that leaves no approach."""
    law = progress.law if obstacle.name == "workpart" else EnergeticLaw()
    coefficients = Coefficients.of(obstacle)
    approach = -progress.gaps.touch(obstacle, progress.state).velocity[0]
    if rests or approach <= progress.slow:
        law, coefficients = EnergeticLaw(), Coefficients(obstacle.friction, obstacle.restitution_friction, 0.0)
    after, record = law.resolve(progress.scene, progress.state, obstacle, coefficients)
    progress.contact(record, obstacle)
    if record.history is not None:
        progress.sample(0.0)
    progress.state = after
    progress.sample(0.0)
    return record


def least_opening_rate(progress: Progress, obstacle: Obstacle) -> float:
    """Return how fast the gap between an obstacle that a single link touches and another one that it touches opens."""
    if len(progress.mechanism.links) > 1:
        return math.inf
    gaps, state = progress.gaps, progress.state
    touch = gaps.touch(obstacle, state)
    closed = [each for each in progress.obstacles if each is not obstacle and progress.touches(each)]
    return min((opening_rate(touch, gaps.touch(each, state)) for each in closed), default=math.inf)


def _stays(progress: Progress, obstacle: Obstacle, record: ContactRecord) -> bool:
    """Whether a rebound is too slow to be followed, or so low that fixed steps would repeat it for ever.

    A step drifts before it kicks: a hop under the acceleration a arrives by a h faster than it left, and restitution
    e leaves no less than e a h/(1 - e), the speed of a hop of (1 + e)/(1 - e) steps.
    """
    arrival, speed = -record.velocity_before[0], record.velocity_after[0]
    if speed <= progress.slow:
        return True
    last, step = progress.rebound, getattr(progress.stepper, "step", 0.0)
    if last is None or last.obstacle.name != obstacle.name or arrival - speed <= LOSSLESS * arrival:
        return False
    hop = record.time - last.time
    low = speed**2 * hop <= 2.0 * (arrival + last.speed) * progress.stepper.noise
    return low and hop * (arrival - speed) <= 2.0 * step * (arrival + speed)


def touch_event(obstacle: str, first: bool) -> str:
    """Return the name of a touch: the first one of the workpart is the strike."""
    return f"{obstacle} touch" if obstacle != "workpart" else "strike" if first else "workpart touch"
