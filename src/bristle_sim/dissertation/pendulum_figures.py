"""Figures 2.26-2.30: Stronge's single and double pendulum (Zhang 2020, sec. 2.4)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bristle_sim.dissertation.impact_figures import AXES, OPERATING_POINT, REBOUND, sweep_panel
from bristle_sim.dissertation.redrawn import Redrawn
from bristle_sim.parameters import Bristle, Contact, DoublePendulum, Hub, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.curves import Axis, Curve, Level, Mark, Panel, curve_of
from bristle_sim.studies.impact_measures import IMPULSE, Measure, final_rate
from bristle_sim.studies.impact_sweeps import HEAVY_ROD, HEAVY_ROD_SURFACE, weighted
from bristle_sim.theory.monofilament import normal_final_impulse, tip_speed

__all__ = ["double_pendulum_figure", "heavy_rod_figure", "single_pendulum_figure"]

Array = NDArray[np.float64]

RATIO = Axis("mass ratio $n$", log=True)
FRICTIONS = (0.3, 0.5, 0.7)
LIGHT_RATIOS, HEAVY_RATIO = (1.0, 10.0), 700.0
RATES = {"2.28": (1, "rod BC"), "2.29": (0, "rod OB")}


def single_pendulum_figure() -> Redrawn:
    """Figure 2.26: the bristle's rebound ratio with a hub of no radius."""
    base = dataclasses.replace(OPERATING_POINT, hub_radius=0.0)
    panel = sweep_panel("rebound_ratio", dataclasses.replace(REBOUND, base=base))
    return Redrawn(
        "2.26", "rebound ratio of Stronge's single pendulum", (panel,), "the bristle on a hub of no radius, $r_h$ = 0"
    )


def double_pendulum_figure(number: str) -> Redrawn:
    """Figures 2.28 and 2.29: rates after impact over the mass ratio, for frictions that stick and reverse."""
    rod, name = RATES[number]
    pendulum = DoublePendulum()
    angles = (math.radians(pendulum.angle_1_deg), math.radians(pendulum.angle_2_deg))
    chain = Chain(
        (pendulum.mass, pendulum.mass),
        (pendulum.length, pendulum.length),
        (-angles[0], -angles[1]),
        (-pendulum.rate_1, -pendulum.rate_2),
    )
    measure = final_rate(rod)
    curves = tuple(
        _curve(f"{mu:g}", measure, lambda n, mu=mu: (weighted(chain, n), Surface(mu, None, 0.5)), _RATIOS, _SIMULATED)  # type: ignore[misc]
        for mu in FRICTIONS
    )
    levels = (Level(pendulum.rate_1, "before the impact"),) if rod == 0 else ()
    axis = Axis(f"rate after impact, {name}", "rad/s")
    return Redrawn(
        number,
        f"double pendulum: rate of {name}, over the mass ratio",
        (Panel(RATIO, axis, curves, family="$\\mu$", levels=levels),),
        "slip stops and reverses for $\\mu$ = 0.3 and 0.5; with 0.7 the tip sticks",
    )


def heavy_rod_figure() -> Redrawn:
    """Figure 2.30: final impulse of the bristle as the second rod of a double pendulum, beside the monofilament's."""
    stiction = math.tan(-HEAVY_ROD.angles[1])
    frictions = 0.9999 * stiction * (1.0 - np.linspace(1.0, 0.0, 121) ** 2)
    simulated = {"energetic": np.linspace(0.0, 0.9, 6) * stiction, "compliant": np.linspace(0.09, 0.81, 5) * stiction}
    curves = [
        _curve(f"$n$ = {n:g}", IMPULSE, _over_friction(n), frictions, simulated) for n in (*LIGHT_RATIOS, HEAVY_RATIO)
    ]
    curves.append(curve_of("bristle on its hub", _monofilament, frictions))
    at = HEAVY_ROD_SURFACE.friction
    mark = Mark(at, IMPULSE.formula(*_over_friction(HEAVY_RATIO)(at)))
    return Redrawn(
        "2.30",
        "final impulse of the modified double pendulum over friction",
        (
            Panel(
                AXES["friction"],
                AXES["normal_final_impulse"],
                tuple(curves),
                marks=(mark,),
                levels=(Level(stiction, "stiction, $\\mu$ = tan $\\gamma$", upright=True),),
                top=3.0 * float(curves[-1].theory[0]),
            ),
        ),
        "the heavy rod is 0.027 m long where the hub has 0.0275: half a per cent less impulse",
    )


_RATIOS = np.geomspace(1.0, 1e4, 121)
_SIMULATED = {"energetic": np.geomspace(1.0, 1e4, 5), "compliant": np.geomspace(10**0.5, 10**3.5, 4)}

Case = Callable[[float], tuple[Chain, Surface]]


def _curve(name: str, measure: Measure, case: Case, x: Array, simulated: dict[str, Array]) -> Curve:
    points = {law: (at, [_simulated(measure, case, float(each), law) for each in at]) for law, at in simulated.items()}
    return curve_of(name, lambda grid: [measure.formula(*case(float(each))) for each in grid], x, points)


def _simulated(measure: Measure, case: Case, x: float, law: str) -> float:
    chain, surface = case(x)
    return measure.read(chain, strike(chain, surface, Contact(law), Settings()).contact)


def _over_friction(ratio: float) -> Case:
    return lambda friction: (weighted(HEAVY_ROD, ratio), dataclasses.replace(HEAVY_ROD_SURFACE, friction=friction))


def _monofilament(friction: Array) -> Array:
    """(2.64) of the bristle at the rate of fig. 2.30."""
    hub, bristle = Hub(), Bristle()
    speed = tip_speed(bristle.length, hub.radius, hub.speed, HEAVY_ROD.rates[1] / hub.speed)
    angle, restitution = -HEAVY_ROD.angles[1], HEAVY_ROD_SURFACE.restitution
    return np.asarray(normal_final_impulse(bristle.mass, speed, angle, friction, restitution))
