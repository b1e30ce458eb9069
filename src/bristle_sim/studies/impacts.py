"""Single impacts compared with their closed forms: radial bristle, Stronge's single and double pendulum.

The simulated side goes through the pymunk scene with the requested contact law, and with the others for comparison. Rates of
pendulums are signed as in the dissertation, negative approaching; in the scene the same motion turns the other way.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from bristle_sim.comparison import Quantity, Report, Table
from bristle_sim.parameters import Bristle, Contact, DoublePendulum, Hub, SinglePendulum, Strike, Surface
from bristle_sim.scene.strike import Chain, ChainStrike, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.answers import agreement, amount
from bristle_sim.studies.strike_point import IMPACT, contact_quantities, outcome_of
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.pendulums import double_pendulum_impact, single_pendulum_impact

LAWS = ("energetic", "compliant", "engine")

COMPLIANT_TOLERANCE = 3e-3
"""Relative difference that a contact resolved in time may have from its rigid-body limit at the default accuracy; usually
it is a thousandth of that, but near the stick threshold the limit itself is approached slowly."""


@dataclass(frozen=True, slots=True)
class Impacts:
    """One impact of a chain on a surface, computed by every contact law.

    ``law`` is the requested one; ``refusals`` say why another one has no result. A duration of the contact resolved in time, s,
    may have been requested; ``timing`` says in words for a film how long that contact takes.
    """

    chain: Chain
    surface: Surface
    law: str
    strikes: dict[str, ChainStrike]
    refusals: dict[str, str]
    contact_duration: float | None = None
    timing: str = ""


NORMAL_COMPRESSIVE, NORMAL_FINAL = IMPACT["normal_compressive_impulse"], IMPACT["normal_final_impulse"]

AT_REST = 1e-13
"""A rate after an impact counts as zero below this fraction of the fastest one before it."""

ROUNDING = 1e-15
"""Relative rounding of a position's distance from the hub's centre: the tip's height over the root is the difference of
two such positions."""

MOST = 1e-3
"""Largest allowance for magnified rounding, relative."""


def radial_chain(hub: Hub, bristle: Bristle, impact_angle: float, rate: float) -> Chain:
    """Return a bristle that stands radially at the impact angle, rad, and turns at a rate, rad/s."""
    return Chain((bristle.mass,), (bristle.length,), (-impact_angle,), (rate,), hub.radius, hub.speed, -impact_angle)


def double_chain(pendulum: DoublePendulum) -> Chain:
    """Return the rods of a double pendulum, whose rates have the other sign in the scene."""
    return Chain(
        (pendulum.mass_ratio * pendulum.mass, pendulum.mass),
        (pendulum.length, pendulum.length),
        (-math.radians(pendulum.angle_1_deg), -math.radians(pendulum.angle_2_deg)),
        (-pendulum.rate_1, -pendulum.rate_2),
    )


def oblique_impact(
    hub: Hub, bristle: Bristle, state: Strike, surface: Surface, contact: Contact, settings: Settings
) -> Report:
    """Simulate one strike of a radial bristle (Zhang 2020, eqs. 2.19-2.65)."""
    gamma, rate = math.radians(state.impact_angle_deg), state.speed_ratio * hub.speed
    impacts = _all_laws(radial_chain(hub, bristle, gamma, rate), surface, contact, settings)
    theory = monofilament_impact(
        bristle.mass, bristle.length, hub.radius, hub.speed, state.speed_ratio, gamma, *_coefficients(surface)
    )
    hidden = ROUNDING * (1.0 + hub.radius / bristle.length)
    tolerance = _tolerance(contact, settings, surface, math.tan(gamma), hidden / math.sin(gamma))
    rows = []
    for name, simulated in contact_quantities(impacts.strikes[contact.law].contact).items():
        expected = None if name == "rebound_ratio" and rate == 0.0 else float(getattr(theory, name))
        least = {"final_bristle_rate": AT_REST * rate, "rebound_ratio": AT_REST}.get(name, 0.0)
        rounding = ROUNDING * rate / max(abs(theory.final_bristle_rate), least) if least else 0.0
        if name == "tangential_compressive_work":
            rounding = hidden / math.cos(gamma)
        rows.append(_row(name, *IMPACT[name], simulated, expected, _widened(tolerance, rounding), least))
    return _report(impacts, rows, lambda one: one.contact.rates_after[0], "bristle")


def single_pendulum(pendulum: SinglePendulum, surface: Surface, contact: Contact, settings: Settings) -> Report:
    """Simulate Stronge's single pendulum (Zhang 2020, sec. 2.4.1)."""
    gamma = math.radians(pendulum.impact_angle_deg)
    chain = Chain((pendulum.mass,), (pendulum.length,), (-gamma,), (-pendulum.rate,))
    impacts = _all_laws(chain, surface, contact, settings)
    found = impacts.strikes[contact.law].contact
    ratio = -found.rates_after[0] / pendulum.rate if pendulum.rate else None
    tolerance = _tolerance(contact, settings, surface, math.tan(gamma), ROUNDING / math.sin(gamma))
    theory = _single_theory(pendulum, gamma, surface)
    # A rate after the impact has the rounding of the one before it.
    widened = _widened(tolerance, ROUNDING / max(abs(theory[0] or 0.0), AT_REST))
    compressive = None if found.compressive_impulse is None else found.compressive_impulse[0]
    rows = [
        _row("rebound_ratio", *IMPACT["rebound_ratio"], ratio, theory[0], widened, AT_REST),
        _row("normal_compressive_impulse", *NORMAL_COMPRESSIVE, compressive, theory[1], tolerance),
        _row("normal_final_impulse", *NORMAL_FINAL, found.impulse[0], theory[2], tolerance),
    ]
    return _report(impacts, rows, lambda one: -one.contact.rates_after[0], "pendulum")


