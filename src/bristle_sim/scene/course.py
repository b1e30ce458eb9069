"""The record of a contact with a spring while it lasts: its phases, and samples of forces and motion."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import State, Vector
from bristle_sim.trajectory import ContactHistory

LEAST_PHASE = 1e-6
"""A phase of less than this fraction of the normal impulse is not named. Close to separation the force is too small to keep a
point from moving with its bodies, so stick always ends in slip; this has no effect in the limit of short contacts."""

BETWEEN = np.linspace(0.0, 1.0, 6)[1:-1, None, None]
"""Fractions of an interval of the rigid-body limit at which samples are added."""

ONE_INSTANT = 1e-6
"""Samples nearer to each other than this fraction of the contact are two sides of one instant: over a shorter time the
rounding of positions, some 1e-16 m against nanometres of penetration, would appear as a speed."""


class SpringPhase(NamedTuple):
    """A phase of the contact: whether the spring loads, the sense of slip, and the normal impulse before the phase."""

    loading: bool
    slip: int
    impulse: float


@dataclass(slots=True)
class ContactCourse:
    """The record of one contact while it lasts.

    Attributes:
        rows: time, normal and tangential force, penetration, normal and tangential velocity at each sample; two samples at one
            time are the end of a phase and the start of the next.
        compression: impulse and work up to the end of compression; None before.
        stopped: the state, impulse and work, and the numbers of rows and phases where the rigid-body law jams.
    """

    phases: list[SpringPhase] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)
    compression: tuple[Vector, Vector] | None = None
    stopped: tuple[State, Vector, Vector, int, int] | None = None

    @property
    def approach(self) -> float:
        """Speed of approach at the first touch."""
        return abs(self.rows[0][4])

    def release(self) -> None:
        """Set the last force to zero: a spring does not pull, and a separated point is not pushed."""
        time, _, _, *motion = self.rows[-1]
        self.rows[-1] = (time, 0.0, 0.0, *motion)

    def phase_names(self, impulse: float, *, jams: bool) -> tuple[str, ...]:
        """Return the names of the phases in order, without those too short to matter; a jam's last phase always counts."""
        ends = [*(phase.impulse for phase in self.phases[1:]), impulse]
        names: list[str] = []
        first = 0
        for phase, end in zip(self.phases, ends, strict=True):
            if end - phase.impulse >= LEAST_PHASE * impulse or (jams and phase is self.phases[-1]):
                first = first or phase.slip
                motion = (
                    "stick" if not phase.slip else "slip" if phase.slip == first else "reverse slip"
                )
                names.append(f"{'compression' if phase.loading else 'restitution'} {motion}")
        return tuple(name for name, _ in itertools.groupby(names))

    def history(self, inverse_mass: Array | None) -> ContactHistory:
        """Return the samples; given a constant K, add samples on the cubics in time between the ends of intervals.

        Between two samples of one phase forces are linear in the penetration, d(delta)/dt = -v_n and dv/dt = K (N, T).
        """
        rows = np.array(self.rows)
        if inverse_mass is not None:
            start = rows[:-1]
            change = rows[1:] - rows[:-1]
            length = change[:, :1]
            deeper = change[:, 3:4]
            steepness = change[:, 1:3] / np.where(deeper == 0.0, 1.0, deeper)
            rates = np.concatenate([-rows[:, 4:5], rows[:, 1:3] @ inverse_mass], axis=1)
            first, last = (
                np.concatenate([steepness * each[:, :1], each], axis=1) * length
                for each in (rates[:-1], rates[1:])
            )
            part = BETWEEN
            left = 1.0 - BETWEEN
            between = start[:, 1:] + part**2 * (3.0 - 2.0 * part) * change[:, 1:]
            between += part * left * (left * first - part * last)
            added = np.concatenate([start[:, :1] + part * length, between], axis=2)
            every = np.concatenate([start[None], added]).transpose(1, 0, 2)
            kept = (length > ONE_INSTANT * (rows[-1, 0] - rows[0, 0])) | (
                np.arange(1 + len(part)) == 0
            )
            rows = np.concatenate([every[kept], rows[-1:]])
        return ContactHistory(*np.ascontiguousarray(rows.T))
