"""Families of impacts: closed forms over a parameter, and simulated impacts on them.

The curves are the dissertation's formulas; the points go through the pymunk scene, one strike each, with the contact law
they are named after. Curve and points of a family are built from the same cases, each a chain and a surface. A rod stands
for the bristle on its hub and, with a hub of no radius, for Stronge's single pendulum.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.curves import Curve
from bristle_sim.studies.impact_measures import IMPULSE, REBOUND, ROD_IMPULSE, Measure, final_rate

__all__ = [
    "HEAVY_ROD",
    "HEAVY_ROD_SURFACE",
    "Families",
    "double_pendulum_families",
    "final_rates_over_mass_ratio",
    "heavy_rod_impulse_over_friction",
    "impulse_over_friction",
    "oblique_families",
    "rebound_over_angle",
    "rebound_over_friction",
    "single_pendulum_families",
    "stiction_friction",
    "weighted",
    "with_own",
]

Array = NDArray[np.float64]
Case = Callable[[float], tuple[Chain, Surface]]
"""The impact that belongs to an x."""

POINTS = 81
"""Places on a closed form: enough for a smooth curve half a page wide."""

FRICTIONS = (0.0, 0.1, 0.3, 0.6, 1.0)
ANGLES = tuple(math.radians(angle) for angle in (15.0, 23.4, 35.0, 50.0, 70.0))
RESTITUTIONS = (0.0, 0.2, 0.42, 0.7, 1.0)
"""What the families of a scenario's figure vary, beside the value of the impact at hand; rad."""

SIMULATED = 9
NEAR_STICTION = 0.95
"""Simulated impacts stay below this share of the stiction friction, curves below 0.9999 of it."""

HEAVY_ROD = Chain((700.0 * 8.387e-5, 8.387e-5), (0.027, 0.027), (-math.radians(23.4),) * 2, (261.8, 845.6))
"""The bristle as the second rod of a double pendulum whose first is 700 times as heavy (Zhang 2020, fig. 2.30)."""

HEAVY_ROD_SURFACE = Surface(friction=0.31, restitution=0.42)


Families = Mapping[str, tuple[Curve, ...]]
"""The curves of a figure's panels, by what they show."""


def oblique_families(chain: Chain, surface: Surface) -> Families:
    """Return the families that a bristle's strike belongs to (Zhang 2020, figs. 2.22-2.24); impacts are simulated.

    A bristle at rest before the impact has no rebound ratio.
    """
    angles, restitutions = with_own(ANGLES, -chain.angles[0]), with_own(RESTITUTIONS, surface.restitution)
    return {
        "rebound over angle": _moving(rebound_over_angle, chain, surface, with_own(FRICTIONS, surface.friction)),
        "impulse by angle": impulse_over_friction(chain, surface, angles=angles),
        "impulse by restitution": impulse_over_friction(chain, surface, restitutions=restitutions),
    }


def single_pendulum_families(chain: Chain, surface: Surface) -> Families:
    """Return the families that a single pendulum's impact belongs to (Zhang 2020, fig. 2.26); impacts are simulated.

    A pendulum at rest before the impact has no rebound ratio.
    """
    return {
        "rebound over angle": _moving(rebound_over_angle, chain, surface, with_own(FRICTIONS, surface.friction)),
        "rebound over friction": _moving(rebound_over_friction, chain, surface, with_own(ANGLES, -chain.angles[0])),
    }


def double_pendulum_families(chain: Chain, surface: Surface) -> Families:
    """Return the families that a double pendulum's impact belongs to (Zhang 2020, figs. 2.28-2.30), simulated too."""
    return {
        "rates over mass ratio": final_rates_over_mass_ratio(chain, surface),
        "heavy rod": heavy_rod_impulse_over_friction(),
    }


def _moving(
    family: Callable[[Chain, Surface, Sequence[float]], tuple[Curve, ...]],
    rod: Chain,
    surface: Surface,
    values: Sequence[float],
) -> tuple[Curve, ...]:
    return family(rod, surface, values) if rod.rates[0] != 0.0 else ()


def with_own(values: Sequence[float], own: float) -> tuple[float, ...]:
    """A family's values, ascending, with the one at hand in place of those within a tenth of it."""
    return tuple(sorted([*(value for value in values if abs(value - own) > 0.1 * own), own]))


def weighted(chain: Chain, mass_ratio: float) -> Chain:
    """A double pendulum with its first rod so many times as heavy as its second."""
    return dataclasses.replace(chain, masses=(mass_ratio * chain.masses[1], chain.masses[1]))


def stiction_friction(surface: Surface, angle: float) -> float:
    """Least friction with which a rod at the angle (rad) does not rebound; inf if restitution's own decides that."""
    return math.tan(angle) if surface.restitution_friction is None else math.inf


def rebound_over_angle(rod: Chain, surface: Surface, frictions: Sequence[float]) -> tuple[Curve, ...]:
    """Rate after over rate before impact, over the impact angle (rad), for each friction (Zhang 2020, figs. 2.24, 2.26).

    Raises:
        ValueError: if the rod is at rest before the impact.
    """
    simulated = {"energetic": np.radians(np.linspace(6.0, 86.0, SIMULATED))}
    curves = []
    for mu in frictions:
        rubbing = _rubbing(surface, mu)
        angles = _angles(rubbing.friction_in_restitution)
        curves.append(_curve(f"{mu:g}", REBOUND, angles, _over_angle(rod, rubbing), simulated))
    return tuple(curves)