def _single_theory(
    pendulum: SinglePendulum, gamma: float, surface: Surface
) -> tuple[float | None, float | None, float | None]:
    """The pendulum's own formulas; with two coefficients of friction, the bristle's with a hub of no radius."""
    if surface.restitution_friction is None or pendulum.rate >= 0.0:
        own = single_pendulum_impact(
            pendulum.mass, pendulum.length, gamma, pendulum.rate, surface.friction, surface.restitution
        )
        ratio = own.rebound_ratio if pendulum.rate else None
        return ratio, own.normal_compressive_impulse, own.normal_final_impulse
    speed = (min(-pendulum.rate, 1e6), max(-pendulum.rate / 1e6, 1.0))
    bristle = monofilament_impact(pendulum.mass, pendulum.length, 0.0, *speed, gamma, *_coefficients(surface))
    values = (bristle.rebound_ratio, bristle.normal_compressive_impulse, bristle.normal_final_impulse)
    return float(values[0]), float(values[1]), float(values[2])


def double_pendulum(pendulum: DoublePendulum, surface: Surface, contact: Contact, settings: Settings) -> Report:
    """Simulate Stronge's double pendulum with any ratio of masses (Zhang 2020, eqs. 2.66-2.111)."""
    impacts = _all_laws(double_chain(pendulum), surface, contact, settings)
    angles = (math.radians(pendulum.angle_1_deg), math.radians(pendulum.angle_2_deg))
    theory = double_pendulum_impact(
        pendulum.mass,
        pendulum.mass_ratio,
        pendulum.length,
        *angles,
        pendulum.rate_1,
        pendulum.rate_2,
        *_coefficients(surface),
    )
    found = impacts.strikes[contact.law]
    impulse = found.contact.compressive_impulse
    # Friction magnifies the rounding of a rod's angle, by itself where the rod lies along the surface.
    mu, (along, across) = surface.friction, (abs(math.cos(angles[1])), abs(math.sin(angles[1])))
    magnified = max(pendulum.mass_ratio, mu / max(across + mu * along, AT_REST))
    within = _tolerance(contact, settings, surface, None, ROUNDING * magnified)
    slowest = AT_REST * max(abs(pendulum.rate_1), abs(pendulum.rate_2))
    compressive = (impulse[0] if impulse else None, theory.normal_compressive_impulse)
    energies = found.kinetic_energy_ratio, theory.kinetic_energy_ratio if found.kinetic_energy_before else None
    after = found.contact.rates_after
    rows = [
        _row("final_rate_1", "rate of the first rod after", "rad/s", -after[0], theory.final_rate_1, within, slowest),
        _row("final_rate_2", "rate of the second rod after", "rad/s", -after[1], theory.final_rate_2, within, slowest),
        _row("normal_compressive_impulse", *NORMAL_COMPRESSIVE, *compressive, within),
        _row("normal_final_impulse", *NORMAL_FINAL, found.contact.impulse[0], theory.normal_final_impulse, within),
        _row("kinetic_energy_ratio", "kinetic energy after over before", "1", *energies, within, AT_REST**2),
    ]
    return _report(impacts, rows, lambda one: -one.contact.rates_after[1], "second rod")


def _coefficients(surface: Surface) -> tuple[float, float, float]:
    return surface.friction, surface.restitution, surface.friction_in_restitution


