"""Contact space, held contacts and the engine's own law: what other tests let pass. Expected from geometry or by hand."""

import itertools
import math

import numpy as np
import pymunk
import pytest

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact_laws import Coefficients, EngineLaw
from bristle_sim.scene.contact_space import contact_space
from bristle_sim.scene.engine_contact import ELBOW, EngineContact, elbow, locking, set_back, sustained_contact_record
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.obstacles import BarObstacle, WorkpartObstacle
from bristle_sim.scene.stepping import Advance
from bristle_sim.scene.strike import Chain, build_strike, strike
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason

ROD = Mechanism((Link.rod(2.0, 1.0),))
"""A rod that hangs from the origin: moment of inertia m/3 about the root, m/12 about the centre."""


def on_workpart(angle: float, friction: float) -> EngineContact:
    """The rod's tip on the workpart."""
    obstacle = WorkpartObstacle(math.cos(angle), friction, friction, 0.5)
    return EngineContact(Scene(ROD, Effects(obstacles=(obstacle,))), obstacle)


def beside_bar(angle: float, along: float, friction: float = 0.0) -> tuple[EngineContact, BarObstacle]:
    """The rod, at an angle, against a bar of reach 0.1 at a distance along it, on the side of larger angles."""
    direction = (math.sin(angle), -math.cos(angle))
    across = (math.cos(angle), math.sin(angle))
    centre = (along * direction[0] + 0.1 * across[0], along * direction[1] + 0.1 * across[1])
    obstacle = BarObstacle(centre, 0.1, 0.0, friction, 0.5)
    return EngineContact(Scene(ROD, Effects(obstacles=(obstacle,))), obstacle), obstacle


Vector = tuple[float, float]


def three_bodies() -> list[pymunk.Body]:
    """Three bodies anywhere, of different masses."""
    bodies = []
    for mass, moment, place, angle in (
        (1.0, 0.3, (0.1, 0.9), 0.2),
        (2.0, 0.5, (0.8, 0.4), -0.7),
        (0.5, 0.2, (1.5, 1.1), 1.3),
    ):
        body = pymunk.Body(mass, moment)
        body.position, body.angle = place, angle
        bodies.append(body)
    return bodies


def row(bodies: list[pymunk.Body], body: pymunk.Body, point: Vector, direction: Vector) -> np.ndarray:
    """Velocity of a body's world point along a direction, per unit of all (v_x, v_y, rate)."""
    found = np.zeros(3 * len(bodies))
    if body in bodies:
        at = 3 * bodies.index(body)
        x, y = point[0] - body.position.x, point[1] - body.position.y
        found[at : at + 3] = (*direction, x * direction[1] - y * direction[0])
    return found


