"""The best positions of the bar: directions found by simulation, compared with formulas and print; maps over position.

The dissertation names one direction, A + theta_1 + gamma (Zhang 2020, eq. 2.1), at which the strike should be radial and the
tip at its fastest.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import logging
import math
import time as clock
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from bristle_sim.comparison import Report, Table, Values, amount, rows
from bristle_sim.dissertation.printed import printed_cue
from bristle_sim.parameters import MapGrid, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import (
    FINEST_MAXIMUM,
    Measures,
    Place,
    Strike,
    fastest_place,
    placed,
    radial_place,
    reference_solution,
    retraction,
    simulation,
    stiffened_direction,
)
from bristle_sim.studies.strike_point import STATE, STRIKE_UNITS, beside_radial, require_rigid, strike_of_keys
from bristle_sim.theory import cueing

if TYPE_CHECKING:
    import xarray as xr

QUANTITIES = {
    "bar_direction_for_radial_strike_deg": ("bar's direction for a radial strike", "deg"),
    "bar_horizontal": ("bar along the workpart S_H", "m"),
    "bar_vertical": ("bar normal to the workpart S_V", "m"),
    "relative_speed_at_contact": STATE["relative_speed_at_contact"],
    "tip_speed_at_contact": STATE["tip_speed_at_contact"],
    "bar_direction_for_highest_tip_speed_deg": ("bar's direction for the fastest tip", "deg"),
    "highest_tip_speed": ("highest tip speed", "m/s"),
}

USUAL_PASSES = 12
"""Passes that a search usually takes."""

MOVES = {"hub_speed": (0.9, 1.1), "belt_stiffness": (0.8, 1.25), "belt_damping_ratio": (0.05, 0.1)}
"""Variations for which the answer is found again: factors on the tool's own value; damping ratios as they are."""


@dataclass(frozen=True, slots=True)
class CueMap:
    """The results: the tool, its places, the formula's direction, rad, and the sensitivity of the answer."""

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
        ValueError: if the tool has no bar or workpart, a wire that bends, or a bar whose distance allows no retraction.
    """
    require_rigid(tool)
    started = clock.perf_counter()
    passes = USUAL_PASSES * (2 + sum(map(len, MOVES.values())) + 2 * with_reference)
    strike = _logged(simulation(settings), passes)
    radial = radial_place(tool, strike)
    fastest, formula = fastest_place(tool, strike, radial.direction), _formula(tool)
    moves, simulated = _moves(tool, strike, radial.direction), _named(tool, radial, fastest)
    referred, printed, within = dict[str, float | None](), dict[str, float](), dict[str, float]()
    if with_reference:
        independent = _logged(reference_solution(settings), 2 * USUAL_PASSES)
        found = radial_place(tool, independent, radial.direction)
        referred = _named(tool, found, fastest_place(tool, independent, radial.direction))
        # An error of the motion turns the bar by about as much; S_V magnifies that by S_H/S_V.
        tolerance, steep = 10.0 * max(1e-8, settings.accuracy), abs(math.tan(radial.direction))
        within = dict.fromkeys(QUANTITIES, tolerance) | {
            "bar_vertical": tolerance * max(1.0, steep),
            "bar_horizontal": tolerance * max(1.0, 1.0 / max(steep, 1e-300)),
            "bar_direction_for_highest_tip_speed_deg": 4.0 * FINEST_MAXIMUM / fastest.direction,
        }
    if tool == Tool():
        names = ("relative_speed_at_contact", "bar_direction_for_radial_strike_deg", "bar_horizontal", "bar_vertical")
        printed = dict(zip(names, printed_cue().values(), strict=True))
    theory = {} if formula is None else _by_formula(tool, formula)
    quantities = rows(QUANTITIES, simulated, theory, referred, printed, within.get)
    head = ("another", "value", "radial strike, deg", "formula, deg", "relative speed, rad/s")
    cells = [[f"{each:.5g}" if isinstance(each, float) else each or "none" for each in row.values()] for row in moves]
    now = _where_it_stands(tool, strike)
    return Report(
        outcome=None,
        quantities=quantities,
        wall_s=clock.perf_counter() - started,
        remarks=(f"the formula with centrifugal stiffening: {math.degrees(stiffened_direction(tool)):.3f} deg",),
        tables=(Table("how the direction moves", head, tuple(map(tuple, cells))),),
        extra={"moves": list(moves)},
        subject=CueMap(tool, settings, grid or MapGrid(), radial, fastest, formula, moves),
        answer=_answer(simulated, now),
    )


def _answer(simulated: Values, now: str) -> str:
    found = {name: value or 0.0 for name, value in simulated.items()}
    direction = found["bar_direction_for_radial_strike_deg"]
    apart = found["bar_direction_for_highest_tip_speed_deg"] - direction
    fastest = "there the tip is also fastest" if abs(apart) < 0.05 else f"the tip is fastest {apart:+.2f}° from there"
    horizontal, vertical = (f"{1e3 * found[name]:.2f} mm" for name in ("bar_horizontal", "bar_vertical"))
    place = f"{horizontal} before the hub's axis and {vertical} below it"
    return (
        f"The bar must stand at {direction:.2f}° from the workpart's normal, {place}; {fastest},"
        f" {amount(found['highest_tip_speed'], 'm/s')}. {now}"
    )


def _where_it_stands(tool: Tool, strike: Strike) -> str:
    assert tool.bar is not None
    stands = math.degrees(math.atan2(tool.bar.horizontal, tool.bar.vertical))
    try:
        lag = strike(tool)["lag_deg_at_contact"] or 0.0
    except ValueError as error:
        return f"Where it stands, at {stands:.2f}°, there is no cued strike: {error}."
    return f"Where it stands, at {stands:.2f}°{' as printed' if tool == Tool() else ''}, the strike is {beside_radial(lag)}."


def _logged(strike: Strike, usual: int) -> Strike:
    """Wrap the strike so that each pass is logged, with the time left if the usual number of passes take the mean so far."""
    started, counter = clock.perf_counter(), itertools.count(1)

    def logged(tool: Tool) -> Measures:
        measures, finished = strike(tool), next(counter)
        left = (clock.perf_counter() - started) / finished * max(usual - finished, 1)
        words = "pass %d of some %d finished, about %.0f s left"
        logging.getLogger(__name__).info(words, finished, max(usual, finished), left)
        return measures

    return logged


def _formula(tool: Tool) -> float | None:
    """Return the dissertation's direction, rad; None for a belt without stiffness, which it does not cover."""
    return cueing.cue(tool, retraction(tool)).bar_direction if tool.belt.stiffness else None


