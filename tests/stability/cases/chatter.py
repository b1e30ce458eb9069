"""Taps that come ever faster and add up in finite time, and taps that never end.

Under a force that hardly changes, a tap of restitution e leaves e of the speed, so each hop lasts e times as long as the
one before, and a hop of T is followed by T e/(1 - e) of further ones. Hops shorter than the square root of the accuracy
are not followed, nor are those under which a fixed step's drift gives back more than restitution takes.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.special import ellipk, ellipkinc

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, row, within, worst
from bristle_sim.benchmarks.hard_cases.contact import SURFACE, above, falling, tapping, taps_of
from bristle_sim.benchmarks.hard_cases.measures import ACCURACY, Start
from bristle_sim.parameters import Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.tool import simulate, tool_units
from bristle_sim.settings import Settings

SHORTEST_HOP = math.sqrt(ACCURACY)
"""Hops that are followed last longer, in radians of the fastest motion."""

UNEVEN = 1.0
"""Relative change of the force in a radian of the fastest motion: the ratio of successive hops is off by as much times a hop."""


def chatter() -> list[HardCase]:
    """Return ever shorter hops on the bar and on the workpart, and taps for ever."""
    rows = []
    for e in (0.5, 0.9):
        promise = f"successive hops as {e:g} to {UNEVEN:g} a radian; then in contact as the reference is"
        rows.append(row("chatter", f"hops on the bar, restitution {e:g}", promise, _taps, "bar", tapping(e), e, {}))
        for friction in (0.0, 0.1, 0.3):
            # Closed form of a single pendulum (Stronge): the ratio of the rates after and before.
            slide = friction / math.tan(SURFACE)
            ratio = e * math.sqrt((1.0 - slide) / (1.0 + slide))
            name, tool = f"hops after a fall, restitution {e:g}, friction {friction:g}", falling(e, friction)
            rows.append(row("chatter", name, promise, _taps, "workpart", tool, ratio, above(0.01)))
    promise = f"taps at odd multiples of the fall's time (elliptic integrals), energy kept, both to {ACCURACY:g}"
    return [*rows, row("chatter", "falls 0.3 rad, restitution 1", promise, _taps_for_ever)]


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
    found = [within(uneven, UNEVEN, "ratio of hops off by, per radian,")]
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
