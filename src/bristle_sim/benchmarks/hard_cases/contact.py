"""Lasting contact where it is hard: taps that add up in finite time, and both obstacles at once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, refusal, row
from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    Start,
    agrees_with_reference,
    impacts_of,
    is_finite,
    sustained_contacts_of,
)
from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length

SURFACE = 0.8
"""Angle, rad, at which a falling bristle meets the workpart."""

SLOWEST = 1e-8
"""Ratio to a motion's speed below which no tap is distinguished from rest."""


def chatter() -> Iterator[HardCase]:
    """Yield taps on the bar, falls on the workpart with and without friction, and a pass in fixed steps.

    A tap of restitution e leaves e of the speed, so that each hop lasts e times as long as the one before.
    """
    case = partial(row, "chatter")
    promise = "at most {} taps, no energy gained; then in contact"
    for e in (0.5, 0.7, 0.9, 0.99):
        quick, few = e in (0.5, 0.9), promise.format(most_taps(e))
        tool = tapping(e)
        yield case(f"bar, restitution {e:g}", few, _comes_to_rest, tool, "bar", e, Settings(hub_turn=2.0), quick=quick)
        # A restitution of 0.99 takes longer than a run to come to rest.
        for friction in (0.0, 0.1, 0.3) if e < 0.99 else ():
            name, tool = f"falls 0.01 rad, restitution {e:g}, friction {friction:g}", falling(e, friction)
            yield case(name, few, _comes_to_rest, tool, "workpart", e, Settings(), above(0.01), quick=quick)
    for step in (1e-5, 1e-6):
        e, settings = Workpart().restitution, Settings(step=step)
        name, few = f"whole pass in steps of {step:g} s", promise.format(most_taps(e))
        yield case(name, few, _comes_to_rest, TOOL, "workpart", e, settings, quick=step > 1e-6)


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


def above(angle: float) -> Start:
    """Return the start of a fall through an angle in rad."""
    return {"start_hub_angle": 0.0, "start_relative_angle": SURFACE + angle}


def taps_of(run: Trajectory, obstacle: str) -> tuple[list[ContactRecord], ContactRecord | None]:
    """Return the taps up to the first sustained contact with an obstacle, and that contact."""
    contact = next(iter(sustained_contacts_of(run, obstacle)), None)
    end = math.inf if contact is None else contact.time
    return [each for each in impacts_of(run, obstacle) if each.time <= end], contact


def most_taps(restitution: float) -> int:
    """Return twice the number that takes a speed down to ``SLOWEST`` of itself; twice for what the motion adds in between."""
    return math.ceil(2.0 * math.log(SLOWEST) / math.log(restitution))


def _comes_to_rest(
    tool: Tool, obstacle: str, restitution: float, settings: Settings, start: Start | None = None
) -> Finding:
    """Return whether a finite number of taps ends in contact, and none of them gains energy."""
    run = simulate(tool, settings, **(start or {}))
    taps, contact = taps_of(run, obstacle)
    works = [(sum(tap.compressive_work or ()), sum(tap.restitutive_work or ())) for tap in taps]
    gained = max(0.0, *(one + two for one, two in works)) / max(abs(one) for one, _ in works)
    told = f"{len(taps)} taps, then {'in' if contact else 'NO'} contact; energy gained {gained:.1g}"
    kept = contact is not None and 1 < len(taps) <= most_taps(restitution) and gained <= 1e-15
    return Finding(told, kept, run.cost.steps)


WEDGE: Start = {"start_hub_angle": -0.9, "start_relative_angle": 1.2}
"""Start of a bristle that leans ahead over the workpart, the bar before it."""

STARTS = {"workpart": (-0.4, -0.3), "bar": (-0.9, -0.4)}
"""Hub angle and relative angle of bristles that start in contact, behind the radial direction, rad."""

AS_REFERENCE = f"end and strike as in the reference to {ACCURACY:g}, the requested accuracy"


