"""The velocity of a single link that obeys its joint and a sustained contact, in closed form.

A link on its joint has one freedom, its rate w. With the levers l_n, l_t of normal and tangent at the joint, the velocity of the
joint u, and friction that adds the fraction f = -mu s of the normal impulse p along the surface, the contact stays closed if

    u.n + l_n (w + (l_n + f l_t) p/I) = 0,

where I is the moment of inertia about the joint, plus the belt's damping times the step. It is the solution of :mod:`bristle_sim.scene.solver` for one link, without its
matrices: those would make a pass 2.5 times as expensive.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.scene.mechanism import Link, Mechanism, Vector
from bristle_sim.scene.pairs import BarPair, ClosedPair, WorkpartPair

Touch = Callable[[Vector, float, float], tuple[float, float, float, float]]
"""Joint, cosine and sine of the link's angle in; the arm of the contact point from the joint and the normal out."""


class LinkVelocity:
    """The rate of a single link after an engine step.

    Attributes:
        impulses: normal and tangential impulse of the contact in the last step, and its slip.
    """

    reversible = False  # its steps are not symmetric in time
    symmetric = correct = False

    def __init__(
        self,
        space: pymunk.Space,
        mechanism: Mechanism,
        damping: Sequence[float],
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
    ) -> None:
        (link,) = links
        self._damping = damping[0]
        self._springs: list[pymunk.DampedRotarySpring] = []
        if self._damping:
            self._springs = [each for each in space.constraints if isinstance(each, pymunk.DampedRotarySpring)]
        self._active = False
        self._link = mechanism.links[0]
        self._inertia = self._link.inertia_about_joint
        self._radius = mechanism.hub_radius
        self._speed = mechanism.hub_speed
        self._hub = None if hub is None else hub._body
        self._body = link._body
        self._touch: Touch | None = None
        self._ratio = 0.0
        self.impulses: list[tuple[float, float, float]] = []

    def take_over(self, *, active: bool) -> None:
        """Assign the damping to this solver or to the engine."""
        if self._damping and active is not self._active:
            self._active = active
            for spring in self._springs:
                spring.damping = 0.0 if active else self._damping

    @property
    def contacts(self) -> Sequence[ClosedPair]:
        """The sustained contact that acts, if there is one."""
        raise AttributeError("contacts are only set")

    @contacts.setter
    def contacts(self, contacts: Sequence[ClosedPair]) -> None:
        self._touch = None
        for closed in contacts:
            self._touch = _touch_of(closed, self._link)
            self._ratio = -closed.pair.friction * (closed.slip or 0)

    def solve(self, step: float) -> None:
        """Make the link's velocity after an engine step obey the joint and the contact, with implicit damping."""
        assert self._touch is not None
        hub = lib.cpBodyGetAngle(self._hub) if self._hub is not None else 0.0
        angle = lib.cpBodyGetAngle(self._body)
        rate = lib.cpBodyGetAngularVelocity(self._body)
        joint = (self._radius * math.sin(hub), -self._radius * math.cos(hub))
        moving_x, moving_y = -self._speed * joint[1], self._speed * joint[0]
        cosine, sine = math.cos(angle), math.sin(angle)
        x, y = self._link.centre
        centre_x, centre_y = cosine * x - sine * y, sine * x + cosine * y
        # The nearest velocity that obeys the joint.
        velocity = lib.cpBodyGetVelocity(self._body)
        moment = centre_x * (velocity.y - moving_y) - centre_y * (velocity.x - moving_x)
        damping = step * self._damping
        inertia = self._inertia + damping
        rate = (self._link.inertia * rate + self._link.mass * moment + damping * self._speed) / inertia
        arm_x, arm_y, normal_x, normal_y = self._touch(joint, cosine, sine)
        lever = arm_x * normal_y - arm_y * normal_x
        along = -arm_x * normal_x - arm_y * normal_y
        turning = (lever + self._ratio * along) / inertia
        approach = moving_x * normal_x + moving_y * normal_y + rate * lever
        push = -approach / (lever * turning) if lever * turning else 0.0
        rate += turning * push
        lib.cpBodySetAngularVelocity(self._body, rate)
        lib.cpBodySetVelocity(self._body, (moving_x - rate * centre_y, moving_y + rate * centre_x))
        slip = moving_x * normal_y - moving_y * normal_x + rate * along
        self.impulses = [(push, self._ratio * push, slip)]


def _touch_of(closed: ClosedPair, link: Link) -> Touch:
    """Return the function that gives the contact point of a pair."""
    pair = closed.pair
    if isinstance(pair, WorkpartPair):
        return _corner((*link.knees, link.tip)[pair.corner])
    assert isinstance(pair, BarPair), "a single link has no neighbour"
    corners = ((0.0, 0.0), *link.knees, link.tip)
    piece = closed.piece or 0
    return _flank(pair, corners[piece], corners[piece + 1])


def _corner(corner: Vector) -> Touch:
    """Return the touch of a corner on the workpart."""
    x, y = corner

    def touch(joint: Vector, cosine: float, sine: float) -> tuple[float, float, float, float]:
        del joint
        return cosine * x - sine * y, sine * x + cosine * y, 0.0, 1.0

    return touch


def _flank(bar: BarPair, start: Vector, end: Vector) -> Touch:
    """Return the touch of a straight piece, with round ends, on the bar."""
    length = math.dist(start, end)
    along_x, along_y = (end[0] - start[0]) / length, (end[1] - start[1]) / length
    bar_x, bar_y = bar.centre
    wire = bar.wire_radius

    def touch(joint: Vector, cosine: float, sine: float) -> tuple[float, float, float, float]:
        x, y = cosine * start[0] - sine * start[1], sine * start[0] + cosine * start[1]
        u, v = cosine * along_x - sine * along_y, sine * along_x + cosine * along_y
        to_bar_x, to_bar_y = bar_x - joint[0], bar_y - joint[1]
        foot = min(max((to_bar_x - x) * u + (to_bar_y - y) * v, 0.0), length)
        x += foot * u
        y += foot * v
        away_x, away_y = x - to_bar_x, y - to_bar_y
        distance = math.hypot(away_x, away_y) or 1.0
        away_x /= distance
        away_y /= distance
        return x - wire * away_x, y - wire * away_y, away_x, away_y

    return touch
