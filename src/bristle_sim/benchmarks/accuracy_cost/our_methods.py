"""This project's own methods at the cases, through the functions that a user calls."""

from __future__ import annotations

import functools
from collections.abc import Callable

from bristle_sim.benchmarks.accuracy_cost.cases import FlightCase, PassCase, StrikeCase, state_at_strike
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.parameters import Contact
from bristle_sim.scene.build import Scene
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.stepping import Stepper, SymmetricSteps
from bristle_sim.scene.strike import strike
from bristle_sim.scene.tool import build_tool, simulate
from bristle_sim.scene.units import Units
from bristle_sim.settings import Settings
from bristle_sim.studies.law_convergence import RIGID, strike_by

__all__ = ["flight_attempts", "pass_attempts", "strike_attempts"]

ACCURACIES = tuple(10.0**-power for power in range(1, 12))
STEP_COUNTS = (2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384)


def flight_attempts(case: FlightCase) -> list[Attempt]:
    """The public call; and a scene built beforehand, as other tools compile a model, carried by each stepper."""
    flight = _Flight(case)
    whole = [
        Attempt("bristle_sim simulate", f"accuracy={accuracy:g}", functools.partial(_simulated_flight, case, accuracy))
        for accuracy in ACCURACIES
    ]
    extrapolated = [
        Attempt(
            "bristle_sim extrapolation",
            f"tolerance={accuracy:g}",
            functools.partial(flight.carry, functools.partial(Extrapolation, accuracy)),
        )
        for accuracy in ACCURACIES
    ]
    symmetric = [
        Attempt("bristle_sim symmetric steps", f"steps={count}", functools.partial(flight.symmetric, count))
        for count in STEP_COUNTS
    ]
    plain = [
        Attempt("bristle_sim plain steps", f"steps={count}", functools.partial(flight.plain, count))
        for count in STEP_COUNTS
    ]
    return [*whole, *extrapolated, *symmetric, *plain]


def _simulated_flight(case: FlightCase, accuracy: float) -> Run:
    settings = Settings(accuracy=accuracy, hub_turn=case.tool.hub.speed * case.duration)
    run = simulate(case.tool, settings, start_relative_angle=-case.retraction)
    return Run((float(run.relative_angle[-1]), float(run.relative_rate[-1])), run.cost.steps)


class _Flight:
    """A scene at rest relative to the hub, ready to be carried over the flight."""

    def __init__(self, case: FlightCase) -> None:
        self.scene: Scene
        self.units: Units
        self.scene, self.units = build_tool(case.tool, hub_start=0.0)
        self.start = State(0.0, (-case.retraction,), (self.scene.mechanism.hub_speed,))
        self.end = case.duration / self.units.time

    def carry(self, make: Callable[[], Stepper]) -> Run:
        """Stretch after stretch, as long as the stepper likes them."""
        stepper, state, before = make(), self.start, self.scene.steps
        while state.time < self.end * (1.0 - 1e-15):
            length = stepper.propose(self.end - state.time)
            result = stepper.advance(self.scene, state, length)
            if stepper.accepts(result, length):
                state = result.state
        return self._run(state.angles[0], state.rates[0], before)

    def symmetric(self, count: int) -> Run:
        """So many steps started and read half a drift off."""
        before = self.scene.steps
        state = SymmetricSteps(self.end / count).advance(self.scene, self.start, self.end).state
        return self._run(state.angles[0], state.rates[0], before)

    def plain(self, count: int) -> Run:
        """So many steps of the engine as it comes, with joints that it corrects."""
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
    """Each contact law; the compliant one at several accuracies and with plain engine steps."""
    laws = [
        Attempt(f"bristle_sim {law}", setting, functools.partial(_struck, case, law, 1e-6))
        for law, setting in (("energetic", "closed phases"), ("engine", "one step"))
    ]
    compliant = [
        Attempt(
            "bristle_sim compliant", f"accuracy={accuracy:g}", functools.partial(_struck, case, "compliant", accuracy)
        )
        for accuracy in ACCURACIES[:7]
    ]
    plain = [
        Attempt("bristle_sim compliant steps", f"steps={count}", functools.partial(_struck_plainly, case, count))
        for count in STEP_COUNTS[4:11]
    ]
    return [*laws, *compliant, *plain]


def _struck(case: StrikeCase, law: str, accuracy: float) -> Run:
    found = strike(case.chain, case.surface, Contact(law), Settings(accuracy=accuracy))
    return Run(found.contact.rates_after, found.steps)


def _struck_plainly(case: StrikeCase, count: int) -> Run:
    found = strike_by(case.chain, case.surface, CompliantLaw(None, RIGID, count))
    return Run(found.rates_after, found.steps)


def pass_attempts(case: PassCase) -> list[Attempt]:
    """The public call, extrapolated and with plain engine steps of a given length."""
    extrapolated = [
        Attempt("bristle_sim simulate", f"accuracy={accuracy:g}", functools.partial(_passed, case, Settings(accuracy)))
        for accuracy in ACCURACIES[:10]
    ]
    plain = [
        Attempt("bristle_sim plain steps", f"step={step:g} s", functools.partial(_passed, case, Settings(step=step)))
        for step in (4e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6)
    ]
    return [*extrapolated, *plain]


def _passed(case: PassCase, settings: Settings) -> Run:
    run = simulate(case.tool, settings, stop_after="strike")
    return Run(state_at_strike(run), run.cost.steps)
