"""Neighbouring bristles in one plane: the least pitches at which their wires do not touch, and the
effect of a touch on the strike.

Rows of bristles are simulated together and compared with the motion of a lone bristle.
"""

import contextlib
import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, Table, Values, rows
from bristle_sim.parameters import Neighbours, Tool
from bristle_sim.readable import amount
from bristle_sim.scene.simulate import simulate, simulate_row
from bristle_sim.settings import Settings, StopReason
from bristle_sim.studies.least_pitch import LeastPitch, least_pitches_of, unsearched
from bristle_sim.studies.strike_measures import IMPACT, STATE, outcome_fields
from bristle_sim.studies.whole_pass import (
    measures_of,
    reference_accuracy,
    require_result,
    require_rigid,
    run_fields,
)
from bristle_sim.trajectory import Trajectory

WIRE_TOUCH = "wire touch"

# Largest difference of simulated and theoretical least pitch, deg. The least pitch of simulated
# rows is searched by bisection within this distance of the theoretical one.
AGREEMENT = 0.05
RESOLUTION = 0.005  # largest width of the interval at which the bisection ends, deg
# Number of samples in a period of the lone bristle on its belt. The centre line is interpolated
# between the samples.
SAMPLES_PER_PERIOD = 150

UNCHANGED = (
    1e-3  # relative change of the impulse below which its three printed digits stay the same
)

STRIKE = {
    name: STATE.get(name) or IMPACT[name]
    for name in ("lag_deg_at_contact", "relative_speed_at_contact", "normal_final_impulse")
}
"""Quantities of a bristle's strike: label and unit."""

LEAST_PITCHES = {
    "least_pitch_to_strike_deg": "least pitch, no touch until the one in front strikes",
    "least_pitch_to_own_strike_deg": "least pitch, no touch until its own strike",
    "least_pitch_whole_pass_deg": "least pitch, no touch in the whole pass",
}


@dataclass(frozen=True, slots=True)
class NeighbourRow:
    """A simulated row of bristles, and the pass of a lone bristle.

    Attributes:
        tool: the tool.
        neighbours: parameters of the row.
        settings: accuracy and limits of the simulations.
        bristles: motions of the bristles, the foremost first.
        lone: motion of the lone bristle.
        least: theoretical least angles between bristles.
    """

    tool: Tool
    neighbours: Neighbours
    settings: Settings
    bristles: tuple[Trajectory, ...]
    lone: Trajectory
    least: tuple[LeastPitch, ...]

    @property
    def touches(self) -> list[float]:
        """Instants at which two wires of the row begin to touch (s), in ascending order."""
        return sorted({time for run in self.bristles for time in _touches(run)})


def neighbours(
    tool: Tool, row: Neighbours, settings: Settings, *, with_reference: bool = False
) -> Report:
    """Find the least pitches, by theory and by simulation, and simulate one row of bristles.

    The pitch is the angle between the roots of neighbouring bristles. At pitches below the least
    pitch, neighbours touch each other. The simulated row has the pitch that ``row`` requests.

    Args:
        tool: the tool.
        row: number of bristles, pitch, and friction and restitution between wires.
        settings: settings of the simulations.
        with_reference: whether the independent reference solver also computes the row.

    Raises:
        ValueError: if the hub is at rest, the wires are flexible, neighbours touch at the start, or
            a run exceeds the step budget.
    """
    require_rigid(tool)
    if not tool.hub.speed:
        raise ValueError(
            "hub_speed = 0: must be above 0, or the bristles do not follow one another (in rad/s)"
        )
    roots = root_pitch(tool)
    if not roots < row.pitch_deg < (360.0 - roots) / (row.bristles - 1):
        raise ValueError(
            f"pitch_deg = {row.pitch_deg:g}: must be above {roots:g} and below {(360.0 - roots) / (row.bristles - 1):g}, or"
            " wires overlap (in deg)"
        )
    bristles = _simulated(tool, row, settings, row.pitch_deg)
    lone = simulate(tool, dataclasses.replace(settings, samples_per_period=SAMPLES_PER_PERIOD))
    found = NeighbourRow(tool, row, settings, bristles, lone, least_pitches_of(tool, lone))
    reference = None
    if with_reference:
        from bristle_sim.reference import simulate_row_reference

        options: Any = {"hub_turn": settings.hub_turn, "accuracy": reference_accuracy(settings)}
        reference = simulate_row_reference(tool, **_placed(row, row.pitch_deg), **options)[-1]
    strikes = list[dict[str, float | None]]()
    for number, run in enumerate(bristles, 1):
        time = run.event_time("strike")
        before = sum(time is None or each < time for each in _touches(run))
        counted = {"bristle": number, "touches_before_strike": before, "contact_time": time}
        strikes.append(counted | strike_values(tool, run))
    last = bristles[-1]
    reason = unsearched(tool, lone)
    theory = f"not searched, as {reason}" if reason else "theory by the motion of one bristle alone"
    least = [_searched(found, each) for each in found.least]
    return Report(
        **outcome_fields(last.first_contact("workpart")),
        quantities=(*least, *_strike_quantities(found, reference)),
        **run_fields(last),
        remarks=(
            f"theory of bristle {row.bristles}'s strike: a bristle alone. The row stops at"
            f" {1e3 * last.time[-1]:.4f} ms ({last.stop_reason}).",
            f"least pitches: {theory}",
        ),
        tables=(_strikes_table(strikes),),
        extra={"bristles": strikes},
        subject=found,
        answer=_answer(found, least, strikes[-1]),
    )


