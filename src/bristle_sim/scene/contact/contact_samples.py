"""Samples of a contact's course between those at the ends of its intervals.

Where only the outcome of a contact is requested, its configuration hardly moves meanwhile, and K is constant. Between two
samples of one phase the forces are then linear in the penetration, and so is the tangential velocity in the normal one.
The penetration follows the quintic through its values, velocities and accelerations at both samples,

    d(delta)/dt = -v_n,    d(v_n)/dt = K_nn N + K_nt T.
"""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Array

COLUMNS = ("time", "normal force", "tangential force", "penetration", "normal velocity", "tangential velocity")
"""Columns of a sample."""

FRACTIONS = np.array([1.0, 2.0]) / 3.0
"""Where samples are added, as fractions of the time between two."""

ONE_INSTANT = 1e-6
"""Samples nearer to each other than this fraction of the contact's duration are two sides of one instant: over a shorter
time the rounding of positions, some 1e-16 m of nanometres of penetration, would be a speed of its own."""

_BASIS = (
    (-6.0, 15.0, -10.0, 0.0, 0.0, 1.0),
    (-3.0, 8.0, -6.0, 0.0, 1.0, 0.0),
    (-0.5, 1.5, -1.5, 0.5, 0.0, 0.0),
    (6.0, -15.0, 10.0, 0.0, 0.0, 0.0),
    (-3.0, 7.0, -4.0, 0.0, 0.0, 0.0),
    (0.5, -1.0, 0.5, 0.0, 0.0, 0.0),
)
"""The quintic's parts of value, slope and curvature at its beginning, and of the same at its end; highest power first."""

_VALUES = np.array([np.polyval(each, FRACTIONS) for each in _BASIS])
_SLOPES = np.array([np.polyval(np.polyder(each), FRACTIONS) for each in _BASIS])


def with_samples_between(samples: Array, inverse_mass: Array) -> Array:
    """Return the samples with others between them, in rows of ``COLUMNS``; two at one instant are ends of two phases.

    Args:
        samples: rows of ``COLUMNS``, in order of time, shape (samples, 6).
        inverse_mass: K of the contact in the order normal, tangential, shape (2, 2).
    """
    start, end = samples[:-1], samples[1:]
    added = _between(start, end, inverse_mass[0])
    added[end[:, 0] - start[:, 0] <= ONE_INSTANT * np.ptp(samples[:, 0])] = np.nan
    blocks = np.concatenate([start[:, None, :], added], axis=1).reshape(-1, len(COLUMNS))
    every = np.concatenate([blocks, samples[-1:]])
    return np.asarray(every[~np.isnan(every[:, 0])])


def _between(start: Array, end: Array, normal_row: Array) -> Array:
    """Return samples at the fractions of each pair, shape (pairs, fractions, columns)."""
    length = end[:, 0] - start[:, 0]
    sides = []
    for side in (start, end):
        _, normal, tangential, depth, speed, _ = side.T
        acceleration = normal_row[0] * normal + normal_row[1] * tangential
        sides += [depth, -speed * length, -acceleration * length**2]
    known = np.stack(sides, axis=1)
    depth = known @ _VALUES
    speed = -(known @ _SLOPES) / np.where(length > 0.0, length, 1.0)[:, None]
    return np.stack(
        [
            start[:, :1] + length[:, None] * FRACTIONS,
            _linear(start[:, 1], end[:, 1], _fraction(depth, start[:, 3], end[:, 3])),
            _linear(start[:, 2], end[:, 2], _fraction(depth, start[:, 3], end[:, 3])),
            depth,
            speed,
            _linear(start[:, 5], end[:, 5], _fraction(speed, start[:, 4], end[:, 4])),
        ],
        axis=2,
    )


def _fraction(value: Array, first: Array, last: Array) -> Array:
    """Return where a value lies between the two of its pair; in the order of time if they are one."""
    change = (last - first)[:, None]
    fraction = (value - first[:, None]) / np.where(change != 0.0, change, 1.0)
    return np.where(change != 0.0, np.clip(fraction, 0.0, 1.0), FRACTIONS)


def _linear(first: Array, last: Array, fraction: Array) -> Array:
    return np.asarray(first[:, None] + (last - first)[:, None] * fraction)
