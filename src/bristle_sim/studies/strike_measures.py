"""Measures of a strike in numbers and words: state of the bristle, impulses, works, rates and
outcome.
"""

import math
from typing import Any

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.readable import amount, plain_number
from bristle_sim.trajectory import ContactRecord, Trajectory

STATE = {
    "lag_deg_at_contact": ("lag at the strike", "deg"),
    "relative_speed_at_contact": ("bristle's speed relative to the hub", "rad/s"),
    "tip_speed_at_contact": ("tip speed v_C", "m/s"),
}
"""State of the bristle at its strike: label and unit of each quantity."""

IMPACT = {
    "normal_compressive_impulse": ("normal impulse of compression p_cy", "N s"),
    "normal_final_impulse": ("normal impulse p_fy", "N s"),
    "tangential_compressive_impulse": ("tangential impulse of compression p_cx", "N s"),
    "normal_compressive_work": ("normal work of compression W_y", "J"),
    "tangential_compressive_work": ("tangential work of compression W_x", "J"),
    "final_bristle_rate": ("bristle's rate after the strike", "rad/s"),
    "rebound_ratio": ("rate after the strike divided by before", "1"),
}
"""Impulses, works and angular velocities of a strike: label and unit of each quantity."""

RADIAL = 0.005
"""Largest lag (deg) at which a sentence calls the bristle radial: half a unit of the last digit
shown."""


def state_at_strike(
    tool: Tool, run: Trajectory, contact: ContactRecord | None
) -> dict[str, float | None]:
    """Return lag, relative angular velocity and tip speed at a strike, by name.

    ``STATE`` lists the names and units. The lag is the angle by which the bristle is behind the
    radial direction. The values are None if there is no contact. The links of a flexible wire
    vibrate; lag and angular velocity are then those of the straight line from root to tip.
    """
    if contact is None:
        return dict.fromkeys(STATE)
    lag = run.hub_angle[0] + tool.hub.speed * contact.time - contact.angles[0]
    rate = contact.rates_before[0]
    if tool.bristle.links > 1:
        before = int(abs(run.time - contact.time).argmin())
        (root, tip), (root_velocity, tip_velocity) = (
            each[before, [0, -1]] @ [1.0, 1j]
            for each in (run.centre_line, run.centre_line_velocity)
        )
        lag = float(np.angle(root * complex(*tool.bristle.path[-1]) * 1j / (tip - root)))
        rate = float(((tip_velocity - root_velocity) / (tip - root)).imag)
    speed = math.hypot(*contact.velocity_before)
    if contact.point == "knee":
        speed = float(run.tip_speed[int(abs(run.time - contact.time).argmin())])
    return {
        "lag_deg_at_contact": math.degrees(lag),
        "relative_speed_at_contact": rate - tool.hub.speed,
        "tip_speed_at_contact": speed,
    }


def beside_radial(lag: float) -> str:
    """Return a lag (deg) in words, for example ``2.74° short of radial``."""
    if abs(lag) < RADIAL:
        return "radial"
    return f"{amount(abs(lag), 'deg')} {'beyond' if lag < 0.0 else 'short of'} radial"


def contact_quantities(contact: ContactRecord | None) -> dict[str, float | None]:
    """Return impulses, works and angular velocities of a contact, by name.

    ``IMPACT`` lists the names and units. A quantity is None if there is no contact, or if the
    contact law does not compute it.
    """
    if contact is None:
        return dict.fromkeys(IMPACT)
    impulse = contact.compressive_impulse or (None, None)
    work = contact.compressive_work or (None, None)
    before = contact.rates_before[0]
    after = contact.rates_after[0]
    return {
        "normal_compressive_impulse": impulse[0],
        "normal_final_impulse": contact.impulse[0],
        "tangential_compressive_impulse": impulse[1],
        "normal_compressive_work": work[0],
        "tangential_compressive_work": work[1],
        "final_bristle_rate": after,
        "rebound_ratio": after / before if before else None,
    }


def outcome_fields(contact: ContactRecord | None) -> dict[str, Any]:
    """Return the fields with which a report states the outcome of a contact.

    They are the outcome's name, the outcome in words, and the phases of the contact. A jam has the
    name ``stiction``.
    """
    if contact is None:
        return {"outcome": "no contact", "outcome_in_words": "does not strike"}
    return {
        "outcome": "stiction" if contact.outcome == "jam" else contact.outcome,
        "outcome_in_words": contact.outcome_in_words,
        "phases": contact.phases,
    }


LARGEST_MAGNIFICATION = 10.0
"""Largest factor by which friction may magnify the impulse without a warning. At this factor 1 % more
friction changes the impulse by about 10 %."""


def impulse_caution(contact: ContactRecord, bends_at_once: bool = False) -> str:
    """Return a warning clause if the impulse of a strike is unreliable; empty otherwise.

    The clause names a remedy. ``bends_at_once`` states whether the strike of a flexible wire is
    modelled as instantaneous. In this model the impulse goes to zero as the number of links grows.
    """
    if bends_at_once:
        return (
            ", which is not to be trusted: the impulse of a wire that bends depends on the duration of the contact"
            " (give it one: --set contact=compliant --set contact_duration=0.1ms)"
        )
    excess = contact.friction_magnification
    if contact.law != "engine" and excess > LARGEST_MAGNIFICATION:
        times = f"by {plain_number(excess, 2)}" if excess < 1e6 else "without bound"
        return (
            f", which is not to be trusted: the rigid law breaks down here, where friction multiplies it {times}"
            " (the speeds before the strike hold; --set tangential_compliance=1.21 computes the impulse of an elastic contact of"
            " steel)"
        )
    return ""
