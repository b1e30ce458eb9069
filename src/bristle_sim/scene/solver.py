"""The velocities of several links that obey their joints and sustained contacts, by one linear
solve a step.

The engine corrects one joint after the other, which takes a chain of n links about 16 n^2
iterations. Its corrections add M^-1 J^T times impulses to the velocities. The nearest velocities
that obey the joints, in the norm of the kinetic energy, are the same with or without these
corrections, so one iteration is enough. The nearest velocities are

    v_k = v_root + sum_j g_kj i E_j rate_j,    (B^T M B + s C) rates = B^T M (v - v_root) + s c_0
    hub speed,

with E_j = e^{i angle_j}; g_kj from the joint of link j to the next joint (j < k) or to the link's
centre (j = k); B the derivatives of the velocities by the rates; and C the hinges' damping,
implicit over the time s. In a plain step v are the engine's velocities and s is the step. In a
symmetric step v is the mean of old and new velocities and s half a step: joints and damping are
then satisfied at the midpoint. With positions half a step ahead, the error of an even number of
such steps has only even powers of the step (Hairer, Lubich and Wanner, *Geometric Numerical
Integration*, sec. II.4 and V.1).

Active contacts add the impulses p that keep their points in touch. Let R be the rows of the
velocities that vanish and Q the rows of the directions in which the impulses act, friction
included. Then

    (R M^-1 Q^T) p = -R rates - drift,    rates change by M^-1 Q^T p.
"""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from typing import Any

import numpy as np
import pymunk

from bristle_sim.arrays import Array
from bristle_sim.scene.engine import Placer
from bristle_sim.scene.gaps import contact_row
from bristle_sim.scene.mechanism import Complexes, Mechanism, Pose
from bristle_sim.scene.pairs import ClosedPair, ClosestApproach, ContactPair

# least singular value, over the largest: below it a contact repeats joints or other contacts
DEPENDENT = 1e-12


