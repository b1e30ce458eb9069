"""The energetic law in a user's own pymunk space."""

import math
import sys
import warnings
from typing import Any

import pymunk
import pytest

from bristle_sim.contact_space.collision_rule import LocatedImpact
from bristle_sim.contact_space.energetic_contact import EnergeticContact
from bristle_sim.contact_space.tunnelling import least_extent
from bristle_sim.theory.impact import newton_impact


def test_resting_speed_brings_a_rod_to_rest() -> None:
    """An inclined rod of 1 m falls on a floor. Approaches slower than the resting speed take no restitution, so it lies still."""
    space = pymunk.Space()
    space.gravity = (0, -9.81)
    floor = pymunk.Segment(space.static_body, (-5, -1), (5, -1), 1.0)
    rod = pymunk.Body(1.0, 1.0 / 12.0)
    rod.angle = 1.5
    rod.velocity = (0.0, -2.0)
    rod.position = (0.0, 0.5 * math.cos(1.5) + 0.011)
    shape = pymunk.Segment(rod, (0, -0.5), (0, 0.5), 0.01)
    floor.collision_type = 1
    shape.collision_type = 2
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
    space.gravity = (0, -gravity)
    space.collision_slop = SLOP
    floor = pymunk.Segment(space.static_body, (-1e3, -1), (1e3, -1), 1.0)
    floor.collision_type = 1
    space.add(floor)
    return space, floor


def ball(space: pymunk.Space, x: float, y: float, speed: float = 0.0, kind: int = 2) -> pymunk.Body:
    """A ball of 0.1 m and 1 kg, of the moment of a solid sphere, that falls at a speed."""
    body = pymunk.Body(1.0, 0.4 * 0.01)
    body.position = (x, y)
    body.velocity = (0.0, -speed)
    shape = pymunk.Circle(body, 0.1)
    shape.collision_type = kind
    space.add(body, shape)
    return body


def one_impact(
    space: pymunk.Space, friction: float = 0.0, restitution: float = 0.5
) -> LocatedImpact:
    """The only impact of one short step."""
    impacts: list[LocatedImpact] = []
    contact = EnergeticContact(
        space, 1, 2, friction=friction, restitution=restitution, report=impacts.append
    )
    contact.step(1e-9)
    (impact,) = impacts
    return impact


class TestBodies:
    def test_an_infinite_moment(self) -> None:
        """A body that cannot turn has no lever: p = (1 + e) m v."""
        space, _ = floor_space(0.0)
        body = pymunk.Body(1.0, math.inf)
        body.position = (0.0, 0.0999)
        body.velocity = (0.0, -1.0)
        shape = pymunk.Circle(body, 0.1, (0.3, 0.0))
        shape.collision_type = 2
        space.add(body, shape)
        assert one_impact(space).impulse_normal == pytest.approx(1.5, rel=1e-12)


class TestManyContacts:
    def test_two_hundred_balls_at_rest_do_not_sink(self) -> None:
        space, _ = floor_space()
        balls = [ball(space, 0.5 * at, 0.1) for at in range(200)]
        impacts: list[LocatedImpact] = []
        contact = EnergeticContact(
            space, 1, 2, friction=0.3, restitution=0.5, report=impacts.append
        )
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
        brake.max_force = 1.0
        brake.max_bias = 0.0
        space.add(brake)
        impacts: list[LocatedImpact] = []
        contact = EnergeticContact(
            space, 1, 2, friction=0.3, restitution=0.5, report=impacts.append
        )
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
        body = ball(space, 0.0, 0.0999, 1.0)
        calls = []

        def let_pass(arbiter: pymunk.Arbiter, _space: pymunk.Space, data: Any) -> None:
            calls.append(data)
            arbiter.process_collision = False

        if when == "before":
            space.on_collision(*types, **{phase: let_pass}, data="user's")  # type: ignore[arg-type]
        impacts: list[LocatedImpact] = []
        contact = EnergeticContact(
            space, 1, 2, friction=0.0, restitution=0.5, report=impacts.append
        )
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
        with pytest.raises(
            ValueError, match=r"^collision_type_a, collision_type_b = \(2, 1\): must be a pair"
        ):
            contact.add_pair(2, 1, friction=0.0, restitution=0.0)

    def test_a_space_takes_one_contact(self) -> None:
        space = pymunk.Space()
        EnergeticContact(space, 1, 2, friction=0.0, restitution=0.0)
        with pytest.raises(
            ValueError, match=r"^space: has an EnergeticContact already; use its add_pair"
        ):
            EnergeticContact(space, 3, 4, friction=0.0, restitution=0.0)


