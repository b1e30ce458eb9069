"""The load that contacts put on a scene: the interface to an integrator, and the forces and sums that it reports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol


class Sums(NamedTuple):
    """Forces of one contact on its link at the end of an interval, and their sums over it; engine units.

    Attributes:
        normal, tangential: the forces. In stick the tangential one is the force that friction would have to supply.
        impulse_normal, impulse_tangential: their integrals over the time.
        work_normal, work_tangential: their integrals over the path.
        tangential_at_start: the tangential force of a spring in stick at the beginning of the interval.
    """

    normal: float = 0.0
    tangential: float = 0.0
    impulse_normal: float = 0.0
    impulse_tangential: float = 0.0
    work_normal: float = 0.0
    work_tangential: float = 0.0
    tangential_at_start: float = 0.0


NUMBERS = len(Sums._fields)  # of a contact in the flat list that an integrator extrapolates


def sums_of(totals: Sequence[float], index: int) -> Sums:
    """Return the sums of one contact from the flat list of all."""
    return Sums(*totals[NUMBERS * index : NUMBERS * (index + 1)])


class Load(Protocol):
    """The forces of all contacts of a smooth motion, as an integrator sees them.

    Attributes:
        symmetric: whether they act alike forwards and backwards in time.
    """

    symmetric: bool

    def begin(self, step: float) -> Callable[[], None]:
        """Reset the sums; return a callback to run before each step of this length."""

    def totals(self) -> list[float]:
        """Return the numbers of :class:`Sums` of each contact, with the last step."""

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether a contact would have to pull."""
