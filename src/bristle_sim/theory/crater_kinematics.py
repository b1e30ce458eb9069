"""Motion and energy of the bristle while its tip cuts, and the width of the cut (Zhang 2020,
section 4.1, compression only).

The dissertation postulates that the tip's excursion along its path grows as S = c_1 (1 - e^(-lambda
t)) (4.1). The constant c_1 is taken from a micrograph, and lambda c_1 from the tip's speed.
Everything else follows from the bristle's geometry. The printed constants carry the rounding of
hand calculation. These constants are the defaults of CraterKinematics; ``of_tool`` computes them
without rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Number
from bristle_sim.parameters import Bristle, Tool

COMPRESSION_TIME = 5e-5  # t_c, s, read off frames of a high-speed camera (Zhang 2020, eq. 3.20)
IMPACT_ANGLE = math.radians(
    23.4
)  # angle of the tip's path to the surface, rad (Zhang 2020, eq. 4.51)


@dataclass(frozen=True, slots=True)
class CraterKinematics:
    """Motion of the bristle during compression (Zhang 2020, eqs. 4.4-4.10).

    All quantities decay exponentially, with q = exp(-decay t) and the time t since first touch (s).
    The defaults are the values printed in the dissertation.

    Attributes:
        decay: decay rate lambda, 1/s.
        excursion: final length of the tip's path, m. At time t the length is excursion (1 - q).
        tip_speed: initial speed of the tip, m/s. At time t the speed is tip_speed q.
        rate: coefficient of the bristle's angular velocity, which is rate q - final_rate, rad/s.
        final_rate: negative of the angular velocity that the bristle has with its tip at rest,
            rad/s.
        centre_speed: coefficient of the speed of the bristle's centre of mass, which is
            centre_speed q + final_centre_speed, m/s.
        final_centre_speed: speed of the centre of mass with the tip at rest, m/s.
        depth: final depth of the tip below the surface, m. At time t the depth is depth (1 - q).
        face_depth: length of the part of the tip's face that is below the surface at the final
            depth, m.
    """

    decay: float = 92400.0
    excursion: float = 3.25e-4
    tip_speed: float = 30.0
    rate: float = 1111.0
    final_rate: float = 266.65
    centre_speed: float = 15.0
    final_centre_speed: float = 3.615
    depth: float = 1.3e-4
    face_depth: float = 2.8e-4

    @classmethod
    def of_tool(cls, tool: Tool, bristle_rate: float) -> CraterKinematics:
        """Return the motion of a radial bristle from its angular velocity at the strike (rad/s).

        The constants are computed without the rounding of the printed constants. The tip arrives
        with the speed v = r_h omega + L bristle_rate (2.24), with the hub's radius r_h and speed
        omega and the wire's length L. The decay rate is v divided by the length of the path (4.3).
        When the tip has come to rest, the bristle has the angular velocity -r_h omega/L (2.36), and
        its centre of mass has half the speed of the hub's rim.
        """
        rim = tool.hub.speed * tool.hub.radius
        length = tool.bristle.length
        excursion = 3.25e-4
        speed = rim + length * bristle_rate
        depth = excursion * math.sin(IMPACT_ANGLE)
        rates = (speed / length, rim / length)
        centre = (0.5 * speed, 0.5 * rim)
        face_depth = depth / math.sin(TipFace().face_angle)
        return cls(speed / excursion, excursion, speed, *rates, *centre, depth, face_depth)

    def tip_displacement(self, time: ArrayLike) -> Number:
        """Return the distance that the tip has moved along its path, m (Zhang 2020, eq. 4.4a)."""
        return self.excursion * self._grown(time)

    def tip_velocity(self, time: ArrayLike) -> Number:
        """Return the speed of the tip along its path, m/s (Zhang 2020, eq. 4.4b)."""
        return self.tip_speed * self._left(time)

    def bristle_rate(self, time: ArrayLike) -> Number:
        """Return the absolute angular velocity of the bristle, rad/s (Zhang 2020, eq. 4.6)."""
        return self.rate * self._left(time) - self.final_rate

    def centre_velocity(self, time: ArrayLike) -> Number:
        """Return the speed of the bristle's centre of mass, m/s (Zhang 2020, eq. 4.7)."""
        return self.centre_speed * self._left(time) + self.final_centre_speed

    def crater_depth(self, time: ArrayLike) -> Number:
        """Return the depth of the tip below the surface, m (Zhang 2020, eq. 4.8)."""
        return self.depth * self._grown(time)

    def _left(self, time: ArrayLike) -> Number:
        return np.exp(-self.decay * np.asarray(time))

    def _grown(self, time: ArrayLike) -> Number:
        return -np.expm1(-self.decay * np.asarray(time))


