"""The contact stiffness and wire damping that would explain the high-speed film and the crater: a
map over stiffness and damping, and the pair of values whose strike comes nearest to both records.

Film and micrograph give three facts of a strike of a straight wire: it touches once, compression
lasts about 50 us, and the crater is 130 um deep. Neither the contact's stiffness nor the damping
was measured. The stiffness is stated here as the duration that the contact of a rigid bristle would
have. Each point of the map is a pass of a wire of links, simulated to half a millisecond after the
first touch. The wire already vibrates when it strikes.
"""

import dataclasses
import math
import time as clock
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Report, Table, rows
from bristle_sim.declared import UnusualValueWarning
from bristle_sim.parameters import FilmGrid, Tool
from bristle_sim.readable import amount
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.bent_bristles import slide_path
from bristle_sim.studies.crater_study import MEASURED as MEASURED_CRATER
from bristle_sim.studies.strike_point import crater_of
from bristle_sim.studies.sweep_point import FAILURE
from bristle_sim.studies.timed_contact import PRINTED_COMPRESSION, compression_end
from bristle_sim.studies.whole_pass import require_result, run_fields
from bristle_sim.theory.crater import CUTTING_FRICTION
from bristle_sim.trajectory import Trajectory

# Time simulated after the first touch, s: one and a half periods of the wire's first bending mode
FOLLOWED = 5e-4
# Measured values by film (Zhang 2020, sec. 3.3) and micrograph (fig. 4.13): number of touches; time
# from the first touch to its deepest penetration, s; depth of the deepest crater, m.
MEASURED = {
    "touches": 1.0,
    "compression_time": PRINTED_COMPRESSION,
    "crater_depth": MEASURED_CRATER,
}

MEASURES = {
    "touches": ("touches within 0.5 ms", "1"),
    "compression_time": ("compression time", "s"),
    "crater_depth": ("crater depth by energy", "m"),
    "forward_slide": ("slide forward in the first touch", "m"),
}
"""Measures of a strike at a point of the map: label and unit of each."""

NEAREST = {
    "nearest_contact_duration": ("nearest: contact of a rigid bristle", "s"),
    "nearest_wire_damping_ratio": ("nearest: damping ratio of the wire", "1"),
}
"""Position of the nearest point on the map: label and unit."""

# Largest relative difference from a measured value at which the value counts as explained. It is
# about the reading error of film and micrograph.
EXPLAINED = 0.1
# Contact duration of the passes that find the instant of the strike, s. The motion before the
# strike does not depend on it.
ANY_DURATION = 1e-4


@dataclass(frozen=True, slots=True)
class FilmMap:
    """A map of strike measures, and its point nearest to the measured values.

    The map extends over the damping of the wire and the duration of the contact.

    Attributes:
        grid: parameters of the map and of the camera.
        dampings: damping ratios of the wire's bending, one for each row of the map.
        durations: durations of a rigid bristle's contact (s), one for each column.
        results: measures at all points of the map, by name; NaN if there is no strike.
        nearest: row and column of the point whose measures are nearest to the measured values.
        tool: tool with the damping and contact duration of the nearest point.
        run: simulated pass of this tool.
    """

    grid: FilmGrid
    dampings: Array
    durations: Array
    results: dict[str, Array]
    nearest: tuple[int, int]
    tool: Tool
    run: Trajectory

    @property
    def frames(self) -> Array:
        """Instants at which the camera's shutter opens, s.

        They extend from half a millisecond before the strike to half a millisecond after it. The
        strike is midway between two of these instants.
        """
        strike = self.run.event_time("strike") or 0.0
        step = 1.0 / self.grid.frame_rate
        count = math.floor(FOLLOWED / step)
        return np.asarray(strike + step * (np.arange(-count, count) + 0.5))


