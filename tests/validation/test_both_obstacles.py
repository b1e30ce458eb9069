"""Contacts with both obstacles: opening rates, grip, wedges, pinned bristles, and starts at random against the reference."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.contact import between
from bristle_sim.parameters import Belt, Hub, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.contact.gaps import Gaps, opening_rate
from bristle_sim.scene.contact.laws import contact_at
from bristle_sim.scene.contact.obstacles import ClosestApproach
from bristle_sim.scene.contact.sustained import SustainedContacts
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.tool import build_tool, simulate, tool_units
from bristle_sim.settings import Settings
from stability.cases.touching import contact_work, deepest, wedge_closes

FEW = Settings(maximum_steps=5000)


class TestWedge:
    @pytest.mark.parametrize("start", [(-0.9, 0.3), (-0.6, 0.4), (-1.1, 0.2)])
    @pytest.mark.parametrize("accuracy", [0.1, 1e-10])
    def test_jams_where_geometry_says(self, start: tuple[float, float], accuracy: float) -> None:
        tool = between(*start, at=0.7, bar_gap=1e-4, gap=3e-4)
        run = simulate(
            tool, Settings(accuracy=accuracy), start_hub_angle=start[0], start_relative_angle=start[1] - start[0]
        )
        assert run.stop_reason == "jam"
        assert run.events[-1].name == "jam"
        # Gaps below 1e-11 of the length are closed; the hub's turn is exact.
        assert run.time[-1] / tool_units(tool).time == pytest.approx(
            wedge_closes(tool, start[0]) / tool_units(tool).time, abs=1e-9
        )


class TestOpeningRate:
    """Two contacts of a link on a joint: levers l, normal velocities v at the rate w, so drifts v - l w."""

    @staticmethod
    def touch(lever: float, velocity: float) -> ClosestApproach:
        return ClosestApproach(0.0, (lever, 0.0), (0.0, 1.0), (velocity, 0.0), ())

    @pytest.mark.parametrize("rate", [-3.0, 0.0, 2.0])
    def test_by_hand(self, rate: float) -> None:
        """Drifts -1 on the lever 0.5 and +1 on the lever -1: -2 + 1 = -1; with +3: 1; on one side there is no end of it."""
        pushes = self.touch(0.5, -1.0 + 0.5 * rate)
        # Rounding.
        assert opening_rate(pushes, self.touch(-1.0, 1.0 - rate)) == pytest.approx(-1.0, rel=1e-14)
        assert opening_rate(self.touch(-1.0, 3.0 - rate), pushes) == pytest.approx(1.0, rel=1e-14)
        assert opening_rate(pushes, self.touch(1.0, -1.0 + rate)) == math.inf

    def test_at_rest(self) -> None:
        assert opening_rate(self.touch(0.5, 0.0), self.touch(-1.0, 0.0)) == 0.0


@pytest.mark.parametrize("step", [None, 1e-5])
@pytest.mark.parametrize("rate", [-200.0, 0.0, 200.0])
def test_pinned_whatever_restitution_and_start(rate: float, step: float | None) -> None:
    """Without a gap between two obstacles at rest no rebound leads anywhere: it remains where it is, pressed on one."""
    tool = replace(between(-0.3, 0.3, at=0.6), hub=Hub(speed=0.0))
    assert tool.bar is not None
    assert tool.workpart is not None
    bar, part = (
        replace(tool.bar, restitution=0.5, friction=0.3),
        replace(tool.workpart, restitution=0.42, friction=0.31),
    )
    run = simulate(
        replace(tool, bar=bar, workpart=part),
        replace(FEW, step=step),
        start_hub_angle=-0.3,
        start_relative_angle=0.6,
        start_relative_rate=rate,
    )
    assert run.stop_reason == "end of the planned time"
    assert len(run.contacts) < 10
    # Gaps below 1e-11 of the length are closed.
    assert np.ptp(run.angles) < 1e-10


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("angle", [-0.9, -0.4, 0.3])
def test_grip_of_one_link_is_that_of_the_engines_bodies(angle: float, friction: float) -> None:
    """One degree of freedom in closed form, compared with the contact-space inverse mass of joined bodies."""
    for part in ("bar", "workpart"):
        tool = between(-0.5, angle, bar_gap=0.0 if part == "bar" else None, gap=0.0 if part == "workpart" else None)
        scene, _ = build_tool(tool, hub_start=-0.5)
        obstacle = replace(scene.effects.obstacles[0], friction=friction)  # type: ignore[type-var]
        state = State(0.0, (angle,), (0.7,))
        touch, space = contact_at(scene, state, obstacle)
        body, point = scene.links[0], np.array(scene.mechanism.poses(state)[0].joint) + np.array(touch.arm)
        arm = point - np.array(body.position)
        free = 1.0 / body.mass + (arm[0] * touch.normal[1] - arm[1] * touch.normal[0]) ** 2 / body.moment
        rub = friction * math.copysign(1.0, touch.velocity[1])
        expected = (space.inverse_mass[0, 0] - rub * space.inverse_mass[0, 1]) / free
        # Rounding, and cancellation of a free body's response against its joint's.
        assert SustainedContacts(scene, [obstacle]).grip(Gaps(scene.mechanism), state) == pytest.approx(
            expected, rel=1e-12, abs=1e-12
        )


def drawn(seed: int) -> tuple[Tool, dict[str, float]]:
    """A tool whose bar stands on the incoming side, and whose bristle starts near bar and workpart."""
    rng = np.random.default_rng(seed)
    while True:
        hub_angle, angle = float(rng.uniform(-1.2, 0.4)), float(rng.uniform(-0.9, 0.7))
        belt = Belt(Tool().belt.stiffness * float(rng.choice([0.3, 1.0, 10.0])))
        rub, slide, restitution = (float(rng.choice(each)) for each in ([0.0, 0.3], [0.0, 0.31], [0.0, 0.42]))
        if abs(angle - hub_angle) > 1.3:
            continue
        try:
            tool = between(hub_angle, angle, at=float(rng.uniform(0.4, 0.95)), bar_gap=2e-4, gap=3e-4)
        except ValueError:
            continue
        assert tool.bar is not None
        assert tool.workpart is not None
        bar, part = replace(tool.bar, friction=rub), replace(tool.workpart, friction=slide, restitution=restitution)
        start = {"start_hub_angle": hub_angle, "start_relative_angle": angle - hub_angle}
        return replace(tool, belt=belt, bar=bar, workpart=part), start


@pytest.mark.parametrize("seed", range(6))
def test_starts_at_random_as_in_the_reference(seed: int) -> None:
    """Near both obstacles, whatever comes of it: same end at the same instant, no energy gained, nothing overlapped."""
    tool, start = drawn(seed)
    run = simulate(tool, Settings(hub_turn=1.5, maximum_steps=100_000), **start)
    referred = simulate_reference(tool, accuracy=1e-9, hub_turn=1.5, **start)
    assert run.stop_reason is referred.stop_reason
    # Ten times the requested accuracy, for what impacts magnify.
    assert run.time[-1] / tool_units(tool).time == pytest.approx(referred.time[-1] / tool_units(tool).time, abs=1e-5)
    assert run.relative_angle[-1] == pytest.approx(referred.relative_angle[-1], abs=1e-5)
    assert deepest(tool, run) <= 1e-6
    # Rounding, of the largest energy around.
    assert max((contact_work(each) for each in run.contacts), default=0.0) <= 1e-12 * run.total_energy.max()
