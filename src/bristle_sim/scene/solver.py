"""The velocities of links after an engine step, corrected to obey joints and sustained contacts.

Several links are corrected together by one linear solve. For a single link all matrices are numbers,
and :mod:`bristle_sim.scene.link_velocity` solves the equations in closed form.

**Joints.** The engine corrects one joint after the other, and would need some 16 n^2 iterations for
a chain of n links. Here one iteration of the engine is enough, because the solver replaces the
engine's velocities v by the closest velocities that obey the joints. The distance of two velocities
is the kinetic energy of their difference. Joint impulses do not change which velocities are
closest, so the joint impulses of the engine have no effect. The velocities v_k of the mass centres
that obey the joints follow from the links' angular velocities w_j:

    v_k = v_root + sum_j g_kj i E_j w_j,    E_j = e^{i angle_j}.

For links at angle 0, g_kj is the vector from the joint of link j to its tip (j < k) or to its mass
centre (j = k). B is the matrix of the derivatives of v and w with respect to w, and M is the matrix
of masses and moments of inertia. The closest angular velocities are the solution of

    (B^T M B + s C) w = B^T M (v - v_root) + s c_0 w_0.

The terms with the time s are the implicit damping. C is the damping matrix of belt and hinges, c_0
the belt's damping for the first link of a wire and 0 for the others, and w_0 the hub's angular
velocity.

**Symmetric steps.** In a plain step s is the length of the step. In a symmetric step v is the mean
of the velocities before and after the step, and s is half its length. Joints and damping are then
satisfied at the midpoint. With positions half a step ahead, the error of an even number of
symmetric steps has only even powers of the step (Hairer, Lubich and Wanner, *Geometric Numerical
Integration*, sec. II.4 and V.1).

**Contacts.** The impulses p at sustained contacts keep the contacts closed. The rows R give the
contact velocities that must be zero: the normal velocities, and the slip velocities in stick. The
rows Q give the directions in which the impulses act, friction included. With the matrix
A = B^T M B + s C,

    (R A^-1 Q^T) p = -R w - u,    change of w = A^-1 Q^T p,

where u holds the contact velocities that the motion of the roots causes.
"""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import Complexes, Mechanism, State
from bristle_sim.scene.pairs import ClosedPair, ClosestApproach, contact_rows

# Ratio of a singular value to the largest singular value, below which the former counts as zero. It
# is zero where a contact repeats the constraint of joints or of other contacts.
DEPENDENT = 1e-12

# Number of iterations of Newton's method. They reduce an error of 1e-3 to 1e-6, 1e-12 and then
# rounding error.
NEWTON_ROUNDS = 3


