"""What a run of a chain records: samples, events and contact records."""

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


class Finished(Exception):
    """Ends a run at a state."""

    def __init__(self, reason: StopReason, state: State) -> None:
        """For a reason."""
        super().__init__(reason)
        self.reason = reason
        self.state = state


class Log:
    """The record of a wire's run; ``interval`` is the time between samples, s, ``first`` the number of its first link."""

    def __init__(self, chain: Chain, interval: float, stop_after: str | None, first: int = 0) -> None:
        self.chain = chain
        self.first = first
        self.interval = interval
        self.stop_after = stop_after
        self.events: list[Event] = []
        self.contacts: list[ContactRecord] = []
        self.impacts: list[float] = []
        self.samples: list[tuple[State, tuple[float, float]]] = []
        self._turned: list[State] = []
        self._marks: list[float] = []

    # Samples

    def of(self, point: Point | None = None) -> Sequence[Log]:
        """Return the logs of the wires that touch in a contact, of all wires without one."""
        del point
        return [self]

    def own(self, state: State) -> State:
        """Return the state of the wire's own links."""
        links = slice(self.first, self.first + self.chain.links)
        return State(state.time, state.angles[links], state.rates[links])

    def sample(self, instant: Instant) -> None:
        """Store a state with its normal and tangential force, N, unless it was stored last."""
        if self.differs(instant.state, instant.total_forces):
            self.samples.append((instant.state, instant.total_forces))

    def differs(self, state: State, forces: tuple[float, float]) -> bool:
        """Whether a state or its forces differ from those stored last."""
        last = self.samples[-1] if self.samples else None
        return (
            last is None
            or (last[0].time, last[1]) != (state.time, forces)
            or bool((last[0].rates != state.rates).any())
        )

    def times(self, start: float, end: float) -> list[float]:
        """Return the multiples of the sampling interval and the marked instants after a start and before an end."""
        count = np.arange(math.floor(start / self.interval), math.ceil(end / self.interval) + 1, dtype=float)
        return [each for each in np.union1d(count * self.interval, self._marks).tolist() if start < each < end]

    def mark(self, time: float) -> None:
        """Request a sample at an instant of the motion that is stored next."""
        self._marks.append(time)

    # Events

    def event(self, name: str, time: float) -> None:
        """Note an event."""
        self.events.append(Event(name, time))

    def seen(self, name: str) -> bool:
        """Whether an event of that name has been noted."""
        return any(each.name == name for each in self.events)

    def check_stop(self, state: State) -> None:
        """End the run if the event that it was to stop after has happened.

        Raises:
            Finished: if it has.
        """
        if self.stop_after is not None and self.seen(self.stop_after):
            raise Finished(StopReason.EVENT, state)

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
        self.mark(state.time)

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

    # Contacts

    def impact(self, point: Point, state: State, after: State, velocity: tuple[float, float], hit: Impact) -> None:
        """Record an impact between the states before and after it."""
        state, after = self.own(state), self.own(after)
        if state.rates[0] < self.chain.speed < after.rates[0]:
            self.turned(state)
        self.contacts.append(
            ContactRecord(
                obstacle=point.obstacle,
                law="energetic",
                outcome=hit.outcome_name,
                time=state.time,
                duration=0.0,
                impulse=_pair(hit.impulse_normal, hit.impulse_tangential),
                compressive_impulse=_pair(hit.compressive_impulse_normal, hit.compressive_impulse_tangential),
                compressive_work=_pair(hit.compressive_work_normal, hit.compressive_work_tangential),
                restitutive_work=_pair(hit.restitutive_work_normal, hit.restitutive_work_tangential),
                velocity_before=velocity,
                velocity_after=_pair(hit.velocity_normal, hit.velocity_tangential),
                angles=tuple(state.angles.tolist()),
                rates_before=tuple(state.rates.tolist()),
                rates_after=tuple(after.rates.tolist()),
                phases=hit.phases,
            )
        )

    def lasting(self, each: Sustained, last: State, velocity: tuple[float, float], outcome: str) -> None:
        """Record a sustained contact that ends in a state with a velocity, (normal, tangential) in m/s."""
        first, last, sums = self.own(each.since), self.own(last), each.sums
        if last.time <= first.time:
            return
        compression = sums if each.compression is None else each.compression
        self.contacts.append(
            ContactRecord(
                obstacle=each.point.obstacle,
                law="sustained" if each.spring is None else "compliant",
                outcome=outcome,
                time=first.time,
                duration=last.time - first.time,
                impulse=_pair(*sums[:2]),
                compressive_impulse=_pair(*compression[:2]),
                compressive_work=_pair(*compression[2:]),
                restitutive_work=_pair(*(sums - compression)[2:]),
                velocity_before=each.velocity_before,
                velocity_after=velocity,
                angles=tuple(first.angles.tolist()),
                rates_before=tuple(first.rates.tolist()),
                rates_after=tuple(last.rates.tolist()),
            )
        )

    def trajectory(self, stop_reason: StopReason, cost: Cost, parameters: dict[str, Any]) -> Trajectory:
        """Return the finished result."""
        chain = self.chain
        time, angles, rates = (np.array(column) for column in zip(*(state for state, _ in self.samples), strict=True))
        corners, velocities = chain.centre_line(time, angles, rates)
        return Trajectory(
            time=time,
            hub_angle=np.asarray(chain.hub_angle(time)),
            angles=angles,
            rates=rates,
            centre_line=np.stack([corners.real, corners.imag], axis=-1),
            centre_line_velocity=np.stack([velocities.real, velocities.imag], axis=-1),
            kinetic_energy=chain.kinetic_energy(time, angles, rates),
            potential_energy=chain.potential_energy(time, angles),
            normal_force=np.array([max(forces[0], 0.0) for _, forces in self.samples]),
            hub_speed=chain.speed,
            events=tuple(sorted(self.events, key=lambda each: each.time)),
            contacts=tuple(sorted(self.contacts, key=lambda each: each.time)),
            stop_reason=stop_reason,
            cost=cost,
            parameters=parameters,
        )


def _pair(normal: float, tangential: float) -> tuple[float, float]:
    return float(normal), float(tangential)
