"""Where a run has got to, with what it runs, and what it has recorded so far."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from bristle_sim.scene.build import Scene
from bristle_sim.scene.changes import Changes
from bristle_sim.scene.contact_laws import ContactLaw
from bristle_sim.scene.gaps import GAP_ROUNDING, Gaps
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.plan import Plan, Recording
from bristle_sim.scene.stepping import Stepper
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import Event

__all__ = ["Progress", "Rebound"]


class Rebound(NamedTuple):
    """The last rebound: from which obstacle, when, and how fast the contact point left."""

    obstacle: str
    time: float
    speed: float


@dataclass(slots=True)
class Progress:
    """What the contact states of one run share.

    Attributes:
        scene, stepper, law, plan: of the run.
        state: the last state that was reached.
        gaps: between the last link and the obstacles.
        changes: signs of the event functions.
        recording: what the run leaves behind.
        rebound: the last rebound, if there was one.
    """

    scene: Scene
    stepper: Stepper
    law: ContactLaw
    plan: Plan
    state: State
    gaps: Gaps
    changes: Changes
    recording: Recording
    rebound: Rebound | None = None

    @classmethod
    def at_start(cls, scene: Scene, start: State, stepper: Stepper, law: ContactLaw, plan: Plan) -> Progress:
        """Return the progress of a run that has not moved yet.

        Raises:
            ValueError: if the start overlaps an obstacle.
        """
        gaps, changes = Gaps(scene.mechanism, start), Changes(scene, stepper, plan.accuracy)
        progress = cls(scene, stepper, law, plan, start, gaps, changes, Recording())
        progress.sample(0.0)
        for obstacle in scene.effects.obstacles:
            gap = gaps.gap(obstacle, start)
            if gap < -GAP_ROUNDING:
                raise ValueError(
                    f"{obstacle.name}: must not overlap the bristle at the start, by {-gap:.3g} of its length"
                )
        return progress

    @property
    def mechanism(self) -> Mechanism:
        """The scene's mechanism."""
        return self.scene.mechanism

    @property
    def stopped(self) -> bool:
        """Whether the run has a reason to stop."""
        return self.recording.stop_reason is not None

    @property
    def first_interval(self) -> float:
        """Longest interval right after a contact, and the least that the growth of later ones starts from."""
        return min(1e-2, max(1e-5, math.sqrt(self.plan.accuracy)))

    def touches(self, obstacle: Obstacle) -> bool:
        """Whether the link is on an obstacle, but for rounding."""
        return abs(self.gaps.gap(obstacle, self.state)) <= GAP_ROUNDING

    def sample(self, force: float) -> None:
        """Record the state that was reached, with the normal force."""
        self.recording.states.append(self.state)
        self.recording.forces.append(force)

    def event(self, name: str, time: float) -> None:
        """Record an event, which may be the one that ends the run."""
        self.recording.events.append(Event(name, time))
        if name == self.plan.stop_after:
            self.stop(FINAL.get(name, StopReason.EVENT))

    def stop(self, reason: StopReason) -> None:
        """End the run; the first reason counts."""
        self.recording.stop_reason = self.recording.stop_reason or reason


FINAL = {"jam": StopReason.JAM, "retraction limit": StopReason.RETRACTION_LIMIT}
"""Events after which nothing goes on, requested or not."""
