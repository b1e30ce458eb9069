"""The record of a contact with a spring while it lasts: its phases, and samples of forces and motion."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bristle_sim.scene.mechanism import State, Vector
from bristle_sim.trajectory import ContactHistory

LEAST_PHASE = 1e-6
"""A phase of less than this fraction of the normal impulse is not named. Close to separation the force is too small to keep a
point from moving with its bodies, so stick always ends in slip; this has no effect in the limit of short contacts."""


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

    def history(self) -> ContactHistory:
        """Return the samples."""
        return ContactHistory(*np.ascontiguousarray(np.array(self.rows).T))
