"""Gaps between a mechanism's links and what they can touch, state by state."""

from __future__ import annotations

from bristle_sim.scene.events import interpolate
from bristle_sim.scene.mechanism import Mechanism, Pose, State
from bristle_sim.scene.obstacles import Obstacle, Touch

GAP_ROUNDING = 1e-11
"""A gap of the scene's unit below this is closed."""


class Gaps:
    """Gaps, touches and poses of a mechanism's links at any state."""

    def __init__(self, mechanism: Mechanism) -> None:
        """Look at a mechanism, which keeps the poses of the last few states."""
        self.mechanism = mechanism

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
        return self.mechanism.poses(state)
