"""Bristles with a knee: the pymunk scene against the integration in one generalized coordinate.

The two share parameters, the impact law and the type of result; geometry, equation of motion, contact and events are
each their own. The strike is held to the accuracy asked of the scene; so are events, except the last touch of the bar,
which the wire's end grazes.
"""

from __future__ import annotations

import pytest

from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

GRAVITY = 9.81
ACCURACY = 1e-6


def tool(
    knee: float,
    position: float,
    nearness: float,
    *,
    friction: float = 0.0,
    restitution: float = 0.0,
    damping: float = 0.0,
    speed: float = 261.8,
) -> Tool:
    """The operating point with a knee; ``nearness`` scales the bar's distance from the hub."""
    return Tool(
        hub=Hub(speed=speed),
        belt=Belt(damping_ratio=damping),
        bristle=Bristle(knee_position=position, knee_angle_deg=knee),
        bar=Bar(horizontal=0.05037 * nearness, vertical=0.0225 * nearness, friction=friction, restitution=restitution),
        gravity=GRAVITY,
    )


def strike_of(run: Trajectory) -> ContactRecord:
    strike = run.first_contact("workpart")
    assert strike is not None
    return strike


def compare_strikes(scene: Trajectory, reference: Trajectory, accuracy: float) -> None:
    """Instant, angle, rate and impulse of the strike.

    The outcome of an oblique blow with friction magnifies errors of its angle, here by less than 20.
    """
    found, expected = strike_of(scene), strike_of(reference)
    assert found.time == pytest.approx(expected.time, rel=accuracy)
    assert found.angles == pytest.approx(expected.angles, abs=accuracy)
    assert found.rates_before == pytest.approx(expected.rates_before, rel=accuracy)
    assert found.rates_after == pytest.approx(expected.rates_after, rel=20.0 * accuracy)
    assert found.impulse == pytest.approx(expected.impulse, rel=20.0 * accuracy)
    assert found.outcome == expected.outcome


def compare_events(scene: Trajectory, reference: Trajectory, accuracy: float) -> None:
    """The release is found from a force that vanishes gently: rounding of it moves the instant, and nothing after it."""
    for name, last, factor in (
        ("bar touch", False, 1.0),
        ("largest retraction", True, 1.0),
        ("bar release", True, max(20.0, 1e-6 / accuracy)),
    ):
        expected = reference.event_time(name, last=last)
        assert expected is not None
        assert scene.event_time(name, last=last) == pytest.approx(expected, rel=factor * accuracy)


def held(run: Trajectory) -> ContactRecord:
    """The longest hold on the bar."""
    holds = [each for each in run.contacts if each.law == "sustained" and each.obstacle == "bar"]
    return max(holds, key=lambda each: each.duration)


def compare_holds(found: ContactRecord, expected: ContactRecord, tolerance: float) -> None:
    """Impulse and work of friction; shares of a force that is no better known than the rates' changes."""
    assert found.compressive_work is not None
    assert expected.compressive_work is not None
    assert found.impulse == pytest.approx(expected.impulse, rel=tolerance)
    assert found.compressive_work[1] == pytest.approx(expected.compressive_work[1], rel=tolerance)


HELD = [
    tool(-56.0, 0.81, 0.942, damping=0.05, speed=200.0),
    tool(-27.0, 0.45, 0.926, friction=0.3, damping=0.05),
    tool(-16.0, 0.41, 0.909, friction=0.3),
    tool(15.0, 0.68, 0.930, friction=0.3),
    tool(20.0, 0.68, 0.990, friction=0.3, damping=0.05),
    tool(45.0, 0.55, 1.007),
    tool(50.0, 0.42, 0.948, friction=0.3, damping=0.05, speed=200.0),
    tool(60.0, 0.75, 0.970, friction=0.1),
]
"""An inelastic bar that holds the wire's end, its rest, or its shank."""

TAPPED = [
    tool(-60.0, 0.79, 0.986, restitution=0.42),
    tool(-35.0, 0.68, 1.012, restitution=0.42, friction=0.3, damping=0.05),
    tool(15.0, 0.84, 0.982, restitution=0.42, friction=0.3),
    tool(40.0, 0.60, 1.000, restitution=0.9, friction=0.1),
]
"""A bar that throws the wire back; the knee may strike it as well as the end."""


