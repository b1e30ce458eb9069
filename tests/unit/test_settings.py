"""Numerical settings: defaults, ranges and whole numbers."""

from __future__ import annotations

import math

import pytest

from bristle_sim.settings import Settings


@pytest.mark.parametrize(
    ("accuracy", "samples"), [(0.1, 8), (1e-3, 8), (1e-4, 15), (1e-6, 24), (1e-11, 24)]
)
def test_as_many_samples_as_a_cubic_needs_for_the_accuracy(accuracy: float, samples: int):
    # Between samples of sin(t) that are h apart a cubic is h^4/384 off.
    assert Settings(accuracy).samples == samples
    assert (
        samples in (8, 24)
        or (math.tau / samples) ** 4 / 384.0 <= accuracy < (math.tau / (samples - 1)) ** 4 / 384.0
    )
    assert Settings(accuracy, samples_per_period=50).samples == 50
