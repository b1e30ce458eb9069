"""A contact resolved in time that is elastic along the surface too: a tangential spring beside the normal one.

The tangential spring has stiffness k/eta^2, with k that of the normal spring in loading, and a foot on the surface. In stick the
foot stands still and the force is T = -(k/eta^2)(x - x_foot). Where that would leave the cone |T| <= mu N the foot slips in the
sense s, with T = -mu s N, until its velocity

    v_foot = v_t + (eta^2/k) dT/dt = v_t + mu s eta^2 kappa v_n

comes to zero; kappa is 1 in loading and 1/e*^2 in unloading. As the contact gets shorter its outcome tends to that of the impact
law with the same eta^2 (:mod:`bristle_sim.theory.impact_compliance`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from bristle_sim.scene.contact.obstacles import ClosestApproach, Obstacle
from bristle_sim.scene.contact.spring import Spring, SpringForce
from bristle_sim.scene.mechanism import Vector

if TYPE_CHECKING:
    from bristle_sim.scene.build import Scene

EDGE_ROUNDING = 1e-9  # fraction of friction's limit within which a force is at the cone's edge


@dataclass(slots=True, eq=False)
class ElasticSpring(Spring):
    """Normal and tangential spring, and Coulomb friction at the latter's foot.

    Attributes:
        squared: eta^2.
        foot: place of the tangential spring's foot along the surface.
    """

    elastic: ClassVar[bool] = True
    squared: float = 1.0
    foot: float = 0.0

    def force(self, scene: Scene, obstacle: Obstacle) -> SpringForce:
        """Return the springs' force as a load."""
        return ElasticForce(scene, obstacle, self)

    @property
    def along_surface(self) -> float:
        """Stiffness of the tangential spring."""
        return self.stiffness / self.squared

    def foot_speed(self, velocity: Vector) -> float:
        """Return the velocity of the foot for slip in the present sense."""
        steepness = self.present_stiffness / self.stiffness
        return velocity[1] + self.friction * self.slip * self.squared * steepness * velocity[0]

    def settle(self, touch: ClosestApproach, place: float, error: float) -> None:
        """Let the foot stand, or slip if the force is at the edge of the friction cone or beyond and would leave it.

        The sign of the foot's velocity decides, or, if the velocity is within the ``error``, that of its acceleration.
        """
        limit = self.friction * self.present_stiffness * max(self.surface - touch.gap - self.residual, 0.0)
        force = min(max(self.stick_force, -limit), limit)
        self.slip = int(-math.copysign(1.0, force) if force else math.copysign(1.0, touch.velocity[1]))
        speed = self.slip * self.foot_speed(touch.velocity)
        if abs(speed) <= error:
            (normal, coupling), (_, tangential) = self.inverse_mass.tolist()
            rub = -self.friction * self.slip
            speed = self.slip * self.foot_speed((normal + rub * coupling, coupling + rub * tangential))
        if self.friction and not (abs(force) >= limit * (1.0 - EDGE_ROUNDING) and speed > 0.0):
            self.slip = 0
        self.stick_force, self.foot = force, place + force / self.along_surface


class ElasticForce(SpringForce):
    """The force of both springs on a corner of a link."""

    spring: ElasticSpring

    def begin(self, step: float) -> Callable[[], None]:
        """Reset the sums. Return a callback that pushes for a step, by the phase that the springs are in."""
        spring, push, place_of, velocity_of = self.spring, self._push, self._place, self._velocity
        ratio, along_surface = -spring.friction * spring.slip, 0.0 if spring.slip else spring.along_surface
        stiffness, height, foot = spring.present_stiffness, spring.surface - spring.residual - self._level, spring.foot
        self._step, self._steps = step, []
        note = self._steps.append

        def act() -> None:
            place, velocity = place_of(), velocity_of()
            normal = stiffness * (height - place.y)
            along = ratio * normal - along_surface * (place.x - foot)
            push((along, normal), (place.x, place.y))
            note((normal, along, velocity.y, velocity.x))

        return act

    def totals(self) -> list[float]:
        """Return the six numbers; the force in stick is that at the end."""
        spring = self.spring
        last = 0.0 if spring.slip else -spring.along_surface * (self._place().x - spring.foot)
        return [*self._sums(), 0.0, last]
