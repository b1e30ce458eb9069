"""Resuming a run that has stopped, from its last state, with everything it was simulated with.

The engine's cached impulses and the lengths of the intervals are no part of a state. A run that was interrupted therefore
meets one that was not to the requested accuracy, not to the bit.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Hub, Tool, Workpart
from bristle_sim.quantity import shown
from bristle_sim.scene.build import Scene
from bristle_sim.scene.engine_contact import LEAST_LEVER, set_back
from bristle_sim.scene.events import locate
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.gaps import GAP_ROUNDING, Gaps
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.obstacles import Obstacle, Touch
from bristle_sim.scene.tool import METHOD, build_tool, simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import ABSENCES, EVENTS, StopReason, checked_event
from bristle_sim.trajectory import ContactRecord, Cost, Event, InnerSamples, Trajectory

__all__ = ["resume", "simulated_with"]

CLEAR = 2.0 * GAP_ROUNDING
"""A gap that is open, of the bristle's length."""

PRESSING = 1e-13
"""Approach that says that a bristle is in contact, of its fastest point's speed: more than rounding, less than any accuracy."""

FIRST, LAST = 1e-6, 1.0
"""Flights tried until a gap opens, in the scene's time units."""

SAMPLES = (
    "hub_angle",
    "angles",
    "rates",
    "centre_line",
    "centre_line_velocity",
    "kinetic_energy",
    "potential_energy",
    "normal_force",
)

PARTS: dict[str, type[Any]] = {
    "hub": Hub,
    "belt": Belt,
    "bristle": Bristle,
    "bar": Bar,
    "workpart": Workpart,
    "contact": Contact,
}


def resume(trajectory: Trajectory, settings: Settings | None = None, *, stop_after: str | None = None) -> Trajectory:
    """Resume a run of ``simulate`` from where it stopped.

    Args:
        trajectory: the run so far, as it was returned or as it was loaded.
        settings: numerical settings from here on, by default the run's own. ``hub_turn`` counts from the beginning of the
            run; on a hub at rest the bristle goes on for as long as a run takes.
        stop_after: name of the event that ends the run, as for ``simulate``; those of the run so far do not count.

    Returns:
        The whole run, from its beginning. A sustained contact that lasts over the stop has two records.

    Raises:
        ValueError: if the trajectory is not one of ``simulate``, or stopped where it cannot be resumed, or has made the turn
            requested already.
    """
    tool, before = simulated_with(trajectory)
    _check(trajectory, stop_after)
    if tool.bristle.links > 1:
        raise ValueError(
            f"trajectory of a wire of {tool.bristle.links} links: must be one of a rigid bristle to be resumed (wire_links = 1)"
        )
    settings = before if settings is None else settings
    if not isinstance(settings, Settings):
        raise ValueError(f"settings = {shown(settings)}: must be Settings or None")
    scene, units = build_tool(tool, hub_start=float(trajectory.hub_angle[-1]))
    stopped = State(0.0, (float(trajectory.angles[-1, 0]),), (float(trajectory.rates[-1, 0]) * units.time,))
    start, kept = _clear(scene, stopped, settings.accuracy, trajectory)
    for name in kept:
        if stop_after in _touches(name):
            # A run that begins in touch calls it one; the next one comes after the release.
            free = resume(trajectory, settings, stop_after=f"{name} release")
            return resume(free, settings, stop_after=stop_after) if free.stop_reason is StopReason.EVENT else free
    hub_angle, later = scene.mechanism.hub_angle(start.time), start.time * units.time
    rest = simulate(
        tool,
        dataclasses.replace(settings, hub_turn=_turn_left(trajectory, settings, later)),
        start_hub_angle=hub_angle,
        start_relative_angle=start.angles[0] - hub_angle,
        start_relative_rate=start.rates[0] / units.time - tool.hub.speed,
        stop_after=_name_from_now_on(trajectory, stop_after),
    )
    return _joined(trajectory, rest, later, kept, settings, stop_after)


