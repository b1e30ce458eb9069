"""The turn that a bristle repeats: run turn after turn until its motion comes back to where it was a turn before.

After a sustained contact only one motion is possible, since on the obstacle the bristle's angle follows from the hub's whatever came
before. Each turn after the first one with a sustained contact is therefore the same, with a damped belt and without. Only
a bristle that bounces off everything remembers more than a turn; its motion need not repeat.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.scene.resume import resume
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.studies.strike_point import require_result
from bristle_sim.trajectory import ContactRecord, Trajectory

TURN = 2.0 * math.pi

MOST_TURNS = 24
"""Turns after which a motion counts as one that does not repeat; a flight loses exp(-2 pi zeta) of its swing a period."""

WIRE_TURNS = 2
"""Turns of a wire that bends, of which the last counts: each takes seconds, and what vibrates need not repeat."""

REPEATED = 1e-9
"""Change of angle, and of rate over the belt's natural rate, rad, that counts as none from turn to turn."""

MAGNIFIED = 100.0
"""Such a change over the requested accuracy, where that is more: a turn adds up errors of some ten flights and contacts."""


class TurnNotCompleted(ValueError):
    """A bristle that jams, or lies down on the hub, completes no turn; the message says when and why."""


@dataclass(frozen=True, slots=True)
class PeriodicTurn:
    """A run of whole turns, the first of which starts at rest relative to the hub; the last repeats the one before.

    The turns that count, from ``begin`` to ``end``, s, are the last one, or the later half of those that do not repeat.
    ``changes`` of the state, rad, are those from the end of the turn before to the end of each; the first is from the start.
    """

    trajectory: Trajectory
    begin: float
    end: float
    turns: int
    changes: tuple[float, ...]
    repeats: bool

    @property
    def contacts(self) -> tuple[ContactRecord, ...]:
        """Contacts of the turns that count."""
        return tuple(each for each in self.trajectory.contacts if each.time >= self.begin)


def periodic_turn(tool: Tool, settings: Settings) -> PeriodicTurn:
    """Simulate turns until one repeats the one before; ``settings.hub_turn`` is ignored.

    Raises:
        TurnNotCompleted: if the bristle jams or lies down on the hub.
        ValueError: if the hub stands still, or a run is not computed within the settings' steps.
    """
    if not tool.hub.speed:
        raise ValueError("hub_speed = 0: must be above 0, or no turn is made (in rad/s)")
    least, rate = max(REPEATED, MAGNIFIED * settings.accuracy), _natural_rate(tool)
    if tool.bristle.links > 1:
        run = _completed(simulate(tool, dataclasses.replace(settings, hub_turn=WIRE_TURNS * TURN)), settings)
        found = run.at(np.linspace(0.0, run.time[-1], WIRE_TURNS + 1))
        lags, rates = (each - each[0] for each in (found.angles - found.hub_angle[:, np.newaxis], found.rates / rate))
        moved = np.abs(np.diff(np.hstack([lags, rates]), axis=0)).max(axis=1)
        return PeriodicTurn(run, float(found.time[-2]), float(found.time[-1]), 1, tuple(moved.tolist()), False)
    run = _completed(simulate(tool, dataclasses.replace(settings, hub_turn=TURN)), settings)
    states, ends, changes = [np.zeros(2)], [0.0], list[float]()
    while True:
        states.append(np.array([run.relative_angle[-1], run.relative_rate[-1] / rate]))
        ends.append(float(run.time[-1]))
        changes.append(float(np.abs(states[-1] - states[-2]).max()))
        if changes[-1] <= least or len(states) > MOST_TURNS:
            break
        longer = dataclasses.replace(settings, hub_turn=len(states) * TURN)
        run = _completed(resume(run, longer), settings)
    repeats = changes[-1] <= least
    turns = 1 if repeats else MOST_TURNS // 2
    return PeriodicTurn(run, ends[-1 - turns], ends[-1], turns, tuple(changes), repeats)


def _completed(run: Trajectory, settings: Settings) -> Trajectory:
    require_result(run, settings)
    if run.stop_reason is not StopReason.END:
        raise TurnNotCompleted(
            f"the bristle completes no turn: {run.stop_reason} at {1e3 * run.time[-1]:.4f} ms, after"
            f" {math.degrees(run.hub_speed * run.time[-1]):.0f} deg of the hub's turn"
        )
    return run


def _natural_rate(tool: Tool) -> float:
    """Return the larger of the hub's speed and the bristle's natural rate, sqrt((k_T + m r_h L/2 omega^2)/I), rad/s."""
    bristle, hub = tool.bristle, tool.hub
    stiffness = tool.belt.stiffness + bristle.mass * hub.radius * math.hypot(*bristle.centre) * hub.speed**2
    return max(math.sqrt(stiffness / bristle.inertia_about_root), hub.speed)