def film(tool: Tool, grid: FilmGrid, settings: Settings) -> Report:
    """Compute maps of a strike's measures, and find the point nearest to the measured values.

    The measures are the touches, the compression time and the crater depth. The axes of a map are
    the duration of the contact and the damping of the wire. The tool of the nearest point is then
    varied in shape, number of links and friction. ``grid`` holds the points of the maps, and the
    settings of the camera.

    Raises:
        ValueError: if no pass of the map strikes, or the optional dependencies ``sweep`` are not
            installed.
    """
    started = clock.perf_counter()
    found = _mapped(tool, grid, settings)
    variants = _variants(found.tool, abs(tool.bristle.knee_angle_deg), settings)
    values = {name: float(each[found.nearest]) for name, each in found.results.items()}
    damping = found.dampings[found.nearest[0]]
    duration = found.durations[found.nearest[1]]
    values |= {"nearest_contact_duration": duration, "nearest_wire_damping_ratio": damping}
    axes = {"wire_damping_ratio": found.dampings, "contact_duration": found.durations}
    exposures = found.frames[:, np.newaxis] + np.linspace(0.0, grid.exposure, 11)
    tips = found.run.at(exposures).tip[..., 1].mean(axis=1) + found.tool.workpart_depth
    frames = zip(exposures[:, 5], tips, strict=True)
    return Report(
        quantities=rows(NEAREST | MEASURES, values, printed=MEASURED),
        **run_fields(found.run) | {"wall_s": clock.perf_counter() - started},
        remarks=(
            "printed: values by film and micrograph",
            *(_reached(name, found.results[name]) for name in MEASURED),
        ),
        tables=(_table(variants),),
        extra={
            "map": axes | found.results,
            "variants": variants,
            "frames": [{"time": time, "tip_height": height} for time, height in frames],
        },
        subject=found,
        answer=_answer(values, duration, damping),
    )


def _mapped(tool: Tool, grid: FilmGrid, settings: Settings) -> FilmMap:
    try:
        from bristle_sim.studies.sweep import sweep
    except ImportError as error:
        raise ValueError(
            f"film needs the extra sweep: pip install bristle-sim[sweep] ({error})"
        ) from error
    if tool.bristle.wire_diameter == 0.0:
        raise ValueError("wire_diameter = 0: must be more than 0, or the tip cuts nothing (in m)")
    straight = tool.replace(knee_angle_deg=0.0, contact="compliant")
    dampings = grid.largest_damping * np.linspace(0.0, 1.0, grid.dampings) ** 2
    durations = np.geomspace(grid.shortest, grid.longest, grid.durations)
    space = {"wire_damping_ratio": dampings, "contact_duration": durations}
    point = partial(simulate_variant, settings, straight)
    swept = sweep(point, space, workers=grid.workers, store=grid.store).load()
    unknown = np.full(swept[FAILURE].shape, math.nan)
    results = {name: swept[name].values if name in swept else unknown for name in MEASURES}
    missed = np.sum(
        [np.log(results[name] / value) ** 2 for name, value in MEASURED.items()], axis=0
    )
    if not np.isfinite(missed).any():
        raise ValueError(
            f"no pass of the map has a strike that is resolved in time; {swept['failure'].values.ravel()[0]}"
        )
    row, column = np.unravel_index(int(np.nanargmin(missed)), missed.shape)
    best = straight.replace(wire_damping_ratio=dampings[row], contact_duration=durations[column])
    return FilmMap(
        grid, dampings, durations, results, (int(row), int(column)), best, simulate(best, settings)
    )


@cache
def _strike_time(tool: Tool, settings: Settings) -> float:
    run = simulate(tool, settings, stop_after="strike")
    require_result(run, settings)
    if (contact := run.first_contact("workpart")) is None:
        raise ValueError(f"no strike: {run.stop_reason}")
    return contact.time


