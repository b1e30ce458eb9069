"""From the crater to the surface: the roughness, coverage and area an hour that a tool makes,
crater by crater.

The first crater is the tip's swept path, of the depth that the contact's energy gives with the
surface inclined (``crater_study``), or a paraboloid of given sizes. The tool places strikes on a
piece of its track; ``ground`` cuts them.
"""

from __future__ import annotations

import dataclasses
import functools
import io
import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array, EqualByValue
from bristle_sim.comparison import Report, amount, rows
from bristle_sim.parameters import Blasting, Bristle, Crater, Hub, Tool
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.settings import Settings
from bristle_sim.studies.crater_study import MEASURED, swept_crater
from bristle_sim.studies.ground import Ground
from bristle_sim.theory.crater_body import CraterBody, Paraboloid
from bristle_sim.theory.roughness import (
    SECTIONS,
    arithmetic_mean_height,
    developed_area_ratio,
    profile_measures,
    roughness_profiles,
    section_heights,
)

MEASURED_RZ = (62e-6, 83e-6)  # mean Rz on corroded API 5L, m (Stango and Khullar, NACE 09191, 2009)
MEASURED_LENGTH = 3.25e-4  # path of the tip and width of the crater, m (Zhang 2020, figs. 4.3, 4.6)
MEASURED_WIDTH = 6.51e-4
LONG_CUTOFF = 2.5e-3  # the next cut-off of ISO 21920-3 above 0.8 mm, m

Blasted = tuple[
    Ground, Array, Array, dict[str, Array]
]  # with places and depths of the strikes, and the course

INSTANTS = 12  # at which roughness and coverage are recorded while the surface forms
MOST_STRIKES = 200_000  # of a surface; some minutes
COVERAGE_ROUNDS = 8  # of the search for the feed that gives a coverage; two to four are usual
# Distance of the coverage from the wanted one that ends the search, and the largest one that is
# accepted after its last round
COVERAGE_TOLERANCE = 1e-3
COVERAGE_ACCEPTED = 1e-2
SPREAD = 3.0  # standard deviations at which the depths' scatter is cut off

UNITS = {
    "rz": ("Rz along the slide", "m"),
    "rz_at_2_5_mm": ("Rz at a cut-off of 2.5 mm", "m"),
    "rz_across": ("Rz across", "m"),
    "ra": ("Ra", "m"),
    "rq": ("Rq", "m"),
    "rsm": ("RSm", "m"),
    "sa": ("Sa", "m"),
    "sdr": ("Sdr", "1"),
    "coverage": ("coverage", "1"),
    "strikes_per_crater_area": ("strikes per crater's area", "1"),
    "mean_depth": ("mean depth", "m"),
    "removed_volume": ("removed volume", "m^3"),
    "removal_rate": ("removal rate", "m^3/s"),
    "area_rate": ("area rate", "m^2/s"),
    "feed": ("feed", "m/s"),
    "strike_rate": ("strikes a second", "1/s"),
    "crater_depth": ("first crater's depth", "m"),
    "crater_length": ("first crater's length", "m"),
    "crater_width": ("first crater's width", "m"),
    "crater_area": ("first crater's area", "m^2"),
    "crater_volume": ("first crater's volume", "m^3"),
}
"""Label and unit of each quantity of a surface."""


