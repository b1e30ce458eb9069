"""The energetic law in a user's own pymunk space."""

import math
from typing import Any

import pymunk
import pytest

from bristle_sim.contact_space.contact_pair import LocatedImpact
from bristle_sim.contact_space.energetic_contact import EnergeticContact
from bristle_sim.theory.impact import newton_impact


def test_resting_speed_brings_a_rod_to_rest() -> None:
    """An inclined rod of 1 m falls on a floor. Approaches slower than the resting speed take no restitution, so it lies still."""
    space = pymunk.Space()
    space.gravity = (0, -9.81)
    floor = pymunk.Segment(space.static_body, (-5, -1), (5, -1), 1.0)
    rod = pymunk.Body(1.0, 1.0 / 12.0)
    rod.angle, rod.velocity, rod.position = 1.5, (0.0, -2.0), (0.0, 0.5 * math.cos(1.5) + 0.011)
    shape = pymunk.Segment(rod, (0, -0.5), (0, 0.5), 0.01)
    floor.collision_type, shape.collision_type = 1, 2
    space.add(floor, rod, shape)
    contact = EnergeticContact(space, 1, 2, friction=0.5, restitution=0.5, resting_speed=0.05)
    for _ in range(5_000):
        contact.step(1e-4)
    # One step of gravity is what a resting contact takes away each time.
    assert rod.velocity.length < 2e-3
    assert rod.position.y == pytest.approx(0.01, abs=2e-3)


GRAVITY = 9.81
SLOP = 1e-3


def floor_space(gravity: float = GRAVITY) -> tuple[pymunk.Space, pymunk.Segment]:
    """A floor at y = 0."""
    space = pymunk.Space()
    space.gravity, space.collision_slop = (0, -gravity), SLOP
    floor = pymunk.Segment(space.static_body, (-1e3, -1), (1e3, -1), 1.0)
    floor.collision_type = 1
    space.add(floor)
    return space, floor


def ball(space: pymunk.Space, x: float, y: float, speed: float = 0.0, kind: int = 2) -> pymunk.Body:
    """A ball of 0.1 m and 1 kg, of the moment of a solid sphere, that falls at a speed."""
    body = pymunk.Body(1.0, 0.4 * 0.01)
    body.position, body.velocity = (x, y), (0.0, -speed)
    shape = pymunk.Circle(body, 0.1)
    shape.collision_type = kind
    space.add(body, shape)
    return body


def one_impact(space: pymunk.Space, friction: float = 0.0, restitution: float = 0.5) -> LocatedImpact:
    """The only impact of one short step."""
    impacts: list[LocatedImpact] = []
    contact = EnergeticContact(space, 1, 2, friction=friction, restitution=restitution, report=impacts.append)
    contact.step(1e-9)
    (impact,) = impacts
    return impact


class TestBodies:
    def test_an_infinite_moment(self) -> None:
        """A body that cannot turn has no lever: p = (1 + e) m v."""
        space, _ = floor_space(0.0)
        body = pymunk.Body(1.0, math.inf)
        body.position, body.velocity = (0.0, 0.0999), (0.0, -1.0)
        shape = pymunk.Circle(body, 0.1, (0.3, 0.0))
        shape.collision_type = 2
        space.add(body, shape)
        assert one_impact(space).impulse_normal == pytest.approx(1.5, rel=1e-12)


class TestManyContacts:
    def test_two_hundred_balls_at_rest_do_not_sink(self) -> None:
        space, _ = floor_space()
        balls = [ball(space, 0.5 * at, 0.1) for at in range(200)]
        impacts: list[LocatedImpact] = []
        contact = EnergeticContact(space, 1, 2, friction=0.3, restitution=0.5, report=impacts.append)
        for _ in range(60):
            contact.step(5e-3)
        assert min(each.position.y for each in balls) > 0.1 - SLOP
        assert not impacts


class TestJoints:
    def test_friction_by_a_joint_of_finite_force_passes_no_impulse(self) -> None:
        """pymunk's idiom: a pivot to the static body with a largest force. The ball bounces and comes to rest on the floor."""
        space, _ = floor_space()
        body = ball(space, 0.0, 0.2)
        brake = pymunk.PivotJoint(space.static_body, body, (0.0, 0.0), (0.0, 0.0))
        brake.max_force, brake.max_bias = 1.0, 0.0
        space.add(brake)
        impacts: list[LocatedImpact] = []
        contact = EnergeticContact(space, 1, 2, friction=0.3, restitution=0.5, report=impacts.append)
        for _ in range(1000):
            contact.step(1e-3)
        assert {each.outcome_name for each in impacts} == {"rebound"}
        assert 0.1 - SLOP < body.position.y < 0.1 + SLOP


