"""Event functions of a run besides touches: functions whose change of sign within a smooth interval is an event."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.events.search import turns
from bristle_sim.scene.integrate.acceleration import acceleration
from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.stop_reason import StopReason


class Touch(NamedTuple):
    """A link meets what it can touch; ``rests`` takes what is left of the approach."""

    obstacle: Obstacle
    rests: bool = False


class Release(NamedTuple):
    """Links leave what they were on; the gaps are still closed."""

    obstacles: tuple[Obstacle, ...]


class HandOver(NamedTuple):
    """A contact slides over a joint, from one link to its neighbour."""

    obstacle: Obstacle
    following: Obstacle


class Slip(NamedTuple):
    """A sustained contact slips in another sense from now on; 0 sticks."""

    obstacle: Obstacle
    sense: int


Change = Touch | Release | HandOver | Slip
"""What an event changes about the contacts."""


@dataclass(frozen=True, slots=True)
class EventFunction:
    """A function whose change of sign is an event.

    Attributes:
        name: what it is.
        value: function of the result of an interval; a change of its sign is the event.
        falling: True or False if only falling or rising through zero counts, None for both.
        event: name under which it is recorded; None for a mere kink in the motion, where an interval has to end.
        final: why the run stops there; None if the run continues.
        exact: ``value`` as a function of the state, where ``value`` has the error of a difference over the interval.
        act: returns what the event changes about the contacts; None if it changes nothing.
        wire: number of the wire whose event it is.
        difference: whether the value is made of a difference of rates over a step, and carries its rounding.
    """

    name: str
    value: Callable[[Advance], float]
    falling: bool | None = None
    event: str | None = None
    final: StopReason | None = None
    exact: Callable[[State], float] | None = None
    act: Callable[[], Change | None] | None = None
    wire: int = 0
    difference: bool = False


def in_flight(scene: Scene) -> list[EventFunction]:
    """Return extremes of each wire's motion relative to the hub: of a wire of several links, which vibrates, its retraction."""
    found = retraction(scene.mechanism)
    if scene.mechanism.wire_links > 1:
        return found
    event = "highest relative speed"
    for wire in range(scene.mechanism.wires):
        exact = partial(acceleration, scene, link=wire)
        value = partial(_acceleration, wire)
        found.append(
            EventFunction(f"{event} of wire {wire}", value, True, event, exact=exact, wire=wire, difference=True)
        )
    return found


def retraction(mechanism: Mechanism) -> list[EventFunction]:
    """Return the event functions of each wire's largest retraction."""

    def relative_rate(link: int, at: Advance) -> float:
        return at.state.rates[link] - mechanism.hub_speed

    event, size = "largest retraction", mechanism.wire_links
    return [
        EventFunction(f"{event} of wire {wire}", partial(relative_rate, wire * size), False, event, wire=wire)
        for wire in range(mechanism.wires)
    ]


def freedom(mechanism: Mechanism, limit: float, start: State) -> list[EventFunction]:
    """Return the event functions of the retraction limit, which a wire's relative angle reaches within an interval or at its end."""

    def left(link: int, at: Advance) -> float:
        states = (at.state, *turns(mechanism, start, at.state, link))
        return limit - max(abs(each.angles[link] - mechanism.root_angle(link, each.time)) for each in states)

    name, size = "retraction limit", mechanism.wire_links
    return [
        EventFunction(
            f"{name} of wire {wire}", partial(left, wire * size), True, name, StopReason.RETRACTION_LIMIT, wire=wire
        )
        for wire in range(mechanism.wires)
    ]


def _acceleration(link: int, at: Advance) -> float:
    return at.accelerations[link]
