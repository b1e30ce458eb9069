"""Hard cases of lasting contact: infinitely many taps in finite time, and both obstacles at
once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.optimize import brentq

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, refusal, row, within
from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    AS_REFERENCE,
    IMPACT_LAWS,
    Start,
    agrees_with_reference,
    impacts_of,
    is_finite,
)
from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.tool import tool_units
from bristle_sim.settings import Settings, StopReason

TOOL = Tool()
ROOT = TOOL.hub.radius
LENGTH = TOOL.bristle.length

SURFACE = 0.8
"""Angle, rad, at which a falling bristle meets the workpart."""

SLOWEST = 1e-8
"""Speed of a tap that counts as rest, as a fraction of the first tap's speed."""


def chatter() -> Iterator[HardCase]:
    """Yield taps on the bar by a wire on a stiff, damped belt, and falls of a hinged wire on the
    workpart.

    A tap with restitution e leaves the fraction e of the speed, so each hop lasts e times as long
    as the hop before.
    """
    pressed = TOOL.replace(
        belt_stiffness=100.0 * TOOL.belt.stiffness, belt_damping_ratio=0.3, workpart=None
    )
    for e in (0.5, 0.9):
        yield _chatters(
            f"bar, restitution {e:g}",
            pressed.replace(bar_restitution=e),
            "bar",
            e,
            Settings(hub_turn=2.0),
            {},
        )
    fall: Start = {"start_hub_angle": 0.0, "start_relative_angle": SURFACE + 0.01}
    hinge = Tool(Hub(speed=0.0, radius=0.0), Belt(stiffness=0.0), bar=None, gravity=9.81)
    for e, friction in ((0.5, 0.3), (0.9, 0.1)):
        tool = replace(
            hinge, workpart=Workpart(friction, None, e, LENGTH * (1.0 - math.cos(SURFACE)))
        )
        name = f"falls 0.01 rad, restitution {e:g}, friction {friction:g}"
        yield _chatters(name, tool, "workpart", e, Settings(), fall)


def _chatters(
    name: str, tool: Tool, obstacle: str, e: float, settings: Settings, start: Start
) -> HardCase:
    """Return a case that must come to rest within twice the taps that reduce a speed to
    ``SLOWEST``.

    The factor 2 covers the motion between the taps.
    """
    most = math.ceil(2.0 * math.log(SLOWEST) / math.log(e))
    promise = f"at most {most} taps, no energy gained; then in contact"
    return row("chatter", name, promise, _comes_to_rest, tool, obstacle, most, settings, start)


def _comes_to_rest(
    tool: Tool, obstacle: str, most: int, settings: Settings, start: Start
) -> Finding:
    """Return the finding that 2 to ``most`` taps end in sustained contact and that no tap gains
    energy.
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
"""Start of a bristle that leans forward over the workpart, with the bar ahead of it."""

STARTS = {"workpart": (-0.4, -0.3), "bar": (-0.9, -0.4)}
"""Hub angle and relative angle of a bristle that starts in contact, rad.

