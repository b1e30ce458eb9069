"""One contact on its way through compression, restitution, slip and stick: smooth stretches, cut where something turns."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact_samples import with_samples_between
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
"""Share of a contact in which the motion shows where slip goes on that has stopped."""

SAME = 1e-5
"""Share of the normal force's drive below which rounding tells slip from stick."""

PATIENCE = 10.0
"""A contact that lasts this many times longer than an impact of its speed would is no impact: something presses the
point on. It ends as ``no rebound``, to be held."""

SHORTEST = 1e-9
"""Stretches shorter than this share of a contact mean that none is short enough: rounding exceeds the tolerance."""

MOST_STRETCHES = 1000
"""A contact that takes more stretches than this is given up."""


@dataclass(frozen=True, slots=True)
class Turn:
    """A function of the stretch whose change of sign ends it, and what the spring does then."""

    value: Callable[[Advance], float]
    rising: bool
    act: Callable[[], None]
    of_velocity: bool = True


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
        self.phases: list[str] = []
        self.totals = np.zeros(4)
        self.at_compression_end: np.ndarray | None = None
        self.rows: list[tuple[float, ...]] = []
        self.first_slip = spring.slip
        if not spring.slip:
            self._settle()
        self._note_phase()
        self._sample()

    def go(self, last: int) -> None:
        """Stretch after stretch until the contact is over, up to so many steps of the scene."""
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
        result = self._advance(length)
        if not self.stepper.accepts(result, length):
            if length < SHORTEST * self.duration:
                raise ValueError(
                    "contact: no stretch of its motion is short enough for the accuracy asked for; less accuracy, or"
                    " friction further from the jam, is allowed"
                )
            return
        act: Callable[[], None] | None = None
        for turn in self._turns():
            span = result.state.time - self.state.time
            right = turn.value(result)
            left = turn.value(Advance(self.state, (), (), 0.0))
            if (right > 0.0) if turn.rising else (right < 0.0):
                before = min(left, -TINY) if turn.rising else max(left, TINY)
                result, act = self._locate(turn, span, before, right), turn.act
        self.state = result.state
        self.totals += result.totals
        if act is None and not self._holds(result):
            act = self._settle
        if act is not None:
            self._sample()
            act()
            self._note_phase()
        self._sample()
        if not self.done and self.state.time - self.rows[0][0] > PATIENCE * self.duration:
            self.done = "no rebound"

    def _locate(self, turn: Turn, span: float, left: float, right: float) -> Advance:
        """The state at a turn within a stretch."""
        tried: dict[float, Advance] = {}

        def value(length: float) -> float:
            tried[length] = self._advance(length)
            return turn.value(tried[length])

        tolerance = LOCATED * self.stepper.noise * (1.0 if turn.of_velocity else self.duration)
        found = locate(value, 0.0, span, left, right, max(TINY, tolerance))
        return tried[found] if found in tried else self._advance(found)

    def _advance(self, length: float) -> Advance:
        return self.stepper.advance(self.scene, self.state, length, self.spring)

    def _turns(self) -> list[Turn]:
        """What can end the smooth motion that the contact is in."""
        spring = self.spring
        turns: list[Turn] = []
        if spring.loading:
            turns.append(Turn(lambda at: self._velocity(at)[0], True, self._end_compression))
        else:
            turns.append(Turn(lambda at: self._penetration(at) - spring.residual, False, self._separate, False))
            turns.append(Turn(lambda at: self._penetration(at) - spring.peak, True, self._reload, False))
        if spring.slip:
            turns.append(Turn(lambda at: spring.slip * self._velocity(at)[1], False, self._settle))
        return turns

    def _end_compression(self) -> None:
        self.at_compression_end = self.totals.copy()
        spring = self.spring
        spring.unload(self.scene.mechanism.poses(self.state)[-1].tip)
        if spring.coefficients.restitution == 0.0:
            self.done = "no rebound"
        elif self.expected == "stiction":
            self.done = "stiction"
        elif not spring.slip:
            self._settle()

    def _separate(self) -> None:
        self.done = "rebound"

    def _reload(self) -> None:
        self.spring.loading = True

    def _settle(self) -> None:
        """Slip has stopped: it goes on in a direction in which friction cannot hold the point, else the point sticks."""
        spring = self.spring
        first = math.copysign(1.0, spring.coupling)
        for direction in (first, -first):
            spring.slip = direction
            after = self._advance(PROBE * min(self.duration, self._quickest()))
            if direction * self._velocity(after)[1] > SAME * abs(spring.coupling) * after.totals[0]:
                break
        else:
            spring.slip = 0.0
        stopped = self.expected == "stiction" and not spring.slip
        if spring.loading and self.rows and (stopped or -self._now()[0] <= SAME * abs(self.rows[0][4])):
            # Slip and compression of one degree of freedom stop together, up to the motion during the contact.
            self._end_compression()

    def _quickest(self) -> float:
        """Time scale of slip, much shorter than the contact where a heavy link lets the tip hardly out of stick."""
        stiffness, _, _ = self.spring.line()
        most = self.spring.inverse_mass[0, 0] + self.spring.friction * abs(self.spring.coupling)
        return math.pi / math.sqrt(stiffness * most) if stiffness * most else math.inf

    def _now(self) -> Vector:
        return self.spring.components(self.scene.mechanism.poses(self.state)[-1].tip_velocity)

    def _holds(self, result: Advance) -> bool:
        """Whether what stick takes of a stretch is what friction can give."""
        normal, tangential = result.totals[:2]
        return bool(self.spring.slip) or abs(tangential) <= (1.0 + 1e-6) * self.spring.friction * normal

    def _penetration(self, at: Advance) -> float:
        return self.spring.penetration(self.scene.mechanism.poses(at.state)[-1].tip)

    def _velocity(self, at: Advance) -> Vector:
        return self.spring.components(self.scene.mechanism.poses(at.state)[-1].tip_velocity)

    def _note_phase(self) -> None:
        if self.done:
            return
        slip = self.spring.slip
        self.first_slip = self.first_slip or slip
        motion = "stick" if not slip else "slip" if slip == self.first_slip else "reverse slip"
        name = f"{'compression' if self.spring.loading else 'restitution'} {motion}"
        if not self.phases or self.phases[-1] != name:
            self.phases.append(name)
        if self.expected == "jam" and not slip and self.spring.loading:
            self.done = "jam"

    def _sample(self) -> None:
        pose = self.scene.mechanism.poses(self.state)[-1]
        depth = self.spring.penetration(pose.tip)
        normal, tangential = (0.0, 0.0) if self.done == "rebound" else self.spring.forces(depth)
        self.rows.append((self.state.time, normal, tangential, depth, *self.spring.components(pose.tip_velocity)))

    def record(self, obstacle: Obstacle, before: State, law: str) -> ContactRecord:
        """The ledger entry; works of the spring follow from its energy, friction's is added up step by step."""
        total = self.totals.tolist()
        middle = total if self.at_compression_end is None else self.at_compression_end.tolist()
        rows = np.array(self.rows)
        if self.longest * SAMPLES > 1.5 * self.duration:
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
            phases=tuple(self.phases),
            history=history,
        )


TINY = math.ulp(1.0)
"""Velocities and penetrations of scene units to which a turn is located."""
