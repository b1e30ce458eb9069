"""Families of a double pendulum's impacts are the closed forms, and simulated impacts lie on them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.parameters import Contact, DoublePendulum, Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.settings import Settings
from bristle_sim.studies.double_pendulum_families import (
    HEAVY_ROD,
    HEAVY_ROD_SURFACE,
    closed_form,
    double_pendulum_panels,
    heavy_rod_panel,
)
from bristle_sim.studies.impacts import Impacts, double_pendulum

IDENTICAL_RODS = Chain((5.0, 5.0), (1.0, 1.0), (-math.pi / 9.0, -math.pi / 6.0), (0.1, 0.2))
"""Stronge's double pendulum (Zhang 2020, fig. 2.28 at n = 1)."""

ROUGH = Surface(friction=0.5, restitution=0.5)


def rods(mass_ratio: float = 1.0) -> Impacts:
    found = double_pendulum(DoublePendulum(mass_ratio=mass_ratio), ROUGH, Contact(), Settings()).subject
    assert isinstance(found, Impacts)
    return found


def test_final_rates_over_the_mass_ratio() -> None:
    panel = double_pendulum_panels(rods())["rates over mass ratio"]
    first, second = panel.curves
    assert first.x[-1] == pytest.approx(1e4)
    # Eqs. 2.92-2.108 at n = 1e4, evaluated on their own to eight digits.
    assert first.theory[-1] == pytest.approx(-0.10002302, abs=5e-9)
    assert second.theory[-1] == pytest.approx(0.12120826, abs=5e-9)
    assert [mark.y for mark in panel.marks] == pytest.approx([-0.19893234, 0.22313679], abs=5e-9)
    for rod, curve in enumerate((first, second), start=1):
        for law, tolerance in (("energetic", 1e-11), ("compliant", 1e-5)):  # rounding; ten times the requested accuracy
            x, simulated = curve.points[law]
            assert x.size == {"energetic": 9, "compliant": 4}[law]
            for ratio, value in zip(x, simulated, strict=True):
                chain = Chain((5.0 * ratio, 5.0), (1.0, 1.0), IDENTICAL_RODS.angles, IDENTICAL_RODS.rates)
                expected = getattr(closed_form(chain, ROUGH), f"final_rate_{rod}")
                assert value == pytest.approx(expected, rel=tolerance)


def test_bristle_as_a_double_pendulum() -> None:
    """Fig. 2.30: p_f at mu = 0.31 and n = 700, eq. 2.87 evaluated on its own."""
    found = closed_form(HEAVY_ROD, HEAVY_ROD_SURFACE).normal_final_impulse
    assert found == pytest.approx(2.4923689e-3, rel=5e-8)
    curve = next(each for each in heavy_rod_panel().curves if each.name == "$n$ = 700")
    # A heavy first rod is a hub of radius L: p_f of the bristle on it, to the share of the masses, 1/700.
    angle = math.radians(23.4)
    momentum = 8.387e-5 * 0.027 * (845.6 + 261.8) / 3.0
    for x, simulated in curve.points.values():
        s_1, s_2 = (math.sin(angle) + sign * x * math.cos(angle) for sign in (1.0, -1.0))
        expected = momentum * (s_2 + 0.42 * np.sqrt(s_1 * s_2)) / (s_1 * s_2)
        np.testing.assert_allclose(simulated, expected, rtol=1.0 / 700.0)
