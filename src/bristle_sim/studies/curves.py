"""What a panel of curves holds: closed forms over a parameter, points that check them, and what is marked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["SOURCES", "Axis", "Curve", "Level", "Mark", "Panel", "Source", "curve_of"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Source:
    """Where points come from, and how far they may be off the curve, see largest_differences."""

    words: str
    tolerance: float | None


SOURCES = {
    # Law and closed form share their algebra up to rounding, which grows like 1/distance near the stiction friction.
    "energetic": Source("scene, energetic law", 1e-9),
    # As oblique_impact: a contact resolved in time reaches its rigid-body limit to a thousandth of this.
    "compliant": Source("scene, contact resolved in time", 3e-3),
    "contact": Source("scene, contact of 50 µs", None),
    # The equation as it stands in print, number by number; what nearly cancels in it leaves 1e-12.
    "printed": Source("printed equation, term by term", 1e-9),
    # The coefficients of (4.59) are rounded, 0.00303 stands for 0.00302.
    "motion": Source("printed motion, summed", 5e-3),
    "table": Source("table 3.1, mean forces", None),
    "sampled": Source("drawn from (3.5), noise 5 N", None),
}
"""Sources of points; None where a difference is a finding or meant to be."""


@dataclass(frozen=True, slots=True)
class Axis:
    """What an axis shows: SI values times ``factor`` in ``unit``; ``1`` for none."""

    name: str
    unit: str = "1"
    factor: float = 1.0
    log: bool = False

    @property
    def label(self) -> str:
        """Name and unit."""
        return self.name if self.unit == "1" else f"{self.name} ({self.unit})"


@dataclass(frozen=True, slots=True)
class Mark:
    """A labelled point, SI, its label to the ``right``, ``left`` or ``above``; without one it is the operating point."""

    x: float
    y: float
    label: str = ""
    side: str = "right"


@dataclass(frozen=True, slots=True)
class Level:
    """A labelled straight line at a value of y, or of x if ``upright``; SI."""

    value: float
    label: str
    upright: bool = False


@dataclass(frozen=True, slots=True)
class Curve:
    """A closed form over x, and points that check it.

    Attributes:
        name: what distinguishes the curve from others of its family.
        x, theory: the closed form.
        points: by source, x and y of each point; an impact that comes to no end is left out.
    """

    name: str
    x: Array
    theory: Array
    points: dict[str, tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes.

    Attributes:
        x, y: the axes.
        curves: a family, told apart by ``family``, e.g. the symbol of what varies.
        marks, levels: what is pointed out.
        top: largest y shown, SI, where curves grow without bound; None for all there is.
    """

    x: Axis
    y: Axis
    curves: tuple[Curve, ...]
    family: str = ""
    marks: tuple[Mark, ...] = ()
    levels: tuple[Level, ...] = ()
    top: float | None = None


def curve_of(
    name: str,
    formula: Callable[[Array], ArrayLike],
    x: ArrayLike,
    points: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
) -> Curve:
    """A curve on a grid that holds the x of all its points too, so that each has a value of the curve beside it."""
    given = {law: (np.asarray(at, float), np.asarray(y, float)) for law, (at, y) in (points or {}).items()}
    grid = np.unique(np.concatenate([np.asarray(x, dtype=float), *(at for at, _ in given.values())]))
    return Curve(name, grid, np.asarray(formula(grid), dtype=float), given)
