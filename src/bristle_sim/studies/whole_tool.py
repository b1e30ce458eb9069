"""The whole tool: forces of all its bristles on the workpart, the drive and a load cell.

The bristles do not touch each other, so their motions are copies of one motion, shifted in time.
With N bristles the mean of a force is N omega/(2 pi) times the time integral of the force on one
bristle over a revolution. The drive's torque is the moment of the forces on the bristles. The
energy dissipated in a revolution, divided by 2 pi, must give the same torque.

In sustained contact with an obstacle the bristle's angle depends on the hub's angle alone, and not
on earlier motion. All revolutions after the first sustained contact are therefore the same, with or
without damping of the belt. A bristle that rebounds from every obstacle need not repeat its motion.
"""

import dataclasses
import itertools
import math
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, rows
from bristle_sim.parameters import Assembly, Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings, StopReason
from bristle_sim.studies.turn_forces import Force, dissipated, load_cell_response, turn_forces
from bristle_sim.studies.whole_pass import require_result, require_rigid, run_fields
from bristle_sim.theory.cueing import field_stiffness
from bristle_sim.trajectory import Trajectory

# Largest number of simulated revolutions. In flight the amplitude of the bristle decays by the
# factor exp(-2 pi zeta) in a period, with the damping ratio zeta of the belt.
MOST_TURNS = 24
# Largest change of the bristle's state over a revolution, rad, at which the revolution counts as
# repeating the preceding one. The state is the bristle's angle relative to the hub, and its angular
# velocity divided by its natural angular frequency.
REPEATED = 1e-9
# Error of a revolution, divided by the requested accuracy. A revolution has about ten flights and
# contacts, each with an error of ten times the accuracy.
MAGNIFIED = 100.0
# Smallest relative tolerance. Splines through 150, 300 and 600 samples a period integrate the
# forces with measured errors of 1e-6, 6e-8 and 4e-9.
LEAST_TOLERANCE = 1e-6
SAMPLES_PER_PERIOD = (
    400  # number of samples in a period of the bristle on its belt, for the splines
)
# Number of instants between two bristles' strikes at which the load cell's force is computed
INSTANTS = 2000
BAND = (5.0, 95.0)  # percentiles over time of the load cell's force that are reported

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


class TurnNotCompleted(ValueError):
    """Raised if a bristle jams, or lies down on the hub, before the hub completes a revolution.

    The message states the instant and the reason.
    """


@dataclass(frozen=True, slots=True)
class PeriodicTurn:
    """The revolutions over which forces are averaged.

    Attributes:
        runs: motion in the last revolution, if it repeats the preceding one; otherwise motions in
            the second half of all revolutions. Each revolution starts from the final state of the
            preceding one.
        changes: change of the bristle's state in each simulated revolution, rad. The first
            revolution starts with the bristle radial and at rest relative to the hub.
        repeats: whether the last revolution repeats the preceding one.
    """

    runs: tuple[Trajectory, ...]
    changes: tuple[float, ...]
    repeats: bool


