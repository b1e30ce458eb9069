"""Data of a redrawn figure or table: panels of curves, the points that check them, and the points' distances from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array


@dataclass(frozen=True, slots=True)
class Source:
    """The source of points in words, and their largest permitted relative distance from the curve."""

    words: str
    tolerance: float | None


SOURCES = {
    # Law and closed form share their algebra up to rounding, which grows like 1/distance near the stiction friction.
    "energetic": Source("scene, energetic law", 1e-9),
    # As oblique_impact: a contact resolved in time reaches its rigid-body limit to a thousandth of this.
    "compliant": Source("scene, contact resolved in time", 3e-3),
    "engine": Source("scene, engine's own contact", None),
    "contact": Source("scene, contact of 50 µs", None),
    # The equation as it stands in print, number by number; the cancellation in it leaves 1e-12.
    "printed": Source("printed equation, term by term", 1e-9),
    # The coefficients of (4.59) are rounded, 0.00303 stands for 0.00302.
    "motion": Source("printed motion, summed", 5e-3),
    "table": Source("table 3.1, mean forces", None),
    "sampled": Source("drawn from (3.5), noise 5 N", None),
}
"""Sources of points; no largest distance where a difference is a finding or intended."""


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis shows SI values times ``factor`` in ``unit``; ``1`` for none."""

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
    """A closed form over x, and points that check it, x and y by source; an impact that does not end is left out."""

    name: str
    x: Array
    theory: Array
    points: dict[str, tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes with a family of curves, distinguished by the varied quantity's symbol, with marked points and lines.

    ``top`` is the largest y shown, SI, where curves grow without bound; None shows all of the curves.
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
    """Return a curve on a grid that includes the x of all its points, so that each can be compared with the curve."""
    given = {
        law: (np.asarray(at, float), np.asarray(y, float))
        for law, (at, y) in (points or {}).items()
    }
    grid = np.unique(
        np.concatenate([np.asarray(x, dtype=float), *(at for at, _ in given.values())])
    )
    return Curve(name, grid, np.asarray(formula(grid), dtype=float), given)


@dataclass(frozen=True, slots=True)
class Redrawn:
    """A figure or table of the dissertation with its own data.

    The number is e.g. ``2.24`` or ``table_3.1``; the note is one line for the reader; the rows of a table, the head first,
    are empty for a figure.
    """

    number: str
    title: str
    panels: tuple[Panel, ...] = ()
    note: str = ""
    table: tuple[tuple[str, ...], ...] = ()

    @property
    def name(self) -> str:
        """``figure_2.24`` or ``table_3.1``."""
        return self.number if self.number.startswith("table") else f"figure_{self.number}"

    @property
    def heading(self) -> str:
        """Number and title."""
        kind = self.number.replace("_", " ").capitalize() if self.table else f"Figure {self.number}"
        return f"{kind}: {self.title}"


def largest_differences(figure: Redrawn) -> dict[str, float]:
    """Return by source of points their largest distance from the curve, as a fraction of its largest value beside a point."""
    found: dict[str, float] = {}
    for curve in (curve for panel in figure.panels for curve in panel.curves):
        for source, (at, y) in curve.points.items():
            beside = curve.theory[np.searchsorted(curve.x, at)]
            size = float(np.max(np.abs(beside), initial=0.0)) or 1.0
            fraction = float(np.max(np.abs(y - beside), initial=0.0)) / size
            found[source] = max(found.get(source, 0.0), fraction)
    return found
