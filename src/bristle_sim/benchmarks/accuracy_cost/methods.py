"""Attempts at the cases by this project and by SciPy's integrators.

An attempt by this project calls one of the public functions, or a time stepper that they contain.
An attempt by SciPy integrates equations of motion that are written in Python.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from functools import partial
from typing import Any

from scipy.integrate import ode, solve_ivp

from bristle_sim.benchmarks.accuracy_cost.cases import Case, StrikeCase, state_at_strike
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run, attempts
from bristle_sim.parameters import Contact
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import strike
from bristle_sim.scene.tool import build_tool
from bristle_sim.settings import Settings
from bristle_sim.theory.cueing import field_stiffness

ACCURACIES = tuple(10.0**-power for power in range(1, 12))
"""Requested accuracies, from coarse to fine."""

STEP_COUNTS = tuple(2**power for power in range(1, 15))
"""Numbers of equal engine steps of a flight."""

PASSES = 4096
"""Number of passes that one attempt by ``ensemble`` computes at once."""


def own_flight(case: Case) -> list[Attempt]:
    """Return this project's attempts at a flight, by three methods.

    The methods are the public function ``simulate``, the extrapolation integrator alone, and equal
    engine steps.
    """

    def simulated(accuracy: float) -> Run:
        """Simulate the flight by the public function ``simulate`` with a requested accuracy."""
        settings = Settings(accuracy=accuracy, hub_turn=case.tool.hub.speed * case.duration)
        run = simulate(case.tool, settings, start_relative_angle=-case.retraction)
        return Run((float(run.relative_angle[-1]), float(run.relative_rate[-1])), run.cost.steps)

    return [
        *attempts("bristle_sim simulate", "accuracy={:g}", simulated, ACCURACIES),
        *_flight_of_built_scene(case),
    ]


def _flight_of_built_scene(case: Case) -> list[Attempt]:
    """Return the attempts at a flight by extrapolation and by equal engine steps.

    The model is built before the timing, as for the other packages.
    """
    scene, units = build_tool(case.tool, hub_start=0.0)
    hub_speed = scene.mechanism.hub_speed
    start = State(0.0, (-case.retraction,), (hub_speed,))
    end = case.duration / units.time

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

        The engine itself corrects the position errors of the joints.
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
        """Return a flight's final state relative to the hub (rad, rad/s), and its engine steps.

        ``angle`` (rad) and ``rate`` (scene units) are the bristle's absolute angle and angular
        velocity at the end of the flight. ``before`` is the number of engine steps that the scene
        had taken before the flight.
        """
        relative = (angle - scene.mechanism.root_angle(end), (rate - hub_speed) / units.time)
        return Run(relative, scene.steps - before)

    return [
        *attempts("bristle_sim extrapolation", "tolerance={:g}", extrapolated, ACCURACIES),
        *attempts("bristle_sim plain steps", "steps={}", plain, STEP_COUNTS),
    ]


def own_strike(case: StrikeCase) -> list[Attempt]:
    """Return this project's attempts at a strike, by each of its three contact laws.

    There is one attempt by the compliant law for each of several requested accuracies.
    """

    def struck(law: str, accuracy: float) -> Run:
        """Simulate the strike by a contact law, and return the rods' angular velocities after it."""
        found = strike(case.chain, case.surface, Contact(law), Settings(accuracy=accuracy))
        return Run(found.contact.rates_after, found.steps)

    return [
        *attempts("bristle_sim energetic", "closed phases", partial(struck, "energetic"), (1e-6,)),
        *attempts("bristle_sim engine", "one step", partial(struck, "engine"), (1e-6,)),
        *attempts(
            "bristle_sim compliant", "accuracy={:g}", partial(struck, "compliant"), ACCURACIES[:7]
        ),
    ]


