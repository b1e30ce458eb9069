"""The engine's bare calls do, bit for bit, what pymunk's documented ones do, and stand in for them only where they exist."""

import dataclasses

import pymunk
import pytest

from bristle_sim.contact_space import engine_calls
from bristle_sim.contact_space.energetic_contact import EnergeticContact
from bristle_sim.parameters import Bar, Tool
from bristle_sim.scene import engine
from bristle_sim.scene.contact import arbiters
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings

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
    step, put = engine.stepper(space), engine.placer([body])
    read, push = engine.point_reader(body, POINT), engine.pusher(body)
    angle, rate, (same,) = engine.readers([body])
    put((0.5, -0.1, 0.7, 0.25, 0.125, -1.5))
    seen = []
    for _ in range(5):
        x, y, u, v = read()
        push((-0.3 * u, 0.2), (x, y))
        step(0.01)
        seen.append((x, y, u, v, angle(same), rate(same), *body.position, *body.velocity))
    put(None)
    seen.append((*body.position, body.angle, *body.velocity, body.angular_velocity))
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
    seen.append((0.5, -0.1, 0.7, 0.25, 0.125, -1.5))
    return seen


def test_bare_calls_are_the_documented_ones() -> None:
    assert swing() == swing_by_pymunk()


def test_without_bare_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine_calls, "lib", None)
    space, body = pendulum()
    assert engine.stepper(space) == space.step
    assert engine.pusher(body) == body.apply_force_at_world_point
    assert swing() == swing_by_pymunk()


def test_every_body_takes_six_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """A kinematic body and two dynamic ones, by the bare call and by pymunk's own."""
    told = [float(number) for number in range(18)]
    for bare in (True, False):
        if not bare:
            monkeypatch.setattr(engine_calls, "lib", None)
        kinds = (pymunk.Body.KINEMATIC, pymunk.Body.DYNAMIC, pymunk.Body.DYNAMIC)
        bodies = [pymunk.Body(1.0, 1.0, kind) for kind in kinds]
        engine.placer(bodies)(told)
        assert told == [
            number for each in bodies for number in (*each.position, each.angle, *each.velocity, each.angular_velocity)
        ]
        angle, rate, same = engine.readers(bodies)
        assert list(map(angle, same)) == [2.0, 8.0, 14.0]
        assert list(map(rate, same)) == [5.0, 11.0, 17.0]


def test_the_first_step_is_checked_by_pymunk() -> None:
    """A body without mass would abort the process in the bare call."""
    space = pymunk.Space()
    space.add(pymunk.Body())
    with pytest.raises(AssertionError, match="mass"):
        engine.stepper(space)


def bounces() -> list[float]:
    """Heights of two balls that fall on each other and on a floor, under the energetic law."""
    space = pymunk.Space()
    space.gravity, floor = (0.0, -9.81), pymunk.Segment(space.static_body, (-9.0, -1.0), (9.0, -1.0), 1.0)
    space.add(floor)
    balls = []
    for height, sideways in ((0.3, 0.02), (0.7, 0.0)):
        body = pymunk.Body(1.0, 0.004)
        body.position = (sideways, height)
        space.add(body, pymunk.Circle(body, 0.1))
        balls.append(body)
    contact = EnergeticContact(space, 0, 0, friction=0.3, restitution=0.5)
    for _ in range(300):
        contact.step(1e-3)
    return [each for body in balls for each in (*body.position, body.angle)]


def test_contacts_are_read_alike_without_bare_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    bare = bounces()
    monkeypatch.setattr(engine_calls, "lib", None)
    assert bounces() == bare


def test_impulses_of_some_steps_are_noted_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ball on a floor, three steps of the same weight; bare or not, whichever way the engine's normal points."""
    space = pymunk.Space()
    space.gravity, floor = (0.0, -10.0), pymunk.Segment(space.static_body, (-9.0, -1.0), (9.0, -1.0), 1.0)
    ball = pymunk.Body(2.0, 0.004)
    ball.position = (0.3, 0.1)
    space.add(floor, ball, pymunk.Circle(ball, 0.1))
    bare = arbiters.impulse_record(space, ball)
    monkeypatch.setattr(engine_calls, "lib", None)
    documented = arbiters.impulse_record(space, ball)
    for _ in range(2):
        # What was noted before is forgotten, but for the last step's.
        stale = bare.begin()
        assert stale == documented.begin()
        for _ in range(3):
            space.step(1e-3)
            bare.note()
            documented.note()
    assert list(bare.read()) == list(documented.read())
    # Weight times step.
    assert stale == 4
    assert arbiters.pushes(bare.read()) == pytest.approx([0.02] * 4, rel=1e-9)


def a_pass() -> tuple[object, ...]:
    """A pass up to the strike, most of it on a smooth and a rough bar: placed, stepped, warmed up, its impulses read."""
    found: list[object] = []
    for friction in (0.0, 0.1):
        tool = dataclasses.replace(Tool(), bar=dataclasses.replace(Bar(), friction=friction))
        run = simulate(tool, Settings(accuracy=1e-4), stop_after="strike")
        found += [run.angles.tolist(), run.rates.tolist(), run.normal_force.tolist(), run.events, run.contacts]
    return tuple(found)


def test_a_pass_is_the_same_without_bare_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    bare = a_pass()
    monkeypatch.setattr(engine_calls, "lib", None)
    assert a_pass() == bare
