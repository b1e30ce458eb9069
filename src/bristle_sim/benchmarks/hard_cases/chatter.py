"""Taps that come ever faster and add up in finite time, and taps that never end.

Under a force that hardly changes, a tap of restitution e leaves e of the speed, so each hop lasts e times as long as the
one before, and a hop of T is followed by T e/(1 - e) of further ones. Hops shorter than the square root of the accuracy
are not followed, nor are those under which a fixed step's drift gives back more than restitution takes.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipk, ellipkinc

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, within, worst
from bristle_sim.parameters import Belt, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.tool import simulate, tool_units
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

__all__ = ["cases", "falling", "most_taps", "tapping", "taps_of"]

THEME = "chatter"

TOOL = Tool()

ACCURACY = Settings().accuracy

SHORTEST_HOP = math.sqrt(ACCURACY)
"""Hops that are followed last longer, in radians of the fastest motion."""

SLOWEST = 1e-8
"""Share of a motion's speed below which no tap is told from rest."""

PER_RADIAN = 1.0
"""Relative change of the force in a radian of the fastest motion: by as much times its length a hop's share is off e."""

SURFACE = 0.8
"""Angle, rad, at which a falling bristle meets the workpart."""

BUDGET = 300_000


def cases(full: bool) -> tuple[HardCase, ...]:
    """On the bar, falling on the workpart, with friction, for ever, and with fixed steps."""
    restitutions = (0.5, 0.7, 0.9, 0.99) if full else (0.5, 0.9)
    steps = (0.01, 3e-3, 1e-3) if full else (0.01, 5e-3)
    return (
        *(_on_the_bar(restitution) for restitution in restitutions),
        *(_fallen(restitution) for restitution in (0.5, 0.9, 0.99)),
        *(_rubbed(friction) for friction in (0.1, 0.3)),
        _for_ever(),
        *(_fixed(restitution, step) for restitution in (0.5, 0.9) for step in steps),
        *(_fixed_pass(step) for step in ((1e-5, 1e-6) if full else (1e-5,))),
    )


def tapping(restitution: float) -> Tool:
    """A stiff and damped belt presses the wire on the bar."""
    belt = Belt(stiffness=100.0 * TOOL.belt.stiffness, damping_ratio=0.3)
    assert TOOL.bar is not None
    return replace(TOOL, belt=belt, bar=replace(TOOL.bar, restitution=restitution), workpart=None)


def falling(restitution: float, friction: float = 0.0) -> Tool:
    """A bristle on a hinge that falls on the workpart, which it meets at the angle ``SURFACE``."""
    part = Workpart(friction, None, restitution, TOOL.bristle.length * (1.0 - math.cos(SURFACE)))
    still = Hub(speed=0.0, radius=0.0)
    return replace(TOOL, hub=still, belt=Belt(stiffness=0.0), bar=None, workpart=part, gravity=9.81)


def taps_of(run: Trajectory, obstacle: str) -> tuple[list[ContactRecord], ContactRecord | None]:
    """Taps up to the first time the bristle is held, and that entry of the ledger."""
    hold = next((each for each in run.contacts if each.obstacle == obstacle and each.law == "hold"), None)
    end = math.inf if hold is None else hold.time
    taps = [each for each in run.contacts if each.obstacle == obstacle and each.law != "hold" and each.time <= end]
    return taps, hold


def most_taps(restitution: float) -> int:
    """Twice as many as take a speed down to ``SLOWEST`` of itself; twice for what the motion adds in between."""
    return math.ceil(2.0 * math.log(SLOWEST) / math.log(restitution))


def _hops(taps: list[ContactRecord], unit: float) -> NDArray[np.float64]:
    """Lengths of the hops that are long enough to be followed, in radians of the fastest motion."""
    lengths = np.diff([tap.time for tap in taps]) / unit
    return np.asarray(lengths[lengths > 2.0 * SHORTEST_HOP])


def _finite(taps: list[ContactRecord], hold: ContactRecord | None, restitution: float) -> Finding:
    told = f"{len(taps)} taps, then {'held' if hold else 'NOT held'}"
    return Finding(told, hold is not None and 1 < len(taps) <= most_taps(restitution))


