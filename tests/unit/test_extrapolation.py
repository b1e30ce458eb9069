"""Extrapolation of engine steps: its weights, and its error against estimate and tolerance.

Free flights are compared with scipy's integrator at a tolerance of 3e-14 on the equation

    a'' = -3 (k a + c a' + (r/2) w^2 sin a + (g/2) sin(psi + a))

of a rod of mass and length 1 on a hub of radius r (moment of inertia about the root 1/3).
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from bristle_sim.scene import extrapolation as repetitions
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.run import run
from bristle_sim.scene.system import Plan, Recording, System

REFEREE = 1e-13
"""Error of scipy's integration over a few radians."""


def test_repetitions_remove_one_power_of_the_step_each() -> None:
    """Weights add up to 1 and annihilate n^-j, j = 1 ... rows - 1; they magnify rounding by their own size."""
    for table in (repetitions.CLOSE, repetitions.WIDE):
        for row, weights in enumerate(table.weights):
            counts = np.array(table.counts[: row + 1], dtype=float)
            for power in range(row + 1):
                scale = np.abs(weights) @ counts**-power
                assert abs(weights @ counts**-power - (power == 0)) < 1e-14 * scale


def random_flight(
    rng: np.random.Generator,
) -> tuple[Scene, State, Callable[..., tuple[float, float]]]:
    """A rod on a hub with each of belt, damping and gravity there or not; natural rates are at most of order 1.

    Gravity is weaker than the belt: an inverted pendulum would magnify errors without bound, which no estimate knows.
    """
    stiffness = float(rng.uniform(0.01, 0.33))
    most = {"radius": 1.0, "damping": 0.5, "gravity": stiffness}
    radius, damping, gravity = (
        float(rng.choice([0.0, rng.uniform(0.0, each)])) for each in most.values()
    )
    speed = float(rng.uniform(-1, 1))
    start_hub = float(rng.uniform(-3, 3))
    mechanism = Mechanism((Link.rod(1.0, 1.0),), radius, speed, start_hub)
    scene = Scene(mechanism, Effects(stiffness=stiffness, damping=damping, gravity=gravity))

    def equation(time: float, state: np.ndarray) -> tuple[float, float]:
        angle, rate = state
        weight = 0.5 * gravity * math.sin(mechanism.root_angle(time) + angle)
        centrifugal = 0.5 * radius * speed**2 * math.sin(angle)
        return rate, -3.0 * (stiffness * angle + damping * rate + centrifugal + weight)

    angle = rng.uniform(-1.4, 1.4)
    rate = rng.uniform(-1.0, 1.0)
    return scene, State(0.0, (start_hub + float(angle),), (speed + float(rate),)), equation


def flown(scene: Scene, start: State, accuracy: float, duration: float) -> Recording:
    """A flight as a pass runs it: a tenth of the accuracy for each interval, 24 intervals a period at least."""
    plan = Plan(end=duration, accuracy=accuracy, longest_interval=2.0 * math.pi / 24.0)
    system = System(scene, start, Extrapolation(0.1 * accuracy), plan)
    for _ in run(system):
        pass
    return system.recording


def true_error(
    scene: Scene, start: State, equation: Callable[..., tuple[float, float]], end: State
) -> float:
    mechanism = scene.mechanism
    relative = (start.angles[0] - mechanism.hub_start, start.rates[0] - mechanism.hub_speed)
    exact = solve_ivp(
        equation, (0.0, end.time), relative, method="DOP853", rtol=3e-14, atol=1e-15
    ).y[:, -1]
    angle = end.angles[0] - mechanism.root_angle(end.time)
    return max(abs(angle - exact[0]), abs(end.rates[0] - mechanism.hub_speed - exact[1]))


def test_an_interval_without_a_fourth_repetition_adds_little_to_the_error() -> None:
    """The estimate is at most a quarter of the permitted error, and the error a quarter of the estimate."""
    rng = np.random.default_rng(7)
    stepper = Extrapolation(1e-3)
    errors = []
    for _ in range(300):
        scene, start, equation = random_flight(rng)
        result = stepper.advance(scene, start, float(rng.uniform(0.3, 1.6)))
        if result.errors.keys() == {2} and result.error <= stepper.noise:
            errors.append(true_error(scene, start, equation, result.state))
    assert len(errors) > 10
    assert max(errors) < stepper.noise / 16.0


def test_an_interval_after_an_overflow_is_as_accurate_as_before() -> None:
    """The engine starts a step from the joint impulses of the last one, which are not numbers then.

    NumPy must not warn of the overflow: the interval is rejected, and a shorter one follows.
    """
    links = tuple(Link.rod(1.0, 1.0) for _ in range(3))
    scene = Scene(Mechanism(links, 1.0, 1.0, 0.0), Effects(stiffness=0.3))
    start = State(0.0, (0.1,) * 3, (1.0,) * 3)
    stepper = Extrapolation(1e-9)
    expected = stepper.advance(scene, start, 0.1)
    assert stepper.advance(scene, start._replace(rates=(1e308, 0.0, 0.0)), 0.1).error == math.inf
    found = stepper.advance(scene, start, 0.1)
    assert found.error <= stepper.noise
    assert np.abs(np.subtract(found.state.rates, expected.state.rates)).max() < stepper.noise


def test_error_of_random_flights_is_within_estimate_and_accuracy(
    record_property: Callable[[str, object], None],
) -> None:
    """A hundred and twenty flights of 1 to 12 radians, with requested accuracies from 1e-3 to 1e-9.

    The estimate is that of the extrapolate before the last and adds up absolute errors, so the true error should be a
    small share of it: more than the estimate means that it lies, less than 1e-4 of it that steps are wasted.
    """
    rng = np.random.default_rng(2020)
    shares = []
    met = []
    for number in range(120):
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


def test_with_damping_no_error_estimate_is_below_a_tenth_of_the_one_before() -> None:
    """A difference of two results that is small by chance is not trusted where damping is fast."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, 1.0, 0.2)
    scene = Scene(mechanism, Effects(stiffness=0.3, damping=0.2))
    raised = 0
    for duration in (0.02, 0.05, 0.1, 0.2):
        stepper = Extrapolation(1e-9, damped_step=1.0)
        result = stepper.advance(scene, State(0.0, (0.5,), (0.3,)), duration)
        *_, before, last = result.errors.values()
        assert result.error == min(max(last, 0.1 * before), stepper.noise)
        raised += result.error > last
    assert raised > 0
