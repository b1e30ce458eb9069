"""A pass in plain engine steps of a fixed length, as a user of the bare engine would take them."""

from __future__ import annotations

import dataclasses
import math

from bristle_sim.parameters import Tool
from bristle_sim.scene.build import Scene, damping_rate, time_scale
from bristle_sim.scene.extrapolation import Extrapolation, IntervalResult
from bristle_sim.scene.load import Load
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.simulate import prepare, run_in_si
from bristle_sim.scene.system import System
from bristle_sim.settings import Settings
from bristle_sim.trajectory import Trajectory

LEAST_CORRECTED_STEP = 1e-6
"""In the scene's time units; shorter steps open joints by less than rounding matters."""

LARGEST_STEP = 1.0
"""Largest engine step, in radians of the fastest motion or time constants of its damping; from 2 on its explicit springs are
unstable, and its damping has half the right value."""


class PlainSteps(Extrapolation):
    """Plain engine steps of a fixed length: first order, without an error estimate.

    In flight the engine corrects the joints, which keeps the energy of the motion. The correction adds velocities, which a load
    such as a sustained contact would take for a force; under a load each step starts from closed joints instead.
    """

    # Twice the deviation of a straight line from the cubic: the engine goes straight on at the old rates.
    interpolation_error = 0.3

    def __init__(self, step: float) -> None:
        """Take steps of a length."""
        super().__init__(step)
        self.step = step
        self._left: tuple[State | None, object, int] = (None, None, 0)

    def propose(self, remaining: float) -> float:
        """Return the length of one step, or the remaining time if that is shorter."""
        return min(self.step, remaining)

    def advance(
        self, scene: Scene, state: State, duration: float, load: Load | None = None
    ) -> IntervalResult:
        """Take one engine step, in flight from where the bodies are if they were left there.

        The correction divides a joint's opening by the step. A shortened step therefore starts from closed joints, and a very
        short one is not corrected.
        """
        end, placed, steps = self._left
        left_here = end is state and placed is scene.placed and steps == scene.engine.steps
        if load is not None or not left_here or duration < self.step:
            scene.place(state)
        correct_joints(scene, completely=load is None and duration > LEAST_CORRECTED_STEP)
        act = None if load is None else load.begin(duration)
        values = scene.step(duration, 1, act) + ([] if load is None else load.totals())
        correct_joints(scene, completely=False)
        failed = load is not None and load.fails(values[3 * len(scene.links) :])
        result = IntervalResult.of(scene, state.time + duration, values, 0.0, failed, {})
        self._left = result.state, scene.placed, scene.engine.steps
        return result

    def accepts(self, result: IntervalResult, duration: float) -> bool:
        """Accept every interval: return True."""
        del result, duration
        return True

    def halves(self, scene: Scene, load: Load | None) -> bool:
        """Return False: a step has no middle."""
        del scene, load
        return False


def correct_joints(scene: Scene, *, completely: bool) -> None:
    """Choose whether every engine step closes the joints or leaves them alone."""
    for joint in scene.joints:
        joint.error_bias = 0.0 if completely else 1.0


def simulate_in_steps(
    tool: Tool,
    step: float,
    settings: Settings | None = None,
    *,
    start_hub_angle: float | None = None,
    start_relative_angle: float = 0.0,
    stop_after: str | None = None,
) -> Trajectory:
    """Simulate a rigid bristle as :func:`bristle_sim.simulate` does, but in plain engine steps of a fixed length, s.

    Raises:
        ValueError: also if the step is too long for this tool.
    """
    settings = settings or Settings()
    begin = (start_hub_angle, start_relative_angle, 0.0)
    given, units, parameters = prepare(tool, settings, begin, stop_after=stop_after)
    scene = given.scene
    fastest = max(1.0 / time_scale(scene), damping_rate(scene))
    largest = min(2.0 * math.pi / settings.samples, LARGEST_STEP) / fastest * units.time
    if not 0.0 < step <= largest:
        raise ValueError(
            f"step = {step:g}: must be at most {largest:g} with this belt, hub speed and bristle (in s)"
        )
    system = System(scene, given.state, PlainSteps(step / units.time), given.plan, law=given.law)
    (run,) = run_in_si(tool, system, units, parameters)
    return dataclasses.replace(run, cost=dataclasses.replace(run.cost, error_estimate=None))
