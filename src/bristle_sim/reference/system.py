"""Wires among their obstacles: sustained contacts, and the contact kinematics, forces and
accelerations in a state.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.reference.contacts import Bar, Point, Spring, Touch, WirePairs, Workpart
from bristle_sim.reference.forces import Acting, Balance, balance, closed
from bristle_sim.reference.mechanics import Chain, Complexes, Kinematics

Obstacles = Mapping[str, Bar | Workpart | WirePairs]

# Rounding error of a rate, over the fastest rate, for each radian turned; measured are 3e-15 in one
# turn, and 7e-15 in 80 turns.
RATE_ROUNDING = 1e-13
REST = 1e-10  # largest velocity that counts as rest, over the bound of all velocities


class State(NamedTuple):
    """The state of all links: time, s, absolute angles, rad, and absolute rates, rad/s."""

    time: float
    angles: Array
    rates: Array


@dataclass(slots=True, eq=False)
class Sustained:
    """A sustained contact.

    Attributes:
        point: location of the contact on the wire.
        slip: sense of the slip; 0 in stick.
        since: state at the start of the contact.
        velocity_before: (normal, tangential) contact velocity at the start, m/s.
        spring: springs of the contact; None if it is rigid.
        sums: normal and tangential impulse, N s, and normal and tangential work, J, so far.
        compression: impulses and works, as in ``sums``, at the end of a compliant contact's
            compression.
    """

    point: Point
    slip: int
    since: State
    velocity_before: tuple[float, float]
    spring: Spring | None = None
    sums: Array = field(default_factory=lambda: np.zeros(4))
    compression: Array | None = None


class System:
    """One or several wires with their obstacles by name and their sustained contacts.

    Contacts with the workpart are compliant if a stiffness, N/m, or a duration of the first
    contact, s, is given. From the duration the stiffness is computed when a wire first touches the
    workpart. All other contacts are rigid.
    """

    def __init__(
        self,
        chain: Chain,
        obstacles: Obstacles,
        stiffness: float | None,
        duration: float | None = None,
    ) -> None:
        self.chain = chain
        self.obstacles = obstacles
        self.duration = duration
        self.stiffness = stiffness
        self.sustained: list[Sustained] = []
        self.size = chain.hub_radius + chain.length
        self.fastest = chain.fastest_rate

    def at(self, state: State) -> Instant:
        """Return a state together with its kinematics and forces."""
        return Instant(self, state)

    @property
    def rigid(self) -> list[Point]:
        """Return the locations of the rigid sustained contacts."""
        return [each.point for each in self.sustained if each.spring is None]

    def friction(self, point: Point, spring: Spring | None = None) -> float:
        """Return the coefficient of friction of a contact.

        While its spring unloads, it is the coefficient in restitution.
        """
        surface = self.obstacles[point.obstacle].surface
        return (
            surface.friction
            if spring is None or spring.loading
            else surface.friction_in_restitution
        )

    def still(self, state: State) -> float:
        """Return the largest velocity that counts as rest, m/s."""
        return (
            REST
            * self.size
            * max(self.chain.speed, float(np.abs(state.rates).max()), self.fastest * 1e-3)
        )

    def rate_rounding(self, state: State) -> float:
        """Return the rounding error of a link's rate, rad/s.

        It is the rounding error of the link's angle times the fastest rate.
        """
        return RATE_ROUNDING * self.fastest * max(1.0, float(np.abs(state.angles).max()))

    def closed(self, state: State) -> State:
        """Return the nearest state in which rigid contacts are closed and do not open."""
        if not (points := self.rigid):
            return state
        instant = self.at(state)
        moved, changed = closed(instant.mass, [instant.touch(point) for point in points])
        return State(state.time, state.angles + moved, state.rates + changed)


class Instant:
    """A state together with its kinematics and its forces.

    Each quantity is computed once, when it is first used.
    """

    def __init__(self, system: System, state: State) -> None:
        self.system = system
        self.state = state
        self._gaps: dict[str, Array] = {}

    @cached_property
    def turn(self) -> Complexes:
        """Directions e^{i theta} of the links, with their absolute angles theta."""
        return np.asarray(np.exp(1j * self.state.angles))

    @cached_property
    def motion(self) -> Kinematics:
        """Positions and motion of the links' first joints."""
        return self.system.chain.kinematics(*self.state)

    @cached_property
    def mass(self) -> Array:
        """Mass matrix of the links, kg m^2."""
        return self.system.chain.mass_matrix(self.turn)

    @cached_property
    def forces(self) -> Array:
        """Generalized forces on the links without contacts, N m."""
        return self.system.chain.forces(*self.state, self.turn)

    def touch(self, point: Point) -> Touch:
        """Return the kinematics of the contact at a point."""
        return self.system.obstacles[point.obstacle].touch(self.system.chain, self.motion, point)

    def acting(self, sustained: Iterable[Sustained]) -> list[Acting]:
        """Return sustained contacts with their kinematics and spring forces."""
        found = []
        for each in sustained:
            touch = self.touch(each.point)
            mu = self.system.friction(each.point, each.spring)
            spring = each.spring
            known = (
                (None, None)
                if spring is None
                else (spring.force(touch.gap), spring.rub(touch, each.slip))
            )
            found.append(Acting(touch, mu, each.slip, *known))
        return found

    @cached_property
    def contacts(self) -> list[Acting]:
        """The sustained contacts with their kinematics."""
        return self.acting(self.system.sustained)

    @cached_property
    def balance(self) -> Balance:
        """Accelerations of the links and forces of the sustained contacts."""
        return balance(self.mass, self.forces, self.contacts)

    def gaps(self, name: str) -> Array:
        """Return the gaps between the wires and the obstacle of this name, m."""
        if name not in self._gaps:
            self._gaps[name] = self.system.obstacles[name].gaps(self.system.chain, self.motion)
        return self._gaps[name]

    @cached_property
    def feet(self) -> Array:
        """Return where the perpendicular from the bar's centre meets each straight piece.

        It is the distance from the start of the piece, m.
        """
        bar = self.system.obstacles["bar"]
        assert isinstance(bar, Bar)
        return bar.feet(self.system.chain, self.motion)[0]
