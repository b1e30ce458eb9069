"""Comparisons of simulations with the reference solution, the energy integral and closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, TypedDict

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, all_of, within, worst
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Contact, Surface, Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.theory.cueing import stiffened_cue
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.pendulums import double_pendulum_impact
from bristle_sim.trajectory import ContactRecord, Trajectory

ACCURACY = Settings().accuracy
"""Default requested accuracy: largest permitted error, relative to the size of the motion."""

MORE_ACCURATE = 1e-3
"""Ratio of the reference's requested accuracy to that of the compared run."""

AS_REFERENCE = "last state and strike as in the reference, to {:g}, the requested accuracy"
"""Promise of a case that is compared with the reference; the number is the tolerance."""

IMPACT_LAWS = ("energetic", "compliant", "engine")
"""Laws of contact records that are impacts; all other records are sustained contacts."""


class Start(TypedDict, total=False):
    """Angles (rad) and relative angular velocity (rad/s) at the start of a run.

    An absent entry takes the default of the simulation.
    """

    start_hub_angle: float
    start_relative_angle: float
    start_relative_rate: float


RELEASED: Start = {"start_relative_angle": -RETRACTION_AT_RELEASE}
"""State at the start of a bristle that is released at rest relative to the hub."""


def impacts_of(run: Trajectory, obstacle: str) -> list[ContactRecord]:
    """Return the impacts on an obstacle in a run, in order of time."""
    return [each for each in run.contacts if each.law in IMPACT_LAWS and each.obstacle == obstacle]


def agrees_with_reference(
    tool: Tool,
    limit: float = ACCURACY,
    *,
    start: Start | None = None,
    stop_after: str | None = None,
    hub_turn: float = 1.5 * math.pi,
) -> Finding:
    """Check that a simulation agrees with the reference solution.

    The stop reasons must be equal. The last states and the first strikes must agree within
    ``limit``, which is also the accuracy requested of the simulation.
    """
    # Imported here, so that themes without a reference do not load its integrator.
    from bristle_sim.reference import simulate_reference

    given: dict[str, Any] = {**(start or {}), "stop_after": stop_after}
    run = simulate(tool, Settings(limit, maximum_steps=1_000_000, hub_turn=hub_turn), **given)
    other = simulate_reference(tool, accuracy=MORE_ACCURATE * limit, hub_turn=hub_turn, **given)
    fastest = float(np.abs(other.rates).max()) or 1.0
    off = [
        float(run.time[-1] / other.time[-1] - 1.0),
        float(run.relative_angle[-1] - other.relative_angle[-1]),
        float(run.relative_rate[-1] - other.relative_rate[-1]) / fastest,
        *_strike_difference(run, other),
    ]
    alike = Finding(run.stop_reason, run.stop_reason is other.stop_reason)
    return all_of(alike, within(worst(off), limit, "off by", run.cost.steps))


def _strike_difference(run: Trajectory, other: Trajectory) -> list[float]:
    """Return the relative differences between the first strikes of two runs.

    They are those of time, angle, angular velocities before and after, and impulse. The list holds
    NaN if only one run has a strike; it is empty if neither has.
    """
    one, two = run.first_contact("workpart"), other.first_contact("workpart")
    if one is None or two is None:
        return [] if one is two else [math.nan]
    fastest = max(map(abs, (*two.rates_before, *two.rates_after)))
    size = abs(two.impulse[0]) or 1.0
    return [
        (one.time - two.time) / float(other.time[-1]),
        one.angles[0] - two.angles[0],
        (one.rates_before[0] - two.rates_before[0]) / fastest,
        (one.rates_after[0] - two.rates_after[0]) / fastest,
        *((a - b) / size for a, b in zip(one.impulse, two.impulse, strict=True)),
    ]


def agrees_with_energy_integral(tool: Tool, accuracy: float) -> Finding:
    """Check the highest angular velocity after an undamped release from rest, and its time.

    The expected values follow from the energy integral.
    """
    run = simulate(
        tool, Settings(accuracy=accuracy), **RELEASED, stop_after="highest relative speed"
    )
    expected = stiffened_cue(replace(Tool(), hub=tool.hub, belt=tool.belt, bristle=tool.bristle))
    late = float(run.time[-1]) / expected.cue_time - 1.0
    fast = float(run.relative_rate[-1]) / expected.highest_relative_speed - 1.0
    return within(worst([late, fast]), accuracy, "off by", run.cost.steps)


def agrees_with_closed_form(strikes: list[tuple[Chain, float, float]], limit: float) -> Finding:
    """Check simulated strikes of one or two rods against the closed forms (Zhang 2020, ch. 2).

    Args:
        strikes: for each strike, the rods, the coefficient of friction and that of restitution.
        limit: largest permitted relative difference.
    """
    off = []
    alike = True
    for chain, friction, e in strikes:
        contact = strike(chain, Surface(friction, None, e), Contact(), Settings()).contact
        rates, impulse, outcome = _closed_form(chain, friction, e)
        alike &= contact.outcome == outcome
        off += [
            worst(np.subtract(contact.rates_after, rates)) / worst((*chain.rates, *rates)),
            contact.impulse[0] / impulse - 1.0,
        ]
    return all_of(
        within(worst(off), limit, "off by"),
        Finding(f"outcomes {'equal' if alike else 'different'}", alike),
    )


def _closed_form(
    chain: Chain, friction: float, restitution: float
) -> tuple[tuple[float, ...], float, str]:
    """Return the result of a strike of one or two rods by its closed form.

    Returns:
        Angular velocities after the impact (rad/s), normal impulse (N s) and name of the outcome.
    """
    mass = chain.masses[-1]
    length = chain.lengths[0]
    if len(chain.masses) == 1:
        radial = (0.0, chain.rates[0], 1.0, -chain.angles[0])
        one = monofilament_impact(mass, length, *radial, friction, restitution)
        return (float(one.final_bristle_rate),), float(one.normal_final_impulse), one.outcome_name
    angle_1, angle_2, rate_1, rate_2 = (-each for each in (*chain.angles, *chain.rates))
    motion = (angle_1, angle_2, rate_1, rate_2)
    ratio = chain.masses[0] / mass
    two = double_pendulum_impact(mass, ratio, length, *motion, friction, restitution)
    return (
        (-float(two.final_rate_1), -float(two.final_rate_2)),
        float(two.normal_final_impulse),
        two.outcome,
    )
