"""Choose the events that a picture labels, and describe the phases between them in words."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bristle_sim.trajectory import Event, Trajectory

MOST_LABELS = 9  # as many labels as fit above a panel of full width
AFTERMATH = 0.12  # how long the story goes on after the tip has left the workpart, as a fraction of the time before
SAME_INSTANT = 1e-9  # events nearer to each other than this are one, s
CARRIED = math.radians(1.0)  # a bristle that starts nearer than this to radial is carried along, not thrown, rad

THROWN = "released: the belt throws the tip"
OUTCOMES = {"stiction": "stiction: no rebound", "jam": "jammed"}
_CAPTIONS = {
    "bar release": THROWN,
    "workpart release": "off the workpart",
    "jam": "jammed",
    "retraction limit": "retraction limit",
}
_SUSTAINED = {"bar": "held back by the bar", "workpart": "drags along the workpart"}


@dataclass(frozen=True, slots=True)
class Phase:
    """An interval of the run and its caption; it lasts to the next phase's start, s."""

    start: float
    caption: str


def story_end(trajectory: Trajectory) -> float:
    """Return the instant to which a pass is shown, s: shortly after the last touch of the workpart, or the end."""
    start, end = float(trajectory.time[0]), float(trajectory.time[-1])
    touches = [event.time for event in trajectory.events if event.name.startswith("workpart ")]
    touches += [contact.time + contact.duration for contact in trajectory.contacts if contact.obstacle == "workpart"]
    if not touches or trajectory.event_time("strike") is None:
        return end
    return min(end, start + (1.0 + AFTERMATH) * (max(touches) - start))


def key_events(trajectory: Trajectory, until: float = math.inf) -> tuple[Event, ...]:
    """Return the events that are labelled, in order of time: of each name one up to the strike and one after it.

    Of several it is the first that counts; of releases, after a few taps, the last. At most nine are returned.
    """
    strike = trajectory.event_time("strike")
    chosen: dict[tuple[str, bool], Event] = {}
    for event in (each for each in _notable(trajectory) if each.time <= until):
        rank = (event.name, strike is not None and event.time > strike)
        if rank not in chosen or event.name.endswith(" release"):
            chosen[rank] = event
    return tuple(sorted(chosen.values(), key=lambda event: event.time)[:MOST_LABELS])


def phases(trajectory: Trajectory, strike_shown: float = 0.0) -> tuple[Phase, ...]:
    """Return the run in words, in order of time; the first phase starts with the run.

    ``strike_shown`` is the time in s for which the instant of the strike keeps its caption.
    """
    thrown = abs(trajectory.relative_angle[0]) > CARRIED
    found = [Phase(float(trajectory.time[0]), THROWN if thrown else "turns with the hub")]
    events, contact = _notable(trajectory), trajectory.first_contact("workpart")
    outcome = "rebound" if contact is None else OUTCOMES.get(contact.outcome, contact.outcome)
    for number, event in enumerate(events):
        if event.name == "strike":
            later = (each.time for each in events[number + 1 :] if each.time > event.time)
            shown_until = min(event.time + strike_shown, next(later, math.inf))
            found.append(Phase(event.time, "strike"))
            if contact is not None and contact.history is not None:
                deepest = float(contact.history.time[np.argmax(contact.history.penetration)])
                shown_until = contact.time + contact.duration
                found[-1:] = [Phase(event.time, "strike: compression"), Phase(deepest, "strike: restitution")]
            found.append(Phase(shown_until, outcome))
        elif (caption := _caption(trajectory, events, number)) is not None:
            found.append(Phase(event.time, caption))
    return tuple(sorted(found, key=lambda phase: phase.start))


def phase_at(run: tuple[Phase, ...], time: float) -> Phase:
    """Return the phase at an instant."""
    return next((phase for phase in reversed(run) if phase.start <= time), run[0])


def _notable(trajectory: Trajectory) -> tuple[Event, ...]:
    """Return the notable events but for releases in the instant of a touch, which belong to a bounce."""
    touches, found = {"bar": -math.inf, "workpart": -math.inf}, []
    for event in trajectory.notable_events:
        obstacle = "workpart" if event.name == "strike" else event.name.split()[0]
        if event.name in ("strike", f"{obstacle} touch"):
            touches[obstacle] = event.time
        if not event.name.endswith(" release") or event.time - touches.get(obstacle, -math.inf) > SAME_INSTANT:
            found.append(event)
    return tuple(found)


def _caption(trajectory: Trajectory, events: tuple[Event, ...], number: int) -> str | None:
    """Return the name of the phase that begins with an event; a touch is sustained if a release follows, else a bounce."""
    event, strike = events[number], trajectory.event_time("strike")
    obstacle = event.name.removesuffix(" touch")
    if obstacle in _SUSTAINED:
        following = (each.name for each in events[number + 1 :] if each.name.startswith(f"{obstacle} "))
        return _SUSTAINED[obstacle] if next(following, "") == f"{obstacle} release" else f"bounces off the {obstacle}"
    if event.name == "largest retraction" and strike is not None and event.time > strike:
        return "thrown forward again"
    if event.name == "highest relative speed" and strike is None:
        return "past its highest speed"
    return _CAPTIONS.get(event.name)
