"""Figures 2.7-2.26: impulses, works and rebound of the radial bristle and of Stronge's single
pendulum.

The curves are the dissertation's formulas (Zhang 2020, chapter 2). Each point is one strike in the
pymunk scene. The points are named after their contact law.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.dissertation.operating_point import OPERATING_POINT, operating_strike
from bristle_sim.dissertation.redrawn import Axis, Curve, Level, Mark, Panel, Redrawn, curve_of
from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_measures import contact_quantities
from bristle_sim.trajectory import ContactRecord

Impact = Callable[[float], tuple[Chain, Surface]]
"""Function that returns the rods and the surface of the impact at a horizontal coordinate x."""

GRID = 401  # points on a curve

# Numbers of impacts on a curve, simulated by the energetic and by the compliant contact law. The
# former extend from end to end of the curve, the latter lie between its ends.
ENERGETIC = 6
COMPLIANT = 5

NEAREST = 0.9
"""Largest friction coefficient of simulated impacts, as a fraction of tan(gamma).

gamma is the impact angle. At tan(gamma) stiction begins; towards it the normal final impulse grows
without bound. The curves end at 0.9999 tan(gamma)."""

FINAL = "normal_final_impulse"
NORMAL = "normal_compressive_work"
TANGENTIAL = "tangential_compressive_work"
TOTAL = "total_compressive_work"


@dataclass(frozen=True, slots=True)
class Sweep:
    """A family of curves: a quantity of the strike over one argument, for values of another one.

    All other arguments are those of the operating point.

    Attributes:
        words: second half of the figure's title, which follows the name of the quantity.
        along: argument that varies along a curve, from ``low`` to ``high``.
        family: argument that varies from curve to curve and takes the values ``values``.
        until_stiction: whether a curve ends just before its friction reaches tan(gamma), where
            gamma is the impact angle. At this friction the tip sticks.
        has_hub: whether the hub has the radius of the operating point. Otherwise its radius is 0.
    """

    words: str
    along: str
    low: float
    high: float
    family: str
    values: tuple[float, ...]
    until_stiction: bool = False
    has_hub: bool = True


AXES = {
    "friction": Axis("friction coefficient $\\mu$"),
    "restitution_friction": Axis("friction coefficient in restitution $\\mu_2$"),
    "length": Axis("bristle length $L$", "mm", 1e3),
    "hub_radius": Axis("hub radius", "mm", 1e3),
    "hub_speed": Axis("hub speed", "rad/s"),
    "speed_ratio": Axis("speed ratio $R$"),
    "impact_angle": Axis("impact angle $\\gamma$", "°", math.degrees(1.0)),
    "restitution": Axis("restitution $e^*$"),
    "normal_compressive_impulse": Axis("normal compressive impulse", "mN·s", 1e3),
    "tangential_compressive_impulse": Axis("tangential compressive impulse", "mN·s", 1e3),
    FINAL: Axis("normal final impulse", "mN·s", 1e3),
    NORMAL: Axis("normal compressive work", "mJ", 1e3),
    TANGENTIAL: Axis("tangential compressive work", "mJ", 1e3),
    TOTAL: Axis("total compressive work", "mJ", 1e3),
    "rebound_ratio": Axis("rate after / rate before"),
}

SYMBOLS = {
    "friction": "$\\mu$",
    "restitution_friction": "$\\mu_2$",
    "hub_radius": "$r_h$",
    "hub_speed": "$\\omega$",
    "impact_angle": "$\\gamma$",
    "restitution": "$e^*$",
}


def _angles(*degrees: float) -> tuple[float, ...]:
    return tuple(math.radians(each) for each in degrees)


FRICTION = Sweep(
    "over friction", "friction", 0.0, 1.0, "impact_angle", _angles(10.0, 15.0, 23.4, 30.0)
)
LENGTH = Sweep(
    "over the bristle's length", "length", 0.01, 0.05, "hub_radius", (0.02, 0.0275, 0.035)
)
RATIO = Sweep("over the speed ratio", "speed_ratio", 1.0, 5.0, "hub_speed", (200.0, 261.8, 320.0))
LATER_FRICTION = Sweep(
    "over friction in restitution",
    "restitution_friction",
    0.0,
    1.0,
    "friction",
    (0.1, 0.31, 0.6),
    True,
)
EARLIER_FRICTION = Sweep(
    "over friction in compression",
    "friction",
    0.0,
    1.0,
    "restitution_friction",
    (0.0, 0.2, 0.31, 0.4),
)
COMMON_FRICTION = Sweep(
    "over friction, by impact angle",
    "friction",
    0.0,
    1.0,
    "impact_angle",
    _angles(15.0, 23.4, 30.0, 40.0),
    True,
)
RESTITUTION = Sweep(
    "over friction, by restitution",
    "friction",
    0.0,
    1.0,
    "restitution",
    (0.2, 0.42, 0.6, 0.8),
    True,
)
REBOUND = Sweep(
    "over the impact angle",
    "impact_angle",
    math.radians(2.0),
    0.5 * math.pi,
    "friction",
    (0.0, 0.1, 0.31, 0.5, 1.0),
)
NO_HUB = dataclasses.replace(REBOUND, words="of Stronge's single pendulum", has_hub=False)

FIGURES: dict[str, tuple[str, Sweep]] = {
    "2.7": ("normal_compressive_impulse", FRICTION),
    "2.8": ("normal_compressive_impulse", LENGTH),
    "2.9": ("normal_compressive_impulse", RATIO),
    "2.10": (NORMAL, FRICTION),
    "2.11": (NORMAL, LENGTH),
    "2.12": (NORMAL, RATIO),
    "2.13": (FINAL, LATER_FRICTION),
    "2.14": (FINAL, EARLIER_FRICTION),
    "2.15": ("tangential_compressive_impulse", FRICTION),
    "2.16": (TANGENTIAL, FRICTION),
    "2.17": (TANGENTIAL, LENGTH),
    "2.18": (TANGENTIAL, RATIO),
    "2.19": (TOTAL, FRICTION),
    "2.20": (TOTAL, LENGTH),
    "2.21": (TOTAL, RATIO),
    "2.22": (FINAL, COMMON_FRICTION),
    "2.23": (FINAL, RESTITUTION),
    "2.24": ("rebound_ratio", REBOUND),
    "2.26": ("rebound_ratio", NO_HUB),
}
"""Quantity and family of curves, by the number of the figure."""

NOTES = {
    "2.13": "grows without bound towards tan $\\gamma$ = 0.433 (dashed), from where on the tip does not rebound",
    "2.19": "the same whatever friction and impact angle: the energy of the effective mass m/3",
    "2.22": "each curve grows without bound towards tan $\\gamma$ (dashed)",
    "2.23": "grows without bound towards tan $\\gamma$ (dashed)",
    "2.24": "flat where the tip stays at rest: $\\mu$ ≥ tan $\\gamma$",
    "2.26": "the bristle on a hub of no radius, $r_h$ = 0",
}


def impact_figure(number: str) -> Redrawn:
    """Return the data of one of the figures 2.7 to 2.26.

    Curves are closed forms, and points are simulated impacts. The operating point is marked, and
    dashed lines mark the friction at which the tip sticks.
    """
    quantity, sweep = FIGURES[number]
    hub = {} if sweep.has_hub else {"hub_radius": 0.0}
    cases = [{**OPERATING_POINT, **hub, sweep.family: value} for value in sweep.values]
    curves = tuple(_curve(quantity, sweep, case) for case in cases)
    # The friction in restitution is that in compression, unless it has a value of its own.
    at = OPERATING_POINT[sweep.along] or OPERATING_POINT["friction"]
    reached = closed_form(quantity, OPERATING_POINT, sweep.along)(np.asarray(at))
    panel = Panel(
        AXES[sweep.along],
        AXES[quantity],
        curves,
        family=SYMBOLS[sweep.family],
        marks=(Mark(at, float(reached)),) if sweep.has_hub else (),
    )
    if sweep.until_stiction:
        tangents = dict.fromkeys(math.tan(case["impact_angle"]) for case in cases)
        label = f"stiction, {SYMBOLS[sweep.along]} = tan $\\gamma$"
        panel = dataclasses.replace(
            panel,
            levels=tuple(Level(each, label, upright=True) for each in tangents),
            top=2.2 * max(float(curve.theory[0]) for curve in curves),
        )
    title = f"{quantity.replace('_', ' ')} {sweep.words}"
    return Redrawn(number, title, (panel,), NOTES.get(number, ""))


def _curve(quantity: str, sweep: Sweep, case: Mapping[str, Any]) -> Curve:
    """Return one curve of a family, with points of simulated impacts.

    Args:
        quantity: name of the quantity.
        sweep: the family of curves.
        case: values of the strike's arguments on this curve.

    The grid is denser where the quantity grows without bound. The points of the energetic law
    extend from end to end of the curve; those of the compliant law lie between its ends.
    """
    low = sweep.low
    high = sweep.high
    simulated = sweep.high
    grid = np.linspace(low, high, GRID)
    if sweep.until_stiction:
        stiction = math.tan(case["impact_angle"])
        simulated = NEAREST * stiction
        high = 0.9999 * stiction
        grid = np.asarray(high - (high - low) * np.linspace(1.0, 0.0, GRID) ** 3)
    places = {
        "energetic": np.linspace(low, simulated, ENERGETIC),
        "compliant": np.linspace(low, simulated, 2 * COMPLIANT + 1)[1::2],
    }

    def impact(x: float) -> tuple[Chain, Surface]:
        """Return the rod and the surface of the strike with the value ``x`` of the varied
        argument.
        """
        given = {**case, sweep.along: x}
        rod = Chain(
            (given["mass"],),
            (given["length"],),
            (-given["impact_angle"],),
            (given["speed_ratio"] * given["hub_speed"],),
            hub_radius=given["hub_radius"],
            hub_speed=given["hub_speed"],
            hub_angle=-given["impact_angle"],
        )
        return rod, Surface(given["friction"], given["restitution_friction"], given["restitution"])

    def read(contact: ContactRecord) -> Any:
        return _value(quantity, contact_quantities(contact).get)

    name = AXES[sweep.family].shown(case[sweep.family])
    return impact_curve(name, closed_form(quantity, case, sweep.along), grid, impact, read, places)


def _value(quantity: str, get: Callable[[str], Any]) -> Any:
    """Return the value of a quantity by its name.

    The total work is the sum of the normal and the tangential work. ``get`` is a function that
    returns any other quantity by its name.
    """
    return get(NORMAL) + get(TANGENTIAL) if quantity == TOTAL else get(quantity)


def closed_form(quantity: str, case: Mapping[str, Any], along: str) -> Callable[[Array], Array]:
    """Return the closed form of a quantity as a function of one argument of the strike.

    ``along`` names this argument; ``case`` holds the values of all arguments.
    """

    def value(x: Array) -> Array:
        found = operating_strike(**{**case, along: x})
        return np.broadcast_to(_value(quantity, partial(getattr, found)), np.shape(x))

    return value


def impact_curve(
    name: str,
    formula: Callable[[Array], ArrayLike],
    x: Array,
    impact: Impact,
    read: Callable[[ContactRecord], float],
    places: Mapping[str, Array],
) -> Curve:
    """Return the curve of a closed form, with points of impacts simulated by several contact laws.

    Args:
        name: label of the curve.
        formula: the closed form, a function of the horizontal coordinate x.
        x: values of x at which the curve is computed.
        impact: function that returns the rods and the surface of the impact at x.
        read: function that returns the quantity of a simulated contact.
        places: values of x at which impacts are simulated, by contact law.
    """
    points = {
        law: (at, [read(_struck(*impact(each), law)) for each in at.tolist()])
        for law, at in places.items()
    }
    return curve_of(name, formula, x, points)


@cache
def _struck(chain: Chain, surface: Surface, law: str) -> ContactRecord:
    """Simulate a strike by the contact law ``law``, and return the record of the contact."""
    return strike(chain, surface, Contact(law), Settings()).contact
