"""What each effect costs: per engine step, per pass and per strike, and what importing each part takes.

The bare scene is a bristle hinged to a turning hub. Each effect is added to it alone, and all together; costs are given
as multiples of the bare scene's. What a scene holds is listed with its cost: an absent effect adds no
body, no constraint, no shape and no callback.
"""

from __future__ import annotations

import functools
import json
import math
import subprocess
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import StrikeCase
from bristle_sim.benchmarks.accuracy_cost.measure import Effort, cpu_times
from bristle_sim.parameters import Bar, Belt, Contact, Tool, Workpart
from bristle_sim.scene.build import HOLD_ITERATIONS, Scene
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.strike import strike
from bristle_sim.scene.tool import build_tool, simulate
from bristle_sim.settings import Settings

__all__ = ["Effect", "effects"]

BARE = Tool(belt=Belt(0.0), bar=None, workpart=None)
WHOLE = Tool()

ADDED: dict[str, Tool] = {
    "bare: hub and bristle": BARE,
    "belt": replace(BARE, belt=Belt()),
    "belt, damped": replace(BARE, belt=Belt(damping_ratio=0.02)),
    "gravity": replace(BARE, gravity=9.81),
    "bar": replace(BARE, bar=Bar()),
    "bar with friction": replace(BARE, bar=Bar(friction=0.2)),
    "workpart, frictionless": replace(BARE, workpart=Workpart(friction=0.0)),
    "workpart with friction": replace(BARE, workpart=Workpart()),
    "all of them": replace(WHOLE, belt=Belt(damping_ratio=0.02), bar=Bar(friction=0.2), gravity=9.81),
}

PASSES: dict[str, tuple[Tool, Settings]] = {
    **{name: (tool, Settings()) for name, tool in ADDED.items()},
    "the tool, energetic contact": (WHOLE, Settings()),
    "the tool, compliant contact": (replace(WHOLE, contact=Contact("compliant")), Settings()),
    "the tool, engine's contact": (replace(WHOLE, contact=Contact("engine")), Settings()),
    "the tool, recorded ten times as densely": (WHOLE, Settings(samples_per_period=240)),
    "the tool, accuracy 1e-3": (WHOLE, Settings(accuracy=1e-3)),
    "the tool, accuracy 1e-9": (WHOLE, Settings(accuracy=1e-9)),
}

MODULES = (
    "numpy",
    "bristle_sim",
    "bristle_sim.parameters",
    "bristle_sim.theory.cueing",
    "bristle_sim.theory.impact",
    "bristle_sim.scene.tool",
    "bristle_sim.reference",
    "bristle_sim.scenario_cli",
    "bristle_sim.studies.whole_pass",
    "bristle_sim.render.pass_figure",
    "bristle_sim.render.pass_video",
)
HEAVY = ("numpy", "pymunk", "scipy.integrate", "matplotlib", "matplotlib.pyplot", "PIL")

STEP = 1e-9
"""Length of the engine steps that are timed, engine units: the scene stays where it is."""

STEPS = 200
"""Engine steps in one timing."""

START = -0.1
"""Relative angle at the start of a pass, rad, so that something moves in every scene."""