def _no_gain(taps: list[ContactRecord]) -> Finding:
    """Each tap takes energy; compression and restitution, normal and tangential, summed."""
    works = [sum(tap.compressive_work or ()) + sum(tap.restitutive_work or ()) for tap in taps]
    spent = max(abs(sum(tap.compressive_work or ())) for tap in taps)
    gained = max(0.0, *works) / spent
    return Finding("energy gained by none" if gained <= 1e-15 else f"energy gained {gained:.2g}", gained <= 1e-15)


def _on_the_bar(restitution: float) -> HardCase:
    promise = (
        f"at most {most_taps(restitution)} taps, the share of successive hops {restitution:g} to {PER_RADIAN:g} a radian,"
        " no energy gained, held at the reference's instant but for hops below sqrt(accuracy)"
    )
    return HardCase(THEME, f"bar, restitution {restitution:g}", promise, partial(_bar, restitution))


def _bar(restitution: float) -> Finding:
    tool = tapping(restitution)
    unit, turn = tool_units(tool).time, 2.0
    run = simulate(tool, Settings(hub_turn=turn))
    taps, hold = taps_of(run, "bar")
    _, expected = taps_of(simulate_reference(tool, accuracy=1e-10, hub_turn=turn), "bar")
    hops = _hops(taps, unit)
    uneven = worst(((hops[1:] / hops[:-1] - restitution) / hops[:-1])[-5:].tolist())
    late = math.nan if hold is None or expected is None else (hold.time - expected.time) / unit
    return both(
        _finite(taps, hold, restitution),
        within(uneven, PER_RADIAN, "share off by, per radian,"),
        _no_gain(taps),
        within(late, _unfollowed(restitution), "held late by, in radians,", run.cost.steps),
    )


def _unfollowed(restitution: float) -> float:
    """Time, in radians, of hops that are not followed; the reference does not follow those below 1e-4 rad."""
    return (SHORTEST_HOP + 1e-4) * restitution / (1.0 - restitution)


def _fallen(restitution: float) -> HardCase:
    promise = (
        f"held after (1 + e)/(1 - e) falls but for hops below sqrt(accuracy), at most {most_taps(restitution)} taps,"
        " no energy gained"
    )
    return HardCase(THEME, f"falls from 1e-4 rad, restitution {restitution:g}", promise, partial(_fall, restitution))


def _fall(restitution: float) -> Finding:
    """From so near that the force is constant to 1e-4."""
    tool = falling(restitution)
    run = simulate(tool, start_hub_angle=0.0, start_relative_angle=SURFACE + 1e-4)
    taps, hold = taps_of(run, "workpart")
    expected = taps[0].time * (1.0 + restitution) / (1.0 - restitution)
    late = math.nan if hold is None else (hold.time - expected) / tool_units(tool).time
    limit = _unfollowed(restitution) + 1e-4 * expected / tool_units(tool).time
    rest = within(float(run.angles[-1, 0]) - SURFACE, ACCURACY, "at last off the surface by, in rad,")
    return both(_finite(taps, hold, restitution), _no_gain(taps), within(late, limit, "held late by"), rest)


def _rubbed(friction: float) -> HardCase:
    promise = f"successive hops as e sqrt((1 - mu cot)/(1 + mu cot)) to {PER_RADIAN:g} a radian, then held"
    name = f"falls with friction {friction:g}, restitution 0.9"
    return HardCase(THEME, name, promise, partial(_rub, friction))


def _rub(friction: float) -> Finding:
    """The closed form of a single pendulum (Stronge): the rates before and after differ by this factor."""
    restitution, slide = 0.9, friction / math.tan(SURFACE)
    tool = falling(restitution, friction)
    run = simulate(tool, start_hub_angle=0.0, start_relative_angle=SURFACE + 0.01)
    taps, hold = taps_of(run, "workpart")
    hops = _hops(taps, tool_units(tool).time)
    expected = restitution * math.sqrt((1.0 - slide) / (1.0 + slide))
    uneven = worst(((hops[1:] / hops[:-1] - expected) / hops[:-1])[-5:].tolist())
    return both(
        _finite(taps, hold, expected),
        within(uneven, PER_RADIAN, "share off by, per radian,", run.cost.steps),
        _no_gain(taps),
    )


