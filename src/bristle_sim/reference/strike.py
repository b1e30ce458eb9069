"""One strike of a wire of links on a compliant workpart, resolved in time."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.reference.contacts import Point, obstacles_of
from bristle_sim.reference.decisions import close_contact
from bristle_sim.reference.log import Log
from bristle_sim.reference.mechanics import Chain
from bristle_sim.reference.run import Run
from bristle_sim.reference.system import State, System
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactHistory, ContactRecord

AT_SURFACE = 1e-9  # the wire's end must be at the workpart's surface to this fraction of hub radius and length
SAMPLES = 200  # in the longest time of a contact


class TooStiffError(ValueError):
    """The wire or its contact is so stiff that the explicit integrator takes too many evaluations."""


def strike_reference(
    tool: Tool,
    hub_angle: float,
    angles: Sequence[float],
    rates: Sequence[float],
    stiffness: float,
    *,
    longest: float,
    accuracy: float = 1e-9,
    most_evaluations: int = 20_000,
) -> ContactRecord:
    """Return the first contact of a wire's end with the workpart by a :class:`bristle_sim.reference.contacts.Spring`, with its history.

    Args:
        tool: with a workpart; its bar is left out.
        hub_angle: psi when the end touches, rad.
        angles, rates: absolute angles and rates of the links then, rad and rad/s.
        stiffness: of the contact, N/m.
        longest: the contact must end within this time, s.
        accuracy: relative accuracy requested; the integrator's tolerance is a hundredth of it.
        most_evaluations: of the right-hand side; the contact of a usual wire of 8 links takes a thousand.

    Raises:
        ValueError: if the wire's end is not at the surface or does not approach it, or the contact lasts too long.
        TooStiffError: if the contact takes more than ``most_evaluations``.
    """
    chain = Chain.of(tool, hub_angle)
    obstacles = obstacles_of(dataclasses.replace(tool, bar=None))
    if "workpart" not in obstacles or not stiffness > 0.0:
        raise ValueError(f"stiffness = {stiffness:g}: must be above 0, and the tool must have a workpart (in N/m)")
    start = State(0.0, np.array(angles, dtype=float), np.array(rates, dtype=float))
    system, log = System(chain, obstacles, {"workpart": stiffness}), Log([chain], longest / SAMPLES, "workpart release")
    place = Point("workpart", len(chain.masses) - 1, True)
    touch = system.at(start).touch(place)
    if abs(touch.gap) > AT_SURFACE * system.size or touch.velocity[0] >= 0.0:
        raise ValueError(
            f"angles = {angles[-1]:g}: must bring the wire's end to the workpart, approaching it; its height is"
            f" {touch.gap:g} m, its normal velocity {touch.velocity[0]:g} m/s (in rad)"
        )
    begun = close_contact(system, log, "workpart", len(chain.corners) - 1, start)
    run = Run(system, log, begun, longest, accuracy / 100.0, most_evaluations)
    reason = run.run()
    if reason is StopReason.STEP_BUDGET:
        raise TooStiffError(f"stiffness = {stiffness:g}: must be less for the independent solution (in N/m)")
    if reason not in (StopReason.EVENT, StopReason.END):
        raise ValueError(f"angles, rates: must be those of a contact that ends; its solution stops: {reason}")
    (record,) = log.records
    if not record.seen("workpart release"):
        raise ValueError(f"longest = {longest:g}: must be longer; the contact has not ended (in s)")
    return dataclasses.replace(record.contacts[0], history=_history(system, place, log))


def _history(system: System, place: Point, log: Log) -> ContactHistory:
    """Return the contact in time, from the samples."""
    states, forces = zip(*log.samples, strict=True)
    touches = [system.at(state).touch(place) for state in states]
    return ContactHistory(
        time=np.array([state.time for state in states]),
        normal_force=np.array(forces)[:, 0, 0],
        tangential_force=np.array(forces)[:, 0, 1],
        penetration=np.array([-each.gap for each in touches]),
        normal_velocity=np.array([each.velocity[0] for each in touches]),
        tangential_velocity=np.array([each.velocity[1] for each in touches]),
    )
