"""Force histories: what other tests let pass. Expected values from the definition, a symmetry or by hand."""

import math
from functools import partial

import numpy as np
import pytest

from bristle_sim.theory.force_fit import fit_force_history
from bristle_sim.theory.force_history import BRISTLE, ForceCurve, segment_impulses

from_first_touch = partial(fit_force_history, start=0.0)


class TestForceHistory:
    @pytest.mark.parametrize("peak_cell", [1.2, 1.5, 2.2])
    def test_a_peak_next_to_either_end(self, peak_cell: float) -> None:
        """F rises like t e^(-lambda t) from an end, so its peak is near 1/lambda: within the first of 512 cells or so.

        F' = 0 there, lambda (cos 30 - cos(w t + 30)) = w sin(w t + 30), and with -lambda the curve is its mirror image.
        """
        decay, turn = 512.0 / peak_cell, 2.0 * math.pi / 1.2
        early = ForceCurve.of_impact(1.0, decay, 1.0, 1.0).peak_time()
        late = ForceCurve.of_impact(1.0, -decay, 1.0, 1.0).peak_time()
        phase = turn * early + math.pi / 6.0
        assert early == pytest.approx(1.0 / decay, rel=0.05)
        assert decay * (math.cos(math.pi / 6.0) - math.cos(phase)) == pytest.approx(turn * math.sin(phase), rel=1e-10)
        # A cell's position is one of order 1.
        assert late == pytest.approx(1.0 - early, abs=1e-14)

    def test_shares_up_to_a_given_time(self) -> None:
        """Without decay I(t) = cos 30 t - (sin(w t + 30) - sin 30)/w in units of F*/2: shares of it by hand."""
        curve, turn = ForceCurve.of_impact(1.0, 0.0, 2.0, 1.0), 2.0 * math.pi / 1.2

        def impulse(time: float) -> float:
            return math.cos(math.pi / 6.0) * time - (math.sin(turn * time + math.pi / 6.0) - 0.5) / turn

        shares = segment_impulses(curve, 3.0, 2, compression_time=0.3)
        expected = 3.0 * impulse(0.15) / impulse(0.3)
        # Differences of terms ten times their size.
        np.testing.assert_allclose(shares, [expected, 3.0 - expected], rtol=1e-13)

    def test_a_short_contact_is_as_exact_as_a_long_one(self) -> None:
        """Rescaling to a peak at 1e-12 s puts the peak there."""
        # A peak is where the rate vanishes: some ulps of the rate.
        assert BRISTLE.rescaled(1.0, 1e-12).peak_time() == pytest.approx(1e-12, rel=1e-12, abs=0.0)

    def test_results_of_a_time_are_floats(self) -> None:
        assert type(BRISTLE.impulse(1e-5)) is float
        assert type(BRISTLE(1e-5)) is float

    def test_a_lead_of_just_less_than_half_a_period(self) -> None:
        """0 <= t_o < T/2: F(0) = offset - swing cos(2 pi t_o/T) is offset + swing cos(pi/8) at t_o = 7 T/16."""
        curve = ForceCurve((1.0,), (0.0,), 1.0, 2.0, 7.0, 16.0)
        assert curve(0.0) == pytest.approx(1.0 + 2.0 * math.cos(math.pi / 8.0), rel=1e-14)


