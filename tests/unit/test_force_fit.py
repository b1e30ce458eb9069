"""The least-squares fit of chapter 3 on points whose curve is known, and the reader of measured points."""

import math

import numpy as np
import pytest

from bristle_sim.theory.force_fit import fit_force_history, read_force_csv
from bristle_sim.theory.force_history import BALL, BRISTLE, ForceCurve

BALL_PEAK, BALL_DURATION = 335.0, 5e-3
TRUE_BALL = ForceCurve.of_impact(1.3935, 101.6189, BALL_PEAK, BALL_DURATION)


def sampled(curve, points=51, share=1.0):
    time = np.linspace(0.0, share * curve.duration, points)
    return time, curve(time)


def model(time, amplitude, decay, duration):
    """(3.3) with one term, written out: t_o/T = 1/12."""
    angle = 2 * np.pi * time / (1.2 * duration) + np.pi / 6
    return amplitude * np.exp(-decay * time) * BALL_PEAK / 2 * (np.cos(np.pi / 6) - np.cos(angle))


def expected_errors(time, noise, values):
    """Standard errors from the normal equations at the true values, slopes by central differences."""
    columns = []
    for i, value in enumerate(values):
        step = 1e-6 * value
        shifted = [model(time, *(v + sign * step * (i == j) for j, v in enumerate(values))) for sign in (1, -1)]
        columns.append((shifted[0] - shifted[1]) / (2 * step))
    jacobian = np.transpose(columns)
    return noise * np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))


@pytest.mark.parametrize("duration", [None, BALL_DURATION])
@pytest.mark.parametrize("share", [1.0, 0.48])
def test_exact_points_give_the_published_parameters_back(duration, share):
    time, force = sampled(TRUE_BALL, share=share)
    fit = fit_force_history(time, force, duration=duration, peak_force=BALL_PEAK)
    # Points carry rounding of 1e-16; up to the peak alone, t_f, c and lambda are told apart 1e5 times worse.
    np.testing.assert_allclose(fit.values[:2], [1.3935, 101.6189], rtol=1e-8)
    assert fit.curve.duration == pytest.approx(BALL_DURATION, rel=1e-8)
    assert fit.root_mean_square < 1e-9


@pytest.mark.parametrize(("curve", "peak_force"), [(BALL, 335.0), (BRISTLE, 60.0)])
def test_published_curves_are_fitted_within_the_rounding_of_their_offset(curve, peak_force):
    fit = fit_force_history(*sampled(curve), duration=curve.duration, peak_force=peak_force)
    # The printed offsets are whole newtons: 0.059 and 0.019 N from what (3.3) has, times c.
    shift = abs(curve.offset - 0.5 * peak_force * math.cos(math.pi / 6)) * curve.amplitude[0]
    assert 0.0 < fit.root_mean_square < shift
    # A constant shift moves c by about shift/mean force.
    assert fit.values[0] == pytest.approx(curve.amplitude[0], rel=2 * shift / np.mean(curve(sampled(curve)[0])))


@pytest.mark.parametrize("seed", range(5))
def test_noisy_points_give_the_parameters_within_their_uncertainty(seed):
    noise = 5.0
    time, force = sampled(TRUE_BALL)
    measured = force + noise * np.random.default_rng(seed).standard_normal(force.size)
    fit = fit_force_history(time, measured, peak_force=BALL_PEAK, noise=noise)
    true = [1.3935, 101.6189, BALL_DURATION]
    errors = expected_errors(time, noise, true)
    # Four standard errors: chance 6e-5 for each of the 15 draws.
    assert np.all(np.abs(fit.values - true) < 4.0 * errors)
    # The errors reported are those at the fitted values, which differ from the true ones by a few errors: second order.
    np.testing.assert_allclose(fit.standard_errors, errors, rtol=0.1)
    # Residual variance: chi-squared with 48 degrees of freedom, relative spread sqrt(2/48); four of them.
    assert fit_force_history(time, measured, peak_force=BALL_PEAK).noise ** 2 == pytest.approx(
        noise**2, rel=4 * math.sqrt(2 / 48)
    )


def test_reported_uncertainty_covers_the_truth_as_often_as_it_says():
    noise, draws = 5.0, 60
    time, force = sampled(TRUE_BALL)
    rng = np.random.default_rng(7)
    fits = [
        fit_force_history(time, force + noise * rng.standard_normal(force.size), peak_force=BALL_PEAK)
        for _ in range(draws)
    ]
    covered = np.mean([np.abs(f.values[0] - 1.3935) < f.standard_errors[0] for f in fits])
    # 68 %, binomial spread sqrt(0.68 0.32/60) = 0.06; three of them.
    assert abs(covered - 0.68) < 0.18


def test_two_terms_are_told_apart_when_the_points_hold_two():
    curve = ForceCurve.of_impact((1.0, 0.8), (50.0, 900.0), BALL_PEAK, BALL_DURATION)
    fit = fit_force_history(*sampled(curve), terms=2, peak_force=BALL_PEAK)
    order = np.argsort(fit.values[2:4])
    # Rounding of 1e-16 times the condition number of two exponentials, about 1e5.
    np.testing.assert_allclose(fit.values[2:4][order], [50.0, 900.0], rtol=1e-7)
    np.testing.assert_allclose(fit.values[:2][order], [1.0, 0.8], rtol=1e-7)
    assert fit.names == ("amplitude 1", "amplitude 2", "decay 1", "decay 2", "duration")


