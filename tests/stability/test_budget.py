"""A run that cannot finish within its steps says so, goes no further, and is no result; the promises notice otherwise."""

from __future__ import annotations

import importlib.util
import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.budget import ONE_STRETCH, SPENT, arrays_of, cases, within_budget
from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.parameters import Contact, Tool, Workpart
from bristle_sim.scenario_cli import main
from bristle_sim.scene import tool as scene_tool
from bristle_sim.scene.plan import Plan
from bristle_sim.scene.progress import Progress
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import Trajectory

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def kept(part: str = "") -> list[bool]:
    found = [case.run().ok for case in cases(full=False) if part in case.name and ".py" not in case.name]
    assert found
    return found


class TestPromisesNotice:
    def test_a_budget_that_is_not_kept(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def later(**given: Any) -> Plan:
            return Plan(**(given | {"maximum_steps": given["maximum_steps"] + 2 * ONE_STRETCH}))

        monkeypatch.setattr(scene_tool, "Plan", later)
        assert not any(kept("flight; 1"))

    def test_a_run_that_hides_it(self, monkeypatch: pytest.MonkeyPatch) -> None:
        stop = Progress.stop
        monkeypatch.setattr(Progress, "stop", lambda progress, _: stop(progress, StopReason.END))
        assert not any(kept())

    def test_numbers_that_are_not_finite(self, monkeypatch: pytest.MonkeyPatch) -> None:
        sample = Progress.sample
        monkeypatch.setattr(Progress, "sample", lambda progress, _: sample(progress, float("nan")))
        assert not any(kept())


def samples(run: Trajectory) -> np.ndarray:
    return np.column_stack([run.time, run.angles, run.rates, run.normal_force])


TOOLS = {
    "pass": Tool(),
    "in time": Tool(contact=Contact("compliant")),
    "restituting": Tool(workpart=Workpart(restitution=0.9)),
}


class TestWholeAndPart:
    @pytest.mark.parametrize("name", TOOLS)
    def test_what_was_reached_is_the_beginning_of_the_whole(self, name: str) -> None:
        """A budget changes nothing but the end: to the bit, every sample and contact up to there."""
        whole = simulate(TOOLS[name])
        for share in (1e-6, 0.1, 0.5, 0.9):
            part = simulate(TOOLS[name], Settings(maximum_steps=1 + int(share * whole.cost.steps)))
            assert part.stop_reason == SPENT
            assert np.array_equal(samples(part), samples(whole)[: len(part.time)])
            assert part.time[-1] < whole.time[-1]
            finished = [replace(each, history=None) for each in part.contacts if each.outcome != SPENT]
            assert finished == [replace(each, history=None) for each in whole.contacts[: len(finished)]]

    @pytest.mark.parametrize("settings", [Settings(), Settings(step=2e-5)])
    def test_exactly_as_many_steps_as_it_takes(self, settings: Settings) -> None:
        steps = simulate(Tool(), settings).cost.steps
        assert simulate(Tool(), replace(settings, maximum_steps=steps)).stop_reason == "end of the planned time"
        assert simulate(Tool(), replace(settings, maximum_steps=10**30)).cost.steps == steps

    def test_the_last_stretch_is_all_that_goes_beyond(self) -> None:
        for budget in (1, 37, 400, 3000, 8000):
            run = simulate(Tool(), Settings(maximum_steps=budget))
            assert within_budget(run, budget, ONE_STRETCH).ok

    def test_absences_and_a_hold_are_entered(self) -> None:
        """What had not happened yet is said, and a hold that the budget ends is in the ledger by that name."""
        assert [each.name for each in simulate(Tool(), Settings(maximum_steps=1)).events] == [
            "bar not touched",
            "workpart not reached",
        ]
        outcomes = {
            each.outcome
            for budget in range(2000, 8000, 1000)
            for each in simulate(Tool(), Settings(maximum_steps=budget)).contacts
            if each.law == "hold"
        }
        assert SPENT in outcomes


def test_fixed_steps_take_no_more_than_their_budget_in_flight() -> None:
    """Between events each stretch is one step."""
    free = replace(Tool(), bar=None, workpart=None)
    for budget, angle in itertools.product((1, 7, 100), (0.0, -0.3)):
        run = simulate(free, Settings(step=1e-5, maximum_steps=budget), start_relative_angle=angle)
        assert run.stop_reason == SPENT
        # The start of a release is looked at again, for an event there.
        assert run.cost.steps <= budget + 100
        assert all(np.isfinite(each).all() for each in arrays_of(run))


@pytest.mark.parametrize("name", ["cue_and_impact", "cue_timing"])
def test_scripts_end_with_one_line(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit status 2, nothing but one line on stderr."""
    monkeypatch.setattr(scene_tool, "Plan", lambda **given: Plan(**(given | {"maximum_steps": 50})))
    description = importlib.util.spec_from_file_location(name, ROOT / "scenarios" / f"{name}.py")
    assert description is not None
    assert description.loader is not None
    script = importlib.util.module_from_spec(description)
    description.loader.exec_module(script)
    assert main(script.SCENARIO, []) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert SPENT in err
    assert err.count("\n") == 1
