"""The run of a scene: smooth stretches between events, impacts by law, sustained touch by the engine's own contact.

In flight nothing touches and the engine's contact is off. Where a gap closes, its instant is located and the contact
law resolves the impact. If that leaves the link at rest against the obstacle and pressed on it, the engine's contact
holds it there, with Coulomb friction, until its force has fallen to zero; the instant of release is located too.
Positions of a held link are set back onto the obstacle after every stretch, because the engine's contact only keeps
velocities.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact_laws import Coefficients, ContactLaw, EnergeticLaw
from bristle_sim.scene.events import first_touch, interpolate, locate
from bristle_sim.scene.hold import ELBOW, MOST_GRIP, STILL, EngineHold, elbow, ledger_of_hold, locking, room, set_back
from bristle_sim.scene.mechanism import Pose, State
from bristle_sim.scene.obstacles import Obstacle, Touch
from bristle_sim.scene.stepping import Advance, Stepper
from bristle_sim.scene.watches import Watch, freedom, in_flight, in_touch
from bristle_sim.trajectory import ContactRecord, Event

__all__ = ["Plan", "Recording", "run"]


@dataclass(frozen=True, slots=True)
class Plan:
    """When a run ends and how finely it is recorded; engine units.

    Attributes:
        end: time at which the run stops.
        accuracy: relative accuracy asked for; sets how finely events are located.
        stop_after: name of an event that ends the run.
        longest_stretch: upper bound of the distance between samples.
        maximum_steps: engine steps after which the run gives up.
        retraction_limit: largest angle of the first link relative to the hub, rad.
    """

    end: float
    accuracy: float
    stop_after: str | None = None
    longest_stretch: float = math.inf
    maximum_steps: int = 1_000_000
    retraction_limit: float = math.inf


@dataclass(slots=True)
class Recording:
    """What a run leaves behind, in engine units."""

    states: list[State] = field(default_factory=list)
    forces: list[float] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    contacts: list[ContactRecord] = field(default_factory=list)
    error: float = 0.0
    stop_reason: str = ""
    wall_s: float = 0.0
    cpu_s: float = 0.0
    steps: int = 0


def run(scene: Scene, start: State, stepper: Stepper, law: ContactLaw, plan: Plan) -> Recording:
    """Run a scene from a state to the plan's end.

    Args:
        scene: the scene; its bodies are placed by the run.
        start: the state to start from; obstacles must not be overlapped.
        stepper: how smooth stretches are carried.
        law: how impacts on the workpart are resolved; the bar's are resolved by the energetic law.
        plan: when to stop.

    Raises:
        ValueError: if the start overlaps an obstacle.
    """
    wall, cpu, steps = clock.perf_counter(), clock.process_time(), scene.steps
    runner = _Runner(scene, start, stepper, law, plan)
    runner.go()
    recording = runner.recording
    recording.wall_s, recording.cpu_s = clock.perf_counter() - wall, clock.process_time() - cpu
    recording.steps = scene.steps - steps
    return recording


class _Runner:
    """State of a run: where it is, what it touches, what it has recorded."""

    def __init__(self, scene: Scene, start: State, stepper: Stepper, law: ContactLaw, plan: Plan) -> None:
        self.scene = scene
        self.mechanism = scene.mechanism
        self.stepper = stepper
        self.law = law
        self.plan = plan
        self.state = start
        self.poses: tuple[tuple[State, Pose], ...] = ((start, self.mechanism.poses(start)[-1]),)
        self.before: Advance | None = None
        self.held: Obstacle | None = None
        self.hold: EngineHold | None = None
        self.hold_start = start
        self.hold_sums: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.budget = scene.steps + plan.maximum_steps
        # After a contact the first stretch is short, and then each is at most twice the last: gaps that open
        # slowly are followed closely while they are small.
        self.shortest = min(1e-2, max(1e-5, math.sqrt(plan.accuracy)))
        self.growth = math.inf
        self.releasing = False
        self.force_slope = 0.0
        # A damped spring turns an error of the rate into one of the acceleration.
        damping = scene.effects.damping / scene.mechanism.links[0].inertia_about_joint
        self.noise = max(NOISE, stepper.noise * (1.0 + damping))
        self.departing: Obstacle | None = None
        # What the last rebound was from, when, and how fast.
        self.departure = ("", 0.0, 0.0)
        self.signs = self._known_signs()
        self.recording = Recording()
        self.stopped = False
        self._sample(start, 0.0)
        for obstacle in scene.effects.obstacles:
            self._check_start(obstacle)

    def _check_start(self, obstacle: Obstacle) -> None:
        gap = self._gap(obstacle, self.state)
        if gap < -GAP_ROUNDING:
            raise ValueError(
                f"{obstacle.name}: overlaps the bristle at the start by {-gap:.3g} of its length; no overlap is allowed"
            )

    def go(self) -> None:
        """Run to the end."""
        for obstacle in self.scene.effects.obstacles:
            if abs(self._gap(obstacle, self.state)) <= GAP_ROUNDING and not self.stopped:
                self._start_in_touch(obstacle)
        while not self.stopped:
            if self.state.time >= self.plan.end * (1.0 - 1e-15):
                self._stop("end of the planned time")
            elif self.scene.steps >= self.budget:
                self._stop("step budget spent")
            else:
                self._stretch()
        self._enter_hold(self.recording.stop_reason)

    def _start_in_touch(self, obstacle: Obstacle) -> None:
        if self._touch_of(obstacle, self.state).velocity[0] > 0.0:
            self._depart(obstacle)
        else:
            self._touch(obstacle)

    def _stretch(self) -> None:
        """One accepted stretch, cut short at its first event."""
        room = min(self.plan.end - self.state.time, self.plan.longest_stretch, self.growth, LONGEST)
        length = self.stepper.propose(room)
        result = self._advance(length)
        if result.failed or (self.held is not None and result.totals[0] <= 0.0):
            self._approach_release(length)
            return
        if not self.stepper.accepts(result, length):
            if not math.isfinite(result.error) or length < SHORTEST:
                self._stop("no step is short enough for the accuracy asked for")
            return
        result, act = self._first_event(result)
        self._commit(result)
        if act is not None:
            act(result)

    def _approach_release(self, length: float) -> None:
        """The hold would end within this stretch: come closer to where its force vanishes, or let go."""
        if self.before is None or length <= max(1e-9, 0.1 * self.plan.accuracy):
            self._let_go(self.state)
            return
        self.releasing = True
        predicted = -self.before.totals[0] / self.force_slope if self.force_slope < 0.0 else 0.0
        self.growth = min(0.5 * length, max(0.95 * predicted, length / 16.0))

    def _advance(self, length: float) -> Advance:
        return self.stepper.advance(self.scene, self.state, length, self.hold)

    def _commit(self, result: Advance) -> None:
        length = result.state.time - self.state.time
        state = result.state
        if self.held is not None:
            state = set_back(self.mechanism, self.held, state, self.hold.piece if self.hold else None)
            self.hold_sums = tuple(a + b for a, b in zip(self.hold_sums, result.totals[1:], strict=True))
            if self.before is not None and length > 0.0:
                self.force_slope = (result.totals[0] - self.before.totals[0]) / length
        self.state, self.before = state, result
        self._take_hold()
        if self.departing is not None and self._gap(self.departing, state) > GAP_ROUNDING:
            self.departing = None
        self.recording.error += result.error
        self._sample(state, result.totals[0] if result.totals else 0.0)
        if self.growth != math.inf:
            near = self.releasing and 0.0 < -self.force_slope * 4.0 * length > result.totals[0]
            self.growth = length if near else max(2.0 * length, 0.0 if self.releasing else self.shortest)

    def _sample(self, state: State, force: float) -> None:
        self.recording.states.append(state)
        self.recording.forces.append(force)

    def _first_event(self, result: Advance) -> tuple[Advance, Callable[[Advance], None] | None]:
        """The stretch up to its first event, and what to do there."""
        act: Callable[[Advance], None] | None = None
        if self.before is None and self.growth == math.inf:
            result = self._look_back(result)
        for obstacle in self.scene.effects.obstacles:
            if obstacle is not self.held:
                result, act = self._look_for_touch(obstacle, result, act)
        for watch in self._watches():
            result, act = self._look_for_change(watch, result, act)
        return result, act

    def _look_for_touch(
        self, obstacle: Obstacle, result: Advance, act: Callable[[Advance], None] | None
    ) -> tuple[Advance, Callable[[Advance], None] | None]:
        def touch(_: Advance) -> None:
            self._touch(obstacle)

        length = result.state.time - self.state.time
        if obstacle is self.departing:
            gap, rate = self._gap_and_rate(obstacle, result.state)
            if gap < -GAP_ROUNDING and rate < 0.0:
                # It is back within the shortest stretch: too low a rebound to follow.
                return result, lambda _: self._touch(obstacle, rests=True)
            return result, act
        if self._rests_on(obstacle, result.state):
            return result, act
        share = first_touch(
            self.mechanism,
            lambda state: self._gap_and_rate(obstacle, state),
            self.state,
            result.state,
            self.stepper.stray(self.state, result.state),
        )
        if share is None:
            return result, act
        reached, closed = result if share == 1.0 else self._advance(share * length), share * length
        at_end, rate = self._gap_and_rate(obstacle, reached.state)
        if at_end > 0.0 and rate > 0.0:
            closed, at_end = self._least_gap(obstacle, closed, at_end)
        if at_end > 0.0:
            return reached, None
        at_start = max(self._gap(obstacle, self.state), 1e-300)
        if at_end < 0.0:
            closed = locate(
                lambda span: self._gap(obstacle, self._advance(span).state),
                0.0,
                closed,
                at_start,
                at_end,
                GAP_TOLERANCE,
            )
        return self._advance(closed), touch

    def _rests_on(self, obstacle: Obstacle, end: State) -> bool:
        """Whether the gap of an obstacle beside the one that holds the link is closed and stays so."""
        if self.held is None or abs(self._gap(obstacle, self.state)) > GAP_ROUNDING:
            return False
        later = (interpolate(self.state, end, 0.5), end)
        return all(abs(self._gap(obstacle, state)) <= GAP_ROUNDING for state in later)

    def _least_gap(self, obstacle: Obstacle, span: float, gap: float) -> tuple[float, float]:
        """Where the gap is closed, or else least, in a motion after which it opens: the duration, and the gap."""
        fastest = 1.5 * self.mechanism.speed_bound(self.state)
        left, right = 0.0, span
        while gap <= fastest * (right - left) and max(1.0, fastest) * (right - left) > SHORTEST:
            middle = 0.5 * (left + right)
            gap, rate = self._gap_and_rate(obstacle, self._advance(middle).state)
            if gap < 0.0:
                return middle, gap
            left, right = (middle, right) if rate < 0.0 else (left, middle)
        return right, gap

    def _look_for_change(
        self, watch: Watch, result: Advance, act: Callable[[Advance], None] | None
    ) -> tuple[Advance, Callable[[Advance], None] | None]:
        length = result.state.time - self.state.time
        instant = 1e-15 * (1.0 + result.state.time)
        if length <= instant:
            return result, act
        right = watch.value(result)
        sign = self.signs.get(watch.name)
        noise = max(self.noise, DIFFERENCE / length)
        if abs(right) > noise:
            self.signs[watch.name] = math.copysign(1.0, right)
        if sign is None or sign * right >= 0.0 or abs(right) <= noise:
            return result, act
        if watch.falling is not None and watch.falling != (sign > 0.0):
            return result, act
        left = watch.value(self.before or self._beginning())
        if watch.exact is not None:
            left, right = watch.exact(self.state), watch.exact(result.state)
            if sign * right > 0.0 or sign * left < -noise:
                # It does not change within this stretch, looked at exactly: the differences have misled.
                self.signs[watch.name] = math.copysign(1.0, right)
                return result, act
        duration = self._locate_change(watch, length, sign * max(sign * left, NOISE), right)
        return self._advance(max(duration, instant)), partial(self._notice, watch)

    def _locate_change(self, watch: Watch, length: float, left: float, right: float) -> float:
        """When a value that differs in sign at the two ends of a stretch is zero."""

        def value(span: float) -> float:
            at = self._advance(span)
            return watch.value(at) if watch.exact is None else watch.exact(at.state)

        tolerance = max(1e-3 * self.plan.accuracy * max(abs(left), abs(right)), 0.01 * NOISE)
        self.stepper.begin_afresh()
        return locate(value, 0.0, length, left, right, tolerance)

    def _watches(self) -> list[Watch]:
        """Events other than touches, for what the link is doing now."""
        found = in_flight(self.scene) if self.held is None else in_touch(self.mechanism, self.held, self.state)
        if self.hold is not None:
            found += [locking(self.hold), elbow(self.hold)]
        if math.isfinite(self.plan.retraction_limit):
            found.append(freedom(self.mechanism, self.plan.retraction_limit, self.state))
        return found

    def _look_back(self, result: Advance) -> Advance:
        """Accelerations at the very start, if the first link's, by the cubic, may have changed its sign since."""
        (start, *_), (rate_0, *_) = self.state.angles, self.state.rates
        (end, *_), (rate_1, *_) = result.state.angles, result.state.rates
        length, after = result.state.time - self.state.time, result.accelerations[0]
        before = 6.0 * (end - start) / length - 4.0 * rate_0 - 2.0 * rate_1
        if after * before >= 0.2 * length * after**2:
            return result
        exact = {watch.name: watch.exact(self.state) for watch in self._watches() if watch.exact is not None}
        self.signs |= {name: math.copysign(1.0, value) for name, value in exact.items() if abs(value) > NOISE}
        # The bodies are no longer where the stretch has left them.
        return self._advance(length)

    def _known_signs(self) -> dict[str, float]:
        """Signs that the state alone tells: what changes in the first stretch of a motion is an event, too."""
        here = self._beginning()
        values = [(watch, watch.value(here)) for watch in self._watches()]
        known = {watch.name: math.copysign(1.0, value) for watch, value in values if abs(value) > self.noise}
        return {watch.name: 1.0 for watch, _ in values if watch.final} | known

    def _beginning(self) -> Advance:
        """The state as the end of a stretch of no length."""
        return Advance(self.state, (math.nan,) * len(self.mechanism.links), (), 0.0)

    def _touch_of(self, obstacle: Obstacle, state: State) -> Touch:
        return obstacle.touch(self._pose(state), state.rates[-1])

    def _pose(self, state: State) -> Pose:
        """Of the last link; both ends of a stretch are asked for again and again."""
        for known, pose in self.poses:
            if known is state:
                return pose
        pose = self.mechanism.poses(state)[-1]
        self.poses = (self.poses[-1], (state, pose))
        return pose

    def _gap_and_rate(self, obstacle: Obstacle, state: State) -> tuple[float, float]:
        touch = self._touch_of(obstacle, state)
        return touch.gap, touch.velocity[0]

    def _gap(self, obstacle: Obstacle, state: State) -> float:
        return self._touch_of(obstacle, state).gap

    def _notice(self, watch: Watch, at: Advance) -> None:
        if watch.event is not None:
            self._event(watch.event, at.state.time)
        if watch.final:
            self._stop(watch.name)
        if watch.name == ELBOW and self.held is not None:
            obstacle = self.held
            self._enter_hold(obstacle.name)
            self._touch(obstacle)

    def _event(self, name: str, at: float) -> None:
        self.recording.events.append(Event(name, at))
        if name == self.plan.stop_after:
            self._stop(name)

    def _stop(self, reason: str) -> None:
        self.stopped = True
        self.recording.stop_reason = self.recording.stop_reason or reason

    def _touch(self, obstacle: Obstacle, *, rests: bool = False) -> None:
        """An impact, and what follows it: flight, or being held; ``rests`` takes what is left of the approach."""
        if self.held is not None:
            self._let_go(self.state)
        law = self.law if obstacle.name == "workpart" else EnergeticLaw()
        coefficients = Coefficients.of(obstacle)
        touch = self._touch_of(obstacle, self.state)
        left = self._room(obstacle)
        if rests or left <= STILL or -touch.velocity[0] <= CAPTURE * self.mechanism.speed_bound(self.state):
            law, coefficients = EnergeticLaw(), Coefficients(obstacle.friction, obstacle.restitution_friction, 0.0)
        first = not any(each.obstacle == obstacle.name for each in self.recording.contacts)
        after, record = law.resolve(self.scene, self.state, obstacle, coefficients)
        self.recording.contacts.append(record)
        if record.history is not None:
            self._sample(self.state, 0.0)
        self.state = after
        self._sample(after, 0.0)
        self._event(_touch_event(obstacle.name, first), record.time)
        if record.outcome == "jam" or left < -STILL:
            self._event("jam", after.time)
            self._stop("jam")
        elif record.outcome != "rebound" or self._stays(record):
            self._hold(obstacle)
        else:
            self.departure = obstacle.name, after.time, record.velocity_after[0]
            self._depart(obstacle)

    def _room(self, obstacle: Obstacle) -> float:
        """How fast the room between an obstacle that a single link touches and another one that it touches opens."""
        if len(self.mechanism.links) > 1:
            return math.inf
        touch, rate = self._touch_of(obstacle, self.state), self.state.rates[-1]
        others = [each for each in self.scene.effects.obstacles if each is not obstacle]
        closed = [each for each in others if self._gap(each, self.state) <= GAP_ROUNDING]
        return min((room(touch, self._touch_of(each, self.state), rate) for each in closed), default=math.inf)

    def _stays(self, record: ContactRecord) -> bool:
        """Whether a rebound is too slow to be followed, or so low that fixed steps would repeat it for ever.

        A step drifts before it kicks: a hop under the acceleration a arrives by a h faster than it left, and restitution
        e leaves no less than e a h/(1 - e), the speed of a hop of (1 + e)/(1 - e) steps.
        """
        arrival, rebound = -record.velocity_before[0], record.velocity_after[0]
        if rebound <= CAPTURE * self.mechanism.speed_bound(self.state):
            return True
        hop, step = record.time - self.departure[1], getattr(self.stepper, "step", 0.0)
        if self.departure[0] != record.obstacle or arrival - rebound <= LOSSLESS * arrival:
            return False
        low = rebound**2 * hop <= 2.0 * (arrival + self.departure[2]) * self.stepper.noise
        return low and hop * (arrival - rebound) <= 2.0 * step * (arrival + rebound)

    def _hold(self, obstacle: Obstacle) -> None:
        """Let the engine's contact hold the link from here on."""
        self.held, self.departing = obstacle, None
        self._begin()
        self.state = set_back(self.mechanism, obstacle, self.state)
        self.hold = EngineHold(self.scene, obstacle)
        self.hold_start, self.hold_sums = self.state, (0.0, 0.0, 0.0)
        self._take_hold()

    def _take_hold(self) -> None:
        """Have the engine's contact act from the state that has been reached, if it can."""
        if self.hold is None:
            return
        grip = self.hold.engage(self.state)
        if grip <= 0.0:
            self._event("jam", self.state.time)
            self._stop("jam")
        elif grip > MOST_GRIP:
            self._stop(f"{self.hold.obstacle.name} friction too high for the engine's contact")

    def _let_go(self, state: State) -> None:
        """The contact's force has fallen to zero."""
        assert self.held is not None
        obstacle = self.held
        self.state = state
        self._enter_hold("release")
        self._event(f"{obstacle.name} release", state.time)
        self._depart(obstacle)

    def _enter_hold(self, outcome: str) -> None:
        """End the hold, if there is one, and enter it in the ledger."""
        if self.held is None:
            return
        self.scene.release(self.held)
        if self.state.time > self.hold_start.time:
            record = ledger_of_hold(self.mechanism, self.held, self.hold_start, self.state, self.hold_sums, outcome)
            self.recording.contacts.append(record)
        self.held = self.hold = None

    def _depart(self, obstacle: Obstacle) -> None:
        self.departing = obstacle
        self._begin()

    def _begin(self) -> None:
        """A new smooth motion begins: nothing of the last one's accelerations and signs holds."""
        self.before, self.growth, self.releasing, self.force_slope = None, self.shortest, False, 0.0
        self.signs = self._known_signs()


def _touch_event(obstacle: str, first: bool) -> str:
    return f"{obstacle} touch" if obstacle != "workpart" else "strike" if first else "workpart touch"


GAP_ROUNDING = 1e-11
"""A gap of the scene's unit below this is closed."""

GAP_TOLERANCE = 1e-13
"""To which a touch is located: rounding of an extrapolated stretch is of this size, and a closer search would not end."""

SHORTEST = 1e-13
"""A stretch shorter than this share of the scene's time unit means that no stretch is short enough. A motion of that
share of the scene's length, too, is an instant."""

LONGEST = 1.0
"""Of a stretch, in the scene's time units: within a radian of the fastest motion each thing that is looked out for
changes its sign once at most, and the cubic through the ends is good to 1/384 of the motion."""

NOISE = 1e-10
"""Rates, accelerations and forces of a scene's units below this have no sign, however accurate the stepper is."""

DIFFERENCE = 1e-13
"""Rounding of the difference of two rates that an acceleration is made of."""

LOSSLESS = 1e-12
"""Share of the speed that an impact may lose by rounding."""

CAPTURE = 1e-8
"""An impact slower than this share of the fastest point's speed takes the rest of the approach away: repeated taps of
a restitution below 1 add up in finite time."""
