"""Equal input gives equal bits: again, among other runs, in threads, in optimised processes, saved and loaded."""

from __future__ import annotations

import ast
import dataclasses
import gc
import hashlib
import math
import os
import subprocess
import sys
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pymunk
import pytest

from bristle_sim.contact_space.energetic_contact import EnergeticContact
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Surface, Tool, Workpart
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.scene.tool import build_tool
from bristle_sim.settings import Settings

SETTINGS = Settings(accuracy=1e-6)

TOOLS = {
    "energetic": Tool(),
    "engine": Tool(contact=Contact("engine")),
    "compliant, 0.1 ms": Tool(contact=Contact("compliant", 1e-4)),
    "damped, bar that throws back": Tool(belt=Belt(damping_ratio=0.05), bar=Bar(restitution=0.9)),
    "bent, rough bar and workpart": Tool(
        bristle=Bristle(knee_angle_deg=20.0), bar=Bar(friction=0.2), workpart=Workpart(friction=0.6)
    ),
}
"""Passes by each contact law and with what else a scene can hold."""


def falling_rods(steps: int = 400) -> list[tuple[float, float, float]]:
    """Let rods fall on a floor in a space of the engine's own."""
    space = pymunk.Space()
    space.gravity = (0.0, -9.81)
    floor = pymunk.Segment(space.static_body, (-5.0, -1.0), (5.0, -1.0), 1.0)
    rods = [pymunk.Body(1.0, 1.0 / 12.0) for _ in range(3)]
    shapes = [pymunk.Segment(body, (0.0, -0.5), (0.0, 0.5), 0.01) for body in rods]
    for index, body in enumerate(rods):
        body.position = (2.0 * index - 2.0, 0.6)
        body.angle = 0.3 * (index + 1)
    for shape, kind in zip((floor, *shapes), (1, 2, 2, 2), strict=True):
        shape.collision_type = kind
    space.add(floor, *rods, *shapes)
    contact = EnergeticContact(space, 1, 2, friction=0.4, restitution=0.6)
    for _ in range(steps):
        contact.step(1e-3)
    return [(body.position.x, body.position.y, body.angle) for body in rods]


def two_rods(law: str) -> object:
    """Let two rods strike whose slip reverses."""
    rods = Chain((5.0, 5.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2))
    return strike(rods, Surface(0.5, None, 0.5), Contact(law), SETTINGS).contact


RUNS: dict[str, Callable[[], object]] = {
    **{name: partial(simulate, tool, SETTINGS) for name, tool in TOOLS.items()},
    "two rods, compliant": partial(two_rods, "compliant"),
    "rods in another space": falling_rods,
}


def bits(result: object) -> str:
    """Return every bit of a result but what it cost in time, as a short text."""
    digest = hashlib.sha256()
    _take(digest.update, result)
    return digest.hexdigest()[:16]


def _take(update: Callable[[bytes], None], part: object) -> None:
    if dataclasses.is_dataclass(part):
        for each in dataclasses.fields(part):
            if each.name not in ("wall_s", "cpu_s"):
                _take(update, getattr(part, each.name))
    elif isinstance(part, tuple | list):
        update(b"(")
        for each in part:
            _take(update, each)
    elif hasattr(part, "tobytes"):
        update(part.tobytes())
    else:
        update(repr(part).encode())


@pytest.fixture(scope="module")
def first() -> dict[str, str]:
    """Run everything once, one after the other."""
    return {name: bits(run()) for name, run in RUNS.items()}


def test_again_among_other_runs_and_in_threads(first: dict[str, str]) -> None:
    with ThreadPoolExecutor(4) as pool:
        again = dict(
            zip(
                reversed(RUNS),
                pool.map(lambda name: bits(RUNS[name]()), reversed(RUNS)),
                strict=True,
            )
        )
    assert again == first


def strike_impulse(friction: float) -> float:
    """Return the final normal impulse of a strike, the coarsest run there is."""
    tool = Tool(workpart=Workpart(friction=friction))
    return simulate(tool, Settings(accuracy=1e-3), stop_after="strike").contacts[-1].impulse[0]


