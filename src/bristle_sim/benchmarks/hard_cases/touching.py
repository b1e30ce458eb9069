"""Several contacts at once, and starts in contact: struck while held, wedged in, pressed on, pulled off, overlapping."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.optimize import brentq

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, refusal, within, worst
from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.tool import simulate, tool_units
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

__all__ = ["between", "cases", "contact_work", "deepest", "wedge_closes"]

THEME = "touching"

TOOL = Tool()
ROOT, LENGTH = TOOL.hub.radius, TOOL.bristle.length

ACCURACY = Settings().accuracy

ROUNDING = 1e-12
"""A bristle at rest moves by no more, in rad; a work that is to be none is no more, of the energies around it."""

SOLVED = 1e-9
"""The engine's iterations leave less of a force."""

CLOSED = 1e-11
"""Share of the bristle's length by which a start may overlap by rounding."""

BUDGET = 20_000

COEFFICIENTS = (
    ("no restitution, no friction", 0.0, 0.0, 0.0, 0.0),
    ("restitution 0.42, friction 0.31", 0.0, 0.2, 0.42, 0.31),
    ("restitution 0.4 and 0.42, friction", 0.4, 0.2, 0.42, 0.31),
    ("restitution 0.9, no friction", 0.0, 0.0, 0.9, 0.0),
)
"""What they are called; restitution and friction of the bar, and of the workpart."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Struck while held, wedged in, pinned, started in contact or overlapping."""
    restitutions = (0.0, 0.3, 0.5, 0.7, 0.9) if full else (0.0, 0.5, 0.9)
    return (
        *(_struck_while_held(*each) for each in COEFFICIENTS),
        *(_wedge(restitution, step) for restitution in restitutions for step in (None, 1e-6)),
        HardCase(
            THEME, "wedged in, restitution 1", f"spends its budget of {BUDGET} steps before the wedge closes", _elastic
        ),
        HardCase(THEME, "pinned by bar and workpart, hub at rest", f"stays to {ROUNDING:g} rad, to the end", _pinned),
        *(case for obstacle in ("workpart", "bar") for case in _starts(obstacle)),
    )


