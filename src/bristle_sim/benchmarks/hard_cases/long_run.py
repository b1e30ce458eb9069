"""Long runs: an undamped bristle swings freely on the turning hub, up to a thousand turns on end.

In the hub's frame its energy is constant (Jacobi's integral of the rotating frame),

    E = I alpha'^2/2 + k alpha^2/2 + m r_h l Omega^2 (1 - cos alpha),

with the bristle's inertia I about its root and its centre of mass at the distance l from there.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, within
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Tool
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings

__all__ = ["jacobi_energy", "long_run"]

FREE = Tool(bar=None, workpart=None)

LEAST_SAMPLES = 6
"""Samples in a period of the belt: fewer are kept than by default."""


def long_run() -> list[HardCase]:
    """Return free swings over many turns of the hub, at two accuracies."""
    return [
        HardCase(
            "long_run",
            f"{turns} hub turns, accuracy {accuracy:g}",
            f"energy in the hub's frame changes by {accuracy:g} a turn at most, the requested accuracy",
            partial(_swings, accuracy, turns),
            turns == 10,
        )
        for turns in (10, 100, 1000)
        for accuracy in (1e-6, 1e-9)
    ]


def jacobi_energy(tool: Tool, angle: NDArray[np.float64], rate: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return E in J, from relative angle (rad) and rate (rad/s)."""
    bristle, hub = tool.bristle, tool.hub
    field = bristle.mass * hub.radius * math.hypot(*bristle.centre) * hub.speed**2
    return np.asarray(
        0.5 * bristle.inertia_about_root * rate**2
        + 0.5 * tool.belt.stiffness * angle**2
        + field * (1.0 - np.cos(angle))
    )


def _swings(accuracy: float, turns: int) -> Finding:
    settings = Settings(accuracy, maximum_steps=10**9, hub_turn=turns * math.tau, samples_per_period=LEAST_SAMPLES)
    run = simulate(FREE, settings, start_relative_angle=-RETRACTION_AT_RELEASE)
    energy = jacobi_energy(FREE, run.relative_angle, run.relative_rate)
    return all_of(
        within((energy[-1] / energy[0] - 1.0) / turns, accuracy, "change a turn", run.cost.steps),
        Finding(f"{run.hub_angle[-1] - run.hub_angle[0]:.9g} rad turned", run.stop_reason == "end of the planned time"),
    )
