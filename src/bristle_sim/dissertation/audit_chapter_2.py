"""Figures of the printed numbers and statements of chapter 2, and of chapters 1, 4 and 5 where they print its quantities (Zhang 2020)."""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from bristle_sim.dissertation.printed import Figure, Figures
from bristle_sim.parameters import PRINTED_BELT_STIFFNESS, RETRACTION_AT_RELEASE, Bar, Belt, operating_point
from bristle_sim.reference import simulate_reference
from bristle_sim.theory import cueing, monofilament
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE

SPEED_RATIO, PRINTED_RATE = 3.23, 845.6
"""R (Zhang 2020, eq. 2.33) and the bristle's rate at the strike, rad/s (fig. 4.2)."""

PRINTED_POSITION = (50.37, 22.5)
"""S_H and S_V, mm (Zhang 2020, eq. 2.3)."""

# The tool and its cue, section 2.2.

tool = operating_point()
bar_radius = Bar().radius
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


def cue_figures() -> Figures:
    """Return the figures of the tool and its cue, section 2.2."""
    return {
        "fig. 1.5: hub speed": Figure(3050 / 60),
        "eq. 2.2: hub speed of 2500 rpm": Figure(2 * math.pi * (2500 / 60)),
        "eq. 2.2: impact angle for a penetration of 4.5 mm": Figure(math.degrees(plain.impact_angle)),
        "fig. 4.2: rate before the impact": Figure(SPEED_RATIO * tool.hub.speed),
        "eq. 4.3: speed of the tip": Figure(monofilament.tip_speed(length, radius, tool.hub.speed, SPEED_RATIO)),
        "fig. 2.7: mass of the bristle": Figure(
            None, 1e5 * (0.25 * math.pi * tool.bristle.wire_diameter**2 * length * 7850)
        ),
        "eq. 2.33: speed ratio R": Figure(
            plain.highest_relative_speed / tool.hub.speed,
            plain.highest_relative_speed,
            stiff.highest_relative_speed,
            cueing.damping_ratio(PRINTED_RATE / stiff.highest_relative_speed),
            simulated_pass().rate,
        ),
        "sec. 2.3.1: the bristle is radial when it strikes": Figure(x := simulated_pass().lag, x, holds=x < 0.05),
        "eq. 2.2: belt stiffness k_T": Figure(
            x := inertia * (PRINTED_RATE / RETRACTION_AT_RELEASE) ** 2,
            math.radians(x),
            math.radians(placed_stiffness),
            math.radians(placed_stiffness - centrifugal),
            math.degrees(cueing.cue(soft).hub_turn),
            math.degrees(cueing.stiffened_cue(soft).hub_turn),
            math.degrees(placed_turn),
        ),
        "fig. 1.5: natural frequency": Figure(
            natural_rate / (2 * math.pi),
            math.radians(filmed_stiffness),
            filmed_stiffness / tool.belt.stiffness,
            254 / (3050 / 60),
        ),
        "eq. 2.3: bar position S_H": Figure(1e3 * plain.bar_horizontal, *bar_places),
        "eq. 2.3: bar position S_V": Figure(1e3 * plain.bar_vertical, *bar_places),
        "sec. 2.2: design forecast within 5 %": Figure(
            x := bar_deviation(plain), x, bar_deviation(stiff), holds=x <= 0.05
        ),
        "eq. 2.2: retraction angle at release": Figure(None, 1e3 * bar_radius),
        "fig. 2.2: the retraction at release is the largest": Figure(
            x := simulated_pass().largest_retraction,
            simulated_pass().release_retraction,
            x,
            holds=abs(x - math.degrees(RETRACTION_AT_RELEASE)) < 0.05,
        ),
        "sec. 2.3: no secondary contact": Figure(
            x := simulated_pass().second_contact, x, 1e3 * math.pi / natural_rate, holds=x == 0
        ),
    }


