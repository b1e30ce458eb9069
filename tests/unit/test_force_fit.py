"""The least-squares fit of chapter 3 on points and records whose curve is known."""

import math

import numpy as np
import pytest

from bristle_sim.theory.force_fit import fit_decay, fit_force_history
from bristle_sim.theory.force_history import BALL, BRISTLE, ForceCurve

BALL_PEAK = 335.0
BALL_DURATION = 5e-3
TRUE_BALL = ForceCurve.of_impact(1.3935, 101.6189, BALL_PEAK, BALL_DURATION)


def sampled(curve, points=51, share=1.0):
    time = np.linspace(0.0, share * curve.duration, points)
    return time, curve(time)


def model(time, amplitude, decay, duration, start):
    """(3.3) with one term, written out: t_o/T = 1/12; 0 outside the contact."""
    since = np.clip(time - start, 0.0, duration)
    angle = 2 * np.pi * since / (1.2 * duration) + np.pi / 6
    return amplitude * np.exp(-decay * since) * BALL_PEAK / 2 * (np.cos(np.pi / 6) - np.cos(angle))


def expected_errors(time, noise, values):
    """Standard errors from the normal equations at the true values, slopes by central differences."""
    columns = []
    for i, value in enumerate(values):
        step = 1e-6 * (value or BALL_DURATION)
        shifted = [
            model(time, *(v + sign * step * (i == j) for j, v in enumerate(values)))
            for sign in (1, -1)
        ]
        columns.append((shifted[0] - shifted[1]) / (2 * step))
    jacobian = np.transpose(columns)
    return noise * np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))


@pytest.mark.parametrize("share", [1.0, 0.48])
def test_exact_points_give_the_published_parameters_back(share):
    fit = fit_decay(*sampled(TRUE_BALL, share=share), BALL_DURATION, BALL_PEAK)
    # Points carry rounding of 1e-16.
    np.testing.assert_allclose([fit.amplitude, fit.decay], [1.3935, 101.6189], rtol=1e-8)


@pytest.mark.parametrize("share", [1.0, 0.7])
def test_an_exact_record_gives_the_published_curve_back(share):
    time, force = sampled(TRUE_BALL, share=share)
    fit = fit_force_history(time, force)
    # Up to a little beyond the peak alone, start, t_f, c and lambda are told apart 1e5 times worse than rounding.
    assert fit.curve.duration == pytest.approx(BALL_DURATION, rel=1e-8)
    assert fit.curve.decay == pytest.approx(101.6189, rel=1e-7)
    assert fit.root_mean_square < 1e-8


@pytest.mark.parametrize(("curve", "peak_force"), [(BALL, 335.0), (BRISTLE, 60.0)])
def test_published_curves_are_fitted_within_the_rounding_of_their_offset(curve, peak_force):
    time, force = sampled(curve)
    fit = fit_decay(time, force, curve.duration, peak_force)
    # The printed offsets are whole newtons: 0.059 and 0.019 N from what (3.3) has, times c.
    shift = abs(curve.offset - 0.5 * peak_force * math.cos(math.pi / 6)) * curve.amplitude
    assert 0.0 < np.sqrt(np.mean((fit(time) - force) ** 2)) < shift
    # A constant shift moves c by about shift/mean force.
    assert fit.amplitude == pytest.approx(curve.amplitude, rel=2 * shift / np.mean(force))


@pytest.mark.parametrize("seed", range(5))
def test_noisy_points_give_the_parameters_within_their_uncertainty(seed):
    noise = 5.0
    time, force = sampled(TRUE_BALL)
    measured = force + noise * np.random.default_rng(seed).standard_normal(force.size)
    fit = fit_force_history(time, measured)
    # The amplitude refers to the largest measured force.
    true = [1.3935 * BALL_PEAK / measured.max(), 101.6189, BALL_DURATION, 0.0]
    errors = expected_errors(time, fit.noise, [1.3935, *true[1:]])
    errors[0] *= BALL_PEAK / measured.max()
    # Four standard errors: chance 6e-5 for each of the 20 draws.
    assert np.all(np.abs(fit.values - true) < 4.0 * errors)
    # The errors reported are those at the fitted values, which differ from the true ones by a few errors: second order.
    np.testing.assert_allclose(fit.standard_errors, errors, rtol=0.15)
    # Residual variance: chi-squared with 47 degrees of freedom, relative spread sqrt(2/47); four of them.
    assert fit.noise**2 == pytest.approx(noise**2, rel=4 * math.sqrt(2 / 47))


@pytest.mark.parametrize(
    ("time", "force", "message"),
    [
        ([0, 1, 2], [0, 1], "shapes"),
        ([0, 1, 2, 3], [0, 1, math.nan, 0], "finite"),
        ([0, 1, 1, 3], [0, 1, 2, 0], "increasing"),
        ([0, 1, 2, 3], [0, 1, 1, 0], "more points than the 4 unknowns, not 4"),
        (
            [0, 1e-294, 2e-294, 3e-294, 4e-294],
            [0, 1, 2, 1, 0],
            r"time: spans 4e-294: must be 1e-12 to 1e\+06 \(in s\)",
        ),
    ],
)
def test_what_is_no_force_history_is_refused(time, force, message):
    with pytest.raises(ValueError, match=message):
        fit_force_history(time, force)


