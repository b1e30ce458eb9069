"""Find where within an interval a link touches an obstacle, for the first time or again, without missing a touch.

Gaps are searched on the cubic by conservative advancement (Mirtich 1996): from a gap g no contact can happen before
g / (largest speed), so nothing is jumped over.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from bristle_sim.scene.contact.gaps import GAP_ROUNDING, behind_joint
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.events.locate import Interval, guess, locate, settle
from bristle_sim.scene.events.table import Touch
from bristle_sim.scene.integrate.extrapolation import Advance
from bristle_sim.scene.mechanism import Mechanism, State, interpolate

if TYPE_CHECKING:
    from bristle_sim.scene.progress import Progress

CUBIC_ERROR = 0.01
"""Bound of the cubic's error of the gap, per fourth power of the interval h (scene units): h^4/384 with a safety factor.
Likewise h^4 w^3/384 bounds it for a rate of amplitude 1 that vibrates with the fastest rate w."""

SHORTEST_ADVANCE = 1e-9  # time and length; a least gap sooner is the one at which the interval begins
LEAST_ADVANCE = 1.0 / 8.0  # fraction of the interval; least values of the gap in between show in its slopes
GAP_TOLERANCE = 1e-13  # least gap to which a touch is located: rounding of an extrapolated interval
LOCATED_GAP = 1e-6  # to which a touch is located, over the accuracy: a slow approach makes more of it in time
SHORTEST_INTERVAL = 1e-13  # in the scene's time units; none shorter is accurate. A motion of that length is an instant
MUCH_SHORTER = 0.25  # fraction of an interval below which more repetitions bring rounding alone
LEAST_HOP = 1e-6  # fraction of an interval; a shorter rebound is none
MOST_HALVINGS = 40  # of a fraction of an interval, down to rounding

Found = tuple[Advance, Touch | None]
"""The interval up to a touch, and the touch; or up to the least gap to an obstacle that is not touched, and None."""


def first_touch_of_all(
    progress: Progress, interval: Interval, sustained: Sequence[Obstacle], separating: Sequence[Obstacle]
) -> Found:
    """Return the interval up to its first touch or least gap; pairs in contact or separating are treated as such."""
    first: Touch | None = None
    gaps, several = progress.gaps, progress.mechanism.wire_links > 1
    for obstacle in progress.obstacles:
        start, end = interval.start, interval.end.state
        if obstacle in sustained or interval.length <= 0.0:
            continue
        if obstacle in separating:
            found = _search_return(progress, interval, obstacle)
        elif (sustained and gaps.rests(obstacle, start, end)) or (
            several and behind_joint(progress, obstacle, [*separating, *sustained], end)
        ):
            continue
        else:
            changes = (abs(b - a) for a, b in zip(start.rates, end.rates, strict=True))
            error = progress.stepper.straightness * interval.length * sum(changes)
            if several:
                error += CUBIC_ERROR * interval.length * (interval.length / progress.plan.time_scale) ** 3
            found = find_touch(progress, interval, obstacle, error)
        if found is not None:
            interval, first = interval._replace(end=found[0]), found[1]
    return interval.end, first


def _search_return(progress: Progress, interval: Interval, obstacle: Obstacle) -> Found | None:
    """Search for a touch of an obstacle that the link has just left: the link must come back within the interval.

    An interval that ends deep inside an obstacle is cut at the hop before, or where the link is still above. A rebound that is
    over within the shortest interval is too low to follow.
    """
    gaps, start, end, length, instant = (
        progress.gaps,
        interval.start,
        interval.end.state,
        interval.length,
        progress.plan.instant,
    )
    gap, rate = gaps.gap_and_rate(obstacle, end)
    if gap >= -GAP_ROUNDING or rate >= 0.0:
        return None

    def gap_at(fraction: float) -> float:
        return gaps.gap(obstacle, interpolate(start, end, fraction))

    progress.stepper.begin_afresh()
    if instant < length and (gap := gap_at(instant / length)) <= 0.0:
        gap = gaps.gap(obstacle, interval.again(instant).state)
    # Whether a single rigid link hops is of no consequence; of several, one may hop while another is pressed on.
    low = progress.mechanism.lone and obstacle.law.at_once and -progress.plan.accuracy <= gap < 0.0
    if low or gaps.gap(obstacle, start) < -GAP_ROUNDING:
        return (interval.end if instant >= length else interval.again(instant)), Touch(obstacle, True)
    part = 1.0
    while part > LEAST_HOP and (above := gap_at(part)) < -GAP_ROUNDING:
        part, below = 0.5 * part, above
    if part < 1.0 and above > 0.0:
        near = length * locate(gap_at, part, 2.0 * part, above, below, GAP_TOLERANCE)
        closed = settle(partial(gaps.gap, obstacle), interval, near, length, GAP_TOLERANCE)
        # The zero at its beginning is none.
        if closed is not None and gaps.gap_and_rate(obstacle, interval.again(closed).state)[1] < 0.0:
            return interval.again(closed), Touch(obstacle)
    while (gap := gaps.gap(obstacle, interval.again(part * length).state)) < -GAP_ROUNDING and part > LEAST_HOP:
        part *= 0.5
    return interval.again(part * length), None if gap > GAP_ROUNDING else Touch(obstacle, True)


def find_touch(progress: Progress, interval: Interval, obstacle: Obstacle, interpolation_error: float) -> Found | None:
    """Return the interval up to its first touch, or up to where a link nearly touched; else None.

    ``interpolation_error`` bounds the deviation of the motion from the cubic through the ends, besides the cubic's own error.
    """
    start, end, gaps, again = interval.start, interval.end, progress.gaps, interval.again
    gap_of, gap_and_rate = partial(gaps.gap, obstacle), partial(gaps.gap_and_rate, obstacle)
    fraction = first_touch(gaps.mechanism, gap_and_rate, start, end.state, interpolation_error)
    if fraction is None:
        return None
    last, near = fraction * interval.length, guess(gap_of, start, end.state, fraction)
    if (near or last) < MUCH_SHORTER * interval.length:
        progress.stepper.begin_afresh()
    tolerance = min(max(LOCATED_GAP * progress.plan.accuracy, GAP_TOLERANCE), 0.1 * GAP_ROUNDING)
    if near is not None and (closed := settle(gap_of, interval, near, last, tolerance)) is not None:
        return again(closed), Touch(obstacle)
    reached, closed = end if fraction == 1.0 else again(last), last
    at_end, rate = gap_and_rate(reached.state)
    if at_end > 0.0 and rate > 0.0:
        # The gap opens again: it is closed, or least, before.
        fastest = 1.5 * gaps.mechanism.speed_bound(start)

        def at_instant(span: float, gap: float) -> bool:
            return gap > fastest * span or max(1.0, fastest) * span <= SHORTEST_INTERVAL

        closed, at_end = _least(lambda span: gap_and_rate(again(span).state), 0.0, closed, at_end, at_instant)
    if at_end > 0.0:
        return reached, None
    if at_end < 0.0:
        at_start = max(gap_of(start), 1e-300)
        closed = locate(lambda span: gap_of(again(span).state), 0.0, closed, at_start, at_end, GAP_TOLERANCE, near)
    return again(closed), Touch(obstacle)


Gap = Callable[[State], tuple[float, float]]
"""The gap of a state, and its rate."""


def first_touch(
    mechanism: Mechanism, gap: Gap, start: State, end: State, interpolation_error: float = 0.0
) -> float | None:
    """Return the fraction of the interval at which the gap is closed or nearly so, on the cubic; None if it stays open.

    The fraction may be later than the touch but never past a second one. ``interpolation_error`` bounds the deviation from the
    cubic besides its own error.
    """
    length = end.time - start.time
    bound = 1.5 * max(mechanism.speed_bound(start), mechanism.speed_bound(end)) * length
    margin = CUBIC_ERROR * length**4 + interpolation_error
    fraction, (value, rate) = 0.0, gap(start)
    while fraction < 1.0 and value <= bound * (1.0 - fraction) + margin:
        ahead = min(1.0, fraction + max(value / bound if bound else 1.0, LEAST_ADVANCE))
        following, next_rate = gap(interpolate(start, end, ahead)) if ahead < 1.0 else gap(end)
        if following < 0.0:
            return ahead
        if rate < 0.0 < next_rate:

            def at(part: float) -> tuple[float, float]:
                return gap(interpolate(start, end, part))

            dip, least = _least(at, fraction, ahead, following, lambda span, _: span < 2.0**-MOST_HALVINGS)
            if least < 0.0 or (least < margin and dip * max(length, bound) > SHORTEST_ADVANCE):
                return dip
        fraction, value, rate = ahead, following, next_rate
    return None


def _least(
    gap: Callable[[float], tuple[float, float]],
    left: float,
    right: float,
    at_right: float,
    enough: Callable[[float, float], bool],
) -> tuple[float, float]:
    """Minimise a gap that falls at the left end and rises at the right; return the place and the gap, at once where it is closed.

    By bisection on the rate, until the length of the bracket and the gap are ``enough``.
    """
    value = at_right
    while not enough(right - left, value):
        middle = 0.5 * (left + right)
        value, rate = gap(middle)
        if value < 0.0:
            return middle, value
        left, right = (middle, right) if rate < 0.0 else (left, middle)
    return right, gap(right)[0]
