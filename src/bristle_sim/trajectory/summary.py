"""Summaries of a trajectory: five lines, and for notebooks a small drawing with them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from bristle_sim.arrays import Array

if TYPE_CHECKING:
    from bristle_sim.trajectory.trajectory import Trajectory

SHOWN = 6
"""Events that are named."""

WIDTH = 260
"""Width of the drawing, px; its height follows from what it shows."""


def summary(run: Trajectory) -> str:
    """Describe samples, strike, events, why the run stopped, and cost: one line each."""
    first, last = (1e3 * float(instant) for instant in (run.time[0], run.time[-1]))
    notable = run.notable_events
    events = ", ".join(f"{event.name} {1e3 * event.time:.4g} ms" for event in notable[:SHOWN])
    more = f" and {len(notable) - SHOWN} more" if len(notable) > SHOWN else ""
    cost, estimate = run.cost, run.cost.error_estimate
    error = "" if estimate is None else f", error estimate {estimate:.1e}"
    lines = (
        f"Trajectory: {run.time.size} samples from {first:.4g} to {last:.4g} ms",
        f"strike: {_strike(run)}",
        f"events: {events or 'none'}{more}",
        f"stopped: {run.stop_reason}",
        f"cost: {cost.steps} steps, {1e3 * cost.wall_s:.3g} ms{error}",
    )
    return "\n".join(lines)


def _strike(run: Trajectory) -> str:
    contact = run.first_contact("workpart")
    if contact is None:
        return "none"
    before, after = (math.hypot(*velocity) for velocity in (contact.velocity_before, contact.velocity_after))
    return (
        f"{contact.outcome} at {1e3 * contact.time:.4g} ms, tip speed {before:.4g} m/s before and {after:.4g} m/s after"
    )


def summary_page(run: Trajectory) -> str:
    """Return the five lines with a drawing of tip path, wire, hub, bar and workpart, as HTML."""
    from html import escape

    words = escape(summary(run))
    return f'<div style="display:flex;gap:1em;align-items:center">{_drawing(run)}<pre>{words}</pre></div>'


def _drawing(run: Trajectory) -> str:
    """Draw to scale: the tip's path, the wire when it strikes or at the end, and the tool as far as it is known; SVG."""
    contact = run.first_contact("workpart")
    at = -1 if contact is None else int(np.abs(run.time - contact.time).argmin())
    points = np.concatenate([run.tip, run.centre_line[at]])
    try:
        parts = _parts(run)
    except ValueError:
        parts = []
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.05 * max(float((high - low).max()), 1e-9)
    (left, bottom), (right, top) = low - margin, high + margin
    stroke = f'fill="none" stroke-width="{0.25 * margin:.4g}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{WIDTH * (top - bottom) / (right - left):.0f}"'
        f' viewBox="{left:.6g} {-top:.6g} {right - left:.6g} {top - bottom:.6g}">'
        f'<g transform="scale(1,-1)" {stroke}>{"".join(parts)}'
        f'<polyline points="{_pairs(run.tip)}" stroke="#0072b2"/>'
        f'<polyline points="{_pairs(run.centre_line[at])}" stroke="#d55e00"/></g></svg>'
    )


def _parts(run: Trajectory) -> list[str]:
    """Hub, bar and workpart as SVG."""
    tool = run.tool
    found = [f'<circle r="{tool.hub.radius:.6g}" stroke="#999"/>']
    if tool.bar is not None:
        x, y = tool.bar.centre
        found.append(f'<circle cx="{x:.6g}" cy="{y:.6g}" r="{tool.bar.radius:.6g}" fill="#999"/>')
    if tool.workpart is not None:
        depth = tool.workpart_depth
        found.append(f'<line x1="-10" y1="{-depth:.6g}" x2="10" y2="{-depth:.6g}" stroke="#999"/>')
    return found


def _pairs(points: Array) -> str:
    return " ".join(f"{x:.6g},{y:.6g}" for x, y in points)
