"""Where neighbouring links of a wire touch the same obstacle at their joint: a touch there belongs to one of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from bristle_sim.scene.contact.gaps import GAP_ROUNDING
from bristle_sim.scene.contact.obstacles import BarObstacle, Obstacle
from bristle_sim.scene.mechanism import State

if TYPE_CHECKING:
    from bristle_sim.scene.progress import Progress


AT_JOINT = 1e-9
"""Fraction of a link within which a foot on it is at its end."""


def neighbour(progress: Progress, obstacle: Obstacle, step: int) -> BarObstacle | None:
    """Return the pair of the same obstacle and the next link of the wire towards the tip (1) or the root (-1)."""
    link, size = obstacle.link + step, progress.mechanism.wire_links
    if obstacle.link < 0 or not isinstance(obstacle, BarObstacle) or link // size != obstacle.link // size:
        return None
    return next((each for each in progress.obstacles if isinstance(each, BarObstacle) and each.link == link), None)


def behind_joint(progress: Progress, obstacle: Obstacle, active: Sequence[Obstacle], end: State) -> bool:
    """Whether a link is nearest to what its neighbour is in contact with at the joint that both have, up to a state.

    One that is clear of it and ends elsewhere may touch it by itself.
    """
    if not isinstance(obstacle, BarObstacle):
        return False
    gaps, now = progress.gaps, progress.state
    sides = [(1.0, 0, neighbour(progress, obstacle, -1)), (-1.0, 1, neighbour(progress, obstacle, 1))]
    for sign, index, other in sides:
        if other in active:
            feet = [sign * obstacle.foot(gaps.poses(state)[obstacle.link])[index] for state in (now, end)]
            if feet[0] <= AT_JOINT and (feet[1] <= AT_JOINT or gaps.gap(obstacle, now) <= GAP_ROUNDING):
                return True
    return False


def at_joint(progress: Progress, obstacle: Obstacle) -> Obstacle:
    """Return the pair that a touch belongs to: at a joint, the one of the link before it, whose round end is there."""
    lower = neighbour(progress, obstacle, -1)
    if (
        lower is None
        or not isinstance(obstacle, BarObstacle)
        or obstacle.foot(progress.gaps.poses(progress.state)[obstacle.link])[0] > 0.0
    ):
        return obstacle
    return lower