class TestUsersScene:
    def test_a_conveyor(self) -> None:
        """It sticks: v_x = 3 (1/m)/K_tt = 3 * 2/7 = 0.857 for a solid sphere, the conveyor going to +x."""
        space, floor = floor_space(0.0)
        floor.surface_velocity = (3.0, 0.0)
        body = ball(space, 0.0, 0.1 - 1e-9, 1.0)
        one_impact(space, friction=1.0)
        # Half the overlap of 2e-9 m is missing from the lever of 0.1 m.
        assert body.velocity.x == pytest.approx(6.0 / 7.0, rel=1e-7)

    @pytest.mark.parametrize("phase", ["begin", "pre_solve"])
    @pytest.mark.parametrize("when", ["before", "after"])
    @pytest.mark.parametrize("types", [(1, 2), (2, 1), (2, None)])
    def test_a_one_way_platform(self, phase: str, when: str, types: tuple[int, int | None]) -> None:
        """The user's callback lets a ball pass, whether it is registered before or after, and is called."""
        space, _ = floor_space(0.0)
        body, calls = ball(space, 0.0, 0.0999, 1.0), []

        def let_pass(arbiter: pymunk.Arbiter, _space: pymunk.Space, data: Any) -> None:
            calls.append(data)
            arbiter.process_collision = False

        if when == "before":
            space.on_collision(*types, **{phase: let_pass}, data="user's")  # type: ignore[arg-type]
        impacts: list[LocatedImpact] = []
        contact = EnergeticContact(space, 1, 2, friction=0.0, restitution=0.5, report=impacts.append)
        if when == "after":
            space.on_collision(*types, **{phase: let_pass}, data="user's")  # type: ignore[arg-type]
        for _ in range(3):
            contact.step(1e-3)
        assert set(calls) == {"user's"}
        assert not impacts
        assert body.velocity.y == -1.0


class TestPairs:
    def test_each_pair_has_its_own_coefficients_and_law(self) -> None:
        """Speeds after e = 0, 0.5 and, by Newton's law, 0.9."""
        space, _ = floor_space(0.0)
        balls = [ball(space, float(kind), 0.0999, 1.0, kind) for kind in (2, 3, 4)]
        contact = EnergeticContact(space, 1, 2, friction=0.0, restitution=0.0)
        contact.add_pair(1, 3, friction=0.0, restitution=0.5)
        contact.add_pair(4, 1, friction=0.0, restitution=0.9, law=newton_impact)
        contact.step(1e-9)
        assert [each.velocity.y for each in balls] == pytest.approx([0.0, 0.5, 0.9], abs=1e-12)

    def test_a_pair_is_added_once(self) -> None:
        contact = EnergeticContact(pymunk.Space(), 1, 2, friction=0.0, restitution=0.0)
        with pytest.raises(ValueError, match=r"^collision_type_a, collision_type_b = \(2, 1\): must be a pair"):
            contact.add_pair(2, 1, friction=0.0, restitution=0.0)

    def test_a_space_takes_one_contact(self) -> None:
        space = pymunk.Space()
        EnergeticContact(space, 1, 2, friction=0.0, restitution=0.0)
        with pytest.raises(ValueError, match=r"^space: has an EnergeticContact already; use its add_pair"):
            EnergeticContact(space, 3, 4, friction=0.0, restitution=0.0)


class TestReports:
    def test_place_time_and_bodies(self) -> None:
        space, _ = floor_space(0.0)
        body = ball(space, 0.3, 0.1 + 0.0255, 1.0)
        impacts: list[LocatedImpact] = []
        contact = EnergeticContact(space, 1, 2, friction=0.0, restitution=0.5, report=impacts.append)
        for _ in range(40):
            contact.step(1e-3)
        (impact,) = impacts
        assert impact.point == pytest.approx((0.3, 0.0), abs=1e-12)
        assert impact.normal == pytest.approx((0.0, 1.0))
        assert impact.bodies == (body, space.static_body)
        # The gap of 25.5 mm at 1 m/s is gone in the middle of the 26th step.
        assert impact.time == pytest.approx(0.0255, rel=1e-12)
        assert impact.outcome_name == "rebound"
        assert float(impact.energy_change) == pytest.approx(0.5 * (0.25 - 1.0))


class TestRest:
    def test_a_sleeping_ball_sleeps_until_it_is_hit(self) -> None:
        space, _ = floor_space()
        space.sleep_time_threshold = 0.05
        resting = ball(space, 0.0, 0.1)
        contact = EnergeticContact(space, 1, 2, friction=0.3, restitution=0.5)
        contact.add_pair(2, 2, friction=0.0, restitution=1.0)
        for _ in range(200):
            contact.step(1e-3)
        assert resting.is_sleeping
        hitting = ball(space, 0.201, 0.1)
        hitting.velocity = (-1.0, 0.0)
        for _ in range(5):
            contact.step(1e-3)
        assert not resting.is_sleeping
        # Equal masses, e = 1, no friction between them: speeds are swapped, less the floor's friction of 5 steps.
        assert resting.velocity.x == pytest.approx(-1.0, abs=0.3 * GRAVITY * 5e-3)
