"""Many contacts of one instant resolved at once, at a bounded cost, without ever gaining energy.

With the contacts' rows B in coordinates scaled by the square root of the mass, orthogonal to the joints' rows, impulses p
change the contact velocities by W p, W = B^T B, and the kinetic energy by p.(v + W p/2). The compression ends with the
impulses that make every contact part or keep closed, within the friction cones (Moreau's plastic impact):

    v_n >= 0,  p_n >= 0,  v_n p_n = 0,  |p_t| <= mu p_n,  and p_t against v_t wherever it is smaller than mu p_n times it.

They minimise that energy but for friction's cone, so they are found by projected gradients with Nesterov's momentum, started anew
where it leads uphill (O'Donoghue and Candes 2015); D with W <= D, row by row the sum over both bodies of the part of each
times its number of rows, is the step. Restitution adds e p_n and e p_t, Poisson's way, and another plastic impact of what
that has driven together. As p.v <= -p.W p for plastic impulses, (1 + e) p loses energy for every e <= 1; the sum p of all
is scaled by at most -2 p.v/(p.W p), which keeps the cones, so that no energy is gained however far the iteration has come.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.contact_space.jacobian import Connected, MassCentres, joined, joint_rows, scaled_jacobian
from bristle_sim.contact_space.projection import close_joints
from bristle_sim.contact_space.touching import TouchingPoint
from bristle_sim.theory.impact_result import NO_REBOUND, REBOUND, Impact

ITERATIONS = 40
"""Iterations of a plastic impact: impulses spread over a chain of about as many bodies."""

DEPENDENT = 1e-12
"""Singular values below this fraction of the largest belong to joints that repeat what others say."""


@dataclass(slots=True)
class Contacts:
    """Contacts of bodies, order of rows (normal, tangential), in coordinates scaled by the square root of the mass.

    Attributes:
        rows: factors of the scaled velocities of the first and second body, shape (m, 2 rows, 2 bodies, 3).
        places: of these bodies' velocities, shape (m, 2 bodies, 3).
        velocity: v, shape (m, 2).
        friction: mu, shape (m,).
        joints: orthonormal basis of the joints' rows, shape (3 bodies, rank).
    """

    rows: Array
    places: NDArray[np.intp]
    velocity: Array
    friction: Array
    joints: Array

    def change(self, impulse: Array) -> Array:
        """Return the change of the scaled velocities by impulses of shape (m, 2), shape (3 bodies,)."""
        parts = np.einsum("mr,mrbx->mbx", impulse, self.rows)
        change = np.bincount(self.places.ravel(), parts.ravel(), len(self.joints))
        return np.asarray(change - self.joints @ (self.joints.T @ change) if self.joints.size else change)

    def gain(self, change: Array) -> Array:
        """Return the change of the contact velocities by that of the scaled velocities, shape (m, 2)."""
        return np.asarray(np.einsum("mrbx,mbx->mr", self.rows, change[self.places]))

    def plastic(self, velocity: Array) -> Array:
        """Return the impulses, shape (m, 2), of a plastic impact from these contact velocities."""
        sizes = (self.rows**2).sum(axis=-1)
        count = np.bincount(self.places[:, :, 0].ravel(), np.full(self.places[:, :, 0].size, 2.0))
        step = (sizes * count[self.places[:, None, :, 0]]).sum(axis=-1)
        step = np.divide(1.0, step, out=np.zeros_like(step), where=step > 0.0)
        impulse = ahead = np.zeros_like(velocity)
        momentum = 1.0
        for _ in range(ITERATIONS):
            slope = velocity + self.gain(self.change(ahead))
            found = ahead - step * slope
            np.maximum(found[:, 0], 0.0, out=found[:, 0])
            bound = self.friction * found[:, 0]
            np.clip(found[:, 1], -bound, bound, out=found[:, 1])
            moved = found - impulse
            if (slope * moved).sum() > 0.0:
                momentum, ahead = 1.0, found
            else:
                following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
                ahead, momentum = found + (momentum - 1.0) / following * moved, following
            impulse = found
        return impulse

    def resolve(self, restitution: Array) -> tuple[Array, Array]:
        """Return the impulses of compression and of restitution, each of shape (m, 2)."""
        first = self.plastic(self.velocity)
        second = restitution[:, None] * first
        if second.any():
            second = second + self.plastic(self.velocity + self.gain(self.change(first + second)))
        total = first + second
        loss, size = -(total * self.velocity).sum(), (self.change(total) ** 2).sum()
        share = min(1.0, max(2.0 * loss / size, 0.0)) if size > 0.0 else 0.0
        return share * first, share * second


def resolve_at_once(points: Sequence[TouchingPoint], rests: Callable[[float, TouchingPoint], bool]) -> list[Impact]:
    """Set the velocities of all bodies that touch here, and of those joined to them, to those after the impact at all points.

    ``rests``: whether an approach at a point has no restitution.

    Returns:
        The record of each point. The works of all of them sum up to the change of the kinetic energy.
    """
    ends = list(dict.fromkeys(body for point in points for body in point.bodies))
    groups = _groups(ends)
    bodies = list(dict.fromkeys([*(body for group, _ in groups for body in group), *ends]))
    index = {body: at for at, body in enumerate(bodies)}
    scale = np.array([_roots(body) for body in bodies])
    velocities = np.array([(*body.velocity, body.angular_velocity) for body in bodies])
    centres = np.array([body.local_to_world(body.center_of_gravity) for body in bodies])
    pairs = np.array([[index[body] for body in point.bodies] for point in points])
    normal = np.array([point.overlap.normal for point in points])
    axes = np.stack([normal, np.stack([normal[:, 1], -normal[:, 0]], axis=1)], axis=1)[:, :, None, :]
    arms = (np.array([point.overlap.point for point in points])[:, None] - centres[pairs])[:, None]
    levers = arms[..., 0] * axes[..., 1] - arms[..., 1] * axes[..., 0]
    factors = np.concatenate([np.broadcast_to(axes, (*levers.shape, 2)), levers[..., None]], axis=-1)
    factors *= np.array([1.0, -1.0])[:, None]
    surfaces = np.array([point.surface_velocity for point in points])
    contacts = Contacts(
        rows=factors * scale[pairs][:, None],
        places=3 * pairs[..., None] + np.arange(3),
        velocity=np.einsum("mrbx,mbx->mr", factors, velocities[pairs])
        - np.einsum("mrx,mx->mr", axes[:, :, 0], surfaces),
        friction=np.array([point.pair.friction for point in points]),
        joints=_joint_basis(groups, index),
    )
    speeds = zip((-contacts.velocity[:, 0]).tolist(), points, strict=True)
    restitution = [0.0 if rests(speed, each) else each.pair.restitution for speed, each in speeds]
    first, second = contacts.resolve(np.array(restitution))
    after = velocities + scale * contacts.change(first + second).reshape(-1, 3)
    for body, velocity, changed in zip(bodies, after.tolist(), (after != velocities).any(axis=1), strict=True):
        if changed:
            body.velocity, body.angular_velocity = (velocity[0], velocity[1]), velocity[2]
    return _records(contacts, first, second)


def _groups(ends: Sequence[pymunk.Body]) -> list[Connected]:
    """Return the bodies that joints connect, and these joints, group by group, with closed joints."""
    groups: list[Connected] = []
    left, joints = joined(ends)
    if not joints:
        return [(left, [])]
    while left:
        groups.append(joined(left[:1]))
        close_joints(*groups[-1])
        left = [each for each in left if each not in groups[-1][0]]
    return groups


def _roots(body: pymunk.Body) -> tuple[float, float, float]:
    if body.body_type != pymunk.Body.DYNAMIC:
        return 0.0, 0.0, 0.0
    return body.mass**-0.5, body.mass**-0.5, body.moment**-0.5


def _joint_basis(groups: Sequence[Connected], index: Mapping[pymunk.Body, int]) -> Array:
    """Return an orthonormal basis of the joints' scaled rows, shape (3 bodies, rank); limits reached count as rigid."""
    found = [np.zeros((3 * len(index), 0))]
    for bodies, joints in groups:
        centres = MassCentres()
        rows = [row.entries for joint in joints for row in joint_rows(joint, centres)]
        if rows:
            columns, _ = scaled_jacobian(rows, bodies)
            lengths = np.sqrt((columns**2).sum(axis=0))
            directions, sizes, _ = np.linalg.svd(columns / np.where(lengths > 0.0, lengths, 1.0), full_matrices=False)
            basis = np.zeros((3 * len(index), int((sizes > DEPENDENT * sizes[0]).sum())))
            basis[[3 * index[body] + at for body in bodies for at in range(3)]] = directions[:, : basis.shape[1]]
            found.append(basis)
    return np.concatenate(found, axis=1)


def _records(contacts: Contacts, first: Array, second: Array) -> list[Impact]:
    before = contacts.velocity
    middle = before + contacts.gain(contacts.change(first))
    after = middle + contacts.gain(contacts.change(second))
    nothing = np.zeros_like(first)
    works = np.stack([first * (before + middle) / 2.0, nothing, second * (middle + after) / 2.0, nothing], axis=-1)
    impulses = np.stack([first, nothing, second, nothing], axis=-1)
    slips = np.sign(np.stack([before[:, 1], nothing[:, 0], middle[:, 1], nothing[:, 0]], axis=-1))
    outcomes = np.where(after[:, 0] > 0.0, REBOUND, NO_REBOUND)
    total = first + second
    return [
        Impact(p[0], p[1], v[0], v[1], c[0], c[1], np.inf, impulse[0], slip, work[0], work[1], outcome)
        for p, v, c, impulse, slip, work, outcome in zip(
            total.tolist(), after.tolist(), first.tolist(), impulses, slips, works, outcomes.tolist(), strict=True
        )
    ]
