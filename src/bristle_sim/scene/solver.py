"""The velocities of links after an engine step, corrected to obey joints and sustained contacts.

Several links are corrected together by one linear solve. For a single link all matrices are numbers,
and the equations are solved in closed form. With matrices a run would take 2.5 times as long.

**Joints.** The engine corrects one joint after the other, and would need some 16 n^2 iterations for
a chain of n links. Here one iteration of the engine is enough, because the solver replaces the
engine's velocities v by the closest velocities that obey the joints. The distance of two velocities
is the kinetic energy of their difference. Joint impulses do not change which velocities are
closest, so the joint impulses of the engine have no effect. The velocities that obey the joints
follow from the angular velocities w of the links and w_0 of the hub: they are B w + b w_0, with the
Jacobian that ``Mechanism.body_rows`` returns (its first column is b). The closest angular velocities
are the solution of

    (B^T M B + s C) w = B^T M (v - b w_0) + s c w_0.

M is the matrix of masses and moments of inertia. The terms with the time s are the implicit
damping: C is the damping matrix of belt and hinges, and c is the belt's damping for the first link
of a wire and 0 for the others.

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

from cmath import rect
from collections.abc import Sequence
from typing import Any

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import Complexes, Mechanism, State
from bristle_sim.scene.pairs import ClosedPair, ClosestApproach, FixedPair, contact_rows

# Ratio of a singular value to the largest singular value, below which the former counts as zero. It
# is zero where a contact repeats the constraint of joints or of other contacts.
DEPENDENT = 1e-12

# Number of iterations of Newton's method. They reduce an error of 1e-3 to 1e-6, 1e-12 and then
# rounding error.
NEWTON_ROUNDS = 3

# Gap, as a fraction of the link's length, below which Newton's method ends. A further iteration would
# change the angular velocity by less than any requested accuracy.
CLOSED_GAP = 1e-10

# Shortest lever of the contact normal about the link's joint, as a fraction of the link's length, at
# which a rotation of the link can close a gap.
LEAST_LEVER = 1e-6

_angle = lib.cpBodyGetAngle
_rate = lib.cpBodyGetAngularVelocity


class LinkVelocity:
    """Corrects a single link's angular velocity after each engine step, to keep a contact closed.

    ``impulses`` is as in ``WireVelocities``, with one contact.
    """

    def __init__(
        self, mechanism: Mechanism, damping: Sequence[float], hub: pymunk.Body, body: pymunk.Body
    ) -> None:
        self._mechanism = mechanism
        (link,) = mechanism.links
        self._corners = link.corners
        self._centre = link.centre
        self._inertia = link.inertia_about_joint
        self._damping = damping[0]
        self._speed = mechanism.hub_speed
        self._root = -1j * mechanism.hub_radius
        self._hub = hub._body
        self._body = body._body
        self.impulses: list[list[tuple[float, float, float]]] = []

    def set_contacts(self, contacts: Sequence[ClosedPair]) -> None:
        """Keep a contact closed in all further steps; ``contacts`` holds this contact alone."""
        (contact,) = contacts
        pair = contact.pair
        assert isinstance(pair, FixedPair), "a single link has no neighbour"
        self._touch = pair.touch
        self._line = pair.lines(self._corners)[contact.piece or 0]
        self._ratio = -pair.friction * (contact.slip or 0)

    def set_back(self, state: State) -> State:
        """Return the state after a rotation of the link that closes the gap of the contact.

        The angular velocity is changed too, so that the gap stays closed.
        """
        time, (angle,), (rate,) = state
        joint = self._root * rect(1.0, self._mechanism.root_angle(time))
        start, end = self._line
        for _ in range(NEWTON_ROUNDS):
            turn = rect(1.0, angle)
            gap, point, normal = self._touch(joint + turn * start, joint + turn * end)
            across = 1j * normal.conjugate()
            lever = ((point - joint) * across).real
            if abs(lever) < LEAST_LEVER:
                return state
            angle -= gap / lever
            rate = -self._speed * (joint * across).real / lever
            if abs(gap) < CLOSED_GAP:
                break
        return State(time, (angle,), (rate,))

    def solve(self, step: float) -> None:
        """Correct the link's angular velocity after an engine step, to keep the contact closed.

        The engine step has already applied the belt's spring and made the link obey its joint. The
        belt's damping is integrated implicitly here. The contact stays closed if

            u_n + l_n (w + (l_n + f l_t) p/I) = 0,

        with the joint's normal velocity u_n, the levers l_n and l_t of normal and tangent about the
        joint, the normal impulse p and the tangential impulse f p. The link would have the angular
        velocity w without the contact, but with damping. I is the moment of inertia about the joint
        plus the damping times the length of the step, which is ``step``.
        """
        body = self._body
        ratio = self._ratio
        joint = self._root * rect(1.0, _angle(self._hub))
        turn = rect(1.0, _angle(body))
        start, end = self._line
        _, point, normal = self._touch(joint + turn * start, joint + turn * end)
        damping = step * self._damping
        inertia = self._inertia + damping
        rate = (self._inertia * _rate(body) + damping * self._speed) / inertia
        along = 1j * normal.conjugate()
        levers = (point - joint) * along  # the normal's lever, and minus the tangent's
        across = self._speed * joint  # velocity of the joint, turned by -90 degrees
        carried = across * along  # its components along the normal and, negative, the tangent
        lever = levers.real
        turning = (lever - ratio * levers.imag) / inertia
        yields = lever * turning
        push = -(carried.real + rate * lever) / yields if yields else 0.0
        rate += turning * push
        velocity = 1j * (across + rate * turn * self._centre)
        lib.cpBodySetAngularVelocity(body, rate)
        lib.cpBodySetVelocity(body, (velocity.real, velocity.imag))
        self.impulses.append([(push, ratio * push, -carried.imag - rate * levers.imag)])


class WireVelocities:
    """Corrects all links' velocities after each engine step, to obey joints and contacts.

    Attributes:
        symmetric: whether the steps are symmetric in time.
        impulses: for each step, a list with one entry for each contact: [normal impulse, tangential
            impulse, slip velocity].
    """

    def __init__(self, mechanism: Mechanism, damping: Sequence[float], bodies: Any) -> None:
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
            of_wire = twists.T @ np.diag(damping) @ twists
            belt = np.tile(np.eye(size)[0] * damping[0], mechanism.wires)
            of_links = np.kron(np.eye(mechanism.wires), of_wire)
            self._damping = np.column_stack([-belt, of_links])
        self._bodies = bodies
        numbers = np.frombuffer(bodies.values).reshape(-1, 6)[: 1 + len(mechanism.links)]
        self._numbers = numbers[1:]
        self._angles = numbers[:, 2]
        self._motion = numbers[1:, 3:]
        self._rates = numbers[:, 5]
        self._old = self._motion.flatten()

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
        for _ in range(NEWTON_ROUNDS):
            turn = np.exp(1j * np.array(state.angles))
            poses = mechanism.poses(state)
            touches = [each.pair.closest(poses, state.rates, each.piece) for each in self._contacts]
            levers = contact_rows(mechanism, turn, self._pairs, touches)
            gaps = np.array([touch.gap for touch in touches])
            velocities = np.array([touch.velocity for touch in touches]).T.ravel()
            mass = mechanism.mass_matrix(turn)
            angles = state.angles - self._nearest(mass, levers[: len(gaps)], gaps)
            rates = state.rates - self._nearest(mass, levers[self._zero], velocities[self._zero])
            state = State(state.time, tuple(angles.tolist()), tuple(rates.tolist()))
        return state

    def _nearest(self, mass: Array, rows: Array, amounts: Array) -> Array:
        """Return the smallest change x of angles or angular velocities with J x = ``amounts``.

        The size of x is measured by the mass matrix ``mass``. The Jacobian J of the gaps or
        velocities is ``rows``.
        """
        response = self._solve(mass, rows.T)[1]
        return np.asarray(response @ self._solution(rows @ response, amounts))

    def _solution(self, matrix: Array, values: Array) -> Array:
        """Return the smallest x for which ``matrix`` times x is closest to ``values``."""
        return np.asarray(self._least_squares(matrix, values, cond=DEPENDENT)[1])

    def begin_symmetric(self) -> None:
        """Make all further steps symmetric in time; they start from the present velocities."""
        self._bodies.keep()
        self._old = self._motion.flatten()
        self.symmetric = True

    def solve(self, step: float) -> None:
        """Correct the bodies' velocities after an engine step to obey joints and contacts.

        ``step`` is the length of the step.
        """
        self._bodies.keep()
        velocities = self._motion.flatten()
        if self.symmetric:
            velocities = 0.5 * (velocities + self._old)
        turn = np.exp(1j * self._angles)
        rows = self._mechanism.body_rows(turn)
        own = rows[:, 1:]  # B; the first column, b, belongs to the hub
        momenta = own.T * self._mechanism.inertias  # B^T M
        matrix = momenta @ rows
        if self._damping is not None:
            matrix += (0.5 * step if self.symmetric else step) * self._damping
        hub = self._rates[0]
        rates = self._solve(matrix[:, 1:], momenta @ velocities - hub * matrix[:, 0])[1]
        velocities = own @ rates + hub * rows[:, 0]
        self._motion[:] = velocities.reshape(-1, 3)
        if self._contacts:
            velocities += own @ self._close_contacts(turn[1:], matrix[:, 1:])
        if self.symmetric:
            velocities = 2.0 * velocities - self._old
            self._old = velocities
        self._motion[:] = velocities.reshape(-1, 3)
        self._bodies(None)

    def _close_contacts(self, turn: Complexes, matrix: Array) -> Array:
        """Record the impulses that keep the contacts closed, and return the angular velocities' change.

        Args:
            turn: e^{i angle} of each link.
            matrix: the mass matrix with damping.
        """
        touches = [self._closest(turn, each) for each in self._contacts]
        levers = contact_rows(self._mechanism, turn, self._pairs, touches)
        velocities = np.array([touch.velocity for touch in touches]).T.ravel()
        response = self._solve(matrix, (self._directions @ levers).T)[1]
        impulses = self._solution(levers[self._zero] @ response, -velocities[self._zero])
        change = np.asarray(response @ impulses)
        # An impulse p in a symmetric step changes the mean of old and new velocities by M^-1 p/2.
        impulses *= 2.0 if self.symmetric else 1.0
        slips = (velocities + levers @ change)[len(touches) :]
        numbers = np.concatenate([impulses @ self._directions, slips])
        self.impulses.append(numbers.reshape(3, -1).T.tolist())
        return change

    def _closest(self, turn: Complexes, contact: ClosedPair) -> ClosestApproach:
        """Return the closest approach of a contact's link and obstacle.

        The closest approach is computed from the bodies' positions in the engine, which drift off
        the joints slightly within an interval. ``turn`` is e^{i angle} of each link.
        """
        poses: Any = {}
        rates: Any = {}
        for number in (contact.pair.link, contact.pair.partner):
            if number is not None:
                link = self._mechanism.links[number]
                x, y, _, u, v, rate = self._numbers[number].tolist()
                turned = complex(turn[number])
                to_centre = link.centre * turned
                joint = complex(x, y) - to_centre
                velocity = complex(u, v) - 1j * rate * to_centre
                poses[number] = link.pose(joint, velocity, turned)
                rates[number] = rate
        return contact.pair.closest(poses, rates, contact.piece)
