"""The tool drawn to scale in millimetres: hub, belt root, wire, bar and workpart, for figures and films alike."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray

from bristle_sim.parameters import Tool
from bristle_sim.render.motion import Course
from bristle_sim.render.style import BLACK, BLUE, GREEN, GREY, LIGHT

__all__ = [
    "BAR_COLOUR",
    "MILLIMETRES",
    "View",
    "WireDrawing",
    "close_up",
    "draw_bar",
    "draw_hub",
    "draw_workpart",
    "name_parts",
    "toward",
    "wire_outline",
]

Array = NDArray[np.float64]

MILLIMETRES = 1e3
"""Millimetres in a metre: drawings are in mm, everything else in m."""

HUB_COLOUR, BAR_COLOUR = "#f3f3f3", "#bdbdbd"


@dataclass(frozen=True, slots=True)
class View:
    """The rectangle that a drawing shows, mm."""

    left: float
    right: float
    bottom: float
    top: float

    def widened(self, aspect: float) -> View:
        """The view grown about its centre, on two sides only, to a ratio of width to height."""
        width, height = self.right - self.left, self.top - self.bottom
        across, up = max(0.0, height * aspect - width) / 2.0, max(0.0, width / aspect - height) / 2.0
        return View(self.left - across, self.right + across, self.bottom - up, self.top + up)

    def apply(self, axes: Axes) -> None:
        """Show this rectangle with equal scales."""
        axes.set_xlim(self.left, self.right)
        axes.set_ylim(self.bottom, self.top)
        axes.set_aspect("equal", adjustable="box")


def close_up(course: Course, tool: Tool, aspect: float, margin: float = 0.05) -> View:
    """The smallest view of that ratio of width to height that holds the wire's path, the bar and the surface."""
    points = [course.centre_line.reshape(-1, 2)]
    if tool.bar is not None:
        points.append(np.array(tool.bar.centre) + tool.bar.radius * np.array([[-1.0, -1.0], [1.0, 1.0]]))
    if tool.workpart is not None:
        points.append(np.array([[course.tip[0, 0], -tool.workpart_depth]]))
    every = np.concatenate(points) * MILLIMETRES
    (left, bottom), (right, top) = every.min(axis=0), every.max(axis=0)
    border = margin * max(right - left, top - bottom)
    return View(left - border, right + border, bottom - border, top + border).widened(aspect)


def draw_hub(axes: Axes, tool: Tool) -> Circle:
    """The root circle that carries the belt, the hub's centre, and which way it turns."""
    radius = tool.hub.radius * MILLIMETRES
    circle = Circle((0.0, 0.0), radius, facecolor=HUB_COLOUR, edgecolor=GREY, linewidth=0.8)
    axes.add_patch(circle)
    axes.plot([0.0], [0.0], "+", color=GREY, markersize=5, markeredgewidth=0.6)
    if tool.hub.speed > 0.0:
        ends = 0.5 * radius * toward(np.radians([-35.0, 35.0]))
        style, bend = "-|>,head_length=4,head_width=2", "arc3,rad=0.33"
        axes.add_patch(FancyArrowPatch(*ends, arrowstyle=style, connectionstyle=bend, color=GREY, linewidth=0.8))
    return circle


def draw_bar(axes: Axes, tool: Tool) -> Circle | None:
    """The accelerator bar, or nothing."""
    if tool.bar is None:
        return None
    centre = (tool.bar.centre[0] * MILLIMETRES, tool.bar.centre[1] * MILLIMETRES)
    circle = Circle(centre, tool.bar.radius * MILLIMETRES, facecolor=BAR_COLOUR, edgecolor=BLACK, linewidth=0.8)
    axes.add_patch(circle)
    return circle


def draw_workpart(axes: Axes, tool: Tool, view: View) -> Rectangle | None:
    """The workpart, hatched from its surface down to the view's edge, or nothing."""
    if tool.workpart is None:
        return None
    surface = -tool.workpart_depth * MILLIMETRES
    # Drawn beyond the view, so that only the surface shows an edge.
    below, beyond = view.bottom - 10.0, 10.0
    block = Rectangle(
        (view.left - beyond, below),
        view.right - view.left + 2.0 * beyond,
        surface - below,
        facecolor=LIGHT,
        edgecolor=GREY,
        linewidth=0.8,
        hatch="////",
    )
    axes.add_patch(block)
    return block


