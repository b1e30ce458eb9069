"""Long runs: an undamped bristle swings freely on the turning hub, ten thousand turns on end.

In the hub's frame its energy is constant (Jacobi's integral of the rotating frame),

    E = I alpha'^2/2 + k alpha^2/2 + m r_h l Omega^2 (1 - cos alpha),

with the bristle's inertia I about its root and its centre of mass at the distance l from there. Extrapolated stretches
start from closed joints. Steps of the engine that are not extrapolated leave the pivot open by what a step h bends away
from a straight line, less than (w h)^2 of the bristle's length, and their energy swings by w h while positions and
velocities are half a step apart (w = 1 in a scene's units).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, within
from bristle_sim.parameters import Tool
from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.stepping import PlainSteps, Stepper, SymmetricSteps
from bristle_sim.scene.time_scales import longest_interval, stepper_for
from bristle_sim.scene.tool import build_tool, simulate
from bristle_sim.settings import Settings

__all__ = ["cases", "jacobi_energy", "pivot_gap"]

THEME = "long_run"

RETRACTION = math.radians(44.5)
"""Of the release, at rest relative to the hub."""

DRIFT = 1e-6
"""Energy that may be lost or gained in a turn of the hub, share of the swing's."""

CLOSED = 1e-14
"""Gap of a pivot whose bodies have just been placed, share of the length: rounding of positions, beside that of angles."""

STEP = 0.004
"""Of the engine as it comes, in radians of the fastest motion: its energy drifts with the third power of the step, some
10 h^3 a turn."""

LEAST_SAMPLES = 6
"""Samples in a period of the belt."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Extrapolated stretches, whole runs to two accuracies, and the engine's own steps."""
    turns, few = (10_000, 100) if full else (100, 10)
    steady = f"energy in the hub's frame drifts by {DRIFT:g} a turn at most"
    return (
        HardCase(
            THEME,
            f"{turns} hub turns in extrapolated stretches, accuracy 1e-06",
            f"{steady}; pivot closed to rounding",
            partial(_stretched, turns),
        ),
        *(
            HardCase(
                THEME,
                f"{few} hub turns as a run, accuracy {accuracy:g}",
                f"energy in the hub's frame drifts by {drift:g} a turn at most; pivot closed to rounding",
                partial(_run, accuracy, few, drift),
            )
            for accuracy, drift in ((1e-6, DRIFT), (1e-9, 1e-3 * DRIFT))
        ),
        HardCase(
            THEME,
            f"{few} hub turns, symmetric steps of {STEP:g} rad",
            f"{steady}; pivot open by (w h)^2 of the length at most, last turn as first",
            partial(_symmetric, few),
        ),
        HardCase(
            THEME,
            f"{few} hub turns, plain steps of {STEP:g} rad",
            f"energy within w h and {DRIFT:g} a turn; pivot open by (w h)^2 of the length at most",
            partial(_plain, few),
        ),
    )


def free_tool() -> Tool:
    """The default tool with nothing to touch."""
    return dataclasses.replace(Tool(), bar=None, workpart=None)


def jacobi_energy(tool: Tool, angle: NDArray[np.float64], rate: NDArray[np.float64]) -> NDArray[np.float64]:
    """E in J, from relative angle (rad) and rate (rad/s)."""
    bristle, hub = tool.bristle, tool.hub
    field = bristle.mass * hub.radius * math.hypot(*bristle.centre) * hub.speed**2
    return np.asarray(
        0.5 * bristle.inertia_about_root * rate**2
        + 0.5 * tool.belt.stiffness * angle**2
        + field * (1.0 - np.cos(angle))
    )


def pivot_gap(scene: Scene) -> float:
    """Distance, in lengths of the bristle, of the two places that the root's pivot should hold together."""
    joint = scene.joints[0]
    return abs(joint.a.local_to_world(joint.anchor_a) - joint.b.local_to_world(joint.anchor_b))