def impact_figures() -> Figures:
    """Return the figures of the bristle's impact, section 2.3."""
    return {
        "fig. 2.7: p_cy falls with friction": Figure(x := least_step(-p_cy), holds=x > 0),
        "fig. 2.7: p_cy converges to a common value as friction approaches 1": Figure(
            x := np.ptp(p_cy[:, -1]) / np.mean(p_cy[:, -1]),
            x,
            np.ptp(p_cy[:, 0]) / np.mean(p_cy[:, -1]),
            holds=x < 0.01,
        ),
        "fig. 2.8: p_cy is linear in the bristle's length": Figure(
            x := bend(by_length.normal_compressive_impulse), holds=x < 1e-12
        ),
        "fig. 2.9: p_cy is linear in the speed ratio": Figure(
            x := bend(by_ratio.normal_compressive_impulse), holds=x < 1e-12
        ),
        "fig. 2.15: p_cx grows with friction": Figure(x := least_step(-p_cx), holds=x > 0),
        "fig. 2.15: p_cx grows as the impact gets shallower": Figure(x := least_step(p_cx[:, 1:].T), holds=x > 0),
        "sec. 5.1: elevated friction leads to the greatest compressive impulse": Figure(
            x := resultant_impulse(0.42) / resultant_impulse(0),
            1e3 * resultant_impulse(0),
            1e3 * resultant_impulse(0.42),
            holds=x > 1,
        ),
        "fig. 2.10: normal work grows with the impact angle": Figure(x := least_step(normal_work.T), holds=x > 0),
        "fig. 2.10: normal work falls with friction": Figure(x := least_step(-normal_work), holds=x > 0),
        "figs. 2.11, 2.12: normal work grows with length, speed ratio and hub speed": Figure(
            x := min(least_step(-each.normal_compressive_work) for each in (by_length, by_ratio, by_speed)),
            holds=x > 0,
        ),
        "fig. 2.16: tangential work grows with friction": Figure(x := least_step(tangential_work), holds=x > 0),
        "figs. 2.17, 2.18: tangential work grows with length, speed ratio and hub speed": Figure(
            x := min(least_step(-each.tangential_compressive_work) for each in (by_length, by_ratio, by_speed)),
            holds=x > 0,
        ),
        "sec. 2.3.2: tangential work is one order of magnitude greater than normal work": Figure(
            x := abs(operating.tangential_compressive_work / operating.normal_compressive_work),
            x,
            10 * math.tan(IMPACT_ANGLE),
            holds=x >= 10,
        ),
        "fig. 2.19: total work behaves like tangential work over friction": Figure(
            x := np.ptp(total_work) / np.abs(np.mean(total_work)), 1e3 * total_work[0], holds=x > 0.01
        ),
        "fig. 2.13: p_fy grows with friction in restitution": Figure(
            x := least_step(strike(0.31, restitution_friction=BELOW_STICTION).normal_final_impulse), holds=x > 0
        ),
        "fig. 2.14: p_fy falls with friction in compression": Figure(
            x := least_step(-strike(BELOW_STICTION, restitution_friction=0.31).normal_final_impulse), holds=x > 0
        ),
        "fig. 2.22: equal or different friction makes minimal distinction": Figure(
            x := np.max(
                np.abs(
                    strike(restitution_friction=BELOW_STICTION).normal_final_impulse
                    / strike(BELOW_STICTION).normal_final_impulse
                    - 1
                )
            ),
            x,
            holds=x < 0.05,
        ),
        "fig. 2.23: p_fy grows with restitution": Figure(
            x := least_step(strike(0.31, restitution=np.linspace(0, 1, 11)).normal_final_impulse), holds=x > 0
        ),
        "fig. 2.24: the rebound ratio falls with friction": Figure(
            x := least_step(strike(BELOW_STICTION).rebound_ratio), holds=x > 0
        ),
        "eq. 2.51: p_fy is arbitrarily large at mu_2 = tan gamma": Figure(
            x := strike(0.31, restitution_friction=stiction * (1 - 1e-08)).normal_final_impulse
            / operating.normal_final_impulse,
            holds=x > 1000.0,
        ),
        "above eq. 2.51: in our model L = r_h": Figure(x := radius / length, holds=abs(x - 1) < 0.001),
        "fig. 4.15: least friction tan(23.4 deg)": Figure(stiction),
        "fig. 4.14: least friction tan(24 deg)": Figure(math.tan(math.radians(24))),
    }
