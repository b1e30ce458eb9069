"""Neighbours in one plane: the least pitches at which wires touch, and what a touch does to the strike.

Rows of bristles are simulated together; the least pitches are compared with those by the motion of a lone bristle, and the
last bristle's strike with the lone one's.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, rows
from bristle_sim.parameters import Neighbours, Tool
from bristle_sim.scene.tool import simulate, simulate_row
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.studies.least_pitch import LonePass, least_pitch, nearest_approach
from bristle_sim.studies.strike_point import outcome_of, ran, require_result, state_at_strike
from bristle_sim.trajectory import Trajectory

WIRE_TOUCH = "wire touch"

FIRST_WIDTH = 0.1
"""Width of the interval about the theoretical least pitch that the search on simulated rows bisects, deg."""

RESOLUTION = 0.005
"""Width to which that interval is bisected, deg."""

WIDENINGS = 5
"""Times that the interval is doubled until its ends differ, after which the search has failed."""

AGREEMENT = 0.05
"""Largest difference of simulated and theoretical least pitches that agrees, deg."""

SAMPLES_PER_PERIOD = 150
"""Samples in a period of the lone bristle on its belt, for the cubics of its centre line."""

MOST_SAMPLES = 5000
"""Samples of a lone pass, eight times those of the operating point, beyond which no least pitch is searched."""

LARGEST = math.pi / 2.0
"""Pitch from which the search goes down, rad."""

BEYOND = 1e-6
"""How far above a least pitch the search for a smaller one begins, rad: a thousand times what it is good to."""

STATE = {"relative_speed_at_contact": "rad/s", "lag_deg_at_contact": "deg", "normal_final_impulse": "N s"}
"""Units of what is reported of the last bristle's strike."""


@dataclass(frozen=True, slots=True)
class LeastPitch:
    """A pitch, deg, above which by a lone bristle's motion two wires do not touch up to an instant of its pass, s.

    There is no instant where the pass has no strike; it may be one of the follower's pass, a pitch later than of the one in
    front.
    """

    name: str
    until: float | None
    of_follower: bool
    by_theory: float | None


@dataclass(frozen=True, slots=True)
class Row:
    """A row of bristles that were simulated together, the foremost first, and the pass of a bristle without neighbours."""

    tool: Tool
    neighbours: Neighbours
    settings: Settings
    bristles: tuple[Trajectory, ...]
    lone: Trajectory
    least: tuple[LeastPitch, ...]

    @property
    def touches(self) -> list[float]:
        """Return the instants at which two wires of the row touch, s."""
        return sorted({time for run in self.bristles for time in _touches(run)})


def neighbours(tool: Tool, row: Neighbours, settings: Settings, *, with_reference: bool = False) -> Report:
    """Find the least pitches by theory and on simulated rows, and simulate one row at its pitch.

    Raises:
        ValueError: if the hub stands still, wires touch at the start, or a run is given up.
    """
    if not tool.hub.speed:
        raise ValueError("hub_speed = 0: must be above 0, or no bristle follows another (in rad/s)")
    roots = root_pitch(tool)
    if not roots < row.pitch_deg < (360.0 - roots) / (row.bristles - 1):
        raise ValueError(
            f"pitch_deg = {row.pitch_deg:g}: must be above {roots:g} and below {(360.0 - roots) / (row.bristles - 1):g}, or"
            " wires stand in each other (in deg)"
        )
    bristles = _simulated(tool, row, settings, row.pitch_deg)
    lone = simulate(tool, dataclasses.replace(settings, samples_per_period=SAMPLES_PER_PERIOD))
    found = Row(tool, row, settings, bristles, lone, _least_pitches(tool, lone))
    reference, least = None, dict[str, float | None]()
    if with_reference:
        from bristle_sim.reference import simulate_reference, simulate_row_reference

        options: Any = {"hub_turn": settings.hub_turn, "accuracy": max(1e-10, 0.1 * settings.accuracy)}
        reference = simulate_row_reference(tool, **_placed(row, row.pitch_deg), **options)[-1]
        alone = simulate_reference(tool, **options)
        least = {each.name: each.by_theory for each in _least_pitches(tool, alone)}
    contact = bristles[-1].first_contact("workpart")
    return Report(
        outcome=outcome_of(contact),
        quantities=(
            *(_searched(found, each, least.get(each.name)) for each in found.least),
            *_strike_quantities(found, reference),
        ),
        phases=() if contact is None else contact.phases,
        **ran(bristles[-1]),
        remarks=_remarks(found),
        subject=found,
    )


