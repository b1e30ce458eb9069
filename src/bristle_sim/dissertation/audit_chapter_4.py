"""Figures of the printed numbers and statements of chapter 4 (Zhang 2020)."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.dissertation.audit_chapter_2 import PRINTED_RATE, tool
from bristle_sim.dissertation.audit_chapter_3 import BRISTLE_AMPLITUDE
from bristle_sim.dissertation.printed import Figure, Figures
from bristle_sim.theory import crater
from bristle_sim.theory.crater_cutting import cutting_stroke, depth_from_energy
from bristle_sim.theory.crater_kinematics import (
    COMPRESSION_TIME,
    IMPACT_ANGLE,
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

# The crater, chapter 4.

CUTTING_FRICTIONS, SHALLOW_ANGLES = np.linspace(0.45, 4.0, 60), np.radians(np.linspace(0.0, 23.4, 27))

drawn, exact = CraterKinematics(), CraterKinematics.of_tool(tool, PRINTED_RATE)
face, angles = TipFace(), oblique_angles(0.5, IMPACT_ANGLE)
rake, beta, eta = (math.degrees(float(each)) for each in (angles.rake, angles.friction, angles.shear))
reached = 1e6 * float(drawn.tip_displacement(COMPRESSION_TIME))
rounded_depth = 1e6 * float(crater.merchant_crater_depth(angles=PRINTED_ANGLES))
exact_energy = energy_coefficients(exact)
lost_energy = 1e3 * float(kinetic_energy(0.0) - kinetic_energy(COMPRESSION_TIME))
stroke = cutting_stroke(
    exact.tip_speed, 2.0 * exact_energy[0] / exact.tip_speed**2, float(specific_cutting_energy(0.5))
)


ply_gaps = crater.merchant_crater_depth_limit() - crater.merchant_crater_depth(plies=[10_000, 100_000])


def motion_figures() -> Figures:
    """Return the figures of motion and width of the cut, section 4.1."""
    return {
        "eq. 4.2: cutting excursion c_1": Figure(None),
        "eq. 4.4: decay lambda": Figure(exact.decay, 30 / drawn.excursion, allowance=49.5),
        "fig. 4.3: excursion at 50 us": Figure(x := reached, x),
        "fig. 4.3: excursion against 325 um": Figure(100 * abs(320 / 325 - 1), reached, 100 * (1 - reached / 325)),
        "eq. 4.6: amplitude of the rate": Figure(30 / 0.027, exact.rate),
        "eq. 4.6: rate at rest": Figure(exact.final_rate),
        "eq. 4.6: initial rate": Figure(drawn.bristle_rate(0), exact.bristle_rate(0)),
        "eq. 4.7: amplitude of v_G": Figure(0.5 * 0.027 * 1111),
        "eq. 4.7: v_G at rest": Figure(exact.final_centre_speed, exact.centre_velocity(0)),
        "eq. 4.8: depth": Figure(drawn.excursion * math.sin(IMPACT_ANGLE)),
        "eq. 4.10: angle of the face": Figure(
            None, 90 - 23.4 - 11.5, 1e4 * drawn.depth / math.sin(math.radians(90 - 23.4 - 11.5))
        ),
        "eq. 4.10: depth on the face": Figure(drawn.depth / math.sin(face.face_angle), 1e4 * exact.face_depth),
        "eq. 4.12: long axis of the tip": Figure(face.long_axis),
        "eq. 4.13: half the short axis": Figure(0.5 * face.short_axis),
        "eq. 4.13: half the long axis": Figure(0.5 * face.long_axis),
        "eq. 4.14: distance from the centre at the end": Figure(0.5 * face.long_axis - 0.00028),
        "eq. 4.15: first constant": Figure(0.00018 * 0.000355 / 0.00046),
        "eq. 4.15: second constant": Figure(0.00028 * 0.000355 / 0.00046),
        "fig. 4.6: width at 50 us": Figure(
            1e6 * CuttingWidth.of_face(face, drawn)(COMPRESSION_TIME), 1e6 * PRINTED_WIDTH(COMPRESSION_TIME)
        ),
        "fig. 4.6: width against 651 um": Figure(100 * abs(652 / 651 - 1)),
    }


def plies_figures() -> Figures:
    """Return the figures of the depth by plies, section 4.2."""
    return {
        "eq. 4.36: rake angle less impact angle": Figure(None),
        "fig. 4.13: rake angle": Figure(rake),
        "eq. 4.52: friction angle": Figure(beta),
        "eq. 4.52: shear angle": Figure(eta),
        "eq. 4.53: shear yield stress of API 5L": Figure(None),
        "eq. 4.55: amplitude of the cutting force": Figure(BRISTLE_AMPLITUDE * math.cos(angles.resultant_angle)),
        "eq. 4.56: angle of the resultant to the shear plane": Figure(eta + beta - rake),
        "eq. 4.56: angle of the resultant to the path": Figure(beta - rake),
        "eq. 4.56: 2/cos(gamma)": Figure(2 / math.cos(IMPACT_ANGLE)),
        "sec. 4.2.2: chip and rebound contradict each other": Figure(
            x := math.degrees(oblique_angles(0.31, IMPACT_ANGLE, check=False).shear), 23.4 - x, holds=x < 23.4
        ),
        "fig. 4.13: crater depth with 300 plies": Figure(rounded_depth, 1e6 * crater.merchant_crater_depth()),
        "sec. 4.2.2: the depth is converged at n = 300": Figure(
            x := 1e6 * crater.merchant_crater_depth_limit(angles=PRINTED_ANGLES),
            math.log10(ply_gaps[0] / ply_gaps[1]),
            x - rounded_depth,
            1e6 * crater.merchant_crater_depth_limit(),
            holds=abs(x - 140) < 0.5,
        ),
        "sec. 4.2.2: the depth is close to the measured 130 um": Figure(
            x := rounded_depth * 1e-06 / 0.00013 - 1, holds=abs(x) < 0.1
        ),
        "fig. 4.14: depth grows with friction": Figure(
            x := 1e6 * np.diff(crater.merchant_crater_depth(CUTTING_FRICTIONS, SHALLOW_ANGLES[:, np.newaxis])).min(),
            holds=x > 0,
        ),
        "fig. 4.15: depth grows with the impact angle": Figure(
            x := 1e6 * np.diff(crater.merchant_crater_depth(CUTTING_FRICTIONS[:, np.newaxis], SHALLOW_ANGLES)).min(),
            holds=x > 0,
        ),
        "fig. 4.16: friction falls with the impact angle at constant depth": Figure(
            x := np.diff(crater.friction_for_crater_depth(0.00014, np.radians(np.linspace(5, 23, 19)))).max(),
            holds=x < 0,
        ),
        "fig. 4.17: depth falls with the shear yield stress": Figure(
            x := 1e6
            * np.diff(crater.merchant_crater_depth(shear_yield_stress=np.linspace(80000000.0, 240000000.0, 17))).max(),
            holds=x < 0,
        ),
    }


def energy_figures() -> Figures:
    """Return the figures of the depth by work and energy, section 4.3."""
    return {
        "eq. 4.59: coefficient of exp(-2 lambda t)": Figure(energy_coefficients()[0]),
        "eq. 4.59: coefficient of exp(-lambda t)": Figure(
            energy_coefficients()[1],
            exact_energy[1],
            kinetic_energy(0, exact_energy),
            kinetic_energy(0, exact_energy) - 0.0126 - 0.000725,
        ),
        "eq. 4.59: constant": Figure(energy_coefficients()[2], 1e4 * exact_energy[2]),
        "eq. 4.66: amplitude over cos(gamma)": Figure(1.016 / math.cos(IMPACT_ANGLE)),
        "fig. 4.19: crater depth by work and energy": Figure(
            1e-06 * (1e6 * crater.energy_crater_depth(300)),
            1e3 * crater.energy_crater_depth(300),
            1e6 * crater.energy_crater_depth_ratio(5),
            1e6 * crater.energy_crater_depth_ratio(300),
        ),
        "sec. 4.3: the energy estimate converges": Figure(
            x := 1e6 * crater.energy_crater_depth(3000) / (1e6 * crater.energy_crater_depth(300)),
            x,
            BRISTLE(0),
            holds=abs(x - 1) < 0.01,
        ),
        "eqs. 4.54, 4.59: the work of the force is the energy given up": Figure(
            x := 1e3 * crater.work_along_path(),
            x,
            lost_energy,
            1e3 * exact_energy[0],
            holds=abs(x / lost_energy - 1) < 0.05,
        ),
        "eqs. 4.4, 4.54: the force brakes the motion": Figure(
            x := path_force(0),
            x,
            path_force(COMPRESSION_TIME),
            BRISTLE(0),
            BRISTLE(COMPRESSION_TIME),
            holds=abs(x - BRISTLE(0)) < 1,
        ),
        "sec. 4.3: energy is not suitable for the crater's depth": Figure(
            x := 1e6 * stroke.depth,
            1e3 * exact_energy[0],
            x,
            1e6 * depth_from_energy(exact_energy[0], specific_cutting_energy(0.5, surface="inclined")),
            1e6 * stroke.duration,
            holds=not 65 < x < 260,
        ),
    }
