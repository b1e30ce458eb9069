"""Figures for the audit of chapter 2 (Zhang 2020).

The audit of chapters 1, 4 and 5 uses them where these print quantities of chapter 2.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from bristle_sim.dissertation.printed import (
    Figure,
    Figures,
    above,
    grows,
    linear,
    printed_number,
    within,
)
from bristle_sim.parameters import PRINTED_BELT_STIFFNESS, RETRACTION_AT_RELEASE, Bar, Belt, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.theory import cueing, pendulums, two_rods
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.monofilament import (
    MonofilamentImpact,
    monofilament_impact,
    stiction_friction,
    tip_speed,
)

SPEED_RATIO, PRINTED_RATE = (
    printed_number(where)
    for where in ("eq. 2.33: speed ratio R", "fig. 4.2: rate before the impact")
)
PRINTED_POSITION = tuple(printed_number(f"eq. 2.3: bar position {name}") for name in ("S_H", "S_V"))
PRINTED_DIRECTION = math.atan2(*PRINTED_POSITION)

tool = Tool()
mass = tool.bristle.mass
length = tool.bristle.length
inertia = tool.bristle.inertia_about_root
radius = tool.hub.radius
natural_rate = float(cueing.natural_rate(tool.belt.stiffness, inertia))


class SimulatedPass(NamedTuple):
    """Results of the reference pass at the operating point.

    Attributes:
        lag: angle of the bristle behind the hub at the strike, deg.
        largest_retraction: largest retraction before the strike, deg.
        release_retraction: retraction at the release from the bar, deg.
        rate: rate of the bristle relative to the hub at the strike, rad/s.
        second_contact: time from the strike to the next impact on the workpart, ms; 0 if there is
            none.
    """

    lag: float
    largest_retraction: float
    release_retraction: float
    rate: float
    second_contact: float


@cache
def simulated_pass() -> SimulatedPass:
    """Simulate the pass at the operating point, with samples dense enough to read angles to 1e-4
    deg.
    """
    run = simulate_reference(tool, accuracy=1e-9, sample_interval=1e-6)
    hits = [each for each in run.contacts if each.obstacle == "workpart"]
    struck = run.event_time("strike") or 0.0
    released = run.event_time("bar release", last=True, before=struck) or 0.0
    lag = float(np.interp(hits[0].time, run.time, run.hub_angle)) - hits[0].angles[0]
    largest = float(np.min(run.relative_angle[run.time <= struck]))
    release = float(np.interp(released, run.time, run.relative_angle))
    second = 1e3 * (hits[1].time - hits[0].time) if len(hits) > 1 else 0.0
    rate = hits[0].rates_before[0] - run.hub_speed
    return SimulatedPass(
        math.degrees(lag), -math.degrees(largest), -math.degrees(release), rate, second
    )


def damping_ratio(fraction: float) -> float:
    """Return the damping ratio at which the highest speed is a fraction of the undamped one.

    The fraction must be between 1/e and 1.
    """
    return float(
        brentq(
            lambda zeta: cueing.damped_highest_speed(1.0, 1.0, zeta) - fraction,
            0.0,
            1.0,
            xtol=1e-14,
        )
    )


def cue_figures() -> Figures:
    """Return the figures of the tool and its cue, section 2.2."""
    plain = cueing.cue(tool)
    stiff = cueing.stiffened_cue(tool)
    soft = dataclasses.replace(tool, belt=Belt(stiffness=PRINTED_BELT_STIFFNESS))
    centrifugal = cueing.field_stiffness(tool)
    # Turn of the hub from the printed position of the bar to the strike, rad.
    turn = PRINTED_DIRECTION - plain.tip_lag - plain.impact_angle
    placed_stiffness = inertia * (0.5 * math.pi * tool.hub.speed / turn) ** 2
    needed_stiffness = inertia * (PRINTED_RATE / RETRACTION_AT_RELEASE) ** 2
    filmed_stiffness = (2.0 * math.pi * 254.0) ** 2 * inertia
    directions = (
        math.degrees(each) for each in (PRINTED_DIRECTION, plain.bar_direction, stiff.bar_direction)
    )
    places = (*directions, 1e3 * stiff.bar_horizontal, 1e3 * stiff.bar_vertical)
    off, stiff_off = (
        max(abs(1e3 * np.array([each.bar_horizontal, each.bar_vertical]) / PRINTED_POSITION - 1.0))
        for each in (plain, stiff)
    )
    steel = 1e5 * (0.25 * math.pi * tool.bristle.wire_diameter**2 * length * 7850)
    fastest = stiff.highest_relative_speed
    simulated = simulated_pass()
    return {
        "fig. 1.5: hub speed": Figure(3050 / 60),
        "eq. 2.2: hub speed of 2500 rpm": Figure(2 * math.pi * (2500 / 60)),
        "eq. 2.2: impact angle for a penetration of 4.5 mm": Figure(
            math.degrees(plain.impact_angle)
        ),
        "fig. 4.2: rate before the impact": Figure(SPEED_RATIO * tool.hub.speed),
        "eq. 4.3: speed of the tip": Figure(tip_speed(length, radius, tool.hub.speed, SPEED_RATIO)),
        "fig. 2.7: mass of the bristle": Figure(None, steel),
        "eq. 2.33: speed ratio R": Figure(
            plain.highest_relative_speed / tool.hub.speed,
            *(
                plain.highest_relative_speed,
                fastest,
                damping_ratio(PRINTED_RATE / fastest),
                simulated.rate,
            ),
        ),
        "sec. 2.3.1: the bristle is radial when it strikes": within(simulated.lag, 0.05),
        "eq. 2.2: belt stiffness k_T": Figure(
            needed_stiffness,
            *(
                math.radians(each)
                for each in (needed_stiffness, placed_stiffness, placed_stiffness - centrifugal)
            ),
            *(
                math.degrees(each)
                for each in (cueing.cue(soft).hub_turn, cueing.stiffened_cue(soft).hub_turn, turn)
            ),
        ),
        "fig. 1.5: natural frequency": Figure(
            natural_rate / (2 * math.pi),
            *(
                math.radians(filmed_stiffness),
                filmed_stiffness / tool.belt.stiffness,
                254 / (3050 / 60),
            ),
        ),
        "eq. 2.3: bar position S_H": Figure(1e3 * plain.bar_horizontal, *places),
        "eq. 2.3: bar position S_V": Figure(1e3 * plain.bar_vertical, *places),
        "sec. 2.2: design forecast within 5 %": within(off, 0.05, stiff_off),
        "eq. 2.2: retraction angle at release": Figure(None, 1e3 * Bar().radius),
        "fig. 2.2: the retraction at release is the largest": Figure(
            simulated.largest_retraction,
            simulated.release_retraction,
            holds=abs(simulated.largest_retraction - math.degrees(RETRACTION_AT_RELEASE)) < 0.05,
        ),
        "sec. 2.3: no secondary contact": Figure(
            simulated.second_contact,
            1e3 * math.pi / natural_rate,
            holds=simulated.second_contact == 0,
        ),
    }


BELOW_STICTION = np.linspace(0.0, 0.42, 22)
"""Friction up to just below tan(23.4 deg) = 0.433."""


def strike(
    friction: Any = None, impact_angle: Any = IMPACT_ANGLE, **other: Any
) -> MonofilamentImpact:
    """Return the monofilament's impact at the operating point, except for the given arguments."""
    workpart = tool.workpart
    assert workpart is not None
    given: dict[str, Any] = {
        "mass": mass,
        "length": length,
        "hub_radius": radius,
        "hub_speed": tool.hub.speed,
    }
    given |= {
        "speed_ratio": SPEED_RATIO,
        "impact_angle": impact_angle,
        "restitution": workpart.restitution,
    }
    return monofilament_impact(
        **given | {"friction": workpart.friction if friction is None else friction} | other
    )


