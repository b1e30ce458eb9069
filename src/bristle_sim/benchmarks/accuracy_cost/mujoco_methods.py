"""MuJoCo at the cases: models compiled beforehand, and its integrators with fixed steps.

The hub is a hinge so heavy that nothing changes its speed, a belt the stiffness of the bristle's hinge. Units are the
scene's, so that numbers are near 1.

Its contacts are soft: with impedance near 1 the contact point obeys a = -b v - k r, which becomes the inelastic bar as it
gets stiffer. No setting makes the returned work e*^2 of that of compression, so that it takes no part in the strikes.
"""

from __future__ import annotations

import functools
import importlib
import math
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import FlightCase, PassCase
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.parameters import Tool
from bristle_sim.scene.tool import tool_units

HUB_INERTIA = 1e12
"""Inertia of the hub in scene units: its speed changes by 1e-13 of itself in a pass."""

HARD = 0.9999
"""Impedance of a contact that dictates its point's acceleration, MuJoCo's largest."""

FREE = '<flag contact="disable" constraint="disable"/>'
"""Options without the parts of the engine that a free motion does not need."""


class _Model:
    """A compiled model and its data."""

    def __init__(self, world: str, integrator: str, option: str = "") -> None:
        self.library: Any = importlib.import_module("mujoco")
        text = f"""<mujoco><option integrator="{integrator}" gravity="0 0 0" tolerance="0">{option}
            </option><worldbody>{world}</worldbody></mujoco>"""
        self.model = self.library.MjModel.from_xml_string(text)
        self.data = self.library.MjData(self.model)

    def start(self, angles: tuple[float, ...], rates: tuple[float, ...], step: float) -> None:
        """Return to time 0, in a given state."""
        self.library.mj_resetData(self.model, self.data)
        self.model.opt.timestep = step
        self.data.qpos[:] = angles
        self.data.qvel[:] = rates

    def step(self, count: int) -> None:
        """Take a number of steps in compiled code."""
        self.library.mj_step(self.model, self.data, count)


def _hub(hub_radius: float, bristle: str) -> str:
    """Return a hub that carries a body at its rim."""
    return f"""<body><joint type="hinge" axis="0 0 1" armature="{HUB_INERTIA!r}"/>
        <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><body pos="0 {-hub_radius!r} 0">{bristle}</body></body>"""


def _rod(mass: float, length: float, stiffness: float, inside: str = "") -> str:
    """Return a slender rod that hangs from its hinge, along (0, -1)."""
    inertia = mass * length**2 / 12.0
    return f"""<joint type="hinge" axis="0 0 1" stiffness="{stiffness!r}"/>
        <inertial pos="0 {-length / 2.0!r} 0" mass="{mass!r}" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>{inside}"""


INTEGRATORS = ("Euler", "implicitfast", "RK4")
STEP_COUNTS = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 512, 1024, 2048, 4096, 8192)


def flight_attempts(case: FlightCase) -> list[Attempt]:
    """Return attempts with each integrator over step counts."""
    return [
        Attempt(f"mujoco {integrator.lower()}", f"steps={count}", functools.partial(flight.fly, count))
        for integrator in INTEGRATORS
        for flight in [_Flight(case, integrator)]
        for count in STEP_COUNTS
    ]


class _Flight(_Model):
    """The released bristle."""

    def __init__(self, case: FlightCase, integrator: str) -> None:
        self.units = tool_units(case.tool)
        self.case = case
        self.hub_speed = case.tool.hub.speed * self.units.time
        stiffness = case.tool.belt.stiffness / self.units.energy
        bristle = _rod(1.0, 1.0, stiffness)
        super().__init__(_hub(case.tool.hub.radius / self.units.length, bristle), integrator, FREE)

    def fly(self, count: int) -> Run:
        """Fly in a number of steps."""
        self.start((0.0, -self.case.retraction), (self.hub_speed, 0.0), self.case.duration / self.units.time / count)
        self.step(count)
        return Run((float(self.data.qpos[1]), float(self.data.qvel[1]) / self.units.time), count)


PASS_STEPS = (250, 500, 1000, 2000, 4000, 8000, 16000, 32000)

STEPS_IN_CONTACT = 2.0
"""Time scale of the bar's critically damped spring in steps: the stiffest that is stable."""


def pass_attempts(case: PassCase) -> list[Attempt]:
    """Return attempts up to the strike; the bar is a critically damped spring, stiffer as steps get shorter."""
    return [
        Attempt(f"mujoco {integrator.lower()}", f"steps={count}", functools.partial(one.go, count))
        for integrator in INTEGRATORS
        for one in [_Pass(case.tool, integrator)]
        for count in PASS_STEPS
    ]


class _Pass(_Model):
    """Hub, bristle and bar; the workpart is where a step ends below it."""

    START = -0.5 * math.pi
    TURN = 0.5 * math.pi
    """Radians of the hub that the steps are counted over; the strike comes earlier."""

    def __init__(self, tool: Tool, integrator: str) -> None:
        self.units = tool_units(tool)
        size = self.units.length
        assert tool.bar is not None
        self.hub_speed = tool.hub.speed * self.units.time
        self.hub_radius, self.depth = tool.hub.radius / size, tool.workpart_depth / size
        x, y = tool.bar.centre
        bar = f'''<geom name="bar" type="sphere" size="{tool.bar.radius / size!r}" pos="{x / size!r} {y / size!r} 0"
            contype="1" conaffinity="0" condim="1" solimp="{HARD} {HARD} 1" priority="1"/>'''
        wire = f'''<geom type="capsule" fromto="0 0 0 0 -1 0" size="{tool.bristle.wire_diameter / 2.0 / size!r}"
            contype="0" conaffinity="1" condim="1" mass="0"/>'''
        bristle = _rod(1.0, 1.0, tool.belt.stiffness / self.units.energy, wire)
        super().__init__(bar + _hub(self.hub_radius, bristle), integrator)

    def go(self, count: int) -> Run:
        """Step in blocks, and step by step through the block in which the tip gets below the workpart."""
        step = self.TURN / self.hub_speed / count
        rate = 1.0 / (STEPS_IN_CONTACT * step)
        self.model.geom("bar").solref = [-(rate**2), -2.0 * rate]
        self.start((self.START, 0.0), (self.hub_speed, 0.0), step)
        before = self._last_above(max(1, count // 64))
        self.data.time, self.data.qpos[:], self.data.qvel[:] = before[0], before[1:3], before[3:5]
        before = self._last_above(1)
        after = self._state()
        ratio = self._height(before) / (self._height(before) - self._height(after))
        time, _, angle, _, rate = (first + ratio * (last - first) for first, last in zip(before, after, strict=True))
        return Run((time * self.units.time, angle, rate / self.units.time), round(after[0] / step))

    def _last_above(self, block: int) -> tuple[float, ...]:
        """Step a block at a time until the tip is below the workpart, and return the state before."""
        while True:
            before = self._state()
            self.step(block)
            if not before[0] * self.hub_speed < 2.0 * self.TURN:
                raise RuntimeError("the tip does not reach the workpart")
            if self._height(self._state()) < 0.0:
                return before

    def _state(self) -> tuple[float, ...]:
        return (float(self.data.time), *self.data.qpos.tolist(), *self.data.qvel.tolist())

    def _height(self, state: tuple[float, ...]) -> float:
        """Return the height of the wire's end above the workpart."""
        hub_angle, angle = state[1:3]
        return self.depth - self.hub_radius * math.cos(hub_angle) - math.cos(hub_angle + angle)
