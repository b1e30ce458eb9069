"""Attempts of this project at the cases, by the public functions and by the steppers below them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import Case, StrikeCase, state_at_strike
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run, attempts
from bristle_sim.benchmarks.accuracy_cost.plain_steps import correct_joints, simulate_in_steps
from bristle_sim.parameters import Contact
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import strike
from bristle_sim.scene.tool import build_tool
from bristle_sim.settings import Settings

ACCURACIES = tuple(10.0**-power for power in range(1, 12))
STEP_COUNTS = tuple(2**power for power in range(1, 15))
STEPS_OF_A_PASS = (4e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6)
"""Lengths of plain engine steps in a pass, s."""
PASSES = 4096
"""Number of passes that are computed at once in arrays."""


def flight_attempts(case: Case) -> list[Attempt]:
    """Return attempts at a flight by the public function and by steppers on a scene.

    The steppers share a scene that is built before the timing, as other packages compile their
    models.
    """
    scene, units = build_tool(case.tool, hub_start=0.0)
    start, end = (
        State(0.0, (-case.retraction,), (scene.mechanism.hub_speed,)),
        case.duration / units.time,
    )

    def simulated(accuracy: float) -> Run:
        """Simulate the flight by the public function at a requested accuracy."""
        settings = Settings(accuracy=accuracy, hub_turn=case.tool.hub.speed * case.duration)
        run = simulate(case.tool, settings, start_relative_angle=-case.retraction)
        return Run((float(run.relative_angle[-1]), float(run.relative_rate[-1])), run.cost.steps)

    def extrapolated(tolerance: float) -> Run:
        """Integrate the flight by intervals of the length that the extrapolation stepper
        proposes."""
        stepper = Extrapolation(tolerance)
        state = start
        before = scene.engine.steps
        while state.time < end * (1.0 - 1e-15):
            length = stepper.propose(end - state.time)
            result = stepper.advance(scene, state, length)
            if stepper.accepts(result, length):
                state = result.state
        return flown(state.angles[0], state.rates[0], before)

    def plain(count: int) -> Run:
        """Integrate the flight by equal engine steps, with the engine's own correction of the
        joints.
        """
        before = scene.engine.steps
        scene.place(start)
        correct_joints(scene, completely=True)
        scene.step(end / count, count)
        correct_joints(scene, completely=False)
        return flown(scene.angles()[0], scene.rates()[0], before)

    def flown(angle: float, rate: float, before: int) -> Run:
        """Return the relative angle (rad), the relative rate (rad/s) and the steps since
        ``before``.
        """
        hub_angle = scene.mechanism.hub_angle(end)
        hub_speed = scene.mechanism.hub_speed
        return Run(
            (angle - hub_angle, (rate - hub_speed) / units.time), scene.engine.steps - before
        )

    return [
        *attempts("bristle_sim simulate", "accuracy={:g}", simulated, ACCURACIES),
        *attempts("bristle_sim extrapolation", "tolerance={:g}", extrapolated, ACCURACIES),
        *attempts("bristle_sim plain steps", "steps={}", plain, STEP_COUNTS),
    ]


def strike_attempts(case: StrikeCase) -> list[Attempt]:
    """Return attempts at a strike by each contact law; the compliant law has several accuracies."""

    def by_law(law: str) -> Callable[[float], Run]:
        """Return the function that strikes by a contact law at a requested accuracy."""

        def run(accuracy: float) -> Run:
            found = strike(case.chain, case.surface, Contact(law), Settings(accuracy=accuracy))
            return Run(found.contact.rates_after, found.steps)

        return run

    return [
        *attempts("bristle_sim energetic", "closed phases", by_law("energetic"), (1e-6,)),
        *attempts("bristle_sim engine", "one step", by_law("engine"), (1e-6,)),
        *attempts("bristle_sim compliant", "accuracy={:g}", by_law("compliant"), ACCURACIES[:7]),
    ]


def pass_attempts(case: Case) -> list[Attempt]:
    """Return attempts at a pass by the public function, and by plain engine steps of a given
    length.
    """

    def passed(setting: Any, run: Callable[..., Any]) -> Run:
        found = run(case.tool, setting, stop_after="strike")
        return Run(state_at_strike(found), found.cost.steps)

    def in_arrays(accuracy: float) -> Run:
        """Compute the pass many times at once."""
        many = ensemble(case.tool, accuracy=accuracy, hub_speed=[case.tool.hub.speed] * PASSES)
        columns = (many.contact_time, -many.lag_at_contact, many.relative_speed_at_contact)
        return Run(tuple(float(each[0]) for each in columns), 0)

    blocks = attempts("bristle_sim ensemble", "accuracy={:g}", in_arrays, ACCURACIES[1:10:4])
    return [
        *attempts(
            "bristle_sim simulate",
            "accuracy={:g}",
            lambda e: passed(Settings(e), simulate),
            ACCURACIES[:10],
        ),
        *(dataclasses.replace(each, passes=PASSES) for each in blocks),
        *attempts(
            "bristle_sim plain steps",
            "step={:g} s",
            lambda dt: passed(dt, simulate_in_steps),
            STEPS_OF_A_PASS,
        ),
    ]