@dataclass(frozen=True, slots=True, eq=False)
class BlastedSurface(EqualByValue):
    """A piece of a blasted surface and its measures, in SI units.

    Attributes:
        blasting, body: the parameters, and the first crater.
        heights: above the original plane, m, shape (across, along).
        places, depths: of the strikes in order, m: the middle (x, y) of each outline, and the depth
            on a plane.
        taken: volume that each strike took, m^3.
        course: strikes, Rz (m), coverage and mean depth (m) while the surface forms, by name.
        rz, rz_at_2_5_mm, rz_across, ra, rq, rsm: mean over all profiles, along the slide but for
            ``rz_across``; None where the ground is too short for the cut-off, or has no element.
        sections_across: section lengths of the profiles across.
        sa, sdr: of the heights less their mean, not filtered.
        coverage, strikes_per_crater_area, mean_depth, removed_volume: of the piece.
        removal_rate, area_rate, feed, strike_rate: of the tool.
        crater_depth, crater_length, crater_width, crater_area, crater_volume: of the first crater.
    """

    blasting: Blasting
    body: CraterBody
    heights: Array
    places: Array
    depths: Array
    taken: Array
    course: dict[str, Array]
    rz: float
    rz_at_2_5_mm: float | None
    rz_across: float
    sections_across: int
    ra: float
    rq: float
    rsm: float | None
    sa: float
    sdr: float
    coverage: float
    strikes_per_crater_area: float
    mean_depth: float
    removed_volume: float
    removal_rate: float
    area_rate: float
    feed: float
    strike_rate: float
    crater_depth: float
    crater_length: float
    crater_width: float
    crater_area: float
    crater_volume: float

    def ground(self) -> Ground:
        """Return the plane ground before the first strike."""
        ground = self.blasting
        size = (ground.cell, ground.ground_length, ground.ground_width)
        return Ground.plane(self.body, ground.crater_rule, *size)


def surface(
    tool: Tool | None = None,
    *,
    crater: Crater | None = None,
    settings: Settings | None = None,
    **keys: Any,
) -> BlastedSurface:
    """Compute a piece of the surface that a tool makes, with its roughness, coverage and area an
    hour.

    >>> import bristle_sim as bs
    >>> sizes = {"crater_depth": "130 um", "crater_length": "325 um", "crater_width": "651 um"}
    >>> keys = {"crater_rule": "plane", "places": "random", "areal_ratio": 3.9}
    >>> made = bs.surface(**sizes, **keys, ground_length="10 mm")
    >>> print(f"covered {made.coverage:.2f}")
    covered 0.98

    Args:
        tool: the dissertation's by default; its pass gives the strike unless ``crater`` does.
        crater: the strike's speed and angle, and how the tip cuts; by default the pass's own, and
            as the dissertation's cuts.
        settings: accuracy of the contact that is resolved in time.
        keys: those of the scenario ``surface``, such as ``feed_speed="10 mm/s"``: numbers in SI
            units or texts with a unit.

    Returns:
        The surface. The same seed gives the same one, bit for bit.

    Raises:
        ValueError: in one line, for a key that is refused, keys that do not fit together, or a tool
            without a strike.
    """
    tool = Tool() if tool is None else tool
    return blasted_surface(tool, crater, Blasting(**keys), settings or Settings())


def blasted_surface(
    tool: Tool, crater: Crater | None, blasting: Blasting, settings: Settings
) -> BlastedSurface:
    """Return the surface that a tool makes; arguments as for ``surface``."""
    body = first_crater(tool, crater, blasting, settings)
    blasting.check_crater("crater_length", body.length)
    blasting.check_crater("crater_width", body.width)
    blasting, pitch = _whole_planes(blasting)
    rate = blasting.planes * blasting.bristles * tool.hub.speed / (2.0 * math.pi)
    if rate == 0.0:
        raise ValueError("hub_speed = 0: must be more than 0, or nothing is struck (in rad/s)")
    area = blasting.ground_length * blasting.ground_width
    piece = functools.partial(_blasted, blasting, body, pitch)
    if blasting.coverage is None:
        number = area * (blasting.areal_ratio or 0.0) / body.area()
        if blasting.areal_ratio is None:
            number = blasting.passes * rate * area / (blasting.track_width * blasting.feed_speed)
        found = piece(number)
    elif blasting.places == "random":  # by far enough strikes: rule plane is covered least
        found = piece(4.0 * _avrami(blasting.coverage) * area / body.area() + 100.0)
    else:
        found = _covering(piece, blasting.coverage, area / body.area())
    return _measured(found, blasting, body, rate)


