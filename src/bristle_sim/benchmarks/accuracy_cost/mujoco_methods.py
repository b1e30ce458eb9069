"""MuJoCo at the cases: models compiled beforehand, its integrators with fixed steps, and its soft contact.

The hub is a hinge so heavy that nothing changes its speed, a belt the stiffness of the bristle's hinge. Units are the
scene's, so that numbers are near 1.

MuJoCo's contacts are soft. With impedance near 1 the contact point obeys a = -b v - k r, whatever friction does; with a
small impedance the contact pushes with the force of such a spring and damper. As it gets stiffer it becomes the
inelastic bar. As a restitution its damping can be tuned to e* without friction, but friction then changes what it
returns: no setting makes the returned work e*^2 of that of compression.
"""

from __future__ import annotations

import functools
import importlib
import itertools
import math
from typing import Any

from scipy.optimize import brentq

from bristle_sim.benchmarks.accuracy_cost.cases import FlightCase, PassCase, StrikeCase
from bristle_sim.benchmarks.accuracy_cost.compliant_contact import TipContact
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.parameters import Tool
from bristle_sim.scene.strike import Chain
from bristle_sim.scene.tool import tool_units

__all__ = ["flight_attempts", "pass_attempts", "spring_of", "strike_attempts"]

HUB_INERTIA = 1e12
"""Inertia of the hub in scene units: its speed changes by 1e-13 of itself in a pass."""

HARD, SOFT = 0.9999, 0.01
"""Impedance of a contact that dictates its point's acceleration, MuJoCo's largest; and of one that is a force."""

FREE = '<flag contact="disable" constraint="disable"/>'
"""Options without the parts of the engine that a free motion does not need."""


class _Model:
    """A compiled model and its data."""

    def __init__(self, world: str, integrator: str, option: str = "") -> None:
        self.library: Any = importlib.import_module("mujoco")
        text = f"""<mujoco><option integrator="{integrator}" gravity="0 0 0" cone="elliptic" tolerance="0">{option}
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


STRIKE_STEPS = (8, 16, 32, 64, 128, 256, 1024)

CONTACT_TIME = 1e-5
"""Duration of an impact over the time in which the chain turns by a radian: it keeps its shape."""

TIP_RADIUS = 1e-9
"""Radius of the ball that touches, in lengths of the last rod."""


def strike_attempts(case: StrikeCase) -> list[Attempt]:
    """Return attempts with the soft contact, tuned to e* without friction, over steps in a contact."""
    strike = _Strike(case)
    return [
        Attempt("mujoco soft contact", f"steps={count}", functools.partial(strike.hit, count)) for count in STRIKE_STEPS
    ]


class _Strike(_Model):
    """A chain whose tip touches a plane."""

    LASTS = 3
    """Contact times that are simulated: friction makes a contact longer."""

    def __init__(self, case: StrikeCase) -> None:
        chain, size = case.chain, case.chain.lengths[-1]
        self.chain, self.fastest = chain, max(map(abs, (*chain.rates, chain.hub_speed)))
        plane = f"""<geom name="plane" type="plane" size="1 1 1" zaxis="0 1 0" contype="1" conaffinity="0" priority="1"
            pos="0 {_tip_height(chain) / size - TIP_RADIUS!r} 0" condim="3" solimp="{SOFT} {SOFT} 1"
            friction="{case.surface.friction!r} 0 0"/>"""
        ball = f'<geom type="sphere" size="{TIP_RADIUS}" pos="0 -1 0" contype="0" conaffinity="1" mass="0"/>'
        inside = ball
        for mass, length in zip(reversed(chain.masses), reversed(chain.lengths), strict=True):
            below = inside if inside == ball else f'<body pos="0 {-length / size!r} 0">{inside}</body>'
            inside = _rod(mass / chain.masses[-1], length / size, 0.0, below)
        super().__init__(plane + _hub(chain.hub_radius / size, inside), "implicitfast")
        self._tune(case)

    def _tune(self, case: StrikeCase) -> None:
        """Set the spring so that its restitution is e* without friction.

        Where impedance is small, the force is that of the spring over the tool's own estimate of the contact's inverse
        mass, which its regularization R = (1 - d)/d times that estimate tells; the spring is scaled by what is true.
        """
        spring = spring_of(case.surface.restitution, CONTACT_TIME)
        self._begin(CONTACT_TIME / 100.0)
        self.step(2)
        estimate = float(self.data.efc_R[0]) * SOFT / (1.0 - SOFT)
        true = TipContact(case.chain, case.surface).normal_inverse_mass * case.chain.masses[-1]
        self.model.geom("plane").solref = [-each * estimate / true for each in spring]

    def _begin(self, step: float) -> None:
        chain = self.chain
        rates = (chain.hub_speed / self.fastest, *(rate / self.fastest for rate in chain.rates))
        self.start(_relative((chain.hub_angle, *chain.angles)), _relative(rates), step)

    def hit(self, count: int) -> Run:
        """Strike with a number of steps in a contact."""
        self._begin(CONTACT_TIME / count)
        self.step(self.LASTS * count)
        after = self.data.qvel.cumsum()[1:] * self.fastest
        return Run(tuple(after.tolist()), self.LASTS * count)


def _tip_height(chain: Chain) -> float:
    rods = sum(length * math.cos(angle) for length, angle in zip(chain.lengths, chain.angles, strict=True))
    return -chain.hub_radius * math.cos(chain.hub_angle) - rods


def _relative(values: tuple[float, ...]) -> tuple[float, ...]:
    """Return absolute angles or rates as hinges count them: each from the one before."""
    return (values[0], *(after - before for before, after in itertools.pairwise(values)))


def spring_of(restitution: float, duration: float) -> tuple[float, float]:
    """Return (k, b) of r'' = -b r' - k r whose impact has a given duration and restitution, if its force only pushes.

    With the damping ratio sin a it releases, at zero acceleration, after (pi - 2 a)/(omega cos a), and returns
    e^(-tan a (pi - 2 a)) of the speed (Schwager and Poeschel 2007); less than e^-2 takes more than critical damping.
    """
    if not math.exp(-2.0) < restitution <= 1.0:
        raise ValueError(f"restitution = {restitution:g}: must be more than e^-2 and at most 1 (dimensionless)")
    angle = float(
        brentq(
            lambda a: math.tan(a) * (math.pi - 2.0 * a) + math.log(restitution), 0.0, 0.5 * math.pi - 1e-9, xtol=1e-15
        )
    )
    rate = (math.pi - 2.0 * angle) / (duration * math.cos(angle))
    return rate**2, 2.0 * math.sin(angle) * rate
