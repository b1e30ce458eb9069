"""A scene holds exactly what was requested, and its bodies stand where the state says."""

import itertools
import math

import numpy as np
import pymunk
import pytest
from scipy.linalg import eigh, expm

from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact.obstacles import WorkpartObstacle
from bristle_sim.scene.integrate.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.tool import build_tool

ROD = Link.rod(1.0, 1.0)
FLOOR = WorkpartObstacle(1.0, 0.5, 0.5, 0.0)
CLOSED = 1e-14
"""Rounding of positions of order 1."""


def kinds(space: pymunk.Space) -> list[str]:
    return sorted(type(each).__name__ for each in space.constraints)


class TestWhatIsThere:
    @pytest.mark.parametrize(
        ("hub", "belt", "bar", "workpart", "gravity"), list(itertools.product([False, True], repeat=5))
    )
    def test_each_effect_brings_its_own_parts_and_no_others(
        self, hub: bool, belt: bool, bar: bool, workpart: bool, gravity: bool
    ) -> None:
        """A hub or a belt brings the kinematic body, a belt its spring, an obstacle, once engaged, its shape and the link's."""
        tool = Tool(
            hub=Hub() if hub else Hub(radius=0.0),
            belt=Belt() if belt else Belt(stiffness=0.0),
            bar=Bar() if bar else None,
            workpart=Workpart() if workpart else None,
            gravity=9.81 if gravity else 0.0,
        )
        scene, units = build_tool(tool)
        assert len(scene.space.bodies) == 1 + (hub or belt)
        assert kinds(scene.space) == ["DampedRotarySpring"] * belt + ["PivotJoint"]
        assert len(scene.space.shapes) == 0
        for obstacle in scene.effects.obstacles:
            scene.contacts.engage(obstacle, friction=0.0, elasticity=0.0, iterations=1)
        assert len(scene.space.shapes) == 2 * (bar + workpart)
        assert len(scene.space.static_body.shapes) == bar + workpart
        # One multiplication and one division of rounding.
        assert -scene.space.gravity.y * units.velocity / units.time == pytest.approx(9.81 * gravity, rel=1e-15)
        assert scene.space.gravity.x == 0.0

    def test_no_callbacks(self) -> None:
        """Velocity and position functions are the engine's own, and no joint calls back."""
        scene, _ = build_tool(Tool(belt=Belt(damping_ratio=0.1), gravity=9.81))
        for body in scene.space.bodies:
            assert body.velocity_func is pymunk.Body.update_velocity
            assert body.position_func is pymunk.Body.update_position
        for joint in scene.space.constraints:
            assert joint.pre_solve is None
            assert joint.post_solve is None


class TestHinges:
    """Two slender rods of length 1, masses 2 and 1, in line on a fixed root: small motion of their angles is linear.

    M = ((m1/3 + m2, m2/2), (m2/2, m2/3)), K = k ((1, -1), (-1, 1)), C = c ((1, -1), (-1, 1)): one angle of both at rest or in
    uniform motion, and one oscillation, det(K - w^2 M) = 0.
    """

    MASS = np.array([[2.0 / 3.0 + 1.0, 0.5], [0.5, 1.0 / 3.0]])
    COUPLING = np.array([[1.0, -1.0], [-1.0, 1.0]])
    RODS = Mechanism((Link.rod(2.0, 1.0), Link.rod(1.0, 1.0)))

    def test_frequency(self) -> None:
        """The mode released at rest is there again, at rest, after 2 pi/w; 1e-4 rad leave 1e-8 of nonlinearity."""
        squares, modes = eigh(0.3 * self.COUPLING, self.MASS)
        shape = 1e-4 * modes[:, -1] / np.abs(modes[:, -1]).max()
        scene = Scene(self.RODS, Effects(hinges=((0.3, 0.0),)))
        state = State(0.0, tuple(shape.tolist()), (0.0, 0.0))
        for _ in range(16):
            state = Extrapolation(1e-12).advance(scene, state, math.tau / math.sqrt(squares[-1]) / 16.0).state
        # Sixteen intervals to 1e-12, of 1e-4 rad.
        assert state.angles == pytest.approx(shape, abs=1e-10)
        assert state.rates == pytest.approx((0.0, 0.0), abs=1e-10)

    def test_damping(self) -> None:
        """The linear system's exponential over 3 time units."""
        inverse = np.linalg.inv(self.MASS)
        system = np.block(
            [[np.zeros((2, 2)), np.eye(2)], [-0.3 * inverse @ self.COUPLING, -0.02 * inverse @ self.COUPLING]]
        )
        start = np.array([1e-4, -1e-4, 0.0, 5e-5])
        expected = expm(3.0 * system) @ start
        scene = Scene(self.RODS, Effects(hinges=((0.3, 0.02),)))
        state = State(0.0, tuple(start[:2].tolist()), tuple(start[2:].tolist()))
        for _ in range(8):
            state = Extrapolation(1e-12).advance(scene, state, 0.375).state
        assert (*state.angles, *state.rates) == pytest.approx(expected, abs=1e-10)

    def test_one_for_each_joint_between_two_links(self) -> None:
        with pytest.raises(ValueError, match=r"^hinges: must be one \(stiffness, damping\) for each of the 1 joints"):
            Scene(self.RODS, Effects(hinges=((0.3, 0.0), (0.3, 0.0))))


