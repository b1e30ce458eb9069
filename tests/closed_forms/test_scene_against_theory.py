"""The pymunk scene against closed forms: harmonic and damped flight, pendulums."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipj

from bristle_sim.parameters import Belt, Hub, Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings

FREE = Tool(bar=None, workpart=None)
ON_AXIS = replace(FREE, hub=Hub(radius=0.0))
ACCURACIES = [1e-4, 1e-7, 1e-10]


def natural_rate(tool: Tool) -> float:
    return math.sqrt(3.0 * tool.belt.stiffness / (tool.bristle.mass * tool.bristle.length**2))


class TestFlight:
    """A run asks each interval for a tenth of the accuracy; some twenty intervals of a pass add up to less than ten of it."""

    @pytest.mark.parametrize("accuracy", ACCURACIES)
    @pytest.mark.parametrize("damping", [0.0, 0.018, 0.7])
    @pytest.mark.parametrize("hub_speed", [0.0, 261.8])
    def test_belt_oscillation(self, accuracy: float, damping: float, hub_speed: float) -> None:
        """Root on the hub's axis: a complex exponential, however fast the hub turns."""
        tool = replace(
            ON_AXIS, hub=Hub(speed=hub_speed, radius=0.0), belt=Belt(damping_ratio=damping)
        )
        run = simulate(
            tool, Settings(accuracy=accuracy), start_relative_angle=-0.6, start_relative_rate=300.0
        )
        natural = natural_rate(tool)
        exponent = natural * complex(-damping, math.sqrt(1.0 - damping**2))
        amplitude = complex(-0.6, (exponent.real * -0.6 - 300.0) / exponent.imag)
        motion = amplitude * np.exp(exponent * run.time)
        np.testing.assert_allclose(run.relative_angle, motion.real, rtol=0.0, atol=accuracy)
        np.testing.assert_allclose(
            run.relative_rate, (exponent * motion).real, rtol=0.0, atol=accuracy * natural
        )
        fastest = run.event_time("highest relative speed")
        assert fastest is not None
        acceleration = (exponent**2 * amplitude * np.exp(exponent * fastest)).real
        assert abs(acceleration) <= 10.0 * accuracy * natural**2

    @pytest.mark.parametrize("speed", [0.0, 261.8])
    def test_pendulum(self, speed: float) -> None:
        """No belt: sin(a/2) = sin(a_0/2) cd(t sqrt(3 g/2L)), in gravity or in the rotating root's field r_h w^2."""
        tool = replace(
            FREE, hub=Hub(speed=speed), belt=Belt(stiffness=0.0), gravity=0.0 if speed else 9.81
        )
        rate = math.sqrt(1.5 * (0.0275 * speed**2 or 9.81) / 0.027)
        run = simulate(
            tool, Settings(accuracy=1e-9), start_hub_angle=0.3, start_relative_angle=-1.3
        )
        swing, start = (run.relative_angle, -1.3) if speed else (run.angles[:, 0], -1.0)
        _, cosine, delta, _ = ellipj(rate * run.time, math.sin(0.5 * start) ** 2)
        np.testing.assert_allclose(
            swing, 2.0 * np.arcsin(math.sin(0.5 * start) * cosine / delta), rtol=0.0, atol=1e-8
        )
        fastest = run.event_time("highest relative speed")
        assert fastest is not None
        # Where the field's potential is least.
        lowest = 0.3 + speed * fastest if speed else 0.0
        assert run.at(fastest).angles[0] == pytest.approx(lowest, abs=1e-7)
