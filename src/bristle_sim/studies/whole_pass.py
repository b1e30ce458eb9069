"""The whole pass compared with the dissertation's chain of formulas: cue geometry, cue time, highest speed, oblique impact.

By the formulas the bar releases the bristle at the retraction that its position permits; the bristle flies a quarter period of
its undamped belt and strikes radially, at its highest speed. Where the simulation differs, that is the finding; only the
independent reference has to agree within a tolerance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bristle_sim.comparison import UNKNOWN, Report, Values, amount, differences, rows
from bristle_sim.dissertation.printed import printed_number
from bristle_sim.parameters import Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings, StopReason
from bristle_sim.studies import strike_point
from bristle_sim.studies.pass_invariants import invariant_rows, invariants_in_words
from bristle_sim.theory import cueing
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.trajectory import Trajectory

LEAST_ERROR = 1e-8
"""Least relative error of the motion that is expected; the reference runs at a tenth of the scene's accuracy, 1e-10 at best."""

ILL_CONDITIONED = {"release_time": 1e3, "release_retraction_deg": 1e3}
"""Factors by which these magnify an error of the motion: the wire's end grazes the bar, where its force falls to zero at a
small slope."""

QUANTITIES = {
    "release_time": ("time of release from the bar", "s"),
    "release_retraction_deg": ("retraction at release", "deg"),
    "largest_retraction_deg": ("largest retraction", "deg"),
    "contact_time": ("time of the strike", "s"),
    **strike_point.STATE,
    **strike_point.IMPACT,
}

PRINTED = {
    "release_retraction_deg": printed_number("eq. 2.2: retraction angle at release"),
    "relative_speed_at_contact": printed_number("fig. 4.2: rate before the impact"),
    "tip_speed_at_contact": printed_number("eq. 4.3: speed of the tip"),
}


@dataclass(frozen=True, slots=True)
class WholePass:
    """A simulated pass, the tool, and the reference's pass if it was requested."""

    tool: Tool
    trajectory: Trajectory
    reference: Trajectory | None


def whole_pass(tool: Tool, settings: Settings, *, with_reference: bool = False) -> Report:
    """Simulate a pass and compare it with the formulas.

    Raises ValueError if the bristle overlaps an obstacle at the start, or the run is given up before its strike.
    """
    run, reference, referred = simulate(tool, settings), None, UNKNOWN
    contact, cost = run.first_contact("workpart"), run.cost
    if contact is None:
        strike_point.require_result(run, settings)
    if with_reference:
        from bristle_sim.reference import simulate_reference

        accuracy = strike_point.reference_accuracy(settings)
        reference = simulate_reference(tool, hub_turn=settings.hub_turn, accuracy=accuracy, stop_after="strike")
        referred = _measured(tool, reference)

    def tolerance(name: str) -> float | None:
        value, unit = referred.get(name), QUANTITIES[name][1]
        if value is None:
            return None
        # Angles are differences of two of some radians, the relative speed one of rates of the hub's size.
        size = math.degrees(1.0) if unit == "deg" else tool.hub.speed if name == "relative_speed_at_contact" else 0.0
        own = max(LEAST_ERROR, settings.accuracy) * ILL_CONDITIONED.get(name, 10.0)
        return own * max(1.0, size / abs(value) if value else size)

    measured = _measured(tool, run)
    found = rows(QUANTITIES, measured, _formulas(tool), referred, PRINTED if tool == Tool() else UNKNOWN, tolerance)
    invariants = invariant_rows(tool, settings, run)
    notable = [f"{event.name} {1e3 * event.time:.4f} ms" for event in run.notable_events]
    estimate = "" if cost.error_estimate is None else f", error estimate {cost.error_estimate:.1e}"
    estimate += "" if cost.holds_until is None else f" that holds up to {1e3 * cost.holds_until:.4g} ms"
    remarks = [
        invariants_in_words(invariants),
        f"events: {', '.join(notable[:8])}{', ...' if len(notable) > 8 else ''}",
        f"stopped: {run.stop_reason}; {cost.steps} engine steps, {1e3 * cost.cpu_s:.0f} ms of CPU{estimate}",
    ]
    if run.stop_reason.gives_up:
        remarks.append(f"given up at {1e3 * run.time[-1]:.4f} ms; {run.stop_advice}; what happened before holds")
    return Report(
        outcome=strike_point.outcome_of(contact),
        # Only an invariant that is violated takes a row, with which the comparison fails.
        quantities=(*found, *(each for each in invariants if each.ok is False)),
        phases=contact.phases if contact is not None else (),
        **strike_point.ran(run),
        remarks=tuple(remarks),
        extra={"invariants": {each.name: each.simulated for each in invariants}, "stopped": strike_point.stopped(run)},
        subject=WholePass(tool, run, reference),
        answer=_why_not(tool, run)
        if contact is None
        else _strike_in_words(measured, strike_point.outcome_of(contact)) + differences(found),
    )


