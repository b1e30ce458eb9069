"""Contacts with both obstacles, and starts in contact: struck while the bar is touched, wedged in, pinned, pressed on, pulled off."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import brentq

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, refusal, within
from bristle_sim.benchmarks.hard_cases.measures import ACCURACY, Start, agrees_with_reference, sustained_contacts_of
from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.scene.tool import simulate, tool_units
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

__all__ = ["WEDGE", "between", "contact_work", "deepest", "touching", "wedge_closes", "wedged"]

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length

ROUNDING = 1e-12
"""Limit of the motion of a bristle at rest, rad, and of the energy that contacts give, relative to that of the motion."""

SOLVED = 1e-9
"""Limit of the relative error of a force: the engine's iterations leave less."""

WEDGE: Start = {"start_hub_angle": -0.9, "start_relative_angle": 1.2}
"""Start of a bristle that leans ahead over the workpart, the bar before it."""

SOUND = f"no energy gained; overlap at most {ACCURACY:g} of the length"

STARTS = {"workpart": (-0.4, -0.3), "bar": (-0.9, -0.4)}
"""Hub angle and relative angle of bristles that start in contact, behind the radial direction, rad."""


def touching() -> list[HardCase]:
    """Return strikes while the bar is touched, wedges, a pinned bristle, and starts in contact or overlapping."""
    rows = []
    for bar, part in ((0.0, 0.0), (0.4, 0.42), (0.0, 0.9)):
        for rub, slide in ((0.0, 0.0), (0.2, 0.31)):
            name = f"struck while the bar is touched, restitution {bar:g} and {part:g}, friction {rub:g} and {slide:g}"
            promise = (
                f"end and strike as in the reference to {10 * ACCURACY:g}, ten times the requested accuracy; {SOUND}"
            )
            rows.append(HardCase("touching", name, promise, partial(_struck_in_contact, bar, rub, part, slide)))
    for e in (0.0, 0.3, 0.5, 0.7, 0.9):
        for step in (None, 1e-6):
            promise = f"jam, by name, when the wedge has closed, to {ACCURACY:g} rad; {SOUND}"
            name = f"wedged in, restitution {e:g}" + (f", steps of {step:g} s" if step else "")
            rows.append(HardCase("touching", name, promise, partial(_jams, e, step), e in (0.0, 0.5, 0.9)))
    promise = f"remains to {ROUNDING:g} rad, to the end"
    rows.append(HardCase("touching", "pinned by bar and workpart, hub at rest", promise, _pinned))
    free = f"leaves without an impulse, as if nothing were there, to {ACCURACY:g}"
    begun = f"as in the reference to {ACCURACY:g}, the requested accuracy, and touched at once"
    for obstacle in STARTS:
        tried: dict[str, tuple[str, Callable[[str], Finding]]] = {
            "at rest, pressed on": (f"{promise}; its force the belt's torque over the lever to {SOLVED:g}", _press),
            "at rest, pulled off": (free, _pull_off),
            "moving into": (begun, _move_in),
            "leaving": ("no contact at the start", _leave),
            "1e-10 of its length inside": ("refused in one line that names the keys", partial(_overlap, 1e-10)),
            "1e-3 of its length inside": ("refused in one line that names the keys", partial(_overlap, 1e-3)),
        }
        rows += [
            HardCase("touching", f"starts {way} the {obstacle}", promise, partial(measure, obstacle))
            for way, (promise, measure) in tried.items()
        ]
    return rows


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


def deepest(tool: Tool, run: Trajectory) -> float:
    """Return how far the wire overlaps the bar, or the tip the workpart, at any sample, in lengths of the bristle."""
    hub, wire = (np.stack([np.sin(angle), -np.cos(angle)], axis=1) for angle in (run.hub_angle, run.angles[:, 0]))
    gaps = [0.0]
    if tool.bar is not None:
        to_bar = np.array(tool.bar.centre) - tool.hub.radius * hub
        along = np.clip((to_bar * wire).sum(axis=1), 0.0, tool.bristle.length)
        gaps.append(float(np.linalg.norm(to_bar - along[:, None] * wire, axis=1).min()) - tool.bar_reach)
    if tool.workpart is not None:
        gaps.append(float(run.tip[:, 1].min()) + tool.workpart_depth)
    return -min(gaps) / tool.bristle.length


