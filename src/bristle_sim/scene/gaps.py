"""Gaps between a mechanism's last link and its obstacles, state by state."""

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
        """From a state on."""
        self.mechanism = mechanism
        self._poses: tuple[tuple[State, Pose], ...] = ((start, mechanism.poses(start)[-1]),)

    def touch(self, obstacle: Obstacle, state: State) -> Touch:
        """Where and how the link would touch the obstacle."""
        return obstacle.touch(self._pose(state), state.rates[-1])

    def gap(self, obstacle: Obstacle, state: State) -> float:
        """Distance of link and obstacle, negative inside."""
        return self.touch(obstacle, state).gap

    def gap_and_rate(self, obstacle: Obstacle, state: State) -> tuple[float, float]:
        """The same, and how fast it opens."""
        touch = self.touch(obstacle, state)
        return touch.gap, touch.velocity[0]

    def rests(self, obstacle: Obstacle, start: State, end: State) -> bool:
        """Whether a gap is closed and stays so."""
        between = (start, interpolate(start, end, 0.5), end)
        return all(abs(self.gap(obstacle, state)) <= GAP_ROUNDING for state in between)

    def _pose(self, state: State) -> Pose:
        for known, pose in self._poses:
            if known is state:
                return pose
        pose = self.mechanism.poses(state)[-1]
        self._poses = (self._poses[-1], (state, pose))
        return pose
