"""Contact-space inverse mass of pymunk bodies against formulas worked out by hand, for mass ratios from 1e-6 to 1e6."""

import itertools
import math

import numpy as np
import pymunk
import pytest

from bristle_sim.contact_space.impulse import contact_space
from bristle_sim.contact_space.jacobian import MassCentres, joint_rows

UP = (0.0, 1.0)
ROUNDING = 1e-13
"""A dozen operations on numbers of order 1."""

RATIOS = [1e-6, 1e-3, 0.3, 1.0, 7.0, 1e3, 1e6]


def rod(mass: float, length: float, root: tuple[float, float], angle: float) -> pymunk.Body:
    """A slender rod that hangs from its root at an angle from -y."""
    body = pymunk.Body(mass, mass * length**2 / 12.0)
    body.angle = angle
    body.position = (root[0] + 0.5 * length * math.sin(angle), root[1] - 0.5 * length * math.cos(angle))
    return body


def hinge(space: pymunk.Space, first: pymunk.Body, second: pymunk.Body, at: tuple[float, float]) -> None:
    space.add(*(each for each in (first, second) if each.space is None), pymunk.PivotJoint(first, second, at))


def unit(angle: float) -> tuple[float, float]:
    return (math.cos(angle), math.sin(angle))


def turned(matrix: np.ndarray, normal_angle: float) -> np.ndarray:
    """A matrix of xy components, seen along a normal and the tangent that is the normal turned clockwise."""
    normal = np.array(unit(normal_angle))
    axes = np.stack([normal, [normal[1], -normal[0]]])
    return axes @ matrix @ axes.T


def double_rods(ratio: float, angle_1: float, angle_2: float) -> np.ndarray:
    """K of the second rod's tip, rods of length 1 and masses n and 1, order (x, y), from q = (theta_1', theta_2').

    T = (n/3 + 1) q_1^2/2 + (1/3) q_2^2/2 + cos(theta_1 - theta_2) q_1 q_2/2; the tip moves at q_1 (cos theta_1, sin
    theta_1) + q_2 (cos theta_2, sin theta_2).
    """
    coupling = 0.5 * math.cos(angle_1 - angle_2)
    diagonal = ratio / 3.0 + 1.0, 1.0 / 3.0
    determinant = diagonal[0] * diagonal[1] - coupling**2
    inverse = np.array([[diagonal[1], -coupling], [-coupling, diagonal[0]]]) / determinant
    tip = np.array([unit(angle_1), unit(angle_2)]).T
    return tip @ inverse @ tip.T


