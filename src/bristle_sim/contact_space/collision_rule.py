"""Two collision types under an impact law, and the record of an impact between them."""

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pymunk

from bristle_sim.arrays import Array
from bristle_sim.contact_space.impulse import ContactSpace
from bristle_sim.contact_space.joints import Vector
from bristle_sim.theory.impact import Impact, energetic_impact
from bristle_sim.theory.numbers import checked_numbers

# Largest collision type plus 1: types are machine words, and the last word means any type.
MOST_TYPES = (1 << 64) - 1


def refusal(name: str, value: Any, rule: str) -> ValueError:
    """Return the ValueError, in one line, for a value that breaks a rule."""
    try:
        text = " ".join(reprlib.repr(value).split())[:100]
    except ValueError:  # Python does not convert an integer of thousands of digits to text
        text = f"<{type(value).__name__}>"
    return ValueError(f"{name} = {text}: {rule}")


@dataclass(frozen=True, slots=True)
class LocatedImpact(Impact):
    """An impact with its time, place and bodies, as passed to ``report``.

    Attributes:
        time: instant of the touch, since the EnergeticContact was created.
        point: world coordinates of the contact.
        normal: unit vector towards the first body; the tangent is the normal turned clockwise.
        bodies: the dynamic body on which the impulse acts, and the body on which the opposite
        impulse acts.
    """

    time: float
    point: Vector
    normal: Vector
    bodies: tuple[pymunk.Body, pymunk.Body]


class CollisionRule:
    """Two collision types with their coefficients and their impact law.

    All are checked, since a bad value can make the engine abort the process.

    Attributes:
        friction: Coulomb's mu in compression and at rest.
        chained: the user's own ``pre_solve`` of these types.

    Raises:
        ValueError: for coefficients out of range, invalid collision types, or a law that is not
            callable.
    """

    def __init__(
        self,
        types: tuple[Any, Any],
        friction: float,
        restitution: float,
        restitution_friction: float | None = None,
        tangential_compliance: float = 0.0,
        law: Callable[..., Impact] = energetic_impact,
    ) -> None:
        for name, kind in zip(("collision_type_a", "collision_type_b"), types, strict=True):
            if isinstance(kind, bool) or not isinstance(kind, int) or not 0 <= kind < MOST_TYPES:
                raise refusal(name, kind, f"must be a whole number from 0 to {MOST_TYPES - 1}")
        later = friction if restitution_friction is None else restitution_friction
        self.friction, self.restitution, self.restitution_friction, compliance = checked_numbers(
            friction=friction,
            restitution=restitution,
            restitution_friction=later,
            tangential_compliance=tangential_compliance,
        )
        self.chained: Any = None
        self._law = law
        self._further = {"tangential_compliance": compliance} if compliance else {}
        try:
            # The law is called without arguments that it does not accept.
            self._knows_stick = "stick_compliance" in inspect.signature(law).parameters
            answer: object = self._call(np.eye(2), (-1.0, 0.0), self.restitution, 1.0)
        except Exception as error:  # of any kind: the function is the user's
            if "tangential_compliance" in str(error):
                unknown = "must be 0 in a law that does not take it"
                raise refusal("tangential_compliance", compliance, unknown) from error
            answer = None
        if not isinstance(answer, Impact):
            raise refusal(
                "law", law, "must be a function like energetic_impact, which returns an Impact"
            )

    def impact(self, space: ContactSpace, *, rests: bool) -> Impact:
        """Return the impact by the pair's law; a contact that comes to rest has no restitution."""
        return self._call(
            space.inverse_mass,
            space.velocity,
            0.0 if rests else self.restitution,
            space.stick_compliance,
        )

    def _call(
        self, inverse_mass: Array, velocity: Vector, restitution: float, stick_compliance: float
    ) -> Impact:
        further = {"stick_compliance": stick_compliance} if self._knows_stick else {}
        coefficients = (self.friction, restitution, self.restitution_friction)
        return self._law(inverse_mass, velocity, *coefficients, **further, **self._further)
