"""How well the quasi-static cue formulas place the bar: release from rest, simulated, beside them.

The formulas let an undamped belt swing the bristle a quarter period while the hub turns. They leave out the rotating
root's centrifugal stiffening and everything the bar does: the tap of first touch, the swing that goes on after the last
touch. The first is in the simulation here; the second is what the whole pass shows.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import PRINTED_BELT_STIFFNESS, Bar, Belt, Bristle, Hub, Tool
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.whole_pass import require_result
from bristle_sim.theory import cueing
from bristle_sim.trajectory import Trajectory

__all__ = ["CueTiming", "cue_timing", "stiffness_readings", "unplaced"]

PRINTED_DIRECTION = math.degrees(math.atan2(0.05037, 0.0225))
"""A + theta_1 + gamma of the printed bar position, deg (Zhang 2020, eq. 2.3)."""

WITHIN = math.radians(2.0)
"""A bar within this of where a reading needs it can be cued there: the tip's speed is then within 0.5 % of its highest."""

UNITS = {
    "cue_time": "s",
    "cue_hub_turn_deg": "deg",
    "highest_relative_speed": "rad/s",
    "bar_direction_deg": "deg",
    "bar_horizontal": "m",
    "bar_vertical": "m",
}
PRINTED = {
    "highest_relative_speed": 845.6,
    "bar_direction_deg": PRINTED_DIRECTION,
    "bar_horizontal": 0.05037,
    "bar_vertical": 0.0225,
}


@dataclass(frozen=True, slots=True)
class CueTiming:
    """A simulated release with the tool and retraction it belongs to."""

    tool: Tool
    retraction: float
    trajectory: Trajectory


def stiffness_readings(tool: Tool) -> dict[str, float]:
    """The readings of the printed "0.00041 N m/rad", and the stiffness of the bristle filmed at 254 Hz, N m/rad."""
    filmed = tool.bristle.inertia_about_root * (2.0 * math.pi * 254.0) ** 2
    return {
        "per_radian": PRINTED_BELT_STIFFNESS,
        "per_degree": math.degrees(PRINTED_BELT_STIFFNESS),
        "from_254_hz": filmed,
    }


def unplaced(bar: Bar, hub: Hub, bristle: Bristle) -> Bar:
    """A bar of the same radius out of everybody's way, for a question whose answer is the bar's place."""
    away = hub.radius + 2.0 * (bristle.length + bristle.wire_diameter + bar.radius)
    return dataclasses.replace(bar, horizontal=min(away, 1e3), vertical=0.0)


def cue_timing(
    tool: Tool,
    retraction: float,
    settings: Settings,
    *,
    stands_at: float = PRINTED_DIRECTION,
    with_reference: bool = True,
) -> Report:
    """Simulate the release from rest at a retraction (rad) and place the bar by what came out.

    ``stands_at`` is the direction (deg) of the bar that the readings of the belt stiffness are tried on.

    Raises:
        ValueError: if nothing drives the bristle, the tip cannot reach the workpart radially, or the release is not
            computed within the settings' steps.
    """
    trajectory = _release(tool, retraction, settings)
    simulated = _placed(tool, retraction, trajectory)
    theory = _formulas(tool, retraction)
    reference: dict[str, float | None] = {}
    if with_reference and simulated["cue_time"] is not None:
        from bristle_sim.reference import simulate_reference

        referred = simulate_reference(
            _bare(tool),
            start_relative_angle=-retraction,
            accuracy=1e-10,
            duration=2.0 * simulated["cue_time"],
            stop_after="highest relative speed",
        )
        reference = _placed(tool, retraction, referred)
    tolerance = _tolerance(settings) if reference else None
    default = Tool()
    parts = (tool.hub, tool.belt, tool.bristle, tool.workpart)
    at_print = parts == (default.hub, default.belt, default.bristle, default.workpart) and retraction == math.radians(
        44.5
    )
    rows = []
    for name, unit in UNITS.items():
        judged, printed = reference.get(name), PRINTED.get(name) if at_print else None
        allowed = None if tolerance is None or judged is None else tolerance * _conditioning(name, reference, tool)
        rows.append(Quantity(name, unit, simulated[name], theory[name], judged, printed, allowed))
    readings, verdicts = _readings(tool, retraction, settings, stands_at)
    return Report(
        outcome=None,
        quantities=(*rows, *readings),
        events=tuple((event.name, event.time) for event in trajectory.events),
        wall_s=trajectory.cost.wall_s,
        steps=trajectory.cost.steps,
        remarks=(*verdicts, *LEFT_OUT),
        extra={"bar_stands_at_deg": stands_at},
        subject=CueTiming(tool, retraction, trajectory),
    )


FULL_TURNS = 1e3
"""Hub turns after which a bristle that is still accelerating is given up: only an extremely soft belt takes as long."""

LEFT_OUT = (
    "left out by the formulas: centrifugal stiffening of the rotating root, belt damping beyond the linear oscillator,",
    "and the bar's dynamics (first tap, swing beyond the last touch), which scenarios/cue_and_impact.py simulates.",
)


