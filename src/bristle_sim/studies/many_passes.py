"""Quantities of passes of many tools at once, computed in arrays and checked by the scene.

Names and units are those of the whole pass.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.passes.result import Ensemble
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.whole_pass import QUANTITIES, measures_of

OUTCOME = "outcome"
REASON = "failure"

CHECKED_POINTS = 8
"""Number of random points at which the scene checks the passes in arrays."""

SCENE_ACCURACY = 1e-9
"""Finest accuracy of the scene in a check; at a finer accuracy it takes longer and agrees no
better."""

SIZES = {
    "contact_time": 0.0,
    "lag_deg_at_contact": np.degrees(1.0),
    "tip_speed_at_contact": 0.0,
    "normal_final_impulse": 0.0,
}
"""Quantities that are compared, and the least size of each, to which a difference is related."""


def unable(tool: Tool, settings: Settings) -> str:
    """Return the reason why passes of a tool cannot be computed in arrays; empty if they can."""
    if tool.contact.law != "energetic":
        return f"contact = {tool.contact.law}"
    if tool.bristle.links > 1 or tool.bristle.knee_angle_deg:
        return "the wire bends" if tool.bristle.links > 1 else "the wire has a knee"
    return "" if settings.hub_turn == Settings().hub_turn else "hub_turn is given"


def pass_quantities(tool: Tool, accuracy: float, **values: Any) -> dict[str, NDArray[Any]]:
    """Return the quantities of whole passes, NaN where a pass lacks a quantity.

    ``outcome`` and ``failure``, the reason in words, are further entries.

    Args:
        tool: the tool that gives the values of all other keys.
        accuracy: requested relative accuracy.
        values: arrays of values, by key, as for ``ensemble``.
    """
    many = ensemble(tool, accuracy=accuracy, **values)
    found = {name: _quantity(many, name) for name in QUANTITIES if name != "rebound_ratio"}
    speed = many.keys.get("hub_speed", tool.hub.speed) + many.relative_speed_at_contact
    found["rebound_ratio"] = many.final_bristle_rate / np.where(speed == 0.0, np.nan, speed)
    return found | {OUTCOME: many.outcome, REASON: many.reason}


def _quantity(many: Ensemble, name: str) -> Array:
    values: Array = getattr(many, name.replace("_deg", ""))
    return np.degrees(values) if "_deg" in name else values


@dataclass(frozen=True, slots=True)
class Check:
    """The comparison of passes in arrays with the scene.

    Attributes:
        passes: number of passes.
        difference: largest relative difference.
        apart: number of passes that strike in only one of the two.
    """

    passes: int
    difference: float
    apart: int

    def __str__(self) -> str:
        """Return the result as the end of a sentence."""
        apart = f", but for {self.apart} that strike in one of the two alone" if self.apart else ""
        return f"the scene agrees to {self.difference:.0e} in {self.passes} passes{apart}"


def checked_by_scene(tool: Tool, accuracy: float, values: Mapping[str, Array]) -> Check:
    """Compare passes in arrays with passes of the scene; ``values`` holds arrays of shape (points,)
    by key.

    Compared are the instant of the strike, lag, tip speed and normal impulse, relative to their
    sizes.
    """
    found = pass_quantities(tool, accuracy, **values)
    settings = Settings(accuracy=max(accuracy, SCENE_ACCURACY))
    worst = 0.0
    apart = 0
    for number, point in enumerate(zip(*(each.tolist() for each in values.values()), strict=True)):
        own = tool.replace(**dict(zip(values, point, strict=True)))
        measured = measures_of(own, simulate(own, settings, stop_after="strike"))
        for name, size in SIZES.items():
            one = float(found[name][number])
            other = measured[name]
            if (other is None) != np.isnan(one):
                apart += name == "contact_time"
            elif other is not None:
                worst = max(worst, abs(one - other) / max(abs(other), size, 1e-300))
    return Check(len(found[OUTCOME]), worst, apart)
