"""Figures 2.28-2.30: Stronge's double pendulum (Zhang 2020, sec. 2.4.2).

Figures 2.28 and 2.29 vary the mass ratio of the two rods. In figure 2.30 the second rod is the
bristle, and the first rod is heavy.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from functools import cache, partial

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.dissertation.impact_figures import (
    AXES,
    FINAL,
    NEAREST,
    Impact,
    closed_form,
    impact_curve,
)
from bristle_sim.dissertation.operating_point import OPERATING_POINT
from bristle_sim.dissertation.redrawn import Axis, Curve, Level, Mark, Panel, Redrawn, curve_of
from bristle_sim.parameters import DoublePendulum, Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.studies.impacts import double_chain
from bristle_sim.theory.pendulums import DoublePendulumImpact, double_pendulum_impact
from bristle_sim.trajectory import ContactRecord

STRONGE = double_chain(DoublePendulum())
"""Double pendulum of figures 2.28 and 2.29."""

HEAVY_ROD = Chain(
    (700.0 * 8.387e-5, 8.387e-5), (0.027, 0.027), (-math.radians(23.4),) * 2, (261.8, 845.6)
)
"""Double pendulum of figure 2.30 (Zhang 2020): the bristle on a rod 700 times as heavy."""


def rate_figure(number: str, name: str, rod: int) -> Redrawn:
    """Return figure 2.28 or 2.29: angular velocity of a rod after the impact, over the mass ratio.

    There is one curve for each of three coefficients of friction. At the two lower ones the tip's
    slip reverses; at the highest the tip sticks.

    Args:
        number: number of the figure.
        name: name of the rod.
        rod: number of the rod, 1 or 2.
    """
    ratios = np.geomspace(1.0, 1e4, 121)
    places = {"energetic": np.geomspace(1.0, 1e4, 5), "compliant": np.geomspace(1.0, 1e4, 9)[1::2]}
    curves = tuple(
        _curve(f"{mu:g}", f"final_rate_{rod}", partial(_impact, STRONGE, 0.5, mu), ratios, places)
        for mu in (0.3, 0.5, 0.7)
    )
    levels = (Level(-STRONGE.rates[0], "before the impact"),) if rod == 1 else ()
    axes = Axis("mass ratio $n$", log=True), Axis(f"rate after impact, {name}", "rad/s")
    note = "slip stops and reverses for $\\mu$ = 0.3 and 0.5; with 0.7 the tip sticks"
    panel = Panel(*axes, curves, family="$\\mu$", levels=levels)
    return Redrawn(number, f"double pendulum: rate of {name}, over the mass ratio", (panel,), note)


def heavy_rod_figure() -> Redrawn:
    """Return figure 2.30: final normal impulse of a double pendulum with a heavy first rod.

    The second rod is the bristle. The closed form of the bristle on a hub is drawn for comparison.
    """
    stiction = math.tan(-HEAVY_ROD.angles[1])
    frictions = 0.9999 * stiction * (1.0 - np.linspace(1.0, 0.0, 121) ** 2)
    last = NEAREST * stiction
    places = {"energetic": np.linspace(0.0, last, 6), "compliant": np.linspace(0.1, 0.9, 5) * last}

    def impact(mass_ratio: float, friction: float) -> tuple[Chain, Surface]:
        return _impact(HEAVY_ROD, 0.42, friction, mass_ratio)

    curves = [
        _curve(f"$n$ = {n:g}", FINAL, partial(impact, n), frictions, places)
        for n in (1.0, 10.0, 700.0)
    ]
    ratio = HEAVY_ROD.rates[1] / OPERATING_POINT["hub_speed"]
    on_hub = closed_form(FINAL, OPERATING_POINT | {"speed_ratio": ratio}, "friction")
    curves.append(curve_of("bristle on its hub", on_hub, frictions))
    at = OPERATING_POINT["friction"]
    panel = Panel(
        AXES["friction"],
        AXES[FINAL],
        tuple(curves),
        marks=(Mark(at, _closed_form(*impact(700.0, at)).normal_final_impulse),),
        levels=(Level(stiction, "stiction, $\\mu$ = tan $\\gamma$", upright=True),),
        top=3.0 * float(curves[-1].theory[0]),
    )
    note = "the heavy rod is 0.027 m long where the hub has 0.0275: half a per cent less impulse"
    return Redrawn(
        "2.30", "final impulse of the modified double pendulum over friction", (panel,), note
    )


def _impact(
    chain: Chain, restitution: float, friction: float, mass_ratio: float
) -> tuple[Chain, Surface]:
    """Return the rods and the surface of a double pendulum's impact.

    ``mass_ratio`` is the mass of the first rod divided by that of the second. It replaces the ratio
    of ``chain``.
    """
    mass = chain.masses[1]
    rods = dataclasses.replace(chain, masses=(mass_ratio * mass, mass))
    return rods, Surface(friction, None, restitution)


@cache
def _closed_form(chain: Chain, surface: Surface) -> DoublePendulumImpact:
    """Return the double pendulum's closed-form impact.

    In the result, angles and angular velocities have the dissertation's signs, which are opposite
    to those of ``chain``.
    """
    first, second = chain.masses
    state = [-each for each in (*chain.angles, *chain.rates)]
    coefficients = (surface.friction, surface.restitution)
    return double_pendulum_impact(
        *(second, first / second, chain.lengths[1], *state, *coefficients)
    )


def _curve(
    name: str, quantity: str, impact: Impact, x: Array, places: Mapping[str, Array]
) -> Curve:
    """Return the closed-form curve of a quantity, with points of simulated impacts.

    The quantity is ``normal_final_impulse`` (N s), or ``final_rate_1`` or ``final_rate_2``, the
    angular velocity of a rod after the impact (rad/s). An angular velocity is negative in the
    direction of approach.

    Args:
        name: label of the curve.
        quantity: name of the quantity.
        impact: function that returns the rods and the surface of the impact at x.
        x: values at which the curve is computed.
        places: values of x at which impacts are simulated, by contact law.
    """

    def formula(grid: Array) -> list[float]:
        return [getattr(_closed_form(*impact(each)), quantity) for each in grid.tolist()]

    def read(contact: ContactRecord) -> float:
        """Return the quantity of a simulated contact, with the sign that it has in the
        dissertation.
        """
        return (
            contact.impulse[0] if quantity == FINAL else -contact.rates_after[int(quantity[-1]) - 1]
        )

    return impact_curve(name, formula, x, impact, read, places)
