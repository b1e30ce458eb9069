"""Audit of the rigid-body impact: statements on figures 2.7-2.30 and the numbers in their captions (Zhang 2020, ch. 2)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from bristle_sim.dissertation.audit_row import Found
from bristle_sim.dissertation.audit_tool import PRINTED_RATE, SPEED_RATIO
from bristle_sim.parameters import Tool, operating_point
from bristle_sim.theory import monofilament, pendulums
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.pendulum_phases import stick_friction

Array = Any
"""A float or an array of floats."""

TOOL = operating_point()
FRICTIONS = np.linspace(0.0, 1.0, 101)
ANGLES = np.radians([15.0, 20.0, 25.0, 30.0])
BELOW_STICTION = np.linspace(0.0, 0.42, 22)
"""Friction up to just below tan(23.4 deg) = 0.433."""


def impact_figures() -> dict[str, Found]:
    """Figures of sections 2.3 and 2.4."""
    return {**_impulses(), **_works(), **_restitution(), **_stiction(), **_pendulums()}


def strike(
    friction: Array | None = None,
    impact_angle: Array = IMPACT_ANGLE,
    restitution: Array | None = None,
    restitution_friction: Array | None = None,
    *,
    length: Array | None = None,
    hub_speed: Array | None = None,
    speed_ratio: Array = SPEED_RATIO,
    tool: Tool = TOOL,
) -> monofilament.MonofilamentImpact:
    """The monofilament's impact at the operating point but for what is given."""
    assert tool.workpart is not None
    return monofilament.monofilament_impact(
        tool.bristle.mass,
        tool.bristle.length if length is None else length,
        tool.hub.radius,
        tool.hub.speed if hub_speed is None else hub_speed,
        speed_ratio,
        impact_angle,
        tool.workpart.friction if friction is None else friction,
        tool.workpart.restitution if restitution is None else restitution,
        restitution_friction,
    )


def resultant_impulse(friction: Array) -> Array:
    """p_c = sqrt(p_cx^2 + p_cy^2) at gamma = 23.4 deg, N s (3.1)."""
    hit = strike(friction)
    return np.hypot(hit.normal_compressive_impulse, hit.tangential_compressive_impulse)


def work_ratio(friction: float, impact_angle: float) -> float:
    """|W_x/W_y| of compression, mu cot(gamma)."""
    hit = strike(friction, impact_angle)
    return abs(float(hit.tangential_compressive_work / hit.normal_compressive_work))


def total_work(friction: Array) -> Array:
    """W_x + W_y of compression at gamma = 23.4 deg, J."""
    hit = strike(friction)
    return hit.normal_compressive_work + hit.tangential_compressive_work


def bend(values: Array) -> float:
    """Largest second difference relative to the range: 0 for a straight line."""
    return float(np.max(np.abs(np.diff(values, 2))) / np.ptp(values))


def least_step(values: Array) -> float:
    """Smallest increase from one value to the next along the last axis, relative to the range."""
    return float(np.min(np.diff(values)) / np.ptp(values))


def _rises(values: Array) -> Found:
    """Return that values increase along their last axis, with the smallest increase relative to the range."""
    step = least_step(values)
    return Found(step, step > 0.0)


def two_friction_difference() -> float:
    """Largest relative difference of p_fy with mu_1 = 0.31 kept and mu_2 varied from that with mu_1 = mu_2 varied."""
    one = strike(BELOW_STICTION).normal_final_impulse
    two = strike(None, restitution_friction=BELOW_STICTION).normal_final_impulse
    return float(np.max(np.abs(two / one - 1.0)))


def degenerate_difference() -> float:
    """Largest difference of the monofilament with r_h = 0 from Stronge's pendulum, in rebound ratios."""
    friction, gamma = 0.31, np.radians([20.0, 40.0, 60.0, 80.0])
    bristle = monofilament.monofilament_impact(1.0, 1.0, 0.0, 1.0, 1.0, gamma, friction, 0.42).rebound_ratio
    stronge = [pendulums.single_pendulum_impact(1.0, 1.0, each, -1.0, friction, 0.42).rebound_ratio for each in gamma]
    return float(np.max(np.abs(bristle - np.array(stronge))))


