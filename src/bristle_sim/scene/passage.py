"""One contact on its way through compression, restitution, slip and stick: smooth stretches, cut where something turns."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact_samples import with_samples_between
from bristle_sim.scene.contact_space import contact_space
from bristle_sim.scene.events import locate
from bristle_sim.scene.mechanism import State, Vector
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.spring import Spring
from bristle_sim.scene.stepping import Advance, Stepper
from bristle_sim.trajectory import ContactHistory, ContactRecord

__all__ = ["SAMPLES", "Passage"]

SAMPLES = 24
"""Least number of stretches that a contact of a given duration is cut into, for its course in time."""

LOCATED = 0.1
"""Share of a stretch's error in velocity, or of what that makes of the penetration, to which a turn is located."""

PROBE = 0.02
"""Share of a contact over which the force that stick takes is extrapolated back to the instant at which slip stops."""

SAME = 1e-5
"""Slip and compression of one degree of freedom stop together: with less than this share of the approach left."""

CONE = 1e-9
"""Share of friction's limit by which rounding may lead the force in stick beyond it."""

LEAST_PHASE = 1e-6
"""A phase of less than this share of the normal impulse is not named. Close to separation nothing holds a point that its
bodies' motion carries along, so that stick always ends in slip; as the contact gets shorter, that has no effect."""

PATIENCE = 10.0
"""A contact that lasts this many times longer than an impact of its speed would is no impact: something presses the
point on. It ends as ``no rebound``, to be held; or where the rigid-body law ends, in a jam or in stiction."""

SHORTEST = 1e-9
"""Stretches shorter than this share of a contact mean that none is short enough: rounding exceeds the tolerance."""

MOST_STRETCHES = 1000
"""A contact that takes more stretches than this is given up."""


@dataclass(frozen=True, slots=True)
class Turn:
    """A function of the stretch whose change of sign ends it, and what the spring does then.

    ``scale`` is what an error of velocity 1 makes of the function.
    """

    value: Callable[[Advance], float]
    rising: bool
    act: Callable[[], None]
    scale: float = 1.0


