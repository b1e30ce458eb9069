"""The closed forms that hard cases are compared with solve their equations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle_sim.benchmarks.accuracy_cost import study
from bristle_sim.benchmarks.accuracy_cost.study import Effort
from bristle_sim.benchmarks.hard_cases import report
from bristle_sim.benchmarks.hard_cases.motion import FREE, jacobi_energy
from bristle_sim.comparison import Unfinished
from bristle_sim.dissertation import figures
from bristle_sim.theory import cueing
from bristle_sim.theory.impact import energetic_impact
from stability.cases.jam import rod_near_jam
from stability.cases.motion import damped_decay


class TestDampedDecay:
    @pytest.mark.parametrize("ratio", [0.0, 1e-9, 0.3, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.5, 10.0, 100.0])
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

    def test_critical_is_the_limit_of_both_sides(self) -> None:
        """(1 + p) e^-p at 1; 1e-9 beside it changes the angle by less than 1e-9, across both ways of computing it."""
        phase = np.linspace(0.0, 400.0, 401)
        expected = ((1.0 + phase) * np.exp(-phase), -phase * np.exp(-phase))
        for ratio in (1.0 - 1e-9, 1.0, 1.0 + 1e-9):
            np.testing.assert_allclose(damped_decay(ratio, phase), expected, rtol=0.0, atol=1e-9)

    def test_slow_exponent_keeps_its_digits(self) -> None:
        """At 1e8 the bristle creeps as e^(-p/(2 zeta)), to 1/(4 zeta^2)."""
        phase = np.array([0.0, 1e7, 1e8])
        np.testing.assert_allclose(damped_decay(1e8, phase)[0], np.exp(-phase / 2e8), rtol=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_one_rod_near_its_jam_by_the_general_law(seed: int) -> None:
    """The law of any bodies with K = 3/m (sin, cos)(sin, cos)^T; pulled along its line, pushed in any direction."""
    rng = np.random.default_rng(seed)
    angle, e = rng.uniform(0.1, 1.4), rng.uniform(0.1, 1.0)
    distance = rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.8)
    for at, velocity in ((-angle, (-math.sin(angle), math.cos(angle))), (angle, (-rng.uniform(0.1, 1.0), 1.0))):
        lever = np.array([math.sin(at), math.cos(at)])
        law = energetic_impact(3.0 * np.outer(lever, lever), velocity, math.tan(angle) * (1.0 + distance), e)
        outcome, impulse = rod_near_jam(at, velocity, distance, e)
        assert law.outcome_name == outcome
        # A hundred roundings: 20 over a distance of at least a fifth.
        assert impulse == pytest.approx(law.impulse_normal, rel=100 * 2.0**-52)


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
