"""The run of a scene: one smooth motion after another, and the decision after each change of contact between them.

In flight nothing touches and the engine's contact is off. Where a gap closes, its instant is located and the contact law
resolves the impact. If the link then rests against the obstacle and is pressed on it, the contact is sustained, with Coulomb
friction, until its force has fallen to zero; the instant of release is located too. Several contacts may be sustained at a
time. After every interval, links in sustained contact are set back onto their obstacles, because the engine's contact
constrains only velocities.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.gaps import GAP_ROUNDING, at_joint, opening_rate
from bristle_sim.scene.contact.laws import ENERGETIC
from bristle_sim.scene.contact.obstacles import Obstacle, dented
from bristle_sim.scene.contact.rigid import LEAST_SLIP
from bristle_sim.scene.contact.sustained import Outcome, Sustained
from bristle_sim.scene.events.locate import Interval
from bristle_sim.scene.events.table import Change, HandOver, Kink, Release, Slip, SpringChange, Touch
from bristle_sim.scene.extrapolation import Stepper
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.motion import SmoothMotion
from bristle_sim.scene.progress import Plan, Progress, Recording
from bristle_sim.scene.spring_contact import after_impact, begin_spring, change_spring, pressed_on
from bristle_sim.settings import StopReason
from bristle_sim.trajectory import ContactRecord

MOST_IMPACTS_AT_ONCE = 64  # times the square of the number of contacts that pass them on; then links are wedged


def run(
    scene: Scene, start: State, stepper: Stepper, plan: Plan, obstacles: Sequence[Obstacle] | None = None
) -> Recording:
    """Run a scene from a state to the plan's end; ``obstacles`` are the pairs, those of the scene by default."""
    budget = scene.engine.work + plan.maximum_steps
    progress = Progress(scene, start, stepper, plan, obstacles)
    motion, recording = _first_motion(progress), progress.recording
    while recording.stop_reason is None:
        if progress.state.time >= plan.end * (1.0 - 1e-15):
            progress.stop(StopReason.END)
        elif scene.engine.work >= budget:
            progress.stop(StopReason.STEP_BUDGET)
        else:
            found = motion.integrate()
            change = motion.up_to_first_event(found) if isinstance(found, Interval) else found
            motion = motion if change is None else _enter(motion, change)
    _end(motion, str(recording.stop_reason), [each.obstacle for each in motion.sustained])
    return recording


def _first_motion(progress: Progress) -> SmoothMotion:
    """Return the motion with which a run starts."""
    motion = SmoothMotion(progress)
    for obstacle in progress.obstacles:
        if progress.recording.stop_reason is not None or not _touches(progress, obstacle):
            continue
        if progress.approach(obstacle) <= 0.0:
            motion = _enter(motion, Touch(obstacle))
        elif not motion.sustained:
            motion = SmoothMotion(progress, (), [*motion.separating, obstacle])
    return motion


def _touches(progress: Progress, obstacle: Obstacle) -> bool:
    return abs(progress.gaps.gap(obstacle, progress.state)) <= GAP_ROUNDING


def _enter(motion: SmoothMotion, change: Change) -> SmoothMotion:
    """Return the motion that follows a change of contact."""
    progress, sustained, separating = motion.progress, motion.sustained, motion.separating
    match change:
        case Touch(touched, rests):
            obstacle = at_joint(progress, touched)
            name = _touch_name(progress, obstacle)
            return _begin_contact(motion, obstacle, name, rests) or _after_impact(motion, obstacle, name, rests)
        case SpringChange():
            return _after_spring(motion, change)
        case Slip(contact, sense):
            contact.turn(sense)
        case Kink(dent):
            if dent is not None:
                progress.obstacles[dent] = dented(progress.obstacles[dent], 0.0)
        case HandOver(obstacle, following):
            _end(motion, following.name, [obstacle])
            sustained = (*motion.sustained, Sustained(following))
        case Release(obstacles):
            _release(motion, obstacles)
            sustained, separating = motion.sustained, (*separating, *obstacles)
    return _following(progress, sustained, separating)