class TestSingleRod:
    def test_free_rod(self) -> None:
        """Across its end 1/m + (L/2)^2/I = 4/m, along it 1/m."""
        body = rod(2.0, 3.0, (0.0, 0.0), 0.0)
        space = contact_space(body, (0.0, -3.0), (1.0, 0.0))
        np.testing.assert_allclose(space.inverse_mass, [[2.0, 0.0], [0.0, 0.5]], atol=ROUNDING)

    @pytest.mark.parametrize("angle", [0.0, 0.4, -1.2, 2.9])
    @pytest.mark.parametrize("share", [1.0, 0.6])
    def test_rod_on_a_fixed_hinge(self, angle: float, share: float) -> None:
        """One degree of freedom: K = J J^T/(m L^2/3) with J = share L along the turn."""
        space, body = pymunk.Space(), rod(2.0, 3.0, (1.0, 2.0), angle)
        hinge(space, space.static_body, body, (1.0, 2.0))
        point = (1.0 + 3.0 * share * math.sin(angle), 2.0 - 3.0 * share * math.cos(angle))
        found = contact_space(body, point, unit(0.7))
        lever = 3.0 * share * np.array(unit(angle))
        expected = turned(np.outer(lever, lever) / (2.0 * 9.0 / 3.0), 0.7)
        np.testing.assert_allclose(found.inverse_mass, expected, atol=ROUNDING)
        # Rank one, to rounding.
        assert abs(np.linalg.det(found.inverse_mass)) < ROUNDING

    def test_kinematic_hub_carries_but_has_no_mass(self) -> None:
        """K is that of a fixed hinge; the velocity is the hub's plus the rod's."""
        space, hub = pymunk.Space(), pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        hub.angular_velocity = 5.0
        body = rod(2.0, 3.0, (0.0, -1.0), 0.0)
        space.add(hub, body)
        space.add(pymunk.PivotJoint(hub, body, (0.0, -1.0)))
        body.velocity, body.angular_velocity = (5.0 + 1.5 * 7.0, 0.0), 7.0
        found = contact_space(body, (0.0, -4.0), UP)
        np.testing.assert_allclose(found.inverse_mass, [[0.0, 0.0], [0.0, 1.5]], atol=ROUNDING)
        # x is the tangent of a floor: hub 5 rad/s times 1 m and rod 7 rad/s times 3 m.
        assert found.velocity == pytest.approx((0.0, 26.0), abs=ROUNDING)

    def test_both_pivot_notations(self) -> None:
        """A joint given by two anchors is the one given by a pivot."""
        matrices = []
        for arguments in (((0.0, 0.0),), ((0.0, 0.0), (0.0, 1.5))):
            space, body = pymunk.Space(), rod(2.0, 3.0, (0.0, 0.0), 0.0)
            space.add(body, pymunk.PivotJoint(space.static_body, body, *arguments))
            matrices.append(contact_space(body, (0.0, -3.0), unit(0.3)).inverse_mass)
        np.testing.assert_allclose(matrices[0], matrices[1], atol=ROUNDING)


