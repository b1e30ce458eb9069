"""Changes of sign of what a run looks out for, and where within a stretch they are."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bristle_sim.scene.build import Scene
from bristle_sim.scene.events import locate
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.stepping import Advance, Stepper
from bristle_sim.scene.touch_search import Stretch
from bristle_sim.scene.watches import Watch

__all__ = ["Changes"]

NOISE = 1e-10
"""Rates, accelerations and forces of a scene's units below this have no sign, however accurate the stepper is."""

DIFFERENCE = 1e-13
"""Rounding of the difference of two rates that an acceleration is made of."""


class Changes:
    """Remembers the sign that each watch's value had last.

    Args:
        scene, stepper: of the run.
        accuracy: to which changes are located, relative.
    """

    def __init__(self, scene: Scene, stepper: Stepper, accuracy: float) -> None:
        """Nothing is known yet."""
        self.stepper = stepper
        self.accuracy = accuracy
        # A damped spring turns an error of the rate into one of the acceleration.
        damping = scene.effects.damping / scene.mechanism.links[0].inertia_about_joint
        self.noise = max(NOISE, stepper.noise * (1.0 + damping))
        self.signs: dict[str, float] = {}

    def begin(self, state: State, watches: Sequence[Watch]) -> None:
        """A new smooth motion begins: signs that the state alone tells; what changes in its first stretch is an event, too."""
        here = _no_stretch(state)
        values = [(watch, watch.value(here)) for watch in watches]
        known = {watch.name: math.copysign(1.0, value) for watch, value in values if abs(value) > self.noise}
        self.signs = {watch.name: 1.0 for watch, _ in values if watch.final is not None} | known

    def look_back(self, stretch: Stretch, watches: Sequence[Watch]) -> bool:
        """Find signs at the very start exactly, if the first link's acceleration may have changed its sign since.

        By the cubic through the ends. Whether it did so, which moves the bodies.
        """
        (start, *_), (rate_0, *_) = stretch.start.angles, stretch.start.rates
        (end, *_), (rate_1, *_) = stretch.end.state.angles, stretch.end.state.rates
        length, after = stretch.length, stretch.end.accelerations[0]
        before = 6.0 * (end - start) / length - 4.0 * rate_0 - 2.0 * rate_1
        if after * before >= 0.2 * length * after**2:
            return False
        exact = {watch.name: watch.exact(stretch.start) for watch in watches if watch.exact is not None}
        self.signs |= {name: math.copysign(1.0, value) for name, value in exact.items() if abs(value) > NOISE}
        return True

    def find(self, watch: Watch, stretch: Stretch, before: Advance | None) -> Advance | None:
        """The stretch up to where the watch's value changes its sign, or None; ``before`` is the one before it."""
        length, instant = stretch.length, 1e-15 * (1.0 + stretch.end.state.time)
        if length <= instant:
            return None
        right, sign = watch.value(stretch.end), self.signs.get(watch.name)
        noise = max(self.noise, DIFFERENCE / length)
        if abs(right) > noise:
            self.signs[watch.name] = math.copysign(1.0, right)
        if sign is None or sign * right >= 0.0 or abs(right) <= noise:
            return None
        if watch.falling is not None and watch.falling != (sign > 0.0):
            return None
        left = watch.value(before or _no_stretch(stretch.start))
        if watch.exact is not None:
            left, right = watch.exact(stretch.start), watch.exact(stretch.end.state)
            if sign * right > 0.0 or sign * left < -noise:
                # It does not change within this stretch, looked at exactly: the differences have misled.
                self.signs[watch.name] = math.copysign(1.0, right)
                return None
        duration = self._locate(watch, stretch, sign * max(sign * left, NOISE), right)
        return stretch.again(max(duration, instant))

    def _locate(self, watch: Watch, stretch: Stretch, left: float, right: float) -> float:
        """When a value that differs in sign at the two ends of a stretch is zero."""

        def value(span: float) -> float:
            at = stretch.again(span)
            return watch.value(at) if watch.exact is None else watch.exact(at.state)

        tolerance = max(1e-3 * self.accuracy * max(abs(left), abs(right)), 0.01 * NOISE)
        self.stepper.begin_afresh()
        return locate(value, 0.0, stretch.length, left, right, tolerance)


def _no_stretch(state: State) -> Advance:
    """A state as the end of a stretch of no length."""
    return Advance(state, (math.nan,) * len(state.angles), (), 0.0)
