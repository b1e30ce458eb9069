"""Hubs at rest, creeping, and at 1e5 rad/s, where the centrifugal field does what the belt did."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.special import ellipj

from bristle_sim.benchmarks.hard_cases.belt_stiffness import beside_reference, budget_spent, release_beside_closed_form
from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, refusal, within, worst
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Belt, Hub, Tool
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings

__all__ = ["cases"]

THEME = "hub_speed"

LIMIT = 1e-6
"""The accuracy asked for."""

FINE = 1e-9
"""The same where it is asked for a thousand times more."""

SPEEDS = (0.0, 1e-3, 1.0, 100.0, 1e3, 1e4, 1e5)

FAST = 1e5

DEFAULT = Hub().speed

BUDGET = 20_000
"""Engine steps of a run that is to spend them."""

RIGID = Belt(stiffness=0.0)
"""No belt: only the field turns the bristle."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Release, whole pass, at rest, in the field alone, and speeds that are not allowed."""
    releases = SPEEDS if full else (0.0, 1e-3, 1e5)
    passes = SPEEDS[3:] if full else (1e3, 1e5)
    return (
        HardCase(
            THEME,
            "at rest: three periods",
            f"period 2 pi sqrt(I/k) and energy kept, both to {FINE:g}, as asked",
            _at_rest,
        ),
        HardCase(THEME, "at rest: whole pass", f"stays where it is to {LIMIT:g}; bar and workpart not met", _stays),
        *(_released(speed, accuracy) for speed in releases for accuracy in (LIMIT, FINE)),
        *(_whole_pass(speed, Belt()) for speed in passes),
        *(_whole_pass(speed, RIGID) for speed in ((1e-3, 1.0, 1e3, 1e5) if full else (1e-3, 1e5))),
        *(_creeps(*each) for each in ((1e-3, Belt()), (1e-300, Belt()), (1e-300, RIGID))),
        *(_field(speed) for speed in ((1e-3, 1.0, 1e3, 1e5) if full else (1e-3, 1e5))),
        *(_same_pass(speed) for speed in ((1e-3, 1.0, 1e5) if full else (1e5,))),
        *(_not_allowed(speed) for speed in (-1.0, -5e-324, 1.001e6, math.nan, math.inf)),
    )


def _turning(speed: float, belt: Belt | None = None) -> Tool:
    return Tool(hub=Hub(speed=speed), belt=belt or Belt())


def _free(speed: float, belt: Belt | None = None) -> Tool:
    return replace(_turning(speed, belt), bar=None, workpart=None)


def _at_rest() -> Finding:
    """The belt's oscillation is harmonic for every amplitude."""
    tool = _free(0.0)
    run = simulate(tool, Settings(accuracy=FINE), start_relative_angle=-RETRACTION_AT_RELEASE)
    times = [event.time for event in run.events if event.name == "highest relative speed"]
    period = 2.0 * math.pi * math.sqrt(tool.bristle.inertia_about_root / tool.belt.stiffness)
    late = (times[-1] - times[0]) / ((len(times) - 1) * period) - 1.0
    drift = float(np.ptp(run.total_energy)) / float(run.total_energy[0])
    return both(within(late, FINE, "period off by", run.cost.steps), within(drift, FINE, "energy by"))


def _stays() -> Finding:
    run = simulate(_turning(0.0))
    tool = _turning(0.0)
    rate = math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)
    moved = worst([float(np.abs(run.relative_angle).max()), float(np.abs(run.relative_rate).max()) / rate])
    names = [event.name for event in run.events]
    told = Finding(", ".join(names), names == ["bar not touched", "workpart not reached"] and not run.contacts)
    return both(within(moved, LIMIT, "moved by", run.cost.steps), told)


def _released(speed: float, accuracy: float) -> HardCase:
    promise = f"highest speed and its time as in closed form to {accuracy:g}, as asked"
    measure = partial(release_beside_closed_form, _free(speed), accuracy)
    return HardCase(THEME, f"{speed:g} rad/s: released, accuracy {accuracy:g}", promise, measure)


