"""Hubs at rest, creeping and fast keep their promises, and the promises notice a program that is broken."""

import dataclasses
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.hub_speed import cases
from bristle_sim.parameters import Belt, Bristle, Hub, Tool
from bristle_sim.scene import time_scales
from bristle_sim.scene import tool as scene_tool
from bristle_sim.scene.build import Effects
from bristle_sim.scene.mechanism import Mechanism
from bristle_sim.scene.tool import simulate, tool_units
from bristle_sim.settings import Settings

FREE = Tool(bar=None, workpart=None)


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def named(*names: str) -> list[HardCase]:
    found = [case for case in cases(full=False) if case.name in names]
    assert len(found) == len(names)
    return found


@pytest.mark.parametrize("retraction", [1e-6, 0.3, 1.5])
def test_belt_on_a_hub_at_rest_is_isochronous(retraction: float) -> None:
    """2 pi sqrt(I/k) whatever the retraction, and all of the energy back after each period."""
    tool = replace(FREE, hub=Hub(speed=0.0))
    run = simulate(tool, start_relative_angle=-retraction)
    times = np.array([event.time for event in run.events if event.name == "highest relative speed"])
    period = 2.0 * math.pi * math.sqrt(tool.bristle.inertia_about_root / tool.belt.stiffness)
    # The accuracy asked for.
    np.testing.assert_allclose(times, (np.arange(len(times)) + 0.25) * period, rtol=1e-6)
    assert np.ptp(run.total_energy) <= 2e-6 * run.total_energy[0]


@pytest.mark.parametrize("speed", [5e-324, 1e-300, 1e-160, 1e-100])
@pytest.mark.parametrize("belt", [Belt(), Belt(stiffness=0.0), Belt(stiffness=0.0, damping_ratio=1.0)])
def test_hub_slower_than_numbers_can_tell(speed: float, belt: Belt) -> None:
    """Units stay numbers whose products are numbers, also for the smallest bristle; a run says why it ends."""
    bristle = Bristle(length=1e-9, mass=1e-30)
    for tool in (
        Tool(hub=Hub(speed=speed), belt=belt),
        replace(FREE, hub=Hub(speed=speed), belt=belt, bristle=bristle),
    ):
        units = tool_units(tool)
        sizes = (units.time, units.energy, units.angular_damping, units.acceleration, units.impulse)
        assert all(0.0 < size < math.inf for size in sizes)
        run = simulate(tool, Settings(maximum_steps=3000))
        assert run.stop_reason in ("step budget spent", "end of the planned time", "retraction limit")
        assert np.isfinite(run.rates).all()


@pytest.mark.parametrize("seed", range(4))
def test_similar_passes_at_any_speed(seed: int) -> None:
    """With belt stiffness and gravity as the square of the hub's speed, the pass is the same in the hub's angle."""
    rng = np.random.default_rng(seed)
    ratio = 10.0 ** rng.uniform(-5.0, 3.0)
    gravity = float(rng.uniform(0.0, min(1.0, 1.0 / ratio**2)) * 1e3)
    first = simulate(Tool(gravity=gravity), stop_after="strike")
    fast = Tool(
        hub=Hub(speed=261.8 * ratio), belt=Belt(stiffness=Belt().stiffness * ratio**2), gravity=gravity * ratio**2
    )
    second = simulate(fast, stop_after="strike")
    # The accuracy asked for, on each side.
    assert second.hub_angle[-1] == pytest.approx(first.hub_angle[-1], rel=2e-6)
    assert second.relative_angle[-1] == pytest.approx(first.relative_angle[-1], abs=2e-6)
    assert second.rates[-1, 0] / ratio == pytest.approx(first.rates[-1, 0], rel=2e-6)


def test_centrifugal_field_takes_over() -> None:
    """At 1e5 rad/s the default's belt is 8e-5 of what turns the bristle back: 3 k/(m L^2) over 3/2 (r_h/L) w^2."""
    found = [
        simulate(
            replace(FREE, hub=Hub(speed=1e5), belt=belt),
            Settings(accuracy=1e-9),
            start_relative_angle=-0.01,
            stop_after="highest relative speed",
        ).time[-1]
        for belt in (Belt(), Belt(stiffness=0.0))
    ]
    belt, field = 3.0 * Belt().stiffness / (8.387e-5 * 0.027**2), 1.5 * 0.0275 / 0.027 * 1e10
    # Both swings take longer than harmonic ones by 1/16 of their square; they are found from rates a hundred times theirs.
    assert found[0] / found[1] == pytest.approx(1.0 / math.sqrt(1.0 + belt / field), rel=2e-8)
    assert belt / field == pytest.approx(8e-5, rel=0.1)


class TestBroken:
    def test_another_speed(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Ten times the limit."""

        def mechanism(*values: Any) -> Mechanism:
            found = Mechanism(*values)
            return dataclasses.replace(found, hub_speed=found.hub_speed * (1.0 + 1e-5))

        monkeypatch.setattr(scene_tool, "Mechanism", mechanism)
        for case in named(
            "100000 rad/s: released, accuracy 1e-06", "1000 rad/s: whole pass", "100000 rad/s: released, no belt"
        ):
            assert not case.measure().ok

    def test_a_belt_that_is_not_there(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def effects(stiffness: float | None = None, **others: Any) -> Effects:
            return Effects(stiffness=(stiffness or 0.0) + 1e-5, **others)

        monkeypatch.setattr(scene_tool, "Effects", effects)
        for case in named("100000 rad/s: released, no belt", "at rest: three periods"):
            assert not case.measure().ok

    def test_energy_lost(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Steps as coarse as an accuracy of 1e-4 asks for, where 1e-9 is promised."""
        monkeypatch.setattr(time_scales, "LOCAL_SHARE", 1e4)
        (case,) = named("at rest: three periods")
        assert not case.measure().ok

    def test_a_bristle_that_gravity_moves(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def effects(gravity: float = 0.0, **others: Any) -> Effects:
            return Effects(gravity=gravity + 1e-5, **others)

        monkeypatch.setattr(scene_tool, "Effects", effects)
        (case,) = named("at rest: whole pass")
        assert not case.measure().ok
