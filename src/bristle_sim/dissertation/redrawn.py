"""Data of a redrawn figure or table: panels of curves, and points with their distances from the
curves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array


@dataclass(frozen=True, slots=True)
class Source:
    """The source of a set of points, with the largest distance at which they count as lying on
    their curve.

    The distance is a fraction of the curve's largest value. It is None for points that need not lie
    on the curve.
    """

    words: str
    tolerance: float | None


SOURCES = {
    # Law and closed form differ by rounding error alone, which grows towards the stiction friction
    # like the reciprocal of the distance from it.
    "energetic": Source("scene, energetic law", 1e-9),
    # As in oblique_impact: a contact resolved in time differs from its rigid-body limit by a
    # thousandth of this tolerance.
    "compliant": Source("scene, contact resolved in time", 3e-3),
    "engine": Source("scene, engine's own contact", None),
    "contact": Source("scene, contact of 50 µs", None),
    # The printed equation with its printed numbers; cancellation leaves an error of 1e-12.
    "printed": Source("printed equation, term by term", 1e-9),
    # The coefficients of (4.59) are rounded: 0.00303 is printed for 0.00302.
    "motion": Source("printed motion, summed", 5e-3),
    "table": Source("table 3.1, mean forces", None),
    "sampled": Source("drawn from (3.5), noise 5 N", None),
}
"""Sources of points by name; the tolerance is None where a difference is a finding or intended."""


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis of a figure, which shows SI values times ``factor`` in ``unit``.

    The unit of a dimensionless quantity is ``1``.
    """

    name: str
    unit: str = "1"
    factor: float = 1.0
    log: bool = False

    @property
    def label(self) -> str:
        """Name of the quantity with its unit in parentheses."""
        return self.name if self.unit == "1" else f"{self.name} ({self.unit})"

    def shown(self, value: float) -> str:
        """Return the text of an SI value in the axis's unit, with up to six decimals."""
        unit = {"1": "", "°": "°"}.get(self.unit, f" {self.unit}")
        return f"{round(value * self.factor, 6):g}{unit}"


@dataclass(frozen=True, slots=True)
class Mark:
    """A marked point of a figure, in SI units.

    ``side`` is the side of the point at which the label stands: ``right``, ``left`` or ``above``. A
    mark without a label is the operating point.
    """

    x: float
    y: float
    label: str = ""
    side: str = "right"


@dataclass(frozen=True, slots=True)
class Level:
    """A labelled straight line at a constant y, in SI units, or at a constant x if ``upright``."""

    value: float
    label: str
    upright: bool = False


@dataclass(frozen=True, slots=True)
class Curve:
    """The curve of a closed form over x, with points that check the closed form.

    ``points`` holds the arrays x and y by source. An impact that does not end has no point.
    """

    name: str
    x: Array
    theory: Array
    points: dict[str, tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes with a family of curves, marked points and lines.

    Attributes:
        x: horizontal axis.
        y: vertical axis.
        curves: the curves; the name of each is its value of the quantity that varies.
        family: symbol of the quantity that varies from curve to curve.
        marks: labelled points.
        levels: labelled straight lines.
        top: largest y shown, in SI units, where curves grow without bound; None shows the whole
            curves.
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
    """Return the curve of a formula on a grid of x that includes the x of every point.

    The distance of a point from the curve then needs no interpolation.
    """
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
    """A figure or table of the dissertation with recomputed data.

    Attributes:
        number: number of the figure or table, such as ``2.24`` or ``table_3.1``.
        title: title of the figure or table.
        panels: panels of a figure.
        note: one line for the reader.
        table: rows of a table, with the header first; empty for a figure.
    """

    number: str
    title: str
    panels: tuple[Panel, ...] = ()
    note: str = ""
    table: tuple[tuple[str, ...], ...] = ()

    @property
    def name(self) -> str:
        """Name of the figure or table, such as ``figure_2.24`` or ``table_3.1``."""
        return self.number if self.number.startswith("table") else f"figure_{self.number}"

    @property
    def heading(self) -> str:
        """Number and title, as shown above the figure or table."""
        kind = self.number.replace("_", " ").capitalize() if self.table else f"Figure {self.number}"
        return f"{kind}: {self.title}"


def largest_differences(figure: Redrawn) -> dict[str, float]:
    """Return the largest distance of the points of each source from their curve.

    The distance is a fraction of the curve's largest magnitude at the points of this source.
    """
    found: dict[str, float] = {}
    for curve in (curve for panel in figure.panels for curve in panel.curves):
        for source, (at, y) in curve.points.items():
            beside = curve.theory[np.searchsorted(curve.x, at)]
            size = float(np.max(np.abs(beside), initial=0.0)) or 1.0
            fraction = float(np.max(np.abs(y - beside), initial=0.0)) / size
            found[source] = max(found.get(source, 0.0), fraction)
    return found
