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
from functools import partial

from bristle_sim.scene.build import Scene
from bristle_sim.scene.changes import Changes
from bristle_sim.scene.contact_laws import Coefficients, ContactLaw, EnergeticLaw
from bristle_sim.scene.gaps import GAP_ROUNDING, Gaps
from bristle_sim.scene.hold import (
    ELBOW,
    MOST_GRIP,
    STILL,
    EngineHold,
    elbow,
    ledger_of_hold,
    locking,
    room,
    set_back,
)
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.plan import Plan, Recording
from bristle_sim.scene.stepping import Advance, Stepper
from bristle_sim.scene.touch_search import SHORTEST, Stretch, find_touch
from bristle_sim.scene.watches import Watch, freedom, in_flight, in_touch
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactRecord, Event

__all__ = ["run"]


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


Act = Callable[[Advance], None]
"""What to do where an event has cut a stretch short."""


class _Runner:
    """State of a run: where it is, what it touches, what it has recorded."""

    def __init__(self, scene: Scene, start: State, stepper: Stepper, law: ContactLaw, plan: Plan) -> None:
        self.scene = scene
        self.mechanism = scene.mechanism
        self.stepper = stepper
        self.law = law
        self.plan = plan
        self.state = start
        self.gaps = Gaps(self.mechanism, start)
        self.before: Advance | None = None
        self.held: Obstacle | None = None
        self.hold: EngineHold | None = None
        self.hold_start = start
        self.hold_sums: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.budget = scene.work + plan.maximum_steps
        # After a contact the first stretch is short, and then each is at most twice the last: gaps that open
        # slowly are followed closely while they are small.
        self.shortest = min(1e-2, max(1e-5, math.sqrt(plan.accuracy)))
        self.growth = math.inf
        self.releasing = False
        self.force_slope = 0.0
        self.departing: Obstacle | None = None
        # What the last rebound was from, when, and how fast.
        self.departure = ("", 0.0, 0.0)
        self.changes = Changes(scene, stepper, plan.accuracy)
        self.changes.begin(start, self._watches())
        self.recording = Recording()
        self.stopped = False
        self._sample(start, 0.0)
        for obstacle in scene.effects.obstacles:
            self._check_start(obstacle)

    def _check_start(self, obstacle: Obstacle) -> None:
        gap = self.gaps.gap(obstacle, self.state)
        if gap < -GAP_ROUNDING:
            raise ValueError(
                f"{obstacle.name}: overlaps the bristle at the start by {-gap:.3g} of its length; no overlap is allowed"
            )

    def go(self) -> None:
        """Run to the end."""
        for obstacle in self.scene.effects.obstacles:
            if abs(self.gaps.gap(obstacle, self.state)) <= GAP_ROUNDING and not self.stopped:
                self._start_in_touch(obstacle)
        while not self.stopped:
            if self.state.time >= self.plan.end * (1.0 - 1e-15):
                self._stop(StopReason.END)
            elif self.scene.work >= self.budget:
                self._stop(StopReason.STEP_BUDGET)
            else:
                self._stretch()
        self._enter_hold(str(self.recording.stop_reason))

    def _start_in_touch(self, obstacle: Obstacle) -> None:
        if self.gaps.touch(obstacle, self.state).velocity[0] > 0.0:
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
                self._stop(StopReason.ACCURACY)
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
        if self.departing is not None and self.gaps.gap(self.departing, state) > GAP_ROUNDING:
            self.departing = None
        self.recording.error += result.error
        self._sample(state, result.totals[0] if result.totals else 0.0)
        if self.growth != math.inf:
            near = self.releasing and 0.0 < -self.force_slope * 4.0 * length > result.totals[0]
            self.growth = length if near else max(2.0 * length, 0.0 if self.releasing else self.shortest)

    def _sample(self, state: State, force: float) -> None:
        self.recording.states.append(state)
        self.recording.forces.append(force)

    def _first_event(self, result: Advance) -> tuple[Advance, Act | None]:
        """The stretch up to its first event, and what to do there."""
        act: Act | None = None
        if (
            self.before is None
            and self.growth == math.inf
            and self.changes.look_back(self._to(result), self._watches())
        ):
            # The bodies are no longer where the stretch has left them.
            result = self._advance(self._to(result).length)
        for obstacle in self.scene.effects.obstacles:
            if obstacle is not self.held:
                result, act = self._look_for_touch(obstacle, result, act)
        for watch in self._watches():
            changed = self.changes.find(watch, self._to(result), self.before)
            if changed is not None:
                result, act = changed, partial(self._notice, watch)
        return result, act

    def _to(self, end: Advance) -> Stretch:
        return Stretch(self.state, end, self._advance)

    def _look_for_touch(self, obstacle: Obstacle, result: Advance, act: Act | None) -> tuple[Advance, Act | None]:
        """The stretch cut short where it comes nearest to an obstacle, and what to do there if it touches."""
        if obstacle is self.departing:
            gap, rate = self.gaps.gap_and_rate(obstacle, result.state)
            if gap < -GAP_ROUNDING and rate < 0.0:
                hop = self._hop(obstacle, result) if gap < -self.plan.accuracy else None
                if hop is not None:
                    return hop, None
                # It is back within the shortest stretch: too low a rebound to follow.
                return result, lambda _: self._touch(obstacle, rests=True)
            return result, act
        if self.held is not None and self.gaps.rests(obstacle, self.state, result.state):
            return result, act
        stray = self.stepper.stray(self.state, result.state)
        found = find_touch(self._to(result), self.gaps, obstacle, stray)
        if found is None:
            return result, act
        reached, closed = found
        return reached, (lambda _: self._touch(obstacle)) if closed else None

    def _hop(self, obstacle: Obstacle, result: Advance) -> Advance | None:
        """The rise of a rebound that is back, deep inside, at the end of the stretch; None if it is too short."""
        stretch = self._to(result)
        span = 0.5 * stretch.length
        while span > LEAST_HOP * stretch.length:
            risen = stretch.again(span)
            if self.gaps.gap(obstacle, risen.state) > GAP_ROUNDING:
                return risen
            span *= 0.5
        return None

    def _watches(self) -> list[Watch]:
        """Events other than touches, for what the link is doing now."""
        found = in_flight(self.scene) if self.held is None else in_touch(self.mechanism, self.held, self.state)
        if self.hold is not None:
            found += [locking(self.hold), elbow(self.hold)]
        if math.isfinite(self.plan.retraction_limit):
            found.append(freedom(self.mechanism, self.plan.retraction_limit, self.state))
        return found

    def _notice(self, watch: Watch, at: Advance) -> None:
        if watch.event is not None:
            self._event(watch.event, at.state.time)
        if watch.final is not None:
            self._stop(watch.final)
        if watch.name == ELBOW and self.held is not None:
            obstacle = self.held
            self._enter_hold(obstacle.name)
            self._touch(obstacle)

    def _event(self, name: str, at: float) -> None:
        self.recording.events.append(Event(name, at))
        if name == self.plan.stop_after:
            self._stop(FINAL.get(name, StopReason.EVENT))

    def _stop(self, reason: StopReason) -> None:
        self.stopped = True
        self.recording.stop_reason = self.recording.stop_reason or reason

    def _touch(self, obstacle: Obstacle, *, rests: bool = False) -> None:
        """An impact, and what follows it: flight, or being held; ``rests`` takes what is left of the approach."""
        if self.held is not None:
            self._let_go(self.state)
        law = self.law if obstacle.name == "workpart" else EnergeticLaw()
        coefficients = Coefficients.of(obstacle)
        touch = self.gaps.touch(obstacle, self.state)
        left = self._room(obstacle)
        if rests or left <= STILL or -touch.velocity[0] <= CAPTURE * self.mechanism.speed_bound(self.state):
            law, coefficients = EnergeticLaw(), Coefficients(obstacle.friction, obstacle.restitution_friction, 0.0)
        first = not any(each.obstacle == obstacle.name for each in self.recording.contacts)
        try:
            after, record = law.resolve(self.scene, self.state, obstacle, coefficients)
        except ValueError:
            if first:
                raise
            self._stop(StopReason.UNRESOLVED)
            return
        self.recording.contacts.append(record)
        if record.history is not None:
            self._sample(self.state, 0.0)
        self.state = after
        self._sample(after, 0.0)
        jams = record.outcome == "jam" or left < -STILL
        if jams:
            self._stop(StopReason.JAM)
        self._event(_touch_event(obstacle.name, first), record.time)
        if jams:
            self._event("jam", after.time)
        elif record.outcome != "rebound" or self._stays(record):
            self._hold(obstacle)
        else:
            self.departure = obstacle.name, after.time, record.velocity_after[0]
            self._depart(obstacle)

    def _room(self, obstacle: Obstacle) -> float:
        """How fast the room between an obstacle that a single link touches and another one that it touches opens."""
        if len(self.mechanism.links) > 1:
            return math.inf
        touch, rate = self.gaps.touch(obstacle, self.state), self.state.rates[-1]
        others = [each for each in self.scene.effects.obstacles if each is not obstacle]
        closed = [each for each in others if self.gaps.gap(each, self.state) <= GAP_ROUNDING]
        return min((room(touch, self.gaps.touch(each, self.state), rate) for each in closed), default=math.inf)

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
            self._stop(StopReason.JAM)
        elif grip > MOST_GRIP:
            self._stop(StopReason.FRICTION)

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
        self.changes.begin(self.state, self._watches())


def _touch_event(obstacle: str, first: bool) -> str:
    return f"{obstacle} touch" if obstacle != "workpart" else "strike" if first else "workpart touch"


FINAL = {"jam": StopReason.JAM, "retraction limit": StopReason.RETRACTION_LIMIT}
"""Events after which nothing goes on, requested or not."""

LONGEST = 1.0
"""Of a stretch, in the scene's time units: within a radian of the fastest motion each thing that is looked out for
changes its sign once at most, and the cubic through the ends is good to 1/384 of the motion."""

LOSSLESS = 1e-12
"""Share of the speed that an impact may lose by rounding."""

LEAST_HOP = 1e-6
"""Share of a stretch within which a rebound that is shorter is taken for none."""

CAPTURE = 1e-8
"""An impact slower than this share of the fastest point's speed takes the rest of the approach away: repeated taps of
a restitution below 1 add up in finite time."""
