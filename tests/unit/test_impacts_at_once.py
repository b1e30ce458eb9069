"""The instant of touch, the bounded cost of a step, and copies of a space with an EnergeticContact."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable

import numpy as np
import pymunk
import pytest

from bristle_sim.contact_space.collision_rule import LocatedImpact
from bristle_sim.contact_space.energetic_contact import EnergeticContact
from bristle_sim.contact_space.sequence import MOST
from bristle_sim.theory.impact import Impact, energetic_impact, newton_impact

GRAVITY = 9.81


def kinetic_energy(space: pymunk.Space) -> float:
    each_energy = (
        0.5 * (b.mass * b.velocity.length**2 + b.moment * b.angular_velocity**2)
        for b in space.bodies
    )
    return sum(each for each in each_energy if math.isfinite(each))


def ball(
    space: pymunk.Space, x: float, y: float, velocity: tuple[float, float] = (0.0, 0.0)
) -> pymunk.Body:
    body = pymunk.Body(1.0, 0.005)
    body.position = (x, y)
    body.velocity = velocity
    shape = pymunk.Circle(body, 0.1)
    shape.collision_type = 2
    shape.elasticity = 1.0
    space.add(body, shape)
    return body


def on_floor() -> pymunk.Space:
    space = pymunk.Space()
    space.gravity = (0.0, -GRAVITY)
    space.collision_slop = 1e-4
    floor = pymunk.Segment(space.static_body, (-50.0, -1.0), (50.0, -1.0), 1.0)
    floor.collision_type = 1
    floor.elasticity = 1.0
    space.add(floor)
    return space


def test_a_touch_on_a_moving_plate_is_located() -> None:
    """The plate comes up at 2 m/s through 25.5 mm: contact in the middle of the 13th step, and e* = 0.5 of that speed."""
    space = pymunk.Space()
    plate = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    plate.velocity = (0.0, 2.0)
    shape = pymunk.Segment(plate, (-5.0, -1.0), (5.0, -1.0), 1.0)
    shape.collision_type = 1
    space.add(plate, shape)
    body = ball(space, 0.0, 0.1255)
    impacts = list[LocatedImpact]()
    contact = EnergeticContact(space, 1, 2, friction=0.3, restitution=0.5, report=impacts.append)
    for _ in range(20):
        contact.step(1e-3)
    assert [each.time for each in impacts] == [pytest.approx(0.01275, rel=1e-12)]
    assert body.velocity.y == pytest.approx(3.0, rel=1e-12)
    assert body.position.y - 0.1255 == pytest.approx(3.0 * (0.02 - 0.01275), rel=1e-12)


def row(count: int, restitution: float) -> tuple[pymunk.Space, list[LocatedImpact]]:
    """A row of touching balls in the air, the first of which is hit at 3 m/s, after one step."""
    space = pymunk.Space()
    impacts = list[LocatedImpact]()
    for at in range(count):
        ball(space, 0.19999 * at, 5.0, (3.0, 0.0) if at == 0 else (0.0, 0.0))
    EnergeticContact(
        space, 2, 2, friction=0.3, restitution=restitution, report=impacts.append
    ).step(1e-5)
    return space, impacts


@pytest.mark.parametrize("count", [5, 40])
def test_newtons_cradle(count: int) -> None:
    space, impacts = row(count, 1.0)
    assert [each.velocity.x for each in space.bodies] == pytest.approx(
        [0.0] * (count - 1) + [3.0], abs=1e-12
    )
    assert len(impacts) == count - 1


@pytest.mark.parametrize("ratio", [100.0, 1e3, 1e6])
def test_a_light_ball_between_two_heavy_ones_throws_them_back(ratio: float) -> None:
    """Without loss after pi/2 sqrt(M/(2 m)) = 11 bounces off each at 100; if it bounces more often, some energy is lost."""
    space = pymunk.Space()
    impacts = list[LocatedImpact]()
    _light, left, right = (ball(space, 0.2 * at, 0.0, (-float(at), 0.0)) for at in (0, -1, 1))
    left.mass = right.mass = ratio
    contact = EnergeticContact(space, 2, 2, friction=0.0, restitution=1.0, report=impacts.append)
    for _ in range(20):
        contact.step(1e-4)
    assert kinetic_energy(space) <= ratio * (1.0 + 1e-12)
    assert sum(each.mass * each.velocity.x for each in space.bodies) == pytest.approx(
        0.0, abs=1e-9 * ratio
    )
    assert len(impacts) <= 2 * MOST
    if ratio == 100.0:
        assert kinetic_energy(space) == pytest.approx(ratio, rel=1e-12)
        assert len(impacts) == 22


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("count", [10, 20, 40])
def test_a_row_of_balls_costs_a_bounded_number_of_impacts(count: int, restitution: float) -> None:
    """Momentum 3 is kept, and the energy is at least that of the common velocity, 4.5/count."""
    space, impacts = row(count, restitution)
    assert len(impacts) <= MOST + count - 1
    assert sum(each.velocity.x for each in space.bodies) == pytest.approx(3.0, rel=1e-12)
    assert 4.5 / count <= kinetic_energy(space) * (1.0 + 1e-12)
    assert kinetic_energy(space) - 4.5 == pytest.approx(
        sum(float(each.energy_change) for each in impacts), abs=1e-12
    )
    if restitution == 0.0:
        assert kinetic_energy(space) == pytest.approx(4.5 / count, rel=1e-9)


def heap(seed: int, jointed: bool) -> pymunk.Space:
    """Up to 60 balls that overlap here and there, some joined, and move at random."""
    chance = np.random.default_rng(seed)
    space = pymunk.Space()
    for at in range(int(chance.integers(20, 60))):
        x, y = (
            0.19 * (at % 7) + chance.uniform(-0.01, 0.01),
            0.19 * (at // 7) + chance.uniform(-0.01, 0.01),
        )
        body = ball(space, x, y, tuple(chance.normal(size=2)))
        body.angular_velocity = chance.normal()
    bodies = list(space.bodies)
    for first, second in zip(bodies[::3], bodies[1::3], strict=False):
        if jointed:
            space.add(
                pymunk.PivotJoint(first, second, tuple((first.position + second.position) / 2.0))
            )
    return space


@pytest.mark.parametrize("jointed", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_a_heap_resolved_at_once_gains_no_energy(seed: int, jointed: bool) -> None:
    """The velocities that open joints are closed first, which loses energy too; without joints the records tell all of it."""
    space = heap(seed, jointed)
    impacts = list[LocatedImpact]()
    chance = np.random.default_rng(seed)
    coefficients = {
        "friction": float(chance.uniform(0.0, 1.0)),
        "restitution": float(chance.uniform(0.0, 1.0)),
    }
    before = kinetic_energy(space)
    momentum = sum(each.velocity.x for each in space.bodies)
    EnergeticContact(space, 2, 2, **coefficients, report=impacts.append).step(1e-9)
    assert len(impacts) > MOST
    assert kinetic_energy(space) <= before * (1.0 + 1e-12)
    assert sum(each.velocity.x for each in space.bodies) == pytest.approx(momentum, abs=1e-9)
    if not jointed:
        change = sum(float(each.energy_change) for each in impacts)
        assert kinetic_energy(space) - before == pytest.approx(change, abs=1e-9 * before)
    for each in impacts[MOST:]:
        assert abs(each.impulse_tangential) <= coefficients["friction"] * each.impulse_normal * (
            1.0 + 1e-9
        )
        assert (each.outcome_name == "rebound") == (each.velocity_normal > 0.0)
        # The impulses are found to 1e-8 of the largest; restitution drives no contact together.
        assert each.velocity_normal >= -1e-6
        # A work is the impulse times the mean of the velocities before and after it.
        pushed = each.impulse_tangential - each.compressive_impulse_tangential
        if abs(pushed) > 1e-3:
            slip = 2.0 * each.phase_work_tangential[2] / pushed - each.velocity_tangential
            assert slip * each.phase_slip[2] >= -1e-9


def bouncing() -> tuple[pymunk.Space, EnergeticContact]:
    space = on_floor()
    for at in range(3):
        ball(space, 0.05 * at, 0.5 + 0.25 * at)
    contact = EnergeticContact(space, 1, 2, friction=0.3, restitution=0.5, report=lambda _: None)
    contact.add_pair(2, 2, friction=0.3, restitution=0.8)
    for _ in range(300):
        contact.step(1e-3)
    return space, contact


def places(space: pymunk.Space) -> list[tuple[float, float]]:
    return [tuple(each.position) for each in space.bodies]


@pytest.mark.parametrize(
    "copied", [pymunk.Space.copy, lambda space: pickle.loads(pickle.dumps(space))]
)
def test_a_copy_goes_on_with_a_contact_of_its_own(
    copied: Callable[[pymunk.Space], pymunk.Space],
) -> None:
    """1e-6: the engine's cached impulses are not copied bit for bit."""
    space, contact = bouncing()
    other = copied(space)
    again = EnergeticContact.of(other)
    assert again is not None
    assert again is not contact
    assert (again.space, again.time, again.report) == (other, contact.time, None)
    for each in (contact, again):
        for _ in range(300):
            each.step(1e-3)
    assert np.array(places(other)) == pytest.approx(np.array(places(space)), abs=1e-6)


