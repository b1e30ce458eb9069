"""Attempts of this project at the cases, by its public functions and by the time steppers that they
use.
"""

from __future__ import annotations

import dataclasses
from functools import partial

from bristle_sim.benchmarks.accuracy_cost.cases import Case, StrikeCase, state_at_strike
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run, attempts
from bristle_sim.parameters import Contact
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import strike
from bristle_sim.scene.tool import build_tool
from bristle_sim.settings import Settings

ACCURACIES = tuple(10.0**-power for power in range(1, 12))
"""Requested accuracies, from coarse to fine."""

STEP_COUNTS = tuple(2**power for power in range(1, 15))
"""Numbers of equal engine steps of a flight."""

PASSES = 4096
"""Number of passes that one attempt by ``ensemble`` computes at once."""


def flight_attempts(case: Case) -> list[Attempt]:
    """Return this project's attempts at a flight, by three methods.

    The methods are the public function ``simulate``, the extrapolation integrator alone, and equal
    engine steps. The last two use a model that is built before the timing, as the other packages
    do.
    """
    scene, units = build_tool(case.tool, hub_start=0.0)
    hub_speed = scene.mechanism.hub_speed
    start = State(0.0, (-case.retraction,), (hub_speed,))
    end = case.duration / units.time

    def simulated(accuracy: float) -> Run:
        """Simulate the flight by the public function ``simulate`` with a requested accuracy."""
        settings = Settings(accuracy=accuracy, hub_turn=case.tool.hub.speed * case.duration)
        run = simulate(case.tool, settings, start_relative_angle=-case.retraction)
        return Run((float(run.relative_angle[-1]), float(run.relative_rate[-1])), run.cost.steps)

    def extrapolated(tolerance: float) -> Run:
        """Integrate the flight by the extrapolation integrator, which chooses its own intervals."""
        stepper = Extrapolation(tolerance)
        state = start
        before = scene.steps
        while state.time < end * (1.0 - 1e-15):
            length = stepper.propose(end - state.time)
            result = stepper.advance(scene, state, length)
            if stepper.accepts(result, length):
                state = result.state
        return flown(state.angles[0], state.rates[0], before)

    def plain(count: int) -> Run:
        """Integrate the flight in ``count`` equal engine steps.

        The engine itself corrects position errors of the joints.
        """
        before = scene.steps
        scene.place(start)
        for joint in scene.joints:
            joint.error_bias = 0.0
        angle, rate, _ = scene.step(end / count, count)
        for joint in scene.joints:
            joint.error_bias = 1.0
        return flown(angle, rate, before)

    def flown(angle: float, rate: float, before: int) -> Run:
        """Return the bristle's final state relative to the hub, and the number of engine steps.

        The angle is in rad, the angular velocity in rad/s.

        Args:
            angle: final absolute angle of the bristle, rad.
            rate: final absolute angular velocity of the bristle, in scene units.
            before: count of the scene's engine steps when the flight began.
        """
        relative = (angle - scene.mechanism.root_angle(end), (rate - hub_speed) / units.time)
        return Run(relative, scene.steps - before)

    return [
        *attempts("bristle_sim simulate", "accuracy={:g}", simulated, ACCURACIES),
        *attempts("bristle_sim extrapolation", "tolerance={:g}", extrapolated, ACCURACIES),
        *attempts("bristle_sim plain steps", "steps={}", plain, STEP_COUNTS),
    ]


def strike_attempts(case: StrikeCase) -> list[Attempt]:
    """Return this project's attempts at a strike, by each of its three contact laws.

    The compliant law takes part with several accuracies.
    """

    def struck(law: str, accuracy: float) -> Run:
        found = strike(case.chain, case.surface, Contact(law), Settings(accuracy=accuracy))
        return Run(found.contact.rates_after, found.steps)

    return [
        *attempts("bristle_sim energetic", "closed phases", partial(struck, "energetic"), (1e-6,)),
        *attempts("bristle_sim engine", "one step", partial(struck, "engine"), (1e-6,)),
        *attempts(
            "bristle_sim compliant", "accuracy={:g}", partial(struck, "compliant"), ACCURACIES[:7]
        ),
    ]


def pass_attempts(case: Case) -> list[Attempt]:
    """Return this project's attempts at a pass, by ``simulate`` and by ``ensemble``.

    ``simulate`` computes one pass; ``ensemble`` computes many passes at once.
    """

    def simulated(accuracy: float) -> Run:
        run = simulate(case.tool, Settings(accuracy), stop_after="strike")
        return Run(state_at_strike(run), run.cost.steps)

    def in_arrays(accuracy: float) -> Run:
        """Compute ``PASSES`` copies of the pass at once by ``ensemble``."""
        many = ensemble(case.tool, accuracy=accuracy, hub_speed=[case.tool.hub.speed] * PASSES)
        columns = (many.contact_time, -many.lag_at_contact, many.relative_speed_at_contact)
        return Run(tuple(float(each[0]) for each in columns), 0)

    blocks = attempts("bristle_sim ensemble", "accuracy={:g}", in_arrays, ACCURACIES[1:10:4])
    return [
        *attempts("bristle_sim simulate", "accuracy={:g}", simulated, ACCURACIES[:10]),
        *(dataclasses.replace(each, passes=PASSES) for each in blocks),
    ]
