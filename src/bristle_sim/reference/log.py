"""The record of a run: samples of all wires, and the events and contacts of each wire."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.reference.contacts import Point
from bristle_sim.reference.mechanics import Chain
from bristle_sim.reference.system import Instant, State, Sustained
from bristle_sim.settings import StopReason
from bristle_sim.theory.impact import Impact
from bristle_sim.trajectory import ContactRecord, Event, Trajectory

STRIKE = "strike"
PEAK = "highest relative speed"
LARGEST_RETRACTION = "largest retraction"
TOUCHES = (STRIKE, "workpart touch", "bar touch", "wire touch")


class Finished(Exception):
    """Raised to end a run; its arguments are the stop reason and the last state."""


class Record:
    """The events and contacts of one wire.

    ``first`` is the index of the wire's first link among the links of all wires.
    """

    def __init__(self, chain: Chain, first: int) -> None:
        self.chain = chain
        self.links = slice(first, first + chain.links)
        self.events: list[Event] = []
        self.contacts: list[ContactRecord] = []
        # States at which the relative rate rises through zero; the retraction may be largest there.
        self.turned: list[State] = []

    def own(self, state: State) -> State:
        """Return the part of a state that belongs to the wire's own links."""
        return State(state.time, state.angles[self.links], state.rates[self.links])

    def relative(self, state: State) -> float:
        """Return the angle of the wire's first link relative to the radial direction, rad."""
        return float(state.angles[self.links][0] - self.chain.hub_angle(state.time))

    def event(self, name: str, time: float) -> None:
        """Record an event of the wire at a time in s."""
        self.events.append(Event(name, time))

    def seen(self, name: str) -> bool:
        """Return whether the wire has had an event of this name."""
        return any(each.name == name for each in self.events)

    def note_largest_retraction(self, states: Sequence[State]) -> None:
        """Record the event of the largest retraction before the strike.

        It is an event only if the relative rate is zero there. ``states`` are the samples of the
        run.
        """
        strike = next((each.time for each in self.events if each.name == STRIKE), math.inf)
        reached = [state for state in states if state.time <= strike]
        turned = [each for each in self.turned if each.time <= strike]
        lowest = min([*turned, reached[0], reached[-1]], key=self.relative)
        if self.relative(lowest) < 0.0 and any(lowest is each for each in turned):
            self.event(LARGEST_RETRACTION, lowest.time)

    def impact(
        self,
        point: Point,
        state: State,
        after: State,
        velocity: tuple[float, float],
        hit: Impact,
        rounding: float,
    ) -> None:
        """Record an impact of the wire.

        Args:
            point: location of the contact.
            state: state before the impact.
            after: state after the impact.
            velocity: (normal, tangential) contact velocity before the impact, m/s.
            hit: the impact.
            rounding: rounding error of a rate, rad/s.
        """
        before = self.own(state).rates[0]
        speed = self.chain.speed
        if before < speed - rounding and self.own(after).rates[0] > speed + rounding:
            self.turned.append(state)
        self._contact(
            point,
            state,
            after,
            "energetic",
            hit.outcome_name,
            phases=hit.phases,
            impulse=(hit.impulse_normal, hit.impulse_tangential),
            compressive_impulse=(
                hit.compressive_impulse_normal,
                hit.compressive_impulse_tangential,
            ),
            compressive_work=hit.compressive_work,
            restitutive_work=hit.restitutive_work,
            velocity_before=velocity,
            velocity_after=(hit.velocity_normal, hit.velocity_tangential),
        )

    def lasting(
        self, each: Sustained, last: State, velocity: tuple[float, float], outcome: str
    ) -> None:
        """Record a sustained contact that ends.

        ``last`` is the state at its end, ``velocity`` the (normal, tangential) contact velocity
        there, m/s.
        """
        if last.time <= each.since.time:
            return
        compression = each.sums if each.compression is None else each.compression
        self._contact(
            each.point,
            each.since,
            last,
            "sustained" if each.spring is None else "compliant",
            outcome,
            impulse=each.sums[:2],
            compressive_impulse=compression[:2],
            compressive_work=compression[2:],
            restitutive_work=(each.sums - compression)[2:],
            velocity_before=each.velocity_before,
            velocity_after=velocity,
        )

    def _contact(
        self,
        point: Point,
        since: State,
        until: State,
        law: str,
        outcome: str,
        phases: tuple[str, ...] = (),
        **pairs: Any,
    ) -> None:
        """Record a contact that lasts from one state to another.

        ``pairs`` are the (normal, tangential) entries of the record by their names.
        """
        first = self.own(since)
        floats: dict[str, Any] = {
            name: (float(normal), float(along)) for name, (normal, along) in pairs.items()
        }
        self.contacts.append(
            ContactRecord(
                obstacle=point.obstacle,
                law=law,
                outcome=outcome,
                phases=phases,
                time=first.time,
                duration=until.time - first.time,
                angles=tuple(first.angles.tolist()),
                rates_before=tuple(first.rates.tolist()),
                rates_after=tuple(self.own(until).rates.tolist()),
                **floats,
            )
        )

    def trajectory(
        self, samples: Sequence[State], normal_force: Array, reason: StopReason, **run: Any
    ) -> Trajectory:
        """Return the trajectory of the wire, with its state at each sample.

        ``normal_force`` holds the sum of the normal contact forces on the wire at each sample, N.
        ``run`` holds further entries of the trajectory.
        """
        chain = self.chain
        time, angles, rates = (
            np.array(column) for column in zip(*map(self.own, samples), strict=True)
        )
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
            normal_force=np.maximum(normal_force, 0.0),
            hub_speed=chain.speed,
            events=tuple(sorted(self.events, key=lambda each: each.time)),
            contacts=tuple(sorted(self.contacts, key=lambda each: each.time)),
            stop_reason=reason,
            **run,
        )


