"""Belt damping ratios from none to a hundred, and to where the motion is too stiff to be followed.

The decay of the bristle released on a hub whose axis carries its root is the damped oscillator's, whatever the speed.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from bristle_sim.benchmarks.hard_cases.belt_stiffness import beside_reference, budget_spent
from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, refusal, within, worst
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Belt, Hub, Tool
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import Trajectory

__all__ = ["cases", "decay"]

THEME = "damping"

Array = NDArray[np.float64]

LIMIT = 1e-6
"""The accuracy asked for."""

FINE = 1e-8
"""The same where it is asked for a hundred times more; with a damping ratio of 10 rounding adds up to a tenth of it."""

SHARES = (0.999, 0.25, 0.0625)
"""Of the longest fixed step allowed."""

START = -RETRACTION_AT_RELEASE

RATIOS = (0.0, 1e-9, 1e-3, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 10.0, 100.0)

BUDGET = 20_000
"""Engine steps of a run that is to spend them."""

HIGHEST = 1e3
"""Damping ratio allowed."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Decay beside its closed form, order, whole pass, fixed steps that are too long, and refusals."""
    passes = RATIOS[1:] if full else (0.5, 10.0)
    return (
        *(_decays(ratio, LIMIT, full) for ratio in RATIOS),
        *(_decays(ratio, FINE, full) for ratio in (RATIOS[1:-1] if full else (1.0,))),
        *(_whole_pass(ratio) for ratio in passes),
        HardCase(THEME, f"ratio {HIGHEST:g}: whole pass", "says that its step budget is spent", _spends),
        *(_too_long(ratio) for ratio in (0.5, 10.0, 100.0)),
        *(
            _first_order(ratio, share)
            for ratio in (0.5, 1.0, 10.0, 100.0)
            for share in (SHARES if full else SHARES[:1])
        ),
        *(_not_allowed(ratio) for ratio in (-1e-9, 1.001 * HIGHEST, math.nan, math.inf)),
    )


def decay(ratio: float, phase: Array) -> tuple[Array, Array]:
    """Angle over its start and rate over start times natural rate, released from rest, over natural rate times time.

    With s = sqrt(zeta^2 - 1), e^(-zeta p) (cosh(s p) + zeta sinh(s p)/s) and -e^(-zeta p) sinh(s p)/s. Its two exponents are
    written without the difference -zeta + s, which would lose the slow one's digits.
    """
    square = (ratio - 1.0) * (ratio + 1.0)
    root = math.sqrt(abs(square))
    if root * float(np.max(phase, initial=0.0)) < 1e-2:
        small = square * phase**2
        # Series of cosh and sinh/s: the next terms are (s p)^6/720 of them, 1e-15.
        even, odd = 1.0 + small / 2.0 + small**2 / 24.0, phase * (1.0 + small / 6.0 + small**2 / 120.0)
        fading = np.exp(-ratio * phase)
    elif square < 0.0:
        even, odd, fading = np.cos(root * phase), np.sin(root * phase) / root, np.exp(-ratio * phase)
    else:
        slow, fast = np.exp(-phase / (ratio + root)), np.exp(-phase * (ratio + root))
        even, odd, fading = 0.5 * (slow + fast), 0.5 * (slow - fast) / root, np.ones_like(phase)
    return fading * (even + ratio * odd), -fading * odd


def _tool(ratio: float, hub: Hub | None = None) -> Tool:
    return Tool(hub=hub or Hub(radius=0.0), belt=Belt(damping_ratio=ratio), bar=None, workpart=None)


def _natural_rate(tool: Tool) -> float:
    return math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)


def _errors(tool: Tool, run: Trajectory) -> tuple[float, float]:
    """Largest errors of angle and rate, over the start and the start times the natural rate."""
    rate = _natural_rate(tool)
    angle, speed = decay(tool.belt.damping_ratio, rate * run.time)
    off = np.abs(run.relative_angle / START - angle).max(), np.abs(run.relative_rate / (START * rate) - speed).max()
    return float(off[0]), float(off[1])


def _rise(tool: Tool, run: Trajectory) -> float:
    """Largest rise of belt and relative kinetic energy from sample to sample, over what there was at the start."""
    energy = (run.relative_angle / START) ** 2 + (run.relative_rate / (START * _natural_rate(tool))) ** 2
    return float(np.diff(energy).max(initial=0.0))