def contact_work(contact: ContactRecord) -> float:
    """Return the work of an impact on the bristle, p . (v + v')/2, or of friction in a sustained contact, J."""
    if contact.law not in ("energetic", "compliant", "engine"):
        return sum(contact.compressive_work or ())
    velocities = zip(contact.velocity_before, contact.velocity_after, strict=True)
    return sum(0.5 * p * (u + v) for p, (u, v) in zip(contact.impulse, velocities, strict=True))


def _sound(tool: Tool, run: Trajectory) -> Finding:
    """Return whether no contact gives energy, and nothing overlaps."""
    gained = max([0.0, *(contact_work(contact) for contact in run.contacts)]) / float(run.total_energy.max())
    return all_of(within(gained, ROUNDING, "gained"), within(max(0.0, deepest(tool, run)), ACCURACY, "overlap"))


def _struck_in_contact(bar_restitution: float, rub: float, restitution: float, slide: float) -> Finding:
    """A near bar and a deep workpart: the bar lets the tip down on it, and in the end folds the bristle."""
    away, direction = 0.054, math.radians(50.0)
    x, y = away * math.sin(direction), away * math.cos(direction)
    bar = Bar(radius=0.0034, friction=rub, restitution=bar_restitution, horizontal=x, vertical=y)
    part = Workpart(slide, None, restitution, penetration=0.0225)
    tool = replace(TOOL, belt=Belt(3.0 * TOOL.belt.stiffness), bar=bar, workpart=part)
    run, unit = simulate(tool), tool_units(tool).time
    ends = [each.time + each.duration for each in sustained_contacts_of(run, "bar")]
    strikes = [each.time for each in run.contacts if each.obstacle == "workpart"]
    struck = [time for time in strikes if any(abs(time - end) <= ROUNDING * unit for end in ends)]
    told = Finding(f"{len(struck)} strikes in contact", bool(struck))
    return all_of(told, agrees_with_reference(tool, 10 * ACCURACY), _sound(tool, run))


def wedge_closes(tool: Tool, start: float) -> float:
    """Return when a bristle whose tip is on the workpart meets the bar with its flank, s."""

    def gap(hub_angle: float) -> float:
        angle = math.acos((tool.workpart_depth - ROOT * math.cos(hub_angle)) / LENGTH)
        x, y = tool.bar.centre if tool.bar is not None else (math.nan, math.nan)
        x, y = x - ROOT * math.sin(hub_angle), y + ROOT * math.cos(hub_angle)
        return x * math.cos(angle) + y * math.sin(angle) - tool.bar_reach

    return (float(brentq(gap, start + 1e-4, start + 0.1, xtol=1e-16)) - start) / tool.hub.speed


def wedged(restitution: float) -> Tool:
    """Return a tool whose bar and workpart close in on the bristle."""
    tool = between(-0.9, 0.3, bar_gap=2e-4, gap=2e-4)
    parts: dict[str, Any] = {
        each: replace(getattr(tool, each), restitution=restitution) for each in ("bar", "workpart")
    }
    return replace(tool, **parts)


def _jams(restitution: float, step: float | None) -> Finding:
    tool = wedged(restitution)
    run = simulate(tool, Settings(step=step, maximum_steps=100_000), **WEDGE)
    late = (float(run.time[-1]) - wedge_closes(tool, WEDGE["start_hub_angle"])) / tool_units(tool).time
    told = Finding(f"{run.stop_reason} after {len(run.contacts)} contacts", run.stop_reason == "jam", run.cost.steps)
    return all_of(told, within(late, ACCURACY, "late by"), _sound(tool, run))