def heavy_rod(mass_ratio: float) -> pendulums.DoublePendulumImpact:
    """The double pendulum of figures 2.28 and 2.29."""
    return pendulums.double_pendulum_impact(
        5.0, mass_ratio, 1.0, math.pi / 9.0, math.pi / 6.0, -0.1, -0.2, friction=0.5, restitution=0.5
    )


def heavy_rod_mass(mass_ratio: float) -> float:
    """m_1 = n m_2, kg."""
    return mass_ratio * TOOL.bristle.mass


def radius_ratio() -> float:
    """r_h/L."""
    return TOOL.hub.radius / TOOL.bristle.length


def hub_as_rod(mass_ratio: float) -> float:
    """p_fy of the double pendulum of figure 2.30 at mu = 0.31, N s."""
    mass, length = TOOL.bristle.mass, TOOL.bristle.length
    angles, rates = (IMPACT_ANGLE, IMPACT_ANGLE), (-TOOL.hub.speed, -PRINTED_RATE)
    hit = pendulums.double_pendulum_impact(mass, mass_ratio, length, *angles, *rates, friction=0.31, restitution=0.42)
    return hit.normal_final_impulse


def _impulses() -> dict[str, Found]:
    over_angles = strike(FRICTIONS, ANGLES[:, np.newaxis])
    ends = over_angles.normal_compressive_impulse[:, -1]
    spread = float(np.ptp(ends) / np.mean(ends))
    first = float(np.ptp(over_angles.normal_compressive_impulse[:, 0]) / np.mean(ends))
    lengths = strike(length=np.linspace(0.01, 0.05, 9)).normal_compressive_impulse
    ratios = strike(speed_ratio=np.linspace(1.0, 5.0, 9)).normal_compressive_impulse
    shear = -over_angles.tangential_compressive_impulse
    impulse = resultant_impulse(BELOW_STICTION)
    return {
        "fig. 2.7: p_cy falls with friction": _rises(-over_angles.normal_compressive_impulse),
        "fig. 2.7: p_cy converges to a common value as friction approaches 1": Found(
            spread, spread < 0.01, (spread, first)
        ),
        "fig. 2.8: p_cy is linear in the bristle's length": Found(bend(lengths), bend(lengths) < 1e-12),
        "fig. 2.9: p_cy is linear in the speed ratio": Found(bend(ratios), bend(ratios) < 1e-12),
        "fig. 2.15: p_cx grows with friction": _rises(shear),
        "fig. 2.15: p_cx grows as the impact gets shallower": _rises(-shear[:, 1:].T),
        "sec. 5.1: elevated friction leads to the greatest compressive impulse": Found(
            float(impulse[-1] / impulse[0]), bool(impulse[-1] > impulse[0]), (1e3 * impulse[0], 1e3 * impulse[-1])
        ),
    }


def _works() -> dict[str, Found]:
    over_angles = strike(FRICTIONS[1:], ANGLES[:, np.newaxis])
    normal, shear = -over_angles.normal_compressive_work, -over_angles.tangential_compressive_work
    by_length, by_ratio = strike(length=np.linspace(0.01, 0.05, 9)), strike(speed_ratio=np.linspace(1.0, 5.0, 9))
    by_speed = strike(hub_speed=np.linspace(100.0, 400.0, 9))
    growth = [least_step(-each.normal_compressive_work) for each in (by_length, by_ratio, by_speed)]
    shear_growth = [least_step(-each.tangential_compressive_work) for each in (by_length, by_ratio, by_speed)]
    ratio = work_ratio(0.31, IMPACT_ANGLE)
    total = total_work(FRICTIONS)
    change = float(np.ptp(total) / np.abs(np.mean(total)))
    return {
        "fig. 2.10: normal work grows with the impact angle": _rises(normal.T),
        "fig. 2.10: normal work falls with friction": _rises(-normal),
        "figs. 2.11, 2.12: normal work grows with length, speed ratio and hub speed": Found(
            min(growth), min(growth) > 0.0
        ),
        "fig. 2.16: tangential work grows with friction": _rises(shear),
        "figs. 2.17, 2.18: tangential work grows with length, speed ratio and hub speed": Found(
            min(shear_growth), min(shear_growth) > 0.0
        ),
        "sec. 2.3.2: tangential work is one order of magnitude greater than normal work": Found(
            ratio, ratio >= 10.0, (ratio, 10.0 * math.tan(IMPACT_ANGLE))
        ),
        "fig. 2.19: total work behaves like tangential work over friction": Found(
            change, change > 0.01, (1e3 * total[0],)
        ),
    }


