"""Crater depth as sums over plies of equal time, by Merchant's circle and by energy (Zhang 2020,
eqs. 4.48-4.66).

The compression is divided into plies, intervals of equal time. Merchant's sum adds the depths of
the plies. In a ply the increase of the cutting force F_c removes a layer over the width b of the
cut:

    depth = cos(gamma) sum_i [F_c(t_i) - F_c(t_{i-1})] sin(eta) cos(eta + beta - alpha)/(b(t_i) tau_s cos(beta - alpha)).

Here alpha is the rake angle, beta the friction angle and eta the shear angle of Merchant's circle
(section 4.2). As the number n of plies grows, the sum of [F_c(t_i) - F_c(t_{i-1})]/b(t_i) tends to
the integral of F_c'(t)/b(t). The width grows like sqrt(t) at first. The sum takes each width at the
end of its ply. The sum is therefore below the integral by a term of order 1/sqrt(n) (Navot 1961),
not 1/n.

The work-energy estimate divides the kinetic energy lost in each ply by the resultant force R at the
end of the ply: d_i = [E(t_{i-1}) - E(t_i)]/R(t_i) (4.62). The depth is cos(gamma) times the sum of
the quotients d_i. This estimate fails. The postulated motion decelerates most at t = 0, where the
force R of (3.19) is almost zero. The depth is therefore 9.65 mm at 300 plies and grows with n. Eq.
4.66 prints the sum of the lost energies divided by the sum of the forces instead; this ratio tends
to zero as n grows. Over the printed path the kinetic energy falls by 15.6 mJ. The force R does at
most 4.05 mJ of work, and the root's bearing takes 3.0 mJ. (These 3.0 mJ are the term of (4.59) in
e^(-lambda t), with the decay rate lambda of the motion.) Some 8.5 mJ remain unexplained, so the
printed force and the printed motion are not those of one impact.

Arguments: the coefficient of friction mu while cutting, the impact angle gamma in rad, the shear
yield stress tau_s in Pa, the number of plies, the compression time t_c in s, and the wire's
diameter in m, which bounds the width b(t). "Printed" values are those of the dissertation.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array, Number
from bristle_sim.theory.crater_kinematics import (
    COMPRESSION_TIME,
    IMPACT_ANGLE,
    PRINTED_FACE,
    PRINTED_KINEMATICS,
    CuttingWidth,
    kinetic_energy,
)
from bristle_sim.theory.force_history import BRISTLE
from bristle_sim.theory.merchant import API_5L, CuttingAngles, oblique_angles
from bristle_sim.theory.numbers import require

CUTTING_FRICTION = 0.5
"""Coefficient of friction while cutting (Zhang 2020, eq. 4.51); chapter 2 takes 0.31 in impacts."""

PLIES = 300  # number of time intervals of the dissertation's sums (Zhang 2020, below eq. 4.56)
DEPTH_ROUNDING = (
    1e-12  # relative amount by which rounding may raise a depth above its largest value
)

NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
"""Gauss-Legendre rule on (-1, 1) for integrands that are smooth over the compression.

