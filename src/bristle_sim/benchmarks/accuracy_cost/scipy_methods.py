"""scipy's integrators at the cases, with right-hand sides as fast as Python can make them."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from scipy.integrate import ode, solve_ivp
from scipy.optimize import brentq

from bristle_sim.benchmarks.accuracy_cost.cases import FlightCase, PassCase, StrikeCase, state_at_strike
from bristle_sim.benchmarks.accuracy_cost.compliant_contact import LONGEST, ContactPhase, Ends, TipContact
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.reference import simulate_reference
from bristle_sim.theory.cueing import centrifugal_stiffness

TOLERANCES = tuple(10.0 ** -(power / 2.0) for power in range(4, 25))
"""Relative tolerances, two to a decade, from 1e-2 to 1e-12."""

METHODS = {each: f"scipy {each.lower()}" for each in ("RK45", "DOP853", "LSODA", "Radau")}
METHODS |= {each: f"scipy ode {each}" for each in ("dopri5", "dop853")}
"""Integrators of ``solve_ivp``, and those that ``ode`` steps in compiled code, with their names in tables."""


def flight_attempts(case: FlightCase) -> list[Attempt]:
    """Return attempts by ``solve_ivp`` with its methods, and by ``ode``, whose loop over steps is compiled."""
    return _attempts(functools.partial(_flown, case, _flight(case)), TOLERANCES)


def strike_attempts(case: StrikeCase) -> list[Attempt]:
    """Return attempts at the bilinear compliant contact in contact space, phase by phase, each ended by an event."""
    return _attempts(functools.partial(_struck, case), TOLERANCES[::2])


def _attempts(solve: Callable[[str, float], Run], tolerances: Sequence[float]) -> list[Attempt]:
    return [
        Attempt(name, f"rtol={each:.3g}", functools.partial(solve, method, each))
        for method, name in METHODS.items()
        for each in tolerances
    ]


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


def _flown(case: FlightCase, slope: Slope, method: str, tolerance: float) -> Run:
    calls = itertools.count()
    if method.islower():
        state = _compiled(slope, calls, method, tolerance).set_initial_value(START).integrate(case.duration)
        evaluations = next(calls)
    else:
        found = solve_ivp(slope, (0.0, case.duration), START, method=method, rtol=tolerance, atol=tolerance)
        state, evaluations = found.y[:, -1], found.nfev
    angle, rate = state.tolist()
    return Run((angle * case.scale[0], rate * case.scale[1]), evaluations)


def _compiled(slope: Callable[..., Any], calls: Iterator[int], method: str, tolerance: float) -> ode:
    """Return the solver whose loop over steps is compiled; it takes one from ``calls`` with each evaluation."""

    def counted(time: float, state: Any) -> Any:
        next(calls)
        return slope(time, state)

    return ode(counted).set_integrator(method, rtol=tolerance, atol=tolerance, nsteps=100_000)


def _struck(case: StrikeCase, method: str, tolerance: float) -> Run:
    evaluations, calls = 0, itertools.count()

    def follow(contact: TipContact, phase: ContactPhase, state: list[float]) -> list[float]:
        """Integrate one phase of the contact, and return the state at its end."""
        nonlocal evaluations
        slope, ends = contact.derivative(phase), contact.ends(phase)
        if method.islower():
            return _followed(lambda: _compiled(slope, calls, method, tolerance), ends, state)
        span, given = (0.0, LONGEST), {"method": method, "rtol": tolerance, "atol": tolerance}
        found = solve_ivp(slope, span, state, events=[_terminal(*each) for each in ends], **given)
        evaluations += found.nfev
        return list(found.y[:, -1].tolist())

    rates = TipContact(case.chain, case.surface).solve(follow)
    return Run(rates, evaluations + next(calls))


def _followed(build: Callable[[], ode], ends: list[tuple[Ends, float]], state: list[float]) -> list[float]:
    """Follow a phase with a compiled loop over steps, and within the step in which it ends with Brent's method."""
    steps: list[tuple[float, list[float]]] = []

    def over(y: Any) -> float:
        return max(direction * function(0.0, y) for function, direction in ends)

    def look(time: float, y: Any) -> int:
        steps.append((time, y.tolist()))
        return -1 if len(steps) > 1 and over(y) > 0.0 else 0

    solver = build()
    solver.set_solout(look)
    solver.set_initial_value(state).integrate(LONGEST)
    (start, begin), (end, _) = steps[-2:]
    solver = build()

    def after(span: float) -> Any:
        solver.set_initial_value(begin)
        return solver.integrate(span) if span else np.array(begin)

    return list(after(brentq(lambda span: over(after(span)), 0.0, end - start)).tolist())


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
