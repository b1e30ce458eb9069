"""Numerical settings: defaults, ranges and whole numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.scene.simulate import samples_per_period
from bristle_sim.settings import Settings


@pytest.mark.parametrize(
    ("accuracy", "samples"), [(0.1, 8), (1e-3, 8), (1e-4, 15), (1e-6, 24), (1e-11, 24)]
)
def test_as_many_samples_as_a_cubic_needs_for_the_accuracy(accuracy: float, samples: int):
    # Between samples of sin(t) that are h apart a cubic is h^4/384 off.
    assert samples_per_period(Settings(accuracy)) == samples
    assert (
        samples in (8, 24)
        or (math.tau / samples) ** 4 / 384.0 <= accuracy < (math.tau / (samples - 1)) ** 4 / 384.0
    )
    assert samples_per_period(Settings(accuracy, samples_per_period=50)) == 50


@pytest.mark.parametrize("name", ["maximum_steps", "samples_per_period"])
def test_a_whole_number_of_numpy_is_a_whole_number(name: str):
    assert type(getattr(Settings(**{name: np.int64(50)}), name)) is int
    for value in (0, 50.5, True, "many", 1e16):
        with pytest.raises(ValueError, match=rf"^{name} = [^\n]*: must be a whole number from 1 "):
            Settings(**{name: value})


def test_a_refused_whole_number_is_shown_as_a_whole_number():
    for value in (0, np.int64(0), 0.0):
        with pytest.raises(ValueError, match=r"^maximum_steps = 0: must be a whole number"):
            Settings(maximum_steps=value)
    with pytest.raises(ValueError, match=r"^samples_per_period = 2000000000: must be"):
        Settings(samples_per_period=2_000_000_000)