def test_a_second_term_does_not_improve_a_fit_to_one():
    time, force = sampled(TRUE_BALL)
    settings = {"duration": BALL_DURATION, "peak_force": BALL_PEAK}
    gains = []
    for seed in range(8):
        measured = force + 5.0 * np.random.default_rng(seed).standard_normal(force.size)
        one = fit_force_history(time, measured, **settings)
        try:
            two = fit_force_history(time, measured, terms=2, **settings)
        except ValueError as refusal:
            assert str(refusal).startswith("terms = 2: the points do not tell")  # noqa: PT017
        else:
            gains.append(1.0 - np.sum(two.residuals**2) / np.sum(one.residuals**2))
    # Two more unknowns take up about 2 of 49 degrees of freedom; 14 is beyond chance (1e-3 for chi-squared of 2).
    assert len(gains) >= 2
    assert max(gains) < 14 / 49


def test_more_terms_than_the_points_hold_are_refused():
    with pytest.raises(ValueError, match="terms = 2: the points do not tell"):
        fit_force_history(*sampled(TRUE_BALL), terms=2, duration=BALL_DURATION, peak_force=BALL_PEAK)


def test_the_peak_force_only_scales_the_amplitude():
    time, force = sampled(TRUE_BALL)
    fits = [fit_force_history(time, force, peak_force=each) for each in (335.0, 670.0, None)]
    # One minimum reached from three scalings: 1e-10 of the curve's 340 N.
    for fit in fits[1:]:
        np.testing.assert_allclose(fit.curve(time), fits[0].curve(time), atol=4e-8)
    assert fits[1].values[0] == pytest.approx(fits[0].values[0] / 2, rel=1e-9)


@pytest.mark.parametrize(
    ("time", "force", "settings", "message"),
    [
        ([0, 1, 2], [0, 1], {}, "shapes"),
        ([0, 1, 2, 3], [0, 1, math.nan, 0], {}, "finite"),
        ([0, 1, 1, 3], [0, 1, 2, 0], {}, "increasing"),
        ([-1, 1, 2, 3], [0, 1, 2, 0], {}, "increasing values from 0"),
        ([0, 1, 2, 3], [0, -1, -2, 0], {}, "above 0"),
        ([0, 1, 2], [0, 1, 0], {}, "3 points"),
        ([0, 1, 2, 3, 4], [0, 1, 2, 1, 0], {"duration": 3.0}, "duration = 3"),
        ([0, 1, 2, 3, 4], [0, 1, 2, 1, 0], {"terms": 0}, "terms = 0"),
        ([0, 1, 2, 3, 4], [0, 1, 2, 1, 0], {"noise": 0.0}, "noise = 0"),
        ([0, 1, 2, 3, 4], [0, 1, 2, 1, 0], {"peak_force": math.nan}, "peak_force = nan"),
    ],
)
def test_what_is_no_force_history_is_refused(time, force, settings, message):
    with pytest.raises(ValueError, match=message):
        fit_force_history(time, force, **settings)


@pytest.mark.parametrize("separator", [",", ";", "\t", " ; "])
@pytest.mark.parametrize("header", ["", "time,force\n", "# Yu et al.\n\nt (s);F (N)\n", "\ufefftime\tforce\n"])
def test_files_are_read_with_any_separator_and_header(tmp_path, separator, header):
    path = tmp_path / "points.csv"
    rows = "\n".join(f"{t}{separator}{f}" for t, f in ((0, 0.5), (1e-3, 2), (2e-3, 3.25), (4e-3, -1)))
    path.write_text(header + rows + "\n\n", encoding="utf-8")
    time, force = read_force_csv(path)
    assert time.tolist() == [0.0, 1e-3, 2e-3, 4e-3]
    assert force.tolist() == [0.5, 2.0, 3.25, -1.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "0 points; at least 4"),
        ("time,force\n", "0 points; at least 4"),
        ("0,1\n1,2\n2,3\n", "3 points; at least 4"),
        ("time,force\n0,1\nx,2\n", "line 3: 'x'"),
        ("time,force\nseconds,newtons\n0,1\n", "line 2: 'seconds'"),
        ("0,1\n1,nan\n", "line 2: 'nan'"),
        ("0,1\n1,inf\n", "line 2: 'inf'"),
        ("0,1\n1,\n", "line 2: ''"),
        ("0,1\n1,2,3\n", "line 2: 3 columns"),
        ("0 1\n", "line 1: 1 columns"),
        ("0,1\n2,2\n\n2,3\n", "line 4: time = 2: more than the time before"),
        ("0,1\n2,2\n1,3\n", "line 3: time = 1"),
        ("-1,1\n", "line 1: time = -1"),
    ],
)
def test_other_files_are_refused_in_one_line(tmp_path, text, message):
    path = tmp_path / "points.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message) as refusal:
        read_force_csv(path)
    assert "\n" not in str(refusal.value)
    assert "points.csv" in str(refusal.value)


def test_missing_and_binary_files_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"none\.csv: a readable file"):
        read_force_csv(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="a readable file"):
        read_force_csv(tmp_path)
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(ValueError, match="text in UTF-8"):
        read_force_csv(binary)