@dataclass(frozen=True, slots=True)
class TipFace:
    """The cutting face of the tip: the ellipse in which a plane cuts the wire.

    The defaults are printed values (Zhang 2020, eqs. 4.9-4.13).

    Attributes:
        short_axis: short axis of the ellipse, which is the wire's diameter, m.
        tilt: angle between the face's normal and the wire's axis, rad; measured as 39.5 deg (fig.
            4.5).
        face_angle: angle of the face to the surface, rad. Eq. 4.10 takes 28 deg. From the rake
            angle, the impact angle plus 11.5 deg (4.36), the face angle would be 55.1 deg.
    """

    short_axis: float = 7.1e-4
    tilt: float = math.radians(39.5)
    face_angle: float = math.radians(28.0)

    @property
    def long_axis(self) -> float:
        """Long axis of the ellipse, short_axis/cos(tilt), m (Zhang 2020, eq. 4.12)."""
        return self.short_axis / math.cos(self.tilt)

    @property
    def full_depth(self) -> float:
        """Depth below the surface from which the cut is as wide as the wire, m.

        Half of the ellipse is then below the surface. The depth is (long_axis/2) sin(face_angle).
        """
        return 0.5 * self.long_axis * math.sin(self.face_angle)

    def width(self, depth: ArrayLike) -> Number:
        """Return the width of the cut (m) at a depth of the tip (m) below the surface (4.9, 4.14).

        At ``full_depth`` and below, the width is the wire's diameter.
        """
        fraction = np.clip(np.asarray(depth, dtype=float) / self.full_depth, 0.0, 1.0)
        return self.short_axis * np.sqrt(fraction * (2.0 - fraction))


@dataclass(frozen=True, slots=True)
class CuttingWidth:
    """Width of the cut as a function of the time since first touch (Zhang 2020, eq. 4.16).

    The width is b(t) = 2 sqrt(h^2 - (h - s + s e^(-decay t))^2), m, with t in s. The defaults are
    the values printed in the dissertation.

    Attributes:
        half_width: radius h of the wire, m.
        swing: length s, m. The end face of the wire is an ellipse, of which a part is below the
            surface at the final depth. s is the length of this part, multiplied by the ratio of the
            ellipse's short axis to its long one. The dissertation prints h - s = 1.39e-4 m.
        decay: decay rate of the motion, 1/s.
    """

    half_width: float = 3.55e-4
    swing: float = 2.16e-4
    decay: float = 92400.0

    @classmethod
    def of_face(cls, face: TipFace, kinematics: CraterKinematics) -> CuttingWidth:
        """Return the width of the cut for a tip's face and a motion (eqs. 4.13-4.15).

        The constants are computed without the rounding of the printed constants.
        """
        swing = kinematics.face_depth * face.short_axis / face.long_axis
        return cls(0.5 * face.short_axis, swing, kinematics.decay)

    def __call__(self, time: ArrayLike) -> Number:
        """Return the width of the cut (m) at times in s, of any shape.

        The formula of ``CuttingWidth`` is factored as a difference of squares, which avoids
        cancellation near t = 0.
        """
        gone = -self.swing * np.expm1(-self.decay * np.asarray(time, dtype=float))
        gone = np.minimum(gone, self.half_width)  # from there on the cut is as wide as the wire
        return 2.0 * np.sqrt(gone * (2.0 * self.half_width - gone))


PRINTED_KINEMATICS = CraterKinematics()  # with the printed constants (Zhang 2020, eqs. 4.4-4.10)
PRINTED_FACE = TipFace()  # with the printed constants (Zhang 2020, eqs. 4.9-4.13)
PRINTED_WIDTH = CuttingWidth()  # with the printed constants (Zhang 2020, eq. 4.16)
# Coefficients of e^(-2 lambda t), of e^(-lambda t) and of 1 in the kinetic energy, J (Zhang 2020,
# eq. 4.59).
PRINTED_ENERGY = (0.0126, 0.00303, 7.25e-4)


def energy_coefficients(
    kinematics: CraterKinematics = PRINTED_KINEMATICS,
) -> tuple[float, float, float]:
    """Return the coefficients a, b and c of the bristle's kinetic energy during compression, J.

    With the decay rate lambda the energy is E(t) = a e^(-2 lambda t) + b e^(-lambda t) + c. The
    coefficients follow from E = m v^2/2 + (m L^2/12) phi'^2/2 (4.58-4.59), with the speed v of the
    bristle's centre of mass, the angular velocity phi', the mass m and the length L.
    """
    wire = Bristle()
    k = kinematics
    half_mass = 0.5 * wire.mass
    half_inertia = 0.5 * wire.inertia_about_centre
    return (
        half_mass * k.centre_speed**2 + half_inertia * k.rate**2,
        2.0
        * (
            half_mass * k.centre_speed * k.final_centre_speed - half_inertia * k.rate * k.final_rate
        ),
        half_mass * k.final_centre_speed**2 + half_inertia * k.final_rate**2,
    )


def kinetic_energy(
    time: ArrayLike, coefficients: tuple[float, float, float] = PRINTED_ENERGY
) -> Number:
    """Return the kinetic energy of the bristle (J) at times >= 0 in s (Zhang 2020, eq. 4.59).

    The energy is a e^(-2 lambda t) + b e^(-lambda t) + c. ``coefficients`` are a, b and c, by
    default those printed in the dissertation. The decay rate lambda is the printed 92400 1/s.
    """
    left = np.exp(-PRINTED_KINEMATICS.decay * np.asarray(time))
    return coefficients[0] * left**2 + coefficients[1] * left + coefficients[2]


def path_force(time: ArrayLike) -> Number:
    """Return the force along the tip's path that the dissertation's motion would require, N.

    The hub keeps its speed, so the force at the tip only changes the bristle's angular velocity
    about its root. The bristle's effective mass at the tip is I/L^2 = m/3, with the inertia I about
    the root, the length L and the mass m. The tip's speed v_C falls like e^(-lambda t), so the
    force is (m/3) lambda v_C(t). The force is largest at first touch, where the dissertation's own
    force (3.19) is zero.
    """
    wire = Bristle()
    motion = PRINTED_KINEMATICS
    return wire.inertia_about_root / wire.length**2 * motion.decay * motion.tip_velocity(time)
