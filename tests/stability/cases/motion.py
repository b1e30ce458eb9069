"""Smooth motion where it is hard: stiff and soft belts, any damping, hubs at rest and fast."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipj

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, refusal, row, within, worst
from bristle_sim.benchmarks.hard_cases.measures import ACCURACY
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Belt, Hub, Tool
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings

Array = NDArray[np.float64]

FREE = Tool(bar=None, workpart=None)

FINE = 1e-9
"""Accuracy of runs that are requested a thousand times more accurate."""

REFUSED = "refused in one line: the step, and what it must be"


def _natural_rate(tool: Tool) -> float:
    return math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)


def belt_stiffness() -> list[HardCase]:
    """Return oscillations in fixed steps, over nine decades of stiffness."""
    return [
        row("belt_stiffness", f"belt x {factor:g}: {part:g} of the longest step", OSCILLATION, _oscillates, tool, part)
        for factor in (1e-3, 1.0, 1e6)
        for tool in [replace(FREE, belt=Belt(stiffness=factor * Belt().stiffness))]
        for part in (0.999, 0.25)
    ]


OSCILLATION = "energy at most 1/(1 - w dt/2) of its start, by the map's invariant; period right to (w dt)^2"


def _oscillates(tool: Tool, part: float) -> Finding:
    """Measure energy and period of the belt's oscillation on a hub at rest, with fixed steps of a part of the longest.

    From x_(n+1) = x_n + h v_n, v_(n+1) = v_n - w^2 h x_(n+1) follows that v^2 + w^2 x^2 + w^2 h x v is constant, hence the
    bound of the energy.
    """
    still = replace(tool, hub=Hub(speed=0.0))
    rate = _natural_rate(still)
    radians = part * 2.0 * math.pi / Settings().samples
    run = simulate(still, Settings(step=radians / rate), start_relative_angle=-RETRACTION_AT_RELEASE)
    angle = run.relative_angle
    energy = angle**2 + (run.relative_rate / rate) ** 2
    top = float(energy.max() / energy[0]) * (1.0 - 0.5 * radians)
    # Crossings of the radial direction, each on the straight line between two samples.
    before = np.nonzero(angle[1:] * angle[:-1] < 0.0)[0]
    slope = (angle[before + 1] - angle[before]) / (run.time[before + 1] - run.time[before])
    crossings = run.time[before] - angle[before] / slope
    period = 2.0 * float(crossings[-1] - crossings[0]) / (len(crossings) - 1)
    return all_of(
        within(top, 1.0 + ACCURACY, f"w dt {radians:.2g}: energy over its bound", run.cost.steps),
        within(period * rate / (2.0 * math.pi) - 1.0, radians**2, "period off by"),
    )


RATIOS = (0.0, 1e-9, 1e-3, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 10.0, 100.0)

FINE_DECAY = 1e-8
"""Accuracy of decays that are requested a hundred times more accurate; at a ratio of 10 rounding adds up to a tenth of it."""


def damping() -> list[HardCase]:
    """Return decays compared with their closed form, and fixed steps, for ratios from 0 to 100."""

    rows = []
    for ratio in RATIOS:
        for accuracy in (ACCURACY, FINE_DECAY) if ratio == 1.0 else (ACCURACY,):
            promise = (
                f"angle and rate as in closed form to {accuracy:g}, the requested accuracy; energy rises by no more"
            )
            # The longest decay takes the more steps the more it is damped: a tenth of it shows as much.
            turn = (0.1 if ratio > 50.0 else 1.0) * Settings().hub_turn
            name = f"ratio {ratio:.10g}: decay, accuracy {accuracy:g}"
            rows.append(row("damping", name, promise, _decays, ratio, accuracy, turn))
        if ratio in (0.5, 10.0, 100.0):
            name = f"ratio {ratio:.10g}: fixed step a tenth too long"
            rows.append(row("damping", name, REFUSED, _refuses_damped_step, ratio))
    return rows


def damped_decay(ratio: float, phase: Array) -> tuple[Array, Array]:
    """Return angle over its start and rate over start times natural rate, released from rest, at natural rate times time.

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


DECAY_START = -RETRACTION_AT_RELEASE


def _on_axis(ratio: float) -> Tool:
    """Return a free bristle whose root is on the hub's axis, so that its decay is the damped oscillator's at any speed."""
    return replace(FREE, hub=Hub(radius=0.0), belt=Belt(damping_ratio=ratio))


