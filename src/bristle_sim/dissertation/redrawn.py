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
    """The origin of a set of points in a figure.

    Attributes:
        words: the origin in words.
        tolerance: largest distance of the points from their curve, as a fraction of the curve's
            largest value. It is None for points that need not lie on the curve.
    """

    words: str
    tolerance: float | None


SOURCES = {
    # Simulation and closed form differ by rounding error alone. The error is inversely proportional
    # to the distance of the friction coefficient from the value at which stiction begins.
    "energetic": Source("scene, energetic law", 1e-9),
    # The tolerance of the scenario oblique_impact. A contact resolved in time usually differs from
    # its rigid-body limit by a thousandth of it.
    "compliant": Source("scene, contact resolved in time", 3e-3),
    "engine": Source("scene, engine's own contact", None),
    "contact": Source("scene, contact of 50 µs", None),
    # The printed equation, evaluated with the printed numbers. Cancellation makes an error of
    # 1e-12.
    "printed": Source("printed equation, term by term", 1e-9),
    # The coefficients of (4.59) are rounded: 0.00303 is printed for 0.00302.
    "motion": Source("printed motion, summed", 5e-3),
    "table": Source("table 3.1, mean forces", None),
    "sampled": Source("drawn from (3.5), noise 5 N", None),
}
"""Origins of points, by name.

The tolerance is None where a difference is intended, or is itself a result."""


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis of a figure: name, unit and scale.

    Attributes:
        name: name of the quantity.
        unit: unit shown, ``1`` for a dimensionless quantity.
        factor: factor from the SI unit to the unit shown.
        log: whether the scale is logarithmic.
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
        """Return the text of a value that is given in SI units.

        The text shows the value in the axis's unit, with up to six decimals.
        """
        unit = {"1": "", "°": "°"}.get(self.unit, f" {self.unit}")
        return f"{round(value * self.factor, 6):g}{unit}"


@dataclass(frozen=True, slots=True)
class Mark:
    """A marked point of a figure, with coordinates in SI units.

    ``side`` is the side of the point on which the label stands: ``right``, ``left`` or ``above``. A
    mark without a label is the operating point.
    """

    x: float
    y: float
    label: str = ""
    side: str = "right"


@dataclass(frozen=True, slots=True)
class Level:
    """A labelled straight line across a panel, in SI units.

    The line is vertical at x = ``value`` if ``upright`` is true, otherwise horizontal at y =
    ``value``.
    """

    value: float
    label: str
    upright: bool = False


@dataclass(frozen=True, slots=True)
class Curve:
    """The curve of a formula, with points that check the formula.

    Attributes:
        name: label of the curve.
        x: horizontal coordinates of the curve, in SI units.
        theory: values of the formula at ``x``.
        points: arrays x and y of the points, by origin (a key of ``SOURCES``).
    """

    name: str
    x: Array
    theory: Array
    points: dict[str, tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes with a family of curves, marked points and straight lines.

    Attributes:
        x: horizontal axis.
        y: vertical axis.
        curves: the curves. The name of a curve states the value of the quantity ``family``.
        family: symbol of the quantity that varies from curve to curve.
        marks: marked points.
        levels: labelled straight lines.
        top: upper end of the vertical axis (SI unit) for curves that grow without bound. None if
            the whole curves are shown.
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
    """Return the curve of a formula, with points.

    The grid ``x`` is extended by the x of every point, so that the distance of a point from the
    curve needs no interpolation.

    Args:
        name: label of the curve.
        formula: function of x.
        x: grid of the curve.
        points: arrays x and y of the points, by origin.
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
    """A recomputed figure or table of the dissertation.

    Attributes:
        number: number of the figure or table, such as ``2.24`` or ``table_3.1``.
        title: title of the figure or table.
        panels: panels of a figure.
        note: remark below the title.
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
    """Return the largest distance of a figure's points from their curve, by the points' source.

    A source is a key of ``SOURCES``, such as the dissertation's print. The distance is vertical,
    and is divided by the curve's largest magnitude at these points.
    """
    found: dict[str, float] = {}
    for curve in (curve for panel in figure.panels for curve in panel.curves):
        for source, (at, y) in curve.points.items():
            beside = curve.theory[np.searchsorted(curve.x, at)]
            size = float(np.max(np.abs(beside), initial=0.0)) or 1.0
            fraction = float(np.max(np.abs(y - beside), initial=0.0)) / size
            found[source] = max(found.get(source, 0.0), fraction)
    return found
