"""Figures 2.28-2.30: Stronge's double pendulum, over the ratio of its masses and as a bristle on a heavy rod (Zhang 2020)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from functools import cache, partial

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.dissertation.impact_figures import AXES, FINAL, OPERATING_POINT, Impact, closed_form, impact_curve
from bristle_sim.dissertation.redrawn import Axis, Curve, Level, Mark, Panel, Redrawn, curve_of
from bristle_sim.parameters import DoublePendulum, Hub, Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.studies.impacts import double_chain
from bristle_sim.theory.pendulums import DoublePendulumImpact, double_pendulum_impact
from bristle_sim.trajectory import ContactRecord

HEAVY_ROD = Chain((700.0 * 8.387e-5, 8.387e-5), (0.027, 0.027), (-math.radians(23.4),) * 2, (261.8, 845.6))
"""The bristle as the second rod of a double pendulum whose first is 700 times as heavy (Zhang 2020, fig. 2.30)."""


def double_pendulum_figure(number: str) -> Redrawn:
    """Return figures 2.28 and 2.29: rates after impact over the mass ratio, for frictions that stick and reverse."""
    rod, name = {"2.28": (2, "rod BC"), "2.29": (1, "rod OB")}[number]
    panel = rate_panel(double_chain(DoublePendulum()), Surface(0.5, None, 0.5), rod, (0.3, 0.5, 0.7), (1.0, 1e4))
    return Redrawn(
        number,
        f"double pendulum: rate of {name}, over the mass ratio",
        (dataclasses.replace(panel, y=Axis(f"rate after impact, {name}", "rad/s")),),
        "slip stops and reverses for $\\mu$ = 0.3 and 0.5; with 0.7 the tip sticks",
    )


def heavy_rod_figure() -> Redrawn:
    """Return figure 2.30: final impulse of the bristle as the second rod of a double pendulum, and the monofilament's."""
    stiction, at = math.tan(-HEAVY_ROD.angles[1]), OPERATING_POINT.friction
    frictions = 0.9999 * stiction * (1.0 - np.linspace(1.0, 0.0, 121) ** 2)
    surface, ratios = Surface(restitution=0.42), (1.0, 10.0, 700.0)
    curves = [*friction_panel(HEAVY_ROD, surface, ratios, 0.9 * stiction, frictions).curves]
    bristle = dataclasses.replace(OPERATING_POINT, speed_ratio=HEAVY_ROD.rates[1] / Hub().speed)
    curves.append(curve_of("bristle on its hub", closed_form(FINAL, bristle, "friction"), frictions))
    own = _closed_form(*_impact(HEAVY_ROD, surface, 700.0, at)).normal_final_impulse
    panel = Panel(
        AXES["friction"],
        AXES[FINAL],
        tuple(curves),
        marks=(Mark(at, own),),
        levels=(Level(stiction, "stiction, $\\mu$ = tan $\\gamma$", upright=True),),
        top=3.0 * float(curves[-1].theory[0]),
    )
    return Redrawn(
        "2.30",
        "final impulse of the modified double pendulum over friction",
        (panel,),
        "the heavy rod is 0.027 m long where the hub has 0.0275: half a per cent less impulse",
    )


def rate_panel(
    chain: Chain, surface: Surface, rod: int, frictions: Sequence[float], ratios: tuple[float, float]
) -> Panel:
    """Return the rate of a rod, the first or the second, over the mass ratio between two, by friction."""
    grid = np.geomspace(*ratios, 121)
    places = {"energetic": np.geomspace(*ratios, 5), "compliant": np.geomspace(*ratios, 9)[1::2]}
    curves = [
        _pendulum_curve(f"{mu:g}", f"final_rate_{rod}", partial(_impact, chain, surface, friction=mu), grid, places)
        for mu in frictions
    ]
    levels = (Level(-chain.rates[0], "before the impact"),) if rod == 1 else ()
    axes = Axis("mass ratio $n$", log=True), Axis("rate after impact", "rad/s")
    return Panel(*axes, tuple(curves), family="$\\mu$", levels=levels)


def friction_panel(
    chain: Chain, surface: Surface, ratios: Sequence[float], last: float, grid: Array | None = None
) -> Panel:
    """Return the final impulse over friction by mass ratio; ``last`` is the largest friction of simulated impacts."""
    places = {"energetic": np.linspace(0.0, last, 6), "compliant": np.linspace(0.1, 0.9, 5) * last}
    frictions = np.linspace(0.0, last, 121) if grid is None else grid
    curves = [
        _pendulum_curve(f"$n$ = {n:g}", FINAL, partial(_impact, chain, surface, n), frictions, places) for n in ratios
    ]
    return Panel(AXES["friction"], AXES[FINAL], tuple(curves))


def _impact(chain: Chain, surface: Surface, mass_ratio: float, friction: float) -> tuple[Chain, Surface]:
    """Return a double pendulum with another ratio of its first rod's mass to its second's, and what it strikes."""
    masses = (mass_ratio * chain.masses[1], chain.masses[1])
    return dataclasses.replace(chain, masses=masses), dataclasses.replace(surface, friction=friction)


@cache
def _closed_form(chain: Chain, surface: Surface) -> DoublePendulumImpact:
    """Return the double pendulum's closed form, its rates signed as in the dissertation."""
    first, second = chain.masses
    state = [-each for each in (*chain.angles, *chain.rates)]
    coefficients = (surface.friction, surface.restitution, surface.friction_in_restitution)
    return double_pendulum_impact(*(second, first / second, chain.lengths[1], *state, *coefficients))


def _pendulum_curve(name: str, quantity: str, impact: Impact, x: Array, places: Mapping[str, Array]) -> Curve:
    """Return p_f, N s, or the rate of a rod, rad/s, negative approaching, over x, and of simulated impacts by law."""

    def formula(grid: Array) -> list[float]:
        return [getattr(_closed_form(*impact(each)), quantity) for each in grid.tolist()]

    def read(contact: ContactRecord) -> float:
        values = {"final_rate_1": -contact.rates_after[0], "final_rate_2": -contact.rates_after[1]}
        return (values | {FINAL: contact.impulse[0]})[quantity]

    return impact_curve(name, formula, x, impact, read, places)