def _answer(row: NeighbourRow, least: Sequence[Quantity], last: Values) -> str:
    known = {each.name: each.theory if each.simulated is None else each.simulated for each in least}
    whole = known["least_pitch_whole_pass_deg"]
    own = known["least_pitch_to_own_strike_deg"]
    struck = last["normal_final_impulse"]
    alone = strike_values(row.tool, row.lone)["normal_final_impulse"]
    touched = bool(last["touches_before_strike"])
    unchanged = touched and struck and alone and abs(struck - alone) <= UNCHANGED * abs(alone)
    apart = ""
    if whole is not None:
        apart = f"Wires of one plane touch each other at a spacing below {whole:.2f}°"
    if own is not None:
        effect = "they touch before the strike" if unchanged else "a touch changes the next strike"
        apart += f"{'; below' if apart else 'Below'} {own:.2f}° {effect}"
    apart += ". " if apart else ""
    number = row.neighbours.bristles
    pitch = f"{row.neighbours.pitch_deg:g}°"
    if struck is None:
        return (
            f"{apart}At {pitch} bristle {number} does not strike: {row.bristles[-1].stop_reason}."
        )
    before = "after a touch" if touched else "untouched until then"
    compared = "" if alone is None else f"; a bristle alone has {amount(alone, 'N s')}"
    if unchanged:
        compared = ", which is the impulse of a bristle alone"
    return f"{apart}At {pitch} bristle {number} strikes with {amount(struck, 'N s')}, {before}{compared}."


def _strikes_table(strikes: Sequence[Values]) -> Table:
    head = (
        "bristle",
        "touches before",
        "strike, ms",
        "lag, deg",
        "relative speed, rad/s",
        "impulse p_fy, mN s",
    )
    factors = dict.fromkeys(strikes[0], 1.0) | {"contact_time": 1e3, "normal_final_impulse": 1e3}
    cells = [
        tuple(
            "-" if value is None else f"{factors[name] * value:.5g}" for name, value in each.items()
        )
        for each in strikes
    ]
    return Table("the strike of each bristle", head, tuple(cells))


def over_pitch(row: NeighbourRow, pitches: Sequence[float]) -> dict[str, Array]:
    """Return the quantities of the last bristle's strike as functions of the pitch.

    ``pitches`` are the angles between neighbouring bristles, deg. A quantity is NaN where the row
    cannot be simulated or its last bristle does not strike.
    """
    found = np.full((len(STRIKE), len(pitches)), math.nan)
    for number, pitch in enumerate(pitches):
        with contextlib.suppress(
            ValueError
        ):  # the row cannot start at this pitch, or the run exceeds its step budget
            run = _simulated(row.tool, row.neighbours, row.settings, pitch, stop_after="strike")[-1]
            found[:, number] = list(strike_values(row.tool, run).values())
    return dict(zip(STRIKE, found, strict=True))


def row_series(row: NeighbourRow) -> dict[str, Any]:
    """Return the motion of a row of bristles as columns of a table.

    The columns are the time, the hub angle of the foremost root, and every bristle's angle relative
    to the hub.
    """
    angles = {
        f"relative_angle_{number} (rad)": run.relative_angle
        for number, run in enumerate(row.bristles, 1)
    }
    return {
        "time (s)": row.bristles[0].time,
        "hub_angle (rad)": row.bristles[0].hub_angle,
        **angles,
    }


def _placed(row: Neighbours, pitch: float) -> dict[str, Any]:
    own = {"neighbour_friction": row.friction, "neighbour_restitution": row.restitution}
    return {"bristles": row.bristles, "pitch": math.radians(pitch), **own}


