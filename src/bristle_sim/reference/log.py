"""What a run records: samples, events and contacts of each wire."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from bristle_sim.reference.contacts import Point
from bristle_sim.reference.mechanics import Chain
from bristle_sim.reference.system import Instant, State, Sustained
from bristle_sim.stop_reason import StopReason
from bristle_sim.theory.impact import Impact
from bristle_sim.trajectory import ContactRecord, Cost, Event, Trajectory

STRIKE, PEAK, LARGEST_RETRACTION = "strike", "highest relative speed", "largest retraction"

Sample = tuple[State, tuple[float, float]]  # a state, and the sums of normal and of tangential force, N


class Finished(Exception):
    """Ends a run; the arguments are the reason and the state."""


class Record:
    """The record of one wire; ``first`` is the number of its first link."""

    def __init__(self, chain: Chain, first: int) -> None:
        self.chain = chain
        self.first = first
        self.events: list[Event] = []
        self.contacts: list[ContactRecord] = []
        self.samples: list[Sample] = []
        self._turned: list[State] = []

    def own(self, state: State) -> State:
        """Return the state of the wire's own links."""
        links = slice(self.first, self.first + self.chain.links)
        return State(state.time, state.angles[links], state.rates[links])

    def differs(self, state: State, forces: tuple[float, float]) -> bool:
        """Whether a state or its forces differ from those stored last."""
        if not self.samples:
            return True
        last, pushed = self.samples[-1]
        return (last.time, pushed) != (state.time, forces) or bool((last.rates != state.rates).any())

    def event(self, name: str, time: float) -> None:
        """Note an event."""
        self.events.append(Event(name, time))

    def seen(self, name: str) -> bool:
        """Whether an event of that name has been noted."""
        return any(each.name == name for each in self.events)

    def touch(self, point: Point, state: State) -> None:
        """Note a touch; the first one of the workpart is the strike."""
        strike = point.obstacle == "workpart" and not self.seen(STRIKE)
        self.event(STRIKE if strike else f"{point.obstacle} touch", state.time)

    def release(self, point: Point, state: State) -> None:
        """Note the end of a contact."""
        self.event(f"{point.obstacle} release", state.time)

    def turned(self, state: State) -> None:
        """Note a state at which retraction may be largest: the relative rate rises through zero."""
        self._turned.append(self.own(state))

    def note_largest_retraction(self) -> None:
        """Note where retraction is largest before the strike, if that is at an instant of no relative rate."""
        strike = min((each.time for each in self.events if each.name == STRIKE), default=math.inf)

        def relative(state: State) -> float:
            return float(state.angles[0] - self.chain.hub_angle(state.time))

        reached = [state for state, _ in self.samples if state.time <= strike]
        lowest = min(relative(reached[0]), relative(reached[-1]), 0.0)
        candidates = [(relative(each), each.time) for each in self._turned if each.time <= strike]
        angle, time = min(candidates, default=(0.0, 0.0))
        if angle < 0.0 and angle <= lowest:
            self.event(LARGEST_RETRACTION, time)

    def impact(self, point: Point, state: State, after: State, velocity: tuple[float, float], hit: Impact) -> None:
        """Record an impact between the states before and after it."""
        first, last = self.own(state), self.own(after)
        if first.rates[0] < self.chain.speed < last.rates[0]:
            self.turned(state)
        given = {
            "impulse": (hit.impulse_normal, hit.impulse_tangential),
            "compressive_impulse": (hit.compressive_impulse_normal, hit.compressive_impulse_tangential),
            "compressive_work": hit.compressive_work,
            "restitutive_work": hit.restitutive_work,
            "velocity_before": velocity,
            "velocity_after": (hit.velocity_normal, hit.velocity_tangential),
        }
        self._contact(point, first, last, given, law="energetic", outcome=hit.outcome_name, phases=hit.phases)

    def lasting(self, each: Sustained, last: State, velocity: tuple[float, float], outcome: str) -> None:
        """Record a sustained contact that ends in a state with a velocity, (normal, tangential) in m/s."""
        if last.time <= each.since.time:
            return
        compression = each.sums if each.compression is None else each.compression
        given = {
            "impulse": each.sums[:2],
            "compressive_impulse": compression[:2],
            "compressive_work": compression[2:],
            "restitutive_work": (each.sums - compression)[2:],
            "velocity_before": each.velocity_before,
            "velocity_after": velocity,
        }
        law = "sustained" if each.spring is None else "compliant"
        self._contact(each.point, self.own(each.since), self.own(last), given, law=law, outcome=outcome)

    def _contact(self, point: Point, first: State, last: State, given: dict[str, Any], **words: Any) -> None:
        """Record a contact between two states with its (normal, tangential) pairs."""
        pairs: dict[str, Any] = {name: (float(normal), float(along)) for name, (normal, along) in given.items()}
        self.contacts.append(
            ContactRecord(
                obstacle=point.obstacle,
                time=first.time,
                duration=last.time - first.time,
                angles=tuple(first.angles.tolist()),
                rates_before=tuple(first.rates.tolist()),
                rates_after=tuple(last.rates.tolist()),
                **pairs,
                **words,
            )
        )

    def trajectory(self, stop_reason: StopReason, cost: Cost, parameters: dict[str, Any]) -> Trajectory:
        """Return the finished result."""
        chain = self.chain
        time, angles, rates = (np.array(column) for column in zip(*(state for state, _ in self.samples), strict=True))
        corners, velocities = chain.centre_line(time, angles, rates)
        kinetic, potential = chain.energies(time, angles, rates)
        return Trajectory(
            time=time,
            hub_angle=np.asarray(chain.hub_angle(time)),
            angles=angles,
            rates=rates,
            centre_line=np.stack([corners.real, corners.imag], axis=-1),
            centre_line_velocity=np.stack([velocities.real, velocities.imag], axis=-1),
            kinetic_energy=kinetic,
            potential_energy=potential,
            normal_force=np.array([max(forces[0], 0.0) for _, forces in self.samples]),
            hub_speed=chain.speed,
            events=tuple(sorted(self.events, key=lambda each: each.time)),
            contacts=tuple(sorted(self.contacts, key=lambda each: each.time)),
            stop_reason=stop_reason,
            cost=cost,
            parameters=parameters,
        )


