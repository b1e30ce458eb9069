"""What each effect costs: per engine step, per pass and per strike.

The bare scene is a bristle hinged to a turning hub. Each effect is added to it alone, and all together; costs are given
as multiples of the bare scene's. What a scene holds is listed with its cost: an absent effect adds no
body, no constraint, no shape and no callback.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import StrikeCase
from bristle_sim.benchmarks.accuracy_cost.measure import Effect, Effort, cpu_times
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, ContactStiffness, Tool, Workpart
from bristle_sim.scene.build import Scene
from bristle_sim.scene.strike import strike
from bristle_sim.scene.tool import build_tool, simulate, simulate_row
from bristle_sim.scene.wire_strike import strike_wire
from bristle_sim.settings import Settings

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

STEP = 1e-9
"""Length of the engine steps that are timed, engine units: the scene stays where it is."""

STEPS = 200
"""Engine steps in one timing."""

START = -0.1
"""Relative angle at the start of a pass, rad, so that something moves in every scene."""


def effects(case: StrikeCase, effort: Effort) -> list[Effect]:
    """Return all rows: steps, passes, strikes; ``case`` is the strike that the contact laws are timed on."""
    passes = PASSES if effort.effort == "full" else dict(list(PASSES.items())[:3])
    return [*_steps(effort), *_passes(passes, effort), *_strikes(case, effort), *growth(effort)]


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
    """Time engine steps of each scene in flight, and with a callback before each."""
    scenes = {name: build_tool(tool)[0] for name, tool in ADDED.items()}
    actions: dict[str, Callable[[], Any]] = {
        name: functools.partial(scene.step, STEP, STEPS) for name, scene in scenes.items()
    }
    bare = build_tool(BARE)[0]
    actions["a load's callback"] = functools.partial(bare.step, STEP, STEPS, lambda: None)
    built = [_contents(scene) for scene in (*scenes.values(), bare)]
    return _rows("engine step", actions, built, STEPS, [None] * len(actions), effort)


def _contents(scene: Scene) -> str:
    space = scene.space
    return f"{len(space.bodies)} bodies, {len(space.constraints)} constraints, {len(space.shapes)} shapes"


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


LINKS, BRISTLES = (1, 2, 4, 8, 16), (1, 2, 4)
"""Links of a wire and bristles of a row whose costs are compared with those of one; two of either at less than full effort."""

GAMMA, RATE = 0.4084, 845.6
"""Impact angle, rad, and rate of the wire that strikes, rad/s (Zhang 2020, caption of fig. 2.30)."""

APART = 0.4
"""Pitch of the row, rad: its bristles touch nobody up to their strikes."""


def growth(effort: Effort) -> list[Effect]:
    """Time a strike of a wire over its number of links, resolved in time to 1e-4, and a row's way to its strikes over its bristles."""
    most = None if effort.effort == "full" else 2
    reach = WHOLE.hub.radius + WHOLE.bristle.length
    part = Workpart(friction=0.0, penetration=reach * (1.0 - math.cos(GAMMA)))
    strikes: dict[str, Callable[[], Any]] = {}
    for links in LINKS[:most]:
        tool = Tool(bristle=Bristle(links=links), bar=None, workpart=part)
        stiffness = ContactStiffness().stiffness(3.0 * math.sin(GAMMA) ** 2 / tool.bristle.mass, part.restitution)
        start = (tool, -GAMMA, [-GAMMA] * links, [RATE] * links, stiffness, Settings(accuracy=1e-4))
        strikes[str(links)] = functools.partial(strike_wire, *start, duration=ContactStiffness().duration)
    counts = [action().steps for action in strikes.values()]
    rows = _rows("links", strikes, ["a strike"] * len(strikes), 1, list(counts), effort)
    surface: dict[str, Any] = {"neighbour_friction": 0.0, "neighbour_restitution": 1.0}
    passes: dict[str, Callable[[], Any]] = {
        str(count): functools.partial(simulate_row, WHOLE, bristles=count, pitch=APART, stop_after="strike", **surface)
        for count in BRISTLES[:most]
    }
    counts = [action()[0].cost.steps for action in passes.values()]
    return rows + _rows("bristles", passes, ["a row"] * len(passes), 1, list(counts), effort)
