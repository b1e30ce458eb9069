"""Wires with their obstacles and sustained contacts, and the forces and accelerations in a state."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.reference.contacts import Bar, Obstacles, Point, Touch
from bristle_sim.reference.forces import (
    Acting,
    Balance,
    Compliant,
    State,
    Sustained,
    balance,
    closed,
)
from bristle_sim.reference.log import STRIKE, Finished, Log
from bristle_sim.reference.mechanics import Chain, Kinematics
from bristle_sim.settings import StopReason

TOUCHES = (STRIKE, "workpart touch", "bar touch", "wire touch")

# Rounding error of a link's angular velocity, divided by the highest angular frequency and by the
# link's angle in rad. Measured are 3e-15 in one revolution, and 7e-15 in 80 revolutions.
RATE_ROUNDING = 1e-13
REST = 1e-10  # largest speed that counts as rest, as a fraction of the bound of all speeds
REST_OF_FASTEST = 1e-3
"""Least angular velocity that enters the bound of all speeds, as a fraction of the tool's highest
angular frequency. It counts only where the hub and all links are slower."""

SLIP_ROUNDING = 1e-3
"""Rounding error of a slip velocity, as a fraction of the largest speed that counts as rest. It is
some hundred rounding errors of the bound of all speeds."""


class System:
    """One or several wires with their obstacles by name, their sustained contacts and their log.

    Contacts with the workpart are compliant if ``stiffness`` (N/m) or ``duration`` (s) is given.
    ``duration`` is that of the first contact; the stiffness is computed from it at that contact.
    All other contacts are rigid.
    """

    def __init__(
        self,
        chain: Chain,
        obstacles: Obstacles,
        log: Log,
        stiffness: float | None = None,
        duration: float | None = None,
    ) -> None:
        self.chain = chain
        self.obstacles = obstacles
        self.log = log
        self.duration = duration
        self.stiffness = stiffness
        self.sustained: list[Sustained] = []
        # By the index of each corner that is still in a dent: the gap (m) at the end of the contact
        # that left the dent.
        self.dents: dict[int, float] = {}
        self.size = chain.hub_radius + chain.length
        self.fastest = chain.fastest_rate

    def at(self, state: State) -> Instant:
        """Return an ``Instant``, which computes the kinematics and the forces of a state."""
        return Instant(self, state)

    @property
    def rigid(self) -> list[Point]:
        """Points at which rigid sustained contacts act."""
        return [each.point for each in self.sustained if not isinstance(each, Compliant)]

    def check_stop(self, state: State) -> None:
        """Raise Finished if the event that ends the run has occurred on every wire.

        If this event is a touch, the run continues until no contact is compliant.
        """
        last = self.log.stop_after
        if last is None or not all(own.times(last) for own in self.log.records):
            return
        if last not in TOUCHES or len(self.rigid) == len(self.sustained):
            raise Finished(StopReason.EVENT, state)

    def still(self, state: State) -> float:
        """Return the speed below which a contact point counts as being at rest, m/s."""
        rates = (self.chain.speed, float(np.abs(state.rates).max()), REST_OF_FASTEST * self.fastest)
        return REST * self.size * max(rates)

    def slip_rounding(self, state: State) -> float:
        """Return the rounding error of a slip velocity, m/s."""
        return SLIP_ROUNDING * self.still(state)

    def rate_rounding(self, state: State) -> float:
        """Return the rounding error of a link's angular velocity, rad/s.

        It is the rounding error of the link's angle (rad) times the highest natural angular
        frequency.
        """
        return RATE_ROUNDING * self.fastest * max(1.0, float(np.abs(state.angles).max()))

    def same_contact(self, first: Point, second: Point) -> bool:
        """Return whether two points belong to the same contact.

        A link has one contact with the bar, which moves along the link. Any other point of a wire
        has a contact of its own.
        """
        if first.obstacle != "bar" or second.obstacle != "bar":
            return first == second
        links = self.chain.pieces.links
        return bool(links[first.piece] == links[second.piece])

    def closed(self, state: State) -> State:
        """Return the closest state with zero gap and zero normal velocity at all rigid contacts."""
        if not (points := self.rigid):
            return state
        instant = self.at(state)
        moved, changed = closed(instant.mass, [instant.touch(point) for point in points])
        return State(state.time, state.angles + moved, state.rates + changed)


class Instant:
    """A state, or the state at n instants, with its kinematics, mass matrix, forces and contacts.

    Each quantity is computed when it is first used, and then stored.
    """

    def __init__(self, system: System, state: State) -> None:
        self.system = system
        self.state = state
        self._gaps: dict[str, Array] = {}

    @cached_property
    def motion(self) -> Kinematics:
        """Positions and velocities of the links' first joints."""
        return self.system.chain.kinematics(*self.state)

    @cached_property
    def mass(self) -> Array:
        """Mass matrix of the links, kg m^2."""
        return self.system.chain.mass_matrix(self.motion.turn)

    @cached_property
    def forces(self) -> Array:
        """Generalized forces on the links without those of contacts, N m."""
        return self.system.chain.forces(self.state.time, self.state.angles, self.motion)

    def touch(self, point: Point) -> Touch:
        """Return the kinematics of the contact at a point of a wire."""
        return self.system.obstacles[point.obstacle].touch(self.system.chain, self.motion, point)

    def acting(self, sustained: Iterable[Sustained]) -> list[Acting]:
        """Return the given contacts with their kinematics, friction and spring forces."""
        return [each.acting(self.touch(each.point)) for each in sustained]

    @cached_property
    def contacts(self) -> list[Acting]:
        """The sustained contacts with their kinematics, friction and spring forces."""
        return self.acting(self.system.sustained)

    @cached_property
    def balance(self) -> Balance:
        """Angular accelerations of the links and forces of the sustained contacts."""
        return balance(self.mass, self.forces, self.contacts)

    def gaps(self, name: str) -> Array:
        """Return the gaps between the wires and the obstacle of the given name, m.

        The shape is (..., pieces), or (..., pairs) for the gaps between wires.
        """
        if name not in self._gaps:
            self._gaps[name] = self.system.obstacles[name].gaps(self.system.chain, self.motion)
        return self._gaps[name]

    @cached_property
    def feet(self) -> Array:
        """Coordinate of the bar's centre along each straight piece (m), from ``Bar.feet``."""
        bar = self.system.obstacles["bar"]
        assert isinstance(bar, Bar)
        return bar.feet(self.system.chain, self.motion)
