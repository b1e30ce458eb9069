"""Exudyn and PyBullet at the release flight; neither knows an energetic restitution.

Exudyn: hub and bristle as a tree of hinges in minimal coordinates, the belt as its proportional joint control, explicit
integrators with fixed or adapted steps. PyBullet: the same tree, semi-implicit Euler; it has no spring in a joint, so the
belt's torque is set before every step.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bristle_sim.benchmarks.accuracy_cost.cases import FlightCase
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.scene.tool import tool_units

__all__ = ["exudyn_flight_attempts", "pybullet_flight_attempts"]

HUB_INERTIA = 1e12
"""In scene units: nothing changes the hub's speed."""

STEP_COUNTS = {
    "RK44": (2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 512),
    "RK67": (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 128),
    "GeneralizedAlpha": (4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048),
}
NAMES = {"RK44": "rk44", "RK67": "rk67", "GeneralizedAlpha": "alpha"}
TOLERANCES = tuple(10.0 ** -(power / 2.0) for power in range(4, 25))
PYBULLET_STEPS = (4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192)


def exudyn_flight_attempts(case: FlightCase) -> list[Attempt]:
    """Explicit Runge-Kutta and generalized-alpha over step counts, DOPRI5 over tolerances."""
    flight = _ExudynFlight(case)
    fixed = [
        Attempt(f"exudyn {NAMES[solver]}", f"steps={count}", functools.partial(flight.stepped, solver, count))
        for solver, counts in STEP_COUNTS.items()
        for count in counts
    ]
    adapted = [
        Attempt("exudyn dopri5", f"rtol={tolerance:.3g}", functools.partial(flight.adapted, tolerance))
        for tolerance in TOLERANCES
    ]
    return [*fixed, *adapted]


class _ExudynFlight:
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

    def stepped(self, solver: str, count: int) -> Run:
        """So many steps of equal length."""
        integration = self.settings.timeIntegration
        integration.automaticStepSize = False
        integration.numberOfSteps = count
        return self._solve(solver)

    def adapted(self, tolerance: float) -> Run:
        """Steps that keep the solver's own estimate within a tolerance."""
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


def pybullet_flight_attempts(case: FlightCase) -> list[Attempt]:
    """Its only integrator over step counts."""
    flight = _BulletFlight(case)
    return [
        Attempt("pybullet euler", f"steps={count}", functools.partial(flight.fly, count)) for count in PYBULLET_STEPS
    ]


BULLET_TREE = """<robot name="tool">
<link name="base"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="bearing" type="continuous"><parent link="base"/><child link="hub"/><axis xyz="0 0 1"/></joint>
<link name="hub"><inertial><mass value="1"/>
<inertia ixx="{hub!r}" iyy="{hub!r}" izz="{hub!r}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="root" type="continuous"><parent link="hub"/><child link="bristle"/><axis xyz="0 0 1"/>
<origin xyz="0 {root!r} 0"/></joint>
<link name="bristle"><inertial><origin xyz="0 -0.5 0"/><mass value="1"/>
<inertia ixx="{rod!r}" iyy="{rod!r}" izz="{rod!r}" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


class _BulletFlight:
    """The released bristle on its hub in a physics client of its own."""

    def __init__(self, case: FlightCase) -> None:
        self.units = tool_units(case.tool)
        self.retraction, self.end = case.retraction, case.duration / self.units.time
        self.hub_speed = case.tool.hub.speed * self.units.time
        self.stiffness = case.tool.belt.stiffness / self.units.energy
        tree = BULLET_TREE.format(hub=HUB_INERTIA, root=-case.tool.hub.radius / self.units.length, rod=1.0 / 12.0)
        with silent(), tempfile.TemporaryDirectory() as folder:
            self.library: Any = importlib.import_module("pybullet")
            self.client = self.library.connect(self.library.DIRECT)
            file = Path(folder) / "tool.urdf"
            file.write_text(tree, encoding="utf-8")
            flags = self.library.URDF_USE_INERTIA_FROM_FILE
            self.body = self.library.loadURDF(str(file), useFixedBase=True, flags=flags, physicsClientId=self.client)
        self._free()

    def _free(self) -> None:
        """Take out what the engine adds on its own: damping, motors, a speed limit."""
        for link in (-1, 0, 1):
            self.library.changeDynamics(
                self.body,
                link,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
                maxJointVelocity=1e9,
                physicsClientId=self.client,
            )
        for joint in (0, 1):
            self.library.setJointMotorControl2(
                self.body, joint, self.library.VELOCITY_CONTROL, force=0.0, physicsClientId=self.client
            )

    def fly(self, count: int) -> Run:
        """So many steps, the belt's torque set before each."""
        library, body, client, torque = self.library, self.body, self.client, self.library.TORQUE_CONTROL
        library.setPhysicsEngineParameter(
            fixedTimeStep=self.end / count, numSolverIterations=1, numSubSteps=0, physicsClientId=client
        )
        library.resetJointState(body, 0, 0.0, self.hub_speed, physicsClientId=client)
        library.resetJointState(body, 1, -self.retraction, 0.0, physicsClientId=client)
        for _ in range(count):
            angle = library.getJointState(body, 1, physicsClientId=client)[0]
            library.setJointMotorControl2(body, 1, torque, force=-self.stiffness * angle, physicsClientId=client)
            library.stepSimulation(physicsClientId=client)
        angle, rate = library.getJointState(body, 1, physicsClientId=client)[:2]
        return Run((angle, rate / self.units.time), count)


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Keep compiled code's own messages off standard output, which may be a JSON document, and standard error."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(stream) for stream in (1, 2)]
    with Path(os.devnull).open("wb") as nowhere:
        for stream in (1, 2):
            os.dup2(nowhere.fileno(), stream)
    try:
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for stream, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, stream)
            os.close(copy)