def between(
    hub_angle: float, angle: float, *, at: float = 0.8, bar_gap: float | None = 0.0, gap: float | None = 0.0
) -> Tool:
    """A tool whose bristle, at an absolute angle (rad), has bar and workpart at the given gaps (m), or none of them.

    The bar stands ahead of the wire, ``at`` a share of its length; neither rubs nor restores.
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
    """How far the wire stands in the bar, or the tip in the workpart, at any sample; share of the length."""
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
    """Work of an impact on the bristle, p . (v + v')/2, J; that of a sustained touch is friction's, from its ledger."""
    if contact.law == "hold":
        return sum(contact.compressive_work or ())
    velocities = zip(contact.velocity_before, contact.velocity_after, strict=True)
    return sum(0.5 * p * (u + v) for p, (u, v) in zip(contact.impulse, velocities, strict=True))


def _sound(tool: Tool, run: Trajectory) -> Finding:
    """No contact gives energy, and nothing overlaps."""
    energy = float(run.total_energy.max())
    gained = max([0.0, *(contact_work(contact) for contact in run.contacts)]) / energy
    gain = Finding("energy gained by none" if gained <= ROUNDING else f"energy gained {gained:.2g}", gained <= ROUNDING)
    inside = deepest(tool, run)
    apart = Finding(f"overlap {'to rounding' if inside <= CLOSED else f'{inside:.2g}'}", inside <= ACCURACY)
    return both(gain, apart)


def _struck_while_held(name: str, bar_restitution: float, bar_friction: float, *surface: float) -> HardCase:
    promise = (
        f"strikes and end as in the reference to {ACCURACY:g}, as asked; no energy gained; overlap at most as much of the"
        " length"
    )
    measure = partial(_strike_while_held, bar_restitution, bar_friction, *surface)
    return HardCase(THEME, f"struck while the bar holds it, {name}", promise, measure)


def _strike_while_held(bar_restitution: float, bar_friction: float, restitution: float, friction: float) -> Finding:
    """A near bar and a deep workpart: the bar lets the tip down on it, and in the end folds the bristle."""
    away, direction = 0.054, math.radians(50.0)
    place = {"horizontal": away * math.sin(direction), "vertical": away * math.cos(direction)}
    bar = Bar(radius=0.0034, friction=bar_friction, restitution=bar_restitution, **place)
    part = Workpart(friction, None, restitution, penetration=0.0225)
    tool = replace(TOOL, belt=Belt(3.0 * TOOL.belt.stiffness), bar=bar, workpart=part)
    run, referred = simulate(tool), simulate_reference(tool, accuracy=1e-10)
    unit = tool_units(tool).time
    ends = [each.time + each.duration for each in run.contacts if (each.obstacle, each.law) == ("bar", "hold")]
    strikes = [each for each in run.contacts if each.obstacle == "workpart"]
    struck = [each for each in strikes if any(abs(each.time - end) <= ROUNDING * unit for end in ends)]
    told = Finding(f"{len(struck)} strikes while held, {run.stop_reason}", bool(struck), run.cost.steps)
    off = [float(run.time[-1] - referred.time[-1]), float(run.time[-1]) * (run.stop_reason != referred.stop_reason)]
    times = [contact.time for contact in referred.contacts]
    off += [min((abs(each.time - time) for time in times), default=math.inf) for each in struck[:1]]
    return both(told, within(worst(off) / unit, ACCURACY, "instants off by, in radians,"), _sound(tool, run))


WEDGE = (-0.9, 0.3)
"""Hub angle and angle of a bristle that leans ahead over the workpart, the bar before it, rad."""


def wedge_closes(tool: Tool, start: float) -> float:
    """Time, s, at which a bristle whose tip is on the workpart meets the bar with its flank."""

    def room(hub_angle: float) -> float:
        angle = math.acos((tool.workpart_depth - ROOT * math.cos(hub_angle)) / LENGTH)
        x, y = tool.bar.centre if tool.bar is not None else (math.nan, math.nan)
        x, y = x - ROOT * math.sin(hub_angle), y + ROOT * math.cos(hub_angle)
        return x * math.cos(angle) + y * math.sin(angle) - tool.bar_reach

    return (float(brentq(room, start + 1e-4, start + 0.1, xtol=1e-16)) - start) / tool.hub.speed


def _wedged(restitution: float) -> Tool:
    tool = between(*WEDGE, bar_gap=2e-4, gap=2e-4)
    assert tool.bar is not None
    assert tool.workpart is not None
    bar, part = replace(tool.bar, restitution=restitution), replace(tool.workpart, restitution=restitution)
    return replace(tool, bar=bar, workpart=part)


def _wedge(restitution: float, step: float | None) -> HardCase:
    how = "" if step is None else f", steps of {step:g} s"
    promise = f"jam, by name, when the wedge has closed, to {ACCURACY:g} rad; no energy gained; overlap at most as much"
    name = f"wedged in by bar and workpart, restitution {restitution:g}{how}"
    return HardCase(THEME, name, promise, partial(_jam, restitution, step))


def _jam(restitution: float, step: float | None) -> Finding:
    tool = _wedged(restitution)
    settings = Settings(step=step, maximum_steps=100_000)
    run = simulate(tool, settings, start_hub_angle=WEDGE[0], start_relative_angle=WEDGE[1] - WEDGE[0])
    late = (float(run.time[-1]) - wedge_closes(tool, WEDGE[0])) / tool_units(tool).time
    told = Finding(f"{run.stop_reason} after {len(run.contacts)} contacts", run.stop_reason == "jam", run.cost.steps)
    return both(told, within(late, ACCURACY, "late by"), _sound(tool, run))


def _elastic() -> Finding:
    """Ever faster between two walls: speed times room stays, and no number of rebounds closes the wedge."""
    tool = _wedged(1.0)
    settings = Settings(maximum_steps=BUDGET)
    run = simulate(tool, settings, start_hub_angle=WEDGE[0], start_relative_angle=WEDGE[1] - WEDGE[0])
    left = 1.0 - float(run.time[-1]) / wedge_closes(tool, WEDGE[0])
    told = f"{run.stop_reason} after {len(run.contacts)} contacts, {left:.2g} of the time left"
    return both(Finding(told, run.stop_reason == "step budget spent" and left > 0.0, run.cost.steps), _sound(tool, run))


def _pinned() -> Finding:
    """Ahead of the vertical on the workpart and behind the bar, neither of which the resting hub drives it into."""
    tool = replace(between(-0.3, 0.3, at=0.6), hub=Hub(speed=0.0))
    run = simulate(tool, start_hub_angle=-0.3, start_relative_angle=0.6)
    return both(_stays(run), _sound(tool, run))


def _stays(run: Trajectory) -> Finding:
    moved = within(float(np.ptp(run.angles)), ROUNDING, "moved by", run.cost.steps)
    return both(moved, Finding(run.stop_reason, run.stop_reason == "end of the planned time"))


START = {"workpart": (-0.4, -0.3), "bar": (-0.9, -0.4)}
"""Hub angle and relative angle of bristles that start in contact, behind the radial direction, rad."""


def _alone(obstacle: str, relative: float, *, turning: bool = False, gap: float = 0.0) -> Tool:
    """A tool with one obstacle, touched at the start."""
    hub_angle = START[obstacle][0]
    gaps = {"bar": (gap, None), "workpart": (None, gap)}[obstacle]
    tool = between(hub_angle, hub_angle + relative, bar_gap=gaps[0], gap=gaps[1])
    return tool if turning else replace(tool, hub=Hub(speed=0.0))


def _run(tool: Tool, obstacle: str, relative: float, rate: float = 0.0) -> Trajectory:
    return simulate(
        tool,
        start_hub_angle=START[obstacle][0],
        start_relative_angle=relative,
        start_relative_rate=rate,
    )


def _starts(obstacle: str) -> tuple[HardCase, ...]:
    """In contact, with every way to go on from there, and inside."""
    held = f"stays to {ROUNDING:g} rad, held by the belt's torque over the lever to {SOLVED:g}"
    left = f"leaves without an impulse, as if nothing were there, to {ACCURACY:g}, as asked"
    struck = f"touched at once, with the start's rate, and as in the reference to {ACCURACY:g}, as asked"
    refused = "refused in one clear line that names the keys"
    tried = [
        (f"starts at rest, pressed on the {obstacle}", held, partial(_press, obstacle)),
        (f"starts at rest, pulled off the {obstacle}", left, partial(_pull_off, obstacle)),
        (f"starts on the {obstacle}, moving in", struck, partial(_move_in, obstacle)),
        (f"starts on the {obstacle}, leaving", "no contact at the start", partial(_leave, obstacle)),
        (f"starts 1e-10 of its length inside the {obstacle}", refused, partial(_overlap, obstacle, 1e-10)),
        (f"starts 1e-3 of its length inside the {obstacle}", refused, partial(_overlap, obstacle, 1e-3)),
    ]
    return tuple(HardCase(THEME, *each) for each in tried)


def _press(obstacle: str) -> Finding:
    """The belt turns the bristle on towards its radial direction."""
    hub_angle, relative = START[obstacle]
    tool = _alone(obstacle, relative)
    run = _run(tool, obstacle, relative)
    lever = 0.8 * LENGTH if obstacle == "bar" else LENGTH * abs(math.sin(hub_angle + relative))
    force = tool.belt.stiffness * abs(relative) / lever
    return both(_stays(run), within(float(run.normal_force[-1]) / force - 1.0, SOLVED, "force off by"))


def _pull_off(obstacle: str) -> Finding:
    """Damped, or it would be back to graze after each period."""
    relative = -START[obstacle][1]
    tool = replace(_alone(obstacle, relative), belt=Belt(damping_ratio=0.1))
    run, free = (_run(each, obstacle, relative) for each in (tool, replace(tool, bar=None, workpart=None)))
    impulses = [abs(each) for contact in run.contacts for each in contact.impulse]
    told = Finding("no impulse" if not any(impulses) else f"impulse {max(impulses):.2g}", not any(impulses))
    off = float(run.relative_angle[-1] - free.relative_angle[-1])
    return both(told, within(off, ACCURACY, "apart from the free bristle by, in rad,", run.cost.steps))


def _move_in(obstacle: str) -> Finding:
    hub_angle, relative = START[obstacle]
    tool = _alone(obstacle, relative, turning=True)
    run = _run(tool, obstacle, relative, 100.0)
    referred = simulate_reference(
        tool, start_hub_angle=hub_angle, start_relative_angle=relative, start_relative_rate=100.0, accuracy=1e-10
    )
    first = run.contacts[0]
    told = Finding(f"touched at {first.time:g} s", first.time == 0.0 and first.rates_before == (run.rates[0, 0],))
    off = float(run.relative_angle[-1] - referred.relative_angle[-1])
    return both(told, within(off, ACCURACY, "last angle off by", run.cost.steps), _sound(tool, run))


def _leave(obstacle: str) -> Finding:
    """Turned back relative to the hub faster than the hub turns."""
    relative = START[obstacle][1]
    tool = _alone(obstacle, relative, turning=True)
    run = _run(tool, obstacle, relative, -3.0 * tool.hub.speed)
    first = min((contact.time for contact in run.contacts), default=math.inf)
    touched = "never touched" if math.isinf(first) else f"first touched after {first / tool_units(tool).time:.2g} rad"
    return both(Finding(touched, first > 0.0, run.cost.steps), _sound(tool, run))


def _overlap(obstacle: str, share: float) -> Finding:
    relative = START[obstacle][1]
    tool = _alone(obstacle, relative, gap=-share * LENGTH)
    words = {"workpart": ("penetration =",), "bar": ("bar_horizontal =", "bar_vertical =")}[obstacle]
    return refusal(lambda: _run(tool, obstacle, relative), *words, "allowed", "in m")