class TestChains:
    @pytest.mark.parametrize("ratio", RATIOS)
    @pytest.mark.parametrize("seed", range(8))
    def test_double_rods(self, ratio: float, seed: int) -> None:
        angle_1, angle_2, normal = np.random.default_rng(seed).uniform(-math.pi, math.pi, 3).tolist()
        space, first = pymunk.Space(), rod(ratio, 1.0, (0.0, 0.0), angle_1)
        knee = (math.sin(angle_1), -math.cos(angle_1))
        second = rod(1.0, 1.0, knee, angle_2)
        hinge(space, space.static_body, first, (0.0, 0.0))
        hinge(space, first, second, knee)
        tip = (knee[0] + math.sin(angle_2), knee[1] - math.cos(angle_2))
        found = contact_space(second, tip, unit(normal)).inverse_mass
        expected = turned(double_rods(ratio, angle_1, angle_2), normal)
        # Rounding times the root of the mass ratio, 1e3, by which the bodies' scales differ.
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
        assert np.array_equal(found, found.T)
        assert np.linalg.eigvalsh(found).min() >= -1e-15 * np.abs(found).max()

    def test_heavy_first_rod_tends_to_a_hub_that_does_not_yield(self) -> None:
        """K = (3/m) e e^T (1 + O(1/n))."""
        space, first, second = pymunk.Space(), rod(1e9, 1.0, (0.0, 0.0), 0.0), rod(1.0, 1.0, (0.0, -1.0), 0.0)
        hinge(space, space.static_body, first, (0.0, 0.0))
        hinge(space, first, second, (0.0, -1.0))
        found = contact_space(second, (0.0, -2.0), (1.0, 0.0)).inverse_mass
        np.testing.assert_allclose(found, [[3.0, 0.0], [0.0, 0.0]], atol=1e-8)

    @pytest.mark.parametrize("ratio", RATIOS)
    def test_pin_joint(self, ratio: float) -> None:
        """Two bodies pinned at their centres: along the pin 1/(m_1 + m_2), across it 1/m_1."""
        space, first, second = pymunk.Space(), pymunk.Body(1.0, 2.0), pymunk.Body(ratio, 3.0)
        second.position = (3.0, 4.0)
        space.add(first, second, pymunk.PinJoint(first, second))
        along = math.atan2(4.0, 3.0)
        found = contact_space(first, (0.0, 0.0), unit(along)).inverse_mass
        np.testing.assert_allclose(found, [[1.0 / (1.0 + ratio), 0.0], [0.0, 1.0]], rtol=1e-12, atol=1e-12)

    def test_two_pivots_weld(self) -> None:
        """Two rods in line, joined twice, are one rod of twice the mass and length: 4/m across its end, 1/m along."""
        space, first, second = pymunk.Space(), rod(1.0, 1.0, (0.0, 0.0), 0.0), rod(1.0, 1.0, (0.0, -1.0), 0.0)
        hinge(space, first, second, (0.0, -1.0))
        hinge(space, first, second, (0.0, -0.3))
        found = contact_space(second, (0.0, -2.0), (1.0, 0.0)).inverse_mass
        np.testing.assert_allclose(found, [[2.0, 0.0], [0.0, 0.5]], atol=1e-12)

    @pytest.mark.parametrize("copies", [2, 5])
    def test_redundant_joints_change_nothing(self, copies: int) -> None:
        matrices = []
        for count in (1, copies):
            space, body = pymunk.Space(), rod(1.0, 1.0, (0.0, 0.0), 0.4)
            for _ in range(count):
                hinge(space, space.static_body, body, (0.0, 0.0))
            matrices.append(contact_space(body, (math.sin(0.4), -math.cos(0.4)), UP).inverse_mass)
        np.testing.assert_allclose(matrices[0], matrices[1], atol=ROUNDING)

    def test_body_that_cannot_move(self) -> None:
        """Hinged at two points of the world: no impulse moves it."""
        space, body = pymunk.Space(), rod(1.0, 1.0, (0.0, 0.0), 0.4)
        hinge(space, space.static_body, body, (0.0, 0.0))
        hinge(space, space.static_body, body, (0.3, -0.2))
        np.testing.assert_allclose(contact_space(body, (1.0, 1.0), UP).inverse_mass, np.zeros((2, 2)), atol=1e-14)

    def test_springs_pass_no_impulse(self) -> None:
        space, body, other = pymunk.Space(), rod(1.0, 1.0, (0.0, 0.0), 0.0), pymunk.Body(1e3, 1e3)
        space.add(body, other)
        space.add(pymunk.DampedRotarySpring(body, other, 0.0, 1e9, 1e9))
        space.add(pymunk.DampedSpring(body, other, (0, 0), (0, 0), 1.0, 1e9, 1e9))
        found = contact_space(body, (0.0, -1.0), (1.0, 0.0))
        assert found.bodies == (body,)
        np.testing.assert_allclose(found.inverse_mass, [[4.0, 0.0], [0.0, 1.0]], atol=ROUNDING)


class TestOther:
    @pytest.mark.parametrize("ratio", RATIOS)
    def test_two_free_bodies_add_up(self, ratio: float) -> None:
        """Discs that meet centre to centre: 1/m_1 + 1/m_2 along the line, with r^2/I more across it."""
        first, second = pymunk.Body(1.0, 0.5), pymunk.Body(ratio, 0.5 * ratio)
        second.position = (-2.0, 0.0)
        first.velocity, second.velocity = (-3.0, 1.0), (4.0, 0.0)
        second.angular_velocity = 6.0
        found = contact_space(first, (-1.0, 0.0), (1.0, 0.0), second)
        sum_ = 1.0 + 1.0 / ratio
        np.testing.assert_allclose(found.inverse_mass, [[sum_, 0.0], [0.0, 3.0 * sum_]], rtol=1e-13, atol=1e-13)
        # The tangent of a normal +x is -y: -(1 - 6).
        assert found.velocity == pytest.approx((-7.0, 5.0), abs=ROUNDING)

    def test_opposite_impulses(self) -> None:
        first, second = pymunk.Body(1.0, 0.5), pymunk.Body(4.0, 2.0)
        second.position = (-2.0, 0.0)
        contact_space(first, (-1.0, 0.0), (1.0, 0.0), second).apply((2.0, 0.0))
        assert (first.velocity, second.velocity) == ((2.0, 0.0), (-0.5, 0.0))


