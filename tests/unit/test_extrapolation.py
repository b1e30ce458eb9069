"""Extrapolation of engine steps: its error against estimate and tolerance, its next interval, and what it refuses.

Free flights are referred to closed forms, or to scipy's integrator at a tolerance of 3e-14 on the equation

    a'' = -3 (k a + c a' + (r/2) w^2 sin a + (g/2) sin(psi + a))

of a rod of mass and length 1 on a hub of radius r (moment of inertia about the root 1/3).
"""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.integrate import extrapolation as repetitions
from bristle_sim.scene.integrate.extrapolation import Extrapolation
from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.plan import Plan, Recording
from bristle_sim.scene.run import run
from unit.test_stepping import Tally, carried, oscillator


class TestExtrapolation:
    def test_tolerance_scale_and_floor(self) -> None:
        """The tolerance is relative to the scale; below the rounding of the first four repetitions nothing is asked."""
        assert Extrapolation(1e-6).noise == 1e-6
        assert Extrapolation(1e-6, 3.0).noise == pytest.approx(3e-6, rel=1e-15, abs=0.0)
        exact = Extrapolation(0.0)
        assert exact.most_rows == exact.rows == 4
        assert exact.noise == repetitions.CLOSE.noise[3]

    def test_a_load_that_always_fails(self) -> None:
        scene, state = oscillator()[:2]
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
        stepper.length = 0.3
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

    @pytest.mark.parametrize(("duration", "kept"), [(0.01, True), (0.2, False)])
    def test_an_interval_cut_short_does_not_shorten_the_next(self, duration: float, kept: bool) -> None:
        """What an interval of a tenth or less tells, at most four times itself, is no news about the length proposed before."""
        stepper = Extrapolation(1e-6)
        stepper.length = 0.5
        accurate = Advance(State(duration, (0.0,), (0.0,)), (0.0,), (), 1e-6, errors={2: 1e-6, 3: 1e-6})
        assert stepper.accepts(accurate, duration)
        assert (stepper.length == 0.5) is kept

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
        scene, start = oscillator()[:2]
        stepper = Extrapolation(1e-9)
        result = stepper.advance(scene, start, 20.0)
        assert result.error > 0.01
        assert not stepper.accepts(result, 20.0)
        assert 2.0 * (1.0 - 1e-12) <= stepper.length < 10.0

    @pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
    def test_uniform_motion_is_hardly_ever_refused(self, tolerance: float) -> None:
        """An oscillator's intervals are all alike, and each is aimed at half the tolerance: its phase alone is new."""
        scene, state = oscillator()[:2]
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


REFEREE = 1e-13
"""Error of scipy's integration over a few radians."""


class TestAccuracy:
    @pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
    @pytest.mark.parametrize("damping", [0.0, 0.3])
    def test_oscillation(self, tolerance: float, damping: float) -> None:
        """Three radians are a few intervals; each keeps the tolerance, and an oscillator does not magnify errors."""
        scene, start, exact = oscillator(damping)
        found = carried(Extrapolation(tolerance), scene, start, 3.0)
        assert np.abs(found - exact(3.0)).max() < 10.0 * tolerance

    def test_repetitions_remove_one_power_of_the_step_each(self) -> None:
        """Weights add up to 1 and annihilate n^-j, j = 1 ... rows - 1; they magnify rounding by their own size."""
        for table in (repetitions.CLOSE, repetitions.WIDE):
            for row, weights in enumerate(table.weights):
                counts = np.array(table.counts[: row + 1], dtype=float)
                for power in range(row + 1):
                    scale = np.abs(weights) @ counts**-power
                    assert abs(weights @ counts**-power - (power == 0)) < 1e-14 * scale

    def test_an_interval_ends_exactly_where_it_was_requested(self) -> None:
        scene, start, _ = oscillator()
        result = Extrapolation(1e-6).advance(scene, start, 0.1234)
        assert result.state.time == 0.1234
        # The acceleration at the end is that of the oscillator, found from the last step's change of rate.
        assert result.accelerations[0] == pytest.approx(-result.state.angles[0], abs=1e-5)

    def test_what_is_left_is_cut_evenly(self) -> None:
        stepper = Extrapolation(1e-6)
        for remaining in np.geomspace(1e-6, 1e3, 40).tolist():
            pieces = remaining / stepper.propose(remaining)
            assert pieces == pytest.approx(round(pieces), rel=1e-14)
            assert remaining / pieces <= 1.2 * stepper.length

    def test_too_long_an_interval_is_refused_and_shortened(self) -> None:
        scene, start, _ = oscillator()
        stepper = Extrapolation(1e-9)
        result = stepper.advance(scene, start, 20.0)
        assert not stepper.accepts(result, 20.0)
        assert stepper.length <= 10.0

    def test_repeats_bit_for_bit(self) -> None:
        results = []
        for _ in range(2):
            scene, start, _ = oscillator(0.2)
            results.append([Extrapolation(1e-8).advance(scene, start, length) for length in (0.3, 1.7, 0.3)])
        assert results[0] == results[1]

    def test_what_the_engine_remembers_does_not_matter(self) -> None:
        """It starts each joint from its last impulse; an interval repeated after another one differs by the tolerance."""
        scene, start, _ = oscillator(0.2)
        first, _, second = (Extrapolation(1e-8).advance(scene, start, length) for length in (0.3, 1.7, 0.3))
        assert second.state.angles == pytest.approx(first.state.angles, abs=1e-8)
        assert second.state.rates == pytest.approx(first.state.rates, abs=1e-8)


