"""Units inside the engine: scaled so that every number near an impact is near 1.

The engine's tolerances are absolute and its biases are per time unit, so results would depend on the units a scene
happens to be given in. A scene therefore runs in units of its own size: a link's length, a link's mass and the time
scale of its motion. This module is the only place that knows their relation to SI.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Units:
    """SI size of one engine unit: length in m, mass in kg, time in s."""

    length: float
    mass: float
    time: float

    @property
    def velocity(self) -> float:
        """m/s."""
        return self.length / self.time

    @property
    def impulse(self) -> float:
        """N s."""
        return self.mass * self.velocity

    @property
    def force(self) -> float:
        """N."""
        return self.impulse / self.time

    @property
    def energy(self) -> float:
        """J, and N m."""
        return self.mass * self.velocity**2

    @property
    def acceleration(self) -> float:
        """m/s^2."""
        return self.velocity / self.time

    @property
    def angular_damping(self) -> float:
        """N m s."""
        return self.energy * self.time
