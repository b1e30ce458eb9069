"""Measure what an impact costs, by the law and through a scene, and a step at rest. ``python tests/benchmarks/law_benchmark.py``

CPU time of one process, the least of several rounds that take turns, so that a noisy machine disturbs all alike.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pymunk

from bristle_sim import EnergeticContact
from bristle_sim.benchmarks.machine import surroundings
from bristle_sim.parameters import Surface
from bristle_sim.scene.impacts import EnergeticLaw
from bristle_sim.scene.strike import Chain, build_strike
from bristle_sim.theory.impact import energetic_impact

SINGLE = Chain((1.0,), (1.0,), (-0.41,), (3.0,))
DOUBLE = Chain((1.0, 1.0), (1.0, 1.0), (-0.35, -0.52), (0.1, 0.2))
SURFACE = Surface(0.3, None, 0.5)


def costs(rounds: int = 9, size: int = 1_000_000) -> dict[str, float]:
    """Return CPU seconds of one impact or step by each way, the least of ``rounds``; arrays hold ``size`` impacts."""
    rng = np.random.default_rng(0)
    roots = rng.normal(size=(size, 2, 2))
    velocity = rng.normal(size=(size, 2))
    masses = roots @ roots.transpose(0, 2, 1)
    velocity[:, 0] = -np.abs(velocity[:, 0])
    friction = rng.uniform(0.0, 2.0, size)
    restitution = rng.uniform(0.0, 1.0, size)
    one = (masses[0], velocity[0], 0.3, 0.5)
    arrays = (masses, velocity, friction, restitution)
    ways: dict[str, tuple[Callable[[], object], int, int]] = {
        "law, arrays": (lambda: energetic_impact(*arrays), 1, size),
        "law, arrays, eta^2 = 1": (
            lambda: energetic_impact(*arrays, tangential_compliance=1.0),
            1,
            size,
        ),
        "law, one impact": (lambda: energetic_impact(*one), 500, 1),
        "scene, one rod": (_through_scene(SINGLE), 200, 1),
        "scene, two rods": (_through_scene(DOUBLE), 200, 1),
        **{
            f"step at rest, {balls:g}, {name}": (_step_at_rest(balls, contact), 200, 1)
            for balls in (1, 50)
            for name, contact in (("engine", False), ("contact", True))
        },
    }
    least = dict.fromkeys(ways, float("inf"))
    for _ in range(rounds):
        for name, (act, times, impacts) in ways.items():
            begin = time.process_time()
            for _ in range(times):
                act()
            least[name] = min(least[name], (time.process_time() - begin) / (times * impacts))
    return least


def _through_scene(chain: Chain) -> Callable[[], object]:
    """Return a call that places the bodies, builds K from them, solves, and sets their velocities."""
    scene, start, obstacle, _ = build_strike(chain, SURFACE)
    law = EnergeticLaw()
    return lambda: law.resolve(scene, start, obstacle)


def _step_at_rest(balls: int, contact: bool) -> Callable[[], object]:
    """Return a step of balls that lie on a floor, by the engine or with an EnergeticContact."""
    space = pymunk.Space()
    space.gravity = (0.0, -9.81)
    floor = pymunk.Segment(space.static_body, (-100.0, -1.0), (100.0, -1.0), 1.0)
    floor.collision_type = 1
    space.add(floor)
    for number in range(balls):
        body = pymunk.Body(1.0, 0.004)
        body.position = (0.5 * number, 0.1)
        shape = pymunk.Circle(body, 0.1)
        shape.collision_type = 2
        space.add(body, shape)
    step = (
        EnergeticContact(space, 1, 2, friction=0.3, restitution=0.5).step if contact else space.step
    )
    for _ in range(10):
        step(1e-6)
    return lambda: step(1e-6)


def main() -> None:
    """Print what was measured, on what, and how to measure it again."""
    found = costs()
    for name, seconds in found.items():
        print(f"{name:<26} {1e6 * seconds:10.3f} us")
    for name, value in surroundings().items():
        print(f"{name}: {value}")
    print("command: python tests/benchmarks/law_benchmark.py")


if __name__ == "__main__":
    main()
