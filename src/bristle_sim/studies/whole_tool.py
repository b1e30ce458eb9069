"""The whole tool: forces of bristles that do not touch each other, on the workpart, the drive and a load cell.

Such bristles are shifted copies of one: with N of them the mean of a force is N omega/(2 pi) times its integral over the
turn that one bristle repeats. The drive's torque is the moment of the forces on the bristle, and in a second way the energy that a turn loses over its angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, rows
from bristle_sim.parameters import Assembly, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.periodic_turn import MAGNIFIED, PeriodicTurn, TurnNotCompleted, periodic_turn
from bristle_sim.studies.strike_point import ran, require_rigid
from bristle_sim.studies.turn_forces import Force, dissipated, load_cell_response, turn_forces

LEAST_TOLERANCE = 1e-6
"""Relative: measured, splines through 150, 300 and 600 samples a period integrate the forces to 1e-6, 6e-8 and 4e-9."""

SAMPLES_PER_PERIOD = 400  # Samples in a period of the bristle on its belt, for the splines
INSTANTS = 2000  # Instants in the period of the summed force from which the band's percentiles are taken
BAND = (5.0, 95.0)  # Percentiles of the force behind the load cell, per cent of the time

UNITS = {
    "impact_rate": ("strikes of all bristles", "1/s"),
    "mean_normal_force": ("mean normal force", "N"),
    "mean_tangential_force": ("mean tangential force", "N"),
    "mean_torque": ("mean torque of the drive", "N m"),
    "mean_hand_torque": ("mean torque on the hand", "N m"),
    "drive_power": ("power of the drive", "W"),
    "force_envelope_low": ("load cell's 5 % percentile", "N"),
    "force_envelope_high": ("load cell's 95 % percentile", "N"),
}


@dataclass(frozen=True, slots=True)
class WholeTool:
    """The tool, its assembly, the turn that a bristle repeats, and the forces on it in each turn that counts."""

    tool: Tool
    assembly: Assembly
    turn: PeriodicTurn
    forces: tuple[tuple[Force, ...], ...]

    @property
    def period(self) -> float:
        """Time from one bristle to the next, s."""
        return 2.0 * math.pi / self.tool.hub.speed / self.assembly.bristles


def whole_tool(tool: Tool, assembly: Assembly, settings: Settings) -> Report:
    """Sum the forces of all bristles, and compare torque and power with the energy that a turn loses.

    Forces are on the workpart: normal into it, tangential in the direction in which the tips travel. The drive's torque
    carries the bar's forces too; the hand that holds hub and bar together bears the workpart's moment alone.

    Raises ValueError if the hub stands still, there is no workpart, the wire bends, or a run is not computed within the
    settings' steps.
    """
    if tool.workpart is None:
        raise ValueError("workpart = None: must be a Workpart, whose forces are requested")
    require_rigid(tool)
    fine = Settings(
        accuracy=settings.accuracy, maximum_steps=settings.maximum_steps, samples_per_period=SAMPLES_PER_PERIOD
    )
    try:
        turn = periodic_turn(tool, fine)
    except TurnNotCompleted as reason:
        return Report(None, rows(UNITS, {}), answer=f"There is no mean force: {reason}.")
    found = WholeTool(tool, assembly, turn, tuple(turn_forces(tool, run) for run in turn.runs))
    last, count = turn.changes[-1], len(turn.changes)
    settled = f"turn {count} repeats the one before, but for {last:.0e} rad"
    if not turn.repeats:
        settled = (
            f"no turn of {count} repeats the one before (the last one differs by {last:.1e} rad):"
            f" means over {len(turn.runs)} turns, without an energy balance"
        )
    quantities = _quantities(found, max(LEAST_TOLERANCE, MAGNIFIED * settings.accuracy))
    value = {each.name: each.simulated or 0.0 for each in quantities}
    answer = (
        f"The hand presses with {value['mean_normal_force']:.3g} N and holds back"
        f" {abs(value['mean_tangential_force']):.3g} N along the workpart and"
        f" {abs(value['mean_hand_torque']):.3g} N m; the drive gives {value['drive_power']:.4g} W; behind"
        f" {assembly.bandwidth:g} Hz a load cell sees {value['force_envelope_low']:.3g} to"
        f" {value['force_envelope_high']:.3g} N for 90 % of the time."
    )
    return Report(
        outcome=None,
        quantities=quantities,
        **ran(turn.runs[-1]),
        remarks=(settled, "theory: the energy that a turn loses"),
        extra={"changes_from_turn_to_turn": list(turn.changes), "repeats": turn.repeats},
        subject=found,
        answer=answer if value["impact_rate"] else "The hand holds against nothing: no bristle touches the workpart.",
    )


def load_cell_series(whole: WholeTool | None) -> dict[str, Array]:
    """Return the normal force that the load cell under the workpart shows, from one bristle to the next.

    Raises ValueError for a tool whose bristle completes no turn.
    """
    if whole is None:
        raise ValueError("whole_tool: the bristle completes no turn, there is no force to show")
    times = whole.period * np.arange(INSTANTS) / INSTANTS
    pushes = [each for turn in whole.forces for each in turn if each.obstacle == "workpart"]
    impacts = [(each.begin, float(each.integral[0])) for each in pushes if not each.course]
    intervals = [
        (each.begin, each.end, lambda at, course=each.course: course(at)[:, 0]) for each in pushes if each.course
    ]
    shown = load_cell_response(impacts, intervals, whole.period, whole.assembly.bandwidth, times)
    return {"time (s)": times, "normal_force (N)": shown / len(whole.forces)}


def _quantities(whole: WholeTool, tolerance: float) -> tuple[Quantity, ...]:
    tool, runs, speed = whole.tool, whole.turn.runs, whole.tool.hub.speed
    turns = whole.assembly.bristles * speed / (2.0 * math.pi)
    rate, forces = turns / len(runs), [each for turn in whole.forces for each in turn]
    pressed = [[each for each in run.contacts if each.obstacle == "workpart"] for run in runs]
    normal, tangential = rate * np.sum([(0.0, 0.0), *(each.impulse for run in pressed for each in run)], axis=0)
    moment = {
        name: float(sum(each.integral[2] for each in forces if each.obstacle == name)) for name in ("workpart", "bar")
    }
    hand = 0.0 - rate * moment["workpart"]
    drive = hand - rate * moment["bar"]
    low, high = np.percentile(load_cell_series(whole)["normal_force (N)"], BAND)
    struck = rate * sum(map(bool, pressed))
    simulated = (struck, normal, 0.0 - tangential, drive, hand, drive * speed, float(low), float(high))
    theory: dict[str, float] = {"impact_rate": turns}
    if whole.turn.repeats:
        power = rate * dissipated(tool, runs[-1])
        theory |= {"mean_torque": power / speed, "drive_power": power}
    within = {"mean_torque": tolerance, "drive_power": tolerance}
    return rows(UNITS, dict(zip(UNITS, simulated, strict=True)), theory, tolerance=within.get)
