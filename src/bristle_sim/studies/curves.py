"""Panels of curves: closed forms over a parameter, simulated or printed points that check them, and marks."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord


@dataclass(frozen=True, slots=True)
class Source:
    """The source of points in words, and how far they may be off the curve, relative."""

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
    """A closed form over x, and points that check it, x and y by source; an impact that comes to no end is left out."""

    name: str
    x: Array
    theory: Array
    points: dict[str, tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes with a family of curves, distinguished by the symbol of what varies, and points and lines of note.

    ``top`` is the largest y shown, SI, where curves grow without bound; None for all there is.
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
    given = {law: (np.asarray(at, float), np.asarray(y, float)) for law, (at, y) in (points or {}).items()}
    grid = np.unique(np.concatenate([np.asarray(x, dtype=float), *(at for at, _ in given.values())]))
    return Curve(name, grid, np.asarray(formula(grid), dtype=float), given)


def impact_curve(
    name: str,
    formula: Callable[[Array], ArrayLike],
    x: Array,
    impact: Callable[[float], tuple[Chain, Surface]],
    read: Callable[[ContactRecord], float | None],
    places: Mapping[str, Array],
) -> Curve:
    """Return a closed form over x, and what is read from simulated impacts at some places by law.

    An impact without an end, or without the quantity, is left out.
    """
    points: dict[str, tuple[ArrayLike, ArrayLike]] = {}
    for law, at in places.items():
        records = ((each, _struck(*impact(each), law)) for each in at.tolist())
        found = [(each, value) for each, record in records if record and (value := read(record)) is not None]
        if found:
            points[law] = ([each for each, _ in found], [value for _, value in found])
    return curve_of(name, formula, x, points)


@functools.cache
def _struck(chain: Chain, surface: Surface, law: str) -> ContactRecord | None:
    """Return the contact of a strike through the scene; None for one that comes to no end."""
    try:
        return strike(chain, surface, Contact(law), Settings()).contact
    except ValueError:
        return None
