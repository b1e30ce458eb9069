"""Where a run starts: bristles at rest relative to the hub, or at an angle and a rate of their own."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from bristle_sim.parameters import Tool
from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import State
from bristle_sim.units import Declared, count, quantity

RETRACTION_LIMIT = math.pi / 2.0
"""Angle of the bristle from the radial direction at which it lies on the hub, rad."""

OVERLAP = 1e-11
"""Fraction of the bristle's length by which rounding lets it overlap what it touches at the start."""

PLACES = {"bar": ("bar_horizontal", "bar_vertical"), "workpart": ("penetration",)}
"""Keys that say where an obstacle stands."""


@dataclass(frozen=True, slots=True)
class Row(Declared):
    """Bristles of one plane on one hub, each a pitch behind the one before it, and how they rub and rebound on each other."""

    bristles: int = count(1, "1 <= bristles <= 100", "number of bristles", "requested")
    pitch: float = quantity(0.0, f"0 <= pitch <= {2.0 * math.pi} rad", "", "requested")
    friction: float = quantity(0.0, "0 <= neighbour_friction <= 1e6", "", "requested")
    restitution: float = quantity(0.0, "0 <= neighbour_restitution <= 1", "", "requested")


LONE = Row()
"""One bristle."""


@dataclass(frozen=True, slots=True)
class StartRelativeToHub(Declared):
    """A start at which every wire has the same angle and rate relative to its root; the numbers are checked."""

    hub_angle: float = quantity(0.0, "-1e6 <= start_hub_angle <= 1e6 rad", "", "requested")
    relative_angle: float = quantity(
        0.0, f"{-RETRACTION_LIMIT} <= start_relative_angle <= {RETRACTION_LIMIT} rad", "", "requested"
    )
    relative_rate: float = quantity(0.0, "-1e9 <= start_relative_rate <= 1e9 rad/s", "", "requested")


@dataclass(frozen=True, slots=True)
class Start:
    """The start of a run.

    Attributes:
        hub_angle: of the first root, rad.
        angles: absolute ones of every link, rad.
        relative_rates: of every link relative to the hub, rad/s.
        described: what a result's parameters say of it.
    """

    hub_angle: float
    angles: tuple[float, ...]
    relative_rates: tuple[float, ...]
    described: dict[str, Any] = field(default_factory=dict)


def check_start(scene: Scene, tool: Tool, start: State) -> None:
    """Refuse a start in which a bristle stands in an obstacle, or in another bristle."""
    poses = scene.mechanism.poses(start)
    for obstacle in scene.effects.obstacles:
        gap = obstacle.closest(poses, start.rates).gap
        if gap >= -OVERLAP:
            continue
        overlap = -gap * tool.bristle.length
        if obstacle.partner is not None:
            raise ValueError(
                f"pitch = {scene.mechanism.pitch:g}: must be one at which bristles are clear of each other at the start,"
                f" these overlap by {overlap:.3g} m (in rad)"
            )
        part = getattr(tool, obstacle.name)
        given = ", ".join(f"{key} = {getattr(part, key.split('_')[-1]):g}" for key in PLACES[obstacle.name])
        raise ValueError(
            f"{given}: the {obstacle.name} must be clear of the bristle at the start, this one overlaps it by"
            f" {overlap:.3g} (in m)"
        )
