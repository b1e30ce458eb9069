"""A hard case, the result of its trial, and the comparison of a simulation with the reference."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from bristle_sim.parameters import RETRACTION_AT_RELEASE, Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory


@dataclass(frozen=True, slots=True)
class Finding:
    """The result of one trial.

    Attributes:
        reached: the result in words, the same in every run.
        ok: whether the result satisfies the condition (the promise) of the case.
        steps: number of engine steps.
    """

    reached: str
    ok: bool
    steps: int = 0


@dataclass(frozen=True, slots=True)
class HardCase:
    """A difficult simulation with the condition that its result must satisfy, the promise.

    Attributes:
        name: name of the case, with the numbers that make it hard.
        promise: the condition in words, with its tolerance and the reason for the tolerance.
        measure: function that runs the simulation and checks the condition.
    """

    name: str
    promise: str
    measure: Callable[[], Finding]

    def run(self) -> Finding:
        """Run the case and return its result; an exception counts as a broken promise."""
        try:
            return self.measure()
        except Exception as error:
            return Finding(f"{type(error).__name__}: {' '.join(str(error).split())}", False)


def hard_case(
    name: str, promise: str, measure: Callable[..., Finding], *given: Any, **named: Any
) -> HardCase:
    """Return a hard case that calls ``measure`` with the arguments ``given`` and ``named``."""
    return HardCase(name, promise, partial(measure, *given, **named))


def within(value: float, limit: float, figure: str, steps: int = 0) -> Finding:
    """Return a finding that is ok if ``abs(value) <= limit``; a NaN is not ok.

    ``figure`` names the value in the finding's text, and ``steps`` is the number of engine steps.
    """
    return Finding(f"{figure} {value:.2g}", abs(value) <= limit, steps)


def all_of(*findings: Finding) -> Finding:
    """Combine several findings into one finding, which is ok if every one of them is ok."""
    words = "; ".join(each.reached for each in findings)
    return Finding(words, all(each.ok for each in findings), sum(each.steps for each in findings))


def worst(values: Iterable[float]) -> float:
    """Return the largest magnitude of the values.

    It is 0 if there are no values, and NaN if a value is NaN.
    """
    return float(np.max(np.abs([0.0, *values])))


ACCURACY = Settings().accuracy
"""Default requested accuracy: largest permitted error, relative to the size of the motion."""

MORE_ACCURATE = 1e-3
"""Ratio of the reference's requested accuracy to that of the compared run."""

AS_REFERENCE = "last state and strike as in the reference, to {:g}, the requested accuracy"
"""Promise of a case that is compared with the reference; the number is the tolerance."""

IMPACT_LAWS = ("energetic", "compliant", "engine")
"""Laws of contact records that are impacts; all other records are sustained contacts."""


Start = dict[str, Any]
"""Angles (rad) and relative angular velocity (rad/s) at the start of a run, by name.

An absent entry takes the default of the simulation."""

RELEASED: Start = {"start_relative_angle": -RETRACTION_AT_RELEASE}
"""State at the start of a bristle that is released at rest relative to the hub."""


def impacts_of(run: Trajectory, obstacle: str) -> list[ContactRecord]:
    """Return the impacts on an obstacle in a run, in order of time."""
    return [each for each in run.contacts if each.law in IMPACT_LAWS and each.obstacle == obstacle]


def agrees_with_reference(
    tool: Tool,
    limit: float = ACCURACY,
    *,
    start: Start | None = None,
    stop_after: str | None = None,
    hub_turn: float = 1.5 * math.pi,
) -> Finding:
    """Check that a simulation agrees with the reference solution.

    The stop reasons must be equal. The last states and the first strikes must agree within
    ``limit``, which is also the accuracy requested of the simulation. Both runs begin with the
    state ``start``. They end after the event ``stop_after``, or when the hub has turned by
    ``hub_turn``, rad.
    """
    # Imported here, so that themes without a reference do not load its integrator.
    from bristle_sim.reference import simulate_reference

    given = {**(start or {}), "stop_after": stop_after}
    run = simulate(tool, Settings(limit, maximum_steps=1_000_000, hub_turn=hub_turn), **given)
    other = simulate_reference(tool, accuracy=MORE_ACCURATE * limit, hub_turn=hub_turn, **given)
    fastest = float(np.abs(other.rates).max()) or 1.0
    off = [
        float(run.time[-1] / other.time[-1] - 1.0),
        float(run.relative_angle[-1] - other.relative_angle[-1]),
        float(run.relative_rate[-1] - other.relative_rate[-1]) / fastest,
        *_strike_difference(run, other),
    ]
    alike = Finding(run.stop_reason, run.stop_reason is other.stop_reason)
    return all_of(alike, within(worst(off), limit, "off by", run.cost.steps))


def _strike_difference(run: Trajectory, other: Trajectory) -> list[float]:
    """Return the differences between the first strikes of two runs.

    The differences are those of time, angle (rad), angular velocities before and after, and
    impulse. All except that of the angle are divided by a magnitude from ``other``. The list holds
    NaN if only one run has a strike. It is empty if neither run has one.
    """
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
