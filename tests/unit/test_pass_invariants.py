"""The invariants of a pass hold where they should, and each notices what breaks it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Hub, Tool, Workpart
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.pass_invariants import invariant_rows
from bristle_sim.trajectory import Trajectory

SETTINGS = Settings()

TOOLS = {
    "default": Tool(),
    "knee": Tool(bristle=Bristle(knee_angle_deg=30.0)),
    "gravity and damping": Tool(gravity=9.81, belt=Belt(damping_ratio=0.1)),
    "rubbing bar that throws back": Tool(bar=Bar(friction=0.3, restitution=0.6)),
    "contact resolved in time": Tool(contact=Contact("compliant")),
    "engine's contact": Tool(contact=Contact("engine")),
    "at rest": Tool(hub=Hub(speed=0.0)),
}


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return simulate(Tool(), SETTINGS)


def verdicts(tool: Tool, settings: Settings, run: Trajectory) -> dict[str, bool | None]:
    return {row.name: row.ok for row in invariant_rows(tool, settings, run)}


@pytest.mark.parametrize("name", TOOLS)
@pytest.mark.parametrize("settings", [SETTINGS, Settings(accuracy=1e-9, hub_turn=2.0)])
def test_kept(name: str, settings: Settings) -> None:
    rows = invariant_rows(TOOLS[name], settings, simulate(TOOLS[name], settings))
    assert [(row.name, row.simulated) for row in rows if row.ok is False] == []
    assert sum(row.ok is True for row in rows) >= 2


def only(name: str, found: dict[str, bool | None]) -> bool:
    return found[name] is False and all(ok is not False for other, ok in found.items() if other != name)


class TestNoticed:
    def test_energy_gained_in_flight(self, run: Trajectory) -> None:
        """Rates 1e-4 too high from half the last flight on: 2e-4 of the kinetic energy, twenty times the tolerance."""
        rates = run.rates.copy()
        late = run.time > 0.5 * (run.contacts[-1].time + run.contacts[-1].duration + run.time[-1])
        assert late.any()
        rates[late] *= 1.001
        assert only("energy_balance", verdicts(Tool(), SETTINGS, replace(run, rates=rates)))

    def test_overlap(self, run: Trajectory) -> None:
        strike = int(np.argmin(np.abs(run.time - run.first_contact("workpart").time)))  # type: ignore[union-attr]
        line = run.centre_line.copy()
        line[strike, -1, 1] -= 1e-4 * Tool().bristle.length
        assert only("deepest_overlap", verdicts(Tool(), SETTINGS, replace(run, centre_line=line)))

    def test_impulse_that_does_not_change_the_velocity(self, run: Trajectory) -> None:
        strike = run.first_contact("workpart")
        assert strike is not None
        assert strike.compressive_impulse is not None
        contacts = [
            replace(each, velocity_after=(each.velocity_after[0] * 1.01, each.velocity_after[1]))
            if each is strike
            else each
            for each in run.contacts
        ]
        assert verdicts(Tool(), SETTINGS, replace(run, contacts=tuple(contacts)))["impulse_momentum_error"] is False

    def test_other_restitution_and_friction(self, run: Trajectory) -> None:
        """A tangential impulse lies outside the cone of a smooth surface, whatever it is."""
        springy, smooth = Tool(workpart=Workpart(restitution=0.5)), Tool(workpart=Workpart(friction=0.0))
        assert only("restitution_work_error", verdicts(springy, SETTINGS, run))
        assert only("friction_cone_excess", verdicts(smooth, SETTINGS, run))

    def test_friction_that_does_work_on_the_wire(self, run: Trajectory) -> None:
        """Friction's work in a sustained contact with its sign turned; the cone is not left."""
        drag = next(each for each in run.contacts if each.law == "sustained" and each.obstacle == "workpart")
        assert drag.compressive_work is not None
        normal, tangential = drag.compressive_work
        assert tangential < 0.0
        helping = [
            replace(each, compressive_work=(normal, -tangential)) if each is drag else each for each in run.contacts
        ]
        assert verdicts(Tool(), SETTINGS, replace(run, contacts=tuple(helping)))["friction_work"] is False
