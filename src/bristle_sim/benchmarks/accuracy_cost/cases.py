"""The cases of the measurement, each with its exact answer and the source of this answer.

The answer of a case consists of a few numbers. The error of an attempt is its largest difference
from these numbers, each difference over the natural scale of its number.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bristle_sim.parameters import RETRACTION_AT_RELEASE, DoublePendulum, Strike, Surface, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.strike import Chain
from bristle_sim.studies.impacts import double_chain, radial_chain
from bristle_sim.theory import cueing
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.pendulums import double_pendulum_impact
from bristle_sim.trajectory import Trajectory

REFERENCE_ACCURACY = 1e-12
"""Accuracy requested of the reference solution of the whole pass: a hundredth of the finest
accuracy that an attempt requests."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A problem with its exact answer.

    Attributes:
        exact: the answer. A flight has the relative angle (rad) and relative rate (rad/s) at its
            end. A pass has the time (s), the relative angle (rad) and the relative rate (rad/s) at
            the strike on the workpart. A strike has the rates of the rods after the impact (rad/s).
        scale: natural scale of each number of the answer, in the number's unit.
        source: source of the exact answer.
        notes: remarks on how the packages take part, or on why a package takes no part.
        tool: tool of a flight or of a pass.
        retraction: retraction at the start of a flight, rad.
        duration: duration of a flight, s.
    """

    name: str
    title: str
    exact: tuple[float, ...]
    scale: tuple[float, ...]
    source: str
    notes: tuple[str, ...] = ()
    tool: Tool = field(default_factory=Tool)
    retraction: float = 0.0
    duration: float = 0.0

    def error(self, values: Sequence[float]) -> float:
        """Return the largest difference between the values and the exact answer, each over its
        scale.

        The error is infinite if a value is NaN.
        """
        worst = float(np.max(np.abs(np.subtract(values, self.exact)) / self.scale))
        return math.inf if math.isnan(worst) else worst


@dataclass(frozen=True, slots=True, kw_only=True)
class StrikeCase(Case):
    """An impact that obeys the energetic law of restitution."""

    chain: Chain
    surface: Surface
    notes: tuple[str, ...] = (
        "bristle_sim: energetic takes no steps; engine is Newton's law",
        "no other package has energetic restitution",
    )


def release_flight() -> Case:
    """Return the undamped flight on a turning hub from release up to the radial direction.

    The energy integral gives the rate in the radial direction.
    """
    tool = Tool(bar=None, workpart=None)
    retraction = RETRACTION_AT_RELEASE
    bristle = tool.bristle
    hub = tool.hub
    centrifugal = cueing.centrifugal_stiffness(bristle.mass, hub.radius, bristle.length, hub.speed)
    swing = (retraction, tool.belt.stiffness, centrifugal, bristle.inertia_about_root)
    speed = float(cueing.stiffened_highest_speed(*swing))
    return Case(
        name="release_flight",
        title="release and flight to the radial position",
        exact=(0.0, speed),
        scale=(retraction, speed),
        source="energy integral; its quarter period by Gauss-Legendre quadrature",
        notes=(
            "scipy, heyoka: the equation of motion, derived by hand; all others: bodies and joints,"
            " the model built beforehand (but for simulate)",
        ),
        tool=tool,
        retraction=retraction,
        duration=float(cueing.stiffened_cue_time(*swing)),
    )


def strike() -> StrikeCase:
    """Return the radial bristle's oblique strike (Zhang 2020, eqs. 2.19-2.65)."""
    bristle = Tool().bristle
    hub = Tool().hub
    state = Strike()
    surface = Surface()
    gamma = math.radians(state.impact_angle_deg)
    rate = state.speed_ratio * hub.speed
    motion = (hub.radius, hub.speed, state.speed_ratio, gamma)
    exact = monofilament_impact(
        bristle.mass, bristle.length, *motion, surface.friction, surface.restitution
    )
    return StrikeCase(
        name="strike",
        title="one oblique strike",
        exact=(float(exact.final_bristle_rate),),
        scale=(rate,),
        source="Zhang 2020, eq. 2.65",
        chain=radial_chain(hub, bristle, gamma, rate),
        surface=surface,
    )


def double_pendulum() -> StrikeCase:
    """Return the strike of Stronge's double pendulum (Zhang 2020, sec. 2.4.2).

    The rods are identical and stand at 20 and 30 degrees to the normal.
    """
    rods = DoublePendulum()
    surface = Surface(friction=0.5, restitution=0.5)
    chain = double_chain(rods)
    angle_1, angle_2, rate_1, rate_2 = (-each for each in (*chain.angles, *chain.rates))
    law = (surface.friction, surface.restitution)
    exact = double_pendulum_impact(
        rods.mass, rods.mass_ratio, rods.length, angle_1, angle_2, rate_1, rate_2, *law
    )
    return StrikeCase(
        name="double_pendulum",
        title="strike of a double pendulum",
        exact=(-exact.final_rate_1, -exact.final_rate_2),
        scale=(max(map(abs, chain.rates)),) * 2,
        source="Zhang 2020, eqs. 2.66-2.90, followed in generalized speeds",
        chain=chain,
        surface=surface,
    )


@functools.cache
def whole_pass_case() -> Case:
    """Return the pass of the dissertation's tool from the start to the strike.

    The bristle starts radial, 90 degrees before the workpart.
    """
    exact = state_at_strike(
        simulate_reference(Tool(), accuracy=REFERENCE_ACCURACY, stop_after="strike")
    )
    return Case(
        name="whole_pass",
        title="whole pass up to the strike",
        exact=exact,
        scale=(exact[0], RETRACTION_AT_RELEASE, exact[2]),
        source=f"scipy DOP853 in generalized coordinates, accuracy {REFERENCE_ACCURACY:g}",
        notes=(
            "scipy: this project's reference, derived by hand",
            "mujoco: the bar as a damped spring as stiff as the step allows",
        ),
    )


def state_at_strike(run: Trajectory) -> tuple[float, float, float]:
    """Return the state at the first contact with the workpart.

    Returns:
        Time (s), relative angle (rad) and relative rate (rad/s). All three are NaN if there is no
        contact.
    """
    contact = run.first_contact("workpart")
    if contact is None:
        return math.nan, math.nan, math.nan
    hub_angle = float(run.hub_angle[0]) + run.hub_speed * contact.time
    return contact.time, contact.angles[0] - hub_angle, contact.rates_before[0] - run.hub_speed