def random_flight(rng: np.random.Generator) -> tuple[Scene, State, Callable[..., tuple[float, float]]]:
    """A rod on a hub with each of belt, damping and gravity there or not; natural rates are at most of order 1.

    Gravity is weaker than the belt: an inverted pendulum would magnify errors without bound, which no estimate knows.
    """
    stiffness = float(rng.uniform(0.01, 0.33))
    most = {"radius": 1.0, "damping": 0.5, "gravity": stiffness}
    radius, damping, gravity = (float(rng.choice([0.0, rng.uniform(0.0, each)])) for each in most.values())
    speed, start_hub = float(rng.uniform(-1, 1)), float(rng.uniform(-3, 3))
    mechanism = Mechanism((Link.rod(1.0, 1.0),), radius, speed, start_hub)
    scene = Scene(mechanism, Effects(stiffness=stiffness, damping=damping, gravity=gravity))

    def equation(time: float, state: np.ndarray) -> tuple[float, float]:
        angle, rate = state
        weight = 0.5 * gravity * math.sin(mechanism.hub_angle(time) + angle)
        centrifugal = 0.5 * radius * speed**2 * math.sin(angle)
        return rate, -3.0 * (stiffness * angle + damping * rate + centrifugal + weight)

    angle, rate = rng.uniform(-1.4, 1.4), rng.uniform(-1.0, 1.0)
    return scene, State(0.0, (start_hub + float(angle),), (speed + float(rate),)), equation


def flown(scene: Scene, start: State, accuracy: float, duration: float) -> Recording:
    """A flight as a pass runs it: a tenth of the accuracy for each interval, 24 intervals a period at least."""
    plan = Plan(end=duration, accuracy=accuracy, longest_interval=2.0 * math.pi / 24.0)
    return run(scene, start, Extrapolation(0.1 * accuracy), plan)


def true_error(scene: Scene, start: State, equation: Callable[..., tuple[float, float]], end: State) -> float:
    mechanism = scene.mechanism
    relative = (start.angles[0] - mechanism.hub_start, start.rates[0] - mechanism.hub_speed)
    exact = solve_ivp(equation, (0.0, end.time), relative, method="DOP853", rtol=3e-14, atol=1e-15).y[:, -1]
    angle = end.angles[0] - mechanism.hub_angle(end.time)
    return max(abs(angle - exact[0]), abs(end.rates[0] - mechanism.hub_speed - exact[1]))


def test_error_of_random_flights_is_within_estimate_and_accuracy(
    record_property: Callable[[str, object], None],
) -> None:
    """Three hundred flights of 1 to 12 radians, with requested accuracies from 1e-3 to 1e-9.

    The estimate is that of the extrapolate before the last and adds up absolute errors, so the true error should be a
    small share of it: more than the estimate means that it lies, less than 1e-4 of it that steps are wasted.
    """
    rng = np.random.default_rng(2020)
    shares, met = [], []
    for number in range(300):
        scene, start, equation = random_flight(rng)
        accuracy = 10.0 ** -(3 + 2 * (number % 4))
        recording = flown(scene, start, accuracy, float(rng.uniform(1.0, 12.0)))
        error = true_error(scene, start, equation, recording.states[-1])
        shares.append(max(error - REFEREE, 0.0) / recording.error)
        met.append(error <= accuracy)
    median = float(np.median(shares))
    record_property("median of true error over estimate", median)
    assert np.mean(np.array(shares) <= 1.0) >= 0.99
    assert 1e-3 < median < 1.0
    assert all(met)


def test_more_accuracy_costs_more_steps() -> None:
    scene, start, _ = random_flight(np.random.default_rng(1))
    taken = [scene.steps]
    for accuracy in (1e-3, 1e-5, 1e-7, 1e-9):
        flown(scene, start, accuracy, 5.0)
        taken.append(scene.steps)
    steps = np.diff(taken).tolist()
    assert steps == sorted(steps)
    assert steps[0] < steps[-1]
