"""Placing the bodies of a scene exactly where a state says, joints closed and velocities consistent."""

from __future__ import annotations

import math

from bristle_sim.scene.engine import Placer
from bristle_sim.scene.mechanism import Mechanism, State


class Placement:
    """Puts the bodies of a scene where a state says.

    Attributes:
        turned: whole turns that the engine's angles leave out, rad.
        placements: number of them so far.
    """

    def __init__(self, mechanism: Mechanism, put: Placer, *, has_hub: bool) -> None:
        """Prepare to place the bodies: the hub if there is one, then the links."""
        self.mechanism, self.has_hub = mechanism, has_hub
        self.turned = 0.0
        self.placements = 0
        self._put = put
        # Runs over one interval all start from one state.
        self._last: tuple[State | None, float] = (None, 0.0)

    def place(self, state: State, drift: float = 0.0) -> None:
        """Put every body where its velocity, from the state and without forces, takes it in the time ``drift``."""
        self.placements += 1
        if self._last[0] is state and self._last[1] == drift:
            self._put(None)
            return
        self._last = (state, drift)
        self._put(self._values(state, drift))

    def _values(self, state: State, drift: float) -> list[float]:
        """Return what the engine is told of every body."""
        values: list[float] = []
        if self.has_hub:
            hub_angle = self.mechanism.hub_angle(state.time + drift)
            # Rounding of an angle grows with its size, and extrapolation magnifies it.
            self.turned = math.tau * round(hub_angle / math.tau)
            values += (0.0, 0.0, hub_angle - self.turned, 0.0, 0.0, self.mechanism.hub_speed)
        for pose, angle, rate in zip(self.mechanism.poses(state), state.angles, state.rates, strict=True):
            (x, y), (u, v) = pose.centre, pose.centre_velocity
            values += (x + drift * u, y + drift * v, angle - self.turned + drift * rate, u, v, rate)
        return values
