"""The velocities of several links that obey their joints and sustained contacts, by one linear solve a step.

The engine corrects one joint after the other, which takes a chain of n links some 16 n^2 iterations. Whatever it has done adds
M^-1 J^T times some impulses, and the nearest velocities that obey the joints, in the norm of the kinetic energy, are the same
without them. So one iteration is enough, and the nearest velocities are

    v_k = v_root + sum_j g_kj i E_j rate_j,    (B^T M B + s C) rates = B^T M (v - v_root) + s c_0 hub speed,

E_j = e^{i angle_j}, g_kj from the joint of link j to the next one (j < k) or to its centre (j = k), B their derivatives by
the rates, and C the hinges' damping, implicit over the time s. In a plain step v are the engine's velocities and s is the
step. In a symmetric one v is the mean of old and new velocities and s half a step: constraint and damping hold at midpoint.
With positions half a step ahead the error of an even number of such steps has even powers of the step alone (Hairer, Lubich
and Wanner, *Geometric Numerical Integration*, sec. II.4 and V.1).

Active contacts add impulses p that keep their points in touch: with R the rows of the velocities that vanish and
Q those of the directions in which the impulses act, friction included,

    (R M^-1 Q^T) p = -R rates - drift,    rates change by M^-1 Q^T p.
"""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pymunk
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.scene.engine import Placer
from bristle_sim.scene.mechanism import Mechanism, Pose, Vector, cross
from bristle_sim.scene.pairs import ClosedPair, ClosestApproach, ContactPair

DEPENDENT = 1e-12  # singular value over the largest below which a contact repeats joints or others


