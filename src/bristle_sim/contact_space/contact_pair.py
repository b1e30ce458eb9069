"""A pair of collision types under an impact law, the points where its shapes touch, and the record of an impact there."""

from __future__ import annotations

import inspect
import math
import reprlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import pymunk

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


@dataclass(frozen=True, slots=True)
class LocatedImpact(Impact):
    """An impact with its place: what a report receives.

    Attributes:
        time: of the step at whose end it happened, since the contact was made.
        point: world coordinates.
        normal: unit vector towards the first body; the tangent is the normal turned clockwise.
        bodies: the body that the impulse acts on, which is dynamic, and the one that takes the opposite impulse.
    """

    time: float
    point: Vector
    normal: Vector
    bodies: tuple[pymunk.Body, pymunk.Body]

    @classmethod
    def of(cls, impact: Impact, touching: TouchingPoint, time: float) -> LocatedImpact:
        """Return the impact at a touching point."""
        given = {each.name: getattr(impact, each.name) for each in fields(Impact)}
        return cls(**given, time=time, point=touching.point, normal=touching.normal, bodies=touching.bodies)


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
    chained: Any = None
    """The user's own ``pre_solve`` of these types."""
    takes_stick_compliance: bool = False

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
        if not callable(self.law):
            raise refusal("law", self.law, "must be a function like energetic_impact")
        self.takes_stick_compliance = "stick_compliance" in inspect.signature(self.law).parameters

    @property
    def types(self) -> frozenset[int]:
        """The two types in any order."""
        return frozenset((self.collision_type_a, self.collision_type_b))

    def impact(self, space: ContactSpace, restitution: float) -> Impact:
        """Return the law's answer for a contact."""
        extra = (space.stick_compliance,) if self.takes_stick_compliance else ()
        return self.law(
            space.inverse_mass, space.velocity, self.friction, restitution, self.restitution_friction, *extra
        )


@dataclass(slots=True, eq=False)
class TouchingPoint:
    """A point where two bodies touch, during one step.

    Attributes:
        pair: the pair of the shapes.
        shapes: the two shapes.
        bodies: the first is dynamic.
        point: world coordinates.
        normal: unit vector towards the first body.
        surface_velocity: of the second body's surface less that of the first, as conveyors have it.
        approach: speed at which the bodies approach here.
        speed: largest speed of the two bodies here so far, to which ``approach`` is rounded.
        impacts: how many there were.
    """

    pair: ContactPair
    shapes: frozenset[pymunk.Shape]
    bodies: tuple[pymunk.Body, pymunk.Body]
    point: Vector
    normal: Vector
    surface_velocity: Vector
    approach: float = 0.0
    speed: float = 0.0
    impacts: int = 0

    def measure(self) -> None:
        """Take the approach from the velocities as they are."""
        first, second = (each.velocity_at_world_point(self.point) for each in self.bodies)
        x = first.x - second.x - self.surface_velocity[0]
        y = first.y - second.y - self.surface_velocity[1]
        self.approach = -(x * self.normal[0] + y * self.normal[1])
        self.speed = max(self.speed, math.hypot(x, y), first.length, second.length)


def read_points(
    arbiter: pymunk.Arbiter, pair: ContactPair, surface_velocity: Vector | None = None
) -> list[TouchingPoint]:
    """Return the points of a contact; ``surface_velocity``, of its second shape less the first's, if known better."""
    first, second = arbiter.bodies
    points = arbiter.contact_point_set
    slide = arbiter.surface_velocity if surface_velocity is None else surface_velocity
    # The engine's normal points from the first body to the second.
    sign = -1.0
    bodies = (first, second)
    if first.body_type != pymunk.Body.DYNAMIC:
        sign, bodies = 1.0, (second, first)
    normal = (sign * points.normal.x, sign * points.normal.y)
    relative = (-sign * slide[0], -sign * slide[1])
    found = []
    for each in points.points:
        middle = (each.point_a + each.point_b) / 2.0
        touching = TouchingPoint(pair, frozenset(arbiter.shapes), bodies, (middle.x, middle.y), normal, relative)
        touching.measure()
        found.append(touching)
    return found


def touching_points(
    pairs: Mapping[frozenset[int], ContactPair],
    surface_velocity: Callable[[tuple[pymunk.Shape, pymunk.Shape]], Vector | None],
    body: pymunk.Body,
) -> list[TouchingPoint]:
    """Return the touching points of a body in all pairs, without those that the engine was told to ignore."""
    found: list[TouchingPoint] = []

    def read(arbiter: pymunk.Arbiter) -> None:
        """Add the points at which a pair of this list touches."""
        shapes = arbiter.shapes
        pair = pairs.get(frozenset(each.collision_type for each in shapes))
        if pair is not None:
            found.extend(read_points(arbiter, pair, surface_velocity(shapes)))

    body.each_arbiter(read)
    return found
