"""Single impacts compared with their closed forms: the radial bristle, and Stronge's single and
double pendulums.

Each impact is simulated by the requested contact law and, for comparison, by the other laws.
Angular velocities of pendulums have the sign of the dissertation, negative in approach. In the
simulation the same motion has the other sign.
"""

import math
import sys
from collections.abc import Callable, Iterable
from typing import Any

from bristle_sim.comparison import Quantity, Report, Table, agreement
from bristle_sim.parameters import (
    Bristle,
    Contact,
    DoublePendulum,
    Hub,
    SinglePendulum,
    Strike,
    Surface,
)
from bristle_sim.readable import amount
from bristle_sim.scene.strike import Chain, ChainStrike
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_laws import Impacts, all_laws
from bristle_sim.studies.strike_measures import IMPACT, contact_quantities, impulse_caution
from bristle_sim.studies.whole_pass import record_fields
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.pendulums import double_pendulum_impact, single_pendulum_impact

COMPLIANT_TOLERANCE = 3e-3
"""Largest relative difference of a contact simulated over time from its rigid-body limit, at the
default accuracy.

Usually the difference is a thousand times smaller; near the threshold of stick it decreases
slowly with the duration of the contact."""


AT_REST = 1e-13
"""Largest rate after an impact that counts as zero, over the fastest rate before it. Also the largest
tangential work that counts as zero, over the normal work."""
# Relative rounding error of a position's distance from the hub's centre. The height of the tip over
# the root is the difference of two positions.
HEIGHT_ROUNDING = 1e-15
LEAST_SLOPE = 100.0
"""Least angle of a bristle from the surface, over its turn during a contact in time, at which the
slide of the tip is compared with theory.

A bristle along the surface slides forward or back by its turn alone, which the closed form does not
know. At this ratio the tangential work differs by 2e-3."""
MOST_WIDENED = 1e-3  # largest amount by which magnified rounding errors widen a relative tolerance


IMPULSES = ("normal_compressive_impulse", "normal_final_impulse")

RODS = {
    "final_rate_1": ("rate of the first rod after", "rad/s"),
    "final_rate_2": ("rate of the second rod after", "rad/s"),
    "kinetic_energy_ratio": ("kinetic energy after over before", "1"),
}
"""Quantities of a double pendulum alone: label and unit."""


def radial_chain(hub: Hub, bristle: Bristle, impact_angle: float, rate: float) -> Chain:
    """Return the bristle as a chain of one rod that stands radially at the impact angle, rad, and
    turns at the rate, rad/s.
    """
    return Chain(
        (bristle.mass,),
        (bristle.length,),
        (-impact_angle,),
        (rate,),
        hub.radius,
        hub.speed,
        -impact_angle,
    )


def double_chain(pendulum: DoublePendulum) -> Chain:
    """Return the two rods of a double pendulum for the simulation, where their angular velocities
    have the other sign.
    """
    return Chain(
        (pendulum.mass_ratio * pendulum.mass, pendulum.mass),
        (pendulum.length, pendulum.length),
        (-math.radians(pendulum.angle_1_deg), -math.radians(pendulum.angle_2_deg)),
        (-pendulum.rate_1, -pendulum.rate_2),
    )


def oblique_impact(
    hub: Hub,
    bristle: Bristle,
    state: Strike,
    surface: Surface,
    contact: Contact,
    settings: Settings,
) -> Report:
    """Simulate one strike of a radial bristle, and compare it with the closed forms (Zhang 2020,
    eqs. 2.19-2.65).
    """
    gamma = math.radians(state.impact_angle_deg)
    rate = state.speed_ratio * hub.speed
    impacts = all_laws(radial_chain(hub, bristle, gamma, rate), surface, contact, settings)
    geometry = (bristle.mass, bristle.length, hub.radius, hub.speed, state.speed_ratio, gamma)
    theory = monofilament_impact(*geometry, *_coefficients(surface))
    found = _bristle_rows(impacts, settings, theory, IMPACT)
    return _report(impacts, found, lambda one: one.contact.rates_after[0], "bristle")


