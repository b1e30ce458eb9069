"""How bodies moved in the engine's last step, and their state at any instant of it.

The engine moves positions by the old velocity and then changes velocities, a leapfrog: with V before a step of length h and
V + g after it, V is the velocity at the middle of the drift and V + g that half a step after the end. At the time s before
the end of the step

    x_s = x - s (V_end - g)    and    V_s = V_end - (s/h + 1/2) g.

The same two lines lead back to the end after an impact at that instant has changed V_s. For e* = 1 the energy that the leapfrog
keeps, V^2/2 of the end of the step and m g x, is then kept exactly in gravity; any other error is of second order in h.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.contact_space.jacobian import Connected, Vector, mass_centre
from bristle_sim.contact_space.projection import allowed_part

Motion = tuple[float, float, float]
"""v_x, v_y and angular velocity, or their change by forces, joints and contacts at rest in the step."""

NONE = (0.0, 0.0, 0.0)


def velocity_of(body: pymunk.Body) -> Motion:
    """Return a body's velocities."""
    velocity = lib.cpBodyGetVelocity(body._body)
    return velocity.x, velocity.y, lib.cpBodyGetAngularVelocity(body._body)


class StepMotion:
    """Velocities before a step, and their gains in it, for bodies that impacts may set in motion.

    Attributes:
        duration: of the step.
        gains: changes of velocity, by body; bodies that are not listed moved uniformly.
    """

    def __init__(self) -> None:
        self.duration = 0.0
        self.gains: dict[pymunk.Body, Motion] = {}
        self._groups: list[Connected] = []

    def note(self, connected: Connected) -> None:
        """Record velocities of jointed bodies within the step, before the engine changes them."""
        if connected[0] and connected[0][0] not in self.gains:
            self._groups.append(connected)
            self.gains.update({body: velocity_of(body) for body in connected[0]})

    def finish(self, duration: float) -> None:
        """Compute the gains after the step; a part that the joints do not permit is a correction of them, not motion."""
        self.duration = duration
        for bodies, joints in self._groups:
            for body in bodies:
                (u, v, turn), (x, y, w) = self.gains[body], velocity_of(body)
                self.gains[body] = (x - u, y - v, w - turn)
            if joints:
                gains = np.array([self.gains[body] for body in bodies]).ravel()
                allowed = allowed_part(bodies, joints, gains).reshape(-1, 3).tolist()
                self.gains.update({body: (u, v, turn) for body, (u, v, turn) in zip(bodies, allowed, strict=True)})

    def clear(self) -> None:
        """Discard the step's data."""
        self.gains.clear()
        self._groups.clear()

    def steps(self, time: float) -> float:
        """Return how many gains the velocities change by from a time before the end of the step to after it."""
        return time / self.duration + 0.5 if self.duration else 0.5

    def state(self, body: pymunk.Body) -> tuple[Motion, Motion, Vector]:
        """Return a body's velocities after the step, its gains and its mass centre."""
        return velocity_of(body), self.gains.get(body, NONE), mass_centre(body)

    def drift(self, bodies: Iterable[pymunk.Body], time: float) -> None:
        """Move bodies forward or back by a time, as the engine moves them within the step."""
        for body in bodies if time else ():
            raw, (x, y, w), (u, v, turn) = body._body, velocity_of(body), self.gains.get(body, NONE)
            lib.cpBodySetAngle(raw, lib.cpBodyGetAngle(raw) + time * (w - turn))  # about the mass centre
            place = lib.cpBodyGetPosition(raw)
            lib.cpBodySetPosition(raw, (place.x + time * (x - u), place.y + time * (y - v)))

    def kick(self, bodies: Iterable[pymunk.Body], steps: float) -> None:
        """Add a multiple of the gain to the velocities."""
        for body in bodies:
            if body in self.gains:
                (x, y, w), (u, v, turn) = velocity_of(body), self.gains[body]
                lib.cpBodySetVelocity(body._body, (x + steps * u, y + steps * v))
                lib.cpBodySetAngularVelocity(body._body, w + steps * turn)
