"""The record of a run: samples of all wires, and the events and contacts of each wire."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.reference.contacts import Point
from bristle_sim.reference.forces import State, Sustained
from bristle_sim.reference.mechanics import Chain
from bristle_sim.settings import ABSENCES, LARGEST_RETRACTION, StopReason
from bristle_sim.trajectory import ContactRecord, Event, Trajectory

STRIKE = "strike"
EQUAL = 1e-8  # difference below which two retractions are equal, rad


class Finished(Exception):
    """Raised to end a run. Its two arguments are the stop reason and the last state."""


class Record:
    """The events and contacts of one wire.

    ``chain`` holds the wire's links, ``number`` is the index of the wire in its row.
    """

    def __init__(self, chain: Chain, number: int) -> None:
        self.chain = chain
        self.number = number
        self.links = slice(number * chain.links, (number + 1) * chain.links)
        self.events: list[Event] = []
        self.contacts: list[ContactRecord] = []

    def own(self, state: State) -> State:
        """Return the state of this wire's links, from the state of the links of all wires."""
        return State(state.time, state.angles[self.links], state.rates[self.links])

    def relative(self, state: State) -> Any:
        """Return the angle of the wire's first link relative to the radial direction, rad."""
        return state.angles[..., self.links.start] - self.chain.hub_angles(state.time)[..., 0]

    def event(self, name: str, time: float) -> None:
        """Record that an event of this wire occurs at a time in s."""
        self.events.append(Event(name, time))

    def times(self, name: str) -> list[float]:
        """Return the times at which events of a given name occurred on this wire, s."""
        return [each.time for each in self.events if each.name == name]

    def contact(self, each: Sustained, until: State, velocity: Array, **known: Any) -> None:
        """Record a contact or an impact of this wire.

        Args:
            each: the contact. An impact is given as a contact with the impact's impulses and works.
            until: state after the contact.
            velocity: (normal, tangential) contact velocity in this state, m/s.
            known: further attributes of the ``ContactRecord``.
        """
        compression = each.sums if each.compression is None else each.compression
        pairs = {
            "impulse": each.sums[:2],
            "compressive_impulse": compression[:2],
            "compressive_work": compression[2:],
            "restitutive_work": (each.sums - compression)[2:],
            "velocity_before": each.velocity_before,
            "velocity_after": velocity,
            "angles": self.own(each.since).angles,
            "rates_before": self.own(each.since).rates,
            "rates_after": self.own(until).rates,
        }
        time = each.since.time
        numbers: dict[str, Any] = {name: tuple(pair.tolist()) for name, pair in pairs.items()}
        self.contacts.append(
            ContactRecord(
                obstacle=each.point.obstacle,
                time=time,
                duration=until.time - time,
                **numbers,
                **known,
            )
        )

    def trajectory(
        self, samples: Sequence[tuple[State, Array]], obstacles: Iterable[str], **run: Any
    ) -> Trajectory:
        """Return the trajectory of this wire.

        Args:
            samples: states, each with the contact forces on every wire, as in ``Log``.
            obstacles: names of the obstacles. If the wire never touches one of them, this is
                recorded as an event.
            run: further attributes of ``Trajectory``.
        """
        states = [state for state, _ in samples]
        for name, absence in ABSENCES.items():
            if name.split()[0] in obstacles and not self.times(absence):
                self.event(name, states[-1].time)
        # Of the extremes of the retraction up to the strike only the largest one is kept, and of equal
        # ones the first; and one that has ended the run.
        strike = min(self.times(STRIKE), default=math.inf)
        reached = [state for state in states if state.time <= strike]
        turns = self.times(LARGEST_RETRACTION)
        turned = [state for state in reached if state.time in turns]
        sizes = {state.time: self.relative(state) for state in (reached[0], *turned, reached[-1])}
        lowest = min(sizes.values())
        equal = (time for time, size in sizes.items() if size <= lowest + EQUAL)
        largest = next(equal) if lowest < 0.0 else math.nan
        known = (largest, states[-1].time if run["stop_reason"] is StopReason.EVENT else largest)
        kept = [e for e in self.events if e.name != LARGEST_RETRACTION or e.time in known]
        time, angles, rates = map(np.array, zip(*map(self.own, states), strict=True))
        corners, velocities = self.chain.centre_line(time, angles, rates)
        kinetic, potential = self.chain.energies(time, angles, rates)
        forces = np.array([forces[self.number, 0] for _, forces in samples])
        return Trajectory(
            time=time,
            hub_angle=self.chain.hub_angles(time)[:, 0],
            angles=angles,
            rates=rates,
            centre_line=np.stack([corners.real, corners.imag], axis=-1),
            centre_line_velocity=np.stack([velocities.real, velocities.imag], axis=-1),
            kinetic_energy=kinetic,
            potential_energy=potential,
            normal_force=np.maximum(forces, 0.0),
            hub_speed=self.chain.speed,
            events=tuple(sorted(kept, key=lambda each: each.time)),
            contacts=tuple(sorted(self.contacts, key=lambda each: each.time)),
            **run,
        )