def over_pitch(row: Row, pitches: Sequence[float]) -> dict[str, Array]:
    """Return the last bristle's state and impulse at its strike over the pitch in degrees; NaN without a run or a strike."""
    found = []
    for pitch in pitches:
        values: list[float | None] = [None] * len(STATE)
        with contextlib.suppress(ValueError):  # a pitch at which the row cannot start, or a run that is given up
            run = _simulated(row.tool, row.neighbours, row.settings, pitch, stop_after="strike")[-1]
            values = list(strike_values(row.tool, run).values())
        found.append([math.nan if value is None else value for value in values])
    return dict(zip(STATE, np.transpose(found), strict=True))


def row_series(row: Row) -> dict[str, Any]:
    """Return time, the foremost root's angle and every bristle's angle from its radial direction, one entry a sample."""
    angles = {f"relative_angle_{number} (rad)": run.relative_angle for number, run in enumerate(row.bristles, 1)}
    return {"time (s)": row.bristles[0].time, "hub_angle (rad)": row.bristles[0].hub_angle, **angles}


def _placed(row: Neighbours, pitch: float) -> dict[str, Any]:
    """Return a row's arguments at a pitch in degrees."""
    return {
        "bristles": row.bristles,
        "pitch": math.radians(pitch),
        "neighbour_friction": row.friction,
        "neighbour_restitution": row.restitution,
    }


