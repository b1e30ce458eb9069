"""Tools of every size: lengths, masses and times scaled, and the same dimensionless motion expected.

With lengths times l, masses times m and times times t, a speed of rotation goes as 1/t, a belt's stiffness as m l^2/t^2 and
gravity as l/t^2. Scaled by powers of two nothing is rounded, so that not a bit may differ; otherwise rounding may tip the
choice of a step, which changes the result by its error.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, within, worst
from bristle_sim.benchmarks.hard_cases.measures import Start, impacts_of
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Bristle, Contact, Tool
from bristle_sim.scene.tool import simulate
from bristle_sim.scene.units import Units
from bristle_sim.settings import Settings
from bristle_sim.trajectory import Trajectory

LIMIT = 1e-9
"""Limit of relative differences after scaling: ten times the requested accuracy."""

SETTINGS = Settings(accuracy=1e-10)
"""So accurate that the choice of a step does not show."""

SLOW = 1e-2
"""Impacts slower than this part of the fastest are the last of ever smaller taps, the sum of many errors."""

UNITY = Units(1.0, 1.0, 1.0)

POWERS = {"0.82 um, 1.2e-12 kg": Units(2.0**-15, 2.0**-26, 2.0**-8), "14 m, 1.4e3 kg": Units(2.0**9, 2.0**24, 2.0**5)}

TOOL = Tool(gravity=3e3)
"""A tool with gravity nearly as strong as the tip's centrifugal acceleration, so that it shows."""

MOTIONS: dict[str, tuple[Tool, Start, str | None]] = {
    "whole pass": (TOOL, {}, None),
    "whole pass, in time": (replace(TOOL, contact=Contact("compliant")), {}, None),
    "whole pass, engine's contact": (replace(TOOL, contact=Contact("engine")), {}, None),
    "flight": (replace(TOOL, bar=None, workpart=None), {"start_relative_angle": -RETRACTION_AT_RELEASE}, None),
    "strike in time": (replace(TOOL, contact=Contact("compliant", duration=1e-5)), {}, "strike"),
}
"""Tool, start and the event that ends the run."""


SIZES = {
    "1 um, 1e-12 kg": (1e-6, 1e-12, 1e-3),
    "10 m, 1e3 kg": (10.0, 1e3, 30.0),
    "1 um, 1e3 kg": (1e-6, 1e3, 1e3),
    "10 m, 1e-12 kg": (10.0, 1e-12, 30.0),
    "1 nm, 1e-30 kg": (1e-9, 1e-30, 1e-3),
    "500 m, 9e5 kg": (500.0, 9e5, 1e4),
}
"""Length in m and mass in kg of a bristle, and a factor of time that keeps belt, hub and gravity within their ranges."""


def size() -> list[HardCase]:
    """Return passes, flights and strikes: equal to the last bit for powers of two, to rounding for any other size."""
    exact = [
        HardCase(
            "size", f"{name}: {motion}", "the default's to the last bit", partial(_same, motion, scale, 0.0), quick
        )
        for (name, scale), quick in zip(POWERS.items(), (True, False), strict=True)
        for motion in ("whole pass", "whole pass, in time", "whole pass, engine's contact")
    ]
    promise = f"the default's after scaling to {LIMIT:g}, ten times the requested accuracy"
    rounded = [
        HardCase("size", f"{name}: {motion}", promise, partial(_same, motion, scale, LIMIT), number < 2)
        for number, (name, (length, mass, time)) in enumerate(SIZES.items())
        for scale in [Units(length / Bristle().length, mass / Bristle().mass, time)]
        for motion in ("whole pass", "flight", "strike in time")
    ]
    return [*exact, *rounded]


def _same(motion: str, scale: Units, limit: float) -> Finding:
    """Compare a run of the scaled tool with one of the default, each in its own units."""
    tool, start, stop_after = MOTIONS[motion]
    settings = SETTINGS if limit else Settings()
    runs = [simulate(scaled(tool, each), settings, stop_after=stop_after, **start) for each in (scale, UNITY)]
    one, two = (dimensionless(run, each) for run, each in zip(runs, (scale, UNITY), strict=True))
    return within(_difference(one, two), limit, "off by", runs[0].cost.steps)


def scaled(tool: Tool, scale: Units) -> Tool:
    """Return the similar tool, its lengths, masses and times multiplied."""

    def times(part: Any, **factors: float) -> Any:
        values = {name: getattr(part, name) for name in factors}
        return replace(part, **{name: value and value * factors[name] for name, value in values.items()})

    length, time = scale.length, scale.time
    return Tool(
        hub=times(tool.hub, speed=1.0 / time, radius=length),
        belt=times(tool.belt, stiffness=scale.energy),
        bristle=times(tool.bristle, length=length, mass=scale.mass, wire_diameter=length),
        bar=tool.bar and times(tool.bar, radius=length, horizontal=length, vertical=length),
        workpart=tool.workpart and times(tool.workpart, penetration=length),
        contact=times(tool.contact, duration=time),
        gravity=tool.gravity * scale.acceleration,
    )


def dimensionless(run: Trajectory, scale: Units) -> dict[str, Any]:
    """Return outcomes, impacts but for the last of ever smaller taps, and the end of a run, in units of its scale."""
    every = impacts_of(run)
    fastest = max((-each.velocity_before[0] for each in every), default=0.0)
    hits = [each for each in every if -each.velocity_before[0] > SLOW * fastest]
    rates = [rate for each in hits for rate in (*each.rates_before, *each.rates_after)]
    works = [part for each in hits for part in each.compressive_work or ()]
    return {
        "words": [run.stop_reason, *((each.obstacle, each.outcome, each.phases) for each in hits)],
        "times": np.array([each.time for each in hits] + [run.time[-1]]) / scale.time,
        "durations": np.array([each.duration for each in hits]) / scale.time,
        "angles": np.array([each.angles[0] for each in hits] + [run.angles[-1, 0]]),
        "rates": np.array([*rates, run.rates[-1, 0]]) * scale.time,
        "tip": run.tip[-1] / scale.length,
        "impulses": np.array([part for each in hits for part in each.impulse]) / scale.impulse,
        "works": np.array(works) / scale.energy,
        "energies": np.array([run.kinetic_energy[-1], run.potential_energy[-1]]) / scale.energy,
    }


def _difference(one: dict[str, Any], two: dict[str, Any]) -> float:
    """Return the largest difference over the largest number of its kind; NaN where words or numbers of numbers differ."""
    kinds = [kind for kind in two if kind != "words" and two[kind].size]
    if one["words"] != two["words"] or any(one[kind].shape != two[kind].shape for kind in kinds):
        return math.nan
    return worst(np.abs(one[kind] - two[kind]).max() / (np.abs(two[kind]).max() or 1.0) for kind in kinds)
