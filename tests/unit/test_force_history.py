"""The force curves of chapter 3: against quadrature, closed forms worked out by hand, and print."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from bristle_sim.theory.force_history import BALL, BRISTLE, ForceCurve, segment_impulses

STEADY = ForceCurve(2.0, 0.0, offset=26.0, swing=30.0, lead=1e-5, period=1.2e-4)
CURVES = pytest.mark.parametrize(
    "curve", [BALL, BRISTLE, STEADY], ids=["ball", "bristle", "steady"]
)

TABLE_3_1 = [0.13, 0.43, 0.79, 1.18, 1.56, 1.93, 2.24, 2.49, 2.67, 2.76]
"""Zhang 2020, table 3.1, in 1e-4 N s."""


def printed_ball(t):
    """Zhang 2020, eq. 3.5, letter by letter."""
    return 1.3935 * np.exp(-101.6189 * t) * (145 - 167.5 * np.cos(2 * np.pi * (t + 0.0005) / 0.006))


def printed_bristle(t):
    """Zhang 2020, eq. 3.19, letter by letter."""
    return 1.0160 * np.exp(-5.4990 * t) * (26 - 30 * np.cos(2 * np.pi * (t + 0.00001) / 0.00012))


@pytest.mark.parametrize(
    ("curve", "formula", "end"), [(BALL, printed_ball, 5e-3), (BRISTLE, printed_bristle, 1e-4)]
)
def test_printed_curves(curve, formula, end):
    t = np.linspace(0.0, end, 101).reshape(1, 101)
    # Two ways of writing one formula: rounding of terms up to 450 N, 1e-13 relative.
    np.testing.assert_allclose(curve(t), formula(t), rtol=0.0, atol=1e-10)
    assert curve.duration == pytest.approx(end, rel=1e-14)
    assert isinstance(curve(0.0), float)


@CURVES
def test_impulse_is_the_integral_of_the_force(curve):
    ends = curve.duration * np.array([0.1, 0.466, 1.0])
    start = 0.05 * curve.duration
    expected = [
        quad(lambda t: float(curve(t)), start, end, epsrel=1e-12, epsabs=0.0)[0] for end in ends
    ]
    # quad is requested to reach 1e-12 of the value.
    np.testing.assert_allclose(curve.impulse(ends, start), expected, rtol=1e-11)
    assert curve.impulse(start, start) == 0.0


@CURVES
def test_rate_is_the_slope_of_the_force(curve):
    t = np.linspace(0.1, 0.9, 9) * curve.duration
    step = 1e-5 * curve.duration
    slope = (curve(t + step) - curve(t - step)) / (2.0 * step)
    scale = np.abs(curve.rate(t)).max()
    # Central differences: (w step)^2/6 = 5e-10 of the third derivative, and rounding 1e-16/1e-5 of the force.
    np.testing.assert_allclose(slope, curve.rate(t), rtol=0.0, atol=1e-8 * scale)


@pytest.mark.parametrize("curve", [BALL, BRISTLE, STEADY])
def test_peak_and_inflection_in_closed_form(curve):
    decay = curve.decay
    w = 2.0 * math.pi / curve.period
    # F' = 0: sin(theta + phi) = decay offset/(swing hypot(w, decay)), tan(phi) = decay/w; the peak is its second root.
    ratio = decay * curve.offset / (curve.swing * math.hypot(w, decay))
    peak = (math.pi - math.asin(ratio) - math.atan2(decay, w)) / w - curve.lead
    assert curve.peak_time() == pytest.approx(peak, rel=1e-13)
    # F'' = 0: cos(theta + psi) = -decay^2 offset/(swing (w^2 + decay^2)), tan(psi) = 2 decay w/(w^2 - decay^2).
    cosine = -(decay**2) * curve.offset / (curve.swing * (w**2 + decay**2))
    inflection = (math.acos(cosine) - math.atan2(2.0 * decay * w, w**2 - decay**2)) / w - curve.lead
    # A root of a derivative that vanishes to rounding only: 1e-16 of the terms over their slope.
    assert curve.inflection_time() == pytest.approx(inflection, rel=1e-12)


def test_printed_peaks_and_impulses():
    # Half a unit of the last printed digit (3.6, 3.17, 3.20, 3.21); 3.7 prints 0.4269 where 3.17 divides by 0.4629.
    assert abs(BALL.peak_time() - 2.328e-3) < 5e-7
    assert abs(BALL.impulse(2.328e-3) - 0.4629) < 5e-5
    assert abs(BALL.impulse(2.328e-3) - 0.4269) > 0.03
    assert abs(BRISTLE.peak_time() - 5e-5) < 5e-8
    assert abs(BRISTLE.peak_force() - 57.0) < 0.5
    assert BALL.peak_force() == pytest.approx(340.7, abs=0.05)


def test_impact_curve_vanishes_at_both_ends_and_is_equation_3_3():
    peak_force = 335.0
    duration = 5e-3
    curve = ForceCurve.of_impact(1.2, 100.0, peak_force, duration)
    t_o = duration / 10
    whole = duration + 2 * duration / 10
    t = np.linspace(0.0, duration, 7)
    bracket = np.cos(2 * np.pi * t_o / whole) - np.cos(2 * np.pi * (t + t_o) / whole)
    expected = 1.2 * np.exp(-100.0 * t) * peak_force / 2 * bracket
    # Rounding of terms of 250 N.
    np.testing.assert_allclose(curve(t), expected, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(curve([0.0, duration]), 0.0, atol=1e-11)


def test_table_3_1():
    # Half a unit of the last printed digit, and 3.1e-4 of the value: p_c is printed as 1.619e-3, half a unit being 5e-7.
    computed = segment_impulses(BALL, 1.619e-3) * 1e4
    assert np.all(np.abs(computed - TABLE_3_1) < 0.005 + 3.1e-4 * computed)
    # Segments of the table differ by 0.1 or more, so neighbours cannot be mistaken.
    assert np.min(np.diff(TABLE_3_1)) > 0.08


@pytest.mark.parametrize("segments", [1, 7, 10, 300])
def test_segments_share_out_the_whole_impulse(segments):
    impulses = np.array([[1.0], [2.5e-3]])
    shares = segment_impulses(BALL, impulses, segments)
    assert shares.shape == (2, 1, segments)
    np.testing.assert_allclose(shares.sum(axis=-1), impulses, rtol=1e-13)
    assert np.all(shares > 0.0)


def test_a_curve_without_a_peak_is_refused():
    with pytest.raises(ValueError, match="rises and falls"):
        ForceCurve(-1.0, 0.0, 0.0, 30.0, 0.0, 1.2e-4).peak_time()


class TestEdges:
    def test_shares_up_to_a_given_time(self) -> None:
        """Without decay I(t) = cos 30 t - (sin(w t + 30) - sin 30)/w in units of F*/2: shares of it by hand."""
        curve = ForceCurve.of_impact(1.0, 0.0, 2.0, 1.0)
        turn = 2.0 * math.pi / 1.2

        def impulse(time: float) -> float:
            return (
                math.cos(math.pi / 6.0) * time
                - (math.sin(turn * time + math.pi / 6.0) - 0.5) / turn
            )

        shares = segment_impulses(curve, 3.0, 2, compression_time=0.3)
        expected = 3.0 * impulse(0.15) / impulse(0.3)
        # Differences of terms ten times their size.
        np.testing.assert_allclose(shares, [expected, 3.0 - expected], rtol=1e-13)


def test_rescaled_curve_has_its_impulse_and_time():
    scaled = BALL.rescaled(1.619e-3, 5e-5)
    assert scaled.peak_time() == pytest.approx(5e-5, rel=1e-12)
    assert scaled.impulse(5e-5) == pytest.approx(1.619e-3, rel=1e-12)
    # The same shares in the same tenths (3.14).
    np.testing.assert_allclose(
        segment_impulses(scaled, 1.0), segment_impulses(BALL, 1.0), rtol=1e-10
    )
