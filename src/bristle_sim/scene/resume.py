"""Resuming a run that has stopped, from its last state, with everything it was simulated with.

The engine's cached impulses and the lengths of the intervals are no part of a state. A run that was interrupted therefore
meets one that was not to the requested accuracy, not to the bit.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.scene.starts import Start
from bristle_sim.scene.tool import METHOD, simulate_from
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import ABSENCES, EVENTS, checked_name
from bristle_sim.trajectory import ContactRecord, Cost, Event, InnerSamples, Trajectory
from bristle_sim.trajectory.storage import INNER, SAMPLES
from bristle_sim.units import shown


def resume(trajectory: Trajectory, settings: Settings | None = None, *, stop_after: str | None = None) -> Trajectory:
    """Resume a run of ``simulate`` from where it stopped.

    Args:
        trajectory: the run so far, returned or loaded.
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
    begin = float(trajectory.time[-1])
    start = Start(
        float(trajectory.hub_angle[-1]),
        tuple(trajectory.angles[-1].tolist()),
        tuple((trajectory.rates[-1] - trajectory.hub_speed).tolist()),
        trajectory.contact_at_end,
        frozenset(each.obstacle for each in trajectory.contacts),
    )
    turn = _turn_left(trajectory, settings)
    rest = simulate_from(tool, dataclasses.replace(settings, hub_turn=turn), start, stop_after)
    return _joined(trajectory, rest, begin, settings, stop_after)


def simulated_with(trajectory: Trajectory) -> tuple[Tool, Settings]:
    """Return the tool and the settings of a run.

    Raises:
        ValueError: for a trajectory that ``simulate`` did not return.
    """
    parameters = getattr(trajectory, "parameters", None)
    try:
        if parameters["method"] != METHOD:  # type: ignore[index]
            raise KeyError(METHOD)
        return trajectory.tool, Settings(**parameters["settings"])  # type: ignore[index]
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"trajectory of {shown(parameters)}: must be one that simulate() returned") from error


def _check(trajectory: Trajectory, stop_after: str | None) -> None:
    if not trajectory.stop_reason.resumable:
        raise ValueError(
            f"trajectory that stopped for {trajectory.stop_reason}: must be one that stopped at an event it was to"
            " stop after, at its end or when its steps were spent"
        )
    if stop_after is not None:
        checked_name("stop_after", stop_after, EVENTS)


def _turn_left(trajectory: Trajectory, settings: Settings) -> float:
    """Return what is left of the hub's turn, rad."""
    done = trajectory.hub_speed * float(trajectory.time[-1])
    if done >= settings.hub_turn * (1.0 - 1e-12):
        raise ValueError(f"hub_turn = {settings.hub_turn:g}: must be more than the turn so far, {done:g} (in rad)")
    return settings.hub_turn - done


def _joined(
    first: Trajectory, rest: Trajectory, begin: float, settings: Settings, stop_after: str | None
) -> Trajectory:
    """Return both parts as one run."""
    events = [*first.events, *(Event(each.name, begin + each.time) for each in rest.events)]
    happened = {each.name for each in events}
    absent = {each for each in happened if each in ABSENCES and ABSENCES[each] not in happened}
    arrays = {each: np.concatenate([getattr(first, each), getattr(rest, each)[1:]]) for each in list(SAMPLES)[1:]}
    return Trajectory(
        time=np.concatenate([first.time, begin + rest.time[1:]]),
        **arrays,
        hub_speed=first.hub_speed,
        events=(
            *(each for each in events if each.name not in ABSENCES),
            *(Event(each, begin + float(rest.time[-1])) for each in sorted(absent)),
        ),
        contacts=(*first.contacts, *(_later(each, begin) for each in rest.contacts)),
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
    return InnerSamples(*(np.concatenate([getattr(one, each), getattr(other, each)]) for each in INNER))


def _later(contact: ContactRecord, begin: float) -> ContactRecord:
    history = contact.history
    if history is not None:
        history = dataclasses.replace(history, time=begin + history.time)
    return dataclasses.replace(contact, time=begin + contact.time, history=history)


def _sum(first: Cost, rest: Cost) -> Cost:
    estimates = (first.error_estimate, rest.error_estimate)
    known = None if estimates[0] is None or estimates[1] is None else estimates[0] + estimates[1]
    return Cost(first.wall_s + rest.wall_s, first.cpu_s + rest.cpu_s, first.steps + rest.steps, known)
