"""The whole pass compared with the dissertation's chain of formulas: cue geometry, cue time, highest speed, oblique impact.

The formulas are applied as in the dissertation: the bar releases the bristle at the retraction that its position permits,
the bristle flies a quarter period of its undamped belt and strikes radially, at its highest speed. Where the simulation
differs from them, that is the finding; only the independent reference has to agree within a tolerance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Tool
from bristle_sim.scene.tool import refuse_endless, simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.pass_invariants import invariant_rows
from bristle_sim.studies.strike_point import (
    CONTACT_UNITS,
    STATE_UNITS,
    contact_quantities,
    require_result,
    state_at_strike,
    stopped,
)
from bristle_sim.theory import cueing
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.trajectory import ContactRecord, Trajectory

PRINTED = {
    "release_retraction_deg": 44.5,
    "relative_speed_at_contact": 845.6,
    "tip_speed_at_contact": 30.0,
}
"""Zhang 2020, eq. 2.2, caption of fig. 2.30, and eq. 4.5."""

LEAST_TOLERANCE = 1e-8
"""Least relative tolerance: the reference runs at a tenth of the scene's accuracy, 1e-10 at best."""

ILL_CONDITIONED = {"release_time": 1e3, "release_retraction_deg": 1e3}
"""Factors by which these magnify an error of the motion: the wire's end grazes the bar, where its force falls to zero at a
small slope."""

ANGLES = ("release_retraction_deg", "largest_retraction_deg", "lag_deg_at_contact")
"""Differences of two angles of some radians."""


@dataclass(frozen=True, slots=True)
class WholePass:
    """A simulated pass, the tool, and the reference's pass if it was requested."""

    tool: Tool
    trajectory: Trajectory
    reference: Trajectory | None


MOST_LINKS = 16
"""Links of a wire in a whole pass, which takes 1,500 n^2 engine steps to the strike and 7,000 n^2 in all, to 1e-6."""


def whole_pass(tool: Tool, settings: Settings, *, with_reference: bool = False) -> Report:
    """Simulate a pass and compare it with the formulas.

    Raises:
        ValueError: if the wire has too many links, the bristle overlaps an obstacle at the start, a fixed step is too short
            for the run, or the run is given up before its strike.
    """
    if tool.bristle.links > MOST_LINKS:
        raise ValueError(
            f"wire_links = {tool.bristle.links}: must be at most {MOST_LINKS} in a whole pass (dimensionless)"
        )
    refuse_endless(tool, settings)
    trajectory = simulate(tool, settings)
    contact = trajectory.first_contact("workpart")
    if contact is None:
        require_result(trajectory, settings)
    reference = None
    if with_reference:
        from bristle_sim.reference import simulate_reference

        reference = simulate_reference(
            tool, hub_turn=settings.hub_turn, accuracy=max(1e-10, 0.1 * settings.accuracy), stop_after="strike"
        )
    return Report(
        outcome=_outcome(contact),
        quantities=(
            *_quantities(tool, settings, trajectory, reference),
            *invariant_rows(tool, settings, trajectory),
        ),
        phases=contact.phases if contact is not None else (),
        events=tuple((event.name, event.time) for event in trajectory.events),
        wall_s=trajectory.cost.wall_s,
        steps=trajectory.cost.steps,
        remarks=_remarks(trajectory),
        extra={"stopped": stopped(trajectory)},
        subject=WholePass(tool, trajectory, reference),
    )


def _outcome(contact: ContactRecord | None) -> str:
    if contact is None:
        return "no contact"
    return "stiction" if contact.outcome == "jam" else contact.outcome


def _quantities(
    tool: Tool, settings: Settings, trajectory: Trajectory, reference: Trajectory | None
) -> tuple[Quantity, ...]:
    simulated, theory = _measured(tool, trajectory), _formulas(tool)
    referred = {} if reference is None else _measured(tool, reference)
    rows = []
    for name, value in simulated.items():
        tolerance = None
        if referred.get(name) is not None:
            tolerance = max(LEAST_TOLERANCE, settings.accuracy) * ILL_CONDITIONED.get(name, 10.0)
            tolerance *= _magnified(tool, name, referred[name])
        printed = PRINTED.get(name) if tool == Tool() else None
        rows.append(Quantity(name, UNITS[name], value, theory.get(name), referred.get(name), printed, tolerance))
    return tuple(rows)


