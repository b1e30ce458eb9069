"""Kinematics where the bristle touches something.

At a touch the normal n points out of the obstacle and the tangent is n turned clockwise by 90 degrees, t = -i n: for the
workpart n = +y and t = +x. Velocities at the contact point are linear in the relative rate,

    (v_n, v_t) = J alpha' + omega (drift), J = d(v_n, v_t)/d alpha',

and the contact-space inverse mass is K = J J^T / I, of rank one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bristle_sim.reference.mechanics import Mechanics, Number, Vector, dot

__all__ = ["Touch", "centripetal", "contact"]


@dataclass(frozen=True, slots=True)
class Touch:
    """Kinematics of the contact point, at one instant or at many.

    Attributes:
        normal_lever, tangential_lever: J, m/rad.
        normal_drift, tangential_drift: velocity of a contact point that turns with the hub (alpha' = 0), m/s.
        bend: second derivative of the gap in time at alpha'' = 0, so that gap'' = J_n alpha'' + bend, m/s^2.
    """

    normal_lever: Number
    tangential_lever: Number
    normal_drift: Number
    tangential_drift: Number
    bend: Number

    def velocity(self, rate: Number) -> tuple[Number, Number]:
        """(v_n, v_t) of the bristle's contact point, m/s."""
        return (
            self.normal_lever * rate + self.normal_drift,
            self.tangential_lever * rate + self.tangential_drift,
        )

    def inverse_mass(self, inertia: float) -> NDArray[np.float64]:
        """K of a single touch, shape (2, 2), 1/kg."""
        lever = np.array([self.normal_lever, self.tangential_lever])
        return np.outer(lever, lever) / inertia


def contact(mechanics: Mechanics, normal: Vector, arm: Vector, root: Vector, bend: Number) -> Touch:
    """Kinematics of the contact point at the arm from the root."""
    tangent, lever, drift = -1j * normal, 1j * arm, 1j * mechanics.speed * (root + arm)
    return Touch(dot(normal, lever), dot(tangent, lever), dot(normal, drift), dot(tangent, drift), bend)


def centripetal(mechanics: Mechanics, normal: Vector, root: Vector, arm: Vector, absolute: Number) -> Number:
    """Centripetal acceleration of a point of the wire along the normal, m/s^2."""
    return dot(normal, -(mechanics.speed**2) * root - absolute**2 * arm)
