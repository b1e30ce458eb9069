"""Results of a run at its strike, and a pass up to there at other values of a tool's keys: a point of maps and sweeps."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from bristle_sim.comparison import amount
from bristle_sim.parameters import Bar, Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.theory.crater_cutting import depth_from_energy
from bristle_sim.theory.merchant import API_5L, specific_cutting_energy
from bristle_sim.trajectory import ContactRecord, Trajectory

STATE = {
    "lag_deg_at_contact": ("lag at the strike", "deg"),
    "relative_speed_at_contact": ("bristle's speed relative to the hub", "rad/s"),
    "tip_speed_at_contact": ("tip speed v_C", "m/s"),
}
"""The bristle's state when it strikes: label and unit of each quantity."""

IMPACT = {
    "normal_compressive_impulse": ("normal impulse of compression p_cy", "N s"),
    "normal_final_impulse": ("normal impulse p_fy", "N s"),
    "tangential_compressive_impulse": ("tangential impulse of compression p_cx", "N s"),
    "normal_compressive_work": ("normal work of compression W_y", "J"),
    "tangential_compressive_work": ("tangential work of compression W_x", "J"),
    "final_bristle_rate": ("bristle's rate after the strike", "rad/s"),
    "rebound_ratio": ("rate after the strike over before", "1"),
}
"""A strike's impulses, works and rates: label and unit of each quantity."""

STRIKE_UNITS = {
    **{name: (STATE | IMPACT)[name][1] for name in (*STATE, "normal_final_impulse", "normal_compressive_work")},
    "crater_depth": "m",
}
"""Units of a cued strike's measures."""

# Lag in degrees below which a bristle counts as radial in words: half a unit of the last digit that is shown
RADIAL = 0.005
# Angle by which the bristle starts before the bar if the bar is in its way 90 degrees before the workpart, rad
CLEAR_OF_BAR = math.radians(5.0)


def state_at_strike(tool: Tool, run: Trajectory, contact: ContactRecord | None) -> dict[str, float | None]:
    """Return the lag, the rate relative to the hub and the tip's speed, in the units of STATE; None without a contact.

    Lag and rate of a wire that bends, whose links vibrate, are those of the line from root to tip.
    """
    if contact is None:
        return dict.fromkeys(STATE)
    lag = run.hub_angle[0] + tool.hub.speed * contact.time - contact.angles[0]
    rate = contact.rates_before[0]
    if tool.bristle.links > 1:
        before = int(abs(run.time - contact.time).argmin())
        (root, tip), (root_velocity, tip_velocity) = (
            each[before, [0, -1]] @ [1.0, 1j] for each in (run.centre_line, run.centre_line_velocity)
        )
        lag = float(np.angle(root * complex(*tool.bristle.tip) * 1j / (tip - root)))
        rate = float(((tip_velocity - root_velocity) / (tip - root)).imag)
    values = math.degrees(lag), rate - tool.hub.speed, math.hypot(*contact.velocity_before)
    return dict(zip(STATE, values, strict=True))


def beside_radial(lag: float) -> str:
    """Return a lag in degrees in words: ``2.74° short of radial``."""
    if abs(lag) < RADIAL:
        return "radial"
    return f"{amount(abs(lag), 'deg')} {'beyond' if lag < 0.0 else 'short of'} radial"


def contact_quantities(contact: ContactRecord | None) -> dict[str, float | None]:
    """Return impulses, works and rates of a contact, in the units of IMPACT; None where its law has none."""
    if contact is None:
        return dict.fromkeys(IMPACT)
    impulse, work = contact.compressive_impulse or (None, None), contact.compressive_work or (None, None)
    before, after = contact.rates_before[0], contact.rates_after[0]
    values = (impulse[0], contact.impulse[0], impulse[1], *work, after, after / before if before else None)
    return dict(zip(IMPACT, values, strict=True))


def outcome_of(contact: ContactRecord | None) -> str:
    """Return the report's word for the end of a contact; a jam is a stiction that no law resolves."""
    if contact is None:
        return "no contact"
    return "stiction" if contact.outcome == "jam" else contact.outcome


def ran(run: Trajectory) -> dict[str, Any]:
    """Return a run's events and cost as fields of a report."""
    events = tuple((event.name, event.time) for event in run.events)
    return {"events": events, "wall_s": run.cost.wall_s, "steps": run.cost.steps}


def resolved(contact: ContactRecord, cost: Any, /, **events: float) -> dict[str, Any]:
    """Return outcome, phases and cost of a single contact, and events by name, s, as fields of a report."""
    fields = {"outcome": outcome_of(contact), "phases": contact.phases, "events": tuple(events.items())}
    return {**fields, "wall_s": cost.wall_s, "steps": cost.steps}


def stopped(run: Trajectory) -> dict[str, Any]:
    """Return why and when a run stopped, and how to make it go further, for the JSON; time in s."""
    reason, time = run.stop_reason, float(run.time[-1])
    return {"reason": str(reason), "time": time, "complete": not reason.gives_up, "remedy": run.stop_advice}


