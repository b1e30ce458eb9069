"""The contact spring of the compliant law, against values by hand and symmetry."""

import math

import numpy as np
import pytest

from bristle_sim.contact_space.impulse import contact_space
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact.laws import Coefficients
from bristle_sim.scene.contact.obstacles import ClosestApproach
from bristle_sim.scene.contact.spring import Plane, Spring, SpringLoad, time_at_unit_stiffness
from bristle_sim.scene.integrate.stepping import PlainSteps
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.theory.impact import energetic_impact

BENT = Link(1.0, 0.1, (0.15, -0.4), (0.1, -1.0))
"""Its centre and tip are off the axis on which its angle is measured."""


def pressed(turn: float, stick: bool) -> tuple[SpringLoad, Scene, State]:
    """Two links whose tip is 0.01 deep in a plane, everything turned about the root at the origin."""
    mechanism = Mechanism((Link.rod(2.0, 1.0), BENT))
    scene, state = Scene(mechanism, Effects()), State(0.0, (0.4 + turn, 0.9 + turn), (0.5, -0.3))
    scene.place(state)
    pose = mechanism.poses(state)[-1]
    normal = (-math.sin(turn), math.cos(turn))
    space = contact_space(scene.links[-1], pose.tip, normal)
    touch = ClosestApproach(0.0, (0.0, 0.0), normal, space.velocity, ())
    load = SpringLoad(scene, touch, space.inverse_mass, 3e5, Coefficients(0.3, 0.2, 0.5))
    load.spring.plane = load.spring.plane._replace(height=load.spring.plane.height + 0.01)
    if stick:
        load.spring.slip = 0.0
    return load, scene, state


class TestSpring:
    @pytest.mark.parametrize("stick", [False, True])
    @pytest.mark.parametrize("turn", [0.7, 2.5, -1.2, math.pi])
    def test_the_plane_may_lie_in_any_direction(self, turn: float, stick: bool) -> None:
        """Nothing knows which way is up: impulses, works and rates of ten steps are those of the plane that is level."""
        found = []
        for angle in (0.0, turn):
            load, scene, state = pressed(angle, stick)
            results = []
            for _ in range(10):
                results.append(PlainSteps(1e-4).advance(scene, state, 1e-4, load))
                state = results[-1].state
            found.append([(*each.totals, *each.state.rates) for each in results])
            assert found[-1][0][0] == pytest.approx(3e5 * 0.01 * 1e-4, rel=1e-9), "k depth h in the first step"
        # Ten steps of a dozen roundings each, of numbers of order 1 (and forces of 4e3), and joints solved to rounding.
        np.testing.assert_allclose(found[1], found[0], rtol=1e-12, atol=1e-11)

    @pytest.mark.parametrize("turn", [0.0, 0.7])
    def test_stick_stops_the_point_within_a_step(self, turn: float) -> None:
        """-(K_nt N + v_t/h)/K_tt leaves v_t = 0 but for the turn of the links within h: rate h of the speed."""
        load, scene, state = pressed(turn, stick=True)
        before = load.spring.plane.components(scene.mechanism.poses(state)[-1].tip_velocity)[1]
        normal = 3e5 * 0.01
        assert abs(before) > 0.1
        assert abs(load.spring.coupling) * normal * 1e-5 > 1e-3, "the normal force alone would set it in motion"
        end = PlainSteps(1e-5).advance(scene, state, 1e-5, load).state
        assert abs(load.spring.plane.components(scene.mechanism.poses(end)[-1].tip_velocity)[1]) < 3e-5

    @pytest.mark.parametrize(("velocity", "slip"), [(-0.1, -1.0), (0.0, 0.0), (2.0, 1.0)])
    def test_direction_of_slip(self, velocity: float, slip: float) -> None:
        plane = Plane((0.6, 0.8), (0.8, -0.6), 0.0)
        assert Spring(plane, velocity, np.eye(2), 1.0, Coefficients(0.3, 0.3, 0.5)).slip == slip

    def test_penetration_and_components_by_hand(self) -> None:
        """Normal (0.6, 0.8), tangent (0.8, -0.6): half a unit along -normal is half a unit deep."""
        scene = Scene(Mechanism((BENT,)), Effects())
        state = State(0.0, (0.1,), (0.2,))
        scene.place(state)
        touch = ClosestApproach(0.0, (0.0, 0.0), (0.6, 0.8), (-1.0, 0.0), ())
        plane = SpringLoad(scene, touch, np.eye(2), 1.0, Coefficients(0.3, 0.3, 0.5)).spring.plane
        x, y = scene.mechanism.poses(state)[-1].tip
        assert plane.penetration((x, y)) == pytest.approx(0.0, abs=1e-15)
        assert plane.penetration((x - 0.3 + 8.0, y - 0.4 - 6.0)) == pytest.approx(0.5, abs=1e-14)
        assert plane.components((1.0, 2.0)) == pytest.approx((2.2, -0.4), abs=1e-15)

    def test_the_way_out_takes_over_where_the_way_in_ends(self) -> None:
        """k/e^2 (delta - (1 - e^2) delta_max) is k delta_max at delta_max and 0 at (1 - e^2) delta_max."""
        load, _, _ = pressed(0.0, stick=False)
        spring = load.spring
        spring.unload((0.0, spring.plane.height - 0.02))
        assert spring.forces(0.02)[0] == pytest.approx(3e5 * 0.02, rel=1e-12)
        assert spring.forces(0.015)[0] == pytest.approx(0.0, abs=1e-9)
        assert spring.forces(0.02)[1] == pytest.approx(-0.2 * spring.slip * 6e3, rel=1e-12)

    def test_without_restitution_there_is_no_way_out(self) -> None:
        load, _, _ = pressed(0.0, stick=False)
        spring = load.spring
        spring.coefficients = Coefficients(0.3, 0.2, 0.0)
        spring.unload((0.0, spring.plane.height - 0.02))
        assert spring.forces(0.02) == (0.0, 0.0)
        assert spring.forces(0.03)[0] == 0.0

    @pytest.mark.parametrize("mass", [1e-12, 1e12])
    def test_duration_of_a_contact_of_any_mass(self, mass: float) -> None:
        """Two quarter periods, pi/2 (1 + e) sqrt(m)."""
        impact = energetic_impact(np.eye(2) / mass, [-1.0, 0.3], 0.1, 0.5)
        expected = 0.75 * math.pi * math.sqrt(mass)
        assert time_at_unit_stiffness(impact, -1.0, 0.5) == pytest.approx(expected, rel=1e-12, abs=0.0)


