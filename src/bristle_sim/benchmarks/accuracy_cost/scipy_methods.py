"""scipy's integrators at the cases, with right-hand sides as fast as Python can make them.

A strike is the bilinear compliant contact in contact space. With the chain's mass matrix M and the Jacobian J of its tip's
(normal, tangential) velocity, K = J M^-1 J^T, and in the limit of a short contact, in which nothing but the contact acts and
the chain keeps its shape,

    delta' = -v_n,    p_n' = N,    p_t' = F,    v = v(0) + K p,

with N = k delta while the tip goes in and N = (k/e*^2) (delta - (1 - e*^2) delta_max) as it unloads, F = -mu sign(v_t) N
in slip, and F = -(K_nt/K_tt) N in stick. Time, impulse and depth are scaled so that k = K_nn = -v_n(0) = 1. This is the
limit to which the compliant contact of a scene tends; here it is cheaper, since no bodies move.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import ode, solve_ivp
from scipy.optimize import brentq

from bristle_sim.benchmarks.accuracy_cost.cases import Case, StrikeCase, state_at_strike
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run, attempts
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.strike import Chain
from bristle_sim.studies.impulse_course import tip_response, tip_velocity
from bristle_sim.theory.cueing import centrifugal_stiffness

TOLERANCES = tuple(10.0 ** -(power / 2.0) for power in range(4, 25))
"""Relative tolerances, two to a decade, from 1e-2 to 1e-12."""

COMPILED = {each: f"scipy ode {each}" for each in ("dopri5", "dop853")}
METHODS = {each: f"scipy {each.lower()}" for each in ("RK45", "DOP853", "LSODA", "Radau")} | COMPILED
"""Integrators of ``solve_ivp``, and those that ``ode`` steps in compiled code, with their names in tables."""

LONGEST_PHASE = 1e3
"""Scaled time in which a phase must end: near the jam, a phase lasts long."""

SETTLED = 1e-9
"""Scaled velocities and depths below this are zero: solvers locate an event to rounding, not to nothing."""

Slope = Callable[[float, Any], tuple[float, ...]]


def flight_attempts(case: Case) -> list[Attempt]:
    """Return attempts by ``solve_ivp`` with its methods, and by ``ode``, whose loop over steps is compiled."""
    return _with(METHODS, partial(_flown, case, _flight(case)), TOLERANCES)


def strike_attempts(case: StrikeCase) -> list[Attempt]:
    """Return attempts at the bilinear compliant contact in contact space, phase by phase, by ``ode``."""
    return _with(COMPILED, partial(_struck, case), TOLERANCES[::2])


def _with(methods: dict[str, str], solve: Callable[[str, float], Run], tolerances: Sequence[float]) -> list[Attempt]:
    found = (attempts(name, "rtol={:.3g}", partial(solve, method), tolerances) for method, name in methods.items())
    return list(itertools.chain.from_iterable(found))


def pass_attempts(case: Case) -> list[Attempt]:
    """Return attempts by the independent reference, which searches all events on the integrator's dense output."""

    def passed(power: int) -> Run:
        run = simulate_reference(case.tool, accuracy=10.0**-power, stop_after="strike")
        return Run(state_at_strike(run), run.cost.steps)

    return attempts("scipy dop853", "accuracy=1e-{:02d}", passed, range(2, 11))


def _flight(case: Case) -> Slope:
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


def _flown(case: Case, slope: Slope, method: str, tolerance: float) -> Run:
    """Fly from the retraction, -1 in its own unit, at rest."""
    calls, start = itertools.count(), (-1.0, 0.0)
    if method in COMPILED:
        state = _compiled(slope, calls, method, tolerance).set_initial_value(start).integrate(case.duration)
        evaluations = next(calls)
    else:
        found = solve_ivp(slope, (0.0, case.duration), start, method=method, rtol=tolerance, atol=tolerance)
        state, evaluations = found.y[:, -1], found.nfev
    angle, rate = state.tolist()
    return Run((angle * case.scale[0], rate * case.scale[1]), evaluations)


def _compiled(slope: Slope, calls: Iterator[int], method: str, tolerance: float) -> ode:
    """Return the solver whose loop over steps is compiled; it takes one from ``calls`` with each evaluation."""

    def counted(time: float, state: Any) -> Any:
        next(calls)
        return slope(time, state)

    return ode(counted).set_integrator(method, rtol=tolerance, atol=tolerance, nsteps=100_000)


