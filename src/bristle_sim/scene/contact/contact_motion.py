"""Smooth motion of a tip in contact with the spring of the compliant law, and where within an interval it turns."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from bristle_sim.contact_space.impulse import contact_space
from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.spring import Spring, SpringLoad
from bristle_sim.scene.events.search import guess, interpolate, locate
from bristle_sim.scene.integrate.stepping import Advance, Stepper
from bristle_sim.scene.mechanism import State, Vector

OPENED = 1e-5
"""A contact is over with less than this fraction of its spring's way out left where slip starts or stops: 1e-10 of its
impulse is left, and the force is so small that rounding of the tip's place would start and stop slip without end."""

SAMPLES = 24
"""Least number of intervals that a contact of a given duration is cut into, for its course in time."""

LOCATED = 0.1
"""Fraction of an interval's error in velocity, or of what that makes of the penetration, to which a turn is located."""

PROBE = 0.02
"""Fraction of a contact over which the force that stick takes is extrapolated back to the instant at which slip stops."""

CONE = 1e-9
"""Fraction of friction's limit by which rounding may lead the force in stick beyond it."""

NEAR = 0.1
"""Fraction of a function's range within an interval by which its extreme, estimated from five values, may be off; the cubic
between the states of an interval of 1.4 radians of the fastest motion is off by 1.4^4/384 = 1 % of its amplitude."""

WITHIN = 0.01
"""Fraction of an interval from its ends within which no extreme is looked for: the function hardly moves there."""

QUARTERS = (0.25, 0.5, 0.75)
"""Fractions of an interval at which a function is looked at for an extreme within."""

UNKNOWN = (math.nan,) * 6
"""What a load adds up, where only the state is known."""

TINY = math.ulp(1.0)
"""Velocities and penetrations of scene units to which a turn is located."""


Saved = tuple[State, tuple[bool, float, float]]
"""A state, and whether the spring loads there, the direction of slip, and the force of stick."""


@dataclass(frozen=True, slots=True)
class Turn:
    """A function of the interval whose change of sign ends it, and what the spring does then.

    Attributes:
        value: the function.
        rising: whether rising through zero counts, or falling.
        act: what the spring does then.
        scale: what an error of velocity 1 makes of the function.
    """

    value: Callable[[Advance], float]
    rising: bool
    act: Callable[[], None]
    scale: float = 1.0

    def margin(self, at: Advance) -> float:
        """Return the function, or its negative where it rises: below 0 once it has changed its sign."""
        value = self.value(at)
        return -value if self.rising else value


@dataclass(frozen=True, slots=True)
class Expectation:
    """What is known of a contact before it is integrated.

    Attributes:
        duration: of the contact.
        longest: duration of its longest interval.
        outcome: of the rigid-body law.
        resumes: whether a point that the rigid-body law stops may move again: after a jam, and after stiction of several links;
            never in a contact so short that the bodies do not move meanwhile.
        vibrates: whether several links move meanwhile, so that slip may stop and resume within an interval.
    """

    duration: float
    longest: float
    outcome: str
    resumes: bool
    vibrates: bool = False

    @classmethod
    def of(cls, duration: float, longest: float, outcome: str, links: int) -> Expectation:
        """Return what is expected of a contact of a mechanism of some links."""
        moves = longest * SAMPLES <= 1.5 * duration
        return cls(duration, longest, outcome, moves and (outcome == "jam" or links > 1), moves and links > 1)

    @property
    def moves(self) -> bool:
        """Whether bodies move noticeably while the contact lasts: it is cut into many intervals then."""
        return self.longest * SAMPLES <= 1.5 * self.duration


