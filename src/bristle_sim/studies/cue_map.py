"""Where the bar must stand: directions found on the simulation, and maps over its position.

The bar moves around the hub at its distance S = hypot(S_H, S_V), so that the retraction at release stays, and its direction
from the workpart's normal decides when the bristle is released. The strike is radial where the lag is zero: a root. The tip
is fastest near it: a maximum. The formulas (Zhang 2020, eq. 2.1) name the same direction, A + theta_1 + gamma.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import itertools
import math
import time as clock
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scipy.optimize import minimize_scalar, toms748

from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Tool
from bristle_sim.quantity import quantity, validate
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_point import (
    STRIKE_UNITS,
    NotCuedError,
    keys_of,
    simulated_strike,
    start_angle,
    strike_measures,
    strike_of_keys,
)
from bristle_sim.theory import cueing

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "CueMap",
    "MapGrid",
    "Place",
    "cue_map",
    "fastest_place",
    "named",
    "position_map",
    "radial_place",
    "simulation",
]

PRINTED = {
    "bar_direction_for_radial_strike_deg": math.degrees(math.atan2(0.05037, 0.0225)),
    "bar_horizontal": 0.05037,
    "bar_vertical": 0.0225,
    "relative_speed_at_contact": 845.6,
}
"""Zhang 2020, eqs. 2.2 and 2.3."""

Measures = dict[str, float | None]
Strike = Callable[[Tool], Measures]
"""Measures of the strike of a tool; raises NotCuedError where there is none."""

FINEST_DIRECTION = 1e-11
"""Interval in which a root is left, rad: errors of the lag at the finest accuracy are of this size."""

FINEST_MAXIMUM = 1e-5
"""Interval in which a maximum is left, rad: the speed changes by the square of it, below any accuracy."""

FIRST_STEP, LARGEST_STEP = math.radians(1.0), math.radians(8.0)
"""Steps by which a root is enclosed: a degree is what the formulas miss it by, and no answer is as narrow as eight."""

JUMP = 1e-4
"""Lag in deg at a root, beyond which it is a jump of the lag from one sign to the other: a bar that is just missed."""

SWUNG = 0.01
"""Lag in deg beyond radial that a bristle must reach somewhere: one that creeps to rest passes zero by rounding alone."""

MOVES = {
    "hub_speed": (0.9, 1.1),
    "belt_stiffness": (0.8, 1.25),
    "belt_damping_ratio": (0.05, 0.1),
}
"""Where the answer is found again: factors on the tool's own value, and the damping ratios themselves."""


@dataclass(frozen=True, slots=True)
class MapGrid:
    """Resolution of the maps, and the processes that compute them."""

    points: float = quantity(
        25.0, "map_points", "1", at_least=2.0, at_most=2000.0, source="chosen: points of each axis of the maps"
    )
    half_width: float = quantity(
        0.008, "map_half_width", "m", above=0.0, at_most=1e3, source="chosen: of the maps about the bar's position"
    )
    workers: float = quantity(
        1.0, "workers", "1", at_least=1.0, at_most=4096.0, source="chosen: processes for the maps"
    )

    def __post_init__(self) -> None:
        validate(self)
        for key, value in (("map_points", self.points), ("workers", self.workers)):
            if value != int(value):
                raise ValueError(f"{key} = {value!r}: must be a whole number (dimensionless)")


@dataclass(frozen=True, slots=True)
class Place:
    """A direction of the bar from the workpart's normal, rad, and the strike that it gives."""

    direction: float
    strike: Measures


@dataclass(frozen=True, slots=True)
class CueMap:
    """What pictures are made of: the tool, its places, the formula's direction (rad), and how the answer moves."""

    tool: Tool
    settings: Settings
    grid: MapGrid
    radial: Place
    fastest: Place
    formula: float | None
    moves: tuple[dict[str, Any], ...]


