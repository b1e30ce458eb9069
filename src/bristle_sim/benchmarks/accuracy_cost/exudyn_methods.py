"""Exudyn at the release flight: hub and bristle as a tree of hinges, the belt as its proportional joint control."""

from __future__ import annotations

import functools
import importlib
from typing import Any

import numpy as np

from bristle_sim.benchmarks.accuracy_cost.cases import FlightCase
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.scene.tool import tool_units

HUB_INERTIA = 1e12
"""Inertia of the hub in scene units: nothing changes its speed."""

STEP_COUNTS = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 512)
TOLERANCES = tuple(10.0 ** -(power / 2.0) for power in range(4, 25))


def flight_attempts(case: FlightCase) -> list[Attempt]:
    """Return attempts by the classical Runge-Kutta method over step counts and by DOPRI5 over tolerances."""
    library: Any = importlib.import_module("exudyn")
    units, stiffness = tool_units(case.tool), case.tool.belt.stiffness
    system = library.SystemContainer().AddSystem()
    rates = [case.tool.hub.speed * units.time, 0.0]
    _assemble(
        library, system, [0.0, -case.retraction], rates, case.tool.hub.radius / units.length, stiffness / units.energy
    )
    settings = library.SimulationSettings()
    settings.solution.file.write = False
    integration, end = settings.timeIntegration, case.duration / units.time
    settings.solution.file.writePeriod = settings.solution.sensors.writePeriod = 2.0 * end
    integration.verboseMode, integration.endTime, integration.initialStepSize = 0, end, 0.0

    def fly(solver: str, count: int, tolerance: float | None) -> Run:
        """Fly in a number of equal steps, or in steps that keep the solver's own estimate within a tolerance."""
        integration.numberOfSteps, integration.automaticStepSize = count, tolerance is not None
        if tolerance is not None:
            integration.relativeTolerance = integration.absoluteTolerance = tolerance
        kind = getattr(library.DynamicSolverType, solver)
        system.SolveDynamic(settings, solverType=kind, updateInitialValues=False, storeSolver=True)
        angle = float(system.systemData.GetODE2Coordinates()[1])
        rate = float(system.systemData.GetODE2Coordinates_t()[1])
        return Run((angle, rate / units.time), int(system.sys["dynamicSolver"].it.currentStepIndex) - 1)

    return [
        *(Attempt("exudyn rk44", f"steps={n}", functools.partial(fly, "RK44", n, None)) for n in STEP_COUNTS),
        *(Attempt("exudyn dopri5", f"rtol={e:.3g}", functools.partial(fly, "DOPRI5", 1, e)) for e in TOLERANCES),
    ]


def _assemble(
    library: Any, system: Any, angles: list[float], rates: list[float], hub_radius: float, stiffness: float
) -> None:
    """Put the released bristle on its hub."""
    items: Any = importlib.import_module("exudyn.itemInterface")
    start = {"initialCoordinates": angles, "initialCoordinates_t": rates, "numberOfODE2Coordinates": 2}
    node = system.AddNode(items.NodeGenericODE2(referenceCoordinates=[0.0, 0.0], **start))
    matrices, vectors = library.Matrix3DList, library.Vector3DList
    nothing, turned = [0.0, 0.0], np.eye(3)
    tree = items.ObjectKinematicTree(
        nodeNumber=node,
        jointTypes=[library.JointType.RevoluteZ] * 2,
        linkParents=[-1, 0],
        jointTransformations=matrices([turned, turned]),
        jointOffsets=vectors([[0.0, 0.0, 0.0], [0.0, -hub_radius, 0.0]]),
        linkInertiasCOM=matrices([np.diag([1.0, 1.0, HUB_INERTIA]), np.eye(3) / 12.0]),
        linkCOMs=vectors([[0.0, 0.0, 0.0], [0.0, -0.5, 0.0]]),
        linkMasses=[1.0, 1.0],
        jointForceVector=nothing,
        jointPositionOffsetVector=nothing,
        jointVelocityOffsetVector=nothing,
        jointPControlVector=[0.0, stiffness],
        jointDControlVector=nothing,
    )
    system.AddObject(tree)
    system.Assemble()