class ContactMotion:
    """Motion of a scene whose last link's tip is in contact.

    Attributes:
        scene, load, stepper, expected: what is integrated, and how.
        state: the last state that was reached.
        stick_force: tangential force that stick takes there.
    """

    def __init__(self, scene: Scene, state: State, load: SpringLoad, stepper: Stepper, expected: Expectation) -> None:
        """Begin at the first touch."""
        self.scene = scene
        self.state = state
        self.load = load
        self.stepper = stepper
        self.expected = expected
        self.stick_force = 0.0

    @property
    def spring(self) -> Spring:
        """The spring in the phase that the contact is in."""
        return self.load.spring

    @property
    def tip(self) -> Vector:
        """Place of the tip."""
        return self.scene.mechanism.poses(self.state)[-1].tip

    def penetration(self, state: State) -> float:
        """Return the depth of the tip."""
        return self.spring.plane.penetration(self.scene.mechanism.poses(state)[-1].tip)

    def velocity(self, state: State) -> Vector:
        """Return the (normal, tangential) velocity of the tip."""
        return self.spring.plane.components(self.scene.mechanism.poses(state)[-1].tip_velocity)

    def up_to_first(
        self, result: Advance, length: float, turns: Sequence[Turn]
    ) -> tuple[Advance, Callable[[], None] | None]:
        """Return the interval of a length up to what first ends its smooth motion, and what the spring does then, if anything."""
        act: Callable[[], None] | None = None
        again = functools.cache(self.advance)
        beginning = result.totals[4]
        start = Advance(self.state, (), (0.0, 0.0, 0.0, 0.0, beginning, beginning), 0.0)
        for turn in turns:
            margin = turn.margin(result)
            if self.expected.vibrates and margin >= 0.0:
                result, length = self._inside(turn, start, result, length, margin)
                margin = turn.margin(result)
            if margin < 0.0:
                left = turn.value(start)
                before = min(left, -TINY) if turn.rising else max(left, TINY)
                right = -margin if turn.rising else margin
                length = self._located(again, turn, result.state, length, (before, right))
                result, act = again(length), turn.act
        return result, act

    def _inside(self, turn: Turn, start: Advance, result: Advance, length: float, last: float) -> tuple[Advance, float]:
        """Return an interval with its length: up to where a function has changed its sign, if it changes it twice; else all.

        Its least margin is that of the parabola through the least of five margins and the two beside it.
        """
        margins = [turn.margin(start), *(turn.margin(_between(start, result, part)) for part in QUARTERS), last]
        least = min(max(margins.index(min(margins)), 1), 3)
        before, middle, after = margins[least - 1 : least + 2]
        bend, slope = before + after - 2.0 * middle, 0.5 * (after - before)
        at = 0.25 * (least - slope / bend) if bend > 0.0 else 0.0
        if not WITHIN < at < 1.0 - WITHIN or middle - 0.5 * slope**2 / bend > NEAR * (max(margins) - min(margins)):
            return result, length
        part = self.advance(at * length)
        return (part, at * length) if turn.margin(part) < 0.0 else (result, length)

    def _located(
        self, again: Callable[[float], Advance], turn: Turn, end: State, length: float, values: tuple[float, float]
    ) -> float:
        """Return when within the interval of a length to a state a function turns that has these values at its ends."""
        near = guess(lambda state: turn.value(Advance(state, (), UNKNOWN, 0.0)), self.state, end)
        tolerance = max(TINY, LOCATED * self.stepper.noise * turn.scale)
        return locate(lambda span: turn.value(again(span)), 0.0, length, *values, tolerance, near)

    def advance(self, length: float) -> Advance:
        """Return the result of an interval from the state that was reached."""
        return self.stepper.advance(self.scene, self.state, length, self.load)

    def saved(self) -> Saved:
        """Return the state that was reached, and what the spring does there, to return to."""
        return self.state, (self.spring.loading, self.spring.slip, self.stick_force)

    def restore(self, saved: Saved) -> None:
        """Return to a state."""
        self.state, (self.spring.loading, self.spring.slip, self.stick_force) = saved

    def opened(self) -> bool:
        """Whether the spring is as good as at the end of its way out."""
        left = self.penetration(self.state) - self.spring.residual
        return not self.spring.loading and left < OPENED * (self.spring.peak - self.spring.residual)

    def follow_bodies(self) -> None:
        """Let stick use the K of the bodies as they stand; in a contact short enough for the rigid limit it is constant."""
        if self.expected.moves and not self.spring.slip:
            self.scene.place(self.state)
            normal, connected = self.spring.plane.normal, self.scene.connected
            space = contact_space(self.scene.links[-1], self.tip, normal, connected=connected)
            self.spring.follow(space.inverse_mass)

    def stop_slip(self) -> None:
        """Let the point stick where slip has stopped if friction suffices, else slip the way it is driven."""
        spring = self.spring
        spring.slip = 0.0
        self.follow_bodies()
        probe = self.advance(PROBE * min(self.expected.duration, self._quickest())).totals
        self.stick_force = probe[4]
        here = Advance(self.state, (), (0.0, 0.0, 0.0, 0.0, probe[4], probe[4]), 0.0)
        if spring.tangential and self.spare(here) < 0.0:
            self.break_away()

    def break_away(self) -> None:
        """Let the point slip against the force of stick, which is more than friction gives."""
        self.spring.slip = -math.copysign(1.0, self.stick_force)

    def _quickest(self) -> float:
        """Return the time scale of slip, far below the contact's where a heavy link lets the tip hardly out of stick."""
        stiffness, _, _ = self.spring.line()
        most = self.spring.inverse_mass[0, 0] + self.spring.friction * abs(self.spring.coupling)
        return math.pi / math.sqrt(stiffness * most) if stiffness * most else math.inf

    def spare(self, at: Advance) -> float:
        """Return the force by which friction's limit exceeds what stick takes."""
        normal, _ = self.spring.forces(self.penetration(at.state))
        return (1.0 + CONE) * self.spring.friction * normal - abs(at.totals[5])

    def sample(self, *, touches: bool) -> tuple[float, ...]:
        """Return time, normal and tangential force, penetration, normal and tangential velocity."""
        depth = self.penetration(self.state)
        normal, tangential = self.spring.forces(depth) if touches else (0.0, 0.0)
        if not self.spring.slip and touches:
            tangential = self.stick_force
        return (self.state.time, normal, tangential, depth, *self.velocity(self.state))


def _between(start: Advance, end: Advance, part: float) -> Advance:
    """Return an instant within an interval: of cubics through angles and rates, and of a parabola for the force of stick."""
    first, last = end.totals[4:6]
    bend = 3.0 * (first + last) - 6.0 * end.totals[1] / (end.state.time - start.state.time)
    stick = first + part * (last - first) - part * (1.0 - part) * bend
    return Advance(interpolate(start.state, end.state, part), (), (0.0, 0.0, 0.0, 0.0, stick, stick), 0.0)
