"""More samples of a contact resolved in time, between those at the ends of its intervals, for the rigid-body limit."""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Array

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


def filled(rows: Array, inverse_mass: Array) -> Array:
    """Return samples with others between them, of the columns of ``ContactCourse.rows``; K in the rigid-body limit is constant.

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
