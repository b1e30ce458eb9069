"""Roughness measures against closed forms, a convolution written out, and the package surfalize."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.special import erf

from bristle_sim.theory.roughness import (
    arithmetic_mean_height,
    developed_area_ratio,
    profile_measures,
    roughness_profiles,
)

CELL = 1e-5
CUTOFF = 8e-4


def measures(profile, sections=5):
    """Return the measures of a profile that is as long as its section lengths."""
    return profile_measures(profile, CELL, profile.shape[-1] * CELL / sections, sections)


def random_profiles(number, points, seed=1):
    """Profiles of some correlation, 10 um high."""
    white = np.random.default_rng(seed).standard_normal((number, points))
    return 1e-5 * np.apply_along_axis(np.convolve, -1, white, np.ones(7) / 7.0, "same")


@pytest.mark.parametrize("period", [100, 40, 400])
def test_a_sine_has_the_filter_s_height_and_its_own_spacing(period):
    place = np.arange(2000)
    wave = 1e-5 * np.sin(2.0 * np.pi * (place + 0.5) / period)
    # The sampled extremes lie half a point from the true ones at most: 1 - cos(pi/period).
    off = 1.1 * (1.0 - math.cos(math.pi / period))
    kept = 1.0 - math.exp(-math.log(2.0) * (CUTOFF / (period * CELL)) ** 2)
    rough = roughness_profiles(wave, CELL, CUTOFF)
    found = profile_measures(rough, CELL, CUTOFF, 5)
    if period <= 80:  # every section has a whole wave
        assert found.rz == pytest.approx(2e-5 * kept, rel=off)
    assert found.ra == pytest.approx(1e-5 * kept * 2.0 / math.pi, rel=off)
    assert found.rq == pytest.approx(1e-5 * kept / math.sqrt(2.0), rel=1e-12)
    if period == 400:  # one wave is as long as the evaluation length
        assert found.rsm is None
        return
    # A chord in place of the sine crosses zero where the sine does, as the points lie evenly about it.
    assert found.rsm == pytest.approx(period * CELL, rel=1e-9)


def test_small_waves_on_large_ones_are_no_elements():
    place = np.arange(2000)
    wave = np.sin(2.0 * np.pi * (place + 0.5) / 100.0)
    rippled = wave + 0.05 * np.sin(2.0 * np.pi * place / 7.0)
    ripples = profile_measures(rippled, CELL, 4e-3, 5)
    assert ripples.rsm == pytest.approx(1e-3, rel=0.01)  # a ripple moves an end by 1 in 19 waves
    assert profile_measures(np.zeros(100), CELL, 2e-4, 5).rsm is None


def test_a_periodic_step_is_filtered_to_an_error_function():
    """The mean line of a step is h (1 + erf(sqrt(pi) x/(alpha cutoff)))/2; steps 10 mm apart do not reach each other."""
    points = 2000
    place = (np.arange(points) + 0.5) * CELL
    step = np.where(place < 0.5 * points * CELL, 0.0, 4e-5)
    alpha = math.sqrt(math.log(2.0) / math.pi)
    rough = roughness_profiles(step, CELL, CUTOFF)
    near = slice(600, 1400)
    mean_line = 2e-5 * (1.0 + erf(math.sqrt(math.pi) * (place - 1e-2) / (alpha * CUTOFF)))
    # The sampled step is one of straight lines within a cell; its error is (cell/cutoff)^2.
    np.testing.assert_allclose(
        rough[near], (step - mean_line)[near], atol=4e-5 * (CELL / CUTOFF) ** 2
    )
    halves = measures(step[500:1500], sections=1)
    assert (halves.rz, halves.ra, halves.rq) == pytest.approx((4e-5, 2e-5, 2e-5), rel=1e-12)


def test_the_filter_is_a_gaussian_convolution():
    """ISO 16610-21 written out: weights exp(-pi (x/(alpha cutoff))^2)/(alpha cutoff) about every point of the periodic profile."""
    profile = random_profiles(1, 1000)[0]
    reach = math.sqrt(math.log(2.0) / math.pi) * CUTOFF
    offsets = np.arange(-1000, 1001)
    weights = np.exp(-math.pi * (offsets * CELL / reach) ** 2)
    weights /= weights.sum()
    mean_line = [float(weights @ profile[(i + offsets) % 1000]) for i in range(1000)]
    rough = roughness_profiles(profile, CELL, CUTOFF)
    np.testing.assert_allclose(rough, profile - mean_line, atol=1e-12 * np.abs(profile).max())


def test_a_lattice_of_paraboloids_has_the_integrals_of_one():
    """z = h (u^2 + v^2), u and v from -1 to 1 in every crater."""
    height, half, count = 1e-4, 2e-4, 5
    points = 400
    u = ((np.arange(points * count) + 0.5) % points) / (points / 2.0) - 1.0
    cell = 2.0 * half / points
    profile = height * u**2
    found = profile_measures(profile, cell, 2.0 * half, count)
    # Midpoint sums: 1/points of the height at the ends, and its square in the integrals.
    assert found.rz == pytest.approx(height, rel=2.5 / points)
    assert found.ra == pytest.approx(height * 4.0 / (9.0 * math.sqrt(3.0)), rel=1e-4)
    assert found.rq == pytest.approx(height * math.sqrt(1.0 / 5.0 - 1.0 / 9.0), rel=1e-4)
    assert found.rsm == pytest.approx(2.0 * half, rel=1e-9)
    surface = height * np.add.outer(u[: 2 * points] ** 2, u[: 2 * points] ** 2)
    mean = dblquad(lambda v, w: abs(v * v + w * w - 2.0 / 3.0), 0.0, 1.0, 0.0, 1.0)[0]
    assert arithmetic_mean_height(surface) == pytest.approx(height * mean, rel=1e-4)
    slope = 2.0 * height / half
    area = dblquad(lambda v, w: math.sqrt(1.0 + slope**2 * (v * v + w * w)), 0.0, 1.0, 0.0, 1.0)[0]
    # Cells across a rim are half flat: two in every 400 along either axis.
    assert developed_area_ratio(surface, cell, cell) == pytest.approx(area - 1.0, rel=4.0 / points)


def test_planes_and_steps_of_a_surface():
    rows, columns = np.indices((50, 80))
    plane = CELL * (0.3 * rows - 0.4 * columns)
    assert developed_area_ratio(plane, CELL, CELL) == pytest.approx(
        math.sqrt(1.25) - 1.0, rel=1e-12
    )
    slope = CELL * 0.4 * columns
    assert arithmetic_mean_height(slope) == pytest.approx(0.4 * CELL * 80 / 4.0, rel=1e-12)
    step = np.where(columns < 40, 0.0, 2e-5)
    assert arithmetic_mean_height(step) == pytest.approx(1e-5, rel=1e-12)
    # Of 79 columns of cells one rises by two cells: sqrt(1 + 2^2) in place of 1.
    assert developed_area_ratio(step, CELL, CELL) == pytest.approx(
        (math.sqrt(5.0) - 1.0) / 79.0, rel=1e-12
    )


def test_profiles_as_surfalize_measures_them():
    surfalize = pytest.importorskip("surfalize")
    profiles = random_profiles(20, 1000)
    filtering = surfalize.filter.GaussianFilter(1e6 * CUTOFF, "highpass", endeffect_mode="wrap")
    for profile in profiles:
        referee = surfalize.Profile(1e6 * profile, 1e6 * CELL)
        rough = filtering(referee)
        found = profile_measures(roughness_profiles(profile, CELL, CUTOFF), CELL, 2e-3, 5)
        for name in ("rz", "ra", "rq"):
            for own, theirs in ((measures(profile), referee), (found, rough)):
                other = 1e-6 * getattr(theirs, name.capitalize())()
                # surfalize cuts the Gaussian off at four standard deviations, where 6e-5 of it are left.
                assert getattr(own, name) == pytest.approx(other, rel=1e-3)


def test_surfaces_as_surfalize_measures_them():
    surfalize = pytest.importorskip("surfalize")
    for seed in range(5):
        heights = random_profiles(120, 200, seed)
        referee = surfalize.Surface(1e6 * heights, 1e6 * CELL, 1e6 * CELL)
        # The same sums; surfalize gives Sdr in per cent.
        assert arithmetic_mean_height(heights) == pytest.approx(1e-6 * referee.Sa(), rel=1e-9)
        assert developed_area_ratio(heights, CELL, CELL) == pytest.approx(
            0.01 * referee.Sdr(), rel=1e-9
        )
