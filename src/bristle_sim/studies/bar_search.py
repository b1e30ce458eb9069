"""Search for the direction of the bar at which the strike is radial (a root), and for the direction
at which the tip is fastest (a maximum).

The bar moves around the hub at a constant distance S = hypot(S_H, S_V) from its centre, so that the
retraction at the release is constant. The bar's direction from the workpart's normal decides when
the bristle is released. The farther the direction is from the normal, the smaller is the lag at the
strike.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar, toms748

from bristle_sim.arrays import Array, Number
from bristle_sim.parameters import Bar, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.many_passes import unable
from bristle_sim.studies.strike_point import NotCuedError, strikes_of_keys
from bristle_sim.studies.sweep_point import FAILURE
from bristle_sim.theory import cueing

Measures = Mapping[str, float]
Strikes = Callable[[Array], Mapping[str, NDArray[Any]]]
"""Function of directions of the bar (rad) that returns the measures of the strikes; without a cued
strike they are NaN, and there is a reason."""

FINEST_DIRECTION = 1e-11  # Tolerance of the root, rad: the error of the lag at the finest accuracy
FINEST_MAXIMUM = (
    1e-5  # Tolerance of the maximum, rad: the speed changes by its square, less than any accuracy
)
# Distance between the directions of the first survey, rad: of passes in arrays, and of passes
# simulated one by one. No range of directions with a strike is narrower.
STEP = math.radians(0.5)
COARSE_STEP = math.radians(4.0)
LAG_JUMP = 1e-4  # Largest lag at a root, deg. Where the bristle just misses the bar the lag jumps: no root.
# Angle beyond radial, deg, that a bristle must reach for some direction. A bristle that creeps to
# rest passes radial by rounding error alone.
SWUNG = 0.01

NOT_RADIAL = "bar_horizontal, bar_vertical: no direction at this distance gives a radial strike"


@dataclass(frozen=True, slots=True)
class Place:
    """A direction of the bar from the workpart's normal (rad) and the measures of the strike that
    it gives.
    """

    direction: float
    strike: Measures


def placed(tool: Tool, direction: float) -> Tool:
    """Return the tool with its bar moved to another direction (rad) at the same distance from the
    hub's centre.
    """
    return tool.replace(**centre_of(tool, direction))


def centre_of(tool: Tool, directions: Number) -> dict[str, Number]:
    """Return the coordinates of the bar's centre by name (m) in given directions (rad) at the bar's
    distance from the hub's centre.
    """
    distance = math.hypot(*bar_of(tool).centre)
    return {
        "bar_horizontal": distance * np.sin(directions),
        "bar_vertical": distance * np.cos(directions),
    }


def bar_of(tool: Tool) -> Bar:
    """Return the tool's bar.

    Raises:
        ValueError: for a tool without bar or workpart.
    """
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: must both be there, or nothing is cued")
    return tool.bar


def strikes_of(tool: Tool, settings: Settings) -> tuple[Strikes, float]:
    """Return the function that computes the strikes for directions of the bar, and the distance of
    the directions in a first survey, rad.
    """
    bar_of(tool)

    def strikes(directions: Array) -> Mapping[str, NDArray[Any]]:
        return strikes_of_keys(settings, tool, **centre_of(tool, directions))

    return strikes, COARSE_STEP if unable(tool) else STEP


def radial_place(tool: Tool, strikes: Strikes, step: float) -> Place:
    """Return the direction of the bar for a radial strike, and that strike.

    Of several directions it is the one nearest to the direction by ``stiffened_direction``.

    Raises:
        NotCuedError: if no direction gives a radial strike; the message has the range of the lags.
    """
    guess = stiffened_direction(tool)
    directions = np.linspace(0.0, math.pi, math.ceil(math.pi / step) + 1)
    found = strikes(directions)
    lags = found["lag_deg_at_contact"]
    known = lags[np.isfinite(lags)]
    if not known.size:
        nearest = found[FAILURE][int(np.abs(directions - guess).argmin())]
        raise NotCuedError(
            f"bar_horizontal, bar_vertical: no direction at this distance cues the bristle; {nearest}"
        )
    falls = np.flatnonzero((lags[:-1] >= 0.0) & (lags[1:] <= 0.0))
    if not falls.size or known.min() > -SWUNG:
        words = f"the bristle strikes with a lag of {known.min():.4g} to {known.max():.4g} deg"
        raise NotCuedError(f"{NOT_RADIAL}; {words}")
    first = falls[np.abs(directions[falls] + 0.5 * step - guess).argmin()]

    def lag(direction: float) -> float:
        return _place(strikes, direction).strike["lag_deg_at_contact"]

    ends = directions[first : first + 2].tolist()
    place = _place(strikes, toms748(lag, *ends, xtol=FINEST_DIRECTION, rtol=4e-15))
    if not abs(place.strike["lag_deg_at_contact"]) <= LAG_JUMP:
        where = f"at {math.degrees(place.direction):.6g} deg"
        raise NotCuedError(f"{NOT_RADIAL}; {where} the lag jumps from one sign to the other")
    return place


def _place(strikes: Strikes, direction: float) -> Place:
    """Return a direction of the bar (rad) with the measures of its strike; they are NaN without a
    cued strike.
    """
    found = strikes(np.array([direction]))
    measures = {name: float(each[0]) for name, each in found.items() if name != FAILURE}
    return Place(float(direction), measures)


def fastest_place(strikes: Strikes, step: float, start: float) -> Place:
    """Return the direction of the bar at which the tip strikes fastest, together with that strike.

    The search goes from the direction ``start`` (rad) in steps to the next maximum of the speed,
    which Brent's method refines.
    """
    directions = start + step * np.arange(-math.floor(start / step), (math.pi - start) / step)
    speeds = np.nan_to_num(strikes(directions)["tip_speed_at_contact"])
    speeds = np.pad(speeds, 1, constant_values=-1.0)
    middle = math.floor(start / step)
    while uphill := int(speeds[middle : middle + 3].argmax()) - 1:
        middle += uphill

    def slowness(direction: float) -> float:
        speed = _place(strikes, direction).strike["tip_speed_at_contact"]
        return -speed if math.isfinite(speed) else 0.0

    bounds = np.clip(directions[middle] + step * np.array([-1.0, 1.0]), 0.0, math.pi)
    found = minimize_scalar(
        slowness, bounds=bounds, method="bounded", options={"xatol": FINEST_MAXIMUM}
    )
    return _place(strikes, found.x)


def retraction(tool: Tool) -> float:
    """Return the retraction at which the bristle slips off the bar, rad."""
    bar = bar_of(tool)
    geometry = (tool.bar_reach, tool.hub.radius, tool.bristle.length)
    return float(cueing.retraction_at_bar(bar.horizontal, bar.vertical, *geometry))


def stiffened_direction(tool: Tool) -> float:
    """Return the direction of the bar by the cue formula with centrifugal stiffening, rad."""
    return cueing.stiffened_cue(tool, retraction(tool)).bar_direction
