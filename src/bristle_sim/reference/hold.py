"""Sustained touch: the obstacle's geometry leads the bristle, and the equation of motion gives the force.

With gap = 0 the bristle's angle is a function of the hub's alone; the contact force follows from

    gap'' = J_n alpha'' + bend = 0,    I alpha'' = torque + N (J_n - mu sign(v_t) J_t),

so N = -a_n I / (J_n (J_n - mu sign(v_t) J_t)), where a_n = J_n torque / I + bend is the normal acceleration that the
contact point would have without contact force: it is pressed on while a_n < 0. Where the bracket and J_n differ in
sign, friction locks the bristle and no force answers (the self-locking jam).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bristle_sim.reference.crossing import crossings, integral
from bristle_sim.reference.mechanics import Mechanics, Number, State
from bristle_sim.reference.obstacles import Obstacle
from bristle_sim.reference.touch import Touch

__all__ = ["Hold", "departure"]

Array = NDArray[np.float64]


def departure(mechanics: Mechanics, touch: Touch, time: Number, angle: Number, rate: Number) -> Number:
    """Normal acceleration a_n of the contact point without contact force, m/s^2; negative presses on."""
    return touch.normal_lever * mechanics.torque(time, angle, rate) / mechanics.inertia + touch.bend


@dataclass(frozen=True, slots=True)
class Hold:
    """The motion along one obstacle; ``side``, the sign of J_n, is which of its two branches."""

    mechanics: Mechanics
    obstacle: Obstacle
    side: float

    def motion(self, time: Array) -> Array:
        """Relative angle and rate, shape (2, n): v_n = J_n alpha' + drift = 0."""
        hub_angle = self.mechanics.hub_angle(time)
        angle = self.obstacle.held_angle(hub_angle, self.side)
        touch = self.obstacle.touch(angle, 0.0, hub_angle)
        return np.stack([angle, -touch.normal_drift / touch.normal_lever])

    def state(self, time: float) -> State:
        """The motion at one instant."""
        angle, rate = self.motion(np.array([time]))[:, 0]
        return State(time, float(angle), float(rate))

    def touch(self, time: Array) -> Touch:
        """Kinematics of the contact point along the motion."""
        angle, rate = self.motion(time)
        return self.obstacle.touch(angle, rate, self.mechanics.hub_angle(time))

    def within_reach(self, time: Array) -> Array:
        """Positive while some bristle angle touches the obstacle, m."""
        return np.asarray(self.obstacle.within_reach(self.mechanics.hub_angle(time)))

    def seams(self, start: float, end: float, resolution: float) -> list[float]:
        """Times between two instants at which the motion passes from one smooth stretch to another."""
        found = (crossings(self._over(seam), start, end, resolution) for seam in self.obstacle.seams(self.side))
        return [time for each in found for time, _ in each]

    def _over(self, function: Callable[[Number], Number]) -> Callable[[Array], Array]:
        return lambda time: np.asarray(function(self.mechanics.hub_angle(time)))

    def departure(self, time: Array) -> Array:
        """a_n along the motion, m/s^2."""
        return np.asarray(departure(self.mechanics, self.touch(time), time, *self.motion(time)))

    def freedom(self, time: Array) -> Array:
        """J_n (J_n - mu sign(v_t) J_t), m^2; friction locks the bristle where it is not positive."""
        touch = self.touch(time)
        resisting = touch.normal_lever - self.obstacle.friction * np.sign(self.slip(time)) * touch.tangential_lever
        return np.asarray(touch.normal_lever * resisting)

    def force(self, time: Array) -> Array:
        """Normal force N; N."""
        return -self.departure(time) * self.mechanics.inertia / self.freedom(time)

    def friction(self, time: Array) -> Array:
        """Tangential force -mu sign(v_t) N; N."""
        return -self.obstacle.friction * np.sign(self.slip(time)) * self.force(time)

    def impulse(self, start: float, end: float) -> tuple[float, float]:
        """(normal, tangential) impulse between two instants, N s."""
        return integral(self.force, start, end), integral(self.friction, start, end)

    def friction_work(self, start: float, end: float) -> float:
        """Work of friction on the bristle, J."""
        return integral(lambda time: self.friction(time) * self.slip(time), start, end)

    def slip(self, time: Array) -> Array:
        """Tangential velocity of the contact point, m/s."""
        return np.asarray(self.touch(time).velocity(self.motion(time)[1])[1])
