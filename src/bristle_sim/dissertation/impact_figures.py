"""Figures 2.7-2.30: impulses, works and rebound of the radial bristle and of Stronge's pendulums (Zhang 2020, secs. 2.3, 2.4)."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from bristle_sim.dissertation.redrawn import Redrawn
from bristle_sim.parameters import DoublePendulum, Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.studies.curves import Axis, Level, Panel
from bristle_sim.studies.double_pendulum_families import Impact, heavy_rod_panel, pendulum_curve, weighted
from bristle_sim.studies.impacts import double_chain
from bristle_sim.studies.rod_families import OPERATING_POINT, TOTAL, Sweep, sweep_panel

FRICTION = Sweep("friction", 0.0, 1.0, "impact_angle", tuple(math.radians(each) for each in (10.0, 15.0, 23.4, 30.0)))
LENGTH = Sweep("length", 0.01, 0.05, "hub_radius", (0.02, 0.0275, 0.035))
RATIO = Sweep("speed_ratio", 1.0, 5.0, "hub_speed", (200.0, 261.8, 320.0))
LATER_FRICTION = Sweep("restitution_friction", 0.0, 1.0, "friction", (0.1, 0.31, 0.6), until_stiction=True)
EARLIER_FRICTION = Sweep("friction", 0.0, 1.0, "restitution_friction", (0.0, 0.2, 0.31, 0.4))
COMMON_FRICTION = Sweep(
    "friction", 0.0, 1.0, "impact_angle", tuple(math.radians(each) for each in (15.0, 23.4, 30.0, 40.0)), True
)
RESTITUTION = Sweep("friction", 0.0, 1.0, "restitution", (0.2, 0.42, 0.6, 0.8), True)
REBOUND = Sweep("impact_angle", math.radians(2.0), 0.5 * math.pi, "friction", (0.0, 0.1, 0.31, 0.5, 1.0))

_FINAL, _NORMAL, _TANGENTIAL = "normal_final_impulse", "normal_compressive_work", "tangential_compressive_work"

FIGURES: dict[str, tuple[str, Sweep, str]] = {
    "2.7": ("normal_compressive_impulse", FRICTION, "over friction"),
    "2.8": ("normal_compressive_impulse", LENGTH, "over the bristle's length"),
    "2.9": ("normal_compressive_impulse", RATIO, "over the speed ratio"),
    "2.10": (_NORMAL, FRICTION, "over friction"),
    "2.11": (_NORMAL, LENGTH, "over the bristle's length"),
    "2.12": (_NORMAL, RATIO, "over the speed ratio"),
    "2.13": (_FINAL, LATER_FRICTION, "over friction in restitution"),
    "2.14": (_FINAL, EARLIER_FRICTION, "over friction in compression"),
    "2.15": ("tangential_compressive_impulse", FRICTION, "over friction"),
    "2.16": (_TANGENTIAL, FRICTION, "over friction"),
    "2.17": (_TANGENTIAL, LENGTH, "over the bristle's length"),
    "2.18": (_TANGENTIAL, RATIO, "over the speed ratio"),
    "2.19": (TOTAL, FRICTION, "over friction"),
    "2.20": (TOTAL, LENGTH, "over the bristle's length"),
    "2.21": (TOTAL, RATIO, "over the speed ratio"),
    "2.22": (_FINAL, COMMON_FRICTION, "over friction, by impact angle"),
    "2.23": (_FINAL, RESTITUTION, "over friction, by restitution"),
    "2.24": ("rebound_ratio", REBOUND, "over the impact angle"),
}
"""Quantity, sweep, and the end of the title, which begins with the quantity."""

NOTES = {
    "2.13": "grows without bound towards tan $\\gamma$ = 0.433 (dashed), from where on the tip does not rebound",
    "2.19": "the same whatever friction and impact angle: the energy of the effective mass m/3",
    "2.22": "each curve grows without bound towards tan $\\gamma$ (dashed)",
    "2.23": "grows without bound towards tan $\\gamma$ (dashed)",
    "2.24": "flat where the tip stays at rest: $\\mu$ ≥ tan $\\gamma$",
}

RATES = {"2.28": (2, "rod BC"), "2.29": (1, "rod OB")}


def impact_figure(number: str) -> Redrawn:
    """Return one of figures 2.7-2.24."""
    quantity, sweep, title = FIGURES[number]
    title = f"{quantity.replace('_', ' ')} {title}"
    return Redrawn(number, title, (sweep_panel(quantity, sweep),), NOTES.get(number, ""))


def single_pendulum_figure() -> Redrawn:
    """Return figure 2.26: the bristle's rebound ratio with a hub of no radius."""
    base = dataclasses.replace(OPERATING_POINT, hub_radius=0.0)
    panel = sweep_panel("rebound_ratio", dataclasses.replace(REBOUND, base=base))
    return Redrawn(
        "2.26", "rebound ratio of Stronge's single pendulum", (panel,), "the bristle on a hub of no radius, $r_h$ = 0"
    )


def double_pendulum_figure(number: str) -> Redrawn:
    """Return figures 2.28 and 2.29: rates after impact over the mass ratio, for frictions that stick and reverse."""
    rod, name = RATES[number]
    pendulum = DoublePendulum()
    chain = double_chain(dataclasses.replace(pendulum, mass_ratio=1.0))
    curves = tuple(
        pendulum_curve(
            f"{mu:g}", f"final_rate_{rod}", _over_mass_ratio(chain, Surface(mu, None, 0.5)), _RATIOS, _SIMULATED
        )
        for mu in (0.3, 0.5, 0.7)
    )
    levels = (Level(pendulum.rate_1, "before the impact"),) if rod == 1 else ()
    axis = Axis(f"rate after impact, {name}", "rad/s")
    return Redrawn(
        number,
        f"double pendulum: rate of {name}, over the mass ratio",
        (Panel(Axis("mass ratio $n$", log=True), axis, curves, family="$\\mu$", levels=levels),),
        "slip stops and reverses for $\\mu$ = 0.3 and 0.5; with 0.7 the tip sticks",
    )


def _over_mass_ratio(chain: Chain, surface: Surface) -> Impact:
    return lambda ratio: (weighted(chain, ratio), surface)


def heavy_rod_figure() -> Redrawn:
    """Return figure 2.30: final impulse of the bristle as the second rod of a double pendulum, and the monofilament's."""
    return Redrawn(
        "2.30",
        "final impulse of the modified double pendulum over friction",
        (heavy_rod_panel(),),
        "the heavy rod is 0.027 m long where the hub has 0.0275: half a per cent less impulse",
    )


_RATIOS = np.geomspace(1.0, 1e4, 121)
_SIMULATED = {"energetic": np.geomspace(1.0, 1e4, 5), "compliant": np.geomspace(10**0.5, 10**3.5, 4)}
