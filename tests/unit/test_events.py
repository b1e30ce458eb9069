"""Finding an event within an interval, on gaps and functions whose roots are known."""

import math
from collections.abc import Callable

import pytest

from bristle_sim.scene.locate import Interval, at_state
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.root import locate
from bristle_sim.scene.touches import first_touch

ROD = Mechanism((Link.rod(1.0, 1.0),))


def interval(length: float = 1.0, rate: float = 1.0) -> Interval:
    """A link that turns by rate times length at a constant rate, so that its angle is rate times the time."""
    ends = State(0.0, (0.0,), (rate,)), State(length, (rate * length,), (rate,))
    return Interval(*map(at_state, ends), lambda time: at_state(State(time, (rate * time,), (rate,))))


def valley(bottom: float, height: float) -> Callable[[State], tuple[float, float]]:
    """A gap that falls to a height at an angle, and rises again, as a parabola over the angle."""

    def gap(state: State) -> tuple[float, float]:
        away = state.angles[0] - bottom
        return away * away + height, 2.0 * away * state.rates[0]

    return gap


def notch(left: float, right: float) -> Callable[[State], tuple[float, float]]:
    """A gap that is closed between two angles and opens at unit slope on both sides."""
    middle, half = 0.5 * (left + right), 0.5 * (right - left)

    def gap(state: State) -> tuple[float, float]:
        away = state.angles[0] - middle
        return abs(away) - half, math.copysign(state.rates[0], away)

    return gap


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
    def test_a_gap_that_is_least_in_between(self, length: float, height: float, error: float, found: bool) -> None:
        """The place of least gap, 0.3 of the interval, to 2^-40 of it, or where it is closed, within its square root."""
        share = first_touch(ROD, valley(0.3 * length, height), interval(length), error)
        if not found:
            assert share is None
        else:
            assert share == pytest.approx(0.3, abs=2e-5 / length if height < 0.0 else 1e-11)

    def test_a_gap_that_is_least_where_the_interval_begins(self) -> None:
        """That is the touch which has just ended."""
        assert first_touch(ROD, valley(1e-10, 1e-4), interval(), 0.01) is None
        assert first_touch(ROD, valley(1e-8, 1e-4), interval(), 0.01) == pytest.approx(1e-8, abs=1e-11)
        # What counts is the time, 1e-10, not the share of the interval.
        assert first_touch(ROD, valley(1e-10, 1e-12), interval(0.01), 1e-10) is None

    @pytest.mark.parametrize("left", [0.01, 0.2, 0.4, 0.6, 0.8, 0.9, 0.99, 0.9999])
    @pytest.mark.parametrize("width", [0.2, 1.0])
    def test_no_gap_is_jumped_over(self, left: float, width: float) -> None:
        """A link of length 1 that turns at 1 closes a gap no faster than 1.5: it is found while it is closed."""
        share = first_touch(ROD, notch(left, left + width), interval(), 0.01)
        assert share is not None
        assert left <= share <= min(left + width, 1.0)


class TestLocate:
    @pytest.mark.parametrize("root", [1e-6, 0.3, 0.999999])
    @pytest.mark.parametrize("sign", [1.0, -1.0])
    def test_a_root_to_a_tolerance_of_the_value(self, root: float, sign: float) -> None:
        """The cube of the distance, which false position alone would approach without end."""

        def value(at: float) -> float:
            return sign * ((at - root) ** 3 + 1e-3 * (at - root))

        found = locate(value, 0.0, 1.0, value(0.0), value(1.0), 1e-12)
        assert abs(value(found)) <= 1e-12
        assert found == pytest.approx(root, abs=1.1e-9)

    @pytest.mark.parametrize("jump", [1e-9, 0.25, 1.0 - 1e-9])
    def test_past_a_jump(self, jump: float) -> None:
        """No value is within the tolerance: the first duration past the jump, to the last digits."""
        found = locate(lambda at: -1.0 if at < jump else 1.0, 0.0, 1.0, -1.0, 1.0, 0.0)
        assert jump <= found <= jump + 1e-14
