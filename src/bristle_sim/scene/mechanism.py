"""Chains of rigid links whose roots are fixed or carried by a turning hub: their shape and mass, without forces."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array

Vector = tuple[float, float]
Complexes = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Link:
    """A rigid link; engine units.

    Positions are those from the link's joint at the angle 0, at which the link is along (0, -1).

    Attributes:
        mass: mass.
        inertia: moment of inertia about the centre of mass.
        centre: centre of mass.
        tip: end of the link.
        knees: corners of the centre line between joint and tip.
    """

    mass: float
    inertia: float
    centre: Vector
    tip: Vector
    knees: tuple[Vector, ...] = ()

    @classmethod
    def rod(cls, mass: float, length: float) -> Link:
        """Return a uniform slender rod, of moment of inertia m L^2/12."""
        return cls(mass, mass * length**2 / 12.0, (0.0, -length / 2.0), (0.0, -length))

    @property
    def inertia_about_joint(self) -> float:
        """Moment of inertia about the joint."""
        return self.inertia + self.mass * (self.centre[0] ** 2 + self.centre[1] ** 2)


class State(NamedTuple):
    """Time, and the absolute angle, rad, and rate of every link; engine units."""

    time: float
    angles: tuple[float, ...]
    rates: tuple[float, ...]


class Pose(NamedTuple):
    """Positions of a link's joint, centre, tip and knees, and the velocity of its joint."""

    joint: Vector
    centre: Vector
    tip: Vector
    joint_velocity: Vector
    knees: tuple[Vector, ...] = ()

    @property
    def corners(self) -> tuple[Vector, ...]:
        """The joint, the knees and the tip."""
        return (self.joint, *self.knees, self.tip)


class ChainConstants(NamedTuple):
    """Constants of identical wires; complex numbers stand for points in the plane.

    Attributes:
        tips: position of every link's tip from its joint.
        centres: position of every link's centre from its joint.
        inertias: moment of inertia of every link about its centre.
        arms: g_kj of one wire, transposed: from the joint of link j to the next joint (j < k) or to
            the link's centre (j = k).
        moments: conjugates of ``arms`` times the masses.
        products: mass matrix at the angles 0.
    """

    tips: Complexes
    centres: Complexes
    inertias: Array
    arms: Complexes
    moments: Complexes
    products: Complexes