def touching() -> Iterator[HardCase]:
    """Yield strikes while the bar is touched, wedges, and starts in contact or overlapping."""
    case = partial(row, "touching")
    for bar, restitution in ((0.0, 0.0), (0.4, 0.42), (0.0, 0.9)):
        for rub, slide in ((0.0, 0.0), (0.2, 0.31)):
            name = f"struck while the bar is touched, restitution {bar:g} and {restitution:g}, friction {rub:g} and {slide:g}"
            promise = f"end and strike as in the reference to {10 * ACCURACY:g}, the requested accuracy"
            yield case(name, promise, agrees_with_reference, near_bar(bar, rub, restitution, slide), 10 * ACCURACY)
    for e in (0.0, 0.3, 0.5, 0.7, 0.9):
        for step in (None, 1e-6):
            name = f"wedged in, restitution {e:g}" + (f", steps of {step:g} s" if step else "")
            yield case(name, "jam, by name", _jams, wedged(e), step, quick=e in (0.0, 0.5, 0.9))
    for what in STARTS:
        tool, start = starting_at(what)
        into: Start = {**start, "start_relative_rate": 100.0}
        yield case(f"starts moving into the {what}", AS_REFERENCE, agrees_with_reference, tool, start=into)
        for fraction in (1e-10, 1e-3):
            words = {"workpart": ("penetration =",), "bar": ("bar_horizontal =", "bar_vertical =")}[what]
            inside, begin = starting_at(what, gap=-fraction * LENGTH)
            name, run = f"starts {fraction:g} of its length inside the {what}", partial(simulate, inside, **begin)
            yield case(name, "refused in one line that names the keys", refusal, run, *words, "in m")


def between(
    hub_angle: float, angle: float, *, at: float = 0.8, bar_gap: float | None = 0.0, gap: float | None = 0.0
) -> Tool:
    """Return a tool whose bristle, at an absolute angle (rad), has bar and workpart at the given gaps (m), or none of them.

    The bar stands ahead of the wire, at a part of its length; neither rubs nor restores.
    """
    along = np.array([math.sin(angle), -math.cos(angle)])
    root = ROOT * np.array([math.sin(hub_angle), -math.cos(hub_angle)])
    bar = part = None
    if bar_gap is not None:
        radius = 1e-3
        reach = radius + 0.5 * TOOL.bristle.wire_diameter + bar_gap
        x, y = root + at * LENGTH * along + reach * np.array([-along[1], along[0]])
        bar = Bar(radius, horizontal=-float(x), vertical=-float(y))
    if gap is not None:
        depth = gap - float(root[1] + LENGTH * along[1])
        part = Workpart(0.0, None, 0.0, ROOT + LENGTH - depth)
    return replace(TOOL, bar=bar, workpart=part)


def starting_at(obstacle: str, *, side: float = 1.0, gap: float = 0.0) -> tuple[Tool, Start]:
    """Return a tool with one obstacle, touched at the start or off it by a gap, and the start; ``side`` -1 leans ahead."""
    hub_angle, relative = STARTS[obstacle][0], side * STARTS[obstacle][1]
    bar_gap, part_gap = (gap, None) if obstacle == "bar" else (None, gap)
    tool = between(hub_angle, hub_angle + relative, bar_gap=bar_gap, gap=part_gap)
    return tool, {"start_hub_angle": hub_angle, "start_relative_angle": relative}


def near_bar(bar_restitution: float, rub: float, restitution: float, slide: float) -> Tool:
    """Return a near bar and a deep workpart: the bar lets the tip down on it, and in the end folds the bristle."""
    away, direction = 0.054, math.radians(50.0)
    x, y = away * math.sin(direction), away * math.cos(direction)
    bar = Bar(radius=0.0034, friction=rub, restitution=bar_restitution, horizontal=x, vertical=y)
    part = Workpart(slide, None, restitution, penetration=0.0225)
    return replace(TOOL, belt=Belt(3.0 * TOOL.belt.stiffness), bar=bar, workpart=part)


def wedged(restitution: float) -> Tool:
    """Return a tool whose bar and workpart close in on the bristle."""
    tool = between(-0.9, 0.3, bar_gap=2e-4, gap=2e-4)
    parts: dict[str, Any] = {
        each: replace(getattr(tool, each), restitution=restitution) for each in ("bar", "workpart")
    }
    return replace(tool, **parts)


def _jams(tool: Tool, step: float | None) -> Finding:
    run = simulate(tool, Settings(step=step, maximum_steps=100_000), **WEDGE)
    told = f"{run.stop_reason} after {len(run.contacts)} contacts"
    return Finding(told, run.stop_reason == "jam" and is_finite(run), run.cost.steps)
