"""The bar directions for a radial strike and for the fastest tip, found by simulation and compared
with formulas and printed values; and maps of the strike over the bar's position.

According to the dissertation a single direction, A + theta_1 + gamma (Zhang 2020, eq. 2.1), gives a
strike that is both radial and fastest. A is the angle by which the tip lags the root, seen from the
hub's centre, at the release; theta_1 is the angle that the hub turns until the bristle is fastest;
gamma is the impact angle.
"""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import UNKNOWN, Report, Values, rows
from bristle_sim.dissertation.printed import printed_cue
from bristle_sim.parameters import Bar, MapGrid, Tool
from bristle_sim.readable import amount
from bristle_sim.settings import Settings
from bristle_sim.studies import bar_search
from bristle_sim.studies.many_passes import checked_by_scene
from bristle_sim.studies.strike_measures import STATE, beside_radial
from bristle_sim.studies.strike_point import strike_measures, strikes_of_keys
from bristle_sim.studies.sweep_point import FAILURE
from bristle_sim.studies.whole_pass import reference_accuracy, require_rigid
from bristle_sim.theory import cueing

QUANTITIES = {
    "bar_direction_for_radial_strike_deg": ("bar's direction for a radial strike", "deg"),
    "bar_horizontal": ("bar along the workpart S_H", "m"),
    "bar_vertical": ("bar normal to the workpart S_V", "m"),
    "relative_speed_at_contact": STATE["relative_speed_at_contact"],
    "tip_speed_at_contact": STATE["tip_speed_at_contact"],
    "bar_direction_for_highest_tip_speed_deg": ("bar's direction for the fastest tip", "deg"),
    "highest_tip_speed": ("highest tip speed", "m/s"),
}

# The reference is solved at directions of the bar that differ by these angles (rad) from the
# directions found by simulation. SECANT: two directions, between which linear interpolation finds
# the radial strike to 1e-10. PARABOLA: three directions, whose parabola has the highest tip speed,
# to 1e-6.
SECANT = 1e-5
PARABOLA = 1e-3

CHECKED_RANGE = math.radians(5.0)
"""Passes are checked by simulation at directions of the bar within this angle (rad) of the
direction for a radial strike."""


@dataclass(frozen=True, slots=True)
class CueMap:
    """Results of the study, from which its maps are drawn.

    Attributes:
        tool: the tool.
        settings: accuracy and limits of the simulated passes.
        grid: size and resolution of the maps.
        radial: direction of the bar at which the bristle is radial when it strikes.
        fastest: direction of the bar at which the tip strikes fastest.
        formula: direction of the bar that the cue formula gives, rad; None for a belt without
            stiffness.
    """

    tool: Tool
    settings: Settings
    grid: MapGrid
    radial: bar_search.Place
    fastest: bar_search.Place
    formula: float | None

    @property
    def marks(self) -> dict[str, float]:
        """Directions of the bar that the maps show (rad), by name.

        The first is the direction of the tool's own bar.
        """
        bar = bar_search.bar_of(self.tool)
        own = "printed position" if bar == Bar() else "the tool's bar"
        found = {own: math.atan2(bar.horizontal, bar.vertical)}
        if self.formula is not None:
            found["by the formula"] = self.formula
        return found | {
            "radial strike": self.radial.direction,
            "fastest tip at this distance": self.fastest.direction,
        }


