"""Answers of the bench, the interactive page of a tool, that need many simulated passes.

They are a map over two parameters, the values of a parameter at which the outcome changes, the
bar's position for a radial strike, a design, and a blasted surface.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from bristle_sim.arrays import Array
from bristle_sim.cli.limits import limits_in_words
from bristle_sim.cli.scenario import Scenario, build_parameters
from bristle_sim.conversion import exact_text
from bristle_sim.parameters import Tool, key_unit
from bristle_sim.passes.strike import OUTCOMES, REFUSED
from bristle_sim.readable import plain_number, readable_unit
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import placed, radial_place, strikes_of
from bristle_sim.studies.design import design
from bristle_sim.studies.limits import limits
from bristle_sim.studies.many_passes import OUTCOME, REASON, pass_quantities
from bristle_sim.studies.surface import surface
from bristle_sim.studies.whole_pass import QUANTITIES
from bristle_sim.units import Range

SETTINGS = Settings(accuracy=1e-6)  # of the passes in a map; their errors are far below one shade
CELLS = 40  # number of cells along each side of the coarse map
PARTS = 5  # number of fine cells along a side of a coarse cell
SHADES = 254  # number of steps of a map's colour scale
EXTREMES = (1.0, 99.0)
"""Percentiles of the values at the ends of the colour scale.

A single extreme value therefore does not darken a map."""


def map_of(pass_of: Scenario, assignments: Sequence[str], on: str, fine: str) -> dict[str, Any]:
    """Return the map of a quantity over two parameters, as data for the page.

    The coarse map is simulated at each of its points. The fine map divides each side of a coarse
    cell into PARTS. Its points are simulated in the cells where the outcome changes or a linear
    interpolation is wrong by a shade, and interpolated in the other cells.

    Args:
        pass_of: the scenario of the whole pass.
        assignments: assignments ``KEY=VALUE`` of the tool.
        on: JSON with ``x`` and ``y``, each a parameter and the ends of its range, and with ``of``,
            the name of the quantity.
        fine: "1" for the fine map, any other text for the coarse map.
    """
    asked = json.loads(on)
    tool = build_parameters(Tool, pass_of.values_of(assignments))
    ends = [_ends(pass_of, *asked[axis]) for axis in "xy"]

    def passes(*fractions: Array) -> tuple[Array, NDArray[Any], NDArray[Any]]:
        """Simulate passes, and return values of the quantity, indices of the outcomes, and reasons.

        A parameter's value is given as a fraction of its range, from 0 to 1.
        """
        places = {
            key: low + (high - low) * each
            for (key, low, high), each in zip(ends, fractions, strict=True)
        }
        found = pass_quantities(tool, SETTINGS, **places)
        codes = (found[OUTCOME][..., np.newaxis] == np.array(OUTCOMES)).argmax(axis=-1)
        values = np.full(codes.shape, np.nan)
        if asked["of"] in QUANTITIES:
            values = found[asked["of"]]
        return values, codes, found[REASON]

    rows, columns = np.indices((CELLS + 1, CELLS + 1)) / CELLS
    values, codes, reasons = passes(columns, rows)
    if (codes == REFUSED).all():
        raise ValueError(f"no map: {reasons[0, 0]}")
    computed = values.size
    numbers = values[np.isfinite(values)]
    low, high = np.percentile(numbers, EXTREMES) if numbers.size else (0.0, 0.0)
    if fine == "1":
        within = np.minimum(np.arange(CELLS * PARTS + 1) // PARTS, CELLS - 1)
        rows, columns = np.nonzero(_rough(values, codes, low, high)[np.ix_(within, within)])
        values, codes = _interpolated(values, codes)
        fractions = (columns / (CELLS * PARTS), rows / (CELLS * PARTS))
        values[rows, columns], codes[rows, columns], _ = passes(*fractions)
        computed += rows.size
    shades = np.clip(np.rint(SHADES * (values - low) / (high - low or 1.0)), 0, SHADES)
    label, unit = QUANTITIES.get(asked["of"], ("outcome", "1"))
    between = f", {computed} computed, the others interpolated to a shade" if fine == "1" else ""
    unit, size = readable_unit(unit, [low, high])
    texts = [f"{plain_number(each / size, 3)} {unit.replace('deg', '°')}" for each in (low, high)]
    return {
        "size": len(values),
        "shades": _coded(np.nan_to_num(shades, nan=SHADES + 1)),
        "outcomes": _coded(codes),
        "names": OUTCOMES,
        "present": np.unique(codes[np.isnan(values)]).tolist(),
        "low": texts[0] if numbers.size else "",
        "high": texts[1],
        "note": f"{label}: {values.size} points{between}",
    }


def _ends(pass_of: Scenario, key: str, *ends: str) -> tuple[str, float, float]:
    """Return a parameter's name and the ends of its range in SI units, from texts with units."""
    declared = pass_of.keys()[key][0]
    low, high = (float(declared.parse(each)) for each in ends)
    return key, low, high


