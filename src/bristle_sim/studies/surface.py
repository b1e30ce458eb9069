"""From crater to surface: the roughness, the coverage and the area per hour that a tool makes,
computed crater by crater.

A crater on a plane is either the volume that the tip sweeps or a paraboloid of given size. The
depth of the swept volume follows from the energy of the contact, for a surface inclined to the
tip's path (``crater_study``). The tool's strikes are placed on a part of the track, the strip of
the workpart under the belt. The module ``ground`` cuts one crater after the other.
"""

import io
import math
import time as clock
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array, EqualByValue
from bristle_sim.comparison import Report, rows
from bristle_sim.parameters import Blasting, Bristle, Crater, Hub, Tool
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.readable import amount
from bristle_sim.settings import Settings
from bristle_sim.studies.crater_study import MEASURED, swept_crater
from bristle_sim.studies.ground import CELLS_ALONG, Blasted, blast, mean_rz, whole_planes
from bristle_sim.theory.crater_body import CraterBody, Paraboloid
from bristle_sim.theory.roughness import (
    SECTIONS,
    arithmetic_mean_height,
    developed_area_ratio,
    profile_measures,
    roughness_profiles,
)

MEASURED_RZ = (62e-6, 83e-6)  # mean Rz on corroded API 5L, m (Stango and Khullar, NACE 09191, 2009)
# Length of the tip's path and width of the crater, m (Zhang 2020, figs. 4.3, 4.6)
MEASURED_LENGTH = 3.25e-4
MEASURED_WIDTH = 6.51e-4
LONG_CUTOFF = 2.5e-3  # cut-off wavelength, m; in ISO 21920-3 the next larger one after 0.8 mm

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
    """A part of a blasted surface, with its measures in SI units.

    Attributes:
        blasting: parameters of the track and the ground.
        body: shape of the first crater.
        heights: heights above the original plane (m), shape (across, along); "along" is the
            direction in which the tip slides.
        places: middle (x, y) of each crater's outline (m), in the order of the strikes.
        depths: depth that each crater would have on a plane, m.
        taken: volume that each strike removed, m^3.
        course: values of four quantities after a growing number of strikes, by name: the number of
            strikes, Rz (m), coverage, and mean depth (m).
        rz, rz_at_2_5_mm, rz_across, ra, rq, rsm: roughness, averaged over all profiles along the
            slide (``rz_across``: across the slide; ``rz_at_2_5_mm``: with a cut-off wavelength of
            2.5 mm). A value is None if the ground is too short for the cut-off wavelength, or the
            profiles have no complete profile element.
        sections_across: number of section lengths in the profiles across the slide.
        sa, sdr: areal roughness of the unfiltered heights, measured from their mean.
        coverage, strikes_per_crater_area, mean_depth, removed_volume: measures of this part of the
            surface.
        removal_rate, area_rate, feed, strike_rate: rates of the whole tool.
        crater_depth, crater_length, crater_width, crater_area, crater_volume: sizes of the first
            crater.
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


def surface(
    tool: Tool | None = None,
    *,
    crater: Crater | None = None,
    settings: Settings | None = None,
    **keys: Any,
) -> BlastedSurface:
    """Compute a part of the surface that a tool makes, with its roughness, coverage and area per
    hour.

    >>> import bristle_sim as bs
    >>> sizes = {"crater_depth": "130 um", "crater_length": "325 um", "crater_width": "651 um"}
    >>> keys = {"crater_rule": "plane", "places": "random", "areal_ratio": 3.9}
    >>> made = bs.surface(**sizes, **keys, ground_length="10 mm")
    >>> print(f"covered {made.coverage:.2f}")
    covered 0.98

    Args:
        tool: the tool; the dissertation's by default. The strike is that of its pass, unless
            ``crater`` is given.
        crater: speed and angle of the strike, and the cutting properties of tip and workpart. By
            default speed and angle are those of the pass, and the cutting properties those of the
            dissertation.
        settings: accuracy of the simulated contact.
        keys: parameters of the scenario ``surface``, such as ``feed_speed="10 mm/s"``, as numbers
            in SI units or texts with a unit.

    Returns:
        The surface. The same seed gives the same surface, bit for bit.

    Raises:
        ValueError: for an invalid parameter, parameters that contradict each other, or a tool
            without a strike. The message is one line.
    """
    tool = Tool() if tool is None else tool
    return blasted_surface(tool, crater, Blasting(**keys), settings or Settings())


def blasted_surface(
    tool: Tool, crater: Crater | None, blasting: Blasting, settings: Settings
) -> BlastedSurface:
    """Compute a part of the surface that a tool makes.

    Args:
        tool: the tool.
        crater: speed and angle of the strike, and the cutting properties; if None, those of the
            tool's pass, and those of the dissertation.
        blasting: parameters of the track and the ground.
        settings: accuracy of the simulated contact.
    """
    body = first_crater(tool, crater, blasting, settings)
    blasting.check_crater("crater_length", body.length)
    blasting.check_crater("crater_width", body.width)
    rate = blasting.planes * blasting.bristles * tool.hub.speed / (2.0 * math.pi)
    if rate == 0.0:
        raise ValueError("hub_speed = 0: must be more than 0, or nothing is struck (in rad/s)")
    blasting = whole_planes(blasting)
    return _measured(blast(blasting, body, rate), blasting, body, rate)


def first_crater(
    tool: Tool, crater: Crater | None, blasting: Blasting, settings: Settings
) -> CraterBody:
    """Return the shape of the first crater, which is cut into a plane.

    The crater is the volume that the tip sweeps. If ``blasting`` gives its length, width or depth,
    the shape is a paraboloid instead; sizes that are not given are those of the swept volume. The
    arguments are those of :func:`blasted_surface`.

    Raises:
        ValueError: if the tool has no strike that cuts.
    """
    given = (blasting.crater_depth, blasting.crater_length, blasting.crater_width)
    if None not in given:
        return Paraboloid(*given)  # type: ignore[arg-type]
    body = swept_crater(tool.hub, tool.bristle, crater or _own_strike(tool), settings)
    if not any(given):
        return body
    depth, length, width = given
    return Paraboloid(depth or body.depth, length or body.length, width or body.width)


def _own_strike(tool: Tool) -> Crater:
    """Return the crater parameters for the strike in the tool's pass.

    Speed and angle are those of the strike, the cutting properties those of the dissertation.

    Raises:
        ValueError: if the tool does not strike the workpart.
    """
    found = ensemble(tool, accuracy=1e-6)
    speed = float(found.tip_speed_at_contact)
    if not math.isfinite(speed):
        raise ValueError(
            f"tool: must strike the workpart; its wire {found.outcome} ({found.reason})"
        )
    rate = (speed - tool.hub.speed * tool.hub.radius) / tool.bristle.length
    angle = math.degrees(float(found.entry_angle_at_contact))
    return Crater(speed_ratio=rate / tool.hub.speed, impact_angle_deg=angle)


def _measured(found: Blasted, blasting: Blasting, body: CraterBody, rate: float) -> BlastedSurface:
    """Compute roughness, coverage, removed volume and area rate of a blasted ground.

    Args:
        found: the ground after the strikes.
        blasting: parameters of the track and the ground.
        body: shape of the first crater.
        rate: number of strikes of the tool per second.
    """
    ground = found.ground
    depths = found.depths
    heights = ground.heights
    cell = blasting.cell
    area = blasting.ground_length * blasting.ground_width
    cutoff = blasting.cutoff_wavelength
    rough = roughness_profiles(heights, ground.step, cutoff)
    along = profile_measures(rough, ground.step, cutoff, SECTIONS)
    width = cell * heights.shape[0]
    section = min(cutoff, width)
    fitting = min(SECTIONS, int(width / section * (1.0 + 1e-9)))
    profiles = roughness_profiles(np.ascontiguousarray(heights.T), cell, cutoff)
    across = profile_measures(profiles, cell, section, fitting)
    long_enough = blasting.ground_length * (1.0 + 1e-9) >= SECTIONS * LONG_CUTOFF
    area_rate = rate * area / depths.size
    removed = -float(heights.sum()) * cell * ground.step
    return BlastedSurface(
        blasting=blasting,
        body=body,
        heights=heights,
        places=found.places,
        depths=depths,
        taken=np.array(ground.taken),
        course=found.course,
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
    """Blast a surface with strikes of a given speed and angle, and compare its roughness with
    measurement.

    Raises:
        ValueError: if parameters contradict each other, or a strike does not cut.
    """
    started = clock.perf_counter()
    tool = Tool(hub=hub, bristle=bristle, bar=None, workpart=None)
    made = blasted_surface(tool, crater, blasting, settings)
    low, high = MEASURED_RZ
    measured = f"{1e6 * low:.0f} to {1e6 * high:.0f} µm"
    cutoff = amount(blasting.cutoff_wavelength, "m")
    theory = {}
    remarks = [
        f"Rz: {SECTIONS} sections of {cutoff} along the slide, {made.sections_across} across, Gaussian filter; the mean"
        f" of all profiles. Measured: {measured} on corroded API 5L (NACE 09191); its cut-off is not known.",
        f"{made.depths.size} strikes on {amount(made.blasting.ground_length, 'm')} by"
        f" {amount(made.blasting.ground_width, 'm')}, rule {blasting.crater_rule}, places: {blasting.places}.",
    ]
    if blasting.places == "random":
        theory["coverage"] = -math.expm1(-made.strikes_per_crater_area)
        remarks.append("theory of the coverage: random places, 1 - exp(-A)")
    if blasting.crater_rule == "energy":
        theory["removed_volume"] = float(np.sum(made.body.volume(made.depths)))
    printed = {
        "crater_depth": MEASURED,
        "crater_length": MEASURED_LENGTH,
        "crater_width": MEASURED_WIDTH,
    }
    values = {name: getattr(made, name) for name in UNITS}
    return Report(
        quantities=rows(UNITS, values, theory, printed=printed),
        wall_s=clock.perf_counter() - started,
        steps=made.depths.size,
        remarks=tuple(remarks),
        extra={"sections_across": made.sections_across, "measured_rz": list(MEASURED_RZ)},
        subject=made,
        answer=(
            f"This tool makes Rz {amount(made.rz, 'm')} at {amount(made.area_rate, 'm^2/s')} and"
            f" {100.0 * made.coverage:.3g} % coverage (cut-off {cutoff}); measured Rz: {measured}."
        ),
    )


def height_lines(made: BlastedSurface) -> str:
    """Return the heights in the text format .xyz: a line with x, y and height (m) for each cell."""
    text = io.StringIO()
    np.savetxt(text, np.column_stack([*height_columns(made).values()]), fmt="%.9g")
    return text.getvalue().removesuffix("\n")


def height_columns(made: BlastedSurface) -> dict[str, Array]:
    """Return the columns x, y and height (m) of all cells, by name.

    Consecutive cells follow each other along the slide.
    """
    across, along = np.indices(made.heights.shape)
    cell = made.blasting.cell
    columns = (cell / CELLS_ALONG * along, cell * across, made.heights)
    names = ("x (m)", "y (m)", "height (m)")
    return dict(zip(names, (each.ravel() for each in columns), strict=True))
