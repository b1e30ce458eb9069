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
from scipy.special import ellipk, ellipkinc

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, within, worst
from bristle_sim.benchmarks.hard_cases.measures import ACCURACY, Start, impacts_of, sustained_contacts_of
from bristle_sim.parameters import Belt, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.tool import simulate, tool_units
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

__all__ = ["SURFACE", "chatter", "falling", "most_taps", "tapping", "taps_of"]

TOOL = Tool()

SHORTEST_HOP = math.sqrt(ACCURACY)
"""Hops that are followed last longer, in radians of the fastest motion."""

SLOWEST = 1e-8
"""Part of a motion's speed below which no tap is distinguished from rest."""

SURFACE = 0.8
"""Angle, rad, at which a falling bristle meets the workpart."""

UNEVEN = 1.0
"""Relative change of the force in a radian of the fastest motion: the ratio of successive hops is off by as much times a hop."""


def chatter() -> list[HardCase]:
    """Return taps on the bar, falls on the workpart with and without friction, taps for ever, and fixed steps."""
    rows = []
    for e in (0.5, 0.7, 0.9, 0.99):
        promise = f"at most {most_taps(e)} taps, successive hops as {e:g} to {UNEVEN:g} a radian, no energy gained; then in contact"
        on_bar = partial(_taps, "bar", tapping(e), e, {})
        rows.append(HardCase("chatter", f"bar, restitution {e:g}", promise, on_bar, e in (0.5, 0.9)))
        for friction in (0.0, 0.1, 0.3):
            # Closed form of a single pendulum (Stronge): the ratio of the rates after and before.
            slide = friction / math.tan(SURFACE)
            ratio = e * math.sqrt((1.0 - slide) / (1.0 + slide))
            fall = partial(_taps, "workpart", falling(e, friction), ratio, above(0.01))
            name = f"falls 0.01 rad, restitution {e:g}, friction {friction:g}"
            rows.append(HardCase("chatter", name, promise, fall, e in (0.5, 0.9)))
        for step in (0.01, 5e-3, 1e-3) if e in (0.5, 0.9) else ():
            name = f"falls, restitution {e:g}, step {step:g} rad"
            promise = (
                "in contact at the accurate run's instant to 2 e/(1 - e) (taps + 2/(1 - e)) steps; no energy gained"
            )
            rows.append(HardCase("chatter", name, promise, partial(_taps_in_steps, e, step), step >= 5e-3))
    promise = f"taps at odd multiples of the fall's time (elliptic integrals), energy kept, both to {ACCURACY:g}"
    rows.append(HardCase("chatter", "falls 0.3 rad, restitution 1", promise, _taps_for_ever))
    for step in (1e-5, 1e-6):
        promise = f"at most {most_taps(Workpart().restitution)} taps, then in contact, and the pass goes on to its end"
        measure = partial(_pass_in_steps, step)
        rows.append(HardCase("chatter", f"whole pass in steps of {step:g} s", promise, measure, step > 1e-6))
    return rows


def tapping(restitution: float) -> Tool:
    """Return a tool whose stiff and damped belt presses the wire on the bar."""
    belt = Belt(stiffness=100.0 * TOOL.belt.stiffness, damping_ratio=0.3)
    assert TOOL.bar is not None
    return replace(TOOL, belt=belt, bar=replace(TOOL.bar, restitution=restitution), workpart=None)


def falling(restitution: float, friction: float = 0.0) -> Tool:
    """Return a bristle on a hinge that falls on the workpart, which it meets at the angle ``SURFACE``."""
    part = Workpart(friction, None, restitution, TOOL.bristle.length * (1.0 - math.cos(SURFACE)))
    still = Hub(speed=0.0, radius=0.0)
    return replace(TOOL, hub=still, belt=Belt(stiffness=0.0), bar=None, workpart=part, gravity=9.81)


def above(height: float) -> Start:
    """Return the start of a fall through an angle in rad."""
    return {"start_hub_angle": 0.0, "start_relative_angle": SURFACE + height}


def taps_of(run: Trajectory, obstacle: str) -> tuple[list[ContactRecord], ContactRecord | None]:
    """Return the taps up to the first sustained contact with an obstacle, and that contact."""
    contact = next(iter(sustained_contacts_of(run, obstacle)), None)
    end = math.inf if contact is None else contact.time
    return [each for each in impacts_of(run, obstacle) if each.time <= end], contact


def most_taps(restitution: float) -> int:
    """Return twice the number that takes a speed down to ``SLOWEST`` of itself; twice for what the motion adds in between."""
    return math.ceil(2.0 * math.log(SLOWEST) / math.log(restitution))


