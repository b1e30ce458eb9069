"""The engine's own contacts between pairs of a scene: their shapes, which are ignored until a pair is engaged, and what they do."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import pymunk

from bristle_sim.scene.arbiters import ImpulseRecord, impulse_record
from bristle_sim.scene.mechanism import Mechanism, Vector
from bristle_sim.scene.obstacles import BarObstacle, Obstacle, WorkpartObstacle
from bristle_sim.scene.wire_pair import WirePair

FAST_SLIP, STICKING = 10.0, 1e9
"""A slip beyond what slip turns back by within an interval, in the scene's units, and a friction beyond any. The slip's rounding
disturbs the normal velocity."""

_NOWHERE = pymunk.ShapeFilter(categories=0, mask=0)


Key = tuple[str, int, int | None, int]
"""Tells pairs apart, whatever their surfaces."""


def _key(obstacle: Obstacle) -> Key:
    pieces = 8 * obstacle.own_piece + obstacle.partner_piece if isinstance(obstacle, WirePair) else 0
    return obstacle.name, obstacle.link, obstacle.partner, pieces


class ContactShapes:
    """Shapes of pairs in a space.

    Attributes:
        space, mechanism, links: of the scene.
        in_flight: iterations of the engine's solver where nothing is engaged.
    """

    def __init__(
        self,
        space: pymunk.Space,
        mechanism: Mechanism,
        links: Sequence[pymunk.Body],
        set_iterations: Callable[[int], None],
    ) -> None:
        """Add nothing: a pair's shapes come when it is engaged first."""
        self.space, self.mechanism, self.links = space, mechanism, links
        self.in_flight, self._set_iterations = space.iterations, set_iterations
        self._shapes: dict[Key, list[pymunk.Shape]] = {}
        self._engaged: dict[Key, tuple[pymunk.Shape, pymunk.Shape]] = {}

    def engage(
        self, obstacle: Obstacle, *, friction: float, elasticity: float, iterations: int, piece: int = 0
    ) -> None:
        """Let the engine's own contact act between a straight piece of a link and an obstacle from now on."""
        key = _key(obstacle)
        if key not in self._shapes:
            self._shapes[key] = self._add(obstacle)
        shapes = self._shapes[key]
        # An obstacle's shape, larger than the obstacle, would touch a neighbouring piece before its time.
        touching = (
            obstacle.touching(shapes, piece) if isinstance(obstacle, WirePair) else (shapes[0], shapes[1 + piece])
        )
        if self._engaged.get(key) != touching:
            self._engaged[key] = touching
            bit = 1 << list(self._engaged).index(key)
            own = pymunk.ShapeFilter(categories=bit, mask=bit)
            for shape in shapes:
                shape.filter = own if shape in touching else _NOWHERE
        touching[0].friction, touching[0].elasticity = friction, elasticity
        self._set_iterations(iterations)

    def direct_friction(self, obstacle: Obstacle, slip: int, tangent: Vector) -> None:
        """Let friction of an engaged pair act against slip of that sense; with 0 let it stick, whatever force that takes.

        Where slip stops, the motion would have a kink within a step. The engine is led to see a slip of one sense, or a
        friction without end, until the run changes it.
        """
        shape = self._engaged[_key(obstacle)][0]
        shape.surface_velocity = (-FAST_SLIP * slip * tangent[0], -FAST_SLIP * slip * tangent[1])
        if slip == 0:
            shape.friction = STICKING

    def release(self) -> None:
        """Let the engine ignore all obstacles again."""
        for key, (obstacles, _) in self._engaged.items():
            obstacles.surface_velocity = (0.0, 0.0)
            for shape in self._shapes[key]:
                shape.filter = _NOWHERE
        self._engaged = {}
        self._set_iterations(self.in_flight)

    def record(self, obstacle: Obstacle) -> ImpulseRecord:
        """Return a record of the impulses on a pair's link while no other pair is engaged."""
        return impulse_record(self.space, self.links[obstacle.link])

    def totals(self, obstacle: Obstacle) -> tuple[float, float, float]:
        """Return (normal, tangential) impulse of the last step on a pair's link, and its slip if there is friction."""
        body, found = self.links[obstacle.link], (0.0, 0.0, 0.0)
        # Where nothing else is engaged, a link has no other contact.
        shape = None if len(self._engaged) < 2 else self._engaged[_key(obstacle)][0]

        def look(arbiter: pymunk.Arbiter) -> None:
            nonlocal found
            if shape is not None and shape not in arbiter.shapes:
                return
            # Which way the engine's normal points, and the sign of its impulse, depend on the order of the shapes inside
            # the engine; a contact only pushes, which settles both.
            normal, impulse = arbiter.normal, arbiter.total_impulse
            push = impulse.dot(normal)
            rub = math.copysign(1.0, push) * impulse.dot((normal.y, -normal.x))
            found = (abs(push), rub, self._slip(arbiter, body, obstacle) if obstacle.friction else 0.0)

        body.each_arbiter(look)
        return found

    def _slip(self, arbiter: pymunk.Arbiter, body: pymunk.Body, obstacle: Obstacle) -> float:
        """Return the tangential velocity of a link where it touches, relative to its partner, as the bodies are."""
        points, first = arbiter.contact_point_set, arbiter.shapes[0].body is body
        found = 0.0
        for each in points.points:
            place = each.point_a if first else each.point_b
            velocity = body.velocity_at_world_point(place)
            if obstacle.partner is not None:
                velocity -= self.links[obstacle.partner].velocity_at_world_point(place)
            outwards = -1.0 if first else 1.0
            found = outwards * velocity.dot((points.normal.y, -points.normal.x))
        return found

    def _add(self, obstacle: Obstacle) -> list[pymunk.Shape]:
        """Add the shapes of a pair, which the engine ignores until they are engaged."""
        if isinstance(obstacle, WirePair):
            shapes = obstacle.shapes(self.links, self.mechanism)
        elif isinstance(obstacle, BarObstacle | WorkpartObstacle):
            link = self.mechanism.links[obstacle.link]
            corners = [(x - link.centre[0], y - link.centre[1]) for x, y in ((0.0, 0.0), *link.knees, link.tip)]
            shapes = obstacle.shapes(self.space, self.links[obstacle.link], corners)
        for shape in shapes:
            shape.filter = _NOWHERE
            shape.friction = 1.0
            shape.elasticity = 1.0
        self.space.add(*shapes)
        return shapes
