"""What the engine's own contact and the contact resolved in time do when they are computed more finely.

The engine's contact, taken with e* as its elasticity, settles to an impact that gains kinetic energy when its solver is
given more iterations. The compliant contact, stepped more finely, converges to the energetic law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bristle_sim.parameters import Surface
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.contact_laws import Coefficients, ContactLaw, EnergeticLaw, EngineLaw
from bristle_sim.scene.strike import Chain, build_strike
from bristle_sim.studies.pendulum_sweeps import closed_form, weighted

__all__ = [
    "IDENTICAL_RODS",
    "Convergence",
    "EngineEnergy",
    "LawResult",
    "compliant_convergence",
    "engine_energy",
    "strike_by",
]

Array = NDArray[np.float64]

ITERATIONS = (1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000)
PLAIN_STEPS = (32, 64, 128, 256, 512)
ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
MASS_RATIOS = (1.0, 10.0, 100.0, 1e3, 1e4)

IDENTICAL_RODS = Chain((5.0, 5.0), (1.0, 1.0), (-np.pi / 9.0, -np.pi / 6.0), (0.1, 0.2))
"""Stronge's double pendulum (Zhang 2020, fig. 2.28 at n = 1)."""

IDENTICAL_RODS_SURFACE = Surface(friction=0.5, restitution=0.5)

RIGID = 1e-4
"""Accuracy to which contacts of plain steps follow the rigid-body limit: well below the steps' own errors, and not so
short that the rounding of positions shows in a penetration."""


@dataclass(frozen=True, slots=True)
class LawResult:
    """An impact by one law: rates after it in rad/s, its energy ratio and the engine steps it took."""

    rates_after: tuple[float, ...]
    kinetic_energy_ratio: float
    steps: int


@dataclass(frozen=True, slots=True)
class EngineEnergy:
    """Kinetic energy after over before: the engine's over its solver iterations, and the energetic law's."""

    iterations: Array
    engine: Array
    energetic: float


@dataclass(frozen=True, slots=True)
class Convergence:
    """Error of a contact resolved in time over engine steps, for one mass ratio; ``plain`` steps and extrapolated.

    Errors are the largest of the rates' differences from the closed form over the largest rate.
    """

    mass_ratio: float
    plain_steps: Array
    plain_error: Array
    extrapolated_steps: Array
    extrapolated_error: Array


def strike_by(chain: Chain, surface: Surface, law: ContactLaw) -> LawResult:
    """One impact of a moving chain through the scene, by a law with settings of its own."""
    scene, start, obstacle, units = build_strike(chain, surface)
    before = scene.mechanism.kinetic_energy(start)
    after, record = law.resolve(scene, start, obstacle, Coefficients.of(obstacle))
    rates = tuple(rate / units.time for rate in record.rates_after)
    return LawResult(rates, scene.mechanism.kinetic_energy(after) / before, scene.steps)


def engine_energy(chain: Chain, surface: Surface, iterations: Sequence[int] = ITERATIONS) -> EngineEnergy:
    """The engine's own contact with more and more iterations, beside the energetic law, for a chain that moves."""
    engine = [strike_by(chain, surface, EngineLaw(count)).kinetic_energy_ratio for count in iterations]
    energetic = strike_by(chain, surface, EnergeticLaw()).kinetic_energy_ratio
    return EngineEnergy(np.array(iterations, dtype=float), np.array(engine), energetic)


def compliant_convergence(mass_ratio: float, plain: Sequence[int] = PLAIN_STEPS) -> Convergence:
    """Stronge's double pendulum by contacts of so many plain engine steps, and extrapolated to several accuracies."""
    chain = weighted(IDENTICAL_RODS, mass_ratio)
    limit = _closed_form(chain)
    stepped = [_error(chain, CompliantLaw(None, RIGID, count), limit) for count in plain]
    extrapolated = [_error(chain, CompliantLaw(None, accuracy), limit) for accuracy in ACCURACIES]
    return Convergence(mass_ratio, *np.array(stepped).T, *np.array(extrapolated).T)


def _error(chain: Chain, law: ContactLaw, limit: Array) -> tuple[int, float]:
    """Engine steps and error of one impact."""
    result = strike_by(chain, IDENTICAL_RODS_SURFACE, law)
    return result.steps, float(np.abs(result.rates_after - limit).max() / np.abs(limit).max())


def _closed_form(chain: Chain) -> Array:
    """Rates after the impact as the chain counts them, rad/s."""
    after = closed_form(chain, IDENTICAL_RODS_SURFACE)
    return -np.array([after.final_rate_1, after.final_rate_2])