class TestReports:
    def test_place_time_and_bodies(self) -> None:
        space, _ = floor_space(0.0)
        body = ball(space, 0.3, 0.1 + 0.0255, 1.0)
        impacts: list[LocatedImpact] = []
        contact = EnergeticContact(
            space, 1, 2, friction=0.0, restitution=0.5, report=impacts.append
        )
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

    def test_a_contact_at_rest_and_a_step_in_flight_make_few_calls(self) -> None:
        """Time is that of calls, some 0.1 us each, and their number is the same on any machine.

        A contact at rest needs five Python functions, two of them pymunk's, and nine calls of the engine, three for its one point.
        A step in flight needs pymunk's own, the beginning and end of the filter, and every sixteenth time the speeds.
        """

        def calls(height: float, balls: int) -> float:
            space, _ = floor_space()
            for number in range(balls):
                ball(space, 0.5 * number, height)
            contact = EnergeticContact(space, 1, 2, friction=0.3, restitution=0.5)
            for _ in range(10):
                contact.step(1e-6)
            kinds: list[str] = []
            sys.setprofile(lambda _frame, kind, _argument: kinds.append(kind))
            try:
                for _ in range(160):
                    contact.step(1e-6)
            finally:
                sys.setprofile(None)
            return (kinds.count("call") + kinds.count("c_call")) / 160

        assert (calls(0.1, 50) - calls(0.1, 1)) / 49 <= 18.0
        assert calls(1e3, 1) <= 25.0


BULLET = 1e3  # m/s


def take_steps(contact: EnergeticContact, number: int, duration: float = 1e-3) -> None:
    """Take steps of one duration."""
    for _ in range(number):
        contact.step(duration)


class TestTunnelling:
    """The engine looks for contacts at the ends of a step only; a bullet of 1000 m/s moves by 1 m in one of 1 ms."""

    @staticmethod
    def bullets(height: float, velocity: tuple[float, float], kind: int = 1) -> EnergeticContact:
        """Return a contact in a space with a floor 20 mm thick and a bullet of 10 mm above it."""
        space = pymunk.Space()
        floor = pymunk.Segment(space.static_body, (-10.0, 0.0), (10.0, 0.0), 0.01)
        floor.collision_type = kind
        space.add(floor)
        bullet = pymunk.Body(1e-3, 1e-8)
        bullet.position = (0.0, height)
        bullet.velocity = velocity
        shape = pymunk.Circle(bullet, 0.005)
        shape.collision_type = 2
        space.add(bullet, shape)
        return EnergeticContact(space, 1, 2, friction=0.3, restitution=0.5)

    def test_a_bullet_that_passes_a_floor_gives_one_warning_with_the_step_that_would_do(
        self,
    ) -> None:
        contact = self.bullets(10.5, (0.0, -BULLET))
        with pytest.warns(RuntimeWarning) as warned:
            take_steps(contact, 20)
        (warning,) = warned
        # The bullet's middle passes that of the floor 15 us after the touch, at 10 mm + 5 mm.
        assert str(warning.message) == (
            "duration = 0.001: a body at the speed 1000 moves by 1 in a step and passes a shape without a contact; "
            "take steps of at most 1.5e-05"
        )
        assert warning.filename == __file__

    @pytest.mark.parametrize("height", [10.5, 10.507, 10.513, 10.52])
    def test_in_that_step_it_strikes_wherever_it_starts(self, height: float) -> None:
        contact = self.bullets(height, (0.0, -BULLET))
        impacts: list[LocatedImpact] = []
        contact.report = impacts.append
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            take_steps(contact, 800, 1.49e-5)
        assert len(impacts) == 1

    @pytest.mark.parametrize(
        ("velocity", "kind"),
        [((BULLET, 0.0), 1), ((0.0, BULLET), 1), ((0.0, -BULLET), 7)],
        ids=["along the floor", "away from it", "through a shape of no pair"],
    )
    def test_fast_bodies_that_pass_no_shape_of_their_pair_are_left_alone(
        self, velocity: tuple[float, float], kind: int
    ) -> None:
        contact = self.bullets(10.5, velocity, kind)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            take_steps(contact, 20)

    def test_a_body_that_becomes_fast_is_noticed_within_sixteen_steps(self) -> None:
        contact = self.bullets(30.5, (0.0, 0.0))
        contact.step(1e-3)
        (bullet,) = contact.space.bodies
        bullet.velocity = (0.0, -BULLET)
        with pytest.warns(RuntimeWarning, match="passes a shape"):
            take_steps(contact, 40)

    def test_the_least_width_of_a_polygon_is_across_an_edge(self) -> None:
        """Of an equilateral triangle of side 2 it is the height, the square root of 3; of a rectangle its shorter side."""
        triangle = pymunk.Poly(None, [(-1.0, 0.0), (1.0, 0.0), (0.0, math.sqrt(3.0))])
        assert least_extent(triangle) == pytest.approx(math.sqrt(3.0), rel=1e-12)
        rectangle = pymunk.Poly(None, [(0.0, 0.0), (3.0, 3.0), (2.5, 3.5), (-0.5, 0.5)], radius=0.1)
        assert least_extent(rectangle) == pytest.approx(math.sqrt(0.5) + 0.2, rel=1e-12)
