"""What the study found: points and effects, and our cost beside the cheapest peer's at the same error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.cases import Case
from bristle_sim.benchmarks.accuracy_cost.effects import Effect
from bristle_sim.benchmarks.accuracy_cost.measure import Point, cheapest, package_of

__all__ = ["OURS", "AccuracyCost", "Comparison", "comparisons", "milliseconds"]

OURS = "bristle_sim"

TARGETS = {
    "release_flight": (1e-3, 1e-6, 1e-9),
    "strike": (1e-3, 1e-6),
    "double_pendulum": (1e-3, 1e-6),
    "whole_pass": (1e-4, 1e-6),
}
"""Errors at which costs are compared."""

NOT_IN_TIME = ("bristle_sim energetic", "bristle_sim engine")
"""Our impact laws that take no steps in time; they are not compared with integrators."""


@dataclass(frozen=True, slots=True)
class AccuracyCost:
    """All that was measured, for tables and pictures.

    Attributes:
        cases: in order.
        points: of all cases and methods.
        effects: what each effect costs.
        missing: packages that are not installed.
    """

    cases: tuple[Case, ...]
    points: tuple[Point, ...]
    effects: tuple[Effect, ...]
    missing: tuple[str, ...]

    def of(self, case: str) -> list[Point]:
        """The points of a case."""
        return [point for point in self.points if point.case == case]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Our cheapest point in time within a target error and the cheapest peer's; None where there is none."""

    case: str
    target: float
    ours: Point | None
    peer: Point | None

    @property
    def ratio(self) -> float | None:
        """Of our CPU time to the peer's."""
        return None if self.ours is None or self.peer is None else self.ours.cpu_s / self.peer.cpu_s

    def as_dict(self) -> dict[str, Any]:
        """As plain values."""
        ours, peer = (None if point is None else point.method for point in (self.ours, self.peer))
        return {"case": self.case, "target": self.target, "ours": ours, "peer": peer, "ratio": self.ratio}


def comparisons(measured: AccuracyCost) -> list[Comparison]:
    """One for each case and target."""
    return [
        _compared(case.name, measured.of(case.name), target) for case in measured.cases for target in TARGETS[case.name]
    ]


def _compared(case: str, points: list[Point], target: float) -> Comparison:
    ours = [each for each in points if package_of(each.method) == OURS and each.method not in NOT_IN_TIME]
    peers = [each for each in points if package_of(each.method) != OURS]
    return Comparison(case, target, cheapest(ours, target), cheapest(peers, target))


def milliseconds(point: Point | None) -> float | None:
    """A point's CPU time."""
    return None if point is None else 1e3 * point.cpu_s
