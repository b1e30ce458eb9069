"""Events of a run: the functions whose change of sign ends a smooth motion, and the kinds of change that follow.

An event *triggers* in an interval (0, h] of a smooth motion if its value has the sign opposite to ``direction`` at the beginning,
and the sign ``direction`` at some later instant of the interval; the instant of the event is the first zero before. At the
beginning of a motion a value within its rounding has no sign. Such a value takes the sign that its kind states in
:data:`BEGINS_POSITIVE`, or else the first sign that it has at the end of an interval. A ``direction`` of 0 stands for both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any, NamedTuple

from bristle_sim.scene.extrapolation import IntervalResult


class Kind(Enum):
    """The kinds of events, with the subject of each."""

    TOUCH = auto()  # pair: its gap closes
    REST = auto()  # pair: its gap closes, and the impact has no restitution
    RELEASE = auto()  # contacts: their normal forces fall to zero
    HAND_OVER = auto()  # contact, and the pair of the neighbouring link onto which it slides
    SLIP_STOPS = auto()  # rigid contact: its slip velocity falls to zero
    BREAKS_AWAY = auto()  # rigid contact that sticks: its tangential force exceeds friction
    SLIPS = auto()  # rigid contact, and the sense in which it slips from now on
    KINK = (
        auto()
    )  # contact: it passes a corner of the wire, or its slip changes its sense without friction's
    LOCKED = auto()  # rigid contact: no force keeps it closed
    DENT_LEFT = (
        auto()
    )  # number of a pair: the tip comes out of the dent that a contact in time has left
    COMPRESSION_ENDS = auto()  # contact with a spring: the approach falls to zero
    UNLOADED = auto()  # contact with a spring: its force falls to zero
    PRESSED_ON = (
        auto()
    )  # contact with a spring that unloads: the penetration exceeds the deepest one
    RELOADING_ENDS = auto()  # contact with a spring pressed on from rest at its deepest point: its approach falls to zero again
    REST_ENDS = auto()  # contact with a spring in slip at rest: friction no longer keeps it at rest
    FOOT_STOPS = auto()  # contact with a spring that slips: its foot stops
    CONE_REACHED = (
        auto()
    )  # contact with a spring that sticks: its tangential force reaches the friction cone
    OVERDUE = (
        auto()
    )  # contact with a spring in the rigid-body limit: it lasts too long to be an impact
    LARGEST_RETRACTION = auto()  # wire: its first link turns back towards the hub's direction
    HIGHEST_SPEED = auto()  # wire: the rate of its only link is highest
    RETRACTION_LIMIT = auto()  # wire: it lies on the hub


SPRING_KINDS = frozenset(
    {
        Kind.COMPRESSION_ENDS,
        Kind.UNLOADED,
        Kind.PRESSED_ON,
        Kind.RELOADING_ENDS,
        Kind.REST_ENDS,
        Kind.FOOT_STOPS,
        Kind.CONE_REACHED,
        Kind.OVERDUE,
    }
)
BEGINS_POSITIVE = frozenset(
    {
        Kind.LOCKED,
        Kind.RETRACTION_LIMIT,
        Kind.PRESSED_ON,
        Kind.RELOADING_ENDS,
        Kind.REST_ENDS,
        Kind.FOOT_STOPS,
        Kind.CONE_REACHED,
    }
)
"""Kinds whose value is positive where a motion begins, or rises from zero there, by the decision at the event before."""

TURNS = SPRING_KINDS | {Kind.RETRACTION_LIMIT, Kind.DENT_LEFT}
"""Kinds whose value may change its sign twice within an interval."""

DIFFERENCES = frozenset({Kind.RELEASE, Kind.BREAKS_AWAY, Kind.HIGHEST_SPEED})
"""Kinds whose value contains a difference of rates over a step, and so its rounding."""

OF_THE_MOTION = frozenset(
    {Kind.LARGEST_RETRACTION, Kind.HIGHEST_SPEED, Kind.RETRACTION_LIMIT, Kind.DENT_LEFT}
)
"""Kinds that do not depend on a contact."""


@dataclass(frozen=True, slots=True)
class Event:
    """A function of the result of an interval whose change of sign is an event.

    Attributes:
        value: the function.
        direction: -1 if it falls through zero, +1 if it rises, 0 for both.
        kind, subject: the kind of event, and its contact, pair or wire.
        tolerance: value to which the zero is located; None for the run's own. Values then have a sign down to rounding.
    """

    value: Callable[[IntervalResult], float]
    direction: int
    kind: Kind
    subject: Any
    tolerance: float | None = None


class Happening(NamedTuple):
    """An event that has happened: its kind and subject, and the sense of slip or the pair that follows."""

    kind: Kind
    subject: Any
    detail: Any = None
