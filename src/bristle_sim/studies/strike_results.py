"""Results of a run at its strike: lag and speeds before it, impulses, works and rates after it; or why there is none."""

from __future__ import annotations

import math
from typing import Any

from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

STATE_UNITS = {
    "lag_deg_at_contact": "deg",
    "relative_speed_at_contact": "rad/s",
    "tip_speed_at_contact": "m/s",
}
"""Units of the bristle's state when it strikes."""

CONTACT_UNITS = {
    "normal_compressive_impulse": "N s",
    "normal_final_impulse": "N s",
    "tangential_compressive_impulse": "N s",
    "normal_compressive_work": "J",
    "tangential_compressive_work": "J",
    "final_bristle_rate": "rad/s",
    "rebound_ratio": "1",
}
"""Units of a strike's impulses, works and rates."""


def state_at_strike(tool: Tool, run: Trajectory, contact: ContactRecord | None) -> dict[str, float | None]:
    """Return the bristle's lag behind the radial direction, its rate relative to the hub and its tip's speed.

    All in the units of STATE_UNITS; None without a contact.
    """
    if contact is None:
        return dict.fromkeys(STATE_UNITS)
    lag = run.hub_angle[0] + tool.hub.speed * contact.time - contact.angles[0]
    values = (math.degrees(lag), contact.rates_before[0] - tool.hub.speed, math.hypot(*contact.velocity_before))
    return dict(zip(STATE_UNITS, values, strict=True))


def contact_quantities(contact: ContactRecord | None) -> dict[str, float | None]:
    """Return impulses, works and rates of a contact, in the units of CONTACT_UNITS; None where its law has none."""
    if contact is None:
        return dict.fromkeys(CONTACT_UNITS)
    impulse, work = contact.compressive_impulse or (None, None), contact.compressive_work or (None, None)
    before, after = contact.rates_before[0], contact.rates_after[0]
    values = (impulse[0], contact.impulse[0], impulse[1], *work, after, after / before if before else None)
    return dict(zip(CONTACT_UNITS, values, strict=True))


def require_result(run: Trajectory, settings: Settings) -> None:
    """Raise ValueError for a run that was given up."""
    if run.stop_reason.gives_up:
        raise ValueError(
            f"accuracy = {settings.accuracy:g}, step = {settings.step}: {run.stop_reason} after"
            f" {run.cost.steps} engine steps at {run.time[-1]:g} s; {run.stop_advice}"
        )


def stopped(run: Trajectory) -> dict[str, Any]:
    """Return why and when a run stopped, and what would let it go further, for the JSON; time in s."""
    reason = run.stop_reason
    found = {"reason": str(reason), "time": float(run.time[-1]), "complete": not reason.gives_up}
    return {**found, "remedy": run.stop_advice}
