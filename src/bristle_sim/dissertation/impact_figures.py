"""Figures 2.7-2.26: impulses, works and rebound of the radial bristle and of Stronge's single
pendulum.

The curves are the dissertation's formulas (Zhang 2020, chapter 2). Each point is one strike in the
pymunk scene, by the contact law that gives the points their name.
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
from bristle_sim.dissertation.redrawn import Axis, Curve, Level, Mark, Panel, Redrawn, curve_of
from bristle_sim.parameters import Bristle, Contact, Hub, Strike, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_measures import contact_quantities
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.trajectory import ContactRecord

Impact = Callable[[float], tuple[Chain, Surface]]
"""Function that returns the rods and the surface of an impact for a value of x."""

GRID = 401  # points on a curve

# Number of simulated impacts on a curve: energetic ones from end to end, compliant ones in between.
ENERGETIC = 6
COMPLIANT = 5

NEAREST = 0.9
"""Largest friction of simulated impacts, as a fraction of the stiction friction.

Towards the stiction friction p_fy has no bound; the curves end at 0.9999 of it."""

FINAL = "normal_final_impulse"
NORMAL = "normal_compressive_work"
TANGENTIAL = "tangential_compressive_work"
TOTAL = "total_compressive_work"


@dataclass(frozen=True, slots=True)
class Case:
    """Arguments of ``monofilament_impact`` for one strike, in SI units and rad.

    The defaults are those of the operating point.
    """

    mass: float = Bristle().mass
    friction: float = Surface().friction
    restitution_friction: float | None = None
    restitution: float = Surface().restitution
    impact_angle: float = math.radians(Strike().impact_angle_deg)
    length: float = Bristle().length
    hub_radius: float = Hub().radius
    hub_speed: float = Hub().speed
    speed_ratio: float = Strike().speed_ratio

    def impact(self) -> tuple[Chain, Surface]:
        """Return the rod that strikes and the surface."""
        angle = -self.impact_angle
        rate = self.speed_ratio * self.hub_speed
        rod = Chain(
            (self.mass,), (self.length,), (angle,), (rate,), self.hub_radius, self.hub_speed, angle
        )
        return rod, Surface(self.friction, self.restitution_friction, self.restitution)


OPERATING_POINT = Case()


@dataclass(frozen=True, slots=True)
class Sweep:
    """A family of curves of strikes.

    The field ``along`` of ``Case`` varies on a curve, from ``low`` to ``high``. The field
    ``family`` varies from curve to curve. With ``until_stiction`` a curve ends where its friction
    reaches tan(gamma), if this is below ``high``.
    """

    along: str
    low: float
    high: float
    family: str
    values: tuple[float, ...]
    until_stiction: bool = False
    base: Case = OPERATING_POINT

    def cases(self) -> list[Case]:
        """Return the fixed parameters of each curve of the family."""
        return [dataclasses.replace(self.base, **{self.family: value}) for value in self.values]


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


FRICTION = Sweep("friction", 0.0, 1.0, "impact_angle", _angles(10.0, 15.0, 23.4, 30.0))
LENGTH = Sweep("length", 0.01, 0.05, "hub_radius", (0.02, 0.0275, 0.035))
RATIO = Sweep("speed_ratio", 1.0, 5.0, "hub_speed", (200.0, 261.8, 320.0))
LATER_FRICTION = Sweep(
    "restitution_friction", 0.0, 1.0, "friction", (0.1, 0.31, 0.6), until_stiction=True
)
EARLIER_FRICTION = Sweep("friction", 0.0, 1.0, "restitution_friction", (0.0, 0.2, 0.31, 0.4))
COMMON_FRICTION = Sweep("friction", 0.0, 1.0, "impact_angle", _angles(15.0, 23.4, 30.0, 40.0), True)
RESTITUTION = Sweep("friction", 0.0, 1.0, "restitution", (0.2, 0.42, 0.6, 0.8), True)
REBOUND = Sweep(
    "impact_angle", math.radians(2.0), 0.5 * math.pi, "friction", (0.0, 0.1, 0.31, 0.5, 1.0)
)

FIGURES: dict[str, tuple[str, Sweep, str]] = {
    "2.7": ("normal_compressive_impulse", FRICTION, "over friction"),
    "2.8": ("normal_compressive_impulse", LENGTH, "over the bristle's length"),
    "2.9": ("normal_compressive_impulse", RATIO, "over the speed ratio"),
    "2.10": (NORMAL, FRICTION, "over friction"),
    "2.11": (NORMAL, LENGTH, "over the bristle's length"),
    "2.12": (NORMAL, RATIO, "over the speed ratio"),
    "2.13": (FINAL, LATER_FRICTION, "over friction in restitution"),
    "2.14": (FINAL, EARLIER_FRICTION, "over friction in compression"),
    "2.15": ("tangential_compressive_impulse", FRICTION, "over friction"),
    "2.16": (TANGENTIAL, FRICTION, "over friction"),
    "2.17": (TANGENTIAL, LENGTH, "over the bristle's length"),
    "2.18": (TANGENTIAL, RATIO, "over the speed ratio"),
    "2.19": (TOTAL, FRICTION, "over friction"),
    "2.20": (TOTAL, LENGTH, "over the bristle's length"),
    "2.21": (TOTAL, RATIO, "over the speed ratio"),
    "2.22": (FINAL, COMMON_FRICTION, "over friction, by impact angle"),
    "2.23": (FINAL, RESTITUTION, "over friction, by restitution"),
    "2.24": ("rebound_ratio", REBOUND, "over the impact angle"),
}
"""Quantity, sweep and end of the title, by figure; a title begins with the quantity."""

NOTES = {
    "2.13": "grows without bound towards tan $\\gamma$ = 0.433 (dashed), from where on the tip does not rebound",
    "2.19": "the same whatever friction and impact angle: the energy of the effective mass m/3",
    "2.22": "each curve grows without bound towards tan $\\gamma$ (dashed)",
    "2.23": "grows without bound towards tan $\\gamma$ (dashed)",
    "2.24": "flat where the tip stays at rest: $\\mu$ ≥ tan $\\gamma$",
}


def impact_figure(number: str) -> Redrawn:
    """Return the data of one of figures 2.7 to 2.24."""
    quantity, sweep, title = FIGURES[number]
    title = f"{quantity.replace('_', ' ')} {title}"
    return Redrawn(number, title, (_panel(quantity, sweep),), NOTES.get(number, ""))


def single_pendulum_figure() -> Redrawn:
    """Return figure 2.26: rebound ratio of the bristle on a hub of zero radius."""
    panel = _panel(
        "rebound_ratio",
        dataclasses.replace(REBOUND, base=dataclasses.replace(OPERATING_POINT, hub_radius=0.0)),
    )
    note = "the bristle on a hub of no radius, $r_h$ = 0"
    return Redrawn("2.26", "rebound ratio of Stronge's single pendulum", (panel,), note)


def _panel(quantity: str, sweep: Sweep) -> Panel:
    """Return the panel of a quantity over a sweep.

    It has the closed form, simulated impacts, the operating point, and a line where stiction
    begins.
    """
    curves = tuple(_curve(quantity, sweep, case) for case in sweep.cases())
    own = getattr(OPERATING_POINT, sweep.along)
    at = OPERATING_POINT.friction if own is None else own
    mark = Mark(at, float(closed_form(quantity, OPERATING_POINT, sweep.along)(np.array([at]))[0]))
    panel = Panel(AXES[sweep.along], AXES[quantity], curves, SYMBOLS[sweep.family])
    if sweep.base == OPERATING_POINT:
        panel = dataclasses.replace(panel, marks=(mark,))
    if not sweep.until_stiction:
        return panel
    tangents = dict.fromkeys(math.tan(case.impact_angle) for case in sweep.cases())
    label = f"stiction, {SYMBOLS[sweep.along]} = tan $\\gamma$"
    levels = tuple(Level(each, label, upright=True) for each in tangents if each <= sweep.high)
    return dataclasses.replace(
        panel, levels=levels, top=2.2 * max(float(curve.theory[0]) for curve in curves)
    )


def _curve(quantity: str, sweep: Sweep, case: Case) -> Curve:
    """Return one curve of a sweep with points of simulated impacts.

    The grid gets denser where the quantity grows without bound. Energetic impacts lie from end to
    end, compliant ones at the middles of equal parts.
    """
    low = sweep.low
    high = sweep.high
    simulated = sweep.high
    grid = np.linspace(low, high, GRID)
    if sweep.until_stiction:
        stiction = math.tan(case.impact_angle)
        simulated = min(high, NEAREST * stiction)
        high = min(high, 0.9999 * stiction)
        grid = np.asarray(high - (high - low) * np.linspace(1.0, 0.0, GRID) ** 3)
    middles = low + (np.arange(COMPLIANT) + 0.5) * ((simulated - low) / COMPLIANT)
    places = {"energetic": np.linspace(low, simulated, ENERGETIC), "compliant": np.asarray(middles)}

    def impact(x: float) -> tuple[Chain, Surface]:
        return dataclasses.replace(case, **{sweep.along: x}).impact()

    def read(contact: ContactRecord) -> Any:
        return _value(quantity, contact_quantities(contact).get)

    axis = AXES[sweep.family]
    unit = {"1": "", "°": "°"}.get(axis.unit, f" {axis.unit}")
    name = f"{round(getattr(case, sweep.family) * axis.factor, 6):g}{unit}"
    return impact_curve(name, closed_form(quantity, case, sweep.along), grid, impact, read, places)


def _value(quantity: str, get: Callable[[str], Any]) -> Any:
    """Return a quantity by name; None if it is unknown.

    The total work is the sum of the normal and the tangential work.
    """
    values = [get(name) for name in ((NORMAL, TANGENTIAL) if quantity == TOTAL else (quantity,))]
    return None if any(value is None for value in values) else sum(values)


def closed_form(quantity: str, case: Case, along: str) -> Callable[[Array], Array]:
    """Return a quantity by the closed form, as a function of one field of the case."""

    def value(x: Array) -> Array:
        found = monofilament_impact(**dataclasses.asdict(case) | {along: x})
        return np.broadcast_to(_value(quantity, partial(getattr, found)), np.shape(x))

    return value


def impact_curve(
    name: str,
    formula: Callable[[Array], ArrayLike],
    x: Array,
    impact: Impact,
    read: Callable[[ContactRecord], float | None],
    places: Mapping[str, Array],
) -> Curve:
    """Return a closed form over x, with points from simulated impacts of each contact law.

    Args:
        name: label of the curve.
        formula: closed form as a function of x.
        x: grid of the curve.
        impact: function that returns the rods and the surface for a value of x.
        read: function that reads the quantity from a contact.
        places: values of x of the simulated impacts, by contact law.

    An impact that does not end, or that lacks the quantity, is left out.
    """
    points: dict[str, Any] = {}
    for law, at in places.items():
        records = ((each, _struck(*impact(each), law)) for each in at.tolist())
        found = [
            (each, value)
            for each, record in records
            if record and (value := read(record)) is not None
        ]
        points[law] = tuple(zip(*found, strict=True))
    return curve_of(name, formula, x, points)


@cache
def _struck(chain: Chain, surface: Surface, law: str) -> ContactRecord | None:
    """Return the contact of a strike in the scene; None if the contact does not end."""
    try:
        return strike(chain, surface, Contact(law), Settings()).contact
    except ValueError:
        return None