def first_crater(
    tool: Tool, crater: Crater | None, blasting: Blasting, settings: Settings
) -> CraterBody:
    """Return the first crater: a paraboloid where one of its sizes is given, else the path of the
    tip.

    Raises ValueError if the tool has no strike that cuts.
    """
    given = (blasting.crater_depth, blasting.crater_length, blasting.crater_width)
    if None not in given:
        return Paraboloid(*given)  # type: ignore[arg-type]
    body = swept_crater(tool.hub, tool.bristle, crater or _own_strike(tool), settings)
    if given == (None, None, None):
        return body
    own = (body.depth, body.length, body.width)
    return Paraboloid(*(b if a is None else a for a, b in zip(given, own, strict=True)))


def _own_strike(tool: Tool) -> Crater:
    """Return the speed and angle of the strike of the tool's pass, as the dissertation's tip cuts."""
    found = ensemble(tool, accuracy=1e-6)
    speed = float(found.tip_speed_at_contact)
    if not math.isfinite(speed):
        raise ValueError(
            f"tool: must strike the workpart, its wire {found.outcome} ({found.reason})"
        )
    rate = (speed - tool.hub.speed * tool.hub.radius) / tool.bristle.length
    angle = math.degrees(float(found.entry_angle_at_contact))
    return Crater(speed_ratio=rate / tool.hub.speed, impact_angle_deg=angle)


def _whole_planes(blasting: Blasting) -> tuple[Blasting, float]:
    """Return the blasting of a ground that is whole planes wide, where they make a pattern, and the
    planes' distance, m.
    """
    pitch = blasting.track_width / blasting.planes
    if blasting.places == "random":
        return blasting, pitch
    width = max(1, round(blasting.ground_width / pitch)) * pitch
    return dataclasses.replace(blasting, ground_width=width), pitch


def _avrami(coverage: float) -> float:
    """Return the areal ratio at which random places cover a fraction, A = -ln(1 - coverage)."""
    return -math.log1p(-coverage)


def _covering(piece: Callable[[float], Blasted], wanted: float, unit: float) -> Blasted:
    """Return the pattern that covers the wanted fraction: strikes fall nearly as ln(1 - coverage).

    ``unit`` is the number of strikes of an areal ratio of 1. Raises ValueError if no feed gives it.
    """
    number = _avrami(wanted) * unit
    best = found = piece(number)
    for _ in range(COVERAGE_ROUNDS):
        reached = found[0].coverage
        if abs(reached - wanted) < abs(best[0].coverage - wanted):
            best = found
        if abs(reached - wanted) <= COVERAGE_TOLERANCE:
            break
        number *= math.sqrt(_avrami(wanted) / _avrami(min(max(reached, 1e-3), 1.0 - 1e-6)))
        found = piece(number)
    if abs(best[0].coverage - wanted) > COVERAGE_ACCEPTED:
        raise ValueError(
            f"coverage = {wanted:g}: must be one that a feed gives, these places cover {reached:.4g}; try areal_ratio"
        )
    return best


