"""Passes in plain engine steps of a fixed length, as taken without an integrator around the
engine."""

from __future__ import annotations

import dataclasses
import math

from bristle_sim.parameters import Tool
from bristle_sim.scene.build import Scene, damping_rate, time_scale
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.interval import IntervalResult, Load
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.simulate import prepare, run_in_si
from bristle_sim.scene.system import System
from bristle_sim.settings import Settings
from bristle_sim.trajectory import Trajectory

LEAST_CORRECTED_STEP = 1e-6
"""Shortest step with joint correction, in the scene's time units.

A shorter step opens a joint by no more than rounding."""

LARGEST_STEP = 1.0
"""Largest engine step times the highest natural frequency or damping rate, 1.

From 2 on the engine's explicit springs are unstable, and its damping has half the right value."""


class PlainSteps(Extrapolation):
    """Plain engine steps of a fixed length: first order, without an error estimate.

    In flight the engine corrects the joints, which keeps the energy of the motion. The correction
    adds velocities. A load, as of a sustained contact, would take these velocities for the effect
    of a force. Each step under a load therefore starts from closed joints, without the correction.
    """

    # Twice the deviation of a straight line from the cubic: the engine goes straight on at the old rates.
    interpolation_error = 0.3

    def __init__(self, step: float) -> None:
        """Take steps of the length ``step``, in the scene's time units."""
        super().__init__(step)
        self.step = step
        self._left: tuple[State | None, object, int] = (None, None, 0)

    def propose(self, remaining: float) -> float:
        """Return the length of one step, or the remaining time if that is shorter."""
        return min(self.step, remaining)

    def advance(
        self, scene: Scene, state: State, duration: float, load: Load | None = None
    ) -> IntervalResult:
        """Take one engine step; in flight it starts from the bodies as the step before left them.

        The engine's correction divides a joint's opening by the step. A shortened step therefore
        starts from closed joints, and the joints of a very short step are not corrected.
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
        """Return True: without an error estimate every interval is accepted."""
        del result, duration
        return True

    def halves(self, scene: Scene, load: Load | None) -> bool:
        """Return False: one engine step has no state at its middle."""
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
    """Simulate a rigid bristle as :func:`bristle_sim.simulate` does, but by plain engine steps.

    Args:
        step: length of every engine step, s. The other arguments are those of ``simulate``.

    Raises:
        ValueError: as ``simulate``, or if the step is too long for the tool.
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
