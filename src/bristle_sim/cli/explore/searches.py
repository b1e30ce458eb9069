"""Answers of the bench, the interactive page of a tool, that need many simulated passes.

They are a map over two parameters, the values of a parameter at which the outcome changes, the
bar's position for a radial strike, a design, and a blasted surface.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.cli.scenario import Scenario, Values, build_parameters
from bristle_sim.parameters import KEYS, Tool
from bristle_sim.passes.strike import OUTCOMES, REFUSED
from bristle_sim.readable import amount
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import centre_of, radial_place, strikes_of
from bristle_sim.studies.design import design
from bristle_sim.studies.limits import limits_in_words
from bristle_sim.studies.many_passes import OUTCOME, pass_quantities
from bristle_sim.studies.surface import surface
from bristle_sim.studies.sweep_point import FAILURE
from bristle_sim.studies.whole_pass import QUANTITIES
from bristle_sim.units import exact_text

SETTINGS = Settings(accuracy=1e-6)  # settings of a map's passes; errors are far below one shade
COARSE = 40
FINE = 200
"""Number of cells along each side of a map: while the user changes a parameter, and afterwards.

The coarse map is computed in 0.03 s, the fine one in 0.6 s."""
SHADES = 254  # number of steps of a map's colour scale
EXTREMES = (1.0, 99.0)
"""Percentiles of the values at the ends of the colour scale.

A single extreme value therefore does not darken a map."""


def map_of(pass_of: Scenario, typed: Values, on: str, fine: str) -> dict[str, Any]:
    """Return the map of a quantity over two parameters, as data for the page.

    Args:
        pass_of: the scenario that simulates a pass.
        typed: values of the tool, as texts or numbers by key.
        on: JSON text. Its entries ``x`` and ``y`` are lists of a parameter's key and the two ends
            of its range. Its entry ``of`` is the name of the quantity.
        fine: "1" for the fine map, any other text for the coarse map.
    """
    asked = json.loads(on)
    tool = build_parameters(Tool, pass_of.values_of(typed))
    lines = []
    for key, *ends in (asked["x"], asked["y"]):
        low, high = (float(pass_of.keys()[key].parse(each)) for each in ends)
        lines.append(np.linspace(low, high, 1 + (FINE if fine == "1" else COARSE)))
    # Both axes may show the same parameter; the map then varies along the second axis alone.
    places = dict(zip((asked["x"][0], asked["y"][0]), np.meshgrid(*lines), strict=True))
    found = pass_quantities(tool, SETTINGS, **places)
    codes = (found[OUTCOME][..., np.newaxis] == np.array(OUTCOMES)).argmax(axis=-1)
    if (codes == REFUSED).all():
        raise ValueError(f"no map: {found[FAILURE][0, 0]}")
    label, unit = QUANTITIES.get(asked["of"], ("outcome", "1"))
    values = found[asked["of"]] if asked["of"] in QUANTITIES else np.full(codes.shape, np.nan)
    numbers = values[np.isfinite(values)]
    low, high = np.percentile(numbers, EXTREMES) if numbers.size else (0.0, 0.0)
    shades = np.clip(np.rint(SHADES * (values - low) / (high - low or 1.0)), 0, SHADES)
    return {
        "size": len(values),
        "shades": _coded(np.nan_to_num(shades, nan=SHADES + 1)),
        "outcomes": _coded(codes),
        "names": OUTCOMES,
        "present": np.unique(codes[np.isnan(values)]).tolist(),
        "low": amount(low, unit) if numbers.size else "",
        "high": amount(high, unit),
        "note": f"{label}: {values.size} points",
    }


def _coded(numbers: Array) -> str:
    return base64.b64encode(numbers.astype(np.uint8).tobytes()).decode("ascii")


def limits_of(pass_of: Scenario, typed: Values, on: str) -> dict[str, Any]:
    """Return a sentence on the values of the map's first parameter at which the outcome changes.

    The arguments are those of :func:`map_of`; ``on`` is the JSON text that describes the map.
    """
    tool = build_parameters(Tool, pass_of.values_of(typed))
    key, *ends = json.loads(on)["x"]
    return {"answer": limits_in_words(tool, key, ends, SETTINGS.accuracy)[0]}


def design_of(pass_of: Scenario, typed: Values, on: str) -> dict[str, Any]:
    """Find a tool whose pass attains the target values, and return its parameters and a sentence.

    The two parameters of the map are varied in the ranges of the map. The arguments are those of
    :func:`map_of`. The JSON text ``on`` also has an entry ``want`` with the target values.
    """
    asked = json.loads(on)
    tool = build_parameters(Tool, pass_of.values_of(typed))
    vary = {key: ends for key, *ends in (asked["x"], asked["y"])}
    found = design(tool, want=asked["want"], vary=vary)
    return {
        "answer": " ".join([found.answer, *found.remarks]),
        "assignments": {
            key: exact_text(value, key, KEYS[key].unit) for key, value in found.varied.items()
        },
    }


def radial_bar(pass_of: Scenario, typed: Values) -> dict[str, Any]:
    """Return the position of the bar for which the wire strikes radially, as texts by key.

    In a radial strike, the line from root to tip has the radial direction. The distance of the bar
    from the hub's centre is not changed. The arguments are those of :func:`map_of`.
    """
    values = pass_of.values_of(typed)
    tool = build_parameters(Tool, values)
    strikes = strikes_of(tool, Settings(accuracy=values["accuracy"]))
    places = centre_of(tool, radial_place(tool, *strikes).direction)
    return {"assignments": {key: f"{1e3 * each:.9g} mm" for key, each in places.items()}}


def surface_of(pass_of: Scenario, typed: Values) -> dict[str, Any]:
    """Simulate the surface that the tool blasts, and return its picture as PNG in base64.

    The arguments are those of :func:`map_of`.
    """
    from bristle_sim.render.style import save_figure
    from bristle_sim.render.surface_pictures import surface_figure

    made = surface(build_parameters(Tool, pass_of.values_of(typed)))
    with TemporaryDirectory() as folder:
        path = save_figure(surface_figure(made), Path(folder) / "surface.png")
        return {"picture": base64.b64encode(path.read_bytes()).decode("ascii")}
