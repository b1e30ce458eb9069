"""Measure what one free vibration of a wire costs, here and elsewhere. ``python tests/benchmarks/wire_vibration.py``

The wire on its belt, hub at rest, starts straight with the velocities of its first bending mode. After one period of the beam
its end is where it started; how far it is away, over the amplitude, is the error: 2 pi times that of the frequency. MuJoCo has
the same links on hinges with springs, PyElastica a Cosserat rod, which also shears and whose sections turn: that is 0.1 % of
the frequency, which it does not get below. Peers that are not installed are left out (extra ``peers``).
"""

from __future__ import annotations

import contextlib
import importlib
import itertools
import math
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.benchmarks.machine import surroundings
from bristle_sim.parameters import Bristle, Hub, Tool, Workpart
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.wire_strike import build_wire, free_flight
from bristle_sim.settings import Settings
from bristle_sim.theory.wire import beam_frequencies, chain_modes, hinge_stiffness, second_moment_of_area

Vibration = Callable[[], float]
"""Vibrates for a period, and returns the end's distance from where it started, m."""

TOOL = Tool(hub=Hub(speed=0.0), bar=None, workpart=Workpart())
WIRE = TOOL.bristle
BEAM = (WIRE.mass, WIRE.length, WIRE.wire_diameter, WIRE.modulus, TOOL.belt.stiffness)
FREQUENCY = float(beam_frequencies(*BEAM, 2)[1])
SCENE = 32
"""Links in the scene; twice as many take some five times as long, as they need n^2 steps."""

AMPLITUDE = 1e-3 * WIRE.length
"""Small: what is not linear is of the order of its square."""


def speeds(places: Array) -> Array:
    """Return the beam's velocities across at places along it, m/s, that give its end the amplitude, see theory/wire.py."""
    bending = WIRE.modulus * second_moment_of_area(WIRE.wire_diameter)
    wave = math.sqrt(math.tau * FREQUENCY) * (WIRE.mass / (bending * WIRE.length)) ** 0.25
    end, root = wave * WIRE.length, TOOL.belt.stiffness / (2.0 * bending * wave)
    # sin + B sinh + C (cos - cosh): C = -root (1 + B) by the belt, and no moment at the free end.
    both = math.cos(end) + math.cosh(end)
    factor = (math.sin(end) - root * both) / (math.sinh(end) + root * both)

    def shape(at: Array) -> Array:
        return np.asarray(np.sin(at) + factor * np.sinh(at) - root * (1.0 + factor) * (np.cos(at) - np.cosh(at)))

    return np.asarray(AMPLITUDE * math.tau * FREQUENCY * shape(wave * places) / shape(np.array(end)))


def rates(links: int) -> Array:
    """Return the rates of a chain's links in its own mode, rad/s, that give its end the amplitude at the beam's frequency."""
    shape = chain_modes(*BEAM, links)[1][:, 1]
    return np.asarray(AMPLITUDE * math.tau * FREQUENCY * shape * links / (WIRE.length * shape.sum()))


def through_scene(links: int, accuracy: float) -> Vibration:
    """Return the vibration of a chain in the scene, to an accuracy."""
    tool = Tool(hub=TOOL.hub, bristle=Bristle(links=links), bar=None, workpart=TOOL.workpart)
    found = rates(links).tolist()
    scene, units, _ = build_wire(tool, 0.0, [0.0] * links, found)
    start = State(0.0, (0.0,) * links, tuple(rate * units.time for rate in found))
    period = 1.0 / FREQUENCY / units.time
    settings = Settings(accuracy=accuracy, maximum_steps=10**9)

    def vibrate() -> float:
        end = free_flight(scene, start, period, period, settings)[-1]
        return units.length * scene.mechanism.poses(end)[-1].tip[0]

    return vibrate


