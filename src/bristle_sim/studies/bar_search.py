"""Search for the direction of the bar at which the strike is radial (a root), and for the direction
at which the tip is fastest (a maximum).

The bar is moved around the hub's centre at the constant distance S = hypot(S_H, S_V), with S_H
along the workpart and S_V normal to it. The retraction, the angle by which the bristle is behind
the radial direction when it slips off the bar, is therefore constant. The bar's direction is the
angle from the workpart's normal to the line from the hub's centre to the bar. It decides when the
bristle is released: the larger the direction, the smaller the bristle's lag behind the radial
direction when it strikes.
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
"""Function of directions of the bar (rad) that returns the measures of the strikes by name.

If a bristle does not strike after leaving the bar, its measures are NaN, and the entry FAILURE has
the reason."""

# Tolerance of the bar's direction for a radial strike, rad. It equals the error of the lag in
# passes of the finest accuracy.
FINEST_DIRECTION = 1e-11
# Tolerance of the direction for the fastest tip, rad. The relative error of the highest speed is
# about the square of the tolerance.
FINEST_MAXIMUM = 1e-5
# Step between the directions of a first survey, rad: STEP if the passes are computed in arrays,
# COARSE_STEP if they are simulated one by one. No interval of directions that give a strike is
# narrower than the step.
STEP = math.radians(0.5)
COARSE_STEP = math.radians(4.0)
# Largest magnitude of the lag at which a strike counts as radial, deg. At directions where the
# bristle just misses the bar, the lag jumps from positive to negative. Such a jump is no radial
# strike.
LAG_JUMP = 1e-4
# Angle, deg. A strike counts as radial only if, at some direction of the bar, the bristle strikes
# beyond the radial direction by more than this angle. An overdamped bristle that creeps towards the
# radial direction passes it by rounding error alone.
SWUNG = 0.01

NOT_RADIAL = "bar_horizontal, bar_vertical: no direction at this distance gives a radial strike"


@dataclass(frozen=True, slots=True)
class Place:
    """A direction of the bar, and the measures of the strike when the bar stands there.

    Attributes:
        direction: angle from the workpart's normal to the line from the hub's centre to the bar,
            rad.
        strike: measures of the strike, by name.
    """

    direction: float
    strike: Measures


def placed(tool: Tool, direction: float) -> Tool:
    """Return the tool with its bar moved around the hub's centre at constant distance.

    ``direction`` is the bar's new angle from the workpart's normal, rad.
    """
    return tool.replace(**centre_of(tool, direction))


def centre_of(tool: Tool, directions: Number) -> dict[str, Number]:
    """Return the coordinates of the bar's centre (m), by name, for directions of the bar (rad).

    The bar keeps its distance from the hub's centre.
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
        raise ValueError("bar, workpart: must both be parts of the tool")
    return tool.bar


def strikes_of(tool: Tool, settings: Settings) -> tuple[Strikes, float]:
    """Return a function that computes strikes for directions of the bar, and the step of a survey.

    Returns:
        The function: it takes directions of the bar (rad) and returns the measures of the strikes.
        The step between neighbouring directions in a first survey, rad. It is larger if the strikes
            are simulated one by one.
    """
    bar_of(tool)

    def strikes(directions: Array) -> Mapping[str, NDArray[Any]]:
        return strikes_of_keys(settings, tool, **centre_of(tool, directions))

    return strikes, COARSE_STEP if unable(tool) else STEP


def radial_place(tool: Tool, strikes: Strikes, step: float) -> Place:
    """Return the direction of the bar at which a bristle strikes radially, and this strike.

    If several directions give a radial strike, the result is the one nearest to the direction that
    the cue formula gives.

    Args:
        tool: the tool.
        strikes: function that computes strikes for directions of the bar.
        step: step of the first survey of directions, rad.

    Raises:
        NotCuedError: if no direction gives a radial strike. The message states the range of the
            lag, the bristle's angle behind the radial direction at the strike.
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
    """Return a direction of the bar (rad) with the measures of the strike that it gives.

    The measures are NaN if the bristle does not strike after leaving the bar.
    """
    found = strikes(np.array([direction]))
    measures = {name: float(each[0]) for name, each in found.items() if name != FAILURE}
    return Place(float(direction), measures)


def fastest_place(strikes: Strikes, step: float, start: float) -> Place:
    """Return the direction of the bar at which the tip strikes fastest, with this strike.

    The search climbs from the direction ``start`` (rad) in steps of ``step`` (rad) to the nearest
    maximum of the tip speed. Brent's method then refines this maximum.
    """
    directions = start + step * np.arange(-math.floor(start / step), (math.pi - start) / step)
    speeds = np.nan_to_num(strikes(directions)["tip_speed_at_contact"])
    speeds = np.pad(speeds, 1, constant_values=-1.0)
    middle = math.floor(start / step)
    while uphill := int(speeds[middle : middle + 3].argmax()) - 1:
        middle += uphill

    def slowness(direction: float) -> float:
        """Return the negative of the tip speed, m/s; 0 without a strike."""
        speed = _place(strikes, direction).strike["tip_speed_at_contact"]
        return -speed if math.isfinite(speed) else 0.0

    bounds = np.clip(directions[middle] + step * np.array([-1.0, 1.0]), 0.0, math.pi)
    found = minimize_scalar(
        slowness, bounds=bounds, method="bounded", options={"xatol": FINEST_MAXIMUM}
    )
    return _place(strikes, found.x)


def retraction(tool: Tool) -> float:
    """Return the retraction at which the bristle slips off the bar, rad.

    The retraction is the angle of the bristle behind the radial direction.
    """
    bar = bar_of(tool)
    geometry = (tool.bar_reach, tool.hub.radius, tool.bristle.length)
    return float(cueing.retraction_at_bar(bar.horizontal, bar.vertical, *geometry))


def stiffened_direction(tool: Tool) -> float:
    """Return the direction of the bar that the cue formula gives, rad.

    The formula includes the stiffness that the centrifugal force adds to the belt's stiffness.
    """
    return cueing.stiffened_cue(tool, retraction(tool)).bar_direction
