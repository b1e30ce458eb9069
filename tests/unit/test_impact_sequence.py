"""Impacts of one instant, on points that are given by hand."""

from __future__ import annotations

import pymunk
import pytest

from bristle_sim.contact_space.contact_pair import ContactPair, TouchingPoint
from bristle_sim.contact_space.sequence import COLLAPSE, ImpactSequence
from bristle_sim.theory.impact import Impact, energetic_impact


def touching(first: pymunk.Body, second: pymunk.Body, restitution: float, normal: tuple[float, float]) -> TouchingPoint:
    """A frictionless point at the origin, where both bodies have their centres of gravity in line."""
    shapes = frozenset((pymunk.Circle(first, 1.0), pymunk.Circle(second, 1.0)))
    pair = ContactPair(1, 2, 0.0, restitution, None, energetic_impact)
    return TouchingPoint(pair, shapes, (first, second), (0.0, 0.0), normal, (0.0, 0.0))


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
    point, recorded = touching(falling, floor, 0.5, (0.0, 1.0)), list[Impact]()
    sequence = ImpactSequence(lambda _: [point], 1.0, lambda _, impact: recorded.append(impact))
    sequence.resolve([falling], {point.shapes} if skipped else set())
    assert falling.velocity == (0.0, pytest.approx(after, abs=1e-15))
    assert [each.impulse_normal for each in recorded] == impacts * [pytest.approx(2.0 * 1.5 * speed, rel=1e-15)]


def squeezed(ratio: float) -> tuple[list[pymunk.Body], list[int]]:
    """A light ball between two that are heavier by a ratio and come at 1 m/s, e = 1; the bodies, and impacts at each point."""
    light = ball(1.0, 0.0, (0.0, 0.0))
    left, right = ball(ratio, -1.0, (1.0, 0.0)), ball(ratio, 1.0, (-1.0, 0.0))
    points = [touching(light, left, 1.0, (1.0, 0.0)), touching(light, right, 1.0, (-1.0, 0.0))]
    of = {light: points, left: points[:1], right: points[1:]}
    sequence = ImpactSequence(of.__getitem__, 1e-3, lambda *_: None)
    sequence.resolve([light, left, right], {each.shapes for each in points})
    return [light, left, right], [each.impacts for each in points]


@pytest.mark.parametrize(("ratio", "bounces"), [(100.0, 11), (1000.0, 35)])
def test_a_light_ball_throws_two_heavy_ones_back(ratio: float, bounces: int) -> None:
    """After pi/2 sqrt(M/(2 m)) bounces off each, without loss: speeds in units of the root of the mass turn by an angle."""
    bodies, impacts = squeezed(ratio)
    assert impacts == [bounces, bounces]
    energy = sum(0.5 * each.mass * each.velocity.x**2 for each in bodies)
    assert energy == pytest.approx(ratio, rel=1e-13)
    assert bodies[1].velocity.x < -0.99
    assert bodies[2].velocity.x > 0.99


def test_a_ball_that_bounces_too_often_gives_no_restitution() -> None:
    """It would bounce 61 times off each; at the fifty-first impact it stays with that ball."""
    (light, left, right), impacts = squeezed(3000.0)
    assert impacts == [COLLAPSE + 1, COLLAPSE]
    assert light.velocity.x == pytest.approx(left.velocity.x, rel=1e-14)
    momentum = light.velocity.x + 3000.0 * (left.velocity.x + right.velocity.x)
    assert momentum == pytest.approx(0.0, abs=1e-10)
    assert left.velocity.x < 0.0 < right.velocity.x
