"""Small things that other tests let pass: each fails if one operator or number of the code is another one.

Every expectation is worked out by hand in the test's docstring.
"""

import math

import numpy as np
import pytest

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