def periodic_turn(tool: Tool, settings: Settings) -> PeriodicTurn:
    """Simulate revolutions of the hub until one repeats the preceding one.

    ``settings.hub_turn`` is ignored. The number of revolutions is limited to MOST_TURNS.

    Raises:
        TurnNotCompleted: if the bristle jams or lies down on the hub.
        ValueError: if the hub is at rest, or a run exceeds the step budget.
    """
    if not tool.hub.speed:
        raise ValueError("hub_speed = 0: must be above 0, or the hub makes no turn (in rad/s)")
    least = max(REPEATED, MAGNIFIED * settings.accuracy)
    stiffness = tool.belt.stiffness + field_stiffness(tool)
    natural_rate = max(math.sqrt(stiffness / tool.bristle.inertia_about_root), tool.hub.speed)
    settings = dataclasses.replace(settings, hub_turn=2.0 * math.pi)
    runs = list[Trajectory]()
    changes = list[float]()
    angle = 0.0
    rate = 0.0
    while len(runs) < MOST_TURNS:
        run = simulate(tool, settings, start_relative_angle=angle, start_relative_rate=rate)
        require_result(run, settings)
        if run.stop_reason is not StopReason.END:
            after = "" if not runs else f" of turn {len(runs) + 1}"
            raise TurnNotCompleted(
                f"the bristle completes no turn: {run.stop_reason} at {1e3 * run.time[-1]:.4f} ms{after}, after"
                f" {math.degrees(run.hub_speed * run.time[-1]):.0f} deg of the hub's turn"
            )
        after_turn = float(run.relative_angle[-1]), float(run.relative_rate[-1])
        changes.append(max(abs(after_turn[0] - angle), abs(after_turn[1] - rate) / natural_rate))
        runs.append(run)
        angle, rate = after_turn
        if changes[-1] <= least:
            return PeriodicTurn((run,), tuple(changes), repeats=True)
    return PeriodicTurn(tuple(runs[MOST_TURNS // 2 :]), tuple(changes), repeats=False)


@dataclass(frozen=True, slots=True)
class WholeTool:
    """Results of the study of the whole tool.

    Attributes:
        tool: the tool with a single bristle.
        assembly: number of bristles, and bandwidth of the load cell.
        turn: the revolutions over which forces are averaged.
        forces: forces on the single bristle in each of these revolutions.
    """

    tool: Tool
    assembly: Assembly
    turn: PeriodicTurn
    forces: tuple[tuple[Force, ...], ...]

    @property
    def period(self) -> float:
        """Time between the strikes of consecutive bristles, s."""
        return 2.0 * math.pi / self.tool.hub.speed / self.assembly.bristles


def whole_tool(tool: Tool, assembly: Assembly, settings: Settings) -> Report:
    """Sum the forces of all bristles, and compare the drive's power with the dissipated energy.

    ``assembly`` holds the number of bristles, and the bandwidth of the load cell under the
    workpart. The reported forces act on the workpart: the normal force into it, the tangential
    force in the direction in which the tips travel. The drive's torque includes the forces of the
    bar. The hand holds hub and bar together, so the torque on the hand is the moment of the
    workpart's forces alone.

    Raises:
        ValueError: if the hub is at rest, there is no workpart, the wire bends, or a run exceeds
            the step budget.
    """
    if tool.workpart is None:
        raise ValueError("workpart = None: must be a Workpart, whose forces are requested")
    require_rigid(tool)
    fine = Settings(
        accuracy=settings.accuracy,
        maximum_steps=settings.maximum_steps,
        samples_per_period=SAMPLES_PER_PERIOD,
    )
    try:
        turn = periodic_turn(tool, fine)
    except TurnNotCompleted as reason:
        return Report(None, rows(UNITS, {}), answer=f"There is no mean force: {reason}.")
    found = WholeTool(tool, assembly, turn, tuple(turn_forces(tool, run) for run in turn.runs))
    last = turn.changes[-1]
    count = len(turn.changes)
    settled = f"Turn {count} repeats the one before, to within {last:.0e} rad."
    if not turn.repeats:
        settled = (
            f"no turn of {count} repeats the one before (the last one differs by {last:.1e} rad);"
            f" means over {len(turn.runs)} turns, without an energy balance"
        )
    quantities = _quantities(found, max(LEAST_TOLERANCE, MAGNIFIED * settings.accuracy))
    value = {each.name: each.simulated or 0.0 for each in quantities}
    answer = (
        f"The hand presses with {value['mean_normal_force']:.3g} N and bears"
        f" {abs(value['mean_tangential_force']):.3g} N along the workpart and"
        f" a torque of {abs(value['mean_hand_torque']):.3g} N m; the drive gives {value['drive_power']:.4g} W; a load cell"
        f" with a bandwidth of {assembly.bandwidth:g} Hz shows {value['force_envelope_low']:.3g} to"
        f" {value['force_envelope_high']:.3g} N for 90 % of the time."
    )
    return Report(
        quantities=quantities,
        **run_fields(turn.runs[-1]),
        remarks=(settled, "theory: the energy that a turn loses"),
        extra={"changes_from_turn_to_turn": list(turn.changes), "repeats": turn.repeats},
        subject=found,
        answer=answer
        if value["impact_rate"]
        else "The hand bears no force: no bristle touches the workpart.",
    )


def load_cell_series(whole: WholeTool | None) -> dict[str, Array]:
    """Return time and normal force of a load cell under the workpart, as columns by name.

    The columns cover the time between the strikes of two consecutive bristles.

    Raises:
        ValueError: if the bristle completes no revolution.
    """
    if whole is None:
        raise ValueError("whole_tool: the bristle completes no turn, so there is no force to show")
    times = whole.period * np.arange(INSTANTS) / INSTANTS
    pushes = [each for turn in whole.forces for each in turn if each.obstacle == "workpart"]
    shown = load_cell_response(pushes, whole.period, whole.assembly.bandwidth, times)
    return {"time (s)": times, "normal_force (N)": shown / len(whole.forces)}


def _quantities(whole: WholeTool, tolerance: float) -> tuple[Quantity, ...]:
    tool = whole.tool
    runs = whole.turn.runs
    speed = whole.tool.hub.speed
    turns = whole.assembly.bristles * speed / (2.0 * math.pi)
    rate = turns / len(runs)
    pushed = {obstacle: np.zeros(3) for obstacle in ("workpart", "bar")}
    for each in itertools.chain(*whole.forces):
        pushed[each.obstacle] += rate * each.integral
    normal, tangential, hand = pushed["workpart"].tolist()
    drive = 0.0 - hand - pushed["bar"][2]
    struck = rate * sum(run.first_contact("workpart") is not None for run in runs)
    low, high = np.percentile(load_cell_series(whole)["normal_force (N)"], BAND)
    # 0.0 - x: no force is shown as 0, not as -0
    simulated = (struck, normal, 0.0 - tangential, drive, 0.0 - hand, drive * speed, low, high)
    theory: dict[str, float] = {"impact_rate": turns}
    if whole.turn.repeats:
        power = rate * dissipated(tool, runs[-1])
        theory |= {"mean_torque": power / speed, "drive_power": power}
    within = {"mean_torque": tolerance, "drive_power": tolerance}
    return rows(UNITS, dict(zip(UNITS, simulated, strict=True)), theory, tolerances=within)
