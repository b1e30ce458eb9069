"""Velocities of a wire's links that obey their joints, by one linear solve a step instead of the engine's iterations.

The engine corrects one joint after the other, which takes a chain of n links some 16 n^2 iterations. Whatever it has done to
the joints so far is M^-1 J^T times some impulses, and the nearest velocities that obey the joints, in the norm of the kinetic
energy, are the same without them. So an engine step with one iteration is enough, and the nearest velocities are those of

    v_k = v_root + sum_j g_kj i E_j rate_j,    (B^T M B + s C) rates = B^T M (v - v_root) + s c_0 hub speed,

E_j = e^{i angle_j}, g_kj from the joint of link j to the next one (j < k) or to its centre (j = k), B their derivatives by
the rates, and C the hinges' damping, implicit over the time s. In a plain step v are the engine's velocities and s is the
step. In a symmetric one v is the mean of those and of the old velocities, s is half a step, and what the solution is the
mean of are the old velocities and the new ones: the constraint and the damping hold at midpoint. With positions half a step
ahead such steps are symmetric in time, so the error of an even number of them has even powers of the step alone (Hairer,
Lubich and Wanner, *Geometric Numerical Integration*, sec. II.4 and V.1).

Sustained contacts add impulses p that keep their points on what they touch: with R the rows of the velocities that vanish and
Q those of the directions in which the impulses act, friction included,

    (R M^-1 Q^T) p = -R rates - drift,    rates change by M^-1 Q^T p.
"""

from __future__ import annotations

import cmath
import contextlib
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pymunk
from scipy.linalg.lapack import dposv

from bristle_sim.arrays import Array
from bristle_sim.scene.engine import placer
from bristle_sim.scene.mechanism import Mechanism, Pose, Vector
from bristle_sim.scene.obstacles import Obstacle, Touch

DEPENDENT = 1e-12
"""Singular values below this fraction of the largest belong to contacts that repeat what joints or others say."""


class Held(NamedTuple):
    """A sustained contact: the pair, the straight piece of its link that touches, and the sense of slip, 0 in stick."""

    obstacle: Obstacle
    piece: int | None
    slip: int | None


