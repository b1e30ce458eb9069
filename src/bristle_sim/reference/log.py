"""What a run of a chain records: samples, events and contact records."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.reference.contacts import Point, Touch
from bristle_sim.reference.mechanics import Chain
from bristle_sim.stop_reason import StopReason
from bristle_sim.theory.impact import Impact
from bristle_sim.trajectory import ContactRecord, Cost, Event, Trajectory

__all__ = ["LARGEST_RETRACTION", "PEAK", "STRIKE", "ChainLog", "ChainState", "Finished"]

STRIKE, PEAK, LARGEST_RETRACTION = "strike", "highest relative speed", "largest retraction"

Reals = NDArray[np.float64]


class ChainState(NamedTuple):
    """Time, and absolute angles and rates of the links; s, rad, rad/s."""

    time: float
    angles: Reals
    rates: Reals


class Finished(Exception):
    """Ends a run."""

    def __init__(self, reason: StopReason) -> None:
        """For a reason."""
        super().__init__(reason)
        self.reason = reason


class ChainLog:
    """The record of a run; ``interval`` is the time between samples, s."""

    def __init__(self, chain: Chain, interval: float, stop_after: str | None) -> None:
        self.chain = chain
        self.interval = interval
        self.stop_after = stop_after
        self.size = chain.hub_radius + chain.length
        self.fastest = chain.fastest_rate
        self.events: list[Event] = []
        self.contacts: list[ContactRecord] = []
        self.impacts = 0
        self._rows: list[tuple[Reals, Reals, Reals, Reals]] = []
        self._turned: list[ChainState] = []
        self._marks: list[float] = []

    def mark(self, time: float) -> None:
        """Request a sample at an instant of the motion that is stored next."""
        self._marks.append(time)

    def turned(self, state: ChainState) -> None:
        """Note where the relative rate rises through zero: retraction may be largest."""
        self._turned.append(state)
        self.mark(state.time)

    def largest_retraction(self) -> None:
        """Note where retraction is largest before the strike, if that is at an instant of no relative rate."""
        strike = min((each.time for each in self.events if each.name == "strike"), default=math.inf)
        time, angles = (np.concatenate(column) for column in list(zip(*self._rows, strict=True))[:2])
        reached = (angles[:, 0] - self.chain.hub_angle(time))[time <= strike]
        candidates = [(each.angles[0] - self.chain.hub_angle(each.time), each.time) for each in self._turned]
        angle, at = min((each for each in candidates if each[1] <= strike), default=(0.0, 0.0))
        if angle < 0.0 and angle <= min(reached[0], reached[-1]):
            self.event("largest retraction", float(at))

    def event(self, name: str, time: float) -> None:
        """Note an event."""
        self.events.append(Event(name, time))

    def seen(self, name: str) -> bool:
        """Whether an event of that name has been noted."""
        return any(each.name == name for each in self.events)

    def check_stop(self) -> None:
        """End the run if the event that it was to stop after has happened.

        Raises:
            Finished: if it has.
        """
        if self.stop_after is not None and self.seen(self.stop_after):
            raise Finished(StopReason.EVENT)

    def touch(self, point: Point, state: ChainState) -> None:
        """Note a touch; the first one of the workpart is the strike."""
        strike = point.obstacle == "workpart" and not self.seen("strike")
        self.event("strike" if strike else f"{point.obstacle} touch", state.time)

    def release(self, point: Point, state: ChainState) -> None:
        """Note the end of a contact."""
        self.event(f"{point.obstacle} release", state.time)

    def sample(self, state: ChainState, force: float) -> None:
        """Store one state."""
        row = np.array([state.time]), state.angles[None], state.rates[None], np.array([max(force, 0.0)])
        self._rows.append(row)

    def samples(
        self,
        motion: Callable[[Reals], Reals],
        start: float,
        end: float,
        force: Callable[[Reals, Reals], Reals] | None,
    ) -> None:
        """Store the motion at multiples of the sampling interval after ``start`` and before ``end``, and at the end."""
        first, last = math.floor(start / self.interval), math.ceil(end / self.interval)
        times = np.arange(first, last + 1, dtype=float) * self.interval
        times = np.union1d(times, self._marks)
        times = np.append(times[(times > start) & (times < end)], end)
        self._marks = [each for each in self._marks if each > end]
        values, count = motion(times), self.chain.links
        forces = np.zeros_like(times) if force is None else np.maximum(force(times, values), 0.0)
        self._rows.append((times, values[:count].T, values[count : 2 * count].T, forces))

    def impact(self, point: Point, state: ChainState, after: ChainState, touch: Touch, hit: Impact) -> None:
        """Record an impact, with samples before and after it."""
        self.impacts += 1
        self.sample(after, 0.0)
        if self.chain.links == 1 and state.rates[0] < self.chain.speed < after.rates[0]:
            self._turned.append(state)
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
                velocity_before=touch.velocity,
                velocity_after=_pair(hit.velocity_normal, hit.velocity_tangential),
                angles=tuple(state.angles.tolist()),
                rates_before=tuple(state.rates.tolist()),
                rates_after=tuple(after.rates.tolist()),
                phases=hit.phases,
            )
        )

    def lasting(
        self,
        point: Point,
        ending: tuple[str, str],
        states: tuple[ChainState, ChainState],
        sums: Reals,
        compression: Reals | None,
        velocities: tuple[tuple[float, float], tuple[float, float]],
    ) -> None:
        """Record a contact that lasted from one state to another.

        ``ending`` are the law and the outcome, ``sums`` the impulses and the works (normal, tangential); ``compression`` those of compression.
        """
        law, outcome = ending
        first, last = states
        if last.time <= first.time:
            return
        compression = sums if compression is None else compression
        rest = (sums - compression).tolist()
        self.contacts.append(
            ContactRecord(
                obstacle=point.obstacle,
                law=law,
                outcome=outcome,
                time=first.time,
                duration=last.time - first.time,
                impulse=_pair(*sums[:2]),
                compressive_impulse=_pair(*compression[:2]),
                compressive_work=_pair(*compression[2:]),
                restitutive_work=_pair(*rest[2:]),
                velocity_before=velocities[0],
                velocity_after=velocities[1],
                angles=tuple(first.angles.tolist()),
                rates_before=tuple(first.rates.tolist()),
                rates_after=tuple(last.rates.tolist()),
            )
        )

    def trajectory(self, stop_reason: StopReason, cost: Cost, parameters: dict[str, Any]) -> Trajectory:
        """Return the finished result."""
        time, angles, rates, force = (np.concatenate(column) for column in zip(*self._rows, strict=True))
        chain = self.chain
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
            normal_force=force,
            hub_speed=chain.speed,
            events=tuple(sorted(self.events, key=lambda each: each.time)),
            contacts=tuple(sorted(self.contacts, key=lambda each: each.time)),
            stop_reason=stop_reason,
            cost=cost,
            parameters=parameters,
        )


def _pair(normal: float, tangential: float) -> tuple[float, float]:
    return float(normal), float(tangential)
