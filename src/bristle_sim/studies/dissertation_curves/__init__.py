"""The data of every computed figure of the dissertation, and of table 3.1, redrawn: one function a figure, no drawing."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from bristle_sim.studies.dissertation_curves import crater, force, impact, pendulums
from bristle_sim.studies.dissertation_curves.model import Redrawn

__all__ = ["NUMBERS", "redrawn"]

_BUILDERS: dict[str, Callable[[], Redrawn]] = {
    **{number: partial(impact.impact_figure, number) for number in impact.FIGURES},
    "2.26": pendulums.single_pendulum_figure,
    "2.28": partial(pendulums.double_pendulum_figure, "2.28"),
    "2.29": partial(pendulums.double_pendulum_figure, "2.29"),
    "2.30": pendulums.heavy_rod_figure,
    "3.1": force.points_figure,
    "3.2": force.fit_figure,
    "3.3": force.bristle_figure,
    "table_3.1": force.table,
    **crater.FIGURES,
}

NUMBERS = tuple(_BUILDERS)
"""Of all figures, in the dissertation's order, and ``table_3.1``."""


def redrawn(number: str) -> Redrawn:
    """One figure's data; impacts are simulated on the way.

    Raises:
        ValueError: if there is no such figure.
    """
    if number not in _BUILDERS:
        raise ValueError(f"only = {number!r}: one word of {' | '.join(NUMBERS)} is allowed")
    return _BUILDERS[number]()
