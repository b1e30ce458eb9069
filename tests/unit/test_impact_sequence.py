"""Impacts of one instant, on points that are given by hand."""

from __future__ import annotations

import pymunk
import pytest

from bristle_sim.contact_space.contact_pair import ContactPair
from bristle_sim.contact_space.sequence import COLLAPSE, ImpactSequence
from bristle_sim.contact_space.step_motion import StepMotion
from bristle_sim.contact_space.touching import Contacts, Overlap, Shapes, TouchingPoint
from bristle_sim.theory.impact import Impact


def touching(first: pymunk.Body, second: pymunk.Body, restitution: float, normal: tuple[float, float]) -> TouchingPoint:
    """A frictionless point at the origin, where both bodies have their centres of gravity in line."""
    shapes = pymunk.Circle(first, 1.0), pymunk.Circle(second, 1.0)
    pair = ContactPair(1, 2, 0.0, restitution)
    return TouchingPoint(pair, shapes, (first, second), (0.0, 0.0), Overlap((0.0, 0.0), normal, 0.0))


def resolved(
    points: list[TouchingPoint], bodies: list[pymunk.Body], resting_speed: float, skipped: bool = True
) -> list[Impact]:
    """Resolve these points, which the engine was kept from or not, and return the impacts."""

    def read(body: pymunk.Body, known: Contacts) -> list[Shapes]:
        found = {frozenset(each.shapes): [each] for each in points if body in each.bodies}
        known.update(found)
        return list(found)

    impacts: list[Impact] = []
    keys = {frozenset(each.shapes) for each in points} if skipped else set()
    sequence = ImpactSequence(read, keys, resting_speed, StepMotion(), lambda _, impact: impacts.append(impact))
    sequence.resolve(bodies)
    return impacts


def ball(mass: float, x: float, velocity: tuple[float, float]) -> pymunk.Body:
    body = pymunk.Body(mass, 1.0)
    body.position, body.velocity = (x, 0.0), velocity
    return body


@pytest.mark.parametrize(
    ("speed", "skipped", "after", "impacts"),
    [
        (2.0, True, 1.0, 1),  # e = 0.5
        (2.0, False, 1.0, 1),
        (0.5, True, 0.0, 0),  # slow: without restitution, and nothing to report
        (0.5, False, -0.5, 0),  # the engine's
    ],
)
def test_slow_contacts_are_the_engines_unless_it_was_kept_from_them(
    speed: float, skipped: bool, after: float, impacts: int
) -> None:
    falling, floor = ball(2.0, 0.0, (0.0, -speed)), pymunk.Body(body_type=pymunk.Body.STATIC)
    recorded = resolved([touching(falling, floor, 0.5, (0.0, 1.0))], [falling], 1.0, skipped)
    assert falling.velocity == (0.0, pytest.approx(after, abs=1e-15))
    assert [each.impulse_normal for each in recorded] == impacts * [pytest.approx(2.0 * 1.5 * speed, rel=1e-15)]


def squeezed(ratio: float) -> tuple[list[pymunk.Body], list[int]]:
    """A light ball between two that are heavier by a ratio and come at 1 m/s, e = 1; the bodies, and impacts at each point."""
    light = ball(1.0, 0.0, (0.0, 0.0))
    left, right = ball(ratio, -1.0, (1.0, 0.0)), ball(ratio, 1.0, (-1.0, 0.0))
    points = [touching(light, left, 1.0, (1.0, 0.0)), touching(light, right, 1.0, (-1.0, 0.0))]
    resolved(points, [light, left, right], 1e-3)
    return [light, left, right], [each.impacts for each in points]


def test_a_light_ball_throws_two_heavy_ones_back() -> None:
    """After pi/2 sqrt(M/(2 m)) bounces off each, without loss: speeds in units of the root of the mass turn by an angle."""
    bodies, impacts = squeezed(100.0)
    assert impacts == [11, 11]
    assert energy(bodies) == pytest.approx(100.0, rel=1e-13)
    assert bodies[1].velocity.x < -0.99
    assert bodies[2].velocity.x > 0.99


@pytest.mark.parametrize("ratio", [1e3, 3e3, 1e6])
def test_balls_that_bounce_too_often_are_parted_at_once(ratio: float) -> None:
    """The light ball would bounce up to 1,100 times; a simultaneous elastic impact keeps energy and momentum too."""
    (light, left, right), impacts = squeezed(ratio)
    assert max(impacts) == COLLAPSE
    assert energy([light, left, right]) <= ratio * (1.0 + 1e-13)
    momentum = light.velocity.x + ratio * (left.velocity.x + right.velocity.x)
    assert momentum == pytest.approx(0.0, abs=1e-12 * ratio)


def energy(bodies: list[pymunk.Body]) -> float:
    return sum(0.5 * each.mass * each.velocity.x**2 for each in bodies)
