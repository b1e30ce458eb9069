"""Attempts of heyoka and MuJoCo at the cases; each model is built before the timing.

MuJoCo's model has the scene's units. The hub is a hinge with such a large inertia that its speed
stays constant, and the belt is the stiffness of the bristle's hinge. Contacts in MuJoCo are soft.
At an impedance near 1 the contact point has the acceleration a = -b v - k r, where v is its
velocity and r its penetration. As k grows, this law approaches an inelastic bar. No setting returns
a given fraction e*^2 of the work of compression in restitution, so MuJoCo does not compute the
strikes.
"""

from __future__ import annotations

import importlib
import math
from functools import partial
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run, attempts
from bristle_sim.parameters import Tool
from bristle_sim.scene.tool import tool_units
from bristle_sim.theory.cueing import field_stiffness

HEYOKA_TOLERANCES = tuple(10.0**-power for power in range(1, 17))
"""Tolerances of heyoka's Taylor series, from coarse to fine."""


def heyoka_flight(case: Case) -> list[Attempt]:
    """Return one attempt at a flight for each tolerance of heyoka's Taylor series.

    The integrators, one for each tolerance, are compiled beforehand. The CPU time of an attempt
    therefore does not include the compilation.
    """
    library: Any = importlib.import_module("heyoka")
    angle, rate = library.make_vars("angle", "rate")
    moment = case.tool.belt.stiffness * angle + field_stiffness(case.tool) * library.sin(angle)
    equations = [(angle, rate), (rate, -moment / case.tool.bristle.inertia_about_root)]
    start = [-case.retraction, 0.0]
    compiled = {
        each: library.taylor_adaptive(equations, start, tol=each) for each in HEYOKA_TOLERANCES
    }

    def fly(tolerance: float) -> Run:
        """Integrate the flight from its start by the integrator compiled for this tolerance."""
        integrator = compiled[tolerance]
        integrator.time = 0.0
        integrator.state[:] = start
        steps = integrator.propagate_until(case.duration)[3]
        return Run((float(integrator.state[0]), float(integrator.state[1])), int(steps))

    return attempts("heyoka taylor", "tol={:.0e}", fly, HEYOKA_TOLERANCES)


HUB_INERTIA = 1e12
"""Moment of inertia of the hub in scene units; a pass changes the hub's speed by a fraction of
1e-13."""

HARD = 0.9999
"""Largest impedance of a contact in MuJoCo, at which the contact prescribes the acceleration of the
contact point."""

FREE = '<flag contact="disable" constraint="disable"/>'
"""MuJoCo's options for a free motion: contacts and constraints are switched off."""

FLIGHT_STEPS = tuple(round(2.0 ** (power / 2.0)) for power in range(2, 27))
PASS_STEPS = tuple(250 * 2**power for power in range(8))
"""Numbers of steps of a flight, and of a pass until the hub has turned by ``HUB_TURN``."""

STEPS_IN_CONTACT = 2.0
"""Time constant of the bar's critically damped spring, in time steps.

With a smaller time constant the integration is unstable."""

HUB_START = -0.5 * math.pi
HUB_TURN = 0.5 * math.pi
"""Hub angle at the start of a pass, and angle by which the hub turns in the chosen number of steps,
rad.

The strike comes before the hub has turned by this angle."""

INTEGRATORS = ("Euler", "implicitfast", "RK4")


def mujoco_flight(case: Case) -> list[Attempt]:
    """Return attempts at a flight by MuJoCo, one for each integrator and number of steps."""
    return [
        attempt
        for each in INTEGRATORS
        for attempt in attempts(
            f"mujoco {each.lower()}",
            "steps={}",
            partial(MujocoModel(case.tool, each).fly, case),
            FLIGHT_STEPS,
        )
    ]


def mujoco_pass(case: Case) -> list[Attempt]:
    """Return attempts at a pass by MuJoCo, one for each integrator and number of steps.

    In MuJoCo's model the bar is a critically damped spring. The spring is stiffer for shorter
    steps.
    """
    return [
        attempt
        for each in INTEGRATORS
        for attempt in attempts(
            f"mujoco {each.lower()}", "steps={}", MujocoModel(case.tool, each).go, PASS_STEPS
        )
    ]


