"""All recomputed figures of the dissertation and table 3.1, with the distances of the points from
their curves.
"""

from __future__ import annotations

import logging
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from bristle_sim.comparison import Quantity, Report, Unfinished
from bristle_sim.declared import Declared
from bristle_sim.dissertation import crater_figures, force_figures, impact_figures, pendulum_figures
from bristle_sim.dissertation.redrawn import SOURCES, Redrawn, largest_differences
from bristle_sim.fields import choice

_BUILDERS: dict[str, Callable[[], Redrawn]] = {
    **{number: partial(impact_figures.impact_figure, number) for number in impact_figures.FIGURES},
    "2.28": partial(pendulum_figures.rate_figure, "2.28", "rod BC", 2),
    "2.29": partial(pendulum_figures.rate_figure, "2.29", "rod OB", 1),
    "2.30": pendulum_figures.heavy_rod_figure,
    "3.1": force_figures.points_figure,
    "3.2": force_figures.fit_figure,
    "3.3": force_figures.bristle_figure,
    "table_3.1": force_figures.table,
    **crater_figures.FIGURES,
}

NUMBERS = tuple(_BUILDERS)
"""Numbers of all figures, in the dissertation's order, and ``table_3.1``."""


def redrawn(number: str) -> Redrawn:
    """Return the data of the figure or table with a given number, after simulating its impacts."""
    return _BUILDERS[number]()


@dataclass(frozen=True, slots=True)
class Selection(Declared):
    """The choice of the figure or table to redraw."""

    only: str = choice(
        "only: figure or table that is redrawn [chosen: one figure alone]", "all", *NUMBERS
    )


def figures_report(selection: Selection) -> Report:
    """Compute the curves and points of the requested figures.

    Raises:
        Unfinished: if the user interrupts the computation. The exception carries a report of the
            figures computed so far.
    """
    begin = clock.perf_counter()
    numbers = NUMBERS if selection.only == "all" else (selection.only,)
    figures: list[Redrawn] = []

    def report() -> Report:
        """Return the report on the figures computed so far.

        Its quantities are the largest distances of points from their curves.
        """
        quantities = tuple(
            _quantity(each, source, distance)
            for each in figures
            for source, distance in largest_differences(each).items()
        )
        words = "largest distance of the points from their curve, as a fraction of the curve's largest value at them:"
        return Report(
            outcome=None,
            quantities=quantities,
            wall_s=clock.perf_counter() - begin,
            remarks=(words, *(f"{each.name}: {each.title}" for each in figures)),
            subject=tuple(figures),
            answer=_answer(quantities),
        )

    try:
        for number in numbers:
            logging.getLogger(__name__).info(
                "figure %s (%d of %d)", number, len(figures) + 1, len(numbers)
            )
            figures.append(redrawn(number))
    except KeyboardInterrupt:
        raise Unfinished(report()) from None
    return report()


def _quantity(figure: Redrawn, source: str, distance: float) -> Quantity:
    label = f"{figure.name.replace('_', ' ')}, {SOURCES[source].words}"
    return Quantity(
        f"{figure.name}_{source}",
        "1",
        distance,
        0.0,
        tolerance=SOURCES[source].tolerance,
        label=label,
    )


def _answer(quantities: Sequence[Quantity]) -> str:
    """Return a sentence that says whether all points lie on their curves.

    Of the points that need not lie on their curve, the sentence also names those with the largest
    distance.
    """
    judged = [each for each in quantities if each.ok is not None]
    missed = [each.label for each in judged if not each.ok]
    if missed:
        return f"No: points are off their curves in {len(missed)} of {len(judged)} sets: {'; '.join(missed)}."
    verdict = (
        "Yes: all points that must lie on a curve do."
        if judged
        else "No points must lie on these curves."
    )
    findings = [each for each in quantities if each.ok is None]
    if not findings:
        return verdict
    distance, label = max((each.simulated or 0.0, each.label) for each in findings)
    return f"{verdict} Of the other points, the farthest from their curve are {label}: by {distance:.2g} of its largest value."
