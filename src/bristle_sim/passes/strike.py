"""The strike of many bristles: the state when the tip meets the workpart, the energetic law, and the outcome in words."""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.motion import free_acceleration
from bristle_sim.passes.state import Passes
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.impact_phases import JAM, REBOUND, Impact

OUTCOMES = ("rebounds", "reverses its slip", "sticks and rebounds", "stays", "jams", "does not strike", "refused")
REBOUNDS, REVERSES, STICKS, STAYS, JAMS, MISSES, REFUSED = range(len(OUTCOMES))
"""The outcomes of a pass, and their codes."""


def strike(passes: Passes, values: dict[str, Array], accuracy: float) -> dict[str, Array]:
    """Return the state at the strike, the impulses, and the rate and outcome after it, in SI units.

    Args:
        passes: whose tips are at the workpart.
        values: of the tools' keys.
        accuracy: relative change of the input within which a graze makes the outcome uncertain.
    """
    length = values["bristle_length"]
    speed = values["hub_speed"]
    turn = passes.hub_angle + passes.angle
    sine = np.sin(turn)
    cosine = np.cos(turn)
    spin = 1.0 + passes.rate
    normal = passes.radius * np.sin(passes.hub_angle) + sine * spin
    tangential = passes.radius * np.cos(passes.hub_angle) + cosine * spin
    compliance = 3.0 / values["bristle_mass"]
    matrix = np.array([[sine * sine, sine * cosine], [sine * cosine, cosine * cosine]]) * compliance
    velocity = np.array([normal, tangential]) * length * speed
    later = np.where(np.isnan(values["restitution_friction"]), values["friction"], values["restitution_friction"])
    elastic = values["tangential_compliance"]
    hit = energetic_impact(
        matrix.transpose(2, 0, 1),
        velocity.T,
        values["friction"],
        values["restitution"],
        later,
        tangential_compliance=elastic if elastic.any() else 0.0,
    )
    gained = (sine * hit.impulse_normal + cosine * hit.impulse_tangential) * compliance / length

    # An error of the angle moves the instant of the strike, and with it the state.
    acceleration = free_acceleration(passes, passes.hub_angle, passes.angle, passes.rate)
    shift = np.abs(sine) / np.maximum(-normal, 1e-300)
    error = passes.error * (1.0 + shift * (np.abs(acceleration) / passes.rate_scale + np.abs(spin)))
    bend = np.abs(passes.radius * np.cos(passes.hub_angle) + cosine * spin**2 + sine * acceleration)
    grazes = normal**2 < 2.0 * bend * accuracy
    return {
        "contact_time": (passes.hub_angle - passes.start) / speed,
        "lag_at_contact": -passes.angle,
        "relative_speed_at_contact": passes.rate * speed,
        "tip_speed_at_contact": np.hypot(*velocity),
        "normal_compressive_impulse": hit.compressive_impulse_normal,
        "normal_final_impulse": hit.impulse_normal,
        "tangential_compressive_impulse": hit.compressive_impulse_tangential,
        "final_bristle_rate": speed * spin + gained,
        "error_estimate": np.where(grazes, 1.0, np.minimum(error, 1.0)),
        "outcome": outcome_codes(hit, tangential),
    }


def outcome_codes(hit: Impact, tangential: Array) -> Array:
    """Return the code of each outcome; a point that reverses its slip, or sticks, does so in a phase with an impulse."""
    active = hit.phase_impulse > 0.0
    sense = np.sign(tangential)[:, np.newaxis]
    reverses = (active & (hit.phase_slip * sense < 0.0)).any(axis=-1)
    sticks = (active & (hit.phase_slip == 0.0)).any(axis=-1)
    parted = np.select([reverses, sticks], [REVERSES, STICKS], REBOUNDS)
    return np.where(hit.outcome == JAM, JAMS, np.where(hit.outcome == REBOUND, parted, STAYS))
