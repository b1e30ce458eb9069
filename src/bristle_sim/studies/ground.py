"""The ground that strikes leave on a part of the track, the strip of the workpart under the belt.
One of three rules determines how a crater meets earlier craters.

Every strike lowers the shape of one crater (``theory/crater_body.py``) until its deepest point is
at a height z_0, and removes everything above the shape. The rules differ in z_0:

- ``energy``: the shape comes down until it has cut as much volume as a crater of the strike's depth
  has on a plane. The energy per volume is thus assumed constant. The shape extends beyond the
  outline of the crater on a plane.
- ``plane``: z_0 is the strike's depth below the original plane.
- ``ground``: z_0 is the strike's depth below the mean height of the ground within the outline.
  Nothing outside of the outline is cut.

The ground is periodic: a crater that crosses one edge continues at the opposite edge.
"""

from __future__ import annotations

import dataclasses
import logging
import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Blasting
from bristle_sim.theory.crater_body import CraterBody
from bristle_sim.theory.roughness import SECTIONS, roughness_profiles, section_heights

log = logging.getLogger(__name__)

# Number of strikes between two searches for the highest cell. Its height bounds the region that a
# strike can cut. Strikes only lower cells, so an older value is still an upper bound.
HIGHEST_EVERY = 64
# Width of a cell across the slide, divided by its length along the slide. Cells are shorter along
# the slide, since Rz is measured in that direction and the ridges are sharp.
CELLS_ALONG = 2
# Height of the crater shape up to which a strike first searches for cells to cut, divided by the
# height that the preceding strike needed. Both heights are measured from the shape's lowest point.
MARGIN = 1.1


def floor_of_volume(above: Array, volume: float) -> float:
    """Return the height z_0 to which cells must be cut down to remove a given volume.

    z_0 solves sum of max(above - z_0, 0) = volume, where ``above`` are the heights of cells of unit
    area. The first trial height assumes that all cells are cut. Cells below the trial height are
    then left out and a new trial height is computed, until it is below all remaining cells
    (Michelot 1986).

    In this example the two highest of three cells lose a volume of 3:

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
    """Heights of the ground on a grid of cells; at first all are 0, and every strike lowers some.

    Attributes:
        body: shape of the crater that a strike cuts.
        blasting: size and cells of the ground, and the rule for the height of a crater's deepest
            point.
        heights: heights above the original plane (m), shape (across, along); "along" is the
            direction in which the tip slides.
        cell: width of a cell across the slide, m; ``step`` is its length along the slide.
        covered: number of cells that were struck at least once.
        taken: volume that each strike removed, in the order of the strikes, m^3.
    """

    body: CraterBody
    blasting: Blasting
    covered: int = 0
    taken: list[float] = field(default_factory=list)
    _highest: float = 0.0
    _needed: float = 0.0

    def __post_init__(self) -> None:
        self.cell = self.blasting.cell
        self.step = self.cell / CELLS_ALONG
        across = round(self.blasting.ground_width / self.cell)
        along = CELLS_ALONG * round(self.blasting.ground_length / self.cell)
        self.heights: Array = np.zeros((across, along))

    @property
    def coverage(self) -> float:
        """Fraction of the ground that was struck."""
        return self.covered / self.heights.size

    def strike(self, x: float, y: float, depth: float) -> None:
        """Cut one crater into the ground.

        Args:
            x, y: middle of the outline that the crater would have on a plane, m.
            depth: depth that the crater would have on a plane, m.
        """
        if len(self.taken) % HIGHEST_EVERY == 0:
            self._highest = float(self.heights.max())
        rule = self.blasting.crater_rule
        if rule == "energy":
            place, ground, bottom = self._by_volume(x, y, depth)
        else:
            place, shape = self._window(x, y, depth)
            ground = self.heights[place]
            outside = shape > depth
            mean = 0.0
            if rule == "ground" and not outside.all():
                mean = float(ground[~outside].mean())
            bottom = np.where(outside, math.inf, shape + (mean - depth))
        cut = np.minimum(ground, bottom)
        self.covered += int(np.count_nonzero(cut < 0.0) - np.count_nonzero(ground < 0.0))
        self.taken.append(float((ground - cut).sum()) * self.cell * self.step)
        self.heights[place] = cut

    def _by_volume(self, x: float, y: float, depth: float) -> tuple[Any, Array, Array]:
        """Find the height at which the crater shape removes as much as a crater of ``depth`` (m)
        on a plane.

        The search is limited to a window of cells. The window is enlarged until the crater shape at
        its edge is above the highest cell.

        Returns:
            Indices of the window's cells.
            Heights of these cells before the strike, m.
            Heights of the crater shape over these cells, m.
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
        """Return the indices of the cells near (x, y), and the crater shape's heights there.

        The cells form the rectangle around the part of the shape that is at most ``height`` (m)
        above the shape's lowest point. There is always at least one cell.
        """
        start, end, side = self.body.reach(height)
        along, dx = _cells(x, start, end, self.step, self.heights.shape[1])
        across, dy = _cells(y, -side, side, self.cell, self.heights.shape[0])
        return np.ix_(across, along), self.body.shape(dx, dy)


