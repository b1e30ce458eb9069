"""Runs whose budget of engine steps is too small, of every kind of motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, row
from bristle_sim.benchmarks.hard_cases.contact import WEDGE, above, falling, starting_at, tapping, wedged
from bristle_sim.benchmarks.hard_cases.measures import ONE_INTERVAL, RELEASED, Start, spends_budget
from bristle_sim.parameters import Contact, Hub, Tool
from bristle_sim.settings import Settings

TOOL = Tool()

ATTEMPTS = 100
"""Most attempts to locate an event: the engine steps of an interval with an event where each takes one fixed step."""

GAMMA = math.acos(TOOL.workpart_depth / (TOOL.hub.radius + TOOL.bristle.length))
"""Angle from the workpart's direction at which a radial tip touches it, rad."""

LONG = 1e4
"""Turn of the hub, rad, that no budget here suffices for."""


def budget() -> list[HardCase]:
    """Return every kind of motion with budgets of 1 to 1000 engine steps, which are looked at between intervals."""
    rows = []
    for name, (tool, settings, start) in _motions().items():
        beyond = ATTEMPTS if settings.step else ONE_INTERVAL
        promise = f"says so, at most {beyond} steps beyond it (one interval), all numbers finite"
        spend = partial(spends_budget, tool, beyond=beyond, settings=settings, start=start)
        rows.append(row("budget", f"{name}; 1, 10, 1000 steps", promise, _spends_each, spend))
    return rows


def _spends_each(spend: Callable[[int], Finding]) -> Finding:
    return all_of(*map(spend, (1, 10, 1000)))


def _motions() -> dict[str, tuple[Tool, Settings, Start]]:
    """Return tool, settings and start of every kind of motion."""
    bare = replace(TOOL, bar=None)
    free, slow = replace(bare, workpart=None), Contact("compliant", duration=1e-3)
    long, fixed = Settings(hub_turn=LONG), Settings(step=1e-6, hub_turn=LONG)
    striking: Start = {"start_hub_angle": -GAMMA, "start_relative_rate": 583.8}
    on_bar, folded = starting_at("bar")
    return {
        "flight": (free, long, RELEASED),
        "flight, fixed steps": (free, fixed, RELEASED),
        "sustained contact with the bar": (replace(on_bar, hub=Hub(speed=1e-3)), long, folded),
        "chatter on the bar, restitution 0.999": (tapping(0.999), long, {}),
        "taps that never end": (falling(1.0), long, above(0.3)),
        "elastic wedge": (wedged(1.0), long, WEDGE),
        "long contact resolved in time": (replace(bare, contact=slow), long, striking),
        "contact by the engine's law": (replace(bare, contact=Contact("engine")), long, striking),
        "whole pass": (TOOL, long, {}),
    }
