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

from bristle_sim.contact_space.jacobian import Connected, Vector
from bristle_sim.contact_space.projection import allowed_part

Gain = tuple[float, float, float]
"""Change of (v_x, v_y, angular velocity) by forces, joints and contacts at rest in the step."""

NONE = (0.0, 0.0, 0.0)


class StepMotion:
    """Velocities before a step, and the gains in it, of the bodies that impacts may set in motion.

    Attributes:
        duration: of the step.
        gains: by body; bodies that are not noted moved uniformly.
    """

    def __init__(self) -> None:
        """No step has been taken."""
        self.duration = 0.0
        self.gains: dict[pymunk.Body, Gain] = {}
        self._groups: list[Connected] = []
        self._states: dict[pymunk.Body, tuple[Gain, Gain, Vector]] = {}

    def note(self, connected: Connected) -> None:
        """Note velocities of jointed bodies within the step, before the engine changes them."""
        if connected[0] and connected[0][0] not in self.gains:
            self._groups.append(connected)
            for body in connected[0]:
                (x, y), turn = body.velocity, body.angular_velocity
                self.gains[body] = (-x, -y, -turn)

    def finish(self, duration: float) -> None:
        """Add the velocities after the step; the gain that joints do not let pass is a correction of them, not motion."""
        self.duration = duration
        for bodies, joints in self._groups:
            for body in bodies:
                (u, v, turn), (x, y) = self.gains[body], body.velocity
                self.gains[body] = (x + u, y + v, turn + body.angular_velocity)
            if joints:
                gains = np.array([self.gains[body] for body in bodies]).ravel()
                allowed = allowed_part(bodies, joints, gains).reshape(-1, 3).tolist()
                self.gains.update({body: (u, v, turn) for body, (u, v, turn) in zip(bodies, allowed, strict=True)})

    def clear(self) -> None:
        """Forget the step."""
        for each in (self.gains, self._groups, self._states):
            each.clear()

    def steps(self, time: float) -> float:
        """Return the number of gains from the velocities at a time before the end of the step to those after it."""
        return time / self.duration + 0.5 if self.duration else 0.5

    def state(self, body: pymunk.Body) -> tuple[Gain, Gain, Vector]:
        """Return a body's velocities after the step, its gains and its mass centre, until it is forgotten."""
        found = self._states.get(body)
        if found is None:
            (x, y), centre = body.velocity, body.local_to_world(body.center_of_gravity)
            found = (x, y, body.angular_velocity), self.gains.get(body, NONE), (centre.x, centre.y)
            self._states[body] = found
        return found

    def forget(self, bodies: Iterable[pymunk.Body]) -> None:
        """Forget the states of bodies that were set in motion anew."""
        for body in bodies:
            self._states.pop(body, None)

    def drift(self, bodies: Iterable[pymunk.Body], time: float) -> None:
        """Move bodies on by a time, or back, as the engine moves them within the step."""
        for body in bodies if time else ():
            (x, y), (u, v, turn) = body.velocity, self.gains.get(body, NONE)
            centre = body.local_to_world(body.center_of_gravity)
            body.angle += time * (body.angular_velocity - turn)
            after = body.local_to_world(body.center_of_gravity)
            place = body.position
            body.position = (
                place.x + centre.x - after.x + time * (x - u),
                place.y + centre.y - after.y + time * (y - v),
            )

    def kick(self, bodies: Iterable[pymunk.Body], steps: float) -> None:
        """Add the gain of so many steps to the velocities."""
        for body in bodies:
            if body in self.gains:
                u, v, turn = self.gains[body]
                x, y = body.velocity
                body.velocity = (x + steps * u, y + steps * v)
                body.angular_velocity += steps * turn
