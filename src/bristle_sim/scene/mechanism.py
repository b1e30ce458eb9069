"""Chains of rigid links whose roots stand still or ride on a turning hub: their shape and mass, without forces."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array

Vector = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Link:
    """A rigid link; ``centre``, ``tip`` and ``knees`` are seen from its joint when the link's angle is 0, along (0, -1).

    Engine units: mass, inertia about the centre of mass, lengths. ``knees`` are corners of its centre line before the tip.
    """

    mass: float
    inertia: float
    centre: Vector
    tip: Vector
    knees: tuple[Vector, ...] = ()

    @classmethod
    def rod(cls, mass: float, length: float) -> Link:
        """Return a uniform slender rod, inertia m L^2/12."""
        return cls(mass, mass * length**2 / 12.0, (0.0, -length / 2.0), (0.0, -length))

    @property
    def inertia_about_joint(self) -> float:
        """Moment of inertia about the joint."""
        return self.inertia + self.mass * (self.centre[0] ** 2 + self.centre[1] ** 2)


class State(NamedTuple):
    """Time, and absolute angle and rate of every link; engine units, rad."""

    time: float
    angles: tuple[float, ...]
    rates: tuple[float, ...]


class Pose(NamedTuple):
    """One link in space: its joint, centre, tip and knees, and velocities of the first three."""

    joint: Vector
    centre: Vector
    tip: Vector
    joint_velocity: Vector
    centre_velocity: Vector
    tip_velocity: Vector
    knees: tuple[Vector, ...] = ()

    @property
    def corners(self) -> tuple[Vector, ...]:
        """The joint, the knees and the tip."""
        return (self.joint, *self.knees, self.tip)


@dataclass(frozen=True, slots=True)
class Mechanism:
    """Links in order from the root; the root moves on a circle of ``hub_radius`` at ``hub_speed``, from ``hub_start``.

    Without a hub (radius and speed 0) the root is the origin. The links of several ``wires``, equally many each, follow one
    another, the foremost wire's first; each root lags the one before it by ``pitch``, rad.
    """

    links: tuple[Link, ...]
    hub_radius: float = 0.0
    hub_speed: float = 0.0
    hub_start: float = 0.0
    wires: int = 1
    pitch: float = 0.0
    wire_links: int = field(init=False)
    _lengths: tuple[float, ...] = field(init=False, repr=False)
    _alone: tuple[Mechanism, ...] = field(init=False, repr=False, compare=False)
    _kept: deque[tuple[State, list[Pose]]] = field(
        default_factory=lambda: deque(maxlen=3), init=False, repr=False, compare=False
    )

    def __post_init__(self) -> None:
        """Count the links of a wire, and take down from joint to joint how long each is."""
        object.__setattr__(self, "wire_links", len(self.links) // self.wires)
        object.__setattr__(self, "_lengths", tuple(math.hypot(*link.tip) for link in self.links))
        alone = () if self.wires == 1 else tuple(map(self.wire, range(self.wires)))
        object.__setattr__(self, "_alone", alone)

    @property
    def lone(self) -> bool:
        """Whether there is one link alone, with one degree of freedom."""
        return len(self.links) == 1

    def hub_angle(self, time: float) -> float:
        """Return the angle of the first root, rad."""
        return self.hub_start + self.hub_speed * time

    def root_angle(self, link: int, time: float) -> float:
        """Return the angle of the root of a link's wire, rad."""
        return self.hub_angle(time) - link // self.wire_links * self.pitch

    def wire(self, number: int) -> Mechanism:
        """Return one of the wires alone."""
        size = self.wire_links
        links = self.links[number * size : (number + 1) * size]
        return Mechanism(links, self.hub_radius, self.hub_speed, self.hub_start - number * self.pitch)

    def poses(self, state: State) -> list[Pose]:
        """Return where every link is and how it moves; the last few are kept, as one state is looked at again and again."""
        for known, poses in self._kept:
            if known is state:
                return poses
        poses = self._poses(state)
        self._kept.append((state, poses))
        return poses

    def _poses(self, state: State) -> list[Pose]:
        if self.wires > 1:
            size = self.wire_links
            parts = (slice(first, first + size) for first in range(0, len(self.links), size))
            alone = (State(state.time, state.angles[part], state.rates[part]) for part in parts)
            return [pose for wire, own in zip(self._alone, alone, strict=True) for pose in wire.poses(own)]
        speed, angle = self.hub_speed, self.hub_angle(state.time)
        x, y = self.hub_radius * math.sin(angle), -self.hub_radius * math.cos(angle)
        joint, joint_velocity = (x, y), (-speed * y, speed * x)
        poses = []
        for link, angle, rate in zip(self.links, state.angles, state.rates, strict=True):
            cosine, sine = math.cos(angle), math.sin(angle)
            centre, centre_velocity = _carried(joint, joint_velocity, link.centre, cosine, sine, rate)
            tip, tip_velocity = _carried(joint, joint_velocity, link.tip, cosine, sine, rate)
            knees: tuple[Vector, ...] = ()
            if link.knees:
                knees = tuple([_carried(joint, joint_velocity, each, cosine, sine, rate)[0] for each in link.knees])
            poses.append(Pose(joint, centre, tip, joint_velocity, centre_velocity, tip_velocity, knees))
            joint, joint_velocity = tip, tip_velocity
        return poses

    def centre_line(self, time: Array, angles: Array, rates: Array) -> tuple[Array, Array]:
        """Return the corners of a wire's centre line from the root over knees and joints to the tip, and their velocities.

        A point with the arm r from a joint at p moves with p' + rate e_z x r; with points as complex numbers x + iy that
        is p' + i rate r.

        Args:
            time: shape (n,).
            angles, rates: of every link, shape (n, links), rad and rad per time unit.

        Returns:
            Positions and velocities, each of shape (n, corners, 2).
        """
        place = -1j * self.hub_radius * np.exp(1j * (self.hub_start + self.hub_speed * time))
        corners = [(place, 1j * self.hub_speed * place)]
        for number, link in enumerate(self.links):
            joint, joint_velocity = corners[-1]
            turn, rate = np.exp(1j * angles[:, number]), rates[:, number]
            arms = [complex(*corner) * turn for corner in (*link.knees, link.tip)]
            corners += [(joint + arm, joint_velocity + 1j * rate * arm) for arm in arms]
        places, velocities = (np.stack(each, axis=1) for each in zip(*corners, strict=True))
        return np.stack([places.real, places.imag], axis=-1), np.stack([velocities.real, velocities.imag], axis=-1)

    def kinetic_energy(self, state: State) -> float:
        """Return the sum of m v^2/2 + I rate^2/2 over the links."""
        poses = self.poses(state)
        return sum(
            0.5 * link.mass * (pose.centre_velocity[0] ** 2 + pose.centre_velocity[1] ** 2)
            + 0.5 * link.inertia * rate**2
            for link, pose, rate in zip(self.links, poses, state.rates, strict=True)
        )

    def speed_bound(self, state: State) -> float:
        """Return a speed that no point exceeds, nor two wires' points relative to each other, while no rate exceeds the state's."""
        reach = sum(length * abs(rate) for length, rate in zip(self._lengths, state.rates, strict=True))
        return min(self.wires, 2) * self.hub_radius * abs(self.hub_speed) + reach

    def row(self, poses: Sequence[Pose], link: int, arm: Vector, direction: Vector) -> Array:
        """Return d(velocity along a direction)/d(rates) of a link's point at ``arm`` from its joint, shape (links,)."""
        row = np.zeros(len(self.links))
        for each in range(link - link % self.wire_links, link):
            joint, tip = poses[each].joint, poses[each].tip
            row[each] = cross((tip[0] - joint[0], tip[1] - joint[1]), direction)
        row[link] = cross(arm, direction)
        return row

    def mass_matrix(self, poses: Sequence[Pose]) -> Array:
        """Return the mass matrix in the links' absolute angles, shape (links, links)."""
        matrix = np.diag([link.inertia for link in self.links])
        for number, (link, pose) in enumerate(zip(self.links, poses, strict=True)):
            arm = (pose.centre[0] - pose.joint[0], pose.centre[1] - pose.joint[1])
            for direction in ((1.0, 0.0), (0.0, 1.0)):
                row = self.row(poses, number, arm, direction)
                matrix += link.mass * np.outer(row, row)
        return matrix


def cross(arm: Vector, direction: Vector) -> float:
    """Return the lever of a direction at an arm."""
    return arm[0] * direction[1] - arm[1] * direction[0]


def _carried(
    origin: Vector, velocity: Vector, arm: Vector, cosine: float, sine: float, rate: float
) -> tuple[Vector, Vector]:
    """Return the position and velocity of a point fixed on a link that is turned about ``origin``, by cosine and sine."""
    along, across = arm
    x, y = cosine * along - sine * across, sine * along + cosine * across
    return (origin[0] + x, origin[1] + y), (velocity[0] - rate * y, velocity[1] + rate * x)
