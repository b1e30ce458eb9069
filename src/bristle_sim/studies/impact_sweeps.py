"""Families of a radial rod's impacts: closed forms over a parameter, and simulated impacts on them.

The curves are the dissertation's formulas; the points go through the pymunk scene, one strike each, with the contact law
they are named after. The rod stands for the bristle on its hub and, with a hub of no radius, for Stronge's single pendulum.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bristle_sim.parameters import Bristle, Contact, Hub, Strike, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.curves import Axis, Curve, Level, Mark, Panel, curve_of
from bristle_sim.studies.whole_pass import contact_quantities
from bristle_sim.theory.monofilament import MonofilamentImpact, monofilament_impact

__all__ = [
    "AXES",
    "OPERATING_POINT",
    "TOTAL",
    "Case",
    "Sweep",
    "struck",
    "sweep_panel",
]

Array = NDArray[np.float64]

GRID = 401
"""Places on a curve."""

ENERGETIC, COMPLIANT = 6, 5
"""Simulated impacts on a curve by law: at ends and steps, and between them."""

NEAREST = 0.9
"""Share of the stiction friction up to which impacts are simulated where p_fy grows without bound; curves end at 0.9999 of it."""

TOTAL = "total_compressive_work"


@dataclass(frozen=True, slots=True)
class Case:
    """One strike of a radial rod; SI and rad, the dissertation's operating point by default.

    The rod stands for the bristle on its hub and, with a hub of no radius, for Stronge's single pendulum.
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

    @classmethod
    def of(cls, rod: Chain, surface: Surface) -> Case:
        """Return the case of a chain of one rod; one without a hub gets a hub of no radius that turns at 1 rad/s."""
        on_hub = rod.hub_radius > 0.0 and rod.hub_speed > 0.0
        speed = rod.hub_speed if on_hub else 1.0
        return cls(
            rod.masses[0],
            surface.friction,
            surface.restitution_friction,
            surface.restitution,
            -rod.angles[0],
            rod.lengths[0],
            rod.hub_radius if on_hub else 0.0,
            speed,
            rod.rates[0] / speed,
        )

    @property
    def chain(self) -> Chain:
        """What strikes."""
        rate = self.speed_ratio * self.hub_speed
        angle = -self.impact_angle
        return Chain((self.mass,), (self.length,), (angle,), (rate,), self.hub_radius, self.hub_speed, angle)

    @property
    def surface(self) -> Surface:
        """What is struck."""
        return Surface(self.friction, self.restitution_friction, self.restitution)


OPERATING_POINT = Case()


@dataclass(frozen=True, slots=True)
class Sweep:
    """A family of strikes: ``along`` varies on a curve from ``low`` to ``high``, ``family`` from curve to curve.

    Attributes:
        along, family: fields of Case.
        values: of the family.
        until_stiction: the curve ends, instead of at ``high``, where the friction that varies reaches tan gamma.
    """

    along: str
    low: float
    high: float
    family: str
    values: tuple[float, ...]
    until_stiction: bool = False
    base: Case = OPERATING_POINT

    def cases(self) -> list[Case]:
        """The curve's fixed part, one for each value of the family."""
        return [dataclasses.replace(self.base, **{self.family: value}) for value in self.values]

    def ends(self, case: Case) -> tuple[float, float, float]:
        """Where curve and simulated impacts begin, where those impacts end, and where the curve ends."""
        if not self.until_stiction:
            return self.low, self.high, self.high
        stiction = math.tan(case.impact_angle)
        return self.low, min(self.high, NEAREST * stiction), min(self.high, 0.9999 * stiction)


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
    "normal_final_impulse": Axis("normal final impulse", "mN·s", 1e3),
    "normal_compressive_work": Axis("normal compressive work", "mJ", 1e3),
    "tangential_compressive_work": Axis("tangential compressive work", "mJ", 1e3),
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


