"""Many simultaneous contacts resolved at once, at a bounded cost and without a gain of energy.

With the contacts' rows B in coordinates scaled by the square root of the mass, orthogonal to the
joints' rows, impulses p change the contact velocities by W p, W = B^T B, and the kinetic energy by
p.(v + W p/2). The compression ends with the impulses that make every contact part or keep closed,
within the friction cones (Moreau's plastic impact):

    v_n >= 0,  p_n >= 0,  v_n p_n = 0,  |p_t| <= mu p_n,  and in slip p_t = -mu p_n sign(v_t).

Without friction cones these impulses minimise the energy. They are found by projected gradients
with Nesterov's momentum, restarted where it leads uphill (O'Donoghue and Candes 2015). The step is
1/D with a diagonal D >= W: D_ii sums, over both bodies, the body's part of W_ii times its number of
rows. Up to ``FEW`` contacts are then solved exactly, each open, sticking or slipping (a semismooth
Newton method), because with very different masses gradients need too many iterations. Restitution
adds e p_n and e p_t (Poisson), and another plastic impact if it drives contacts together. As p.v <=
-p.W p for plastic impulses, (1 + e) p loses energy for every e <= 1. The sum p of all impulses is
scaled by at most -2 p.v/(p.W p), which keeps them in the cones. So no energy is gained even if the
iteration has not converged.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import NDArray
from pymunk._chipmunk_cffi import lib

from bristle_sim.arrays import Array
from bristle_sim.contact_space.joints import close_joints, joined, joint_basis
from bristle_sim.contact_space.touching import StepMotion, TouchingPoint
from bristle_sim.theory.impact_phases import NO_REBOUND, REBOUND, Impact

# largest number for a plastic impact: impulses spread over a chain of about 40 bodies
ITERATIONS = 40
SETTLED = 1e-4  # change of the impulses in the last iteration, as a fraction of the largest impulse
FEW = 40  # largest number of contacts of a plastic impact that is solved exactly, in some 2 ms
NEWTON_ROUNDS = 20  # largest number of rounds of the exact solution; about five are enough
# Error of the conditions of an exact solution, as a fraction of the largest impulse and of the
# largest velocity.
EXACT = 1e-9


@dataclass(slots=True)
class Contacts:
    """Contacts of bodies in coordinates scaled by the square root of the mass.

    The order of rows is (normal, tangential); m is the number of contacts.

    Attributes:
        rows: factors of the scaled velocities of the first and second body, shape (2 rows, m, 6).
        places: indices of these bodies' velocities, shape (m, 6).
        velocity: contact velocity v, shape (m, 2).
        friction: mu, shape (m,).
        joints: orthonormal basis of the joints' rows, shape (3 bodies, rank).
    """

    rows: Array
    places: NDArray[np.intp]
    velocity: Array
    friction: Array
    joints: Array

    def change(self, impulse: Array) -> Array:
        """Return the change of the scaled velocities, shape (3 bodies,), by impulses of shape (m,
        2).
        """
        parts = impulse[:, :1] * self.rows[0]
        parts += impulse[:, 1:] * self.rows[1]
        change = np.bincount(self.places.ravel(), parts.ravel(), len(self.joints))
        return np.asarray(
            change - self.joints @ (self.joints.T @ change) if self.joints.size else change
        )

    def gain(self, change: Array) -> Array:
        """Return the change of the contact velocities, shape (m, 2), by a change of the scaled
        velocities.
        """
        return np.asarray(np.einsum("rmx,mx->mr", self.rows, change.take(self.places)))

    def plastic(self, velocity: Array) -> Array:
        """Return the impulses, shape (m, 2), of a plastic impact that starts at given contact
        velocities.
        """
        sizes = (self.rows**2).reshape(2, len(velocity), 2, 3).sum(axis=-1)
        ends = self.places[:, ::3]
        count = np.bincount(ends.ravel(), np.full(ends.size, 2.0))
        step = (sizes * count[ends]).sum(axis=-1).T
        step = np.divide(1.0, step, out=np.zeros_like(step), where=step > 0.0)
        impulse = ahead = np.zeros_like(velocity)
        momentum = 1.0
        for _ in range(ITERATIONS):
            slope = velocity + self.gain(self.change(ahead))
            projected = self._in_cone(ahead - step * slope)
            moved = projected - impulse
            if (slope * moved).sum() > 0.0:
                momentum = 1.0
                ahead = projected
            else:
                following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
                ahead = projected + (momentum - 1.0) / following * moved
                momentum = following
            impulse = projected
            if np.abs(moved).max() <= SETTLED * np.abs(projected).max():
                break
        return impulse if len(velocity) > FEW else self._exact(velocity, impulse)

    def _exact(self, velocity: Array, impulse: Array) -> Array:
        """Refine the estimated impulses of a plastic impact by Newton's method.

        If the method fails, return the estimate.
        """
        count = len(velocity)
        speeds = velocity.ravel()
        scaled = np.zeros((len(self.joints), count, 2))
        scaled[self.places[:, :, None], np.arange(count)[:, None, None], [0, 1]] = (
            self.rows.transpose(1, 2, 0)
        )
        rows = scaled.reshape(len(self.joints), -1)
        rows -= self.joints @ (self.joints.T @ rows)
        matrix = rows.T @ rows
        unit = np.eye(2 * count)
        step = np.divide(
            1.0, matrix.diagonal(), out=np.zeros(2 * count), where=matrix.diagonal() > 0.0
        )
        known: set[bytes] = set()
        found: Array = impulse.ravel()
        normal = 2 * np.arange(count)
        along = normal + 1
        for _ in range(NEWTON_ROUNDS):
            trial = found - step * (matrix @ found + speeds)
            closed = trial[normal] > 0.0
            limit = self.friction * np.maximum(trial[normal], 0.0)
            slip = np.where(np.abs(trial[along]) >= limit, np.sign(trial[along]), 0.0)
            if (state := closed.tobytes() + slip.tobytes()) in known:
                break
            known.add(state)
            system = matrix.copy()
            target = -speeds
            open_normal = normal[~closed]
            system[open_normal] = unit[open_normal]
            target[open_normal] = 0.0
            fixed = (slip != 0.0) | ~closed
            cone = unit[along] - (self.friction * slip * closed)[:, None] * unit[normal]
            system[along[fixed]] = cone[fixed]
            target[along[fixed]] = 0.0
            found = np.asarray(np.linalg.lstsq(system, target, rcond=1e-14)[0])
        after = matrix @ found + speeds
        most = EXACT * np.abs(found).max(initial=0.0)
        part = after[normal] >= -EXACT * np.abs(speeds).max(initial=0.0)
        kept = (found[normal] >= -most) & (
            np.abs(found[along]) <= self.friction * found[normal] + most
        )
        return self._in_cone(found.reshape(-1, 2)) if part.all() and kept.all() else impulse

    def _in_cone(self, impulse: Array) -> Array:
        """Project impulses, in place, onto the friction cone: p_n >= 0 and |p_t| <= mu p_n."""
        np.maximum(impulse[:, 0], 0.0, out=impulse[:, 0])
        bound = self.friction * impulse[:, 0]
        np.minimum(np.maximum(impulse[:, 1], -bound, out=impulse[:, 1]), bound, out=impulse[:, 1])
        return impulse

    def resolve(self, restitution: Array) -> tuple[Array, Array]:
        """Return the impulses of compression and of restitution, each of shape (m, 2)."""
        first = self.plastic(self.velocity)
        second = restitution[:, None] * first
        if second.any():
            second = second + self.plastic(self.velocity + self.gain(self.change(first + second)))
        total = first + second
        loss = -(total * self.velocity).sum()
        size = (self.change(total) ** 2).sum()
        fraction = min(1.0, max(2.0 * loss / size, 0.0)) if size > 0.0 else 0.0
        return fraction * first, fraction * second

    def records(self, first: Array, second: Array) -> list[Impact]:
        """Return the record of each contact from its impulses of compression and of restitution."""
        middle = self.velocity + self.gain(self.change(first))
        after = middle + self.gain(self.change(second))
        nothing = np.zeros_like(first)
        works = [
            first * (self.velocity + middle) / 2.0,
            nothing,
            second * (middle + after) / 2.0,
            nothing,
        ]
        phases = [np.stack(each, axis=-1) for each in ([first, nothing, second, nothing], works)]
        slips = np.sign(
            np.stack([self.velocity[:, 1], nothing[:, 0], middle[:, 1], nothing[:, 0]], axis=-1)
        )
        outcomes = np.where(after[:, 0] > 0.0, REBOUND, NO_REBOUND).tolist()
        totals = np.concatenate([first + second, after, first], axis=1).tolist()
        columns = zip(totals, phases[0], slips, phases[1], outcomes, strict=True)
        entries = [
            (*total, np.inf, impulse, slip, *work, outcome)
            for total, (impulse, _), slip, work, outcome in columns
        ]
        return [Impact(*each) for each in entries]


def resolve_at_once(
    points: Sequence[TouchingPoint],
    rests: Callable[[float, TouchingPoint], bool],
    motion: StepMotion,
) -> list[Impact]:
    """Apply the impact at all points to the velocities of their bodies and of bodies joined to
    them.

    The impact is at the end of the step; the engine's velocities are half a step ahead of it.
    ``rests`` returns whether an approach at a point has no restitution.

    Returns:
        The record of each point. The sum of all works is the change of the kinetic energy.
    """
    ends = list(dict.fromkeys(body for point in points for body in point.bodies))
    index = {body: at for at, body in enumerate(dict.fromkeys([*joined(ends)[0], *ends]))}
    joints = _close_joints(index, motion)
    dynamic = [body.body_type == pymunk.Body.DYNAMIC for body in index]
    inertia = np.array([(body.mass, body.mass, body.moment) for body in index], dtype=float)
    scale = np.where(np.array(dynamic)[:, None], inertia, np.inf) ** -0.5
    moving, gains, places = zip(*map(motion.state, index), strict=True)
    half = 0.5 * np.array(gains)
    centres = np.array(places)
    velocities = np.array(moving) - half
    pairs = np.array([[index[point.bodies[0]], index[point.bodies[1]]] for point in points])
    normal = np.array([point.overlap.normal for point in points])
    axes = np.stack([normal, np.stack([normal[:, 1], -normal[:, 0]], axis=1)], axis=1)[
        :, :, None, :
    ]
    arms = (np.array([point.overlap.point for point in points])[:, None] - centres[pairs])[:, None]
    levers = arms[..., 0] * axes[..., 1] - arms[..., 1] * axes[..., 0]
    factors = np.concatenate(
        [np.broadcast_to(axes, (*levers.shape, 2)), levers[..., None]], axis=-1
    )
    factors *= np.array([1.0, -1.0])[:, None]
    slide = np.einsum(
        "mrx,mx->mr", axes[:, :, 0], np.array([point.surface_velocity for point in points])
    )
    contacts = Contacts(
        rows=np.ascontiguousarray(
            (factors * scale[pairs][:, None]).reshape(-1, 2, 6).transpose(1, 0, 2)
        ),
        places=(3 * pairs[..., None] + np.arange(3)).reshape(-1, 6),
        velocity=np.einsum("mrbx,mbx->mr", factors, velocities[pairs]) - slide,
        friction=np.array([point.pair.friction for point in points]),
        joints=joints,
    )
    speeds = zip((-contacts.velocity[:, 0]).tolist(), points, strict=True)
    restitution = [0.0 if rests(speed, each) else each.pair.restitution for speed, each in speeds]
    first, second = contacts.resolve(np.array(restitution))
    after = velocities + scale * contacts.change(first + second).reshape(-1, 3)
    changed = (after != velocities).any(axis=1).tolist()
    for body, (x, y, turn) in itertools.compress(
        zip(index, (after + half).tolist(), strict=True), changed
    ):
        lib.cpBodySetVelocity(body._body, (x, y))
        lib.cpBodySetAngularVelocity(body._body, turn)
    return contacts.records(first, second)


def _close_joints(index: dict[pymunk.Body, int], motion: StepMotion) -> Array:
    """Close the joints of bodies, and return a basis of the joints' scaled rows, shape (3 bodies,
    rank).

    Reached limits are treated as rigid.
    """
    found = [np.zeros((3 * len(index), 0))]
    left = [body for body in index if body._constraints]
    while left:
        bodies, joints = joined(left[:1])
        motion.kick(bodies, -0.5)
        close_joints(bodies, joints)
        motion.kick(bodies, 0.5)
        rigid, _ = joint_basis(bodies, joints)
        found.append(np.zeros((3 * len(index), rigid.shape[1])))
        found[-1][[3 * index[body] + at for body in bodies for at in range(3)]] = rigid
        left = [each for each in left[1:] if each not in bodies]
    return np.concatenate(found, axis=1)