class Log:
    """The record of a run: samples of all wires, and the events and contacts of each wire.

    A sample is a state together with the contact forces on each wire: an array of the sums of the
    normal and of the tangential forces (N), shape (wires, 2).

    Args:
        wires: the links of each wire, as a separate chain.
        interval: time between samples, s.
        stop_after: name of the event that ends the run, or None.
        pairs: indices of the two straight pieces of each pair of ``WirePairs``.

    ``impacts`` holds the state before each impact of any wire, and the point of the impact.
    """

    def __init__(
        self,
        wires: Sequence[Chain],
        interval: float,
        stop_after: str | None,
        pairs: Sequence[Sequence[int]] = (),
    ) -> None:
        self.records = [Record(each, number) for number, each in enumerate(wires)]
        self.interval = interval
        self.stop_after = stop_after
        self.pairs = pairs
        self.samples: list[tuple[State, Array]] = []
        self.impacts: list[tuple[State, Point]] = []

    def pieces(self, point: Point) -> Sequence[int]:
        """Return the indices of the one or two straight pieces that take part in a contact."""
        return self.pairs[point.piece] if point.obstacle == "wire" else [point.piece]

    def of(self, point: Point) -> Sequence[Record]:
        """Return the records of the one or two wires that take part in a contact."""
        size = len(self.records[0].chain.pieces.links)
        return [self.records[piece // size] for piece in self.pieces(point)]

    def contact(self, each: Sustained, until: State, velocity: Array, **known: Any) -> None:
        """Record a contact or an impact of one or two wires; arguments as for ``Record.contact``."""
        records = self.of(each.point)
        links = self.records[0].chain.pieces.links
        for own, other, piece in zip(
            records, reversed(records), self.pieces(each.point), strict=True
        ):
            own.contact(
                each,
                until,
                velocity,
                link=int(links[piece % len(links)]) + 1 if own.chain.links > 1 else None,
                neighbour=None if other is own else other.number + 1,
                **known,
            )

    def sample(self, state: State, pushes: Iterable[tuple[Point, Array]]) -> None:
        """Store a state and the forces at its contacts as a sample.

        Nothing is stored if the sample equals the preceding one. ``pushes`` pairs the point of each
        contact with its (normal, tangential) force, N.
        """
        forces = np.zeros((len(self.records), 2))
        for point, push in pushes:
            for own in self.of(point):
                forces[own.number] += push
        if self.samples:
            last, pushed = self.samples[-1]
            moved = last.time != state.time or (last.rates != state.rates).any()
            if not moved and (pushed == forces).all():
                return
        self.samples.append((state, forces))

    def times(self, start: float, end: float) -> list[float]:
        """Return the sample times between ``start`` and ``end``, both excluded, s.

        They are multiples of the sampling interval.
        """
        ends = math.floor(start / self.interval), math.ceil(end / self.interval) + 1
        found = np.arange(*ends, dtype=float) * self.interval
        times: list[float] = found[(found > start) & (found < end)].tolist()
        return times

    def touched(self, point: Point, time: float) -> None:
        """Record a touch at a point of a wire, at a time in s.

        A wire's first touch of the workpart is recorded as its strike.
        """
        for own in self.of(point):
            strike = point.obstacle == "workpart" and not own.times(STRIKE)
            own.event(STRIKE if strike else f"{point.obstacle} touch", time)

    def released(self, point: Point, time: float) -> None:
        """Record the release of a contact at a time in s."""
        for own in self.of(point):
            own.event(f"{point.obstacle} release", time)

    def forget_impacts(self, since: float, first: Point) -> None:
        """Remove the records of all impacts from a time on (s), except the first, which is a jam.

        ``first`` is the point of the first impact.
        """
        for own in self.records:
            later = [each for each in own.contacts if each.time >= since]
            kept = [replace(later[0], outcome="jam")] if own in self.of(first) else []
            own.contacts = [each for each in own.contacts if each.time < since] + kept

    def jam(self, state: State) -> Finished:
        """Record for every wire that the wires jam, and return the exception that ends the run.

        In a jam friction or geometry locks the wires, so that the equations have no solution.
        """
        for own in self.records:
            own.event("jam", state.time)
        return Finished(StopReason.JAM, state)
