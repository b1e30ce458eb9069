"""Audit of the crater's kinematics and depth (Zhang 2020, chapter 4)."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.dissertation.audit_row import AuditRow, claim, missing, number
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


def crater_rows() -> tuple[AuditRow, ...]:
    """Rows of chapter 4."""
    return (*_motion(), *_tip(), *_angles(), *_plies(), *_trends(), *_energy(), *_consistency())


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


def _motion() -> tuple[AuditRow, ...]:
    k, by = PRINTED_KINEMATICS, CraterKinematics.of_tool
    reached = MICRO * float(k.tip_displacement(COMPRESSION_TIME))
    centre = EXACT.centre_velocity(0.0)
    return (
        missing("eq. 4.2: cutting excursion c_1", "3.25e-4", "m", "measured on a micrograph"),
        number("eq. 4.4: decay lambda", "92400", "1/s", EXACT.decay, by,
               f"30.03/3.25e-4; the 30 m/s of (4.3) would give {30.0 / k.excursion:.0f}", allowance=49.5),
        number("fig. 4.3: excursion at 50 us", "320", "um", reached, CraterKinematics.tip_displacement,
               f"(4.4a) gives {reached:.1f}; printed to two digits"),
        number("fig. 4.3: excursion against 325 um", "1.5", "%", percent_apart(320.0, 325.0), percent_apart,
               f"from the printed 320; with {reached:.1f} it is {100.0 * (1.0 - reached / 325.0):.2f} %"),
        number("eq. 4.6: amplitude of the rate", "1111", "rad/s", 30.0 / 0.027, CraterKinematics.bristle_rate,
               f"30/0.027; with the unrounded speed {EXACT.rate:.1f}"),
        number("eq. 4.6: rate at rest", "266.65", "rad/s", EXACT.final_rate, by),
        number("eq. 4.6: initial rate", "845.6", "rad/s", float(k.bristle_rate(0.0)), CraterKinematics.bristle_rate,
               f"(4.6) starts from a speed rounded to 30 m/s; from 30.03 it is {float(EXACT.bristle_rate(0.0)):.1f}"),
        number("eq. 4.7: amplitude of v_G", "15", "m/s", 0.5 * 0.027 * 1111.0, CraterKinematics.centre_velocity),
        number("eq. 4.7: v_G at rest", "3.615", "m/s", EXACT.final_centre_speed, by,
               f"half the rim's speed; 3.615 is the initial v_G = {centre:.3f} less the rounded 15, so the rounding of one"
               " constant went into the other"),
        number("eq. 4.8: depth", "1.3e-4", "m", k.excursion * math.sin(IMPACT_ANGLE), CraterKinematics.crater_depth),
    )  # fmt: skip


def _tip() -> tuple[AuditRow, ...]:
    face = TipFace()
    on_face = PRINTED_KINEMATICS.depth / math.sin(face.face_angle)
    unrounded = MICRO * float(CuttingWidth.of_face(face, PRINTED_KINEMATICS)(COMPRESSION_TIME))
    printed = MICRO * float(PRINTED_WIDTH(COMPRESSION_TIME))
    rake = 90.0 - 23.4 - 11.5
    return (
        missing("eq. 4.10: angle of the face", "28", "deg",
                f"read off a figure; the rake angle of (4.36) puts the face at {rake:.1f} deg to the path, where the trace"
                f" of the depth is {1e4 * PRINTED_KINEMATICS.depth / math.sin(math.radians(rake)):.2f}e-4 m. It is"
                " 39.5 deg less 11.5 deg"),
        number("eq. 4.10: depth on the face", "2.8e-4", "m", on_face, CraterKinematics.crater_face_depth,
               f"from the rounded 1.3e-4; unrounded {1e4 * EXACT.face_depth:.2f}e-4"),
        number("eq. 4.12: long axis of the tip", "9.2e-4", "m", face.long_axis, TipFace),
        number("eq. 4.13: half the short axis", "3.55e-4", "m", 0.5 * face.short_axis, TipFace),
        number("eq. 4.13: half the long axis", "4.6e-4", "m", 0.5 * face.long_axis, TipFace),
        number("eq. 4.14: distance from the centre at the end", "1.8e-4", "m", 0.5 * face.long_axis - 2.8e-4, TipFace),
        number("eq. 4.15: first constant", "1.39e-4", "m", half_axis_share(1.8e-4), half_axis_share),
        number("eq. 4.15: second constant", "2.16e-4", "m", half_axis_share(2.8e-4), half_axis_share),
        number("fig. 4.6: width at 50 us", "652", "um", unrounded, CuttingWidth.of_face,
               f"with unrounded constants; (4.16) as printed gives {printed:.2f}"),
        number("fig. 4.6: width against 651 um", "0.15", "%", percent_apart(652.0, 651.0), percent_apart),
    )  # fmt: skip


def _angles() -> tuple[AuditRow, ...]:
    angles, low = oblique_angles(0.5, IMPACT_ANGLE), oblique_angles(0.31, IMPACT_ANGLE, check=False)
    rake, friction, shear = (math.degrees(float(each)) for each in (angles.rake, angles.friction, angles.shear))
    buried = math.degrees(float(low.shear))
    cut = BRISTLE.amplitude[0] * math.cos(float(angles.resultant_angle))
    return (
        missing("eq. 4.36: rake angle less impact angle", "11.5", "deg", "measured on the tip"),
        number("fig. 4.13: rake angle", "34.9", "deg", rake, oblique_angles),
        number("eq. 4.52: friction angle", "74.9", "deg", friction, oblique_angles),
        number("eq. 4.52: shear angle", "25", "deg", shear, oblique_angles),
        missing("eq. 4.53: shear yield stress of API 5L", "1.2e8", "Pa", "taken from a data sheet"),
        number("eq. 4.55: amplitude of the cutting force", "0.78", "1", cut, oblique_angles),
        number("eq. 4.56: angle of the resultant to the shear plane", "65", "deg", shear + friction - rake,
               oblique_angles),
        number("eq. 4.56: angle of the resultant to the path", "40", "deg", friction - rake, oblique_angles),
        number("eq. 4.56: 2/cos(gamma)", "2.18", "1", 2.0 / math.cos(IMPACT_ANGLE), merchant_crater_depth),
        claim("sec. 4.2.2: chip and rebound contradict each other", "mu >= tan gamma and mu < tan gamma", "deg", buried,
              buried < 23.4, oblique_angles,
              f"with the friction 0.31 of chapter 2 the shear plane stays {23.4 - buried:.2f} deg under the surface; measured"
              " to the inclined surface instead, its angle of least work comes out for every mu"),
    )  # fmt: skip


def _plies() -> tuple[AuditRow, ...]:
    exact = MICRO * float(merchant_crater_depth())
    rounded = MICRO * float(merchant_crater_depth(angles=PRINTED_ANGLES))
    limits = [MICRO * float(merchant_crater_depth_limit(angles=each)) for each in (None, PRINTED_ANGLES)]
    order = convergence_order(10_000)
    gap = limits[1] - rounded
    away = rounded * 1e-6 / MEASURED - 1.0
    return (
        number("fig. 4.13: crater depth with 300 plies", "140", "um", rounded, merchant_crater_depth,
               f"with the rounded angles of (4.52); exact ones give {exact:.2f}"),
        claim("sec. 4.2.2: the depth is converged at n = 300", "140 um, converged", "um", limits[1],
              abs(limits[1] - 140.0) < 0.5, merchant_crater_depth_limit,
              f"b(0) = 0 makes the sum converge like n^-{order:.2f}: at n = 300 {gap:.2f} um are missing, and a tenth of that"
              f" takes 30000 plies. The limit is {limits[0]:.2f} um with exact angles"),
        claim("sec. 4.2.2: the depth is close to the measured 130 um", "close", "1", away, abs(away) < 0.1,
              merchant_crater_depth),
    )  # fmt: skip


def _trends() -> tuple[AuditRow, ...]:
    friction, angles = np.linspace(0.45, 4.0, 60), np.radians(np.linspace(0.0, 23.4, 27))
    over_friction = np.diff(merchant_crater_depth(friction, angles[:, np.newaxis]), axis=1)
    over_angle = np.diff(merchant_crater_depth(friction[:, np.newaxis], angles), axis=1)
    curve = np.diff(friction_for_crater_depth(140e-6, np.radians(np.linspace(5.0, 23.0, 19))))
    stress = np.diff(merchant_crater_depth(shear_yield_stress=np.linspace(0.8e8, 2.4e8, 17)))
    by = merchant_crater_depth
    return (
        claim("fig. 4.14: depth grows with friction", "grows", "um", MICRO * over_friction.min(),
              bool(over_friction.min() > 0.0), by),
        claim("fig. 4.15: depth grows with the impact angle", "grows", "um", MICRO * over_angle.min(),
              bool(over_angle.min() > 0.0), by),
        claim("fig. 4.16: friction falls with the impact angle at constant depth", "falls", "1", curve.max(),
              bool(curve.max() < 0.0), friction_for_crater_depth),
        claim("fig. 4.17: depth falls with the shear yield stress", "falls", "um", MICRO * stress.max(),
              bool(stress.max() < 0.0), by),
    )  # fmt: skip


def _energy() -> tuple[AuditRow, ...]:
    first, second, third = energy_coefficients()
    exact = energy_coefficients(EXACT)
    start = float(kinetic_energy(0.0, exact))
    sums = [MICRO * float(energy_crater_depth(n)) for n in (300, 3000)]
    ratios = [MICRO * float(energy_crater_depth_ratio(n)) for n in (5, 300)]
    return (
        number("eq. 4.59: coefficient of exp(-2 lambda t)", "0.0126", "J", first, energy_coefficients),
        number("eq. 4.59: coefficient of exp(-lambda t)", "0.00303", "J", second, energy_coefficients,
               f"what the printed (4.6) and (4.7) give; unrounded ones give {exact[1]:.5f}. 0.00303 is the initial energy"
               f" {start:.5f} less the two other printed coefficients, {start - 0.0126 - 7.25e-4:.5f}"),
        number("eq. 4.59: constant", "7.25e-4", "J", third, energy_coefficients,
               f"with the 3.615 m/s of (4.7); the unrounded 3.59975 gives {1e4 * exact[2]:.2f}e-4, so the dissertation had it"),
        number("eq. 4.66: amplitude over cos(gamma)", "1.107", "1", 1.016 / math.cos(IMPACT_ANGLE), energy_crater_depth),
        number("fig. 4.19: crater depth by work and energy", "7.58e-5", "m", 1e-6 * sums[0], energy_crater_depth,
               f"the quotients as derived add up to {sums[0] / 1e3:.2f} mm, since the force begins near zero; the ratio of two"
               f" sums of (4.66) gives {ratios[0]:.2f} um with 5 plies and {ratios[1]:.2f} um with 300"),
        claim("sec. 4.3: the energy estimate converges", "converges", "1", sums[1] / sums[0],
              abs(sums[1] / sums[0] - 1.0) < 0.01, energy_crater_depth,
              f"ten times the plies make it {sums[1] / sums[0]:.2f} times as deep; it ends at 14 mm only because rounding left"
              f" F(0) = {BRISTLE(0.0):.4f} N. As a ratio of sums it falls like 1/n"),
    )  # fmt: skip


def _consistency() -> tuple[AuditRow, ...]:
    work = 1e3 * work_along_path()
    lost = 1e3 * float(kinetic_energy(0.0) - kinetic_energy(COMPRESSION_TIME))
    ends = [float(path_force(t)) for t in (0.0, COMPRESSION_TIME)]
    energy, u = energy_coefficients(EXACT)[0], float(specific_cutting_energy(0.5))
    mass = 2.0 * energy / EXACT.tip_speed**2
    stroke = cutting_stroke(EXACT.tip_speed, mass, u)
    inclined = float(depth_from_energy(energy, specific_cutting_energy(0.5, surface="inclined")))
    return (
        claim("eqs. 4.54, 4.59: the work of the force is the energy given up", "equal", "mJ", work,
              abs(work / lost - 1.0) < 0.05, work_along_path,
              f"over the printed path the force does {work:.2f} mJ, the kinetic energy falls by {lost:.1f} mJ; of these"
              f" {1e3 * energy:.1f} mJ are the tip's, the rest is taken by the root's bearing"),
        claim("eqs. 4.4, 4.54: the force brakes the motion", "m/3 dv/dt = -F", "N", ends[0],
              abs(ends[0] - BRISTLE(0.0)) < 1.0, path_force,
              f"the motion asks for {ends[0]:.1f} N at first touch and {ends[1]:.2f} N at 50 us, the force history has"
              f" {BRISTLE(0.0):.2f} and {BRISTLE(COMPRESSION_TIME):.1f} N"),
        claim("sec. 4.3: energy is not suitable for the crater's depth", "not suitable", "um", MICRO * stroke.depth,
              not 0.5 * MEASURED < stroke.depth < 2.0 * MEASURED, cutting_stroke,
              f"the tip's {1e3 * energy:.1f} mJ over the specific cutting energy give {MICRO * stroke.depth:.0f} um"
              f" ({MICRO * inclined:.0f} um with the shear plane measured to the inclined surface), either side of the measured"
              f" 130. Cutting alone would take {1e6 * stroke.duration:.0f} us, not 50"),
    )  # fmt: skip