def cue_map(
    tool: Tool, settings: Settings, grid: MapGrid | None = None, *, with_reference: bool = True
) -> Report:
    """Find the bar's direction for a radial strike, and its direction for the highest tip speed.

    The two directions are compared with each other and with the cue formula. ``grid`` holds extent
    and resolution of the maps. ``with_reference`` states whether the independent reference solver
    also finds both directions.

    Raises:
        NotCuedError: if no direction gives a radial strike.
        ValueError: if the tool has no bar or workpart, the wire bends, or the bar is at a distance
            at which it does not retract the bristle.
    """
    require_rigid(tool)
    started = clock.perf_counter()
    strikes, step = bar_search.strikes_of(tool, settings)
    radial = bar_search.radial_place(tool, strikes, step)
    fastest = bar_search.fastest_place(strikes, step, radial.direction)
    theory = UNKNOWN
    printed = UNKNOWN
    referred = UNKNOWN
    within: Values = UNKNOWN
    formula = None
    if tool.belt.stiffness:  # by the formula the radial and the fastest strike are the same
        cue = cueing.cue(tool, bar_search.retraction(tool))
        formula = cue.bar_direction
        speed = cue.highest_relative_speed
        tip = tool.bristle.length * (tool.hub.speed + speed) + tool.hub.radius * tool.hub.speed
        place = bar_search.Place(
            formula, {"relative_speed_at_contact": speed, "tip_speed_at_contact": tip}
        )
        theory = _named(tool, place, place)
    if tool == Tool():
        names = (
            "relative_speed_at_contact",
            "bar_direction_for_radial_strike_deg",
            "bar_horizontal",
            "bar_vertical",
        )
        printed = dict(zip(names, printed_cue().values(), strict=True))
    if with_reference:
        referred = _referred(tool, settings, radial, fastest)
        # A relative error of the motion changes the bar's direction by about the same angle. The
        # relative error of S_V is larger by S_H/S_V, that of S_H by S_V/S_H.
        tolerance = 10.0 * max(1e-8, settings.accuracy)
        steep = abs(math.tan(radial.direction))
        within = dict.fromkeys(QUANTITIES, tolerance) | {
            "bar_vertical": tolerance * max(1.0, steep),
            "bar_horizontal": tolerance * max(1.0, 1.0 / max(steep, 1e-300)),
            "bar_direction_for_highest_tip_speed_deg": tolerance
            + 4.0 * bar_search.FINEST_MAXIMUM / fastest.direction,
        }

    def values_of(fractions: Array) -> dict[str, Array]:
        offsets = CHECKED_RANGE * (2.0 * fractions[0] - 1.0)
        return bar_search.centre_of(tool, radial.direction + offsets)

    check = checked_by_scene(tool, settings, np.array([0.5]), values_of)
    found = CueMap(tool, settings, grid or MapGrid(), radial, fastest, formula)
    stiffened = math.degrees(bar_search.stiffened_direction(tool))
    simulated = _named(tool, radial, fastest)
    return Report(
        quantities=rows(QUANTITIES, simulated, theory, referred, printed, within),
        remarks=(f"the formula with centrifugal stiffening: {stiffened:.3f} deg",),
        subject=found,
        answer=f"{_found_in_words(found)} {_where_it_stands(found, strikes)}; {check}.",
        wall_s=clock.perf_counter() - started,
    )


def _referred(
    tool: Tool, settings: Settings, radial: bar_search.Place, fastest: bar_search.Place
) -> Values:
    """Return the study's quantities, computed with the independent reference solver.

    The solver computes passes with directions of the bar close to ``radial`` and ``fastest``, the
    two directions found by simulation. Linear interpolation of the lag gives the direction of a
    radial strike. A parabola through tip speeds gives the direction of the highest tip speed.
    """
    from bristle_sim.reference import simulate_reference

    options: dict[str, Any] = {"accuracy": reference_accuracy(settings), "stop_after": "strike"}

    def strikes(directions: Array) -> dict[str, Array]:
        """Return measures of strikes by the reference solver, for directions of the bar (rad)."""
        tools = [bar_search.placed(tool, float(each)) for each in directions]
        found = [strike_measures(each, simulate_reference(each, **options)) for each in tools]
        names = ("lag_deg_at_contact", "relative_speed_at_contact", "tip_speed_at_contact")
        return {name: np.array([each[name] for each in found]) for name in names}

    offsets = SECANT * np.array([-1.0, 1.0])
    beside = strikes(radial.direction + offsets)
    low, high = beside["lag_deg_at_contact"]
    part = low / (low - high)
    measures = {name: float(a + part * (b - a)) for name, (a, b) in beside.items()}
    root = radial.direction + float(offsets[0] + part * (offsets[1] - offsets[0]))
    around = PARABOLA * np.array([-1.0, 0.0, 1.0])
    speeds = strikes(fastest.direction + around)["tip_speed_at_contact"]
    bend, slope, height = np.polyfit(around, speeds, 2).tolist()
    top = {"tip_speed_at_contact": height - 0.25 * slope**2 / bend}
    best = bar_search.Place(fastest.direction - 0.5 * slope / bend, top)
    return _named(tool, bar_search.Place(root, measures), best)


