"""A labelled drawing of a strike that shows axes, angles and signs: python -m bristle_sim.render.strike_drawing FILE."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LIGHT,
    VERMILION,
    axes_at,
    blank_figure,
    save_figure,
    styled,
)
from bristle_sim.render.tool_drawing import MILLIMETRES, toward

HUB_ANGLE, LAG = math.radians(-20.0), math.radians(12.0)
"""Of the root from the workpart's direction, and of the wire behind the radial direction: larger than at the operating
point, so that both can be seen, rad."""

LETTERS = 7.5


@styled()
def strike_drawing(tool: Tool | None = None) -> Figure:
    """Draw hub, wire and workpart at the instant of a strike, with the names and positive directions of all quantities."""
    tool = tool or Tool()
    radius, length = tool.hub.radius * MILLIMETRES, tool.bristle.length * MILLIMETRES
    figure = blank_figure(16.0, 9.5)
    axes = axes_at(figure, 0.0, 0.0, 16.0, 9.5)
    axes.set_axis_off()
    root = radius * toward(HUB_ANGLE)
    tip = root + length * toward(HUB_ANGLE - LAG)
    axes.set_xlim(-72.0, 40.0)
    axes.set_ylim(tip[1] - 12.0, tip[1] - 12.0 + 112.0 * 9.5 / 16.0)
    axes.axhspan(tip[1] - 20.0, tip[1], facecolor=LIGHT, edgecolor=GREY, linewidth=0.8)
    axes.add_patch(Circle((0.0, 0.0), radius, facecolor="#f3f3f3", edgecolor=GREY))
    axes.plot([0.0, 0.0], [0.0, tip[1]], color=GREY, linewidth=0.8, dashes=(5, 3))
    axes.plot(
        *np.array([[0.0, 0.0], root + 1.02 * length * toward(HUB_ANGLE)]).T, color=GREY, linewidth=0.8, dashes=(5, 3)
    )
    axes.plot(*np.array([root, tip]).T, color=BLUE, linewidth=3.0, solid_capstyle="butt")
    axes.plot(*root, "o", color=GREEN, markersize=5)
    _angles(axes, radius, root)
    _motion(axes, radius)
    _impact(axes, tip)
    _penetration(axes, tool, tip)
    return figure


def _say(axes: Axes, x: float, y: float, words: str, color: str = BLACK, side: str = "left") -> None:
    axes.text(x, y, words, color=color, fontsize=LETTERS, ha=side, va="center")


def _arrow(axes: Axes, start: tuple[float, float], step: tuple[float, float], color: str, style: str = "-|>") -> None:
    end = (start[0] + step[0], start[1] + step[1])
    axes.annotate("", end, start, arrowprops={"arrowstyle": style, "color": color, "shrinkA": 0, "shrinkB": 0})


def _angles(axes: Axes, radius: float, root: Array) -> None:
    """The hub's angle at its centre, and the lag at the root."""
    below = -90.0
    hub, wire = below + math.degrees(HUB_ANGLE), below + math.degrees(HUB_ANGLE - LAG)
    axes.add_patch(Arc((0.0, 0.0), 1.1 * radius, 1.1 * radius, theta1=hub, theta2=below, color=BLACK))
    axes.add_patch(Arc((root[0], root[1]), 32.0, 32.0, theta1=wire, theta2=hub, color=BLACK))
    _say(axes, 1.2, -0.62 * radius, "hub angle, negative\nbefore the root is lowest")
    _say(axes, root[0] - 6.5, root[1] - 6.0, "retraction: positive\nwhere the wire lags", side="right")
    _say(axes, root[0] - 2.0, root[1] + 1.5, "root, in the belt", GREEN, "right")
    _say(axes, 0.8, root[1] - 7.0, "angle 0: from the hub's\ncentre to the workpart", GREY)


def _motion(axes: Axes, radius: float) -> None:
    """How the hub turns, and the axes."""
    ends = 0.74 * radius * toward(np.radians([50.0, 95.0]))
    style = "-|>,head_length=5,head_width=2.5"
    axes.add_patch(FancyArrowPatch(*ends, arrowstyle=style, connectionstyle="arc3,rad=0.25", color=BLACK))
    _say(axes, 1.5, -0.12 * radius, "hub speed, rates:\npositive this way")
    corner = (-66.0, -18.0)
    _arrow(axes, corner, (9.0, 0.0), BLACK)
    _arrow(axes, corner, (0.0, 9.0), BLACK)
    _say(axes, corner[0] + 9.5, corner[1], "x, tangential: as the tip travels")
    _say(axes, corner[0] - 1.0, corner[1] + 10.8, "y, normal: out of the workpart")


def _impact(axes: Axes, tip: Array) -> None:
    """Tip velocities before and after, and the impulse on the tip with its signs."""
    x, y = float(tip[0]), float(tip[1])
    _arrow(axes, (x - 15.0, y + 8.0), (14.4, -7.6), BLUE)
    _say(axes, x - 15.5, y + 7.0, "velocity of the tip before:\nnormal part < 0", BLUE, "right")
    _arrow(axes, (x + 0.6, y + 0.4), (9.0, 5.0), BLUE)
    _say(axes, x + 10.0, y + 5.0, "after: normal part > 0", BLUE)
    _arrow(axes, (x, y), (0.0, 12.0), VERMILION)
    _say(axes, x - 0.8, y + 11.8, "normal impulse > 0", VERMILION, "right")
    _arrow(axes, (x, y), (-8.0, 0.0), VERMILION)
    _say(axes, x - 1.0, y - 4.0, "tangential impulse on the tip:\n< 0 where friction opposes x", VERMILION, "right")


def _penetration(axes: Axes, tool: Tool, tip: Array) -> None:
    """The circle of undeflected tips, and how deep the workpart cuts into it."""
    reach = (tool.hub.radius + tool.bristle.length) * MILLIMETRES
    axes.add_patch(Arc((0.0, 0.0), 2 * reach, 2 * reach, theta1=-118.0, theta2=-58.0, color=GREY, linestyle=":"))
    _arrow(axes, (3.0, float(tip[1])), (0.0, -math.sqrt(reach**2 - 9.0) - float(tip[1])), BLACK, "<|-|>")
    _say(axes, 3.0, -reach - 2.0, "penetration below the hub")
    _say(axes, 25.0, -reach + 12.5, "circle of\nstraight tips", GREY)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("usage: python -m bristle_sim.render.strike_drawing FILE.svg")
    save_figure(strike_drawing(), Path(sys.argv[1]))