def record(
    curve=BRISTLE, step=1e-6, before=0.0, after=0.0, origin=0.0, baseline=0.0, noise=0.0, seed=0
):
    """A contact as an oscilloscope records it: on a clock of its own, with samples before and after, offset and noise."""
    time = np.arange(-round(before / step), round((curve.duration + after) / step) + 1) * step
    force = np.where(
        (time >= 0.0) & (time <= curve.duration), curve(np.clip(time, 0.0, curve.duration)), 0.0
    )
    return time + origin, force + baseline + noise * np.random.default_rng(seed).standard_normal(
        time.size
    )


def found(fit):
    peak = fit.curve.peak_time()
    return peak, float(fit.curve.impulse(peak)), fit.curve.peak_force()


@pytest.mark.parametrize(("before", "after"), [(0.0, 0.0), (1e-4, 0.0), (0.0, 1e-4), (1e-3, 2e-3)])
@pytest.mark.parametrize("origin", [0.0, 1e-4, 0.01, 1.0, -3.0])
def test_a_contact_is_found_on_any_clock(origin, before, after):
    """(3.19) with its printed offset, which is 0.02 N of 57 off what (3.3) has: 3e-4, and as much of the impulse to 50 us."""
    fit = fit_force_history(*record(before=before, after=after, origin=origin))
    peak, impulse, force = found(fit)
    # 0.02 N over the initial slope of 8e5 N/s is 25 ns; a clock at 3 s is read to 4e-16 s.
    assert fit.start == pytest.approx(origin, abs=3e-8)
    assert peak == pytest.approx(5e-5, rel=1e-3)
    assert impulse == pytest.approx(1.61157e-3, rel=1e-3)
    assert force == pytest.approx(56.88, rel=1e-3)


@pytest.mark.parametrize("baseline", [0.0, 25.0, -400.0])
@pytest.mark.parametrize("noise", [0.5, 3.0])
@pytest.mark.parametrize("seed", range(3))
def test_a_contact_is_found_in_noise_and_above_a_baseline(seed, noise, baseline):
    true = {"start": 0.25, "baseline": baseline, "duration": BRISTLE.duration}
    fit = fit_force_history(
        *record(before=2e-3, after=5e-3, origin=0.25, baseline=baseline, noise=noise, seed=seed)
    )
    errors = dict(zip(fit.names, zip(fit.values, fit.standard_errors, strict=True), strict=True))
    for name, value in true.items():
        # Four standard errors and the 25 ns and 0.02 N of the printed offset: chance 6e-5 for each.
        assert abs(errors[name][0] - value) < 4.0 * errors[name][1] + (
            0.02 if name == "baseline" else 3e-8
        )
    # Six unknowns share the noise of about a hundred points; five standard deviations.
    assert found(fit)[2] == pytest.approx(56.88, abs=0.02 + 5.0 * noise * math.sqrt(6 / 100))


@pytest.mark.parametrize("seed", range(1, 4))
@pytest.mark.parametrize("points", [40, 400, 4000])
def test_no_contact_is_found_in_noise(points, seed):
    """One record of noise in a hundred may show one; these nine do not."""
    time = 1e-6 * np.arange(points)
    with pytest.raises(ValueError, match=r"^force: (no contact found|\d+ points)"):
        fit_force_history(time, np.random.default_rng(seed).standard_normal(points))


RAMP = np.arange(12.0)


@pytest.mark.parametrize(
    ("time", "force", "message"),
    [
        (RAMP, 0 * RAMP, "no contact found"),
        (RAMP, 0 * RAMP + 5.3, "no contact found"),
        (RAMP, RAMP, "no contact found|its end must be after the peak"),
        (RAMP, 11 - RAMP, "no contact found|its start must be before that of the contact"),
        (RAMP, np.where(RAMP == 6, 5.0, 0.0), "force: no contact found"),
        (RAMP, np.where(abs(RAMP - 5) < 2, -1.0, -9.0), "force: no contact found"),
        (*record(baseline=6.0), "force: begins at 6.0"),
        (*record(baseline=-6.0), "force: begins at -5.9"),
        (
            *(each[20:] for each in record(after=1e-4)),
            "time: begins at .* its start must be before that of the contact",
        ),
        (1e9 * RAMP**9, 0 * RAMP + [0, 1, 2, 2, 1, 0, 0, 0, 0, 0, 0, 0], "."),
    ],
)
def test_records_without_a_whole_contact_are_refused(time, force, message):
    with pytest.raises(ValueError, match=message) as refusal:
        fit_force_history(time, force)
    assert "SVD" not in str(refusal.value)


@pytest.mark.parametrize("points", [21, 60])
def test_a_force_that_grows(points: int) -> None:
    """A negative decay is a parameter as any other; 1e-8 for points that carry rounding of 1e-16."""
    curve = ForceCurve.of_impact(0.7, -150.0, 100.0, 5e-3)
    time = np.linspace(0.0, 5e-3, points)
    fit = fit_decay(time, curve(time), 5e-3, 100.0)
    np.testing.assert_allclose([fit.amplitude, fit.decay], [0.7, -150.0], rtol=1e-8)
    assert fit_force_history(time, curve(time)).curve.decay == pytest.approx(-150.0, rel=1e-7)
