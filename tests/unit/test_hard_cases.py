"""The closed forms that hard cases are compared with solve their equations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle_sim.benchmarks.accuracy_cost import study
from bristle_sim.benchmarks.accuracy_cost.study import Effort
from bristle_sim.benchmarks.hard_cases import report
from bristle_sim.benchmarks.hard_cases.motion import FREE, damped_decay, jacobi_energy
from bristle_sim.comparison import Unfinished
from bristle_sim.dissertation import figures
from bristle_sim.theory import cueing


class TestDampedDecay:
    @pytest.mark.parametrize("ratio", [0.0, 1e-9, 0.3, 1.0, 1.5, 10.0, 100.0])
    def test_solves_the_equation(self, ratio: float) -> None:
        """A library's integrator, at a relative tolerance of 1e-11, on a'' + 2 zeta a' + a = 0."""
        phase = np.linspace(0.0, 20.0, 41)
        solution = solve_ivp(
            lambda _, state: (state[1], -state[0] - 2.0 * ratio * state[1]),
            (0.0, 20.0),
            (1.0, 0.0),
            method="Radau" if ratio > 10.0 else "DOP853",
            t_eval=phase,
            max_step=0.5 / (1.0 + ratio) if ratio <= 10.0 else math.inf,
            rtol=1e-11,
            atol=1e-13,
        )
        # Some hundred steps of that tolerance.
        np.testing.assert_allclose(damped_decay(ratio, phase), solution.y, rtol=0.0, atol=1e-9)

    def test_slow_exponent_keeps_its_digits(self) -> None:
        """At 1e8 the bristle creeps as e^(-p/(2 zeta)), to 1/(4 zeta^2)."""
        phase = np.array([0.0, 1e7, 1e8])
        np.testing.assert_allclose(damped_decay(1e8, phase)[0], np.exp(-phase / 2e8), rtol=1e-12)


def interrupted(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("module", "step", "run", "kept"),
    [
        (report, "cases_of", lambda: report.hard_cases(report.HardCaseChoice("grazing", "quick")), "rows"),
        (study, "_measure", lambda: study.accuracy_cost(Effort("quick", "none")), "curves"),
        (figures, "redrawn", lambda: figures.figures_report(figures.Selection("4.6")), None),
    ],
)
def test_an_interruption_keeps_what_is_finished(module, step, run, kept, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, step, interrupted)
    with pytest.raises(Unfinished) as ended:
        run()
    assert kept is None or ended.value.report.extra[kept] == []


def test_jacobi_energy_of_the_release() -> None:
    """At rest in the release and at the highest speed of the energy integral, radial: the same, by the closed form."""
    bristle, hub = FREE.bristle, FREE.hub
    centrifugal = cueing.centrifugal_stiffness(bristle.mass, hub.radius, bristle.length, hub.speed)
    speed = cueing.stiffened_highest_speed(0.77, FREE.belt.stiffness, centrifugal, bristle.inertia_about_root)
    energies = jacobi_energy(FREE, np.array([-0.77, 0.0]), np.array([0.0, float(speed)]))
    assert energies[1] == pytest.approx(energies[0], rel=1e-12)
