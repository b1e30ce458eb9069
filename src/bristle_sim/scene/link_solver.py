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

import math
from collections.abc import Callable, Sequence

import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.scene.mechanism import Link, Mechanism
from bristle_sim.scene.pairs import BarPair, ClosedPair, WorkpartPair

_angle = lib.cpBodyGetAngle
_rate = lib.cpBodyGetAngularVelocity
_set_rate = lib.cpBodySetAngularVelocity
_set_velocity = lib.cpBodySetVelocity

Touch = Callable[[float, float, float, float], tuple[float, float, float, float]]
"""Function that locates the contact point of a link.

It takes x and y of the joint, and the cosine and sine of the link's angle. It returns x and y of
the vector from the joint to the contact point, and x and y of the contact normal."""


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
        (link,) = links
        self._damping = damping[0]
        self._link = mechanism.links[0]
        self._inertia = self._link.inertia_about_joint
        self._centre = self._link.centre
        self._radius = mechanism.hub_radius
        self._speed = mechanism.hub_speed
        self._hub = None if hub is None else hub._body
        self._body = link._body
        self._touch: Touch | None = None
        self._ratio = 0.0
        self.impulses: list[list[tuple[float, float, float]]] = []

    def set_contacts(self, contacts: Sequence[ClosedPair]) -> None:
        """Keep one sustained contact closed from now on; ``contacts`` holds this contact alone."""
        (closed,) = contacts
        self._touch = _touch_of(closed, self._link)
        self._ratio = -closed.pair.friction * (closed.slip or 0)

    def solve(self, step: float) -> None:
        """Correct the link's rate after an engine step so that the contact stays closed; the belt's
        damping is integrated implicitly.

        The engine step has applied the belt's spring and has already made the link obey its joint.
        """
        touch = self._touch
        body = self._body
        speed = self._speed
        ratio = self._ratio
        assert touch is not None
        hub = _angle(self._hub) if self._hub is not None else 0.0
        angle = _angle(body)
        joint_x = self._radius * math.sin(hub)
        joint_y = -self._radius * math.cos(hub)
        moving_x = -speed * joint_y
        moving_y = speed * joint_x
        cosine = math.cos(angle)
        sine = math.sin(angle)
        arm_x, arm_y, normal_x, normal_y = touch(joint_x, joint_y, cosine, sine)
        damping = step * self._damping
        inertia = self._inertia + damping
        rate = (self._inertia * _rate(body) + damping * speed) / inertia
        lever = arm_x * normal_y - arm_y * normal_x
        along = -arm_x * normal_x - arm_y * normal_y
        turning = (lever + ratio * along) / inertia
        yields = lever * turning
        push = (
            -(moving_x * normal_x + moving_y * normal_y + rate * lever) / yields if yields else 0.0
        )
        rate += turning * push
        x, y = self._centre
        _set_rate(body, rate)
        _set_velocity(
            body,
            (moving_x - rate * (sine * x + cosine * y), moving_y + rate * (cosine * x - sine * y)),
        )
        slip = moving_x * normal_y - moving_y * normal_x + rate * along
        self.impulses.append([(push, ratio * push, slip)])


def _touch_of(closed: ClosedPair, link: Link) -> Touch:
    """Return the function that locates the contact point and the normal of a pair.

    On the workpart the contact point is a corner of the link. On the bar it is the point of a
    straight segment of the wire, with round ends, that is closest to the bar.
    """
    pair = closed.pair
    corners = ((0.0, 0.0), *link.knees, link.tip)
    if isinstance(pair, WorkpartPair):
        corner_x, corner_y = corners[1:][pair.corner]
        return lambda _, __, cosine, sine: (
            cosine * corner_x - sine * corner_y,
            sine * corner_x + cosine * corner_y,
            0.0,
            1.0,
        )
    assert isinstance(pair, BarPair), "a single link has no neighbour"
    (start_x, start_y), end = corners[closed.piece or 0 :][:2]
    length = math.dist((start_x, start_y), end)
    along_x = (end[0] - start_x) / length
    along_y = (end[1] - start_y) / length
    bar_x, bar_y = pair.centre
    wire = pair.wire_radius

    def touch(
        joint_x: float, joint_y: float, cosine: float, sine: float
    ) -> tuple[float, float, float, float]:
        """Return x and y of the vector from joint to contact point, and x and y of the normal."""
        x = cosine * start_x - sine * start_y
        y = sine * start_x + cosine * start_y
        u = cosine * along_x - sine * along_y
        v = sine * along_x + cosine * along_y
        to_bar_x = bar_x - joint_x
        to_bar_y = bar_y - joint_y
        foot = (to_bar_x - x) * u + (to_bar_y - y) * v
        foot = 0.0 if foot < 0.0 else length if foot > length else foot
        x += foot * u
        y += foot * v
        away_x = x - to_bar_x
        away_y = y - to_bar_y
        distance = math.hypot(away_x, away_y) or 1.0
        away_x /= distance
        away_y /= distance
        return x - wire * away_x, y - wire * away_y, away_x, away_y

    return touch
