"""The whole tool: forces of bristles that do not touch each other, on the workpart, the drive and a load cell.

Such bristles are shifted copies of one: with N of them the mean of a force is N omega/(2 pi) times its integral over the
turn that one bristle repeats. The drive's torque is found from the moments of the forces on the bristle, and, apart from
that, from the energy that a turn loses.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, rows
from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.periodic_turn import PeriodicTurn, TurnNotCompleted, periodic_turn
from bristle_sim.studies.strike_point import ran
from bristle_sim.studies.turn_forces import Impulse, SampledForce, dissipated, load_cell_response, turn_forces
from bristle_sim.units import Declared, count, quantity

LEAST_TOLERANCE = 1e-6
"""Relative: measured, splines through 150, 300 and 600 samples a period integrate the forces to 1e-6, 6e-8 and 4e-9."""

MAGNIFIED = 100.0
"""Errors of the sums over the requested accuracy: a turn adds up those of some ten flights and contacts, each of some ten
times the accuracy."""

SAMPLES_PER_PERIOD = 400
"""Samples in a period of the bristle on its belt, for the splines."""

INSTANTS = 2000
"""Instants in the period of the summed force from which the band's percentiles are taken."""

BAND = (5.0, 95.0)
"""Percentiles of the force behind the load cell, per cent of the time."""

UNITS = {
    "impact_rate": "1/s",
    "mean_normal_force": "N",
    "mean_tangential_force": "N",
    "mean_torque": "N m",
    "mean_hand_torque": "N m",
    "drive_power": "W",
    "force_envelope_low": "N",
    "force_envelope_high": "N",
}


@dataclass(frozen=True, slots=True)
class Assembly(Declared):
    """How many bristles the tool has, and the load cell under the workpart."""

    bristles: int = count(
        42,
        "bristles",
        at_least=1,
        at_most=10_000,
        source="chosen: six staggered rows of seven, which do not touch each other",
        meaning="number of bristles, evenly spaced about the hub",
        usual=None,
    )
    bandwidth: float = quantity(
        1000.0,
        "load_cell_bandwidth",
        "Hz",
        at_least=1e-3,
        at_most=1e5,
        source="chosen: a stiff load cell with a workpart on it",
        meaning="bandwidth of the load cell under the workpart, a low-pass of second order",
    )


@dataclass(frozen=True, slots=True)
class WholeTool:
    """The tool, its assembly, the turn that a bristle repeats, and the forces on it in that turn."""

    tool: Tool
    assembly: Assembly
    turn: PeriodicTurn
    forces: tuple[Impulse | SampledForce, ...]

    @property
    def duration(self) -> float:
        """Length of the turns that count, s."""
        return self.turn.end - self.turn.begin

    @property
    def period(self) -> float:
        """Time from one bristle to the next, s."""
        return 2.0 * math.pi / self.tool.hub.speed / self.assembly.bristles


def whole_tool(tool: Tool, assembly: Assembly, settings: Settings) -> Report:
    """Sum the forces of all bristles, and compare their means with the impulses and with the energy balance.

    Forces are on the workpart: normal into it, tangential in the direction in which the tips travel. The drive's torque
    carries the bar's forces too; the hand that holds hub and bar together bears the workpart's moment alone.

    Raises:
        ValueError: if the hub stands still, there is no workpart, or a run is not computed within the settings' steps.
    """
    if tool.workpart is None:
        raise ValueError("workpart = None: must be a Workpart, whose forces are requested")
    fine = Settings(
        accuracy=settings.accuracy, maximum_steps=settings.maximum_steps, samples_per_period=SAMPLES_PER_PERIOD
    )
    try:
        turn = periodic_turn(tool, fine)
    except TurnNotCompleted as reason:
        return Report(None, rows(UNITS, {}), remarks=(str(reason),))
    found = WholeTool(tool, assembly, turn, tuple(turn_forces(tool, turn)))
    events = ((each.name, each.time - turn.begin) for each in turn.trajectory.events if each.time >= turn.begin)
    return Report(
        outcome=None,
        quantities=_quantities(found, max(LEAST_TOLERANCE, MAGNIFIED * settings.accuracy)),
        **{**ran(turn.trajectory), "events": tuple(events)},
        remarks=_remarks(turn, bends=tool.bristle.links > 1),
        extra={"changes_from_turn_to_turn": list(turn.changes), "repeats": turn.repeats},
        subject=found,
    )