def _decays(ratio: float, accuracy: float, full: bool) -> HardCase:
    name = f"ratio {ratio:.10g}: decay, accuracy {accuracy:g}"
    promise = f"angle and rate as in closed form to {accuracy:g}, as asked; energy never rises by more"
    # The longest decay takes as many steps as damping asks for: a tenth of it shows as much.
    turn = Settings().hub_turn if full or ratio < 50.0 else 0.1 * Settings().hub_turn
    return HardCase(THEME, name, promise, partial(_follows, ratio, accuracy, turn))


def _follows(ratio: float, accuracy: float, turn: float) -> Finding:
    tool = _tool(ratio)
    run = simulate(tool, Settings(accuracy=accuracy, hub_turn=turn), start_relative_angle=START)
    through = Finding(run.stop_reason, run.stop_reason == "end of the planned time")
    off = within(worst(list(_errors(tool, run))), accuracy, "off by", run.cost.steps)
    return both(through, off, within(_rise(tool, run), accuracy, "energy rises by"))


def _longest_step(tool: Tool) -> float:
    """Of samples and damping, the latter about the bristle's centre; s."""
    fastest = max(_natural_rate(tool), tool.hub.speed, tool.belt_damping / tool.bristle.inertia_about_centre)
    return 2.0 * math.pi / Settings().samples_per_period / fastest


def _whole_pass(ratio: float) -> HardCase:
    tool, promise = replace(Tool(), belt=Belt(damping_ratio=ratio)), f"strike and end as in the reference to {LIMIT:g}"
    return HardCase(THEME, f"ratio {ratio:.10g}: whole pass", promise, partial(beside_reference, tool, LIMIT))


def _spends() -> Finding:
    return budget_spent(replace(Tool(), belt=Belt(damping_ratio=HIGHEST)), BUDGET)


def _too_long(ratio: float) -> HardCase:
    name = f"ratio {ratio:g}: fixed step a tenth too long"
    return HardCase(THEME, name, "refused: the step, and what is allowed", partial(_refused, ratio))


def _refused(ratio: float) -> Finding:
    tool = _tool(ratio)
    return refusal(lambda: simulate(tool, Settings(step=1.1 * _longest_step(tool))), "step =", "is allowed", "in s")


def _first_order(ratio: float, share: float) -> HardCase:
    name = f"ratio {ratio:g}: {share:g} of the longest step"
    promise = "angle right to x + w dt of its way, x being c dt over the inertia about the centre"
    return HardCase(THEME, name, promise, partial(_stays_close, ratio, share))


def _stays_close(ratio: float, share: float) -> Finding:
    """A decay by fixed steps, over a period or, where it creeps, as far as some thousand steps go.

    In a step the engine takes 1 - e^-x of the rate about the centre instead of x, and in one that starts afresh, after an
    event, 3/4 x of the rate too much, which the joint gives back in the next.
    """
    tool = _tool(ratio, Hub(speed=1.0, radius=0.0))
    rate, step = _natural_rate(tool), share * _longest_step(tool)
    settings = Settings(step=step, hub_turn=min(2.0 * math.pi, 60.0 / (1.0 + ratio)) / rate)
    run = simulate(tool, settings, start_relative_angle=START)
    damped = step * tool.belt_damping / tool.bristle.inertia_about_centre
    way = 1.0 - float(decay(ratio, rate * run.time)[0].min())
    off = within(_errors(tool, run)[0] / way, damped + step * rate, f"x {damped:.2g}: off by", run.cost.steps)
    return both(off, within(float(np.abs(run.relative_angle / START).max()), 1.0 + LIMIT, "angle at most"))


def _not_allowed(ratio: float) -> HardCase:
    promise = "refused: belt_damping_ratio, value and range"
    return HardCase(THEME, f"ratio {ratio:g}", promise, partial(_refused_ratio, ratio))


def _refused_ratio(ratio: float) -> Finding:
    words = (f"belt_damping_ratio = {ratio!r}", "must be", f"<= {HIGHEST:g}", "dimensionless")
    return refusal(lambda: Belt(damping_ratio=ratio), *words)