def _row(
    name: str,
    label: str,
    unit: str,
    simulated: float | None,
    theory: float | None,
    tolerance: float | None,
    least: float = 0.0,
) -> Quantity:
    """Return a quantity, either side of which is zero where it is no more than the least."""
    first, second = (0.0 if each is not None and abs(each) <= least else each for each in (simulated, theory))
    return Quantity(name, unit, first, second, tolerance=tolerance, label=label)


def _tolerance(
    contact: Contact, settings: Settings, surface: Surface, jam: float | None, rounding: float
) -> float | None:
    """Return the relative difference from theory that a law may have; None for one that does not follow it.

    Near the jam, mu = tan gamma, results magnify the rounding of K by the inverse of the distance. ``rounding`` is
    its magnification by geometry: a bristle short compared with its hub or nearly upright, stick under a huge first mass.
    """
    if contact.law == "engine" or (contact.law == "compliant" and contact.duration is not None):
        return None
    if contact.law == "compliant":
        return max(COMPLIANT_TOLERANCE, settings.accuracy)
    distance = 1.0 if jam is None else min(1.0, abs(1.0 - surface.friction_in_restitution / jam))
    return _widened(1e-9 + 1e-14 / max(distance, 1e-14), rounding)


def _widened(tolerance: float | None, rounding: float) -> float | None:
    """Return a tolerance with rounding that the law does not cause."""
    return None if tolerance is None else tolerance + min(rounding, MOST)


def _all_laws(chain: Chain, surface: Surface, contact: Contact, settings: Settings) -> Impacts:
    """Simulate the strike by the requested law, and by the others where they have a result."""
    strikes, refusals = {}, {}
    for law in LAWS:
        if law == contact.law:
            strikes[law] = strike(chain, surface, contact, settings)
            continue
        try:
            strikes[law] = strike(chain, surface, Contact(law), settings)
        except ValueError as error:
            refusals[law] = str(error)
    return Impacts(chain, surface, contact.law, strikes, refusals, contact.duration)


def _report(impacts: Impacts, rows: list[Quantity], rate: Callable[[ChainStrike], float], turning: str) -> Report:
    """Return the report; ``rate`` is that of the rod that turns, rad/s."""
    requested = impacts.strikes[impacts.law]
    laws = [_law(law, one, rate(one)) for law, one in impacts.strikes.items()]
    return Report(
        outcome=outcome_of(requested.contact),
        quantities=tuple(rows),
        phases=requested.contact.phases,
        events=(("strike", requested.contact.time),),
        steps=requested.steps,
        wall_s=requested.wall_s,
        remarks=tuple(f"{law}: {reason}" for law, reason in impacts.refusals.items()),
        tables=(_compared_laws(laws),),
        extra={"laws": laws},
        subject=impacts,
        answer=_answer(requested, rows, rate(requested), turning),
    )


def _answer(requested: ChainStrike, rows: list[Quantity], rate: float, turning: str) -> str:
    if not requested.contact.impulse[0]:
        return "There is no impact: the tip does not approach the surface."
    words = {"rebound": "rebounds", "no rebound": "does not rebound"}.get(requested.contact.outcome, "sticks")
    impulse = amount(requested.contact.impulse[0], "N s")
    return (
        f"{agreement(rows)}: the tip {words}, its normal impulse is {impulse}, and the {turning} then turns at"
        f" {amount(rate, 'rad/s')}."
    )


def _compared_laws(laws: Sequence[dict[str, Any]]) -> Table:
    """Return the table of every law's rate, impulses, works and energy ratio, in SI units."""
    head = ("law", "rate after, rad/s", "p_n, N s", "p_t, N s", "work n, J", "work t, J", "energy ratio")
    forms = ("", ".9g", ".6g", ".6g", ".5g", ".5g", ".7f")
    cells = (
        ["-" if value is None else format(value, form) for value, form in zip(law.values(), forms, strict=True)]
        for law in laws
    )
    return Table("the contact laws compared", head, tuple(map(tuple, cells)))


def _law(law: str, one: ChainStrike, rate: float) -> dict[str, Any]:
    """Return a law's results for the JSON, in SI units; no works where the law has none."""
    first, second = one.contact.compressive_work, one.contact.restitutive_work
    works = (None, None) if first is None or second is None else (first[0] + second[0], first[1] + second[1])
    return {
        "law": law,
        "rate_after": rate,
        "normal_impulse": one.contact.impulse[0],
        "tangential_impulse": one.contact.impulse[1],
        "normal_work": works[0],
        "tangential_work": works[1],
        "kinetic_energy_ratio": one.kinetic_energy_ratio,
    }