def _coded(numbers: Array) -> str:
    return base64.b64encode(numbers.astype(np.uint8).tobytes()).decode("ascii")


def _rough(values: Array, codes: NDArray[Any], low: float, high: float) -> NDArray[np.bool_]:
    """Return the coarse cells in which a linear interpolation may be wrong by more than a shade.

    These are cells whose corners differ in outcome, and cells where the interpolation error, h^2
    f''/8 along each side h, is too large. ``low`` and ``high`` are the ends of the colour scale.
    """
    kinds = 2 * codes + np.isnan(values)
    rough = maximum_filter(kinds, 3) != minimum_filter(kinds, 3)
    for axis, edges in enumerate(([[1, 1], [0, 0]], [[0, 0], [1, 1]])):
        bend = np.pad(np.diff(values, 2, axis=axis), edges, "edge")
        rough |= np.abs(bend) / 4.0 > (high - low) / SHADES
    return np.asarray(rough[1:, 1:] | rough[:-1, 1:] | rough[1:, :-1] | rough[:-1, :-1])


def _interpolated(values: Array, codes: NDArray[Any]) -> tuple[Array, NDArray[Any]]:
    """Interpolate a coarse map to the fine points: the values linearly, the outcomes by the nearest
    point.
    """
    place = np.arange(CELLS * PARTS + 1) / PARTS
    weights = np.maximum(0.0, 1.0 - np.abs(place[:, np.newaxis] - np.arange(CELLS + 1)))
    nearest = np.ix_(*2 * [np.rint(place).astype(int)])
    between = weights @ np.nan_to_num(values) @ weights.T
    return np.where(np.isnan(values)[nearest], np.nan, between), codes[nearest]


def limits_of(pass_of: Scenario, assignments: Sequence[str], on: str) -> dict[str, Any]:
    """Find the values of the map's first parameter at which the outcome changes; return a sentence."""
    tool = build_parameters(Tool, pass_of.values_of(assignments))
    key, low, high = _ends(pass_of, *json.loads(on)["x"])
    declared = pass_of.keys()[key][0]
    assert isinstance(declared, Range)
    found = limits(tool, accuracy=SETTINGS.accuracy, **{key: (low, high)})
    return {"answer": limits_in_words(declared, min(low, high), max(low, high), found)}


def design_of(pass_of: Scenario, assignments: Sequence[str], on: str) -> dict[str, Any]:
    """Find the tool whose pass has the wanted quantities; return its parameters and a sentence.

    The two parameters of the map are varied in the ranges of the map.
    """
    asked = json.loads(on)
    tool = build_parameters(Tool, pass_of.values_of(assignments))
    ranges = [_ends(pass_of, *asked[axis]) for axis in "xy"]
    found = design(tool, want=asked["want"], vary={key: (low, high) for key, low, high in ranges})
    return {
        "answer": " ".join([found.answer, *found.remarks]),
        "assignments": {
            key: exact_text(value, key, key_unit(key)) for key, value in found.varied.items()
        },
    }


def radial_bar(pass_of: Scenario, assignments: Sequence[str]) -> dict[str, Any]:
    """Return the bar's position for which the strike is radial, as texts of its two coordinates.

    The bar keeps its distance from the hub's centre. In a radial strike the lag is zero.
    """
    values = pass_of.values_of(assignments)
    tool = build_parameters(Tool, values)
    strikes = strikes_of(tool, Settings(accuracy=values["accuracy"]))
    found = placed(tool, radial_place(tool, *strikes).direction).bar
    assert found is not None
    places = {"bar_horizontal": found.horizontal, "bar_vertical": found.vertical}
    return {"assignments": {key: f"{1e3 * each:.9g} mm" for key, each in places.items()}}


def surface_of(pass_of: Scenario, assignments: Sequence[str]) -> dict[str, Any]:
    """Simulate the surface that the tool blasts, and return its picture as PNG in base64."""
    from bristle_sim.render.style import save_figure
    from bristle_sim.render.surface_pictures import surface_figure

    made = surface(build_parameters(Tool, pass_of.values_of(assignments)))
    with TemporaryDirectory() as folder:
        path = save_figure(surface_figure(made), Path(folder) / "surface.png")
        return {"picture": base64.b64encode(path.read_bytes()).decode("ascii")}


KINDS: dict[str, Callable[..., dict[str, Any]]] = {
    "map": map_of,
    "limits": limits_of,
    "design": design_of,
    "radial": radial_bar,
    "surface": surface_of,
}
"""The functions that answer requests of the page, by the name of the request."""
