"""Chapter 4's sums over plies a second time: the printed equations, number by number, and their limit by extrapolation."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bristle_sim.crater_parameters import Crater
from bristle_sim.parameters import Bristle
from bristle_sim.theory.crater import merchant_crater_depth

__all__ = ["energy_depth_course", "merchant_depth_course", "merchant_depth_extrapolated", "merchant_depth_sum"]

Array = NDArray[np.float64]


def merchant_depth_course(crater: Crater, constant_deg: float = 90.0) -> Array:
    """Depth after each of the plies, 0 first, m: (4.57) as printed, with arccot(mu) in degrees; shape (plies + 1,).

    Its 45 degrees are half of the constant C of (4.45).
    """
    time = np.linspace(0.0, crater.compression_time, int(crater.plies) + 1)
    steep, gamma = math.degrees(math.atan2(1.0, crater.friction)), crater.impact_angle_deg
    half = constant_deg / 2.0
    shear = math.radians(half - steep / 2.0 + gamma / 2.0)
    resultant, leaning = math.radians(half + steep / 2.0 - gamma / 2.0), math.radians(steep - gamma)
    growth = np.diff(_printed_force(time) * math.cos(leaning))
    share = math.sin(shear) * math.cos(resultant) * math.cos(math.radians(gamma)) / math.cos(leaning)
    width = 2.0 * np.sqrt(3.55e-4**2 - (1.39e-4 + 2.16e-4 * np.exp(-92400.0 * time[1:])) ** 2)
    return np.concatenate([[0.0], np.cumsum(growth * share / (width * crater.shear_yield_stress))])


def energy_depth_course(crater: Crater) -> Array:
    """The same by work and energy (4.58, 4.62-4.65), from the printed motion (4.6, 4.7), m; shape (plies + 1,)."""
    time, wire = np.linspace(0.0, crater.compression_time, int(crater.plies) + 1), Bristle()
    left = np.exp(-92400.0 * time)
    rate, centre = 1111.0 * left - 266.65, 15.0 * left + 3.615
    energy = 0.5 * wire.mass * centre**2 + 0.5 * wire.inertia_about_centre * rate**2
    depth = np.cumsum(-np.diff(energy) / _printed_force(time[1:]))
    return np.concatenate([[0.0], depth * math.cos(math.radians(crater.impact_angle_deg))])


def merchant_depth_extrapolated(crater: Crater, *, coarsest: int = 4, levels: int = 8) -> float:
    """Limit of many plies, m, from sums over 4 to 65536: Richardson for an error in powers of 1/sqrt(n)."""
    plies = [coarsest * 4**level for level in range(levels)]
    sums = [float(each) for each in merchant_depth_sum(crater, plies)]
    for power in range(1, levels):
        gain = 2.0**power
        sums = [(gain * fine - coarse) / (gain - 1.0) for coarse, fine in pairwise(sums)]
    return sums[0]


def _printed_force(time: Array) -> Array:
    """(3.19), N."""
    return np.asarray(
        1.0160 * np.exp(-5.4990 * time) * (26.0 - 30.0 * np.cos(2.0 * np.pi * (time + 0.00001) / 0.00012))
    )


def merchant_depth_sum(crater: Crater, plies: ArrayLike) -> Array:
    """The theory's sum for any numbers of plies, m."""
    return np.asarray(
        merchant_crater_depth(
            crater.friction,
            math.radians(crater.impact_angle_deg),
            crater.shear_yield_stress,
            plies,
            compression_time=crater.compression_time,
        )
    )
