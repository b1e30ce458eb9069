"""Numerical settings of a run, apart from anything physical."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bristle_sim.units import ANY, Declared, quantity, shown

MAXIMUM_STEPS = 500_000
"""Engine steps of a run by default: sixty whole passes of a rigid bristle, or one of a wire of 8 links; 2 to 6 s of CPU time, of a
wire that bends 12 to 20 s."""

MOST_SAMPLES = 1_000_000_000  # more than a run could hold

LEAST_NEEDED, MOST_NEEDED = 8, 24
"""Samples in a period by default: fewer make a poor picture, and more are not worth their time, although the cubic through 24
is good to 1e-5 only."""


@dataclass(frozen=True, slots=True)
class Settings(Declared):
    """How accurately to compute, and at what price to give up.

    ``maximum_steps`` are the engine steps after which a run stops and says so; a step that takes the engine's solver hundreds of
    iterations counts once more for each hundred. ``samples_per_period`` is the least number of samples in a period of the bristle
    on its belt; None takes as many, from 8 to 24, as give a cubic through them the accuracy: its error is h^4/384 of a motion that
    is sampled every h rad.
    """

    accuracy: float = quantity(
        1e-6,
        "1e-11 <= accuracy <= 0.1: relative accuracy requested of the simulation"
        " [chosen; less than 1e-11 is more than double precision gives]",
        usual=ANY,
    )
    maximum_steps: int = MAXIMUM_STEPS
    hub_turn: float = quantity(
        4.71238898038469,
        "1e-12 <= hub_turn <= 1e6 rad: turn of the hub after which the pass ends [three quarters of a turn]",
        usual=ANY,
    )
    samples_per_period: int | None = None

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        for name in ("maximum_steps", "samples_per_period"):
            value = getattr(self, name)
            if value is None and name == "samples_per_period":
                continue
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise ValueError(f"{name} = {shown(value)}: must be a whole number of at least 1")
        if self.samples > MOST_SAMPLES:
            raise ValueError(f"samples_per_period = {shown(self.samples_per_period)}: must be at most {MOST_SAMPLES:g}")

    @property
    def samples(self) -> int:
        """Least number of samples in a period, given or by the accuracy."""
        if self.samples_per_period is not None:
            return self.samples_per_period
        needed: int = math.ceil(math.tau / (384.0 * self.accuracy) ** 0.25)
        return min(max(LEAST_NEEDED, needed), MOST_NEEDED)
