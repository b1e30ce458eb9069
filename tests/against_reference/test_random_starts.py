"""Contacts with both obstacles: opening rates, grip, wedges, pinned bristles, and starts at random against the reference."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.contact import between
from bristle_sim.benchmarks.hard_cases.measures import agrees_with_reference
from bristle_sim.parameters import Belt, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.tool import tool_units
from bristle_sim.settings import Settings, StopReason


def drawn(seed: int) -> tuple[Tool, dict[str, float]]:
    """A tool whose bar stands on the incoming side, and whose bristle starts near bar and workpart."""
    rng = np.random.default_rng(seed)
    while True:
        hub_angle = float(rng.uniform(-1.2, 0.4))
        angle = float(rng.uniform(-0.9, 0.7))
        belt = Belt(Tool().belt.stiffness * float(rng.choice([0.3, 1.0, 10.0])))
        rub, slide, restitution = (
            float(rng.choice(each)) for each in ([0.0, 0.3], [0.0, 0.31], [0.0, 0.42])
        )
        if abs(angle - hub_angle) > 1.3:
            continue
        try:
            tool = between(
                hub_angle, angle, at=float(rng.uniform(0.4, 0.95)), bar_gap=2e-4, gap=3e-4
            )
        except ValueError:
            continue
        assert tool.bar is not None
        assert tool.workpart is not None
        bar = replace(tool.bar, friction=rub)
        part = replace(tool.workpart, friction=slide, restitution=restitution)
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
    assert run.time[-1] / tool_units(tool).time == pytest.approx(
        referred.time[-1] / tool_units(tool).time, abs=1e-5
    )
    assert run.relative_angle[-1] == pytest.approx(referred.relative_angle[-1], abs=1e-5)
    assert (run.tip[:, 1] + tool.workpart_depth).min() >= -1e-6 * tool.bristle.length
    # Rounding, of the largest energy around.
    works = [
        (*(each.compressive_work or ()), *(each.restitutive_work or ())) for each in run.contacts
    ]
    assert max(map(sum, works), default=0.0) <= 1e-12 * run.total_energy.max()


@pytest.mark.parametrize(
    ("hub_angle", "angle", "left_out"), [(-0.4, -0.7, "bar"), (-0.6, -1.0, "workpart")]
)
def test_a_start_that_moves_into_an_obstacle(hub_angle: float, angle: float, left_out: str) -> None:
    """In contact at the start, and approaching at 100 rad/s: end and strike as in the reference."""
    tool = replace(between(hub_angle, angle), **{left_out: None})
    start = {
        "start_hub_angle": hub_angle,
        "start_relative_angle": angle - hub_angle,
        "start_relative_rate": 100.0,
    }
    found = agrees_with_reference(tool, start=start)
    assert found.ok, found.reached


@pytest.mark.parametrize(
    ("tool", "angle"), [(Tool(), 0.0), (Tool(belt=Belt(damping_ratio=0.1)), -0.3)]
)
def test_the_highest_relative_speed_is_the_first_maximum(tool: Tool, angle: float) -> None:
    """Undamped it follows the strike; from a start behind the hub it precedes the bar."""
    start = {"start_relative_angle": angle, "stop_after": "highest relative speed"}
    run, exact = simulate(tool, **start), simulate_reference(tool, **start)
    assert exact.stop_reason is run.stop_reason is StopReason.EVENT
    assert run.time[-1] == pytest.approx(exact.time[-1], rel=1e-6)


@pytest.mark.parametrize("restitution", [0.0, 0.42])
def test_events_have_the_same_names(restitution: float) -> None:
    """Up to the hops that the reference takes as rest: a rebound is no release, a slide along the bar ends with one."""
    tool = replace(Tool(), bar=replace(Tool().bar, restitution=restitution))
    runs = simulate(tool, Settings(hub_turn=1.8)), simulate_reference(tool, hub_turn=1.8)
    names = [[each.name for each in run.events] for run in runs]
    assert names[0] == names[1]
    assert names[0].count("workpart touch") == 2


def test_a_wedge_closes_without_a_rebound() -> None:
    """A link that touches bar and workpart has no motion that opens both: the impact that jams it returns nothing."""
    tool = between(-0.9, 0.3, bar_gap=2e-4, gap=2e-4).replace(bar_restitution=0.5, restitution=0.5)
    start = {"start_hub_angle": -0.9, "start_relative_angle": 1.2}
    run = simulate(tool, Settings(maximum_steps=100_000), **start)
    last = run.contacts[-1]
    assert run.stop_reason == "jam"
    assert last.velocity_before[0] < 0.0
    # Rounding, in units of the approach.
    assert last.velocity_after[0] == pytest.approx(0.0, abs=-1e-9 * last.velocity_before[0])
