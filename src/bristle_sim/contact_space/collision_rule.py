"""Two collision types under an impact law, and the record of an impact between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pymunk

from bristle_sim.arrays import Array
from bristle_sim.contact_space.joints import Vector
from bristle_sim.theory.impact import Impact
from bristle_sim.theory.numbers import checked_numbers
from bristle_sim.units import shown

# Largest collision type plus 1. Types are machine words, and the largest word means any type.
MOST_TYPES = (1 << 64) - 1


@dataclass(frozen=True, slots=True)
class LocatedImpact(Impact):
    """An impact with its time, location and bodies.

    An EnergeticContact passes an object of this class to the user's function ``report``. All
    numbers are in the units of the space.

    Attributes:
        time: time of the touch, measured from the creation of the EnergeticContact.
        point: world coordinates (x, y) of the contact.
        normal: unit vector (x, y) towards the first body; the tangent is the normal turned
            clockwise.
        bodies: the first body, which is dynamic and on which the impulse acts, and the second body,
            on which the opposite impulse acts.
    """

    time: float
    point: Vector
    normal: Vector
    bodies: tuple[pymunk.Body, pymunk.Body]


class CollisionRule:
    """The impact law and the coefficients for contacts between two collision types.

    All arguments are checked, because the engine may abort the process on an invalid value.

    Attributes:
        friction: Coulomb's coefficient of friction in compression and at rest.
        restitution: energetic coefficient of restitution.
        restitution_friction: coefficient of friction in restitution.
        tangential_compliance: ratio of the normal to the tangential contact stiffness.
        chained: the user's own ``pre_solve`` callback for these types, or None.

    Raises:
        ValueError: for coefficients out of range, invalid collision types, or a law that is not
            callable.
    """

    def __init__(
        self,
        types: tuple[Any, Any],
        friction: float,
        restitution: float,
        restitution_friction: float | None,
        tangential_compliance: float,
        law: Callable[..., Impact],
    ) -> None:
        for name, kind in zip(("collision_type_a", "collision_type_b"), types, strict=True):
            if isinstance(kind, bool) or not isinstance(kind, int) or not 0 <= kind < MOST_TYPES:
                raise ValueError(
                    f"{name} = {shown(kind)}: must be a whole number from 0 to {MOST_TYPES - 1}"
                )
        later = friction if restitution_friction is None else restitution_friction
        coefficients = checked_numbers(
            friction=friction,
            restitution=restitution,
            restitution_friction=later,
            tangential_compliance=tangential_compliance,
        )
        self.friction, self.restitution, self.restitution_friction, compliance = coefficients
        self.tangential_compliance = compliance
        self.chained: Any = None
        self._law = law
        try:
            answer: object = self.impact(np.eye(2), (-1.0, 0.0), 1.0, rests=False)
        except Exception as error:  # of any kind: the function is the user's
            if str(error).startswith("tangential_compliance"):
                raise
            answer = None
        if not isinstance(answer, Impact):
            raise ValueError(
                f"law = {shown(law)}: must be a function like energetic_impact, which returns an Impact"
            )

    def impact(
        self, inverse_mass: Array, velocity: Vector, stick_compliance: float, *, rests: bool
    ) -> Impact:
        """Return the impact that the law predicts for two shapes of these collision types.

        Args:
            inverse_mass: inverse mass matrix of the contact point, order (normal, tangential).
            velocity: (normal, tangential) velocity of the contact point before the impact.
            stick_compliance: change of the normal velocity per unit normal impulse in stick.
            rests: whether to set the restitution to 0, so that the contact comes to rest.
        """
        return self._law(
            inverse_mass,
            velocity,
            self.friction,
            0.0 if rests else self.restitution,
            self.restitution_friction,
            stick_compliance,
            self.tangential_compliance,
        )