def name_parts(axes: Axes, tool: Tool, letter_size: float, *, without: Collection[str] = ()) -> None:
    """Names of hub, bar and workpart but those left out, haloed so that they read on any ground; ``letter_size`` in points."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    radius = tool.hub.radius * MILLIMETRES
    # As near to the hub's centre as the view allows.
    x = min(max(0.0, left + 0.08 * (right - left)), right - 0.08 * (right - left))
    y = min(max(-0.25 * radius, bottom + 0.05 * (top - bottom)), top - 0.05 * (top - bottom))
    places: dict[str, tuple[float, float, str]] = {}
    if math.hypot(x, y) < 0.9 * radius:
        places["hub"] = (x, y, "center")
    if tool.bar is not None:
        places["bar"] = (MILLIMETRES * tool.bar.centre[0], MILLIMETRES * tool.bar.centre[1], "center")
    if tool.workpart is not None:
        places["workpart"] = (left + 0.025 * (right - left), bottom + 0.03 * (top - bottom), "left")
    grounds = {"hub": HUB_COLOUR, "bar": BAR_COLOUR, "workpart": "white"}
    for name in (each for each in places if each not in without):
        x, y, side = places[name]
        halo = [withStroke(linewidth=2.5, foreground=grounds[name])]
        axes.text(x, y, name, ha=side, va="center", fontsize=letter_size, path_effects=halo, zorder=7, clip_on=True)


SHARPEST = 0.5
"""Least 1 + cos of a corner's angle that is mitred in full: 120 degrees, beyond any knee."""


def toward(angle: ArrayLike) -> Array:
    """The direction on the page of an angle from the workpart's, (sin, -cos), shape (*angle.shape, 2)."""
    return np.stack([np.sin(angle), -np.cos(angle)], axis=-1)


def wire_outline(centre_line: Array, diameter: float) -> Array:
    """Outline of a flat-ended wire about its centre line: along its left side to the tip and back along its right.

    Corners are mitred, at most to SHARPEST, where a chain folds back on itself.

    Args:
        centre_line: shape (corners, 2), in the unit of ``diameter``.

    Returns:
        Shape (2 corners, 2); the tip lies midway between the two points in the middle.
    """
    along = np.diff(centre_line, axis=0)
    along /= np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-300)[:, np.newaxis]
    across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    before, after = np.vstack([across[:1], across]), np.vstack([across, across[-1:]])
    # The mitre m has the projection 1 on both normals: m = (b + a)/(1 + b.a).
    mitre = (before + after) / np.maximum(1.0 + (before * after).sum(axis=1), SHARPEST)[:, np.newaxis]
    side = 0.5 * diameter * mitre
    return np.concatenate([centre_line + side, (centre_line - side)[::-1]])


class WireDrawing:
    """The wire, its root in the belt, the radial line it is measured from, and a ring of roots that shows the turn."""

    def __init__(self, axes: Axes, tool: Tool, *, color: str = BLUE, alpha: float = 1.0, details: bool = False) -> None:
        self._diameter = tool.bristle.wire_diameter * MILLIMETRES
        # The outline's line keeps a hair-thin wire visible.
        self.wire = Polygon(np.zeros((4, 2)), facecolor=color, edgecolor=color, linewidth=0.5, alpha=alpha, zorder=4)
        self.wire.set_joinstyle("round")
        axes.add_patch(self.wire)
        (self.root,) = axes.plot([], [], "o", color=GREEN, markersize=4.5, markeredgecolor="white", zorder=5)
        self.artists: list[Artist] = [self.wire, self.root]
        if details:
            (self.radial,) = axes.plot([], [], color=GREY, linewidth=0.8, dashes=(5, 3), zorder=2)
            (self.ring,) = axes.plot([], [], "o", color=GREY, markersize=3, zorder=3)
            self.artists = [self.radial, self.ring, *self.artists]

    def place(self, centre_line: Array) -> None:
        """Move everything to where the centre line's corners are, from the hub's centre, shape (corners, 2), m."""
        corners = np.asarray(centre_line) * MILLIMETRES
        root = corners[0]
        self.wire.set_xy(wire_outline(corners, self._diameter))
        self.root.set_data(root[:1], root[1:])
        if len(self.artists) > 2:
            rim, length = math.hypot(*root), float(np.hypot(*np.diff(corners, axis=0).T).sum())
            outward = root / rim if rim > 0.0 else np.zeros(2)
            self.radial.set_data(*np.array([root, root + length * outward]).T)
            turns = np.exp(1j * np.arange(1, 12) * (np.pi / 6.0)) * complex(*root)
            self.ring.set_data(turns.real, turns.imag)
