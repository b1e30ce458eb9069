"""Families of a double pendulum's impacts: closed forms over a parameter, and simulated impacts on them.

The curves are the dissertation's formulas; the points go through the pymunk scene, one strike each, with the contact law
they are named after.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Bristle, Hub, Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.studies.curves import Axis, Curve, Level, Mark, Panel, curve_of, impact_curve
from bristle_sim.studies.impacts import Impacts
from bristle_sim.studies.rod_families import AXES
from bristle_sim.theory.monofilament import normal_final_impulse, tip_speed
from bristle_sim.theory.pendulums import DoublePendulumImpact, double_pendulum_impact
from bristle_sim.trajectory import ContactRecord

Impact = Callable[[float], tuple[Chain, Surface]]
"""The double pendulum and the surface that belong to an x."""

POINTS = 81
"""Points on a closed form over the mass ratio: enough for a smooth curve half a page wide."""

SIMULATED = 9

FINAL_IMPULSE = "normal_final_impulse"

LIGHT_RATIOS, HEAVY_RATIO = (1.0, 10.0), 700.0

HEAVY_ROD = Chain((700.0 * 8.387e-5, 8.387e-5), (0.027, 0.027), (-math.radians(23.4),) * 2, (261.8, 845.6))
"""The bristle as the second rod of a double pendulum whose first is 700 times as heavy (Zhang 2020, fig. 2.30)."""

HEAVY_ROD_SURFACE = Surface(friction=0.31, restitution=0.42)


def closed_form(chain: Chain, surface: Surface) -> DoublePendulumImpact:
    """The double pendulum's closed form, its rates signed as in the dissertation."""
    return double_pendulum_impact(
        chain.masses[1],
        chain.masses[0] / chain.masses[1],
        chain.lengths[1],
        -chain.angles[0],
        -chain.angles[1],
        -chain.rates[0],
        -chain.rates[1],
        surface.friction,
        surface.restitution,
        surface.friction_in_restitution,
    )


def heavy_rod_panel() -> Panel:
    """Return p_f of the bristle as a double pendulum over the friction, by mass ratio (Zhang 2020, fig. 2.30)."""
    stiction = math.tan(-HEAVY_ROD.angles[1])
    frictions = 0.9999 * stiction * (1.0 - np.linspace(1.0, 0.0, 121) ** 2)
    simulated = {"energetic": np.linspace(0.0, 0.9, 6) * stiction, "compliant": np.linspace(0.09, 0.81, 5) * stiction}
    curves = [
        pendulum_curve(f"$n$ = {n:g}", FINAL_IMPULSE, _over_friction(n), frictions, simulated)
        for n in (*LIGHT_RATIOS, HEAVY_RATIO)
    ]
    hub, bristle, coefficient = Hub(), Bristle(), HEAVY_ROD_SURFACE.restitution
    speed = tip_speed(bristle.length, hub.radius, hub.speed, HEAVY_ROD.rates[1] / hub.speed)
    given = (bristle.mass, speed, -HEAVY_ROD.angles[1])
    curves.append(curve_of("bristle on its hub", lambda mu: normal_final_impulse(*given, mu, coefficient), frictions))
    at = HEAVY_ROD_SURFACE.friction
    own = getattr(closed_form(*_over_friction(HEAVY_RATIO)(at)), FINAL_IMPULSE)
    return Panel(
        AXES["friction"],
        AXES[FINAL_IMPULSE],
        tuple(curves),
        marks=(Mark(at, own),),
        levels=(Level(stiction, "stiction, $\\mu$ = tan $\\gamma$", upright=True),),
        top=3.0 * float(curves[-1].theory[0]),
    )


def pendulum_curve(name: str, quantity: str, impact: Impact, x: Array, places: Mapping[str, Array]) -> Curve:
    """Return p_f, N s, or the rate of a rod, rad/s, negative approaching, over x, and of simulated impacts by law."""

    def formula(grid: Array) -> list[float]:
        return [getattr(closed_form(*impact(float(each))), quantity) for each in grid]

    def read(contact: ContactRecord) -> float:
        values = {"final_rate_1": -contact.rates_after[0], "final_rate_2": -contact.rates_after[1]}
        return (values | {FINAL_IMPULSE: contact.impulse[0]})[quantity]

    return impact_curve(name, formula, x, impact, read, places)


def double_pendulum_panels(impacts: Impacts) -> dict[str, Panel]:
    """Return the families that a double pendulum's impact belongs to (Zhang 2020, figs. 2.28-2.30), simulated too."""
    chain, surface = impacts.chain, impacts.surface
    own = chain.masses[0] / chain.masses[1]
    ratios = np.geomspace(min(1.0, 0.5 * own), max(1e4, min(2.0 * own, 1e12)), POINTS)
    energetic = ratios[:: POINTS // (SIMULATED - 1)]
    places = {"energetic": energetic, "compliant": np.sqrt(energetic[1:] * energetic[:-1])[::2]}

    def impact(ratio: float) -> tuple[Chain, Surface]:
        return weighted(chain, ratio), surface

    curves = tuple(pendulum_curve(f"rod {k}", f"final_rate_{k}", impact, ratios, places) for k in (1, 2))
    after = impacts.strikes[impacts.law].contact.rates_after
    rates = Panel(
        Axis("mass ratio $m_1/m_2$", log=True),
        Axis("rate after the impact", "rad/s"),
        curves,
        family="rate of",
        marks=tuple(Mark(own, -rate) for rate in after),
        levels=(Level(-chain.rates[0], "rod 1 before the impact"),),
    )
    return {"rates over mass ratio": rates, "heavy rod": heavy_rod_panel()}


def weighted(chain: Chain, mass_ratio: float) -> Chain:
    """Return a double pendulum with another ratio of its first rod's mass to its second's."""
    return dataclasses.replace(chain, masses=(mass_ratio * chain.masses[1], chain.masses[1]))


def _over_friction(ratio: float) -> Impact:
    return lambda friction: (weighted(HEAVY_ROD, ratio), dataclasses.replace(HEAVY_ROD_SURFACE, friction=friction))