def reference_accuracy(settings: Settings) -> float:
    """Return the accuracy of the independent solution: a tenth of the scene's, 1e-10 at best."""
    return max(1e-10, 0.1 * settings.accuracy)


def require_rigid(tool: Tool) -> None:
    """Refuse a wire that bends, whose lag and speed vibrate."""
    if tool.bristle.links > 1:
        raise ValueError(f"wire_links = {tool.bristle.links}: must be 1, a rigid bristle (dimensionless)")


class GivenUpError(ValueError):
    """The solver gave up a run; the motion that would follow is unknown."""


class NotCuedError(ValueError):
    """The pass has no strike cued by the bar."""


def require_result(run: Trajectory, settings: Settings) -> None:
    """Raise GivenUpError for a run that was given up."""
    if run.stop_reason.gives_up:
        raise GivenUpError(
            f"accuracy = {settings.accuracy:g}: {run.stop_reason} after"
            f" {run.cost.steps} engine steps at {run.time[-1]:g} s; {run.stop_advice}"
        )


def strike_of_keys(
    settings: Settings | None = None, tool: Tool | None = None, /, **values: float
) -> dict[str, float | None]:
    """Return the measures of the strike of a tool at other values of its keys, in the units of STRIKE_UNITS.

    The pass begins 90 degrees before the workpart, or earlier if the bar stands there.

    Raises ValueError if the run is given up, or has no cued strike.
    """
    settings, tool = settings or Settings(), (tool or Tool()).replace(**values)
    run = simulate(tool, settings, start_hub_angle=start_angle(tool), stop_after="strike")
    require_result(run, settings)
    return strike_measures(tool, run)


def full_pass(tool: Tool, bar: Bar, settings: Settings) -> dict[str, Any]:
    """Return lag and relative speed at the strike of a pass with a bar; None where there is none, with the reason."""
    direction = math.degrees(math.atan2(bar.horizontal, bar.vertical))
    row: dict[str, Any] = {"belt_stiffness": tool.belt.stiffness, "bar_direction_deg": direction}
    row |= {"lag_deg_at_contact": None, "relative_speed_at_contact": None}
    try:
        turning = dataclasses.replace(settings, hub_turn=2.0 * math.pi)
        found = strike_of_keys(turning, dataclasses.replace(tool, bar=bar))
    except ValueError as error:
        return row | {"no_strike": str(error)}
    return row | {name: each for name, each in found.items() if name in row}


def start_angle(tool: Tool) -> float:
    """Return an angle of the hub at which a radial bristle is clear of the bar, at most -pi/2, rad."""
    if tool.bar is None:
        raise ValueError("bar = None: must be a Bar, or nothing cues the bristle")
    direction = math.atan2(tool.bar.horizontal, tool.bar.vertical)
    covered = math.asin(min(1.0, tool.bar_reach / math.hypot(*tool.bar.centre)))
    return -max(0.5 * math.pi, direction + covered + CLEAR_OF_BAR)


def strike_measures(tool: Tool, run: Trajectory) -> dict[str, float | None]:
    """Return the measures of the strike of a bristle that the bar has cued; None for those that are unknown.

    Raises NotCuedError if the bristle does not strike, or strikes before it has touched the bar or while it does.
    """
    strike = run.first_contact("workpart")
    if strike is None:
        raise NotCuedError(f"the bristle must strike the workpart, it does not: {run.stop_reason}")
    touches = [each for each in run.contacts if each.obstacle == "bar" and each.time <= strike.time]
    if not touches:
        raise NotCuedError("the bristle must touch the bar before it strikes the workpart")
    if max(each.time + each.duration for each in touches) >= strike.time:
        raise NotCuedError("the bristle must have left the bar when it strikes the workpart")
    found = {**state_at_strike(tool, run, strike), **contact_quantities(strike), "crater_depth": None}
    entry = math.atan2(-strike.velocity_before[0], abs(strike.velocity_before[1]))
    work, friction = strike.compressive_work, tool.workpart.friction if tool.workpart else 0.0
    if work is not None and friction > 0.0 and 0.0 < entry < 0.5 * math.pi:
        found["crater_depth"] = crater_depth(work, friction, entry)
    return {name: found[name] for name in STRIKE_UNITS}


def crater_depth(compressive_work: tuple[float, float], friction: float, entry: float) -> float:
    """Return the crater's depth if its chip takes the energy that the tip gives up in compression, m.

    The tip cuts straight along its velocity, at an angle to the surface, rad, into API 5L steel, the shear plane ending at the
    inclined surface (theory/crater_cutting.py).
    """
    energy = specific_cutting_energy(friction, entry, API_5L, "inclined")
    return float(depth_from_energy(max(0.0, -sum(compressive_work)), energy, entry))
