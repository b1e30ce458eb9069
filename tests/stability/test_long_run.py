"""Many turns on end keep their promises: energy in the hub's frame, and the pivot that holds the bristle."""

import math

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases import long_run
from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.long_run import RETRACTION, cases, free_tool, jacobi_energy
from bristle_sim.scene import tool as scene_tool
from bristle_sim.scene.build import Scene
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.theory import cueing

QUICK = cases(full=False)


@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def test_jacobi_energy_of_the_release() -> None:
    """At rest in the release and at the highest speed of the energy integral, radial: the same, by the closed form."""
    tool = free_tool()
    bristle, hub = tool.bristle, tool.hub
    centrifugal = cueing.centrifugal_stiffness(bristle.mass, hub.radius, bristle.length, hub.speed)
    speed = cueing.stiffened_highest_speed(RETRACTION, tool.belt.stiffness, centrifugal, bristle.inertia_about_root)
    energies = jacobi_energy(tool, np.array([-RETRACTION, 0.0]), np.array([0.0, float(speed)]))
    assert energies[1] == pytest.approx(energies[0], rel=1e-12)


def test_full_effort_turns_ten_thousand_times() -> None:
    assert any(case.name.startswith("10000 hub turns") for case in cases(full=True))


def test_a_careless_stepper_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (scene_tool, long_run):
        monkeypatch.setattr(module, "stepper_for", lambda *_: Extrapolation(1e-3))
    assert not QUICK[0].measure().ok
    assert not QUICK[1].measure().ok


def test_a_pivot_that_is_left_open_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Scene, "correct_joints", lambda *_, **__: None)
    finding = QUICK[3].measure()
    assert not finding.ok
    assert "pivot gap" in finding.reached


def test_a_loss_of_energy_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A damping of a millionth of the critical one takes 1 - exp(-2 zeta w t) of the energy: 5e-5 a turn."""
    built = scene_tool.Effects

    def damped(**given: float) -> object:
        return built(**(given | {"damping": 2e-6 * math.sqrt(given["stiffness"] / 3.0)}))

    monkeypatch.setattr(scene_tool, "Effects", damped)
    for case in QUICK[:4]:
        assert not case.measure().ok, case.name
