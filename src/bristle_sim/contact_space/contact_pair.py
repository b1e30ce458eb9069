"""A pair of collision types under an impact law, the points where its shapes touch, and the record of an impact there."""

from __future__ import annotations

import inspect
import math
import reprlib
from collections.abc import Callable
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

import numpy as np
import pymunk

from bristle_sim.arrays import Array
from bristle_sim.contact_space.impulse import ContactSpace
from bristle_sim.contact_space.jacobian import Vector
from bristle_sim.theory.checks import checked_numbers
from bristle_sim.theory.impact import Impact, energetic_impact

MOST_TYPES = (1 << 64) - 1
"""Collision types are machine words, the last of which stands for any type."""


def refusal(name: str, value: Any, rule: str) -> ValueError:
    """Return the error, in one line, for a value that breaks a rule."""
    try:
        shown = " ".join(reprlib.repr(value).split())[:100]
    except ValueError:  # a whole number of thousands of digits, which Python does not write out
        shown = f"<{type(value).__name__}>"
    return ValueError(f"{name} = {shown}: {rule}")


def number_from_zero(name: str, value: Any, most: float, unit: str) -> float:
    """Return a number from 0 to ``most`` as a float, or raise ValueError."""
    try:
        number = math.nan if isinstance(value, bool) or not isinstance(value, Real) else float(value)
    except OverflowError:
        number = math.inf
    if not 0.0 <= number <= most:
        raise refusal(name, value, f"must be a finite number with 0 <= {name} <= {most:g} ({unit})")
    return number + 0.0


@dataclass(frozen=True, slots=True)
class LocatedImpact(Impact):
    """An impact with its place: what a report receives.

    Attributes:
        time: of the touch, since the contact was made.
        point: world coordinates.
        normal: unit vector towards the first body; the tangent is the normal turned clockwise.
        bodies: the body that the impulse acts on, which is dynamic, and the one that takes the opposite impulse.
    """

    time: float
    point: Vector
    normal: Vector
    bodies: tuple[pymunk.Body, pymunk.Body]


@dataclass(slots=True)
class ContactPair:
    """Two collision types, their coefficients and their law.

    Raises:
        ValueError: for coefficients out of range, types that are no collision types, a law that is no function.
    """

    collision_type_a: int
    collision_type_b: int
    friction: float
    restitution: float
    restitution_friction: float | None = None
    law: Callable[..., Impact] = energetic_impact
    tangential_compliance: float = 0.0
    chained: Any = None
    """The user's own ``pre_solve`` of these types."""
    _further: dict[str, float] = field(default_factory=dict)
    """Further arguments of the law by name; it gets none that it does not know."""

    def __post_init__(self) -> None:
        """Check every value: what the engine gets unchecked can end the process."""
        for name in ("collision_type_a", "collision_type_b"):
            kind = getattr(self, name)
            if isinstance(kind, bool) or not isinstance(kind, int) or not 0 <= kind < MOST_TYPES:
                raise refusal(name, kind, f"must be a whole number from 0 to {MOST_TYPES - 1}")
        if self.restitution_friction is None:
            self.restitution_friction = self.friction
        self.friction, self.restitution, self.restitution_friction = checked_numbers(
            friction=self.friction, restitution=self.restitution, restitution_friction=self.restitution_friction
        )
        compliance = number_from_zero("tangential_compliance", self.tangential_compliance, 1e4, "dimensionless")
        self.tangential_compliance = compliance
        try:
            known = inspect.signature(self.law).parameters.keys()
            self._further = {"tangential_compliance": compliance} if compliance else {}
            self._further |= {"stick_compliance": 1.0} if "stick_compliance" in known else {}
            answer: object = self._call(np.eye(2), (-1.0, 0.0), self.restitution, 1.0)
        except Exception as error:  # whatever the function thinks of these arguments
            if "tangential_compliance" in str(error):
                raise refusal(
                    "tangential_compliance", compliance, "must be 0 in a law that does not take it"
                ) from error
            answer = None
        if not isinstance(answer, Impact):
            raise refusal("law", self.law, "must be a function like energetic_impact, which returns an Impact")

    @property
    def types(self) -> frozenset[int]:
        """The two types in any order."""
        return frozenset((self.collision_type_a, self.collision_type_b))

    def impact(self, space: ContactSpace, *, rests: bool) -> Impact:
        """Return the law's answer for a contact, without restitution for one that comes to rest."""
        restitution = 0.0 if rests else self.restitution
        return self._call(space.inverse_mass, space.velocity, restitution, space.stick_compliance)

    def _call(self, inverse_mass: Array, velocity: Vector, restitution: float, stick_compliance: float) -> Impact:
        if "stick_compliance" in self._further:
            self._further["stick_compliance"] = stick_compliance
        coefficients = (self.friction, restitution, self.restitution_friction)
        return self.law(inverse_mass, velocity, *coefficients, **self._further)