def simulated_with(trajectory: Trajectory) -> tuple[Tool, Settings]:
    """Return the tool and the settings of a run.

    Raises:
        ValueError: for a trajectory that ``simulate`` did not return.
    """
    parameters = getattr(trajectory, "parameters", None)
    try:
        stored, settings = dict(parameters["tool"]), dict(parameters["settings"])  # type: ignore[index]
        if parameters["method"] != METHOD:  # type: ignore[index]
            raise KeyError(METHOD)
        parts = {name: None if stored[name] is None else kind(**stored[name]) for name, kind in PARTS.items()}
        return Tool(**{**stored, **parts}), Settings(**settings)
    except (KeyError, TypeError) as error:
        raise ValueError(f"trajectory of {shown(parameters)}: must be one that simulate() returned") from error


def _check(trajectory: Trajectory, stop_after: str | None) -> None:
    if not trajectory.stop_reason.resumable:
        raise ValueError(
            f"trajectory that stopped for {trajectory.stop_reason}: must be one that stopped at an event it was to"
            " stop after, at its end or when its steps were spent"
        )
    if stop_after is not None:
        checked_event("stop_after", stop_after, EVENTS)


def _turn_left(trajectory: Trajectory, settings: Settings, later: float) -> float:
    """Return what is left of the hub's turn, rad."""
    done = trajectory.hub_speed * (float(trajectory.time[-1]) + later)
    if done >= settings.hub_turn * (1.0 - 1e-12):
        raise ValueError(f"hub_turn = {settings.hub_turn:g}: must be more than the turn so far, {done:g} (in rad)")
    return settings.hub_turn - done


def _touches(name: str) -> tuple[str, ...]:
    return ("strike", "workpart touch") if name == "workpart" else (f"{name} touch",)


def _name_from_now_on(trajectory: Trajectory, event: str | None) -> str | None:
    """Return what an event is called in a run that begins now: its first touch of the workpart is a strike."""
    struck = trajectory.event_time("strike") is not None
    return {"strike": None, "workpart touch": "strike"}.get(event, event) if struck and event else event


def _touch(scene: Scene, state: State, obstacle: Obstacle) -> Touch:
    return obstacle.touch(scene.mechanism.poses(state)[-1], state.rates[-1])


def _clear(scene: Scene, state: State, accuracy: float, trajectory: Trajectory) -> tuple[State, list[str]]:
    """Return the first state that a run can start from, and the obstacles that the bristle stays on; the others are left first."""
    kept = []
    for obstacle in scene.effects.obstacles:
        if _touch(scene, state, obstacle).gap > GAP_ROUNDING:
            continue
        if _leaves(scene, state, obstacle, trajectory):
            state = _flown(scene, state, obstacle, accuracy)
        else:
            kept.append(obstacle.name)
        if _touch(scene, state, obstacle).gap <= GAP_ROUNDING:
            state = _pressed(scene, set_back(Gaps(scene.mechanism, state), [obstacle], state), obstacle)
    return state, kept


def _leaves(scene: Scene, state: State, obstacle: Obstacle, trajectory: Trajectory) -> bool:
    """Whether the bristle leaves an obstacle: by the state of contact at the end, or by its velocity at a fresh touch."""
    end = trajectory.contact_at_end
    if end.obstacle == obstacle.name:
        return end.state == "separating"
    return _touch(scene, state, obstacle).velocity[0] > 0.0


def _pressed(scene: Scene, state: State, obstacle: Obstacle) -> State:
    """Return the state with an approach that rounding cannot turn into a departure, as sustained contact begins."""
    touch = _touch(scene, state, obstacle)
    lever = touch.arm[0] * touch.normal[1] - touch.arm[1] * touch.normal[0]
    if abs(lever) < LEAST_LEVER:
        return state
    change = (touch.velocity[0] + PRESSING * scene.mechanism.speed_bound(state)) / lever
    return state._replace(rates=(*state.rates[:-1], state.rates[-1] - change))


