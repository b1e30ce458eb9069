"""Figure, film and notebook views of a run; the methods of :class:`Trajectory` call them."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.render.motion_data import motion_data
from bristle_sim.render.pass_figure import pass_figure
from bristle_sim.render.report import filled
from bristle_sim.trajectory import Trajectory
from bristle_sim.trajectory.pictures import Html

POINTS = 300  # number of points of the tip's path in a summary's drawing, besides the samples
MARGIN = 0.05  # width of the free border of a summary's drawing, as a fraction of its larger extent


def plot(run: Trajectory, until: float | None) -> Figure:
    """Draw a run up to the time ``until``, s.

    If ``until`` is None, the figure ends shortly after the tip has left the workpart.
    """
    return pass_figure(run, run.tool, until=until)


def film(
    run: Trajectory, path: str | Path, fps: float, size: tuple[int, int], options: Mapping[str, Any]
) -> Path:
    """Write a film of a run, and return its path.

    Args:
        run: the run.
        path: an mp4 or gif file.
        fps: number of frames per second.
        size: width and height of the picture, px.
        options: further options of :func:`bristle_sim.render.tool_films.pass_film`.
    """
    from bristle_sim.render.tool_films import pass_film

    return pass_film(run, run.tool, width=size[0], height=size[1], **options).write(path, fps)


def view(run: Trajectory) -> Html:
    """Return an HTML frame for a notebook that shows the motion of a run with a slider.

    The frame's style does not affect the notebook.
    """
    page = filled("report.html.jinja", alone=True, name="run", motion=motion_data(run, run.tool))
    look = 'style="width:100%;height:44rem;border:0" title="motion of the run"'
    return Html(f'<iframe srcdoc="{escape(page)}" {look}></iframe>')


def summary_page(run: Trajectory) -> str:
    """Return the summary of a run as HTML, with a drawing to scale.

    The drawing shows the tip's path, and the wire at the strike or, without a strike, at the end of
    the run. The tool is drawn if the run has its parameters.

    Raises:
        ValueError: if these parameters do not describe a tool.
    """
    contact = run.first_contact("workpart")
    tool = run.tool if "tool" in run.parameters else None
    wire = run.centre_line[-1 if contact is None else int(np.abs(run.time - contact.time).argmin())]
    path = run.course(points=POINTS).tip if run.time[-1] > run.time[0] else run.tip
    points = np.concatenate([path, wire]) * [1.0, -1.0]
    border = MARGIN * np.ptp(points, axis=0).max()
    corner = points.min(axis=0) - border
    box = (*corner, *(points.max(axis=0) + border - corner))
    return filled("summary.html.jinja", run=run, path=path, wire=wire, box=box, tool=tool)
