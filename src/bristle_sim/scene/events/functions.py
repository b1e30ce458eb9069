"""Event functions, whose change of sign within a smooth interval is an event, and what an event changes about the contacts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.sustained import Sustained
from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.mechanism import State
from bristle_sim.stop_reason import StopReason


class Touch(NamedTuple):
    """A link meets what it can touch; with ``rests`` the impact has no restitution."""

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
    """A rigid contact slips in another sense from now on; 0 sticks."""

    contact: Sustained
    sense: int


class Kink(NamedTuple):
    """The motion has a kink: the contact passes a corner of the wire, or the tip leaves a dent."""


class SpringEvent(Enum):
    """What happens to a contact with a spring."""

    COMPRESSION_ENDS = auto()
    UNLOADED = auto()
    PRESSED_ON = auto()
    SLIP_STOPS = auto()
    STICK_BREAKS = auto()
    OVERDUE = auto()


class SpringChange(NamedTuple):
    """A contact with a spring passes into another phase, or ends."""

    contact: Sustained
    event: SpringEvent


Change = Touch | Release | HandOver | Slip | Kink | SpringChange
"""What an event changes about the contacts."""


@dataclass(frozen=True, slots=True)
class EventFunction:
    """A function whose change of sign is an event.

    Attributes:
        name: what it is.
        value: function of the result of an interval; a change of its sign is the event.
        falling: True or False if only falling or rising through zero counts, None for both.
        event: name under which it is recorded; None for one that is not.
        final: why the run stops there; None if the run continues.
        exact: ``value`` as a function of the state, where ``value`` has the error of a difference over the interval.
        act: returns what the event changes about the contacts; None if it changes nothing.
        wire: number of the wire whose event it is.
        difference: whether the value is made of a difference of rates over a step, and carries its rounding.
        tolerance: to which it is located where the run's own does not do; values then have a sign down to rounding.
        turns: whether it may change its sign twice within an interval.
        positive: whether the value is known to be positive where the motion begins.
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
    tolerance: float | None = None
    turns: bool = False
    positive: bool = False


def at_state(state: State) -> Advance:
    """Return a state as the end of an interval of no length."""
    return Advance(state, (math.nan,) * len(state.angles), (), 0.0)
