"""Equation of motion of one bristle on a hub that keeps its speed.

Points and vectors of the plane are complex numbers x + iy: multiplying by i turns counterclockwise by 90 degrees, so a
point with the arm r from a centre that turns at the rate w moves with i w r. Points of the wire are seen from the root
with the shank along -i, and turn with e^{i phi}. Every function broadcasts over arrays.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.parameters import Tool

__all__ = ["Mechanics", "Motion", "State", "dot"]

Number = Any
"""A float or an array of floats."""

Vector = Any
"""A complex number or an array of them."""

Motion = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Times of shape (n,) -> relative angle and relative rate, shape (2, n)."""


class State(NamedTuple):
    """Relative angle alpha and relative rate at an instant; s, rad, rad/s."""

    time: float
    angle: float
    rate: float


def dot(first: Vector, second: Vector) -> Number:
    """Scalar product of two plane vectors."""
    return (np.conj(first) * second).real


@dataclass(frozen=True, slots=True)
class Mechanics:
    """A tool's bristle and hub as plain numbers, SI units.

    Attributes:
        corners: of the centre line after the root, the tip last.
        centre_distance, centre_lead: of the centre of mass, its distance rho from the root, and the angle delta by which
            it is ahead of the shank, 0 for a straight wire.
        start_hub_angle: psi_0, rad.
    """

    speed: float
    hub_radius: float
    length: float
    corners: tuple[complex, ...]
    centre_distance: float
    centre_lead: float
    mass: float
    inertia: float
    stiffness: float
    damping: float
    gravity: float
    start_hub_angle: float

    @classmethod
    def of(cls, tool: Tool, start_hub_angle: float) -> Mechanics:
        """The mechanics of a tool."""
        if tool.bristle.links != 1:
            raise ValueError(
                f"wire_links = {tool.bristle.links}: must be 1, as only a rigid bristle can be simulated (dimensionless)"
            )
        centre = complex(*tool.bristle.centre)
        return cls(
            speed=tool.hub.speed,
            hub_radius=tool.hub.radius,
            length=tool.bristle.length,
            corners=tuple(complex(*corner) for corner in tool.bristle.path),
            centre_distance=abs(centre),
            centre_lead=float(np.angle(1j * centre)),
            mass=tool.bristle.mass,
            inertia=tool.bristle.inertia_about_root,
            stiffness=tool.belt.stiffness,
            damping=tool.belt_damping,
            gravity=tool.gravity,
            start_hub_angle=start_hub_angle,
        )

    def hub_angle(self, time: Number) -> Number:
        """Hub angle, psi = psi_0 + omega t, rad."""
        return self.start_hub_angle + self.speed * time

    def torque(self, time: Number, angle: Number, rate: Number) -> Number:
        """Torque on alpha without contact, N m.

        With the centre of mass at the distance rho from the root, delta ahead of the shank, from
        T = m r_h^2 omega^2/2 + m r_h rho omega phi' cos(alpha + delta) + I phi'^2/2, where phi = psi + alpha and I is the
        inertia about the root, and V = k alpha^2/2 + m g y_centre, Lagrange's equation is

            I alpha'' = -k alpha - c alpha' - m r_h rho omega^2 sin(alpha + delta) - m g rho sin(psi + alpha + delta).
        """
        moment, lean = self.mass * self.centre_distance, angle + self.centre_lead
        centrifugal = moment * self.hub_radius * self.speed**2 * np.sin(lean)
        weight = moment * self.gravity * np.sin(self.hub_angle(time) + lean) if self.gravity else 0.0
        return -self.stiffness * angle - self.damping * rate - centrifugal - weight

    def right_hand_side(self, time: float, state: NDArray[np.float64]) -> tuple[float, float]:
        """(alpha', alpha'') in flight."""
        return state[1], self.torque(time, state[0], state[1]) / self.inertia

    def root(self, hub_angle: Number) -> Vector:
        """Position of the bristle's root, m."""
        return self.hub_radius * self.direction(hub_angle)

    @staticmethod
    def direction(angle: Number) -> Vector:
        """Unit vector (sin, -cos) of an angle from -y."""
        return -1j * np.exp(1j * angle)

    @property
    def tip(self) -> complex:
        """The centre line's end, seen from the root as ``corners``, m."""
        return self.corners[-1]

    def tip_position(self, hub_angle: Number, angle: Number) -> Vector:
        """Position of the centre line's end, m."""
        return self.root(hub_angle) + self.tip * np.exp(1j * (hub_angle + angle))

    def centre_line(self, hub_angle: Number, angle: Number, rate: Number) -> tuple[Vector, Vector]:
        """Corners of the centre line from the root to its end, m, and their velocities, m/s; corners on a last axis.

        The root moves with i omega times its position, a corner with the arm r from it with i phi' r more, where phi' is
        the wire's absolute rate omega + alpha'.
        """
        root = np.asarray(self.root(hub_angle))[..., np.newaxis]
        arms = np.exp(1j * np.asarray(hub_angle + angle))[..., np.newaxis] * np.array([0.0, *self.corners])
        swing = 1j * (self.speed + np.asarray(rate))[..., np.newaxis] * arms
        return root + arms, 1j * self.speed * root + swing

    def kinetic_energy(self, angle: Number, rate: Number) -> Number:
        """Kinetic energy of the whole wire, J."""
        absolute = self.speed + rate
        root_speed = self.hub_radius * self.speed
        coupling = self.mass * root_speed * self.centre_distance * absolute * np.cos(angle + self.centre_lead)
        return 0.5 * self.mass * root_speed**2 + coupling + 0.5 * self.inertia * absolute**2

    def potential_energy(self, hub_angle: Number, angle: Number) -> Number:
        """Energy of belt and gravity, k alpha^2/2 + m g y_centre, J."""
        lean = hub_angle + angle + self.centre_lead
        height = -self.hub_radius * np.cos(hub_angle) - self.centre_distance * np.cos(lean)
        return 0.5 * self.stiffness * angle**2 + self.mass * self.gravity * height

    @property
    def natural_rate(self) -> float:
        """Rate of small undamped oscillations, belt, hub and gravity together, rad/s.

        About the radial position for a straight wire, no more than this for one with a knee.
        """
        moment = self.mass * self.centre_distance * (self.hub_radius * self.speed**2 + self.gravity)
        return math.sqrt((self.stiffness + moment) / self.inertia)

    @property
    def fastest_rate(self) -> float:
        """Upper bound of the rates at which the motion changes: oscillation, damping and hub, rad/s."""
        return self.natural_rate + self.damping / self.inertia + self.speed
