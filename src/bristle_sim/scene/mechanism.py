"""Chains of rigid links whose roots are fixed or carried by a rotating hub.

The module contains their geometry, kinematics and mass, but no forces. Points and vectors in the
plane are complex numbers x + iy. The vector v turned by 90 degrees is i v. A point at the vector r
from a link's joint moves at the joint's velocity plus i r times the link's angular velocity.
"""

from __future__ import annotations

import cmath
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array

Vector = tuple[float, float]
"""Two real components: (x, y) in the engine, (normal, tangential) at a contact."""
Complexes = NDArray[np.complex128]
Times = TypeVar("Times", float, Array)


@dataclass(frozen=True, slots=True)
class Link:
    """A rigid link; engine units.

    Positions are complex numbers x + iy relative to the link's joint, with the link at angle 0. A
    straight link at angle 0 points along -y.

    Attributes:
        mass: mass.
        inertia: moment of inertia about the centre of mass.
        centre: position of the centre of mass.
        corners: positions of the joint (which is 0), of the knees of the centre line, and of the
            tip.
    """

    mass: float
    inertia: float
    centre: complex
    corners: tuple[complex, ...]

    @classmethod
    def rod(cls, mass: float, length: float) -> Link:
        """Return a uniform slender rod, whose moment of inertia is m L^2/12."""
        return cls(mass, mass * length**2 / 12.0, -0.5j * length, (0j, -1j * length))

    @property
    def inertia_about_joint(self) -> float:
        """Moment of inertia about the joint."""
        return self.inertia + self.mass * abs(self.centre) ** 2

    def pose(self, joint: complex, velocity: complex, turn: complex) -> Pose:
        """Return the link's ``Pose``, given its direction and the motion of its joint.

        Args:
            joint: position of the joint.
            velocity: velocity of the joint.
            turn: e^{i angle} of the link.
        """
        corners = [joint]
        for corner in self.corners[1:]:
            corners.append(joint + turn * corner)
        return Pose(joint, velocity, turn * self.centre, tuple(corners))


class State(NamedTuple):
    """The state of a mechanism.

    Attributes:
        time: time, in engine units.
        angles: absolute angle of each link, rad.
        rates: absolute angular velocity of each link, rad per engine unit of time.
    """

    time: float
    angles: tuple[float, ...]
    rates: tuple[float, ...]

    def moved(self, time: float, accelerations: Sequence[float]) -> State:
        """Return the state a short time later, at constant angular accelerations."""
        links = [*zip(self.angles, self.rates, accelerations, strict=True)]
        angles = tuple([a + time * (u + 0.5 * time * b) for a, u, b in links])
        return State(self.time + time, angles, tuple([u + time * b for _, u, b in links]))


class Pose(NamedTuple):
    """Position of a link in the plane, and the velocity of its joint.

    Attributes:
        joint: position of the joint.
        velocity: velocity of the joint.
        to_centre: vector from the joint to the centre of mass.
        corners: positions of the joint, the knees and the tip.
    """

    joint: complex
    velocity: complex
    to_centre: complex
    corners: tuple[complex, ...]