def _named(tool: Tool, radial: Place, fastest: Place) -> dict[str, float | None]:
    bar = placed(tool, radial.direction).bar
    assert bar is not None
    strike, highest = radial.strike, fastest.strike["tip_speed_at_contact"]
    place = (math.degrees(radial.direction), bar.horizontal, bar.vertical)
    speeds = (strike["relative_speed_at_contact"], strike["tip_speed_at_contact"])
    return dict(zip(QUANTITIES, (*place, *speeds, math.degrees(fastest.direction), highest), strict=True))


def _by_formula(tool: Tool, direction: float) -> Values:
    """Return the dissertation's values; in it the radial and the fastest strike are the same."""
    speed = cueing.cue(tool, retraction(tool)).highest_relative_speed
    tip = tool.bristle.length * (tool.hub.speed + speed) + tool.hub.radius * tool.hub.speed
    place = Place(direction, {"relative_speed_at_contact": speed, "tip_speed_at_contact": tip})
    return _named(tool, place, place)


def _moves(tool: Tool, strike: Strike, start: float) -> tuple[dict[str, Any], ...]:
    """Return the direction and tip speed of a radial strike at other hub speeds, stiffnesses and damping ratios."""
    own, found = {"hub_speed": tool.hub.speed, "belt_stiffness": tool.belt.stiffness}, []
    for key, value in ((key, own.get(key, 1.0) * choice) for key, choices in MOVES.items() for choice in choices):
        other, direction, speed = tool.replace(**{key: value}), None, None
        with contextlib.suppress(ValueError):  # the row says so by having no direction
            place = radial_place(other, strike, start)
            direction, speed = math.degrees(place.direction), place.strike["relative_speed_at_contact"]
        formula = _formula(other)
        names = ("key", "value", "bar_direction_for_radial_strike_deg", "theory", "relative_speed_at_contact")
        values = (key, value, direction, formula and math.degrees(formula), speed)
        found.append(dict(zip(names, values, strict=True)))
    return tuple(found)


def position_map(tool: Tool, settings: Settings, grid: MapGrid) -> xr.Dataset:
    """Return measures of the strike over the bar's position, NaN where it cues none; needs the extra ``sweep``.

    The maps are centred on the bar's position.
    """
    import numpy as np

    try:
        from bristle_sim.studies.sweep import sweep
    except ImportError as error:
        raise ValueError(f"maps need the extra sweep: pip install bristle-sim[sweep] ({error})") from error
    assert tool.bar is not None
    offsets = np.linspace(-grid.half_width, grid.half_width, grid.points)
    horizontal = tool.bar.horizontal + offsets
    space = {"bar_vertical": tool.bar.vertical + offsets, "bar_horizontal": horizontal[horizontal >= 0.0]}
    point = functools.partial(strike_of_keys, settings, tool)
    units = {**STRIKE_UNITS, "bar_horizontal": "m", "bar_vertical": "m"}
    return sweep(point, space, units=units, workers=None if grid.workers == 1 else grid.workers)
