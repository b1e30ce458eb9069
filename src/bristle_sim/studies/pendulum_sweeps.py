"""Families of a double pendulum's impacts: closed forms over a parameter, and simulated impacts on them.

The curves are the dissertation's formulas; the points go through the pymunk scene, one strike each, with the contact law
they are named after.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bristle_sim.parameters import Bristle, Contact, Hub, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.curves import Curve, Level, Mark, Panel, curve_of
from bristle_sim.studies.impact_sweeps import AXES
from bristle_sim.theory.monofilament import normal_final_impulse, tip_speed
from bristle_sim.theory.pendulums import DoublePendulumImpact, double_pendulum_impact
from bristle_sim.trajectory import ContactRecord

__all__ = [
    "HEAVY_ROD",
    "HEAVY_ROD_SURFACE",
    "IMPULSE",
    "Case",
    "Measure",
    "closed_form",
    "final_rate",
    "heavy_rod_panel",
    "pendulum_curve",
    "weighted",
]

Array = NDArray[np.float64]
Case = Callable[[float], tuple[Chain, Surface]]
"""The impact that belongs to an x."""

LIGHT_RATIOS, HEAVY_RATIO = (1.0, 10.0), 700.0

HEAVY_ROD = Chain((700.0 * 8.387e-5, 8.387e-5), (0.027, 0.027), (-math.radians(23.4),) * 2, (261.8, 845.6))
"""The bristle as the second rod of a double pendulum whose first is 700 times as heavy (Zhang 2020, fig. 2.30)."""

HEAVY_ROD_SURFACE = Surface(friction=0.31, restitution=0.42)


@dataclass(frozen=True, slots=True)
class Measure:
    """One number of an impact: by closed form, and as read from a simulated one."""

    formula: Callable[[Chain, Surface], float]
    read: Callable[[Chain, ContactRecord], float]


def final_rate(rod: int) -> Measure:
    """Rate of a double pendulum's first (0) or second (1) rod after impact, rad/s, negative approaching."""
    name = f"final_rate_{rod + 1}"
    return Measure(
        lambda chain, surface: float(getattr(closed_form(chain, surface), name)),
        lambda _, contact: -contact.rates_after[rod],
    )


def closed_form(chain: Chain, surface: Surface) -> DoublePendulumImpact:
    """The double pendulum's closed form, its rates signed as in the dissertation."""
    return double_pendulum_impact(
        rod_mass=chain.masses[1],
        mass_ratio=chain.masses[0] / chain.masses[1],
        rod_length=chain.lengths[1],
        angle_1=-chain.angles[0],
        angle_2=-chain.angles[1],
        rate_1=-chain.rates[0],
        rate_2=-chain.rates[1],
        friction=surface.friction,
        restitution=surface.restitution,
        restitution_friction=surface.friction_in_restitution,
    )


IMPULSE = Measure(
    lambda chain, surface: closed_form(chain, surface).normal_final_impulse, lambda _, contact: contact.impulse[0]
)
"""p_f of a double pendulum, N s."""


def heavy_rod_panel() -> Panel:
    """Return p_f of the bristle as a double pendulum over the friction, by mass ratio (Zhang 2020, fig. 2.30)."""
    stiction = math.tan(-HEAVY_ROD.angles[1])
    frictions = 0.9999 * stiction * (1.0 - np.linspace(1.0, 0.0, 121) ** 2)
    simulated = {"energetic": np.linspace(0.0, 0.9, 6) * stiction, "compliant": np.linspace(0.09, 0.81, 5) * stiction}
    curves = [
        pendulum_curve(f"$n$ = {n:g}", IMPULSE, _over_friction(n), frictions, simulated)
        for n in (*LIGHT_RATIOS, HEAVY_RATIO)
    ]
    curves.append(curve_of("bristle on its hub", _monofilament, frictions))
    at = HEAVY_ROD_SURFACE.friction
    return Panel(
        AXES["friction"],
        AXES["normal_final_impulse"],
        tuple(curves),
        marks=(Mark(at, IMPULSE.formula(*_over_friction(HEAVY_RATIO)(at))),),
        levels=(Level(stiction, "stiction, $\\mu$ = tan $\\gamma$", upright=True),),
        top=3.0 * float(curves[-1].theory[0]),
    )


def pendulum_curve(name: str, measure: Measure, case: Case, x: Array, simulated: Mapping[str, Array]) -> Curve:
    """Return a measure of impacts over x in closed form, and of simulated ones by law; an impact without an end is left out."""
    points = {law: _simulated(measure, case, at, law) for law, at in simulated.items()}
    return curve_of(name, lambda grid: [measure.formula(*case(float(each))) for each in grid], x, points)


def _simulated(measure: Measure, case: Case, x: Array, law: str) -> tuple[Array, Array]:
    found = []
    for each in x.tolist():
        chain, surface = case(each)
        try:
            contact = strike(chain, surface, Contact(law), Settings()).contact
        except ValueError:
            continue
        found.append((each, measure.read(chain, contact)))
    places, values = np.array(found).reshape(-1, 2).T
    return places, values


def weighted(chain: Chain, mass_ratio: float) -> Chain:
    """A double pendulum with its first rod so many times as heavy as its second."""
    return dataclasses.replace(chain, masses=(mass_ratio * chain.masses[1], chain.masses[1]))


def _over_friction(ratio: float) -> Case:
    return lambda friction: (weighted(HEAVY_ROD, ratio), dataclasses.replace(HEAVY_ROD_SURFACE, friction=friction))


def _monofilament(friction: Array) -> Array:
    """Return (2.64) of the bristle at the rate of fig. 2.30."""
    hub, bristle = Hub(), Bristle()
    speed = tip_speed(bristle.length, hub.radius, hub.speed, HEAVY_ROD.rates[1] / hub.speed)
    angle, restitution = -HEAVY_ROD.angles[1], HEAVY_ROD_SURFACE.restitution
    return np.asarray(normal_final_impulse(bristle.mass, speed, angle, friction, restitution))