def equal_in_threads(runs: int) -> bool:
    """Compare runs of eight threads with serial ones; the collector of each frees what others have left."""
    frictions = (0.2, 0.31, 0.5)
    expected = [*map(strike_impulse, frictions), falling_rods(200)]

    def same(number: int) -> bool:
        kind = number % len(expected)
        found = strike_impulse(frictions[kind]) if kind < len(frictions) else falling_rods(200)
        return found == expected[kind]

    with ThreadPoolExecutor(8) as pool:
        return all(pool.map(same, range(runs)))


@pytest.mark.parametrize("runs", [160, pytest.param(4000, marks=pytest.mark.nightly)])
def test_eight_threads_run_side_by_side(runs: int) -> None:
    """In a process of its own, which a fault would end."""
    in_a_process(f"assert equal_in_threads({runs})")


def equal_in_threaded_sweeps() -> bool:
    """Compare sweeps whose points run in the threads of a pool, or of a Dask worker, with a serial one."""
    import distributed

    from bristle_sim.studies.sweep import sweep

    space = {"friction": np.linspace(0.1, 0.6, 200)}
    expected = sweep(strike_impulse, space, progress=False)
    with ThreadPoolExecutor(8) as pool:
        equal = sweep(strike_impulse, space, workers=pool, progress=False).identical(expected)
    layout = {"n_workers": 1, "threads_per_worker": 8, "dashboard_address": ":0"}
    with (
        distributed.LocalCluster(**layout, processes=False) as cluster,
        distributed.Client(cluster) as client,
    ):
        return equal and sweep(
            strike_impulse, space, workers=client.get_executor(), progress=False
        ).identical(expected)


@pytest.mark.nightly
def test_sweeps_in_threads_equal_the_serial_one() -> None:
    pytest.importorskip("distributed", reason="needs the extra sweep")
    in_a_process("assert equal_in_threaded_sweeps()")


def test_a_space_is_freed_while_it_holds_its_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    """Were they garbage already, the collector of another thread would remove them at the same time."""
    engine = pymunk.space.lib
    left = []
    scene, _ = build_tool(Tool())
    bodies = weakref.WeakSet(scene.links)

    class Recorded:
        def __getattr__(self, name: str) -> object:
            if name == "cpSpaceEachBody":
                gc.collect()
                left.append(len(bodies))
            return getattr(engine, name)

    step = scene.step
    monkeypatch.setattr("pymunk.space.lib", Recorded())
    del scene
    gc.collect()
    del step  # it steps the space
    gc.collect()
    assert set(left) == {1}


def in_a_process(statement: str) -> None:
    """Run a statement with the names of this file in a process of its own."""
    subprocess.run(
        [sys.executable, "-c", f"from promises.test_repeatability import *\n{statement}"],
        timeout=300.0,
        check=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )


def test_in_another_process_without_asserts_and_with_other_hashes(first: dict[str, str]) -> None:
    program = "from promises.test_repeatability import RUNS, bits\nprint([bits(run()) for run in RUNS.values()])"
    done = subprocess.run(
        [sys.executable, "-OO", "-c", program],
        capture_output=True,
        text=True,
        timeout=60.0,
        check=True,
        env=os.environ | {"PYTHONHASHSEED": "1", "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert ast.literal_eval(done.stdout) == list(first.values())


def test_a_bit_that_differs_is_noticed(first: dict[str, str]) -> None:
    run = simulate(Tool(), SETTINGS)
    for name in ("time", "angles", "potential_energy"):
        array = getattr(run, name).copy()
        array.flat[-1] = math.nextafter(array.flat[-1], math.inf)
        assert bits(dataclasses.replace(run, **{name: array})) != first["energetic"]
    event = dataclasses.replace(run.events[0], time=math.nextafter(run.events[0].time, 1.0))
    assert bits(dataclasses.replace(run, events=(event, *run.events[1:]))) != first["energetic"]
    assert (
        bits(simulate(Tool(), Settings(accuracy=math.nextafter(1e-6, 1.0)))) != first["energetic"]
    )
