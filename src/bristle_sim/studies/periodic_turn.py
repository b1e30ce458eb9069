"""The turn that a bristle repeats: turn after turn is simulated until the motion ends as it began.

After a sustained contact only one motion is possible, since on the obstacle the bristle's angle follows from the hub's whatever came
before. Each turn after the first one with a sustained contact is therefore the same, with a damped belt and without. Only
a bristle that bounces off everything remembers more than a turn; its motion need not repeat.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from bristle_sim.parameters import Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.studies.strike_point import require_result, start_angle
from bristle_sim.trajectory import Trajectory

MOST_TURNS = 24
"""Turns after which a motion counts as one that does not repeat; a flight loses exp(-2 pi zeta) of its swing a period."""

REPEATED = 1e-9  # Change of angle, and of rate over the belt's natural rate, rad, that counts as none from turn to turn

MAGNIFIED = 100.0
"""Errors of a turn over the requested accuracy: it adds up those of some ten flights and contacts, each of some ten times the
accuracy."""


class TurnNotCompleted(ValueError):
    """A bristle that jams, or lies down on the hub, completes no turn; the message says when and why."""


@dataclass(frozen=True, slots=True)
class PeriodicTurn:
    """The turns that count: the last one, which repeats the one before, or the later half of those that do not repeat.

    Each is a run that starts in the state in which the one before ended. ``changes`` of the state, rad, are those over
    each turn from the first on, which starts radial and at rest relative to the hub.
    """

    runs: tuple[Trajectory, ...]
    changes: tuple[float, ...]
    repeats: bool


def periodic_turn(tool: Tool, settings: Settings) -> PeriodicTurn:
    """Simulate turns until one repeats the one before; ``settings.hub_turn`` is ignored.

    Raises:
        TurnNotCompleted: if the bristle jams or lies down on the hub.
        ValueError: if the hub stands still, or a run is not computed within the settings' steps.
    """
    if not tool.hub.speed:
        raise ValueError("hub_speed = 0: must be above 0, or no turn is made (in rad/s)")
    bristle, hub, least = tool.bristle, tool.hub, max(REPEATED, MAGNIFIED * settings.accuracy)
    stiffness = tool.belt.stiffness + bristle.mass * hub.radius * math.hypot(*bristle.centre) * hub.speed**2
    natural_rate = max(math.sqrt(stiffness / bristle.inertia_about_root), hub.speed)
    settings = dataclasses.replace(settings, hub_turn=2.0 * math.pi)
    start = -0.5 * math.pi if tool.bar is None else start_angle(tool)
    runs, changes, angle, rate = list[Trajectory](), list[float](), 0.0, 0.0
    while len(runs) < MOST_TURNS:
        run = simulate(tool, settings, start_hub_angle=start, start_relative_angle=angle, start_relative_rate=rate)
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
