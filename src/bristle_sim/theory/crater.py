"""Crater depth by Merchant's modified circle, summed over plies of equal time (Zhang 2020, eqs. 4.48-4.57).

Each ply adds the depth that the growth of the cutting force shears off at the width the tip has then,

    depth = cos(gamma) sum_i [F_c(t_i) - F_c(t_{i-1})] sin(eta) cos(eta + beta - alpha)/(b(t_i) tau_s cos(beta - alpha)).

As n grows this is the integral of F_c'(t)/b(t). The width starts like sqrt(t), so the integrand has an inverse square
root at t = 0 and the sum, a rule of right end points, falls short of the limit by -zeta(1/2) = 1.4604 times the
coefficient of 1/sqrt(t) times sqrt(t_c/n) (Navot 1961): order one half, not one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bristle_sim.quantity import Range
from bristle_sim.theory.checks import finite, positive, ranges, require, single, whole
from bristle_sim.theory.crater_kinematics import COMPRESSION_TIME, IMPACT_ANGLE, PRINTED_WIDTH
from bristle_sim.theory.force_history import BRISTLE, ForceCurve
from bristle_sim.theory.merchant import API_5L, CuttingAngles, oblique_angles

__all__ = [
    "CUTTING_FRICTION",
    "PLIES",
    "constant_for_crater_depth",
    "friction_for_crater_depth",
    "merchant_crater_depth",
    "merchant_crater_depth_limit",
]

Number = Any
"""A float where the arguments are, else an array of their broadcast shape."""

Width = Callable[[ArrayLike], Any]
"""Cutting width in m over time in s."""

CUTTING_FRICTION = 0.5
"""Friction coefficient while cutting (Zhang 2020, eq. 4.51); chapter 2 takes 0.31 for the impact."""

PLIES = 300
"""Number of plies of the dissertation's depths (Zhang 2020, below eq. 4.56)."""

NODES = 64
"""Gauss-Legendre nodes; the integrand is smooth once the root is substituted away, 20 would reach rounding."""

LEAST = 1e-60
"""Of a yield stress, Pa: less makes depths that are no number."""

MOST_PLIES = 10_000_000
"""Plies are summed in one array."""


_arguments = ranges(
    Range("depth", "m", -1e6, 1e6, True, "Zhang 2020, fig. 4.16"),
    Range("friction", "1", -1e300, 1e300, True, "Zhang 2020, eq. 4.51"),
    Range("impact_angle", "rad", -1e6, 1e6, True, "Zhang 2020, eq. 4.51"),
    Range("shear_yield_stress", "Pa", -1e30, 1e30, True, "Zhang 2020, eq. 4.53"),
    Range("compression_time", "s", 1e-30, 1e-2, True, "Zhang 2020, eq. 3.20"),
)
"""What is allowed for the arguments of these names; functions narrow it where they must."""


@_arguments
def merchant_crater_depth(
    friction: ArrayLike = CUTTING_FRICTION,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    plies: ArrayLike = PLIES,
    *,
    angles: CuttingAngles | None = None,
    force: ForceCurve = BRISTLE,
    width: Width = PRINTED_WIDTH,
    compression_time: float = COMPRESSION_TIME,
) -> Number:
    """Crater depth as a sum over n plies of equal time (4.50), m.

    Args:
        friction: mu while cutting.
        impact_angle: gamma, rad.
        shear_yield_stress: tau_s, Pa.
        plies: n, whole numbers.
        angles: of the cut; by default exact ones for mu and gamma, PRINTED_ANGLES for the rounded ones of (4.52).
        force: resultant R(t), N.
        width: b(t), m.
        compression_time: t_c, s.

    Raises:
        ShearAngleError: where mu < tan(gamma), by default angles.
        ValueError: for any other argument out of its range.
    """
    ratio = _depth_ratio(friction, impact_angle, shear_yield_stress, angles)
    counts = np.asarray(plies)
    whole("plies", counts, MOST_PLIES)
    sums = np.reshape([_ply_sum(int(n), force, width, compression_time) for n in counts.flat], counts.shape)
    return ratio * sums


