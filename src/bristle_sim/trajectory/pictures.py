"""Picture, film and summary of a trajectory; the one place that calls the layer which draws, only when a picture is requested."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle_sim.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bristle_sim.trajectory.trajectory import Trajectory

SHOWN = 6  # events that are named

LINES = "white-space:pre-wrap;min-width:0"  # lines of a summary wrap, instead of squeezing the drawing
WIDTH = 260  # width of a summary's drawing, px; its height follows from what it shows


def plot(run: Trajectory, *, until: float | None = None) -> Figure:
    """Draw tool, tip path, retraction, speed and energy; ``until`` is the last instant shown, s."""
    from bristle_sim.render.pass_figure import pass_figure

    return pass_figure(run, run.tool, until=until)


def animate(run: Trajectory, path: str | Path, *, fps: float = 30.0, **options: Any) -> Path:
    """Film the run to an mp4 or gif file; options are those of ``bristle_sim.render.tool_films.PassFilm``."""
    from bristle_sim.render.tool_films import PassFilm

    return PassFilm(run, run.tool, **options).write(path, fps)


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


def summary_page(run: Trajectory) -> str:
    """Return the five lines with a drawing of tip path, wire, hub, bar and workpart, as HTML."""
    from html import escape

    words = escape(summary(run))
    return (
        f'<div style="display:flex;gap:1em;align-items:center">{_drawing(run)}<pre style="{LINES}">{words}</pre></div>'
    )


def _drawing(run: Trajectory) -> str:
    """Draw to scale: the tip's path, the wire when it strikes or at the end, and the tool as far as it is known; SVG."""
    contact = run.first_contact("workpart")
    wire = run.centre_line[-1 if contact is None else int(np.abs(run.time - contact.time).argmin())]
    points = np.concatenate([run.tip, wire])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.05 * max(float((high - low).max()), 1e-9)
    (left, bottom), (right, top) = low - margin, high + margin
    try:
        tool = run.tool
        parts = [f'<circle r="{tool.hub.radius:.6g}" stroke="#999"/>']
        if tool.bar is not None:
            x, y = tool.bar.centre
            parts.append(f'<circle cx="{x:.6g}" cy="{y:.6g}" r="{tool.bar.radius:.6g}" fill="#999"/>')
        if tool.workpart is not None:
            y = -tool.workpart_depth
            parts.append(f'<line x1="-10" y1="{y:.6g}" x2="10" y2="{y:.6g}" stroke="#999"/>')
    except ValueError:
        parts = []
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" style="flex:none" width="{WIDTH}" height="{WIDTH * (top - bottom) / (right - left):.0f}"'
        f' viewBox="{left:.6g} {-top:.6g} {right - left:.6g} {top - bottom:.6g}">'
        f'<g transform="scale(1,-1)" fill="none" stroke-width="{0.25 * margin:.4g}">{"".join(parts)}'
        f'<polyline points="{_pairs(run.tip)}" stroke="#0072b2"/>'
        f'<polyline points="{_pairs(wire)}" stroke="#d55e00"/></g></svg>'
    )


def _pairs(points: Array) -> str:
    return " ".join(f"{x:.6g},{y:.6g}" for x, y in points)
