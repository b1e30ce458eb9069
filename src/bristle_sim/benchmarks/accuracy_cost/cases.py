"""The cases of the measurement, each with its exact answer and the source of this answer.

The answer of a case consists of a few numbers. The error of an attempt is the largest difference
from these numbers, where each difference is divided by a magnitude of its number (``scale``).
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
"""Accuracy requested of the reference solution of the whole pass.

It is a hundredth of the finest accuracy that is requested of an attempt."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A test problem with its exact answer. It is a flight, a strike or a whole pass.

    Angles and angular velocities are those of the bristle relative to the hub, unless stated
    otherwise.

    Attributes:
        name: short name of the case.
        title: name of the case in words.
        exact: the numbers of the exact answer. For a flight they are the angle (rad) and the
            angular velocity (rad/s) at its end. For a pass they are the time (s), the angle (rad)
            and the angular velocity (rad/s) at the strike on the workpart. For a strike they are
            the absolute angular velocities of the rods after the impact (rad/s).
        scale: for each number of the answer, the magnitude by which its error is divided.
        source: how the exact answer is obtained.
        notes: remarks on how each package solves the case, or why a package cannot.
        tool: tool of a flight or of a pass.
        retraction: angle by which the bristle lags the radial direction at the start of a flight,
            rad.
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
        """Return the error of an answer relative to the exact answer.

        The error of each number is its difference from the exact number, divided by its ``scale``.
        The largest of these errors is returned, or infinity if a value is NaN.
        """
        worst = float(np.max(np.abs(np.subtract(values, self.exact)) / self.scale))
        return math.inf if math.isnan(worst) else worst


@dataclass(frozen=True, slots=True, kw_only=True)
class StrikeCase(Case):
    """An impact of the rods ``chain`` on ``surface``, by the energetic law of restitution."""

    chain: Chain
    surface: Surface
    notes: tuple[str, ...] = (
        "bristle_sim: energetic takes no time steps; engine is Newton's law of restitution",
        "no other package has energetic restitution",
    )


def release_flight() -> Case:
    """Return the case of an undamped bristle that is released at rest on a turning hub.

    The flight ends when the bristle is radial. The bristle's exact angular velocity at the end
    follows from the energy integral.
    """
    tool = Tool(bar=None, workpart=None)
    retraction = RETRACTION_AT_RELEASE
    centrifugal = cueing.field_stiffness(tool)
    swing = (retraction, tool.belt.stiffness, centrifugal, tool.bristle.inertia_about_root)
    speed = float(cueing.stiffened_highest_speed(*swing))
    return Case(
        name="release_flight",
        title="release and flight to the radial position",
        exact=(0.0, speed),
        scale=(retraction, speed),
        source="energy integral; its quarter period by Gauss-Legendre quadrature",
        notes=(
            "scipy, heyoka: the equation of motion, derived by hand; all others: bodies and joints;"
            " only simulate builds its model within the measured time",
        ),
        tool=tool,
        retraction=retraction,
        duration=float(cueing.stiffened_cue_time(*swing)),
    )


def strike() -> StrikeCase:
    """Return the case of a single rod, the radial bristle, that strikes obliquely.

    The exact answer follows from eqs. 2.19-2.65 of Zhang (2020).
    """
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
    """Return the case of Stronge's double pendulum that strikes a surface (Zhang 2020, sec. 2.4.2).

    Its two rods are identical and make angles of 20 and 30 degrees with the surface normal.
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
    """Return the case of a pass of the dissertation's tool, from the start to the strike.

    The bristle starts radial, and the hub starts 90 degrees before the workpart's normal.
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
            "scipy: this project's reference, whose equations are derived by hand",
            "mujoco: the bar is a damped spring, as stiff as the time step permits",
        ),
    )


def state_at_strike(run: Trajectory) -> tuple[float, float, float]:
    """Return the bristle's state, relative to the hub, at its first contact with the workpart.

    Returns:
        Time (s), angle (rad) and angular velocity (rad/s). All three are NaN if there is no
        contact.
    """
    contact = run.first_contact("workpart")
    if contact is None:
        return math.nan, math.nan, math.nan
    hub_angle = float(run.hub_angle[0]) + run.hub_speed * contact.time
    return contact.time, contact.angles[0] - hub_angle, contact.rates_before[0] - run.hub_speed