def _following(progress: Progress, sustained: Sequence[Sustained], separating: Sequence[Obstacle]) -> SmoothMotion:
    """Return the motion with these contacts, or end the run if the contact that was to end it is over."""
    over = progress.recording.stop_reason is None and progress.had_last_event
    if over and not any(each.spring for each in sustained):
        progress.stop(StopReason.EVENT)
        return SmoothMotion(progress)
    return SmoothMotion(progress, sustained, separating)


def _end(motion: SmoothMotion, outcome: str, obstacles: Sequence[Obstacle]) -> None:
    """End the sustained contacts of some obstacles, and record them."""
    progress = motion.progress
    progress.scene.contacts.release()
    for each in motion.sustained:
        if each.obstacle in obstacles and (record := each.record(progress.gaps, progress.state, outcome)):
            progress.contact(record, each.obstacle)
    motion.sustained = tuple(each for each in motion.sustained if each.obstacle not in obstacles)


def _release(motion: SmoothMotion, obstacles: Sequence[Obstacle], outcome: str = Outcome.RELEASE) -> None:
    """Release contacts whose forces have fallen to zero or which an impact has ended."""
    _end(motion, outcome, obstacles)
    for each in obstacles:
        motion.progress.event(f"{each.name} release", motion.progress.wires_of(each))


def _jammed(motion: SmoothMotion, obstacle: Obstacle) -> SmoothMotion:
    """Stop the run at an impact that jams a link."""
    motion.progress.stop(StopReason.JAM)
    motion.progress.event("jam", motion.progress.wires_of(obstacle))
    return motion


def _given_up(motion: SmoothMotion, error: ValueError) -> SmoothMotion:
    """Stop the run at a contact that its law cannot resolve, with the law's advice; the first contact must be resolved."""
    if not motion.progress.recording.contacts:
        raise error
    motion.progress.stop(StopReason.UNRESOLVED, str(error))
    return motion


def _after_spring(motion: SmoothMotion, change: SpringChange) -> SmoothMotion:
    """Return the motion after a phase of a contact with a spring, or after its end."""
    progress, contact = motion.progress, change.contact
    outcome, spring, obstacle = change_spring(motion, change), contact.spring, contact.obstacle
    if outcome is None or spring is None:
        return _following(progress, motion.sustained, motion.separating)
    if outcome is Outcome.REBOUND:
        spring.course.release()
    _end(motion, outcome, [obstacle])
    gap = progress.gaps.gap(obstacle, progress.state)
    if gap < -progress.plan.accuracy and obstacle.partner is None:
        # The tip is left in a dent, whose ground is the surface from here on.
        ground = dented(obstacle, obstacle.dent - gap)
        progress.obstacles[progress.obstacles.index(obstacle)] = obstacle = ground
    wires = progress.wires_of(obstacle)
    if outcome is Outcome.JAM:
        progress.stop(StopReason.JAM)
        progress.sample()
        progress.event("jam", wires)
        return motion
    # A spring without restitution pushes no more: where the tip is pressed on, it touches the ground of its dent.
    spent = outcome is Outcome.NO_REBOUND and spring.expected.moves
    leaves = outcome is Outcome.REBOUND and progress.approach(obstacle) > progress.slow
    if not leaves and (again := pressed_on(motion, obstacle)) is not None:
        progress.event(f"{obstacle.name} release", wires)
        progress.event(_touch_name(progress, obstacle), wires, lasts=True)
        return _following(progress, [again], motion.separating)
    if spent or leaves:
        progress.event(f"{obstacle.name} release", wires)
        return _following(progress, motion.sustained, [*motion.separating, obstacle])
    return _following(progress, [*motion.sustained, Sustained(obstacle)], motion.separating)


