"""The energetic impact law in anybody's pymunk space: contacts are found by the engine and resolved by the law.

Chipmunk restores a share of the approach velocity (Newton's restitution) and iterates Coulomb friction; where bodies are
joined, that can create energy. Here the engine still finds the contacts and solves the joints, but an approaching contact
takes the impulse of Stronge's law, on all bodies that joints connect to it, at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pymunk

from bristle_sim.quantity import Range, shown
from bristle_sim.scene.contact_space import contact_space
from bristle_sim.theory.impact import Impact, energetic_impact

__all__ = ["EnergeticContact"]

ROUNDS = 10
"""Rounds over the contacts of a step: an impact at one can drive another into its surface again."""

MOST_TYPES = 1 << 63
"""Collision types are machine words."""

DURATION = Range("duration", "time", 0.0, 1e9, True, "the engine lets NaN pass")
"""Of a step."""

ROUNDING = 1e-9
"""Share of a step's fastest approach below which a contact is at rest."""


@dataclass(frozen=True, slots=True)
class _Touching:
    body: pymunk.Body
    other: pymunk.Body
    point: tuple[float, float]
    normal: tuple[float, float]


class EnergeticContact:
    """Energetic restitution and Coulomb friction between two collision types of a space.

    Args:
        space: the space; its own units.
        collision_type_a, collision_type_b: of the shapes concerned; the engine no longer responds to their contacts.
        friction: Coulomb's mu, >= 0.
        restitution: energetic coefficient e*, in [0, 1].
        restitution_friction: mu in restitution; equal to ``friction`` by default.
        resting_speed: approach slower than this takes no restitution, so that bodies come to rest.
        report: called with each Impact.

    Raises:
        ValueError: for coefficients out of range, and for anything but a space and collision types.

    Step the space with :meth:`step` instead of ``space.step``. Several contacts at one instant are resolved one after
    the other, the fastest approach first. Penetration is not corrected.
    """

    def __init__(
        self,
        space: pymunk.Space,
        collision_type_a: int,
        collision_type_b: int,
        *,
        friction: float,
        restitution: float,
        restitution_friction: float | None = None,
        resting_speed: float = 0.0,
        report: Callable[[Impact], None] | None = None,
    ) -> None:
        """See the class."""
        if not isinstance(space, pymunk.Space):
            raise ValueError(f"space = {shown(space)}: a pymunk.Space is allowed")
        types: dict[str, Any] = {"collision_type_a": collision_type_a, "collision_type_b": collision_type_b}
        for name, kind in types.items():
            if isinstance(kind, bool) or not isinstance(kind, int) or not 0 <= kind < MOST_TYPES:
                raise ValueError(f"{name} = {shown(kind)}: a whole number from 0 to {MOST_TYPES - 1} is allowed")
        if not (report is None or callable(report)):
            raise ValueError(f"report = {shown(report)}: None or a function of one Impact is allowed")
        self.space = space
        self.friction = Range("friction", "1", 0.0, 1e9, True, "Coulomb").check(friction)
        self.restitution = Range("restitution", "1", 0.0, 1.0, True, "Stronge 1990").check(restitution)
        later = friction if restitution_friction is None else restitution_friction
        self.restitution_friction = Range("restitution_friction", "1", 0.0, 1e9, True, "Coulomb").check(later)
        self.resting_speed = Range("resting_speed", "length/time", 0.0, 1e300, True, "chosen").check(resting_speed)
        self.report = report
        self._touching: list[_Touching] = []
        space.on_collision(collision_type_a, collision_type_b, pre_solve=self._notice)

    def step(self, duration: float) -> None:
        """One engine step, then the impacts of the contacts it found.

        Raises:
            ValueError: for a duration that is negative or not finite, or if a body that is hit hangs on a joint that is
                neither pivot nor pin.
        """
        self._touching.clear()
        self.space.step(DURATION.check(duration))
        fastest = 0.0
        for _ in range(ROUNDS):
            approach = self._resolve_fastest(ROUNDING * fastest)
            if approach == 0.0:
                return
            fastest = max(fastest, approach)

    def _notice(self, arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: Any) -> None:
        """Remember the points of a contact, and keep the engine from responding to it."""
        arbiter.process_collision = False
        body, other = arbiter.bodies
        normal = -arbiter.contact_point_set.normal
        if body.body_type != pymunk.Body.DYNAMIC:
            body, other, normal = other, body, -normal
        for point in arbiter.contact_point_set.points:
            middle = (point.point_a + point.point_b) / 2.0
            self._touching.append(_Touching(body, other, (middle.x, middle.y), (normal.x, normal.y)))

    def _resolve_fastest(self, least: float) -> float:
        """Resolve the contact that approaches fastest, if faster than ``least``; its approach, or 0."""
        spaces = [contact_space(each.body, each.point, each.normal, each.other) for each in self._touching]
        approaching = [space for space in spaces if -space.velocity[0] > least]
        if not approaching:
            return 0.0
        fastest = min(approaching, key=lambda space: space.velocity[0])
        rests = -fastest.velocity[0] <= self.resting_speed
        impact = energetic_impact(
            fastest.inverse_mass,
            fastest.velocity,
            self.friction,
            0.0 if rests else self.restitution,
            self.restitution_friction,
            fastest.stick_compliance,
        )
        impulse = (impact.impulse_normal, impact.impulse_tangential)
        fastest.apply(impulse, (impact.velocity_normal, impact.velocity_tangential))
        if self.report is not None:
            self.report(impact)
        return -fastest.velocity[0]