class TestForceFit:
    """Points on a curve with known parameters give these back; 1e-8 for points that carry rounding of 1e-16."""

    def test_a_force_that_grows(self) -> None:
        """A negative decay is a parameter as any other, also where the duration is given."""
        curve = ForceCurve.of_impact(0.7, -150.0, 100.0, 5e-3)
        time = np.linspace(0.0, 5e-3, 21)
        fit = from_first_touch(time, curve(time), duration=5e-3, peak_force=100.0)
        np.testing.assert_allclose(fit.values, [0.7, -150.0], rtol=1e-8)
        assert fit.curve.decay == tuple(fit.values[1:])

    def test_noise_is_that_of_the_degrees_of_freedom(self) -> None:
        """Residuals of n points and p parameters: s^2 (n - p) is their sum of squares."""
        time = np.linspace(0.0, 1.0, 6)
        force = ForceCurve.of_impact(1.0, 1.0, 10.0, 1.0)(time) + np.array([0.0, 1.0, -1.0, 1.0, -1.0, 0.0])
        fit = from_first_touch(time, force, peak_force=10.0)
        assert fit.noise**2 * 3 == pytest.approx(np.sum(fit.residuals**2), rel=1e-12)

    def test_a_single_point_that_says_much(self) -> None:
        """Four of five points are next to the first touch, where the bracket of (3.3) is below a fifth of the fifth's."""
        curve = ForceCurve.of_impact(1.0, 1.5, 2.0, 1.0)
        time = np.array([0.0, 0.01, 0.02, 0.03, 0.5])
        fit = from_first_touch(time, curve(time), duration=1.0, peak_force=2.0)
        np.testing.assert_allclose(fit.values, [1.0, 1.5], rtol=1e-8)

    def test_four_points_are_enough_for_three_unknowns_and_not_for_four(self) -> None:
        curve = ForceCurve.of_impact(1.0, 1.5, 2.0, 1.0)
        time = np.array([0.1, 0.4, 0.6, 0.9])
        np.testing.assert_allclose(
            from_first_touch(time, curve(time), peak_force=2.0).values, [1.0, 1.5, 1.0], rtol=1e-8
        )
        with pytest.raises(ValueError, match=r"^force: 4 points; there must be more than the 4 unknowns"):
            from_first_touch(time, curve(time), terms=2, duration=1.0)

    def test_an_amplitude_of_any_size(self) -> None:
        """F* only scales the amplitude: with F* = 1e13 times as large it is 1e-13 times as large, and as certain."""
        curve = ForceCurve.of_impact(1.4, 100.0, 300.0, 5e-3)
        time = np.linspace(0.0, 5e-3, 51)
        fits = [from_first_touch(time, curve(time), peak_force=scale, noise=1.0) for scale in (300.0, 3e15)]
        np.testing.assert_allclose(fits[1].values, fits[0].values * [1e-13, 1.0, 1.0], rtol=1e-8)
        np.testing.assert_allclose(fits[1].standard_errors, fits[0].standard_errors * [1e-13, 1.0, 1.0], rtol=1e-6)

    @pytest.mark.parametrize(
        ("time", "settings", "said"),
        [
            ([0.0, math.nan, 0.5, 0.7, 0.9], {}, ("time", "finite", "(in s, N)")),
            ([0.0, 0.2, 0.5, 0.7, 0.9], {"terms": 0}, ("terms = 0", "1 <= terms")),
            ([0.0, 0.4, 0.3, 0.7, 0.9], {}, ("time", "increasing", "(in s)")),
            ([0.0, 0.2, 0.5, 0.7, 0.9], {"duration": 0.8}, ("duration = 0.8", "0.9", "(in s)")),
            ([0.0, 0.2, 0.5, 0.7, 0.9], {"duration": -1.0}, ("duration = -1", "duration > 0", "(in s)")),
            ([0.0, 0.2, 0.5, 0.7, 0.9], {"peak_force": -1.0}, ("peak_force = -1", "peak_force > 0", "(in N)")),
            ([0.0, 0.2, 0.5, 0.7, 0.9], {"noise": -1.0}, ("noise = -1", "noise > 0", "(in N)")),
        ],
    )
    def test_refusals_name_key_value_range_and_unit(self, time: list[float], settings: dict, said: tuple) -> None:
        with pytest.raises(ValueError, match=f"^{said[0]}") as refusal:
            from_first_touch(time, [0.0, 1.0, 2.0, 1.0, 0.5], **settings)
        assert all(word in str(refusal.value) for word in said)


CURVE = ForceCurve.of_impact(1.0, 0.0, 2.0, 1.0)

REFUSALS = {
    "peak_force = -2": (lambda: ForceCurve.of_impact(1.0, 0.0, -2.0, 1.0), "peak_force > 0", "(in N)"),
    "duration = 0": (lambda: ForceCurve.of_impact(1.0, 0.0, 2.0, 0.0), "duration > 0", "(in s)"),
    "impulse = 0": (lambda: CURVE.rescaled(0.0, 1.0), "impulse > 0", "(in N s)"),
    "compression_time = 0": (lambda: CURVE.rescaled(1.0, 0.0), "compression_time > 0", "(in s)"),
    "amplitude = nan": (lambda: ForceCurve((math.nan,), (0.0,), 1.0, 1.0, 0.0, 1.0), "finite", "(dimensionless)"),
    "decay = inf": (lambda: ForceCurve((1.0,), (math.inf,), 1.0, 1.0, 0.0, 1.0), "finite", "(in 1/s)"),
    "offset = inf": (lambda: ForceCurve((1.0,), (0.0,), math.inf, 1.0, 0.0, 1.0), "finite", "(in N)"),
    "lead = nan": (lambda: ForceCurve((1.0,), (0.0,), 1.0, 1.0, math.nan, 1.0), "finite", "(in s)"),
    "swing = 0": (lambda: ForceCurve((1.0,), (0.0,), 1.0, 0.0, 0.0, 1.0), "swing > 0", "(in N)"),
    "period = 0": (lambda: ForceCurve((1.0,), (0.0,), 1.0, 1.0, 0.0, 0.0), "period > 0", "(in s)"),
    "lead = 0.5": (lambda: ForceCurve((1.0,), (0.0,), 1.0, 1.0, 0.5, 1.0), "0 <= lead < period/2 = 0.5 ", "(in s)"),
    "impulse = inf": (lambda: segment_impulses(CURVE, math.inf), "finite", "(in N s)"),
}


@pytest.mark.parametrize("start", REFUSALS)
def test_refusals_name_key_value_range_and_unit(start: str) -> None:
    call, allowed, unit = REFUSALS[start]
    with pytest.raises(ValueError, match=f"^{start}") as refusal:
        call()
    assert allowed in str(refusal.value)
    assert str(refusal.value).endswith(unit)
