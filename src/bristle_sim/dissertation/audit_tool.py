"""Audit of the tool and its cue (Zhang 2020, fig. 1.5 and section 2.2), computed and simulated."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np

from bristle_sim.dissertation.audit_row import Found
from bristle_sim.parameters import PRINTED_BELT_STIFFNESS, RETRACTION_AT_RELEASE, Belt, Tool, operating_point
from bristle_sim.reference import simulate_reference
from bristle_sim.theory import cueing, monofilament
from bristle_sim.trajectory import Trajectory

SPEED_RATIO = 3.23
"""R (Zhang 2020, eq. 2.33)."""

PRINTED_RATE = 845.6
"""Rate of the bristle at the strike, rad/s (Zhang 2020, fig. 4.2)."""

PRINTED_POSITION = (50.37, 22.5)
"""S_H and S_V, mm (Zhang 2020, eq. 2.3)."""

FIGURE_1_5 = (3050.0, 254.0)
"""Hub speed in rpm and natural frequency in Hz of the film (Zhang 2020, fig. 1.5)."""


SAMPLES = 1e-6
"""Time between samples of the simulated pass, s: angles between them are read off to 1e-4 deg."""


def tool_figures() -> dict[str, Found]:
    """Figures of figure 1.5 and section 2.2."""
    tool = operating_point()
    return {**_speeds(tool), **_speed_ratio(tool), **_belt(tool), **_position(tool), **_passes(tool)}


def turns_per_second(revolutions_per_minute: float) -> float:
    """Cycles per second of a speed in revolutions per minute."""
    return revolutions_per_minute / 60.0


def angular_speed(revolutions_per_minute: float) -> float:
    """rad/s of a speed in revolutions per minute."""
    return 2.0 * math.pi * turns_per_second(revolutions_per_minute)


def rate_before_impact(tool: Tool) -> float:
    """R times the hub's speed (2.33), rad/s."""
    return SPEED_RATIO * tool.hub.speed


def wire_mass(tool: Tool, density: float = 7850.0) -> float:
    """Mass of a straight wire of the bristle's length and diameter, kg; density of steel in kg/m^3."""
    return 0.25 * math.pi * tool.bristle.wire_diameter**2 * tool.bristle.length * density


def stiffness_for_speed(tool: Tool, speed: float) -> float:
    """Belt stiffness with which theta_p sqrt(k/I) is the speed (rad/s), N m/rad."""
    return tool.bristle.inertia_about_root * (speed / RETRACTION_AT_RELEASE) ** 2


def stiffness_for_position(tool: Tool) -> float:
    """Belt stiffness with which (2.1) gives the direction of the printed bar position, N m/rad."""
    placed = cueing.cue(tool)
    turn = math.atan2(*PRINTED_POSITION) - placed.tip_lag - placed.impact_angle
    return tool.bristle.inertia_about_root * (0.5 * math.pi * tool.hub.speed / turn) ** 2


def bar_deviation(placed: cueing.Cue) -> float:
    """Largest relative deviation of a bar position from the printed one."""
    pairs = zip((placed.bar_horizontal, placed.bar_vertical), PRINTED_POSITION, strict=True)
    return max(abs(1e3 * computed / printed - 1.0) for computed, printed in pairs)


@cache
def simulated_pass() -> Trajectory:
    """The whole pass at the operating point, undamped, from the independent reference."""
    return simulate_reference(operating_point(), accuracy=1e-9, sample_interval=SAMPLES)


def simulated_strike() -> tuple[float, float]:
    """How far short of radial the bristle is when it strikes, deg, and its speed relative to the hub, rad/s."""
    run = simulated_pass()
    strike = run.first_contact("workpart")
    assert strike is not None
    lag = float(np.interp(strike.time, run.time, run.hub_angle)) - strike.angles[0]
    return math.degrees(lag), strike.rates_before[0] - run.hub_speed


def simulated_retraction() -> float:
    """Largest retraction before the strike, deg."""
    run = simulated_pass()
    before = run.time <= (run.event_time("strike") or 0.0)
    return -math.degrees(float(np.min(run.relative_angle[before])))


def simulated_second_contact() -> float:
    """Time from the strike to the next impact on the workpart, ms; 0 where there is none."""
    times = [each.time for each in simulated_pass().contacts if each.obstacle == "workpart"]
    return 1e3 * (times[1] - times[0]) if len(times) > 1 else 0.0


