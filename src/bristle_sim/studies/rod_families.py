"""Families of a radial rod's impacts: closed forms over a parameter, and simulated impacts on them.

The curves are the dissertation's formulas; the points go through the pymunk scene, one strike each, with the contact law
they are named after. The rod stands for the bristle on its hub and, with a hub of no radius, for Stronge's single pendulum.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Bristle, Hub, Strike, Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.studies.curves import Axis, Curve, Level, Mark, Panel, impact_curve
from bristle_sim.studies.impacts import Impacts
from bristle_sim.studies.strike_point import contact_quantities
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.trajectory import ContactRecord

GRID = 401
"""Points on a curve."""

ENERGETIC, COMPLIANT = 6, 5
"""Simulated impacts on a curve by law: at ends and steps, and between them."""

NEAREST = 0.9
"""Fraction of the stiction friction up to which impacts are simulated where p_fy has no bound; curves end at 0.9999 of it."""

FRICTIONS = (0.0, 0.1, 0.3, 0.6, 1.0)
ANGLES = tuple(math.radians(angle) for angle in (15.0, 23.4, 35.0, 50.0, 70.0))
RESTITUTIONS = (0.0, 0.2, 0.42, 0.7, 1.0)
"""Values that distinguish the curves of a scenario's figure, with the value of the scenario's own impact; rad."""

TOTAL = "total_compressive_work"


@dataclass(frozen=True, slots=True)
class Case:
    """One strike of a radial rod; SI and rad, the dissertation's operating point by default."""

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
        radius, speed = (rod.hub_radius, rod.hub_speed) if on_hub else (0.0, 1.0)
        coefficients = (surface.friction, surface.restitution_friction, surface.restitution)
        return cls(rod.masses[0], *coefficients, -rod.angles[0], rod.lengths[0], radius, speed, rod.rates[0] / speed)

    @property
    def chain(self) -> Chain:
        """The rod that strikes."""
        angle, rate = -self.impact_angle, self.speed_ratio * self.hub_speed
        return Chain((self.mass,), (self.length,), (angle,), (rate,), self.hub_radius, self.hub_speed, angle)

    @property
    def surface(self) -> Surface:
        """The surface that is struck."""
        return Surface(self.friction, self.restitution_friction, self.restitution)


OPERATING_POINT = Case()


