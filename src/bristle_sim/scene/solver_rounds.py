"""How many iterations of the engine's solver leave nothing but rounding of the errors of joints and contacts.

The engine corrects one contact or joint after the other, each as if its bodies were free (Gauss and Seidel's method): with A
the response of all constraints to each other's impulses, D its diagonal blocks and L what is below them, an iteration leaves
I - (D + L)^-1 A of the error, and the spectral radius of that tells how many are needed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import Mechanism, Pose, Vector
from bristle_sim.scene.obstacles import Obstacle, Touch

SOLVED = math.log(1e-17)
"""Iterations leave this fraction of the error: rounding."""

MOST_ITERATIONS = 40_000
"""Iterations of the engine's solver in a step; a link 1e-3 times as heavy as the next one takes them."""

REPEATS = 1e-9
"""An eigenvalue this near to 1 belongs to constraints that repeat each other, such as a tip that sticks at the end of a straight
wire: how they share their impulse is open, and no error."""


def contact_rounds(
    mechanism: Mechanism,
    poses: Sequence[Pose],
    obstacles: Sequence[Obstacle],
    touches: Sequence[Touch],
    slips: Sequence[int | None],
) -> tuple[int, bool]:
    """Return the iterations that solve joints and contacts, of given senses of slip, and whether any number of them does."""
    rows, columns, blocks = [], [], []
    for obstacle, touch, slip in zip(obstacles, touches, slips, strict=True):
        x, y = poses[obstacle.link].joint
        point = (x + touch.arm[0], y + touch.arm[1])
        across, along = (
            _entries(mechanism, poses, obstacle.link, point, each) for each in (touch.normal, touch.tangent)
        )
        if obstacle.partner is not None:
            across -= _entries(mechanism, poses, obstacle.partner, point, touch.normal)
            along -= _entries(mechanism, poses, obstacle.partner, point, touch.tangent)
        rows.append(across)
        columns.append(across - obstacle.friction * slip * along if slip else across)
        blocks.append(-1.0)
        if slip == 0 and obstacle.friction:
            rows.append(along)
            columns.append(along)
            blocks.append(-1.0)
    for link, pose in enumerate(poses):
        for direction in ((1.0, 0.0), (0.0, 1.0)):
            row = _entries(mechanism, poses, link, pose.joint, direction)
            if link % mechanism.wire_links:
                row -= _entries(mechanism, poses, link - 1, pose.joint, direction)
            rows.append(row)
            columns.append(row)
            blocks.append(float(link))
    left = _left(np.array(rows), np.array(columns), np.array(blocks))
    if left >= 1.0:
        return MOST_ITERATIONS, False
    return min(2 + math.ceil(SOLVED / math.log(max(left, 1e-3))), MOST_ITERATIONS), True


def _left(rows: Array, columns: Array, blocks: Array) -> float:
    """Return the fraction of the error that an iteration leaves in the end."""
    response = rows @ columns.T
    free = rows @ rows.T
    # The parts of a contact are corrected at once, each by itself; contacts one after the other, which is at least as fast.
    lower = np.where(blocks[:, None] > blocks[None, :], response, 0.0)
    same = np.where((blocks[:, None] == blocks[None, :]) & (blocks[:, None] >= 0.0), free, 0.0)
    same += np.diag(np.where(blocks < 0.0, np.diag(free), 0.0))
    found = np.linalg.eigvals(np.eye(len(rows)) - np.linalg.solve(same + lower, response))
    return float(np.abs(found[np.abs(found - 1.0) > REPEATS]).max())


def _entries(mechanism: Mechanism, poses: Sequence[Pose], link: int, point: Vector, direction: Vector) -> Array:
    """Return a row of the Jacobian of the bodies' velocities times the root of their inverse masses."""
    row, body, centre = np.zeros(3 * len(poses)), mechanism.links[link], poses[link].centre
    lever = (point[0] - centre[0]) * direction[1] - (point[1] - centre[1]) * direction[0]
    mass, inertia = math.sqrt(body.mass), math.sqrt(body.inertia)
    link %= len(poses)
    row[3 * link : 3 * link + 3] = direction[0] / mass, direction[1] / mass, lever / inertia
    return row
