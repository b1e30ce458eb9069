"""Figures of the printed statements on Stronge's pendulums, and on the general impact law (Zhang 2020, sec. 2.4)."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.dissertation.audit_chapter_2 import (
    PRINTED_RATE,
    SPEED_RATIO,
    equal_lengths,
    length,
    mass,
    operating,
    radius,
    tool,
)
from bristle_sim.dissertation.printed import Figure, Figures
from bristle_sim.theory import monofilament, pendulums
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.pendulums import stick_friction


def degenerate_difference() -> float:
    """Return the largest difference of the monofilament with r_h = 0 from Stronge's pendulum, in rebound ratios."""
    gamma = np.radians([20.0, 40.0, 60.0, 80.0])
    bristle = monofilament.monofilament_impact(1.0, 1.0, 0.0, 1.0, 1.0, gamma, 0.31, 0.42).rebound_ratio
    stronge = [pendulums.single_pendulum_impact(1.0, 1.0, each, -1.0, 0.31, 0.42).rebound_ratio for each in gamma]
    return float(np.max(np.abs(bristle - np.array(stronge))))


def heavy_rod(mass_ratio: float) -> pendulums.DoublePendulumImpact:
    """Return the impact of the double pendulum of figures 2.28 and 2.29."""
    return pendulums.double_pendulum_impact(5.0, mass_ratio, 1.0, math.pi / 9.0, math.pi / 6.0, -0.1, -0.2, 0.5, 0.5)


hub_as_rod = pendulums.double_pendulum_impact(
    mass, 700.0, length, IMPACT_ANGLE, IMPACT_ANGLE, -tool.hub.speed, -PRINTED_RATE, 0.31, 0.42
).normal_final_impulse
"""p_fy of the double pendulum of figure 2.30 at mu = 0.31, N s."""


def law_difference() -> float:
    """Return the relative difference of (2.64) from the general two-dimensional law at the operating point."""
    sine, cosine = math.sin(IMPACT_ANGLE), math.cos(IMPACT_ANGLE)
    matrix = 3.0 / mass * np.array([[sine * sine, -sine * cosine], [-sine * cosine, cosine * cosine]])
    speed = float(monofilament.tip_speed(length, radius, tool.hub.speed, SPEED_RATIO))
    law = energetic_impact(matrix, (-speed * sine, speed * cosine), 0.31, 0.42)
    return abs(float(law.impulse_normal / operating.normal_final_impulse) - 1.0)


def pendulum_figures() -> Figures:
    """Return the figures of Stronge's pendulums, section 2.4."""
    return {
        "fig. 2.26: the degenerated model is Stronge's pendulum": Figure(x := degenerate_difference(), holds=x < 1e-12),
        "fig. 2.28: the rate of rod BC converges as n grows": Figure(
            x := abs(heavy_rod(10000.0).final_rate_2 / heavy_rod(100000000.0).final_rate_2 - 1), holds=x < 0.001
        ),
        "fig. 2.29: rod OB keeps its rate as n grows": Figure(
            x := abs(heavy_rod(10000.0).final_rate_1 + 0.1), holds=x < 0.0001
        ),
        "fig. 2.30: mass m_1 of the heavy rod, 700 times m_2": Figure(700 * mass),
        "fig. 2.30: the double pendulum agrees with the monofilament": Figure(
            x := hub_as_rod / operating.normal_final_impulse - 1,
            abs(x),
            abs(hub_as_rod / equal_lengths - 1),
            holds=abs(x) < 0.01,
        ),
        "eq. 2.111: the double pendulum's stiction friction is tan gamma": Figure(
            x := stick_friction(700, IMPACT_ANGLE, IMPACT_ANGLE) - math.tan(IMPACT_ANGLE), holds=abs(x) < 1e-12
        ),
        "eq. 2.64: p_fy is what the impact law gives": Figure(x := law_difference(), holds=x < 1e-12),
    }
