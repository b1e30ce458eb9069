"""Small things that other tests let pass: each fails if one operator or number of the code is another one.

Every expectation is worked out by hand in the test's docstring.
"""

import math

import numpy as np
import pymunk
import pytest

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene import repetitions
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact_space import contact_space
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.repetitions import Repetitions
from bristle_sim.scene.spring import time_at_unit_stiffness
from bristle_sim.scene.stepping import PlainSteps, Stepper, SymmetricSteps
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.theory.impact import energetic_impact, poisson_impact


class TestImpactLaw:
    @pytest.mark.parametrize("slip", [10.0, 0.35])
    def test_work_of_friction_in_restitution(self, slip: float) -> None:
        """K = 1 (uncoupled), v_n = -1, mu = 0.3, e* = 0.5: p_c = 1, p_r = 0.5, and v_t falls by 0.3 per unit impulse.

        Friction takes the energy of the tangential motion, v_t^2/2 before restitution less v_t^2/2 after it. Slip of 0.35
        has 0.05 left after compression, less than the 0.15 that restitution could take: all of it goes.
        """
        result = energetic_impact(np.eye(2), [-1.0, slip], 0.3, 0.5)
        before, after = slip - 0.3, max(slip - 0.45, 0.0)
        # A few roundings of numbers of order slip^2.
        small = 1e-15 * slip**2
        assert result.compressive_work_tangential == pytest.approx(0.5 * (before**2 - slip**2), rel=1e-14, abs=small)
        assert result.restitutive_work_tangential == pytest.approx(0.5 * (after**2 - before**2), rel=1e-13, abs=small)

    def test_work_of_friction_after_slip_that_reverses_in_restitution(self) -> None:
        """K = ((1, 0.8), (0.8, 1)), v = (-1, -1.2), mu = 0.1, e* = 1: by hand.

        Backward slip: v_n' = 0.8 (1.25 + 0.1), v_t' = 0.9, so compression ends at p = 1/1.08 with v_t = -1.2 + 0.9/1.08,
        W_c = -0.5/1.08. Slip stops after (1.2 - 0.9/1.08)/0.9 more, where v_n = 1.08 times that; forward slip then has
        v_n' = 0.92, v_t' = 0.7, and takes v_n^2 - w^2 = 2 0.92 (W_c left). Friction's work is -0.1 times the slip path.
        """
        result = energetic_impact([[1.0, 0.8], [0.8, 1.0]], [-1.0, -1.2], 0.1, 1.0)
        left_slip = 1.2 - 0.9 / 1.08
        backwards = left_slip / 0.9
        at_stop = 1.08 * backwards
        work_left = 0.5 / 1.08 - 0.5 * at_stop * backwards
        forwards = (math.sqrt(at_stop**2 + 2.0 * 0.92 * work_left) - at_stop) / 0.92
        friction = -0.1 * 0.5 * (left_slip * backwards + 0.7 * forwards**2)
        assert result.phases == ("compression slip", "restitution slip", "restitution reverse slip")
        # A few roundings, of differences that keep one digit less.
        assert result.restitutive_work_tangential == pytest.approx(friction, rel=1e-13)

    @pytest.mark.parametrize("matrix", [((-1.0, 0.0), (0.0, 0.0)), ((0.0, 0.0), (0.0, -1.0))])
    def test_negative_mass_beside_none_is_refused(self, matrix: tuple[tuple[float, float], ...]) -> None:
        """K = diag(-1, 0) has a determinant of 0 as a hinged rod's K has, but no body gains speed against its impulse."""
        with pytest.raises(ValueError, match="positive semidefinite"):
            energetic_impact(matrix, [-1.0, 0.0], 0.3, 0.5)

    @pytest.mark.parametrize("scale", [1.0, 3.0])
    def test_poisson_in_stiction(self, scale: float) -> None:
        """One degree of freedom, mu > tan gamma: stick leaves no compliance, so p_r = e p_c parts the point from nothing.

        Its speed is 0 after the impact, and the outcome is the energetic law's: stiction.
        """
        angle = math.radians(30.0)
        lever = np.array([-math.sin(angle), math.cos(angle)])
        matrix = scale * np.outer(lever, lever)
        for law in (poisson_impact, energetic_impact):
            result = law(matrix, 2.0 * lever, 0.7, 0.5)
            assert result.outcome_name == "stiction"
            assert result.velocity_normal == 0.0

    def test_a_rebound_at_unit_compliance_is_one(self) -> None:
        """K = 1, e = 1, v_n = -1: the point leaves at exactly 1, which is no stiction."""
        for law in (poisson_impact, energetic_impact):
            result = law(np.eye(2), [-1.0, 0.0], 0.3, 1.0)
            assert (result.velocity_normal, result.outcome_name) == (1.0, "rebound")

    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_friction_that_just_suffices_sticks(self, side: float) -> None:
        """mu = |K_nt|/K_tt exactly, no slip before: Zhang 2020, eq. 2.90, counts equality as stick."""
        result = energetic_impact([[1.0, 0.5 * side], [0.5 * side, 1.0]], [-1.0, 0.0], 0.5, 0.5)
        assert result.phases == ("compression stick", "restitution stick")
        assert result.impulse_tangential == pytest.approx(-0.5 * side * result.impulse_normal, rel=1e-15)


