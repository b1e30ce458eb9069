"""Finding an event within an interval, on gaps and functions whose roots are known."""

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from bristle_sim.parameters import Tool
from bristle_sim.scene.events import Event, Kind
from bristle_sim.scene.extrapolation import IntervalResult
from bristle_sim.scene.locate import Interval, first_change, locate
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.pairs import ClosestApproach
from bristle_sim.scene.run import run
from bristle_sim.scene.simulate import prepare
from bristle_sim.scene.system import LEAST_VALUE
from bristle_sim.scene.tool import ONE_BRISTLE, Row
from bristle_sim.scene.touches import _search_hop as search_hop
from bristle_sim.scene.touches import first_touch, polynomial_error
from bristle_sim.settings import Settings

ROD = Mechanism((Link.rod(1.0, 1.0),))


def interval(length: float = 1.0, rate: float = 1.0) -> Interval:
    """A link that turns by rate times length at a constant rate, so that its angle is rate times the time."""
    ends = State(0.0, (0.0,), (rate,)), State(length, (rate * length,), (rate,))
    return Interval(
        *map(IntervalResult, ends),
        lambda time: IntervalResult(State(time, (rate * time,), (rate,))),
    )


def approach(gap: float, rate: float) -> ClosestApproach:
    """A closest approach with a gap and the rate at which the gap opens."""
    return ClosestApproach(gap, (0.0, 0.0), (0.0, 1.0), (rate, 0.0))


def valley(bottom: float, height: float) -> Callable[[State], ClosestApproach]:
    """A gap that falls to a height at an angle, and rises again, as a parabola over the angle."""

    def closest(state: State) -> ClosestApproach:
        away = state.angles[0] - bottom
        return approach(away * away + height, 2.0 * away * state.rates[0])

    return closest


def notch(left: float, right: float) -> Callable[[State], ClosestApproach]:
    """A gap that is closed between two angles and opens at unit slope on both sides."""
    middle = 0.5 * (left + right)
    half = 0.5 * (right - left)

    def closest(state: State) -> ClosestApproach:
        away = state.angles[0] - middle
        return approach(abs(away) - half, math.copysign(state.rates[0], away))

    return closest


class TestFirstTouch:
    """A gap that gets smaller than the error of the motion between the interval's ends may be closed."""

    @pytest.mark.parametrize(
        ("length", "height", "error", "found"),
        [
            (1.0, 0.02, 0.01, False),
            (1.0, 0.005, 0.01, True),
            (0.5, 0.001, 6e-4, False),
            (0.5, 0.0005, 6e-4, True),
            (1.0, -1e-10, 0.0, True),
            (0.1, -1e-10, 0.0, True),
        ],
    )
    def test_a_gap_that_is_least_in_between(
        self, length: float, height: float, error: float, found: bool
    ) -> None:
        """The place of least gap, 0.3 of the interval, to 2^-40 of it, or where it is closed, within its square root."""
        share = first_touch(ROD, valley(0.3 * length, height), interval(length), error)
        if not found:
            assert share is None
        else:
            assert share == pytest.approx(0.3, abs=2e-5 / length if height < 0.0 else 1e-11)

    def test_a_gap_that_is_least_where_the_interval_begins(self) -> None:
        """That is the touch which has just ended. The polynomial's error falls there with the square of the time, to 2e-17 after 1e-8."""
        assert first_touch(ROD, valley(1e-10, 1e-18), interval(), 0.01) is None
        assert first_touch(ROD, valley(1e-8, 1e-4), interval(), 0.01) is None
        assert first_touch(ROD, valley(1e-8, 1e-18), interval(), 0.01) == pytest.approx(
            1e-8, abs=1e-11
        )
        # What counts is the time, 1e-10, not the share of the interval.
        assert first_touch(ROD, valley(1e-10, 1e-12), interval(0.01), 1e-10) is None

    @pytest.mark.parametrize("left", [0.01, 0.2, 0.4, 0.6, 0.8, 0.9, 0.99, 0.9999])
    @pytest.mark.parametrize("width", [0.2, 1.0])
    def test_no_gap_is_jumped_over(self, left: float, width: float) -> None:
        """A link of length 1 that turns at 1 closes a gap no faster than 1.5: it is found while it is closed."""
        share = first_touch(ROD, notch(left, left + width), interval(), 0.01)
        assert share is not None
        assert left <= share <= min(left + width, 1.0)