def _pinned() -> Finding:
    """Ahead of the vertical on the workpart and behind the bar, neither of which the resting hub drives it into."""
    tool = replace(between(-0.3, 0.3, at=0.6), hub=Hub(speed=0.0))
    run = simulate(tool, start_hub_angle=-0.3, start_relative_angle=0.6)
    return all_of(_remains(run), _sound(tool, run))


def _remains(run: Trajectory) -> Finding:
    moved = within(float(np.ptp(run.angles)), ROUNDING, "moved by", run.cost.steps)
    return all_of(moved, Finding(run.stop_reason, run.stop_reason == "end of the planned time"))


def _alone(
    obstacle: str, *, side: float = 1.0, turning: bool = False, gap: float = 0.0, rate: float = 0.0
) -> tuple[Tool, Start]:
    """Return a tool with one obstacle, touched at the start or off it by a gap, and the start; ``side`` -1 leans ahead."""
    hub_angle, relative = STARTS[obstacle][0], side * STARTS[obstacle][1]
    bar_gap, part_gap = (gap, None) if obstacle == "bar" else (None, gap)
    tool = between(hub_angle, hub_angle + relative, bar_gap=bar_gap, gap=part_gap)
    start: Start = {"start_hub_angle": hub_angle, "start_relative_angle": relative, "start_relative_rate": rate}
    return tool if turning else replace(tool, hub=Hub(speed=0.0)), start


def _press(obstacle: str) -> Finding:
    """The belt turns the bristle towards its radial direction."""
    tool, start = _alone(obstacle)
    run = simulate(tool, **start)
    relative = start["start_relative_angle"]
    lever = 0.8 * LENGTH if obstacle == "bar" else LENGTH * abs(math.sin(start["start_hub_angle"] + relative))
    force = tool.belt.stiffness * abs(relative) / lever
    return all_of(_remains(run), within(float(run.normal_force[-1]) / force - 1.0, SOLVED, "force off by"))


def _pull_off(obstacle: str) -> Finding:
    """Damped, or it would be back to graze after each period."""
    tool, start = _alone(obstacle, side=-1.0)
    tool = replace(tool, belt=Belt(damping_ratio=0.1))
    run, free = (simulate(each, **start) for each in (tool, replace(tool, bar=None, workpart=None)))
    impulses = [abs(each) for contact in run.contacts for each in contact.impulse]
    off = float(run.relative_angle[-1] - free.relative_angle[-1])
    return all_of(
        Finding("an impulse" if any(impulses) else "no impulse", not any(impulses)),
        within(off, ACCURACY, "off the free bristle by, in rad,", run.cost.steps),
    )


def _move_in(obstacle: str) -> Finding:
    tool, start = _alone(obstacle, turning=True, rate=100.0)
    run = simulate(tool, **start)
    first = run.contacts[0]
    told = Finding(f"touched at {first.time:g} s", first.time == 0.0 and first.rates_before == (run.rates[0, 0],))
    return all_of(told, agrees_with_reference(tool, start=start), _sound(tool, run))


def _leave(obstacle: str) -> Finding:
    """Turned back relative to the hub faster than the hub turns."""
    tool, start = _alone(obstacle, turning=True, rate=-3.0 * TOOL.hub.speed)
    run = simulate(tool, **start)
    first = min((contact.time for contact in run.contacts), default=math.inf)
    told = Finding(f"first touched at {first:.2g} s", first > 0.0, run.cost.steps)
    return all_of(told, _sound(tool, run))


def _overlap(part: float, obstacle: str) -> Finding:
    tool, start = _alone(obstacle, gap=-part * LENGTH)
    words = {"workpart": ("penetration =",), "bar": ("bar_horizontal =", "bar_vertical =")}[obstacle]
    return refusal(lambda: simulate(tool, **start), *words, "in m")