def rebound_over_friction(rod: Chain, surface: Surface, angles: Sequence[float]) -> tuple[Curve, ...]:
    """Rate after over rate before impact, over the friction, for each impact angle (rad).

    Raises:
        ValueError: if the rod is at rest before the impact.
    """
    curves = []
    for angle in angles:
        frictions, simulated = _frictions(surface, angle)
        case = _over_friction(_inclined(rod, angle), surface)
        curves.append(_curve(_degrees(angle), REBOUND, frictions, case, {"energetic": simulated}))
    return tuple(curves)


def impulse_over_friction(
    rod: Chain, surface: Surface, *, angles: Sequence[float] = (), restitutions: Sequence[float] = ()
) -> tuple[Curve, ...]:
    """p_f over the friction, for each impact angle (rad) and for each e* (Zhang 2020, figs. 2.22 and 2.23), N s.

    Curves end short of the stiction friction, where p_f grows without bound.
    """
    own = -rod.angles[0]
    family = [(_degrees(angle), angle, surface) for angle in angles]
    family += [(f"{e:g}", own, dataclasses.replace(surface, restitution=e)) for e in restitutions]
    curves = []
    for name, angle, bouncing in family:
        frictions, simulated = _frictions(surface, angle)
        case = _over_friction(_inclined(rod, angle), bouncing)
        curves.append(_curve(name, ROD_IMPULSE, frictions, case, {"energetic": simulated}))
    return tuple(curves)


def final_rates_over_mass_ratio(chain: Chain, surface: Surface) -> tuple[Curve, Curve]:
    """Rates of the first and second rod after impact over the ratio of masses (Zhang 2020, figs. 2.29, 2.28), rad/s.

    Signed as in the dissertation, negative approaching.
    """
    own = chain.masses[0] / chain.masses[1]
    ratios = np.geomspace(min(1.0, 0.5 * own), max(1e4, min(2.0 * own, 1e12)), POINTS)
    energetic = ratios[:: POINTS // (SIMULATED - 1)]
    simulated = {"energetic": energetic, "compliant": np.sqrt(energetic[1:] * energetic[:-1])[::2]}
    case = _over_mass_ratio(chain, surface)
    first, second = (_curve(f"rod {k + 1}", final_rate(k), ratios, case, simulated) for k in (0, 1))
    return first, second


def heavy_rod_impulse_over_friction(ratios: Sequence[float] = (1.0, 10.0, 700.0)) -> tuple[Curve, ...]:
    """p_f of the bristle as a double pendulum over the friction, for each mass ratio (Zhang 2020, fig. 2.30), N s."""
    frictions, energetic = _frictions(HEAVY_ROD_SURFACE, -HEAVY_ROD.angles[1])
    simulated = {"energetic": energetic, "compliant": 0.5 * (energetic[1:] + energetic[:-1])[::2]}
    return tuple(
        _curve(f"{n:g}", IMPULSE, frictions, _over_friction(weighted(HEAVY_ROD, n), HEAVY_ROD_SURFACE), simulated)
        for n in ratios
    )


def _angles(friction: float) -> Array:
    """Impact angles for a curve, closer together above the one at which the rod begins to rebound, rad."""
    beginning, end = max(math.atan(friction), 0.01), 0.5 * math.pi
    rebounding = beginning + (end - beginning) * np.linspace(0.0, 1.0, POINTS) ** 2
    return np.concatenate([[min(0.01, 0.5 * beginning)], rebounding])


def _frictions(surface: Surface, angle: float) -> tuple[Array, Array]:
    """Frictions for a curve, closer together towards stiction, and for simulated impacts on it."""
    most = min(max(1.0, 1.25 * surface.friction), stiction_friction(surface, angle))
    curve = most * (1.0 - np.linspace(1.0, 1e-2, POINTS) ** 2)
    return curve, np.linspace(0.0, NEAR_STICTION * most, SIMULATED)


def _curve(name: str, measure: Measure, x: Array, case: Case, simulated: Mapping[str, Array]) -> Curve:
    theory = np.array([measure.formula(*case(float(each))) for each in x])
    return Curve(name, x, theory, {law: _simulated(measure, where, case, law) for law, where in simulated.items()})


def _simulated(measure: Measure, x: Array, case: Case, law: str) -> tuple[Array, Array]:
    """The impacts that come to an end, through the scene."""
    found = []
    for each in x:
        chain, surface = case(float(each))
        try:
            contact = strike(chain, surface, Contact(law), Settings()).contact
        except ValueError:
            continue
        found.append((each, measure.read(chain, contact)))
    places, values = np.array(found).reshape(-1, 2).T
    return places, values


def _rubbing(surface: Surface, friction: float) -> Surface:
    """The surface with another friction; one of its own in restitution stays."""
    return dataclasses.replace(surface, friction=friction)


def _inclined(rod: Chain, angle: float) -> Chain:
    """The radial rod at another impact angle."""
    return dataclasses.replace(rod, angles=(-angle,), hub_angle=-angle)


def _over_angle(rod: Chain, surface: Surface) -> Case:
    return lambda angle: (_inclined(rod, angle), surface)


def _over_friction(chain: Chain, surface: Surface) -> Case:
    return lambda friction: (chain, _rubbing(surface, friction))


def _over_mass_ratio(chain: Chain, surface: Surface) -> Case:
    return lambda ratio: (weighted(chain, ratio), surface)


def _degrees(angle: float) -> str:
    return f"{round(math.degrees(angle), 6):g}°"
