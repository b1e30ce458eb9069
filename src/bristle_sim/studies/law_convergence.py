"""What the engine's own contact does when its solver is given more iterations, and a strike by any law with its own settings.

The engine's contact, taken with e* as its elasticity, settles to an impact that gains kinetic energy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Surface
from bristle_sim.scene.contact_laws import Coefficients, ContactLaw, EnergeticLaw, EngineLaw
from bristle_sim.scene.strike import Chain, build_strike

ITERATIONS = (1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000)

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


def strike_by(chain: Chain, surface: Surface, law: ContactLaw) -> LawResult:
    """Simulate one impact of a moving chain by a law with settings of its own."""
    scene, start, obstacle, units = build_strike(chain, surface)
    before = scene.mechanism.kinetic_energy(start)
    after, record = law.resolve(scene, start, obstacle, Coefficients.of(obstacle))
    rates = tuple(rate / units.time for rate in record.rates_after)
    return LawResult(rates, scene.mechanism.kinetic_energy(after) / before, scene.steps)


def engine_energy(chain: Chain, surface: Surface, iterations: Sequence[int] = ITERATIONS) -> EngineEnergy:
    """Return the energy ratio of a moving chain by the engine's own contact over its iterations, and by the energetic law."""
    engine = [strike_by(chain, surface, EngineLaw(count)).kinetic_energy_ratio for count in iterations]
    energetic = strike_by(chain, surface, EnergeticLaw()).kinetic_energy_ratio
    return EngineEnergy(np.array(iterations, dtype=float), np.array(engine), energetic)
