"""Extremes and limits within one interval are found where closed forms put them."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.motion import with_bar
from bristle_sim.parameters import Belt, Hub, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings

FREE = replace(Tool(), bar=None, workpart=None)
COARSE = Settings(accuracy=0.1, samples_per_period=1)


class TestNothingElseIsMissed:
    """Extremes and the retraction limit within one interval, on a hub at rest, where alpha = A sin(w t + phase)."""

    RATE = math.sqrt(FREE.belt.stiffness / FREE.bristle.inertia_about_root)
    STILL = replace(FREE, hub=Hub(speed=0.0))

    @pytest.mark.parametrize("settings", [COARSE, Settings()])
    @pytest.mark.parametrize("amplitude", [1.6, 2.0, 10.0])
    def test_limit_within_an_interval(self, amplitude: float, settings: Settings) -> None:
        """Thrown from the radial direction, past 90 degrees and back before the interval would end."""
        run = simulate(self.STILL, settings, start_relative_rate=-amplitude * self.RATE)
        assert run.stop_reason == "retraction limit"
        expected = math.asin(math.pi / 2.0 / amplitude) / self.RATE
        # Near its largest the angle hardly changes: the instant is magnified by 1/cos of the phase, 5 for 1.6.
        assert run.time[-1] == pytest.approx(expected, rel=5.0 * settings.accuracy)

    @pytest.mark.parametrize("outwards", [1.0, 1e5])
    def test_start_at_the_limit(self, outwards: float) -> None:
        """Released there, it swings back; thrown outwards, it ends at once."""
        angle = -math.pi / 2.0
        assert (
            simulate(self.STILL, start_relative_angle=angle).stop_reason
            == "end of the planned time"
        )
        run = simulate(self.STILL, start_relative_angle=angle, start_relative_rate=-outwards)
        assert run.stop_reason == "retraction limit"
        # Rates below 1e-10 of the scene's units have no sign, and the angle at which they do is as small.
        assert run.time[-1] * self.RATE < 1e-4

    @pytest.mark.parametrize("phase", np.linspace(-3.0, 3.0, 12).tolist())
    def test_extremes_in_the_first_interval(self, phase: float) -> None:
        """Rate A w cos: retraction is largest where the phase is -pi/2, first of three alike, the speed where it is 0, modulo 2 pi."""
        start = {
            "start_relative_angle": math.sin(phase),
            "start_relative_rate": self.RATE * math.cos(phase),
        }
        scene = simulate(self.STILL, Settings(samples_per_period=1), **start)
        reference = simulate_reference(self.STILL, accuracy=1e-9, **start)
        for run, (name, at) in itertools.product(
            (scene, reference),
            (("largest retraction", -math.pi / 2.0), ("highest relative speed", 0.0)),
        ):
            found = [event.time * self.RATE for event in run.events if event.name == name]
            instants = np.arange((at - phase) % (2.0 * math.pi), 6.0 * math.pi, 2.0 * math.pi)
            expected = instants[:1] if name == "largest retraction" else instants
            # The requested accuracy, over the largest phase of three periods.
            assert found == pytest.approx(expected, abs=6.0 * math.pi * 1e-6)


def test_no_belt_no_speed_no_harm() -> None:
    """A bristle that nothing moves beside a bar meets nothing and takes next to no steps."""
    still = replace(with_bar(1e-3), hub=Hub(speed=0.0), belt=Belt(stiffness=0.0))
    run = simulate(still, COARSE)
    assert run.contacts == ()
    assert run.cost.steps < 2000
