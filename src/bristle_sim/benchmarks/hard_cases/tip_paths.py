"""Paths of a tip that just reach an obstacle or just miss it: where the obstacle must stand for that.

A radial bristle that turns with its hub keeps its tip on the circle of radius R = r_h + L, one on a hub at rest swings
as cos(omega_n t). Where the tip of one that swings on a turning hub is lowest, the independent solution tells.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bristle_sim.parameters import Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference

__all__ = ["bar_at", "gap_of_circle", "lowest_place", "swinging", "workpart_at"]

TOOL = Tool()

LENGTH = TOOL.bristle.length

REACH = TOOL.hub.radius + LENGTH
"""Radius of the tip's circle, m."""

SIDE = math.radians(40.0)
"""Angle of the root on a hub at rest."""

SWING = math.radians(25.0)
"""Amplitude of the bristle there: its tip is lowest where it turns back."""

LEAN = -0.4
"""Angle at which a bristle on the turning hub starts to swing, rad."""

FINE = 1e-6
"""Interval of the reference's samples, s: a thousandth of a radian of the bristle's swing."""


def bar_at(depth: float) -> Tool:
    """The tool without workpart, its bar moved along its own radius until the tip's circle dips ``depth`` L into it."""
    assert TOOL.bar is not None
    away = (REACH + TOOL.bar_reach - depth * LENGTH) / math.hypot(*TOOL.bar.centre)
    bar = replace(TOOL.bar, horizontal=TOOL.bar.horizontal * away, vertical=TOOL.bar.vertical * away)
    return replace(TOOL, bar=bar, workpart=None)


def workpart_at(depth: float) -> Tool:
    """The tool without bar over a workpart into which the tip's circle dips ``depth`` L."""
    return replace(TOOL, bar=None, workpart=Workpart(penetration=depth * LENGTH))


def gap_of_circle(tool: Tool) -> Callable[[float], float]:
    """Gap in m, in closed form, of a tip on its circle after the time in s."""
    bar = tool.bar

    def gap(time: float) -> float:
        angle = tool.hub.speed * time - math.pi / 2.0
        tip = (REACH * math.sin(angle), -REACH * math.cos(angle))
        if bar is None:
            return tool.workpart_depth + tip[1]
        return math.dist(tip, bar.centre) - tool.bar_reach

    return gap


def swinging(depth: float) -> Tool:
    """A hub at rest; the surface lies ``depth`` L above the lowest place of the tip, where it turns back."""
    lowest = TOOL.hub.radius * math.cos(SIDE) + LENGTH * math.cos(SIDE - SWING)
    part = Workpart(penetration=REACH - lowest + depth * LENGTH)
    return replace(TOOL, hub=Hub(speed=0.0), bar=None, workpart=part)


def lowest_place() -> float:
    """Depth below the hub's centre that the tip of the swinging bristle reaches at its lowest, by the reference, m."""
    run = simulate_reference(
        replace(TOOL, bar=None, workpart=None), start_relative_angle=LEAN, accuracy=1e-12, sample_interval=FINE
    )
    height = run.tip[:, 1]
    at = int(height.argmin())
    around = slice(at - 2, at + 3)
    # Through five samples, in intervals from the middle one: off by the fifth power of a thousandth.
    quartic = np.polynomial.Polynomial.fit(
        (run.time[around] - run.time[at]) / FINE, height[around], 4, domain=(-2, 2), window=(-2, 2)
    )
    places = [root.real for root in quartic.deriv().roots() if abs(root.imag) < 1e-9 and abs(root.real) <= 1.0]
    return -min(float(quartic(place)) for place in places)
