"""Drawings to scale in millimetres: the tool's parts, wires, arrows and a scale bar."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.patches import Circle, FancyArrowPatch, Rectangle
from matplotlib.patheffects import withStroke
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, LIGHT
from bristle_sim.render.style import MILLIMETRES, scale_for

LONGEST_SCALE_BAR = 0.28  # longest scale bar as a fraction of the axes' width
# Largest distance of a drawn bar from the hub's centre, over the wires' largest distance
BAR_SHOWN = 2.0
HUB_COLOUR = "#f3f3f3"
BAR_COLOUR = "#bdbdbd"

GROUND: dict[str, Any] = {"facecolor": LIGHT, "edgecolor": GREY, "linewidth": 0.8, "hatch": "////"}
"""Style of parts at rest: a workpart or the bracket of a hinge."""


class View(NamedTuple):
    """The rectangle that a drawing shows, in the unit of the drawn points."""

    left: float
    right: float
    bottom: float
    top: float

    @classmethod
    def around(cls, points: Sequence[ArrayLike], aspect: float | None, margin: float) -> View:
        """Return the smallest rectangle that contains arrays of points, each of shape (..., 2).

        ``aspect`` is the ratio of width to height, if prescribed. ``margin`` is the width of the
        free border as a fraction of the points' larger extent.
        """
        every = np.concatenate([np.reshape(each, (-1, 2)) for each in points])
        (left, bottom), (right, top) = every.min(axis=0).tolist(), every.max(axis=0).tolist()
        border = margin * max(right - left, top - bottom, 1e-300)
        width, height = right - left + 2.0 * border, top - bottom + 2.0 * border
        aspect = aspect or width / height
        across = max(0.0, height * aspect - width) / 2.0 + border
        up = max(0.0, width / aspect - height) / 2.0 + border
        return cls(left - across, right + across, bottom - up, top + up)

    def apply(self, axes: Axes) -> None:
        """Make axes show this rectangle, with equal scales in both directions."""
        axes.set(xlim=(self.left, self.right), ylim=(self.bottom, self.top))
        axes.set_aspect("equal", adjustable="box")


def close_up(lines: Array, tool: Tool, aspect: float, margin: float = 0.05) -> View:
    """Return the smallest rectangle, mm, that shows the wires, a bar near them and the workpart's
    surface.

    ``lines`` holds the points of the wires, shape (..., 2), m.
    """
    points = [lines]
    reach = BAR_SHOWN * float(np.hypot(lines[..., 0], lines[..., 1]).max())
    if tool.bar is not None and math.hypot(*tool.bar.centre) < reach:
        points.append(
            np.array(tool.bar.centre) + tool.bar.radius * np.array([[-1.0, -1.0], [1.0, 1.0]])
        )
    if tool.workpart is not None:
        points.append(np.array([[lines[..., 0].mean(), -tool.workpart_depth]]))
    return View.around([MILLIMETRES * each for each in points], aspect, margin)


def moving_arrow(axes: Axes, color: str, linewidth: float, head: float) -> FancyArrowPatch:
    """Add an arrow that :func:`point_arrow` moves later; ``head`` is the size of its head in
    points.
    """
    arrow = FancyArrowPatch(
        (0.0, 0.0), (0.0, 0.0), arrowstyle="-|>", mutation_scale=head, shrinkA=0.0, shrinkB=0.0
    )
    arrow.set(color=color, linewidth=linewidth, zorder=5)
    axes.add_patch(arrow)
    return arrow


def point_arrow(
    arrow: FancyArrowPatch, start: tuple[float, float], end: tuple[float, float], shortest: float
) -> None:
    """Move an arrow to the given start and end, or hide an arrow shorter than ``shortest``."""
    arrow.set_visible(math.dist(start, end) > shortest)
    arrow.set_positions(start, end)


def draw_film_tool(axes: Axes, tool: Tool, view: View, letter_size: float) -> None:
    """Draw the background of a film: the tool with the names of its parts, and a scale bar."""
    view.apply(axes)
    axes.set_axis_off()
    draw_tool(axes, tool, view)
    name_parts(axes, tool, letter_size)
    longest = LONGEST_SCALE_BAR * (view.right - view.left)
    decade = 10.0 ** math.floor(math.log10(longest))
    length = decade * max(
        step for step in (1.0, 2.0, 5.0) if step * decade <= longest * (1.0 + 1e-9)
    )
    shown = scale_for(length / MILLIMETRES, "m")
    words = f"{length * shown.factor / MILLIMETRES:g} {shown.unit}"
    bar = AnchoredSizeBar(
        axes.transData,
        length,
        words,
        "lower right",
        pad=0.3,
        borderpad=0.8,
        size_vertical=0.004 * (view.top - view.bottom),
        color=BLACK,
        fontproperties=FontProperties(size=letter_size),
    )
    axes.add_artist(bar)


def draw_tool(axes: Axes, tool: Tool, view: View) -> None:
    """Draw hub, bar and workpart; the hub is the circle of the roots with its sense of rotation.

    A tool without bar or workpart is drawn without them.
    """
    radius = tool.hub.radius * MILLIMETRES
    axes.add_patch(Circle((0.0, 0.0), radius, facecolor=HUB_COLOUR, edgecolor=GREY, linewidth=0.8))
    axes.plot([0.0], [0.0], "+", color=GREY, markersize=5, markeredgewidth=0.6)
    if tool.hub.speed > 0.0:
        ends = 0.5 * radius * toward(np.radians([-35.0, 35.0]))
        style = "-|>,head_length=4,head_width=2"
        bend = "arc3,rad=0.33"
        axes.add_patch(
            FancyArrowPatch(
                *ends, arrowstyle=style, connectionstyle=bend, color=GREY, linewidth=0.8
            )
        )
    if tool.bar is not None:
        draw_bar(axes, *tool.bar.centre, tool.bar.radius)
    if tool.workpart is not None:
        # extent of the workpart beyond the view, mm, so that only its surface shows an edge
        beyond = 10.0
        place = (view.left - beyond, view.bottom - beyond)
        height = -tool.workpart_depth * MILLIMETRES - view.bottom + beyond
        axes.add_patch(Rectangle(place, view.right - view.left + 2.0 * beyond, height, **GROUND))


def draw_bar(axes: Axes, x: float, y: float, radius: float, **options: Any) -> None:
    """Draw an accelerator bar as a circle; lengths in m, ``options`` as for a patch of matplotlib."""
    look: dict[str, Any] = {"facecolor": BAR_COLOUR, "edgecolor": BLACK, "linewidth": 0.8}
    axes.add_patch(
        Circle((MILLIMETRES * x, MILLIMETRES * y), MILLIMETRES * radius, **(look | options))
    )


def name_parts(axes: Axes, tool: Tool, letter_size: float) -> None:
    """Write the names of hub, bar and workpart, outlined so that they are legible on any
    background.

    ``letter_size`` is in points.
    """
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    width = right - left
    height = top - bottom
    radius = tool.hub.radius * MILLIMETRES
    # The name of the hub is as near to the hub's centre as the view permits.
    x = float(np.clip(0.3 * radius, left + 0.08 * width, right - 0.08 * width))
    y = float(np.clip(0.35 * radius, bottom + 0.05 * height, top - 0.05 * height))
    names = {"hub": ((x, y), "center", HUB_COLOUR)} if math.hypot(x, y) < 0.9 * radius else {}
    if tool.bar is not None:
        x, y = (MILLIMETRES * each for each in tool.bar.centre)
        names["bar"] = ((x, y), "center", BAR_COLOUR)
    if tool.workpart is not None:
        names["workpart"] = ((left + 0.025 * width, bottom + 0.03 * height), "left", "white")
    look: dict[str, Any] = {"va": "center", "fontsize": letter_size, "zorder": 7, "clip_on": True}
    for name, (place, side, ground) in names.items():
        halo = [withStroke(linewidth=2.5, foreground=ground)]
        axes.text(*place, name, ha=side, path_effects=halo, **look)


def toward(angle: ArrayLike) -> Array:
    """Return the unit vector (sin, -cos) at an angle from the downward direction.

    The angle is in rad. The result has the shape (*angle.shape, 2).
    """
    return np.stack([np.sin(angle), -np.cos(angle)], axis=-1)


def touch_places(lines: Sequence[Array], diameter: float) -> Array:
    """Return the points where neighbouring wires touch, from the hub's centre, mm, shape (touches,
    2).

    Two wires touch if a corner or an end of one wire is within 1.05 wire diameters of the other
    wire's centre line. ``lines`` holds the centre lines, each of shape (corners, 2), m;
    ``diameter`` is in m.
    """
    places = []
    for one, other in itertools.pairwise(lines):
        pairs = [
            (point, _foot(point, line))
            for points, line in ((one, other), (other, one))
            for point in points[1:]
        ]
        point, foot = min(pairs, key=lambda pair: math.dist(*pair))
        if math.dist(point, foot) < 1.05 * diameter:
            places.append(0.5 * (point + foot))
    return MILLIMETRES * np.reshape(places, (-1, 2))


def _foot(point: Array, line: Array) -> Array:
    """Return the point of a polyline that is nearest to a given point."""
    along = np.diff(line, axis=0)
    part = np.clip(((point - line[:-1]) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    feet = line[:-1] + part[:, None] * along
    return np.asarray(feet[np.argmin(np.hypot(*(point - feet).T))])


class WireDrawing:
    """The drawing of a wire and its root.

    With ``details``, it also has the radial line through the root and the roots of other bristles.
    """

    def __init__(
        self,
        axes: Axes,
        tool: Tool,
        *,
        color: str = BLUE,
        alpha: float = 1.0,
        details: bool = False,
    ) -> None:
        """Draw the wire to scale, half a point wider so that a thin wire is visible.

        ``axes`` must have their final limits.
        """
        width = (
            axes.get_window_extent().width / axes.figure.dpi * 72.0 / float(np.ptp(axes.get_xlim()))
        )
        thickness = 0.5 + width * tool.bristle.wire_diameter * MILLIMETRES
        look: dict[str, Any] = {"color": color, "alpha": alpha, "linewidth": thickness}
        ends: dict[str, Any] = {"solid_capstyle": "butt", "solid_joinstyle": "miter"}
        (self.wire,) = axes.plot([], [], zorder=4, **look, **ends)
        (self.root,) = axes.plot(
            [], [], "o", color=GREEN, markersize=4.5, markeredgecolor="white", zorder=5
        )
        self.artists: list[Artist] = [self.wire, self.root]
        if details:
            (self.radial,) = axes.plot([], [], color=GREY, linewidth=0.8, dashes=(5, 3), zorder=2)
            (self.ring,) = axes.plot([], [], "o", color=GREY, markersize=3, zorder=3)
            self.artists = [self.radial, self.ring, *self.artists]

    def place(self, centre_line: Array) -> None:
        """Move the drawing to a new position of the wire.

        ``centre_line`` holds the corners of the wire from the hub's centre, shape (corners, 2), m.
        """
        corners = np.asarray(centre_line) * MILLIMETRES
        root = corners[0]
        self.wire.set_data(*corners.T)
        self.root.set_data(root[:1], root[1:])
        if len(self.artists) > 2:
            length = float(np.hypot(*np.diff(corners, axis=0).T).sum())
            turns = np.arange(1, 12) * (np.pi / 6.0)
            end = root * (1.0 + length / max(math.hypot(*root), 1e-300))
            self.radial.set_data(*np.array([root, end]).T)
            roots = np.exp(1j * turns) * complex(*root)
            self.ring.set_data(roots.real, roots.imag)
