"""The projection of the bodies' velocities onto the closest velocities that obey the joints.

The joints constrain the velocities V of the bodies by J V = b, with the Jacobian J and the
prescribed rates b of the joints. After an engine step J V differs from b, because the solver has a
tolerance and adds velocities to correct positions. Let M be the mass matrix, U = M^1/2 V and A =
M^-1/2 J^T. The smallest change of U that restores J V = b is dU = -A (A^T A)^+ (J V - b), where ^+
denotes the pseudoinverse. If no motor prescribes a rate (b = 0), the energy falls by |dU|^2/2, as
in a plastic impact of the joints. J has the row of a limit only if the bodies would otherwise move
past the limit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pymunk
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.contact_space.joints import joint_rows, scaled_columns

# Largest magnitude of a velocity error J V - b that counts as rounding error, as a fraction of the
# sum of the magnitudes of the terms of J V - b.
CLOSED = 1e-14
# Ratio of a singular value of the joints' rows to the largest singular value, below which the first
# counts as zero. Singular values are zero where a joint repeats the constraints of other joints.
DEPENDENT = 1e-12


def of_length_one(columns: Array) -> tuple[Array, Array]:
    """Return the columns scaled to length 1, and the lengths before scaling.

    The scaling makes constraints of rotation and of translation, which have different units,
    comparable. A column of zeros is not changed; its length is returned as 1.
    """
    lengths = np.sqrt((columns**2).sum(axis=0))
    lengths[lengths == 0.0] = 1.0
    return columns / lengths, lengths


def orthogonal_part(columns: Array, others: Array) -> Array:
    """Return the part of each column that is orthogonal to all ``others``, as a matrix.

    The columns of ``others`` may be linearly dependent.
    """
    directions, sizes, _ = np.linalg.svd(of_length_one(others)[0], full_matrices=False)
    basis = directions[:, sizes > DEPENDENT * sizes.max(initial=0.0)]
    # Two projections are enough: the second removes the rounding error of the first (Kahan and
    # Parlett).
    for _ in range(2):
        columns = columns - basis @ (basis.T @ columns)
    return columns


def joint_columns(
    bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint]
) -> tuple[Array, Array]:
    """Return the scaled Jacobian M^-1/2 J^T of joints and the diagonal of M^-1/2.

    M is the mass matrix. A limit that is reached counts as a rigid joint.
    """
    return scaled_columns([row.entries for joint in joints for row in joint_rows(joint)], bodies)


def allowed_part(
    bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint], changes: Array
) -> Array:
    """Return the velocity changes without the part that joints prevent, shape (3 * len(bodies),).

    The result is the velocity change that the joints allow and that is closest to ``changes``. The
    distance of two velocity changes is the kinetic energy of their difference.
    """
    columns, scale = joint_columns(bodies, joints)
    scaled = np.divide(changes, scale, out=np.zeros_like(changes), where=scale > 0.0)
    return scale * orthogonal_part(scaled, columns)


def close_joints(bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint]) -> None:
    """Change the bodies' velocities as little as possible so that the velocities obey the joints.

    The size of a change is the kinetic energy that the bodies would have if the velocity changes
    were their velocities.

    Raises:
        RuntimeError: if the search finds no set of limits such that each limit in the set pushes
            and the bodies pass no other limit.
    """
    rows = [row for joint in joints for row in joint_rows(joint)]
    if not rows:
        return
    rates, sizes = np.array([row.excess() for row in rows]).T
    limits: NDArray[np.bool_] = np.array([row.limit for row in rows])
    if not (np.where(limits, -rates, np.abs(rates)) > CLOSED * sizes).any():
        return
    columns, scale = scaled_columns([row.entries for row in rows], bodies)
    columns, lengths = of_length_one(columns)
    change = _least_change(columns, rates / lengths, CLOSED * sizes / lengths, limits)
    set_in_motion(bodies, scale * change)


def set_in_motion(bodies: Sequence[pymunk.Body], change: Array) -> None:
    """Add ``change`` to the velocities of bodies.

    The changes of v_x, v_y and the angular velocity of the first body come first, then those of the
    next body.
    """
    for body, (x, y, turn) in zip(bodies, change.reshape(-1, 3).tolist(), strict=True):
        body.velocity += (x, y)
        body.angular_velocity += turn


def _least_change(
    columns: Array, rates: Array, rounding: Array, limits: NDArray[np.bool_]
) -> Array:
    """Return the shortest vector dU with rates + A^T dU = 0.

    For a limit, both rates + A^T dU and the impulse must instead be >= 0.

    Args:
        columns: the matrix A; each column is the scaled row of a joint.
        rates: present velocity errors J V - b of the joints, scaled like the rows.
        rounding: rounding error of each of ``rates``.
        limits: True for each column that belongs to a limit.
    """
    active = ~limits | (rates < -rounding)
    for _ in range(2 * len(rates) + 8):
        rigid = columns[:, active]
        change = np.asarray(
            np.linalg.lstsq(rigid.T, -rates[active], rcond=DEPENDENT)[0], dtype=float
        )
        impulses = np.zeros(len(rates))
        impulses[active] = np.linalg.lstsq(rigid, change, rcond=DEPENDENT)[0]
        after = rates + columns.T @ change
        pulls = limits & active & (impulses < -DEPENDENT * np.abs(impulses).max(initial=0.0))
        passed = limits & ~active & (after < -rounding - DEPENDENT * np.abs(rates).max())
        if pulls.any():
            active[np.argmin(np.where(pulls, impulses, np.inf))] = False
        elif passed.any():
            active[np.argmin(np.where(passed, after, np.inf))] = True
        else:
            return change
    raise RuntimeError(
        "limits of joints: no set of them pushes and keeps the others; remove joints that contradict each other"
    )