def cue_map(tool: Tool, settings: Settings, grid: MapGrid | None = None, *, with_reference: bool = True) -> Report:
    """Find the directions of the bar for a radial strike and for the highest tip speed, and compare them.

    Raises:
        NotCuedError: if no direction gives a radial strike.
        ValueError: if the tool has no bar or workpart, or the bar's distance from the hub allows no retraction.
    """
    started = clock.perf_counter()
    strike = simulation(settings)
    radial = radial_place(tool, strike)
    fastest = fastest_place(tool, strike, radial.direction)
    formula = _formula(tool)
    moves = tuple(_moves(tool, strike, radial.direction))
    return Report(
        outcome=None,
        quantities=_quantities(tool, settings, radial, fastest, formula, with_reference=with_reference),
        wall_s=clock.perf_counter() - started,
        remarks=_remarks(tool, strike, moves),
        extra={"moves": list(moves)},
        subject=CueMap(tool, settings, grid or MapGrid(), radial, fastest, formula, moves),
    )


def placed(tool: Tool, direction: float) -> Tool:
    """The tool with its bar in another direction at the same distance, rad."""
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: must both be there, or nothing is cued")
    distance = math.hypot(tool.bar.horizontal, tool.bar.vertical)
    horizontal, vertical = distance * math.sin(direction), distance * math.cos(direction)
    return dataclasses.replace(tool, bar=dataclasses.replace(tool.bar, horizontal=horizontal, vertical=vertical))


def radial_place(tool: Tool, strike: Strike, guess: float | None = None) -> Place:
    """The direction of the bar for which the bristle strikes radially, by toms748 between directions that enclose it.

    Raises:
        NotCuedError: if there is none, with what happens instead.
    """

    @functools.cache
    def at(direction: float) -> Measures:
        return strike(placed(tool, direction))

    def lag(direction: float) -> float:
        return at(direction)["lag_deg_at_contact"] or 0.0

    low, high = _enclosed(lag, _guess(tool) if guess is None else guess)
    direction = float(toms748(lag, low, high, xtol=FINEST_DIRECTION, rtol=4e-15))
    found = at(direction)
    if abs(found["lag_deg_at_contact"] or 0.0) > JUMP:
        raise NotCuedError(
            f"bar_horizontal, bar_vertical: no direction at this distance gives a radial strike; at"
            f" {math.degrees(direction):.6g} deg the lag jumps from one sign to the other"
        )
    return Place(direction, found)


def _enclosed(lag: Callable[[float], float], guess: float) -> tuple[float, float]:
    """Two directions between which the lag falls through zero: outwards from a guess, first to where that is likely."""
    lags: dict[float, float] = {}
    reasons: list[str] = []
    forwards, backwards = [*_outwards(guess, math.pi)], [*_outwards(guess, 0.0)]
    waiting = [guess]
    while waiting:
        direction = waiting.pop(0)
        try:
            lags[direction] = lag(direction)
        except NotCuedError as error:
            reasons.append(str(error))
        if direction == guess:
            first = lags.get(guess, 0.0)
            near, far = (forwards, backwards) if first >= 0.0 else (backwards, forwards)
            waiting = near + far if abs(first) > SWUNG else [near[0], far[0], *near[1:], *far[1:]]
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
        "bar_horizontal, bar_vertical: no direction at this distance gives a radial strike; the bristle strikes with a lag"
        f" of {least:.4g} to {most:.4g} deg"
    )


def _outwards(guess: float, end: float) -> Iterator[float]:
    """Directions from a guess to an end, near the guess in smaller steps, rad."""
    sign, step, offset = math.copysign(1.0, end - guess), FIRST_STEP, FIRST_STEP
    while offset < abs(end - guess):
        yield guess + sign * offset
        step = min(2.0 * step, LARGEST_STEP)
        offset += step
    yield end


def fastest_place(tool: Tool, strike: Strike, start: float) -> Place:
    """The direction of the bar for which the tip strikes fastest, by Brent's method about a start, rad.

    Raises:
        NotCuedError: if the bar cues no strike at the start.
    """

    def slowness(direction: float) -> float:
        try:
            return -(strike(placed(tool, direction))["tip_speed_at_contact"] or 0.0)
        except NotCuedError:
            return 0.0

    step = 2.0 * FIRST_STEP
    middle, best = start, slowness(start)
    while True:  # walk uphill until both neighbours are slower; the directions end at 0 and pi
        sides = [each for each in (middle - step, middle + step) if 0.0 < each < math.pi]
        values = [slowness(each) for each in sides]
        if min(values) >= best:
            break
        best, middle = min(zip(values, sides, strict=True))
    bounds = (max(middle - step, 0.0), min(middle + step, math.pi))
    found = minimize_scalar(slowness, bounds=bounds, method="bounded", options={"xatol": FINEST_MAXIMUM})
    return Place(float(found.x), strike(placed(tool, float(found.x))))


