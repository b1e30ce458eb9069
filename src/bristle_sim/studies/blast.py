"""Strikes on a piece of the track: their number, places and depths, and the ground that they leave."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Blasting
from bristle_sim.studies.ground import Ground
from bristle_sim.theory.crater_body import CraterBody
from bristle_sim.theory.roughness import SECTIONS, roughness_profiles, section_heights

INSTANTS = 12  # at which roughness and coverage are recorded while the surface forms
MOST_STRIKES = 200_000  # of a surface; some minutes
COVERAGE_ROUNDS = 8  # of the search for the feed that gives a coverage; two to four are usual
# Distance of the coverage from the wanted one that ends the search, and the largest one that is
# accepted after its last round
COVERAGE_TOLERANCE = 1e-3
COVERAGE_ACCEPTED = 1e-2
SPREAD = 3.0  # standard deviations at which the depths' scatter is cut off


class Blasted(NamedTuple):
    """The ground after the strikes.

    Attributes:
        ground: the ground.
        places, depths: of the strikes in order, m.
        course: strikes, Rz (m), coverage and mean depth (m) while the surface forms, by name.
    """

    ground: Ground
    places: Array
    depths: Array
    course: dict[str, Array]


def whole_planes(blasting: Blasting) -> Blasting:
    """Return the blasting of a ground that is whole planes wide, where they make a pattern."""
    if blasting.places == "random":
        return blasting
    pitch = blasting.track_width / blasting.planes
    width = max(1, round(blasting.ground_width / pitch)) * pitch
    return dataclasses.replace(blasting, ground_width=width)


def blast(blasting: Blasting, body: CraterBody, rate: float) -> Blasted:
    """Return the ground after the strikes that the coverage, the areal ratio or the feed demands.

    ``rate`` is the tool's, in strikes a second. Raises ValueError for too many strikes or none, and
    for a coverage that no feed gives.
    """
    area = blasting.ground_length * blasting.ground_width
    if blasting.coverage is None:
        number = area * (blasting.areal_ratio or 0.0) / body.area()
        if blasting.areal_ratio is None:
            number = blasting.passes * rate * area / (blasting.track_width * blasting.feed_speed)
        return _blasted(blasting, body, number)
    wanted = _avrami(blasting.coverage)
    if blasting.places == "random":  # by far enough strikes: rule plane is covered least
        return _blasted(blasting, body, 4.0 * wanted * area / body.area() + 100.0)
    number = wanted * (area / body.area())  # strikes fall nearly as ln(1 - coverage)
    best = None
    missed = math.inf
    for _ in range(COVERAGE_ROUNDS):
        found = _blasted(blasting, body, number)
        reached = found.ground.coverage
        if best is None or abs(reached - blasting.coverage) < missed:
            best = found
            missed = abs(reached - blasting.coverage)
        if missed <= COVERAGE_TOLERANCE:
            return best
        number *= math.sqrt(wanted / _avrami(min(max(reached, 1e-3), 1.0 - 1e-6)))
    if best is None or missed > COVERAGE_ACCEPTED:
        raise ValueError(
            f"coverage = {blasting.coverage:g}: must be one that a feed gives, these places cover {reached:.4g}; try areal_ratio"
        )
    return best


def _avrami(coverage: float) -> float:
    """Return the areal ratio at which random places cover a fraction, A = -ln(1 - coverage)."""
    return -math.log1p(-coverage)


def _blasted(blasting: Blasting, body: CraterBody, strikes: float) -> Blasted:
    """Return the ground after a number of strikes; fewer if random places cover the wanted fraction
    before.
    """
    if not 0.5 <= strikes <= MOST_STRIKES:
        raise ValueError(
            f"feed_speed, passes, areal_ratio: must make from 1 to {MOST_STRIKES:g} strikes on the ground, these make {strikes:.4g}"
        )
    number = round(strikes)
    random = np.random.default_rng(blasting.seed)
    scatter = random.standard_normal(number).clip(-SPREAD, SPREAD)
    depths = body.depth * (1.0 + blasting.depth_scatter * scatter)
    places = _places(blasting, number, random)
    ground = Ground.plane(body, blasting)
    # The lowest point comes to rest over the middle of a cell, or the cells would miss the sharp
    # ends of valleys
    lowest = np.rint((places[:, 0] + body.lowest) / ground.step)
    places[:, 0] = lowest * ground.step - body.lowest
    wanted = math.inf
    expected: float = number
    if blasting.coverage is not None and blasting.places == "random":
        wanted = blasting.coverage
        area = blasting.ground_length * blasting.ground_width
        expected = _avrami(wanted) * area / body.area()
    pause = max(1, math.ceil(expected / INSTANTS))
    course: list[tuple[float, ...]] = [(0, 0.0, 0.0, 0.0)]
    done = 0
    while done < number and ground.coverage < wanted:
        x, y = places[done].tolist()
        ground.strike(x, y, float(depths[done]))
        done += 1
        if done % pause == 0 or done == number or ground.coverage >= wanted:
            rz = mean_rz(ground, blasting.cutoff_wavelength)
            course.append((done, rz, ground.coverage, -float(ground.heights.mean())))
    names = ("strikes", "rz", "coverage", "mean_depth")
    columns = dict(zip(names, np.array(course).T, strict=True))
    return Blasted(ground, places[:done], depths[:done], columns)


def _places(blasting: Blasting, number: int, random: np.random.Generator) -> Array:
    """Return the places of the strikes in order, m, shape (number, 2).

    In a pattern the strikes of a pass follow each other evenly along the track, plane after plane;
    passes after the first one begin at a random place.
    """
    length = blasting.ground_length
    width = blasting.ground_width
    if blasting.places == "random":
        return random.uniform((0.0, 0.0), (length, width), (number, 2))
    pitch = blasting.track_width / blasting.planes
    scatter = 0.5 * pitch if blasting.place_scatter is None else blasting.place_scatter
    ends = np.rint(np.linspace(0.0, number, blasting.passes + 1)).astype(int)
    along = list[Array]()
    plane = list[Array]()
    for count in np.diff(ends):
        start = random.uniform() if along else 0.0
        along.append((np.arange(count) / max(count, 1) + start) % 1.0 * length)
        plane.append(np.arange(count) % round(width / pitch))
    across = (np.concatenate(plane) + 0.5) * pitch + scatter * random.standard_normal(number)
    return np.column_stack([np.concatenate(along), across % width])


def mean_rz(ground: Ground, cutoff: float) -> float:
    """Return the mean Rz of all profiles along the slide, m."""
    profiles = roughness_profiles(ground.heights, ground.step, cutoff)
    return float(section_heights(profiles, ground.step, cutoff, SECTIONS).mean())
