"""The course of one contact resolved in time: its phases, what its forces add up to, samples, and the record of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.contact.contact_samples import with_samples_between
from bristle_sim.scene.mechanism import State
from bristle_sim.trajectory import ContactHistory, ContactRecord

LEAST_PHASE = 1e-6
"""A phase of less than this fraction of the normal impulse is not named. Close to separation nothing keeps a point that its
bodies' motion carries along, so that stick always ends in slip; as the contact gets shorter, that has no effect."""


class Phase(NamedTuple):
    """A phase of the contact: whether the spring loads, direction of slip, and the normal impulse before it."""

    loading: bool
    slip: float
    impulse: float


class CourseMark(NamedTuple):
    """How far a course had got: what had been added up, numbers of samples and phases."""

    totals: Array
    rows: int
    phases: int


class ContactCourse:
    """What is recorded of one contact.

    Attributes:
        phases: in order.
        totals: normal and tangential impulse, normal and tangential work.
        at_compression_end: the same at the end of compression; None before.
        rows: samples of time, normal and tangential force, penetration, normal and tangential velocity.
        states: of the scene at the samples.
    """

    def __init__(self) -> None:
        """Nothing has happened yet."""
        self.phases: list[Phase] = []
        self.totals = np.zeros(4)
        self.at_compression_end: Array | None = None
        self.rows: list[tuple[float, ...]] = []
        self.states: list[State] = []

    @property
    def begin(self) -> float:
        """Time of the first touch."""
        return self.rows[0][0]

    @property
    def approach(self) -> float:
        """Speed of approach at the first touch."""
        return abs(self.rows[0][4])

    def add(self, totals: Sequence[float]) -> None:
        """Add what the forces did over an interval."""
        self.totals += totals

    def end_compression(self) -> None:
        """Note what had been added up when compression ended."""
        self.at_compression_end = self.totals.copy()

    def begin_phase(self, loading: bool, slip: float) -> None:
        """Note that a phase begins."""
        self.phases.append(Phase(loading, slip, float(self.totals[0])))

    def mark(self) -> CourseMark:
        """Return how far the course has got."""
        return CourseMark(self.totals.copy(), len(self.rows), len(self.phases))

    def return_to(self, mark: CourseMark) -> None:
        """Forget what came after a mark, which lies within compression."""
        self.totals, self.at_compression_end = mark.totals, None
        del self.rows[mark.rows :], self.states[mark.rows :], self.phases[mark.phases :]

    def phase_names(self, jams: bool) -> tuple[str, ...]:
        """Return the names of the phases in order, but for those too short to matter; the last one of a jam matters."""
        ends = [*(phase.impulse for phase in self.phases[1:]), float(self.totals[0])]
        least = LEAST_PHASE * float(self.totals[0])
        names: list[str] = []
        first = 0.0
        for phase, end in zip(self.phases, ends, strict=True):
            if end - phase.impulse < least and not (jams and phase is self.phases[-1]):
                continue
            first = first or phase.slip
            motion = "stick" if not phase.slip else "slip" if phase.slip == first else "reverse slip"
            name = f"{'compression' if phase.loading else 'restitution'} {motion}"
            if not names or names[-1] != name:
                names.append(name)
        return tuple(names)

    def record(
        self, names: tuple[str, str, str], before: State, after: State, inverse_mass: Array | None
    ) -> ContactRecord:
        """Return the contact record.

        Args:
            names: of obstacle, law and outcome.
            before, after: states at the contact's beginning and end.
            inverse_mass: K where it is constant, and samples between follow from it; None where the bodies move meanwhile.
        """
        total = self.totals.tolist()
        middle = total if self.at_compression_end is None else self.at_compression_end.tolist()
        rows = np.array(self.rows)
        if inverse_mass is not None:
            rows = with_samples_between(rows, inverse_mass)
        first, last = self.rows[0], self.rows[-1]
        obstacle, law, outcome = names
        return ContactRecord(
            obstacle=obstacle,
            law=law,
            outcome=outcome,
            time=before.time,
            duration=after.time - before.time,
            impulse=(total[0], total[1]),
            compressive_impulse=(middle[0], middle[1]),
            compressive_work=(middle[2], middle[3]),
            restitutive_work=(total[2] - middle[2], total[3] - middle[3]),
            velocity_before=(first[4], first[5]),
            velocity_after=(last[4], last[5]),
            angles=before.angles,
            rates_before=before.rates,
            rates_after=after.rates,
            phases=self.phase_names(outcome == "jam"),
            history=ContactHistory(*np.ascontiguousarray(rows.T)),
        )