def _magnified(tool: Tool, name: str, value: float | None) -> float:
    """Return the factor by which a small difference of two angles or rates magnifies the relative error of either."""
    size = math.degrees(1.0) if name in ANGLES else tool.hub.speed if name == "relative_speed_at_contact" else 0.0
    return max(1.0, size / abs(value) if value else size)


UNITS = {
    "release_time": "s",
    "release_retraction_deg": "deg",
    "largest_retraction_deg": "deg",
    "contact_time": "s",
    **STATE_UNITS,
    **CONTACT_UNITS,
}


def _measured(tool: Tool, run: Trajectory) -> dict[str, float | None]:
    """Quantities of a run; None for what did not happen."""
    contact = run.first_contact("workpart")
    until = contact.time if contact is not None else math.inf
    touches = [each.time + each.duration for each in run.contacts if each.obstacle == "bar" and each.time <= until]
    release = max(touches, default=None)
    return {
        "release_time": release,
        "release_retraction_deg": None if release is None else -math.degrees(_relative_angle_at(run, release)),
        "largest_retraction_deg": _largest_retraction(run, until),
        "contact_time": None if contact is None else contact.time,
        **state_at_strike(tool, run, contact),
        **contact_quantities(contact),
    }


def _relative_angle_at(run: Trajectory, time: float) -> float:
    """Relative angle at an event, rad: events are samples."""
    return float(run.relative_angle[int(abs(run.time - time).argmin())])


def _largest_retraction(run: Trajectory, until: float) -> float:
    """Largest lag before an instant, deg: extremes are samples."""
    return -math.degrees(float(run.relative_angle[run.time <= until].min()))


def _formulas(tool: Tool) -> dict[str, float | None]:
    """Return the dissertation's chain of formulas for this tool; nothing where they do not apply."""
    if tool.bristle.knee_angle_deg:
        return {}
    if tool.bar is None or tool.workpart is None or not tool.belt.stiffness or not tool.hub.speed:
        return {}
    geometry = (tool.hub.radius, tool.bristle.length)
    try:
        retraction = float(cueing.retraction_at_bar(tool.bar.horizontal, tool.bar.vertical, tool.bar_reach, *geometry))
        cue = cueing.cue(tool, retraction)
    except ValueError:
        return {}
    bar_direction = math.atan2(tool.bar.horizontal, tool.bar.vertical)
    release = (math.pi / 2.0 - bar_direction + cue.tip_lag) / tool.hub.speed
    rate = cue.highest_relative_speed + tool.hub.speed
    impact = (
        monofilament_impact(
            tool.bristle.mass,
            tool.bristle.length,
            tool.hub.radius,
            tool.hub.speed,
            rate / tool.hub.speed,
            cue.impact_angle,
            tool.workpart.friction,
            tool.workpart.restitution,
            tool.workpart.friction_in_restitution,
        )
        if cue.impact_angle > 0.0
        else None
    )
    values: dict[str, float | None] = {
        "release_time": release,
        "release_retraction_deg": math.degrees(retraction),
        "largest_retraction_deg": math.degrees(retraction),
        "contact_time": release + cue.cue_time,
        "lag_deg_at_contact": 0.0,
        "relative_speed_at_contact": cue.highest_relative_speed,
        "tip_speed_at_contact": tool.bristle.length * rate + tool.hub.radius * tool.hub.speed,
    }
    if impact is not None:
        values |= {name: float(getattr(impact, name)) for name in CONTACT_UNITS}
    return values


def _remarks(trajectory: Trajectory) -> tuple[str, ...]:
    cost = trajectory.cost
    estimate = "" if cost.error_estimate is None else f", error estimate {cost.error_estimate:.1e}"
    notable = trajectory.notable_events
    events = ", ".join(f"{event.name} {1e3 * event.time:.4f} ms" for event in notable[:8])
    given_up = (
        f"given up at {1e3 * trajectory.time[-1]:.4f} ms: {trajectory.stop_reason}; {trajectory.stop_advice}; what"
        " happened before holds"
    )
    return (
        f"events: {events}{', ...' if len(notable) > 8 else ''}",
        f"stopped: {trajectory.stop_reason}; {cost.steps} engine steps, {1e3 * cost.cpu_s:.0f} ms of CPU{estimate}",
        *([given_up] if trajectory.stop_reason.gives_up else []),
    )