def _decays(ratio: float, accuracy: float, turn: float) -> Finding:
    tool = _on_axis(ratio)
    rate = _natural_rate(tool)
    run = simulate(tool, Settings(accuracy=accuracy, hub_turn=turn), start_relative_angle=DECAY_START)
    angle, speed = run.relative_angle / DECAY_START, run.relative_rate / (DECAY_START * rate)
    exact_angle, exact_speed = damped_decay(ratio, rate * run.time)
    off = worst([np.abs(angle - exact_angle).max(), np.abs(speed - exact_speed).max()])
    return all_of(
        Finding(run.stop_reason, run.stop_reason == "end of the planned time"),
        within(off, accuracy, "off by", run.cost.steps),
        within(float(np.diff(angle**2 + speed**2).max(initial=0.0)), accuracy, "energy rises by"),
    )


def _longest_step(tool: Tool) -> float:
    """Return the longest fixed step in s, by the samples in a period and by the damping about the bristle's centre."""
    fastest = max(_natural_rate(tool), tool.hub.speed, tool.belt_damping / tool.bristle.inertia_about_centre)
    return 2.0 * math.pi / Settings().samples / fastest


def _refuses_damped_step(ratio: float) -> Finding:
    tool = _on_axis(ratio)
    return refusal(lambda: simulate(tool, Settings(step=1.1 * _longest_step(tool))), "step =", "in s")


def hub_speed() -> list[HardCase]:
    """Return the oscillation on a hub at rest, a tool that stands still, and the field alone."""
    kept = f"period 2 pi sqrt(I/k) and energy kept, to {FINE:g} as requested"
    still = f"remains where it is to {ACCURACY:g}; touches nothing"
    promise = f"angle and rate by elliptic functions to {FINE:g}, the requested accuracy"
    return [
        row("hub_speed", "0 rad/s: three periods", kept, _three_periods),
        row("hub_speed", "0 rad/s: whole pass", still, _remains),
        *(row("hub_speed", f"{v:g} rad/s: released, no belt", promise, _swings_in_field, v) for v in (1e-3, 1e5)),
    ]


def _three_periods() -> Finding:
    """Measure period and energy on a hub at rest, where the belt's oscillation is harmonic for every amplitude."""
    tool = replace(FREE, hub=Hub(speed=0.0))
    run = simulate(tool, Settings(accuracy=FINE), start_relative_angle=-RETRACTION_AT_RELEASE)
    times = [event.time for event in run.events if event.name == "highest relative speed"]
    late = (times[-1] - times[0]) / ((len(times) - 1) * 2.0 * math.pi / _natural_rate(tool)) - 1.0
    drift = float(np.ptp(run.total_energy)) / float(run.total_energy[0])
    return all_of(within(late, FINE, "period off by", run.cost.steps), within(drift, FINE, "energy by"))


def _remains() -> Finding:
    tool = Tool(hub=Hub(speed=0.0))
    run = simulate(tool)
    moved = worst([np.abs(run.relative_angle).max(), np.abs(run.relative_rate).max() / _natural_rate(tool)])
    names = [event.name for event in run.events]
    told = Finding(", ".join(names), names == ["bar not touched", "workpart not reached"] and not run.contacts)
    return all_of(within(moved, ACCURACY, "moved by", run.cost.steps), told)


def _swings_in_field(speed: float) -> Finding:
    """Compare with Jacobi's elliptic functions: without a belt alpha'' = -W^2 sin alpha, W^2 = (3 r_h/(2 L)) w^2.

    Released from rest, sin(alpha/2) = k cd(W t), alpha' = -2 k W k' sn(W t)/dn(W t) with k the sine of half the start.
    """
    tool = replace(FREE, hub=Hub(speed=speed), belt=Belt(stiffness=0.0))
    run = simulate(tool, Settings(accuracy=FINE), start_relative_angle=-RETRACTION_AT_RELEASE)
    rate = math.sqrt(1.5 * tool.hub.radius / tool.bristle.length) * speed
    k = math.sin(-0.5 * RETRACTION_AT_RELEASE)
    sn, cn, dn, _ = ellipj(rate * run.time, k * k)
    angle = 2.0 * np.arcsin(k * cn / dn)
    speeds = -2.0 * k * math.sqrt(1.0 - k * k) * sn / dn
    off = worst([np.abs(run.relative_angle - angle).max(), np.abs(run.relative_rate / rate - speeds).max()])
    return within(off, FINE, "off by", run.cost.steps)
