"""Fixed steps of the engine: their observed order against a closed form, loads, and what they know of their error."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.integrate.extrapolation import PlainSteps, Stepper
from bristle_sim.scene.mechanism import Link, Mechanism, State

ROD = Link.rod(1.0, 1.0)


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
    """Angle and rate at the end, interval by interval."""
    while duration - state.time > 1e-12:
        length = stepper.propose(duration - state.time)
        result = stepper.advance(scene, state, length)
        if stepper.accepts(result, length):
            state = result.state
    return np.array([state.angles[0], state.rates[0]])


def observed_order(damping: float) -> float:
    """Slope of error over step in a doubly logarithmic plot, from 128 to 1024 steps a radian; steps add up exactly."""
    scene, start, exact = oscillator(damping)
    counts = np.array([256, 512, 1024, 2048])
    errors = [np.abs(carried(PlainSteps(2.0 / count), scene, start, 2.0) - exact(2.0)).max() for count in counts]
    return float(-np.polyfit(np.log(counts), np.log(errors), 1)[0])


class TestOrder:
    """The next power of the step is 1/100 of the first at the coarsest step here: orders come out within a few 0.01."""

    @pytest.mark.parametrize("damping", [0.0, 0.3])
    def test_plain_steps_are_of_first_order(self, damping: float) -> None:
        assert observed_order(damping) == pytest.approx(1.0, abs=0.03)
