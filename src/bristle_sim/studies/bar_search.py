"""Search the simulation for directions of the bar: that of a radial strike (a root) and that of the fastest tip (a maximum).

The bar moves around the hub at its distance S = hypot(S_H, S_V), so that the retraction at release stays. Its direction from
the workpart's normal decides when the bristle is released; the lag at the strike falls as the direction grows.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar, toms748

from bristle_sim.parameters import Bar, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_point import NotCuedError, strike_measures, strike_of_keys
from bristle_sim.studies.whole_pass import GivenUpError, reference_accuracy
from bristle_sim.theory import cueing

Measures = dict[str, float | None]
Strike = Callable[[Tool], Measures]
"""Measures of the strike of a tool; raises NotCuedError where there is none."""

FINEST_DIRECTION = (
    1e-11  # Tolerance of a root, rad: errors of the lag at the finest accuracy are of this size
)
FINEST_MAXIMUM = 1e-5  # Tolerance of a maximum, rad: the speed changes by its square, which is below any accuracy
# First and largest step to bracket a root: the formulas miss it by a degree, and no range with an answer is under
# eight
FIRST_STEP = math.radians(1.0)
LARGEST_STEP = math.radians(8.0)
MOST_STEPS = 30  # Steps to either side: more than 180 degrees
# Successive passes, from the first on, that may be given up (each takes seconds): then the others would be, too
MOST_GIVEN_UP = 3
LAG_JUMP = 1e-4  # Lag in deg beyond which a sign change is no root but a jump of the lag: a bar that is just missed
# Lag in deg beyond radial that a bristle must reach somewhere: one that creeps to rest passes zero by rounding alone
SWUNG = 0.01


NOT_RADIAL = "bar_horizontal, bar_vertical: no direction at this distance gives a radial strike"


@dataclass(frozen=True, slots=True)
class Place:
    """A direction of the bar from the workpart's normal, rad, and the strike that it gives."""

    direction: float
    strike: Measures


def placed(tool: Tool, direction: float) -> Tool:
    """Return the tool with its bar in another direction at the same distance, rad."""
    bar = _bar_of(tool)
    distance = math.hypot(*bar.centre)
    return tool.replace(
        bar_horizontal=distance * math.sin(direction), bar_vertical=distance * math.cos(direction)
    )


def _bar_of(tool: Tool) -> Bar:
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: must both be there, or nothing is cued")
    return tool.bar


def radial_place(tool: Tool, strike: Strike, guess: float | None = None) -> Place:
    """Return the direction of the bar for a radial strike, by toms748 between two directions that enclose it.

    Raises:
        NotCuedError: if there is none, with the lags that were found.
        GivenUpError: if the first passes are given up.
    """

    @functools.cache
    def at(direction: float) -> Measures:
        return strike(placed(tool, direction))

    def lag(direction: float) -> float:
        return at(direction)["lag_deg_at_contact"] or 0.0

    low, high = _enclosed(lag, stiffened_direction(tool) if guess is None else guess)
    direction = float(toms748(lag, low, high, xtol=FINEST_DIRECTION, rtol=4e-15))
    if abs(lag(direction)) > LAG_JUMP:
        where = f"at {math.degrees(direction):.6g} deg"
        raise NotCuedError(f"{NOT_RADIAL}; {where} the lag jumps from one sign to the other")
    return Place(direction, at(direction))


def _enclosed(lag: Callable[[float], float], guess: float) -> tuple[float, float]:
    """Return two directions between which the lag falls through zero, the nearest to a guess."""
    lags = dict[float, float]()
    reasons = list[ValueError]()
    offsets = np.cumsum(
        FIRST_STEP * np.minimum(2.0 ** np.arange(MOST_STEPS), LARGEST_STEP / FIRST_STEP)
    )
    sides = (
        guess + offsets[offsets < math.pi - guess],
        [math.pi],
        guess - offsets[offsets < guess],
        [0.0],
    )
    tried = [guess, *np.concatenate(sides).tolist()]
    for direction in sorted(tried, key=lambda each: abs(each - guess)):
        try:
            lags[direction] = lag(direction)
        except ValueError as error:
            reasons.append(error)
            if (
                not lags
                and sum(isinstance(each, GivenUpError) for each in reasons) == MOST_GIVEN_UP
            ):
                raise
        if lags and min(lags.values()) < -SWUNG:
            for low, high in itertools.pairwise(sorted(lags)):
                if lags[low] >= 0.0 >= lags[high] and high - low <= LARGEST_STEP * 1.001:
                    return low, high
    if not lags:
        raise NotCuedError(
            f"bar_horizontal, bar_vertical: no direction at this distance cues the bristle; {reasons[0]}"
        )
    least, most = min(lags.values()), max(lags.values())
    raise NotCuedError(
        f"{NOT_RADIAL}; the bristle strikes with a lag of {least:.4g} to {most:.4g} deg"
    )


def fastest_place(tool: Tool, strike: Strike, start: float) -> Place:
    """Return the direction of the bar for the fastest tip, by Brent's method about a start, rad.

    Raises NotCuedError if the bar cues no strike at the start.
    """

    def slowness(direction: float) -> float:
        """Return the negative tip speed at the strike, m/s; 0 without a strike."""
        try:
            return -(strike(placed(tool, direction))["tip_speed_at_contact"] or 0.0)
        except ValueError:  # no strike there
            return 0.0

    step = 2.0 * FIRST_STEP
    middle = start
    best = slowness(start)
    while True:  # walk uphill until both neighbours are slower; the directions end at 0 and pi
        sides = [each for each in (middle - step, middle + step) if 0.0 < each < math.pi]
        values = [slowness(each) for each in sides]
        if min(values) >= best:
            break
        best, middle = min(zip(values, sides, strict=True))
    bounds = (max(middle - step, 0.0), min(middle + step, math.pi))
    found = minimize_scalar(
        slowness, bounds=bounds, method="bounded", options={"xatol": FINEST_MAXIMUM}
    )
    return Place(float(found.x), strike(placed(tool, float(found.x))))


def simulation(settings: Settings) -> Strike:
    """Return the function that simulates the strike of a tool."""
    return functools.partial(strike_of_keys, settings)


def reference_solution(settings: Settings) -> Strike:
    """Return the function that computes the strike of a tool by the independent solution."""
    from bristle_sim.reference import simulate_reference

    options: dict[str, Any] = {"accuracy": reference_accuracy(settings), "stop_after": "strike"}

    def strike(tool: Tool) -> Measures:
        run = simulate_reference(tool, **options)
        return strike_measures(tool, run)

    return strike


def retraction(tool: Tool) -> float:
    """Return the retraction at which the bristle slips off the bar, rad."""
    bar = _bar_of(tool)
    geometry = (tool.bar_reach, tool.hub.radius, tool.bristle.length)
    return float(cueing.retraction_at_bar(bar.horizontal, bar.vertical, *geometry))


def stiffened_direction(tool: Tool) -> float:
    """Return the stiffened formula's direction, rad."""
    return cueing.stiffened_cue(tool, retraction(tool)).bar_direction
