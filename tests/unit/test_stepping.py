"""Steps of the engine: their observed order, and extrapolation's error against its estimate and its tolerance.

Free flights are referred to closed forms, or to scipy's integrator at a tolerance of 3e-14 on the equation

    a'' = -3 (k a + c a' + (r/2) w^2 sin a + (g/2) sin(psi + a))

of a rod of mass and length 1 on a hub of radius r (moment of inertia about the root 1/3).
"""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle_sim.scene import repetitions
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact_laws import EnergeticLaw
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.plan import Plan, Recording
from bristle_sim.scene.run import run
from bristle_sim.scene.stepping import PlainSteps, Stepper, SymmetricSteps

ROD = Link.rod(1.0, 1.0)
REFEREE = 1e-13
"""Error of scipy's integration over a few radians."""


def oscillator(damping: float = 0.0) -> tuple[Scene, State, Callable[[float], np.ndarray]]:
    """A rod whose root stands on the hub's axis: harmonic, of natural rate 1, released at 0.7 rad and -0.2."""
    scene = Scene(Mechanism((ROD,)), Effects(stiffness=1.0 / 3.0, damping=2.0 / 3.0 * damping))
    exponent = complex(-damping, math.sqrt(1.0 - damping**2))
    amplitude = complex(0.7, (exponent.real * 0.7 + 0.2) / exponent.imag)

    def exact(time: float) -> np.ndarray:
        motion = amplitude * np.exp(exponent * time)
        return np.array([motion.real, (exponent * motion).real])

    return scene, State(0.0, (0.7,), (-0.2,)), exact


def carried(stepper: Stepper, scene: Scene, state: State, duration: float) -> np.ndarray:
    """Angle and rate at the end, stretch by stretch."""
    while duration - state.time > 1e-12:
        length = stepper.propose(duration - state.time)
        result = stepper.advance(scene, state, length)
        if stepper.accepts(result, length):
            state = result.state
    return np.array([state.angles[0], state.rates[0]])


def observed_order(kind: type[PlainSteps] | type[SymmetricSteps], damping: float) -> float:
    """Slope of error over step in a doubly logarithmic plot, from 128 to 1024 steps a radian; steps add up exactly."""
    scene, start, exact = oscillator(damping)
    counts = np.array([256, 512, 1024, 2048])
    errors = [np.abs(carried(kind(2.0 / count), scene, start, 2.0) - exact(2.0)).max() for count in counts]
    return float(-np.polyfit(np.log(counts), np.log(errors), 1)[0])


class TestOrder:
    """The next power of the step is 1/100 of the first at the coarsest step here: orders come out within a few 0.01."""

    @pytest.mark.parametrize("damping", [0.0, 0.3])
    def test_plain_steps_are_of_first_order(self, damping: float) -> None:
        assert observed_order(PlainSteps, damping) == pytest.approx(1.0, abs=0.03)

    def test_symmetric_steps_are_of_second_order(self) -> None:
        assert observed_order(SymmetricSteps, 0.0) == pytest.approx(2.0, abs=0.03)

    def test_symmetric_steps_are_of_first_order_with_damping(self) -> None:
        assert observed_order(SymmetricSteps, 0.3) == pytest.approx(1.0, abs=0.1)

    def test_plain_error_is_the_one_of_drift_then_kick(self) -> None:
        """Drift by the old rate, then kick: a' = a + h u, u' = u - h a' is the energy-like integral's own motion.

        For the undamped oscillator those two lines are what the engine does, up to the joint's O(h^2) per step.
        """
        scene, start, _ = oscillator()
        angle, rate, step = start.angles[0], start.rates[0], 1e-3
        for _ in range(1000):
            angle += step * rate
            rate -= step * angle
        found = carried(PlainSteps(step), scene, start, 1.0)
        first_order = abs(found - oscillator()[2](1.0)).max()
        assert found == pytest.approx([angle, rate], abs=0.01 * first_order)