class TestApply:
    @pytest.mark.parametrize("ratio", RATIOS)
    def test_impulse_moves_the_contact_by_k_and_leaves_joints_closed(self, ratio: float) -> None:
        """dv = K p at the contact; T changes by p.v + p.K p/2, the work of p along the way."""
        space, first = pymunk.Space(), rod(ratio, 1.0, (0.0, 0.0), 0.5)
        knee = (math.sin(0.5), -math.cos(0.5))
        second = rod(1.0, 1.0, knee, -0.8)
        hinge(space, space.static_body, first, (0.0, 0.0))
        hinge(space, first, second, knee)
        set_turning(first, second, knee, (0.3, -0.7))
        tip, impulse = (knee[0] + math.sin(-0.8), knee[1] - math.cos(-0.8)), np.array([0.4, -0.9])
        found = contact_space(second, tip, unit(1.1))
        before = kinetic(first, second)
        found.apply(impulse)
        after = contact_space(second, tip, unit(1.1)).velocity
        # Rounding times the root of the mass ratio.
        change = found.inverse_mass @ impulse
        np.testing.assert_allclose(
            np.subtract(after, found.velocity), change, atol=1e-12 * max(1.0, np.abs(change).max())
        )
        work = impulse @ found.velocity + 0.5 * impulse @ change
        assert kinetic(first, second) - before == pytest.approx(work, rel=1e-11, abs=1e-12 * max(1.0, ratio))
        opening = first.velocity_at_world_point(knee) - second.velocity_at_world_point(knee)
        assert abs(opening) < 1e-12 * max(1.0, abs(second.velocity))


def set_turning(first: pymunk.Body, second: pymunk.Body, knee: tuple[float, float], rates: tuple[float, float]) -> None:
    """Velocities of two rods of length 1 that turn about the origin and their knee."""
    first.angular_velocity, second.angular_velocity = rates
    first.velocity = (-rates[0] * first.position.y, rates[0] * first.position.x)
    arm = second.position - knee
    second.velocity = (-rates[0] * knee[1] - rates[1] * arm.y, rates[0] * knee[0] + rates[1] * arm.x)


def kinetic(*bodies: pymunk.Body) -> float:
    return sum(0.5 * b.mass * b.velocity.dot(b.velocity) + 0.5 * b.moment * b.angular_velocity**2 for b in bodies)


class TestRefusals:
    def test_normal_of_another_length(self) -> None:
        with pytest.raises(ValueError, match="must be a vector of length 1"):
            contact_space(pymunk.Body(1.0, 1.0), (0.0, 0.0), (0.0, 2.0))

    def test_nan_normal(self) -> None:
        with pytest.raises(ValueError, match="length 1"):
            contact_space(pymunk.Body(1.0, 1.0), (0.0, 0.0), (math.nan, 1.0))