def _simulated(tool: Tool, row: Neighbours, settings: Settings, pitch: float, **options: Any) -> tuple[Trajectory, ...]:
    # A step takes as long as its row has bristles: 16 us for two, 85 us for twelve.
    brief = dataclasses.replace(settings, maximum_steps=max(1, 2 * settings.maximum_steps // row.bristles))
    runs = simulate_row(tool, brief, **_placed(row, pitch), **options)
    require_result(runs[-1], settings)
    return runs


def root_pitch(tool: Tool) -> float:
    """Return the pitch at which wires touch at their roots, 2 asin(d/(2 r_h)), deg."""
    if not tool.bristle.wire_diameter < 2.0 * tool.hub.radius:
        raise ValueError(f"hub_radius = {tool.hub.radius:g}: must be above half of wire_diameter (in m)")
    return math.degrees(2.0 * math.asin(tool.bristle.wire_diameter / (2.0 * tool.hub.radius)))


def _least_pitches(tool: Tool, lone: Trajectory) -> tuple[LeastPitch, ...]:
    """Return the theoretical least pitches, from the narrowest; none where ``_unsearched`` says why."""
    contact = lone.first_contact("workpart")
    strike = None if contact is None else contact.time
    found, largest, searched = [], LARGEST, not _unsearched(tool, lone)
    # Each counts fewer touches than the one before, so that its pitch is smaller.
    for words, until, own in (
        ("whole_pass", float(lone.time[-1]), False),
        ("to_own_strike", strike, True),
        ("to_strike", strike, False),
    ):
        theory = None
        if until is not None and searched:
            largest = least_pitch(lone, tool.bristle.wire_diameter, until=until, of_follower=own, largest=largest)
            theory = math.degrees(largest)
            largest += BEYOND
        found.append(LeastPitch(f"least_pitch_{words}_deg", until, own, theory))
    return tuple(reversed(found))


def _unsearched(tool: Tool, lone: Trajectory) -> str:
    """Return the reason why no least pitch is searched; empty if it is."""
    if lone.time.size > MOST_SAMPLES:
        return "the pass has too many oscillations of the bristle on its belt"
    if nearest_approach(LonePass(lone), LARGEST, float(lone.time[-1]))[0] <= tool.bristle.wire_diameter:
        return f"wires touch each other even {math.degrees(LARGEST):g} deg apart"
    return ""


def _searched(row: Row, least: LeastPitch, reference: float | None) -> Quantity:
    """Search the pitch from which two simulated wires touch, beside the theoretical one; reference by its lone pass."""
    if least.until is None or least.by_theory is None or row.neighbours.search == "no":
        return Quantity(least.name, "deg", None, least.by_theory, reference)
    pair, end, speed = dataclasses.replace(row.neighbours, bristles=2), least.until, row.tool.hub.speed

    def touch(pitch: float) -> bool:
        """Tell whether two wires a pitch apart, deg, touch in the time that counts."""
        if pitch <= root_pitch(row.tool):
            return True
        turn = math.radians(pitch)
        until = end + turn / speed if least.of_follower else end
        # A row runs until the hub has carried its last root so far.
        brief = dataclasses.replace(row.settings, hub_turn=speed * until - turn)
        events = _simulated(row.tool, pair, brief, pitch)[0].events
        return any(each.name == WIRE_TOUCH and each.time <= until for each in events)

    found = _edge(touch, least.by_theory)
    return Quantity(least.name, "deg", found, least.by_theory, reference, tolerance=AGREEMENT / least.by_theory)


def _edge(touch: Callable[[float], bool], near: float) -> float | None:
    """Bisect between a pitch at which wires touch and a larger one at which they do not, deg."""
    width = FIRST_WIDTH
    for _ in range(WIDENINGS):
        low, high = near - 0.5 * width, near + 0.5 * width
        if touch(low) and not touch(high):
            break
        width *= 2.0
    else:
        return None
    while high - low > RESOLUTION:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if touch(middle) else (low, middle)
    return 0.5 * (low + high)


def strike_values(tool: Tool, run: Trajectory) -> dict[str, float | None]:
    """Return what is reported of a bristle's first strike, in the units of STATE; None without one."""
    contact = run.first_contact("workpart")
    impulse = None if contact is None else contact.impulse[0]
    state = state_at_strike(tool, run, contact) | {"normal_final_impulse": impulse}
    return {name: state[name] for name in STATE}


def _touches(run: Trajectory) -> list[float]:
    return [each.time for each in run.events if each.name == WIRE_TOUCH]


def _strike_quantities(row: Row, reference: Trajectory | None) -> tuple[Quantity, ...]:
    """Return the last bristle's touches and its strike; theory is the lone bristle, from which a touch may differ."""
    last, touches = row.bristles[-1], len(_touches(row.bristles[-1]))
    judged = reference is not None or not touches
    simulated = {"wire_contacts": float(touches), **strike_values(row.tool, last)}
    theory = {"wire_contacts": None if touches else 0.0, **strike_values(row.tool, row.lone)}
    referred: dict[str, float | None] = {}
    if reference is not None:
        referred = {"wire_contacts": float(len(_touches(reference))), **strike_values(row.tool, reference)}
    # Errors are relative to angles of a radian, the hub's rate, and the strike of a bristle alone.
    scales = {"lag_deg_at_contact": math.degrees(1.0), "relative_speed_at_contact": row.tool.hub.speed}

    def tolerance(name: str) -> float | None:
        """Return the relative difference that a quantity may have; None where nothing judges it."""
        if name == "wire_contacts":  # a row ends for all when one bristle jams
            counted = judged and (reference is not None or last.stop_reason is StopReason.END)
            return 0.0 if counted else None
        value = (referred or theory)[name]
        # Another bristle of the row, or this one, may end the run before this one could strike.
        cut_short = simulated[name] is None and last.stop_reason is not StopReason.END
        if not judged or not value or cut_short:
            return None
        size = max(scales.get(name, 0.0), abs(theory[name] or value))
        return 10.0 * row.settings.accuracy * max(1.0, size / abs(value))

    return rows({"wire_contacts": "1", **STATE}, simulated, theory, referred, tolerance=tolerance)


def _remarks(row: Row) -> tuple[str, ...]:
    last, number = row.bristles[-1], row.neighbours.bristles
    contact, end = last.first_contact("workpart"), f"{1e3 * last.time[-1]:.4f} ms ({last.stop_reason})"
    strike = "does not strike" if contact is None else f"strikes at {1e3 * contact.time:.4f} ms"
    counted = (
        "least pitches: theory by the motion of one bristle alone; counted are touches until the bristle in front"
        " strikes, until the follower itself does, and in the whole pass"
    )
    if reason := _unsearched(row.tool, row.lone):
        counted = f"least pitches: not searched, as {reason}"
    return f"bristle {number} {strike}; the row stops at {end}", counted, "theory of the strike: a bristle alone"
