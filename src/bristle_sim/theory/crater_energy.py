"""Work-energy estimate of the crater depth as printed, and where it fails (Zhang 2020, section 4.3).

The estimate divides, ply by ply, the kinetic energy given up by the force, d_i = [E(t_{i-1}) - E(t_i)]/R(t_i) (4.62), and
adds the d_i up. It fails for three reasons:

* the postulated motion brakes hardest at t = 0, where the force of (3.19) begins near zero, so the first quotients are
  huge: as written the sum is 9.65 mm at 300 plies, and with F(0) = 0, as (3.3) has it, it grows without end, by
  cos(gamma) |E'(0)|/F'(0) ln 10 = 6.9 mm for each tenfold n;
* read as a ratio of two sums, as (4.66) is set in print, the divisor grows with n and the depth tends to zero;
* force and motion belong to two different events: over the printed path the printed force does 4.05 mJ of work, while the
  kinetic energy falls by 15.6 mJ.

Of these 15.6 mJ only 12.6 mJ are work at the tip. The hub keeps its speed, so the root's bearing brakes the bristle
too: its work, m r_h w (L/6) times the change of the rate, is the 3.0 mJ of the term in e^(-lambda t).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.parameters import Bristle
from bristle_sim.quantity import Range
from bristle_sim.theory.checks import ranges, single, whole
from bristle_sim.theory.crater_kinematics import (
    COMPRESSION_TIME,
    IMPACT_ANGLE,
    PRINTED_KINEMATICS,
    CraterKinematics,
)
from bristle_sim.theory.force_history import BRISTLE, ForceCurve

__all__ = [
    "PRINTED_ENERGY",
    "energy_coefficients",
    "energy_crater_depth",
    "energy_crater_depth_ratio",
    "kinetic_energy",
    "path_force",
    "work_along_path",
]

Number = Any
"""A float where the argument is one, else an array of its shape."""

PRINTED_ENERGY = (0.0126, 0.00303, 7.25e-4)
"""Coefficients of e^(-2 lambda t), e^(-lambda t) and 1 in E_k, J (Zhang 2020, eq. 4.59)."""

MOST_PLIES = 10_000_000
"""Plies are summed in one array."""

NODES = 64
"""Gauss-Legendre nodes for smooth integrands over the compression; 20 would reach rounding."""


_arguments = ranges(
    Range("time", "s", 0.0, 1e3, True, "Zhang 2020, eq. 4.59"),
    Range("impact_angle", "rad", -1e6, 1e6, True, "Zhang 2020, eq. 4.65"),
    Range("decay", "1/s", 0.0, 1e15, True, "Zhang 2020, eq. 4.1: lambda"),
    Range("compression_time", "s", 1e-30, 1e-2, True, "Zhang 2020, eq. 3.20"),
)
"""What is allowed for the arguments of these names."""


def energy_coefficients(
    kinematics: CraterKinematics = PRINTED_KINEMATICS, bristle: Bristle | None = None
) -> tuple[float, float, float]:
    """Coefficients of e^(-2 lambda t), e^(-lambda t) and 1 in E_k = m v_G^2/2 + (m L^2/12) rate^2/2 (4.58-4.59), J."""
    wire = Bristle() if bristle is None else bristle
    half_mass, half_inertia = 0.5 * wire.mass, 0.5 * wire.inertia_about_centre
    k = kinematics
    return (
        half_mass * k.centre_speed**2 + half_inertia * k.rate**2,
        2.0 * (half_mass * k.centre_speed * k.final_centre_speed - half_inertia * k.rate * k.final_rate),
        half_mass * k.final_centre_speed**2 + half_inertia * k.final_rate**2,
    )


@_arguments
def kinetic_energy(
    time: ArrayLike,
    coefficients: tuple[float, float, float] = PRINTED_ENERGY,
    decay: float = PRINTED_KINEMATICS.decay,
) -> Number:
    """Kinetic energy of the bristle (4.59), J, at times in s; coefficients as printed by default."""
    left = np.exp(-decay * np.asarray(time, dtype=float))
    return coefficients[0] * left**2 + coefficients[1] * left + coefficients[2]


@_arguments
def energy_crater_depth(
    plies: int = 300,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    *,
    force: ForceCurve = BRISTLE,
    coefficients: tuple[float, float, float] = PRINTED_ENERGY,
    decay: float = PRINTED_KINEMATICS.decay,
    compression_time: float = COMPRESSION_TIME,
) -> Number:
    """Sum of the energy quotients as derived, cos(gamma) sum_i dE_i/R(t_i) (4.62-4.65), m; it grows with the plies."""
    lost, resisted = _plies(plies, force, coefficients, decay, compression_time)
    return np.cos(impact_angle) * np.sum(lost / resisted)


@_arguments
def energy_crater_depth_ratio(
    plies: int = 300,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    *,
    force: ForceCurve = BRISTLE,
    coefficients: tuple[float, float, float] = PRINTED_ENERGY,
    decay: float = PRINTED_KINEMATICS.decay,
    compression_time: float = COMPRESSION_TIME,
) -> Number:
    """The same as a ratio of two sums, cos(gamma) sum_i dE_i / sum_i R(t_i) (4.66 as set), m; it falls like 1/n."""
    lost, resisted = _plies(plies, force, coefficients, decay, compression_time)
    return np.cos(impact_angle) * np.sum(lost) / np.sum(resisted)


@_arguments
def work_along_path(
    force: ForceCurve = BRISTLE,
    kinematics: CraterKinematics = PRINTED_KINEMATICS,
    compression_time: float = COMPRESSION_TIME,
) -> float:
    """Integral of R v_C over the compression, J: an upper bound of what that force does along that motion."""
    single("compression_time", compression_time)
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    time = 0.5 * compression_time * (nodes + 1.0)
    return float(0.5 * compression_time * np.sum(weights * force(time) * kinematics.tip_velocity(time)))


@_arguments
def path_force(
    time: ArrayLike, kinematics: CraterKinematics = PRINTED_KINEMATICS, bristle: Bristle | None = None
) -> Number:
    """Force along the path that the postulated motion takes, (m/3) lambda v_C(t), N.

    The root moves with the hub at constant speed, so the force at the tip turns the bristle alone: its effective mass
    along the path is I/L^2 = m/3, and v_C falls like e^(-lambda t). Largest at first touch, where (3.19) has nothing.
    """
    wire = Bristle() if bristle is None else bristle
    return wire.inertia_about_root / wire.length**2 * kinematics.decay * kinematics.tip_velocity(time)


def _plies(
    plies: int,
    force: ForceCurve,
    coefficients: tuple[float, float, float],
    decay: float,
    compression_time: float,
) -> tuple[Any, Any]:
    """Energy given up in each ply, J, and the force at its end, N."""
    whole("plies", plies, MOST_PLIES)
    time = np.linspace(0.0, single("compression_time", compression_time), int(single("plies", plies)) + 1)
    return -np.diff(kinetic_energy(time, coefficients, decay)), force(time[1:])