def _for_ever() -> HardCase:
    promise = (
        f"taps at odd multiples of the fall's time (elliptic integrals), energy kept, both to {ACCURACY:g}, as asked"
    )
    return HardCase(THEME, "falls 0.3 rad, restitution 1", promise, _elastic)


def _elastic() -> Finding:
    tool, above = falling(1.0), SURFACE + 0.3
    run = simulate(tool, start_hub_angle=0.0, start_relative_angle=above)
    taps, hold = taps_of(run, "workpart")
    times = np.array([tap.time for tap in taps])
    expected = _time_of_fall(tool, above) * (2.0 * np.arange(len(taps)) + 1.0)
    # Energies from the surface up: that of the fall.
    fall = tool.bristle.mass * tool.gravity * 0.5 * tool.bristle.length * (math.cos(SURFACE) - math.cos(above))
    told = Finding(f"{len(taps)} taps", hold is None and len(taps) == int((run.time[-1] / expected[0] + 1.0) / 2.0))
    return both(
        told,
        within(worst((times / expected - 1.0).tolist()), ACCURACY, "instants off by", run.cost.steps),
        within(float(np.ptp(run.total_energy)) / fall, ACCURACY, "energy by"),
    )


def _time_of_fall(tool: Tool, above: float) -> float:
    """A rod on a hinge, let go at an angle from hanging: sin(angle/2) = k sin u, and t = (K(k) - F(u, k))/w."""
    rate = math.sqrt(1.5 * tool.gravity / tool.bristle.length)
    modulus = math.sin(0.5 * above)
    amplitude = math.asin(math.sin(0.5 * SURFACE) / modulus)
    return float(ellipk(modulus**2) - ellipkinc(amplitude, modulus**2)) / rate


def _fixed(restitution: float, step: float) -> HardCase:
    promise = "held, at the accurate run's instant to 2 e/(1 - e) (taps + 2/(1 - e)) steps; no energy gained"
    name = f"falls, restitution {restitution:g}, step {step:g} rad"
    return HardCase(THEME, name, promise, partial(_step, restitution, step))


def _step(restitution: float, step: float) -> Finding:
    """Each tap comes faster by a h: its hops last 2 h e/(1 - e) longer in all. Twice the least speed is not followed."""
    tool = falling(restitution)
    unit = tool_units(tool).time
    settings = Settings(step=step * unit, maximum_steps=BUDGET)
    run, exact = (
        simulate(tool, each, start_hub_angle=0.0, start_relative_angle=SURFACE + 0.01)
        for each in (settings, Settings())
    )
    taps, hold = taps_of(run, "workpart")
    _, expected = taps_of(exact, "workpart")
    late = math.nan if hold is None or expected is None else (hold.time - expected.time) / unit / step
    limit = 2.0 * restitution / (1.0 - restitution) * (len(taps) + 2.0 / (1.0 - restitution))
    finite = both(_finite(taps, hold, restitution), _no_gain(taps))
    return both(finite, within(late / limit, 1.0, "late by, of the limit,", run.cost.steps))


def _fixed_pass(step: float) -> HardCase:
    promise = f"at most {most_taps(Workpart().restitution)} taps, then held, and released before the pass ends"
    return HardCase(THEME, f"whole pass in steps of {step:g} s", promise, partial(_pass, step))


def _pass(step: float) -> Finding:
    run = simulate(TOOL, Settings(step=step))
    taps, hold = taps_of(run, "workpart")
    ended = Finding(run.stop_reason, run.stop_reason == "end of the planned time", run.cost.steps)
    released = Finding(
        "released" if hold and hold.outcome == "release" else "not released",
        hold is not None and hold.outcome == "release",
    )
    return both(_finite(taps, hold, Workpart().restitution), released, _no_gain(taps), ended)