def _touch_name(progress: Progress, obstacle: Obstacle) -> str:
    """Return the name of a touch: that of the first one, or of a later one of the same wire."""
    wire, size = progress.wires_of(obstacle)[0], progress.mechanism.wire_links
    for contact, links in progress.recording.contacts:
        if contact.obstacle == obstacle.name and wire in [link // size for link in links]:
            return f"{obstacle.name} touch"
    return obstacle.first_touch


def _begin_contact(motion: SmoothMotion, obstacle: Obstacle, name: str, rests: bool) -> SmoothMotion | None:
    """Return the motion with a new contact, with a spring or at rest; None if the touch is an impact."""
    progress, law = motion.progress, obstacle.law
    if any(each.obstacle is obstacle for each in motion.sustained):
        return None
    contact = None
    if rests and not progress.mechanism.lone:
        # Coupled links would pass a hop on to each other for ever: all touching links come to rest together.
        contact = Sustained(obstacle)
    elif not law.at_once and -progress.approach(obstacle) > progress.slow:
        try:
            spring = law.spring(progress.scene, progress.state, obstacle)
        except ValueError as error:
            return _given_up(motion, error)
        contact = None if spring is None else begin_spring(motion, obstacle, spring)
    if contact is None:
        return None
    progress.event(name, progress.wires_of(obstacle), lasts=contact.spring is not None)
    others = [each for each in motion.separating if each is not obstacle]
    return _following(progress, [*motion.sustained, contact], others)


def _after_impact(motion: SmoothMotion, obstacle: Obstacle, name: str, rests: bool) -> SmoothMotion:
    """Resolve an impact and those that follow it at the same instant; return the motion after it."""
    progress, lone = motion.progress, motion.progress.mechanism.lone
    if any(each.obstacle is obstacle for each in motion.sustained):
        # Another piece of the same link takes over.
        _end(motion, obstacle.name, [obstacle])
    elif lone:
        _release(motion, [each.obstacle for each in motion.ordered])
    left = _least_opening_rate(progress, obstacle) if lone else math.inf
    progress.scene.contacts.release()
    try:
        record = _resolve(progress, obstacle, rests=rests or left <= LEAST_SLIP)
    except ValueError as error:
        return _given_up(motion, error)
    jams = record.outcome == Outcome.JAM or left < -LEAST_SLIP
    if jams:
        progress.stop(StopReason.JAM)
    progress.event(name, progress.wires_of(obstacle))
    if jams:
        return _jammed(motion, obstacle)
    if not lone:
        return _after_all_touches(motion, obstacle)
    springs = after_impact(motion) if motion.springs else []
    if record.outcome != Outcome.REBOUND or record.velocity_after[0] <= progress.slow:
        return _following(progress, [*springs, Sustained(obstacle)], ())
    return _following(progress, springs, [obstacle])


def _least_opening_rate(progress: Progress, obstacle: Obstacle) -> float:
    """Return the least opening rate of a lone link between this obstacle and any other one that it touches."""
    touch = progress.gaps.closest(obstacle, progress.state)
    closed = [each for each in progress.obstacles if each is not obstacle and _touches(progress, each)]
    rates = (opening_rate(touch, progress.gaps.closest(each, progress.state)) for each in closed)
    return min(rates, default=math.inf)


def _after_all_touches(motion: SmoothMotion, touched: Obstacle) -> SmoothMotion:
    """Resolve other closed contacts that the impact drives together, the fastest approach first; return the motion after it."""
    progress = motion.progress
    lasting = {each.obstacle: each for each in motion.sustained if each.spring is None}
    closed = list(dict.fromkeys([touched, *lasting, *motion.separating]))
    for _ in range(MOST_IMPACTS_AT_ONCE * len(closed) ** 2):
        rates = {each: progress.approach(each) for each in closed}
        fastest = min(rates, key=rates.__getitem__)
        if rates[fastest] >= -progress.slow:
            break
        if _resolve(progress, fastest, rests=False).outcome == Outcome.JAM:
            return _jammed(motion, fastest)
    else:
        return _jammed(motion, fastest)
    leaving = [each for each in closed if rates[each] > progress.slow]
    _release(motion, [each for each in lasting if each in leaving], touched.name)
    for contact in lasting.values():
        contact.slip = None
    springs = after_impact(motion)
    staying = [lasting.get(each) or Sustained(each) for each in closed if each not in leaving]
    return _following(progress, [*staying, *springs], leaving)


def _resolve(progress: Progress, obstacle: Obstacle, *, rests: bool) -> ContactRecord:
    """Resolve the impact by the obstacle's law, or by a law without restitution."""
    before, law, touched = progress.state, obstacle.law, obstacle
    if rests or -progress.approach(obstacle) <= progress.slow:
        law, touched = ENERGETIC, replace(obstacle, restitution=0.0)
    progress.state, record = law.resolve(progress.scene, before, touched)
    progress.propagate(obstacle, before, record)
    progress.contact(record, obstacle)
    progress.sample()
    return record
