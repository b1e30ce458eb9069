"""Drawings to scale, in millimetres, of the tool's parts and wires, with arrows and a scale bar."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke
from matplotlib.quiver import Quiver
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.readable import MILLIMETRES
from bristle_sim.render.style import BLACK, BLUE, GREEN, GREY, LIGHT, Look

# Largest distance of a visible bar from the hub's centre, divided by the distance of the farthest
# point of the wires
BAR_SHOWN = 2.0
POINTS = (
    201  # points on a straight segment of wire at which the distance to another wire is computed
)
HUB_COLOUR = "#f3f3f3"
BAR_COLOUR = "#bdbdbd"

GROUND: Look = {
    "facecolor": LIGHT, "edgecolor": GREY, "linewidth": 0.8, "hatch": "////", "xmin": -1.0, "xmax": 2.0,
}  # fmt: skip
"""Style of the workpart, drawn with ``axhspan``; its sides lie outside the axes."""


def show_points(axes: Axes, points: Sequence[ArrayLike], margin: float) -> None:
    """Set the limits of axes so that all given points are visible, with equal scales in x and y.

    Args:
        axes: the axes.
        points: arrays of points, each of shape (..., 2), in the axes' unit.
        margin: smallest width of the free border, as a fraction of the larger extent of the points.
    """
    every = np.concatenate([np.reshape(each, (-1, 2)) for each in points])
    extent = np.ptp(every, axis=0)
    size = extent + 2.0 * margin * extent.max()
    aspect = axes.get_window_extent().width / axes.get_window_extent().height
    size = np.maximum(size, size[::-1] * [aspect, 1.0 / aspect])
    low = 0.5 * (every.min(axis=0) + every.max(axis=0) - size)
    x, y = np.transpose([low, low + size])
    axes.set(xlim=x, ylim=y, aspect="equal", anchor="N")


def show_wires(axes: Axes, tool: Tool, lines: ArrayLike, margin: float = 0.05) -> None:
    """Set the limits of axes (mm) so that wires and the workpart's surface are visible.

    A bar is included unless it is far from the wires.

    Args:
        axes: the axes.
        tool: tool whose bar and workpart are to be visible.
        lines: points of the wires, shape (..., 2), m.
        margin: width of the free border, as a fraction of the drawing's larger extent.
    """
    wires = np.asarray(lines)
    points = [wires]
    reach = BAR_SHOWN * float(np.hypot(wires[..., 0], wires[..., 1]).max())
    if tool.bar is not None and math.hypot(*tool.bar.centre) < reach:
        points += [np.add(tool.bar.centre, sign * tool.bar.radius) for sign in (-1.0, 1.0)]
    if tool.workpart is not None:
        points.append(np.array([wires[..., 0].mean(), -tool.workpart_depth]))
    show_points(axes, [MILLIMETRES * each for each in points], margin)


def points_per_unit(axes: Axes) -> float:
    """Return the printed length (points of 1/72 inch) of one unit along the x axis."""
    width = axes.get_window_extent().width / axes.figure.dpi * 72.0
    return float(width / np.ptp(axes.get_xlim()))


def add_arrows(axes: Axes, *colors: str) -> Quiver:
    """Add one arrow, without length at first, for each colour.

    The method ``set_offsets`` of the result places the arrows, and ``set_UVC`` sets their
    components.
    """
    none = np.zeros(len(colors))
    units: Look = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "units": "dots"}
    look: Look = {"width": axes.figure.dpi / 24.0, "minlength": 0.0, "zorder": 5}
    return axes.quiver(none, none, none, none, color=colors, **units, **look)


def draw_wires(
    axes: Axes,
    tool: Tool,
    lines: ArrayLike,
    colors: Sequence[str],
    *,
    margin: float = 0.05,
    radial: bool = False,
) -> list[WireDrawing]:
    """Draw the tool and a scale bar, and return one movable drawing of a wire for each colour.

    Args:
        axes: axes of the drawing, in mm.
        tool: the tool.
        lines: points of the wires, shape (..., 2), m. They determine the limits of the axes.
        colors: colours of the wires.
        margin: width of the free border, as a fraction of the drawing's larger extent.
        radial: whether the radial line through each root is drawn.
    """
    show_wires(axes, tool, lines, margin)
    draw_tool(axes, tool)
    length = float(np.diff(axes.get_xticks()[:2]).item())
    bar = AnchoredSizeBar(axes.transData, length, f"{length:g} mm", "lower right")
    axes.add_artist(bar)
    axes.set_axis_off()
    return [WireDrawing(axes, tool, color=color, radial=radial) for color in colors]


def draw_tool(axes: Axes, tool: Tool) -> None:
    """Draw hub, bar and workpart with their names, in axes whose limits are final.

    The hub is the circle on which the roots move, with an arrow in its sense of rotation. The bar
    or the workpart may be absent. The names have a white outline, so that they are legible on any
    background.
    """
    low, high = np.transpose([axes.get_xlim(), axes.get_ylim()])
    size = high - low
    radius = tool.hub.radius * MILLIMETRES
    draw_circle(axes, (0.0, 0.0), tool.hub.radius, facecolor=HUB_COLOUR, edgecolor=GREY)
    if tool.hub.speed > 0.0:
        start, end = 0.5 * radius * toward(np.radians([-35.0, 35.0]))
        arrow = {"arrowstyle": "-|>", "connectionstyle": "arc3,rad=0.33", "color": GREY}
        axes.annotate("", end, start, arrowprops=arrow, annotation_clip=True)
    # The name of the hub is as near to the hub's centre as the view permits.
    rim = [0.08, 0.05] * size
    place = np.clip([0.3 * radius, 0.35 * radius], low + rim, high - rim)
    names = {"hub": place} if math.hypot(*place) < 0.9 * radius else {}
    if tool.bar is not None:
        draw_circle(axes, tool.bar.centre, tool.bar.radius)
        names["bar"] = MILLIMETRES * np.asarray(tool.bar.centre)
    if tool.workpart is not None:
        axes.axhspan(low[1] - 2.0 * size[1], -tool.workpart_depth * MILLIMETRES, **GROUND)
        names["workpart"] = low + [0.13, 0.03] * size
    for name, (x, y) in names.items():
        text = axes.text(x, y, name, ha="center", va="center", zorder=7, clip_on=True)
        text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])


def draw_circle(axes: Axes, centre: Sequence[float], radius: float, **look: Any) -> None:
    """Draw the circle of a hub or bar.

    ``centre`` and ``radius`` are in m; the axes are in mm. ``look`` are matplotlib's options for a
    patch; they replace the style of a bar.
    """
    bar = {"facecolor": BAR_COLOUR, "edgecolor": BLACK, "linewidth": 0.8}
    x, y = (MILLIMETRES * each for each in centre)
    axes.add_patch(Circle((x, y), MILLIMETRES * radius, **(bar | look)))


def toward(angle: ArrayLike) -> Array:
    """Return the unit vector (sin a, -cos a) at an angle a (rad) from the downward direction.

    The result has the shape (*angle.shape, 2).
    """
    return np.stack([np.sin(angle), -np.cos(angle)], axis=-1)


def touch_places(lines: Sequence[Array], diameter: float) -> Array:
    """Return the points at which neighbouring wires touch, mm from the hub's centre.

    Two wires count as touching if the distance between their centre lines is less than 1.05 wire
    diameters.

    Args:
        lines: centre lines of the wires in their order along the hub, each of shape (corners, 2),
            m.
        diameter: diameter of the wires, m.

    Returns:
        The points, shape (touches, 2).
    """
    places = []
    for one, other in pairwise(
        np.concatenate([np.linspace(*ends, POINTS) for ends in pairwise(line)]) for line in lines
    ):
        gaps = np.linalg.norm(one[:, np.newaxis] - other, axis=-1)
        row, column = np.unravel_index(np.argmin(gaps), gaps.shape)
        if gaps[row, column] < 1.05 * diameter:
            places.append(0.5 * (one[row] + other[column]))
    return MILLIMETRES * np.reshape(places, (-1, 2))


class WireDrawing:
    """Movable drawing of a wire with its root, and optionally the radial line through the root."""

    def __init__(
        self,
        axes: Axes,
        tool: Tool,
        *,
        color: str = BLUE,
        alpha: float = 1.0,
        radial: bool = False,
    ) -> None:
        """Add the drawing to axes whose limits are final.

        The thickness of the wire is drawn to scale, plus 1/144 inch so that a thin wire is visible.
        ``color`` and ``alpha`` are the colour and the opacity of the wire. ``radial`` adds the
        radial line through the root.
        """
        thickness = 0.5 + points_per_unit(axes) * tool.bristle.wire_diameter * MILLIMETRES
        ends: Look = {"solid_capstyle": "butt", "solid_joinstyle": "miter"}
        look: Look = {"color": color, "alpha": alpha, "linewidth": thickness, "zorder": 4}
        (self.wire,) = axes.plot([], [], **look, **ends)
        look = {"color": GREEN, "markersize": 4.5, "markeredgecolor": "white", "zorder": 5}
        (self.root,) = axes.plot([], [], "o", label="root in the belt", **look)
        (self.radial,) = axes.plot([], [], "--", color=GREY, linewidth=0.8, visible=radial)
        self.artists = [self.radial, self.wire, self.root]
        self.reach = 1.0 + tool.bristle.length / max(tool.hub.radius, 1e-300)

    def place(self, centre_line: Array) -> None:
        """Move the drawing to a position of the wire.

        ``centre_line`` holds the wire's root, hinges or knee, and tip, relative to the hub's
        centre, shape (corners, 2), m.
        """
        corners = np.asarray(centre_line) * MILLIMETRES
        root = corners[0]
        self.wire.set_data(*corners.T)
        self.root.set_data(root[:1], root[1:])
        self.radial.set_data(*np.transpose([root, self.reach * root]))
