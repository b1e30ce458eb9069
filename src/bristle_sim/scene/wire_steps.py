"""Engine steps of wires that bend, whose joints and sustained contacts are solved for instead of the engine's iterations."""

from __future__ import annotations

from collections.abc import Sequence
from operator import sub

import pymunk

from bristle_sim.scene.engine import EngineSteps
from bristle_sim.scene.wire_velocities import WireVelocities


class WireSteps(EngineSteps):
    """Engine steps, each followed by a linear solve while the engine's solver takes a single iteration."""

    wires: WireVelocities

    def __init__(
        self,
        space: pymunk.Space,
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
        joints: Sequence[pymunk.Constraint],
        wires: WireVelocities,
    ) -> None:
        """Leave the joints to the engine until the iterations are set."""
        super().__init__(space, hub, links, joints)
        self.wires = wires
        self._engine_step = self._step

    def set_iterations(self, count: int) -> None:
        """Have the engine's solver take this many iterations in every step; one alone leaves the joints to the wires' solver."""
        super().set_iterations(count)
        active = count == 1
        self.wires.take_over(active=active)
        self._step = self._step_and_solve if active else self._engine_step
        self.take_symmetric = self._take_symmetric if active else None
        self._last_length = 0.0

    def _step_and_solve(self, length: float) -> None:
        self._engine_step(length)
        self.wires.solve(length)

    def _take_symmetric(self, length: float, count: int) -> list[float]:
        """Take an even number of steps symmetric in time from where the bodies were half a step ago; return as ``take`` does.

        After odd numbers of steps the links have an error of their own. The accelerations are those of the last two steps.
        """
        self.steps += count
        self.work += count * self._price
        with self.wires.symmetric_steps():
            for _ in range(count - 2):
                self._step(length)
            before = self.rates()
            self._step(length)
            self._step(length)
        after = self.rates()
        angles = [angle + 0.5 * length * rate for angle, rate in zip(self.angles(), after, strict=True)]
        return [*angles, *after, *[0.5 * change / length for change in map(sub, after, before)]]

    def _start_cold(self, length: float) -> None:
        """Let the engine forget the impulses of its last step where they count."""
        if self.take_symmetric is None:
            super()._start_cold(length)