class TestSpringTime:
    """Duration for k = 1: v' = a N and N' = -k v turn (v, N) at the rate sqrt(a k), with k/e*^2 on the way out."""

    @pytest.mark.parametrize("slip", [0.0, 0.1, 0.3, 9.0])
    def test_uncoupled_contact(self, slip: float) -> None:
        """Two quarter periods, pi/2 (1 + e)/sqrt(a), wherever slip stops: a = 2, mu = 0.5, p_c = 0.5, p_r = 0.25.

        Slip of 0.1 stops in compression, 0.3 in restitution, 9 never.
        """
        impact = energetic_impact([[2.0, 0.0], [0.0, 1.0]], [-1.0, slip], 0.5, 0.5)
        expected = 0.5 * math.pi * 1.5 / math.sqrt(2.0)
        assert time_at_unit_stiffness(impact, -1.0, 0.5) == pytest.approx(expected, rel=1e-13)

    @pytest.mark.parametrize("speed", [0.01, 1.0, 100.0])
    def test_slip_at_rest(self, speed: float) -> None:
        """K = ((1, 0.8), (0.8, 1)), mu 0 and then 5, e* = 0.5, slip equal to the approach u: phases by hand.

        Compression a quarter period pi/2; N then stays sqrt(2 4 u^2/8) = u for an impulse of 4 u, a time of 4; stick
        with a = 0.36 and stiffness 4 leaves in a quarter period of pi/2/1.2.
        """
        impact = energetic_impact([[1.0, 0.8], [0.8, 1.0]], [-speed, speed], 0.0, 0.5, 5.0)
        expected = 0.5 * math.pi + 4.0 + 0.5 * math.pi / 1.2
        # The angle of a phase that begins at rest is that of a v_n of rounding: 1e-16 over its speed.
        assert time_at_unit_stiffness(impact, -speed, 0.5) == pytest.approx(expected, rel=1e-12)

    def test_slip_that_reverses_in_restitution(self) -> None:
        """K = ((1, 0.8), (0.8, 1)), v = (-1, -1.2), mu = 0.1, e* = 0.9: a = 1.08 until slip stops, then 0.92.

        N at the end of compression is 1/sqrt(1.08). On the way out (k = 1/0.81) v_n = N sqrt(a/k) sin(angle).
        """
        impact = energetic_impact([[1.0, 0.8], [0.8, 1.0]], [-1.0, -1.2], 0.1, 0.9)
        assert impact.phases == ("compression slip", "restitution slip", "restitution reverse slip")
        speed = 1.08 * (1.2 - 0.9 / 1.08) / 0.9
        stiffness, force = 1.0 / 0.81, 1.0 / math.sqrt(1.08)
        first = math.asin(speed / (force * math.sqrt(1.08 / stiffness)))
        second = 0.5 * math.pi - math.atan(speed / (force * math.cos(first) * math.sqrt(0.92 / stiffness)))
        expected = 0.5 * math.pi / math.sqrt(1.08) + first / math.sqrt(1.08 * stiffness)
        expected += second / math.sqrt(0.92 * stiffness)
        assert time_at_unit_stiffness(impact, -1.0, 0.9) == pytest.approx(expected, rel=1e-12)
