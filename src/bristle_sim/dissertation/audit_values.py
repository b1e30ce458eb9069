"""Names that the expressions of ``audit.toml`` use: the printed tool, its cue, strikes over parameters, a simulated pass."""

# ruff: noqa: F401  (what only the table uses)

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from bristle_sim.parameters import PRINTED_BELT_STIFFNESS, RETRACTION_AT_RELEASE, Belt, operating_point
from bristle_sim.reference import simulate_reference
from bristle_sim.theory import crater, cueing, monofilament, pendulums
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
from bristle_sim.theory.force_fit import fit_force_history
from bristle_sim.theory.force_history import (
    BALL,
    BRISTLE,
    PRINTED_BRISTLE_IMPULSE,
    TABLE_3_1,
    ForceCurve,
    segment_impulses,
)
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.merchant import PRINTED_ANGLES, oblique_angles, specific_cutting_energy
from bristle_sim.theory.pendulums import stick_friction

SPEED_RATIO, PRINTED_RATE = 3.23, 845.6
"""R (Zhang 2020, eq. 2.33) and the bristle's rate at the strike, rad/s (fig. 4.2)."""

PRINTED_POSITION = (50.37, 22.5)
"""S_H and S_V, mm (Zhang 2020, eq. 2.3)."""

# The tool and its cue, section 2.2.

tool = operating_point()
mass, length, inertia, radius = tool.bristle.mass, tool.bristle.length, tool.bristle.inertia_about_root, tool.hub.radius
plain, stiff = cueing.cue(tool), cueing.stiffened_cue(tool)
soft = dataclasses.replace(tool, belt=Belt(stiffness=PRINTED_BELT_STIFFNESS))
natural_rate = float(cueing.natural_rate(tool.belt.stiffness, inertia))
centrifugal = float(cueing.centrifugal_stiffness(mass, radius, length, tool.hub.speed))
placed_turn = math.atan2(*PRINTED_POSITION) - plain.tip_lag - plain.impact_angle
placed_stiffness = inertia * (0.5 * math.pi * tool.hub.speed / placed_turn) ** 2
"""Turn of the hub that the printed bar position leaves to the cue, rad, and the belt stiffness that it needs, N m/rad."""

filmed_stiffness = (2.0 * math.pi * 254.0) ** 2 * inertia
bar_places = (
    math.degrees(math.atan2(*PRINTED_POSITION)),
    math.degrees(plain.bar_direction),
    math.degrees(stiff.bar_direction),
    1e3 * stiff.bar_horizontal,
    1e3 * stiff.bar_vertical,
)


def bar_deviation(placed: cueing.Cue) -> float:
    """Return the largest relative deviation of a bar position from the printed one."""
    pairs = zip((placed.bar_horizontal, placed.bar_vertical), PRINTED_POSITION, strict=True)
    return max(abs(1e3 * computed / printed - 1.0) for computed, printed in pairs)


class SimulatedPass(NamedTuple):
    """A pass by the reference: lag at the strike and retractions, largest and at release, deg, relative rate, rad/s, and the
    time from the strike to the next impact on the workpart, ms; 0 where there is none.
    """

    lag: float
    largest_retraction: float
    release_retraction: float
    rate: float
    second_contact: float


@cache
def simulated_pass() -> SimulatedPass:
    """Simulate the pass at the operating point, sampled so that angles are read off to 1e-4 deg."""
    run = simulate_reference(tool, accuracy=1e-9, sample_interval=1e-6)
    hits = [each for each in run.contacts if each.obstacle == "workpart"]
    struck = run.event_time("strike") or 0.0
    released = run.event_time("bar release", last=True, before=struck) or 0.0
    lag = float(np.interp(hits[0].time, run.time, run.hub_angle)) - hits[0].angles[0]
    largest = float(np.min(run.relative_angle[run.time <= struck]))
    release = float(np.interp(released, run.time, run.relative_angle))
    second = 1e3 * (hits[1].time - hits[0].time) if len(hits) > 1 else 0.0
    rate = hits[0].rates_before[0] - run.hub_speed
    return SimulatedPass(math.degrees(lag), -math.degrees(largest), -math.degrees(release), rate, second)


# Impacts, sections 2.3 and 2.4.

BELOW_STICTION = np.linspace(0.0, 0.42, 22)
"""Friction up to just below tan(23.4 deg) = 0.433."""