def _cells(
    middle: float, start: float, end: float, step: float, period: int
) -> tuple[NDArray[np.int_], Array]:
    """Return the cells between two distances from ``middle``, along one axis of the grid.

    The grid is periodic. No cell occurs twice.

    Args:
        middle: coordinate from which distances are measured, m.
        start, end: smallest and largest distance of a cell, with sign, m.
        step: size of a cell, m.
        period: number of cells of the grid along the axis.

    Returns:
        Indices of the cells.
        Distances of the cells from ``middle``, m.
    """
    first = math.ceil((middle + start) / step)
    last = max(math.floor((middle + end) / step), first)
    excess = last - first + 1 - period
    if excess > 0:
        first += excess // 2
        last = first + period - 1
    numbers = np.arange(first, last + 1)
    return numbers % period, step * numbers.astype(float) - middle


INSTANTS = 12  # number of instants at which roughness and coverage are recorded
MOST_STRIKES = 200_000  # largest number of strikes on a surface; they take some minutes
# Largest number of iterations of the search for the feed that gives a coverage; two to four suffice
COVERAGE_ROUNDS = 8
# Error of the coverage at which the search for the feed ends, and largest error that is accepted
# after the last iteration of the search
COVERAGE_TOLERANCE = 1e-3
COVERAGE_ACCEPTED = 1e-2
SPREAD = 3.0  # largest deviation of a depth from the mean, in standard deviations


class Blasted(NamedTuple):
    """The ground after the strikes, and how it formed.

    Attributes:
        ground: the ground.
        places: middle (x, y) of each crater's outline (m), in the order of the strikes.
        depths: depth that each crater would have on a plane, m.
        course: values of four quantities after a growing number of strikes, by name: the number of
            strikes, Rz (m), coverage, and mean depth (m).
    """

    ground: Ground
    places: Array
    depths: Array
    course: dict[str, Array]


def whole_planes(blasting: Blasting) -> Blasting:
    """Return the blasting parameters with the ground's width rounded to a multiple of the distance
    between two planes of bristles.

    If the strikes are placed at random, there are no planes, and the parameters are unchanged.
    """
    if blasting.places == "random":
        return blasting
    pitch = blasting.track_width / blasting.planes
    width = max(1, round(blasting.ground_width / pitch)) * pitch
    return dataclasses.replace(blasting, ground_width=width)


def blast(blasting: Blasting, body: CraterBody, rate: float) -> Blasted:
    """Strike a plane ground as often as the requested coverage, areal ratio or feed speed requires.

    Args:
        blasting: parameters of the track and the ground.
        body: shape of a crater on a plane.
        rate: number of strikes of the tool per second.

    Returns:
        The ground after the strikes.

    Raises:
        ValueError: for fewer than one strike, too many strikes, or a coverage that cannot be
            reached.
    """
    area = blasting.ground_length * blasting.ground_width
    if blasting.coverage is None:
        number = area * (blasting.areal_ratio or 0.0) / body.area()
        if blasting.areal_ratio is None:
            number = blasting.passes * rate * area / (blasting.track_width * blasting.feed_speed)
        return _blasted(blasting, body, number)
    wanted = _avrami(blasting.coverage)
    if blasting.places == "random":  # enough even for the rule ``plane``, which covers least
        return _blasted(blasting, body, 4.0 * wanted * area / body.area() + 100.0)
    number = wanted * (area / body.area())  # about proportional to -ln(1 - coverage)
    for _ in range(COVERAGE_ROUNDS):
        found = _blasted(blasting, body, number)
        reached = found.ground.coverage
        if abs(reached - blasting.coverage) <= COVERAGE_TOLERANCE:
            break
        number *= math.sqrt(wanted / _avrami(min(max(reached, 1e-3), 1.0 - 1e-6)))
    if abs(reached - blasting.coverage) > COVERAGE_ACCEPTED:
        raise ValueError(
            f"coverage = {blasting.coverage:g}: must be one that some feed gives; these places cover {reached:.4g}; try areal_ratio"
        )
    return found


