"""What a run leaves behind: samples, events and the contacts' ledger."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.reference.hold import Hold
from bristle_sim.reference.mechanics import Mechanics, Motion, State
from bristle_sim.reference.watch import Happening
from bristle_sim.stop_reason import StopReason
from bristle_sim.theory.impact import Impact
from bristle_sim.trajectory import ContactRecord, Cost, Event, Trajectory

__all__ = ["JAM", "Log"]

Array = NDArray[np.float64]

JAM = "jam"


class Log:
    """Collects a run; ``stationary`` holds the instants at which retraction could be largest."""

    def __init__(self, mechanics: Mechanics, interval: float) -> None:
        self.mechanics = mechanics
        self.interval = interval
        self.events: list[Event] = []
        self.contacts: list[ContactRecord] = []
        self.stationary: list[State] = []
        self._rows: list[Array] = []
        self._marks: list[float] = []

    def event(self, name: str, time: float) -> None:
        """Note an event."""
        self.events.append(Event(name, time))

    def seen(self, name: str) -> bool:
        """Whether an event of that name has been noted."""
        return any(each.name == name for each in self.events)

    def mark(self, time: float) -> None:
        """Ask for a sample at an instant of the motion that is stored next."""
        self._marks.append(time)

    def sample(self, state: State, force: float = 0.0) -> None:
        """Store one state, unless it is the one stored last: only an impact makes two of an instant."""
        if self._rows:
            time, _, rate, _ = self._rows[-1][-1]
            if time == state.time and math.isclose(rate, state.rate, rel_tol=1e-9, abs_tol=1e-12):
                return
        self._rows.append(np.array([[*state, max(force, 0.0)]]))

    def samples(self, motion: Motion, start: float, end: float, force: Callable[[Array], Array] | None = None) -> None:
        """Store the motion at marks and multiples of the sampling interval after ``start`` and up to ``end``."""
        first, last = math.floor(start / self.interval), math.ceil(end / self.interval)
        times = np.union1d(np.arange(first, last + 1, dtype=np.float64) * self.interval, self._marks)
        times = times[(times > start) & (times <= end)]
        if times.size:
            forces = np.zeros_like(times) if force is None else np.maximum(force(times), 0.0)
            self._rows.append(np.column_stack([times, *motion(times), forces]))
        self._marks = [each for each in self._marks if each > end]

    def impact(self, obstacle: str, state: State, rate_after: float, before: tuple[float, float], hit: Impact) -> None:
        """Add an impact to the ledger."""
        self.contacts.append(
            ContactRecord(
                obstacle=obstacle,
                law="energetic",
                outcome=hit.outcome_name,
                time=state.time,
                duration=0.0,
                impulse=_pair(hit.impulse_normal, hit.impulse_tangential),
                compressive_impulse=_pair(hit.compressive_impulse_normal, hit.compressive_impulse_tangential),
                compressive_work=_pair(hit.compressive_work_normal, hit.compressive_work_tangential),
                restitutive_work=_pair(hit.restitutive_work_normal, hit.restitutive_work_tangential),
                velocity_before=_pair(*before),
                velocity_after=_pair(hit.velocity_normal, hit.velocity_tangential),
                **self._rates(state, rate_after),
                phases=hit.phases,
            )
        )

    def hold(self, hold: Hold, start: float, last: Happening) -> None:
        """Sample a sustained touch and add it to the ledger; it does no normal work, and nothing is restituted."""
        if last.time <= start:
            return
        # Towards a jam the force grows beyond bounds, and its impulse as the logarithm of the time that is left.
        jammed = last.name == JAM
        until = last.time - 1e-6 * (last.time - start) if jammed else last.time
        first, end = hold.state(start), hold.state(last.time)
        self.sample(first, float(hold.force(np.array([start]))[0]))
        self.samples(hold.motion, start, end.time, hold.force)
        self.sample(end, 0.0 if jammed else float(hold.force(np.array([end.time]))[0]))
        impulse = hold.impulse(start, until)
        self.contacts.append(
            ContactRecord(
                obstacle=hold.obstacle.name,
                law="sustained",
                outcome=last.name,
                time=start,
                duration=end.time - start,
                impulse=impulse,
                compressive_impulse=impulse,
                compressive_work=(0.0, hold.friction_work(start, until)),
                restitutive_work=(0.0, 0.0),
                velocity_before=_pair(0.0, hold.slip(np.array([start]))[0]),
                velocity_after=_pair(0.0, hold.slip(np.array([end.time]))[0]),
                **self._rates(first, end.rate),
            )
        )

    def largest_retraction(self) -> None:
        """Note where retraction is largest before the strike, if it is at an instant of no relative rate."""
        strike = min((each.time for each in self.events if each.name == "strike"), default=math.inf)
        rows = np.concatenate(self._rows)
        reached = rows[rows[:, 0] <= strike, 1]
        candidates = [each for each in self.stationary if each.time <= strike]
        deepest = min(candidates, key=lambda each: each.angle, default=None)
        if deepest is not None and deepest.angle < 0.0 and deepest.angle <= min(reached[0], reached[-1]):
            self.event("largest retraction", deepest.time)

    def trajectory(self, stop_reason: StopReason, cost: Cost, parameters: dict[str, Any]) -> Trajectory:
        """The finished result."""
        time, angle, rate, force = np.concatenate(self._rows).T
        hub_angle = self.mechanics.hub_angle(time)
        corners, velocities = self.mechanics.centre_line(hub_angle, angle, rate)
        return Trajectory(
            time=time,
            hub_angle=hub_angle,
            angles=(hub_angle + angle)[:, np.newaxis],
            rates=(self.mechanics.speed + rate)[:, np.newaxis],
            centre_line=np.stack([corners.real, corners.imag], axis=-1),
            centre_line_velocity=np.stack([velocities.real, velocities.imag], axis=-1),
            kinetic_energy=self.mechanics.kinetic_energy(angle, rate),
            potential_energy=self.mechanics.potential_energy(hub_angle, angle),
            normal_force=force,
            hub_speed=self.mechanics.speed,
            events=tuple(sorted(self.events, key=lambda each: each.time)),
            contacts=tuple(self.contacts),
            stop_reason=stop_reason,
            cost=cost,
            parameters=parameters,
        )

    def _rates(self, state: State, rate_after: float) -> dict[str, Any]:
        speed = self.mechanics.speed
        return {
            "angles": (float(self.mechanics.hub_angle(state.time) + state.angle),),
            "rates_before": (float(speed + state.rate),),
            "rates_after": (float(speed + rate_after),),
        }


def _pair(normal: float, tangential: float) -> tuple[float, float]:
    return float(normal), float(tangential)
