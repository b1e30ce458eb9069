"""Measures of a whole run that cases of several themes share: compared with the reference, with a closed form, and a spent budget."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, TypedDict

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, all_of, within, worst
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.repetitions import CLOSE
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.theory.cueing import stiffened_cue
from bristle_sim.trajectory import ContactRecord, Trajectory

__all__ = [
    "ACCURACY",
    "ONE_INTERVAL",
    "Start",
    "agrees_with_energy_integral",
    "agrees_with_reference",
    "end_difference",
    "impacts_of",
    "is_finite",
    "spends_budget",
    "sustained_contacts_of",
]

ACCURACY = Settings().accuracy
"""Requested accuracy where a case says nothing else; a result must be right to it, relative to the motion's size."""

MORE_ACCURATE = 1e-3
"""Accuracy of the reference over that of the run which is compared with it."""

ONE_INTERVAL = 100 * sum(CLOSE.counts)
"""Most engine steps of one interval of smooth motion that ends at an event: a hundred attempts to locate it."""

IMPACT_LAWS = ("energetic", "compliant", "engine")


class Start(TypedDict, total=False):
    """Start of a run, in rad and rad/s; what is absent is as by default."""

    start_hub_angle: float
    start_relative_angle: float
    start_relative_rate: float


def impacts_of(run: Trajectory, obstacle: str | None = None) -> list[ContactRecord]:
    """Return the impacts of a run, on one obstacle or on both."""
    return [each for each in run.contacts if each.law in IMPACT_LAWS and obstacle in (None, each.obstacle)]


def sustained_contacts_of(run: Trajectory, obstacle: str) -> list[ContactRecord]:
    """Return the sustained contacts of a run with an obstacle."""
    return [each for each in run.contacts if each.law not in IMPACT_LAWS and each.obstacle == obstacle]


def is_finite(run: Trajectory) -> bool:
    """Return whether every number of a run's samples, events and contacts is finite."""
    samples = [run.time, run.hub_angle, run.angles, run.rates, run.tip, run.total_energy, run.normal_force]
    contacts = [
        np.array([each.time, each.duration, *each.impulse, *each.velocity_after, *each.rates_after])
        for each in run.contacts
    ]
    events = np.array([event.time for event in run.events])
    return all(bool(np.isfinite(each).all()) for each in (*samples, *contacts, events))


def agrees_with_reference(
    tool: Tool,
    limit: float = ACCURACY,
    *,
    start: Start | None = None,
    stop_after: str | None = None,
    may_lose_grip: bool = False,
) -> Finding:
    """Compare a run of an accuracy equal to the limit with the reference: why it ends, its last state and its first strike.

    A run that may lose its grip on the bar is compared up to there.
    """
    given: dict[str, Any] = {**(start or {}), "stop_after": stop_after}
    run = simulate(tool, Settings(accuracy=max(limit, 1e-11)), **given)
    lost = may_lose_grip and run.stop_reason is StopReason.NO_GRIP
    upto: dict[str, Any] = {"duration": float(run.time[-1])} if lost else {}
    other = simulate_reference(tool, accuracy=max(MORE_ACCURATE * limit, 1e-12), **given, **upto)
    off = worst([*end_difference(run, other), *([] if lost else strike_difference(run, other))])
    alike = lost or run.stop_reason is other.stop_reason
    return all_of(Finding(run.stop_reason, alike), within(off, limit, "off by", run.cost.steps))


def end_difference(run: Trajectory, other: Trajectory) -> list[float]:
    """Return differences of time (relative), angle (rad) and rate (relative to the highest) at the end of two runs."""
    fastest = float(np.abs(other.rates).max()) or 1.0
    return [
        float(run.time[-1] / other.time[-1] - 1.0),
        float(run.relative_angle[-1] - other.relative_angle[-1]),
        float(run.relative_rate[-1] - other.relative_rate[-1]) / fastest,
    ]


def strike_difference(run: Trajectory, other: Trajectory) -> list[float]:
    """Return differences of time, angle, rates and impulse of the first strike; NaN where only one of the runs has one."""
    one, two = run.first_contact("workpart"), other.first_contact("workpart")
    if one is None or two is None:
        return [] if one is two else [math.nan]
    fastest = max(map(abs, (*two.rates_before, *two.rates_after)))
    size = abs(two.impulse[0]) or 1.0
    return [
        (one.time - two.time) / float(other.time[-1]),
        one.angles[0] - two.angles[0],
        (one.rates_before[0] - two.rates_before[0]) / fastest,
        (one.rates_after[0] - two.rates_after[0]) / fastest,
        *((a - b) / size for a, b in zip(one.impulse, two.impulse, strict=True)),
    ]


def agrees_with_energy_integral(tool: Tool, accuracy: float) -> Finding:
    """Compare highest speed and its time of an undamped bristle released from rest with the energy integral's."""
    run = simulate(
        tool,
        Settings(accuracy=accuracy),
        start_relative_angle=-RETRACTION_AT_RELEASE,
        stop_after="highest relative speed",
    )
    expected = stiffened_cue(replace(Tool(), hub=tool.hub, belt=tool.belt, bristle=tool.bristle))
    late = float(run.time[-1]) / expected.cue_time - 1.0
    fast = float(run.relative_rate[-1]) / expected.highest_relative_speed - 1.0
    return within(worst([late, fast]), accuracy, "off by", run.cost.steps)


def spends_budget(
    tool: Tool, budget: int, beyond: int = ONE_INTERVAL, *, settings: Settings | None = None, start: Start | None = None
) -> Finding:
    """Return whether a run that needs more steps than its budget says so, within an interval of it, with finite numbers only."""
    run = simulate(tool, replace(settings or Settings(), maximum_steps=budget), **(start or {}))
    excess = run.cost.steps - budget
    said = run.stop_reason is StopReason.STEP_BUDGET
    told = f"{excess} beyond" + ("" if said else f", {run.stop_reason}") + ("" if is_finite(run) else ", not finite")
    return Finding(told, said and 0 <= excess <= beyond and is_finite(run), run.cost.steps)
