"""The propagation of a run's error over an impact."""

from __future__ import annotations

import math

from bristle_sim.scene.mechanism import State, cross
from bristle_sim.scene.pairs import ClosestApproach, ContactPair
from bristle_sim.scene.system import System
from bristle_sim.trajectory import ContactRecord

MOST_CHANGED_APPROACH = (
    0.5  # by the error, as a fraction; the impact is beyond linear error propagation then
)


def propagate_error(
    system: System, pair: ContactPair, before: State, record: ContactRecord
) -> None:
    """Propagate the error over an impact, by two motions that are off by it in angle, and in rate with either sign.

    These touch at another instant, with another approach and another lever, which change the jump of their rates. If the law
    has adjusted the slip so that it ends with the approach, it is uncertain whether the contact sticks or jams.
    """
    gaps = system.gaps
    recording = system.recording
    error = system.recording.error
    if recording.lost is not None:
        return
    earlier = next((each for each in reversed(recording.states) if each.time < before.time), before)
    since = before.time - earlier.time or math.inf
    touch = gaps.closest(pair, before)
    approach, slip = touch.velocity
    changes = [(b - a) / since for a, b in zip(earlier.rates, before.rates, strict=True)]
    jumps = [b - a for a, b in zip(before.rates, record.rates_after, strict=True)]
    snap = abs(slip - record.velocity_before[1])
    jams = pair.friction * abs(slip) >= abs(approach)
    undecided = snap > (0.0 if jams else error)
    for off in (error, -error):
        angles = [each + error for each in before.angles]
        rates = [each + off for each in before.rates]
        gap, opening = gaps.gap_and_rate(pair, State(before.time, tuple(angles), tuple(rates)))
        late = -gap / opening if opening else math.inf
        angles = [each + late * rate for each, rate in zip(angles, rates, strict=True)]
        rates = [each + late * change for each, change in zip(rates, changes, strict=True)]
        other = gaps.closest(pair, State(before.time + late, tuple(angles), tuple(rates)))
        part = _jump_ratio(touch, other, single_link=system.mechanism.single_link) - 1.0
        if undecided or not abs(part) < MOST_CHANGED_APPROACH:
            recording.lost = before.time
            return
        for jump in jumps:
            recording.error = max(recording.error, abs(error - jump * late), abs(off + jump * part))


def _jump_ratio(touch: ClosestApproach, other: ClosestApproach, *, single_link: bool) -> float:
    """Return the ratio of the jumps of the rates, the second over the first, in two nearby impacts.

    A jump is in proportion to the approach and, of a single link, inversely to the lever of the normal.
    """
    jump = touch.velocity[0]
    other_jump = other.velocity[0]
    if single_link:
        jump *= cross(other.arm, other.normal)
        other_jump *= cross(touch.arm, touch.normal)
    return other_jump / jump if jump else math.inf
