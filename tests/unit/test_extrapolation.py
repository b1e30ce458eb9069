"""Extrapolation of engine steps: its tolerance, its next interval, and what it refuses."""

import math

import pytest

from bristle_sim.scene import repetitions
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.stepping import Advance


class Tally:
    """A load that does nothing, counts how often it is called, and fails below a step."""

    def __init__(self, least: float = 0.0) -> None:
        self.least = least
        self.calls = 0

    def begin(self) -> None:
        self.calls = 0

    def apply(self, step: float) -> None:
        del step
        self.calls += 1

    def totals(self, step: float) -> list[float]:
        return [step, float(self.calls)]

    def fails(self, totals: list[float]) -> bool:
        return totals[0] < self.least


def oscillator() -> tuple[Scene, State]:
    """A rod of mass and length 1, turning about the hub's axis at a natural rate of 1."""
    return Scene(Mechanism((Link.rod(1.0, 1.0),)), Effects(stiffness=1.0 / 3.0)), State(0.0, (0.7,), (-0.2,))


class TestExtrapolation:
    def test_tolerance_scale_and_floor(self) -> None:
        """The tolerance is relative to the scale; below the rounding of the first four repetitions nothing is asked."""
        assert Extrapolation(1e-6).noise == 1e-6
        assert Extrapolation(1e-6, 3.0).noise == pytest.approx(3e-6, rel=1e-15, abs=0.0)
        exact = Extrapolation(0.0)
        assert exact.most_rows == exact.rows == 4
        assert exact.noise == repetitions.CLOSE.noise[3]

    def test_a_load_that_always_fails(self) -> None:
        scene, state = oscillator()
        assert Extrapolation(1e-6).advance(scene, state, 0.1, Tally(1.0)).failed

    def test_no_error_besides_the_cubics_own(self) -> None:
        start, end = State(0.0, (0.1,), (1.0,)), State(1.0, (0.3,), (1.5,))
        assert Extrapolation(1e-6).interpolation_error(start, end) == 0.0

    @pytest.mark.parametrize(
        ("errors", "row", "grows"),
        [
            ({1: 1e-4, 2: 1e-6, 3: 5e-7, 4: 4.9e-7}, 2, False),
            ({2: 1e-4, 3: 1e-6}, 3, True),
            ({2: 3e-6, 3: 2.4e-6}, 2, False),
            ({2: 1e-6, 3: 2.6e-7}, 3, False),
            ({1: 1e-6}, 1, True),
            ({2: 1e-12}, 2, True),
            ({1: 1e-30, 2: 1.0, 3: 1.0}, 2, False),
        ],
    )
    def test_the_cheapest_interval_is_next(self, errors: dict[int, float], row: int, grows: bool) -> None:
        """Row r (from 0) of error e: the interval times 0.9 (limit/2e)^(1/(r + 1)), within 0.1 and 4, at a cost of r + 1
        overheads and its steps (Hairer, Norsett and Wanner, sec. II.9); the least cost per length wins, with two rows
        at least. If that is the last row and its price is a tenth below that before it, one more row is tried, with the
        interval that keeps the price.
        """
        stepper = Extrapolation(1e-6)
        counts, overhead = (4, 5, 6, 7, 8, 10), repetitions.RUN_OVERHEAD

        def cost(of: int) -> float:
            return overhead * (of + 1) + sum(counts[: of + 1])

        def length(of: int) -> float:
            return 0.3 * min(4.0, max(0.1, 0.9 * (0.5e-6 / errors[of]) ** (1.0 / (of + 1))))

        prices = {of: cost(of) / length(of) for of in errors}
        assert row == min([of for of in errors if of > 1] or errors, key=prices.__getitem__), "the case is what it says"
        assert grows == (row == max(errors) and prices[row] < 0.9 * prices.get(row - 1, math.inf))
        state = State(0.3, (0.0,), (0.0,))
        assert stepper.accepts(Advance(state, (0.0,), (), 1e-6, errors=errors), 0.3), (
            "an error of the limit itself is accepted"
        )
        expected = length(row) * (cost(row + 1) / cost(row) if grows else 1.0)
        assert stepper.length == pytest.approx(expected, rel=1e-14)
        assert stepper.rows == row + 1 + grows

    def test_a_refused_interval_is_halved_at_least(self) -> None:
        """Row 3 of an error of 1.01 limits would go on with 0.9 (1/2.02)^(1/4) = 0.75 of the interval."""
        stepper = Extrapolation(1e-6)
        assert not stepper.accepts(Advance(State(0.3, (0.0,), (0.0,)), (0.0,), (), 1.01e-6, errors={3: 1.01e-6}), 0.3)
        assert stepper.length == 0.15

    def test_no_more_rows_than_rounding_allows(self) -> None:
        """With a tolerance of 0 there are four; the last is then the best whatever its price."""
        for last in (2, 3):
            stepper = Extrapolation(0.0)
            result = Advance(State(0.3, (0.0,), (0.0,)), (0.0,), (), stepper.limit, errors={last: stepper.limit})
            assert stepper.accepts(result, 0.3)
            assert stepper.rows == 4

    def test_an_interval_may_be_a_tenth_longer_to_save_a_stub(self) -> None:
        """1.05 lengths are gone in one interval, 1.15 in two halves."""
        stepper = Extrapolation(1e-6)
        assert stepper.propose(1.05 * stepper.length) == 1.05 * stepper.length
        assert stepper.propose(1.15 * stepper.length) == 0.575 * stepper.length

    def test_a_refused_interval_is_cut_by_its_estimate(self) -> None:
        """Twenty radians are far off 1e-9: an error e of order k needs (1e-9/e)^(1/k), at most 0.2 for e >= 0.01, k <= 10.

        No change is larger than tenfold at once.
        """
        scene, start = oscillator()
        stepper = Extrapolation(1e-9)
        result = stepper.advance(scene, start, 20.0)
        assert result.error > 0.01
        assert not stepper.accepts(result, 20.0)
        assert 2.0 * (1.0 - 1e-12) <= stepper.length < 10.0

    @pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
    def test_uniform_motion_is_hardly_ever_refused(self, tolerance: float) -> None:
        """An oscillator's intervals are all alike, and each is aimed at half the tolerance: its phase alone is new."""
        scene, state = oscillator()
        stepper = Extrapolation(tolerance)
        refused = accepted = 0
        while state.time < 60.0:
            length = stepper.propose(1e3)
            result = stepper.advance(scene, state, length)
            if stepper.accepts(result, length):
                state, accepted = result.state, accepted + 1
            else:
                refused += 1
        assert accepted > 10
        assert refused <= 0.2 * accepted