def projected(bodies: list[pymunk.Body], joints: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """K = C W C^T - C W J^T (J W J^T)^-1 J W C^T with the inverse masses W, as textbooks have it."""
    inverse = np.diag([share for body in bodies for share in (1.0 / body.mass, 1.0 / body.mass, 1.0 / body.moment)])
    held = joints @ inverse @ contact.T
    return contact @ inverse @ contact.T - held.T @ np.linalg.solve(joints @ inverse @ joints.T, held)


class TestContactSpace:
    """Pivots at (0.5, 0.5) and (1.2, 0.7), a pin from (0, 1) on the first body to (2, 0.5) on the third, a soft spring."""

    PIVOTS = ((0, 1, (0.5, 0.5)), (1, 2, (1.2, 0.7)))
    PIN = ((0.0, 1.0), (2.0, 0.5))

    @pytest.mark.parametrize("order", [*itertools.permutations(range(4)), *itertools.permutations((0, 1, 3))])
    @pytest.mark.parametrize("touched", [0, 1, 2])
    def test_whatever_body_is_touched_and_however_they_were_joined(self, touched: int, order: tuple[int, ...]) -> None:
        """K against the textbook's formula; an impulse p changes the point's velocity by K p and leaves joints closed."""
        space, bodies = pymunk.Space(), three_bodies()
        space.add(*bodies)
        ends = [bodies[index].world_to_local(at) for index, at in zip((0, 2), self.PIN, strict=True)]
        makers = [lambda a=a, b=b, at=at: pymunk.PivotJoint(bodies[a], bodies[b], at) for a, b, at in self.PIVOTS]
        makers.append(lambda: pymunk.PinJoint(bodies[0], bodies[2], *ends))
        makers.append(lambda: pymunk.DampedSpring(bodies[0], space.static_body, (0, 0), (0, 0), 1.0, 1e3, 10.0))
        for index in order:
            space.add(makers[index]())
        point, normal = (0.7, 0.2), (0.6, 0.8)
        contact = np.stack([row(bodies, bodies[touched], point, each) for each in (normal, (0.8, -0.6))])
        joints = [
            row(bodies, bodies[a], at, each) - row(bodies, bodies[b], at, each)
            for a, b, at in self.PIVOTS
            for each in ((1.0, 0.0), (0.0, 1.0))
        ]
        along = tuple((np.subtract(self.PIN[1], self.PIN[0]) / math.dist(*self.PIN)).tolist())
        if 2 in order:
            joints.append(row(bodies, bodies[0], self.PIN[0], along) - row(bodies, bodies[2], self.PIN[1], along))
        expected = projected(bodies, np.array(joints), contact)
        found = contact_space(bodies[touched], point, normal)
        # Nine velocities, five constraints: some ten roundings of numbers of order 10.
        np.testing.assert_allclose(found.inverse_mass, expected, rtol=0.0, atol=1e-12)
        assert set(found.bodies) == set(bodies)
        found.apply((0.3, -0.2))
        change = np.array([each for body in bodies for each in (*body.velocity, body.angular_velocity)])
        np.testing.assert_allclose(contact @ change, expected @ (0.3, -0.2), rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(np.array(joints) @ change, 0.0, rtol=0.0, atol=1e-12)

    @pytest.mark.parametrize("normal", [(0.5, 0.5), (0.0, 0.0), (1.0, 1e-4), (math.nan, 1.0)])
    def test_a_normal_is_a_unit_vector(self, normal: Vector) -> None:
        with pytest.raises(ValueError, match=r"^normal = \(.*\): a vector of length 1 is allowed$"):
            contact_space(three_bodies()[0], (0.0, 0.0), normal)


class TestGrip:
    """(K_nn - mu sign(v_t) K_nt) over that of the free rod, 1/m + lever^2/J."""

    @pytest.mark.parametrize("rate", [-0.3, 0.0, 0.3])
    @pytest.mark.parametrize("friction", [0.0, 0.4])
    def test_on_the_workpart(self, rate: float, friction: float) -> None:
        """K_nn = 3/m sin^2, K_nt = 3/m sin cos; free 1/m (1 + 12 (sin/2)^2); no slip, no friction."""
        angle = 0.7
        sine, cosine = math.sin(angle), math.cos(angle)
        slip = math.copysign(1.0, rate) if rate else 0.0
        expected = 3.0 * sine * (sine - friction * slip * cosine) / (1.0 + 3.0 * sine**2)
        found = on_workpart(angle, friction).grip(State(0.0, (angle,), (rate,)))
        assert found == pytest.approx(expected, rel=1e-13)

    @pytest.mark.parametrize("angle", [0.0, 0.7, -2.0])
    @pytest.mark.parametrize("along", [0.3, 0.5, 0.9])
    def test_on_a_bar_in_any_direction(self, angle: float, along: float) -> None:
        """K_nn = 3/m s^2 at a distance s from the root; free 1/m (1 + 12 (s - 1/2)^2)."""
        hold, _ = beside_bar(angle, along)
        found = hold.grip(State(0.0, (angle,), (0.1,)))
        assert found == pytest.approx(3.0 * along**2 / (1.0 + 12.0 * (along - 0.5) ** 2), rel=1e-12)

    @pytest.mark.parametrize("along", [0.2, 0.5, 0.8])
    def test_iterations_solve_to_rounding_and_no_further(self, along: float) -> None:
        """Each leaves 1 - grip of the error: as many as it takes to 1e-17."""
        hold, _ = beside_bar(0.7, along)
        left = abs(1.0 - hold.engage(State(0.0, (0.7,), (0.1,))))
        rounds = hold.scene.space.iterations
        assert left**rounds <= 1e-17 < left ** (rounds - 1)

    def test_iterations_have_a_bound(self) -> None:
        """Friction of tan gamma leaves no grip: no number of iterations is enough, 40 000 are taken."""
        hold = on_workpart(0.7, math.tan(0.7))
        assert hold.engage(State(0.0, (0.7,), (0.3,))) == pytest.approx(0.0, abs=1e-15)
        assert hold.scene.space.iterations == 40_000

    @pytest.mark.parametrize(("force", "impulse", "fails"), [(1.0, 0.0, False), (0.0, 1.0, True), (-1.0, 1.0, True)])
    def test_a_contact_only_pushes(self, force: float, impulse: float, fails: bool) -> None:
        """What counts is the force of the last step, not what was pushed before."""
        assert on_workpart(0.7, 0.3).fails([force, impulse, 0.0, 0.0]) is fails


class TestWatches:
    def test_friction_that_locks_is_a_jam(self) -> None:
        """Zero where the grip is 1e-3; it ends the run and has a name in the record only with friction."""
        state = State(0.0, (0.7,), (0.3,))
        result = Advance(state, (0.0,), (), 0.0)
        for friction, event in ((0.4, "jam"), (0.0, None)):
            hold = on_workpart(0.7, friction)
            watch = locking(hold)
            assert watch.value(result) == pytest.approx(hold.grip(state) - 1e-3, abs=1e-15)
            assert (watch.falling, watch.event) == (True, event)
            assert watch.final is (StopReason.JAM if friction else StopReason.NO_GRIP)

    def test_another_piece_that_meets_the_bar(self) -> None:
        """Its gap falls to zero; a straight wire has no other piece."""
        hold, _ = beside_bar(0.7, 0.5)
        watch = elbow(hold)
        assert (watch.name, watch.falling) == (ELBOW, True)
        assert watch.value(Advance(State(0.0, (0.7,), (0.1,)), (0.0,), (), 0.0)) == math.inf


class TestSetBack:
    """Newton's method ends after three rounds: 1e-3 off is 1e-6, 1e-12 and then rounding."""

    @pytest.mark.parametrize("off", [1e-3, -1e-3])
    def test_onto_the_workpart(self, off: float) -> None:
        """The tip is at -cos of the angle, and does not move along the normal where the rate is 0."""
        hold = on_workpart(0.7, 0.0)
        found = set_back(ROD, hold.obstacle, State(1.5, (0.7 + off,), (0.2,)))
        assert found.time == 1.5
        assert found.angles[0] == pytest.approx(0.7, abs=1e-14)
        assert found.rates[0] == pytest.approx(0.0, abs=1e-14)

    @pytest.mark.parametrize("angle", [0.0, 0.7, -2.0])
    @pytest.mark.parametrize("off", [1e-3, -1e-3])
    def test_onto_a_bar_in_any_direction(self, angle: float, off: float) -> None:
        _, obstacle = beside_bar(angle, 0.6)
        found = set_back(ROD, obstacle, State(0.0, (angle + off,), (0.2,)))
        assert found.angles[0] == pytest.approx(angle, abs=1e-13)
        assert found.rates[0] == pytest.approx(0.0, abs=1e-13)

    def test_a_link_whose_turning_does_not_help_stays(self) -> None:
        """A hanging rod's tip moves along the surface."""
        state = State(0.0, (0.0,), (0.2,))
        assert set_back(ROD, WorkpartObstacle(0.9, 0.0, 0.0, 0.5), state) == state


def test_ledger_of_a_hold() -> None:
    """Slip of a tip at 0.7 is the rate times cos 0.7; the normal velocity is 0 by definition."""
    obstacle = WorkpartObstacle(math.cos(0.7), 0.4, 0.4, 0.5)
    first, last = State(1.0, (0.7,), (0.5,)), State(1.5, (0.7,), (-0.25,))
    record = sustained_contact_record(ROD, obstacle, first, last, (3.0, -1.0, -0.2), "released")
    assert (record.obstacle, record.law, record.outcome) == ("workpart", "hold", "released")
    assert (record.time, record.duration, record.impulse) == (1.0, 0.5, (3.0, -1.0))
    assert record.compressive_work == (0.0, -0.2)
    assert record.compressive_impulse is record.restitutive_work is None
    assert record.velocity_before == (0.0, pytest.approx(0.5 * math.cos(0.7), rel=1e-15))
    assert record.velocity_after == (0.0, pytest.approx(-0.25 * math.cos(0.7), rel=1e-15))
    assert (record.angles, record.rates_before, record.rates_after) == ((0.7,), (0.5,), (-0.25,))


def test_the_rigid_law_takes_no_time() -> None:
    record = strike(Chain((2.0,), (1.0,), (-0.6,), (1.0,)), Surface(0.3, None, 0.5), Contact(), Settings()).contact
    assert (record.duration, record.time, record.law) == (0.0, 0.0, "energetic")


class TestEngineLaw:
    """Newton's restitution of one rod at 0.6: v_n is -e times what it was, whatever friction does (one freedom)."""

    @pytest.mark.parametrize(("friction", "restitution"), [(0.0, 0.5), (0.3, 0.5), (0.0, 1.0), (0.0, 0.0)])
    def test_one_rod(self, friction: float, restitution: float) -> None:
        """Slip does not turn before the normal velocity does, so p_t = -mu p_n and p_n = -(1 + e) v_n/(K_nn + mu K_nt).

        With friction that is so in compression; the clamp then takes what is left of slip as it comes.
        """
        chain, surface = Chain((2.0,), (1.0,), (-0.6,), (1.0,)), Surface(friction, None, restitution)
        scene, state, obstacle, _ = build_strike(chain, surface)
        after, record = EngineLaw(100).resolve(scene, state, obstacle, Coefficients.of(obstacle))
        assert (record.obstacle, record.law, record.duration, record.time) == ("workpart", "engine", 0.0, 0.0)
        assert record.outcome == ("rebound" if restitution else "no rebound")
        assert (after.time, after.angles) == (state.time, state.angles)
        assert (record.angles, record.rates_before, record.rates_after) == (state.angles, state.rates, after.rates)
        before = (-math.sin(0.6), math.cos(0.6))
        assert record.velocity_before == pytest.approx(before, rel=1e-14)
        # Iterations solve the joint to rounding; the engine's bias of a step of 1e-12 is below it.
        assert record.velocity_after == pytest.approx([-restitution * each for each in before], abs=1e-9)
        sine, cosine = math.sin(0.6), math.cos(0.6)
        moment = sine * record.impulse[0] - cosine * record.impulse[1]
        assert moment == pytest.approx((1.0 + restitution) / 3.0, rel=1e-9), "angular momentum about the root"
        if not friction:
            assert record.impulse == pytest.approx(((1.0 + restitution) / (3.0 * sine), 0.0), rel=1e-9, abs=1e-12)
        assert (record.compressive_impulse, record.compressive_work, record.restitutive_work) == (None, None, None)

    def test_ten_iterations_unless_told_otherwise(self) -> None:
        """More iterations of a chain give more: Stronge's double pendulum comes out otherwise with each number."""
        chain, surface = (
            Chain((5.0, 5.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2)),
            Surface(0.5),
        )
        usual = strike(chain, surface, Contact("engine"), Settings()).contact
        rates = []
        for iterations in (10, 50):
            scene, state, obstacle, units = build_strike(chain, surface)
            after, _ = EngineLaw(iterations).resolve(scene, state, obstacle, Coefficients.of(obstacle))
            rates.append(tuple(rate / units.time for rate in after.rates))
        assert usual.rates_after == pytest.approx(rates[0], rel=1e-12)
        assert usual.rates_after != pytest.approx(rates[1], rel=1e-3)

    def test_the_scene_is_left_as_in_flight(self) -> None:
        """Nothing of the contact acts any more: a rod within the workpart is let through, but for the step's error h^2."""
        scene, state, obstacle, _ = build_strike(Chain((2.0,), (1.0,), (-0.6,), (1.0,)), Surface(0.3, None, 0.5))
        iterations = scene.space.iterations
        after, _ = EngineLaw().resolve(scene, state, obstacle, Coefficients.of(obstacle))
        assert scene.space.iterations == iterations
        assert scene.angles() == list(after.angles)
        assert scene.rates() == list(after.rates)
        inside = State(0.0, (-0.5,), (1.0,))
        scene.place(inside)
        scene.step(1e-3, 1)
        assert scene.rates()[0] == pytest.approx(1.0, abs=1e-6)
