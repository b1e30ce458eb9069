"""Results of a run, turned from the scene's units to SI."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.integrate.time_scales import motion_scale
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.plan import Recording
from bristle_sim.scene.units import Units
from bristle_sim.stop_reason import ABSENCES, LARGEST_RETRACTION, StopReason
from bristle_sim.trajectory import ContactHistory, ContactRecord, Cost, Event, Trajectory, WireMotion


def trajectory_in_si(
    recording: Recording, scene: Scene, units: Units, parameters: dict[str, Any], *, with_estimate: bool, wire: int = 0
) -> Trajectory:
    """Return what a run has recorded of a wire, in SI units; a method without an error estimate leaves it out."""
    mechanism, states = scene.mechanism, recording.states
    if mechanism.wires > 1:
        own = slice(wire * mechanism.wire_links, (wire + 1) * mechanism.wire_links)
        mechanism = mechanism.wire(wire)
        states = [State(state.time, state.angles[own], state.rates[own]) for state in states]
    time, angles, rates = (np.array(column) for column in zip(*states, strict=True))
    hub = np.asarray(mechanism.hub_start + mechanism.hub_speed * time)
    kinetic, potential = _energies(mechanism, scene.effects, (hub, angles, rates))
    centre_line, centre_line_velocity = mechanism.centre_line(time, angles, rates)
    forces = [each[wire] for each in recording.forces]
    return Trajectory(
        time=time * units.time,
        hub_angle=hub,
        angles=angles,
        rates=rates / units.time,
        centre_line=centre_line * units.length,
        centre_line_velocity=centre_line_velocity * units.velocity,
        kinetic_energy=kinetic * units.energy,
        potential_energy=potential * units.energy,
        normal_force=np.array(forces) * units.force,
        hub_speed=parameters["tool"]["hub"]["speed"],
        events=tuple(Event(event.name, event.time * units.time) for event in _events(recording, scene, wire)),
        contacts=tuple(contact_in_si(contact, units) for contact in _contacts(recording, scene.mechanism, wire)),
        stop_reason=recording.stop_reason or StopReason.END,
        cost=Cost(
            *recording.cost,
            recording.error / motion_scale(scene, recording.states[0]) if with_estimate else None,
        ),
        parameters=parameters,
        stop_detail=recording.stop_detail,
        inner_samples=_inner_samples(recording, scene, units),
    )


def _events(recording: Recording, scene: Scene, wire: int) -> list[Event]:
    """Return a wire's events, and by name what never happened."""
    found = _with_largest_retraction(recording, scene, wire)
    names = {event.name for event in found}
    parts = {each.name for each in scene.effects.obstacles}
    absent = [name for name, event in ABSENCES.items() if name.split()[0] in parts and event not in names]
    return found + [Event(name, recording.states[-1].time) for name in absent]


def _with_largest_retraction(recording: Recording, scene: Scene, wire: int) -> list[Event]:
    """Return a wire's events with its largest retraction up to the strike, or of the run, as the only one of its name.

    A retraction that is larger at either end of that time than at every turn in between is no event. One that the run
    stops at stays.
    """
    found = [event for event, wires in recording.events if wire in wires]
    turns = [event for event in found if event.name == LARGEST_RETRACTION]
    strike = min((event.time for event in found if event.name == "strike"), default=math.inf)
    mechanism, link = scene.mechanism, wire * scene.mechanism.wire_links
    lags = [
        (mechanism.root_angle(link, each.time) - each.angles[link], each.time)
        for each in recording.states
        if each.time <= strike
    ]
    at_turns = [lag for lag in lags if any(lag[1] == event.time for event in turns)]
    largest, time = max(at_turns, default=(0.0, math.nan))
    if largest <= 0.0 or largest < max(lags[0][0], lags[-1][0]):
        time = math.nan
    if recording.stop_reason is StopReason.EVENT and turns and turns[-1].time == recording.states[-1].time:
        time = turns[-1].time
    return [event for event in found if event.name != LARGEST_RETRACTION or event.time == time]


