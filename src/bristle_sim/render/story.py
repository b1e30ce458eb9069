"""Phases and events of a run that figures and films name, and the captions of the phases."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle_sim.trajectory import Event, Trajectory

MOST_LABELS = 9  # number of labels that fit above a panel of full width
AFTERMATH = 0.12  # time shown after the tip leaves the workpart, as a fraction of the time before
SAME_INSTANT = 1e-9  # largest interval between events that count as simultaneous, s
# Largest angle (rad) between a bristle and the radial direction at the start for which the bristle
# counts as turning with the hub. At a larger angle the belt throws the bristle.
CARRIED = math.radians(1.0)
# Largest relative angular velocity at the start, as a fraction of the hub's angular velocity, at which
# the bristle counts as turning with the hub.
LAGGING = 0.01

THROWN = "released: the belt throws the tip"
OUTCOMES = {"stiction": "stiction: no rebound", "jam": "jammed"}
_CAPTIONS = {
    "bar release": THROWN,
    "workpart release": "off the workpart",
    "jam": "jammed",
    "retraction limit": "retraction limit",
    "largest retraction": "thrown forward again",
    "highest relative speed": "past its highest speed",
}
_SUSTAINED = {"bar": "held back by the bar", "workpart": "drags along the workpart"}


class Phase(NamedTuple):
    """A phase of a run, with its start time (s) and its caption in a film or figure.

    A phase ends when the next phase starts.
    """

    start: float
    caption: str


def story_end(trajectory: Trajectory) -> float:
    """Return the time (s) at which figures and films of a pass end.

    It is shortly after the last contact between tip and workpart or, without a strike, the end of
    the run.
    """
    start, end = float(trajectory.time[0]), float(trajectory.time[-1])
    touches = [event.time for event in trajectory.events if event.name.startswith("workpart ")]
    touches += [
        contact.time + contact.duration
        for contact in trajectory.contacts
        if contact.obstacle == "workpart"
    ]
    if not touches or trajectory.event_time("strike") is None:
        return end
    return min(end, start + (1.0 + AFTERMATH) * (max(touches) - start))


def key_events(trajectory: Trajectory, until: float = math.inf) -> tuple[Event, ...]:
    """Return the events that figures label, in order of time; there are at most nine.

    At most one event of each name is labelled up to the strike, and at most one after the strike.
    Of several releases the last is labelled, since earlier ones end brief touches. Of several other
    events with the same name the first is labelled.

    Args:
        trajectory: motion of the pass.
        until: time of the last event that is labelled, s.
    """
    strike = trajectory.event_time("strike")
    chosen: dict[tuple[str, bool], Event] = {}
    for event in (each for each in _notable(trajectory) if each.time <= until):
        rank = (event.name, strike is not None and event.time > strike)
        if rank not in chosen or event.name.endswith(" release"):
            chosen[rank] = event
    return tuple(sorted(chosen.values(), key=lambda event: event.time)[:MOST_LABELS])


def phases(trajectory: Trajectory, strike_shown: float = 0.0) -> tuple[Phase, ...]:
    """Return the phases of a run with their captions, in order of time.

    ``strike_shown`` is the time (s) for which the caption of an instantaneous strike remains.
    """
    start = float(trajectory.time[0])
    events = _notable(trajectory)
    lags = abs(trajectory.relative_rate[0]) > LAGGING * abs(trajectory.hub_speed)
    first = "lags behind the hub by its inertia" if lags else "turns with the hub"
    if abs(trajectory.relative_angle[0]) > CARRIED:
        first = THROWN
    found = [Phase(start, first)]
    for number, event in enumerate(events):
        later = events[number + 1 :]
        if event.name == "strike":
            found += _strike(trajectory, event, later, strike_shown)
        elif caption := _caption(trajectory, event, later, lags):
            found.append(Phase(event.time, caption))
    return tuple(sorted(found, key=lambda phase: phase.start))


def _strike(
    trajectory: Trajectory, strike: Event, later: Sequence[Event], shown: float
) -> list[Phase]:
    contact = trajectory.first_contact("workpart")
    outcome = "rebound" if contact is None else contact.outcome
    outcome = OUTCOMES.get(outcome, outcome)
    if contact is None or contact.history is None:
        ends = [each.time for each in later if each.time > strike.time]
        end = min([strike.time + shown, *ends])
        return [Phase(strike.time, "strike"), Phase(end, outcome)]
    deepest = float(contact.history.time[np.argmax(contact.history.penetration)])
    return [
        Phase(strike.time, "strike: compression"),
        Phase(deepest, "strike: restitution"),
        Phase(contact.time + contact.duration, outcome),
    ]


def _caption(trajectory: Trajectory, event: Event, later: Sequence[Event], lags: bool) -> str:
    """Return the caption of the phase that begins with an event.

    The caption is empty if no phase begins with the event.

    Args:
        trajectory: motion of the pass.
        event: an event other than the strike.
        later: the events after ``event``.
        lags: whether the bristle rotates more slowly than the hub at the start.
    """
    name = event.name
    strike = trajectory.event_time("strike")
    obstacle = name.removesuffix(" touch")
    if obstacle in _SUSTAINED:
        # A touch that ends in a release, or lasts to the end of the run, is sustained. Any other
        # touch is a bounce.
        own = (each.name for each in later if each.name.startswith(f"{obstacle} "))
        released = next(own, "").endswith(" release")
        if released or _lasts(trajectory, event, obstacle):
            return _SUSTAINED[obstacle]
        return f"bounces off the {obstacle}"
    if name == "bar release" and any(
        each.name == "bar touch" and (strike is None or each.time < strike) for each in later
    ):
        return "off the bar"
    skipped = {
        # before a strike the release, not the largest retraction, begins the phase
        "largest retraction": not lags if strike is None else event.time < strike,
        "highest relative speed": strike is not None,
    }
    return "" if skipped.get(name) else _CAPTIONS.get(name, "")


def _lasts(trajectory: Trajectory, touch: Event, obstacle: str) -> bool:
    """Return whether a touch of an obstacle is a jam or begins a sustained contact."""
    return any(
        each.obstacle == obstacle
        and (each.law == "sustained" or each.outcome == "jam")
        and abs(each.time - touch.time) <= SAME_INSTANT
        for each in trajectory.contacts
    )


def phase_at(run: tuple[Phase, ...], time: float) -> Phase:
    """Return the phase that contains a time, s."""
    return next((phase for phase in reversed(run) if phase.start <= time), run[0])


def _notable(trajectory: Trajectory) -> tuple[Event, ...]:
    """Return the notable events of a run, except the releases that end bounces.

    A bounce is a touch whose release has the same time.
    """
    touches = dict[str, float]()
    found = []
    for event in trajectory.notable_events:
        obstacle, _, kind = ("workpart touch" if event.name == "strike" else event.name).partition(
            " "
        )
        if kind == "touch":
            touches[obstacle] = event.time
        if kind != "release" or event.time - touches.get(obstacle, -math.inf) > SAME_INSTANT:
            found.append(event)
    return tuple(found)
