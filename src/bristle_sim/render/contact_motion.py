"""A contact resolved in time as a film shows it, with free motion shortly before and after."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.render.story import OUTCOMES, Phase
from bristle_sim.studies.bent_bristles import slide_path
from bristle_sim.studies.contact_course import pieces
from bristle_sim.trajectory import ContactRecord

BEFORE, AFTER = 0.10, 0.18  # free motion shown before and after, as fractions of the time in touch
BRIEF = 1e-3  # slip that stops earlier, as a fraction of the time in touch, is none to show


@dataclass(frozen=True, slots=True)
class ContactMotion:
    """Samples over time, linear in between, two of them at an instant where a force jumps; SI units.

    Attributes:
        time: s, from the first touch; negative before it.
        normal_velocity, tangential_velocity: of the tip, m/s.
        normal_force, tangential_force: on the tip, N.
        depth, along: displacement of the tip below the surface and along it since the first touch, m.
        phases: what happens from when on, e.g. ``compression slip``; the first is the arrival, the last the outcome.
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
        later = (phase.start for phase in self.phases[2:-1] if phase.caption.partition(" ")[2] != "slip")
        stop = next(later, 0.0)
        return stop if stop > BRIEF * self.touch_end else None

    def at(self, name: str, time: float) -> float:
        """One of the arrays at an instant, s."""
        return float(np.interp(time, self.time, getattr(self, name)))


def contact_motion(record: ContactRecord) -> ContactMotion:
    """Return a record's samples with free motion before and after; a tip that does not leave stays pressed on as it is.

    Raises:
        ValueError: if the contact has no history: its law is instantaneous, or the tip did not approach.
    """
    history = record.history
    if history is None or history.time.size < 2:
        raise ValueError(f"contact with the {record.obstacle}: {record.outcome}; there is no motion in time to show")
    clock, force = history.time - history.time[0], (history.normal_force, history.tangential_force)
    velocity = (history.normal_velocity, history.tangential_velocity)
    samples = np.stack([*velocity, *force, history.penetration, slide_path(history)])
    end, first, last = float(clock[-1]), samples[:, 0], samples[:, -1]
    if record.outcome == "rebound":
        after = [_freely(last, 0.0), _freely(last, AFTER * end)]
    else:
        after = [np.array([0.0, 0.0, *last[2:]])] * 2
    v_n, v_t, normal, tangential, depth, along = np.column_stack(
        [_freely(first, -BEFORE * end), _freely(first, 0.0), samples, *after]
    )
    time = np.array([-BEFORE * end, 0.0, *clock, end, (1.0 + AFTER) * end])
    # A piece of no length is rounding at the end of another one.
    parts = sorted(pieces(clock), key=lambda part: clock[part[1] - 1] - clock[part[0]])[-len(record.phases) :]
    named = zip(sorted(parts), record.phases, strict=False)
    phases = [Phase(float(clock[part[0]]), name) for part, name in named]
    ending = {**OUTCOMES, "stiction": "stiction: the tip stays", "jam": "jam: the tip stays"}
    outcome = Phase(end, ending.get(record.outcome, record.outcome))
    phases = [Phase(-BEFORE * end, "the tip arrives"), *phases, outcome]
    return ContactMotion(time, v_n, v_t, normal, tangential, depth, along, tuple(phases), end)


def _freely(state: Array, elapsed: float) -> Array:
    """Return velocities, no forces, and displacements a time after a state, s."""
    normal, tangential, _, _, depth, along = state.tolist()
    return np.array([normal, tangential, 0.0, 0.0, depth - normal * elapsed, along + tangential * elapsed])