def load_cell_series(whole: WholeTool | None) -> dict[str, Array]:
    """Return the normal force that the load cell under the workpart shows, from one bristle to the next.

    Raises:
        ValueError: for a tool whose bristle completes no turn.
    """
    if whole is None:
        raise ValueError("whole_tool: the bristle completes no turn, there is no force to show")
    times = whole.period * np.arange(INSTANTS) / INSTANTS
    pushes = [each for each in whole.forces if isinstance(each, Impulse) and each.obstacle == "workpart"]
    impacts = [(each.time, float(each.integral[0])) for each in pushes]
    rigid = whole.tool.bristle.links == 1
    intervals = [
        (begin, end, lambda at, course=each.course: course(at)[:, 0])
        for each in whole.forces
        if isinstance(each, SampledForce) and each.obstacle == "workpart"
        # Stick and slip of a wire that bends change its force from one node of the spline to the next.
        for begin, end in itertools.pairwise(each.edges if rigid else [each.begin, *each.course.x[1:]])
    ]
    shown = load_cell_response(impacts, intervals, whole.period, whole.assembly.bandwidth, times)
    return {"time (s)": times, "normal_force (N)": shown / whole.turn.turns}


def _quantities(whole: WholeTool, tolerance: float) -> tuple[Quantity, ...]:
    tool, speed = whole.tool, whole.tool.hub.speed
    rate = whole.assembly.bristles / whole.duration
    means = rate * _integral(whole, "workpart")
    drive = 0.0 - (means[2] + rate * _integral(whole, "bar")[2])
    records = [each for each in whole.turn.contacts if each.obstacle == "workpart"]
    normal, tangential = rate * np.sum([each.impulse for each in records] or [(0.0, 0.0)], axis=0)
    power = None
    if whole.turn.repeats:
        power = rate * dissipated(tool, whole.turn, [edge for each in whole.forces for edge in each.edges])
    low, high = np.percentile(load_cell_series(whole)["normal_force (N)"], BAND)
    struck = len({math.floor((each.time - whole.turn.begin) / whole.duration * whole.turn.turns) for each in records})
    simulated = (rate * struck, means[0], 0.0 - means[1], drive, 0.0 - means[2], drive * speed, float(low), float(high))
    torque = None if power is None else power / speed
    turns = whole.assembly.bristles * speed / (2.0 * math.pi)
    theory = (turns, normal, 0.0 - tangential, torque, None, power, None, None)
    one, other = (dict(zip(UNITS, side, strict=True)) for side in (simulated, theory))
    judged: tuple[str, ...] = ("mean_normal_force", "mean_tangential_force", "mean_torque", "drive_power")
    if tool.bristle.links > 1:
        other, judged = {"impact_rate": turns}, ()
    return rows(UNITS, one, other, tolerance=lambda name: tolerance if name in judged else None)


def _integral(whole: WholeTool, obstacle: str) -> Array:
    """Return normal and tangential impulse, N s, and their moment, N m s, over the turns that count."""
    own = [each.integral for each in whole.forces if each.obstacle == obstacle]
    return np.asarray(np.sum([np.zeros(3), *own], axis=0))


def _remarks(turn: PeriodicTurn, *, bends: bool) -> tuple[str, ...]:
    last, count = turn.changes[-1], len(turn.changes)
    settled = f"turn {count} repeats the one before, but for {last:.0e} rad"
    if not turn.repeats:
        settled = (
            f"no turn of {count} repeats the one before (the last one differs by {last:.1e} rad):"
            f" means over {turn.turns} turns, without an energy balance"
        )
    theory = "theory: impulses' sum for the forces; energy lost in a turn for torque and power"
    if bends:
        theory = "theory: none for a wire that bends, whose forces are scaled to the impulses' sum"
    return settled, theory
