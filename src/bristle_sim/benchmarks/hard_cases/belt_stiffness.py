"""Belts from a thousandth to a million times the default's stiffness, and fixed steps that are too long for them.

The motion that a stiff belt makes is as smooth as a soft one's in its own time; only a pass, whose length the hub sets,
takes ever more of it.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, refusal, within, worst
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Belt, Hub, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.theory.cueing import centrifugal_stiffness, stiffened_cue
from bristle_sim.trajectory import Trajectory

__all__ = ["beside_reference", "budget_spent", "cases", "end_difference", "release_beside_closed_form"]

THEME = "belt_stiffness"

DEFAULT = Belt().stiffness

LIMIT = 1e-6
"""The accuracy asked for."""

FINE = 1e-9
"""The same where the release flight is asked for a thousand times more."""

BUDGET = 20_000
"""Engine steps of a run that is to spend them."""

FACTORS = (1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6)

LONG = (2.5, 100.0, 1e5)
"""Fixed steps in radians of the fastest motion: past 2 the engine's springs are unstable."""

SHARES = (0.999, 0.25)
"""Of the longest fixed step allowed."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Release, whole pass and fixed steps, over nine decades of stiffness."""
    flights = FACTORS if full else (1e-3, 1.0, 1e6)
    passes = FACTORS[:7] if full else (1e-3, 10.0)
    fixed = (1e-3, 1.0, 1e6)
    return (
        *(_release(factor, accuracy) for factor in flights for accuracy in (LIMIT, FINE)),
        *(_whole_pass(factor) for factor in passes),
        *((_up_to_strike(1e4), _as_far_as_held(1e5), _as_far_as_held(1e6)) if full else ()),
        HardCase(THEME, "belt x 1e6: whole pass", "says that its step budget is spent", partial(_spends, 1e6)),
        *(_too_long(factor, step) for factor in fixed for step in LONG),
        *(_long(factor, share) for factor in fixed for share in (SHARES if full else SHARES[:1])),
    )


def _belt(tool: Tool, factor: float) -> Tool:
    return replace(tool, belt=Belt(stiffness=DEFAULT * factor))


def _free(factor: float, hub: Hub | None = None) -> Tool:
    return _belt(Tool(hub=hub or Hub(), bar=None, workpart=None), factor)


def _release(factor: float, accuracy: float) -> HardCase:
    promise = f"highest speed and its time as in closed form to {accuracy:g}, as asked"
    measure = partial(release_beside_closed_form, _free(factor), accuracy)
    return HardCase(THEME, f"belt x {factor:g}: released, accuracy {accuracy:g}", promise, measure)


def _whole_pass(factor: float) -> HardCase:
    promise = f"strike and end as in the reference to {LIMIT:g}, as asked"
    return HardCase(
        THEME, f"belt x {factor:g}: whole pass", promise, partial(beside_reference, _belt(Tool(), factor), LIMIT)
    )


def _up_to_strike(factor: float) -> HardCase:
    promise = f"the strike as in the reference to {LIMIT:g}, as asked"
    measure = partial(beside_reference, _belt(Tool(), factor), LIMIT, stop_after="strike")
    return HardCase(THEME, f"belt x {factor:g}: pass up to the strike", promise, measure)


def _as_far_as_held(factor: float) -> HardCase:
    promise = f"as in the reference to {LIMIT:g} up to where it ends, and a word why it ends"
    return HardCase(THEME, f"belt x {factor:g}: pass up to the strike", promise, partial(_as_far_as_it_goes, factor))


def release_beside_closed_form(tool: Tool, accuracy: float) -> Finding:
    """Highest speed of the undamped bristle released from rest, and its time, beside the energy integral's."""
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


def beside_reference(
    tool: Tool, limit: float, stop_after: str | None = None, maximum_steps: int = 1_000_000
) -> Finding:
    """A pass asked for an accuracy equal to the limit, beside the reference: why and in which state it ends, its strike."""
    settings = Settings(accuracy=max(limit, 1e-11), maximum_steps=maximum_steps)
    run = simulate(tool, settings, stop_after=stop_after)
    other = simulate_reference(tool, accuracy=max(1e-3 * limit, 1e-12), stop_after=stop_after)
    alike = run.stop_reason is other.stop_reason
    off = worst([*end_difference(run, other), *_strike_difference(run, other)])
    return both(Finding(run.stop_reason, alike), within(off, limit, "off by", run.cost.steps))


def end_difference(run: Trajectory, other: Trajectory) -> list[float]:
    """Time, angle and rate at the end of two runs, relative, in rad, and relative to the highest rate."""
    fastest = float(np.abs(other.rates).max()) or 1.0
    return [
        float(run.time[-1] / other.time[-1] - 1.0),
        float(run.relative_angle[-1] - other.relative_angle[-1]),
        float(run.relative_rate[-1] - other.relative_rate[-1]) / fastest,
    ]


