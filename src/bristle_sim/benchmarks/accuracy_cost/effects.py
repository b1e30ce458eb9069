"""What each effect costs: per engine step, per pass and per strike.

The bare scene is a bristle hinged to a turning hub. Each effect is added to it alone, and all together; costs are given
as multiples of the bare scene's. What a scene holds is listed with its cost: an absent effect adds no
body, no constraint, no shape and no callback.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import StrikeCase
from bristle_sim.benchmarks.accuracy_cost.measure import Effect, Effort, cpu_times
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, ContactStiffness, Tool, Workpart
from bristle_sim.scene.simulate import simulate, simulate_row
from bristle_sim.scene.strike import strike
from bristle_sim.scene.tool import build_tool
from bristle_sim.settings import Settings
from bristle_sim.studies.flexible_wire import FlexibleStrike

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

LINKS, BRISTLES = (1, 2, 4, 8, 16), (1, 2, 4)
"""Links of a wire and bristles of a row whose costs are compared with those of one; two of either at less than full effort."""

GAMMA, RATE = 0.4084, 845.6
"""Impact angle, rad, and rate of the wire that strikes, rad/s (Zhang 2020, caption of fig. 2.30)."""

APART: dict[str, Any] = {"pitch": 0.4, "neighbour_friction": 0.0, "neighbour_restitution": 1.0, "stop_after": "strike"}
"""A row whose bristles touch nobody up to their strikes."""

Actions = dict[str, tuple[Callable[[], Any], str]]
"""What is timed, and what its scene holds, in which the result of a first call is named {0}."""


def effects(case: StrikeCase, effort: Effort) -> list[Effect]:
    """Return all rows: steps, passes, strikes; ``case`` is the strike that the contact laws are timed on.

    Passes last three quarters of a hub turn, or up to where the scene stops by itself. A strike of a wire is resolved in
    time to 1e-4.
    """
    full = effort.effort == "full"
    passes = PASSES if full else dict(list(PASSES.items())[:3])
    given = (case.chain, case.surface), Settings(accuracy=1e-3)
    priced: dict[str, Actions] = {
        "pass": {
            name: (partial(simulate, *each, start_relative_angle=START), f"{_contents(each[0])}; {{0.stop_reason}}")
            for name, each in passes.items()
        },
        "strike": {
            law: (partial(strike, *given[0], Contact(law), given[1]), "one rod")
            for law in ("energetic", "engine", "compliant")
        },
        "links": {str(links): (_wire(links), "a strike") for links in LINKS[: None if full else 2]},
        "bristles": {
            str(count): (partial(simulate_row, WHOLE, bristles=count, **APART), "a row")
            for count in BRISTLES[: None if full else 2]
        },
    }
    return [*steps(effort), *(row for what, actions in priced.items() for row in _priced(what, actions, effort))]


def steps(effort: Effort) -> list[Effect]:
    """Time engine steps of each scene in flight, and with a callback before each."""
    actions: Actions = {
        name: (partial(build_tool(tool)[0].step, STEP, STEPS), _contents(tool)) for name, tool in ADDED.items()
    }
    loaded = partial(build_tool(BARE)[0].step, STEP, STEPS, lambda: None)
    return _priced("engine step", actions | {"a load's callback": (loaded, _contents(BARE))}, effort, STEPS)


def _priced(what: str, actions: Actions, effort: Effort, number: int = 1) -> list[Effect]:
    """Return the costs of actions that each do a number of things."""
    results = [action() for action, _ in actions.values()]
    times = [least / number for least, _ in cpu_times([action for action, _ in actions.values()], effort)]
    found = []
    for (name, (_, holds)), time, result in zip(actions.items(), times, results, strict=True):
        single = result[0] if isinstance(result, Sequence) else result
        count = getattr(getattr(single, "cost", single), "steps", None)
        found.append(Effect(what, name, time, time / times[0], holds.format(result), count))
    return found


def _contents(tool: Tool) -> str:
    space = build_tool(tool)[0].space
    return f"{len(space.bodies)} bodies, {len(space.constraints)} constraints, {len(space.shapes)} shapes"


def _wire(links: int) -> Callable[[], Any]:
    """Return a strike of a wire of links at the impact angle."""
    part = Workpart(friction=0.0, penetration=(WHOLE.hub.radius + WHOLE.bristle.length) * (1.0 - math.cos(GAMMA)))
    tool = Tool(bristle=Bristle(links=links), bar=None, workpart=part)
    return FlexibleStrike(tool, GAMMA, RATE, ContactStiffness(), Settings(accuracy=1e-4)).run