class _Chains:
    """The links of all wires, one wire after the other, and the velocities that obey their joints.

    Attributes:
        solve: solves a linear system with the mass matrix.
        mechanism: the chains of links.
        constants: constants of the wires.
        velocities: velocities of the links' centres, as complex numbers.
        rates: rates of the links.
        turn: e^{i angle} of each link in the last solution.
        matrix: mass matrix of the last solution, with damping.
    """

    def __init__(
        self, mechanism: Mechanism, damping: Sequence[float], hub: Array, numbers: Array
    ) -> None:
        from scipy.linalg.lapack import dposv  # imported where it is needed only

        self.solve = dposv
        size = mechanism.wire_links
        links = mechanism.links
        self.mechanism = mechanism
        self.constants = mechanism.constants
        self._links = links
        self._damping = None
        if any(damping):
            twists = np.eye(size) - np.eye(size, k=-1)
            of_wire = np.asarray(twists.T @ np.diag(damping) @ twists, dtype=float)
            self._damping = np.kron(np.eye(mechanism.wires), of_wire)
        self._belt = np.tile(np.eye(size)[0] * damping[0], mechanism.wires)
        lag = mechanism.pitch * (np.arange(len(links)) // size)
        self._roots = -1j * mechanism.hub_radius * np.exp(-1j * lag)
        self._hub = hub
        self._places = numbers[:, :2].view(np.complex128)[:, 0]
        self.velocities = numbers[:, 3:5].view(np.complex128)[:, 0]
        self._angles = numbers[:, 2]
        self.rates = numbers[:, 5]
        self.turn, self.matrix = np.ones(len(self._links), complex), np.eye(len(self._links))

    def close(self, time: float) -> None:
        """Set the velocities to the nearest ones that obey the joints, with damping that acts for
        ``time``.
        """
        constants = self.constants
        self.turn = turn = np.exp(1j * self._angles)
        places = self._roots * cmath.exp(1j * self._hub[2])
        carried = 1j * self._hub[5] * places
        self.matrix = matrix = self.mechanism.mass_matrix(turn)
        momenta = (
            turn.conj() * self.each(self.velocities - carried, constants.moments)
        ).imag + constants.inertias * self.rates
        if self._damping is not None:
            matrix += time * self._damping
            momenta += time * self._hub[5] * self._belt
        self.rates[:] = rates = self.solve(matrix, momenta)[1]
        self.velocities[:] = carried + self.each(1j * turn * rates, constants.arms)

    def each(self, values: Complexes, matrix: Complexes) -> Complexes:
        return np.asarray((values.reshape(-1, len(matrix)) @ matrix).ravel())

    def closest(self, pair: ContactPair, piece: int | None) -> ClosestApproach:
        """Return a pair's closest approach from the bodies in the engine, with their drift off the
        joints.
        """
        poses: Any = {}
        rates: Any = {}
        for link in (pair.link, pair.partner):
            if link is not None:
                turn = complex(self.turn[link])
                rate = float(self.rates[link])
                to_centre = complex(self.constants.centres[link]) * turn
                joint = self._places[link] - to_centre
                carried = self.velocities[link] - 1j * rate * to_centre
                corners = [
                    joint + complex(*each) * turn
                    for each in (*self._links[link].knees, self._links[link].tip)
                ]
                start, moving, *knees, tip = [
                    (each.real, each.imag) for each in (joint, carried, *corners)
                ]
                # The velocities of centre and tip are not used.
                rates[link], poses[link] = (
                    rate,
                    Pose(start, start, tip, moving, moving, moving, tuple(knees)),
                )
        return pair.closest(poses, rates, piece)


class WireVelocities:
    """Sets the velocities of all links of a mechanism after an engine step.

    Attributes:
        symmetric: whether the steps are symmetric in time.
        impulses: for each step and contact, the normal and the tangential impulse, and the slip
            velocity.
    """

    reversible = True  # steps with this solver can be symmetric in time

    def __init__(
        self,
        mechanism: Mechanism,
        damping: Sequence[float],
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
    ) -> None:
        self.symmetric = False
        self.impulses: list[list[tuple[float, float, float]]] = []
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
        """Keep these sustained contacts closed from now on."""
        self._contacts = contacts

    def begin_symmetric(self) -> None:
        """Make the steps symmetric in time from now on, beginning with the bodies' present
        velocities.
        """
        self._bodies.keep()
        self._old[:] = self._velocities
        self.symmetric = True

    def solve(self, step: float) -> None:
        """Change the bodies' velocities after an engine step so that they obey joints and contacts."""
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
        """Add the contacts' impulses to the velocities."""
        chains = self._chains
        mechanism = chains.mechanism
        contacts = self._contacts
        touches = [chains.closest(each.pair, each.piece) for each in contacts]
        pairs = list(enumerate(zip(contacts, touches, strict=True)))
        across = [
            contact_row(mechanism, chains.turn, each.pair, touch, touch.normal)
            for _, (each, touch) in pairs
        ]
        along = {
            at: contact_row(mechanism, chains.turn, each.pair, touch, touch.tangent)
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
        if len(stopped) == 1:  # a contact without lever bears no force
            impulses = stopped / rigid[0] if rigid[0, 0] else np.zeros(1)
        else:
            impulses = np.linalg.lstsq(rigid, stopped, rcond=DEPENDENT)[0]
        change = response @ impulses
        chains.rates += change
        chains.velocities += chains.each(1j * chains.turn * change, chains.constants.arms)
        # The mean of old and new velocities changes by half of an impulse.
        whole: list[float] = (impulses * (2.0 if self.symmetric else 1.0)).tolist()
        rubs = dict(zip(stuck, whole[len(across) :], strict=True))
        found = []
        for at, (push, touch) in enumerate(zip(whole, touches, strict=False)):
            slip = float(touch.velocity[1] + along[at] @ change) if at in along else 0.0
            found.append((push, rubs.get(at, ratios[at] * push), slip))
        self.impulses.append(found)
