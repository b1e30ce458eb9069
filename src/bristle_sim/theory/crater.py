"""Crater depth as sums over plies of equal time, by Merchant's circle and by energy (Zhang 2020,
eqs. 4.48-4.66).

Merchant's sum adds the depths of the plies. The growth of the cutting force in a ply shears off its
depth, at the width of the cut at that time:

    depth = cos(gamma) sum_i [F_c(t_i) - F_c(t_{i-1})] sin(eta) cos(eta + beta - alpha)/(b(t_i) tau_s cos(beta - alpha)).

As n grows this tends to the integral of F_c'(t)/b(t). The width starts like sqrt(t), so that the
sum, a rule of right end points, falls short of the limit like 1/sqrt(n) (Navot 1961): order one
half, not one.

The work-energy estimate adds, over the plies, the lost kinetic energy divided by the force, d_i =
[E(t_{i-1}) - E(t_i)]/R(t_i) (4.62). It fails: the postulated motion brakes hardest at t = 0, where
the force of (3.19) begins near zero, so that as written the sum is 9.65 mm at 300 plies and grows
with n; read as a ratio of two sums, as (4.66) is set in print, it tends to zero; and over the
printed path the force does 4.05 mJ of work, while the kinetic energy falls by 15.6 mJ (of which 3.0
mJ, the term in e^(-lambda t), are work of the root's bearing): force and motion belong to two
different events.

Arguments: the friction mu while cutting, gamma in rad, tau_s in Pa, the number of plies, t_c in s,
and the wire's diameter in m, which bounds the printed width b(t). The printed force is that of the
printed wire.
"""

from __future__ import annotations

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
"""Friction while cutting (Zhang 2020, eq. 4.51); chapter 2 takes 0.31 for the impact."""

PLIES = 300  # plies of the dissertation's depths (Zhang 2020, below eq. 4.56)
DEPTH_ROUNDING = 1e-12  # relative rounding error with which the extreme depths are still accepted

NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
"""Gauss-Legendre rule on (-1, 1) for integrands that are smooth over the compression.

20 nodes would already leave rounding alone."""


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
    """Return the crater depth, m, as a sum over n plies of equal time (4.50).

    Force R(t) and width b(t) are the printed ones.

    By default the angles of the cut are exact for mu and gamma; PRINTED_ANGLES are the rounded ones
    of (4.52). Raises ShearAngleError where mu < tan(gamma), unless ``angles`` are given.

    The dissertation's 300 plies, with its rounded angles (below 4.56):

    >>> from bristle_sim.theory.merchant import PRINTED_ANGLES
    >>> print(f"{1e6 * merchant_crater_depth(angles=PRINTED_ANGLES):.0f} um")
    140 um
    """
    counts = np.asarray(plies)
    sums = [_ply_sum(int(n), compression_time, wire_diameter) for n in counts.flat]
    return _depth_ratio(friction, impact_angle, shear_yield_stress, angles) * np.reshape(
        sums, counts.shape
    )


def merchant_crater_depth_limit(
    friction: ArrayLike = CUTTING_FRICTION,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    *,
    angles: CuttingAngles | None = None,
    compression_time: float = COMPRESSION_TIME,
    wire_diameter: float = PRINTED_FACE.short_axis,
) -> Number:
    """Return the limit of ``merchant_crater_depth`` for infinitely many plies, m.

    The arguments are those of ``merchant_crater_depth``.

    With the printed angles it is 142.28 um, which the sums approach as 1/sqrt(n): 142.13 um with
    100,000 plies:

    >>> from bristle_sim.theory.merchant import PRINTED_ANGLES
    >>> print(f"{1e6 * merchant_crater_depth_limit(angles=PRINTED_ANGLES):.2f} um")
    142.28 um
    """
    u = 0.5 * (
        NODES + 1.0
    )  # t = t_c u^2 turns R'(t)/b(t), which is like 1/sqrt(t), into a smooth integrand
    time = compression_time * u**2
    width = CuttingWidth(0.5 * wire_diameter)
    growth = float(np.sum(WEIGHTS * compression_time * u * BRISTLE.rate(time) / width(time)))
    return _depth_ratio(friction, impact_angle, shear_yield_stress, angles) * growth