class Passage:
    """One contact on its way: the state, what has been added up, and the record in time."""

    def __init__(
        self,
        scene: Scene,
        state: State,
        spring: Spring,
        stepper: Stepper,
        times: tuple[float, float],
        expected: str,
    ) -> None:
        """``times`` are the contact's duration and that of its longest stretch; ``expected`` is the rigid outcome."""
        self.scene = scene
        self.state = state
        self.spring = spring
        self.stepper = stepper
        self.duration, self.longest = duration, longest = times
        self.expected = expected
        self.done = ""
        self.most_stretches = max(MOST_STRETCHES, int(4 * duration / stepper.propose(longest)))
        self.turns_meanwhile = self.longest * SAMPLES <= 1.5 * self.duration
        # A single rod comes to rest for good, or goes where its hub goes: no impact.
        self.goes_on = self.turns_meanwhile and (expected == "jam" or len(scene.links) > 1)
        self.phases: list[_Phase] = []
        self.totals = np.zeros(4)
        self.at_compression_end: np.ndarray | None = None
        self.rows: list[tuple[float, ...]] = []
        self.stick_force = 0.0
        self._stop: _Stop | None = None
        if not spring.slip:
            self._settle()
        self._note_phase()
        self._sample()

    def go(self, last: int) -> None:
        """Stretch after stretch until the contact is over, up to so many steps of the scene."""
        try:
            self._go(last)
        except ValueError:
            if self._stop is None:
                raise
        if self._stop is not None and self.done != "rebound":
            self._end_at(self._stop)

    def _go(self, last: int) -> None:
        for _ in range(self.most_stretches):
            if self.done:
                return
            if self.scene.steps > last:
                raise ValueError(
                    "contact: step budget spent before it is over; more steps, less accuracy or a contact_duration that"
                    " is shorter is allowed"
                )
            self._stretch()
        raise ValueError(
            f"contact: not over after {self.most_stretches} stretches of its motion; friction further from the jam, or links'"
            " masses closer to each other, are allowed"
        )

    def _stretch(self) -> None:
        length = self.stepper.propose(self.longest)
        self._follow_bodies()
        result = self._advance(length)
        if not self.stepper.accepts(result, length):
            if length < SHORTEST * self.duration:
                raise ValueError(
                    "contact: no stretch of its motion is short enough for the accuracy asked for; less accuracy, or"
                    " friction further from the jam, is allowed"
                )
            return
        result, act = self._first_turn(result)
        self.state = result.state
        self.totals += result.totals[:4]
        self.stick_force = result.totals[5]
        if act is not None:
            self._sample()
            act()
            self._note_phase()
        self._sample()
        if not self.done and self.state.time - self.rows[0][0] > PATIENCE * self.duration:
            self.done = "no rebound"

    def _first_turn(self, result: Advance) -> tuple[Advance, Callable[[], None] | None]:
        """The stretch up to what first ends its smooth motion, and what the spring does then, if anything."""
        act: Callable[[], None] | None = None
        beginning = result.totals[4]
        start = Advance(self.state, (), (0.0, 0.0, 0.0, 0.0, beginning, beginning), 0.0)
        for turn in self._turns():
            right = turn.value(result)
            if (right > 0.0) if turn.rising else (right < 0.0):
                left = turn.value(start)
                before = min(left, -TINY) if turn.rising else max(left, TINY)
                result, act = self._locate(turn, result.state.time - self.state.time, before, right), turn.act
        return result, act

    def _locate(self, turn: Turn, span: float, left: float, right: float) -> Advance:
        """The state at a turn within a stretch."""
        tried: dict[float, Advance] = {}

        def value(length: float) -> float:
            tried[length] = self._advance(length)
            return turn.value(tried[length])

        tolerance = LOCATED * self.stepper.noise * turn.scale
        found = locate(value, 0.0, span, left, right, max(TINY, tolerance))
        return tried[found] if found in tried else self._advance(found)

    def _advance(self, length: float) -> Advance:
        return self.stepper.advance(self.scene, self.state, length, self.spring)

    def _follow_bodies(self) -> None:
        """Let stick use the K of the bodies as they stand; in a contact short enough for the rigid limit it is constant."""
        if self.turns_meanwhile and not self.spring.slip:
            self.scene.place(self.state)
            tip = self.scene.mechanism.poses(self.state)[-1].tip
            self.spring.follow(contact_space(self.scene.links[-1], tip, self.spring.normal).inverse_mass)

    def _turns(self) -> list[Turn]:
        """What can end the smooth motion that the contact is in."""
        spring = self.spring
        turns: list[Turn] = []
        if spring.loading:
            turns.append(Turn(lambda at: self._velocity(at)[0], True, self._end_compression))
        else:
            depth = self.duration
            turns.append(Turn(lambda at: self._penetration(at) - spring.residual, False, self._separate, depth))
            turns.append(Turn(lambda at: self._penetration(at) - spring.peak, True, self._reload, depth))
        if spring.slip:
            turns.append(Turn(lambda at: spring.slip * self._velocity(at)[1], False, self._settle))
        elif spring.tangential:
            turns.append(Turn(self._spare, False, self._break, spring.stiffness * self.duration))
        return turns

    def _end_compression(self) -> None:
        self.at_compression_end = self.totals.copy()
        spring = self.spring
        spring.unload(self.scene.mechanism.poses(self.state)[-1].tip)
        if spring.coefficients.restitution == 0.0:
            self.done = "no rebound"
            return
        if self.expected == "stiction":
            self._stopped()
        if not spring.slip and not self.done:
            self._settle()

    def _separate(self) -> None:
        self.done = "rebound"

    def _reload(self) -> None:
        self.spring.loading = True
        if not self.spring.slip:
            self._settle()

    def _break(self) -> None:
        """Stick asks for more than friction gives: the point slips against the force that held it."""
        self.spring.slip = -math.copysign(1.0, self.stick_force)

    def _settle(self) -> None:
        """Slip has stopped: the point sticks if friction can hold it, else slips the way it is driven."""
        spring = self.spring
        spring.slip = 0.0
        self._follow_bodies()
        probe = self._advance(PROBE * min(self.duration, self._quickest())).totals
        self.stick_force = probe[4]
        here = Advance(self.state, (), (0.0, 0.0, 0.0, 0.0, probe[4], probe[4]), 0.0)
        if spring.tangential and self._spare(here) < 0.0:
            self._break()
        if not (spring.loading and self.rows):
            return
        stopped = self.expected == "stiction" and not spring.slip
        # Slip and compression of one degree of freedom stop together, up to the motion during the contact.
        if (stopped and not self.goes_on) or -self._now()[0] <= SAME * abs(self.rows[0][4]):
            self._end_compression()
        elif stopped:
            self._stopped()

    def _quickest(self) -> float:
        """Time scale of slip, much shorter than the contact where a heavy link lets the tip hardly out of stick."""
        stiffness, _, _ = self.spring.line()
        most = self.spring.inverse_mass[0, 0] + self.spring.friction * abs(self.spring.coupling)
        return math.pi / math.sqrt(stiffness * most) if stiffness * most else math.inf

    def _now(self) -> Vector:
        return self.spring.components(self.scene.mechanism.poses(self.state)[-1].tip_velocity)

    def _spare(self, at: Advance) -> float:
        """Force by which friction's limit exceeds what stick takes."""
        normal, _ = self.spring.forces(self._penetration(at))
        return (1.0 + CONE) * self.spring.friction * normal - abs(at.totals[5])

    def _penetration(self, at: Advance) -> float:
        return self.spring.penetration(self.scene.mechanism.poses(at.state)[-1].tip)

    def _velocity(self, at: Advance) -> Vector:
        return self.spring.components(self.scene.mechanism.poses(at.state)[-1].tip_velocity)

    def _note_phase(self) -> None:
        if self.done:
            return
        spring = self.spring
        self.phases.append(_Phase(spring.loading, spring.slip, float(self.totals[0])))
        if self.expected == "jam" and not spring.slip and spring.loading:
            self._stopped()

    def _stopped(self) -> None:
        """The rigid-body law ends here without rebound; a contact of a given duration may still find its way out."""
        if not self.goes_on:
            self.done = self.expected
        elif self._stop is None:
            spring = self.spring
            forces = spring.loading, spring.slip, self.stick_force
            self._stop = _Stop(self.state, self.totals.copy(), forces, len(self.rows), len(self.phases))

    def _end_at(self, stop: _Stop) -> None:
        """The contact comes to no end of its own either: it ends where the rigid-body law does."""
        self.done = self.expected
        self.state, self.totals, self.at_compression_end = stop.state, stop.totals, None
        self.spring.loading, self.spring.slip, self.stick_force = stop.forces
        del self.rows[stop.rows :], self.phases[stop.phases :]
        self._sample()

    def _names(self) -> tuple[str, ...]:
        """The phases in order, but for those too short to matter."""
        ends = [*(phase.impulse for phase in self.phases[1:]), float(self.totals[0])]
        least = LEAST_PHASE * float(self.totals[0])
        names: list[str] = []
        first = 0.0
        for phase, end in zip(self.phases, ends, strict=True):
            if end - phase.impulse < least and not (self.done == "jam" and phase is self.phases[-1]):
                continue
            first = first or phase.slip
            motion = "stick" if not phase.slip else "slip" if phase.slip == first else "reverse slip"
            name = f"{'compression' if phase.loading else 'restitution'} {motion}"
            if not names or names[-1] != name:
                names.append(name)
        return tuple(names)

    def _sample(self) -> None:
        pose = self.scene.mechanism.poses(self.state)[-1]
        depth = self.spring.penetration(pose.tip)
        normal, tangential = (0.0, 0.0) if self.done == "rebound" else self.spring.forces(depth)
        if not self.spring.slip and self.done != "rebound":
            tangential = self.stick_force
        self.rows.append((self.state.time, normal, tangential, depth, *self.spring.components(pose.tip_velocity)))

    def record(self, obstacle: Obstacle, before: State, law: str) -> ContactRecord:
        """The ledger entry; works of the spring follow from its energy, friction's is added up step by step."""
        total = self.totals.tolist()
        middle = total if self.at_compression_end is None else self.at_compression_end.tolist()
        rows = np.array(self.rows)
        if not self.turns_meanwhile:
            rows = with_samples_between(rows, self.spring.inverse_mass)
        history = ContactHistory(*np.ascontiguousarray(rows.T))
        first, last = self.rows[0], self.rows[-1]
        return ContactRecord(
            obstacle=obstacle.name,
            law=law,
            outcome=self.done,
            time=before.time,
            duration=self.state.time - before.time,
            impulse=(total[0], total[1]),
            compressive_impulse=(middle[0], middle[1]),
            compressive_work=(middle[2], middle[3]),
            restitutive_work=(total[2] - middle[2], total[3] - middle[3]),
            velocity_before=(first[4], first[5]),
            velocity_after=(last[4], last[5]),
            angles=before.angles,
            rates_before=before.rates,
            rates_after=self.state.rates,
            phases=self._names(),
            history=history,
        )


@dataclass(frozen=True, slots=True)
class _Phase:
    """A phase of the contact: whether the spring loads, direction of slip, and the normal impulse before it."""

    loading: bool
    slip: float
    impulse: float


@dataclass(frozen=True, slots=True)
class _Stop:
    """Where the rigid-body law ends without rebound: state, what had been added up, numbers of samples and phases.

    ``forces``: whether the spring loads, direction of slip, and the force of stick.
    """

    state: State
    totals: NDArray[np.float64]
    forces: tuple[bool, float, float]
    rows: int
    phases: int


TINY = math.ulp(1.0)
"""Velocities and penetrations of scene units to which a turn is located."""