def _stretched(turns: int) -> Finding:
    """A scene carried stretch after stretch, as a run does it, without looking for events."""
    tool = free_tool()
    scene, units = build_tool(tool, hub_start=0.0)
    speed = scene.mechanism.hub_speed
    state, end = State(0.0, (-RETRACTION,), (speed,)), turns * math.tau / speed
    stepper = stepper_for(scene, Settings(1e-6, samples_per_period=LEAST_SAMPLES), units, state, end)
    before = _energy(tool, scene, state, units.time)
    while state.time < end * (1.0 - 1e-15):
        length = stepper.propose(min(end - state.time, longest_interval(scene, LEAST_SAMPLES)))
        result = stepper.advance(scene, state, length)
        if stepper.accepts(result, length):
            state = result.state
    drift = (_energy(tool, scene, state, units.time) / before - 1.0) / turns
    return both(within(drift, DRIFT, "drift a turn", scene.steps), _closed(scene, state))


def _run(accuracy: float, turns: int, drift: float) -> Finding:
    """Through the public call, and the bodies where its last state puts them."""
    tool = free_tool()
    settings = Settings(accuracy, maximum_steps=10**9, hub_turn=turns * math.tau, samples_per_period=LEAST_SAMPLES)
    run = simulate(tool, settings, start_relative_angle=-RETRACTION)
    energy = jacobi_energy(tool, run.relative_angle, run.relative_rate)
    scene, units = build_tool(tool)
    last = State(run.time[-1] / units.time, tuple(run.angles[-1]), tuple(run.rates[-1] * units.time))
    return both(
        within((energy[-1] / energy[0] - 1.0) / turns, drift, "drift a turn", run.cost.steps),
        _closed(scene, last),
        Finding(f"{run.hub_angle[-1] - run.hub_angle[0]:.9g} rad turned", run.stop_reason == "end of the planned time"),
    )


def _closed(scene: Scene, state: State) -> Finding:
    """The pivot's gap once the bodies are placed: rounding of places, and of an angle of many turns."""
    scene.place(state)
    return within(pivot_gap(scene), CLOSED + math.ulp(state.angles[0]), "pivot gap")


def _symmetric(turns: int) -> Finding:
    scene, energies, gaps = _carried(SymmetricSteps, turns)
    return both(
        within((energies[-1] / energies[0] - 1.0) / turns, DRIFT, "drift a turn", scene.steps),
        within(gaps[0], STEP**2, "pivot gap in the first turn"),
        within(gaps[-1], STEP**2, "in the last"),
    )


def _plain(turns: int) -> Finding:
    scene, energies, gaps = _carried(PlainSteps, turns)
    strayed = max(abs(energy / energies[0] - 1.0) for energy in energies)
    return both(
        within(strayed, STEP + turns * DRIFT, "energy strays by", scene.steps),
        within(max(gaps), STEP**2, "pivot gap"),
    )


def _carried(steps: Callable[[float], Stepper], turns: int) -> tuple[Scene, list[float], list[float]]:
    """The scene after so many turns, and energy and gap at the end of each, the start's energy first.

    A turn is a whole number of steps: one cut short would close the joints, and disturb the motion.
    """
    tool = free_tool()
    scene, units = build_tool(tool, hub_start=0.0)
    speed = scene.mechanism.hub_speed
    state = State(0.0, (-RETRACTION,), (speed,))
    energies, gaps = [_energy(tool, scene, state, units.time)], []
    count = math.ceil(math.tau / speed / STEP / SymmetricSteps.COUNT)
    stretch = math.tau / speed / count
    stepper = steps(stretch / SymmetricSteps.COUNT)
    for _ in range(turns):
        for _ in range(count):
            reached = state.time + stretch
            while reached - state.time > 1e-9 * stretch:
                state = stepper.advance(scene, state, stepper.propose(stretch)).state
        energies.append(_energy(tool, scene, state, units.time))
        gaps.append(pivot_gap(scene))
    return scene, energies, gaps


def _energy(tool: Tool, scene: Scene, state: State, unit: float) -> float:
    angle = state.angles[0] - scene.mechanism.hub_angle(state.time)
    rate = (state.rates[0] - scene.mechanism.hub_speed) / unit
    return float(jacobi_energy(tool, np.asarray(angle), np.asarray(rate)))