class TestContactSpace:
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


def oscillator() -> tuple[Scene, State]:
    """A rod of mass and length 1, turning about the hub's axis at a natural rate of 1."""
    return Scene(Mechanism((Link.rod(1.0, 1.0),)), Effects(stiffness=1.0 / 3.0)), State(0.0, (0.7,), (-0.2,))


class TestStepping:
    @pytest.mark.parametrize("stepper", [PlainSteps(0.01), SymmetricSteps(0.01)])
    def test_joints_are_left_uncorrected(self, stepper: Stepper) -> None:
        """A correction divides what is open by the step: over the instant of an impact it would be without bound."""
        scene, state = oscillator()
        stepper.advance(scene, state, 0.01)
        assert [joint.error_bias for joint in scene.joints] == [1.0]

    @pytest.mark.parametrize("kind", [PlainSteps, SymmetricSteps])
    @pytest.mark.parametrize("step", [0.01, 3.0])
    def test_stray_of_a_straight_line(self, kind: type[PlainSteps] | type[SymmetricSteps], step: float) -> None:
        """A cubic that ends on the line of its first rate, at another rate, is off it by h dr (s^2 - s^3), at most 4/27.

        Twice that for each link; 2 % for a factor of 8/27 rounded to two digits.
        """
        start, end = State(1.0, (0.1, 0.2), (1.0, -2.0)), State(1.0 + step, (0.3, 0.1), (1.5, -2.2))
        assert kind(0.01).interpolation_error(start, end) == pytest.approx(8.0 / 27.0 * step * 0.7, rel=0.02)

    def test_cost_counts_every_run_and_step(self) -> None:
        """Two runs of 4 and 5 steps cost two overheads and 9 steps."""
        overhead = repetitions.RUN_OVERHEAD
        assert Repetitions(4, 5).costs == [overhead + 4.0, 2.0 * overhead + 9.0]

    def test_a_stretch_may_be_a_tenth_longer_to_save_a_stub(self) -> None:
        """1.05 lengths are gone in one stretch, 1.15 in two halves."""
        stepper = Extrapolation(1e-6)
        assert stepper.propose(1.05 * stepper.length) == 1.05 * stepper.length
        assert stepper.propose(1.15 * stepper.length) == 0.575 * stepper.length

    def test_a_refused_stretch_is_cut_by_its_estimate(self) -> None:
        """Twenty radians are far off 1e-9: an error e of order k needs (1e-9/e)^(1/k), at most 0.2 for e >= 0.01, k <= 10.

        No change is larger than tenfold at once.
        """
        scene, start = oscillator()
        stepper = Extrapolation(1e-9)
        result = stepper.advance(scene, start, 20.0)
        assert result.error > 0.01
        assert not stepper.accepts(result, 20.0)
        assert 2.0 * (1.0 - 1e-12) <= stepper.length < 10.0

    @pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
    def test_uniform_motion_is_hardly_ever_refused(self, tolerance: float) -> None:
        """An oscillator's stretches are all alike, and each is aimed at half the tolerance: its phase alone is new."""
        scene, state = oscillator()
        stepper = Extrapolation(tolerance)
        refused = accepted = 0
        while state.time < 60.0:
            length = stepper.propose(1e3)
            result = stepper.advance(scene, state, length)
            if stepper.accepts(result, length):
                state, accepted = result.state, accepted + 1
            else:
                refused += 1
        assert accepted > 10
        assert refused <= 0.2 * accepted


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


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_ledger_of_a_contact_resolved_in_time(restitution: float) -> None:
    """Every entry tends to that of the rigid-body law, as the rates do: within ten times the accuracy asked for."""
    chain = Chain((1.0, 1.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2))
    surface = Surface(0.3, None, restitution)
    limit = strike(chain, surface, Contact(), Settings()).contact
    found = strike(chain, surface, Contact("compliant"), Settings(accuracy=1e-5)).contact
    for name in ("compressive_impulse", "compressive_work", "restitutive_work", "velocity_before", "velocity_after"):
        expected = getattr(limit, name)
        # The tangential parts are shares of the normal ones; a final v_n of 0 is one beside that of the approach.
        size = max(map(abs, limit.velocity_before if "velocity" in name else expected), default=0.0)
        assert getattr(found, name) == pytest.approx(expected, rel=1e-4, abs=1e-4 * size + 1e-12), name
