"""The loop of a run: smooth motions, and a decision about the contacts after each event between
them.

In flight nothing touches. Where a gap closes, the instant is located and the contact law resolves
the impact. If the link is then pressed onto the obstacle, the contact is sustained, with Coulomb
friction, until its normal force falls to zero. The instant of this release is located too. Several
contacts may be sustained at the same time.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator

from bristle_sim.scene.collisions import end_contacts
from bristle_sim.scene.decide import decide, first_motion
from bristle_sim.scene.events import Happening
from bristle_sim.scene.motion import Motion, accept, integrate, up_to_first_event
from bristle_sim.scene.system import Recording, System
from bristle_sim.settings import StopReason

log = logging.getLogger(__name__)


def run(system: System) -> Recording:
    """Run a system from its present state to the plan's end, and return the recording."""
    for _ in run_by_intervals(system):
        pass
    return system.recording


def run_by_intervals(system: System) -> Iterator[tuple[Motion, Happening | None]]:
    """Run a system from its present state to the plan's end, interval by interval.

    Yields:
        Pairs of a motion and the event that has ended its interval, or None. The first pair is the
            motion with which the run starts, and None. Each interval yields one pair at its end.
            Each event yields a second pair: the motion that follows the event, and None. The last
            pair is a motion without contacts, and None.
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
            accept(system, motion, interval)
        log.debug("%.4f", system.state.time / plan.end)  # fraction of the run that is done
        if interval is None and event is None:
            continue
        yield motion, event
        if event is not None:
            motion = decide(system, motion, event)
            yield motion, None
    end_contacts(system, motion.contacts, motion.contacts, str(system.recording.stop_reason))
    yield Motion(), None
