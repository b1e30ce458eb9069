"""Results of a run, converted from the scene's units to SI."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from operator import attrgetter
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.build import Effects, Scene, motion_scale
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.system import Recording, System
from bristle_sim.scene.tool import Units
from bristle_sim.settings import ABSENCES, LARGEST_RETRACTION, StopReason
from bristle_sim.trajectory import ContactRecord, Cost, Event, Trajectory, WireMotion


def trajectories_in_si(
    system: System,
    units: Units,
    parameters: dict[str, Any],
    cost: tuple[float, float, int],
) -> tuple[Trajectory, ...]:
    """Return a trajectory of each wire in SI units, from a system that has run.

    ``cost`` is wall time, s, processor time, s, and number of engine steps.
    """
    recording = system.recording
    scene = system.scene
    estimate = recording.error / motion_scale(scene, recording.states[0])
    lost = recording.lost
    errors = (estimate, None if lost is None else lost * units.time)
    found = []
    size = scene.mechanism.wire_links
    forces = np.array(recording.forces) * units.force
    for number in range(scene.mechanism.wires):
        mechanism = scene.mechanism.wire(number)
        own = slice(number * size, (number + 1) * size)
        motion = columns(recording.states, own)
        hub = mechanism.hub_start + mechanism.hub_speed * motion[0]
        kinetic, potential = energies(mechanism, scene.effects, motion)
        samples = _in_space(mechanism, motion, units)
        found.append(
            Trajectory(
                **{each.name: getattr(samples, each.name) for each in dataclasses.fields(samples)},
                hub_angle=hub,
                kinetic_energy=kinetic * units.energy,
                potential_energy=potential * units.energy,
                normal_force=forces[:, number],
                hub_speed=parameters["tool"]["hub"]["speed"],
                events=_events(recording, scene, number, (motion[0], hub - motion[1][:, 0]), units),
                contacts=contacts_in_si(recording.contacts, scene.mechanism, number, units),
                stop_reason=recording.stop_reason or StopReason.END,
                cost=Cost(*cost, *errors),
                parameters=parameters,
                stop_detail=recording.stop_detail,
            )
        )
    return tuple(found)


def columns(states: Sequence[State], own: slice = slice(None)) -> tuple[Array, Array, Array]:
    """Return times, and one wire's angles and rates, of shapes (n,), (n, links) and (n, links)."""
    time, angles, rates = (np.array(column) for column in zip(*states, strict=True))
    return time, angles[:, own], rates[:, own]


def _in_space(mechanism: Mechanism, motion: tuple[Array, Array, Array], units: Units) -> WireMotion:
    """Return a wire's motion in SI, with its centre line."""
    line, velocity = mechanism.centre_line(*motion)
    time, angles, rates = motion
    return WireMotion(
        time * units.time,
        angles,
        rates / units.time,
        line * units.length,
        velocity * units.velocity,
    )


def _events(
    recording: Recording, scene: Scene, wire: int, lags: tuple[Array, Array], units: Units
) -> tuple[Event, ...]:
    """Return a wire's events, with at most one largest retraction.

    The largest retraction is the largest one at which the wire turns, up to the strike or in the
    whole run. There is none if the retraction at either end of that time is larger. A largest
    retraction at which the run stops is kept in any case. Events that never happened are named at
    the end. ``lags`` are times and retractions of the samples.
    """
    found = []
    names = set()
    turns = []
    strike = math.inf
    for event, wires in recording.events:
        if wire in wires:
            found.append(event)
            names.add(event.name)
            turns += [event.time] if event.name == LARGEST_RETRACTION else []
            strike = min(strike, event.time) if event.name == "strike" else strike
    (times, lag), end = lags, float(lags[0][-1])
    last = int(np.searchsorted(times, strike, side="right")) - 1
    at_turns = [
        (float(lag[np.searchsorted(times, turn)]), turn) for turn in turns if turn <= strike
    ]
    largest, time = max(at_turns, default=(0.0, math.nan))
    if largest <= 0.0 or largest < max(lag[0], lag[last]):
        time = math.nan
    if recording.stop_reason is StopReason.EVENT and turns and turns[-1] == end:
        time = end
    parts = {each.name for each in scene.effects.pairs}
    found = [each for each in found if each.name != LARGEST_RETRACTION or each.time == time]
    for name, event_name in ABSENCES.items():
        if name.split()[0] in parts and event_name not in names:
            found.append(Event(name, end))
    return tuple([Event(each.name, each.time * units.time) for each in found])