class Log:
    """The record of a run: samples of all wires, and the events and contacts of each wire.

    ``interval`` is the time between samples, s. ``pairs`` holds the indices of the two wires of
    each pair that can touch. A sample is a state with the sum of the normal and the sum of the
    tangential contact forces on each wire, N.
    """

    def __init__(
        self,
        wires: Sequence[Chain],
        interval: float,
        stop_after: str | None,
        pairs: Sequence[tuple[int, int]] = (),
    ) -> None:
        self.records = [Record(each, number * each.links) for number, each in enumerate(wires)]
        self.interval = interval
        self.stop_after = stop_after
        self.pairs = pairs
        self.samples: list[tuple[State, Array]] = []
        self.impacts: list[float] = []
        self.marks: list[float] = []  # times of additional samples, s

    def of(self, point: Point) -> Sequence[Record]:
        """Return the records of the one or two wires in a contact."""
        if point.obstacle == "wire":
            return [self.records[each] for each in self.pairs[point.piece]]
        return self.records if len(self.records) == 1 else [self.records[point.piece]]

    def sample(self, instant: Instant) -> None:
        """Store a sample, the state with the contact forces, unless it equals the last sample."""
        forces = np.zeros((len(self.records), 2))
        state = instant.state
        for number, each in enumerate(instant.system.sustained):
            for record in self.of(each.point):
                push = instant.balance.normal[number], instant.balance.tangential[number]
                forces[self.records.index(record)] += push
        if self.samples:
            last, pushed = self.samples[-1]
            if (
                last.time == state.time
                and (pushed == forces).all()
                and (last.rates == state.rates).all()
            ):
                return
        self.samples.append((state, forces))

    def times(self, start: float, end: float) -> list[float]:
        """Return the times of samples between a start and an end, both excluded, s.

        They are the multiples of the sampling interval and the times in ``marks``.
        """
        count = np.arange(
            math.floor(start / self.interval), math.ceil(end / self.interval) + 1, dtype=float
        )
        return [
            each
            for each in np.union1d(count * self.interval, self.marks).tolist()
            if start < each < end
        ]

    def touched(self, point: Point, time: float) -> None:
        """Record a touch; a wire's first touch of the workpart is its strike."""
        for own in self.of(point):
            strike = point.obstacle == "workpart" and not own.seen(STRIKE)
            own.event(STRIKE if strike else f"{point.obstacle} touch", time)

    def released(self, point: Point, time: float) -> None:
        """Record the release of a contact at a time in s."""
        for own in self.of(point):
            own.event(f"{point.obstacle} release", time)

    def check_stop(self, state: State, sustained: Sequence[Sustained]) -> None:
        """Raise Finished if every wire has had the event that ends the run.

        If this event is a touch, compliant contacts must have ended too.
        """
        last = self.stop_after
        if last is None or not all(record.seen(last) for record in self.records):
            return
        if last in TOUCHES and any(each.spring is not None for each in sustained):
            return
        raise Finished(StopReason.EVENT, state)

    def jam(self, state: State) -> Finished:
        """Record a jam of all wires, and return the exception that ends the run.

        In a jam friction or geometry locks the wires.
        """
        for record in self.records:
            record.event("jam", state.time)
        return Finished(StopReason.JAM, state)
