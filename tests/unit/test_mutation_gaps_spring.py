"""The contact spring of the compliant law: what other tests let pass. Expected by hand and from symmetry."""

import math

import numpy as np
import pytest

from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact_laws import Coefficients
from bristle_sim.scene.contact_space import contact_space
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.obstacles import Touch
from bristle_sim.scene.spring import Spring, time_at_unit_stiffness
from bristle_sim.scene.stepping import PlainSteps
from bristle_sim.theory.impact import energetic_impact

BENT = Link(1.0, 0.1, (0.15, -0.4), (0.1, -1.0))
"""Its centre and tip are off the axis on which its angle is measured."""


def pressed(turn: float, stick: bool) -> tuple[Spring, Scene, State]:
    """Two links whose tip is 0.01 deep in a plane, everything turned about the root at the origin."""
    mechanism = Mechanism((Link.rod(2.0, 1.0), BENT))
    scene, state = Scene(mechanism, Effects()), State(0.0, (0.4 + turn, 0.9 + turn), (0.5, -0.3))
    scene.place(state)
    pose = mechanism.poses(state)[-1]
    normal = (-math.sin(turn), math.cos(turn))
    space = contact_space(scene.links[-1], pose.tip, normal)
    touch = Touch(0.0, (0.0, 0.0), normal, space.velocity, ())
    spring = Spring(scene, touch, space.inverse_mass, 3e5, Coefficients(0.3, 0.2, 0.5))
    spring.surface += 0.01
    if stick:
        spring.slip = 0.0
    return spring, scene, state


class TestSpring:
    @pytest.mark.parametrize("stick", [False, True])
    @pytest.mark.parametrize("turn", [0.7, 2.5, -1.2, math.pi])
    def test_the_plane_may_lie_in_any_direction(self, turn: float, stick: bool) -> None:
        """Nothing knows which way is up: impulses, works and rates of ten steps are those of the plane that is level."""
        found = []
        for angle in (0.0, turn):
            spring, scene, state = pressed(angle, stick)
            results = []
            for _ in range(10):
                results.append(PlainSteps(1e-4).advance(scene, state, 1e-4, spring))
                state = results[-1].state
            found.append([(*each.totals, *each.state.rates) for each in results])
            assert found[-1][0][0] == pytest.approx(3e5 * 0.01 * 1e-4, rel=1e-9), "k depth h in the first step"
        # Ten steps of a dozen roundings each, of numbers of order 1 (and forces of 4e3), and joints solved to rounding.
        np.testing.assert_allclose(found[1], found[0], rtol=1e-12, atol=1e-11)

    @pytest.mark.parametrize("turn", [0.0, 0.7])
    def test_stick_stops_the_point_within_a_step(self, turn: float) -> None:
        """-(K_nt N + v_t/h)/K_tt leaves v_t = 0 but for the turn of the links within h: rate h of the speed."""
        spring, scene, state = pressed(turn, stick=True)
        before = spring.components(scene.mechanism.poses(state)[-1].tip_velocity)[1]
        normal = 3e5 * 0.01
        assert abs(before) > 0.1
        assert abs(spring.coupling) * normal * 1e-5 > 1e-3, "the normal force alone would set it in motion"
        end = PlainSteps(1e-5).advance(scene, state, 1e-5, spring).state
        assert abs(spring.components(scene.mechanism.poses(end)[-1].tip_velocity)[1]) < 3e-5

    @pytest.mark.parametrize(("velocity", "slip"), [(-0.1, -1.0), (0.0, 0.0), (2.0, 1.0)])
    def test_direction_of_slip(self, velocity: float, slip: float) -> None:
        scene = Scene(Mechanism((BENT,)), Effects())
        scene.place(State(0.0, (0.1,), (0.2,)))
        touch = Touch(0.0, (0.0, 0.0), (0.6, 0.8), (-1.0, velocity), ())
        assert Spring(scene, touch, np.eye(2), 1.0, Coefficients(0.3, 0.3, 0.5)).slip == slip

    def test_penetration_and_components_by_hand(self) -> None:
        """Normal (0.6, 0.8), tangent (0.8, -0.6): half a unit along -normal is half a unit deep."""
        scene = Scene(Mechanism((BENT,)), Effects())
        state = State(0.0, (0.1,), (0.2,))
        scene.place(state)
        touch = Touch(0.0, (0.0, 0.0), (0.6, 0.8), (-1.0, 0.0), ())
        spring = Spring(scene, touch, np.eye(2), 1.0, Coefficients(0.3, 0.3, 0.5))
        x, y = scene.mechanism.poses(state)[-1].tip
        assert spring.penetration((x, y)) == pytest.approx(0.0, abs=1e-15)
        assert spring.penetration((x - 0.3 + 8.0, y - 0.4 - 6.0)) == pytest.approx(0.5, abs=1e-14)
        assert spring.components((1.0, 2.0)) == pytest.approx((2.2, -0.4), abs=1e-15)

    def test_the_way_out_takes_over_where_the_way_in_ends(self) -> None:
        """k/e^2 (delta - (1 - e^2) delta_max) is k delta_max at delta_max and 0 at (1 - e^2) delta_max."""
        spring, _, _ = pressed(0.0, stick=False)
        spring.unload((0.0, spring.surface - 0.02))
        assert spring.forces(0.02)[0] == pytest.approx(3e5 * 0.02, rel=1e-12)
        assert spring.forces(0.015)[0] == pytest.approx(0.0, abs=1e-9)
        assert spring.forces(0.02)[1] == pytest.approx(-0.2 * spring.slip * 6e3, rel=1e-12)

    def test_without_restitution_there_is_no_way_out(self) -> None:
        spring, _, _ = pressed(0.0, stick=False)
        spring.coefficients = Coefficients(0.3, 0.2, 0.0)
        spring.unload((0.0, spring.surface - 0.02))
        assert spring.forces(0.02) == (0.0, 0.0)
        assert spring.forces(0.03)[0] == 0.0

    @pytest.mark.parametrize("mass", [1e-12, 1e12])
    def test_duration_of_a_contact_of_any_mass(self, mass: float) -> None:
        """Two quarter periods, pi/2 (1 + e) sqrt(m)."""
        impact = energetic_impact(np.eye(2) / mass, [-1.0, 0.3], 0.1, 0.5)
        expected = 0.75 * math.pi * math.sqrt(mass)
        assert time_at_unit_stiffness(impact, -1.0, 0.5) == pytest.approx(expected, rel=1e-12, abs=0.0)
