"""A run in five lines."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bristle_sim.trajectory.trajectory import Trajectory

SHOWN = 6  # events that are named


def summary(run: Trajectory) -> str:
    """Describe samples, strike, events, why the run stopped, and cost: one line each."""
    first, last = (1e3 * float(instant) for instant in (run.time[0], run.time[-1]))
    notable, contact = run.notable_events, run.first_contact("workpart")
    events = ", ".join(f"{event.name} {1e3 * event.time:.4g} ms" for event in notable[:SHOWN])
    more = f" and {len(notable) - SHOWN} more" if len(notable) > SHOWN else ""
    cost, estimate, strike = run.cost, run.cost.error_estimate, "none"
    if contact is not None:
        before, after = (math.hypot(*velocity) for velocity in (contact.velocity_before, contact.velocity_after))
        speeds = f"tip speed {before:.4g} m/s before and {after:.4g} m/s after"
        strike = f"{contact.outcome} at {1e3 * contact.time:.4g} ms, {speeds}"
    error = "" if estimate is None else f", error estimate {estimate:.1e}"
    lines = (
        f"Trajectory: {run.time.size} samples from {first:.4g} to {last:.4g} ms",
        f"strike: {strike}",
        f"events: {events or 'none'}{more}",
        f"stopped: {run.stop_reason}",
        f"cost: {cost.steps} steps, {1e3 * cost.wall_s:.3g} ms{error}",
    )
    return "\n".join(lines)