@_arguments
def merchant_crater_depth_limit(
    friction: ArrayLike = CUTTING_FRICTION,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    *,
    angles: CuttingAngles | None = None,
    force: ForceCurve = BRISTLE,
    width: Width = PRINTED_WIDTH,
    compression_time: float = COMPRESSION_TIME,
) -> Number:
    """What merchant_crater_depth tends to as the plies grow in number, m; arguments as there.

    t = t_c u^2 turns the integrand R'(t)/b(t), which is like 1/sqrt(t), into a smooth one.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    u = 0.5 * (nodes + 1.0)
    end = single("compression_time", compression_time)
    time = end * u**2
    growth = float(np.sum(weights * end * u * force.rate(time) / width(time)))
    return _depth_ratio(friction, impact_angle, shear_yield_stress, angles) * growth


@_arguments
def friction_for_crater_depth(
    depth: ArrayLike,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    plies: int = PLIES,
    *,
    force: ForceCurve = BRISTLE,
    width: Width = PRINTED_WIDTH,
    compression_time: float = COMPRESSION_TIME,
) -> Number:
    """Friction that makes the crater ``depth`` deep (Zhang 2020, fig. 4.16): merchant_crater_depth solved for mu.

    With the shear angle of least work, sin(eta) cos(eta + beta - alpha) = [1 - sin(arccot(mu) - gamma)]/2.

    Raises:
        ValueError: for a depth that no mu >= tan(gamma) gives.
    """
    gamma, stress = np.asarray(impact_angle, dtype=float), np.asarray(shear_yield_stress, dtype=float)
    whole("plies", plies, MOST_PLIES)
    single("plies", plies)
    _check_stress(stress)
    deepest = np.cos(gamma) / stress * _ply_sum(plies, force, width, compression_time)
    sine = 1.0 - 2.0 * np.asarray(depth, dtype=float) / deepest
    # mu runs from tan(gamma), where arccot(mu) - gamma = pi/2 - 2 gamma, to infinity, where it is -gamma.
    given = (sine <= np.cos(2.0 * gamma) + 1e-12) & (sine > -np.sin(gamma))
    require("depth", depth, given, "a depth that some friction >= tan(impact_angle) gives is allowed (in m)")
    # arcsin(1 - 2 x) = pi/2 - 2 arcsin(sqrt(x)) keeps the digits of a small depth.
    return np.tan(2.0 * np.arcsin(np.sqrt(np.maximum(depth / deepest, 0.0))) - gamma)


@_arguments
def constant_for_crater_depth(
    depth: ArrayLike,
    friction: ArrayLike = CUTTING_FRICTION,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    plies: int = PLIES,
    *,
    force: ForceCurve = BRISTLE,
    width: Width = PRINTED_WIDTH,
    compression_time: float = COMPRESSION_TIME,
) -> Number:
    """The constant C of (4.45), rad, that makes the crater ``depth`` deep, m: merchant_crater_depth solved for C.

    With x = beta - alpha = arccot(mu) - gamma and eta = (C - x)/2, the angles enter the depth by sin(eta) cos(eta + x) =
    [sin(C) - sin(x)]/2, so that sin(C) = sin(x) + 2 depth tau_s/(cos(gamma) sum of dR/b). The deepest crater is that of
    least work, C = pi/2. The shear plane comes out of the surface, eta >= gamma (4.35), where C >= arccot(mu) + gamma:
    craters less deep than sin(gamma) cos(arccot mu) cos(gamma) (sum of dR/b)/tau_s have a C, but no chip.

    Raises:
        ValueError: for a depth that no C within 0 < C <= pi/2 gives.
    """
    gamma, stress = np.asarray(impact_angle, dtype=float), np.asarray(shear_yield_stress, dtype=float)
    whole("plies", plies, MOST_PLIES)
    single("plies", plies)
    _check_stress(stress)
    positive("depth", depth, "m")
    require("friction", friction, np.greater(friction, 0.0), "must be above 0 (dimensionless)")
    require("impact_angle", gamma, (gamma >= 0.0) & (gamma < 0.5 * np.pi), "must be at least 0, below pi/2 (in rad)")
    scale = np.cos(gamma) / stress * _ply_sum(plies, force, width, compression_time)
    sine = np.sin(np.arctan2(1.0, friction) - gamma) + 2.0 * np.asarray(depth, dtype=float) / scale
    # Rounding must not refuse the depth of least work itself.
    given = (sine > 0.0) & (sine <= 1.0 + 1e-12)
    require("depth", depth, given, "must be the depth for some C, 0 < C <= pi/2, the deepest being that of pi/2 (in m)")
    return np.arcsin(np.minimum(sine, 1.0))


def _depth_ratio(
    friction: ArrayLike, impact_angle: ArrayLike, shear_yield_stress: ArrayLike, angles: CuttingAngles | None
) -> Number:
    """Crater depth per sum of dR/b, 1/Pa; cos(beta - alpha) of F_c cancels against the one below (4.50)."""
    stress = np.asarray(shear_yield_stress, dtype=float)
    _check_stress(stress)
    finite("impact_angle", impact_angle, "rad")
    chosen = oblique_angles(friction, impact_angle) if angles is None else angles
    return chosen.resultant_ratio * np.cos(impact_angle) / stress


def _check_stress(stress: Number) -> None:
    positive("shear_yield_stress", stress, "Pa")
    require("shear_yield_stress", stress, stress > LEAST, f"more than {LEAST:g} is allowed (in Pa)")


def _ply_sum(plies: int, force: ForceCurve, width: Width, compression_time: float) -> float:
    """Sum of [R(t_i) - R(t_{i-1})]/b(t_i), N/m."""
    time: NDArray[np.float64] = np.linspace(0.0, single("compression_time", compression_time), int(plies) + 1)
    return float(np.sum(np.diff(force(time)) / width(time[1:])))
