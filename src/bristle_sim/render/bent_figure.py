"""Tip paths of a reverse bent, a straight and a forward bent bristle through the contact zone."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.parameters import Tool
from bristle_sim.render.motion import Motion
from bristle_sim.render.style import BLUE, GREEN, GREY, VERMILION, axes_at, blank_figure, styled
from bristle_sim.studies.bent_bristles import BentBristles
from bristle_sim.trajectory import Trajectory

__all__ = ["bent_figure"]

COLOURS = {"reverse": VERMILION, "straight": BLUE, "forward": GREEN}
NAMES = {"reverse": "reverse bent", "straight": "straight", "forward": "forward bent"}
MILLIMETRES, MICROSECONDS = 1e3, 1e6

BEFORE, AFTER = 0.6e-3, 1.2e-3
"""Time shown around the strike, s."""


@styled()
def bent_figure(bent: BentBristles) -> Figure:
    """Draw wires and tip paths around the strike (mm), and the tips' speed along the workpart in touch (us)."""
    figure = blank_figure(16.0, 13.0)
    paths = axes_at(figure, 1.6, 6.6, 14.0, 6.0)
    speeds = axes_at(figure, 1.6, 1.2, 14.0, 4.2)
    for shape, run in bent.trajectories.items():
        _draw_path(paths, bent.tools[shape], run, shape)
        _draw_speed(speeds, run, shape)
    paths.axhline(0.0, color=GREY, linewidth=1.0)
    paths.set_aspect("equal")
    paths.set_ylim(-1.0, 14.0)
    paths.set_xlabel("along the workpart, from the point of strike (mm)")
    paths.set_ylabel("above the workpart (mm)")
    paths.legend(loc="upper right", frameon=False)
    speeds.axhline(0.0, color=GREY, linewidth=0.6)
    speeds.set_xlabel("time since the strike (µs)")
    speeds.set_ylabel("tip speed along\nthe workpart (m/s)")
    speeds.legend(loc="upper right", frameon=False)
    return figure


def _draw_path(axes: Axes, tool: Tool, run: Trajectory, shape: str) -> None:
    """Tip path around the strike, solid in and after it, and the wire at the strike."""
    contact = run.first_contact("workpart")
    if contact is None:
        return
    motion, colour = Motion(run), COLOURS[shape]
    origin = np.array([np.interp(contact.time, run.time, run.tip[:, 0]), -tool.workpart_depth])
    for first, last, style in ((-BEFORE, 0.0, "--"), (0.0, AFTER, "-")):
        time = contact.time + np.linspace(first, last, 300)
        points = (motion.centre_line(time)[:, -1] - origin) * MILLIMETRES
        axes.plot(*points.T, style, color=colour, label=NAMES[shape] if style == "-" else None, gid=f"path {shape}")
    wire = motion.centre_line(contact.time) - origin
    axes.plot(*(wire.T * MILLIMETRES), color=colour, linewidth=2.4, alpha=0.45, gid=f"wire {shape}")


def _draw_speed(axes: Axes, run: Trajectory, shape: str) -> None:
    contact = run.first_contact("workpart")
    if contact is None or contact.history is None:
        return
    history = contact.history
    time = (history.time - history.time[0]) * MICROSECONDS
    turn = int(np.argmax(history.normal_velocity >= 0.0))
    axes.plot(time, history.tangential_velocity, color=COLOURS[shape], label=NAMES[shape])
    axes.plot(time[turn], history.tangential_velocity[turn], "o", color=COLOURS[shape], markersize=4)
    if shape == "reverse":
        axes.annotate(
            "end of compression", (time[turn], history.tangential_velocity[turn]), (8, 14), textcoords="offset points"
        )