With 20 nodes its error would already be no more than rounding error."""


def merchant_crater_depth(
    friction: ArrayLike = CUTTING_FRICTION,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    plies: ArrayLike = PLIES,
    *,
    angles: CuttingAngles | None = None,
    compression_time: float = COMPRESSION_TIME,
    wire_diameter: float = PRINTED_FACE.short_axis,
) -> Number:
    """Return the crater depth by Merchant's circle, summed over equal time steps, m.

    The dissertation calls the time steps plies. The sum is eq. 4.50 of Zhang (2020), with the force
    R(t) and the width b(t) of the dissertation.

    Args:
        friction: coefficient of friction while cutting.
        impact_angle: angle at which the tip's path descends into the surface, rad.
        shear_yield_stress: shear yield stress of the workpart, Pa.
        plies: number of time steps. ``math.inf`` gives the limit; the error of a sum of n steps
            decreases like 1/sqrt(n).
        angles: rake, friction and shear angle of the cut; by default they follow from ``friction``
            and ``impact_angle``. ``PRINTED_ANGLES`` are the rounded angles of eq. 4.52.
        compression_time: duration of the compression, s.
        wire_diameter: diameter of the wire, the largest width of the cut, m.

    Raises:
        ShearAngleError: where the friction is below tan(impact_angle), unless ``angles`` are given.

    The dissertation's 300 plies, with its rounded angles (below 4.56):

    >>> from bristle_sim.theory.merchant import PRINTED_ANGLES
    >>> print(f"{1e6 * merchant_crater_depth(angles=PRINTED_ANGLES):.0f} um")
    140 um

    100,000 plies give 142.13 um; the limit is:

    >>> print(f"{1e6 * merchant_crater_depth(plies=math.inf, angles=PRINTED_ANGLES):.2f} um")
    142.28 um
    """
    counts = np.asarray(plies)
    sums = [_ply_sum(float(n), compression_time, wire_diameter) for n in counts.flat]
    return _depth_ratio(friction, impact_angle, shear_yield_stress, angles) * np.reshape(
        sums, counts.shape
    )


def friction_for_crater_depth(
    depth: ArrayLike,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    plies: int = PLIES,
) -> Number:
    """Return the coefficient of friction at which the crater has a given depth (m).

    The function is the inverse of ``merchant_crater_depth``: it solves eq. 4.50 for the friction mu
    (Zhang 2020, fig. 4.16). With the shear angle eta of least work, the friction angle beta and the
    rake angle alpha, the depth's factor sin(eta) cos(eta + beta - alpha) is
    [1 - sin(beta - alpha)]/2. Here beta - alpha = arccot(mu) - gamma, with the impact angle gamma,
    so the factor depends on mu and gamma only. The other arguments are those of
    ``merchant_crater_depth``.

    Raises:
        ValueError: for a depth that no friction mu >= tan(gamma) gives.

    >>> print(f"{friction_for_crater_depth(merchant_crater_depth(0.5)):.6f}")
    0.500000
    """
    gamma = np.asarray(impact_angle)
    scale = (
        np.cos(gamma)
        / shear_yield_stress
        * _ply_sum(plies, COMPRESSION_TIME, PRINTED_FACE.short_axis)
    )
    sine = 1.0 - 2.0 * np.asarray(depth) / scale
    # mu runs from tan(gamma), where arccot(mu) - gamma = pi/2 - 2 gamma, to infinity, where it is
    # -gamma.
    given = (sine <= np.cos(2.0 * gamma) + DEPTH_ROUNDING) & (sine > -np.sin(gamma))
    require(
        "depth", depth, given, "must be the depth for some friction >= tan(impact_angle) (in m)"
    )
    # arcsin(1 - 2 x) = pi/2 - 2 arcsin(sqrt(x)) keeps the digits of a small depth.
    return np.tan(2.0 * np.arcsin(np.sqrt(depth / scale)) - gamma)


def constant_for_crater_depth(
    depth: ArrayLike,
    friction: ArrayLike = CUTTING_FRICTION,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    plies: int = PLIES,
    *,
    compression_time: float = COMPRESSION_TIME,
    wire_diameter: float = PRINTED_FACE.short_axis,
) -> Number:
    """Return the constant C of the shear angle (rad) at which the crater has a given depth (m).

    The shear angle eta follows from C = 2 eta + x (4.45). Here x = beta - alpha = arccot(mu) -
    gamma is the angle between the resultant force and the cutting velocity. The angles enter the
    depth by sin(eta) cos(eta + x) = [sin(C) - sin(x)]/2. So eq. 4.50 gives

        sin(C) = sin(x) + 2 depth tau_s/(cos(gamma) sum dR/b),

    where dR is the increase of the force in a time step, b the width of the cut and tau_s the shear
    yield stress. The shear plane emerges from the surface (eta >= gamma, 4.35) only if C >=
    arccot(mu) + gamma. The other arguments are those of ``merchant_crater_depth``.

    Raises:
        ValueError: for a depth that no C within 0 < C <= pi/2 gives.

    The shear angle of least work has C = 90 deg:

    >>> print(f"{np.degrees(constant_for_crater_depth(merchant_crater_depth())):.4f}")
    90.0000
    """
    gamma = np.asarray(impact_angle)
    scale = np.cos(gamma) / shear_yield_stress * _ply_sum(plies, compression_time, wire_diameter)
    sine = np.sin(np.arctan2(1.0, friction) - gamma) + 2.0 * np.asarray(depth) / scale
    given = (sine > 0.0) & (sine <= 1.0 + DEPTH_ROUNDING)
    require(
        "depth",
        depth,
        given,
        "must be the depth for some C, 0 < C <= pi/2, the scale being that of pi/2 (in m)",
    )
    return np.arcsin(np.minimum(sine, 1.0))


def _depth_ratio(
    friction: ArrayLike,
    impact_angle: ArrayLike,
    shear_yield_stress: ArrayLike,
    angles: CuttingAngles | None,
) -> Number:
    """Return the crater depth divided by the sum of dR/b, 1/Pa.

    dR is the increase of the resultant force in a time step, b the width of the cut. With the
    friction angle beta and the rake angle alpha, the cutting force is R cos(beta - alpha), and this
    cosine cancels the one in the denominator of (4.50). The arguments are those of
    ``merchant_crater_depth``.
    """
    chosen = oblique_angles(friction, impact_angle) if angles is None else angles
    return chosen.resultant_ratio * np.cos(impact_angle) / shear_yield_stress


def _ply_sum(plies: float, compression_time: float, wire_diameter: float) -> float:
    """Return the sum of [R(t_i) - R(t_{i-1})]/b(t_i) over equal time steps, N/m.

    R is the resultant force, b the width of the cut. For infinitely many steps the result is the
    integral of R'(t)/b(t). The arguments are those of ``merchant_crater_depth``.
    """
    width = CuttingWidth(0.5 * wire_diameter)
    if math.isinf(plies):
        # t = t_c u^2 turns R'(t)/b(t), which is like 1/sqrt(t), into a smooth integrand.
        u = 0.5 * (NODES + 1.0)
        time = compression_time * u**2
        return float(np.sum(WEIGHTS * compression_time * u * BRISTLE.rate(time) / width(time)))
    time = np.linspace(0.0, compression_time, int(plies) + 1)
    return float(np.sum(np.diff(BRISTLE(time)) / width(time[1:])))


def energy_crater_depth(
    plies: int = PLIES,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    *,
    compression_time: float = COMPRESSION_TIME,
) -> Number:
    """Return the crater depth (m) as a sum of quotients of energy and force.

    The depth is cos(gamma) sum_i (dE_i/R_i) (Zhang 2020, eqs. 4.62-4.65). The compression time (s)
    is divided into ``plies`` equal steps. dE_i is the kinetic energy lost in step i, R_i the force
    at the end of step i, and gamma the impact angle (rad). The sum does not converge: it grows with
    ``plies``. The depth in print is 75.8 um.

    >>> print(f"{1e3 * energy_crater_depth(300):.2f} mm")
    9.65 mm
    """
    lost, resisted = _energy_plies(plies, compression_time)
    return np.cos(impact_angle) * np.sum(lost / resisted)


def energy_crater_depth_ratio(
    plies: int = PLIES,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    *,
    compression_time: float = COMPRESSION_TIME,
) -> Number:
    """Return the crater depth as the ratio of a sum of energies to a sum of forces, m.

    The depth is cos(gamma) (sum_i dE_i)/(sum_i R_i), as eq. 4.66 of Zhang (2020) is printed. dE_i
    is the kinetic energy lost in time step i, R_i the force at the end of step i, and gamma the
    impact angle. The depth falls like 1/``plies``: the sum of energies converges, while the sum of
    forces grows in proportion to ``plies``.

    With 5 plies the result is the printed depth:

    >>> print(f"{1e6 * energy_crater_depth_ratio(5):.2f} um")
    75.78 um
    """
    lost, resisted = _energy_plies(plies, compression_time)
    return np.cos(impact_angle) * np.sum(lost) / np.sum(resisted)


def _energy_plies(plies: int, compression_time: float) -> tuple[Array, Array]:
    """Return the kinetic energy lost in each of equal time steps (J), and the force at the end of
    each step (N).
    """
    time = np.linspace(0.0, compression_time, int(plies) + 1)
    return -np.diff(kinetic_energy(time)), np.asarray(BRISTLE(time[1:]))


def work_along_path() -> float:
    """Return an upper bound of the work of the contact force in the dissertation's motion, J.

    The bound is the integral of R v_C over the compression. R is the resultant force, which is not
    parallel to the tip's path, and v_C is the speed of the tip.
    """
    time = 0.5 * COMPRESSION_TIME * (NODES + 1.0)
    return float(
        0.5
        * COMPRESSION_TIME
        * np.sum(WEIGHTS * BRISTLE(time) * PRINTED_KINEMATICS.tip_velocity(time))
    )