def resultant_impulse(friction: float) -> float:
    """Return the resultant compressive impulse, N s, at an impact angle of 23.4 deg (eq. 3.1).

    It is p_c = sqrt(p_cx^2 + p_cy^2).
    """
    hit = strike(friction)
    return float(np.hypot(hit.normal_compressive_impulse, hit.tangential_compressive_impulse))


operating = strike(0.31)


def compression_figures() -> Figures:
    """Return the figures of the bristle's compression, section 2.3."""
    over_angles = strike(
        np.linspace(0.0, 1.0, 101), np.radians([15.0, 20.0, 25.0, 30.0])[:, np.newaxis]
    )
    p_cy = over_angles.normal_compressive_impulse
    p_cx = over_angles.tangential_compressive_impulse
    normal, tangential = (
        -over_angles.normal_compressive_work[:, 1:],
        -over_angles.tangential_compressive_work[:, 1:],
    )
    by_length = strike(length=np.linspace(0.01, 0.05, 9))
    by_ratio = strike(speed_ratio=np.linspace(1.0, 5.0, 9))
    sweeps = (by_length, by_ratio, strike(hub_speed=np.linspace(100.0, 400.0, 9)))
    total_work = strike(np.linspace(0.0, 1.0, 101))
    total_work = total_work.normal_compressive_work + total_work.tangential_compressive_work
    work_ratio = abs(operating.tangential_compressive_work / operating.normal_compressive_work)
    smooth = resultant_impulse(0)
    rough = resultant_impulse(0.42)
    spread = np.ptp(p_cy, axis=0) / np.mean(p_cy[:, -1])
    return {
        "fig. 2.7: p_cy falls with friction": grows(-p_cy),
        "fig. 2.7: p_cy converges to a common value as friction approaches 1": within(
            spread[-1], 0.01, spread[0]
        ),
        "fig. 2.8: p_cy is linear in the bristle's length": linear(
            by_length.normal_compressive_impulse
        ),
        "fig. 2.9: p_cy is linear in the speed ratio": linear(by_ratio.normal_compressive_impulse),
        "fig. 2.15: p_cx grows with friction": grows(-p_cx),
        "fig. 2.15: p_cx grows as the impact gets shallower": grows(p_cx[:, 1:].T),
        "sec. 5.1: elevated friction leads to the greatest compressive impulse": above(
            rough / smooth, 1, 1e3 * smooth, 1e3 * rough
        ),
        "fig. 2.10: normal work grows with the impact angle": grows(normal.T),
        "fig. 2.10: normal work falls with friction": grows(-normal),
        "figs. 2.11, 2.12: normal work grows with length, speed ratio and hub speed": grows(
            *(-each.normal_compressive_work for each in sweeps)
        ),
        "fig. 2.16: tangential work grows with friction": grows(tangential),
        "figs. 2.17, 2.18: tangential work grows with length, speed ratio and hub speed": grows(
            *(-each.tangential_compressive_work for each in sweeps)
        ),
        "sec. 2.3.2: tangential work is one order of magnitude greater than normal work": above(
            work_ratio, 10, 10 * math.tan(IMPACT_ANGLE)
        ),
        "fig. 2.19: total work behaves like tangential work over friction": above(
            np.ptp(total_work) / np.abs(np.mean(total_work)), 0.01, 1e3 * total_work[0]
        ),
    }


