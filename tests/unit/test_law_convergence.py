"""More iterations let the engine's contact gain energy; finer steps let the compliant contact converge."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.contact_laws import EnergeticLaw
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.double_pendulum_families import closed_form, weighted
from bristle_sim.studies.law_convergence import RIGID, engine_energy, strike_by

IDENTICAL_RODS = Chain((5.0, 5.0), (1.0, 1.0), (-math.pi / 9.0, -math.pi / 6.0), (0.1, 0.2))
"""Stronge's double pendulum (Zhang 2020, fig. 2.28 at n = 1)."""

THREE_RODS = Chain((3.0, 1.5, 0.7), (0.4, 0.9, 0.6), (0.3, -0.5, -0.9), (-1.0, 2.0, 3.0))
ROUGH = Surface(friction=0.5, restitution=0.5)


def kinetic_energy(rates: tuple[float, float]) -> float:
    """T of identical rods of 5 kg and 1 m at 20 and 30 deg, eq. 2.66."""
    q_1, q_2 = rates[0], 0.5 * rates[1]
    return 5.0 * (2.0 / 3.0 * q_1**2 + 2.0 / 3.0 * q_2**2 + math.cos(math.radians(10.0)) * q_1 * q_2)


def test_the_engine_creates_energy() -> None:
    energy = engine_energy(IDENTICAL_RODS, ROUGH, iterations=(10, 1000))
    before = kinetic_energy((-0.1, -0.2))
    # Rates measured with the bare engine, to three digits: energies to about twice 5e-4/0.2.
    assert energy.engine[0] == pytest.approx(kinetic_energy((-0.212, 0.249)) / before, rel=2e-2)
    assert energy.engine[1] == pytest.approx(kinetic_energy((-0.335, 0.363)) / before, rel=2e-2)
    assert energy.engine[1] > 1.0
    # The energetic law's rates, eqs. 2.74-2.89 evaluated on their own to eight digits.
    assert energy.energetic == pytest.approx(kinetic_energy((-0.19893234, 0.22313679)) / before, rel=1e-7)


def test_strike_by_a_law_is_the_strike_of_that_name() -> None:
    found, named = strike_by(THREE_RODS, ROUGH, EnergeticLaw()), strike(THREE_RODS, ROUGH, Contact(), Settings())
    assert found.rates_after == named.contact.rates_after
    assert found.kinetic_energy_ratio == pytest.approx(named.kinetic_energy_ratio, rel=1e-14)  # one sum, two orders


def error_and_steps(chain: Chain, law: CompliantLaw) -> tuple[float, int]:
    """Largest difference of a rate from the closed form over the largest rate, and the engine steps."""
    found, limit = strike_by(chain, ROUGH, law), closed_form(chain, ROUGH)
    rates = np.array([-limit.final_rate_1, -limit.final_rate_2])
    return float(np.abs(found.rates_after - rates).max() / np.abs(rates).max()), found.steps


@pytest.mark.parametrize("mass_ratio", [1.0, 1e4])
def test_compliant_contact_converges_to_the_energetic_law(mass_ratio: float) -> None:
    chain = weighted(IDENTICAL_RODS, mass_ratio)
    (coarse, few), (fine, many) = (error_and_steps(chain, CompliantLaw(None, RIGID, count)) for count in (64, 512))
    # One, less what the first-order error's own curvature and the contact's length leave.
    assert math.log(coarse / fine) / math.log(512 / 64) > 0.95
    assert fine < 4e-3  # first order, and 1e-3 at about 2000 steps measured with the bare engine
    assert (few, many) >= (64, 512)
    # Extrapolated to 1e-2 and 1e-6; the latter within ten times of what was requested.
    assert error_and_steps(chain, CompliantLaw(None, 1e-2))[0] < 1e-2
    assert error_and_steps(chain, CompliantLaw(None, 1e-6))[0] < 1e-5
