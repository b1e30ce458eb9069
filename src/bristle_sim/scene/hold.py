"""A link held against an obstacle by the engine's contact: set back onto the obstacle, and entered in the ledger."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.trajectory import ContactRecord

__all__ = ["EngineHold", "ledger_of_hold", "set_back"]

LEAST_LEVER = 1e-6
"""With a lever of the contact normal shorter than this share of the link, turning the link cannot set it back."""


class EngineHold:
    """The engine's own contact as a load: it needs no help, and is lost once its force is gone."""

    def __init__(self, scene: Scene) -> None:
        """For a scene whose obstacle is engaged."""
        self.scene = scene

    def begin(self) -> None:
        """Nothing to forget."""

    def apply(self, step: float) -> None:
        """The engine acts by itself."""

    def totals(self, step: float) -> list[float]:
        """The normal force of the last step."""
        return [self.scene.contact_impulse()[0] / step]

    def fails(self, totals: list[float]) -> bool:
        """A contact only pushes."""
        return totals[0] <= 0.0


def set_back(mechanism: Mechanism, obstacle: Obstacle, state: State) -> State:
    """Turn the last link by Newton's method so that it touches the obstacle and keeps touching it."""
    angles, rates = list(state.angles), list(state.rates)
    for _ in range(3):
        placed = State(state.time, tuple(angles), tuple(rates))
        touch = obstacle.touch(mechanism.poses(placed)[-1], rates[-1])
        lever = touch.arm[0] * touch.normal[1] - touch.arm[1] * touch.normal[0]
        if abs(lever) < LEAST_LEVER:
            return state
        angles[-1] -= touch.gap / lever
        rates[-1] -= touch.velocity[0] / lever
    return State(state.time, tuple(angles), tuple(rates))


def ledger_of_hold(
    mechanism: Mechanism, obstacle: Obstacle, states: Sequence[State], forces: Sequence[float]
) -> ContactRecord:
    """Impulse and work of a sustained touch, by the trapezoidal rule over its samples."""
    slips = [obstacle.touch(mechanism.poses(state)[-1], state.rates[-1]).velocity[1] for state in states]
    normal = tangential = work = 0.0
    for index in range(1, len(states)):
        push = 0.5 * (forces[index] + forces[index - 1]) * (states[index].time - states[index - 1].time)
        slip = 0.5 * (slips[index] + slips[index - 1])
        rub = -math.copysign(obstacle.friction, slip) * push
        normal, tangential, work = normal + push, tangential + rub, work + rub * slip
    first, last = states[0], states[-1]
    return ContactRecord(
        obstacle=obstacle.name,
        law="hold",
        outcome="released",
        time=first.time,
        duration=last.time - first.time,
        impulse=(normal, tangential),
        compressive_impulse=None,
        compressive_work=(0.0, work),
        restitutive_work=None,
        velocity_before=(0.0, slips[0]),
        velocity_after=(0.0, slips[-1]),
        angles=first.angles,
        rates_before=first.rates,
        rates_after=last.rates,
    )