def restitution_figures() -> Figures:
    """Return the figures of the bristle's restitution, section 2.3.

    The normal final impulse is p_fy.
    """
    stiction = float(stiction_friction(IMPACT_ANGLE))
    nearly_stuck = strike(0.31, restitution_friction=stiction * (1 - 1e-08)).normal_final_impulse
    equal = strike(BELOW_STICTION)
    later = strike(0.31, restitution_friction=BELOW_STICTION).normal_final_impulse
    earlier = strike(BELOW_STICTION, restitution_friction=0.31).normal_final_impulse
    by_restitution = strike(0.31, restitution=np.linspace(0, 1, 11)).normal_final_impulse
    apart = np.max(np.abs(later / equal.normal_final_impulse - 1))
    return {
        "fig. 2.13: p_fy grows with friction in restitution": grows(later),
        "fig. 2.14: p_fy falls with friction in compression": grows(-earlier),
        "fig. 2.22: equal or different friction makes minimal distinction": within(apart, 0.05),
        "fig. 2.23: p_fy grows with restitution": grows(by_restitution),
        "fig. 2.24: the rebound ratio falls with friction": grows(equal.rebound_ratio),
        "eq. 2.51: p_fy is arbitrarily large at mu_2 = tan gamma": above(
            nearly_stuck / operating.normal_final_impulse, 1000
        ),
        "above eq. 2.51: in our model L = r_h": Figure(
            radius / length, holds=abs(radius / length - 1) < 0.001
        ),
        "fig. 4.15: least friction tan(23.4 deg)": Figure(stiction),
        "fig. 4.14: least friction tan(24 deg)": Figure(math.tan(math.radians(24))),
    }


