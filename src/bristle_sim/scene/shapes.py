"""The engine's own contact of a link with a fixed pair, for an impact by the engine's law."""

from __future__ import annotations

from typing import Any

import pymunk

from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import Vector
from bristle_sim.scene.pairs import ContactPair, WirePair


def engine_impact(
    scene: Scene, pair: ContactPair, piece: int, normal: Vector, iterations: int, step: float
) -> Vector:
    """Take one engine step in which the engine resolves an impact; return the normal and the tangential impulse on the link.

    Args:
        scene: the scene, placed at the instant of the impact.
        pair: the pair, whose coefficients are the engine's elasticity and friction.
        piece: straight piece of the link that touches.
        normal: unit vector out of the obstacle.
        iterations: of the engine's solver.
        step: length of the step, so short that only the impact happens in it.
    """
    assert not isinstance(pair, WirePair), (
        "the engine's own contacts are those of a link with a fixed obstacle"
    )
    space = scene.engine.space
    link = scene.mechanism.links[pair.link]
    corners = [
        (x - link.centre[0], y - link.centre[1]) for x, y in ((0.0, 0.0), *link.knees, link.tip)
    ]
    obstacle, *pieces = pair.shapes(space, scene.links[pair.link], corners)
    touching = pieces[piece]
    for shape in (obstacle, touching):
        shape.friction = shape.elasticity = 1.0
    obstacle.friction = pair.friction
    obstacle.elasticity = pair.restitution
    impulses: list[pymunk.Vec2d] = []

    def note(arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        del space, data
        impulses.append(arbiter.total_impulse)

    space.add(obstacle, touching)
    space.on_collision(post_solve=note)
    before = space.iterations
    space.iterations = iterations
    scene.step(step, 1)
    space.iterations = before
    space.on_collision()
    space.remove(obstacle, touching)
    if not impulses:
        return (0.0, 0.0)
    (x, y) = impulses[0]
    push = x * normal[0] + y * normal[1]
    rub = x * normal[1] - y * normal[0]
    # The sign of the engine's impulse depends on the order of the shapes; a contact only pushes.
    return (push, rub) if push >= 0.0 else (-push, -rub)
