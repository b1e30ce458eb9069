"""The strike of many bristles: state at the workpart, energetic law, and outcome in words."""

from __future__ import annotations

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
    speed, length = values["hub_speed"], values["bristle_length"]
    compliance = 3.0 / values["bristle_mass"]
    friction, later = values["friction"], values["restitution_friction"]
    # the second row of each array is perturbed
    off = accuracy * np.array([[0.0], [1.0]])
    turn = passes.hub_angle + passes.angle + off
    spin = 1.0 + passes.rate + off * passes.rate_scale
    lever = np.stack([np.sin(turn), np.cos(turn)], axis=-1)
    root = np.stack([np.sin(passes.hub_angle), np.cos(passes.hub_angle)], axis=-1)
    motion = passes.radius[:, np.newaxis] * root + lever * spin[..., np.newaxis]
    impact = energetic_impact(
        lever[..., np.newaxis] * lever[..., np.newaxis, :] * compliance[:, np.newaxis, np.newaxis],
        motion * (length * speed)[:, np.newaxis],
        friction,
        values["restitution"],
        np.where(np.isnan(later), friction, later),
        tangential_compliance=values["tangential_compliance"],
    )
    outcome, beside = outcome_codes(impact)
    normal_impulse, tangential_impulse = impact.impulse_normal, impact.impulse_tangential
    size = np.maximum(np.hypot(normal_impulse[0], tangential_impulse[0]), LEAST)
    change = np.abs(normal_impulse[1] - normal_impulse[0]) / size
    compressive_work = impact.compressive_work
    sine, cosine = lever[0].T
    normal, tangential = motion[0].T
    gain = (sine * normal_impulse[0] + cosine * tangential_impulse[0]) * compliance / length

    # An error of the angle shifts the instant of the strike, and so changes the state.
    acceleration = free_acceleration(passes, passes.hub_angle, passes.angle, passes.rate)
    shift = np.abs(sine) / np.maximum(-normal, LEAST)
    error = passes.error * (
        1.0 + shift * (np.abs(acceleration) / passes.rate_scale + np.abs(spin[0]))
    )
    error *= np.maximum(1.0, change / accuracy)
    bend = np.abs(passes.radius * root[:, 1] + cosine * spin[0] ** 2 + sine * acceleration)
    uncertain = (normal**2 < 2.0 * bend * accuracy) | (beside != outcome)
    return {
        "contact_time": (passes.hub_angle - passes.start) / speed,
        "lag_at_contact": -passes.angle,
        "relative_speed_at_contact": passes.rate * speed,
        "tip_speed_at_contact": np.hypot(normal, tangential) * length * speed,
        "normal_compressive_impulse": impact.compressive_impulse_normal[0],
        "normal_final_impulse": normal_impulse[0],
        "tangential_compressive_impulse": impact.compressive_impulse_tangential[0],
        "normal_compressive_work": compressive_work[0][0],
        "tangential_compressive_work": compressive_work[1][0],
        "entry_angle_at_contact": np.arctan2(-normal, np.abs(tangential)),
        "final_bristle_rate": speed * spin[0] + gain,
        "error_estimate": np.where(uncertain, 1.0, np.minimum(error, 1.0)),
        "outcome": outcome,
    }


def outcome_codes(impact: Impact) -> Chosen:
    """Return the code of each pass's outcome.

    A tip counts as reversing its slip, or as sticking, only if it does so in a phase with a
    positive impulse. If a tip sticks from the start of the impact, there is no slip to reverse.
    """
    active = impact.phase_impulse > 0.0
    initial = impact.phase_slip[..., :1]
    reverses = (active & (impact.phase_slip * initial < 0.0)).any(axis=-1)
    sticks = (active & (impact.phase_slip == 0.0)).any(axis=-1)
    parted = np.select([reverses, sticks], [REVERSES, STICKS], REBOUNDS)
    return np.where(impact.outcome == JAM, JAMS, np.where(impact.outcome == REBOUND, parted, STAYS))
