"""The forces of sustained contacts, as a load that adds them up: the engine's own of a lone link, those solved for of several."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.arbiters import pushes
from bristle_sim.scene.contact.obstacles import Obstacle

if TYPE_CHECKING:
    from bristle_sim.scene.contact.sustained import Sustained

PULL = 1e-14
"""Impulse of a step, in the scene's unit, below which a pull is rounding."""


class ContactForces(ABC):
    """Forces of sustained contacts, which are lost once one of them is gone.

    The totals are each contact's normal force in the last step, then its normal and tangential impulse and friction's work; of
    several links, which friction may stop, the tangential forces in the last step follow.

    Attributes:
        scene: of the contacts.
        obstacles: the pairs in contact.
        reached: totals of the last interval.
    """

    symmetric = True

    def __init__(self, scene: Scene, obstacles: Sequence[Obstacle]) -> None:
        """Nothing has been added up yet."""
        self.scene = scene
        self.obstacles = tuple(obstacles)
        self.reached: Sequence[float] = ()
        self._step = 0.0
        self._sums: list[float] = []
        self._due = False

    def begin(self, step: float) -> Callable[[], None]:
        """Forget what was added up; return what adds up, before each step, what was done in the step before."""
        self._step, self._due = step, False
        self._sums = [0.0] * (3 * len(self.obstacles))
        return self._apply

    @abstractmethod
    def totals(self) -> list[float]:
        """Return what was added up, with the last step."""

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

    def _apply(self) -> None:
        if self._due:
            self._add()
        self._due = True

    @abstractmethod
    def _add(self) -> None:
        """Add up what was done in the step before."""

    def _add_up(self, index: int, push: float, rub: float, slip: float) -> None:
        self._sums[3 * index] += push
        self._sums[3 * index + 1] += rub
        self._sums[3 * index + 2] += rub * slip


class EngineForces(ContactForces):
    """The engine's own contact of a lone link, which acts by itself."""

    def __init__(self, scene: Scene, obstacles: Sequence[Obstacle]) -> None:
        """Nothing has been added up yet."""
        super().__init__(scene, obstacles)
        (self._obstacle,) = obstacles
        # A push alone is read once an interval.
        self._record = None if self._obstacle.friction else scene.contacts.record(self._obstacle)
        self._stale, self._push = 0, 0.0

    def begin(self, step: float) -> Callable[[], None]:
        """Forget what was added up; return what notes, before each step, what the engine did in the step before."""
        if step != self._step:
            self.scene.warm_up(step)
        if self._record is None:
            return super().begin(step)
        self._step = step
        # What was before it is noted here, and before the first step once more.
        self._stale = 2 * self._record.begin()
        return self._record.note

    def totals(self) -> list[float]:
        """Return what was added up, with the last step."""
        if self._record is None:
            self._add()
            return [self._push / self._step, *self._sums]
        self._record.note()
        found = pushes(self._record.read()[self._stale :])
        return [found[-1] / self._step if found else 0.0, sum(found), 0.0, 0.0]

    def _add(self) -> None:
        self._push, rub, slip = self.scene.contacts.totals(self._obstacle)
        self._add_up(0, self._push, rub, slip)


class SolvedForces(ContactForces):
    """Contacts of several links, whose forces are solved for with their joints.

    In steps symmetric in time the forces of odd and even ones differ by an error that the mean of two does not have.
    """

    def __init__(self, scene: Scene, obstacles: Sequence[Obstacle]) -> None:
        """Nothing has been added up yet."""
        super().__init__(scene, obstacles)
        self._pulls: dict[int, float] = {}
        self._last = self._mean = np.zeros((0, 2))
        self._odd = False

    def begin(self, step: float) -> Callable[[], None]:
        """Forget what was added up; return what adds up, before each step, what was done in the step before."""
        self._pulls, self._odd = {}, False
        return super().begin(step)

    def totals(self) -> list[float]:
        """Return what was added up, with the last step.

        Where earlier steps pulled, the normal force is that pull, so that the contact is released.
        """
        self._add()
        pushes, rubs = (self._mean / self._step).T.tolist()
        normal = [self._pulls.get(index, push) for index, push in enumerate(pushes)]
        return [*normal, *self._sums, *rubs]

    def _add(self) -> None:
        impulses = np.array(self.scene.joint_solver.impulses)
        self._odd = not self._odd
        self._mean = impulses[:, :2] if self._odd else 0.5 * (self._last + impulses[:, :2])
        self._last = impulses[:, :2]
        for index, (push, rub, slip) in enumerate(impulses.tolist()):
            if not self._odd and self._mean[index, 0] < -PULL:
                self._pulls[index] = self._mean[index, 0] / self._step
            self._add_up(index, push, rub, slip)
