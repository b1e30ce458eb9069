"""Contacts with both obstacles, and starts in contact: struck while the bar is touched, wedged in, pinned, pressed on, pulled off."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.optimize import brentq

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, row, within
from bristle_sim.benchmarks.hard_cases.contact import WEDGE, between, near_bar, starting_at, wedged
from bristle_sim.benchmarks.hard_cases.measures import ACCURACY, sustained_contacts_of
from bristle_sim.parameters import Belt, Hub, Tool
from bristle_sim.scene.tool import simulate, tool_units
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length

ROUNDING = 1e-12
"""Limit of the motion of a bristle at rest, rad, and of the energy that contacts give, relative to that of the motion."""

SOLVED = 1e-9
"""Limit of the relative error of a force: the engine's iterations leave less."""

SOUND = f"no energy gained; overlap at most {ACCURACY:g} of the length"


def touching() -> list[HardCase]:
    """Return strikes while the bar is touched, wedges, a pinned bristle, and starts in contact."""
    rows, case = [], partial(row, "touching")
    for bar, part, rub, slide in ((0.0, 0.0, 0.0, 0.0), (0.4, 0.42, 0.2, 0.31), (0.0, 0.9, 0.2, 0.31)):
        name = f"struck in contact, restitution {bar:g} and {part:g}, friction {rub:g} and {slide:g}"
        rows.append(
            case(name, f"struck while the bar is touched; {SOUND}", _struck_in_contact, near_bar(bar, rub, part, slide))
        )
    for e in (0.0, 0.5, 0.9):
        promise = f"jam, by name, when the wedge has closed, to {ACCURACY:g} rad; {SOUND}"
        rows.append(case(f"wedge that closes, restitution {e:g}", promise, _jams, e))
    promise = f"remains to {ROUNDING:g} rad, to the end"
    rows.append(case("pinned by bar and workpart, hub at rest", promise, _pinned))
    free = f"leaves without an impulse, as if nothing were there, to {ACCURACY:g}"
    for obstacle in ("workpart", "bar"):
        tried: dict[str, tuple[str, Callable[[str], Finding]]] = {
            "at rest, pressed on": (f"{promise}; its force the belt's torque over the lever to {SOLVED:g}", _press),
            "at rest, pulled off": (free, _pull_off),
            "leaving": ("no contact at the start", _leave),
        }
        rows += [
            case(f"starts {way} the {obstacle}", told, measure, obstacle) for way, (told, measure) in tried.items()
        ]
    return rows


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


def _struck_in_contact(tool: Tool) -> Finding:
    run, unit = simulate(tool), tool_units(tool).time
    ends = [each.time + each.duration for each in sustained_contacts_of(run, "bar")]
    strikes = [each.time for each in run.contacts if each.obstacle == "workpart"]
    struck = [time for time in strikes if any(abs(time - end) <= ROUNDING * unit for end in ends)]
    told = Finding(f"{len(struck)} strikes in contact", bool(struck))
    return all_of(told, _sound(tool, run))


def wedge_closes(tool: Tool, start: float) -> float:
    """Return when a bristle whose tip is on the workpart meets the bar with its flank, s."""

    def gap(hub_angle: float) -> float:
        angle = math.acos((tool.workpart_depth - ROOT * math.cos(hub_angle)) / LENGTH)
        x, y = tool.bar.centre if tool.bar is not None else (math.nan, math.nan)
        x, y = x - ROOT * math.sin(hub_angle), y + ROOT * math.cos(hub_angle)
        return x * math.cos(angle) + y * math.sin(angle) - tool.bar_reach

    return (float(brentq(gap, start + 1e-4, start + 0.1, xtol=1e-16)) - start) / tool.hub.speed


def _jams(restitution: float) -> Finding:
    tool = wedged(restitution)
    run = simulate(tool, Settings(maximum_steps=100_000), **WEDGE)
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


def _press(obstacle: str) -> Finding:
    """The belt turns the bristle towards its radial direction."""
    tool, start = starting_at(obstacle)
    tool = replace(tool, hub=Hub(speed=0.0))
    run = simulate(tool, **start)
    relative = start["start_relative_angle"]
    lever = 0.8 * LENGTH if obstacle == "bar" else LENGTH * abs(math.sin(start["start_hub_angle"] + relative))
    force = tool.belt.stiffness * abs(relative) / lever
    return all_of(_remains(run), within(float(run.normal_force[-1]) / force - 1.0, SOLVED, "force off by"))


def _pull_off(obstacle: str) -> Finding:
    """Damped, or it would be back to graze after each period."""
    tool, start = starting_at(obstacle, side=-1.0)
    tool = replace(tool, hub=Hub(speed=0.0), belt=Belt(damping_ratio=0.1))
    run, free = (simulate(each, **start) for each in (tool, replace(tool, bar=None, workpart=None)))
    impulses = [abs(each) for contact in run.contacts for each in contact.impulse]
    off = float(run.relative_angle[-1] - free.relative_angle[-1])
    return all_of(
        Finding("an impulse" if any(impulses) else "no impulse", not any(impulses)),
        within(off, ACCURACY, "off the free bristle by, in rad,", run.cost.steps),
    )


def _leave(obstacle: str) -> Finding:
    """Turned back relative to the hub faster than the hub turns."""
    tool, start = starting_at(obstacle)
    start = {**start, "start_relative_rate": -3.0 * TOOL.hub.speed}
    run = simulate(tool, **start)
    first = min((contact.time for contact in run.contacts), default=math.inf)
    told = Finding(f"first touched at {first:.2g} s", first > 0.0, run.cost.steps)
    return all_of(told, _sound(tool, run))