def contacts_in_si(
    records: Sequence[tuple[ContactRecord, tuple[int, ...]]],
    mechanism: Mechanism,
    wire: int,
    units: Units,
) -> tuple[ContactRecord, ...]:
    """Return a wire's contact records in SI units, with the wire's own angles and rates.

    Each record names the link in contact and the neighbouring bristle that it touches, if any.
    """
    found = []
    size = mechanism.wire_links
    own = slice(wire * size, (wire + 1) * size)
    for contact, links in records:
        wires = [link // size for link in links]
        if wire in wires:
            place = wires.index(wire)
            link = links[place] % size + 1
            neighbour = wires[place - 1] + 1
            alone = dataclasses.replace(
                contact,
                angles=contact.angles[own],
                rates_before=contact.rates_before[own],
                rates_after=contact.rates_after[own],
                link=link if size > 1 else None,
                neighbour=neighbour if len(wires) > 1 else None,
            )
            found.append(contact_in_si(alone, units))
    return tuple(sorted(found, key=attrgetter("time")))


def energies(
    mechanism: Mechanism, effects: Effects, motion: tuple[Array, Array, Array]
) -> tuple[Array, Array]:
    """Return the kinetic energy, and the potential energy of belt, hinges and gravity, at each
    sample; engine units.
    """
    time, angles, _ = motion
    hub = mechanism.hub_start + mechanism.hub_speed * time
    kinetic = np.zeros(len(time))
    potential = 0.5 * (effects.stiffness or 0.0) * (angles[:, 0] - hub) ** 2
    for link, turn, rate, joint, velocity in mechanism.walk(*motion):
        arm = complex(*link.centre) * turn
        kinetic += (
            0.5 * link.mass * np.abs(velocity + 1j * rate * arm) ** 2 + 0.5 * link.inertia * rate**2
        )
        potential += effects.gravity * link.mass * (joint + arm).imag
    for number, (stiffness, _) in enumerate(effects.hinges[: len(mechanism.links) - 1]):
        potential += 0.5 * stiffness * (angles[:, number + 1] - angles[:, number]) ** 2
    return kinetic, potential


RECORD_UNITS = {
    "time": ("time", "duration"),
    "impulse": ("impulse", "compressive_impulse"),
    "energy": ("compressive_work", "restitutive_work"),
    "velocity": ("velocity_before", "velocity_after"),
    "rate": ("rates_before", "rates_after"),
}
HISTORY_UNITS = {
    "time": ("time",),
    "force": ("normal_force", "tangential_force"),
    "length": ("penetration",),
    "velocity": ("normal_velocity", "tangential_velocity"),
}


def contact_in_si(contact: ContactRecord, units: Units) -> ContactRecord:
    """Return a contact record converted from engine units to SI."""
    history = contact.history and dataclasses.replace(
        contact.history, **_in_si(contact.history, HISTORY_UNITS, units)
    )
    return dataclasses.replace(contact, history=history, **_in_si(contact, RECORD_UNITS, units))


def _in_si(record: object, table: Mapping[str, tuple[str, ...]], units: Units) -> dict[str, Any]:
    """Return the numbers, tuples and arrays of a record in SI by name."""
    found: dict[str, Any] = {}
    for unit, names in table.items():
        size = getattr(units, unit)
        for name in names:
            value = getattr(record, name)
            if value is not None:
                found[name] = (
                    tuple([each * size for each in value])
                    if isinstance(value, tuple)
                    else value * size
                )
    return found