class _Wires(NamedTuple):
    """Constants of identical wires; complex numbers stand for points in the plane.

    ``size`` counts the links of a wire. Tips, centres and inertias are those of every link, from its joint and about its centre.
    ``arms`` and ``moments`` are g_kj of one wire, transposed, and their conjugates times the masses; ``products`` is the mass
    matrix at the angles 0; ``damping`` is C, and ``belt`` the part of it that turns with the hub. Roots are at the hub's angle 0.
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


def _wires(mechanism: Mechanism, damping: Sequence[float]) -> _Wires:
    """Return the constants of a mechanism's wires, whose joints have these damping coefficients, the root first."""
    links = mechanism.links
    size = mechanism.wire_links
    wires = np.eye(mechanism.wires)
    tips, centres = np.array([(complex(*link.tip), complex(*link.centre)) for link in links]).T
    inertias = np.array([link.inertia for link in links])
    arms = np.where(np.tri(size, k=-1, dtype=bool), tips[:size], 0.0) + np.diag(centres[:size])
    moments = np.conj(arms).T * np.array([link.mass for link in links[:size]])
    twists = np.eye(size) - np.eye(size, k=-1)
    lag = mechanism.pitch * (np.arange(len(links)) // size)
    products = np.kron(wires, moments @ arms + np.diag(inertias[:size]))
    damped = (
        np.kron(wires, np.asarray(twists.T @ np.diag(damping) @ twists, dtype=float))
        if any(damping)
        else None
    )
    belt = np.tile(np.eye(size)[0] * damping[0], mechanism.wires)
    roots = -1j * mechanism.hub_radius * np.exp(-1j * lag)
    return _Wires(size, tips, centres, inertias, arms.T, moments.T, products, damped, belt, roots)


class _Chains:
    """The links of all wires, one wire after the other: their bodies' numbers, and the velocities that obey the joints.

    ``matrix``, with damping, and ``turn``, e^{i angle} of each link, are those of the last solution.
    """

    def __init__(
        self, mechanism: Mechanism, damping: Sequence[float], hub: Array, numbers: Array
    ) -> None:
        from scipy.linalg.lapack import dposv  # imported where it is needed only

        self.solve = dposv
        self.wires = _wires(mechanism, damping)
        self._links = mechanism.links
        self._hub = hub
        self._places = numbers[:, :2].view(np.complex128)[:, 0]
        self.velocities = numbers[:, 3:5].view(np.complex128)[:, 0]
        self._angles = numbers[:, 2]
        self.rates = numbers[:, 5]
        self.turn, self.matrix = np.ones(len(self._links), complex), np.eye(len(self._links))

    def close(self, time: float) -> None:
        """Set the velocities to the nearest ones that obey the joints, with the damping acting for a time."""
        wires = self.wires
        self.turn = turn = np.exp(1j * self._angles)
        back = turn.conj()
        places = wires.roots * cmath.exp(1j * self._hub[2])
        carried = 1j * self._hub[5] * places
        self.matrix = matrix = (back[:, None] * wires.products * turn).real
        momenta = (
            back * self.each(self.velocities - carried, wires.moments)
        ).imag + wires.inertias * self.rates
        if wires.damping is not None:
            matrix += time * wires.damping
            momenta += time * self._hub[5] * wires.belt
        self.rates[:] = rates = self.solve(matrix, momenta)[1]
        self.velocities[:] = carried + self.each(1j * turn * rates, wires.arms)

    def each(
        self, values: NDArray[np.complex128], matrix: NDArray[np.complex128]
    ) -> NDArray[np.complex128]:
        return np.asarray((values.reshape(-1, self.wires.size) @ matrix).ravel())

    def closest(self, pair: ContactPair, piece: int | None) -> ClosestApproach:
        """Return the pair's closest approach for the bodies as they are, including their drift off the joints."""
        poses: Any = {}
        rates: Any = {}
        for link in (pair.link, pair.partner):
            if link is not None:
                turn = complex(self.turn[link])
                rate = float(self.rates[link])
                to_centre = complex(self.wires.centres[link]) * turn
                joint = self._places[link] - to_centre
                carried = self.velocities[link] - 1j * rate * to_centre
                corners = [
                    joint + complex(*each) * turn
                    for each in (*self._links[link].knees, self._links[link].tip)
                ]
                start, moving, *knees, tip = [
                    (each.real, each.imag) for each in (joint, carried, *corners)
                ]
                # The velocities of centre and tip are not looked at.
                rates[link], poses[link] = (
                    rate,
                    Pose(start, start, tip, moving, moving, moving, tuple(knees)),
                )
        return pair.closest(poses, rates, piece)

    def row(self, pair: ContactPair, touch: ClosestApproach, direction: Vector) -> Array:
        """Return d(relative velocity of a contact along a direction)/d(rates)."""
        row = np.zeros(len(self._links))
        for link, arm, sign in (
            (pair.link, touch.arm, 1.0),
            (pair.partner, touch.partner_arm, -1.0),
        ):
            if link is not None and arm is not None:
                carriers = slice(link - link % self.wires.size, link)
                reaches = self.wires.tips[carriers] * self.turn[carriers]
                row[carriers] += (sign * 1j * complex(direction[0], -direction[1]) * reaches).real
                row[link] += sign * cross(arm, direction)
        return row


class WireVelocities:
    """The velocities of all links of a mechanism after an engine step.

    Attributes:
        symmetric: whether steps are symmetric in time.
        impulses: normal and tangential impulse of each of them in the last step, and its slip.
    """

    reversible = True  # its steps can be symmetric in time

    def __init__(
        self,
        mechanism: Mechanism,
        damping: Sequence[float],
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
    ) -> None:
        self.symmetric = False
        self.impulses: list[tuple[float, float, float]] = []
        self._contacts: Sequence[ClosedPair] = ()
        has_hub = hub is not None
        self._bodies = Placer([hub, *links] if hub is not None else links)
        rows = np.frombuffer(self._bodies.values)[: 6 * (len(links) + has_hub)].reshape(-1, 6)
        self._velocities = rows[has_hub:, 3:]
        self._old = self._velocities.copy()
        self._chains = _Chains(
            mechanism, damping, rows[0] if has_hub else np.zeros(6), rows[has_hub:]
        )

    def set_contacts(self, contacts: Sequence[ClosedPair]) -> None:
        """From now on keep these sustained contacts closed."""
        self._contacts = contacts

    def begin_symmetric(self) -> None:
        """From now on make the steps symmetric in time, beginning with the bodies' present velocities."""
        self._bodies.keep()
        self._old[:] = self._velocities
        self.symmetric = True

    def solve(self, step: float) -> None:
        """Make the bodies' velocities after an engine step obey joints and contacts."""
        self._bodies.keep()
        velocities = self._velocities
        old = self._old
        if self.symmetric:
            velocities += old
            velocities *= 0.5
        self._chains.close(0.5 * step if self.symmetric else step)
        if self._contacts:
            self._push()
        if self.symmetric:
            velocities *= 2.0
            velocities -= old
            old[:] = velocities
        self._bodies(None)

    def _push(self) -> None:
        """Add the impulses of the contacts."""
        chains = self._chains
        contacts = self._contacts
        touches = [chains.closest(each.pair, each.piece) for each in contacts]
        pairs = list(enumerate(zip(contacts, touches, strict=True)))
        across = [chains.row(each.pair, touch, touch.normal) for _, (each, touch) in pairs]
        along = {
            at: chains.row(each.pair, touch, touch.tangent)
            for at, (each, touch) in pairs
            if each.pair.friction
        }
        ratios = [-each.pair.friction * (each.slip or 0) for each in contacts]
        pushes = [
            row + ratio * along[at] if ratio else row
            for at, (row, ratio) in enumerate(zip(across, ratios, strict=True))
        ]
        stuck = [at for at in along if contacts[at].slip == 0]
        sticking = [along[at] for at in stuck]
        response = chains.solve(chains.matrix, np.array([*pushes, *sticking]).T)[1]
        rigid = np.array([*across, *sticking]) @ response
        stopped = -np.array(
            [touch.velocity[0] for touch in touches] + [touches[at].velocity[1] for at in stuck]
        )
        if len(stopped) == 1:  # a contact without lever bears nothing
            impulses = stopped / rigid[0] if rigid[0, 0] else np.zeros(1)
        else:
            impulses = np.linalg.lstsq(rigid, stopped, rcond=DEPENDENT)[0]
        change = response @ impulses
        chains.rates += change
        chains.velocities += chains.each(1j * chains.turn * change, chains.wires.arms)
        # A mean of old and new velocities takes half of an impulse.
        whole: list[float] = (impulses * (2.0 if self.symmetric else 1.0)).tolist()
        rubs = dict(zip(stuck, whole[len(across) :], strict=True))
        self.impulses = []
        for at, (push, touch) in enumerate(zip(whole, touches, strict=False)):
            slip = float(touch.velocity[1] + along[at] @ change) if at in along else 0.0
            self.impulses.append((push, rubs.get(at, ratios[at] * push), slip))
