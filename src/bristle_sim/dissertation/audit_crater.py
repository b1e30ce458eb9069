"""Audit of the crater's kinematics and depth (Zhang 2020, chapter 4)."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.dissertation.audit_row import Found
from bristle_sim.dissertation.audit_tool import PRINTED_RATE
from bristle_sim.parameters import operating_point
from bristle_sim.theory.crater import (
    energy_crater_depth,
    energy_crater_depth_ratio,
    friction_for_crater_depth,
    merchant_crater_depth,
    merchant_crater_depth_limit,
    work_along_path,
)
from bristle_sim.theory.crater_cutting import cutting_stroke, depth_from_energy
from bristle_sim.theory.crater_kinematics import (
    COMPRESSION_TIME,
    IMPACT_ANGLE,
    PRINTED_KINEMATICS,
    PRINTED_WIDTH,
    CraterKinematics,
    CuttingWidth,
    TipFace,
    energy_coefficients,
    kinetic_energy,
    path_force,
)
from bristle_sim.theory.force_history import BRISTLE
from bristle_sim.theory.merchant import PRINTED_ANGLES, oblique_angles, specific_cutting_energy

MICRO = 1e6
MEASURED = 130e-6
"""Measured depth of the crater, m (Zhang 2020, fig. 4.13)."""

EXACT = CraterKinematics.of_tool(operating_point(), PRINTED_RATE)
"""The motion unrounded."""


def crater_figures() -> dict[str, Found]:
    """Figures of chapter 4."""
    return {**_motion(), **_tip(), **_angles(), **_plies(), **_trends(), **_energy(), **_consistency()}


def half_axis_share(length: float) -> float:
    """Length along the face times a_2/a_1 with the printed half axes 3.55 and 4.6e-4 m (4.15), m."""
    return length * 3.55e-4 / 4.6e-4


def percent_apart(theory: float, experiment: float) -> float:
    """Difference of two printed numbers in per cent of the second."""
    return 100.0 * abs(theory / experiment - 1.0)


def convergence_order(plies: int) -> float:
    """Order at which the ply sum approaches its limit between n and 10 n plies."""
    gaps = merchant_crater_depth_limit() - merchant_crater_depth(plies=[plies, 10 * plies])
    return float(np.log10(gaps[0] / gaps[1]))


def _motion() -> dict[str, Found]:
    k = PRINTED_KINEMATICS
    reached = MICRO * float(k.tip_displacement(COMPRESSION_TIME))
    centre = EXACT.centre_velocity(0.0)
    return {
        "eq. 4.4: decay lambda": Found(EXACT.decay, told=(30.0 / k.excursion,), allowance=49.5),
        "fig. 4.3: excursion at 50 us": Found(reached, told=(reached,)),
        "fig. 4.3: excursion against 325 um": Found(
            percent_apart(320.0, 325.0), told=(reached, 100.0 * (1.0 - reached / 325.0))
        ),
        "eq. 4.6: amplitude of the rate": Found(30.0 / 0.027, told=(EXACT.rate,)),
        "eq. 4.6: rate at rest": Found(EXACT.final_rate),
        "eq. 4.6: initial rate": Found(float(k.bristle_rate(0.0)), told=(float(EXACT.bristle_rate(0.0)),)),
        "eq. 4.7: amplitude of v_G": Found(0.5 * 0.027 * 1111.0),
        "eq. 4.7: v_G at rest": Found(EXACT.final_centre_speed, told=(centre,)),
        "eq. 4.8: depth": Found(k.excursion * math.sin(IMPACT_ANGLE)),
    }


def _tip() -> dict[str, Found]:
    face = TipFace()
    on_face = PRINTED_KINEMATICS.depth / math.sin(face.face_angle)
    unrounded = MICRO * float(CuttingWidth.of_face(face, PRINTED_KINEMATICS)(COMPRESSION_TIME))
    printed = MICRO * float(PRINTED_WIDTH(COMPRESSION_TIME))
    rake = 90.0 - 23.4 - 11.5
    return {
        "eq. 4.10: angle of the face": Found(
            None, told=(rake, 1e4 * PRINTED_KINEMATICS.depth / math.sin(math.radians(rake)))
        ),
        "eq. 4.10: depth on the face": Found(on_face, told=(1e4 * EXACT.face_depth,)),
        "eq. 4.12: long axis of the tip": Found(face.long_axis),
        "eq. 4.13: half the short axis": Found(0.5 * face.short_axis),
        "eq. 4.13: half the long axis": Found(0.5 * face.long_axis),
        "eq. 4.14: distance from the centre at the end": Found(0.5 * face.long_axis - 2.8e-4),
        "eq. 4.15: first constant": Found(half_axis_share(1.8e-4)),
        "eq. 4.15: second constant": Found(half_axis_share(2.8e-4)),
        "fig. 4.6: width at 50 us": Found(unrounded, told=(printed,)),
        "fig. 4.6: width against 651 um": Found(percent_apart(652.0, 651.0)),
    }


def _angles() -> dict[str, Found]:
    angles, low = oblique_angles(0.5, IMPACT_ANGLE), oblique_angles(0.31, IMPACT_ANGLE, check=False)
    rake, friction, shear = (math.degrees(float(each)) for each in (angles.rake, angles.friction, angles.shear))
    buried = math.degrees(float(low.shear))
    cut = BRISTLE.amplitude[0] * math.cos(float(angles.resultant_angle))
    return {
        "fig. 4.13: rake angle": Found(rake),
        "eq. 4.52: friction angle": Found(friction),
        "eq. 4.52: shear angle": Found(shear),
        "eq. 4.55: amplitude of the cutting force": Found(cut),
        "eq. 4.56: angle of the resultant to the shear plane": Found(shear + friction - rake),
        "eq. 4.56: angle of the resultant to the path": Found(friction - rake),
        "eq. 4.56: 2/cos(gamma)": Found(2.0 / math.cos(IMPACT_ANGLE)),
        "sec. 4.2.2: chip and rebound contradict each other": Found(buried, buried < 23.4, (23.4 - buried,)),
    }


def _plies() -> dict[str, Found]:
    exact = MICRO * float(merchant_crater_depth())
    rounded = MICRO * float(merchant_crater_depth(angles=PRINTED_ANGLES))
    limits = [MICRO * float(merchant_crater_depth_limit(angles=each)) for each in (None, PRINTED_ANGLES)]
    order = convergence_order(10_000)
    gap = limits[1] - rounded
    away = rounded * 1e-6 / MEASURED - 1.0
    return {
        "fig. 4.13: crater depth with 300 plies": Found(rounded, told=(exact,)),
        "sec. 4.2.2: the depth is converged at n = 300": Found(
            limits[1], abs(limits[1] - 140.0) < 0.5, (order, gap, limits[0])
        ),
        "sec. 4.2.2: the depth is close to the measured 130 um": Found(away, abs(away) < 0.1),
    }


def _trends() -> dict[str, Found]:
    friction, angles = np.linspace(0.45, 4.0, 60), np.radians(np.linspace(0.0, 23.4, 27))
    over_friction = np.diff(merchant_crater_depth(friction, angles[:, np.newaxis]), axis=1)
    over_angle = np.diff(merchant_crater_depth(friction[:, np.newaxis], angles), axis=1)
    curve = np.diff(friction_for_crater_depth(140e-6, np.radians(np.linspace(5.0, 23.0, 19))))
    stress = np.diff(merchant_crater_depth(shear_yield_stress=np.linspace(0.8e8, 2.4e8, 17)))
    return {
        "fig. 4.14: depth grows with friction": Found(MICRO * over_friction.min(), bool(over_friction.min() > 0.0)),
        "fig. 4.15: depth grows with the impact angle": Found(MICRO * over_angle.min(), bool(over_angle.min() > 0.0)),
        "fig. 4.16: friction falls with the impact angle at constant depth": Found(
            curve.max(), bool(curve.max() < 0.0)
        ),
        "fig. 4.17: depth falls with the shear yield stress": Found(MICRO * stress.max(), bool(stress.max() < 0.0)),
    }


def _energy() -> dict[str, Found]:
    first, second, third = energy_coefficients()
    exact = energy_coefficients(EXACT)
    start = float(kinetic_energy(0.0, exact))
    sums = [MICRO * float(energy_crater_depth(n)) for n in (300, 3000)]
    ratios = [MICRO * float(energy_crater_depth_ratio(n)) for n in (5, 300)]
    return {
        "eq. 4.59: coefficient of exp(-2 lambda t)": Found(first),
        "eq. 4.59: coefficient of exp(-lambda t)": Found(second, told=(exact[1], start, start - 0.0126 - 7.25e-4)),
        "eq. 4.59: constant": Found(third, told=(1e4 * exact[2],)),
        "eq. 4.66: amplitude over cos(gamma)": Found(1.016 / math.cos(IMPACT_ANGLE)),
        "fig. 4.19: crater depth by work and energy": Found(1e-6 * sums[0], told=(sums[0] / 1e3, ratios[0], ratios[1])),
        "sec. 4.3: the energy estimate converges": Found(
            sums[1] / sums[0], abs(sums[1] / sums[0] - 1.0) < 0.01, (sums[1] / sums[0], BRISTLE(0.0))
        ),
    }


def _consistency() -> dict[str, Found]:
    work = 1e3 * work_along_path()
    lost = 1e3 * float(kinetic_energy(0.0) - kinetic_energy(COMPRESSION_TIME))
    ends = [float(path_force(t)) for t in (0.0, COMPRESSION_TIME)]
    energy, u = energy_coefficients(EXACT)[0], float(specific_cutting_energy(0.5))
    mass = 2.0 * energy / EXACT.tip_speed**2
    stroke = cutting_stroke(EXACT.tip_speed, mass, u)
    inclined = float(depth_from_energy(energy, specific_cutting_energy(0.5, surface="inclined")))
    return {
        "eqs. 4.54, 4.59: the work of the force is the energy given up": Found(
            work, abs(work / lost - 1.0) < 0.05, (work, lost, 1e3 * energy)
        ),
        "eqs. 4.4, 4.54: the force brakes the motion": Found(
            ends[0], abs(ends[0] - BRISTLE(0.0)) < 1.0, (ends[0], ends[1], BRISTLE(0.0), BRISTLE(COMPRESSION_TIME))
        ),
        "sec. 4.3: energy is not suitable for the crater's depth": Found(
            MICRO * stroke.depth,
            not 0.5 * MEASURED < stroke.depth < 2.0 * MEASURED,
            (1e3 * energy, MICRO * stroke.depth, MICRO * inclined, 1e6 * stroke.duration),
        ),
    }