def _conditioning(name: str, values: dict[str, float | None], tool: Tool) -> float:
    """By how much a quantity magnifies a relative error of the motion.

    Highest is the rate where the torques of belt and damping balance, and they leave it as alpha''' = -(K/I) alpha': an
    error delta of the rate, relative, moves that instant t by c delta/K, which is c/(K t) times delta of it. A coordinate
    of the bar magnifies what turns the bar, some delta of its direction, by the other coordinate over this one.
    """
    time = values["cue_time"]
    if name == "highest_relative_speed" or not time:
        return 1.0
    bristle, hub = tool.bristle, tool.hub
    field = cueing.centrifugal_stiffness(bristle.mass, hub.radius, bristle.length, hub.speed)
    timing = max(1.0, tool.belt_damping / ((tool.belt.stiffness + float(field)) * time))
    if name not in ("bar_horizontal", "bar_vertical"):
        return timing
    pair = (values["bar_horizontal"] or 0.0, values["bar_vertical"] or 0.0)
    turned = max(1.0, math.radians(values["bar_direction_deg"] or 0.0))
    return timing * turned * math.hypot(*pair) / max(abs(values[name] or 0.0), 1e-300)


def _bare(tool: Tool) -> Tool:
    """The tool without the bar and the workpart that it must have."""
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: a tool that has both is allowed")
    return dataclasses.replace(tool, bar=None, workpart=None)


def _release(tool: Tool, retraction: float, settings: Settings) -> Trajectory:
    turning = dataclasses.replace(settings, hub_turn=FULL_TURNS * 2.0 * math.pi)
    run = simulate(_bare(tool), turning, start_relative_angle=-retraction, stop_after="highest relative speed")
    require_result(run, settings)
    estimate, allowed = run.cost.error_estimate, _tolerance(settings)
    if estimate is not None and estimate > allowed:
        raise ValueError(
            f"accuracy = {settings.accuracy:g}: at least {0.1 * estimate:.2g} is allowed for this release, in whose"
            f" {math.degrees(tool.hub.speed * run.time[-1]):.3g} deg of hub turn errors of {estimate:.2g} add up"
            " (dimensionless)"
        )
    return run


def _tolerance(settings: Settings) -> float:
    """Relative difference from the reference that a release may have."""
    return max(1e-8, 10.0 * settings.accuracy)


def _placed(tool: Tool, retraction: float, run: Trajectory) -> dict[str, float | None]:
    """Cue time and speed of a run, and the bar position that follows from them (Zhang 2020, eq. 2.1)."""
    time = run.event_time("highest relative speed")
    if time is None or tool.workpart is None:
        return dict.fromkeys(UNITS)
    geometry = (tool.hub.radius, tool.bristle.length)
    turn = tool.hub.speed * time
    direction = (
        float(cueing.tip_lag(*geometry, retraction))
        + turn
        + float(cueing.impact_angle(*geometry, tool.workpart.penetration))
    )
    distance = cueing.bar_distance(tool.bar_reach, cueing.tip_radius(*geometry, retraction))
    horizontal, vertical = cueing.bar_position(distance, direction)
    speed = float(run.relative_rate[int(abs(run.time - time).argmin())])
    values = (time, math.degrees(turn), speed, math.degrees(direction), float(horizontal), float(vertical))
    return dict(zip(UNITS, values, strict=True))


def _formulas(tool: Tool, retraction: float) -> dict[str, float | None]:
    if not tool.belt.stiffness:
        return dict.fromkeys(UNITS)
    cue = cueing.cue(tool, retraction)
    values = (
        cue.cue_time,
        math.degrees(cue.hub_turn),
        cue.highest_relative_speed,
        math.degrees(cue.bar_direction),
        cue.bar_horizontal,
        cue.bar_vertical,
    )
    return dict(zip(UNITS, values, strict=True))


def _readings(tool: Tool, retraction: float, settings: Settings, stands_at: float) -> tuple[list[Quantity], list[str]]:
    """Cue time and bar direction for every reading of the printed stiffness, and which one the printed bar can cue."""
    rows, verdicts = [], []
    for reading, stiffness in stiffness_readings(tool).items():
        belt = Belt(stiffness, tool.belt.damping_ratio)
        read = dataclasses.replace(tool, belt=belt)
        simulated, theory = _placed(tool, retraction, _release(read, retraction, settings)), _formulas(read, retraction)
        for name in ("cue_time", "bar_direction_deg"):
            rows.append(
                Quantity(f"{name}_{reading}", UNITS[name], simulated[name], theory[name], printed=PRINTED.get(name))
            )
        verdicts.append(_verdict(reading, stiffness, simulated["bar_direction_deg"], stands_at))
    return rows, verdicts


def _verdict(reading: str, stiffness: float, direction: float | None, stands_at: float) -> str:
    words = f"belt stiffness {reading.replace('_', ' ')} ({stiffness:.5g} N m/rad): "
    if direction is None:
        return words + "never reaches a highest speed; cannot be cued by any bar"
    off = direction - stands_at
    can = "can" if abs(math.radians(off)) <= WITHIN else "cannot"
    return (
        f"{words}bar needed at {direction:.2f} deg, {off:+.2f} deg from where it stands ({stands_at:.2f} deg);"
        f" {can} be cued there"
    )
