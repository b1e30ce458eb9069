"""What is watched while the bristle moves, in flight and in hold alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.reference.crossing import Piece, crossings, nodes
from bristle_sim.reference.hold import Hold
from bristle_sim.reference.mechanics import Mechanics, Motion, State
from bristle_sim.reference.obstacles import Obstacle

__all__ = [
    "ROUNDING",
    "Happening",
    "Watch",
    "gaps",
    "happenings",
    "held",
    "limit",
    "peak",
    "state_at",
    "stationary",
]

Array = NDArray[np.float64]

ROUNDING = 1e-13
"""Share of a quantity's natural size that is rounding.

A gap below this share of hub radius plus bristle length is rounding: a touch is located where it is as far inside.
"""


class Watch(NamedTuple):
    """A function of (time, angle, rate) whose change of sign in one direction matters.

    ``resolution`` is the size below which its values mean nothing. One that ``ends`` the motion also goes off where it
    is found on the far side already: between two steps a value can change by a rounding.
    """

    name: str
    function: Callable[[Array, Array, Array], Array]
    direction: int
    resolution: float
    ends: bool = True


class Happening(NamedTuple):
    """A watch that went off, and when (s)."""

    name: str
    time: float


def happenings(watches: Iterable[Watch], motion: Motion, start: float, end: float) -> list[Happening]:
    """All that goes off on a piece of motion, in order of time; what one watch ends, those after it need not search."""
    found = []
    whole, times = end, nodes(start, end)
    angles, rates = motion(times)
    for watch in watches:
        values = watch.function(times, angles, rates)
        piece = Piece.through(values, start, whole)
        # Most pieces of motion are far from most events, and their series says so at once.
        settled = piece.sign == -watch.direction or (piece.sign and not watch.ends)
        if settled and piece.resolved(values, watch.resolution):
            continue
        close = _closely(watch, motion, start, end)
        end = close[0].time if watch.ends and close else end
        found += close
    return sorted(found, key=lambda each: each.time)


def _closely(watch: Watch, motion: Motion, start: float, end: float) -> list[Happening]:
    value = _along(watch, motion)
    if watch.ends and watch.direction * value(np.array([start]))[0] > 0.0:
        return [Happening(watch.name, start)]
    changes = crossings(value, start, end, watch.resolution)
    return [Happening(watch.name, time) for time, direction in changes if direction == watch.direction]


def _along(watch: Watch, motion: Motion) -> Callable[[Array], Array]:
    return lambda time: watch.function(time, *motion(time))


def state_at(motion: Motion, time: float) -> State:
    """The motion at one instant."""
    angle, rate = motion(np.array([time]))[:, 0]
    return State(time, float(angle), float(rate))


def gaps(mechanics: Mechanics, obstacles: Iterable[Obstacle], state: State) -> list[Watch]:
    """A touch of each obstacle: its gap falls below zero, or below what it is at the start, by more than rounding."""
    return [_gap(mechanics, each, state) for each in obstacles]


def _gap(mechanics: Mechanics, obstacle: Obstacle, state: State) -> Watch:
    rounding = ROUNDING * (mechanics.hub_radius + mechanics.length)
    level = min(float(obstacle.gap(state.angle, mechanics.hub_angle(state.time))), 0.0) - rounding

    def above(time: Array, angle: Array, _: Array) -> Array:
        return np.asarray(obstacle.gap(angle, mechanics.hub_angle(time)) - level)

    return Watch(obstacle.name, above, -1, 0.1 * rounding)


def limit(name: str) -> Watch:
    """The bristle leans over by 90 degrees: the wire would enter the hub's disc."""
    return Watch(name, lambda _time, angle, _rate: (0.5 * math.pi) ** 2 - angle**2, -1, ROUNDING)


def stationary(name: str, mechanics: Mechanics) -> Watch:
    """Relative rate rises through zero: retraction is largest."""
    return Watch(name, lambda _time, _angle, rate: rate, 1, ROUNDING * mechanics.fastest_rate, ends=False)


def peak(name: str, mechanics: Mechanics) -> Watch:
    """Relative acceleration falls through zero in flight: the relative rate is highest."""

    def acceleration(time: Array, angle: Array, rate: Array) -> Array:
        return np.asarray(mechanics.torque(time, angle, rate) / mechanics.inertia)

    return Watch(name, acceleration, -1, ROUNDING * mechanics.fastest_rate**2, ends=False)


def held(release: str, jam: str, hold: Hold) -> list[Watch]:
    """What ends a hold: the force falls to zero, or friction locks the bristle."""

    def departing(time: Array, _angle: Array, _rate: Array) -> Array:
        # The square of the lever takes the pole out where the obstacle gets out of reach.
        return np.asarray(hold.departure(time) * hold.touch(time).normal_lever ** 2)

    mechanics = hold.mechanics
    area = mechanics.length**2
    acceleration = (mechanics.hub_radius + mechanics.length) * mechanics.fastest_rate**2
    watches = [Watch(release, departing, 1, ROUNDING * area * acceleration)]
    if hold.obstacle.friction:
        watches.append(Watch(jam, lambda time, _angle, _rate: hold.freedom(time), -1, ROUNDING * area))
    return watches