def _come_to_rest(taps: list[ContactRecord], contact: ContactRecord | None, restitution: float) -> Finding:
    """Return whether a finite number of taps ends in contact, and none of them gains energy."""
    works = [(sum(tap.compressive_work or ()), sum(tap.restitutive_work or ())) for tap in taps]
    gained = max(0.0, *(one + two for one, two in works)) / max(abs(one) for one, _ in works)
    told = f"{len(taps)} taps, then {'in' if contact else 'NO'} contact; energy gained {gained:.1g}"
    return Finding(told, contact is not None and 1 < len(taps) <= most_taps(restitution) and gained <= 1e-15)


def _taps(obstacle: str, tool: Tool, ratio: float, start: Start) -> Finding:
    """Compare the ratio of successive hops with theory, and the instant of sustained contact with the reference's.

    The reference does not follow hops below 1e-4 rad.
    """
    unit, turn = tool_units(tool).time, 2.0 if obstacle == "bar" else Settings().hub_turn
    run = simulate(tool, Settings(hub_turn=turn), **start)
    taps, contact = taps_of(run, obstacle)
    hops = np.diff([tap.time for tap in taps]) / unit
    hops = hops[hops > 2.0 * SHORTEST_HOP]
    uneven = worst(((hops[1:] / hops[:-1] - ratio) / hops[:-1])[-5:])
    found = [_come_to_rest(taps, contact, ratio), within(uneven, UNEVEN, "ratio of hops off by, per radian,")]
    if obstacle == "bar":
        _, expected = taps_of(simulate_reference(tool, accuracy=1e-10, hub_turn=turn, **start), obstacle)
        late = math.nan if contact is None or expected is None else (contact.time - expected.time) / unit
        found.append(within(late, (SHORTEST_HOP + 1e-4) * ratio / (1.0 - ratio), "late by, in radians,"))
    else:
        found.append(within(float(run.angles[-1, 0]) - SURFACE, ACCURACY, "at last off the surface by, in rad,"))
    return replace(all_of(*found), steps=run.cost.steps)


def _taps_for_ever() -> Finding:
    """Compare with a rod on a hinge, released at an angle from hanging: sin(angle/2) = k sin u, t = (K(k) - F(u, k))/w."""
    tool, height = falling(1.0), SURFACE + 0.3
    run = simulate(tool, **above(0.3))
    taps, contact = taps_of(run, "workpart")
    modulus = math.sin(0.5 * height)
    amplitude = math.asin(math.sin(0.5 * SURFACE) / modulus)
    rate = math.sqrt(1.5 * tool.gravity / tool.bristle.length)
    fall_time = float(ellipk(modulus**2) - ellipkinc(amplitude, modulus**2)) / rate
    late = np.array([tap.time for tap in taps]) / (fall_time * (2.0 * np.arange(len(taps)) + 1.0)) - 1.0
    # Energies are compared with that of the fall.
    fall = tool.bristle.mass * tool.gravity * 0.5 * tool.bristle.length * (math.cos(SURFACE) - math.cos(height))
    number = int((run.time[-1] / fall_time + 1.0) / 2.0)
    return all_of(
        Finding(f"{len(taps)} taps", contact is None and len(taps) == number),
        within(worst(late), ACCURACY, "instants off by", run.cost.steps),
        within(float(np.ptp(run.total_energy)) / fall, ACCURACY, "energy by"),
    )


def _taps_in_steps(restitution: float, step: float) -> Finding:
    """Compare the instant of sustained contact with the accurate run's.

    Each tap comes faster by a h: its hops last 2 h e/(1 - e) longer in all. Twice the least speed is not followed.
    """
    tool = falling(restitution)
    unit = tool_units(tool).time
    run = simulate(tool, Settings(step=step * unit, maximum_steps=300_000), **above(0.01))
    taps, contact = taps_of(run, "workpart")
    _, expected = taps_of(simulate(tool, **above(0.01)), "workpart")
    late = math.nan if contact is None or expected is None else (contact.time - expected.time) / unit / step
    limit = 2.0 * restitution / (1.0 - restitution) * (len(taps) + 2.0 / (1.0 - restitution))
    rest = _come_to_rest(taps, contact, restitution)
    return all_of(rest, within(late / limit, 1.0, "late by, of the limit,", run.cost.steps))


def _pass_in_steps(step: float) -> Finding:
    run = simulate(TOOL, Settings(step=step))
    rest = _come_to_rest(*taps_of(run, "workpart"), Workpart().restitution)
    ended = run.stop_reason == "end of the planned time" and run.event_time("workpart release") is not None
    return all_of(rest, Finding(run.stop_reason, ended, run.cost.steps))