def own_pass(case: Case) -> list[Attempt]:
    """Return this project's attempts at a pass, by ``simulate`` and by ``ensemble``.

    ``simulate`` computes one pass; ``ensemble`` computes many passes at once.
    """

    def simulated(accuracy: float) -> Run:
        """Simulate the pass up to the strike with a requested accuracy."""
        run = simulate(case.tool, Settings(accuracy), stop_after="strike")
        return Run(state_at_strike(run), run.cost.steps)

    def in_arrays(accuracy: float) -> Run:
        """Compute ``PASSES`` equal passes by one call of ``ensemble``, and return the first one."""
        many = ensemble(case.tool, accuracy=accuracy, hub_speed=[case.tool.hub.speed] * PASSES)
        columns = (many.contact_time, -many.lag_at_contact, many.relative_speed_at_contact)
        return Run(tuple(float(each[0]) for each in columns), 0)

    blocks = attempts("bristle_sim ensemble", "accuracy={:g}", in_arrays, ACCURACIES[1:10:4])
    return [
        *attempts("bristle_sim simulate", "accuracy={:g}", simulated, ACCURACIES[:10]),
        *(dataclasses.replace(each, passes=PASSES) for each in blocks),
    ]


TOLERANCES = tuple(10.0 ** -(power / 2.0) for power in range(4, 25))
"""Relative tolerances of SciPy's integrators, two to a decade, from 1e-2 to 1e-12."""

MOST_STEPS = 100_000  # largest number of steps of a flight by an integrator of SciPy's ``ode``


def scipy_flight(case: Case) -> list[Attempt]:
    """Return attempts at a flight by the integrators of SciPy's ``solve_ivp`` and ``ode``.

    The loop over time steps is Python code in ``solve_ivp`` and compiled code in ``ode``. Both
    solve I alpha'' = -k_T alpha - m r_h (L/2) omega^2 sin alpha for the bristle's angle alpha
    relative to the hub. I is the bristle's moment of inertia about its root, k_T the belt's
    stiffness, m and L are the bristle's mass and length, r_h is the hub's radius and omega its
    angular velocity. Angle and angular velocity are divided by their largest values, since ``ode``
    has one absolute tolerance for both.
    """
    retraction, highest = case.scale
    scale = highest / retraction
    inertia = case.tool.bristle.inertia_about_root
    belt = case.tool.belt.stiffness / inertia / scale
    centrifugal = field_stiffness(case.tool) / inertia / highest
    start = (-1.0, 0.0)

    def slope(_: float, state: Any) -> list[float]:
        """Return the time derivatives of the scaled angle and the scaled angular velocity, 1/s."""
        angle, rate = state.tolist()
        # A list: before SciPy 1.17 the compiled code treats a tuple as several return values.
        return [scale * rate, -belt * angle - centrifugal * math.sin(retraction * angle)]

    def solved(method: str, tolerance: float) -> Run:
        """Integrate the flight by a method of ``solve_ivp``."""
        limits = {"rtol": tolerance, "atol": tolerance}
        found = solve_ivp(slope, (0.0, case.duration), start, method=method, **limits)
        return flown(found.y[:, -1], found.nfev)

    def stepped(method: str, tolerance: float) -> Run:
        """Integrate the flight by a compiled method of SciPy's ``ode``.

        ``ode`` does not report the number of evaluations, so they are counted here.
        """
        calls = itertools.count()

        def counted(time: float, state: Any) -> list[float]:
            """Count an evaluation of the right-hand side, and return its value."""
            next(calls)
            return slope(time, state)

        solver = ode(counted).set_integrator(
            method, rtol=tolerance, atol=tolerance, nsteps=MOST_STEPS
        )
        return flown(solver.set_initial_value(start).integrate(case.duration), next(calls))

    def flown(state: Any, evaluations: int) -> Run:
        """Return the final angle (rad) and angular velocity (rad/s) from the scaled state."""
        return Run(tuple((state * case.scale).tolist()), evaluations)

    methods = [
        (f"scipy {each.lower()}", solved, each) for each in ("RK45", "DOP853", "LSODA", "Radau")
    ]
    methods += [(f"scipy ode {each}", stepped, each) for each in ("dopri5", "dop853")]
    return [
        attempt
        for name, integrate, method in methods
        for attempt in attempts(name, "rtol={:.3g}", partial(integrate, method), TOLERANCES)
    ]


def scipy_pass(case: Case) -> list[Attempt]:
    """Return runs of a pass by the project's independent reference, one for each accuracy.

    The reference integrates with SciPy and locates all events on the integrator's dense output.
    """

    def passed(power: int) -> Run:
        """Solve the pass up to the strike with the accuracy 10^-``power``."""
        run = simulate_reference(case.tool, accuracy=10.0**-power, stop_after="strike")
        return Run(state_at_strike(run), run.cost.steps)

    return attempts("scipy dop853", "accuracy=1e-{:02d}", passed, range(2, 11))