@pytest.mark.parametrize("bent", HELD)
def test_held_by_the_bar(bent: Tool) -> None:
    scene = simulate(bent, Settings(accuracy=ACCURACY), stop_after="strike")
    reference = simulate_reference(bent, stop_after="strike")
    compare_strikes(scene, reference, ACCURACY)
    compare_events(scene, reference, ACCURACY)
    compare_holds(held(scene), held(reference), 20.0 * ACCURACY)


@pytest.mark.parametrize("bent", TAPPED)
def test_thrown_back_by_the_bar(bent: Tool) -> None:
    scene = simulate(bent, Settings(accuracy=ACCURACY), stop_after="strike")
    reference = simulate_reference(bent, stop_after="strike")
    compare_strikes(scene, reference, ACCURACY)
    taps = [[each for each in run.contacts if each.obstacle == "bar"][:3] for run in (scene, reference)]
    assert [each.outcome for each in taps[0]] == [each.outcome for each in taps[1]]
    for found, expected in zip(*taps, strict=True):
        assert found.time == pytest.approx(expected.time, rel=ACCURACY)
        assert found.impulse == pytest.approx(expected.impulse, rel=20.0 * ACCURACY, abs=20.0 * ACCURACY * 1e-3)


@pytest.mark.parametrize("knee", [-60.0, -20.0, 35.0, 60.0])
def test_whole_pass_without_a_bar(knee: float) -> None:
    """Undisturbed flight about a position that the knee's centre of mass shifts, up to the strike."""
    bent = Tool(bar=None, bristle=Bristle(knee_angle_deg=knee), belt=Belt(damping_ratio=0.02), gravity=GRAVITY)
    scene = simulate(bent, Settings(accuracy=ACCURACY), start_relative_angle=-0.4, stop_after="strike")
    reference = simulate_reference(bent, start_relative_angle=-0.4, stop_after="strike")
    compare_strikes(scene, reference, ACCURACY)
    assert scene.total_energy[0] == pytest.approx(reference.total_energy[0], rel=1e-12)


def test_finer_accuracy_comes_nearer() -> None:
    """A thousandth of the error is requested, and no more is left."""
    bent = HELD[1]
    scene = simulate(bent, Settings(accuracy=1e-9), stop_after="strike")
    reference = simulate_reference(bent, accuracy=1e-12, stop_after="strike")
    compare_strikes(scene, reference, 1e-9)
    compare_events(scene, reference, 1e-9)


CAPPED = Settings(accuracy=ACCURACY, maximum_steps=20_000)


@pytest.mark.parametrize(
    "bent",
    [
        tool(-39.0, 0.70, 0.895, friction=0.3, damping=0.05),
        tool(17.0, 0.745, 0.866, friction=0.3, damping=0.05, speed=200.0),
        tool(-40.7, 0.882, 0.825, speed=200.0),
        tool(43.6, 0.7086, 0.7704, friction=0.3),
    ],
)
def test_touch_near_the_knee(bent: Tool) -> None:
    scene, reference = simulate(bent, CAPPED, stop_after="strike"), simulate_reference(bent, stop_after="strike")
    assert scene.stop_reason == reference.stop_reason
    compare_holds(held(scene), held(reference), 20.0 * ACCURACY)


@pytest.mark.parametrize("restitution", [0.0, 0.42])
def test_blow_in_the_elbow(restitution: float) -> None:
    """A bar that the shank holds meets the rest; the blow is an impact of its own."""
    bent = tool(31.0, 0.9, 0.875, friction=0.3, restitution=restitution, damping=0.05, speed=200.0)
    scene, reference = simulate(bent, CAPPED, stop_after="strike"), simulate_reference(bent, stop_after="strike")
    first = next(index for index, each in enumerate(reference.contacts) if each.outcome == "bar")
    blow = reference.contacts[first + 1]
    near = [each for each in scene.contacts if each.law == "energetic" and abs(each.time / blow.time - 1.0) < ACCURACY]
    assert near
    assert near[0].impulse == pytest.approx(blow.impulse, rel=1e-3)
