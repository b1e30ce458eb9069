"""Steps and their extrapolation: what other tests let pass. Expected values by hand."""

import math

import pytest

from bristle_sim.scene import repetitions
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.repetitions import Repetitions
from bristle_sim.scene.stepping import Advance, PlainSteps, SymmetricSteps


class Tally:
    """A load that does nothing, counts how often it is asked to, and fails below a step."""

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


class TestFixedSteps:
    @pytest.mark.parametrize(
        ("share", "count"), [(0.5, 1), (1.0, 1), (2.0, 2), (2.5, 3), (8.0, 8), (8.0 * (1.0 + 1e-14), 8)]
    )
    def test_a_stretch_takes_as_many_steps_as_it_needs(self, share: float, count: int) -> None:
        """Equal steps no longer than the one asked for; a stretch of whole steps is not cut once more by rounding."""
        scene, state = oscillator()
        load = Tally()
        result = SymmetricSteps(0.01).advance(scene, state, 0.01 * share, load)
        assert load.calls == scene.steps == count
        assert result.totals == (0.01 * share / count, count)

    def test_symmetric_steps_propose_eight(self) -> None:
        stepper = SymmetricSteps(0.01)
        assert stepper.propose(1e3) == pytest.approx(0.08, rel=1e-15)
        assert stepper.propose(0.03) == 0.03

    @pytest.mark.parametrize("kind", [PlainSteps, SymmetricSteps])
    def test_a_load_that_fails_makes_the_stretch_fail(self, kind: type[PlainSteps] | type[SymmetricSteps]) -> None:
        scene, state = oscillator()
        for least, failed in ((0.0, False), (0.05, True)):
            result = kind(0.1).advance(scene, state, 0.01, Tally(least))
            assert result.failed is failed
            assert len(result.accelerations) == 1
            assert result.error == 0.0, "there is no estimate"

    def test_joints_are_corrected_in_flight_alone(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Not under a load, which would take a correction for a force, nor over next to nothing, where it has no bound."""
        scene, state = oscillator()
        told: list[bool] = []
        monkeypatch.setattr(scene, "correct_joints", lambda *, completely: told.append(bool(completely)))
        for duration, load in ((0.01, None), (0.01, Tally()), (1e-7, None), (1e-7, Tally())):
            PlainSteps(0.01).advance(scene, state, duration, load)
        assert told == [True, False, False, False, False, False, False, False]


class TestRepetitions:
    def test_three_repetitions_by_hand(self) -> None:
        """Lagrange's weights at h = 0 for n = 4, 5, 6: 4/(-1) 4/(-2) = 8, 5/1 5/(-1) = -25, 6/2 6/1 = 18."""
        table = Repetitions(4, 5, 6)
        assert table.counts == (4, 5, 6)
        assert table.weights == [(1.0,), (-4.0, 5.0), (8.0, -25.0, 18.0)]
        # Less the weights without the first result, (1,) and (-5, 6).
        assert table.differences[1:] == [(-4.0, 4.0), (8.0, -20.0, 12.0)]
        assert table.noise == pytest.approx(
            [each * repetitions.ROUNDING for each in (1.0, 9.0, 51.0)], rel=1e-15, abs=0.0
        )


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

    def test_it_does_not_stray_from_the_cubic(self) -> None:
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
    def test_the_cheapest_stretch_is_next(self, errors: dict[int, float], row: int, grows: bool) -> None:
        """Row r (from 0) of error e: the stretch times 0.9 (limit/2e)^(1/(r + 1)), within 0.1 and 4, at a cost of r + 1
        overheads and its steps (Hairer, Norsett and Wanner, sec. II.9); the least cost per length wins, with two rows
        at least. If that is the last row and its price is a tenth below that before it, one more row is tried, with the
        stretch that keeps the price.
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

    def test_a_refused_stretch_is_halved_at_least(self) -> None:
        """Row 3 of an error of 1.01 limits would go on with 0.9 (1/2.02)^(1/4) = 0.75 of the stretch."""
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