The bristle starts behind the radial direction."""


def touching() -> Iterator[HardCase]:
    """Yield a strike while the bar is touched, a wedge, and starts in contact or in overlap."""
    case = partial(row, "touching")
    as_reference = AS_REFERENCE.format(ACCURACY)
    # A near bar and a deep workpart: the bar lowers the tip onto the workpart and at last folds the
    # bristle.
    near = {
        "bar_radius": 0.0034,
        "bar_horizontal": 0.0413664,
        "bar_vertical": 0.0347105,
        "penetration": 0.0225,
    }
    both = TOOL.replace(
        belt_stiffness=3.0 * TOOL.belt.stiffness, bar_restitution=0.4, bar_friction=0.2, **near
    )
    yield case(
        "struck while the bar is touched",
        AS_REFERENCE.format(10 * ACCURACY),
        agrees_with_reference,
        both,
        10 * ACCURACY,
    )
    wedge = between(-0.9, 0.3, bar_gap=2e-4, gap=2e-4).replace(bar_restitution=0.5, restitution=0.5)
    promise = f"jam, by name, when the wedge has closed, to {ACCURACY:g} of the scene's time"
    yield case("wedged in, restitution 0.5", promise, _jams, wedge)
    still = "remains to 1e-12 rad, to the end"
    pinned: Start = {"start_hub_angle": -0.3, "start_relative_angle": 0.6}
    resting = between(-0.3, 0.3, at=0.6).replace(hub_speed=0.0)
    yield case("pinned by bar and workpart, hub at rest", still, _remains, resting, pinned)
    for obstacle, words in (
        ("workpart", ("penetration =",)),
        ("bar", ("bar_horizontal =", "bar_vertical =")),
    ):
        tool, start, lever = starting_at(obstacle)
        promise = f"{still}; its force the belt's torque over the lever to 1e-9"
        rests = (tool.replace(hub_speed=0.0), start, lever)
        yield case(f"starts at rest, pressed on the {obstacle}", promise, _remains, *rests)
        into: Start = {**start, "start_relative_rate": 100.0}
        yield case(
            f"starts moving into the {obstacle}",
            as_reference,
            agrees_with_reference,
            tool,
            start=into,
        )
        inside, begin, _ = starting_at(obstacle, gap=-1e-10 * LENGTH)
        name = f"starts 1e-10 of its length inside the {obstacle}"
        run = partial(simulate, inside, **begin)
        yield case(name, "refused in one line that names the keys", refusal, run, *words, "in m")


def between(
    hub_angle: float,
    angle: float,
    *,
    at: float = 0.8,
    bar_gap: float | None = 0.0,
    gap: float | None = 0.0,
) -> Tool:
    """Return a tool with bar and workpart at given gaps (m) from its bristle.

    The bristle stands at the absolute angle ``angle``, the hub at ``hub_angle``, both in rad. The
    bar stands ahead of the wire, at the fraction ``at`` of its length. A gap of None leaves that
    obstacle out. Neither obstacle has friction or restitution.
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


def starting_at(obstacle: str, *, gap: float = 0.0) -> tuple[Tool, Start, float]:
    """Return a tool with one obstacle beside the bristle.

    Args:
        obstacle: ``bar`` or ``workpart``.
        gap: gap between the obstacle and the bristle at the start, m; negative for overlap.

    Returns:
        The tool, its start, and the lever of the contact force about the root, m.
    """
    hub_angle, relative = STARTS[obstacle]
    start: Start = {"start_hub_angle": hub_angle, "start_relative_angle": relative}
    if obstacle == "bar":
        return between(hub_angle, hub_angle + relative, bar_gap=gap, gap=None), start, 0.8 * LENGTH
    tool = between(hub_angle, hub_angle + relative, bar_gap=None, gap=gap)
    return tool, start, LENGTH * abs(math.sin(hub_angle + relative))


def _jams(tool: Tool) -> Finding:
    """Return the finding whether the run of a wedged wire ends with a jam, at the instant of the
    jam.

    The wire jams when its flank meets the bar while the tip is on the workpart.
    """
    assert tool.bar is not None
    begin, (bar_x, bar_y) = WEDGE["start_hub_angle"], tool.bar.centre

    def gap(hub_angle: float) -> float:
        """Return the gap between the wire's flank and the bar, m, while the tip is on the
        workpart."""
        angle = math.acos((tool.workpart_depth - ROOT * math.cos(hub_angle)) / LENGTH)
        x, y = bar_x - ROOT * math.sin(hub_angle), bar_y + ROOT * math.cos(hub_angle)
        return x * math.cos(angle) + y * math.sin(angle) - tool.bar_reach

    closed = brentq(gap, begin + 1e-4, begin + 0.1, xtol=1e-15)
    run = simulate(tool, Settings(maximum_steps=100_000), **WEDGE)
    late = (float(run.time[-1]) - (closed - begin) / tool.hub.speed) / tool_units(tool).time
    named = Finding(
        f"{run.stop_reason} after {len(run.contacts)} contacts", run.stop_reason is StopReason.JAM
    )
    return all_of(
        named, Finding("finite", is_finite(run)), within(late, ACCURACY, "late by", run.cost.steps)
    )


def _remains(tool: Tool, start: Start, lever: float = 0.0) -> Finding:
    """Check that a bristle on a resting hub stays at rest.

    With a lever (m), check too that the contact force balances the belt's torque.
    """
    run = simulate(tool, **start)
    moved = within(float(np.ptp(run.angles)), 1e-12, "moved by", run.cost.steps)
    found = [moved, Finding(run.stop_reason, run.stop_reason is StopReason.END)]
    if lever:
        force = tool.belt.stiffness * abs(start["start_relative_angle"]) / lever
        found.append(within(float(run.normal_force[-1]) / force - 1.0, 1e-9, "force off by"))
    return all_of(*found)
