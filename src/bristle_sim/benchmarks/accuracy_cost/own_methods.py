"""This project's own methods at the cases, through the functions that a user calls and through its steppers."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterable
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import FlightCase, PassCase, StrikeCase, state_at_strike
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.parameters import Contact
from bristle_sim.scene.contact.compliant import PLAIN_ACCURACY, CompliantLaw
from bristle_sim.scene.integrate.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.strike import build_strike, strike, struck
from bristle_sim.scene.tool import build_tool, simulate, simulate_in_steps
from bristle_sim.settings import Settings
from bristle_sim.trajectory import Trajectory

ACCURACIES = tuple(10.0**-power for power in range(1, 12))
STEP_COUNTS = tuple(2**power for power in range(1, 15))


def _attempts(method: str, setting: str, run: Callable[[Any], Run], values: Iterable[float]) -> list[Attempt]:
    """Return an attempt for each value of a method's setting."""
    return [Attempt(f"bristle_sim {method}", setting.format(value), functools.partial(run, value)) for value in values]


def flight_attempts(case: FlightCase) -> list[Attempt]:
    """Return the public call; and each stepper with a scene that is built beforehand, as other tools compile a model."""
    flight = _Flight(case)
    return [
        *_attempts("simulate", "accuracy={:g}", functools.partial(_simulated_flight, case), ACCURACIES),
        *_attempts("extrapolation", "tolerance={:g}", flight.extrapolated, ACCURACIES),
        *_attempts("plain steps", "steps={}", flight.plain, STEP_COUNTS),
    ]


def _simulated_flight(case: FlightCase, accuracy: float) -> Run:
    settings = Settings(accuracy=accuracy, hub_turn=case.tool.hub.speed * case.duration)
    run = simulate(case.tool, settings, start_relative_angle=-case.retraction)
    return Run((float(run.relative_angle[-1]), float(run.relative_rate[-1])), run.cost.steps)


class _Flight:
    """A scene at rest relative to the hub, ready to be carried over the flight."""

    def __init__(self, case: FlightCase) -> None:
        self.scene, self.units = build_tool(case.tool, hub_start=0.0)
        self.start = State(0.0, (-case.retraction,), (self.scene.mechanism.hub_speed,))
        self.end = case.duration / self.units.time

    def extrapolated(self, tolerance: float) -> Run:
        """Carry the scene interval after interval, as long as the stepper proposes them."""
        stepper, state, before = Extrapolation(tolerance), self.start, self.scene.steps
        while state.time < self.end * (1.0 - 1e-15):
            length = stepper.propose(self.end - state.time)
            result = stepper.advance(self.scene, state, length)
            if stepper.accepts(result, length):
                state = result.state
        return self._run(state.angles[0], state.rates[0], before)

    def plain(self, count: int) -> Run:
        """Carry the scene in equal steps of the engine as it comes, with joints that it corrects."""
        before = self.scene.steps
        self.scene.place(self.start)
        self.scene.correct_joints(completely=True)
        self.scene.step(self.end / count, count)
        self.scene.correct_joints(completely=False)
        return self._run(self.scene.angles()[0], self.scene.rates()[0], before)

    def _run(self, angle: float, rate: float, before: int) -> Run:
        hub_angle, hub_speed = self.scene.mechanism.hub_angle(self.end), self.scene.mechanism.hub_speed
        return Run((angle - hub_angle, (rate - hub_speed) / self.units.time), self.scene.steps - before)


def strike_attempts(case: StrikeCase) -> list[Attempt]:
    """Return each contact law; the compliant one at several accuracies and with plain engine steps."""
    struck = functools.partial(_struck, case)
    return [
        Attempt("bristle_sim energetic", "closed phases", functools.partial(struck, "energetic", 1e-6)),
        Attempt("bristle_sim engine", "one step", functools.partial(struck, "engine", 1e-6)),
        *_attempts("compliant", "accuracy={:g}", functools.partial(struck, "compliant"), ACCURACIES[:7]),
        *_attempts("compliant steps", "steps={}", functools.partial(_struck_in_steps, case), STEP_COUNTS[4:11]),
    ]


def _struck(case: StrikeCase, law: str, accuracy: float) -> Run:
    found = strike(case.chain, case.surface, Contact(law), Settings(accuracy=accuracy))
    return Run(found.contact.rates_after, found.steps)


def _struck_in_steps(case: StrikeCase, count: int) -> Run:
    scene, start, obstacle, units = build_strike(case.chain, case.surface)
    law = CompliantLaw(None, PLAIN_ACCURACY, count)
    _, record, _ = struck(scene, start, dataclasses.replace(obstacle, law=law), Settings())
    return Run(tuple(rate / units.time for rate in record.rates_after), scene.steps)


def pass_attempts(case: PassCase) -> list[Attempt]:
    """Return the public call, extrapolated and with plain engine steps of a given length."""
    steps = (4e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6)
    return [
        *_attempts(
            "simulate",
            "accuracy={:g}",
            lambda each: _passed(simulate(case.tool, Settings(each), stop_after="strike")),
            ACCURACIES[:10],
        ),
        *_attempts(
            "plain steps",
            "step={:g} s",
            lambda each: _passed(simulate_in_steps(case.tool, each, stop_after="strike")),
            steps,
        ),
    ]


def _passed(run: Trajectory) -> Run:
    return Run(state_at_strike(run), run.cost.steps)
