"""What a run looks out for besides touches: functions whose change of sign within a smooth interval is an event."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from bristle_sim.scene.acceleration import acceleration
from bristle_sim.scene.build import Scene
from bristle_sim.scene.events import turns
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.stepping import Advance
from bristle_sim.stop_reason import StopReason

__all__ = ["EventFunction", "freedom", "in_flight", "in_touch"]


@dataclass(frozen=True, slots=True)
class EventFunction:
    """One thing to look out for.

    Attributes:
        name: what it is.
        value: function of the result of an interval; a change of its sign is the event.
        falling: True or False if only falling or rising through zero counts, None for both.
        event: name under which it is recorded; None for a mere kink in the motion, where an interval has to end.
        final: why the run stops there; None if it goes on.
        exact: the same as a function of the state, where ``value`` has the error of a difference over the interval.
    """

    name: str
    value: Callable[[Advance], float]
    falling: bool | None = None
    event: str | None = None
    final: StopReason | None = None
    exact: Callable[[State], float] | None = None


def in_flight(scene: Scene) -> list[EventFunction]:
    """Extremes of the first link's motion relative to the hub."""
    name = "highest relative speed"
    return [
        _retraction(scene.mechanism),
        EventFunction(name, _acceleration, falling=True, event=name, exact=partial(acceleration, scene)),
    ]


def in_touch(mechanism: Mechanism, obstacle: Obstacle, state: State) -> list[EventFunction]:
    """Largest retraction, and kinks of a motion in sustained contact: contact passing the wire's end, slip that turns."""

    def kink(index: int, at: Advance) -> float:
        return obstacle.touch(mechanism.poses(at.state)[-1], at.state.rates[-1]).kinks[index]

    def slip(at: Advance) -> float:
        return obstacle.touch(mechanism.poses(at.state)[-1], at.state.rates[-1]).velocity[1]

    corners = len(obstacle.touch(mechanism.poses(state)[-1], state.rates[-1]).kinks)
    functions = [_retraction(mechanism)]
    functions += [EventFunction(f"corner {index} of the wire", partial(kink, index)) for index in range(corners)]
    return [*functions, EventFunction("slip", slip)] if obstacle.friction else functions


def freedom(mechanism: Mechanism, limit: float, start: State) -> EventFunction:
    """The first link's angle relative to the hub reaches what the geometry allows, be it only within an interval."""

    def left(at: Advance) -> float:
        return limit - max(_leaning(mechanism, state) for state in (at.state, *turns(mechanism, start, at.state)))

    return EventFunction(
        "retraction limit", left, falling=True, event="retraction limit", final=StopReason.RETRACTION_LIMIT
    )


def _leaning(mechanism: Mechanism, state: State) -> float:
    return abs(state.angles[0] - mechanism.hub_angle(state.time))


def _retraction(mechanism: Mechanism) -> EventFunction:
    def relative_rate(at: Advance) -> float:
        return at.state.rates[0] - mechanism.hub_speed

    return EventFunction("largest retraction", relative_rate, falling=False, event="largest retraction")


def _acceleration(at: Advance) -> float:
    return at.accelerations[0]
