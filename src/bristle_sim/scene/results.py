"""Results of a run, converted from engine units to SI units."""

from __future__ import annotations

import dataclasses
import math
import time as clock
from collections.abc import Sequence
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.system import System
from bristle_sim.scene.tool import Units
from bristle_sim.settings import ABSENCES, LARGEST_RETRACTION, StopReason
from bristle_sim.trajectory import ContactHistory, ContactRecord, Cost, Event, Trajectory


def trajectories_in_si(
    tool: Tool, system: System, units: Units, parameters: dict[str, Any]
) -> tuple[Trajectory, ...]:
    """Return one trajectory for each wire, in SI units, from the record of a run.

    Args:
        tool: the tool that was simulated.
        system: the system after its run.
        units: conversion factors from engine units to SI units.
        parameters: the input of the run, as plain numbers and strings.
    """
    recording = system.recording
    wall = clock.perf_counter() - recording.begun_wall
    cpu = clock.process_time() - recording.begun_cpu
    scene = system.scene
    forces = np.array(recording.forces) * units.force
    found = []
    for number in range(scene.mechanism.wires):
        motion = motion_in_si(scene, units, recording.states, number)
        found.append(
            Trajectory(
                **motion,
                normal_force=forces[:, number],
                hub_speed=parameters["tool"]["hub"]["speed"],
                events=_events(system, units, number, motion),
                contacts=contacts_in_si(recording.contacts, scene.mechanism, number, units),
                stop_reason=recording.stop_reason or StopReason.END,
                cost=Cost(
                    wall,
                    cpu,
                    scene.steps,
                    recording.error / system.plan.scale,
                    None if recording.lost is None else recording.lost * units.time,
                ),
                parameters=parameters,
                stop_detail=recording.stop_detail,
            ).with_places(tool)
        )
    return tuple(found)


def motion_in_si(
    scene: Scene, units: Units, states: Sequence[State], wire: int = 0
) -> dict[str, Array]:
    """Return the motion and the energies of a wire at n samples, in SI units.

    The result is a dictionary with the names of a ``Trajectory``'s attributes as keys. The
    potential energy is that of belt, hinges and gravity.
    """
    mechanism = scene.mechanism
    effects = scene.effects
    first = wire * mechanism.wire_links
    own = slice(first, first + mechanism.wire_links)
    time, angles, rates = (np.array(column) for column in zip(*states, strict=True))
    poses = mechanism.poses_at(time, angles.T, rates.T, np.exp)[own]
    angles = angles[:, own]
    rates = rates[:, own]
    hub = mechanism.root_angle(time, first)
    kinetic = np.zeros(len(time))
    potential = 0.5 * effects.stiffness * (angles[:, 0] - hub) ** 2
    potential += 0.5 * effects.hinge[0] * (np.diff(angles) ** 2).sum(axis=1)
    places: list[Array] = []
    velocities: list[Array] = []
    for link, pose, rate in zip(mechanism.links[own], poses, rates.T, strict=True):
        velocity = pose.velocity + 1j * rate * pose.to_centre
        kinetic += 0.5 * link.mass * np.abs(velocity) ** 2 + 0.5 * link.inertia * rate**2
        potential += effects.gravity * link.mass * (pose.joint + pose.to_centre).imag
        for corner in pose.corners[1 if places else 0 :]:
            places.append(corner)
            velocities.append(pose.velocity + 1j * rate * (corner - pose.joint))
    line, moving = (np.stack(each, axis=1)[..., None].view(float) for each in (places, velocities))
    return {
        "time": time * units.time,
        "angles": angles,
        "rates": rates / units.time,
        "centre_line": line * units.length,
        "centre_line_velocity": moving * units.velocity,
        "hub_angle": hub,
        "kinetic_energy": kinetic * units.energy,
        "potential_energy": potential * units.energy,
    }


