"""Velocities of several links that obey joints and sustained contacts, by one linear solve a step.

The engine corrects one joint after the other, which takes a chain of n links some 16 n^2 iterations, and more in contact. Whatever it has done to
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
from numpy.typing import NDArray
from scipy.linalg.lapack import dposv

from bristle_sim.arrays import Array
from bristle_sim.scene.contact.obstacles import ClosestApproach, Held, Obstacle
from bristle_sim.scene.engine import Placer
from bristle_sim.scene.mechanism import Mechanism, Pose, Vector, cross

DEPENDENT = 1e-12
"""Singular values below this fraction of the largest belong to contacts that repeat what joints or others say."""


class _Wires(NamedTuple):
    """What does not change of wires that are all alike: complex numbers stand for points of the plane.

    Attributes:
        size: links of a wire.
        tips, centres, inertias: of every link, from its joint and about its centre of gravity.
        arms, moments: g_kj of one wire, transposed, and their conjugates times the masses.
        products: mass matrix of all links at the angles 0, before its turning.
        damping, belt: C, None without damping, and what the hub's turning adds to it.
        roots: of each link's wire, at the hub's angle 0.
    """

    size: int
    tips: NDArray[np.complex128]
    centres: NDArray[np.complex128]
    inertias: Array
    arms: NDArray[np.complex128]
    moments: NDArray[np.complex128]
    products: NDArray[np.complex128]
    damping: Array | None
    belt: Array
    roots: NDArray[np.complex128]

    @classmethod
    def of(cls, mechanism: Mechanism, damping: Sequence[float]) -> _Wires:
        """Take down the wires of a mechanism, whose joints have these damping coefficients, the root first."""
        links, size, wires = mechanism.links, mechanism.wire_links, np.eye(mechanism.wires)
        tips, centres = np.array([(complex(*link.tip), complex(*link.centre)) for link in links]).T
        inertias = np.array([link.inertia for link in links])
        arms = np.where(np.tri(size, k=-1, dtype=bool), tips[:size], 0.0) + np.diag(centres[:size])
        moments = np.conj(arms).T * np.array([link.mass for link in links[:size]])
        twists = np.eye(size) - np.eye(size, k=-1)
        lag = mechanism.pitch * (np.arange(len(links)) // size)
        return cls(
            size,
            tips,
            centres,
            inertias,
            arms.T,
            moments.T,
            np.kron(wires, moments @ arms + np.diag(inertias[:size])),
            np.kron(wires, np.asarray(twists.T @ np.diag(damping) @ twists, dtype=float)) if any(damping) else None,
            np.tile(np.eye(size)[0] * damping[0], mechanism.wires),
            -1j * mechanism.hub_radius * np.exp(-1j * lag),
        )


class _Chains:
    """The links of all wires, one wire after the other: their bodies' numbers, and the velocities that obey the joints.

    Attributes:
        rates, velocities: of the bodies; they may be written.
        matrix, turn: mass matrix with damping, and e^{i angle} of each link, of the last solution.
    """

    def __init__(self, mechanism: Mechanism, damping: Sequence[float], hub: Array, numbers: Array) -> None:
        """Look at x, y, angle, u, v and rate of each link in ``numbers``, and of the hub."""
        self._wires, self._links, self._hub = _Wires.of(mechanism, damping), mechanism.links, hub
        self._places = numbers[:, :2].view(np.complex128)[:, 0]
        self.velocities = numbers[:, 3:5].view(np.complex128)[:, 0]
        self._angles, self.rates = numbers[:, 2], numbers[:, 5]
        self.turn, self.matrix = np.ones(len(self._links), complex), np.eye(len(self._links))

    def close(self, time: float, *, correct: bool) -> None:
        """Set the velocities to those that obey the joints, with the damping over a time."""
        wires = self._wires
        self.turn = turn = np.exp(1j * self._angles)
        back = turn.conj()
        places = wires.roots * cmath.exp(1j * self._hub[2])
        carried = 1j * self._hub[5] * places
        if correct:
            carried = carried - (self._places - places - self._each(turn, wires.arms)) / time
        self.matrix = matrix = (back[:, None] * wires.products * turn).real
        momenta = (back * self._each(self.velocities - carried, wires.moments)).imag + wires.inertias * self.rates
        if wires.damping is not None:
            matrix += time * wires.damping
            momenta += time * self._hub[5] * wires.belt
        self.rates[:] = rates = dposv(matrix, momenta)[1]
        self.velocities[:] = carried + self._each(1j * turn * rates, wires.arms)

    def add(self, change: Array) -> None:
        """Change the rates, and the velocities with them."""
        self.rates += change
        self.velocities += self._each(1j * self.turn * change, self._wires.arms)

    def _each(self, values: NDArray[np.complex128], matrix: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return each wire's values times the matrix of a wire."""
        return np.asarray((values.reshape(-1, self._wires.size) @ matrix).ravel())

    def closest(self, obstacle: Obstacle, piece: int | None) -> ClosestApproach:
        """Return where the pair's links touch as the bodies are, off their joints by what they have drifted."""
        links = [obstacle.link] if obstacle.partner is None else [obstacle.link, obstacle.partner]
        # Of the links only these are looked at.
        poses: Any = {link: self._pose(link) for link in links}
        rates: Any = {link: float(self.rates[link]) for link in links}
        return obstacle.closest(poses, rates, piece)

    def row(self, obstacle: Obstacle, touch: ClosestApproach, direction: Vector) -> Array:
        """Return d(relative velocity of a contact along a direction)/d(rates)."""
        row = np.zeros(len(self._links))
        for link, arm, sign in ((obstacle.link, touch.arm, 1.0), (obstacle.partner, touch.partner_arm, -1.0)):
            if link is not None and arm is not None:
                carriers = slice(link - link % self._wires.size, link)
                reaches = self._wires.tips[carriers] * self.turn[carriers]
                row[carriers] += (sign * 1j * complex(direction[0], -direction[1]) * reaches).real
                row[link] += sign * cross(arm, direction)
        return row

    def _pose(self, link: int) -> Pose:
        """Return the pose of a link as its body is."""
        turn, rate = complex(self.turn[link]), float(self.rates[link])
        centre, velocity = complex(self._places[link]), complex(self.velocities[link])
        to_centre = complex(self._wires.centres[link]) * turn
        joint, carried = centre - to_centre, velocity - 1j * rate * to_centre
        corners = [complex(*each) * turn for each in (*self._links[link].knees, self._links[link].tip)]
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