@dataclass
class Mechanism:
    """One or several wires, each a chain of rigid links, on a hub of constant angular velocity.

    Attributes:
        links: the links of all wires, from the root of each wire. The foremost wire comes first;
            all wires have the same number of links.
        hub_radius: radius of the circle on which the roots move; 0 for a root at the origin.
        hub_speed: angular velocity of the hub.
        hub_start: angle of the first root at time 0, rad.
        wires: number of wires.
        pitch: angle by which each root lags the root in front of it, rad.
        wire_links: number of links of one wire.
        single_link: whether the mechanism is a single link, with one degree of freedom.
        jointed: whether a wire has several links.
    """

    links: tuple[Link, ...]
    hub_radius: float = 0.0
    hub_speed: float = 0.0
    hub_start: float = 0.0
    wires: int = 1
    pitch: float = 0.0
    wire_links: int = field(init=False)
    single_link: bool = field(init=False)
    jointed: bool = field(init=False)
    _known: deque[tuple[State, list[Pose]]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Compute the attributes that follow from the numbers of links and wires."""
        self.wire_links = len(self.links) // self.wires
        self.single_link = len(self.links) == 1
        self.jointed = self.wire_links > 1
        self._known = deque(maxlen=6)

    def root_angle(self, time: Times, link: int = 0) -> Times:
        """Return the angle (rad) of the root of the wire that contains a link.

        Args:
            time: a time, or an array of times.
            link: the link's index.
        """
        return self.hub_start + self.hub_speed * time - link // self.wire_links * self.pitch

    def poses(self, state: State) -> list[Pose]:
        """Return the positions and joint velocities of all links.

        The results for the last six states are cached.
        """
        for known, poses in self._known:
            if known is state:
                return poses
        poses = self.poses_at(*state, cmath.exp)
        self._known.append((state, poses))
        return poses

    def poses_at(self, time: Any, angles: Any, rates: Any, exp: Callable[[Any], Any]) -> list[Any]:
        """Return the positions and joint velocities of all links, for one or several times.

        Args:
            time: the time, or an array of n times.
            angles: angle of each link (rad), or an array of shape (links, n).
            rates: angular velocity of each link, or an array of shape (links, n).
            exp: exponential function, of numbers or of arrays like the other arguments.

        Returns:
            One ``Pose`` for each link, of numbers or of arrays of shape (n,).
        """
        poses: list[Pose] = []
        for number, link in enumerate(self.links):
            if number % self.wire_links == 0:
                joint = -1j * self.hub_radius * exp(1j * self.root_angle(time, number))
                velocity = 1j * self.hub_speed * joint
            else:
                carrier = poses[-1]
                joint = carrier.corners[-1]
                velocity = velocity + 1j * rates[number - 1] * (joint - carrier.joint)
            poses.append(link.pose(joint, velocity, exp(1j * angles[number])))
        return poses

    def speed_bound(self, state: State) -> float:
        """Return an upper bound of any point's speed and of the relative speed of any two points.

        The bound holds as long as no link rotates faster than in ``state``.
        """
        bound = min(self.wires, 2) * self.hub_radius * abs(self.hub_speed)
        for link, rate in zip(self.links, state.rates, strict=True):
            bound += abs(link.corners[-1]) * abs(rate)
        return bound

    @cached_property
    def tips(self) -> Complexes:
        """Vectors from joint to tip of all links, with the links at angle 0."""
        return np.array([link.corners[-1] for link in self.links])

    @cached_property
    def arms(self) -> Complexes:
        """Parts of the vectors from the hub's centre to the links' centres of mass.

        Row k of the array, shape (links, 1 + links), belongs to link k. Its first entry is the
        vector to the wire's root, with the hub at angle 0. The other entries belong to the links,
        each at angle 0: the vector from joint to tip of a link that carries link k, the vector from
        the joint to the centre of mass of link k itself, and 0 for any other link.
        """
        wire = np.arange(len(self.links)) // self.wire_links
        roots = -1j * self.hub_radius * np.exp(-1j * self.pitch * wire)
        carriers = np.tril(wire[:, None] == wire, k=-1)
        own = np.diag([link.centre for link in self.links])
        return np.column_stack([roots, np.where(carriers, self.tips, own)])

    @cached_property
    def inertias(self) -> Array:
        """Mass, mass again, and moment of inertia about the centre of mass of each link in turn."""
        return np.array([[link.mass, link.mass, link.inertia] for link in self.links]).ravel()

    @cached_property
    def _still_rows(self) -> Array:
        """``body_rows`` of links whose centres of mass do not move, shape (links, 3, 1 + links)."""
        rows = np.zeros((len(self.links), 3, 1 + len(self.links)))
        rows[:, 2, 1:] = np.eye(len(self.links))
        return rows

    def body_rows(self, turn: Complexes) -> Array:
        """Return the Jacobian B of the links' velocities in the angular velocities.

        It has three rows for each link: the velocity of its centre of mass along x and y, and its
        angular velocity. The columns belong to the angular velocities of the hub and of all links.
        ``turn`` is e^{i angle} of hub and links, shape (1 + links,).
        """
        rows = self._still_rows.copy()
        velocities = 1j * self.arms * turn
        rows[:, 0] = velocities.real
        rows[:, 1] = velocities.imag
        return rows.reshape(-1, len(turn))

    def mass_matrix(self, turn: Complexes) -> Array:
        """Return the mass matrix, shape (links, links); the coordinates are the absolute angles.

        ``turn`` is e^{i angle} of each link, shape (links,).
        """
        rows = self.body_rows(np.concatenate([[1.0], turn]))[:, 1:]
        return np.asarray(rows.T * self.inertias @ rows)

    def straight_mass_matrix(self) -> Array:
        """Return the mass matrix of one wire whose links are all at the same angle."""
        size = self.wire_links
        return self.mass_matrix(np.ones(len(self.links), complex))[:size, :size]


def xy(point: complex) -> Vector:
    """Return the coordinates (x, y) of a point, the form that the engine requires."""
    return (point.real, point.imag)


def cross(arm: complex, direction: complex) -> float:
    """Return the cross product of two vectors, ``arm`` x ``direction``.

    The product is the moment, about the start of ``arm``, of a force ``direction`` that acts at the
    end of ``arm``. For a unit vector ``direction`` the product is the lever of the force.
    """
    return (arm.conjugate() * direction).imag


class Curve:
    """The interpolating polynomial of the motion in an interval.

    For each link the polynomial is the cubic Hermite polynomial of the angles and angular
    velocities at both ends. If the state in the middle is given, (s (1 - s))^2 times a linear
    function of s is added, where s is the fraction of the interval. The angle and the angular
    velocity in the middle are then exact too.
    """

    def __init__(self, start: State, middle: State | None, end: State) -> None:
        """Compute the coefficients of each link's polynomial."""
        self._start = start.time
        self._length = length = end.time - start.time
        self._middle = part = 0.0 if middle is None else (middle.time - start.time) / length
        hump = part * (1.0 - part)
        self._links = []
        for link, angle in enumerate(start.angles):
            turn = length * start.rates[link]
            change = end.angles[link] - angle
            twist = turn + length * end.rates[link] - 2.0 * change
            bend = change - turn - twist
            lift = tilt = 0.0
            if middle is not None:
                lift = middle.angles[link] - angle - part * (turn + part * (bend + part * twist))
                lift /= hump * hump
                tilt = length * middle.rates[link] - turn - part * (2.0 * bend + 3.0 * part * twist)
                tilt = (tilt - 2.0 * hump * (1.0 - 2.0 * part) * lift) / (hump * hump)
            self._links.append((angle, turn, bend, twist, lift, tilt))

    def at(self, time: float) -> State:
        """Return the interpolated state at a time after the start."""
        part = time / self._length
        hump = part * (1.0 - part)
        angles = []
        rates = []
        for angle, turn, bend, twist, lift, tilt in self._links:
            raised = lift + tilt * (part - self._middle)
            cubic = angle + part * (turn + part * (bend + part * twist))
            angles.append(cubic + hump * hump * raised)
            slope = turn + part * (2.0 * bend + 3.0 * part * twist)
            slope += hump * (hump * tilt + 2.0 * (1.0 - 2.0 * part) * raised)
            rates.append(slope / self._length)
        return State(self._start + time, tuple(angles), tuple(rates))
