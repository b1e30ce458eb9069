"""Single impacts compared with their closed forms: the radial bristle, and Stronge's single and
double pendulums.

Each impact is simulated by the requested contact law and, for comparison, by the other laws.
Angular velocities of pendulums have the dissertation's sign, which is negative in approach. The
simulation has the opposite sign.
"""

import math
import sys
from collections.abc import Mapping
from typing import Any

from bristle_sim.comparison import Quantity, Report, Table, Values, agreement, rows
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
from bristle_sim.theory.pendulums import double_pendulum_impact

COMPLIANT_TOLERANCE = 3e-3
"""Largest relative difference of a contact simulated over time from its rigid-body limit, at the
default accuracy.

Usually the difference is a thousand times smaller; near the threshold of stick it decreases
slowly with the duration of the contact."""

AT_REST = 1e-13
"""Largest angular velocity after an impact that counts as zero, divided by the largest one before
it. Also the largest tangential work that counts as zero, divided by the normal work."""
# Relative rounding error of a distance from the hub's centre. The height of the tip above the root
# is the difference of two such distances.
HEIGHT_ROUNDING = 1e-15
LEAST_SLOPE = 100.0
"""Least ratio at which the slide of the tip is compared with theory: the angle between bristle and
surface, divided by the angle by which the bristle rotates during a contact resolved in time.

The closed form neglects the rotation. At this ratio the tangential work differs by 2e-3."""
MOST_WIDENED = 1e-3  # largest amount by which magnified rounding errors widen a relative tolerance

IMPULSES = ("normal_compressive_impulse", "normal_final_impulse")

PENDULUM = ("final_rate_1", "final_rate_2", *IMPULSES, "kinetic_energy_ratio")

RODS = {
    "final_rate_1": ("rate of the first rod after", "rad/s"),
    "final_rate_2": ("rate of the second rod after", "rad/s"),
    "kinetic_energy_ratio": ("kinetic energy after divided by before", "1"),
}
"""Quantities of a double pendulum alone: label and unit."""


def radial_chain(hub: Hub, bristle: Bristle, impact_angle: float, rate: float) -> Chain:
    """Return the bristle as a chain of one radial rod.

    Args:
        hub, bristle: dimensions and motion of the hub, and properties of the rod.
        impact_angle: angle between the rod and the surface's normal, rad.
        rate: angular velocity of the rod, rad/s.
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
    """Return the two rods of a double pendulum as a chain for the simulation.

    Angles and angular velocities in the simulation have the opposite sign.
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
    """Simulate a strike of a radial bristle, and compare it with the closed-form solution.

    ``state`` is the motion before the strike. The solution is that of Zhang 2020, eqs. 2.19-2.65.
    """
    gamma = math.radians(state.impact_angle_deg)
    chain = radial_chain(hub, bristle, gamma, state.speed_ratio * hub.speed)
    motion = (hub.radius, hub.speed, state.speed_ratio)
    impacts = all_laws(chain, surface, contact, settings)
    return _report(impacts, _one_rod(impacts, settings, motion, IMPACT), 1.0, "bristle")


def single_pendulum(
    pendulum: SinglePendulum, surface: Surface, contact: Contact, settings: Settings
) -> Report:
    """Simulate the strike of Stronge's single pendulum, and compare it with the closed-form
    solution.

    The solution (Zhang 2020, sec. 2.4.1) is that of the bristle on a hub of zero radius.
    """
    gamma = math.radians(pendulum.impact_angle_deg)
    chain = Chain((pendulum.mass,), (pendulum.length,), (-gamma,), (-pendulum.rate,))
    impacts = all_laws(chain, surface, contact, settings)
    labels = {name: IMPACT[name] for name in ("rebound_ratio", *IMPULSES)}
    found = _one_rod(impacts, settings, (0.0, 1.0, -pendulum.rate), labels)
    return _report(impacts, found, -1.0, "pendulum")


