"""scipy's integrators at the cases, with right-hand sides as fast as Python can make them."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import ode, solve_ivp
from scipy.optimize import brentq

from bristle_sim.benchmarks.accuracy_cost.cases import FlightCase, PassCase, StrikeCase, state_at_strike
from bristle_sim.benchmarks.accuracy_cost.compliant_contact import ContactPhase, TipContact
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.reference import simulate_reference
from bristle_sim.theory.cueing import centrifugal_stiffness

TOLERANCES = tuple(10.0 ** -(power / 2.0) for power in range(4, 25))
"""Relative tolerances, two to a decade, from 1e-2 to 1e-12."""

COMPILED = ("dopri5", "dop853")
"""Integrators that ``ode`` steps in compiled code."""


def flight_attempts(case: FlightCase) -> list[Attempt]:
    """Return attempts by ``solve_ivp`` with its methods, and by ``ode``, whose loop over steps is compiled."""
    slope = _flight(case)
    attempts = []
    for method in ("RK45", "DOP853", "LSODA", "Radau"):
        attempts += [_attempt(f"scipy {method.lower()}", each, _solved, case, slope, method) for each in TOLERANCES]
    for method in COMPILED:
        attempts += [
            _attempt(f"scipy ode {method}", each, _stepped_in_compiled_code, case, slope, method) for each in TOLERANCES
        ]
    return attempts


def _attempt(method: str, tolerance: float, solve: Callable[..., Run], *arguments: Any) -> Attempt:
    return Attempt(method, f"rtol={tolerance:.3g}", functools.partial(solve, *arguments, tolerance))


Slope = Callable[[float, Any], tuple[float, float]]

START = (-1.0, 0.0)
"""Relative angle in units of the retraction, relative rate in units of the highest."""


def _flight(case: FlightCase) -> Slope:
    """Return the right-hand side of I alpha'' = -k alpha - m r_h (L/2) omega^2 sin alpha in units of retraction and highest rate."""
    tool, (retraction, highest) = case.tool, case.scale
    stiffening = centrifugal_stiffness(tool.bristle.mass, tool.hub.radius, tool.bristle.length, tool.hub.speed)
    scale = highest / retraction
    belt = tool.belt.stiffness / tool.bristle.inertia_about_root / scale
    extra = float(stiffening) / tool.bristle.inertia_about_root / highest

    def slope(_: float, state: Any) -> tuple[float, float]:
        angle, rate = state.tolist()
        return scale * rate, -belt * angle - extra * math.sin(retraction * angle)

    return slope


def _flown(case: FlightCase, state: Any, evaluations: int) -> Run:
    angle, rate = state.tolist()
    return Run((angle * case.scale[0], rate * case.scale[1]), evaluations)


def _solved(case: FlightCase, slope: Slope, method: str, tolerance: float) -> Run:
    found = solve_ivp(slope, (0.0, case.duration), START, method=method, rtol=_least(tolerance), atol=tolerance)
    return _flown(case, found.y[:, -1], found.nfev)


def _least(tolerance: float) -> float:
    """Return the tolerance, or the least of which solve_ivp does not warn: a hundred roundings."""
    return max(tolerance, 2.5e-14)


def _stepped_in_compiled_code(case: FlightCase, slope: Slope, method: str, tolerance: float) -> Run:
    count = 0

    def counted(time: float, state: Any) -> tuple[float, float]:
        nonlocal count
        count += 1
        return slope(time, state)

    solver = ode(counted).set_integrator(method, rtol=tolerance, atol=tolerance, nsteps=100_000)
    solver.set_initial_value(START)
    return _flown(case, solver.integrate(case.duration), count)


def strike_attempts(case: StrikeCase) -> list[Attempt]:
    """Return attempts at the bilinear compliant contact in contact space, phase by phase, each ended by an event."""
    methods = {f"scipy {each.lower()}": (_struck, each) for each in ("RK45", "DOP853", "LSODA", "Radau")}
    methods |= {f"scipy ode {each}": (_struck_in_compiled_code, each) for each in COMPILED}
    return [
        _attempt(name, each, solve, case, method)
        for name, (solve, method) in methods.items()
        for each in TOLERANCES[::2]
    ]


def _struck(case: StrikeCase, method: str, tolerance: float) -> Run:
    evaluations = 0

    def follow(contact: TipContact, phase: ContactPhase, state: list[float]) -> list[float]:
        nonlocal evaluations
        events = [_terminal(*each) for each in contact.ends(phase)]
        found = solve_ivp(
            contact.derivative(phase),
            (0.0, contact.LONGEST),
            state,
            method=method,
            events=events,
            rtol=_least(tolerance),
            atol=tolerance,
        )
        evaluations += found.nfev
        return list(found.y[:, -1].tolist())

    return Run(TipContact(case.chain, case.surface).solve(follow), evaluations)


def _struck_in_compiled_code(case: StrikeCase, method: str, tolerance: float) -> Run:
    """Strike with a compiled loop over steps, and within the step in which a phase ends Brent's method."""
    evaluations = 0

    def follow(contact: TipContact, phase: ContactPhase, state: list[float]) -> list[float]:
        nonlocal evaluations
        slope, ends = contact.derivative(phase), contact.ends(phase)
        steps: list[tuple[float, list[float]]] = []

        def over(y: Any) -> float:
            return max(direction * function(0.0, y) for function, direction in ends)

        def look(time: float, y: Any) -> int:
            steps.append((time, y.tolist()))
            return -1 if len(steps) > 1 and over(y) > 0.0 else 0

        def after(span: float) -> Any:
            solver.set_initial_value(begin)
            return solver.integrate(span) if span else np.array(begin)

        def counted(time: float, y: Any) -> tuple[float, float, float]:
            nonlocal evaluations
            evaluations += 1
            return slope(time, y)

        solver = ode(counted).set_integrator(method, rtol=tolerance, atol=tolerance, nsteps=100_000)
        solver.set_solout(look)
        solver.set_initial_value(state).integrate(contact.LONGEST)
        (start, begin), (end, _) = steps[-2:]
        solver = ode(counted).set_integrator(method, rtol=tolerance, atol=tolerance, nsteps=100_000)
        return list(after(brentq(lambda span: over(after(span)), 0.0, end - start)).tolist())

    return Run(TipContact(case.chain, case.surface).solve(follow), evaluations)


def _terminal(function: Callable[..., float], direction: float) -> Any:
    """Return the function as solve_ivp wants an event that ends the integration."""

    def event(time: float, state: Any) -> float:
        return function(time, state)

    event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
    return event


def pass_attempts(case: PassCase) -> list[Attempt]:
    """Return attempts by the independent reference, which searches all events on the integrator's dense output."""
    return [
        Attempt("scipy dop853", f"accuracy=1e-{power:02d}", functools.partial(_passed, case, 10.0**-power))
        for power in range(2, 11)
    ]


def _passed(case: PassCase, accuracy: float) -> Run:
    run = simulate_reference(case.tool, accuracy=accuracy, stop_after="strike")
    return Run(state_at_strike(run), run.cost.steps)