@pytest.mark.parametrize("row", [ONE_BRISTLE, Row(2, 0.16, 0.3, 0.5)], ids=["one", "two"])
@pytest.mark.parametrize(
    "keys",
    [{}, {"wire_links": 3}, {"contact": "compliant", "contact_duration": 1e-4, "friction": 0.6}],
    ids=["rigid", "wire", "in time"],
)
def test_a_gap_that_is_left_unsearched_is_open(keys: dict[str, Any], row: Row) -> None:
    """The lower bound of a gap is below the gap after every interval, through impacts, contacts and dents."""
    system, *_ = prepare(
        Tool().replace(**keys), Settings(accuracy=1e-4), (None, 0.0, 0.0), row, stop_after=None
    )
    unsearched = 0
    for motion, _ in run(system):
        active = [contact.pair for contact in motion.contacts]
        for pair in system.pairs:
            least = system.clearances.get(pair, 0.0)
            if least > 0.0 and pair not in active:
                unsearched += 1
                assert system.closest(pair).gap >= least
    assert unsearched > 20


def swing(fastest: float, time: float) -> State:
    """A link that swings with a rate of amplitude 1 and a given angular frequency."""
    return State(time, (math.sin(fastest * time) / fastest,), (math.cos(fastest * time),))


@pytest.mark.parametrize("length", [0.1, 0.3, 1.0])
@pytest.mark.parametrize(
    ("links", "time_scale", "middle"), [(1, 1.0, False), (1, 1.0, True), (3, 0.25, False)]
)
def test_the_error_of_a_gap_on_the_polynomial_is_bounded(
    length: float, links: int, time_scale: float, middle: bool
) -> None:
    """For an amplitude A and the frequency w it is at most A (w h)^4/384, or with a middle A (w h)^6/(6! 432)."""
    length *= time_scale
    fastest = 1.0 / time_scale
    plan = SimpleNamespace(time_scale=time_scale)
    system: Any = SimpleNamespace(plan=plan, mechanism=SimpleNamespace(jointed=links > 1))
    worst = 0.0
    for begin in [0.1 * number * time_scale for number in range(63)]:
        ends = [swing(fastest, begin + part * length) for part in (0.0, 0.5, 1.0)]
        end = IntervalResult(ends[2], middle=ends[1] if middle else None)
        moved = Interval(IntervalResult(ends[0]), end, IntervalResult)
        bound = polynomial_error(system, moved)
        for part in (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8):
            exact = swing(fastest, begin + part * length).angles[0]
            worst = max(worst, abs(moved.at(part * length).angles[0] - exact) / bound)
    assert 0.1 < worst < 1.0


class TestLocate:
    @pytest.mark.parametrize("root", [1e-6, 0.3, 0.999999])
    @pytest.mark.parametrize("sign", [1.0, -1.0])
    def test_a_root_to_a_tolerance_of_the_value(self, root: float, sign: float) -> None:
        """The cube of the distance, which false position alone would approach without end."""

        def value(at: float) -> float:
            return sign * ((at - root) ** 3 + 1e-3 * (at - root))

        found = locate(value, float, 0.0, 1.0, value(0.0), value(1.0), 1e-12)
        assert abs(value(found)) <= 1e-12
        assert found == pytest.approx(root, abs=1.1e-9)

    @pytest.mark.parametrize("jump", [1e-9, 0.25, 1.0 - 1e-9])
    def test_past_a_jump(self, jump: float) -> None:
        """No value is within the tolerance: the first duration past the jump, to the last digits."""
        found = locate(lambda at: -1.0 if at < jump else 1.0, float, 0.0, 1.0, -1.0, 1.0, 0.0)
        assert jump <= found <= jump + 1e-14


