"""A scene holds exactly what was requested, and its bodies stand where the state says."""

import itertools
import math

import numpy as np
import pymunk
import pytest

from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact.obstacles import WorkpartObstacle
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


class TestContact:
    def resting(self, effects: Effects, angle: float) -> Scene:
        """A rod on a fixed root whose tip stands on the floor at an angle, pressed on by gravity."""
        scene = Scene(Mechanism((ROD,)), effects)
        scene.place(State(0.0, (angle,), (0.0,)))
        return scene

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