class TestPlacing:
    STATE = State(0.4, (0.3, -1.2, 2.0), (1.0, -3.0, 0.5))
    CHAIN = Mechanism((ROD, Link.rod(2.0, 0.5), Link(1.0, 0.1, (0.1, -0.3), (0.2, -0.8))), 0.7, 1.3, -0.2)

    def test_joints_are_closed_and_their_ends_move_together(self) -> None:
        scene = Scene(self.CHAIN, Effects())
        scene.place(self.STATE)
        assert len(scene.joints) == 3
        for joint in scene.joints:
            first, second = joint.a.local_to_world(joint.anchor_a), joint.b.local_to_world(joint.anchor_b)
            assert abs(first - second) < CLOSED
            difference = joint.a.velocity_at_world_point(first) - joint.b.velocity_at_world_point(second)
            assert abs(difference) < 10.0 * CLOSED

    def test_bodies_are_where_the_poses_are(self) -> None:
        scene = Scene(self.CHAIN, Effects())
        scene.place(self.STATE)
        assert scene.angles() == list(self.STATE.angles)
        assert scene.rates() == list(self.STATE.rates)
        for body, pose in zip(scene.links, self.CHAIN.poses(self.STATE), strict=True):
            assert body.position == pose.centre
            assert body.velocity == pose.centre_velocity
            tip = self.CHAIN.links[scene.links.index(body)].tip
            centre = self.CHAIN.links[scene.links.index(body)].centre
            assert abs(body.local_to_world((tip[0] - centre[0], tip[1] - centre[1])) - pose.tip) < CLOSED


class TestContact:
    def resting(self, effects: Effects, angle: float) -> Scene:
        """A rod on a fixed root whose tip stands on the floor at an angle, pressed on by gravity."""
        scene = Scene(Mechanism((ROD,)), effects)
        scene.place(State(0.0, (angle,), (0.0,)))
        return scene

    def test_impulse_of_a_resting_contact_carries_the_weight(self) -> None:
        """Rod at 45 degrees, gravity g: moments about the root, N L sin 45 = m g (L/2) sin 45, so N = m g/2."""
        floor = WorkpartObstacle(math.cos(0.25 * math.pi), 0.0, 0.0, 0.0)
        scene = self.resting(Effects(gravity=9.0, obstacles=(floor,)), 0.25 * math.pi)
        scene.contacts.engage(floor, friction=0.0, elasticity=0.0, iterations=80)
        scene.step(1e-3, 3)
        normal, tangential, _ = scene.contacts.totals(floor)
        # Eighty iterations leave 0.4^80; the state moves by 1e-6 in three steps of 1e-3.
        assert normal == pytest.approx(4.5e-3, rel=1e-5)
        assert tangential == 0.0

    @pytest.mark.parametrize("friction", [0.2, 0.7])
    def test_friction_opposes_slip(self, friction: float) -> None:
        """A pendulum's tip rubs over a floor to the right: the tangential impulse is -mu times the normal one."""
        floor = WorkpartObstacle(math.cos(0.6), friction, friction, 0.0)
        scene = self.resting(Effects(obstacles=(floor,)), -0.6)
        scene.place(State(0.0, (-0.6,), (1.0,)))
        scene.contacts.engage(floor, friction=friction, elasticity=0.0, iterations=200)
        scene.step(1e-9, 1)
        normal, tangential, _ = scene.contacts.totals(floor)
        # One degree of freedom: v_n = -L sin 0.6, K = (s (s + mu c)) 3/m with friction helping to stop the tip.
        s, c = math.sin(0.6), math.cos(0.6)
        assert normal == pytest.approx(s / (3.0 * s * (s + friction * c)), rel=1e-6)
        assert tangential == pytest.approx(-friction * normal, rel=1e-12)
