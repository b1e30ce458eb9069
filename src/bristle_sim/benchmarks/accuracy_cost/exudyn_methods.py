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
    flight = _Flight(case)
    return [
        *(Attempt("exudyn rk44", f"steps={n}", functools.partial(flight.stepped, n)) for n in STEP_COUNTS),
        *(Attempt("exudyn dopri5", f"rtol={e:.3g}", functools.partial(flight.adapted, e)) for e in TOLERANCES),
    ]


class _Flight:
    """The released bristle on its hub, assembled."""

    def __init__(self, case: FlightCase) -> None:
        self.library: Any = importlib.import_module("exudyn")
        self.units = tool_units(case.tool)
        self.start = ((0.0, -case.retraction), (case.tool.hub.speed * self.units.time, 0.0))
        self.system = self.library.SystemContainer().AddSystem()
        self._assemble(case.tool.hub.radius / self.units.length, case.tool.belt.stiffness / self.units.energy)
        self.settings = self._settings(case.duration / self.units.time)

    def _assemble(self, hub_radius: float, stiffness: float) -> None:
        items: Any = importlib.import_module("exudyn.itemInterface")
        angles, rates = self.start
        node = self.system.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=[0.0, 0.0],
                initialCoordinates=list(angles),
                initialCoordinates_t=list(rates),
                numberOfODE2Coordinates=2,
            )
        )
        matrices, vectors = self.library.Matrix3DList, self.library.Vector3DList
        nothing, turned = [0.0, 0.0], np.eye(3)
        self.system.AddObject(
            items.ObjectKinematicTree(
                nodeNumber=node,
                jointTypes=[self.library.JointType.RevoluteZ] * 2,
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
        )
        self.system.Assemble()

    def _settings(self, end: float) -> Any:
        settings = self.library.SimulationSettings()
        settings.solution.file.write = False
        settings.solution.file.writePeriod = settings.solution.sensors.writePeriod = 2.0 * end
        settings.timeIntegration.verboseMode = 0
        settings.timeIntegration.endTime = end
        settings.timeIntegration.initialStepSize = 0.0
        return settings

    def stepped(self, count: int) -> Run:
        """Fly in a number of steps of equal length."""
        integration = self.settings.timeIntegration
        integration.automaticStepSize = False
        integration.numberOfSteps = count
        return self._solve("RK44")

    def adapted(self, tolerance: float) -> Run:
        """Fly in steps that keep the solver's own estimate within a tolerance."""
        integration = self.settings.timeIntegration
        integration.automaticStepSize = True
        integration.numberOfSteps = 1
        integration.relativeTolerance = integration.absoluteTolerance = tolerance
        return self._solve("DOPRI5")

    def _solve(self, solver: str) -> Run:
        kind = getattr(self.library.DynamicSolverType, solver)
        self.system.SolveDynamic(self.settings, solverType=kind, updateInitialValues=False, storeSolver=True)
        angle = float(self.system.systemData.GetODE2Coordinates()[1])
        rate = float(self.system.systemData.GetODE2Coordinates_t()[1])
        return Run((angle, rate / self.units.time), int(self.system.sys["dynamicSolver"].it.currentStepIndex) - 1)
