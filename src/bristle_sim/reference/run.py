"""The pass of a wire of links: intervals of smooth motion with any contacts sustained, and events between them.

scipy's DOP853 integrates an interval, with the impulses and friction's work of sustained contacts as further unknowns. The
interval ends at the first event: an obstacle is touched, a contact's force falls to zero, its place passes a corner of the
wire, slip stops or begins. After an event, impacts are resolved, the fastest approach first, and it is decided which of the
closed contacts stay.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from bristle_sim.reference.contacts import Bar, Point, Spring, Touch, Workpart
from bristle_sim.reference.crossing import Piece as Series
from bristle_sim.reference.crossing import crossings, nodes
from bristle_sim.reference.forces import Acting, Balance, acting, balance, closed, freedom, resolve
from bristle_sim.reference.log import LARGEST_RETRACTION, PEAK, STRIKE, ChainLog, ChainState, Finished
from bristle_sim.reference.mechanics import Chain, Kinematics
from bristle_sim.stop_reason import StopReason

__all__ = ["ChainRun"]

Reals = NDArray[np.float64]

INSIDE = 1e-12
"""A touch is located where the gap is this fraction of hub radius and length below zero: above the drift of closed gaps."""

REST = 1e-10
"""A velocity below this fraction of the fastest point's bound is rest: impacts between stiff hinges round this much."""

PAST = 1e-9
"""A contact passes a corner when it is this fraction of the length beyond it, so that rounding does not bring it back."""

LOWEST_REBOUND = 1e-10
"""A rebound that the forces end below this fraction of hub radius and length is taken for a sustained contact."""

MOST_IMPACTS, MOST_AT_ONCE = 20_000, 400
"""The number of impacts in a run, and at one instant, after which it gives up."""

ROUNDING = 1e-13


@dataclass(slots=True)
class Sustained:
    """A contact that lasts: its place, the sense of its slip (0 sticks), since when, and its spring if it has one.

    ``sums`` are the normal and tangential impulse and the normal and tangential work; ``compression`` those up to the first
    end of compression.
    """

    point: Point
    slip: int
    since: ChainState
    velocity_before: tuple[float, float]
    sums: Reals
    spring: Spring | None = None
    compression: Reals | None = None
    compressed: float = math.nan


class Event(NamedTuple):
    """A function of times and states whose change of sign in one direction ends an interval, and what follows.

    The gap of an obstacle and a piece has a ``place``: it need not be looked at while it is far from closing.
    """

    value: Callable[[Reals, Reals], Reals]
    direction: int
    resolution: float
    follow: Callable[[], None]
    place: tuple[str, int] | None = None


