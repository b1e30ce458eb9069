"""Interpolate a contact resolved in time between its samples, with free motion shortly before and after."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from bristle_sim.arrays import Array
from bristle_sim.render.story import OUTCOMES, Phase
from bristle_sim.trajectory import ContactHistory, ContactRecord

POINTS = 1500
"""Instants of a whole contact: a picture's width."""

BEFORE, AFTER = 0.10, 0.18
"""Free motion shown before and after, as fractions of the time in touch."""

BRIEF = 1e-3
"""An interval of less than this fraction of the contact is rounding at the end of another one."""

RESTING = 1e-6
"""A tip slower than this fraction of its speed on arrival does not slip."""

_COLUMNS = ("normal_velocity", "tangential_velocity", "normal_force", "tangential_force", "penetration")
_MOTIONS = {"slip": "the tip slips", "reverse slip": "the tip slips back", "stick": "the tip sticks"}
_ENDINGS = {**OUTCOMES, "stiction": "stiction: the tip stays", "jam": "jam: the tip stays"}


@dataclass(frozen=True, slots=True)
class ContactMotion:
    """Arrays of one length over time, with two entries at an instant where a force jumps; SI units.

    Attributes:
        time: s, from the first touch; negative before it.
        normal_velocity, tangential_velocity: of the tip, m/s.
        normal_force, tangential_force: on the tip, N.
        depth, along: way of the tip below the surface and along it since the first touch, m.
        phases: what happens from when on, e.g. ``compression slip``; the first is ``arrival``.
        touch_end: when the contact ends, s.
    """

    time: Array
    normal_velocity: Array
    tangential_velocity: Array
    normal_force: Array
    tangential_force: Array
    depth: Array
    along: Array
    phases: tuple[Phase, ...]
    touch_end: float

    @property
    def fastest(self) -> float:
        """Highest speed of the tip, m/s."""
        return float(np.hypot(self.normal_velocity, self.tangential_velocity).max())

    @property
    def compression_end(self) -> float:
        """When the tip is deepest in the surface, s from the first touch."""
        return float(self.time[int(np.argmax(self.depth))])

    @property
    def slip_stop(self) -> float | None:
        """When the slip of arrival comes to its end, s; None if it does not."""
        touching = (phase for phase in self.phases if 0.0 <= phase.start < self.touch_end)
        later = next((phase.start for phase in touching if phase.caption.partition(" ")[2] != "slip"), 0.0)
        return later or None

    def at(self, name: str, time: float) -> float:
        """One of the arrays at an instant, s."""
        return float(np.interp(time, self.time, getattr(self, name)))


def contact_motion(record: ContactRecord) -> ContactMotion:
    """Fill a record's samples in, monotone from turn to turn, and add free motion before and after.

    Raises:
        ValueError: if the contact has no history: its law is instantaneous, or the tip did not approach.
    """
    history = record.history
    if history is None or history.time.size < 2:
        raise ValueError(f"contact with the {record.obstacle}: {record.outcome}; there is no motion in time to show")
    clock, columns = history.time - history.time[0], np.stack([getattr(history, name) for name in _COLUMNS])
    instants, filled = [], []
    for part in intervals(history):
        count = max(2, round(POINTS * np.ptp(clock[part]) / clock[-1]))
        instants.append(np.linspace(clock[part][0], clock[part][-1], count))
        filled.append(PchipInterpolator(clock[part], columns[:, part], axis=-1)(instants[-1]))
    time, values = _with_free_motion(np.concatenate(instants), np.concatenate(filled, axis=-1), record.outcome)
    normal_velocity, tangential_velocity, normal_force, tangential_force, depth = values
    steps = 0.5 * (tangential_velocity[1:] + tangential_velocity[:-1]) * np.diff(time)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    moving = (normal_velocity, tangential_velocity, normal_force, tangential_force, depth)
    phases = _phases(history, record.outcome)
    return ContactMotion(time, *moving, along - np.interp(0.0, time, along), phases, float(clock[-1]))


def intervals(history: ContactHistory) -> list[slice]:
    """Return the samples from turn to turn: at a turn two of them share an instant."""
    cuts = [0, *(np.flatnonzero(np.diff(history.time) <= 0.0) + 1).tolist(), history.time.size]
    return [slice(start, end) for start, end in pairwise(cuts) if end - start > 1]


def caption(phase: str) -> str:
    """Return a phase in words for those who watch the film."""
    half, _, motion = phase.partition(" ")
    return f"{half}: {_MOTIONS[motion]}" if motion in _MOTIONS else phase


def _with_free_motion(time: Array, values: Array, outcome: str) -> tuple[Array, Array]:
    """Add steady velocities before and after; a tip that does not leave stays pressed on as it is."""
    before, after = np.array([-BEFORE, 0.0]) * time[-1], np.array([1.0, 1.0 + AFTER]) * time[-1]
    arriving, going = np.repeat(values[:, :1], 2, axis=1), np.repeat(values[:, -1:], 2, axis=1)
    arriving[2:4] = 0.0
    arriving[4] = -arriving[0] * before
    if outcome == "rebound":
        going[2:4] = 0.0
        going[4] -= going[0] * (after - time[-1])
    else:
        going[:2] = 0.0
    return np.concatenate([before, time, after]), np.concatenate([arriving, values, going], axis=1)


def _phases(history: ContactHistory, outcome: str) -> tuple[Phase, ...]:
    """Return arrival, one phase for each interval that is no rounding, and the ending."""
    start, whole = float(history.time[0]), float(np.ptp(history.time))
    phases = [Phase(-BEFORE * whole, "the tip arrives")]
    for part in intervals(history):
        name = _phase(history, (part.start + part.stop) // 2)
        if np.ptp(history.time[part]) > BRIEF * whole and name != phases[-1].caption:
            phases.append(Phase(float(history.time[part.start]) - start, name))
    return (*phases, Phase(whole, _ENDINGS.get(outcome, outcome)))


def _phase(history: ContactHistory, middle: int) -> str:
    """Return compression or restitution, and slip, reverse slip or stick, from the sample in the middle of an interval."""
    half = "compression" if history.normal_velocity[middle] < 0.0 else "restitution"
    arrival = float(history.tangential_velocity[0])
    fastest = float(np.hypot(history.normal_velocity[0], arrival))
    # The middle of an interval of two samples is its end, where slip may just stop: take both of its sides.
    slip = float(history.tangential_velocity[middle - 1] + history.tangential_velocity[middle])
    if abs(slip) <= RESTING * fastest:
        return f"{half} stick"
    return f"{half} slip" if slip * arrival > 0.0 else f"{half} reverse slip"
