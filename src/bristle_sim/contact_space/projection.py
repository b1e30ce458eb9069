"""Velocities that obey the joints: the nearest ones, in the norm of the kinetic energy.

After an engine's solver, joints open at some rate: its tolerance, and velocity that it adds to correct their positions. With J
V = b as in :mod:`bristle_sim.contact_space.jacobian` and A = M^-1/2 J^T, the smallest change of M^1/2 V that closes the joints
is dU = -A (A^T A)^+ (J V - b). With b = 0 (no motors) the energy falls by |dU|^2/2: it is a plastic impact of the joints.
Limits take part only if they would be passed, and only push.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pymunk
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.contact_space.jacobian import joint_rows, scaled_columns

Flags = NDArray[np.bool_]

CLOSED = 1e-14  # a rate below this fraction of the terms that it is the sum of is rounding

DEPENDENT = 1e-12  # singular values below this fraction of the largest belong to joints that repeat what others say


def span(columns: Array) -> Array:
    """Return an orthonormal basis of the columns' span, shape (rows, rank); columns may be dependent."""
    directions, sizes, _ = np.linalg.svd(of_length_one(columns), full_matrices=False)
    return np.asarray(directions[:, sizes > DEPENDENT * sizes[0]])


def of_length_one(columns: Array) -> Array:
    """Return the columns scaled to length 1: joints that turn and joints that shift have different units."""
    lengths = np.sqrt((columns**2).sum(axis=0))
    return np.asarray(columns / np.where(lengths > 0.0, lengths, 1.0))


def joint_basis(bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint]) -> tuple[Array, Array]:
    """Return a basis of the joints' scaled rows, shape (3 bodies, rank), and the diagonal of M^-1/2; limits are rigid."""
    rows = [row.entries for joint in joints for row in joint_rows(joint)]
    columns, scale = scaled_columns(rows, bodies)
    return span(columns) if rows else np.zeros((len(scale), 0)), scale


def close_joints(bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint], with_limits: bool = True) -> None:
    """Apply the least change of velocity at which no joint opens.

    The change is measured in the norm of the kinetic energy. Limits are ignored unless ``with_limits``.

    Raises:
        RuntimeError: if limits take turns at pushing without end.
    """
    rows = [row for joint in joints for row in joint_rows(joint) if with_limits or not row.limit]
    if not rows:
        return
    rates, sizes = np.array([row.excess() for row in rows]).T
    limits: Flags = np.array([row.limit for row in rows])
    if not (np.where(limits, -rates, np.abs(rates)) > CLOSED * sizes).any():
        return
    columns, scale = scaled_columns([row.entries for row in rows], bodies)
    lengths = np.sqrt((columns**2).sum(axis=0))
    lengths[lengths == 0.0] = 1.0
    change = scale * _least_change(columns / lengths, rates / lengths, CLOSED * sizes / lengths, limits)
    for body, (x, y, turn) in zip(bodies, change.reshape(-1, 3).tolist(), strict=True):
        body.velocity += (x, y)
        body.angular_velocity += turn


def allowed_part(bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint], changes: Array) -> Array:
    """Return the part of velocity changes, shape (3 bodies), that the joints permit: the orthogonal projection onto it."""
    rigid, scale = joint_basis(bodies, joints)
    scaled = np.divide(changes, scale, out=np.zeros_like(changes), where=scale > 0.0)
    return np.asarray(scale * (scaled - rigid @ (rigid.T @ scaled)))


def _least_change(columns: Array, rates: Array, rounding: Array, limits: Flags) -> Array:
    """Return the dU of least length with rates + A^T dU = 0, or >= 0 at limits, whose impulses are >= 0."""
    active = ~limits | (rates < -rounding)
    for _ in range(2 * len(rates) + 8):
        rigid = columns[:, active]
        change = np.asarray(np.linalg.lstsq(rigid.T, -rates[active], rcond=DEPENDENT)[0], dtype=float)
        impulses = np.zeros(len(rates))
        impulses[active] = np.linalg.lstsq(rigid, change, rcond=DEPENDENT)[0]
        after = rates + columns.T @ change
        pulls = limits & active & (impulses < -DEPENDENT * np.abs(impulses).max(initial=0.0))
        passed = limits & ~active & (after < -rounding - DEPENDENT * np.abs(rates).max())
        if not (pulls.any() or passed.any()):
            return change
        if pulls.any():
            active[np.argmin(np.where(pulls, impulses, np.inf))] = False
        else:
            active[np.argmin(np.where(passed, after, np.inf))] = True
    raise RuntimeError(
        "limits of joints: no set of them pushes and keeps the others; remove joints that contradict each other"
    )