def _whole_pass(speed: float, belt: Belt) -> HardCase:
    name = f"{speed:g} rad/s: whole pass{'' if belt.stiffness else ', no belt'}"
    promise = f"strike and end as in the reference to {LIMIT:g}, as asked"
    return HardCase(THEME, name, promise, partial(beside_reference, _turning(speed, belt), LIMIT))


def _creeps(speed: float, belt: Belt) -> HardCase:
    name = f"{speed:g} rad/s: whole pass{'' if belt.stiffness else ', no belt'}"
    measure = partial(budget_spent, _turning(speed, belt), BUDGET)
    return HardCase(THEME, name, "says that its step budget is spent", measure)


def _field(speed: float) -> HardCase:
    name = f"{speed:g} rad/s: released, no belt"
    promise = f"angle and rate as a pendulum's in the field to {FINE:g}, as asked"
    return HardCase(THEME, name, promise, partial(_pendulum, speed))


def _pendulum(speed: float) -> Finding:
    """Without a belt alpha'' = -W^2 sin alpha, W^2 = (m r_h L/2/I) w^2, beside Jacobi's elliptic functions.

    Released from rest, sin(alpha/2) = k cd(W t), alpha' = -2 k W k' sn(W t)/dn(W t) with k the sine of half the start.
    """
    tool = _free(speed, RIGID)
    run = simulate(tool, Settings(accuracy=FINE), start_relative_angle=-RETRACTION_AT_RELEASE)
    # m r_h (L/2) over m L^2/3.
    rate = math.sqrt(1.5 * tool.hub.radius / tool.bristle.length) * speed
    k = math.sin(-0.5 * RETRACTION_AT_RELEASE)
    sn, cn, dn, _ = ellipj(rate * run.time, k * k)
    angle = 2.0 * np.arcsin(k * cn / dn)
    speeds = -2.0 * k * math.sqrt(1.0 - k * k) * sn / dn
    return both(
        within(float(np.abs(run.relative_angle - angle).max()), FINE, "angle off by", run.cost.steps),
        within(float(np.abs(run.relative_rate / rate - speeds).max()), FINE, "rate by"),
    )


def _same_pass(speed: float) -> HardCase:
    name = f"{speed:g} rad/s: belt as stiff to it"
    promise = f"the pass of the default in its own time, to {LIMIT:g}, as asked"
    return HardCase(THEME, name, promise, partial(_similar, speed))


def _similar(speed: float) -> Finding:
    """With the stiffness as the square of the speed nothing but the time scale changes."""
    ratio = speed / DEFAULT
    run = simulate(_turning(speed, Belt(stiffness=Belt().stiffness * ratio**2)))
    other = simulate(Tool())
    one, two = run.first_contact("workpart"), other.first_contact("workpart")
    if one is None or two is None or run.stop_reason != other.stop_reason:
        return Finding(f"ends by {run.stop_reason}", False, run.cost.steps)
    fastest = float(np.abs(other.rates).max())
    off = [
        one.time * ratio / two.time - 1.0,
        one.angles[0] - two.angles[0],
        (one.rates_after[0] / ratio - two.rates_after[0]) / fastest,
        one.impulse[0] / ratio / two.impulse[0] - 1.0,
        float(run.relative_angle[-1] - other.relative_angle[-1]),
        float(run.relative_rate[-1] / ratio - other.relative_rate[-1]) / fastest,
    ]
    return within(worst(off), LIMIT, "off by", run.cost.steps)


def _not_allowed(speed: float) -> HardCase:
    promise = "refused: hub_speed, value and range"
    return HardCase(THEME, f"{speed:g} rad/s", promise, partial(_refused, speed))


def _refused(speed: float) -> Finding:
    return refusal(lambda: Hub(speed=speed), f"hub_speed = {speed!r}", "must be", "0 <= hub_speed <= ", "in rad/s")
