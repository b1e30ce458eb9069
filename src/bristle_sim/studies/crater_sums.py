"""Sums over plies of chapter 4 computed a second time, from the printed equations, and the constant C of (4.45) that they need.

(4.45), 2 eta + beta - alpha = C, leaves C to the work material; the dissertation takes that of least work, 90 degrees, and
its crater is deeper than measured. Less C makes a flatter shear plane and a shallower crater, until the shear plane no longer
comes out of the surface (4.35): then there is a C, but no chip.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from itertools import product
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity
from bristle_sim.parameters import Bristle
from bristle_sim.parameters.experiments import Crater
from bristle_sim.theory.crater import constant_for_crater_depth

FRICTIONS = (0.461, 0.47, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 4.0)
IMPACT_ANGLES_DEG = (5.0, 10.0, 15.0, 20.0, 23.4)
"""Rows of the table: the ranges of figs. 4.14 and 4.15, closer where C runs from its least value to 90 degrees."""

SAME_SUM = 1e-9
"""Relative difference of two sums over plies by different orders of their terms."""


def cut_of(crater: Crater) -> dict[str, Any]:
    """Return what the theory's functions of the crater take, by the names of their arguments; SI and rad."""
    return {
        "friction": crater.friction,
        "impact_angle": math.radians(crater.impact_angle_deg),
        "shear_yield_stress": crater.shear_yield_stress,
        "compression_time": crater.compression_time,
    }


def merchant_depth_course(crater: Crater, constant_deg: float = 90.0) -> Array:
    """Return the depth after each ply, 0 first, m, by (4.57) as printed, in degrees; shape (plies + 1,).

    Its 45 degrees are half of the constant C of (4.45).
    """
    time = np.linspace(0.0, crater.compression_time, int(crater.plies) + 1)
    steep, gamma = math.degrees(math.atan2(1.0, crater.friction)), crater.impact_angle_deg
    half = constant_deg / 2.0
    shear = math.radians(half - steep / 2.0 + gamma / 2.0)
    resultant, leaning = math.radians(half + steep / 2.0 - gamma / 2.0), math.radians(steep - gamma)
    growth = np.diff(_printed_force(time) * math.cos(leaning))
    ratio = math.sin(shear) * math.cos(resultant) * math.cos(math.radians(gamma)) / math.cos(leaning)
    width = 2.0 * np.sqrt(3.55e-4**2 - (1.39e-4 + 2.16e-4 * np.exp(-92400.0 * time[1:])) ** 2)
    return np.concatenate([[0.0], np.cumsum(growth * ratio / (width * crater.shear_yield_stress))])


def energy_depth_course(crater: Crater) -> Array:
    """Return the depth after each ply by work and energy (4.58, 4.62-4.65), m, from the printed motion (4.6, 4.7)."""
    time, wire = np.linspace(0.0, crater.compression_time, int(crater.plies) + 1), Bristle()
    left = np.exp(-92400.0 * time)
    rate, centre = 1111.0 * left - 266.65, 15.0 * left + 3.615
    energy = 0.5 * wire.mass * centre**2 + 0.5 * wire.inertia_about_centre * rate**2
    depth = np.cumsum(-np.diff(energy) / _printed_force(time[1:]))
    return np.concatenate([[0.0], depth * math.cos(math.radians(crater.impact_angle_deg))])


def _printed_force(time: Array) -> Array:
    """Return the force (3.19), N."""
    turning = np.cos(2.0 * np.pi * (time + 0.00001) / 0.00012)
    return np.asarray(1.0160 * np.exp(-5.4990 * time) * (26.0 - 30.0 * turning))


def constant_row(crater: Crater, depth: float) -> Quantity:
    """Return C in degrees, by root finding on the printed sum (4.57) and in closed form; empty where there is none."""
    name = "constant_for_measured_depth_deg"
    theory, found = _closed_form_deg(crater, depth), _root_deg(crater, depth)
    if theory is None:
        return Quantity(name, "deg", found)
    # d(depth)/depth = cos(C) dC/(sin(C) - sin(x)); at C = 90 degrees the depth is stationary and C known to its root.
    constant, slope = math.radians(theory), math.cos(math.radians(theory))
    gain = math.sin(constant) - math.sin(_resultant_angle(crater))
    error = min(SAME_SUM * gain / max(slope, 1e-12), math.sqrt(2.0 * SAME_SUM * gain))
    return Quantity(name, "deg", found, theory, tolerance=max(error / constant, 1e-12))


def constants_over(
    crater: Crater,
    depth: float,
    frictions: Iterable[float] = FRICTIONS,
    impact_angles_deg: Iterable[float] = IMPACT_ANGLES_DEG,
) -> list[dict[str, Any]]:
    """Return C and shear angle over friction and impact angle, degrees; None where no C gives the depth."""
    rows = []
    for gamma, friction in product(impact_angles_deg, frictions):
        tried = dataclasses.replace(crater, friction=friction, impact_angle_deg=gamma)
        row: dict[str, Any] = {"friction": friction, "impact_angle_deg": gamma}
        constant = row["constant_deg"] = _closed_form_deg(tried, depth)
        known = constant is not None
        row["shear_angle_deg"] = 0.5 * (constant - math.degrees(_resultant_angle(tried))) if known else None
        # eta >= gamma, which is C >= arccot(mu) + gamma (4.35).
        least = math.degrees(math.atan2(1.0, friction)) + gamma
        row["shear_plane_emerges"] = constant >= least - 1e-9 if known else None
        rows.append(row)
    return rows


def _resultant_angle(crater: Crater) -> float:
    """Return x = beta - alpha = arccot(mu) - gamma, rad."""
    return math.atan2(1.0, crater.friction) - math.radians(crater.impact_angle_deg)


def _closed_form_deg(crater: Crater, depth: float) -> Any:
    try:
        return math.degrees(float(constant_for_crater_depth(depth, plies=int(crater.plies), **cut_of(crater))))
    except ValueError:
        return None


def _root_deg(crater: Crater, depth: float) -> float | None:
    """Return the C for which the printed sum is as deep; the depth rises with C, from 0 at C = x."""
    from scipy.optimize import brentq

    def excess(constant: float) -> float:
        return float(merchant_depth_course(crater, constant)[-1]) / depth - 1.0

    low = max(0.0, math.degrees(_resultant_angle(crater)))
    if abs(excess(90.0)) <= SAME_SUM:
        return 90.0
    return float(brentq(excess, low, 90.0, xtol=1e-13)) if excess(low) < 0.0 < excess(90.0) else None
