"""The run of a scene: one smooth motion after another, and a decision after each event between them.

In flight nothing touches. Where a gap closes, its instant is located and the contact law resolves the impact. If the link then
rests against the obstacle and is pressed on it, the contact is sustained, with Coulomb friction, until its force has fallen to
zero; the instant of release is located too. Several contacts may be sustained at a time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bristle_sim.scene.build import Scene
from bristle_sim.scene.collisions import end_contacts
from bristle_sim.scene.decide import decide, first_motion
from bristle_sim.scene.extrapolation import Stepper
from bristle_sim.scene.happening import Happening, Kind
from bristle_sim.scene.impacts import ENERGETIC, ContactLaw
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.motion import Motion, accept, integrate, overdue, up_to_first_event
from bristle_sim.scene.pairs import ContactPair
from bristle_sim.scene.system import Plan, Recording, System
from bristle_sim.settings import StopReason


def run(
    scene: Scene,
    start: State,
    stepper: Stepper,
    plan: Plan,
    pairs: Sequence[ContactPair] | None = None,
    law: ContactLaw = ENERGETIC,
) -> Recording:
    """Run a scene from a state to the plan's end.

    Args:
        scene: the scene.
        start: its state at the start.
        stepper: integrator of motion without springs.
        plan: of the run.
        pairs: the pairs that can touch, those of the scene by default.
        law: impact law of the workpart.
    """
    system = System(scene, start, stepper, plan, pairs, law)
    for _ in run_by_intervals(system):
        pass
    return system.recording


def run_by_intervals(system: System) -> Iterator[tuple[Motion, Happening | None]]:
    """Run a system from its present state to the plan's end, interval by interval.

    Yields:
        The motion with which the run starts, and None. At the end of each interval its motion, and the event that ended it or
        None; after an event once more, with the motion that was decided and None. At the end of the run a motion without
        contacts, and None.
    """
    plan = system.plan
    engine = system.scene.engine
    budget = engine.work + plan.maximum_steps
    motion = first_motion(system)
    yield motion, None
    while system.recording.stop_reason is None:
        if system.state.time >= plan.end * (1.0 - 1e-15):
            system.stop(StopReason.END)
            break
        if engine.work >= budget:
            system.stop(StopReason.STEP_BUDGET)
            break
        interval, event = integrate(system, motion)
        if interval is not None:
            interval, event = up_to_first_event(system, motion, interval)
        if interval is not None:
            if interval.length > 0.0:
                accept(system, motion, interval)
            event = event or overdue(system, motion)
            if motion.locked:
                event = Happening(Kind.LOCKED, None)
        if interval is not None or event is not None:
            yield motion, event
        if event is not None:
            motion = decide(system, motion, event)
            yield motion, None
    end_contacts(system, motion.contacts, motion.contacts, str(system.recording.stop_reason))
    yield Motion(), None
