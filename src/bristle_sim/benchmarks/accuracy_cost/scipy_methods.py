"""Attempts of SciPy's integrators at the cases, with fast right-hand sides in plain Python."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import partial
from typing import Any

from scipy.integrate import ode, solve_ivp

from bristle_sim.benchmarks.accuracy_cost.cases import Case, state_at_strike
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run, attempts
from bristle_sim.reference import simulate_reference
from bristle_sim.theory.cueing import centrifugal_stiffness

TOLERANCES = tuple(10.0 ** -(power / 2.0) for power in range(4, 25))
"""Relative tolerances, two to a decade, from 1e-2 to 1e-12."""

COMPILED = {each: f"scipy ode {each}" for each in ("dopri5", "dop853")}
METHODS = {
    each: f"scipy {each.lower()}" for each in ("RK45", "DOP853", "LSODA", "Radau")
} | COMPILED
"""Names in tables of the integrators of ``solve_ivp``, and of ``ode``, which steps in compiled
code."""

Slope = Callable[[float, Any], tuple[float, ...]]


def flight_attempts(case: Case) -> list[Attempt]:
    """Return attempts at a flight by the integrators of SciPy's ``solve_ivp`` and ``ode``.

    The loop over time steps is compiled code in ``ode`` and Python code in ``solve_ivp``.
    """
    slope = _flight(case)
    return [
        each
        for method, name in METHODS.items()
        for each in attempts(name, "rtol={:.3g}", partial(_flown, case, slope, method), TOLERANCES)
    ]


def pass_attempts(case: Case) -> list[Attempt]:
    """Return attempts at a pass by the project's independent reference solution.

    The reference integrates with SciPy and locates all events on the integrator's dense output.
    """

    def passed(power: int) -> Run:
        run = simulate_reference(case.tool, accuracy=10.0**-power, stop_after="strike")
        return Run(state_at_strike(run), run.cost.steps)

    return attempts("scipy dop853", "accuracy=1e-{:02d}", passed, range(2, 11))


def _flight(case: Case) -> Slope:
    """Return the right-hand side of I alpha'' = -k_T alpha - m r_h (L/2) omega^2 sin alpha.

    I is the bristle's moment of inertia about its root, k_T the belt's stiffness, m and L are the
    bristle's mass and length, r_h is the hub's radius and omega its angular velocity. The angle
    alpha is divided by its initial magnitude, and the angular velocity alpha' by its largest value.
    """
    tool = case.tool
    retraction, highest = case.scale
    stiffening = centrifugal_stiffness(
        tool.bristle.mass, tool.hub.radius, tool.bristle.length, tool.hub.speed
    )
    scale = highest / retraction
    belt = tool.belt.stiffness / tool.bristle.inertia_about_root / scale
    extra = float(stiffening) / tool.bristle.inertia_about_root / highest

    def slope(_: float, state: Any) -> tuple[float, float]:
        angle, rate = state.tolist()
        return scale * rate, -belt * angle - extra * math.sin(retraction * angle)

    return slope


def _flown(case: Case, slope: Slope, method: str, tolerance: float) -> Run:
    """Integrate the flight from rest and return the final state.

    The angle is divided by its initial magnitude, so that it starts at -1.
    """
    calls = itertools.count()
    start = (-1.0, 0.0)

    def counted(time: float, state: Any) -> list[float]:
        """Return the right-hand side, and count this evaluation."""
        next(calls)
        # A list: before SciPy 1.17 the compiled code treats a tuple as several return values.
        return list(slope(time, state))

    if method in COMPILED:
        solver = ode(counted).set_integrator(method, rtol=tolerance, atol=tolerance, nsteps=100_000)
        state = solver.set_initial_value(start).integrate(case.duration)
        evaluations = next(calls)
    else:
        found = solve_ivp(
            slope, (0.0, case.duration), start, method=method, rtol=tolerance, atol=tolerance
        )
        state = found.y[:, -1]
        evaluations = found.nfev
    angle, rate = state.tolist()
    return Run((angle * case.scale[0], rate * case.scale[1]), evaluations)
