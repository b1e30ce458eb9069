"""Equations of motion of wires of rigid links on a hub of constant speed.

Points of the plane are complex numbers x + iy. The unknowns are the links' absolute angles theta. A
vector that is fixed on a link is given for the unstressed wire at angle 0, whose shank points along
-i. At the angle theta this vector is multiplied by e^{i theta}. The root is at z_0(t). Two vectors
start at the joint of link k that is nearer to the root: u_k ends at the next joint, g_k at the
centre of mass of link k. The centre of mass of link i is at

    c_i = z_0(t) + sum_k a_ik e^{i theta_k},    a_ik = u_k for k < i, g_i for k = i, 0 otherwise,

and Lagrange's equations in the theta are, with W_jk = sum_i m_i conj(a_ij) a_ik and B_j = sum_i m_i
a_ij,

    sum_k [Re(conj(E_j) W_jk E_k) + J_j delta_jk] theta_k'' =
        sum_k Im(conj(E_j) W_jk E_k) theta_k'^2 - Re(conj(i B_j E_j) (z_0'' + i g)) + springs,    E_k = e^{i theta_k}.

m_i is the mass of link i, J_j the inertia of link j about its centre and g gravity. The links have
equal lengths along the wire; the link with the wire's knee is bent. Belt and hinges are torsion
springs and dampers. All springs are unstressed if every link has the hub's angle. Wire k of a row
has its own root at the hub angle psi_k + omega t. Only contacts couple the links of two wires.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Bristle, Tool
from bristle_sim.theory.wire import hinge_damping, hinge_stiffness

Complexes = NDArray[np.complex128]

# Distance along the wire, as a fraction of its length, within which a knee and the end of a link
# coincide.
CUT_ROUNDING = 1e-12


class Pieces(NamedTuple):
    """The straight pieces of the wires' centre lines.

    A straight link is one piece; a knee divides its link into two. Vectors are complex numbers x +
    iy, in the axes of the unstressed wire at angle 0.

    Attributes:
        links: index of the link to which each piece belongs.
        starts: vector from the link's first joint to the start of each piece, m.
        directions: unit vector along each piece.
        lengths: length of each piece, m.
    """

    links: NDArray[np.int_]
    starts: Complexes
    directions: Complexes
    lengths: Array

    @property
    def ends(self) -> Complexes:
        """Vector from the link's first joint to the end of each piece, m."""
        return np.asarray(self.starts + self.lengths * self.directions)


class Kinematics(NamedTuple):
    """Positions and motion of the links' first joints, shape (..., links).

    A link's first joint is the one nearer to the hub. Vectors are complex numbers x + iy.

    Attributes:
        turn: unit vector e^{i theta} of each link, with its absolute angle theta.
        rates: absolute angular velocity of each link, rad/s.
        joint: position of each link's first joint, m.
        velocity: velocity of each first joint, m/s.
        acceleration: acceleration of each first joint if the links' angular accelerations are zero,
            m/s^2.
    """

    turn: Complexes
    rates: Array
    joint: Complexes
    velocity: Complexes
    acceleration: Complexes