def _flown(scene: Scene, state: State, obstacle: Obstacle, accuracy: float) -> State:
    """Return the state at which a gap that a contact in time leaves closed is open, or where it closes again."""
    stepper = Extrapolation(0.1 * accuracy)

    def after(span: float) -> State:
        return stepper.advance(scene, state, span).state

    def clearance(span: float) -> float:
        return _touch(scene, after(span), obstacle).gap - CLEAR

    short, span = 0.0, FIRST
    while clearance(span) < 0.0:
        if span > LAST or _touch(scene, after(span), obstacle).velocity[0] < 0.0:
            return after(span)
        short, span = span, 2.0 * span
    least = clearance(short) if short else _touch(scene, state, obstacle).gap - CLEAR
    return after(locate(clearance, short, span, least, clearance(span), 0.5 * CLEAR))


def _joined(
    first: Trajectory, rest: Trajectory, later: float, kept: list[str], settings: Settings, stop_after: str | None
) -> Trajectory:
    """Return both parts as one run; what the rest tells of the touch that it began in is left out."""
    begin, skip = float(first.time[-1]) + later, 0 if later else 1
    struck = first.event_time("strike") is not None

    def called(name: str) -> str:
        return "workpart touch" if struck and name == "strike" else name

    # Only what leaves an obstacle is clear of it: a touch at the very beginning is the one that lasts.
    again = {name for obstacle in kept for name in _touches(obstacle)}
    new = [each for each in rest.events if each.time > 0.0 or each.name not in again]
    events = [*first.events, *(Event(called(each.name), begin + each.time) for each in new)]
    happened = {each.name for each in events}
    absent = {each for each in happened if each in ABSENCES and ABSENCES[each] not in happened}
    contacts = [
        each for each in rest.contacts if each.time > 0.0 or each.law == "sustained" or each.obstacle not in kept
    ]
    arrays = {each: np.concatenate([getattr(first, each), getattr(rest, each)[skip:]]) for each in SAMPLES}
    return Trajectory(
        time=np.concatenate([first.time, begin + rest.time[skip:]]),
        **arrays,
        hub_speed=first.hub_speed,
        events=(
            *(each for each in events if each.name not in ABSENCES),
            *(Event(each, begin + float(rest.time[-1])) for each in sorted(absent)),
        ),
        contacts=(*first.contacts, *(_later(each, begin) for each in contacts)),
        stop_reason=rest.stop_reason,
        cost=_sum(first.cost, rest.cost),
        contact_at_end=rest.contact_at_end,
        stop_detail=rest.stop_detail,
        inner_samples=_inner_samples(first, rest, begin),
        parameters={**first.parameters, "settings": dataclasses.asdict(settings), "stop_after": stop_after},
    )


def _inner_samples(first: Trajectory, rest: Trajectory, begin: float) -> InnerSamples | None:
    """Return those of both parts."""
    one, other = first.inner_samples, rest.inner_samples
    if other is None:
        return one
    other = dataclasses.replace(other, time=begin + other.time)
    if one is None:
        return other
    names = (each.name for each in dataclasses.fields(InnerSamples))
    return InnerSamples(*(np.concatenate([getattr(one, each), getattr(other, each)]) for each in names))


def _later(contact: ContactRecord, begin: float) -> ContactRecord:
    history = contact.history
    if history is not None:
        history = dataclasses.replace(history, time=begin + history.time)
    return dataclasses.replace(contact, time=begin + contact.time, history=history)


def _sum(first: Cost, rest: Cost) -> Cost:
    estimates = (first.error_estimate, rest.error_estimate)
    known = None if estimates[0] is None or estimates[1] is None else estimates[0] + estimates[1]
    return Cost(first.wall_s + rest.wall_s, first.cpu_s + rest.cpu_s, first.steps + rest.steps, known)