def sweep_panel(quantity: str, sweep: Sweep) -> Panel:
    """Return a quantity over a sweep: closed form, simulated impacts, the operating point and where stiction begins."""
    curves = tuple(_curve(quantity, sweep, case) for case in sweep.cases())
    own = getattr(OPERATING_POINT, sweep.along)
    at = OPERATING_POINT.friction if own is None else own
    mark = Mark(at, float(_formula(quantity, OPERATING_POINT, sweep.along)(np.array([at]))[0]))
    shows_own = sweep.base == OPERATING_POINT
    unbounded = sweep.until_stiction and quantity == "normal_final_impulse"
    return Panel(
        AXES[sweep.along],
        AXES[quantity],
        curves,
        family=SYMBOLS[sweep.family],
        marks=(mark,) if shows_own else (),
        levels=_stiction(sweep),
        top=_top(curves) if unbounded else None,
    )


@functools.cache
def struck(case: Case, law: str) -> dict[str, float | None]:
    """Return quantities of a strike through the scene; empty for a contact that comes to no end."""
    try:
        found = contact_quantities(strike(case.chain, case.surface, Contact(law), Settings()).contact)
    except ValueError:
        return {}
    normal, tangential = found["normal_compressive_work"], found["tangential_compressive_work"]
    total = None if normal is None or tangential is None else normal + tangential
    return found | {TOTAL: total}


def _curve(quantity: str, sweep: Sweep, case: Case) -> Curve:
    low, simulated, high = sweep.ends(case)
    points: dict[str, tuple[list[float], list[float]]] = {}
    for law, number in (("energetic", ENERGETIC), ("compliant", COMPLIANT)):
        for at in _places(low, simulated, number, between=law == "compliant"):
            here = dataclasses.replace(case, **{sweep.along: at})
            value = struck(here, law).get(quantity)
            if value is not None:
                places, values = points.setdefault(law, ([], []))
                places.append(at)
                values.append(value)
    return curve_of(_name(sweep, case), _formula(quantity, case, sweep.along), _grid(low, high, sweep), points)


def _places(low: float, high: float, number: int, *, between: bool) -> Sequence[float]:
    """Equally spaced; ``between`` keeps to the middles of as many parts."""
    if not between:
        return [float(each) for each in np.linspace(low, high, number)]
    step = (high - low) / number
    return [low + (i + 0.5) * step for i in range(number)]


def _grid(low: float, high: float, sweep: Sweep) -> Array:
    """Closer together at the end where a curve grows without bound."""
    if sweep.until_stiction:
        return np.asarray(high - (high - low) * np.linspace(1.0, 0.0, GRID) ** 3)
    return np.linspace(low, high, GRID)


def _formula(quantity: str, case: Case, along: str) -> Callable[[Array], Array]:
    """The closed form over one field of the case."""

    def value(x: Array) -> Array:
        given = {each.name: getattr(case, each.name) for each in dataclasses.fields(case)} | {along: x}
        found = monofilament_impact(**given)
        return np.broadcast_to(_read(quantity, found), np.shape(x))

    return value


def _read(quantity: str, found: MonofilamentImpact) -> Array:
    if quantity == TOTAL:
        return np.asarray(found.normal_compressive_work + found.tangential_compressive_work)
    return np.asarray(getattr(found, quantity))


def _name(sweep: Sweep, case: Case) -> str:
    axis = AXES[sweep.family]
    value = getattr(case, sweep.family) * axis.factor
    unit = {"1": "", "°": "°"}.get(axis.unit, f" {axis.unit}")
    return f"{round(value, 6):g}{unit}"


def _stiction(sweep: Sweep) -> tuple[Level, ...]:
    """Upright lines at tan gamma, where a friction along the curves reaches it."""
    if not sweep.until_stiction:
        return ()
    angles = [
        angle for angle in dict.fromkeys(case.impact_angle for case in sweep.cases()) if math.tan(angle) <= sweep.high
    ]
    label = f"stiction, {SYMBOLS[sweep.along]} = tan $\\gamma$"
    return tuple(Level(math.tan(angle), label, upright=True) for angle in angles)


def _top(curves: Sequence[Curve]) -> float:
    """Twice what the curves begin with: the rest leads to infinity."""
    return 2.2 * max(float(curve.theory[0]) for curve in curves)
