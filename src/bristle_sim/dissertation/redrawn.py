"""Hold the data of a redrawn figure or table, and measure how far its points are from its curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle_sim.studies.curves import Panel


@dataclass(frozen=True, slots=True)
class Redrawn:
    """A figure or table of the dissertation with its own data.

    The number is e.g. ``2.24`` or ``table_3.1``; the note, one line, is what a reader should know; the rows of a table, the
    head first, are empty for a figure.
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
        for law, (at, y) in curve.points.items():
            beside = curve.theory[np.searchsorted(curve.x, at)]
            size = float(np.max(np.abs(beside), initial=0.0)) or 1.0
            share = float(np.max(np.abs(y - beside), initial=0.0)) / size
            found[law] = max(found.get(law, 0.0), share)
    return found
