"""Numerical settings: defaults, ranges and whole numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.settings import MAXIMUM_STEPS, Settings


def test_defaults():
    settings = Settings()
    assert settings.accuracy == 1e-6
    assert settings.step is None
    assert settings.hub_turn == 1.5 * math.pi
    assert settings.maximum_steps == MAXIMUM_STEPS
    assert settings.samples_per_period == 24


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("accuracy", (1e-11, 1e-8, 0.1)),
        ("step", (None, 1e-12, 1e-6, 1.0)),
        ("hub_turn", (1e-3, 1e6)),
        ("maximum_steps", (1, 10**9)),
        ("samples_per_period", (1, 100)),
    ],
)
def test_what_is_allowed(name: str, values: tuple[float | None, ...]):
    for value in values:
        assert getattr(Settings(**{name: value}), name) == value


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("accuracy", (0.0, 0.99e-11, 0.11, math.nan, None, "1e-6")),
        ("step", (0.0, 9e-13, -1e-6, 1.1, math.inf, "none")),
        ("hub_turn", (0.0, -1.0, 1.1e6, math.nan, None)),
        ("maximum_steps", (0, -1, 1.5, 10.0, True, None, "10", np.float64(10.0))),
        ("samples_per_period", (0, -3, 2.5, True, None)),
    ],
)
def test_what_is_refused(name: str, values: tuple[object, ...]):
    for value in values:
        with pytest.raises(ValueError, match=rf"^{name} = .*(must be|is allowed)"):
            Settings(**{name: value})