def heavy_rod(mass_ratio: float) -> pendulums.DoublePendulumImpact:
    """Return the impact of the double pendulum of figures 2.28 and 2.29 at a mass ratio."""
    return pendulums.double_pendulum_impact(
        5.0, mass_ratio, 1.0, math.pi / 9.0, math.pi / 6.0, -0.1, -0.2, 0.5, 0.5
    )


def pendulum_figures() -> Figures:
    """Return the figures of Stronge's pendulums, section 2.4.

    They include the general impact law at the operating point.
    """
    angles = np.radians([20.0, 40.0, 60.0, 80.0])
    bristle = monofilament_impact(1.0, 1.0, 0.0, 1.0, 1.0, angles, 0.31, 0.42).rebound_ratio
    stronge = [
        pendulums.single_pendulum_impact(1.0, 1.0, each, -1.0, 0.31, 0.42).rebound_ratio
        for each in angles
    ]
    hub_as_rod = pendulums.double_pendulum_impact(
        *(
            mass,
            700.0,
            length,
            IMPACT_ANGLE,
            IMPACT_ANGLE,
            -tool.hub.speed,
            -PRINTED_RATE,
            0.31,
            0.42,
        )
    ).normal_final_impulse
    equal_lengths = strike(
        0.31, hub_radius=length, speed_ratio=PRINTED_RATE / tool.hub.speed
    ).normal_final_impulse
    apart = hub_as_rod / operating.normal_final_impulse - 1
    lever = np.array([-math.sin(IMPACT_ANGLE), math.cos(IMPACT_ANGLE)])
    speed = tip_speed(length, radius, tool.hub.speed, SPEED_RATIO)
    law = energetic_impact(
        3.0 / mass * np.outer(lever, lever), speed * lever, 0.31, 0.42
    ).impulse_normal
    threshold = two_rods.stick_friction(700, IMPACT_ANGLE, IMPACT_ANGLE)
    fast_rate = heavy_rod(1e4).final_rate_2
    limit_rate = heavy_rod(1e8).final_rate_2
    return {
        "fig. 2.26: the degenerated model is Stronge's pendulum": within(
            np.max(np.abs(bristle - stronge)), 1e-12
        ),
        "fig. 2.28: the rate of rod BC converges as n grows": within(
            abs(fast_rate / limit_rate - 1), 0.001
        ),
        "fig. 2.29: rod OB keeps its rate as n grows": within(
            abs(heavy_rod(1e4).final_rate_1 + 0.1), 0.0001
        ),
        "fig. 2.30: mass m_1 of the heavy rod, 700 times m_2": Figure(700 * mass),
        "fig. 2.30: the double pendulum agrees with the monofilament": within(
            apart, 0.01, abs(apart), abs(hub_as_rod / equal_lengths - 1)
        ),
        "eq. 2.111: the double pendulum's stiction friction is tan gamma": within(
            threshold - math.tan(IMPACT_ANGLE), 1e-12
        ),
        "eq. 2.64: p_fy is what the impact law gives": within(
            abs(law / operating.normal_final_impulse - 1.0), 1e-12
        ),
    }
