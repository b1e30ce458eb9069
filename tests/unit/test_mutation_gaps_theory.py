"""Small things of the closed forms that other tests let pass: each fails if one operator or number is another one.

Every expectation is worked out by hand, from a symmetry or from the definition, in the test's docstring.
"""

import math
from collections.abc import Callable

import numpy as np
import pytest

from bristle_sim.theory import checks, cueing, monofilament
from bristle_sim.theory.impact import OUTCOMES, energetic_impact, newton_impact, poisson_impact
from bristle_sim.theory.pendulums import double_pendulum_impact, single_pendulum_impact, stick_friction

LAWS = (energetic_impact, poisson_impact, newton_impact)


def one_freedom(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Direction (n, t) of the tip of a bristle at an angle to the normal, and K of unit mass along it alone."""
    along = np.array([-math.sin(angle), math.cos(angle)])
    return along, np.outer(along, along)


class TestImpactLaw:
    @pytest.mark.parametrize("law", LAWS)
    @pytest.mark.parametrize("lengthen", [np.asarray, lambda value: np.stack([value, value])])
    def test_whole_numbers_are_numbers(self, law: Callable, lengthen: Callable) -> None:
        """K = ((2, 1), (1, 2)), v = (-1, 1), mu = 0, e = 1 typed as integers: v_n is reversed by 2 |v_n|/K_nn."""
        matrix, velocity = lengthen(np.array([[2, 1], [1, 2]])), lengthen(np.array([-1, 1]))
        for arguments in ((matrix, velocity, 0, 1), (matrix.astype(float), velocity, 0.0, 1)):
            result = law(*arguments)
            np.testing.assert_allclose(result.impulse_normal, 1.0, rtol=1e-15)
            np.testing.assert_allclose(result.velocity_tangential, 2.0, rtol=1e-15)

    def test_a_touch_whose_work_is_below_the_smallest_float(self) -> None:
        """K = 1, v_n = -1e-170: W_c = 5e-341 is no float, but p_f lies between p_c = 1e-170 and 2 p_c, and the outcome is named by v_n."""
        result = energetic_impact(np.eye(2), [-1e-170, 0.0], 0.3, 0.5)
        assert 1e-170 <= result.impulse_normal <= 2e-170
        assert result.outcome_name == ("rebound" if result.velocity_normal > 0.0 else "no rebound")

    @pytest.mark.parametrize("law", LAWS)
    @pytest.mark.parametrize("lengthen", [float, lambda value: np.array([value])])
    def test_one_freedom_a_rounding_off_its_line(self, law: Callable, lengthen: Callable) -> None:
        """mu = 0.7 > tan 0.5: once slip has stopped nothing moves the point, whose v_n is then 1e-9 tan 0.5 or so.

        That is rest, and the impulse is that of compression, 2/(sin 0.5 + 0.7 cos 0.5), up to parts in 1e9.
        """
        along, matrix = one_freedom(0.5)
        result = law(matrix, 2.0 * along + np.array([0.0, 1e-9]), lengthen(0.7), 0.5)
        assert OUTCOMES[int(np.asarray(result.outcome).item())] == "stiction"
        expected = 2.0 / (math.sin(0.5) + 0.7 * math.cos(0.5))
        assert np.asarray(result.impulse_normal).item() == pytest.approx(expected, rel=1e-8)

    def test_one_freedom_well_off_its_line_can_still_part(self) -> None:
        """Where v_n = w > 0 is left and stick adds nothing, the work rule asks for p = e*^2 (-W_c)/w more (Stronge).

        v_n at the stop is the slip offered, 1e-3 2, times tan 0.5, since v_t/v_n moves along one line.
        """
        along, matrix = one_freedom(0.5)
        result = energetic_impact(matrix, 2.0 * along + np.array([0.0, 2e-3]), 0.7, 0.5)
        assert result.velocity_normal == pytest.approx(2e-3 * math.tan(0.5), rel=1e-9)
        assert result.outcome_name == "rebound"
        needed = -0.25 * result.compressive_work_normal - result.phase_work_normal[2]
        assert result.phase_impulse[3] == pytest.approx(needed / result.velocity_normal, rel=1e-9)

    def test_poissons_impulse_spent_in_slip_at_rest_parts_nothing(self) -> None:
        """One degree of freedom that slips on at rest (mu 0, then 5): v_n stays 0, which is no rebound."""
        along, matrix = one_freedom(0.5)
        result = poisson_impact(matrix, 2.0 * along + np.array([0.0, -5.0]), 0.0, 0.5, 5.0)
        assert result.velocity_normal == 0.0
        assert result.outcome_name == "stiction"

    @pytest.mark.parametrize("law", LAWS)
    def test_phases_that_do_not_occur_have_no_slip(self, law: Callable) -> None:
        """A point that departs has none of the four; without restitution (e = 0) the last two are missing."""
        departing = law(np.eye(2), [1.0, 1.0], 0.3, 0.5)
        assert departing.outcome_name == "no contact"
        assert not departing.phase_slip.any()
        assert not law(np.eye(2), [-1.0, 9.0], 0.3, 0.0).phase_slip[2:].any()

    @pytest.mark.parametrize("law", LAWS)
    @pytest.mark.parametrize("lengthen", [float, lambda value: np.array([value, 0.5 * value])])
    def test_a_point_that_nothing_moves_along_the_normal_jams(self, law: Callable, lengthen: Callable) -> None:
        """K_nn = 0 is positive semidefinite: no impulse stops the approach."""
        outcome = law(np.diag([0.0, 1.0]), [-1.0, 0.5], lengthen(0.3), 0.5).outcome
        assert np.all(np.asarray(outcome) == OUTCOMES.index("jam"))

    @pytest.mark.parametrize("law", LAWS)
    @pytest.mark.parametrize("lengthen", [float, lambda value: np.array([value])])
    @pytest.mark.parametrize("coupling", [1e-310, -1e-310])
    def test_a_coupling_too_small_to_be_divided_by_is_none(
        self, law: Callable, lengthen: Callable, coupling: float
    ) -> None:
        """1/1e-310 is no float. Uncoupled, v = (-1, 5), mu = 0.3, e = 0.5: p_f = 1.5, and v_t falls by 0.45."""
        result = law([[1.0, coupling], [coupling, 1.0]], [-1.0, 5.0], lengthen(0.3), 0.5)
        assert np.asarray(result.impulse_normal).item() == pytest.approx(1.5, rel=1e-15)
        assert np.asarray(result.velocity_tangential).item() == pytest.approx(4.55, rel=1e-15)


class TestMonofilament:
    def test_friction_of_restitution_is_that_of_compression_by_default(self) -> None:
        """Case 2 (2.59): p_fy = p_cy (1 + e* sqrt(s_1/s_2)), phi'_f = -(r_h/L) w - e* (v_C/L) sqrt(s_2/s_1), by hand."""
        gamma, mu, e = 0.6, 0.3, 0.5
        first, second = math.sin(gamma) + mu * math.cos(gamma), math.sin(gamma) - mu * math.cos(gamma)
        impulse = monofilament.normal_final_impulse(3.0, 2.0, gamma, mu, e)
        assert impulse == pytest.approx(2.0 / first * (1.0 + e * math.sqrt(first / second)), rel=1e-14)
        rate = monofilament.final_rate(2.0, 0.5, 0.25, 4.0, gamma, mu, e)
        assert rate == pytest.approx(-2.0 - e * 4.0 * math.sqrt(second / first), rel=1e-14)

    def test_a_tip_at_rest_does_not_touch(self) -> None:
        """R = -r_h/L: v_C = (R L + r_h) w = 0, which is no approach."""
        result = monofilament.monofilament_impact(1.0, 0.5, 0.25, 4.0, -0.5, 0.6, 0.3, 0.5)
        assert result.outcome_name == "no contact"
        assert result.final_bristle_rate == result.initial_bristle_rate == -2.0

    @pytest.mark.parametrize("value", [-0.25, [0.5, -0.25]])
    def test_refusal_shows_the_first_bad_value(self, value: object) -> None:
        with pytest.raises(ValueError, match=r"^friction = -0.25: .*0 <= friction <= 1e\+09.*\(dimensionless\)$"):
            monofilament.normal_compressive_impulse(1.0, 1.0, 0.5, value)

    def test_no_number_is_out_of_range(self) -> None:
        with pytest.raises(ValueError, match=r"^mass = "):
            monofilament.normal_compressive_impulse(None, 1.0, 0.5, 0.3)


class TestPendulums:
    def test_an_elastic_rod_without_friction_is_thrown_back(self) -> None:
        """e* = 1, mu = 0: the rate is reversed, and the impulse twice that of compression, m L w/(3 sin gamma)."""
        result = single_pendulum_impact(3.0, 0.5, 0.6, -2.0, 0.0, 1.0)
        assert (result.outcome, result.rebound_ratio, result.final_rate) == ("rebound", -1.0, 2.0)
        assert result.normal_compressive_impulse == pytest.approx(1.0 / math.sin(0.6), rel=1e-14)
        assert result.normal_final_impulse == pytest.approx(2.0 / math.sin(0.6), rel=1e-14)

    @pytest.mark.parametrize(
        ("friction", "restitution", "outcome"),
        [(0.1, 0.0, "no rebound"), (9.0, 0.0, "no rebound"), (9.0, 0.5, "stiction")],
    )
    def test_why_a_rod_stays(self, friction: float, restitution: float, outcome: str) -> None:
        """Without restitution nothing drives the rod back; with it, friction above tan gamma holds it."""
        result = single_pendulum_impact(3.0, 0.5, 0.6, -2.0, friction, restitution)
        assert (result.outcome, result.final_rate, result.rebound_ratio) == (outcome, 0.0, 0.0)

    def test_friction_of_tan_gamma_itself_holds_the_rod(self) -> None:
        """No rebound for mu >= tan gamma: cos gamma = 0.8 and sin gamma = 0.6 = 0.75 cos gamma, where floats agree."""
        exact = [gamma for gamma in np.linspace(0.2, 1.2, 41).tolist() if holds_exactly(gamma)]
        assert exact, "some angle whose sine is the float product of tangent and cosine"
        for gamma in exact:
            result = single_pendulum_impact(1.0, 1.0, gamma, -1.0, math.sin(gamma) / math.cos(gamma), 0.5)
            assert result.outcome == "stiction"

    def test_a_rod_that_swings_away_keeps_its_rate(self) -> None:
        result = single_pendulum_impact(3.0, 0.5, 0.6, 2.0, 0.3, 0.5)
        assert (result.outcome, result.final_rate, result.rebound_ratio) == ("no contact", 2.0, 1.0)

    @pytest.mark.parametrize("apart", [0.0, 1e-10, -1e-10, 5e-9])
    def test_rods_parallel_up_to_rounding_are_held_by_friction(self, apart: float) -> None:
        """Their tip moves along one line, so above tan theta no impulse parts it: energy lost is all but a drift."""
        result = double_pendulum_impact(1.0, 2.0, 1.0, 0.4, 0.4 + apart, -1.0, -2.0, 1.5 * math.tan(0.4), 0.5)
        assert result.outcome == "stiction"
        # All the tip's approach is stopped by m_eff v/(sin + mu cos); restitution adds nothing to that.
        assert result.normal_final_impulse == pytest.approx(result.normal_compressive_impulse, rel=1e-6)

    def test_friction_of_the_threshold_itself_sticks(self) -> None:
        """Zhang 2020, eq. 2.90: mu >= mu_bar sticks."""
        threshold = float(stick_friction(1.0, 0.35, 0.52))
        result = double_pendulum_impact(5.0, 1.0, 1.0, 0.35, 0.52, -0.1, -0.2, threshold, 0.5)
        assert result.phases[-1] == "restitution stick"

    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_slip_of_a_billionth_is_slip(self, side: float) -> None:
        """Two rods at 0.35 and 0.52 whose tip slips by 1e-9 of their speed: p_s = |v_t|/|v_t'|, v_t' by the mass matrix."""
        angles, friction = side * np.array([0.35, 0.52]), 0.1
        rates = side * np.array([1.0, -(math.cos(0.35) + 1e-9) / math.cos(0.52)])
        result = double_pendulum_impact(1.0, 1.0, 1.0, *angles.tolist(), *rates.tolist(), friction, 0.5)
        along, away, c = -np.cos(angles), np.sin(angles), 0.5 * math.cos(0.17)
        change = along @ np.linalg.inv([[4.0 / 3.0, c], [c, 1.0 / 3.0]]) @ (away - side * friction * along)
        assert float(along @ rates) * change < 0.0, "the slip does stop"
        assert result.phases[0] == "compression slip"
        # A difference of numbers of order 1 is 1e-9: seven digits are left.
        assert result.slip_stop_impulse == pytest.approx(1e-9 / abs(change), rel=1e-6, abs=0.0)

    def test_no_slip_has_stopped_at_once(self) -> None:
        """Rods at 0.5 and -0.5 with opposite rates come straight down: p_s = 0."""
        result = double_pendulum_impact(1.0, 1.0, 1.0, 0.5, -0.5, -1.0, 1.0, 0.9, 0.5)
        assert result.slip_stop_impulse == 0.0
        assert result.phases == ("compression stick", "restitution stick")


def holds_exactly(gamma: float) -> bool:
    """Whether tan gamma cos gamma is sin gamma in floats too."""
    return math.sin(gamma) - math.sin(gamma) / math.cos(gamma) * math.cos(gamma) == 0.0


class TestCueing:
    def test_a_bar_at_the_ends_of_the_tips_reach(self) -> None:
        """Hub 3, bristle 4: a tip 7 from the centre is not retracted at all, one 1 from it half a turn."""
        assert cueing.retraction_at_bar(7.0, 0.0, 0.0, 3.0, 4.0) == 0.0
        assert cueing.retraction_at_bar(0.0, 1.0, 0.0, 3.0, 4.0) == math.pi

    def test_folded_bristles_of_any_size(self) -> None:
        """The tip at |r_h - L| is half a turn back, although rounding may ask for the arcsine of more than 1.

        An error of some ulps in sin^2 is one of its root in the angle.
        """
        hubs, lengths = np.random.default_rng(5).uniform(0.01, 1.0, (2, 200))
        found = cueing.retraction_at_bar(np.abs(hubs - lengths), 0.0, 0.0, hubs, lengths)
        np.testing.assert_allclose(found, math.pi, rtol=0.0, atol=1e-6)

    def test_half_a_turn_has_no_cue_time(self) -> None:
        """A pendulum at its top stays there: |theta_p| < pi."""
        with pytest.raises(ValueError, match=r"^retraction = 3\.14159: less than pi"):
            cueing.stiffened_cue_time(math.pi, 0.0, 1.0, 1.0)


def test_numbers_that_no_machine_word_holds_are_numbers() -> None:
    """10^30 is a Python integer of 100 bits; no value at all (None) is refused like nan."""
    for check in (checks.finite, checks.positive, checks.not_negative):
        check("mass", 10**30, "kg")
        with pytest.raises(ValueError, match=r"^mass = "):
            check("mass", None, "kg")
    with pytest.raises(ValueError, match=r"^n = 1e\+30: "):
        checks.whole("n", 10**30, 7)
    checks.whole("n", 7, 7)


@pytest.mark.parametrize("value", [0, 8, 1.5, True])
def test_whole_numbers_in_a_range(value: object) -> None:
    """True is no number here, although Python counts it as 1."""
    with pytest.raises(ValueError, match=r"^n = .*1 <= n <= 7"):
        checks.whole("n", value, 7)
