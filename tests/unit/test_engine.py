"""The engine's bare calls do, bit for bit, what pymunk's documented ones do."""

import pymunk
import pytest

from bristle_sim.scene import engine

POINT = (0.1, -0.5)


def pendulum() -> tuple[pymunk.Space, pymunk.Body]:
    space = pymunk.Space()
    space.gravity = (0.0, -9.81)
    body = pymunk.Body(1.3, 0.4)
    space.add(body, pymunk.PivotJoint(space.static_body, body, (0.2, 0.3), (0.0, 0.5)))
    return space, body


def swing() -> list[tuple[float, ...]]:
    """Some steps of a pendulum that is placed, read and pushed on, as the engine module does it."""
    space, body = pendulum()
    step, put = engine.stepper(space), engine.placer(body)
    read, push = engine.point_reader(body, POINT), engine.pusher(body)
    put(0.7, (0.5, -0.1), (0.25, 0.125), -1.5)
    seen = []
    for _ in range(5):
        x, y, u, v = read()
        push((-0.3 * u, 0.2), (x, y))
        step(0.01)
        seen.append((x, y, u, v, body.angle, body.angular_velocity, *body.position, *body.velocity))
    return seen


def swing_by_pymunk() -> list[tuple[float, ...]]:
    """Swing the pendulum by pymunk's documented calls."""
    space, body = pendulum()
    body.angle, body.position, body.velocity, body.angular_velocity = 0.7, (0.5, -0.1), (0.25, 0.125), -1.5
    seen = []
    for _ in range(5):
        (x, y), (u, v) = body.local_to_world(POINT), body.velocity_at_local_point(POINT)
        body.apply_force_at_world_point((-0.3 * u, 0.2), (x, y))
        space.step(0.01)
        seen.append((x, y, u, v, body.angle, body.angular_velocity, *body.position, *body.velocity))
    return seen


def test_bare_calls_are_the_documented_ones() -> None:
    assert swing() == swing_by_pymunk()


def test_the_first_step_is_checked_by_pymunk() -> None:
    """A body without mass would abort the process in the bare call."""
    space = pymunk.Space()
    space.add(pymunk.Body())
    with pytest.raises(AssertionError, match="mass"):
        engine.stepper(space)