def _strike_in_words(measured: Values, outcome: str) -> str:
    names = ("contact_time", *strike_point.STATE, "normal_final_impulse")
    time, lag, speed, tip, impulse = (measured[name] or 0.0 for name in names)
    relative = "turning with the hub" if abs(speed) < 0.5 else f"at {amount(speed, 'rad/s')} relative to the hub"
    by_bar = "" if measured["release_time"] else ", not released by a bar"
    return (
        f"The bristle strikes at {amount(time, 's', 4)}{by_bar}, {strike_point.beside_radial(lag)}, {relative}, its tip at"
        f" {amount(tip, 'm/s')}, with a normal impulse of {amount(impulse, 'N s')} ({outcome})."
    )


def _why_not(tool: Tool, run: Trajectory) -> str:
    ended = str(run.stop_reason)
    if run.stop_reason is StopReason.RETRACTION_LIMIT:
        ended = f"it folds back by {math.degrees(float(np.abs(run.relative_angle).max())):.0f}°"
    reason = f"{ended} at {amount(float(run.time[-1]), 's', 4)}; {run.stop_advice}"
    if tool.workpart is None:
        reason = "the tool has no workpart"
    elif run.stop_reason is StopReason.END:
        reason = f"its tip stays {amount(tool.workpart_depth + float(run.tip[:, 1].min()), 'm')} above it"
    return f"The bristle does not strike the workpart: {reason}."


def _measured(tool: Tool, run: Trajectory) -> Values:
    """Return the quantities of a run, None for events that did not happen; events and extremes are samples."""
    contact = run.first_contact("workpart")
    until = contact.time if contact is not None else math.inf
    touches = [each.time + each.duration for each in run.contacts if each.obstacle == "bar" and each.time <= until]
    release, retraction = max(touches, default=None), None
    if release is not None:
        retraction = math.degrees(run.retraction[int(abs(run.time - release).argmin())])
    return {
        "release_time": release,
        "release_retraction_deg": retraction,
        "largest_retraction_deg": math.degrees(run.retraction[run.time <= until].max()),
        "contact_time": None if contact is None else contact.time,
        **strike_point.state_at_strike(tool, run, contact),
        **strike_point.contact_quantities(contact),
    }


def _formulas(tool: Tool) -> Values:
    """Return the dissertation's chain of formulas for this tool; nothing where they do not apply."""
    bristle, hub, bar, part = tool.bristle, tool.hub, tool.bar, tool.workpart
    if bristle.knee_angle_deg or bar is None or part is None or not tool.belt.stiffness or not hub.speed:
        return UNKNOWN
    geometry = (hub.radius, bristle.length)
    try:
        retraction = float(cueing.retraction_at_bar(bar.horizontal, bar.vertical, tool.bar_reach, *geometry))
        cue = cueing.cue(tool, retraction)
    except ValueError:
        return UNKNOWN
    release = (math.pi / 2.0 - math.atan2(bar.horizontal, bar.vertical) + cue.tip_lag) / hub.speed
    rate = cue.highest_relative_speed + hub.speed
    tip_speed = bristle.length * rate + hub.radius * hub.speed
    retractions = [math.degrees(retraction)] * 2
    chain = (release, *retractions, release + cue.cue_time, 0.0, cue.highest_relative_speed, tip_speed)
    values: Values = dict(zip(QUANTITIES, chain, strict=False))
    if not cue.impact_angle > 0.0:
        return values
    wire, ratio = (bristle.mass, bristle.length, hub.radius, hub.speed), rate / hub.speed
    coefficients = (part.friction, part.restitution, part.friction_in_restitution)
    impact = monofilament_impact(*wire, ratio, cue.impact_angle, *coefficients)
    return {**values, **{name: float(getattr(impact, name)) for name in strike_point.IMPACT}}
