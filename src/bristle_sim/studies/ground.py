"""Ground on which craters fall one after the other, and the three rules by which a crater meets an
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

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Blasting
from bristle_sim.theory.crater_body import CraterBody

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
