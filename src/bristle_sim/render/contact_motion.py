"""Motion and forces of a contact over time, with free motion before and after it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.render.story import OUTCOMES, Phase
from bristle_sim.studies.bent_bristles import slide_path
from bristle_sim.studies.timed_contact import pieces
from bristle_sim.trajectory import ContactRecord

# Free motion shown before and after the contact, as fractions of its duration.
BEFORE = 0.10
AFTER = 0.18


@dataclass(frozen=True, slots=True)
class ContactMotion:
    """Motion and forces of an impact over time, in SI units.

    Values between two samples are interpolated linearly. Where a force jumps, two samples have the
    same time.

    Attributes:
        time: times from the first touch, s; negative before it.
        samples: velocities of the tip (``normal_velocity``, ``tangential_velocity``, m/s), forces
            on it (``normal_force``, ``tangential_force``, N), and its displacement since the first
            touch, ``depth`` below the surface and ``along`` the surface, m.
        phases: phases of the impact with their start times, for example ``compression slip``. The
            first is the arrival, the last is the outcome.
        touch_end: end of the contact, s.
    """

    time: Array
    samples: dict[str, Array]
    phases: tuple[Phase, ...]
    touch_end: float

    def largest(self, *names: str) -> float:
        """Return the largest magnitude over time of a vector whose components are the named
        samples.
        """
        return float(np.linalg.norm([self.samples[name] for name in names], axis=0).max())

    @property
    def compression_end(self) -> float:
        """Time from the first touch to the deepest penetration, s."""
        return float(self.time[int(np.argmax(self.samples["depth"]))])

    def at(self, name: str, time: float) -> float:
        """Return a quantity at a time, s, interpolated between its samples."""
        return float(np.interp(time, self.time, self.samples[name]))


def contact_motion(record: ContactRecord) -> ContactMotion:
    """Return motion and forces of a recorded contact over time, with free motion before and after
    it.

    A tip that does not leave the surface remains at rest after the contact.

    Raises:
        ValueError: if the contact has no history: its law is instantaneous, or the tip did not
            approach.
    """
    history = record.history
    if history is None or history.time.size < 2:
        raise ValueError(
            f"contact with the {record.obstacle}: {record.outcome}; there is no motion in time to show"
        )
    clock = history.time - history.time[0]
    end = float(clock[-1])
    leaves = record.outcome == "rebound"

    def extended(values: Array, speed: Array) -> Array:
        """Return samples of a coordinate, with free motion at its first and last speed around them."""
        start = [values[0] - BEFORE * end * speed[0], values[0]]
        return np.concatenate([start, values, [values[-1], values[-1] + AFTER * end * speed[-1]]])

    def held(values: Array, before: float, after: float) -> Array:
        """Return samples with two equal ones before and two after them, as fractions of the ends."""
        return np.concatenate([2 * [before * values[0]], values, 2 * [after * values[-1]]])

    normal = held(history.normal_velocity, 1.0, leaves)
    tangential = held(history.tangential_velocity, 1.0, leaves)
    samples = {
        "normal_velocity": normal,
        "tangential_velocity": tangential,
        "normal_force": held(history.normal_force, 0.0, not leaves),
        "tangential_force": held(history.tangential_force, 0.0, not leaves),
        "depth": extended(history.penetration, -normal),
        "along": extended(slide_path(history), tangential),
    }
    time = np.array([-BEFORE * end, 0.0, *clock, end, (1.0 + AFTER) * end])
    # The shortest pieces, beyond the number of phases, are rounding at the end of other pieces.
    parts = sorted(pieces(clock), key=lambda part: clock[part[1] - 1] - clock[part[0]])[
        -len(record.phases) :
    ]
    named = [
        Phase(float(clock[part[0]]), name)
        for part, name in zip(sorted(parts), record.phases, strict=False)
    ]
    ending = {**OUTCOMES, "stiction": "stiction: the tip stays", "jam": "jam: the tip stays"}
    outcome = Phase(end, ending.get(record.outcome, record.outcome))
    phases = (Phase(-BEFORE * end, "the tip arrives"), *named, outcome)
    return ContactMotion(time, samples, phases, end)
