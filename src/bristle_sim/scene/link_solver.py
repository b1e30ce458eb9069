"""The velocity of a single link that obeys its joint and a sustained contact, in closed form.

A link on its joint has one degree of freedom, its rate w. Let n be the contact normal, l_n and l_t
the levers of normal and tangent about the joint, u the velocity of the joint, and p the normal
impulse. Friction adds the impulse f p along the surface, with f = -mu s, the coefficient of
friction mu and the sense of slip s. The contact stays closed if

    u.n + l_n (w + (l_n + f l_t) p/I) = 0,

where I is the moment of inertia about the joint plus the belt's damping times the step. This
closed form equals the solution of :mod:`bristle_sim.scene.solver` for one link; the matrices of
that module would make a pass 2.5 times as slow.
"""

from __future__ import annotations

from cmath import rect
from collections.abc import Sequence

import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.scene.mechanism import Mechanism
from bristle_sim.scene.pairs import ClosedPair, FixedPair

_angle = lib.cpBodyGetAngle
_rate = lib.cpBodyGetAngularVelocity
_set_rate = lib.cpBodySetAngularVelocity
_set_velocity = lib.cpBodySetVelocity


class LinkVelocity:
    """Sets the angular velocity of a single link after each engine step so that its contact stays
    closed.

    Attributes:
        impulses: for each step, a list with one entry for the one contact: (normal impulse,
            tangential impulse, slip velocity).
    """

    reversible = False  # steps with this solver are not symmetric in time

    def __init__(
        self,
        mechanism: Mechanism,
        damping: Sequence[float],
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
    ) -> None:
        self._damping = damping[0]
        (self._link,) = mechanism.links
        self._inertia = self._link.inertia_about_joint
        self._centre = self._link.centre
        self._root = -1j * mechanism.hub_radius
        self._speed = mechanism.hub_speed
        self._hub = None if hub is None else hub._body
        self._body = links[0]._body
        self.impulses: list[list[tuple[float, float, float]]] = []

    def set_contacts(self, contacts: Sequence[ClosedPair]) -> None:
        """Keep one sustained contact closed from now on; ``contacts`` holds this contact alone."""
        ((pair, piece, slip),) = contacts
        assert isinstance(pair, FixedPair), "a single link has no neighbour"
        self._pair = pair
        self._line = pair.lines(self._link.corners)[piece or 0]
        self._ratio = -pair.friction * (slip or 0)

    def solve(self, step: float) -> None:
        """Correct the link's rate after an engine step so that the contact stays closed; the belt's
        damping is integrated implicitly.

        The engine step has applied the belt's spring and has already made the link obey its joint.
        """
        body = self._body
        ratio = self._ratio
        speed = self._speed
        joint = self._root
        if self._hub is not None:
            joint *= rect(1.0, _angle(self._hub))
        turn = rect(1.0, _angle(body))
        start, end = self._line
        _, point, normal = self._pair.touch((joint + turn * start, joint + turn * end))
        damping = step * self._damping
        inertia = self._inertia + damping
        rate = (self._inertia * _rate(body) + damping * speed) / inertia
        # The contact point's velocity, u + i w arm, has the components of i (speed * joint + w arm).
        along = 1j * normal.conjugate()
        levers = (point - joint) * along  # lever of the normal, and minus the tangent's
        carried = joint * along
        lever = levers.real
        turning = (lever - ratio * levers.imag) / inertia
        yields = lever * turning
        push = -(speed * carried.real + rate * lever) / yields if yields else 0.0
        rate += turning * push
        velocity = 1j * (speed * joint + rate * turn * self._centre)
        _set_rate(body, rate)
        _set_velocity(body, (velocity.real, velocity.imag))
        slip = -speed * carried.imag - rate * levers.imag
        self.impulses.append([(push, ratio * push, slip)])
