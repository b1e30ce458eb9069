"""Pictures that a run gives of itself: figure, film, and the drawings that a notebook shows."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.render.pass_figure import pass_figure
from bristle_sim.trajectory import Trajectory
from bristle_sim.trajectory.pictures import Html

LINES = "white-space:pre-wrap;min-width:0"  # lines of a summary wrap, instead of squeezing the drawing
WIDTH = 260  # width of a summary's drawing, px; its height follows from its content


def plot(run: Trajectory, until: float | None) -> Figure:
    """Draw a run up to an instant, s, or to the end of its story."""
    return pass_figure(run, run.tool, until=until)


def film(run: Trajectory, path: str | Path, fps: float, size: tuple[int, int], options: Mapping[str, Any]) -> Path:
    """Film a run, with frames a second and a size in px."""
    from bristle_sim.render.tool_films import pass_film

    return pass_film(run, run.tool, width=size[0], height=size[1], **options).write(path, fps)


def view(run: Trajectory) -> Html:
    """Return the motion with a slider."""
    from bristle_sim.render.report import view_page

    return Html(view_page(run))


def summary_page(run: Trajectory) -> str:
    """Return the summary as HTML, beside it to scale the tip's path, the wire at the strike or the end, and the known tool."""
    contact = run.first_contact("workpart")
    wire = run.centre_line[-1 if contact is None else int(np.abs(run.time - contact.time).argmin())]
    points = np.concatenate([run.tip, wire])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.05 * max(float((high - low).max()), 1e-9)
    (left, bottom), (right, top) = low - margin, high + margin
    parts = []
    try:
        tool = run.tool
        parts.append(f'<circle r="{tool.hub.radius:.6g}" stroke="#999"/>')
        if tool.bar is not None:
            x, y = tool.bar.centre
            parts.append(f'<circle cx="{x:.6g}" cy="{y:.6g}" r="{tool.bar.radius:.6g}" fill="#999"/>')
        if tool.workpart is not None:
            y = -tool.workpart_depth
            parts.append(f'<line x1="-10" y1="{y:.6g}" x2="10" y2="{y:.6g}" stroke="#999"/>')
    except ValueError:
        pass  # a run of something else has no tool to draw
    return (
        f'<div style="display:flex;gap:1em;align-items:center"><svg xmlns="http://www.w3.org/2000/svg"'
        f' style="flex:none" width="{WIDTH}" height="{WIDTH * (top - bottom) / (right - left):.0f}"'
        f' viewBox="{left:.6g} {-top:.6g} {right - left:.6g} {top - bottom:.6g}">'
        f'<g transform="scale(1,-1)" fill="none" stroke-width="{0.25 * margin:.4g}">{"".join(parts)}'
        f'<polyline points="{_pairs(run.tip)}" stroke="#0072b2"/>'
        f'<polyline points="{_pairs(wire)}" stroke="#d55e00"/></g></svg>'
        f'<pre style="{LINES}">{escape(repr(run))}</pre></div>'
    )


def _pairs(points: Array) -> str:
    return " ".join(f"{x:.6g},{y:.6g}" for x, y in points)
