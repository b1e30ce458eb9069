"""The course of one contact resolved in time: its phases, samples of force and motion, and the record of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import State
from bristle_sim.trajectory import ContactHistory

LEAST_PHASE = 1e-6
"""A phase of less than this fraction of the normal impulse is not named. Close to separation nothing keeps a point that its
bodies' motion carries along, so that stick always ends in slip; as the contact gets shorter, that has no effect."""


BETWEEN = np.linspace(0.0, 1.0, 6)[1:-1]
"""Fractions of an interval of the rigid-body limit at which samples are added."""

ONE_INSTANT = 1e-6
"""Samples nearer to each other than this fraction of the contact are two sides of one instant: over a shorter time the
rounding of positions, some 1e-16 m of nanometres of penetration, would be a speed of its own."""

_ENDS = ((0.0, 0), (0.0, 1), (0.0, 2), (1.0, 0), (1.0, 1), (1.0, 2))
"""Values, slopes and curvatures at the beginning and the end of an interval: the place and the order of the derivative."""

_QUINTIC = np.linalg.inv([[np.polyval(np.polyder(row, order), at) for row in np.eye(6)] for at, order in _ENDS])
"""The quintic's coefficients, highest power first, by these."""

_PLACES = np.array([np.polyval(_QUINTIC, at) for at in BETWEEN])
_SLOPES = np.array([[np.polyval(np.polyder(column), at) for column in _QUINTIC.T] for at in BETWEEN])


class SpringPhase(NamedTuple):
    """A phase of the contact: whether the spring loads, sense of slip, and the normal impulse before it."""

    loading: bool
    slip: int
    impulse: float


@dataclass(slots=True)
class ContactCourse:
    """What is recorded of one contact while it lasts.

    Attributes:
        phases: in order.
        rows: time, normal and tangential force, penetration, normal and tangential velocity at each sample.
        compression: impulse (normal, tangential) and work (the same) up to the end of compression; None before.
        stopped: where the rigid-body law jams: the state, the sums, and the numbers of rows and phases there.
    """

    phases: list[SpringPhase] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)
    compression: tuple[float, ...] | None = None
    stopped: tuple[State, tuple[float, ...], int, int] | None = None

    @property
    def approach(self) -> float:
        """Speed of approach at the first touch."""
        return abs(self.rows[0][4])

    def sample(self, row: tuple[float, ...]) -> None:
        """Note force and motion at a time; two samples at one time are the ends of two phases."""
        self.rows.append(row)

    def let_go(self) -> None:
        """End free of force: a spring does not pull, and a point that has left is not pushed."""
        time, _, _, *motion = self.rows[-1]
        self.rows[-1] = (time, 0.0, 0.0, *motion)

    def history(self, inverse_mass: Array | None) -> ContactHistory:
        """Return the samples, with others between them where K is given, which is constant in the rigid-body limit."""
        rows = np.array(self.rows)
        return ContactHistory(*np.ascontiguousarray((rows if inverse_mass is None else _filled(rows, inverse_mass)).T))

    def phase_names(self, impulse: float, *, jams: bool) -> tuple[str, ...]:
        """Return the names of the phases in order, but for those too short to matter; the last one of a jam matters."""
        ends = [*(phase.impulse for phase in self.phases[1:]), impulse]
        names: list[str] = []
        first = 0
        for phase, end in zip(self.phases, ends, strict=True):
            if end - phase.impulse < LEAST_PHASE * impulse and not (jams and phase is self.phases[-1]):
                continue
            first = first or phase.slip
            motion = "stick" if not phase.slip else "slip" if phase.slip == first else "reverse slip"
            name = f"{'compression' if phase.loading else 'restitution'} {motion}"
            if not names or names[-1] != name:
                names.append(name)
        return tuple(names)


def _filled(rows: Array, inverse_mass: Array) -> Array:
    """Return samples with others between them.

    Between two samples of one phase the forces are linear in the penetration, and so is the tangential velocity in the
    normal one. The penetration follows the quintic through its values, velocities and accelerations at both,
    d(delta)/dt = -v_n, d(v_n)/dt = K_nn N + K_nt T.
    """
    start, end = rows[:-1], rows[1:]
    length = end[:, 0] - start[:, 0]
    sides = []
    for _, normal, tangential, depth, speed, _ in (start.T, end.T):
        acceleration = inverse_mass[0, 0] * normal + inverse_mass[0, 1] * tangential
        sides += [depth, -speed * length, -acceleration * length**2]
    known = np.stack(sides)
    long = np.where(length > 0.0, length, 1.0)
    depth, speed = _PLACES @ known, -(_SLOPES @ known) / long
    by_depth, by_speed = _fraction(depth, start[:, 3], end[:, 3]), _fraction(speed, start[:, 4], end[:, 4])
    columns = [
        start[:, 0] + BETWEEN[:, None] * length,
        start[:, 1] + by_depth * (end[:, 1] - start[:, 1]),
        start[:, 2] + by_depth * (end[:, 2] - start[:, 2]),
        depth,
        speed,
        start[:, 5] + by_speed * (end[:, 5] - start[:, 5]),
    ]
    added = np.stack(columns, axis=2).transpose(1, 0, 2)
    added[length <= ONE_INSTANT * np.ptp(rows[:, 0])] = np.nan
    every = np.concatenate([np.concatenate([start[:, None], added], axis=1).reshape(-1, 6), rows[-1:]])
    return np.asarray(every[~np.isnan(every[:, 0])])


def _fraction(value: Array, first: Array, last: Array) -> Array:
    """Return where a value lies between the two of its interval; in the order of time if they are one."""
    change = last - first
    fraction = (value - first) / np.where(change != 0.0, change, 1.0)
    return np.where(change != 0.0, np.clip(fraction, 0.0, 1.0), BETWEEN[:, None])