class Chain:
    """The equations of motion of one or several wires of rigid links on a hub, in SI units.

    The last axis of an array runs over the links of all wires, or over their straight pieces.
    Vectors are complex numbers x + iy.

    Attributes:
        wires, links: number of wires, and number of links of all wires.
        start_hub_angles: for each link, the hub angle at which its wire starts, rad.
        pieces: straight pieces of the centre lines.
        middles: vector from the link's first joint to the middle of each piece, m.
        ends: vector from the first joint to the end of each link, m.
        products: matrix W of the module's docstring (kg m^2), shape (links, links).
        moments: complex conjugate of B of the module's docstring (kg m), shape (links,).
        masses: mass of each piece, kg.
        inertias: moment of inertia of each piece about its middle, kg m^2.
        before: matrix with a 1 in row k and column i if link k lies between the root and link i of
            the same wire, 0 otherwise.
        first: array with a 1 for each link that begins at a root, 0 otherwise.
        apart: matrix that multiplies the links' angles to give each angle minus that of the
            preceding link.
        tips: whether each piece ends at a wire's tip.
        corners: whether each piece ends at a tip or a knee, which can touch a flat surface.
        stiffness: stiffness of the torsion spring in each link's first joint, N m/rad.
        damping: constant of the damper in each link's first joint, N m s/rad.
    """

    def __init__(self, tool: Tool, *start_hub_angles: float) -> None:
        """Divide each wire into the tool's number of links.

        ``start_hub_angles`` are the hub angles at which the wires start, one for each wire, rad.
        """
        bristle = tool.bristle
        links = bristle.links
        count = len(start_hub_angles)
        self.speed = tool.hub.speed
        self.hub_radius = tool.hub.radius
        self.gravity = tool.gravity
        self.length = bristle.length
        self.wires = count
        self.links = links * count
        self.start_hub_angles = np.repeat(start_hub_angles, links)
        self.start_roots = -1j * self.hub_radius * np.exp(1j * self.start_hub_angles)
        lone = _cut(bristle)
        own = np.add.outer(links * np.arange(count), lone.links).ravel()
        starts, directions, lengths = np.tile(lone[1:], count)
        self.pieces = Pieces(own, starts, directions, lengths.real)
        self.middles = self.pieces.starts + 0.5 * self.pieces.lengths * self.pieces.directions
        self.ends = np.zeros(self.links, dtype=complex)
        self.ends[own] = self.pieces.ends  # the last piece of each link
        self.masses = bristle.mass * self.pieces.lengths / bristle.length
        self.inertias = self.masses * self.pieces.lengths**2 / 12.0
        wires = np.repeat(np.arange(count), links)
        same = np.equal.outer(wires, wires)
        self.before = np.triu(same, 1).astype(complex)
        arms = (self.before.T * self.ends)[own]  # the vectors a_ij of the module's docstring
        arms[np.arange(len(own)), own] = self.middles
        self.products = np.conj(arms).T @ (self.masses[:, None] * arms)
        self.moments = np.conj(self.masses @ arms)
        self.inertia_matrix = np.diag(np.bincount(own, self.inertias))
        self.first = np.diff(wires, prepend=-1)
        self.apart = np.eye(self.links) - same * np.eye(self.links, k=1)
        self.tips = np.tile(np.arange(len(lone.links)) == len(lone.links) - 1, count)
        bends = self.pieces.directions[1:] != self.pieces.directions[:-1]
        self.corners = self.tips | np.append(bends, True)
        hinge = 0.0
        damper = 0.0
        if links > 1:
            hinge = hinge_stiffness(bristle.wire_diameter, bristle.length, bristle.modulus, links)
            damper = hinge_damping(
                bristle.mass,
                bristle.length,
                bristle.wire_diameter,
                bristle.modulus,
                tool.belt.stiffness,
                bristle.bending_damping_ratio,
                links,
            )
        self.stiffness = np.tile([tool.belt.stiffness] + [hinge] * (links - 1), count)
        self.damping = np.tile([tool.belt_damping] + [damper] * (links - 1), count)

    def hub_angles(self, time: Any) -> Array:
        """Return the hub angle (rad) of each link's wire, shape (..., links); ``time`` is in s."""
        return np.asarray(np.add.outer(self.speed * time, self.start_hub_angles))

    def _roots(self, time: Any) -> Complexes:
        """Return the position of the root of each link's wire (m), shape (..., links)."""
        return np.asarray(np.multiply.outer(np.exp(1j * self.speed * time), self.start_roots))

    def mass_matrix(self, turn: Complexes) -> Array:
        """Return the mass matrix of the links (kg m^2), shape (..., links, links).

        ``turn`` are the unit vectors e^{i theta} of the links, shape (..., links).
        """
        coupled = np.conj(turn)[..., :, None] * self.products * turn[..., None, :]
        return np.asarray(coupled.real + self.inertia_matrix)

    def forces(self, time: Any, angles: Array, motion: Kinematics) -> Array:
        """Return the generalized forces on the links without those of contacts, N m.

        They consist of the centrifugal terms, gravity, and the torques of belt and hinges.
        """
        root = -(self.speed**2) * self._roots(time)
        carried = self.moments * (root + 1j * self.gravity)
        carried -= (motion.rates**2 * motion.turn) @ self.products.T
        inertia = (np.conj(1j * motion.turn) * carried).real
        torques = self.stiffness * self._twists(angles, self.hub_angles(time))
        torques += self.damping * self._twists(motion.rates, self.speed)
        return np.asarray(-inertia - torques @ self.apart.T)

    def _twists(self, values: Array, hub: Any) -> Array:
        """Return the value of each link minus the value of the preceding link.

        ``values`` are angles or angular velocities. ``hub`` is the hub's angle or angular velocity,
        which is subtracted for the first link of a wire.
        """
        return np.asarray(values @ self.apart - hub * self.first)

    def kinematics(self, time: Any, angles: Array, rates: Array) -> Kinematics:
        """Return the positions and the motion of the links' first joints."""
        turn = np.exp(1j * angles)
        root = self._roots(time)
        arms = self.ends * turn
        return Kinematics(
            turn,
            rates,
            root + arms @ self.before,
            1j * self.speed * root + (1j * rates * arms) @ self.before,
            -(self.speed**2) * root - (rates**2 * arms) @ self.before,
        )

    def jacobian(self, motion: Kinematics, link: int, arm: Any) -> Complexes:
        """Return the Jacobian of a point's velocity in the angular velocities of the links, m.

        The point is fixed on the link of the index ``link``. ``arm`` is the vector from the first
        joint of this link to the present position of the point, m.
        """
        row = 1j * self.ends * motion.turn * self.before[:, link]
        row[..., link] = 1j * arm
        return np.asarray(row)

    def points(self, motion: Kinematics, links: Any, arms: Any) -> tuple[Any, Any]:
        """Return the positions (m) and velocities (m/s) of points that are fixed on links.

        ``links`` are the indices of the links. ``arms`` are the vectors from their first joints to
        the points (m), in the axes of the unstressed wire at angle 0.
        """
        turned = arms * motion.turn[..., links]
        return (
            motion.joint[..., links] + turned,
            motion.velocity[..., links] + 1j * motion.rates[..., links] * turned,
        )

    def centre_line(self, time: Any, angles: Array, rates: Array) -> tuple[Complexes, Complexes]:
        """Return the corners of a single wire's centre line (m) and their velocities (m/s).

        The corners are the root and the end of every straight piece. Both results have the shape
        (..., pieces + 1).
        """
        arms = np.array([0j, *self.pieces.ends])
        return self.points(self.kinematics(time, angles, rates), [0, *self.pieces.links], arms)

    def energies(self, time: Any, angles: Array, rates: Array) -> tuple[Any, Any]:
        """Return the kinetic and the potential energy of all links, J.

        Belt, hinges and gravity contribute to the potential energy.
        """
        links = self.pieces.links
        places, velocities = self.points(self.kinematics(time, angles, rates), links, self.middles)
        moving = self.masses * np.abs(velocities) ** 2 + self.inertias * rates[..., links] ** 2
        springs = 0.5 * self.stiffness * self._twists(angles, self.hub_angles(time)) ** 2
        weights = self.gravity * (self.masses * places.imag).sum(axis=-1)
        return 0.5 * moving.sum(axis=-1), springs.sum(axis=-1) + weights

    @property
    def fastest_rate(self) -> float:
        """Upper bound of the angular frequencies of the motion without contacts, rad/s.

        It is the sum of the highest natural angular frequency of the straight chain in the
        centrifugal field, the highest decay rate of its damping, and the hub's speed.
        """
        springs = (self.apart * self.stiffness) @ self.apart.T
        dampers = (self.apart * self.damping) @ self.apart.T
        weight = self.masses.sum() / self.wires * self.length
        field = weight * (self.hub_radius * self.speed**2 + self.gravity) * np.eye(self.links)
        inverse = np.linalg.inv(self.mass_matrix(np.ones(self.links, dtype=complex)))
        square, decay = (
            float(np.abs(np.linalg.eigvals(inverse @ each)).max())
            for each in (springs + field, dampers)
        )
        return math.sqrt(square) + decay + self.speed


def _cut(bristle: Bristle) -> Pieces:
    """Divide a wire's centre line into equally long links, and each link into straight pieces."""
    corners = np.array([0j, *(complex(*corner) for corner in bristle.path)])
    sides = np.diff(corners)
    # Distances from the root along the wire, m.
    stations = np.append(0.0, np.abs(sides).cumsum())
    borders = np.linspace(0.0, bristle.length, bristle.links + 1)
    cuts = np.union1d(stations, borders)
    cuts = cuts[np.append(True, np.diff(cuts) > CUT_ROUNDING * bristle.length)]
    lengths = np.diff(cuts)
    middles = cuts[:-1] + 0.5 * lengths
    links = np.searchsorted(borders, middles) - 1
    starts = np.interp(cuts[:-1], stations, corners) - np.interp(borders[links], stations, corners)
    directions = (sides / np.abs(sides))[np.searchsorted(stations, middles) - 1]
    return Pieces(links, starts, directions, lengths)
