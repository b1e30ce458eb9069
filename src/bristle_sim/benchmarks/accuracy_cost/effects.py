"""What each effect costs per engine step, and how cost grows with the links of a wire and the bristles of a row.

The bare scene is a bristle hinged to a turning hub. Each effect is added to it alone, and all together; costs are given
as multiples of the bare scene's. What a scene holds is listed with its cost: an absent effect adds no
body, no constraint, no shape and no callback.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.measure import Effect, Effort, cpu_times
from bristle_sim.parameters import Bar, Belt, Bristle, ContactStiffness, Tool, Workpart
from bristle_sim.scene.simulate import simulate_row
from bristle_sim.scene.tool import build_tool
from bristle_sim.settings import Settings
from bristle_sim.studies.flexible_wire import FlexibleStrike

BARE, WHOLE = Tool(belt=Belt(0.0), bar=None, workpart=None), Tool()

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

STEP, STEPS = 1e-9, 200
"""Length, in engine units, and number of the engine steps in one timing: the scene stays where it is."""

LINKS, BRISTLES = (1, 2, 4, 8, 16), (1, 2, 4)
"""Links of a wire and bristles of a row whose costs are compared with those of one; two of either at less than full effort."""

GAMMA, RATE = 0.4084, 845.6
"""Impact angle, rad, and rate of the wire that strikes, rad/s (Zhang 2020, caption of fig. 2.30)."""

APART: dict[str, Any] = {"pitch": 0.4, "neighbour_friction": 0.0, "neighbour_restitution": 1.0, "stop_after": "strike"}
"""A row whose bristles touch nobody up to their strikes."""

Actions = dict[str, tuple[Callable[[], Any], str]]
"""What is timed by the name of its effect, and what its scene holds."""


def effects(effort: Effort) -> list[Effect]:
    """Return all rows: steps, strikes of wires, which are resolved in time to 1e-4, and rows of bristles up to their strikes."""
    some = None if effort.effort == "full" else 2
    wires: Actions = {str(links): (_strike_of(links), "a strike") for links in LINKS[:some]}
    rows: Actions = {str(n): (partial(simulate_row, WHOLE, bristles=n, **APART), "a row") for n in BRISTLES[:some]}
    return [*steps(effort), *_priced("links", wires, effort), *_priced("bristles", rows, effort)]


def steps(effort: Effort) -> list[Effect]:
    """Time engine steps of each scene in flight, and with a callback before each."""
    scenes = {name: build_tool(tool)[0] for name, tool in ADDED.items()}
    actions: Actions = {name: (partial(each.step, STEP, STEPS), _contents(each)) for name, each in scenes.items()}
    loaded = build_tool(BARE)[0]
    actions["a load's callback"] = (partial(loaded.step, STEP, STEPS, lambda: None), _contents(loaded))
    return _priced("engine step", actions, effort, STEPS)


def _priced(what: str, actions: Actions, effort: Effort, number: int = 1) -> list[Effect]:
    """Return the costs of actions that each do a number of things."""
    times = [least / number for least, _ in cpu_times([action for action, _ in actions.values()], effort)]
    rows = zip(actions.items(), times, strict=True)
    return [Effect(what, name, time, time / times[0], holds) for (name, (_, holds)), time in rows]


def _contents(scene: Any) -> str:
    space = scene.space
    return f"{len(space.bodies)} bodies, {len(space.constraints)} constraints, {len(space.shapes)} shapes"


def _strike_of(links: int) -> Callable[[], Any]:
    """Return a strike of a wire of links at the impact angle."""
    part = Workpart(friction=0.0, penetration=(WHOLE.hub.radius + WHOLE.bristle.length) * (1.0 - math.cos(GAMMA)))
    tool = Tool(bristle=Bristle(links=links), bar=None, workpart=part)
    return FlexibleStrike(tool, GAMMA, RATE, ContactStiffness(), Settings(accuracy=1e-4)).run
