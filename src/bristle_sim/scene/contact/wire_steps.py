"""Engine steps of several links, whose joints and sustained contacts are solved for where the engine's iterations are dear."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from operator import sub
from typing import TYPE_CHECKING

import pymunk

from bristle_sim.scene.contact.obstacles import Held
from bristle_sim.scene.engine import EngineSteps

if TYPE_CHECKING:
    from bristle_sim.scene.contact.solver import WireVelocities


LINKS_OF_A_STEP = 32
"""Links whose solve counts as one step: measured, 17, 21, 31 and 60 us for 8, 16, 32 and 64 links."""


def _nothing() -> None:
    """Do nothing before a step."""


class WireSteps(EngineSteps):
    """Engine steps, each followed by a linear solve: always of wires that bend, of rigid links in sustained contact only."""

    def __init__(
        self,
        space: pymunk.Space,
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
        joints: Sequence[pymunk.Constraint],
        solver: Callable[[], WireVelocities],
        *,
        bending: bool,
    ) -> None:
        """Leave the joints to the engine until the iterations are set; the solver is made when it is first needed."""
        super().__init__(space, hub, links, joints)
        self._make, self._bending = solver, bending
        self._wires: WireVelocities | None = None
        self._engine_step = self._step

    @property
    def joint_solver(self) -> WireVelocities:
        """The solver."""
        if self._wires is None:
            self._wires = self._make()
        return self._wires

    @property
    def take_symmetric(self) -> Callable[..., list[float]] | None:
        """What takes steps symmetric in time, while the joints are solved for."""
        return None if self._step is self._engine_step else self._take_symmetric

    def set_iterations(self, count: int) -> None:
        """Have the engine's solver take this many iterations in every step; one leaves the joints of bending wires to theirs."""
        super().set_iterations(count)
        self._price = max(self._price, math.ceil(len(self._links) / LINKS_OF_A_STEP))
        self._always = self._bending and count == 1
        self.hold(())
        if self._bending:
            self._last_length = 0.0

    def hold(self, contacts: Sequence[Held]) -> None:
        """Have these sustained contacts solved for from now on, together with the joints; none leaves them as in flight."""
        active = bool(contacts) or self._always
        self._step = self._step_and_solve if active else self._engine_step
        if active or self._wires is not None:
            self.joint_solver.contacts = contacts
            self.joint_solver.take_over(active=active)

    def _step_and_solve(self, length: float) -> None:
        self._engine_step(length)
        self.joint_solver.solve(length)

    def _take_symmetric(self, length: float, count: int, act: Callable[[], None] = _nothing) -> list[float]:
        """Take an even number of steps symmetric in time from where the bodies were half a step ago; return as ``take`` does.

        After odd numbers of steps the links have an error of their own. The accelerations are those of the last two steps.
        """
        self.steps += count
        self.work += count * self._price
        with self.joint_solver.symmetric_steps():
            for left in range(count, 0, -1):
                if left == 2:
                    before = self.rates()
                act()
                self._step(length)
        after = self.rates()
        angles = [angle + 0.5 * length * rate for angle, rate in zip(self.angles(), after, strict=True)]
        return [*angles, *after, *[0.5 * change / length for change in map(sub, after, before)]]

    def _start_cold(self, length: float) -> None:
        """Let the engine forget the impulses of its last step where they count."""
        if self.take_symmetric is None:
            super()._start_cold(length)