class WireVelocities:
    """The velocities of all links of a mechanism after an engine step.

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
        self._bodies = Placer([hub, *links] if hub is not None else links)
        rows = np.frombuffer(self._bodies.values)[: 6 * (len(links) + has_hub)].reshape(-1, 6)
        self._velocities = rows[has_hub:, 3:]
        self._old = self._velocities.copy()
        self._chains = _Chains(mechanism, damping, rows[0] if has_hub else np.zeros(6), rows[has_hub:])

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
        velocities, old = self._velocities, self._old
        if self._symmetric:
            velocities += old
            velocities *= 0.5
        self._chains.close(0.5 * step if self._symmetric else step, correct=self.correct)
        if self.contacts:
            self._push()
        if self._symmetric:
            velocities *= 2.0
            velocities -= old
            old[:] = velocities
        self._bodies(None)

    def _push(self) -> None:
        """Add the impulses of the contacts."""
        chains = self._chains
        touches = [chains.closest(each.obstacle, each.piece) for each in self.contacts]
        pairs = list(zip(self.contacts, touches, strict=True))
        rows = [chains.row(each.obstacle, touch, touch.normal) for each, touch in pairs]
        pushes, speeds, along = list(rows), [touch.velocity[0] for touch in touches], {}
        for index, (held, touch) in enumerate(pairs):
            if held.obstacle.friction:
                along[index] = chains.row(held.obstacle, touch, touch.tangent)
                if held.slip:
                    pushes[index] = rows[index] - held.obstacle.friction * held.slip * along[index]
        stuck = [index for index in along if self.contacts[index].slip == 0]
        response = dposv(chains.matrix, np.array([*pushes, *(along[index] for index in stuck)]).T)[1]
        rigid = np.array([*rows, *(along[index] for index in stuck)]) @ response
        impulses = _solved(rigid, speeds + [touches[index].velocity[1] for index in stuck])
        change = response @ impulses
        chains.add(change)
        # A mean of old and new velocities takes half of an impulse.
        impulses = impulses * (2.0 if self._symmetric else 1.0)
        rubs = dict(zip(stuck, impulses[len(rows) :], strict=True))
        self.impulses = [
            (
                float(impulses[index]),
                float(rubs.get(index, -held.obstacle.friction * (held.slip or 0) * impulses[index])),
                float(touch.velocity[1] + along[index] @ change) if index in along else 0.0,
            )
            for index, (held, touch) in enumerate(pairs)
        ]


def _solved(rigid: Array, speeds: Sequence[float]) -> Array:
    """Return the impulses that stop the speeds; 0 of a contact that has no lever."""
    if len(speeds) == 1:
        return np.array([-speeds[0] / rigid[0, 0] if rigid[0, 0] else 0.0])
    return np.asarray(np.linalg.lstsq(rigid, -np.array(speeds), rcond=DEPENDENT)[0])


def _vector(number: complex) -> Vector:
    return number.real, number.imag