def _blasted(blasting: Blasting, body: CraterBody, pitch: float, strikes: float) -> Blasted:
    """Return the ground after the strikes, with their places and depths and the course of the
    ground.

    The number of strikes is ``strikes``. If a coverage is wanted and the places are random, the
    strikes end when it is reached.
    """
    if not 0.5 <= strikes <= MOST_STRIKES:
        raise ValueError(
            f"feed_speed, passes, areal_ratio: must make from 1 to {MOST_STRIKES:g} strikes on the ground, these make {strikes:.4g}"
        )
    number = round(strikes)
    random = np.random.default_rng(blasting.seed)
    depths = random.standard_normal(number).clip(-SPREAD, SPREAD)
    depths = body.depth * (1.0 + blasting.depth_scatter * depths)
    places = _places(blasting, pitch, number, random)
    ground = Ground.plane(
        body, blasting.crater_rule, blasting.cell, blasting.ground_length, blasting.ground_width
    )
    # The lowest point comes to rest over the middle of a cell, or the cells would miss the sharp
    # ends of valleys
    lowest = np.rint((places[:, 0] + body.lowest) / ground.step)
    places[:, 0] = lowest * ground.step - body.lowest
    stopping = blasting.coverage is not None and blasting.places == "random"
    expected = _avrami(blasting.coverage or 0.0) * blasting.ground_length * blasting.ground_width
    pause = max(1, math.ceil((expected / body.area() if stopping else number) / INSTANTS))
    course: list[tuple[float, ...]] = [(0, 0.0, 0.0, 0.0)]
    done = 0
    for (x, y), depth in zip(places.tolist(), depths.tolist(), strict=True):
        ground.strike(x, y, depth)
        done += 1
        over = stopping and ground.coverage >= (blasting.coverage or 0.0)
        if done % pause == 0 or over or done == number:
            rz = mean_rz(ground, blasting.cutoff_wavelength)
            course.append((done, rz, ground.coverage, -float(ground.heights.mean())))
        if over:
            break
    names = ("strikes", "rz", "coverage", "mean_depth")
    columns = dict(zip(names, np.array(course).T, strict=True))
    return ground, places[:done], depths[:done], columns


def _places(blasting: Blasting, pitch: float, number: int, random: np.random.Generator) -> Array:
    """Return the places of the strikes in order, m, shape (number, 2).

    In a pattern the strikes of a pass follow each other evenly along the track, plane after plane;
    passes after the first one begin at a random place.
    """
    length = blasting.ground_length
    width = blasting.ground_width
    if blasting.places == "random":
        return random.uniform((0.0, 0.0), (length, width), (number, 2))
    planes = round(width / pitch)
    scatter = 0.5 * pitch if blasting.place_scatter is None else blasting.place_scatter
    ends = np.rint(np.linspace(0.0, number, blasting.passes + 1)).astype(int)
    along = list[Array]()
    for count in np.diff(ends):
        start = random.uniform() if along else 0.0
        along.append((np.arange(count) / max(count, 1) + start) % 1.0 * length)
    plane = np.concatenate([np.arange(count) % planes for count in np.diff(ends)])
    across = (plane + 0.5) * pitch + scatter * random.standard_normal(number)
    return np.column_stack([np.concatenate(along), across % width])


def mean_rz(ground: Ground, cutoff: float) -> float:
    """Return the mean Rz of all profiles along the slide, m."""
    profiles = roughness_profiles(ground.heights, ground.step, cutoff)
    return float(section_heights(profiles, ground.step, cutoff, SECTIONS).mean())


def _measured(
    found: Blasted,
    blasting: Blasting,
    body: CraterBody,
    rate: float,
) -> BlastedSurface:
    """Return the surface with its measures; the tool's ``rate`` is in strikes a second."""
    ground, places, depths, course = found
    heights = ground.heights
    cell = blasting.cell
    area = blasting.ground_length * blasting.ground_width
    cutoff = blasting.cutoff_wavelength
    rough = roughness_profiles(heights, ground.step, cutoff)
    along = profile_measures(rough, ground.step, cutoff, SECTIONS)
    section = min(cutoff, cell * heights.shape[0])
    fitting = min(SECTIONS, max(1, int(cell * heights.shape[0] / section * (1.0 + 1e-9))))
    profiles = roughness_profiles(np.ascontiguousarray(heights.T), cell, cutoff)
    across = profile_measures(profiles, cell, section, fitting)
    long_enough = blasting.ground_length * (1.0 + 1e-9) >= SECTIONS * LONG_CUTOFF
    area_rate = rate * area / depths.size
    removed = -float(heights.sum()) * cell * ground.step
    return BlastedSurface(
        blasting=blasting,
        body=body,
        heights=heights,
        places=places,
        depths=depths,
        taken=np.array(ground.taken),
        course=course,
        rz=along.rz,
        rz_at_2_5_mm=mean_rz(ground, LONG_CUTOFF) if long_enough else None,
        rz_across=across.rz,
        sections_across=fitting,
        ra=along.ra,
        rq=along.rq,
        rsm=along.rsm,
        sa=arithmetic_mean_height(heights),
        sdr=developed_area_ratio(heights, ground.step, cell),
        coverage=ground.coverage,
        strikes_per_crater_area=depths.size * body.area() / area,
        mean_depth=-float(heights.mean()),
        removed_volume=removed,
        removal_rate=rate * removed / depths.size,
        area_rate=area_rate,
        feed=area_rate * blasting.passes / blasting.track_width,
        strike_rate=rate,
        crater_depth=body.depth,
        crater_length=body.length,
        crater_width=body.width,
        crater_area=body.area(),
        crater_volume=float(body.volume()),
    )