class TestJointsThatTurn:
    """Two rods pinned at their centres to the ground, of moments 1 and I, one of which is struck at a lever of 1."""

    @staticmethod
    def compliance(make: object) -> float:
        space, first, second = pymunk.Space(), pymunk.Body(1.0, 1.0), pymunk.Body(1.0, 3.0)
        second.position = (5.0, 0.0)
        space.add(first, second)
        for body in (first, second):
            space.add(pymunk.PivotJoint(space.static_body, body, tuple(body.position)))
        space.add(make(first, second))  # type: ignore[operator]
        return float(contact_space(first, (1.0, 0.0), UP).inverse_mass[0, 0])

    def test_gear(self) -> None:
        """ratio w_b = w_a, so T = (1 + 3/ratio^2) w_a^2/2."""
        found = self.compliance(lambda first, second: pymunk.GearJoint(first, second, 0.0, 2.0))
        assert found == pytest.approx(1.0 / (1.0 + 3.0 / 4.0), rel=1e-13)

    def test_motor(self) -> None:
        """It holds w_b - w_a whatever the torque: T = (1 + 3) w_a^2/2."""
        found = self.compliance(lambda first, second: pymunk.SimpleMotor(first, second, 7.0))
        assert found == pytest.approx(0.25, rel=1e-13)

    def test_motor_of_finite_torque(self) -> None:
        def make(first: pymunk.Body, second: pymunk.Body) -> pymunk.Constraint:
            motor = pymunk.SimpleMotor(first, second, 7.0)
            motor.max_force = 1e9
            return motor

        assert self.compliance(make) == pytest.approx(1.0, rel=1e-13)

    @pytest.mark.parametrize(("lowest", "expected"), [(0.0, 0.25), (-1.0, 1.0)])
    def test_rotary_limit(self, lowest: float, expected: float) -> None:
        """Joined as one at the limit, apart before it."""
        found = self.compliance(lambda first, second: pymunk.RotaryLimitJoint(first, second, lowest, 1.0))
        assert found == pytest.approx(expected, rel=1e-13)

    def test_groove(self) -> None:
        """A body in a groove along x: free along it, and held across it at its anchor 1 from the centre: 1/(m + I)."""
        space, body = pymunk.Space(), pymunk.Body(1.0, 3.0)
        space.add(body, pymunk.GrooveJoint(space.static_body, body, (0.0, 0.0), (2.0, 0.0), (1.0, 0.0)))
        matrix = contact_space(body, (0.0, 0.0), UP).inverse_mass
        np.testing.assert_allclose(matrix, [[0.25, 0.0], [0.0, 1.0]], atol=ROUNDING)

    def test_a_limit_of_what_cannot_turn_is_not_passed(self) -> None:
        """Gears to the ground leave w = 0 but for rounding, which the terms of the limit's rate then consist of."""
        space, body, wheel = pymunk.Space(), pymunk.Body(1.3, 0.7), pymunk.Body(2.0, 1.1)
        gears = pymunk.GearJoint(space.static_body, wheel, 0.0, 1.3), pymunk.GearJoint(wheel, body, 0.0, 0.9)
        ratchets = [pymunk.RatchetJoint(wheel, body, 0.0, tooth) for tooth in (-0.3, 0.3)]
        space.add(body, wheel, *gears, *ratchets)
        limits = [row for each in ratchets for row in joint_rows(each, MassCentres())]
        for angle in np.linspace(0.0, 3.0, 10):
            found = contact_space(body, (0.3, math.cos(angle)), UP, released=ratchets)
            assert not any(found.passes(limit, (1.0, math.sin(angle))) for limit in limits)


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


class TestThreeBodies:
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
        with pytest.raises(ValueError, match=r"^normal = \(.*\): must be a vector of length 1$"):
            contact_space(three_bodies()[0], (0.0, 0.0), normal)


class TestAKneeJoinedTwice:
    @pytest.mark.parametrize("seed", range(6))
    def test_a_knee_joined_twice_is_joined_once(self, seed: int) -> None:
        """The second pivot says what the first says but for rounding, which must not be taken for a constraint."""
        angle, x, y, mass = np.random.default_rng(seed).uniform(0.1, 1.3, 4).tolist()
        matrices = []
        for copies in (1, 2):
            space, first, second = pymunk.Space(), pymunk.Body(mass, 0.7), pymunk.Body(1.0, 0.3)
            first.position, second.position, second.angle = (-x, y), (y, -x), angle
            space.add(first, second)
            for _ in range(copies):
                space.add(pymunk.PivotJoint(first, second, (0.1 * x, 0.3)))
            matrices.append(contact_space(second, (x, -1.0), (math.sin(angle), math.cos(angle))).inverse_mass)
        # A dozen operations on numbers of order 10.
        np.testing.assert_allclose(matrices[1], matrices[0], rtol=0.0, atol=1e-13 * np.abs(matrices[0]).max())
