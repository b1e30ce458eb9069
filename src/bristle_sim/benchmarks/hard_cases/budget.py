"""Runs whose step budget is too small for them: each ends within it, says so, and leaves finite numbers behind.

A budget is looked at between intervals of smooth motion. An interval is repeated with up to 24 steps, 144 in all, and again
for every attempt to locate an event in it; an impact that is resolved in time counts as one interval.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of
from bristle_sim.benchmarks.hard_cases.chatter import above, falling, tapping
from bristle_sim.benchmarks.hard_cases.measures import ONE_INTERVAL, Start, spends_budget
from bristle_sim.benchmarks.hard_cases.touching import WEDGE, between, wedged
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Belt, Contact, Hub, Tool
from bristle_sim.settings import Settings

__all__ = ["budget"]

TOOL = Tool()
BARE = replace(TOOL, bar=None)

ATTEMPTS = 100
"""Most attempts to locate an event: the engine steps of an interval with an event where each takes one fixed step."""

GAMMA = math.acos(TOOL.workpart_depth / (TOOL.hub.radius + TOOL.bristle.length))
"""Angle from the workpart's direction at which a radial tip touches it, rad."""

LONG = 1e4
"""Turn of the hub, rad, that no budget here suffices for."""


def budget() -> list[HardCase]:
    """Return every kind of motion with budgets of 1 to 3000 engine steps."""
    rows = []
    for name, (tool, settings, start) in _motions().items():
        beyond = ATTEMPTS if settings.step else ONE_INTERVAL
        promise = f"says so, at most {beyond} steps beyond it (one interval), all numbers finite"
        for budgets, quick in (((1, 10, 1000), True), ((3000,), False)):
            told = f"{name}; {', '.join(map(str, budgets))} steps"
            measure = partial(_spend, tool, settings, start, budgets, beyond)
            rows.append(HardCase("budget", told, promise, measure, quick))
    return rows


def _spend(tool: Tool, settings: Settings, start: Start, budgets: tuple[int, ...], beyond: int) -> Finding:
    return all_of(*(spends_budget(tool, each, beyond, settings=settings, start=start) for each in budgets))


def _motions() -> dict[str, tuple[Tool, Settings, Start]]:
    """Return tool, settings and start of every kind of motion."""
    free, slow = replace(BARE, workpart=None), Contact("compliant", duration=1e-3)
    long, fixed = Settings(hub_turn=LONG), Settings(step=1e-6, hub_turn=LONG)
    fine = Settings(accuracy=1e-11, hub_turn=LONG)
    released: Start = {"start_relative_angle": -RETRACTION_AT_RELEASE}
    folded: Start = {"start_hub_angle": -0.4, "start_relative_angle": -0.5}
    pressed: Start = {"start_hub_angle": -0.4, "start_relative_angle": -0.3}
    striking: Start = {"start_hub_angle": -GAMMA, "start_relative_rate": 583.8}
    on_workpart = replace(between(-0.4, -0.7, bar_gap=None), hub=Hub(speed=0.0))
    on_bar = replace(between(-0.4, -0.9, gap=None), hub=Hub(speed=1e-3))
    return {
        "flight": (free, long, released),
        "flight, accuracy 1e-11, damped": (replace(free, belt=Belt(damping_ratio=10.0)), fine, released),
        "flight, hub at 1e5 rad/s": (replace(free, hub=Hub(speed=1e5)), long, released),
        "flight, fixed steps": (free, fixed, released),
        "sustained contact with the bar": (on_bar, long, folded),
        "sustained contact with the bar, fixed steps": (on_bar, fixed, folded),
        "sustained contact with the workpart, fixed steps": (on_workpart, Settings(step=1e-7), pressed),
        "chatter on the bar, restitution 0.999": (tapping(0.999), long, {}),
        "taps that never end": (falling(1.0), long, above(0.3)),
        "taps that never end, fixed steps": (falling(1.0), Settings(step=1e-6), above(0.3)),
        "elastic wedge": (wedged(1.0), long, WEDGE),
        "contact resolved in time": (replace(BARE, contact=Contact("compliant")), long, striking),
        "long contact resolved in time": (replace(BARE, contact=slow), long, striking),
        "contact by the engine's law": (replace(BARE, contact=Contact("engine")), long, striking),
        "whole pass": (TOOL, long, {}),
    }
