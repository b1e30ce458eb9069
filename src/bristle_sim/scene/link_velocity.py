"""The velocity of a single link after an engine step, corrected to obey a sustained contact.

With one contact and one degree of freedom, the equations of :mod:`bristle_sim.scene.solver` are
solved in closed form. With matrices a run would take 2.5 times as long.
"""

from __future__ import annotations

from cmath import rect
from collections.abc import Sequence

import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.pairs import ClosedPair, FixedPair
from bristle_sim.scene.solver import NEWTON_ROUNDS

LEAST_LEVER = 1e-6
"""Shortest lever of the contact normal about the link's joint, as a fraction of the link's length,
at which a rotation of the link can close a gap."""

CLOSED_GAP = 1e-10
"""Gap, as a fraction of the link's length, below which Newton's method ends. A further iteration
would change the angular velocity by less than any requested accuracy."""

_angle = lib.cpBodyGetAngle
_rate = lib.cpBodyGetAngularVelocity
_set_rate = lib.cpBodySetAngularVelocity
_set_velocity = lib.cpBodySetVelocity


class LinkVelocity:
    """Corrects a single link's angular velocity after each engine step, to keep a contact closed.

    Attributes:
        impulses: for each step, a list with one entry for the contact: (normal impulse, tangential
            impulse, slip velocity).
    """

    def __init__(
        self,
        mechanism: Mechanism,
        damping: Sequence[float],
        hub: pymunk.Body,
        body: pymunk.Body,
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
        speed = self._speed
        ratio = self._ratio
        joint = self._root * rect(1.0, _angle(self._hub))
        turn = rect(1.0, _angle(body))
        start, end = self._line
        _, point, normal = self._touch(joint + turn * start, joint + turn * end)
        damping = step * self._damping
        inertia = self._inertia + damping
        rate = (self._inertia * _rate(body) + damping * speed) / inertia
        along = 1j * normal.conjugate()
        levers = (point - joint) * along  # the normal's lever, and minus the tangent's
        across = speed * joint  # velocity of the joint, turned by -90 degrees
        carried = across * along  # its components along the normal and, negative, the tangent
        lever = levers.real
        turning = (lever - ratio * levers.imag) / inertia
        yields = lever * turning
        push = -(carried.real + rate * lever) / yields if yields else 0.0
        rate += turning * push
        velocity = 1j * (across + rate * turn * self._centre)
        _set_rate(body, rate)
        _set_velocity(body, (velocity.real, velocity.imag))
        self.impulses.append([(push, ratio * push, -carried.imag - rate * levers.imag)])