class MujocoModel:
    """MuJoCo's compiled model of a tool: hub, bristle and bar.

    The model has no workpart. The strike is in the first step at whose end the tip is below the
    workpart's surface.
    """

    def __init__(self, tool: Tool, integrator: str) -> None:
        self.library: Any = importlib.import_module("mujoco")
        self.units = tool_units(tool)
        size = self.units.length
        self.hub_speed = tool.hub.speed * self.units.time
        self.hub_radius = tool.hub.radius / size
        bar = ""
        wire = ""
        option = FREE
        if tool.bar is not None:
            self.depth = tool.workpart_depth / size
            x, y = tool.bar.centre
            contact = (
                f'solimp="{HARD} {HARD} 1" priority="1" contype="1" conaffinity="0" condim="1"'
            )
            bar = f'<geom name="bar" type="sphere" size="{tool.bar.radius / size!r}" pos="{x / size!r} {y / size!r} 0" {contact}/>'
            half = 0.5 * tool.bristle.wire_diameter / size
            wire = f'<geom type="capsule" fromto="0 0 0 0 -1 0" size="{half!r}" contype="0" conaffinity="1" condim="1" mass="0"/>'
            option = ""
        hinge = '<joint type="hinge" axis="0 0 1"'
        stiffness = tool.belt.stiffness / self.units.energy
        rod = 1.0 / 12.0
        text = f"""<mujoco><option integrator="{integrator}" gravity="0 0 0" tolerance="0">{option}</option><worldbody>{bar}
<body>{hinge} armature="{HUB_INERTIA!r}"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<body pos="0 {-self.hub_radius!r} 0">{hinge} stiffness="{stiffness!r}"/>
<inertial pos="0 -0.5 0" mass="1" diaginertia="{rod!r} {rod!r} {rod!r}"/>{wire}</body></body></worldbody></mujoco>"""
        self.model = self.library.MjModel.from_xml_string(text)
        self.data = self.library.MjData(self.model)

    def fly(self, case: Case, count: int) -> Run:
        """Release the bristle and integrate its flight in ``count`` equal steps."""
        self._start((0.0, -case.retraction), case.duration / self.units.time / count)
        self.library.mj_step(self.model, self.data, count)
        return Run((float(self.data.qpos[1]), float(self.data.qvel[1]) / self.units.time), count)

    def go(self, count: int) -> Run:
        """Integrate a pass up to the strike; in each step the hub turns by ``HUB_TURN / count``.

        The steps are first taken in blocks, until the tip is below the workpart's surface. The last
        block is then repeated step by step to find the step in which the tip strikes. The state at
        the strike is interpolated linearly within this step.
        """
        step = HUB_TURN / self.hub_speed / count
        rate = 1.0 / (STEPS_IN_CONTACT * step)
        self.model.geom("bar").solref = [-(rate**2), -2.0 * rate]
        self._start((HUB_START, 0.0), step)
        before = self._last_above(max(1, count // 64))
        self.data.time, self.data.qpos[:], self.data.qvel[:] = before[0], before[1:3], before[3:5]
        before, after = self._last_above(1), self._state()
        ratio = self._height(before) / (self._height(before) - self._height(after))
        time, _, angle, _, rate = (
            first + ratio * (last - first) for first, last in zip(before, after, strict=True)
        )
        return Run((time * self.units.time, angle, rate / self.units.time), round(after[0] / step))

    def _start(self, angles: tuple[float, float], step: float) -> None:
        """Reset the model to time 0, with the bristle at rest relative to the hub.

        Args:
            angles: the hub's angle and the bristle's angle relative to the hub, rad.
            step: the time step, in the model's units.
        """
        self.library.mj_resetData(self.model, self.data)
        self.model.opt.timestep = step
        self.data.qpos[:], self.data.qvel[:] = angles, (self.hub_speed, 0.0)

    def _last_above(self, block: int) -> tuple[float, ...]:
        """Integrate until the tip is below the workpart's surface; return the state before.

        The tip's height is tested after every ``block`` steps. The returned state is that of the
        last test at which the tip was not below the surface.
        """
        while True:
            before = self._state()
            self.library.mj_step(self.model, self.data, block)
            if not before[0] * self.hub_speed < 2.0 * HUB_TURN:
                raise RuntimeError("the tip does not reach the workpart")
            if self._height(self._state()) < 0.0:
                return before

    def _state(self) -> tuple[float, ...]:
        return (float(self.data.time), *self.data.qpos.tolist(), *self.data.qvel.tolist())

    def _height(self, state: tuple[float, ...]) -> float:
        """Return the height of the tip above the workpart's surface, in the model's units."""
        hub_angle, angle = state[1:3]
        return self.depth - self.hub_radius * math.cos(hub_angle) - math.cos(hub_angle + angle)
