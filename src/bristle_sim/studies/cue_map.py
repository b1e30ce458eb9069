"""The best directions of the bar, found by simulation and compared with formulas and print, and maps over its position.

The dissertation names one direction, A + theta_1 + gamma (Zhang 2020, eq. 2.1), for a strike both radial and fastest.
"""

from __future__ import annotations

import functools
import itertools
import logging
import math
import time as clock
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bristle_sim.comparison import UNKNOWN, Report, Values, amount, rows
from bristle_sim.dissertation.printed import printed_cue
from bristle_sim.parameters import MapGrid, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies import bar_search
from bristle_sim.studies.strike_measures import STATE, beside_radial
from bristle_sim.studies.strike_point import STRIKE_UNITS, strike_of_keys
from bristle_sim.studies.whole_pass import require_rigid
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

USUAL_PASSES = 12  # Passes that a search usually takes


@dataclass(frozen=True, slots=True)
class CueMap:
    """The tool, its best places, and the formula's direction, rad, which is None for a belt without stiffness."""

    tool: Tool
    settings: Settings
    grid: MapGrid
    radial: bar_search.Place
    fastest: bar_search.Place
    formula: float | None


def cue_map(
    tool: Tool, settings: Settings, grid: MapGrid | None = None, *, with_reference: bool = True
) -> Report:
    """Find the directions of the bar for a radial strike and for the highest tip speed, and compare them.

    Raises:
        NotCuedError: if no direction gives a radial strike.
        ValueError: if the tool has no bar or workpart, a wire that bends, or a bar whose distance allows no retraction.
    """
    require_rigid(tool)
    started = clock.perf_counter()
    usual = 2 * USUAL_PASSES
    strike = _logged(bar_search.simulation(settings), usual * (1 + with_reference))
    radial = bar_search.radial_place(tool, strike)
    fastest = bar_search.fastest_place(tool, strike, radial.direction)
    simulated = _named(tool, radial, fastest)
    theory = UNKNOWN
    referred = UNKNOWN
    printed = UNKNOWN
    if with_reference:
        independent = _logged(bar_search.reference_solution(settings), usual)
        found = bar_search.radial_place(tool, independent, radial.direction)
        referred = _named(
            tool, found, bar_search.fastest_place(tool, independent, radial.direction)
        )
    # An error of the motion turns the bar by about as much; S_V magnifies that by S_H/S_V.
    tolerance = 10.0 * max(1e-8, settings.accuracy)
    steep = abs(math.tan(radial.direction))
    within = dict.fromkeys(QUANTITIES, tolerance) | {
        "bar_vertical": tolerance * max(1.0, steep),
        "bar_horizontal": tolerance * max(1.0, 1.0 / max(steep, 1e-300)),
        "bar_direction_for_highest_tip_speed_deg": tolerance
        + 4.0 * bar_search.FINEST_MAXIMUM / fastest.direction,
    }
    if tool == Tool():
        names = (
            "relative_speed_at_contact",
            "bar_direction_for_radial_strike_deg",
            "bar_horizontal",
            "bar_vertical",
        )
        printed = dict(zip(names, printed_cue().values(), strict=True))
    cue = cueing.cue(tool, bar_search.retraction(tool)) if tool.belt.stiffness else None
    if cue is not None:  # in it the radial and the fastest strike are the same
        speed = cue.highest_relative_speed
        tip = tool.bristle.length * (tool.hub.speed + speed) + tool.hub.radius * tool.hub.speed
        place = bar_search.Place(
            cue.bar_direction, {"relative_speed_at_contact": speed, "tip_speed_at_contact": tip}
        )
        theory = _named(tool, place, place)
    return Report(
        quantities=rows(
            QUANTITIES, simulated, theory, referred, printed, within.get if with_reference else None
        ),
        remarks=(
            f"the formula with centrifugal stiffening: {math.degrees(bar_search.stiffened_direction(tool)):.3f} deg",
        ),
        subject=CueMap(
            tool,
            settings,
            grid or MapGrid(),
            radial,
            fastest,
            None if cue is None else cue.bar_direction,
        ),
        answer=f"{_found_in_words(simulated)} {_where_it_stands(tool, strike)}",
        wall_s=clock.perf_counter() - started,
    )


def _found_in_words(simulated: Values) -> str:
    found = {name: value or 0.0 for name, value in simulated.items()}
    direction = found["bar_direction_for_radial_strike_deg"]
    apart = found["bar_direction_for_highest_tip_speed_deg"] - direction
    fastest = (
        "there the tip is also fastest"
        if abs(apart) < 0.05
        else f"the tip is fastest {apart:+.2f}° from there"
    )
    horizontal, vertical = (1e3 * found[name] for name in ("bar_horizontal", "bar_vertical"))
    side = "below" if vertical >= 0.0 else "above"
    place = f"{horizontal:.2f} mm before the hub's axis and {abs(vertical):.2f} mm {side} it"
    return (
        f"The bar must stand at {direction:.2f}° from the workpart's normal, {place}; {fastest},"
        f" {amount(found['highest_tip_speed'], 'm/s')}."
    )


def _where_it_stands(tool: Tool, strike: bar_search.Strike) -> str:
    assert tool.bar is not None
    stands = math.degrees(math.atan2(tool.bar.horizontal, tool.bar.vertical))
    try:
        lag = strike(tool)["lag_deg_at_contact"] or 0.0
    except ValueError as error:
        return f"Where it stands, at {stands:.2f}°, there is no cued strike: {error}."
    return f"Where it stands, at {stands:.2f}°{' as printed' if tool == Tool() else ''}, the strike is {beside_radial(lag)}."


def _logged(strike: bar_search.Strike, usual: int) -> bar_search.Strike:
    """Log each pass that is finished, and the usual number of passes."""
    counter = itertools.count(1)

    def logged(tool: Tool) -> bar_search.Measures:
        measures = strike(tool)
        logging.getLogger(__name__).info("pass %d of some %d finished", next(counter), usual)
        return measures

    return logged


def _named(tool: Tool, radial: bar_search.Place, fastest: bar_search.Place) -> Values:
    bar = bar_search.placed(tool, radial.direction).bar
    assert bar is not None
    strike = radial.strike
    highest = fastest.strike["tip_speed_at_contact"]
    place = (math.degrees(radial.direction), bar.horizontal, bar.vertical)
    speeds = (strike["relative_speed_at_contact"], strike["tip_speed_at_contact"])
    return dict(
        zip(QUANTITIES, (*place, *speeds, math.degrees(fastest.direction), highest), strict=True)
    )


def position_map(tool: Tool, settings: Settings, grid: MapGrid) -> xr.Dataset:
    """Return measures of the strike over the bar's position, NaN where it cues none; needs the extra ``sweep``.

    The maps are centred on the bar's position.
    """
    try:
        from bristle_sim.studies.sweep import sweep
    except ImportError as error:
        raise ValueError(
            f"maps need the extra sweep: pip install bristle-sim[sweep] ({error})"
        ) from error
    assert tool.bar is not None
    offsets = np.linspace(-grid.half_width, grid.half_width, grid.points)
    horizontal = tool.bar.horizontal + offsets
    space = {
        "bar_vertical": tool.bar.vertical + offsets,
        "bar_horizontal": horizontal[horizontal >= 0.0],
    }
    point = functools.partial(strike_of_keys, settings, tool)
    units = {**STRIKE_UNITS, "bar_horizontal": "m", "bar_vertical": "m"}
    return sweep(point, space, units=units, workers=None if grid.workers == 1 else grid.workers)
