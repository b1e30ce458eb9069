"""Taps add up in finite time, with extrapolated and with fixed steps; the promises notice if they do not."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.chatter import SURFACE, cases, falling, most_taps, tapping, taps_of
from bristle_sim.parameters import Tool, Workpart
from bristle_sim.scene import transitions
from bristle_sim.scene.contact_laws import Coefficients
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.tool import simulate, tool_units
from bristle_sim.settings import Settings


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def kept(part: str) -> list[bool]:
    found = [case.run().ok for case in cases(full=False) if part in case.name]
    assert found
    return found


class TestPromisesNotice:
    def test_fixed_steps_that_tap_for_ever(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Without a stepper's step, every hop is followed: the least speed e a h/(1 - e) never falls to rest."""
        monkeypatch.setattr(transitions, "_stays", lambda _progress, record: record.velocity_after[0] <= 1e-8)
        assert not any(kept("whole pass"))

    def test_another_restitution(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """2 % more, which near 1 gains energy."""

        def livelier(obstacle: Obstacle) -> Coefficients:
            return Coefficients(obstacle.friction, obstacle.restitution_friction, min(1.02 * obstacle.restitution, 1.0))

        monkeypatch.setattr(transitions.Coefficients, "of", livelier)
        assert not any(kept("bar, restitution 0.5"))
        assert not any(kept("friction"))
        assert not any(kept("from 1e-4 rad, restitution 0.5"))

    def test_energy_gained(self, monkeypatch: pytest.MonkeyPatch) -> None:
        resolve = transitions.EnergeticLaw.resolve

        def gaining(*given: Any) -> Any:
            after, record = resolve(*given)
            lively = after._replace(rates=tuple(1.001 * rate for rate in after.rates))
            work = (record.restitutive_work[0] - 2.0 * record.compressive_work[0], record.restitutive_work[1])
            return lively, dataclasses.replace(record, restitutive_work=work)

        monkeypatch.setattr(transitions.EnergeticLaw, "resolve", gaining)
        monkeypatch.setattr("bristle_sim.scene.contact_laws.EnergeticLaw.resolve", gaining)
        assert not any(kept("falls 0.3 rad"))
        assert not any(kept("friction 0.3"))


class TestFalls:
    @pytest.mark.parametrize("restitution", [0.05, 0.3, 0.8, 0.95])
    @pytest.mark.parametrize("accuracy", [1e-3, 1e-8])
    def test_arrives_with_what_it_left_with(self, restitution: float, accuracy: float) -> None:
        """Conservation between two taps: the speed of arrival is that of departure; a tap leaves e of it."""
        run = simulate(
            falling(restitution), Settings(accuracy=accuracy), start_hub_angle=0.0, start_relative_angle=SURFACE + 0.01
        )
        taps, hold = taps_of(run, "workpart")
        assert hold is not None
        assert len(taps) <= most_taps(restitution)
        # The last tap ends a hop that is not followed.
        departures, arrivals = (
            np.array([getattr(tap, name)[0] for tap in taps[:-1]]) for name in ("velocity_after", "velocity_before")
        )
        # Exact to the law's rounding.
        np.testing.assert_allclose(departures / -arrivals, restitution, rtol=1e-12)
        # The accuracy asked for, relative to the length in the scene's unit of time.
        tool = falling(restitution)
        np.testing.assert_allclose(-arrivals[1:], departures[:-1], atol=accuracy * 0.027 / tool_units(tool).time)

    @pytest.mark.parametrize("law", ["compliant", "engine"])
    def test_other_laws_come_to_rest_as_well(self, law: str) -> None:
        tool = falling(0.7)
        run = simulate(
            replace(tool, contact=replace(tool.contact, law=law)),
            start_hub_angle=0.0,
            start_relative_angle=SURFACE + 0.05,
        )
        taps, hold = taps_of(run, "workpart")
        assert hold is not None
        assert 2 < len(taps) <= most_taps(0.7)
        # The accuracy asked for.
        assert run.angles[-1, 0] == pytest.approx(SURFACE, abs=1e-6)


class TestFixedSteps:
    @pytest.mark.parametrize("step", [3e-5, 1e-5])
    @pytest.mark.parametrize("restitution", [0.0, 0.2, 0.42, 0.7])
    def test_taps_do_not_multiply_as_the_step_shrinks(self, restitution: float, step: float) -> None:
        """Each tap leaves e of the speed, down to where a hop is as short as a step."""
        tool = replace(Tool(), workpart=Workpart(restitution=restitution))
        run = simulate(tool, Settings(step=step))
        taps, _ = taps_of(run, "workpart")
        assert len(taps) <= 3 + math.log(step / 18e-3) / math.log(max(restitution, 0.1)) * 2.0
        assert run.stop_reason == "end of the planned time"

    def test_restitution_1_is_not_taken_for_chatter(self) -> None:
        """Nothing is lost at a tap, and each hop comes back faster by a h: v^2 = v_0^2 (1 + h t/t_1^2).

        With hops of 2 t_1 v/v_0, t_1 being the first fall's time, (t_1/h) (sqrt(1 + h t/t_1^2) - 1) of them fit in.
        """
        tool, step = falling(1.0), 0.02
        unit = tool_units(tool).time
        run = simulate(tool, Settings(step=step * unit), start_hub_angle=0.0, start_relative_angle=SURFACE + 0.02)
        taps, hold = taps_of(run, "workpart")
        assert hold is None
        fall, time = taps[0].time / unit, run.time[-1] / unit
        # To one hop, and 10 % for the force, which changes by as much over the height that the hops gain.
        hops = fall / step * (math.sqrt(1.0 + step * time / fall**2) - 1.0)
        assert len(taps) - 1 == pytest.approx(hops, rel=0.1, abs=1.0)

    def test_a_long_hop_is_followed(self) -> None:
        """A high rebound is no chatter, however few steps it takes: restitution 0.9, a step of a quarter radian."""
        tool = falling(0.9)
        step = 0.25 * tool_units(tool).time
        run = simulate(tool, Settings(step=step, samples_per_period=1), start_hub_angle=0.0, start_relative_angle=1.5)
        taps, _ = taps_of(run, "workpart")
        assert len(taps) >= 3


@pytest.mark.parametrize("restitution", [0.6, 0.9])
def test_accumulation_seen_from_two_accuracies(restitution: float) -> None:
    """The instant of rest, extrapolated from each run's last hops by e/(1 - e), is one and the same."""
    tool = tapping(restitution)
    unit = tool_units(tool).time
    found = []
    for accuracy in (1e-5, 1e-7):
        taps, hold = taps_of(simulate(tool, Settings(accuracy=accuracy, hub_turn=2.0)), "bar")
        assert hold is not None
        times = np.array([tap.time for tap in taps])[:-1] / unit
        found.append((times[-1] + (times[-1] - times[-2]) * restitution / (1.0 - restitution), times[-1] - times[-2]))
    (first, hop), (second, _) = found
    # The share of a hop is off e by the hop's length at most, which the rest of the series, hop/(1 - e)^2, magnifies.
    assert first == pytest.approx(second, abs=(hop / (1.0 - restitution)) ** 2)