def _strike_difference(run: Trajectory, other: Trajectory) -> list[float]:
    """Time, angle, rates and impulse of the first strike; NaN where only one of the runs has one."""
    one, two = run.first_contact("workpart"), other.first_contact("workpart")
    if one is None or two is None:
        return [] if one is two else [math.nan]
    fastest = max(map(abs, (*two.rates_before, *two.rates_after)))
    return [
        one.time / two.time - 1.0,
        one.angles[0] - two.angles[0],
        (one.rates_before[0] - two.rates_before[0]) / fastest,
        (one.rates_after[0] - two.rates_after[0]) / fastest,
        *((a - b) / two.impulse[0] for a, b in zip(one.impulse, two.impulse, strict=True)),
    ]


def _as_far_as_it_goes(factor: float) -> Finding:
    """A run that may end before the strike, beside a reference of the same length."""
    tool = _belt(Tool(), factor)
    run = simulate(tool, stop_after="strike")
    if run.stop_reason is StopReason.EVENT:
        return beside_reference(tool, LIMIT, stop_after="strike")
    other = simulate_reference(tool, duration=float(run.time[-1]))
    told = Finding(run.stop_reason, run.stop_reason is StopReason.NO_GRIP)
    return both(told, within(worst(end_difference(run, other)), LIMIT, "off by", run.cost.steps))


def _spends(factor: float) -> Finding:
    return budget_spent(_belt(Tool(), factor), BUDGET)


def budget_spent(tool: Tool, budget: int, **start: Any) -> Finding:
    """A pass that takes more than its budget ends within a stretch of it, says so, and holds nothing but numbers."""
    run = simulate(tool, Settings(maximum_steps=budget), **start)
    finite = all(np.isfinite(each).all() for each in (run.time, run.angles, run.rates, run.tip, run.total_energy))
    told = Finding(run.stop_reason, run.stop_reason == "step budget spent" and finite)
    # One event is located in at most a hundred runs over a stretch of at most 144 steps.
    kept = Finding(f"{run.cost.steps} steps", run.cost.steps <= budget + 14_400, run.cost.steps)
    return both(told, kept)


def _fastest(factor: float, hub: Hub) -> float:
    """Of belt and hub, from the equation of motion, rad/s."""
    tool = _free(factor, hub)
    bristle = tool.bristle
    g = centrifugal_stiffness(bristle.mass, hub.radius, bristle.length, hub.speed)
    return max(math.sqrt((tool.belt.stiffness + g) / bristle.inertia_about_root), hub.speed)


def _too_long(factor: float, radians: float) -> HardCase:
    name = f"belt x {factor:g}: fixed step of {radians:g} rad"
    return HardCase(THEME, name, "refused: the step, and what is allowed", partial(_refused, factor, radians))


def _refused(factor: float, radians: float) -> Finding:
    step = radians / _fastest(factor, Hub())
    return refusal(lambda: simulate(_belt(Tool(), factor), Settings(step=step)), "step =", "in s")


def _long(factor: float, share: float) -> HardCase:
    name = f"belt x {factor:g}: {share:g} of the longest step"
    promise = "energy never above 1/(1 - w dt/2) of its start; period right to (w dt)^2; highest speed within 2 dt"
    return HardCase(THEME, name, promise, partial(_first_order, factor, share))


def _first_order(factor: float, share: float) -> Finding:
    return both(*_at_rest(factor, share), _turning(factor, share))


def _at_rest(factor: float, share: float) -> tuple[Finding, Finding]:
    """Energy and period of the belt's oscillation on a hub at rest, with fixed steps.

    From x_(n+1) = x_n + h v_n, v_(n+1) = v_n - w^2 h x_(n+1) follows that v^2 + w^2 x^2 + w^2 h x v stays, hence the bound.
    """
    rate = _fastest(factor, Hub(speed=0.0))
    radians = share * 2.0 * math.pi / Settings().samples_per_period
    run = _released(_free(factor, Hub(speed=0.0)), radians / rate)
    energy = run.relative_angle**2 + (run.relative_rate / rate) ** 2
    top = float(energy.max() / energy[0]) * (1.0 - 0.5 * radians)
    late = _period(run) * rate / (2.0 * math.pi) - 1.0
    return (
        within(top, 1.0 + LIMIT, f"w dt {radians:.2g}: energy over its bound", run.cost.steps),
        within(late, radians**2, "period off by"),
    )


def _turning(factor: float, share: float) -> Finding:
    """Time of the highest speed on the turning hub, off by how many steps."""
    tool = _free(factor)
    step = share * 2.0 * math.pi / Settings().samples_per_period / _fastest(factor, tool.hub)
    run = _released(tool, step, "highest relative speed")
    late = (float(run.time[-1]) - stiffened_cue(_belt(Tool(), factor)).cue_time) / step
    return within(late, 2.0, "steps off", run.cost.steps)


def _released(tool: Tool, step: float, stop_after: str | None = None) -> Trajectory:
    return simulate(tool, Settings(step=step), start_relative_angle=-RETRACTION_AT_RELEASE, stop_after=stop_after)


def _period(run: Trajectory) -> float:
    """From the first to the last crossing of the radial direction, each on the straight line between two samples."""
    angle: NDArray[np.float64] = run.relative_angle
    before = np.nonzero(angle[1:] * angle[:-1] < 0.0)[0]
    slope = (angle[before + 1] - angle[before]) / (run.time[before + 1] - run.time[before])
    at = run.time[before] - angle[before] / slope
    return float(2.0 * (at[-1] - at[0]) / (len(at) - 1))