def simulation(settings: Settings) -> Strike:
    """The strike by the simulation."""

    def strike(tool: Tool) -> Measures:
        return strike_measures(tool, simulated_strike(tool, settings))

    return strike


def _referred(settings: Settings) -> Strike:
    """The same by the independent solution."""
    from bristle_sim.reference import simulate_reference

    def strike(tool: Tool) -> Measures:
        accuracy = max(1e-10, 0.1 * settings.accuracy)
        run = simulate_reference(tool, start_hub_angle=start_angle(tool), accuracy=accuracy, stop_after="strike")
        return strike_measures(tool, run)

    return strike


def _retraction(tool: Tool) -> float:
    """Retraction at which the bristle slips off the bar, rad."""
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: must both be there, or nothing is cued")
    geometry = (tool.hub.radius, tool.bristle.length)
    return float(cueing.retraction_at_bar(tool.bar.horizontal, tool.bar.vertical, tool.bar_reach, *geometry))


def _guess(tool: Tool) -> float:
    """The stiffened formula's direction, rad."""
    return cueing.stiffened_cue(tool, _retraction(tool)).bar_direction


def _formula(tool: Tool) -> float | None:
    """The dissertation's direction, rad; None for a belt without stiffness, which it does not cover."""
    return cueing.cue(tool, _retraction(tool)).bar_direction if tool.belt.stiffness else None


UNITS = {
    "bar_direction_for_radial_strike_deg": "deg",
    "bar_horizontal": "m",
    "bar_vertical": "m",
    "relative_speed_at_contact": "rad/s",
    "tip_speed_at_contact": "m/s",
    "bar_direction_for_highest_tip_speed_deg": "deg",
    "highest_tip_speed": "m/s",
}


def _quantities(
    tool: Tool, settings: Settings, radial: Place, fastest: Place, formula: float | None, *, with_reference: bool
) -> tuple[Quantity, ...]:
    simulated = named(tool, radial) | {
        "bar_direction_for_highest_tip_speed_deg": math.degrees(fastest.direction),
        "highest_tip_speed": fastest.strike["tip_speed_at_contact"],
    }
    theory = {} if formula is None else _by_formula(tool, formula)
    referred: Measures = {}
    if with_reference:
        strike = _referred(settings)
        referred = named(tool, radial_place(tool, strike, radial.direction))
        highest = fastest_place(tool, strike, radial.direction)
        referred["bar_direction_for_highest_tip_speed_deg"] = math.degrees(highest.direction)
        referred["highest_tip_speed"] = highest.strike["tip_speed_at_contact"]
    printed = PRINTED if tool == Tool() else {}
    # An error of the motion turns the bar by about as much; S_V magnifies that by S_H/S_V.
    tolerance = 10.0 * max(1e-8, settings.accuracy)
    steep = abs(math.tan(radial.direction))
    widened = {
        "bar_vertical": max(1.0, steep),
        "bar_horizontal": max(1.0, 1.0 / max(steep, 1e-300)),
        "bar_direction_for_highest_tip_speed_deg": 4.0 * FINEST_MAXIMUM / fastest.direction / tolerance,
    }
    return tuple(
        Quantity(
            name,
            unit,
            simulated[name],
            theory.get(name),
            referred.get(name),
            printed.get(name),
            tolerance * widened.get(name, 1.0) if name in referred else None,
        )
        for name, unit in UNITS.items()
    )


def named(tool: Tool, place: Place) -> Measures:
    """What is reported of a radial strike."""
    bar = placed(tool, place.direction).bar
    assert bar is not None
    return {
        "bar_direction_for_radial_strike_deg": math.degrees(place.direction),
        "bar_horizontal": bar.horizontal,
        "bar_vertical": bar.vertical,
        "relative_speed_at_contact": place.strike["relative_speed_at_contact"],
        "tip_speed_at_contact": place.strike["tip_speed_at_contact"],
    }