def single_pendulum(
    pendulum: SinglePendulum, surface: Surface, contact: Contact, settings: Settings
) -> Report:
    """Simulate the strike of Stronge's single pendulum, and compare it with the closed forms (Zhang
    2020, sec. 2.4.1).

    If friction differs between compression and restitution, the closed forms are those of the
    bristle on a hub of zero radius.
    """
    gamma = math.radians(pendulum.impact_angle_deg)
    rod = (pendulum.mass, pendulum.length)
    rate = pendulum.rate
    chain = Chain((pendulum.mass,), (pendulum.length,), (-gamma,), (-rate,))
    impacts = all_laws(chain, surface, contact, settings)
    theory: Any
    if surface.restitution_friction is None or rate >= 0.0:
        theory = single_pendulum_impact(*rod, gamma, rate, surface.friction, surface.restitution)
    else:
        speed = (min(-rate, 1e6), max(-rate / 1e6, 1.0))
        theory = monofilament_impact(*rod, 0.0, *speed, gamma, *_coefficients(surface))
    found = _bristle_rows(impacts, settings, theory, ("rebound_ratio", *IMPULSES))
    return _report(impacts, found, lambda one: -one.contact.rates_after[0], "pendulum")


def _bristle_rows(
    impacts: Impacts, settings: Settings, theory: Any, names: Iterable[str]
) -> list[Quantity]:
    """Compare the named quantities of one rod's impact with the closed form's attributes of the
    same names.
    """
    chain = impacts.chain
    contact = impacts.contact
    surface = impacts.surface
    gamma = -chain.angles[0]
    before = chain.rates[0]
    hidden = HEIGHT_ROUNDING * (1.0 + chain.hub_radius / chain.lengths[0])
    tolerance = _tolerance(contact, settings, surface, math.tan(gamma), hidden / math.sin(gamma))
    # A rate after the impact has the rounding of the rate before it.
    at_rest = HEIGHT_ROUNDING / max(abs(theory.rebound_ratio), AT_REST) if before else 0.0
    rounding = {
        "final_bristle_rate": at_rest,
        "rebound_ratio": at_rest,
        "tangential_compressive_work": hidden / math.cos(gamma),
    }
    record = impacts.strikes[contact.law].contact
    simulated = contact_quantities(record)
    turned = abs(before) * record.duration
    unknown = {"rebound_ratio"} if before == 0.0 else set[str]()
    if contact.duration is None and math.cos(gamma) < LEAST_SLOPE * turned:
        unknown |= {"tangential_compressive_impulse", "tangential_compressive_work"}
    least = {
        "final_bristle_rate": AT_REST * abs(before),
        "rebound_ratio": AT_REST,
        "tangential_compressive_work": AT_REST * abs(simulated["normal_compressive_work"] or 0.0),
    }
    found = []
    for name in names:
        pair = (simulated[name], None if name in unknown else float(getattr(theory, name)))
        within = _widened(tolerance, rounding.get(name, 0.0))
        found.append(_row(name, IMPACT[name], pair, within, least.get(name, 0.0)))
    return found


def double_pendulum(
    pendulum: DoublePendulum, surface: Surface, contact: Contact, settings: Settings
) -> Report:
    """Simulate the strike of Stronge's double pendulum, and compare it with the closed forms (Zhang
    2020, eqs. 2.66-2.111).

    The two rods may have any ratio of masses.
    """
    impacts = all_laws(double_chain(pendulum), surface, contact, settings)
    angles = (math.radians(pendulum.angle_1_deg), math.radians(pendulum.angle_2_deg))
    rates = (pendulum.rate_1, pendulum.rate_2)
    rods = (pendulum.mass, pendulum.mass_ratio, pendulum.length)
    theory = double_pendulum_impact(*rods, *angles, *rates, *_coefficients(surface))
    one = impacts.strikes[contact.law]
    # Friction magnifies the rounding of a rod's angle; the factor is the friction itself for a rod
    # along the surface.
    mu, (along, across) = surface.friction, (abs(math.cos(angles[1])), abs(math.sin(angles[1])))
    # An approach that is the difference of two almost equal speeds has the rounding of the speeds.
    speeds = [rate * math.sin(angle) for rate, angle in zip(rates, angles, strict=True)]
    cancelled = sum(map(abs, speeds)) / max(abs(sum(speeds)), sys.float_info.min)
    magnified = max(pendulum.mass_ratio, mu / max(across + mu * along, AT_REST), cancelled)
    within = _tolerance(contact, settings, surface, None, HEIGHT_ROUNDING * magnified)
    slowest = AT_REST * max(map(abs, rates))
    rate_1, rate_2 = one.contact.rates_after
    impulses = contact_quantities(one.contact)
    sides = {
        "final_rate_1": (-rate_1, slowest),
        "final_rate_2": (-rate_2, slowest),
        **{name: (impulses[name], 0.0) for name in IMPULSES},
        "kinetic_energy_ratio": (one.kinetic_energy_ratio, AT_REST**2),
    }
    found = []
    for name, (simulated, least) in sides.items():
        known = name != "kinetic_energy_ratio" or one.kinetic_energy_before
        pair = (simulated, getattr(theory, name) if known else None)
        found.append(_row(name, (IMPACT | RODS)[name], pair, within, least))
    return _report(impacts, found, lambda one: -one.contact.rates_after[1], "second rod")