class ContactPhase(NamedTuple):
    """A smooth interval of a contact: friction (stick has none), direction of slip, and the spring's force law."""

    friction: float
    slip: float
    stiffness: float
    residual: float
    loading: bool


class TipContact:
    """A chain's scaled contact, whose state is (delta, p_n, p_t)."""

    def __init__(self, chain: Chain) -> None:
        """Scale the contact by its inverse mass along the normal and its speed of approach."""
        jacobian, response = tip_response(chain)
        inverse_mass, speeds = jacobian @ response, tip_velocity(chain)
        unit_impulse = -speeds[0] / float(inverse_mass[0, 0])
        self.rates_per_impulse = response / np.array(chain.lengths)[:, None] * unit_impulse
        (_, self.k_nt), (_, self.k_tt) = (inverse_mass / inverse_mass[0, 0]).tolist()
        self.v_t = -speeds[1] / speeds[0]

    def velocity(self, state: Sequence[float]) -> tuple[float, float]:
        """Return v_n and v_t."""
        _, p_n, p_t = state
        return float(-1.0 + p_n + self.k_nt * p_t), float(self.v_t + self.k_nt * p_n + self.k_tt * p_t)

    def derivative(self, phase: ContactPhase) -> Slope:
        """Return the right-hand side within a phase, in plain floats: the fastest that Python offers a solver."""
        ratio = -phase.friction * phase.slip if phase.slip else -self.k_nt / self.k_tt
        stiffness, residual, coupling = phase.stiffness, phase.residual, self.k_nt

        def slope(_: float, state: Any) -> tuple[float, float, float]:
            depth, normal, tangential = state.tolist()
            force = stiffness * (depth - residual)
            return 1.0 - normal - coupling * tangential, force, ratio * force

        return slope

    def over(self, phase: ContactPhase, state: Sequence[float]) -> float:
        """Return a function of the state that is below 0 within a phase and rises through it at the phase's end."""
        normal, tangential = self.velocity(state)
        own = normal if phase.loading else phase.residual - float(state[0])
        return max(own, -phase.slip * tangential) if phase.slip else own


def _struck(case: StrikeCase, method: str, tolerance: float) -> Run:
    """Go through the contact's phases; after slip has stopped, stick where friction suffices, else slip as the force drives."""
    contact, surface, calls = TipContact(case.chain), case.surface, itertools.count()
    state, released = [0.0, 0.0, 0.0], surface.restitution**2
    phase = ContactPhase(surface.friction, math.copysign(1.0, contact.v_t), 1.0, 0.0, loading=True)
    while True:
        build = partial(_compiled, contact.derivative(phase), calls, method, tolerance)
        state = _followed(build, partial(contact.over, phase), state)
        normal, tangential = contact.velocity(state)
        if phase.slip and phase.slip * tangential <= SETTLED:
            sticks = phase.friction * contact.k_tt >= abs(contact.k_nt)
            phase = phase._replace(slip=0.0 if sticks else math.copysign(1.0, contact.k_nt))
        if phase.loading and normal >= -SETTLED:
            later, residual = surface.friction_in_restitution, state[0] * (1.0 - released)
            phase = ContactPhase(later, phase.slip, 1.0 / released, residual, loading=False)
        elif not phase.loading and state[0] - phase.residual <= SETTLED:
            rates = np.asarray(case.chain.rates) + contact.rates_per_impulse @ state[1:]
            return Run(tuple(rates.tolist()), next(calls))


def _followed(build: Callable[[], ode], over: Callable[[Any], float], state: list[float]) -> list[float]:
    """Follow a phase with a compiled loop over steps, and within the step in which it ends with Brent's method."""
    steps: list[tuple[float, list[float]]] = []

    def look(time: float, y: Any) -> int:
        steps.append((time, y.tolist()))
        return -1 if len(steps) > 1 and over(y) > 0.0 else 0

    solver = build()
    solver.set_solout(look)
    solver.set_initial_value(state).integrate(LONGEST_PHASE)
    (start, begin), (end, _) = steps[-2:]
    solver = build()

    def after(span: float) -> Any:
        solver.set_initial_value(begin)
        return solver.integrate(span) if span else np.array(begin)

    return list(after(brentq(lambda span: over(after(span)), 0.0, end - start)).tolist())