class WireVelocities:
    """Corrects all links' velocities after each engine step, to obey joints and contacts.

    Attributes:
        symmetric: whether the steps are symmetric in time.
        impulses: for each step, a list with one entry for each contact: [normal impulse, tangential
            impulse, slip velocity].
    """

    def __init__(
        self,
        mechanism: Mechanism,
        damping: Sequence[float],
        bodies: Any,
    ) -> None:
        """Prepare the corrections.

        Args:
            mechanism: the mechanism.
            damping: damping of the torsion springs of one wire, first that of the belt.
            bodies: the ``build.Placer`` of hub and links.
        """
        from scipy.linalg.lapack import dgelss, dposv  # imported where they are needed only

        self._solve = dposv
        self._least_squares = dgelss
        self.symmetric = False
        self.impulses: list[list[list[float]]] = []
        self.set_contacts(())
        self._mechanism = mechanism
        size = mechanism.wire_links
        self._damping = None
        if any(damping):
            twists = np.eye(size) - np.eye(size, k=-1)
            of_wire = np.asarray(twists.T @ np.diag(damping) @ twists, dtype=float)
            self._damping = np.kron(np.eye(mechanism.wires), of_wire)
        self._belt = np.tile(np.eye(size)[0] * damping[0], mechanism.wires)
        links = len(mechanism.links)
        lag = mechanism.pitch * (np.arange(links) // size)
        self._roots = -1j * mechanism.hub_radius * np.exp(-1j * lag)
        self._bodies = bodies
        rows = np.frombuffer(bodies.values).reshape(-1, 6)
        self._hub = rows[0]
        self._numbers = numbers = rows[1 : links + 1]
        self._angles = numbers[:, 2]
        self._motion = numbers[:, 3:]
        self._velocities = numbers[:, 3:5].view(np.complex128)[:, 0]
        self._rates = numbers[:, 5]
        self._old = self._motion.copy()

    def set_contacts(self, contacts: Sequence[ClosedPair]) -> None:
        """Keep the given sustained contacts closed in all further steps."""
        count = len(contacts)
        stuck = [count + index for index, each in enumerate(contacts) if each.slip == 0]
        self._contacts = contacts
        self._pairs = [each.pair for each in contacts]
        # R selects rows of the Jacobian, Q combines them; both stand in the module's equations
        self._zero = [*range(count), *stuck]
        self._directions = np.eye(2 * count)[self._zero]
        ratios = [-each.pair.friction * (each.slip or 0) for each in contacts]
        self._directions[:count, count:] = np.diag(ratios)

    def set_back(self, state: State) -> State:
        """Return the closest state in which all contacts are closed and their gaps do not change.

        The state is found by Newton's method. The distance between states is measured by the mass
        matrix M. With the Jacobian J of the contacts and their gaps g, the change of the angles is
        -M^-1 J^T (J M^-1 J^T)^-1 g. The change of the angular velocities is the same expression,
        with the normal velocities instead of g. In contacts that stick the slip velocity is removed
        too.
        """
        mechanism = self._mechanism
        contacts = self._contacts
        time, angles, rates = state[0], np.array(state.angles), np.array(state.rates)
        for _ in range(NEWTON_ROUNDS):
            turn = np.exp(1j * angles)
            poses = mechanism.poses(State(time, tuple(angles.tolist()), tuple(rates.tolist())))
            touches = [each.pair.closest(poses, rates.tolist(), each.piece) for each in contacts]
            levers = contact_rows(mechanism, turn, self._pairs, touches)
            gaps = np.array([touch.gap for touch in touches])
            velocities = np.array([touch.velocity for touch in touches]).T.ravel()
            mass = mechanism.mass_matrix(turn)
            angles = angles - self._nearest(mass, levers[: len(gaps)], gaps)
            rates = rates - self._nearest(mass, levers[self._zero], velocities[self._zero])
        return State(time, tuple(angles.tolist()), tuple(rates.tolist()))

    def _nearest(self, mass: Array, rows: Array, amounts: Array) -> Array:
        """Return the smallest change x of angles or angular velocities with J x = ``amounts``.

        The size of x is measured by the mass matrix.

        Args:
            mass: the mass matrix.
            rows: Jacobian J of the gaps or velocities.
            amounts: required changes of the gaps or velocities.
        """
        response = self._solve(mass, rows.T)[1]
        return np.asarray(response @ self._solution(rows @ response, amounts))

    def _solution(self, matrix: Array, values: Array) -> Array:
        """Return the smallest x for which ``matrix`` times x is closest to ``values``."""
        return np.asarray(self._least_squares(matrix, values, cond=DEPENDENT)[1])

    def begin_symmetric(self) -> None:
        """Make all further steps symmetric in time; they start from the present velocities."""
        self._bodies.keep()
        self._old[:] = self._motion
        self.symmetric = True

    def solve(self, step: float) -> None:
        """Correct the bodies' velocities after an engine step to obey joints and contacts.

        ``step`` is the length of the step.
        """
        self._bodies.keep()
        motion = self._motion
        old = self._old
        if self.symmetric:
            motion += old
            motion *= 0.5
        turn = np.exp(1j * self._angles)
        matrix = self._close_joints(turn, 0.5 * step if self.symmetric else step)
        if self._contacts:
            self._close_contacts(turn, matrix)
        if self.symmetric:
            motion *= 2.0
            motion -= old
            old[:] = motion
        self._bodies(None)

    def _close_joints(self, turn: Complexes, time: float) -> Array:
        """Replace the velocities by the closest velocities that obey the joints.

        Args:
            turn: e^{i angle} of each link.
            time: time for which damping acts, in scene units.

        Returns:
            The mass matrix plus ``time`` times the damping matrix, in the links' angles.
        """
        constants = self._mechanism.constants
        places = self._roots * cmath.exp(1j * self._hub[2])
        carried = 1j * self._hub[5] * places
        matrix = self._mechanism.mass_matrix(turn)
        momenta = (
            turn.conj() * self._of_each_wire(self._velocities - carried, constants.moments)
        ).imag + constants.inertias * self._rates
        if self._damping is not None:
            matrix += time * self._damping
            momenta += time * self._hub[5] * self._belt
        self._rates[:] = rates = self._solve(matrix, momenta)[1]
        self._velocities[:] = carried + self._of_each_wire(1j * turn * rates, constants.arms)
        return matrix

    def _of_each_wire(self, values: Complexes, matrix: Complexes) -> Complexes:
        return np.asarray((values.reshape(-1, len(matrix)) @ matrix).ravel())

    def _close_contacts(self, turn: Complexes, matrix: Array) -> None:
        """Apply the impulses that keep the contacts closed, and record them.

        Args:
            turn: e^{i angle} of each link.
            matrix: the mass matrix with damping, as returned by ``_close_joints``.
        """
        mechanism = self._mechanism
        touches = [self._closest(turn, each) for each in self._contacts]
        levers = contact_rows(mechanism, turn, self._pairs, touches)
        velocities = np.array([touch.velocity for touch in touches]).T.ravel()
        response = self._solve(matrix, (self._directions @ levers).T)[1]
        impulses = self._solution(levers[self._zero] @ response, -velocities[self._zero])
        change = response @ impulses
        self._rates += change
        self._velocities += self._of_each_wire(1j * turn * change, mechanism.constants.arms)
        # An impulse p in a symmetric step changes the mean of old and new velocities by M^-1 p/2.
        impulses *= 2.0 if self.symmetric else 1.0
        slips = (velocities + levers @ change)[len(touches) :]
        numbers = np.concatenate([impulses @ self._directions, slips])
        self.impulses.append(numbers.reshape(3, -1).T.tolist())

    def _closest(self, turn: Complexes, contact: ClosedPair) -> ClosestApproach:
        """Return the closest approach of a contact's link and obstacle.

        The closest approach is computed from the bodies' positions in the engine, which drift off
        the joints slightly within an interval. ``turn`` is e^{i angle} of each link.
        """
        mechanism = self._mechanism
        poses: Any = {}
        rates: Any = {}
        for number in (contact.pair.link, contact.pair.partner):
            if number is not None:
                link = mechanism.links[number]
                x, y, _, u, v, rate = self._numbers[number].tolist()
                turned = complex(turn[number])
                to_centre = link.centre * turned
                joint = complex(x, y) - to_centre
                velocity = complex(u, v) - 1j * rate * to_centre
                poses[number] = link.pose(joint, velocity, turned)
                rates[number] = rate
        return contact.pair.closest(poses, rates, contact.piece)