def friction_for_crater_depth(
    depth: ArrayLike,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    plies: int = PLIES,
) -> Number:
    """Return the friction at which the crater has a depth, m: (4.50) solved for mu (Zhang 2020,
    fig. 4.16).

    With the shear angle of least work, sin(eta) cos(eta + beta - alpha) = [1 - sin(arccot(mu) -
    gamma)]/2. Raises ValueError for a depth that no mu >= tan(gamma) gives.

    It is the inverse of ``merchant_crater_depth``:

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
    # mu runs from tan(gamma), where arccot(mu) - gamma = pi/2 - 2 gamma, to infinity, where it is -gamma.
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
    """Return the constant C of (4.45), rad, at which the crater has a depth, m: (4.50) solved for
    C.

    With x = beta - alpha = arccot(mu) - gamma and eta = (C - x)/2, the angles enter the depth by
    sin(eta) cos(eta + x) = [sin(C) - sin(x)]/2, so that sin(C) = sin(x) + 2 depth tau_s/(cos(gamma)
    sum of dR/b). The shear plane comes out of the surface, eta >= gamma (4.35), where C >=
    arccot(mu) + gamma. Raises ValueError for a depth that no C within 0 < C <= pi/2 gives.

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
    """Return the ratio of the crater depth to the sum of dR/b, 1/Pa.

    The factor cos(beta - alpha) in F_c cancels against that in the denominator of (4.50).
    """
    chosen = oblique_angles(friction, impact_angle) if angles is None else angles
    return chosen.resultant_ratio * np.cos(impact_angle) / shear_yield_stress


def _ply_sum(plies: int, compression_time: float, wire_diameter: float) -> float:
    """Return the sum of [R(t_i) - R(t_{i-1})]/b(t_i), N/m."""
    time = np.linspace(0.0, compression_time, plies + 1)
    return float(np.sum(np.diff(BRISTLE(time)) / CuttingWidth(0.5 * wire_diameter)(time[1:])))


def energy_crater_depth(
    plies: int = PLIES,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    *,
    compression_time: float = COMPRESSION_TIME,
) -> Number:
    """Return the crater depth as the derived sum of quotients, cos(gamma) sum_i dE_i/R(t_i), m
    (4.62-4.65).

    It grows with the number of plies.

    >>> print(f"{1e3 * energy_crater_depth(300):.2f} mm")  # 75.8 um are printed
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
    """Return the crater depth as the ratio of two sums, cos(gamma) sum_i dE_i / sum_i R(t_i), m
    (4.66 as printed).

    It falls like 1/n.

    With 5 plies it is the printed depth:

    >>> print(f"{1e6 * energy_crater_depth_ratio(5):.2f} um")
    75.78 um
    """
    lost, resisted = _energy_plies(plies, compression_time)
    return np.cos(impact_angle) * np.sum(lost) / np.sum(resisted)


def _energy_plies(plies: int, compression_time: float) -> tuple[Array, Array]:
    """Return the kinetic energy lost in each ply, J, and the force at the end of each ply, N."""
    time = np.linspace(0.0, compression_time, int(plies) + 1)
    return -np.diff(kinetic_energy(time)), np.asarray(BRISTLE(time[1:]))


def work_along_path() -> float:
    """Return the integral of R v_C over the compression, J.

    It is an upper bound of the force's work along the printed motion.
    """
    time = 0.5 * COMPRESSION_TIME * (NODES + 1.0)
    return float(
        0.5
        * COMPRESSION_TIME
        * np.sum(WEIGHTS * BRISTLE(time) * PRINTED_KINEMATICS.tip_velocity(time))
    )