def _restitution() -> dict[str, Found]:
    over_first = strike(BELOW_STICTION, restitution_friction=0.31).normal_final_impulse
    over_second = strike(0.31, restitution_friction=BELOW_STICTION).normal_final_impulse
    over_e = strike(0.31, restitution=np.linspace(0.0, 1.0, 11)).normal_final_impulse
    rebound = -strike(BELOW_STICTION).rebound_ratio
    difference = two_friction_difference()
    return {
        "fig. 2.13: p_fy grows with friction in restitution": _rises(over_second),
        "fig. 2.14: p_fy falls with friction in compression": _rises(-over_first),
        "fig. 2.22: equal or different friction makes minimal distinction": Found(
            difference, difference < 0.05, (difference,)
        ),
        "fig. 2.23: p_fy grows with restitution": _rises(over_e),
        "fig. 2.24: the rebound ratio falls with friction": _rises(-rebound),
    }


def _stiction() -> dict[str, Found]:
    threshold = float(monofilament.stiction_friction(IMPACT_ANGLE))
    near = strike(0.31, restitution_friction=threshold * (1.0 - 1e-8)).normal_final_impulse
    growth = float(near / strike(0.31).normal_final_impulse)
    ratio = radius_ratio()
    rounded = math.tan(math.radians(24.0))
    return {
        "eq. 2.51: p_fy is arbitrarily large at mu_2 = tan gamma": Found(growth, growth > 1e3),
        "above eq. 2.51: in our model L = r_h": Found(ratio, abs(ratio - 1.0) < 1e-3),
        "fig. 4.15: least friction tan(23.4 deg)": Found(threshold),
        "fig. 4.14: least friction tan(24 deg)": Found(rounded),
    }


def _pendulums() -> dict[str, Found]:
    alike = degenerate_difference()
    heavy, heavier = heavy_rod(1e4), heavy_rod(1e8)
    drift = abs(heavy.final_rate_1 + 0.1)
    settled = abs(heavy.final_rate_2 / heavier.final_rate_2 - 1.0)
    bristle = float(strike(0.31).normal_final_impulse)
    apart = hub_as_rod(700.0) / bristle - 1.0
    mass = heavy_rod_mass(700.0)
    stick = float(stick_friction(700.0, IMPACT_ANGLE, IMPACT_ANGLE)) - math.tan(IMPACT_ANGLE)
    return {
        "fig. 2.26: the degenerated model is Stronge's pendulum": Found(alike, alike < 1e-12),
        "fig. 2.28: the rate of rod BC converges as n grows": Found(settled, settled < 1e-3),
        "fig. 2.29: rod OB keeps its rate as n grows": Found(drift, drift < 1e-4),
        "fig. 2.30: mass m_1 of the heavy rod, 700 times m_2": Found(mass),
        "fig. 2.30: the double pendulum agrees with the monofilament": Found(
            apart, abs(apart) < 0.01, (abs(apart), abs(hub_as_rod(700.0) / _equal_lengths() - 1.0))
        ),
        "eq. 2.111: the double pendulum's stiction friction is tan gamma": Found(stick, abs(stick) < 1e-12),
        "eq. 2.64: p_fy is what the impact law gives": Found(_law_difference(), _law_difference() < 1e-12),
    }


def _equal_lengths() -> float:
    """p_fy of a monofilament on a hub of radius L, N s."""
    speed = TOOL.bristle.length * (TOOL.hub.speed + PRINTED_RATE)
    return float(monofilament.normal_final_impulse(TOOL.bristle.mass, speed, IMPACT_ANGLE, 0.31, 0.42))


def _law_difference() -> float:
    """Relative difference of (2.64) from the general two-dimensional law at the operating point."""
    sine, cosine = math.sin(IMPACT_ANGLE), math.cos(IMPACT_ANGLE)
    matrix = 3.0 / TOOL.bristle.mass * np.array([[sine * sine, -sine * cosine], [-sine * cosine, cosine * cosine]])
    speed = float(monofilament.tip_speed(TOOL.bristle.length, TOOL.hub.radius, TOOL.hub.speed, SPEED_RATIO))
    law = energetic_impact(matrix, (-speed * sine, speed * cosine), 0.31, 0.42)
    return abs(float(law.impulse_normal / strike(0.31).normal_final_impulse) - 1.0)
