"""A bristle's contact of a given compression time, and perhaps of a given impulse.

A contact of 50 us is not the instant of chapter 2: meanwhile the hub turns by 0.75 deg and the bristle by more, so its impulse
and duration differ from the rigid-body limit by some per cent. Speed and stiffness are therefore adjusted until the contact in
the scene has what is requested.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity
from bristle_sim.parameters import Bristle, Contact, Hub, Surface
from bristle_sim.scene.strike import ChainStrike, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_course import TimedContact, compression_end
from bristle_sim.studies.impacts import Impacts, radial_chain
from bristle_sim.studies.strike_point import outcome_of
from bristle_sim.theory.monofilament import normal_compressive_impulse

Result = TypeVar("Result")

REQUEST_TOLERANCE = 1e-6
"""Least relative difference from the request at which the adjustment ends, or the accuracy if that is coarser."""

MOST_ROUNDS = 30
"""Rounds of adjustment; five to ten are usual."""

LARGEST_STEP = 0.5
"""Largest change of the logarithm of speed or duration in a round."""

WORK_TOLERANCE = 1e-4
"""Relative difference between the work of the force and the energy given up: cubics through some thirty samples of a half wave
leave (pi/30)^4/180 = 7e-7 of a work, more where the hub turns by degrees meanwhile or the last piece is short; six samples of
its velocities leave 5e-5."""

PRINTED_COMPRESSION = 5e-5
"""Compression time of a bristle's strike, s (Zhang 2020, sec. 3.3)."""


def resultant_impulse(mass: float, tip_speed: float, impact_angle: float, friction: float) -> float:
    """Return the impulse p_c of the rigid-body impact (Zhang 2020, eqs. 2.37, 2.56 and 3.8), N s."""
    return math.hypot(1.0, friction) * float(normal_compressive_impulse(mass, tip_speed, impact_angle, friction))


def timed_contact(
    hub: Hub,
    bristle: Bristle,
    surface: Surface,
    impact_angle: float,
    settings: Settings,
    *,
    compression_time: float,
    rate: float | None = None,
    impulse: float | None = None,
) -> TimedContact:
    """Simulate a strike whose contact has the given compression time, s.

    The impact angle is in rad. Either the rate of the bristle, rad/s, or the compressive impulse, N s, must be given; for an
    impulse the rate is found.

    Raises ValueError if there is no such contact.
    """
    if (rate is None) == (impulse is None):
        raise ValueError("rate, impulse: must be exactly one of the two")
    requested, speed = [compression_time], bristle.length * (rate or 0.0) + hub.radius * hub.speed
    if impulse is not None:
        requested = [compression_time, impulse]
        speed = impulse / resultant_impulse(bristle.mass, 1.0, impact_angle, surface.friction)

    def struck(duration: float, speed: float) -> tuple[TimedContact, tuple[float, float]]:
        if not duration * max(speed, hub.speed * hub.radius, hub.speed * bristle.length) <= bristle.length:
            raise ValueError(
                f"compression_time: must be shorter; in {duration:g} s of contact tip or hub move by more than"
                " the bristle's length"
            )
        chain = radial_chain(hub, bristle, impact_angle, (speed - hub.radius * hub.speed) / bristle.length)
        found = strike(chain, surface, Contact("compliant", duration), settings)
        record, values = found.contact, (0.0, 0.0)
        contact = TimedContact(bristle, surface, chain, record, found.steps, found.wall_s)
        if record.history is not None and record.history.normal_force.max() > 0.0:
            values = contact.compression_time, contact.compressive_impulse
        if not min(values) > 0.0:
            raise ValueError(f"speed_ratio: must let the tip strike; this one approaches at {speed:g} m/s")
        return contact, values

    # The spring is 1/e*^2 stiffer in restitution, and the tip yields to it in proportion to s_2 instead of s_1.
    cosine, sine = math.cos(impact_angle), math.sin(impact_angle)
    leaving, whole = sine - surface.friction_in_restitution * cosine, 1.0
    if leaving > 0.0:
        whole += surface.restitution * math.sqrt((sine + surface.friction * cosine) / leaving)
    given = np.array([compression_time * whole, speed])
    return _adjusted(struck, given, np.array(requested), max(REQUEST_TOLERANCE, settings.accuracy))


def contact_fields(contact: TimedContact | None, **later: float) -> dict[str, Any]:
    """Return outcome, phases, cost and events of a report on a contact, and later events by name, s."""
    if contact is None:
        return {"outcome": "no contact"}
    return {
        "outcome": outcome_of(contact.record),
        "phases": contact.record.phases,
        "events": (("strike", 0.0), ("deepest", contact.compression_time), *later.items()),
        "wall_s": contact.wall_s,
        "steps": contact.steps,
    }


def work_row(contact: TimedContact) -> Quantity:
    """Compare the work of the force over the path with the energy given up."""
    words, given = "work of the force", contact.energy_given_up
    return Quantity("contact_work", "J", -contact.work, given, tolerance=WORK_TOLERANCE, label=words)


def with_visible_contact(impacts: Impacts, settings: Settings | None = None) -> Impacts:
    """Give the contact resolved in time the printed 50 us of compression, for films, unless a duration was requested.

    The contact of the report is so short that the rods stand still meanwhile (the rigid-body limit): nanometres and
    meganewtons. Where 50 us are too short or too long for these rods, it stays so, and ``timing`` says it.
    """
    if impacts.contact_duration is not None and impacts.law == "compliant":
        return dataclasses.replace(impacts, timing="contact_duration as requested")
    limit = dataclasses.replace(impacts, timing="rigid-body limit")
    found, duration = impacts.strikes.get("compliant"), 2.0 * PRINTED_COMPRESSION
    if found is None or math.hypot(*found.contact.velocity_before) * duration > min(impacts.chain.lengths):
        return limit

    def struck(duration: float) -> tuple[ChainStrike, tuple[float]]:
        found = strike(impacts.chain, impacts.surface, Contact("compliant", duration), settings or Settings())
        if found.contact.history is None:
            raise ValueError("contact: must be resolved in time")
        return found, (compression_end(found.contact.history),)

    try:
        visible = _adjusted(struck, np.array([duration]), np.array([PRINTED_COMPRESSION]), REQUEST_TOLERANCE)
    except ValueError:
        return limit
    strikes = {**impacts.strikes, "compliant": visible}
    return dataclasses.replace(impacts, strikes=strikes, timing="as printed, for the film")


def _adjusted(
    struck: Callable[..., tuple[Result, tuple[float, ...]]], given: Array, wanted: Array, tolerance: float
) -> Result:
    """Return the result whose values are those wanted, by Broyden's method in the logarithms of as many numbers given."""
    free, slopes = len(wanted), np.eye(len(wanted))
    step = before = np.zeros(free)
    for _ in range(MOST_ROUNDS):
        found, values = struck(*given.tolist())
        missing = np.log(wanted / np.array(values[:free]))
        if np.all(np.abs(missing) <= tolerance):
            return found
        if step.any():
            slopes += np.outer(before - missing - slopes @ step, step) / float(step @ step)
        step, before = np.clip(np.linalg.solve(slopes, missing), -LARGEST_STEP, LARGEST_STEP), missing
        given[:free] *= np.exp(step)
    raise ValueError(f"compression_time = {wanted[0]:g}: must be shorter, as the hub turns too far meanwhile (in s)")