def _contacts(recording: Recording, mechanism: Mechanism, wire: int) -> Iterator[ContactRecord]:
    """Yield a wire's contact records, with its own angles and rates, its link in contact and its partner."""
    size, own = mechanism.wire_links, slice(wire * mechanism.wire_links, (wire + 1) * mechanism.wire_links)
    for contact, links in sorted(recording.contacts, key=lambda each: each[0].time):
        wires = [link // size for link in links]
        if mechanism.lone:
            yield contact
        elif wire in wires:
            place = wires.index(wire)
            yield dataclasses.replace(
                contact,
                angles=contact.angles[own],
                rates_before=contact.rates_before[own],
                rates_after=contact.rates_after[own],
                link=links[place] % size + 1 if size > 1 else None,
                neighbour=wires[1 - place] + 1 if len(wires) > 1 else None,
            )


def _energies(mechanism: Mechanism, effects: Effects, motion: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    """Return kinetic energy, and potential energy of belt, hinges and gravity, in engine units, each of shape (n,).

    ``motion`` is the states' hub angle, angles and rates as arrays.
    """
    hub, angles, rates = motion
    kinetic, potential = np.zeros(len(hub)), 0.5 * (effects.stiffness or 0.0) * (angles[:, 0] - hub) ** 2
    place = -1j * mechanism.hub_radius * np.exp(1j * hub)
    velocity = 1j * mechanism.hub_speed * place
    for number, link in enumerate(mechanism.links):
        turn, rate = np.exp(1j * angles[:, number]), rates[:, number]
        arm = complex(*link.centre) * turn
        kinetic += 0.5 * link.mass * np.abs(velocity + 1j * rate * arm) ** 2 + 0.5 * link.inertia * rate**2
        potential += effects.gravity * link.mass * (place + arm).imag
        tip = complex(*link.tip) * turn
        place, velocity = place + tip, velocity + 1j * rate * tip
    for number, (stiffness, _) in enumerate(effects.hinges[: len(mechanism.links) - 1]):
        potential += 0.5 * stiffness * (angles[:, number + 1] - angles[:, number]) ** 2
    return kinetic, potential


def _inner_samples(recording: Recording, scene: Scene, units: Units) -> WireMotion | None:
    if not recording.inner:
        return None
    count, links = len(recording.inner), len(recording.states[0].angles)
    time = np.array([state.time for state in recording.inner])
    angles = np.array([state.angles for state in recording.inner]).reshape(count, links)
    rates = np.array([state.rates for state in recording.inner]).reshape(count, links)
    line, velocity = scene.mechanism.centre_line(time, angles, rates)
    return WireMotion(time * units.time, angles, rates / units.time, line * units.length, velocity * units.velocity)


def contact_in_si(contact: ContactRecord, units: Units) -> ContactRecord:
    """Return a contact record turned from engine units to SI."""

    def scaled(pair: tuple[float, float] | None, unit: float) -> Any:
        return None if pair is None else (pair[0] * unit, pair[1] * unit)

    return dataclasses.replace(
        contact,
        time=contact.time * units.time,
        duration=contact.duration * units.time,
        impulse=scaled(contact.impulse, units.impulse),
        compressive_impulse=scaled(contact.compressive_impulse, units.impulse),
        compressive_work=scaled(contact.compressive_work, units.energy),
        restitutive_work=scaled(contact.restitutive_work, units.energy),
        velocity_before=scaled(contact.velocity_before, units.velocity),
        velocity_after=scaled(contact.velocity_after, units.velocity),
        rates_before=tuple(rate / units.time for rate in contact.rates_before),
        rates_after=tuple(rate / units.time for rate in contact.rates_after),
        history=None if contact.history is None else _history_in_si(contact.history, units),
    )


def _history_in_si(history: ContactHistory, units: Units) -> ContactHistory:
    return ContactHistory(
        time=history.time * units.time,
        normal_force=history.normal_force * units.force,
        tangential_force=history.tangential_force * units.force,
        penetration=history.penetration * units.length,
        normal_velocity=history.normal_velocity * units.velocity,
        tangential_velocity=history.tangential_velocity * units.velocity,
    )