def _by_formula(tool: Tool, direction: float) -> Measures:
    """The dissertation's side: radial and fastest are one."""
    speed = cueing.cue(tool, _retraction(tool)).highest_relative_speed
    tip = tool.bristle.length * (tool.hub.speed + speed) + tool.hub.radius * tool.hub.speed
    strike: Measures = {"relative_speed_at_contact": speed, "tip_speed_at_contact": tip}
    both = named(tool, Place(direction, strike))
    return both | {"bar_direction_for_highest_tip_speed_deg": math.degrees(direction), "highest_tip_speed": tip}


def moved(tool: Tool, key: str, value: float) -> Tool:
    """The tool with another hub speed (rad/s), belt stiffness (N m/rad) or belt damping ratio."""
    if key == "hub_speed":
        return dataclasses.replace(tool, hub=dataclasses.replace(tool.hub, speed=value))
    return dataclasses.replace(tool, belt=dataclasses.replace(tool.belt, **{key.removeprefix("belt_"): value}))


def _moves(tool: Tool, strike: Strike, start: float) -> list[dict[str, Any]]:
    """The direction for a radial strike and its speed for other hub speeds, stiffnesses and damping ratios."""
    own = {"hub_speed": tool.hub.speed, "belt_stiffness": tool.belt.stiffness}
    rows = []
    for key, choices in MOVES.items():
        for choice in choices:
            value = own[key] * choice if key in own else choice
            other, found = moved(tool, key, value), None
            with contextlib.suppress(ValueError):  # the row says so by having no direction
                found = radial_place(other, strike, start)
            formula = _formula(other)
            rows.append(
                {
                    "key": key,
                    "value": value,
                    "bar_direction_for_radial_strike_deg": found and math.degrees(found.direction),
                    "theory": formula and math.degrees(formula),
                    "relative_speed_at_contact": found and found.strike["relative_speed_at_contact"],
                }
            )
    return rows


def _remarks(tool: Tool, strike: Strike, moves: tuple[dict[str, Any], ...]) -> tuple[str, ...]:
    assert tool.bar is not None
    stands = math.degrees(math.atan2(tool.bar.horizontal, tool.bar.vertical))
    stiffened = math.degrees(_guess(tool))
    try:
        lag = f"{strike(tool)['lag_deg_at_contact']:.4g} deg short of radial"
    except NotCuedError as error:
        lag = str(error)
    lines = [
        f"where the bar stands, {stands:.3f} deg: {lag}; the formula with centrifugal stiffening: {stiffened:.3f} deg",
        "",
        f"{'with another':<20} {'value':>10} {'direction, deg':>15} {'formula, deg':>13} {'relative rate, rad/s':>21}",
    ]
    for row in moves:
        numbers = (row["bar_direction_for_radial_strike_deg"], row["theory"], row["relative_speed_at_contact"])
        shown = ("none" if each is None else f"{each:.5g}" for each in numbers)
        direction, formula, rate = shown
        lines.append(f"{row['key']:<20} {row['value']:>10.5g} {direction:>15} {formula:>13} {rate:>21}")
    return tuple(lines)


def position_map(tool: Tool, settings: Settings, grid: MapGrid) -> xr.Dataset:
    """Measures of the strike over the bar's position, NaN where it cues none; needs the extra ``sweep``.

    The maps are centred on the bar's position.
    """
    import numpy as np

    try:
        from bristle_sim.studies.sweep import sweep
    except ImportError as error:
        raise ValueError(f"maps need the extra sweep: pip install bristle-sim[sweep] ({error})") from error
    assert tool.bar is not None
    offsets = np.linspace(-grid.half_width, grid.half_width, int(grid.points))
    fixed = {key: value for key, value in keys_of(tool).items() if key not in ("bar_horizontal", "bar_vertical")}
    horizontal = tool.bar.horizontal + offsets
    space = {"bar_vertical": tool.bar.vertical + offsets, "bar_horizontal": horizontal[horizontal >= 0.0]}
    point = functools.partial(strike_of_keys, settings, **fixed)
    units = {**STRIKE_UNITS, "bar_horizontal": "m", "bar_vertical": "m"}
    return sweep(point, space, units=units, workers=None if grid.workers == 1.0 else int(grid.workers))