def simulate_variant(settings: Settings, tool: Tool, /, **keys: float) -> dict[str, float | None]:
    """Simulate a strike of the tool with some of its parameters changed, and return measures of the
    strike.

    ``MEASURES`` lists their names and units. The simulation ends half a millisecond after the first
    touch. Compression time and slide are None unless the contact law is ``compliant``.

    Args:
        settings: accuracy and limits of the simulation.
        tool: the tool.
        keys: values of the changed parameters, by name.

    Raises:
        ValueError: if the pass has no strike, or the solver fails.
    """
    with warnings.catch_warnings(
        action="ignore", category=UnusualValueWarning
    ):  # the user has not typed the values of the map
        tool = tool.replace(**keys)
        until = _strike_time(tool.replace(contact_duration=ANY_DURATION), settings) + FOLLOWED
    run = simulate(tool, dataclasses.replace(settings, hub_turn=tool.hub.speed * until))
    require_result(run, settings)
    touches = [each for each in run.contacts if each.obstacle == "workpart"]
    wire_diameter = tool.bristle.wire_diameter
    craters = (crater_of(each, CUTTING_FRICTION, wire_diameter) for each in touches)
    depths = [each for each in craters if each is not None]
    compression = slide = None
    if (history := touches[0].history) is not None:
        compression = compression_end(history)
        slide = float(slide_path(history).max())
    values = (float(len(touches)), compression, max(depths, default=None), slide)
    return dict(zip(MEASURES, values, strict=True))


def _variants(best: Tool, knee: float, settings: Settings) -> list[dict[str, Any]]:
    """Return the measures of variants of the tool ``best`` in shape, number of links or friction.

    ``knee`` is the angle of the bent shapes, deg. If a variant cannot be simulated, its entry
    ``failure`` has the reason.
    """
    links = best.bristle.links
    changes: dict[str, dict[str, float]] = {
        "straight": {},
        "reverse bent": {"knee_angle_deg": -knee},
        "forward bent": {"knee_angle_deg": knee},
        "rigid": {"wire_links": 1},
        **{
            f"{number} links": {"wire_links": number}
            for number in sorted({links // 2, 3 * links // 2} - {0, 1, links})
        },
        **{f"friction {value:g}": {"friction": value} for value in (0.2, 0.5)},
    }

    def one(keys: Mapping[str, float]) -> dict[str, Any]:
        try:
            return simulate_variant(settings, best, **keys) | {FAILURE: ""}
        except ValueError as error:
            return dict.fromkeys(MEASURES) | {FAILURE: str(error)}

    return [{"variant": name, **one(keys)} for name, keys in changes.items()]


def _table(variants: list[dict[str, Any]]) -> Table:
    heads = ("touches", "compression, µs", "crater, µm", "slide forward, mm")
    factors = dict(zip(MEASURES, (1.0, 1e6, 1e6, 1e3), strict=True))
    cells = []
    for each in variants:
        shown = (
            "-" if each[name] is None else f"{factor * each[name]:.4g}"
            for name, factor in factors.items()
        )
        cells.append((f"{each['variant']}: {each['failure']}".removesuffix(": ")[:40], *shown))
    head = ("the nearest pair, but", *heads)
    return Table("the nearest pair with other wires", head, tuple(cells))


def _reached(name: str, results: Array) -> str:
    (label, unit), measured = MEASURES[name], MEASURED[name]
    low, high = float(np.nanmin(results)), float(np.nanmax(results))
    reached = "lies" if low <= measured <= high else "does not lie"
    return f"{label}: {amount(measured, unit)} {reached} on the map, {amount(low, unit)} to {amount(high, unit)}"


def _answer(values: Mapping[str, float], duration: float, damping: float) -> str:
    missed = []
    for name, measured in MEASURED.items():
        value, (label, unit) = values[name], MEASURES[name]
        if abs(value / measured - 1.0) > EXPLAINED:
            missed.append(f"{label} {amount(value, unit)}, measured {amount(measured, unit)}")
    place = f"a contact of {amount(duration, 's')} and a damping ratio of {damping:.2g}"
    if not missed:
        return f"{place[0].upper()}{place[1:]} explain touches, compression time and crater to {100.0 * EXPLAINED:.0f} %."
    return f"No pair of the map explains all three facts; the nearest, {place}, misses these: {' and '.join(missed)}."