def _avrami(coverage: float) -> float:
    """Return the areal ratio A = -ln(1 - coverage) of randomly placed craters.

    The areal ratio is the total area of all craters divided by the area of the ground. The coverage
    is the fraction of the ground that they cover.
    """
    return -math.log1p(-coverage)


def _blasted(blasting: Blasting, body: CraterBody, strikes: float) -> Blasted:
    """Return the ground after a number of strikes.

    If the strikes fall at random places, they end as soon as the requested coverage is reached.

    Raises:
        ValueError: for fewer than one strike or more than MOST_STRIKES strikes.
    """
    if not 0.5 <= strikes <= MOST_STRIKES:
        raise ValueError(
            f"feed_speed, passes, areal_ratio: must make from 1 to {MOST_STRIKES:g} strikes on the ground; these make {strikes:.4g}"
        )
    number = round(strikes)
    random = np.random.default_rng(blasting.seed)
    scatter = random.standard_normal(number).clip(-SPREAD, SPREAD)
    depths = body.depth * (1.0 + blasting.depth_scatter * scatter)
    places = _places(blasting, number, random)
    ground = Ground(body, blasting)
    # The lowest point of each crater is moved to the middle of a cell. Elsewhere the cells would
    # miss the sharp ends of valleys.
    lowest = np.rint((places[:, 0] + body.lowest) / ground.step)
    places[:, 0] = lowest * ground.step - body.lowest
    wanted = math.inf
    expected: float = number
    if blasting.coverage is not None and blasting.places == "random":
        wanted = blasting.coverage
        expected = _avrami(wanted) * blasting.ground_length * blasting.ground_width / body.area()
    pause = max(1, math.ceil(expected / INSTANTS))
    share = max(1, math.ceil(expected / 100.0))
    course = [(0.0, 0.0, 0.0, 0.0)]
    for done, ((x, y), depth) in enumerate(zip(places.tolist(), depths.tolist(), strict=True), 1):
        ground.strike(x, y, depth)
        ended = done == number or ground.coverage >= wanted
        if ended or done % pause == 0:
            rz = mean_rz(ground, blasting.cutoff_wavelength)
            course.append((done, rz, ground.coverage, -float(ground.heights.mean())))
        if done % share == 0:
            log.info("%.0f %% of the strikes made", min(100.0 * done / expected, 99.0))
        if ended:
            break
    names = ("strikes", "rz", "coverage", "mean_depth")
    columns = dict(zip(names, np.array(course).T, strict=True))
    return Blasted(ground, places[:done], depths[:done], columns)


def _places(blasting: Blasting, number: int, random: np.random.Generator) -> Array:
    """Return the position (x, y) of each strike (m), shape (number, 2), in order.

    The positions are either random or a pattern. In the pattern the strikes of one pass of the tool
    are evenly spaced along the track, and the planes of bristles strike in turn. Each later pass
    begins at a random position.
    """
    length = blasting.ground_length
    width = blasting.ground_width
    if blasting.places == "random":
        return random.uniform((0.0, 0.0), (length, width), (number, 2))
    pitch = blasting.track_width / blasting.planes
    scatter = 0.5 * pitch if blasting.place_scatter is None else blasting.place_scatter
    ends = np.rint(np.linspace(0.0, number, blasting.passes + 1)).astype(int)
    counts = np.diff(ends).tolist()
    starts = [0.0, *random.uniform(size=blasting.passes - 1)]
    passes = zip(counts, starts, strict=True)
    along = [(np.arange(count) / max(count, 1) + start) % 1.0 for count, start in passes]
    plane = np.concatenate([*map(np.arange, counts)]) % round(width / pitch)
    across = (plane + 0.5) * pitch + scatter * random.standard_normal(number)
    return np.column_stack([np.concatenate(along) * length, across % width])


def mean_rz(ground: Ground, cutoff: float) -> float:
    """Return the roughness Rz (m), the mean of all profiles along the slide.

    ``cutoff`` is the cut-off wavelength of the roughness filter, m.
    """
    profiles = roughness_profiles(ground.heights, ground.step, cutoff)
    return float(section_heights(profiles, ground.step, cutoff, SECTIONS).mean())