class Log:
    """The records of all wires of a run; ``interval`` is the time between samples, s.

    ``pairs`` are the wires of which each contact of two wires consists, by its number.
    """

    def __init__(
        self, wires: Sequence[Chain], interval: float, stop_after: str | None, pairs: Sequence[tuple[int, int]] = ()
    ) -> None:
        self.records = [Record(each, number * each.links) for number, each in enumerate(wires)]
        self.interval = interval
        self.stop_after = stop_after
        self.pairs = pairs
        self.impacts: list[float] = []
        self._marks: list[float] = []

    def of(self, point: Point) -> Sequence[Record]:
        """Return the records of the wires that touch in a contact."""
        if len(self.records) == 1:
            return self.records
        wires = self.pairs[point.piece] if point.obstacle == "wire" else (point.piece,)
        return [self.records[each] for each in wires]

    def sample(self, instant: Instant) -> None:
        """Store a state with the contacts' forces, for all wires or for none: unless it was stored last."""
        forces = np.zeros((len(self.records), 2))
        if sustained := instant.system.sustained:
            pushes = np.column_stack([instant.balance.normal, instant.balance.tangential])
            for each, push in zip(sustained, pushes, strict=True):
                for record in self.of(each.point):
                    forces[self.records.index(record)] += push
        pairs = zip(self.records, forces.tolist(), strict=True)
        new = [(each.own(instant.state), (normal, along)) for each, (normal, along) in pairs]
        if any(record.differs(*one) for record, one in zip(self.records, new, strict=True)):
            for record, one in zip(self.records, new, strict=True):
                record.samples.append(one)

    def times(self, start: float, end: float) -> list[float]:
        """Return the multiples of the sampling interval and the marked instants after a start and before an end."""
        count = np.arange(math.floor(start / self.interval), math.ceil(end / self.interval) + 1, dtype=float)
        return [each for each in np.union1d(count * self.interval, self._marks).tolist() if start < each < end]

    def mark(self, time: float) -> None:
        """Request a sample at an instant of the motion that is stored next."""
        self._marks.append(time)

    def event(self, name: str, time: float) -> None:
        """Note an event that concerns every wire."""
        for record in self.records:
            record.event(name, time)

    def seen(self, name: str) -> bool:
        """Whether every wire has had an event of that name."""
        return all(record.seen(name) for record in self.records)

    def check_stop(self, state: State) -> None:
        """End the run if the event that it was to stop after has happened. Raises Finished if it has."""
        if self.stop_after is not None and self.seen(self.stop_after):
            raise Finished(StopReason.EVENT, state)
