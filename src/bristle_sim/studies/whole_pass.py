"""The whole pass, the trip of one bristle past bar and workpart, compared with the dissertation's
chain of formulas: geometry of the cue, cue time, highest speed, oblique impact.

In the formulas the bar releases the bristle at the retraction that the bar's position permits. The
bristle then swings for a quarter period on its undamped belt, and strikes radially at its highest
speed. A difference between simulation and formulas is a finding, not an error. Only the independent
reference solution must agree within a tolerance.
"""

import math
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np

from bristle_sim.comparison import UNKNOWN, Report, Values, differences, rows
from bristle_sim.dissertation.printed import printed_number
from bristle_sim.parameters import Tool
from bristle_sim.readable import amount
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import ChainStrike
from bristle_sim.settings import Settings, StopReason
from bristle_sim.studies.pass_invariants import invariant_rows, invariants_in_words
from bristle_sim.studies.strike_measures import (
    IMPACT,
    STATE,
    beside_radial,
    contact_quantities,
    impulse_caution,
    outcome_fields,
    state_at_strike,
)
from bristle_sim.theory import cueing
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.trajectory import ContactRecord, Trajectory
from bristle_sim.trajectory.trajectory import course_in_words

LEAST_ERROR = 1e-8
"""Smallest relative error of the motion that the tolerances assume."""

ILL_CONDITIONED = {"release_time": 1e3, "release_retraction_deg": 1e3}
"""Factors by which some quantities magnify an error of the motion.

At the release the wire's end grazes the bar, and the force falls to zero slowly."""

QUANTITIES = {
    "release_time": ("time of release from the bar", "s"),
    "release_retraction_deg": ("retraction at release", "deg"),
    "largest_retraction_deg": ("largest retraction", "deg"),
    "contact_time": ("time of the strike", "s"),
    **STATE,
    **IMPACT,
}

PRINTED = {
    "release_retraction_deg": printed_number("eq. 2.2: retraction angle at release"),
    "relative_speed_at_contact": printed_number("fig. 4.2: rate before the impact"),
    "tip_speed_at_contact": printed_number("eq. 4.3: speed of the tip"),
}


@dataclass(frozen=True, slots=True)
class WholePass:
    """A simulated pass: the trip of one bristle past bar and workpart.

    Attributes:
        tool: the tool.
        trajectory: the simulated motion.
        reference: motion computed by the independent reference solver; None if it was not
            requested.
    """

    tool: Tool
    trajectory: Trajectory
    reference: Trajectory | None


def whole_pass(tool: Tool, settings: Settings, *, with_reference: bool = False) -> Report:
    """Simulate a pass, and compare it with the dissertation's formulas.

    Raises:
        ValueError: if the bristle overlaps an obstacle at the start, or the solver gives up before
            the strike.
    """
    run = simulate(tool, settings)
    reference = None
    referred = UNKNOWN
    within = dict[str, float]()
    contact = run.first_contact("workpart")
    if contact is None:
        require_result(run, settings)
    if with_reference:
        from bristle_sim.reference import simulate_reference

        accuracy = reference_accuracy(settings)
        end = "strike" if tool.contact.duration is None else "workpart release"
        reference = simulate_reference(
            tool, hub_turn=settings.hub_turn, accuracy=accuracy, stop_after=end
        )
        referred = measures_of(tool, reference)
        within = _tolerances(tool, settings, referred)

    measured = measures_of(tool, run)
    found = rows(
        QUANTITIES,
        measured,
        _formulas(tool),
        referred,
        PRINTED if tool == Tool() else UNKNOWN,
        within,
    )
    invariants = invariant_rows(tool, settings, run)
    remarks = [invariants_in_words(invariants), *course_in_words(run)]
    above = (run.cost.error_estimate or 0.0) > settings.accuracy
    if above and not run.accuracy_not_reached:
        remarks.append(
            f"the error estimate is above the requested accuracy {settings.accuracy:g}: request a smaller one"
        )
    if reference is not None and reference.stop_reason.gives_up:
        remarks.append(
            f"the reference gives up at {1e3 * reference.time[-1]:.4f} ms: {reference.stop_reason}"
        )
    if run.stop_reason.gives_up:
        remarks.append(
            f"given up at {1e3 * run.time[-1]:.4f} ms; {run.stop_advice}; the result is valid up to there"
        )
    bends_at_once = tool.bristle.links > 1 and tool.contact.duration is None
    trusted = found
    if contact is not None and impulse_caution(contact, bends_at_once):
        trusted = tuple([each for each in found if each.name in STATE])
    return Report(
        **outcome_fields(contact),
        # An invariant has a row only if it is violated. The comparison then fails.
        quantities=(*found, *[each for each in invariants if each.ok is False]),
        **run_fields(run),
        remarks=tuple(remarks),
        extra={
            "invariants": dict(map(attrgetter("name", "simulated"), invariants)),
            "stopped": stop_fields(run),
        },
        subject=WholePass(tool, run, reference),
        answer=_why_not(tool, run)
        if contact is None
        else _strike_in_words(measured, contact, bends_at_once) + differences(trusted),
    )


