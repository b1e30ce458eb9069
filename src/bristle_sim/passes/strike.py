"""The strike of many bristles: state at the workpart, energetic law, and outcome in words."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.motion import free_acceleration
from bristle_sim.passes.state import LEAST, Chosen, Passes
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.impact_phases import JAM, REBOUND, Impact

OUTCOMES = (
    "rebounds",
    "reverses its slip",
    "sticks and rebounds",
    "stays",
    "jams",
    "does not strike",
    "refused",
)
REBOUNDS, REVERSES, STICKS, STAYS, JAMS, MISSES, REFUSED = range(len(OUTCOMES))
"""Outcomes of a pass in words, and their codes."""


class Blow(NamedTuple):
    """The impact of each tip on the workpart.

    Attributes:
        normal, tangential: velocity components of the tip before the impact, m/s.
        impact: result of the impact law.
        gain: change of the wire's angular velocity in the impact, rad/s.
        outcome: code of the outcome.
    """

    normal: Array
    tangential: Array
    impact: Impact
    gain: Array
    outcome: Chosen


def strike(passes: Passes, values: dict[str, Array], accuracy: float) -> dict[str, Array]:
    """Return the results of each strike in SI units, by the names of the attributes of
    ``Ensemble``.

    The impact law is evaluated a second time, with the wire's angle and angular velocity perturbed
    by the accuracy. The relative change of the normal impulse shows how much the impact magnifies
    an error. The error estimate is 1 if the perturbation changes the outcome, or if the tip
    approaches so slowly that an error as small as the accuracy decides whether it touches.

    Args:
        passes: passes whose tips touch the workpart.
        values: values of the tool's keys for each pass.
        accuracy: requested relative accuracy.
    """
    speed = values["hub_speed"]
    blow = _blow(passes, values, 0.0)
    beside = _blow(passes, values, accuracy)
    size = np.hypot(blow.impact.impulse_normal, blow.impact.impulse_tangential)
    change = np.abs(beside.impact.impulse_normal - blow.impact.impulse_normal) / np.maximum(
        size, LEAST
    )

    # An error of the angle shifts the instant of the strike, and so changes the state.
    turn = passes.hub_angle + passes.angle
    spin = 1.0 + passes.rate
    acceleration = free_acceleration(passes, passes.hub_angle, passes.angle, passes.rate)
    normal = np.maximum(-blow.normal / (values["bristle_length"] * speed), LEAST)
    shift = np.abs(np.sin(turn)) / normal
    error = passes.error * (1.0 + shift * (np.abs(acceleration) / passes.rate_scale + np.abs(spin)))
    error *= np.maximum(1.0, change / accuracy)
    bend = np.abs(
        passes.radius * np.cos(passes.hub_angle)
        + np.cos(turn) * spin**2
        + np.sin(turn) * acceleration
    )
    work = blow.impact.compressive_work
    uncertain = (normal**2 < 2.0 * bend * accuracy) | (beside.outcome != blow.outcome)
    return {
        "contact_time": (passes.hub_angle - passes.start) / speed,
        "lag_at_contact": -passes.angle,
        "relative_speed_at_contact": passes.rate * speed,
        "tip_speed_at_contact": np.hypot(blow.normal, blow.tangential),
        "normal_compressive_impulse": blow.impact.compressive_impulse_normal,
        "normal_final_impulse": blow.impact.impulse_normal,
        "tangential_compressive_impulse": blow.impact.compressive_impulse_tangential,
        "normal_compressive_work": work[0],
        "tangential_compressive_work": work[1],
        "entry_angle_at_contact": np.arctan2(-blow.normal, np.abs(blow.tangential)),
        "final_bristle_rate": speed * spin + blow.gain,
        "error_estimate": np.where(uncertain, 1.0, np.minimum(error, 1.0)),
        "outcome": blow.outcome,
    }


def _blow(passes: Passes, values: dict[str, Array], off: float) -> Blow:
    """Return the impact of each wire, computed from a perturbed state.

    The angle is perturbed by ``off`` (rad), and the angular velocity by ``off`` times
    ``passes.rate_scale``.
    """
    length = values["bristle_length"]
    turn = passes.hub_angle + passes.angle + off
    spin = 1.0 + passes.rate + off * passes.rate_scale
    sine = np.sin(turn)
    cosine = np.cos(turn)
    tip_speed = length * values["hub_speed"]
    normal = (passes.radius * np.sin(passes.hub_angle) + sine * spin) * tip_speed
    tangential = (passes.radius * np.cos(passes.hub_angle) + cosine * spin) * tip_speed
    compliance = 3.0 / values["bristle_mass"]
    lever = np.array([sine, cosine])
    friction, later = values["friction"], values["restitution_friction"]
    impact = energetic_impact(
        (lever[:, np.newaxis] * lever * compliance).transpose(2, 0, 1),
        np.array([normal, tangential]).T,
        friction,
        values["restitution"],
        np.where(np.isnan(later), friction, later),
        tangential_compliance=values["tangential_compliance"],
    )
    gain = (sine * impact.impulse_normal + cosine * impact.impulse_tangential) * compliance / length
    return Blow(normal, tangential, impact, gain, outcome_codes(impact))


def outcome_codes(impact: Impact) -> Chosen:
    """Return the code of each pass's outcome.

    A tip counts as reversing its slip, or as sticking, only if it does so in a phase with a
    positive impulse. If a tip sticks from the start of the impact, there is no slip to reverse.
    """
    active = impact.phase_impulse > 0.0
    initial = impact.phase_slip[:, :1]
    reverses = (active & (impact.phase_slip * initial < 0.0)).any(axis=-1)
    sticks = (active & (impact.phase_slip == 0.0)).any(axis=-1)
    parted = np.select([reverses, sticks], [REVERSES, STICKS], REBOUNDS)
    return np.where(impact.outcome == JAM, JAMS, np.where(impact.outcome == REBOUND, parted, STAYS))