def test_a_detached_contact_leaves_the_space_to_the_engine() -> None:
    """The callback that was there before is there again, and the space takes another contact."""
    space = on_floor()
    calls = list[int]()
    body = ball(space, 0.0, 0.3, (0.0, -1.0))
    space.on_collision(1, 2, pre_solve=lambda *_: calls.append(1))
    contact = EnergeticContact(space, 1, 2, friction=0.0, restitution=0.0)
    contact.detach()
    assert EnergeticContact.of(space) is None
    for _ in range(200):
        space.step(1e-3)
    assert calls
    assert body.velocity.y > 0.0  # elastic, by the engine
    assert EnergeticContact.of(space) is None
    assert (
        EnergeticContact.of(EnergeticContact(space, 1, 2, friction=0.0, restitution=0.0).space)
        is not None
    )


@pytest.mark.parametrize("law", [max, print, 3, lambda *_: None, lambda: Impact])
def test_a_law_that_is_none_is_refused_when_it_is_given(law: object) -> None:
    contact = EnergeticContact(pymunk.Space(), 1, 2, friction=0.0, restitution=0.0)
    with pytest.raises(
        ValueError,
        match=r"^law = .*: must be a function like energetic_impact, which returns an Impact$",
    ):
        contact.add_pair(3, 4, friction=0.0, restitution=0.0, law=law)  # type: ignore[arg-type]


