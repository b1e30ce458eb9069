"""The released bristle by formula over time, and where each reading of the belt stiffness needs the bar.

The quasi-static formulas let the bristle swing as a linear oscillator on its belt,

    alpha(t) = -theta_p e^(-zeta Omega t) (cosh w t + zeta Omega/w sinh w t),    w = Omega sqrt(zeta^2 - 1),

an undamped cosine in the dissertation (Zhang 2020, sec. 2.2), and place the bar by its cue time (eq. 2.1).
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bristle_sim.parameters import Belt, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.cue_timing import cue_timing, stiffness_readings
from bristle_sim.theory.cueing import natural_rate

__all__ = ["BarPlace", "ReadingPlaces", "bar_places", "formula_motion"]

Array = NDArray[np.float64]


class BarPlace(NamedTuple):
    """A bar's centre: S_H and S_V in m, and its direction from the workpart's normal in rad."""

    horizontal: float
    vertical: float
    direction: float


@dataclass(frozen=True, slots=True)
class ReadingPlaces:
    """The bar that one reading of the belt stiffness (N m/rad) needs, by simulation and by formula, None where none."""

    reading: str
    stiffness: float
    simulated: BarPlace | None
    formula: BarPlace | None


def formula_motion(tool: Tool, retraction: float, time: ArrayLike) -> tuple[Array, Array]:
    """Relative angle and rate of the released bristle as a linear oscillator, rad and rad/s, at times in s.

    Raises:
        ValueError: if the belt has no stiffness.
    """
    instants = np.asarray(time, dtype=float)
    rate = float(natural_rate(tool.belt.stiffness, tool.bristle.inertia_about_root))
    decay = tool.belt.damping_ratio * rate
    turns = 1j * np.sqrt(complex(decay**2 - rate**2)) * instants
    # sinh(w t)/w = t sin(i w t)/(i w t), which has its limit t at critical damping.
    swing, drift = np.cos(turns), instants * np.sinc(turns / np.pi)
    fading = np.exp(-decay * instants)
    angle = -retraction * fading * (swing + decay * drift).real
    return angle, retraction * rate**2 * fading * drift.real


def bar_places(tool: Tool, retraction: float, settings: Settings | None = None) -> tuple[ReadingPlaces, ...]:
    """Where each reading of the printed belt stiffness needs the bar, for a retraction in rad.

    Raises:
        ValueError: if the tool has no bar or no workpart.
    """
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: a tool that has both is allowed")
    places = []
    for reading, stiffness in stiffness_readings(tool).items():
        read = dataclasses.replace(tool, belt=Belt(stiffness, tool.belt.damping_ratio))
        report = cue_timing(read, retraction, settings or Settings(), with_reference=False)
        rows = {row.name: row for row in report.quantities}
        wanted = [rows[name] for name in ("bar_horizontal", "bar_vertical", "bar_direction_deg")]
        simulated, formula = _place([row.simulated for row in wanted]), _place([row.theory for row in wanted])
        places.append(ReadingPlaces(reading, stiffness, simulated, formula))
    return tuple(places)


def _place(values: list[float | None]) -> BarPlace | None:
    horizontal, vertical, degrees = values
    if horizontal is None or vertical is None or degrees is None:
        return None
    return BarPlace(horizontal, vertical, math.radians(degrees))