class WireVelocities:
    """The velocities of all wires of a mechanism.

    Attributes:
        correct: whether a step closes what is open of the joints by its end, as the engine's own correction does.
        contacts: sustained contacts that act.
        impulses: of each of them in the last step: normal and tangential impulse, and its slip.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        damping: Sequence[float],
        springs: Sequence[pymunk.DampedRotarySpring],
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
    ) -> None:
        """Set the velocities of links on a hub, if there is one, with the damping of a wire's joints, the root first."""
        self._symmetric = self.correct = False
        self.contacts: Sequence[Held] = ()
        self.impulses: list[tuple[float, float, float]] = []
        self._springs = [(spring, spring.damping) for spring in springs]
        has_hub = hub is not None
        self._bodies = placer([hub, *links] if hub is not None else links)
        rows = np.frombuffer(self._bodies.values)[: 6 * (len(links) + has_hub)].reshape(-1, 6)
        self._hub, self._numbers = rows[0] if has_hub else np.zeros(6), rows[has_hub:]
        self._velocities = self._numbers[:, 3:]
        self._old = self._velocities.copy()
        self._size = mechanism.wire_links
        self._wires = [_Wire(mechanism, damping, number, self._numbers) for number in range(mechanism.wires)]

    def take_over(self, *, active: bool) -> None:
        """Leave the damping to the solver here, or to the engine."""
        for spring, damping in self._springs:
            spring.damping = 0.0 if active else damping

    @contextlib.contextmanager
    def symmetric_steps(self) -> Iterator[None]:
        """Make the steps symmetric in time, from the bodies' velocities as they are."""
        self._bodies.keep()
        self._old[:] = self._velocities
        self._symmetric = True
        try:
            yield
        finally:
            self._symmetric = False

    def solve(self, step: float) -> None:
        """Have the bodies' velocities after an engine step obey joints and contacts."""
        self._bodies.keep()
        velocities, old, time = self._velocities, self._old, step
        if self._symmetric:
            velocities += old
            velocities *= 0.5
            time = 0.5 * step
        for wire in self._wires:
            wire.solve(self._hub, time, correct=self.correct)
        if self.contacts:
            self._push()
        if self._symmetric:
            velocities *= 2.0
            velocities -= old
            old[:] = velocities
        self._bodies(None)

    def _push(self) -> None:
        """Add the impulses of the contacts."""
        touches = [self._touch(each.obstacle, each.piece) for each in self.contacts]
        rows = [
            self._row(each.obstacle, touch, touch.normal) for each, touch in zip(self.contacts, touches, strict=True)
        ]
        pushes, speeds, along = list(rows), [touch.velocity[0] for touch in touches], {}
        for index, (held, touch) in enumerate(zip(self.contacts, touches, strict=True)):
            if held.obstacle.friction:
                along[index] = self._row(held.obstacle, touch, touch.tangent)
                if held.slip:
                    pushes[index] = rows[index] - held.obstacle.friction * held.slip * along[index]
        stuck = [index for index in along if self.contacts[index].slip == 0]
        parts = [*pushes, *(along[index] for index in stuck)]
        response = np.concatenate([each.response(np.array(parts)[:, each.part]) for each in self._wires])
        rigid = np.array([*rows, *(along[index] for index in stuck)]) @ response
        speeds += [touches[index].velocity[1] for index in stuck]
        impulses = _solved(rigid, speeds)
        change = response @ impulses
        for wire in self._wires:
            wire.add(change[wire.part])
        rubs = dict(zip(stuck, impulses[len(rows) :], strict=True))
        self.impulses = [
            (
                float(impulses[index]),
                float(rubs.get(index, -held.obstacle.friction * (held.slip or 0) * impulses[index])),
                float(touch.velocity[1] + along[index] @ change) if index in along else 0.0,
            )
            for index, (held, touch) in enumerate(zip(self.contacts, touches, strict=True))
        ]

    def _touch(self, obstacle: Obstacle, piece: int | None) -> Touch:
        """Return where the pair's links touch as the bodies are, off their joints by what they have drifted."""
        links = [obstacle.link] if obstacle.partner is None else [obstacle.link, obstacle.partner]
        # Of the links only these are looked at.
        poses: Any = {link: self._wires[link // self._size].pose(link % self._size) for link in links}
        rates: Any = {link: float(self._numbers[link, 5]) for link in links}
        return obstacle.touch_between(poses, rates, piece)

    def _row(self, obstacle: Obstacle, touch: Touch, direction: Vector) -> Array:
        """Return d(relative velocity of a contact along a direction)/d(rates)."""
        row = np.zeros(len(self._numbers))
        for link, arm, sign in ((obstacle.link, touch.arm, 1.0), (obstacle.partner, touch.partner_arm, -1.0)):
            if link is not None and arm is not None:
                wire = self._wires[link // self._size]
                row[wire.part] += sign * wire.row(link % self._size, complex(*arm), complex(*direction))
        return row


class _Wire:
    """One wire, whose links' numbers (x, y, angle, u, v, rate) are rows ``part`` of those of all links."""

    def __init__(self, mechanism: Mechanism, damping: Sequence[float], number: int, numbers: Array) -> None:
        """Take down what does not change: arms, masses, damping, and where the root is at the hub's angle 0."""
        self._own = mechanism.wire(number).links
        size = len(self._own)
        self.part = slice(number * size, (number + 1) * size)
        self._tips, self._centres = np.array([(complex(*link.tip), complex(*link.centre)) for link in self._own]).T
        self._inertias = np.array([link.inertia for link in self._own])
        self._arms = np.where(np.tri(size, k=-1, dtype=bool), self._tips, 0.0) + np.diag(self._centres)
        self._moments = np.conj(self._arms).T * np.array([link.mass for link in self._own])
        self._products = self._moments @ self._arms + np.diag(self._inertias)
        twists = np.eye(size) - np.eye(size, k=-1)
        self._damping = twists.T @ np.diag(damping) @ twists if any(damping) else None
        self._belt_damping = damping[0]
        self._root = -1j * mechanism.hub_radius * cmath.exp(-1j * number * mechanism.pitch)
        links = numbers[self.part]
        self._places, self._velocities = links[:, :2].view(np.complex128)[:, 0], links[:, 3:5].view(np.complex128)[:, 0]
        self._angles, self._rates = links[:, 2], links[:, 5]
        self._turn = np.ones(size, complex)
        self._matrix = np.eye(size)

    def solve(self, hub: Array, time: float, *, correct: bool) -> None:
        """Set the velocities to those that obey the joints, with the damping over a time."""
        self._turn = turn = np.exp(1j * self._angles)
        back = turn.conj()
        place = self._root * cmath.exp(1j * hub[2])
        carried = 1j * hub[5] * place
        if correct:
            carried = carried - (self._places - place - self._arms @ turn) / time
        self._matrix = matrix = (back[:, None] * self._products * turn).real
        momenta = (back * (self._moments @ (self._velocities - carried))).imag + self._inertias * self._rates
        if self._damping is not None:
            matrix += time * self._damping
            momenta[0] += time * self._belt_damping * hub[5]
        self._rates[:] = rates = dposv(matrix, momenta)[1]
        self._velocities[:] = carried + self._arms @ (1j * turn * rates)

    def response(self, pushes: Array) -> Array:
        """Return the change of the rates by each of these rows of generalized impulses, in columns."""
        return np.asarray(dposv(self._matrix, pushes.T)[1])

    def add(self, change: Array) -> None:
        """Change the rates, and the velocities with them."""
        self._rates += change
        self._velocities += self._arms @ (1j * self._turn * change)

    def row(self, link: int, arm: complex, direction: complex) -> Array:
        """Return d(velocity of a link's point at ``arm`` from its joint, along a direction)/d(rates)."""
        levers = self._tips * self._turn
        levers[link], levers[link + 1 :] = arm, 0.0
        return np.asarray((1j * direction.conjugate() * levers).real, dtype=float)

    def pose(self, link: int) -> Pose:
        """Return the pose of a link as its body is."""
        turn, rate = complex(self._turn[link]), float(self._rates[link])
        centre, velocity = complex(self._places[link]), complex(self._velocities[link])
        to_centre = complex(self._centres[link]) * turn
        joint, carried = centre - to_centre, velocity - 1j * rate * to_centre
        corners = [complex(*each) * turn for each in (*self._own[link].knees, self._own[link].tip)]
        *knees, tip = [joint + each for each in corners]
        return Pose(
            _vector(joint),
            _vector(centre),
            _vector(tip),
            _vector(carried),
            _vector(velocity),
            _vector(carried + 1j * rate * corners[-1]),
            tuple(map(_vector, knees)),
        )


def _solved(rigid: Array, speeds: Sequence[float]) -> Array:
    """Return the impulses that stop the speeds."""
    if len(speeds) == 1:
        return np.array([-speeds[0] / rigid[0, 0]])
    return np.asarray(np.linalg.lstsq(rigid, -np.array(speeds), rcond=DEPENDENT)[0])


def _vector(number: complex) -> Vector:
    return number.real, number.imag
