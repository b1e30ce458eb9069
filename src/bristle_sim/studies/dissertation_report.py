"""The redrawn figures as a report: how far the points of each lie from its curves."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass

from bristle_sim.comparison import Quantity, Report
from bristle_sim.quantity import choice, validate
from bristle_sim.studies.dissertation_curves import NUMBERS, redrawn
from bristle_sim.studies.dissertation_curves.model import SOURCES, Redrawn, largest_differences

__all__ = ["Selection", "figures_report"]


@dataclass(frozen=True, slots=True)
class Selection:
    """Which figures to redraw."""

    only: str = choice("all", "only", ("all", *NUMBERS), source="chosen: one figure alone")

    def __post_init__(self) -> None:
        validate(self)


def figures_report(selection: Selection) -> Report:
    """Compute curves and points of the figures asked for."""
    begin = clock.perf_counter()
    numbers = NUMBERS if selection.only == "all" else (selection.only,)
    figures = tuple(redrawn(number) for number in numbers)
    heads = tuple(f"{figure.name}: {figure.title}" for figure in figures)
    return Report(
        outcome=None,
        quantities=tuple(row for figure in figures for row in _rows(figure)),
        wall_s=clock.perf_counter() - begin,
        remarks=(
            "",
            "largest distance of points from their curve, as a share of its largest value beside one, in",
            *heads,
        ),
        subject=figures,
    )


def _rows(figure: Redrawn) -> tuple[Quantity, ...]:
    return tuple(
        Quantity(f"{figure.name}_{law}", "1", difference, 0.0, tolerance=SOURCES[law].tolerance)
        for law, difference in largest_differences(figure).items()
    )
