"""heyoka at the release flight: Taylor series of the equation of motion, compiled for it beforehand."""

from __future__ import annotations

import functools
import importlib
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import FlightCase
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.theory.cueing import centrifugal_stiffness

TOLERANCES = tuple(10.0**-power for power in range(1, 17))


def flight_attempts(case: FlightCase) -> list[Attempt]:
    """Return attempts with tolerances of the series' remainder; each has a program of its own."""
    library: Any = importlib.import_module("heyoka")
    angle, rate = library.make_vars("angle", "rate")
    tool, bristle = case.tool, case.tool.bristle
    field = float(centrifugal_stiffness(bristle.mass, tool.hub.radius, bristle.length, tool.hub.speed))
    moment = tool.belt.stiffness * angle + field * library.sin(angle)
    equations, start = [(angle, rate), (rate, -moment / bristle.inertia_about_root)], [-case.retraction, 0.0]

    def fly(integrator: Any) -> Run:
        integrator.time, integrator.state[:] = 0.0, start
        steps = integrator.propagate_until(case.duration)[3]
        return Run((float(integrator.state[0]), float(integrator.state[1])), int(steps))

    compiled = {each: library.taylor_adaptive(equations, start, tol=each) for each in TOLERANCES}
    return [
        Attempt("heyoka taylor", f"tol={each:.0e}", functools.partial(fly, integrator))
        for each, integrator in compiled.items()
    ]
