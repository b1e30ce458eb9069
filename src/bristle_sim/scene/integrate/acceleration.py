"""The acceleration of a link as a function of the state: the limit of the engine's steps from there.

A difference of rates over an interval has the interval's error, divided by the length of a step. The difference over the
second of two steps from a given state has no such part: it is the acceleration there but for powers of the step, which
extrapolation to zero step removes. (The first step will not do: what the engine's rotary damper does to the joint in one
step is only put right in the next.)
"""

from __future__ import annotations

import math
from operator import mul

from bristle_sim.scene.build import Scene
from bristle_sim.scene.integrate.repetitions import lagrange_weights
from bristle_sim.scene.integrate.time_scales import damping_rate
from bristle_sim.scene.mechanism import State

REACH = 0.3
"""Longest of the steps, in the scene's time units and time constants of the engine's damping. Measured: rounding and what
extrapolation leaves are then some 1e-12 both, times the rate of the damping."""

COUNTS = (1, 2, 3, 4, 5, 6, 8, 10, 12)
"""The steps are this many times shorter."""

WEIGHTS = lagrange_weights(COUNTS)


def acceleration(scene: Scene, state: State, link: int = 0) -> float:
    """Return the acceleration of a link where nothing touches, in engine units."""
    reach = REACH / (1.0 + damping_rate(scene))
    return math.fsum(map(mul, WEIGHTS, (_in_second_step(scene, state, reach / count, link) for count in COUNTS)))


def _in_second_step(scene: Scene, state: State, step: float, link: int) -> float:
    scene.place(state)
    return scene.step(step, 2)[2 * len(scene.links) + link]