@dataclass
class Mechanism:
    """Links in order from the root, which moves on a circle of ``hub_radius`` at ``hub_speed`` from
    ``hub_start``.

    Without a hub (radius and speed 0) the root is the origin. Several ``wires`` have equally many
    links; the links of the foremost wire come first. Each root lags the root before it by
    ``pitch``, rad.
    """

    links: tuple[Link, ...]
    hub_radius: float = 0.0
    hub_speed: float = 0.0
    hub_start: float = 0.0
    wires: int = 1
    pitch: float = 0.0
    wire_links: int = field(init=False)
    single_link: bool = field(init=False)
    _known: deque[tuple[State, list[Pose]]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Count the links of a wire; ``single_link`` is true for one link alone, with one degree of
        freedom.
        """
        self.wire_links = len(self.links) // self.wires
        self.single_link = len(self.links) == 1
        self._known = deque(maxlen=3)

    def hub_angle(self, time: float) -> float:
        """Return the angle of the first root, rad."""
        return self.hub_start + self.hub_speed * time

    def root_angle(self, link: int, time: float) -> float:
        """Return the angle of the root of a link's wire, rad."""
        return self.hub_angle(time) - link // self.wire_links * self.pitch

    def wire(self, number: int) -> Mechanism:
        """Return a mechanism of one of the wires alone."""
        own = slice(number * self.wire_links, (number + 1) * self.wire_links)
        return Mechanism(
            self.links[own], self.hub_radius, self.hub_speed, self.hub_start - number * self.pitch
        )

    def poses(self, state: State) -> list[Pose]:
        """Return the poses of all links; those of the last three states are cached."""
        for known, poses in self._known:
            if known is state:
                return poses
        poses = []
        for number, (link, angle, rate) in enumerate(
            zip(self.links, state.angles, state.rates, strict=True)
        ):
            if number % self.wire_links == 0:
                root = self.hub_start + self.hub_speed * state.time
                root -= number // self.wire_links * self.pitch
                x = self.hub_radius * math.sin(root)
                y = -self.hub_radius * math.cos(root)
                u = -self.hub_speed * y
                v = self.hub_speed * x
            cosine = math.cos(angle)
            sine = math.sin(angle)
            a, b = link.centre
            centre = (x + cosine * a - sine * b, y + sine * a + cosine * b)
            a, b = link.tip
            tip = (x + cosine * a - sine * b, y + sine * a + cosine * b)
            knees = [(x + cosine * a - sine * b, y + sine * a + cosine * b) for a, b in link.knees]
            poses.append(Pose((x, y), centre, tip, (u, v), tuple(knees)))
            u -= rate * (tip[1] - y)
            v += rate * (tip[0] - x)
            x, y = tip
        self._known.append((state, poses))
        return poses

    def walk(
        self, time: Array, angles: Array, rates: Array
    ) -> Iterator[tuple[Link, Array, Array, Array, Array]]:
        """Yield each link of a wire with its turn, rate, and its joint's position and velocity, at
        the given times.

        Points are complex numbers x + iy. A point with the arm r from a joint at p has the velocity
        p' + i rate r.

        Yields:
            The link, e^(i angle), the rate, the joint's position and the joint's velocity; arrays
            over the times.
        """
        joint = -1j * self.hub_radius * np.exp(1j * (self.hub_start + self.hub_speed * time))
        velocity = 1j * self.hub_speed * joint
        for link, angle, rate in zip(self.links, angles.T, rates.T, strict=True):
            turn = np.exp(1j * angle)
            yield link, turn, rate, joint, velocity
            tip = complex(*link.tip) * turn
            joint = joint + tip
            velocity = velocity + 1j * rate * tip

    def centre_line(self, time: Array, angles: Array, rates: Array) -> tuple[Array, Array]:
        """Return the corners of a wire's centre line from root to tip, and their velocities.

        Args:
            time: times, shape (n,).
            angles: angles of the links, rad, shape (n, links).
            rates: rates of the links, shape (n, links).

        Returns:
            Positions and velocities, each of shape (n, corners, 2).
        """
        corners: list[tuple[Array, Array]] = []
        for link, turn, rate, joint, velocity in self.walk(time, angles, rates):
            arms = [complex(*corner) * turn for corner in (*link.knees, link.tip)]
            corners += [] if corners else [(joint, velocity)]
            corners += [(joint + arm, velocity + 1j * rate * arm) for arm in arms]
        places, velocities = (np.stack(each, axis=1) for each in zip(*corners, strict=True))
        return np.stack([places.real, places.imag], axis=-1), np.stack(
            [velocities.real, velocities.imag], axis=-1
        )

    def speed_bound(self, state: State) -> float:
        """Return a bound of the speed of all points, or of one wire relative to another, while no
        rate exceeds the state's.
        """
        bound = min(self.wires, 2) * self.hub_radius * abs(self.hub_speed)
        for link, rate in zip(self.links, state.rates, strict=True):
            bound += math.hypot(*link.tip) * abs(rate)
        return bound

    @cached_property
    def constants(self) -> ChainConstants:
        """Constants of the wires, computed when they are first needed."""
        size = self.wire_links
        tips, centres = np.array(
            [(complex(*link.tip), complex(*link.centre)) for link in self.links]
        ).T
        inertias = np.array([link.inertia for link in self.links])
        arms = np.where(np.tri(size, k=-1, dtype=bool), tips[:size], 0.0) + np.diag(centres[:size])
        moments = np.conj(arms).T * np.array([link.mass for link in self.links[:size]])
        products = np.kron(np.eye(self.wires), moments @ arms + np.diag(inertias[:size]))
        return ChainConstants(tips, centres, inertias, arms.T, moments.T, products)

    def mass_matrix(self, turn: Complexes) -> Array:
        """Return the mass matrix in the links' absolute angles, shape (links, links); ``turn`` is e^{i angle} of each link."""
        return np.asarray((turn.conj()[:, None] * self.constants.products * turn).real)


def cross(arm: Vector, direction: Vector) -> float:
    """Return the lever of a direction through the end of an arm, about the arm's start."""
    return arm[0] * direction[1] - arm[1] * direction[0]


class Curve:
    """The polynomial through the angles and rates of two states (cubic) or three states
    (quintic)."""

    def __init__(self, *states: State) -> None:
        """Compute the coefficients of Newton's form for each link, by divided differences."""
        times = [state.time for state in states for _ in range(2)]
        self._nodes = times[-2::-1]
        self._links = []
        for angles, rates in zip(
            zip(*(state.angles for state in states), strict=True),
            zip(*(state.rates for state in states), strict=True),
            strict=True,
        ):
            column = [angle for angle in angles for _ in range(2)]
            for order in range(1, len(times)):
                for last in range(len(times) - 1, order - 1, -1):
                    span = times[last] - times[last - order]
                    change = column[last] - column[last - 1]
                    column[last] = change / span if span else rates[last // 2]
            self._links.append(column[::-1])

    def __call__(self, time: float) -> State:
        """Return the state at a time."""
        distances = [time - node for node in self._nodes]
        angles = []
        rates = []
        for highest, *others in self._links:
            value = highest
            rate = 0.0
            for distance, coefficient in zip(distances, others, strict=True):
                rate = rate * distance + value
                value = value * distance + coefficient
            angles.append(value)
            rates.append(rate)
        return State(time, tuple(angles), tuple(rates))