class ChainRun:
    """One run of a chain among obstacles."""

    def __init__(
        self,
        chain: Chain,
        obstacles: dict[str, Bar | Workpart],
        log: ChainLog,
        start: ChainState,
        end: float,
        tolerance: float,
        stiffness: float | None = None,
    ) -> None:
        """``stiffness`` of the workpart's contact, N/m; None is rigid."""
        self.stiffness = stiffness
        self.chain = chain
        self.obstacles = obstacles
        self.log = log
        self.state = start
        self.end = end
        self.tolerance = tolerance
        self.sustained: list[Sustained] = []
        self.evaluations = 0

    def run(self) -> StopReason:
        """Run to the end and return the reason for stopping."""
        self.log.sample(self.state, 0.0)
        reason = StopReason.END
        try:
            while self.state.time < self.end:
                self._interval()()
        except Finished as finished:
            reason = finished.reason
        for each in self.sustained:
            self._record(each, str(reason))
        return reason

    # Smooth motion

    def _interval(self) -> Callable[[], None]:
        """Integrate to the next event; return what follows it."""
        events = self._events()
        solver = self._solver()
        while True:
            solver.step()
            self.evaluations += solver.nfev
            solver.nfev = 0
            if solver.status == "failed":
                raise Finished(StopReason.ACCURACY)
            motion = solver.dense_output()
            first = self._first(events, motion, solver.t_old, solver.t)
            until, follow = first if first is not None else (solver.t, None)
            if self.chain.links == 1 and self._extremes(motion, solver.t_old, until):
                self._take(self.state.time, motion(self.state.time))
                raise Finished(StopReason.EVENT)
            self._note(motion, solver.t_old, until)
            self._take(until, motion(until))
            if follow is not None:
                return follow
            if solver.status == "finished":
                return lambda: None
            if self.sustained and self._drifted():
                return lambda: None

    def _solver(self) -> DOP853:
        speeds = max(self.chain.speed, float(np.abs(self.state.rates).max()), 1e-300)
        count = self.chain.links
        scale = np.concatenate([np.ones(count), np.full(count, max(speeds, self.log.fastest))])
        force = self.chain.masses.sum() * self.log.size * self.log.fastest
        work = force * self.log.size * self.log.fastest
        sums = np.tile([force, force, work, work], len(self.sustained))
        start = np.concatenate([self.state.angles, self.state.rates, *(each.sums for each in self.sustained)])
        return DOP853(
            self._right_hand_side,
            self.state.time,
            start,
            self.end,
            max_step=1.0 / self.log.fastest if self.log.fastest else np.inf,
            rtol=self.tolerance,
            atol=self.tolerance * np.concatenate([scale, sums]),
        )

    def _right_hand_side(self, time: float, values: Reals) -> Reals:
        count = self.chain.links
        contacts, found = self._balance(time, values)
        velocities = np.array([each.touch.velocity for each in contacts]).reshape(-1, 2)
        powers = found.normal * velocities[:, 0], found.tangential * velocities[:, 1]
        sums = np.column_stack([found.normal, found.tangential, *powers]).ravel()
        return np.concatenate([values[count : 2 * count], found.accelerations, sums])

    def _balance(self, time: float, values: Reals) -> tuple[list[Acting], Balance]:
        """Contacts and the balance of forces at an instant."""
        count = self.chain.links
        angles, rates = values[:count], values[count : 2 * count]
        contacts = self._acting(ChainState(time, angles, rates), self.sustained)
        mass = self.chain.mass_matrix(np.exp(1j * angles))
        return contacts, balance(mass, self.chain.forces(time, angles, rates), contacts)

    def _acting(self, state: ChainState, sustained: list[Sustained]) -> list[Acting]:
        touches = self._touches(state, [each.point for each in sustained])
        return [
            Acting(
                touch,
                self._friction(each.point),
                each.slip,
                None if each.spring is None else each.spring.force(-touch.gap),
            )
            for touch, each in zip(touches, sustained, strict=True)
        ]

    @property
    def _rigid(self) -> list[Point]:
        return [each.point for each in self.sustained if each.spring is None]

    def _touches(self, state: ChainState, points: list[Point]) -> list[Touch]:
        if not points:
            return []
        motion = self.chain.kinematics(*state)
        return [self.obstacles[point.obstacle].touch(self.chain, motion, point) for point in points]

    def _friction(self, point: Point) -> float:
        return self.obstacles[point.obstacle].surface.friction

    def _take(self, time: float, values: Reals) -> None:
        """Go on to an instant of the motion."""
        count = self.chain.links
        self.state = ChainState(time, values[:count].copy(), values[count : 2 * count].copy())
        for number, each in enumerate(self.sustained):
            each.sums = values[2 * count + 4 * number :][:4].copy()

    def _drifted(self) -> bool:
        """Close what the integrator has let the gaps drift; whether that was worth a new start."""
        touches = self._touches(self.state, self._rigid)
        if max((abs(touch.gap) for touch in touches), default=0.0) < 0.02 * INSIDE * self.log.size:
            return False
        self._close(touches)
        return True

    def _close(self, touches: list[Touch]) -> None:
        if not touches:
            return
        time, angles, rates = self.state
        mass = self.chain.mass_matrix(np.exp(1j * angles))
        moved, changed = closed(mass, touches)
        self.state = ChainState(time, angles + moved, rates + changed)

    # Events

    def _events(self) -> list[Event]:
        found = [*self._touch_events(), *self._sustained_events()]
        limit = partial(self._call, self._retraction_limit)
        lean = lambda times, values: (0.5 * math.pi) ** 2 - (values[0] - self.chain.hub_angle(times)) ** 2  # noqa: E731
        return [*found, Event(lean, -1, ROUNDING, limit)]

    @staticmethod
    def _call(act: Callable[[], None]) -> None:
        act()

    def _retraction_limit(self) -> None:
        self.log.event("retraction limit", self.state.time)
        raise Finished(StopReason.RETRACTION_LIMIT)

    def _touch_events(self) -> list[Event]:
        """An obstacle is touched where it is not touched yet."""
        inside = INSIDE * self.log.size
        motion, found = self.chain.kinematics(*self.state), []
        for name, obstacle in self.obstacles.items():
            for piece, gap in enumerate(obstacle.gaps(self.chain, motion).tolist()):
                if not self._shadowed(name, piece):
                    value = partial(self._gap, obstacle, piece, min(gap, 0.0) - inside)
                    found.append(Event(value, -1, 0.1 * inside, partial(self._meet, name, piece), (name, piece)))
        return found

    def _shadowed(self, obstacle: str, piece: int) -> bool:
        """Whether a piece's nearest point is in contact already, or the corner that is."""
        if isinstance(self.obstacles[obstacle], Workpart):
            return any(each.point.obstacle == obstacle for each in self.sustained)
        points = [each.point for each in self.sustained if each.point.obstacle == obstacle]
        return any(point.piece == piece or (point.corner and point.piece == piece - 1) for point in points)

    def _gap(self, obstacle: Bar | Workpart, piece: int, level: float, times: Reals, values: Reals) -> Reals:
        return np.asarray(obstacle.gaps(self.chain, self._motion(times, values))[..., piece] - level)

    def _motion(self, times: Reals, values: Reals) -> Kinematics:
        count = self.chain.links
        return self.chain.kinematics(times, values[:count].T, values[count : 2 * count].T)

    def _sustained_events(self) -> list[Event]:
        """What ends or changes a sustained contact."""
        found = []
        for number, each in enumerate(self.sustained):
            scale = self.chain.masses.sum() * self.log.size * self.log.fastest**2
            if each.spring is None:
                found.append(Event(partial(self._force, number), -1, ROUNDING * scale, self._decide))
            else:
                found += self._spring_events(each, each.spring)
            mu = self._friction(each.point)
            if mu and each.slip:
                # Slip that begins after stick may start from a velocity that is rounding, of either sign.
                level = min(each.slip * self._touches(self.state, [each.point])[0].velocity[1], 0.0)
                sliding = partial(self._slip, number, each.slip, level - 1e-3 * self._still())
                found.append(Event(sliding, -1, ROUNDING * self.log.size * self.log.fastest, self._decide))
                if each.spring is None:
                    locking = partial(self._freedom, number)
                    found.append(Event(locking, -1, ROUNDING / self.chain.masses.sum(), self._jam))
            elif mu:
                found.append(Event(partial(self._cone, number, mu), -1, ROUNDING * scale, self._decide))
            obstacle = self.obstacles[each.point.obstacle]
            if isinstance(obstacle, Bar):
                found += self._places(each, obstacle)
        return found

    def _spring_events(self, each: Sustained, spring: Spring) -> list[Event]:
        """Compression ends; on the way out the force falls to zero, or the penetration is as deep as before."""
        speed, depth = ROUNDING * self.log.size * self.log.fastest, ROUNDING * spring.deepest

        def opening(times: Reals, values: Reals) -> Reals:
            return np.array([self._touches_at(at, each)[0].velocity[0] for at in zip(times, values.T, strict=True)])

        def above(level: float, times: Reals, values: Reals) -> Reals:
            found = [self._touches_at(at, each)[0].gap for at in zip(times, values.T, strict=True)]
            return -np.array(found) - level

        if spring.loading:
            return [Event(opening, 1, speed, partial(self._turn, each, spring))]
        reload = Event(partial(above, spring.deepest * (1.0 + 1e-13)), 1, depth, partial(self._reload, spring))
        return [Event(partial(above, spring.left), -1, depth, partial(self._part, each)), reload]

    def _touches_at(self, at: tuple[float, Reals], each: Sustained) -> list[Touch]:
        count = self.chain.links
        return self._touches(ChainState(at[0], at[1][:count], at[1][count : 2 * count]), [each.point])

    def _turn(self, each: Sustained, spring: Spring) -> None:
        spring.deepest, spring.loading = -self._touches(self.state, [each.point])[0].gap, False
        if each.compression is None:
            each.compression, each.compressed = each.sums, self.state.time
        if not spring.restitution:
            self._part(each)

    def _reload(self, spring: Spring) -> None:
        spring.loading = True

    def _part(self, each: Sustained) -> None:
        self._record(each, "rebound")
        self.log.release(each.point, self.state)
        self.sustained.remove(each)
        self.log.check_stop()

    def _places(self, each: Sustained, bar: Bar) -> list[Event]:
        """The contact passes from flank to corner or back."""
        index, past = each.point.piece, PAST * self.chain.length
        length, resolution = self.chain.pieces[index].length, ROUNDING * self.chain.length
        last = index == len(self.chain.pieces) - 1

        def event(piece: int, level: float, direction: int, point: Point) -> Event:
            value = partial(self._foot, bar, piece, level)
            return Event(value, direction, resolution, partial(self._move, each, point))

        if each.point.corner:
            found = [event(index, length - past, -1, each.point._replace(corner=False))]
            if not last:
                found.append(event(index + 1, past, 1, Point(each.point.obstacle, index + 1, False)))
            return found
        found = [event(index, length + past, 1, each.point._replace(corner=True))]
        if index:
            found.append(event(index, -past, -1, Point(each.point.obstacle, index - 1, True)))
        return found

    def _foot(self, bar: Bar, piece: int, level: float, times: Reals, values: Reals) -> Reals:
        return np.asarray(bar.feet(self.chain, self._motion(times, values))[0][..., piece] - level)

    def _move(self, each: Sustained, point: Point) -> None:
        each.point = point
        self._close(self._touches(self.state, self._rigid))

    def _force(self, number: int, times: Reals, values: Reals) -> Reals:
        return np.array([self._balance(*at)[1].normal[number] for at in zip(times, values.T, strict=True)])

    def _cone(self, number: int, mu: float, times: Reals, values: Reals) -> Reals:
        found = [self._balance(*at)[1] for at in zip(times, values.T, strict=True)]
        return np.array([mu * each.normal[number] - abs(each.tangential[number]) for each in found])

    def _slip(self, number: int, sense: int, level: float, times: Reals, values: Reals) -> Reals:
        point = self.sustained[number]
        found = [self._touches_at(at, point)[0].velocity[1] for at in zip(times, values.T, strict=True)]
        return sense * np.array(found) - level

    def _freedom(self, number: int, times: Reals, values: Reals) -> Reals:
        each = self.sustained[number]
        ratio = -self._friction(each.point) * each.slip
        count, found = self.chain.links, []
        for time, column in zip(times, values.T, strict=True):
            touch = self._touches(ChainState(time, column[:count], column[count : 2 * count]), [each.point])[0]
            found.append(freedom(self.chain.mass_matrix(np.exp(1j * column[:count])), touch, ratio))
        return np.array(found)

    def _first(
        self, events: list[Event], motion: Callable[[Reals], Reals], start: float, end: float
    ) -> tuple[float, Callable[[], None]] | None:
        """The first event on a step of the integrator, and what follows it."""
        first = None
        whole, times = end, nodes(start, end)
        values = motion(times)
        near = self._near(times, values)
        for event in events:
            if event.place is not None and event.place not in near:
                continue
            found = event.value(times, values)
            series = Series.through(found, start, whole)
            if series.sign == -event.direction and series.resolved(found, event.resolution):
                continue
            value = partial(_along, event.value, motion)
            if event.direction * value(np.array([start]))[0] > 0.0:
                return start, event.follow
            for time, direction in crossings(value, start, end, event.resolution):
                if direction == event.direction:
                    first, end = (time, event.follow), time
                    break
        return first

    def _extremes(self, motion: Callable[[Reals], Reals], start: float, end: float) -> bool:
        """Note where a rigid bristle lags or leads most, and its highest relative rate; whether the run ends there."""

        def rate(times: Reals) -> Reals:
            return np.asarray(motion(times)[1] - self.chain.speed)

        def acceleration(times: Reals) -> Reals:
            return np.array([self._balance(*at)[1].accelerations[0] for at in zip(times, motion(times).T, strict=True)])

        scale = ROUNDING * self.log.fastest
        for time, direction in _changes(rate, start, end, scale):
            if direction > 0:
                self.log.turned(ChainState(time, *motion(time)[:2, None]))
                if self.log.stop_after == LARGEST_RETRACTION:
                    self._note(motion, start, time)
                    self.state = ChainState(time, *motion(time)[:2, None])
                    return True
        if self.sustained or self.log.seen(PEAK) or self.log.seen(STRIKE):
            return False
        for time, direction in _changes(acceleration, start, end, scale * self.log.fastest):
            fast = rate(np.array([time]))[0] > self.tolerance * self.log.fastest
            if direction < 0 and fast and not self._bar_ahead(time):
                self.log.event(PEAK, time)
                self.log.mark(time)
                if self.log.stop_after == PEAK:
                    self._note(motion, start, time)
                    self.state = ChainState(time, *motion(time)[:2, None])
                    return True
                break
        return False

    def _bar_ahead(self, time: float) -> bool:
        """Whether an untouched bar is still within half a turn ahead of the root: the bristle has not been thrown yet."""
        bar = self.obstacles.get("bar")
        if not isinstance(bar, Bar) or self.log.seen("bar touch") or not self.chain.speed:
            return False
        return bool((bar.centre / self.chain.root(time)).imag > 0.0)

    def _near(self, times: Reals, values: Reals) -> set[tuple[str, int]]:
        """The obstacles and pieces that can come to touch in a step: no gap closes faster than the links' points move."""
        motion, count = self._motion(times[-1:], values[:, -1:]), self.chain.links
        rates = np.abs(values[count : 2 * count]).max(axis=1)
        reach = abs(self.chain.speed) * self.chain.hub_radius + float(np.abs(self.chain.ends) @ rates)
        far = 2.0 * reach * (times[0] - times[-1])
        found = set()
        for name, obstacle in self.obstacles.items():
            gaps = obstacle.gaps(self.chain, motion)[0]
            found |= {(name, int(piece)) for piece in np.flatnonzero(gaps < abs(far))}
        return found

    def _note(self, motion: Callable[[Reals], Reals], start: float, end: float) -> None:
        """Have the log sample the motion, with the workpart's or bar's normal force."""
        self.log.samples(motion, start, end, self._total_force if self.sustained else None)

    def _total_force(self, times: Reals, values: Reals) -> Reals:
        return np.array([self._balance(*at)[1].normal.sum() for at in zip(times, values.T, strict=True)])

    # Contact

    def _meet(self, name: str, piece: int) -> None:
        """A contact closes: impacts follow, and contacts that stay."""
        point = self._place_of(name, piece)
        self.log.touch(point, self.state)
        self._decide(point)

    def _place_of(self, name: str, piece: int) -> Point:
        """Return where a piece is touched: on its flank, at the corner at its end, or at the one before it."""
        obstacle = self.obstacles[name]
        if isinstance(obstacle, Workpart):
            return Point(name, len(self.chain.pieces) - 1, True)
        foot = float(obstacle.feet(self.chain, self.chain.kinematics(*self.state))[0][piece])
        if foot <= 0.0 and piece:
            return Point(name, piece - 1, True)
        return Point(name, piece, foot >= self.chain.pieces[piece].length)

    def _jam(self) -> None:
        self.log.event("jam", self.state.time)
        raise Finished(StopReason.JAM)

    def _decide(self, new: Point | None = None) -> None:
        """Resolve impacts among the closed contacts, then find which of them stay closed."""
        springs = [each for each in self.sustained if each.spring is not None]
        points = self._rigid
        if new is not None and new.obstacle == "workpart" and self.stiffness is not None:
            springs.append(self._spring(new))
        elif new is not None and new not in points:
            points.append(new)
        if points:
            self._impacts(points)
            self._rest_low_rebounds(self._touches(self.state, points))
        touches = self._touches(self.state, points)
        resting = [i for i, touch in enumerate(touches) if abs(touch.velocity[0]) <= self._still()]
        contacts = [Acting(touches[i], self._friction(points[i]), 0) for i in resting] + self._acting(
            self.state, springs
        )
        mass = self.chain.mass_matrix(np.exp(1j * self.state.angles))
        kept = acting(mass, self.chain.forces(*self.state), contacts, self._still())
        if kept is None:
            self._jam()
        assert kept is not None
        for i, slip in kept:
            if i >= len(resting):
                springs[i - len(resting)].slip = slip
        self._keep(
            {
                points[resting[i]]: (slip, (0.0, touches[resting[i]].velocity[1]))
                for i, slip in kept
                if i < len(resting)
            },
            points,
        )
        self.sustained += [each for each in springs if each not in self.sustained]
        self.log.check_stop()

    def _spring(self, point: Point) -> Sustained:
        """A compliant contact that begins."""
        assert self.stiffness is not None
        touch = self._touches(self.state, [point])[0]
        spring = Spring(self.stiffness, self.obstacles[point.obstacle].surface.restitution)
        return Sustained(point, 0, self.state, touch.velocity, np.zeros(4), spring)

    def _still(self) -> float:
        return (
            REST * self.log.size * max(self.chain.speed, float(np.abs(self.state.rates).max()), self.log.fastest * 1e-3)
        )

    def _impacts(self, points: list[Point]) -> None:
        """Resolve the impacts at an instant one after the other, the fastest approach first."""
        for _ in range(MOST_AT_ONCE):
            touches = self._touches(self.state, points)
            fastest = min(range(len(points)), key=lambda i: touches[i].velocity[0])
            if touches[fastest].velocity[0] >= -self._still():
                return
            self._hit(points[fastest], touches[fastest])
        self._jam()

    def _hit(self, point: Point, touch: Touch, *, elastic: bool = True) -> None:
        surface = self.obstacles[point.obstacle].surface
        mass = self.chain.mass_matrix(np.exp(1j * self.state.angles))
        restitution = surface.restitution if elastic else 0.0
        change, hit = resolve(mass, touch, surface.friction, restitution, surface.friction_in_restitution)
        after = self.state._replace(rates=self.state.rates + change)
        self.log.impact(point, self.state, after, touch, hit)
        self.state = after
        if hit.outcome_name == "jam":
            self._jam()
        if self.log.impacts > MOST_IMPACTS:
            raise Finished(StopReason.MOST_CONTACTS)

    def _rest_low_rebounds(self, touches: list[Touch]) -> None:
        """Stop contacts that part so slowly that the forces would end their hop within rounding."""
        mass = self.chain.mass_matrix(np.exp(1j * self.state.angles))
        free = np.linalg.solve(mass, self.chain.forces(*self.state))
        low = []
        for touch in touches:
            falling = float(touch.normal_row @ free) + touch.bias[0]
            parting = touch.velocity[0]
            hop = parting**2 < -2.0 * falling * LOWEST_REBOUND * self.log.size
            low += [touch] if falling < 0.0 and parting > 0.0 and hop else []
        if low:
            changed = closed(mass, low)[1]
            self.state = self.state._replace(rates=self.state.rates + changed)

    def _keep(self, kept: dict[Point, tuple[int, tuple[float, float]]], points: list[Point]) -> None:
        """Begin, continue and end sustained contacts."""
        remaining = []
        for each in self.sustained:
            if each.spring is not None:
                remaining.append(each)
            elif each.point in kept:
                each.slip = kept.pop(each.point)[0]
                remaining.append(each)
            else:
                self.log.release(each.point, self.state)
                self._record(each, "release")
        for point in points:
            if point in kept:
                slip, velocity = kept[point]
                remaining.append(Sustained(point, slip, self.state, velocity, np.zeros(4)))
            elif not any(each.point == point for each in self.sustained):
                self.log.release(point, self.state)
        self.sustained = remaining
        if remaining:
            self._close(self._touches(self.state, self._rigid))

    def _record(self, each: Sustained, outcome: str) -> None:
        after = self._touches(self.state, [each.point])[0].velocity
        if each.spring is None:
            after = (0.0, after[1])
        compression = each.compression if each.spring is not None else each.sums
        velocities = (each.velocity_before, after)
        law = "hold" if each.spring is None else "compliant"
        self.log.lasting(each.point, (law, outcome), (each.since, self.state), each.sums, compression, velocities)


def _changes(
    function: Callable[[Reals], Reals], start: float, end: float, resolution: float
) -> list[tuple[float, int]]:
    """Changes of sign on a step; most steps have none, which the series of the function tells at once."""
    if end <= start:
        return []
    values = function(nodes(start, end))
    series = Series.through(values, start, end)
    if series.sign and series.resolved(values, resolution):
        return []
    return crossings(function, start, end, resolution)


def _along(value: Callable[[Reals, Reals], Reals], motion: Callable[[Reals], Reals], times: Reals) -> Reals:
    return np.asarray(value(times, motion(times)))