class TestFirstChange:
    """A sign changes with its event only: no interval is accepted that ends beyond the zero of a function without the event."""

    @pytest.mark.parametrize("share", [0.1 * 2.0**-power for power in range(16)])
    @pytest.mark.parametrize("power", [0.3, 0.5, 1.0, 3.0])
    def test_a_force_vanishes_early_in_a_long_interval(self, share: float, power: float) -> None:
        """A rough estimate of its zero, to 1 % of the largest value, may lie on either side of it."""

        def force(at: Any) -> float:
            return float(share**power - at.state.time**power)

        plan = SimpleNamespace(time_scale=1.0, accuracy=1e-3)
        stepper = SimpleNamespace(noise=1e-4)
        system: Any = SimpleNamespace(plan=plan, stepper=stepper)
        release = Event(Kind.RELEASE, None, force, noise=LEAST_VALUE, sign=1.0)
        reached, event = first_change(system, [release], interval())
        if event is None:
            assert force(reached.end) >= -LEAST_VALUE
        else:
            assert abs(force(reached.end)) <= 1e-6

    def test_a_force_that_is_zero_at_the_start_vanishes_there(self) -> None:
        """Its estimated zero is so early that an interval which ends before it has no length."""
        plan = SimpleNamespace(time_scale=1.0, accuracy=1e-3)
        system: Any = SimpleNamespace(plan=plan, stepper=SimpleNamespace(noise=1e-4))
        slips = Event(Kind.BREAKS_AWAY, None, lambda at: -at.state.time, noise=1e-10, sign=1.0)
        reached, event = first_change(system, [slips], interval())
        assert event is slips
        assert reached.length < 1e-8

    @pytest.mark.parametrize(
        ("direction", "sign", "value", "kept"),
        [
            (-1, 1.0, -1.0, True),
            (-1, -1.0, 1.0, False),
            (1, 1.0, -1.0, False),
            (1, -1.0, 1.0, True),
            (0, 1.0, -1.0, True),
            (0, None, -1.0, False),
        ],
    )
    def test_a_change_of_sign_that_is_an_event_is_left_to_it(
        self, direction: int, sign: float | None, value: float, kept: bool
    ) -> None:
        event = Event(Kind.SLIP_STOPS, None, lambda _: value, direction, sign=sign)
        event.follow(interval().end)
        assert event.sign == (sign if kept else value)

    def test_an_event_within_an_instant_of_the_start_is_there(self) -> None:
        """What a shorter time is integrated to is rounding."""
        whole = interval()
        cut = whole.up_to(whole.integrate_to(1e-16))
        assert cut.end is whole.first
        assert cut.length == 0.0
        assert whole.up_to(whole.integrate_to(1e-3)).length == 1e-3


def test_a_hop_whose_end_cannot_be_located_is_no_rest_while_the_gap_is_open() -> None:
    """On the polynomial the gap closes after 0.95 of the interval. In the motion it is 0.05 up to a jump at the end."""

    def moved(time: float) -> IntervalResult:
        return IntervalResult(State(time, (0.05,), (1.0,)), (0.0,))

    first = IntervalResult(State(0.0, (0.0,), (1.0,)))
    hop = Interval(first, IntervalResult(State(1.0, (-0.1,), (-1.2,))), moved)
    plan = SimpleNamespace(time_scale=1.0, accuracy=1e-3, instant=0.01)
    system: Any = SimpleNamespace(
        plan=plan,
        mechanism=SimpleNamespace(single_link=False),
        stepper=SimpleNamespace(noise=1e-4),
        closest=lambda _, state: approach(state.angles[0], state.rates[0]),
    )
    pair: Any = None
    found = search_hop(system, hop, pair, 1.0)
    assert found is not None
    reached, event = found
    assert (reached.length, event) == (0.5, None)