def _found_in_words(found: CueMap) -> str:
    direction = math.degrees(found.radial.direction)
    apart = math.degrees(found.fastest.direction) - direction
    best = (
        "there the tip is also fastest"
        if abs(apart) < 0.05
        else f"the tip is fastest {apart:+.2f}° from there"
    )
    bar = bar_search.bar_of(bar_search.placed(found.tool, found.radial.direction))
    side = "below" if bar.vertical >= 0.0 else "above"
    place = f"{1e3 * bar.horizontal:.2f} mm before the hub's axis and {1e3 * abs(bar.vertical):.2f} mm {side} it"
    return (
        f"For a radial strike the bar must stand at {direction:.2f}° from the workpart's normal, {place}; {best},"
        f" {amount(found.fastest.strike['tip_speed_at_contact'], 'm/s')}."
    )


def _where_it_stands(found: CueMap, strikes: bar_search.Strikes) -> str:
    own = next(iter(found.marks.values()))
    strike = strikes(np.array([own]))
    stands = f"In its present place, at {math.degrees(own):.2f}°"
    if strike[FAILURE][0]:
        return f"{stands}, there is no cued strike: {strike[FAILURE][0]}"
    lag = float(strike["lag_deg_at_contact"][0])
    printed = " as printed" if found.tool == Tool() else ""
    return f"{stands}{printed}, the strike is {beside_radial(lag)}"


def _named(tool: Tool, radial: bar_search.Place, fastest: bar_search.Place) -> Values:
    """Return the study's quantities by name.

    Args:
        tool: the tool.
        radial: direction of the bar for a radial strike, with its strike.
        fastest: direction of the bar for the fastest tip, with its strike.
    """
    bar = bar_search.bar_of(bar_search.placed(tool, radial.direction))
    return {
        "bar_direction_for_radial_strike_deg": math.degrees(radial.direction),
        "bar_horizontal": bar.horizontal,
        "bar_vertical": bar.vertical,
        "relative_speed_at_contact": radial.strike["relative_speed_at_contact"],
        "tip_speed_at_contact": radial.strike["tip_speed_at_contact"],
        "bar_direction_for_highest_tip_speed_deg": math.degrees(fastest.direction),
        "highest_tip_speed": fastest.strike["tip_speed_at_contact"],
    }


def position_map(found: CueMap) -> tuple[Array, Array, dict[str, Array]]:
    """Compute the strikes for a grid of positions of the bar.

    The grid extends over the position of the tool's own bar and the positions that the study found.

    Returns:
        The coordinates S_H along the workpart and S_V normal to it (m), each ascending.
        The measures of the strikes by name, shape (S_V, S_H). They are NaN where the bristle does
            not strike after leaving the bar.
    """
    directions = np.array([*found.marks.values()])
    places = np.array([*bar_search.centre_of(found.tool, directions).values()])
    low, high = places.min(axis=1), places.max(axis=1)
    middle = 0.5 * (low + high)
    half = max(found.grid.half_width, ROOM * float((high - low).max()))
    offsets = np.linspace(-half, half, found.grid.points)
    horizontal, vertical = middle[:, np.newaxis] + offsets
    horizontal = horizontal[horizontal >= 0.0]
    centre = {"bar_horizontal": horizontal, "bar_vertical": vertical[:, np.newaxis]}
    return horizontal, vertical, strikes_of_keys(found.settings, found.tool, **centre)


# Least half-width of the maps, divided by the largest distance between the positions of the bar
# that they show. More than 0.5 leaves a margin.
ROOM = 0.6