def _speeds(tool: Tool) -> dict[str, Found]:
    placed = cueing.cue(tool)
    return {
        "fig. 1.5: hub speed": Found(turns_per_second(FIGURE_1_5[0])),
        "eq. 2.2: hub speed of 2500 rpm": Found(angular_speed(2500.0)),
        "eq. 2.2: impact angle for a penetration of 4.5 mm": Found(math.degrees(placed.impact_angle)),
        "fig. 4.2: rate before the impact": Found(rate_before_impact(tool)),
        "eq. 4.3: speed of the tip": Found(
            float(monofilament.tip_speed(tool.bristle.length, tool.hub.radius, tool.hub.speed, SPEED_RATIO))
        ),
        "fig. 2.7: mass of the bristle": Found(None, told=(1e5 * wire_mass(tool),)),
    }


def _speed_ratio(tool: Tool) -> dict[str, Found]:
    placed = cueing.cue(tool)
    fast = cueing.stiffened_cue(tool)
    ratio = placed.highest_relative_speed / tool.hub.speed
    lag, simulated = simulated_strike()
    damping = float(cueing.damping_ratio(PRINTED_RATE / fast.highest_relative_speed))
    return {
        "eq. 2.33: speed ratio R": Found(
            ratio, told=(placed.highest_relative_speed, fast.highest_relative_speed, damping, simulated)
        ),
        "sec. 2.3.1: the bristle is radial when it strikes": Found(lag, lag < 0.05, (lag,)),
    }


def _belt(tool: Tool) -> dict[str, Found]:
    inertia = tool.bristle.inertia_about_root
    needed, placed = stiffness_for_speed(tool, PRINTED_RATE), stiffness_for_position(tool)
    g = float(cueing.centrifugal_stiffness(tool.bristle.mass, tool.hub.radius, tool.bristle.length, tool.hub.speed))
    soft = replace(tool, belt=Belt(stiffness=PRINTED_BELT_STIFFNESS))
    turns = [math.degrees(each(soft).hub_turn) for each in (cueing.cue, cueing.stiffened_cue)]
    plain = cueing.cue(tool)
    room = math.degrees(math.atan2(*PRINTED_POSITION) - plain.tip_lag - plain.impact_angle)
    frequency = float(cueing.natural_rate(tool.belt.stiffness, inertia)) / (2.0 * math.pi)
    rpm, other = FIGURE_1_5
    film = (2.0 * math.pi * other) ** 2 * inertia
    return {
        "eq. 2.2: belt stiffness k_T": Found(
            needed,
            told=(math.radians(needed), math.radians(placed), math.radians(placed - g), turns[0], turns[1], room),
        ),
        "fig. 1.5: natural frequency": Found(
            frequency, told=(math.radians(film), film / tool.belt.stiffness, other / turns_per_second(rpm))
        ),
    }


def _position(tool: Tool) -> dict[str, Found]:
    plain, stiff = cueing.cue(tool), cueing.stiffened_cue(tool)
    direction = math.degrees(math.atan2(*PRINTED_POSITION))
    horizontal, vertical = 1e3 * plain.bar_horizontal, 1e3 * plain.bar_vertical
    largest, stiffened = bar_deviation(plain), bar_deviation(stiff)
    return {
        "eq. 2.3: bar position S_H": Found(
            horizontal,
            told=(
                direction,
                math.degrees(plain.bar_direction),
                math.degrees(stiff.bar_direction),
                1e3 * stiff.bar_horizontal,
                1e3 * stiff.bar_vertical,
            ),
        ),
        "eq. 2.3: bar position S_V": Found(
            vertical,
            told=(
                direction,
                math.degrees(plain.bar_direction),
                math.degrees(stiff.bar_direction),
                1e3 * stiff.bar_horizontal,
                1e3 * stiff.bar_vertical,
            ),
        ),
        "sec. 2.2: design forecast within 5 %": Found(largest, largest <= 0.05, (largest, stiffened)),
        "eq. 2.2: retraction angle at release": Found(None, told=(1e3 * (tool.bar.radius if tool.bar else math.nan),)),
    }


def _passes(tool: Tool) -> dict[str, Found]:
    largest, delay = simulated_retraction(), simulated_second_contact()
    stiffness = float(cueing.natural_rate(tool.belt.stiffness, tool.bristle.inertia_about_root))
    return {
        "fig. 2.2: the retraction at release is the largest": Found(
            largest, abs(largest - math.degrees(RETRACTION_AT_RELEASE)) < 0.05, (_release_retraction(), largest)
        ),
        "sec. 2.3: no secondary contact": Found(delay, delay == 0.0, (delay, 1e3 * math.pi / stiffness)),
    }


def _release_retraction() -> float:
    run = simulated_pass()
    released = run.event_time("bar release", last=True, before=run.event_time("strike") or math.inf)
    assert released is not None
    return -math.degrees(float(np.interp(released, run.time, run.relative_angle)))