def _events(system: System, units: Units, wire: int, motion: dict[str, Array]) -> tuple[Event, ...]:
    """Return a wire's events in SI units; lesser maxima of the retraction are left out.

    The run has recorded every local maximum of the retraction. Of the maxima before the strike (or
    before the end of a run without a strike) only the largest one is returned. Of several that are
    equal within the run's accuracy it is the first. No maximum is returned if the retraction is
    larger at the strike or the end, or as large at the start. A maximum that has stopped the run is
    always returned. If the wire has not touched the bar, or not touched the workpart, an event at
    the end of the run states this.

    Args:
        system: the system after its run.
        units: conversion factors from engine units to SI units.
        wire: index of the wire.
        motion: the wire's motion, as returned by ``motion_in_si``.
    """
    recording = system.recording
    times = motion["time"]
    lag = motion["hub_angle"] - motion["angles"][:, 0]
    end = float(times[-1])
    found = [
        Event(event.name, event.time * units.time)
        for event, wires in recording.events
        if wire in wires
    ]
    names = [event.name for event in found]
    strike = min([event.time for event in found if event.name == "strike"], default=math.inf)
    turns = [each.time for each in found if each.name == LARGEST_RETRACTION and each.time <= strike]
    instants = [times[0], *turns, min(strike, end)]
    retractions = lag[np.searchsorted(times, instants)]
    largest = max(retractions)
    equal = retractions >= largest - system.plan.accuracy * system.plan.scale
    kept = [instants[equal.argmax()]] if largest >= 0.0 else []
    if recording.stop_reason is StopReason.EVENT:
        kept.append(end)
    found = [each for each in found if each.name != LARGEST_RETRACTION or each.time in kept]
    parts = {each.name for each in system.scene.effects.pairs}
    for name, absence in ABSENCES.items():
        if name.split()[0] in parts and absence not in names:
            found.append(Event(name, end))
    return tuple(found)


def contacts_in_si(
    records: Sequence[tuple[ContactRecord, tuple[int, ...]]],
    mechanism: Mechanism,
    wire: int,
    units: Units,
) -> tuple[ContactRecord, ...]:
    """Return a wire's contact records in SI units, in order of time.

    A returned record holds the angles and angular velocities of this wire only, the number of the
    link in contact and, in a contact of two bristles, the number of the other bristle. ``records``
    pairs the record of each contact of the run with the indices of the links in contact.
    """
    size = mechanism.wire_links
    own = slice(wire * size, (wire + 1) * size)
    found = []
    for contact, links in records:
        wires = [link // size for link in links]
        if wire in wires:
            place = wires.index(wire)
            found.append(
                contact_in_si(
                    contact,
                    units,
                    angles=contact.angles[own],
                    rates_before=contact.rates_before[own],
                    rates_after=contact.rates_after[own],
                    link=links[place] % size + 1 if size > 1 else None,
                    neighbour=wires[place - 1] + 1 if len(wires) > 1 else None,
                )
            )
    return tuple(sorted(found, key=attrgetter("time")))


UNIT_OF = {
    "time": "time", "duration": "time", "impulse": "impulse", "compressive_impulse": "impulse",
    "compressive_work": "energy", "restitutive_work": "energy", "velocity_before": "velocity",
    "velocity_after": "velocity", "rates_before": "rate", "rates_after": "rate", "normal_force": "force",
    "tangential_force": "force", "penetration": "length", "normal_velocity": "velocity",
    "tangential_velocity": "velocity",
}  # fmt: skip
"""Attribute of ``Units`` that holds the unit of each number of a contact record or its history."""


T = TypeVar("T", ContactRecord, ContactHistory)


def contact_in_si(record: T, units: Units, **changes: Any) -> T:
    """Return a contact record, or its history, converted from engine units to SI units.

    ``changes`` replace attributes of the record; they are in engine units too.
    """
    for name, unit in UNIT_OF.items():
        value = changes.get(name, getattr(record, name, None))
        if value is not None:
            size = getattr(units, unit)
            changes[name] = (
                tuple([each * size for each in value]) if isinstance(value, tuple) else value * size
            )
    history = getattr(record, "history", None)
    if history is not None:
        changes["history"] = contact_in_si(history, units)
    return dataclasses.replace(record, **changes)
