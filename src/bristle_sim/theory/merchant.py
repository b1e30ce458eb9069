"""Merchant's orthogonal cutting, classical and with the tool entering obliquely (Zhang 2020,
section 4.2).

The tool pushes the chip with a resultant R that makes the angle beta - alpha with the cutting
velocity (beta: friction angle, alpha: rake angle). The chip shears off along a plane at the shear
angle eta to the cutting velocity. In this plane the yield stress tau_s acts over the area b
d_u/sin(eta), with the width b and the uncut depth d_u. In the dissertation's modified circle d_u is
measured normal to a path that descends at the impact angle gamma. For every rake angle the
resultant R then makes the angle arccot(mu) with the workpart, where mu is the ratio of tangential
to normal force on the workpart: beta - alpha = arccot(mu) - gamma.

With ``surface="parallel"`` the length of the shear plane is d_u/sin(eta), as in (4.28). This is
right for a surface parallel to the path. The real surface rises from the path at gamma, so a shear
plane at eta meets it after the length d_u cos(gamma)/sin(eta - gamma). ``surface="inclined"`` uses
this length. For every gamma, least work then gives eta - gamma = pi/4 - arccot(mu)/2 and

    R = 2 tau_s b depth/(1 - sin(arccot mu)),    u = 2 tau_s cos(gamma) cos(arccot(mu) - gamma)/(1 - sin(arccot mu)),

with the specific cutting energy u. The shear plane then emerges from the surface for every mu > 0,
while (4.43) requires mu >= tan(gamma).

Stresses in Pa, angles in rad, mu > 0 and 0 <= gamma < pi/2; all arguments broadcast.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Number
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE

# Surface at which the shear plane ends: parallel to the path, or inclined to it.
Surface = Literal["parallel", "inclined"]
API_5L = 1.2e8  # shear yield stress of the steel API 5L, Pa (Zhang 2020, eq. 4.53)
# Rake angle minus impact angle, measured on the tip, rad (Zhang 2020, eq. 4.36).
RAKE_OFFSET = math.radians(11.5)


class ShearAngleError(ValueError):
    """Raised when the shear plane of the chip would not emerge from the surface.

    In the modified circle this happens where the shear angle is below the impact angle (4.35).
    """


@dataclass(frozen=True, slots=True)
class CuttingAngles:
    """The angles of Merchant's circle, as numbers or as arrays of one broadcast shape.

    Attributes:
        rake: rake angle alpha, rad.
        friction: friction angle beta, rad.
        shear: shear angle eta, rad.

    If rake and friction angle are equal, the shear angle of least work is 45 deg. The resultant is
    then tau_s b d_u/(sin 45 cos 45), twice the shear yield stress times the area of the chip:

    >>> angles = CuttingAngles(rake=0.0, friction=0.0, shear=math.pi / 4.0)
    >>> print(f"{angles.resultant_ratio:.6f} {angles.cutting_ratio:.6f}")
    0.500000 0.500000
    """

    rake: Number
    friction: Number
    shear: Number

    @property
    def resultant_angle(self) -> Number:
        """Angle beta - alpha between the resultant force and the cutting velocity, rad."""
        return self.friction - self.rake

    @property
    def resultant_ratio(self) -> Number:
        """Ratio of the force tau_s b d_u to the resultant force R (Zhang 2020, eq. 4.20).

        The ratio is sin(eta) cos(eta + beta - alpha). tau_s is the shear yield stress, b the width
        and d_u the uncut depth of the chip.
        """
        return np.sin(self.shear) * np.cos(self.shear + self.resultant_angle)

    @property
    def cutting_ratio(self) -> Number:
        """Ratio of the force tau_s b d_u to the cutting force F_c (Zhang 2020, eq. 4.46).

        The ratio is sin(eta) cos(eta + beta - alpha)/cos(beta - alpha). tau_s is the shear yield
        stress, b the width and d_u the uncut depth of the chip. F_c/(b d_u) is the specific cutting
        energy.
        """
        return self.resultant_ratio / np.cos(self.resultant_angle)


# Rounding error of a shear angle, by which it may lie below the impact angle, rad.
ANGLE_ROUNDING = 1e-12

PRINTED_ANGLES = CuttingAngles(math.radians(34.9), math.radians(74.9), math.radians(25.0))
"""The dissertation's rounded angles, at a friction of 0.5 and an impact angle of 23.4 deg (Zhang
2020, eqs. 4.36, 4.52)."""


def oblique_angles(
    friction: ArrayLike, impact_angle: ArrayLike, *, check: bool = True
) -> CuttingAngles:
    """Return the angles of Merchant's circle for a tip that enters the surface obliquely.

    The rake angle is alpha = gamma + ``RAKE_OFFSET`` and the friction angle beta = ``RAKE_OFFSET``
    + arccot(mu). The shear angle eta = pi/4 - (beta - alpha)/2 needs the least work (4.25).

    Args:
        friction: ratio mu > 0 of tangential to normal force on the workpart.
        impact_angle: angle gamma of the path to the surface, 0 <= gamma < pi/2, rad.
        check: whether to raise an error where the shear plane would not emerge from the surface.

    Raises:
        ShearAngleError: if ``check`` is set, where eta < gamma, that is mu < tan(gamma) (4.42).

    With mu = 1 the resultant is at 45 deg to the workpart. A path along the surface (gamma = 0) has
    eta = 45 - 45/2 = 22.5 deg:

    >>> angles = oblique_angles(1.0, 0.0)
    >>> print(f"{math.degrees(angles.resultant_angle):.3f} {math.degrees(angles.shear):.3f} {math.degrees(angles.rake):.3f}")
    45.000 22.500 11.500
    """
    gamma = np.asarray(impact_angle)
    upright = np.arctan2(1.0, friction)
    shear = 0.5 * np.subtract(0.5 * math.pi, upright - gamma)
    angles = CuttingAngles(gamma + RAKE_OFFSET, RAKE_OFFSET + upright, shear)
    # The margin accepts mu = tan(gamma) itself, whatever the rounding of arccot.
    buried = shear < gamma - ANGLE_ROUNDING
    if check and np.any(buried):
        worst, least = (
            float(np.broadcast_to(each, buried.shape)[buried][0])
            for each in (friction, np.tan(gamma))
        )
        raise ShearAngleError(
            f"friction = {worst:g}: must be friction >= tan(impact_angle) = {least:g}, or the shear plane does not come out"
            " of the surface (dimensionless)"
        )
    return angles


def specific_cutting_energy(
    friction: ArrayLike,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    surface: Surface = "parallel",
) -> Number:
    """Return the specific cutting energy, the cutting force divided by the chip's area, J/m^3.

    The specific cutting energy is u = F_c/(b d_u), with the cutting force F_c, the width b and the
    uncut depth d_u of the chip.

    Args:
        friction: ratio mu > 0 of tangential to normal force on the workpart.
        impact_angle: angle gamma of the path to the surface, rad.
        shear_yield_stress: shear yield stress tau_s of the workpart, Pa.
        surface: direction of the surface at which the shear plane ends, relative to the tip's path:
            ``parallel``, as the dissertation assumes, or ``inclined``, as the real surface is.

    At mu = 1, gamma = 0, tau_s = 1 Pa: u = cos(45)/(sin(22.5) cos(67.5)) = 0.707107/0.146447.

    >>> print(f"{specific_cutting_energy(1.0, 0.0, 1.0):.3f}")
    4.828
    """
    angles = oblique_angles(friction, impact_angle, check=False)
    if surface == "parallel":
        return shear_yield_stress / angles.cutting_ratio
    # [1 - sin(arccot mu)]/2 = [1 - cos(arctan mu)]/2, in the form without cancellation.
    ratio = np.sin(0.5 * np.arctan(friction)) ** 2
    return shear_yield_stress * np.cos(impact_angle) * np.cos(angles.resultant_angle) / ratio
