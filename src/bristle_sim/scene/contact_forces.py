"""The forces of the engine's own contacts, as a load that adds them up."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from bristle_sim.scene.arbiters import pushes
from bristle_sim.scene.build import Scene
from bristle_sim.scene.obstacles import MARGIN, Obstacle
from bristle_sim.scene.sustained_contact import Sustained

if TYPE_CHECKING:
    from bristle_sim.scene.wire_velocities import Held


PULL = 1e-14
"""Impulse of a step, in the scene's unit, below which a pull is rounding."""


class ContactForces:
    """The engine's own contacts as a load: they act by themselves, and are lost once their forces are gone.

    Attributes:
        scene: of the contacts.
        obstacles: the pairs in contact.
        reached: totals of the last interval.
        held: the contacts of wires that bend, whose forces are solved for with their joints.
    """

    def __init__(self, scene: Scene, obstacles: Sequence[Obstacle]) -> None:
        """Nothing has been added up yet."""
        self.scene = scene
        self.obstacles = tuple(obstacles)
        self.reached: Sequence[float] = ()
        self.held: Sequence[Held] = ()
        self._last = [(0.0, 0.0, 0.0)] * len(self.obstacles)
        self._pushes_back = any(each.partner is not None and each.friction for each in obstacles)
        self._sums: list[float] = []
        self._step = 0.0
        self._pulls: dict[int, float] = {}
        self._due = False
        # A push alone, of one contact, is read once an interval.
        alone = scene.wires is None and len(obstacles) == 1 and not obstacles[0].friction
        self._record = scene.contacts.record(obstacles[0]) if alone else None
        self._stale = 0

    def hold(self, pieces: Sequence[int | None], slips: Sequence[int | None]) -> None:
        """Have the wires' own solver keep the contacts closed, with these straight pieces and senses of slip."""
        from bristle_sim.scene.wire_velocities import Held

        self.held = tuple(Held(*each) for each in zip(self.obstacles, pieces, slips, strict=True))

    def begin(self, step: float) -> Callable[[], None]:
        """Forget what was added up; return what adds up, before each step, what the engine did in the step before."""
        if step != self._step and not self.held:
            self.scene.warm_up(step)
        self._step = step
        if self._record is not None:
            # What was before it is noted here, and before the first step once more.
            self._stale = 2 * self._record.begin()
            return self._record.note
        count = len(self.obstacles)
        self._sums, self._last, self._due = [0.0] * (3 * count), [(0.0, 0.0, 0.0)] * count, False
        self._pulls = {}
        if self.scene.wires is not None:
            self.scene.wires.contacts = self.held
        return self._apply

    def _apply(self) -> None:
        """Add up what the engine, which acts by itself, did in the step before."""
        if self._due:
            self._add()
        self._due = True
        if self._pushes_back and not self.held:
            for obstacle, (_, rub, _) in zip(self.obstacles, self._last, strict=True):
                if obstacle.partner is not None:
                    # The partner's shape is larger than it, which lengthens the lever of friction on it.
                    self.scene.links[obstacle.partner].torque -= MARGIN * rub / self._step

    def totals(self) -> list[float]:
        """Return each contact's normal force in the last step, then its normal and tangential impulse and friction's work.

        Where an earlier step pulled on a wire that bends, the normal force is that pull, so that the contact is released.
        The tangential forces in the last step follow for several links, where friction may make a contact stick.
        """
        if self._record is not None:
            self._record.note()
            found = pushes(self._record.read()[self._stale :])
            force = found[-1] / self._step if found else 0.0
            return [force, sum(found)] + [0.0] * (2 if len(self.scene.links) == 1 else 3)
        self._add()
        if self.scene.wires is not None:
            self.scene.wires.contacts = ()
        step = self._step
        found = [self._pulls.get(index, each[0]) / step for index, each in enumerate(self._last)] + self._sums
        return found if len(self.scene.links) == 1 else found + [each[1] / step for each in self._last]

    def fails(self, totals: list[float]) -> bool:
        """Return whether a contact would have to pull."""
        return min(self.normal(totals)) <= 0.0

    def normal(self, totals: Sequence[float]) -> Sequence[float]:
        """Return the contacts' normal forces from the totals."""
        return totals[: len(self.obstacles)]

    def spare_friction(self, totals: Sequence[float], index: int) -> float:
        """Return by how much friction's limit exceeds the tangential force of a contact."""
        return self.obstacles[index].friction * totals[index] - abs(totals[4 * len(self.obstacles) + index])

    def driven(self, totals: Sequence[float], index: int) -> int:
        """Return the sense in which a contact that sticks would slip."""
        return -1 if totals[4 * len(self.obstacles) + index] > 0.0 else 1

    def share_out(self, totals: Sequence[float], sustained: Sequence[Sustained], length: float) -> None:
        """Add what was added up in an interval to the contacts' own sums."""
        count, self.reached = len(self.obstacles), totals
        for index, each in enumerate(sustained):
            each.add(totals[index], totals[count + 3 * index : count + 3 * index + 3], length)

    def _add(self) -> None:
        sums, last, wires = self._sums, self._last, self.scene.wires
        for index, obstacle in enumerate(self.obstacles):
            found = self.scene.contacts.totals(obstacle) if wires is None else wires.impulses[index]
            push, rub, slip = last[index] = found
            if push < -PULL:
                self._pulls[index] = push
            sums[3 * index] += push
            if obstacle.friction:
                sums[3 * index + 1] += rub
                sums[3 * index + 2] += rub * slip
