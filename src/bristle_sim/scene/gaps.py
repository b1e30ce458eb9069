"""Gaps between a mechanism's links and what they can touch, state by state."""

from __future__ import annotations

from bristle_sim.scene.events import interpolate
from bristle_sim.scene.mechanism import Mechanism, Pose, State
from bristle_sim.scene.obstacles import Obstacle, Touch

__all__ = ["GAP_ROUNDING", "Gaps"]

GAP_ROUNDING = 1e-11
"""A gap of the scene's unit below this is closed."""


class Gaps:
    """Looks from one state after the other; both ends of an interval are looked up again and again, so they are kept."""

    def __init__(self, mechanism: Mechanism, start: State) -> None:
        """Begin with the poses of a state."""
        self.mechanism = mechanism
        self._poses: tuple[tuple[State, list[Pose]], ...] = ((start, mechanism.poses(start)),)

    def touch(self, obstacle: Obstacle, state: State, piece: int | None = None) -> Touch:
        """Return where and how the link would touch the obstacle, with one of its pieces if it is named."""
        return obstacle.touch_between(self.poses(state), state.rates, piece)

    def gap(self, obstacle: Obstacle, state: State) -> float:
        """Return the distance of link and obstacle, negative inside."""
        return self.touch(obstacle, state).gap

    def gap_and_rate(self, obstacle: Obstacle, state: State) -> tuple[float, float]:
        """Return the distance of link and obstacle, and how fast it opens."""
        touch = self.touch(obstacle, state)
        return touch.gap, touch.velocity[0]

    def rests(self, obstacle: Obstacle, start: State, end: State) -> bool:
        """Whether a gap is closed and stays so."""
        between = (start, interpolate(start, end, 0.5), end)
        return all(abs(self.gap(obstacle, state)) <= GAP_ROUNDING for state in between)

    def poses(self, state: State) -> list[Pose]:
        """Return where every link is and how it moves."""
        for known, poses in self._poses:
            if known is state:
                return poses
        poses = self.mechanism.poses(state)
        self._poses = (self._poses[-1], (state, poses))
        return poses
