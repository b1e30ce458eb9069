"""What follows a change of contact: after a touch the impact law, and then sustained contact, separation or the end."""

from __future__ import annotations

import math

from bristle_sim.scene.contact_laws import Coefficients, EnergeticLaw
from bristle_sim.scene.contact_states import (
    Change,
    ContactState,
    InFlight,
    Opening,
    Separating,
    Touch,
)
from bristle_sim.scene.engine_contact import STILL, opening_rate
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.progress import Progress, Rebound
from bristle_sim.scene.sustained_contact import InSustainedContact
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactRecord

__all__ = ["CAPTURE", "enter", "first_state"]

CAPTURE = 1e-8
"""An impact slower than this fraction of the fastest point's speed takes the rest of the approach away: repeated taps of
a restitution below 1 add up in finite time."""

LOSSLESS = 1e-12
"""Fraction of the speed that an impact may lose by rounding."""


def first_state(progress: Progress) -> ContactState:
    """Return the state of contact in which a run starts."""
    state: ContactState = InFlight(progress, None)
    for obstacle in progress.scene.effects.obstacles:
        if progress.stopped or not progress.touches(obstacle):
            continue
        if progress.gaps.touch(obstacle, progress.state).velocity[0] <= 0.0:
            state = enter(progress, state.meet(obstacle))
        elif not isinstance(state, InSustainedContact):
            state = Separating(progress, obstacle)
    return state


def enter(progress: Progress, change: Change) -> ContactState:
    """Return the state of contact that follows a change."""
    if isinstance(change, Touch):
        return _after_touch(progress, change.obstacle, rests=change.rests)
    if isinstance(change, Opening):
        return InFlight.after(progress, change)
    return Separating(progress, change.obstacle)


def _after_touch(progress: Progress, obstacle: Obstacle, *, rests: bool) -> ContactState:
    """Resolve an impact; ``rests`` takes what is left of the approach. Returns the state that follows."""
    left = least_opening_rate(progress, obstacle)
    first = not any(each.obstacle == obstacle.name for each in progress.recording.contacts)
    try:
        record = _resolve(progress, obstacle, rests=rests or left <= STILL)
    except ValueError:
        if first:
            raise
        progress.stop(StopReason.UNRESOLVED)
        return InFlight(progress, progress.first_interval)
    jams = record.outcome == "jam" or left < -STILL
    if jams:
        progress.stop(StopReason.JAM)
    progress.event(touch_event(obstacle.name, first), record.time)
    if jams:
        progress.event("jam", progress.state.time)
        return InFlight(progress, progress.first_interval)
    if record.outcome != "rebound" or _stays(progress, record):
        return InSustainedContact(progress, obstacle)
    progress.rebound = Rebound(obstacle.name, progress.state.time, record.velocity_after[0])
    return Separating(progress, obstacle)


def _resolve(progress: Progress, obstacle: Obstacle, *, rests: bool) -> ContactRecord:
    """Carry the run through the impact by the obstacle's law, or one that leaves no approach."""
    law = progress.law if obstacle.name == "workpart" else EnergeticLaw()
    coefficients = Coefficients.of(obstacle)
    approach = -progress.gaps.touch(obstacle, progress.state).velocity[0]
    if rests or approach <= CAPTURE * progress.mechanism.speed_bound(progress.state):
        law, coefficients = EnergeticLaw(), Coefficients(obstacle.friction, obstacle.restitution_friction, 0.0)
    after, record = law.resolve(progress.scene, progress.state, obstacle, coefficients)
    progress.recording.contacts.append(record)
    if record.history is not None:
        progress.sample(0.0)
    progress.state = after
    progress.sample(0.0)
    return record


def least_opening_rate(progress: Progress, obstacle: Obstacle) -> float:
    """How fast the gap between an obstacle that a single link touches and another one that it touches opens."""
    if len(progress.mechanism.links) > 1:
        return math.inf
    gaps, state = progress.gaps, progress.state
    touch, rate = gaps.touch(obstacle, state), state.rates[-1]
    closed = [each for each in progress.scene.effects.obstacles if each is not obstacle and progress.touches(each)]
    return min((opening_rate(touch, gaps.touch(each, state), rate) for each in closed), default=math.inf)


def _stays(progress: Progress, record: ContactRecord) -> bool:
    """Whether a rebound is too slow to be followed, or so low that fixed steps would repeat it for ever.

    A step drifts before it kicks: a hop under the acceleration a arrives by a h faster than it left, and restitution
    e leaves no less than e a h/(1 - e), the speed of a hop of (1 + e)/(1 - e) steps.
    """
    arrival, speed = -record.velocity_before[0], record.velocity_after[0]
    if speed <= CAPTURE * progress.mechanism.speed_bound(progress.state):
        return True
    last, step = progress.rebound, getattr(progress.stepper, "step", 0.0)
    if last is None or last.obstacle != record.obstacle or arrival - speed <= LOSSLESS * arrival:
        return False
    hop = record.time - last.time
    low = speed**2 * hop <= 2.0 * (arrival + last.speed) * progress.stepper.noise
    return low and hop * (arrival - speed) <= 2.0 * step * (arrival + speed)


def touch_event(obstacle: str, first: bool) -> str:
    """Return the name of a touch: the first one of the workpart is the strike."""
    return f"{obstacle} touch" if obstacle != "workpart" else "strike" if first else "workpart touch"