def surface_study(
    hub: Hub, bristle: Bristle, crater: Crater, blasting: Blasting, settings: Settings
) -> Report:
    """Blast a surface with strikes of a given speed and angle, and compare its roughness with the
    measured one.

    Raises ValueError for parameters that do not fit together, or a strike that does not cut.
    """
    started = clock.perf_counter()
    tool = Tool(hub=hub, bristle=bristle, bar=None, workpart=None)
    made = blasted_surface(tool, crater, blasting, settings)
    theory = dict[str, float]()
    if blasting.places == "random":
        theory["coverage"] = -math.expm1(-made.strikes_per_crater_area)
    if blasting.crater_rule == "energy":
        theory["removed_volume"] = float(np.sum(made.body.volume(made.depths)))
    printed = {
        "crater_depth": MEASURED,
        "crater_length": MEASURED_LENGTH,
        "crater_width": MEASURED_WIDTH,
    }
    values = {name: getattr(made, name) for name in UNITS}
    low, high = MEASURED_RZ
    cutoff = amount(blasting.cutoff_wavelength, "m")
    return Report(
        quantities=rows(UNITS, values, theory, printed=printed),
        wall_s=clock.perf_counter() - started,
        steps=made.depths.size,
        remarks=(
            f"Rz: {SECTIONS} sections of {cutoff} along the slide, {made.sections_across} across, Gaussian filter; the mean"
            f" of all profiles. Measured: {1e6 * low:.0f} to {1e6 * high:.0f} µm on corroded API 5L (NACE 09191); its cut-off"
            " is not known.",
            f"{made.depths.size} strikes on {amount(made.blasting.ground_length, 'm')} by"
            f" {amount(made.blasting.ground_width, 'm')}, rule {blasting.crater_rule}, places: {blasting.places}.",
            *(
                ["theory of the coverage: random places, 1 - exp(-A)"]
                if "coverage" in theory
                else []
            ),
        ),
        extra={"sections_across": made.sections_across, "measured_rz": list(MEASURED_RZ)},
        subject=made,
        answer=(
            f"This tool makes Rz {amount(made.rz, 'm')} at {amount(made.area_rate, 'm^2/s')} and"
            f" {100.0 * made.coverage:.3g} % coverage (cut-off {cutoff}); measured {1e6 * low:.0f} to {1e6 * high:.0f} µm."
        ),
    )


def height_lines(made: BlastedSurface) -> str:
    """Return place and height of every cell, m, as lines of three numbers: the format .xyz."""
    text = io.StringIO()
    np.savetxt(text, np.column_stack([*height_columns(made).values()]), fmt="%.9g")
    return text.getvalue().removesuffix("\n")


def height_columns(made: BlastedSurface) -> dict[str, Array]:
    """Return place and height of every cell, m, row by row along the slide."""
    across, along = np.indices(made.heights.shape)
    ground = made.ground()
    columns = (ground.step * along, ground.cell * across, made.heights)
    names = ("x (m)", "y (m)", "height (m)")
    return dict(zip(names, (each.ravel() for each in columns), strict=True))