def _one_rod(
    impacts: Impacts,
    settings: Settings,
    motion: tuple[float, float, float],
    labels: Mapping[str, tuple[str, str]],
) -> tuple[Quantity, ...]:
    """Compare the impact of one rod with the closed-form solution for the bristle.

    Args:
        impacts: the impact by each contact law.
        settings: the requested accuracy.
        motion: hub radius (m), hub speed (rad/s), and the rod's angular velocity divided by the hub
            speed.
        labels: label and unit of each quantity, by name.
    """
    chain = impacts.chain
    contact = impacts.contact
    surface = impacts.surface
    gamma = -chain.angles[0]
    before = abs(chain.rates[0])
    coefficients = (surface.friction, surface.restitution, surface.friction_in_restitution)
    rod = (chain.masses[0], chain.lengths[0])
    closed_form = monofilament_impact(*rod, *motion, gamma, *coefficients)
    known = [name for name in labels if before or name != "rebound_ratio"]
    theory = {name: float(getattr(closed_form, name)) for name in known}
    record = impacts.strikes[contact.law].contact
    simulated = contact_quantities(record)
    if contact.duration is None and math.cos(gamma) < LEAST_SLOPE * before * record.duration:
        theory.pop("tangential_compressive_impulse", None)
        theory.pop("tangential_compressive_work", None)
    hidden = HEIGHT_ROUNDING * (1.0 + chain.hub_radius / chain.lengths[0])
    # The angular velocity after the impact has the absolute rounding error of the one before.
    at_rest = HEIGHT_ROUNDING / max(abs(theory.get("rebound_ratio", math.inf)), AT_REST)
    rounding = dict.fromkeys(labels, hidden / math.sin(gamma))
    for name in ("final_bristle_rate", "rebound_ratio"):
        rounding[name] = rounding["rebound_ratio"] + at_rest
    if "tangential_compressive_work" in labels:
        rounding["tangential_compressive_work"] += hidden / math.cos(gamma)
    least = {
        "final_bristle_rate": AT_REST * before,
        "rebound_ratio": AT_REST,
        "tangential_compressive_work": AT_REST * abs(simulated["normal_compressive_work"] or 0.0),
    }
    tolerance = _tolerance(impacts, settings, math.tan(gamma))
    return _compared(labels, simulated, theory, tolerance, rounding, least)


def double_pendulum(
    pendulum: DoublePendulum, surface: Surface, contact: Contact, settings: Settings
) -> Report:
    """Simulate the strike of Stronge's double pendulum, and compare it with the closed-form
    solution.

    The solution is that of Zhang 2020, eqs. 2.66-2.111. The two rods may have different masses.
    """
    impacts = all_laws(double_chain(pendulum), surface, contact, settings)
    angles = (math.radians(pendulum.angle_1_deg), math.radians(pendulum.angle_2_deg))
    rates = (pendulum.rate_1, pendulum.rate_2)
    rods = (pendulum.mass, pendulum.mass_ratio, pendulum.length)
    coefficients = (surface.friction, surface.restitution, surface.friction_in_restitution)
    closed_form = double_pendulum_impact(*rods, *angles, *rates, *coefficients)
    one = impacts.strikes[contact.law]
    labels = {name: (RODS | IMPACT)[name] for name in PENDULUM}
    rate_1, rate_2 = one.contact.rates_after
    simulated = contact_quantities(one.contact) | {
        "final_rate_1": -rate_1,
        "final_rate_2": -rate_2,
        "kinetic_energy_ratio": one.kinetic_energy_ratio,
    }
    theory = {name: float(getattr(closed_form, name)) for name in labels}
    if not one.kinetic_energy[0]:
        del theory["kinetic_energy_ratio"]
    # Friction mu amplifies the rounding error of the second rod's angle; for a rod that lies along
    # the surface the factor is mu.
    along = abs(math.cos(angles[1]))
    across = abs(math.sin(angles[1]))
    rubbed = surface.friction / max(across + surface.friction * along, AT_REST)
    # The difference of two almost equal speeds of approach has the rounding error of the speeds.
    speeds = [rate * math.sin(angle) for rate, angle in zip(rates, angles, strict=True)]
    cancelled = sum(map(abs, speeds)) / max(abs(sum(speeds)), sys.float_info.min)
    magnified = max(pendulum.mass_ratio, rubbed, cancelled)
    rounding = dict.fromkeys(labels, HEIGHT_ROUNDING * magnified)
    slowest = AT_REST * max(map(abs, rates))
    least = {
        "final_rate_1": slowest,
        "final_rate_2": slowest,
        "kinetic_energy_ratio": AT_REST**2,
    }
    found = _compared(labels, simulated, theory, _tolerance(impacts, settings), rounding, least)
    return _report(impacts, found, -1.0, "second rod")


