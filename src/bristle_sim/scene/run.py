"""The run of a scene: from one event to the next, in one smooth motion after the other.

In flight nothing touches and the engine's contact is off. Where a gap closes, its instant is located and the contact
law resolves the impact. If that leaves the link at rest against the obstacle and pressed on it, the engine's contact
keeps it there, with Coulomb friction, until its force has fallen to zero; the instant of release is located too. Several
contacts may be sustained at a time. Positions of links in sustained contact are set back onto what they touch after every
interval, because the engine's contact only keeps velocities.
"""

from __future__ import annotations

from collections.abc import Sequence

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.decisions import end, enter, first_motion
from bristle_sim.scene.integrate.stepping import Stepper
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.plan import Plan, Recording
from bristle_sim.scene.progress import Progress
from bristle_sim.stop_reason import StopReason


def run(
    scene: Scene, start: State, stepper: Stepper, plan: Plan, obstacles: Sequence[Obstacle] | None = None
) -> Recording:
    """Run a scene from a state to the plan's end.

    Args:
        scene: the scene; its bodies are placed by the run.
        start: the state to start from; obstacles must not be overlapped.
        stepper: how intervals of smooth motion are integrated.
        plan: when to stop.
        obstacles: the pairs; those of the scene by default.

    Raises:
        ValueError: if the start overlaps an obstacle.
    """
    budget = scene.work + plan.maximum_steps
    progress = Progress.at_start(scene, start, stepper, plan, obstacles)
    motion = first_motion(progress)
    while not progress.stopped:
        if progress.state.time >= plan.end * (1.0 - 1e-15):
            progress.stop(StopReason.END)
        elif scene.work >= budget:
            progress.stop(StopReason.STEP_BUDGET)
        else:
            change = motion.proceed()
            motion = motion if change is None else enter(motion, change)
    recording = progress.recording
    end(motion, str(recording.stop_reason))
    return recording
