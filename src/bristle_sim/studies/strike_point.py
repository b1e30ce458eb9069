"""One point of a map or a sweep: a pass up to its strike, with some of the tool's parameters
changed.

A pass is the trip of one bristle past bar and workpart.
"""

import dataclasses
import math
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Bar, Tool
from bristle_sim.readable import finite
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.many_passes import ENTRY, OUTCOME, pass_quantities, unable
from bristle_sim.studies.strike_measures import IMPACT, STATE
from bristle_sim.studies.sweep_point import FAILURE, evaluate_in_turn
from bristle_sim.studies.whole_pass import measures_of, require_result
from bristle_sim.theory.crater_cutting import depth_from_energy
from bristle_sim.theory.crater_kinematics import PRINTED_FACE
from bristle_sim.theory.merchant import API_5L, specific_cutting_energy
from bristle_sim.trajectory import ContactRecord, Trajectory

STRIKE_UNITS = {
    **{
        name: (STATE | IMPACT)[name][1]
        for name in (*STATE, "normal_final_impulse", "normal_compressive_work")
    },
    "crater_depth": "m",
}
"""Unit of each measure of a strike after the bristle has left the bar."""


class NotCuedError(ValueError):
    """Raised for a pass without a cued strike.

    In a cued strike the bristle touches the bar, leaves it, and then strikes the workpart.
    """


def strike_of_keys(
    settings: Settings | None = None, tool: Tool | None = None, /, **values: float
) -> dict[str, float | None]:
    """Simulate a pass with some of the tool's parameters changed, and return the measures of its
    strike.

    ``STRIKE_UNITS`` lists the names and units of the measures. ``values`` are the changed
    parameters, by name.

    Raises:
        ValueError: if the run exceeds the step budget, or the bristle does not strike after leaving
            the bar.
    """
    settings = settings or Settings()
    tool = (tool or Tool()).replace(**values)
    run = simulate(tool, settings, stop_after="strike")
    require_result(run, settings)
    return strike_measures(tool, run)


def strikes_of_keys(settings: Settings, tool: Tool, **values: Any) -> dict[str, NDArray[Any]]:
    """Return the measures of the strikes of many tools, by name.

    ``STRIKE_UNITS`` lists the names and units of the measures. ``values`` are arrays of the
    parameters in which the tools differ, by name. The strikes are computed as arrays if the bristle
    is straight and rigid and the law is energetic; otherwise they are simulated one by one. If a
    bristle does not strike after leaving the bar, its measures are NaN, and ``failure`` has the
    reason.
    """
    if unable(tool):
        found = evaluate_in_turn(partial(strike_of_keys, settings, tool), values)
        unknown = np.full(found[FAILURE].shape, math.nan)
        return {**dict.fromkeys(STRIKE_UNITS, unknown), **found}
    found = pass_quantities(tool, settings, **values)
    cued = found["release_time"] < found["contact_time"]
    found["crater_depth"] = crater_depth(
        -found["normal_compressive_work"] - found["tangential_compressive_work"],
        values.get("friction", tool.workpart.friction if tool.workpart else 0.0),
        found[ENTRY],
        values.get("wire_diameter", tool.bristle.wire_diameter),
    )
    measures = {name: np.where(cued, found[name], math.nan) for name in STRIKE_UNITS}
    struck = np.isfinite(found["contact_time"])
    not_cued = "the bristle must touch the bar, and leave it, before it strikes the workpart"
    reason = np.where(struck, not_cued, found[OUTCOME].astype(object) + ": " + found[FAILURE])
    return measures | {FAILURE: np.where(cued, "", reason)}


def full_pass(tool: Tool, bar: Bar, settings: Settings) -> dict[str, Any]:
    """Simulate a pass with the given bar, and return the state of the bristle at its strike.

    The state is the lag (deg) and the angular velocity relative to the hub (rad/s), by name. Both
    are None if the bristle does not strike after leaving the bar; the entry ``no_strike`` then has
    the reason. Belt stiffness and direction of the bar are also returned.
    """
    direction = math.degrees(math.atan2(bar.horizontal, bar.vertical))
    row: dict[str, Any] = {"belt_stiffness": tool.belt.stiffness, "bar_direction_deg": direction}
    names = ("lag_deg_at_contact", "relative_speed_at_contact")
    try:
        turning = dataclasses.replace(settings, hub_turn=2.0 * math.pi)
        found = strike_of_keys(turning, dataclasses.replace(tool, bar=bar))
    except ValueError as error:
        return row | dict.fromkeys(names) | {"no_strike": str(error)}
    return row | {name: found[name] for name in names}


def strike_measures(tool: Tool, run: Trajectory) -> dict[str, float | None]:
    """Return the measures of the first strike of a pass, by name.

    ``STRIKE_UNITS`` lists the names and units. A measure that the contact law does not compute is
    None.

    Raises:
        NotCuedError: if the bristle does not strike, has not touched the bar before, or still
            touches it.
    """
    strike = run.first_contact("workpart")
    if strike is None:
        raise NotCuedError(f"the bristle must strike the workpart; it does not: {run.stop_reason}")
    found = dict(measures_of(tool, run))
    release = found["release_time"]
    if release is None:
        raise NotCuedError("the bristle must touch the bar before it strikes the workpart")
    if release >= strike.time:
        raise NotCuedError("the bristle must have left the bar when it strikes the workpart")
    friction = tool.workpart.friction if tool.workpart else 0.0
    found["crater_depth"] = crater_of(strike, friction, tool.bristle.wire_diameter)
    return {name: found[name] for name in STRIKE_UNITS}


def crater_of(contact: ContactRecord, friction: float, wire_diameter: float) -> float | None:
    """Return the depth (m) of the crater that a tip cuts along its velocity before the contact.

    ``friction`` is the coefficient of friction between chip and tip. The depth is None if the tip
    cuts no chip, or if the contact law does not compute work.
    """
    if contact.compressive_work is None:
        return None
    normal, tangential = contact.velocity_before
    entry = math.atan2(-normal, abs(tangential))
    depth = crater_depth(-sum(contact.compressive_work), friction, entry, wire_diameter)
    return finite(float(depth))


def crater_depth(
    lost: ArrayLike, friction: ArrayLike, entry: ArrayLike, wire_diameter: ArrayLike
) -> Array:
    """Return the depth of a crater (m) that the tip's energy loss in compression can cut.

    The tip is as wide as the wire. It cuts along its velocity into API 5L steel. The shear plane
    ends at the workpart's surface, which is inclined to the tip's path (theory/crater_cutting.py).
    The depth is NaN if no chip is cut: without friction, with a wire of zero diameter, or if the
    tip does not enter the workpart obliquely. The arguments broadcast.

    Args:
        lost: energy that the tip loses in compression, J.
        friction: coefficient of friction between chip and tip.
        entry: angle between the tip's velocity and the surface, rad.
        wire_diameter: diameter of the wire, m.
    """
    given = np.broadcast_arrays(lost, friction, entry, wire_diameter)
    cuts = (given[1] > 0.0) & (given[2] > 0.0) & (given[2] < 0.5 * math.pi) & (given[3] > 0.0)
    energy, rubbing, angle, width = (each[cuts] for each in given)
    specific = specific_cutting_energy(rubbing, angle, API_5L, "inclined")
    found = np.full(cuts.shape, math.nan)
    # Craters of wires of different diameters are geometrically similar, so the volume is
    # proportional to the cube of the diameter.
    size = width / PRINTED_FACE.short_axis
    found[cuts] = size * depth_from_energy(np.maximum(0.0, energy) / size**3, specific, angle)
    return found
