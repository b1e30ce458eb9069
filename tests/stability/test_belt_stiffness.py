"""Stiff and soft belts keep their promises, and the promises notice a program that is broken."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.belt_stiffness import (
    DEFAULT,
    beside_reference,
    budget_spent,
    cases,
    release_beside_closed_form,
)
from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.parameters import Bar, Belt, Hub, Tool
from bristle_sim.scene import time_scales
from bristle_sim.scene import tool as scene_tool
from bristle_sim.scene.build import Effects
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.stepping import PlainSteps
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.whole_pass import whole_pass
from bristle_sim.theory.cueing import stiffened_cue_time, stiffened_highest_speed

FREE = Tool(bar=None, workpart=None)


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def test_every_kind_is_tried_in_both_efforts() -> None:
    quick, full = ({case.name for case in cases(full=full)} for full in (False, True))
    assert quick < full
    assert len(full) == len(cases(full=True))


@pytest.mark.parametrize("seed", range(6))
def test_release_of_any_belt(seed: int) -> None:
    """Stiffness over nine decades and retractions up to 85 degrees, beside the energy integral."""
    rng = np.random.default_rng(seed)
    tool = replace(FREE, belt=Belt(stiffness=DEFAULT * 10.0 ** rng.uniform(-3.0, 6.0)))
    retraction = float(rng.uniform(0.1, 1.48))
    run = simulate(tool, start_relative_angle=-retraction, stop_after="highest relative speed")
    bristle, hub = tool.bristle, tool.hub
    field = 0.5 * bristle.mass * hub.radius * bristle.length * hub.speed**2
    inertia = bristle.mass * bristle.length**2 / 3.0
    # The accuracy asked for.
    time = stiffened_cue_time(retraction, tool.belt.stiffness, field, inertia)
    speed = stiffened_highest_speed(retraction, tool.belt.stiffness, field, inertia)
    assert run.time[-1] == pytest.approx(time, rel=1e-6)
    assert run.relative_rate[-1] == pytest.approx(speed, rel=1e-6)


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("radians", [0.26, 0.03])
def test_fixed_steps_are_the_symplectic_map(factor: float, radians: float) -> None:
    """On a hub at rest x_n = x_0 cos((n - 1/2) u)/cos(u/2), 2 sin(u/2) = w h, as drift and kick give, up to a first event."""
    tool = replace(FREE, hub=Hub(speed=0.0), belt=Belt(stiffness=DEFAULT * factor))
    rate = math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)
    run = simulate(tool, Settings(step=radians / rate), start_relative_angle=-0.5)
    whole = int(1.5 / radians)
    turn = 2.0 * math.asin(0.5 * radians)
    expected = -0.5 * np.cos((np.arange(whole) - 0.5) * turn) / math.cos(0.5 * turn)
    # A step moves the centre along its tangent: a third of the cube of what it turns by, at most w h x_0, each.
    np.testing.assert_allclose(run.relative_angle[:whole], expected, rtol=0.0, atol=whole * (0.5 * radians) ** 3 / 3.0)


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e6])
def test_the_longest_step_allowed_is_a_24th_of_the_period(factor: float) -> None:
    tool = replace(FREE, hub=Hub(speed=0.0), belt=Belt(stiffness=DEFAULT * factor))
    longest = 2.0 * math.pi / 24.0 * math.sqrt(tool.bristle.inertia_about_root / tool.belt.stiffness)
    settings = Settings(step=longest * (1.0 - 1e-12))
    assert simulate(tool, settings, start_relative_angle=-0.1).stop_reason == "end of the planned time"
    with pytest.raises(ValueError, match=r"^step = \S+: at most \S+ is allowed .* \(in s\)$"):
        simulate(tool, Settings(step=longest * (1.0 + 1e-12)), start_relative_angle=-0.1)


def scaled_belt(monkeypatch: pytest.MonkeyPatch, factor: float) -> None:
    """Build every scene with a belt that is off by a factor."""

    def effects(stiffness: float | None = None, **others: Any) -> Effects:
        return Effects(stiffness=None if stiffness is None else stiffness * factor, **others)

    monkeypatch.setattr(scene_tool, "Effects", effects)


def test_a_belt_off_by_little_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Times go as the root of the stiffness: 4e-6 of it is twice the limit."""
    scaled_belt(monkeypatch, 1.0 + 4e-6)
    assert not release_beside_closed_form(FREE, 1e-6).ok
    assert not beside_reference(Tool(), 1e-6).ok


def test_steps_that_gain_energy_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    class Gaining(PlainSteps):
        def advance(self, *args: Any, **others: Any) -> Any:
            found = super().advance(*args, **others)
            state = found.state
            return found._replace(state=State(state.time, state.angles, tuple(1.02 * each for each in state.rates)))

    monkeypatch.setattr(time_scales, "PlainSteps", Gaining)
    long = [case for case in cases(full=False) if "longest step" in case.name]
    assert long
    assert not any(case.measure().ok for case in long)


def test_a_step_let_through_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A program that takes other steps than those asked for."""
    monkeypatch.setattr(scene_tool, "stepper_for", lambda *_: Extrapolation(1e-4))
    (case,) = (case for case in cases(full=False) if case.name == "belt x 1: fixed step of 2.5 rad")
    assert not case.run().ok


def test_a_run_that_ends_within_its_budget_has_not_spent_it() -> None:
    assert not budget_spent(FREE, 100_000).ok


@pytest.mark.parametrize(
    ("tool", "allowed"),
    [
        (Tool(belt=Belt(stiffness=1e5 * Tool().belt.stiffness)), "softer belt"),
        (Tool(bar=Bar(friction=5.0)), "bar_friction"),
    ],
)
def test_a_hold_that_the_engine_cannot_follow_is_no_result(tool: Tool, allowed: str) -> None:
    """The bar would let go later, and the wire strike: "no contact" would be wrong, so it is refused in one line."""
    with pytest.raises(ValueError, match=allowed) as refused:
        whole_pass(tool, Settings())
    assert "\n" not in str(refused.value)