@dataclass(frozen=True, slots=True)
class Sweep:
    """A family of strikes: ``along`` varies on a curve from ``low`` to ``high``, ``family`` from curve to curve.

    Both are fields of Case. A curve may end, instead of at ``high``, where the friction that varies reaches tan gamma.
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
        """Return where curve and simulated impacts begin, where those impacts end, and where the curve ends."""
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
    unbounded = sweep.until_stiction and quantity == "normal_final_impulse"
    return Panel(
        AXES[sweep.along],
        AXES[quantity],
        curves,
        family=SYMBOLS[sweep.family],
        marks=(mark,) if sweep.base == OPERATING_POINT else (),
        levels=_stiction(sweep),
        top=2.2 * max(float(curve.theory[0]) for curve in curves) if unbounded else None,
    )


def _curve(quantity: str, sweep: Sweep, case: Case) -> Curve:
    """Return a curve closer in x where it grows without bound, and points by law: ends and steps, middles between them."""
    low, simulated, high = sweep.ends(case)
    middles = low + (np.arange(COMPLIANT) + 0.5) * ((simulated - low) / COMPLIANT)
    places = {"energetic": np.linspace(low, simulated, ENERGETIC), "compliant": np.asarray(middles, dtype=float)}
    grid = np.linspace(low, high, GRID)
    if sweep.until_stiction:
        grid = np.asarray(high - (high - low) * np.linspace(1.0, 0.0, GRID) ** 3)

    def impact(x: float) -> tuple[Chain, Surface]:
        here = dataclasses.replace(case, **{sweep.along: x})
        return here.chain, here.surface

    def read(contact: ContactRecord) -> Any:
        return _value(quantity, contact_quantities(contact).get)

    axis = AXES[sweep.family]
    unit = {"1": "", "°": "°"}.get(axis.unit, f" {axis.unit}")
    name = f"{round(getattr(case, sweep.family) * axis.factor, 6):g}{unit}"
    return impact_curve(name, _formula(quantity, case, sweep.along), grid, impact, read, places)


def _value(quantity: str, get: Callable[[str], Any]) -> Any:
    """Return a quantity by name, the total work as the sum of both; None where it is not known."""
    works = ("normal_compressive_work", "tangential_compressive_work")
    values = [get(name) for name in (works if quantity == TOTAL else (quantity,))]
    return None if any(value is None for value in values) else sum(values)


def _formula(quantity: str, case: Case, along: str) -> Callable[[Array], Array]:
    """Return the closed form as a function of one field of the case."""

    def value(x: Array) -> Array:
        given = {each.name: getattr(case, each.name) for each in dataclasses.fields(case)} | {along: x}
        found = monofilament_impact(**given)
        return np.broadcast_to(_value(quantity, lambda name: getattr(found, name)), np.shape(x))

    return value


def _stiction(sweep: Sweep) -> tuple[Level, ...]:
    """Draw upright lines at tan gamma, where a friction along the curves reaches it."""
    if not sweep.until_stiction:
        return ()
    tangents = [math.tan(angle) for angle in dict.fromkeys(case.impact_angle for case in sweep.cases())]
    label = f"stiction, {SYMBOLS[sweep.along]} = tan $\\gamma$"
    return tuple(Level(tangent, label, upright=True) for tangent in tangents if tangent <= sweep.high)


def oblique_panels(impacts: Impacts) -> dict[str, Panel]:
    """Return the families that a bristle's strike belongs to (Zhang 2020, figs. 2.22-2.24); impacts are simulated."""
    own = Case.of(impacts.chain, impacts.surface)
    impulse = impacts.strikes[impacts.law].contact.impulse[0]
    by_angle, restitutions = _over_friction(own), with_own(RESTITUTIONS, own.restitution)
    by_restitution = dataclasses.replace(by_angle, family="restitution", values=restitutions)
    return {
        "impulse by angle": _marked("normal_final_impulse", by_angle, own.friction, impulse),
        "impulse by restitution": _marked("normal_final_impulse", by_restitution, own.friction, impulse),
        **_rebound_over_angle(impacts, own),
    }


def single_pendulum_panels(impacts: Impacts) -> dict[str, Panel]:
    """Return the families that a single pendulum's impact belongs to (Zhang 2020, fig. 2.26); impacts are simulated.

    A pendulum at rest before the impact has none.
    """
    own = Case.of(impacts.chain, impacts.surface)
    ratio = _rebound_ratio(impacts)
    if ratio is None:
        return {}
    over_friction = _marked("rebound_ratio", _over_friction(own), own.friction, ratio)
    return {**_rebound_over_angle(impacts, own), "rebound over friction": over_friction}


def _rebound_over_angle(impacts: Impacts, own: Case) -> dict[str, Panel]:
    """Return the rebound ratio over the impact angle; nothing for a rod at rest."""
    ratio = _rebound_ratio(impacts)
    if ratio is None:
        return {}
    frictions = with_own(FRICTIONS, own.friction)
    sweep = Sweep("impact_angle", math.radians(2.0), 0.5 * math.pi, "friction", frictions, base=own)
    return {"rebound over angle": _marked("rebound_ratio", sweep, own.impact_angle, ratio)}


def _rebound_ratio(impacts: Impacts) -> float | None:
    before = impacts.chain.rates[0]
    return impacts.strikes[impacts.law].contact.rates_after[0] / before if before else None


def _over_friction(own: Case) -> Sweep:
    """Vary friction by impact angle, up to stiction unless restitution has a friction of its own."""
    angles, most = with_own(ANGLES, own.impact_angle), max(1.0, 1.25 * own.friction)
    return Sweep("friction", 0.0, most, "impact_angle", angles, own.restitution_friction is None, own)


def _marked(quantity: str, sweep: Sweep, x: float, y: float) -> Panel:
    """Return the sweep's panel with the scenario's own impact as its mark."""
    return dataclasses.replace(sweep_panel(quantity, sweep), marks=(Mark(x, y),))


def with_own(values: Sequence[float], own: float) -> tuple[float, ...]:
    """Return a family's values, ascending, with a scenario's own in place of those within a tenth of it."""
    return tuple(sorted([*(value for value in values if abs(value - own) > 0.1 * own), own]))