def _coefficients(surface: Surface) -> tuple[float, float, float]:
    return surface.friction, surface.restitution, surface.friction_in_restitution


def _row(
    name: str,
    words: tuple[str, str],
    sides: Iterable[float | None],
    within: float | None,
    least: float,
) -> Quantity:
    """Return a comparison of a simulated and a theoretical value, ``sides``; a value of magnitude
    up to ``least`` counts as 0.
    """
    first, second = (0.0 if each is not None and abs(each) <= least else each for each in sides)
    return Quantity(name, words[1], first, second, tolerance=within, label=words[0])


def _tolerance(
    contact: Contact, settings: Settings, surface: Surface, jam: float | None, rounding: float
) -> float | None:
    """Return the largest relative difference of a contact law from theory; None for a law that does
    not follow the theory.

    At the jam, mu = tan gamma, the solution is singular. Near it the rounding error of the inverse
    mass matrix K is magnified by the inverse of the relative distance from the jam. ``jam`` is the
    friction at the jam, if there is one. ``rounding`` is the rounding error that geometry
    magnifies: of a bristle that is short compared with its hub or nearly upright, or of stick under
    a huge first mass.
    """
    timed = contact.law == "compliant" and contact.duration is not None
    if contact.law == "engine" or timed or contact.tangential_compliance:
        return None
    if contact.law == "compliant":
        return max(COMPLIANT_TOLERANCE, settings.accuracy)
    distance = 1.0 if jam is None else min(1.0, abs(1.0 - surface.friction_in_restitution / jam))
    return _widened(1e-9 + 1e-14 / max(distance, 1e-14), rounding)


def _widened(tolerance: float | None, rounding: float) -> float | None:
    return None if tolerance is None else tolerance + min(rounding, MOST_WIDENED)


def _report(
    impacts: Impacts, rows: list[Quantity], rate: Callable[[ChainStrike], float], turning: str
) -> Report:
    requested = impacts.strikes[impacts.contact.law]
    elastic = bool(impacts.contact.tangential_compliance)
    one = requested.contact
    turned = rate(requested)
    head = (
        "law",
        "rate after, rad/s",
        "p_n, N s",
        "p_t, N s",
        "work n, J",
        "work t, J",
        "energy ratio",
    )
    laws = [_law(law, each, rate(each)) for law, each in impacts.strikes.items()]
    forms = ("", ".9g", ".6g", ".6g", ".5g", ".5g", ".7f")
    pairs = (zip(law.values(), forms, strict=True) for law in laws)
    cells = tuple(
        tuple("-" if value is None else format(value, form) for value, form in each)
        for each in pairs
    )
    impulse = f"a normal impulse of {amount(one.impulse[0], 'N s')}{impulse_caution(one)}"
    known = (
        "the formulas are for a contact that is rigid along the surface"
        if elastic
        else agreement(rows)
    )
    motion = f"the {turning} then turns at {amount(turned, 'rad/s')}"
    answer = f"The tip {one.outcome_in_words}, with {impulse}; {motion}, and {known}."
    remarks = [f"{law}: {reason}" for law, reason in impacts.refusals.items()]
    if elastic:
        remarks.append("theory: of a contact that is rigid along the surface")
    return Report(
        **record_fields(one, requested, strike=one.time),
        quantities=tuple(rows),
        remarks=tuple(remarks),
        tables=(Table("the contact laws compared", head, cells),),
        extra={"laws": laws},
        subject=impacts,
        answer=answer
        if one.impulse[0]
        else "There is no impact: the tip does not approach the surface.",
    )


def _law(law: str, one: ChainStrike, rate: float) -> dict[str, Any]:
    """Return the results by one contact law for the JSON, in SI units."""
    normal, tangential = one.contact.impulse
    works = one.contact.work or (None, None)
    return {
        "law": law,
        "rate_after": rate,
        "normal_impulse": normal,
        "tangential_impulse": tangential,
        "normal_work": works[0],
        "tangential_work": works[1],
        "kinetic_energy_ratio": one.kinetic_energy_ratio,
    }
