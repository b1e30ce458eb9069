"""Hard cases of contact: infinitely many impacts (taps) in a finite time, and simultaneous contact
with bar and workpart.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    AS_REFERENCE,
    IMPACT_LAWS,
    Finding,
    HardCase,
    Start,
    agrees_with_reference,
    all_of,
    hard_case,
    impacts_of,
    within,
)
from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.tool import tool_units
from bristle_sim.settings import Settings, StopReason

TOOL = Tool()
ROOT = TOOL.hub.radius
LENGTH = TOOL.bristle.length

SURFACE = 0.8
"""Angle from the vertical (rad) at which a falling bristle meets the workpart."""

SLOWEST = 1e-8
"""Speed of an impact, as a fraction of the first impact's speed, below which the wire counts as at
rest."""


def chatter() -> Iterator[HardCase]:
    """Yield cases of a wire that bounces on an obstacle at ever shorter intervals until it rests.

    In two cases a wire on a stiff, damped belt bounces on the bar. In two others a wire on a hinge
    falls on the workpart. An impact multiplies the speed by the coefficient of restitution e. Each
    interval between impacts is therefore about e times as long as the previous interval.
    """
    pressed = TOOL.replace(
        belt_stiffness=100.0 * TOOL.belt.stiffness, belt_damping_ratio=0.3, workpart=None
    )
    for e in (0.5, 0.9):
        tool = pressed.replace(bar_restitution=e)
        yield _chatters(f"bar, restitution {e:g}", tool, "bar", e, Settings(hub_turn=2.0), {})
    fall: Start = {"start_hub_angle": 0.0, "start_relative_angle": SURFACE + 0.01}
    hinge = Tool(Hub(speed=0.0, radius=0.0), Belt(stiffness=0.0), bar=None, gravity=9.81)
    for e, friction in ((0.5, 0.3), (0.9, 0.1)):
        surface = Workpart(friction, None, e, LENGTH * (1.0 - math.cos(SURFACE)))
        tool = replace(hinge, workpart=surface)
        name = f"falls 0.01 rad, restitution {e:g}, friction {friction:g}"
        yield _chatters(name, tool, "workpart", e, Settings(), fall)


def _chatters(
    name: str, tool: Tool, obstacle: str, e: float, settings: Settings, start: Start
) -> HardCase:
    """Return a case whose repeated impacts must end with the bristle resting on the obstacle.

    The coefficient of restitution is ``e``. The permitted number of impacts is twice the number n
    at which e^n = ``SLOWEST``. The factor 2 allows for the motion between the impacts.
    """
    most = math.ceil(2.0 * math.log(SLOWEST) / math.log(e))
    promise = f"at most {most} taps, no energy gained; then in contact"
    return hard_case(name, promise, _comes_to_rest, tool, obstacle, most, settings, start)


def _comes_to_rest(
    tool: Tool, obstacle: str, most: int, settings: Settings, start: Start
) -> Finding:
    """Check that impacts on an obstacle end in sustained contact.

    There must be 2 to ``most`` impacts, none of which gains energy.
    """
    run = simulate(tool, settings, **start)
    sustained = [
        each.time
        for each in run.contacts
        if each.law not in IMPACT_LAWS and each.obstacle == obstacle
    ]
    taps = [
        each for each in impacts_of(run, obstacle) if each.time <= min(sustained, default=math.inf)
    ]
    works = [(sum(tap.compressive_work or ()), sum(tap.restitutive_work or ())) for tap in taps]
    gained = max(0.0, *(one + two for one, two in works)) / max(abs(one) for one, _ in works)
    result = (
        f"{len(taps)} taps, then {'in' if sustained else 'NO'} contact; energy gained {gained:.1g}"
    )
    return Finding(
        result, bool(sustained) and 1 < len(taps) <= most and gained <= 1e-15, run.cost.steps
    )


WEDGE: Start = {"start_hub_angle": -0.9, "start_relative_angle": 1.2}
"""State at the start of a bristle that leans forward over the workpart; the bar is ahead of it."""

PINNED: Start = {"start_hub_angle": -0.3, "start_relative_angle": 0.6}
"""State at the start of a bristle that touches both the bar and the workpart."""


def touching() -> Iterator[HardCase]:
    """Yield cases of a wire in contact with the bar and the workpart at once.

    One wire strikes the workpart while it touches the bar. One is wedged between bar and workpart.
    One lies at rest between them.
    """
    # A near bar and a deep workpart: the bar lowers the tip onto the workpart and at last folds the
    # bristle.
    both = TOOL.replace(
        belt_stiffness=3.0 * TOOL.belt.stiffness,
        bar_restitution=0.4,
        bar_friction=0.2,
        bar_radius=0.0034,
        bar_horizontal=0.0413664,
        bar_vertical=0.0347105,
        penetration=0.0225,
    )
    limit = 10 * ACCURACY
    promise = AS_REFERENCE.format(limit)
    yield hard_case("struck while the bar is touched", promise, agrees_with_reference, both, limit)
    promise = (
        f"stops with a jam when the wedge has closed, to {ACCURACY:g} of the scene's time unit"
    )
    yield hard_case("wedged in, restitution 0.5", promise, _jams)
    name = "pinned by bar and workpart, hub at rest"
    yield hard_case(name, "moves by at most 1e-12 rad until the end", _remains)


def between(
    hub_angle: float, angle: float, *, at: float = 0.8, bar_gap: float = 0.0, gap: float = 0.0
) -> Tool:
    """Return a tool whose bar and workpart are at given distances from its bristle.

    The bar stands ahead of the wire. Neither obstacle has friction or restitution.

    Args:
        hub_angle: hub angle, rad.
        angle: absolute angle of the bristle, rad.
        at: distance along the wire from its root to the bar, as a fraction of the wire's length.
        bar_gap: gap between wire and bar, m.
        gap: gap between tip and workpart, m.
    """
    along = np.array([math.sin(angle), -math.cos(angle)])
    root = ROOT * np.array([math.sin(hub_angle), -math.cos(hub_angle)])
    radius = 1e-3
    reach = radius + 0.5 * TOOL.bristle.wire_diameter + bar_gap
    x, y = root + at * LENGTH * along + reach * np.array([-along[1], along[0]])
    depth = gap - float(root[1] + LENGTH * along[1])
    return replace(
        TOOL,
        bar=Bar(radius, horizontal=-float(x), vertical=-float(y)),
        workpart=Workpart(0.0, None, 0.0, ROOT + LENGTH - depth),
    )


def _jams() -> Finding:
    """Check that the run of a wedged wire stops with a jam, and at the right time.

    The wire jams when its side meets the bar while the tip is on the workpart.
    """
    begin = WEDGE["start_hub_angle"]
    tool = between(begin, 0.3, bar_gap=2e-4, gap=2e-4)
    tool = tool.replace(bar_restitution=0.5, restitution=0.5)
    assert tool.bar is not None
    bar_x, bar_y = tool.bar.centre

    def gap(hub_angle: float) -> float:
        """Return the gap (m) between bar and wire at a hub angle (rad); the tip is on the workpart.

        The gap is negative if the wire overlaps the bar.
        """
        angle = math.acos((tool.workpart_depth - ROOT * math.cos(hub_angle)) / LENGTH)
        x = bar_x - ROOT * math.sin(hub_angle)
        y = bar_y + ROOT * math.cos(hub_angle)
        return x * math.cos(angle) + y * math.sin(angle) - tool.bar_reach

    closed = brentq(gap, begin + 1e-4, begin + 0.1, xtol=1e-15)
    run = simulate(tool, Settings(maximum_steps=100_000), **WEDGE)
    late = (float(run.time[-1]) - (closed - begin) / tool.hub.speed) / tool_units(tool).time
    named = Finding(
        f"{run.stop_reason} after {len(run.contacts)} contacts", run.stop_reason is StopReason.JAM
    )
    return all_of(named, within(late, ACCURACY, "late by", run.cost.steps))


def _remains() -> Finding:
    """Check that a bristle between bar and workpart stays at rest on a resting hub."""
    tool = between(-0.3, 0.3, at=0.6).replace(hub_speed=0.0)
    run = simulate(tool, **PINNED)
    moved = within(float(np.ptp(run.angles)), 1e-12, "moved by", run.cost.steps)
    return all_of(moved, Finding(run.stop_reason, run.stop_reason is StopReason.END))