def strike(friction: Any = None, impact_angle: Any = IMPACT_ANGLE, **other: Any) -> monofilament.MonofilamentImpact:
    """Return the monofilament's impact at the operating point but for what is given, by names of its arguments."""
    workpart = tool.workpart
    assert workpart is not None
    own = {
        "length": length,
        "hub_speed": tool.hub.speed,
        "speed_ratio": SPEED_RATIO,
        "restitution": workpart.restitution,
    }
    mu = workpart.friction if friction is None else friction
    given: dict[str, Any] = {"mass": mass, "hub_radius": radius, "friction": mu, "impact_angle": impact_angle}
    return monofilament.monofilament_impact(**given, **(own | other))


def resultant_impulse(friction: float) -> float:
    """Return p_c = sqrt(p_cx^2 + p_cy^2) at gamma = 23.4 deg, N s (3.1)."""
    hit = strike(friction)
    return float(np.hypot(hit.normal_compressive_impulse, hit.tangential_compressive_impulse))


def bend(values: Any) -> float:
    """Return the largest second difference relative to the range: 0 for a straight line."""
    return float(np.max(np.abs(np.diff(values, 2))) / np.ptp(values))


def least_step(values: Any) -> float:
    """Return the smallest increase from one value to the next along the last axis, relative to the range."""
    return float(np.min(np.diff(values)) / np.ptp(values))


over_angles = strike(np.linspace(0.0, 1.0, 101), np.radians([15.0, 20.0, 25.0, 30.0])[:, np.newaxis])
p_cy, p_cx = over_angles.normal_compressive_impulse, over_angles.tangential_compressive_impulse
normal_work, tangential_work = (
    -each[:, 1:] for each in (over_angles.normal_compressive_work, over_angles.tangential_compressive_work)
)
by_length, by_ratio = strike(length=np.linspace(0.01, 0.05, 9)), strike(speed_ratio=np.linspace(1.0, 5.0, 9))
by_speed = strike(hub_speed=np.linspace(100.0, 400.0, 9))
over_friction = strike(np.linspace(0.0, 1.0, 101))
total_work = over_friction.normal_compressive_work + over_friction.tangential_compressive_work
operating = strike(0.31)
stiction = float(monofilament.stiction_friction(IMPACT_ANGLE))
equal_lengths = float(
    monofilament.normal_final_impulse(mass, length * (tool.hub.speed + PRINTED_RATE), IMPACT_ANGLE, 0.31, 0.42)
)
"""p_fy of a monofilament on a hub of radius L, N s."""


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


# The force history, chapter 3.

BALL_TIME = 2.328e-3
"""t'_c as the dissertation rounds it, s (Zhang 2020, eq. 3.6)."""

IMPULSE_ROUNDING = 0.5e-6 / PRINTED_BRISTLE_IMPULSE
"""Relative rounding of the printed p_c."""

BRISTLE_AMPLITUDE = BRISTLE.amplitude[0]

segments = 1e4 * segment_impulses(BALL, PRINTED_BRISTLE_IMPULSE, compression_time=BALL_TIME)
table_sum = sum(float(each) for each in TABLE_3_1)
rescaled = BALL.rescaled(PRINTED_BRISTLE_IMPULSE, COMPRESSION_TIME)
table_fit = fit_force_history(
    COMPRESSION_TIME / len(TABLE_3_1) * (np.arange(len(TABLE_3_1)) + 0.5),
    1e-4 * np.array(TABLE_3_1, dtype=float) / (COMPRESSION_TIME / len(TABLE_3_1)),
    duration=BRISTLE.duration,
    peak_force=2.0 * BRISTLE.swing,
    start=0.0,
)
"""Fit of (3.3) to the forces of table 3.1, impulse over time at the middle of each segment, with F* = 60 N."""

# The crater, chapter 4.

CUTTING_FRICTIONS, SHALLOW_ANGLES = np.linspace(0.45, 4.0, 60), np.radians(np.linspace(0.0, 23.4, 27))

printed, exact = CraterKinematics(), CraterKinematics.of_tool(tool, PRINTED_RATE)
face, angles = TipFace(), oblique_angles(0.5, IMPACT_ANGLE)
rake, beta, eta = (math.degrees(float(each)) for each in (angles.rake, angles.friction, angles.shear))
reached = 1e6 * float(printed.tip_displacement(COMPRESSION_TIME))
rounded_depth = 1e6 * float(crater.merchant_crater_depth(angles=PRINTED_ANGLES))
exact_energy = energy_coefficients(exact)
lost_energy = 1e3 * float(kinetic_energy(0.0) - kinetic_energy(COMPRESSION_TIME))
stroke = cutting_stroke(
    exact.tip_speed, 2.0 * exact_energy[0] / exact.tip_speed**2, float(specific_cutting_energy(0.5))
)


ply_gaps = crater.merchant_crater_depth_limit() - crater.merchant_crater_depth(plies=[10_000, 100_000])