def _compared(
    labels: Mapping[str, tuple[str, str]],
    simulated: Values,
    theory: Values,
    tolerance: float | None,
    rounding: Mapping[str, float],
    least: Mapping[str, float],
) -> tuple[Quantity, ...]:
    """Compare simulated values with theory.

    Args:
        labels: label and unit of each quantity, by name.
        simulated, theory: values by name.
        tolerance: accepted relative difference, to which ``rounding`` is added. None if the values
            need not agree with theory.
        rounding: relative rounding error of each value, by name. It depends on the geometry of the
            impact.
        least: largest magnitude of a value that counts as 0, by name.

    Returns:
        One quantity for each label, with the simulated and the theoretical value.
    """

    def rounded(values: Values) -> Values:
        """Return the values, with +0 in place of values of negligible magnitude."""
        return {
            name: value and value * (abs(value) > least.get(name, 0.0)) + 0.0
            for name, value in values.items()
        }

    within: Values = {}
    if tolerance is not None:
        within = {name: tolerance + min(rounding[name], MOST_WIDENED) for name in labels}
    return rows(labels, rounded(simulated), rounded(theory), tolerances=within)


def _tolerance(impacts: Impacts, settings: Settings, jam: float = math.inf) -> float | None:
    """Return the accepted relative difference of the requested contact law from theory.

    A contact law that does not follow the theory has None. The accepted difference grows as the
    friction mu approaches the friction ``jam`` at which the rod jams. There the rounding error of
    the inverse mass matrix K is amplified by the factor 1/|1 - mu/jam|.

    Args:
        impacts: the impact by each contact law.
        settings: the requested accuracy.
        jam: coefficient of friction at which the rod jams; infinite if it does not.
    """
    contact = impacts.contact
    if contact.law == "engine" or contact.duration is not None or contact.tangential_compliance:
        return None
    if contact.law == "compliant":
        return max(COMPLIANT_TOLERANCE, settings.accuracy)
    distance = min(1.0, abs(1.0 - impacts.surface.friction_in_restitution / jam))
    return 1e-9 + 1e-14 / max(distance, 1e-14)


def _report(
    impacts: Impacts, quantities: tuple[Quantity, ...], sign: float, turning: str
) -> Report:
    """Return the report on an impact.

    Args:
        impacts: the impact by each contact law.
        quantities: the comparison with theory.
        sign: factor +1 or -1 that gives simulated angular velocities the dissertation's sign.
        turning: name of the rod whose angular velocity the answer states.
    """
    requested = impacts.strikes[impacts.contact.law]
    elastic = bool(impacts.contact.tangential_compliance)
    one = requested.contact
    head = (
        "law",
        "rate after, rad/s",
        "p_n, N s",
        "p_t, N s",
        "work n, J",
        "work t, J",
        "energy ratio",
    )
    laws = [_law(law, each, sign) for law, each in impacts.strikes.items()]
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
        else agreement(quantities)
    )
    rate = sign * one.rates_after[-1]
    if abs(rate) <= AT_REST * max(map(abs, one.rates_before)):
        rate = 0.0
    motion = f"the {turning} then turns at {amount(rate, 'rad/s')}"
    answer = f"The tip {one.outcome_in_words}, with {impulse}; {motion}, and {known}."
    remarks = [f"{law}: {reason}" for law, reason in impacts.refusals.items()]
    if elastic:
        remarks.append("theory: of a contact that is rigid along the surface")
    return Report(
        **record_fields(requested, strike=one.time),
        quantities=quantities,
        remarks=tuple(remarks),
        tables=(Table("the contact laws compared", head, cells),),
        extra={"laws": laws},
        subject=impacts,
        answer=answer
        if one.impulse[0]
        else "There is no impact: the tip does not approach the surface.",
    )


def _law(law: str, one: ChainStrike, sign: float) -> dict[str, Any]:
    """Return a contact law's results for the JSON output; ``sign`` is that of :func:`_report`."""
    normal, tangential = one.contact.impulse
    works = one.contact.work or (None, None)
    return {
        "law": law,
        "rate_after": sign * one.contact.rates_after[-1],
        "normal_impulse": normal,
        "tangential_impulse": tangential,
        "normal_work": works[0],
        "tangential_work": works[1],
        "kinetic_energy_ratio": one.kinetic_energy_ratio,
    }
