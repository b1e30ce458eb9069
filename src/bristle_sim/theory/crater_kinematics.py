"""Motion of the bristle while its tip cuts, its energy, and the width of the cut (Zhang 2020,
section 4.1, compression only).

The dissertation postulates that the tip's excursion along its path grows as S = c_1 (1 - e^(-lambda
t)) (4.1) and takes c_1 from a micrograph, lambda c_1 from the tip's speed. Everything else follows
from the bristle's geometry. The printed constants carry the rounding of hand calculation. They are
the defaults of CraterKinematics; ``of_tool`` computes them without rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Number
from bristle_sim.parameters import Bristle, Tool

COMPRESSION_TIME = 5e-5  # t_c, read off high-speed camera frames, s (Zhang 2020, eq. 3.20)
IMPACT_ANGLE = math.radians(23.4)  # rad (Zhang 2020, eq. 4.51)


@dataclass(frozen=True, slots=True)
class CraterKinematics:
    """Motion during compression (Zhang 2020, eqs. 4.4-4.10); defaults as printed.

    With q = exp(-decay t), t in s, a motion is a constant times q or 1 - q.

    Attributes:
        decay: lambda, 1/s.
        excursion: c_1, m; the path is S = excursion (1 - q).
        tip_speed: initial speed along the path, m/s; v_C = tip_speed q.
        rate: rad/s; the absolute rate of the bristle is rate q - final_rate.
        final_rate: rad/s; see ``rate``.
        centre_speed: m/s; the speed of the bristle's centre is v_G = centre_speed q +
            final_centre_speed.
        final_centre_speed: m/s; see ``centre_speed``.
        depth: final depth below the surface, m; the depth is depth (1 - q).
        face_depth: trace of the final depth on the tip's face, m; it grows as the depth does.
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
        """Return the unrounded motion of a radial bristle that strikes at an absolute rate, rad/s.

        The tip arrives with v = r_h w + L rate (2.24), so lambda = v/c_1 (4.3). When the tip has
        come to rest, the bristle has the rate -r_h w/L (2.36) and its centre half the rim's speed.
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
        """Return S along the path (4.4a), m."""
        return self.excursion * self._grown(time)

    def tip_velocity(self, time: ArrayLike) -> Number:
        """Return v_C along the path (4.4b), m/s."""
        return self.tip_speed * self._left(time)

    def bristle_rate(self, time: ArrayLike) -> Number:
        """Return the absolute rate of the bristle (4.6), rad/s."""
        return self.rate * self._left(time) - self.final_rate

    def centre_velocity(self, time: ArrayLike) -> Number:
        """Return v_G (4.7), m/s."""
        return self.centre_speed * self._left(time) + self.final_centre_speed

    def crater_depth(self, time: ArrayLike) -> Number:
        """Return the depth below the surface, S sin(gamma) (4.8), m."""
        return self.depth * self._grown(time)

    def _left(self, time: ArrayLike) -> Number:
        return np.exp(-self.decay * np.asarray(time))

    def _grown(self, time: ArrayLike) -> Number:
        return -np.expm1(-self.decay * np.asarray(time))


@dataclass(frozen=True, slots=True)
class TipFace:
    """The cutting face: the ellipse in which a plane cuts the wire (Zhang 2020, eqs. 4.9-4.13).

    Its short axis a_2, m, is the wire's diameter d.

    The face's normal is tilted from the wire's axis by 39.5 deg (measured; fig. 4.5). (4.10) puts
    the face at 28 deg to the surface, the rake angle gamma + 11.5 deg (4.36) at 55.1 deg; both are
    kept as printed. Angles in rad.
    """

    short_axis: float = 7.1e-4
    tilt: float = math.radians(39.5)
    face_angle: float = math.radians(28.0)

    @property
    def long_axis(self) -> float:
        """Return a_1 = d/cos(tilt) (4.12), m."""
        return self.short_axis / math.cos(self.tilt)

    @property
    def full_depth(self) -> float:
        """Return the depth below the surface at which the cut is as wide as the wire, (a_1/2) sin(face_angle), m."""
        return 0.5 * self.long_axis * math.sin(self.face_angle)

    def width(self, depth: ArrayLike) -> Number:
        """Return the width of the cut at a depth below the surface, both in m (4.9, 4.14).

        From the centre line of the ellipse on, the width is the wire's diameter.
        """
        fraction = np.clip(np.asarray(depth, dtype=float) / self.full_depth, 0.0, 1.0)
        return self.short_axis * np.sqrt(fraction * (2.0 - fraction))


@dataclass(frozen=True, slots=True)
class CuttingWidth:
    """b(t) = 2 sqrt(h^2 - (h - s + s e^(-decay t))^2), m, t in s (Zhang 2020, eq. 4.16); defaults as printed.

    h = d/2 is the half-width, m. The swing s, m, is the trace of the final depth on the face times a_2/a_1; the other printed
    constant, 1.39e-4, is h - s. The decay is lambda, 1/s.
    """

    half_width: float = 3.55e-4
    swing: float = 2.16e-4
    decay: float = 92400.0

    @classmethod
    def of_face(cls, face: TipFace, kinematics: CraterKinematics) -> CuttingWidth:
        """Return the unrounded width of the cut by a face in a motion (4.13-4.15)."""
        swing = kinematics.face_depth * face.short_axis / face.long_axis
        return cls(0.5 * face.short_axis, swing, kinematics.decay)

    def __call__(self, time: ArrayLike) -> Number:
        """Return the width, m, at times (s) of any shape.

        The difference of squares is factored, so that it keeps its digits near t = 0.
        """
        gone = -self.swing * np.expm1(-self.decay * np.asarray(time, dtype=float))
        gone = np.minimum(gone, self.half_width)  # from there on a thin wire cuts as wide as it is
        return 2.0 * np.sqrt(gone * (2.0 * self.half_width - gone))


PRINTED_KINEMATICS = CraterKinematics()  # with the printed constants (Zhang 2020, eqs. 4.4-4.10)
PRINTED_FACE = TipFace()  # with the printed constants (Zhang 2020, eqs. 4.9-4.13)
PRINTED_WIDTH = CuttingWidth()  # with the printed constants (Zhang 2020, eq. 4.16)
PRINTED_ENERGY = (
    0.0126,
    0.00303,
    7.25e-4,
)  # of e^(-2 lambda t), e^(-lambda t) and 1 in E_k, J (Zhang 2020, eq. 4.59)


def energy_coefficients(
    kinematics: CraterKinematics = PRINTED_KINEMATICS,
) -> tuple[float, float, float]:
    """Return the coefficients of e^(-2 lambda t), e^(-lambda t) and 1 in E_k, J.

    E_k = m v_G^2/2 + (m L^2/12) rate^2/2 (4.58-4.59).
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
    time: ArrayLike,
    coefficients: tuple[float, float, float] = PRINTED_ENERGY,
    decay: float = PRINTED_KINEMATICS.decay,
) -> Number:
    """Return the kinetic energy of the bristle, J, at times >= 0 in s (4.59).

    The coefficients are the printed ones by default.
    """
    left = np.exp(-decay * np.asarray(time))
    return coefficients[0] * left**2 + coefficients[1] * left + coefficients[2]


def path_force(time: ArrayLike) -> Number:
    """Return the force along the path that the postulated motion requires, (m/3) lambda v_C(t), N.

    The root moves with the hub at constant speed, so the force at the tip turns the bristle alone:
    its effective mass along the path is I/L^2 = m/3, and v_C falls like e^(-lambda t). The force is
    largest at first touch, where the force of (3.19) is zero.
    """
    wire = Bristle()
    motion = PRINTED_KINEMATICS
    return wire.inertia_about_root / wire.length**2 * motion.decay * motion.tip_velocity(time)
