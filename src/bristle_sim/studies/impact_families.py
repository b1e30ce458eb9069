"""Families that an impact at hand belongs to, with the impact itself marked: what figures of single impacts show."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from bristle_sim.parameters import Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.studies.curves import Axis, Level, Mark, Panel
from bristle_sim.studies.impact_sweeps import Case, Sweep, sweep_panel
from bristle_sim.studies.impacts import Impacts
from bristle_sim.studies.pendulum_sweeps import final_rate, heavy_rod_panel, pendulum_curve, weighted

__all__ = ["double_pendulum_panels", "oblique_panels", "single_pendulum_panels", "with_own"]

FRICTIONS = (0.0, 0.1, 0.3, 0.6, 1.0)
ANGLES = tuple(math.radians(angle) for angle in (15.0, 23.4, 35.0, 50.0, 70.0))
RESTITUTIONS = (0.0, 0.2, 0.42, 0.7, 1.0)
"""What the families of a scenario's figure vary, beside the value of the impact at hand; rad."""

RATIO = Axis("mass ratio $m_1/m_2$", log=True)

PLACES = 81
"""On a closed form over the mass ratio: enough for a smooth curve half a page wide."""

SIMULATED = 9


def oblique_panels(impacts: Impacts) -> dict[str, Panel]:
    """Return the families that a bristle's strike belongs to (Zhang 2020, figs. 2.22-2.24); impacts are simulated."""
    own = Case.of(impacts.chain, impacts.surface)
    impulse = impacts.strikes[impacts.law].contact.impulse[0]
    over_friction = _over_friction(own, "impact_angle", with_own(ANGLES, own.impact_angle))
    by_restitution = dataclasses.replace(
        over_friction, family="restitution", values=with_own(RESTITUTIONS, own.restitution)
    )
    return {
        "impulse by angle": _marked("normal_final_impulse", over_friction, own.friction, impulse),
        "impulse by restitution": _marked("normal_final_impulse", by_restitution, own.friction, impulse),
        **_rebound(impacts, own, "rebound over angle"),
    }


def single_pendulum_panels(impacts: Impacts) -> dict[str, Panel]:
    """Return the families that a single pendulum's impact belongs to (Zhang 2020, fig. 2.26); impacts are simulated.

    A pendulum at rest before the impact has none.
    """
    return _rebound(impacts, Case.of(impacts.chain, impacts.surface), "rebound over angle", "rebound over friction")


def _rebound(impacts: Impacts, own: Case, *names: str) -> dict[str, Panel]:
    """Rebound ratio over the impact angle and over friction, for a rod that moves."""
    before = impacts.chain.rates[0]
    if before == 0.0:
        return {}
    ratio = impacts.strikes[impacts.law].contact.rates_after[0] / before
    found = {}
    for name in names:
        if name == "rebound over angle":
            frictions = with_own(FRICTIONS, own.friction)
            sweep = Sweep("impact_angle", math.radians(2.0), 0.5 * math.pi, "friction", frictions, base=own)
            found[name] = _marked("rebound_ratio", sweep, own.impact_angle, ratio)
        else:
            sweep = _over_friction(own, "impact_angle", with_own(ANGLES, own.impact_angle))
            found[name] = _marked("rebound_ratio", sweep, own.friction, ratio)
    return found


def _over_friction(own: Case, family: str, values: tuple[float, ...]) -> Sweep:
    """Over friction; up to stiction, unless restitution has a friction of its own."""
    most = max(1.0, 1.25 * own.friction)
    return Sweep("friction", 0.0, most, family, values, own.restitution_friction is None, own)


def _marked(quantity: str, sweep: Sweep, x: float, y: float) -> Panel:
    """The sweep's panel with the impact at hand as its mark."""
    return dataclasses.replace(sweep_panel(quantity, sweep), marks=(Mark(x, y),))


def with_own(values: Sequence[float], own: float) -> tuple[float, ...]:
    """Return a family's values, ascending, with the one at hand in place of those within a tenth of it."""
    return tuple(sorted([*(value for value in values if abs(value - own) > 0.1 * own), own]))


def double_pendulum_panels(impacts: Impacts) -> dict[str, Panel]:
    """Return the families that a double pendulum's impact belongs to (Zhang 2020, figs. 2.28-2.30), simulated too."""
    chain, surface = impacts.chain, impacts.surface
    own = chain.masses[0] / chain.masses[1]
    ratios = np.geomspace(min(1.0, 0.5 * own), max(1e4, min(2.0 * own, 1e12)), PLACES)
    energetic = ratios[:: PLACES // (SIMULATED - 1)]
    simulated = {"energetic": energetic, "compliant": np.sqrt(energetic[1:] * energetic[:-1])[::2]}

    def case(ratio: float) -> tuple[Chain, Surface]:
        return weighted(chain, ratio), surface

    curves = tuple(pendulum_curve(f"rod {k + 1}", final_rate(k), case, ratios, simulated) for k in (0, 1))
    after = impacts.strikes[impacts.law].contact.rates_after
    rates = Panel(
        RATIO,
        Axis("rate after the impact", "rad/s"),
        curves,
        family="rate of",
        marks=tuple(Mark(own, -rate) for rate in after),
        levels=(Level(-chain.rates[0], "rod 1 before the impact"),),
    )
    return {"rates over mass ratio": rates, "heavy rod": heavy_rod_panel()}