def _simulated(
    tool: Tool, row: Neighbours, settings: Settings, pitch: float, **options: Any
) -> tuple[Trajectory, ...]:
    # A step takes 16 us for two bristles, 85 us for twelve. The step budget shrinks accordingly.
    brief = dataclasses.replace(
        settings, maximum_steps=max(1, 2 * settings.maximum_steps // row.bristles)
    )
    runs = simulate_row(tool, brief, **_placed(row, pitch), **options)
    require_result(runs[-1], settings)
    return runs


def root_pitch(tool: Tool) -> float:
    """Return the angle between bristles at which their wires touch at the roots, deg.

    It is 2 asin(d/(2 r_h)), where d is the wire's diameter and r_h the hub's radius.

    Raises:
        ValueError: if the hub is thinner than the wire.
    """
    if not tool.bristle.wire_diameter < 2.0 * tool.hub.radius:
        raise ValueError(
            f"hub_radius = {tool.hub.radius:g}: must be above half of wire_diameter (in m)"
        )
    return math.degrees(2.0 * math.asin(tool.bristle.wire_diameter / (2.0 * tool.hub.radius)))


def _searched(row: NeighbourRow, least: LeastPitch) -> Quantity:
    """Search for the largest pitch at which two simulated wires touch, near its theoretical value.

    Returns:
        The comparison of both pitches. The simulated pitch is None if there was no search, or if it
            is not within AGREEMENT of the theoretical pitch.
    """
    theory = least.by_theory
    compared = Quantity(least.name, "deg", None, theory, label=LEAST_PITCHES[least.name])
    if least.until is None or theory is None or row.neighbours.search == "no":
        return compared
    pair = dataclasses.replace(row.neighbours, bristles=2)
    end = least.until
    speed = row.tool.hub.speed

    def touch(pitch: float) -> bool:
        """Return whether the wires of two simulated bristles touch at a pitch (deg)."""
        if pitch <= root_pitch(row.tool):
            return True
        turn = math.radians(pitch)
        until = end + turn / speed if least.of_follower else end
        # A row of two is simulated until the hub has turned by ``hub_turn`` plus one pitch.
        brief = dataclasses.replace(row.settings, hub_turn=speed * until - turn)
        return any(each <= until for each in _touches(_simulated(row.tool, pair, brief, pitch)[0]))

    compared = dataclasses.replace(compared, tolerance=AGREEMENT / theory)
    low = theory - AGREEMENT
    high = theory + AGREEMENT
    if touch(high) or not touch(low):
        return compared
    while high - low > RESOLUTION:
        middle = 0.5 * (low + high)
        if touch(middle):
            low = middle
        else:
            high = middle
    return dataclasses.replace(compared, simulated=0.5 * (low + high))


def strike_values(tool: Tool, run: Trajectory) -> dict[str, float | None]:
    """Return the quantities of a bristle's first strike, by name; None if there is no strike.

    ``STRIKE`` lists their names and units.
    """
    found = measures_of(tool, run)
    return {name: found[name] for name in STRIKE}


def _touches(run: Trajectory) -> list[float]:
    return [each.time for each in run.events if each.name == WIRE_TOUCH]


def _strike_quantities(row: NeighbourRow, reference: Trajectory | None) -> tuple[Quantity, ...]:
    """Compare the strike of the row's last bristle with that of a lone bristle.

    The values of the lone bristle stand in the column of theory. The number of touches of the last
    wire is also listed; only the reference solution has it too.
    """
    tool = row.tool
    last = row.bristles[-1]
    touched = bool(_touches(last))
    ended = last.stop_reason is StopReason.END
    simulated = {"wire_contacts": float(len(_touches(last))), **strike_values(tool, last)}
    theory = strike_values(tool, row.lone)
    referred: Values = {}
    if reference is not None:
        touches = float(len(_touches(reference)))
        referred = {"wire_contacts": touches, **strike_values(tool, reference)}
    # A touch may change all later motion, so that the lone bristle is no theory any more. If one
    # bristle stops the simulation, later touches of all bristles are missing.
    within = dict[str, float]()
    if reference is not None:
        within["wire_contacts"] = 0.0
    if reference is not None or not touched:
        # Errors are relative to an angle of 1 rad, the hub's rate, and the strike of a lone
        # bristle.
        scales = (math.degrees(1.0), tool.hub.speed, 0.0)
        for name, scale in zip(STRIKE, scales, strict=True):
            value = (referred or theory)[name]
            if value and (ended or simulated[name] is not None):
                size = max(scale, abs(theory[name] or value))
                within[name] = 10.0 * row.settings.accuracy * max(1.0, size / abs(value))
    units = {"wire_contacts": ("touches of its wire", "1"), **STRIKE}
    return rows(units, simulated, theory, referred, tolerances=within)