def _tolerances(tool: Tool, settings: Settings, referred: Values) -> dict[str, float]:
    """Return the accepted relative differences from the reference solution, by name.

    The tolerances follow from the errors of both motions. ``referred`` are the quantities of the
    reference solution; a quantity that is None has no tolerance.
    """
    within = {}
    for name, value in referred.items():
        if value is not None:
            unit = QUANTITIES[name][1]
            # An angle is the difference of two angles of a few radians, the relative speed that of
            # two rates as large as the hub's.
            size = math.degrees(1.0) if unit == "deg" else 0.0
            if name == "relative_speed_at_contact":
                size = tool.hub.speed
            own = max(LEAST_ERROR, settings.accuracy) * ILL_CONDITIONED.get(name, 10.0)
            within[name] = own * max(1.0, size / abs(value) if value else size)
    return within


def _strike_in_words(measured: Values, contact: ContactRecord, bends_at_once: bool) -> str:
    with_knee = " with its knee" if contact.point == "knee" else ""
    known = {name: value for name, value in measured.items() if value is not None}
    speed = known["relative_speed_at_contact"]
    time = amount(known["contact_time"], "s", 4)
    lag = beside_radial(known["lag_deg_at_contact"])
    tip = amount(known["tip_speed_at_contact"], "m/s")
    impulse = amount(known["normal_final_impulse"], "N s")
    relative = (
        "turning with the hub"
        if abs(speed) < 0.5
        else f"at {amount(speed, 'rad/s')} relative to the hub"
    )
    subject = "The bristle" if measured["release_time"] else "The bristle, which no bar touches,"
    return (
        f"{subject} strikes{with_knee} at {time}, {lag}, {relative}, its tip at {tip}, with a normal impulse of"
        f" {impulse}{impulse_caution(contact, bends_at_once)}; the {contact.point or 'tip'} {contact.outcome_in_words}."
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


def measures_of(tool: Tool, run: Trajectory) -> Values:
    """Return the quantities of a pass, by name.

    A quantity is None if its event did not happen. Extremes and states at events are taken from the
    samples.
    """
    contact = run.first_contact("workpart")
    until = contact.time if contact is not None else math.inf
    ends = (
        each.time + each.duration
        for each in run.contacts
        if each.obstacle == "bar" and each.time <= until
    )
    release = max(ends, default=None)
    retraction = None
    if release is not None:
        retraction = math.degrees(run.retraction[int(abs(run.time - release).argmin())])
    return {
        "release_time": release,
        "release_retraction_deg": retraction,
        "largest_retraction_deg": math.degrees(run.retraction[run.time <= until].max()),
        "contact_time": None if contact is None else contact.time,
        **state_at_strike(tool, run, contact),
        **contact_quantities(contact),
    }


def _formulas(tool: Tool) -> Values:
    """Return the quantities of a pass by the dissertation's formulas, by name.

    The mapping is empty if the formulas do not apply to the tool.
    """
    bristle = tool.bristle
    hub = tool.hub
    bar = tool.bar
    part = tool.workpart
    if (
        bristle.knee_angle_deg
        or bar is None
        or part is None
        or not tool.belt.stiffness
        or not hub.speed
    ):
        return UNKNOWN
    place = (bar.horizontal, bar.vertical, tool.bar_reach)
    try:
        retraction = float(cueing.retraction_at_bar(*place, hub.radius, bristle.length))
        cue = cueing.cue(tool, retraction)
    except ValueError:
        return UNKNOWN
    release = (
        cue.tip_lag - math.atan2(bar.horizontal, bar.vertical) - tool.start_hub_angle
    ) / hub.speed
    rate = cue.highest_relative_speed + hub.speed
    values: Values = {
        "release_time": release,
        "release_retraction_deg": math.degrees(retraction),
        "largest_retraction_deg": math.degrees(retraction),
        "contact_time": release + cue.cue_time,
        "lag_deg_at_contact": 0.0,
        "relative_speed_at_contact": cue.highest_relative_speed,
        "tip_speed_at_contact": bristle.length * rate + hub.radius * hub.speed,
    }
    if not cue.impact_angle > 0.0:
        return values
    wire = (bristle.mass, bristle.length, hub.radius, hub.speed, rate / hub.speed)
    coefficients = (part.friction, part.restitution, part.friction_in_restitution)
    impact = monofilament_impact(*wire, cue.impact_angle, *coefficients)
    return {**values, **{name: float(getattr(impact, name)) for name in IMPACT}}


def run_fields(run: Trajectory) -> dict[str, Any]:
    """Return the fields with which a report describes a run.

    They are the run's events and cost, and a sentence if the run misses the requested accuracy.
    """
    return {
        "not_reached": run.accuracy_not_reached,
        "events": tuple(map(attrgetter("name", "time"), run.events)),
        "wall_s": run.cost.wall_s,
        "steps": run.cost.steps,
    }


def record_fields(struck: ChainStrike, **events: float) -> dict[str, Any]:
    """Return the fields with which a report describes a contact: outcome, phases, cost and events.

    ``events`` are times of events (s), by name.
    """
    return {
        **outcome_fields(struck.contact),
        "events": tuple(events.items()),
        "wall_s": struck.wall_s,
        "steps": struck.steps,
    }


def stop_fields(run: Trajectory) -> dict[str, Any]:
    """Return the fields of the JSON output on how a run ended.

    They are the reason of the end, its time (s), whether the run is complete, and advice on how to
    continue the run.
    """
    return {
        "reason": str(run.stop_reason),
        "time": float(run.time[-1]),
        "complete": not run.stop_reason.gives_up,
        "remedy": run.stop_advice,
    }


def reference_accuracy(settings: Settings) -> float:
    """Return the accuracy requested of the independent reference solution.

    It is a tenth of the simulation's accuracy, but not less than 1e-10.
    """
    return max(1e-10, 0.1 * settings.accuracy)


def require_rigid(tool: Tool) -> None:
    """Check that the wire is rigid.

    Raises:
        ValueError: for a wire of several links, whose vibration makes lag and speed ambiguous.
    """
    if tool.bristle.links > 1:
        raise ValueError(
            f"wire_links = {tool.bristle.links}: must be 1, a rigid bristle (dimensionless)"
        )


class GivenUpError(ValueError):
    """Raised if the solver gave up a run, so that the rest of the motion is unknown."""


def require_result(run: Trajectory, settings: Settings) -> None:
    """Check that the solver did not give up a run with the given settings.

    Raises:
        GivenUpError: if the solver gave up. The message advises how to continue.
    """
    if run.stop_reason.gives_up:
        raise GivenUpError(
            f"accuracy = {settings.accuracy:g}: {run.stop_reason} after"
            f" {run.cost.steps} engine steps at {run.time[-1]:g} s; {run.stop_advice}"
        )
