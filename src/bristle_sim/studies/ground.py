"""Strikes on a piece of the track, and the ground that they leave, by three rules for how a crater meets an
earlier one.

Every strike brings the shape of one crater (``theory/crater_body.py``) to a height z_0, and what is
above it is gone. The rules differ in z_0:

- ``energy``: the shape comes down until the volume that it has cut from peaks and valleys is that
  of a crater of the strike's depth on a plane, as if energy per volume were constant. The shape
  continues beyond the first crater's outline.
- ``plane``: z_0 is the strike's depth below the original plane.
- ``ground``: z_0 is the strike's depth below the mean of the ground within the outline, and nothing
  outside of it is cut.

The ground is periodic: what leaves it on one side enters on the other.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Blasting
from bristle_sim.theory.crater_body import CraterBody
from bristle_sim.theory.roughness import SECTIONS, roughness_profiles, section_heights

# Strikes between two searches for the highest cell, which bounds the places that a strike can cut;
# it only ever falls
HIGHEST_EVERY = 64
CELLS_ALONG = 2  # cells along the slide on a cell across: Rz is measured along, over sharp ridges
MARGIN = 1.1  # of the height of the first window tried over the height that a strike before needed


def floor_of_volume(above: Array, volume: float) -> float:
    """Return the height z_0 for which the sum of max(above - z_0, 0) is the volume, in the unit of
    the heights.

    The mean of the cells less the volume's share is too low while cells below it count; without
    them it rises, until no cell is below it (Michelot 1986). Three columns, of which the highest
    two take a volume of 3:

    >>> floor_of_volume(np.array([1.0, 4.0, 0.0]), 3.0)
    1.0
    """
    while True:
        floor = (float(above.sum()) - volume) / above.size
        higher = above[above > floor]
        if higher.size == above.size:
            return floor
        above = higher


@dataclass(eq=False)
class Ground:
    """Heights above the original plane, m, shape (across, along); it changes with every strike.

    Attributes:
        cell: width of a cell across the slide, m; ``step`` is its length along it.
        covered: number of cells that were struck.
        taken: volumes that the strikes took, in order, m^3.
    """

    body: CraterBody
    rule: str
    cell: float
    heights: Array
    covered: int = 0
    taken: list[float] = field(default_factory=list)
    _highest: float = 0.0
    _needed: float = 0.0

    @classmethod
    def plane(cls, body: CraterBody, blasting: Blasting) -> Ground:
        """Return the plane ground before the first strike."""
        cell = blasting.cell
        along = CELLS_ALONG * round(blasting.ground_length / cell)
        heights = np.zeros((round(blasting.ground_width / cell), along))
        return cls(body, blasting.crater_rule, cell, heights)

    @property
    def step(self) -> float:
        """Return the length of a cell along the slide, m."""
        return self.cell / CELLS_ALONG

    @property
    def coverage(self) -> float:
        """Return the struck fraction of the ground."""
        return self.covered / self.heights.size

    def strike(self, x: float, y: float, depth: float) -> None:
        """Cut a crater whose outline on a plane has its middle at (x, y), and whose depth there is
        ``depth``, m.
        """
        if len(self.taken) % HIGHEST_EVERY == 0:
            self._highest = float(self.heights.max())
        if self.rule == "energy":
            place, ground, bottom = self._by_volume(x, y, depth)
        else:
            place, shape = self._window(x, y, depth)
            ground = self.heights[place]
            outside = shape > depth
            mean = 0.0
            if self.rule == "ground" and not outside.all():
                mean = float(ground[~outside].mean())
            bottom = np.where(outside, math.inf, shape + (mean - depth))
        cut = np.minimum(ground, bottom)
        self.covered += int(np.count_nonzero(cut < 0.0) - np.count_nonzero(ground < 0.0))
        self.taken.append(float((ground - cut).sum()) * self.cell * self.step)
        self.heights[place] = cut

    def _by_volume(self, x: float, y: float, depth: float) -> tuple[Any, Array, Array]:
        """Return the cells that a strike may cut, their heights, and the shape at the height that
        takes its volume.

        The window is large enough if the shape at its edge would be above the ground's highest
        cell.
        """
        volume = float(self.body.volume(depth)) / (self.cell * self.step)
        height = MARGIN * max(self._needed, depth)
        while True:
            place, shape = self._window(x, y, height)
            ground = self.heights[place]
            floor = floor_of_volume((ground - shape).ravel(), volume)
            self._needed = self._highest - floor
            if self._needed <= height or ground.size == self.heights.size:
                return place, ground, shape + floor
            height = MARGIN * self._needed

    def _window(self, x: float, y: float, height: float) -> tuple[Any, Array]:
        """Return the cells where the shape is up to some height above its lowest point, at least
        one, and the shape there.
        """
        start, end, side = self.body.reach(height)
        along, dx = _cells(x, start, end, self.step, self.heights.shape[1])
        across, dy = _cells(y, -side, side, self.cell, self.heights.shape[0])
        return np.ix_(across, along), self.body.shape(dx, dy)


def _cells(
    middle: float, start: float, end: float, step: float, period: int
) -> tuple[NDArray[np.int_], Array]:
    """Return the numbers of the cells between two distances from a place, no cell twice, and their
    distances, m.
    """
    first = math.ceil((middle + start) / step)
    last = max(math.floor((middle + end) / step), first)
    excess = last - first + 1 - period
    if excess > 0:
        first += excess // 2
        last = first + period - 1
    numbers = np.arange(first, last + 1)
    return numbers % period, step * numbers.astype(float) - middle


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
