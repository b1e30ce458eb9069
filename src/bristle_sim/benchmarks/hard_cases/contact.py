"""Lasting contact where it is hard: taps that add up in finite time, and both obstacles at once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, refusal, row, within, worst
from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    Start,
    agrees_with_reference,
    end_difference,
    impacts_of,
    is_finite,
    strike_difference,
    sustained_contacts_of,
)
from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.scene.tool import simulate, simulate_row, tool_units
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactRecord, Trajectory

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length

SURFACE = 0.8
"""Angle, rad, at which a falling bristle meets the workpart."""

SLOWEST = 1e-8
"""Ratio to a motion's speed below which no tap is distinguished from rest."""


def chatter() -> Iterator[HardCase]:
    """Yield taps on the bar and falls on the workpart, with and without friction.

    A tap of restitution e leaves e of the speed, so that each hop lasts e times as long as the one before.
    """
    case = partial(row, "chatter")
    promise = "at most {} taps, no energy gained; then in contact"
    for e in (0.5, 0.9, 0.99):
        few, tool = promise.format(most_taps(e)), tapping(e)
        yield case(
            f"bar, restitution {e:g}", few, _comes_to_rest, tool, "bar", e, Settings(hub_turn=2.0), quick=e < 0.99
        )
    for e, friction in ((0.5, 0.3), (0.9, 0.1)):
        name, few = f"falls 0.01 rad, restitution {e:g}, friction {friction:g}", promise.format(most_taps(e))
        yield case(name, few, _comes_to_rest, falling(e, friction), "workpart", e, Settings(), above(0.01))


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
    """Yield strikes while the bar is touched, wedges, starts in contact or overlapping, and nearly parallel wires."""
    case = partial(row, "touching")
    for bar, part, rub, slide in ((0.0, 0.0, 0.0, 0.0), (0.4, 0.42, 0.2, 0.31)):
        name = f"struck while the bar is touched, restitution {bar:g} and {part:g}, friction {rub:g} and {slide:g}"
        promise = f"end and strike as in the reference to {10 * ACCURACY:g}, the requested accuracy"
        yield case(name, promise, agrees_with_reference, near_bar(bar, rub, part, slide), 10 * ACCURACY)
    for e in (0.0, 0.5):
        promise = f"jam, by name, when the wedge has closed, to {ACCURACY:g} of the scene's time"
        yield case(f"wedged in, restitution {e:g}", promise, _jams, e)
    promise = "remains to 1e-12 rad, to the end"
    yield case("pinned by bar and workpart, hub at rest", promise, _pinned)
    for what in STARTS:
        tool, start = starting_at(what)
        promise = f"{promise}; its force the belt's torque over the lever to 1e-9"
        yield case(f"starts at rest, pressed on the {what}", promise, _presses, what)
        into: Start = {**start, "start_relative_rate": 100.0}
        yield case(f"starts moving into the {what}", AS_REFERENCE, agrees_with_reference, tool, start=into)
        words = {"workpart": ("penetration =",), "bar": ("bar_horizontal =", "bar_vertical =")}[what]
        inside, begin = starting_at(what, gap=-1e-10 * LENGTH)
        name, run = f"starts 1e-10 of its length inside the {what}", partial(simulate, inside, **begin)
        yield case(name, "refused in one line that names the keys", refusal, run, *words, "in m")
    same = f"the reference's end and strike, to {PARALLEL:g}"
    yield case("two bristles 3 deg apart, nearly parallel", same, _nearly_parallel, 3.0)


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


def _jams(restitution: float) -> Finding:
    """Compare the end of a run with the instant at which a flank meets the bar while the tip is on the workpart."""
    tool, begin = wedged(restitution), WEDGE["start_hub_angle"]
    centre = tool.bar.centre if tool.bar is not None else (math.nan, math.nan)

    def gap(hub_angle: float) -> float:
        angle = math.acos((tool.workpart_depth - ROOT * math.cos(hub_angle)) / LENGTH)
        x, y = centre[0] - ROOT * math.sin(hub_angle), centre[1] + ROOT * math.cos(hub_angle)
        return x * math.cos(angle) + y * math.sin(angle) - tool.bar_reach

    low, high = begin + 1e-4, begin + 0.1
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gap(low) * gap(middle) > 0.0 else (low, middle)
    run = simulate(tool, Settings(maximum_steps=100_000), **WEDGE)
    late = (float(run.time[-1]) - (low - begin) / tool.hub.speed) / tool_units(tool).time
    told = Finding(f"{run.stop_reason} after {len(run.contacts)} contacts", run.stop_reason is StopReason.JAM)
    return all_of(told, Finding("finite", is_finite(run)), within(late, ACCURACY, "late by", run.cost.steps))


def _remains(run: Trajectory) -> Finding:
    moved = within(float(np.ptp(run.angles)), 1e-12, "moved by", run.cost.steps)
    return all_of(moved, Finding(run.stop_reason, run.stop_reason is StopReason.END))


def _pinned() -> Finding:
    """Ahead of the vertical on the workpart and behind the bar, neither of which the resting hub drives it into."""
    tool = replace(between(-0.3, 0.3, at=0.6), hub=Hub(speed=0.0))
    return _remains(simulate(tool, start_hub_angle=-0.3, start_relative_angle=0.6))


def _presses(obstacle: str) -> Finding:
    """The belt turns the bristle towards its radial direction."""
    tool, start = starting_at(obstacle)
    tool = replace(tool, hub=Hub(speed=0.0))
    run, relative = simulate(tool, **start), start["start_relative_angle"]
    lever = 0.8 * LENGTH if obstacle == "bar" else LENGTH * abs(math.sin(start["start_hub_angle"] + relative))
    force = tool.belt.stiffness * abs(relative) / lever
    return all_of(_remains(run), within(float(run.normal_force[-1]) / force - 1.0, 1e-9, "force off by"))


PARALLEL = 1e-5
"""Limit of differences from the reference of wires that are nearly parallel: they magnify errors, and are run to 1e-8."""


def _nearly_parallel(pitch_deg: float) -> Finding:
    """Let two rigid bristles touch each other along their flanks up to the strike, in the scene and in the reference."""
    from bristle_sim.reference import simulate_row_reference

    surface = {"neighbour_friction": 0.2, "neighbour_restitution": 0.5}
    given: dict[str, Any] = {"bristles": 2, "pitch": math.radians(pitch_deg), "stop_after": "strike", **surface}
    runs = simulate_row(Tool(), Settings(accuracy=1e-8), **given)
    others = simulate_row_reference(Tool(), accuracy=1e-10, **given)
    pairs = list(zip(runs, others, strict=True))
    off = worst(each for pair in pairs for each in (*end_difference(*pair), *strike_difference(*pair)))
    touches = sum(each.obstacle == "wire" for each in runs[0].contacts)
    return all_of(Finding(f"{touches} touches", touches > 0), within(off, PARALLEL, "off by", runs[0].cost.steps))
