"""Runs whose step budget is too small for them: each ends within it, says so, and leaves finite numbers behind.

A budget is looked at between stretches. A stretch is repeated with up to 24 steps, 144 in all, and again for every try
at an event in it; an impact that is resolved in time counts as one stretch.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, refusal
from bristle_sim.benchmarks.hard_cases.chatter import SURFACE, falling, tapping
from bristle_sim.benchmarks.hard_cases.touching import WEDGE, between
from bristle_sim.comparison import Report
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Belt, Contact, Hub, Tool
from bristle_sim.scene.repetitions import CLOSE
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.cue_timing import cue_timing
from bristle_sim.studies.whole_pass import whole_pass
from bristle_sim.trajectory import Trajectory

__all__ = ["SPENT", "arrays_of", "cases", "within_budget"]

THEME = "budget"

TOOL = Tool()
BARE = replace(TOOL, bar=None)

SPENT = "step budget spent"

BUDGETS = (1, 10, 1000)

TRIES = 100
"""At most, at an event, or stretches of a contact."""

ONE_STRETCH = TRIES * sum(CLOSE.counts)
"""Engine steps of a stretch with an event; those of a fixed step are as many as the tries."""

GAMMA = math.acos(TOOL.workpart_depth / (TOOL.hub.radius + TOOL.bristle.length))
"""Angle from the workpart's direction at which a radial tip touches it, rad."""

STRIKING = {"start_hub_angle": -GAMMA, "start_relative_rate": 583.8}

LONG = 1e4
"""Turn of the hub, rad, that no budget here suffices for."""

Kind = tuple[str, Tool, Settings, Mapping[str, float], int]


def cases(full: bool) -> tuple[HardCase, ...]:
    """Every kind of motion with every budget, and what scripts make of it."""
    budgets = (*BUDGETS, 3000) if full else BUDGETS
    return (*(_case(kind, budgets) for kind in _kinds()), *_scripts())


def _kinds() -> list[Kind]:
    """Name, tool, settings, start, and what one stretch may take."""
    released = {"start_relative_angle": -RETRACTION_AT_RELEASE}
    pressed = {"start_hub_angle": -0.4, "start_relative_angle": -0.3}
    folded = {"start_hub_angle": -0.4, "start_relative_angle": -0.5}
    above = {"start_hub_angle": 0.0, "start_relative_angle": SURFACE + 0.3}
    wedged = {"start_hub_angle": WEDGE[0], "start_relative_angle": WEDGE[1] - WEDGE[0]}
    free, still = replace(BARE, workpart=None), Hub(speed=0.0)
    on_workpart = replace(between(-0.4, -0.7, bar_gap=None), hub=still)
    on_bar = replace(between(-0.4, -0.9, gap=None), hub=Hub(speed=1e-3))
    long, fine = Settings(hub_turn=LONG), Settings(accuracy=1e-11, hub_turn=LONG)
    fixed = Settings(step=1e-6, hub_turn=LONG)
    slow = Contact("compliant", duration=1e-3)
    wedge = between(*WEDGE, bar_gap=2e-4, gap=2e-4)
    assert wedge.bar is not None
    assert wedge.workpart is not None
    wedge = replace(wedge, bar=replace(wedge.bar, restitution=1.0), workpart=replace(wedge.workpart, restitution=1.0))
    return [
        ("flight", free, long, released, ONE_STRETCH),
        ("flight, accuracy 1e-11, damped", replace(free, belt=Belt(damping_ratio=10.0)), fine, released, ONE_STRETCH),
        ("flight, hub at 1e5 rad/s", replace(free, hub=Hub(speed=1e5)), long, released, ONE_STRETCH),
        ("flight, fixed steps", free, fixed, released, TRIES),
        ("held on the bar", on_bar, long, folded, ONE_STRETCH),
        ("held on the bar, fixed steps", on_bar, fixed, folded, TRIES),
        ("held on the workpart, fixed steps", on_workpart, Settings(step=1e-7), pressed, TRIES),
        ("chatter on the bar, restitution 0.999", tapping(0.999), long, {}, ONE_STRETCH),
        ("taps that never end", falling(1.0), long, above, ONE_STRETCH),
        ("taps that never end, fixed steps", falling(1.0), Settings(step=1e-6), above, TRIES),
        ("elastic wedge", wedge, long, wedged, ONE_STRETCH),
        ("contact resolved in time", replace(BARE, contact=Contact("compliant")), long, STRIKING, ONE_STRETCH),
        ("long contact resolved in time", replace(BARE, contact=slow), long, STRIKING, ONE_STRETCH),
        ("contact by the engine's law", replace(BARE, contact=Contact("engine")), long, STRIKING, ONE_STRETCH),
        ("whole pass", TOOL, long, {}, ONE_STRETCH),
    ]


def _case(kind: Kind, budgets: tuple[int, ...]) -> HardCase:
    name, tool, settings, start, stretch = kind
    promise = f"says '{SPENT}', at most {stretch} steps beyond it, all numbers finite"
    budget = ", ".join(f"{each:g}" for each in budgets)
    return HardCase(THEME, f"{name}; {budget} steps", promise, partial(_spend, tool, settings, start, budgets, stretch))


def _spend(
    tool: Tool, settings: Settings, start: Mapping[str, float], budgets: tuple[int, ...], stretch: int
) -> Finding:
    runs = [
        simulate(
            tool,
            replace(settings, maximum_steps=budget),
            start_hub_angle=start.get("start_hub_angle", -0.5 * math.pi),
            start_relative_angle=start.get("start_relative_angle", 0.0),
            start_relative_rate=start.get("start_relative_rate", 0.0),
        )
        for budget in budgets
    ]
    return both(*(within_budget(run, budget, stretch) for run, budget in zip(runs, budgets, strict=True)))


def within_budget(run: Trajectory, budget: int, stretch: int) -> Finding:
    """Whether a run says that its budget is spent, soon after it is, and has numbers to show."""
    beyond = run.cost.steps - budget
    finite = all(np.isfinite(each).all() for each in arrays_of(run))
    told = (
        f"{beyond} beyond" + ("" if run.stop_reason == SPENT else f", {run.stop_reason}") + ("" if finite else ", NaN")
    )
    return Finding(told, run.stop_reason == SPENT and 0 <= beyond <= stretch and finite, run.cost.steps)


def arrays_of(run: Trajectory) -> list[np.ndarray]:
    """Every number of a trajectory's samples, events and contacts."""
    samples = [run.time, run.hub_angle, run.angles, run.rates, run.tip]
    energies = [run.kinetic_energy, run.potential_energy, run.normal_force]
    contacts = [
        np.array([contact.time, contact.duration, *contact.impulse, *contact.velocity_after, *contact.rates_after])
        for contact in run.contacts
    ]
    return [*samples, *energies, np.array([event.time for event in run.events]), *contacts]


def _scripts() -> tuple[HardCase, ...]:
    """What the scripts run."""
    few = Settings(maximum_steps=100)
    studies: dict[str, Callable[[], Report]] = {
        "cue_and_impact": lambda: whole_pass(TOOL, few),
        "cue_timing": lambda: cue_timing(TOOL, RETRACTION_AT_RELEASE, few),
    }
    words = (SPENT, "accuracy =", "step =")
    return tuple(
        HardCase(THEME, f"{name}.py, 100 steps", "refused in one clear line", partial(refusal, study, *words))
        for name, study in studies.items()
    )