def spun(**tangential: float) -> tuple[pymunk.Body, LocatedImpact]:
    """A disc with spin that falls on a floor without gravity, after one step, and its impact."""
    space = on_floor()
    impacts = list[LocatedImpact]()
    space.gravity = (0.0, 0.0)
    body = ball(space, 0.0, 0.1 - 1e-9, (1.0, -2.0))
    body.angular_velocity = 5.0
    EnergeticContact(
        space, 1, 2, friction=0.4, restitution=0.7, report=impacts.append, **tangential
    ).step(1e-9)
    return body, impacts[0]


@pytest.mark.parametrize("compliance", [0.0, 0.3, 1.21, 10.0])
def test_a_contact_elastic_along_the_surface(compliance: float) -> None:
    """The law's own answer for the disc's K = diag(1/m, 1/m + r^2/I) = diag(1, 3): bit for bit the rigid one at 0."""
    body, impact = spun(tangential_compliance=compliance)
    law = energetic_impact(
        np.diag([1.0, 3.0]), (-2.0, 1.5), 0.4, 0.7, tangential_compliance=compliance
    )
    assert impact.impulse_tangential == pytest.approx(float(law.impulse_tangential), rel=1e-7)
    assert body.velocity.x == pytest.approx(1.0 + float(law.impulse_tangential), rel=1e-7)
    assert float(impact.energy_change) <= 0.0
    if not compliance:
        rigid, _ = spun()
        assert (rigid.velocity, rigid.angular_velocity) == (body.velocity, body.angular_velocity)


@pytest.mark.parametrize(
    ("value", "law"), [(-1.0, energetic_impact), (2e4, energetic_impact), (1.0, newton_impact)]
)
def test_a_tangential_compliance_out_of_range_or_unknown_to_the_law_is_refused(
    value: float, law: object
) -> None:
    contact = EnergeticContact(pymunk.Space(), 1, 2, friction=0.0, restitution=0.0)
    with pytest.raises(ValueError, match=r"^tangential_compliance = .*: must be"):
        contact.add_pair(3, 4, friction=0.3, restitution=0.5, tangential_compliance=value, law=law)  # type: ignore[arg-type]


def test_many_impacts_that_have_nothing_to_do_with_each_other_act_at_their_instants() -> None:
    """More than the limit of a group: each of them rises like a ball alone, exactly but for rounding."""
    heights = []
    for count in (1, 2 * MOST):
        space = on_floor()
        balls = [ball(space, 0.5 * at, 0.5) for at in range(count)]
        contact = EnergeticContact(space, 1, 2, friction=0.3, restitution=1.0)
        for _ in range(100):
            contact.step(1.0 / 240.0)
        heights.append([each.position.y for each in balls])
    assert heights[1] == pytest.approx(heights[0] * 2 * MOST, rel=1e-12)