def in_mujoco(links: int, fineness: int) -> Vibration:
    """Return the vibration of the same links in MuJoCo, by Runge and Kutta's fourth order, in n^2 times so many steps."""
    mujoco, steps = importlib.import_module("mujoco"), fineness * links**2
    length, mass = WIRE.length / links, WIRE.mass / links
    hinge = float(hinge_stiffness(WIRE.wire_diameter, WIRE.length, WIRE.modulus, links))
    springs = [TOOL.belt.stiffness] + [hinge] * (links - 1)
    world = ""
    for link in reversed(range(links)):
        turn = mass * length**2 / 12.0
        world = f"""<body pos="0 {-length * bool(link)!r} 0"><joint type="hinge" axis="0 0 1" stiffness="{springs[link]!r}"/>
            <inertial pos="0 {-0.5 * length!r} 0" mass="{mass!r}" diaginertia="{turn!r} {turn!r} {turn!r}"/>{world}</body>"""
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><compiler boundmass="0" boundinertia="0"/><option integrator="RK4" gravity="0 0 0"
        timestep="{1.0 / FREQUENCY / steps!r}"><flag contact="disable" constraint="disable"/></option>
        <worldbody>{world}</worldbody></mujoco>"""
    )
    data, given = mujoco.MjData(model), np.diff(rates(links), prepend=0.0)

    def vibrate() -> float:
        mujoco.mj_resetData(model, data)
        data.qvel[:] = given
        mujoco.mj_step(model, data, steps)
        return float(length * np.sin(np.cumsum(data.qpos)).sum())

    return vibrate


def in_elastica(elements: int, courant: float) -> Vibration:
    """Return the vibration of PyElastica's rod, in units of length, mass and period, for which its tolerances are meant.

    ``courant``: step over the time that sound takes through an element.
    """
    elastica: Any = importlib.import_module("elastica")
    energy = WIRE.mass * (WIRE.length * FREQUENCY) ** 2
    modulus, belt = WIRE.modulus * WIRE.length**3 / energy, TOOL.belt.stiffness / energy
    radius = 0.5 * WIRE.wire_diameter / WIRE.length
    density = 1.0 / (math.pi * radius**2)
    steps = math.ceil(math.sqrt(modulus / density) * elements / courant)
    given = speeds(np.linspace(0.0, WIRE.length, elements + 1)) / (WIRE.length * FREQUENCY)

    class Root(elastica.ConstraintBase):  # type: ignore[misc]
        def constrain_values(self, system: Any, time: float) -> None:  # noqa: ARG002
            system.position_collection[:, 0] = 0.0

        def constrain_rates(self, system: Any, time: float) -> None:  # noqa: ARG002
            system.velocity_collection[:, 0] = 0.0

    class Belt(elastica.NoForces):  # type: ignore[misc]
        def apply_torques(self, system: Any, time: float = 0.0) -> None:  # noqa: ARG002
            system.external_torques[0, 0] -= belt * system.tangents[0, 0]

    class Simulator(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing):  # type: ignore[misc]
        pass

    def vibrate() -> float:
        simulator, options = Simulator(), {"youngs_modulus": modulus, "shear_modulus": modulus / 2.6}
        ways = np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0])
        rod = elastica.CosseratRod.straight_rod(elements, np.zeros(3), *ways, 1.0, radius, density, **options)
        simulator.append(rod)
        simulator.constrain(rod).using(Root, constrained_position_idx=(0,))
        simulator.add_forcing_to(rod).using(Belt)
        simulator.finalize()
        rod.velocity_collection[0] = given
        # Directors are normal, binormal and tangent: the rate about the normal, z, is the first.
        rod.omega_collection[0] = np.diff(given) * elements
        with contextlib.redirect_stdout(None):
            elastica.integrate(elastica.PositionVerlet(), simulator, 1.0, steps, progress_bar=False)
        return float(rod.position_collection[0, -1]) * WIRE.length

    return vibrate


def vibrations(most: int = 32) -> Iterator[tuple[str, int, float, float, float]]:
    """Yield method, number of links or elements up to ``most``, setting, relative error and CPU time in s."""
    ways: tuple[tuple[str, str, Callable[..., Vibration], tuple[float, ...]], ...] = (
        ("pymunk scene, accuracy", "pymunk", through_scene, (1e-3,)),
        ("mujoco rk4, steps/n^2", "mujoco", in_mujoco, (4, 40)),
        ("pyelastica verlet, Courant", "elastica", in_elastica, (0.1, 0.05)),
    )
    counts = [count for count in (2, 4, 8, 16, 32) if count <= most]
    for (name, module, build, settings), count in itertools.product(ways, counts):
        for setting in settings if count <= SCENE or name != ways[0][0] else ():
            try:
                importlib.import_module(module)
            except ImportError:
                continue
            vibrate = build(count, setting)
            vibrate()  # compiles what is compiled at the first call
            begin = time.process_time()
            error = abs(vibrate()) / AMPLITUDE
            yield name, count, setting, error, time.process_time() - begin


def main() -> None:
    """Print error against CPU time, and on what it was measured."""
    print(f"{'method':30}{'pieces':>8}{'setting':>10}{'error':>10}{'CPU ms':>10}")
    for name, count, setting, error, seconds in vibrations():
        print(f"{name:30}{count:8d}{setting:10g}{error:10.1e}{1e3 * seconds:10.1f}", flush=True)
    print("\n".join(f"{key}: {value}" for key, value in surroundings().items()))


if __name__ == "__main__":
    main()