class TestExtrapolation:
    @pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
    @pytest.mark.parametrize("damping", [0.0, 0.3])
    def test_oscillation(self, tolerance: float, damping: float) -> None:
        """Three radians are a few stretches; each keeps the tolerance, and an oscillator does not magnify errors."""
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

    def test_a_stretch_ends_exactly_where_it_was_asked_to(self) -> None:
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

    def test_too_long_a_stretch_is_refused_and_shortened(self) -> None:
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
        """It starts each joint from its last impulse; a stretch repeated after another one differs by the tolerance."""
        scene, start, _ = oscillator(0.2)
        first, _, second = (Extrapolation(1e-8).advance(scene, start, length) for length in (0.3, 1.7, 0.3))
        assert second.state.angles == pytest.approx(first.state.angles, abs=1e-8)
        assert second.state.rates == pytest.approx(first.state.rates, abs=1e-8)

    def test_a_load_that_fails_makes_the_stretch_fail(self) -> None:
        class Lost:
            def begin(self) -> None: ...

            def apply(self, step: float) -> None: ...

            def totals(self, step: float) -> list[float]:
                return [step]

            def fails(self, totals: list[float]) -> bool:
                return totals[0] < 0.02

        scene, start, _ = oscillator()
        assert Extrapolation(1e-12).advance(scene, start, 0.16, Lost()).failed
        assert not PlainSteps(0.1).advance(scene, start, 0.1, Lost()).failed
        assert PlainSteps(0.1).advance(scene, start, 0.01, Lost()).failed


def random_flight(rng: np.random.Generator) -> tuple[Scene, State, Callable[..., tuple[float, float]]]:
    """A rod on a hub with each of belt, damping and gravity there or not; natural rates are at most of order 1.

    Gravity is weaker than the belt: an inverted pendulum would magnify errors without bound, which no estimate knows.
    """
    stiffness = float(rng.uniform(0.01, 0.33))
    most = {"radius": 1.0, "damping": 0.5, "gravity": stiffness}
    radius, damping, gravity = (float(rng.choice([0.0, rng.uniform(0.0, each)])) for each in most.values())
    speed, start_hub = float(rng.uniform(-1, 1)), float(rng.uniform(-3, 3))
    mechanism = Mechanism((ROD,), radius, speed, start_hub)
    scene = Scene(mechanism, Effects(stiffness=stiffness, damping=damping, gravity=gravity))

    def equation(time: float, state: np.ndarray) -> tuple[float, float]:
        angle, rate = state
        weight = 0.5 * gravity * math.sin(mechanism.hub_angle(time) + angle)
        centrifugal = 0.5 * radius * speed**2 * math.sin(angle)
        return rate, -3.0 * (stiffness * angle + damping * rate + centrifugal + weight)

    angle, rate = rng.uniform(-1.4, 1.4), rng.uniform(-1.0, 1.0)
    return scene, State(0.0, (start_hub + float(angle),), (speed + float(rate),)), equation


def flown(scene: Scene, start: State, accuracy: float, duration: float) -> Recording:
    """A flight as a pass runs it: a tenth of the accuracy for each stretch, 24 stretches a period at least."""
    plan = Plan(end=duration, accuracy=accuracy, longest_interval=2.0 * math.pi / 24.0)
    return run(scene, start, Extrapolation(0.1 * accuracy), EnergeticLaw(), plan)


def true_error(scene: Scene, start: State, equation: Callable[..., tuple[float, float]], end: State) -> float:
    mechanism = scene.mechanism
    relative = (start.angles[0] - mechanism.hub_start, start.rates[0] - mechanism.hub_speed)
    exact = solve_ivp(equation, (0.0, end.time), relative, method="DOP853", rtol=3e-14, atol=1e-15).y[:, -1]
    angle = end.angles[0] - mechanism.hub_angle(end.time)
    return max(abs(angle - exact[0]), abs(end.rates[0] - mechanism.hub_speed - exact[1]))


def test_error_of_random_flights_is_within_estimate_and_accuracy(
    record_property: Callable[[str, object], None],
) -> None:
    """Three hundred flights of 1 to 12 radians, asked for accuracies from 1e-3 to 1e-9.

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
    steps = [flown(scene, start, accuracy, 5.0).steps for accuracy in (1e-3, 1e-5, 1e-7, 1e-9)]
    assert steps == sorted(steps)
    assert steps[0] < steps[-1]