@dataclass(frozen=True, slots=True)
class Effect:
    """One row: what was added, what it cost (CPU s) and how that compares with the first row of its kind.

    ``what`` is ``engine step``, ``pass``, ``strike`` or ``import``; ``holds`` counts what the scene has, or names the
    libraries that an import loads; ``steps`` are engine steps taken.
    """

    what: str
    effect: str
    cpu_s: float
    ratio: float
    holds: str
    steps: int | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the row as plain values."""
        return {name: getattr(self, name) for name in self.__slots__}


def effects(case: StrikeCase, effort: Effort) -> list[Effect]:
    """Return all rows: steps, passes, strikes, imports; ``case`` is the strike that the contact laws are timed on."""
    full = effort.effort == "full"
    passes, modules = (PASSES, MODULES) if full else (dict(list(PASSES.items())[:3]), MODULES[:3])
    return [*_steps(effort), *_passes(passes, effort), *_strikes(case, effort), *_imports(modules, effort)]


def _rows(
    what: str,
    actions: dict[str, Callable[[], Any]],
    holds: Iterable[str],
    number: int,
    steps: list[int | None],
    effort: Effort,
) -> list[Effect]:
    """Return the costs of actions that each do a number of things."""
    times = [least / number for least, _ in cpu_times(list(actions.values()), effort)]
    return [
        Effect(what, name, time, time / times[0], contents, count)
        for name, time, contents, count in zip(actions, times, holds, steps, strict=True)
    ]


def _steps(effort: Effort) -> list[Effect]:
    """Time engine steps of each scene in flight, with a callback before each, and with the tip in contact."""
    scenes = {name: build_tool(tool)[0] for name, tool in ADDED.items()}
    actions: dict[str, Callable[[], Any]] = {
        name: functools.partial(scene.step, STEP, STEPS) for name, scene in scenes.items()
    }
    bare, touching = build_tool(BARE)[0], _touching()
    actions["a load's callback"] = functools.partial(bare.step, STEP, STEPS, lambda _: None)
    actions["engine's contact with the tip"] = functools.partial(touching.step, STEP, STEPS)
    built = [_contents(scene) for scene in (*scenes.values(), bare, touching)]
    return _rows("engine step", actions, built, STEPS, [None] * len(actions), effort)


def _contents(scene: Scene) -> str:
    space = scene.space
    return f"{len(space.bodies)} bodies, {len(space.constraints)} constraints, {len(space.shapes)} shapes"


def _touching() -> Scene:
    """Return a radial bristle at the angle at which its tip touches the workpart, and the engine's contact switched on."""
    tool = replace(BARE, workpart=Workpart())
    angle = -math.acos(tool.workpart_depth / (tool.hub.radius + tool.bristle.length))
    scene, _ = build_tool(tool, hub_start=angle)
    scene.place(State(0.0, (angle,), (-scene.mechanism.hub_speed * scene.mechanism.hub_radius,)))
    (obstacle,) = scene.effects.obstacles
    scene.contacts.engage(obstacle, friction=obstacle.friction, elasticity=0.0, iterations=HOLD_ITERATIONS)
    return scene


def _passes(passes: dict[str, tuple[Tool, Settings]], effort: Effort) -> list[Effect]:
    """Time passes over three quarters of a hub turn, or up to where the scene stops by itself."""
    actions = {
        name: functools.partial(simulate, tool, settings, start_relative_angle=START)
        for name, (tool, settings) in passes.items()
    }
    runs = [action() for action in actions.values()]
    scenes = [build_tool(tool)[0] for tool, _ in passes.values()]
    built = [f"{_contents(scene)}; {run.stop_reason}" for scene, run in zip(scenes, runs, strict=True)]
    return _rows("pass", dict(actions), built, 1, [run.cost.steps for run in runs], effort)


def _strikes(case: StrikeCase, effort: Effort) -> list[Effect]:
    """Time one strike under each contact law."""
    actions = {
        law: functools.partial(strike, case.chain, case.surface, Contact(law), Settings(accuracy=1e-3))
        for law in ("energetic", "engine", "compliant")
    }
    counts = [action().steps for action in actions.values()]
    return _rows("strike", dict(actions), ["one rod"] * len(actions), 1, list(counts), effort)


IMPORT = """
import json, sys, time
begin = time.process_time()
import {module}
print(json.dumps([time.process_time() - begin, [name for name in {heavy!r} if name in sys.modules]]))
"""


def _imports(modules: Iterable[str], effort: Effort) -> list[Effect]:
    """Time imports in fresh interpreters, the least of some, and name the heavy libraries that each loads."""
    rows: list[Effect] = []
    for module in modules:
        found = [_imported(module) for _ in range(min(3, effort.rounds))]
        least = min(time for time, _ in found)
        first = rows[0].cpu_s if rows else least
        rows.append(Effect("import", module, least, least / first, ", ".join(found[0][1]) or "none of the heavy ones"))
    return rows


def _imported(module: str) -> tuple[float, list[str]]:
    text = IMPORT.format(module=module, heavy=HEAVY)
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    time, loaded = json.loads(done.stdout)
    return float(time), list(loaded)
