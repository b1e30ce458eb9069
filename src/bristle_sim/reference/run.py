"""The whole pass: flight, impact and hold in turn, each ended by an event that is located on the motion."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from bristle_sim.reference.bar import Circle
from bristle_sim.reference.crossing import crossings
from bristle_sim.reference.flight import flight_steps
from bristle_sim.reference.hold import Hold, departure
from bristle_sim.reference.log import JAM, Log
from bristle_sim.reference.mechanics import Mechanics, Motion, State
from bristle_sim.reference.obstacles import Obstacle
from bristle_sim.reference.touch import Touch
from bristle_sim.reference.watch import (
    ROUNDING,
    Happening,
    Watch,
    gaps,
    happenings,
    held,
    limit,
    peak,
    state_at,
    stationary,
)
from bristle_sim.stop_reason import StopReason
from bristle_sim.theory.impact import Impact, energetic_impact

__all__ = ["END_OF_RUN", "PEAK", "STRIKE", "Pass", "Plan"]

LOWEST_REBOUND = 1e-10
"""A rebound that the forces end below this share of hub radius plus bristle length is none.

Taps with a restitution below 1 would accumulate for ever; the sustained touch takes over instead.
"""

MOST_CONTACTS = 2000
"""Contacts after which a run gives up."""

MOST_AT_ONCE = 64
"""Contacts within ``AT_ONCE`` (1e-10 of the motion's fastest rate) after which the bristle counts as wedged."""

AT_ONCE = 1e-10

STRIKE, PEAK, LIMIT = "strike", "highest relative speed", "retraction limit"
STATIONARY, RELEASE, END_OF_RUN = "stationary", "release", "end of run"
LARGEST_RETRACTION = "largest retraction"

REASONS = {LIMIT: StopReason.RETRACTION_LIMIT, JAM: StopReason.JAM, END_OF_RUN: StopReason.END}
"""Why a run stops at what ends its motion; at anything else it stops because that was requested."""


@dataclass(frozen=True, slots=True)
class Plan:
    """When a run ends (s), where it stops early, its integrator's relative tolerance, and the sampling interval (s)."""

    end: float
    stop_after: str | None
    tolerance: float
    interval: float


class _Stop(Exception):
    """Ends the run."""

    def __init__(self, reason: StopReason) -> None:
        """For a reason."""
        super().__init__(reason)
        self.reason = reason


class Pass:
    """One run; ``state`` is where it has got to."""

    def __init__(self, mechanics: Mechanics, obstacles: tuple[Obstacle, ...], plan: Plan, state: State) -> None:
        self.mechanics = mechanics
        self.obstacles = {each.name: each for each in obstacles}
        self.plan = plan
        self.state = state
        self.log = Log(mechanics, plan.interval)
        self.evaluations = 0
        self._touches: list[float] = []

    def run(self) -> StopReason:
        """Run to the end; returns the reason for stopping."""
        try:
            while True:
                obstacle: Obstacle | None = self._fly()
                while obstacle is not None:
                    obstacle = self._meet(obstacle)
        except _Stop as stop:
            self.log.sample(self.state)
            return stop.reason

    @property
    def _hub_angle(self) -> float:
        return float(self.mechanics.hub_angle(self.state.time))

    # Flight

    def _fly(self) -> Obstacle:
        """Free motion up to a touch."""
        self.log.sample(self.state)
        watches = [*self._watches(self.obstacles.values()), peak(PEAK, self.mechanics)]
        for motion, start, end, evaluations in flight_steps(
            self.mechanics, self.state, self.plan.end, self.plan.tolerance
        ):
            self.evaluations += evaluations
            last = self._scan(watches, motion, start, end)
            self.state = state_at(motion, end if last is None else last.time)
            self.log.samples(motion, start, self.state.time)
            if last is not None:
                self.log.sample(self.state)
                return self._obstacle_or_stop(last, self.obstacles)
        raise _Stop(StopReason.END)

    def _watches(self, obstacles: Iterable[Obstacle]) -> list[Watch]:
        return [*gaps(self.mechanics, obstacles, self.state), limit(LIMIT), stationary(STATIONARY, self.mechanics)]

    def _scan(self, watches: list[Watch], motion: Motion, start: float, end: float) -> Happening | None:
        """Note what happens on a piece of motion up to the first event that ends it; return that one."""
        for each in happenings(watches, motion, start, end):
            if each.name == STATIONARY:
                self.log.stationary.append(state_at(motion, each.time))
                self.log.mark(each.time)
                if self.plan.stop_after == LARGEST_RETRACTION:
                    return each
            elif each.name != PEAK or self._note_peak(state_at(motion, each.time)):
                return each
        return None

    def _note_peak(self, state: State) -> bool:
        """Note the first highest relative speed before the strike; true if the run stops there.

        While the bar is still ahead of the root, an untouched bristle is not thrown but idles about its equilibrium.
        """
        if (
            state.rate <= self.plan.tolerance * self.mechanics.fastest_rate
            or self.log.seen(PEAK)
            or self.log.seen(STRIKE)
            or self._bar_ahead(state)
        ):
            return False
        self.log.event(PEAK, state.time)
        self.log.mark(state.time)
        return self.plan.stop_after == PEAK

    def _bar_ahead(self, state: State) -> bool:
        bar = self.obstacles.get("bar")
        if not isinstance(bar, Circle) or self.log.seen("bar touch") or not self.mechanics.speed:
            return False
        return bar.ahead(float(self.mechanics.hub_angle(state.time)))

    def _obstacle_or_stop(self, happening: Happening, obstacles: dict[str, Obstacle]) -> Obstacle:
        if happening.name in obstacles:
            return obstacles[happening.name]
        if happening.name in (LIMIT, JAM):
            self.log.event(happening.name, happening.time)
        raise _Stop(REASONS.get(happening.name, StopReason.EVENT))

    # Contact

    def _meet(self, obstacle: Obstacle) -> Obstacle | None:
        """A touch: impact where the contact point approaches, then hold where it stays; the next obstacle met."""
        self._count_touch()
        name = self._touch_name(obstacle)
        self.log.event(name, self.state.time)
        obstacle = self._touched_part(obstacle)
        touch = obstacle.touch(*self.state[1:], self._hub_angle)
        parting = float(touch.velocity(self.state.rate)[0])
        if parting < 0.0:
            parting = self._hit(obstacle, touch)
        if self.plan.stop_after == name:
            raise _Stop(StopReason.EVENT)
        if self._stays(obstacle, parting):
            return self._hold(obstacle)
        self._release(obstacle)
        return None

    def _release(self, obstacle: Obstacle) -> None:
        name = f"{obstacle.name} release"
        self.log.event(name, self.state.time)
        if self.plan.stop_after == name:
            raise _Stop(StopReason.EVENT)

    def _touched_part(self, obstacle: Obstacle) -> Obstacle:
        side = self._side(obstacle)
        return min(obstacle.parts(side), key=lambda part: float(part.gap(self.state.angle, self._hub_angle)))

    def _side(self, obstacle: Obstacle) -> float:
        """+1 where the contact point leaves the obstacle as alpha grows, -1 where it approaches."""
        return 1.0 if obstacle.touch(*self.state[1:], self._hub_angle).normal_lever > 0.0 else -1.0

    def _touch_name(self, obstacle: Obstacle) -> str:
        first = obstacle.name == "workpart" and not self.log.seen(STRIKE)
        return STRIKE if first else f"{obstacle.name} touch"

    def _count_touch(self) -> None:
        """Stop where touches follow one another without time passing, or without end."""
        self._touches.append(self.state.time)
        recent = self._touches[-MOST_AT_ONCE:]
        fastest = max(self.mechanics.fastest_rate, abs(self.state.rate))
        if len(recent) == MOST_AT_ONCE and (recent[-1] - recent[0]) * fastest < AT_ONCE:
            self.log.event(JAM, self.state.time)
            raise _Stop(StopReason.JAM)
        if len(self._touches) > MOST_CONTACTS:
            raise _Stop(StopReason.MOST_CONTACTS)

    def _hit(self, obstacle: Obstacle, touch: Touch) -> float:
        """Resolve an impact; returns the normal velocity after it, m/s."""
        before = touch.velocity(self.state.rate)
        surface = (obstacle.friction, obstacle.restitution, obstacle.friction_in_restitution)
        hit = energetic_impact(touch.inverse_mass(self.mechanics.inertia), before, *surface)
        after = self.state._replace(rate=self.state.rate + self._kick(touch, hit))
        self.log.impact(obstacle.name, self.state, after.rate, before, hit)
        if self.state.rate < 0.0 < after.rate:
            self.log.stationary.append(self.state)
        self.state = after
        if hit.outcome_name == JAM:
            self.log.event(JAM, after.time)
            raise _Stop(StopReason.JAM)
        return float(hit.velocity_normal)

    def _kick(self, touch: Touch, hit: Impact) -> float:
        """Change of the rate by an impulse, J . p / I, rad/s."""
        moment = touch.normal_lever * hit.impulse_normal + touch.tangential_lever * hit.impulse_tangential
        return float(moment / self.mechanics.inertia)

    def _stays(self, obstacle: Obstacle, parting: float) -> bool:
        """Whether the contact point, pressed on, parts at no speed or at one too low to matter."""
        touch = obstacle.touch(*self.state[1:], self._hub_angle)
        free = float(departure(self.mechanics, touch, *self.state))
        lowest = LOWEST_REBOUND * (self.mechanics.hub_radius + self.mechanics.length)
        return free < 0.0 and max(parting, 0.0) ** 2 < -2.0 * free * lowest

    def _hold(self, obstacle: Obstacle) -> Obstacle | None:
        """Sustained touch, up to the release or to what else ends it."""
        hold = Hold(self.mechanics, obstacle, self._side(obstacle))
        others = self._others(hold)
        start, last = self.state.time, Happening(JAM, self.state.time)
        if hold.freedom(np.array([start]))[0] > 0.0:
            last = self._slide(hold, others.values())
        self.log.hold(hold, start, last)
        self.state = hold.state(last.time) if last.time > start else self.state
        if last.name == RELEASE or last.name in others:
            self._release(obstacle)
        return None if last.name == RELEASE else self._obstacle_or_stop(last, others)

    def _others(self, hold: Hold) -> dict[str, Obstacle]:
        """What else can be touched during a hold: other obstacles, and the other part of the one that holds."""
        name = hold.obstacle.name
        others = [obstacle for obstacle in self.obstacles.values() if obstacle.name != name]
        others += (part for part in self.obstacles[name].parts(hold.side) if part != hold.obstacle)
        return {each.name: each for each in others}

    def _slide(self, hold: Hold, others: Collection[Obstacle]) -> Happening:
        """Follow the obstacle; what ends it."""
        watches = [*held(RELEASE, JAM, hold), *self._watches(others)]
        end = self._held_at_most(hold)
        edges = self._stretches(hold, self.state.time, end)
        found = (self._scan(watches, hold.motion, *edge) for edge in itertools.pairwise(edges))
        rest = Happening(END_OF_RUN if end >= self.plan.end else RELEASE, end)
        return next((each for each in found if each is not None), rest)

    def _stretches(self, hold: Hold, start: float, end: float) -> list[float]:
        """Edges of smooth stretches of a hold, no longer than a radian of the fastest motion."""
        pieces = 1 + int((end - start) * self.mechanics.fastest_rate)
        seams = hold.seams(start, end, ROUNDING * self.mechanics.length**2)
        return sorted({*np.linspace(start, end, pieces + 1).tolist(), *seams})

    def _held_at_most(self, hold: Hold) -> float:
        """The end of the run, or just before the obstacle gets out of reach."""
        start, end = self.state.time, self.plan.end
        rounding = ROUNDING * (self.mechanics.hub_radius + self.mechanics.length)
        leaving = [time for time, direction in crossings(hold.within_reach, start, end, rounding) if direction < 0]
        return start + (1.0 - 1e-9) * (leaving[0] - start) if leaving else end
