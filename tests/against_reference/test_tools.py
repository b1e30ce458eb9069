"""One table of tools and accuracies up to their strikes: the pymunk scene against the independent solution.

They share the parameters, the type of the result and the impact law, and nothing else: equations of motion, contact
geometry, sustained contacts, integration and event search are each done twice. Compared are touches, impacts, impulses of
sustained contacts, the strike, and the state at the end. Tolerances are ten times the requested accuracy, of each quantity's
own size; what a row says magnifies errors gets so many times that. A hundred times that for sustained contacts, whose
impulse ends with a force that vanishes at a small slope.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory


def changed(**parts: dict[str, float]) -> Tool:
    tool = Tool()
    return replace(
        tool, **{part: replace(getattr(tool, part), **values) for part, values in parts.items()}
    )


def tool(
    nearness: float = 1.0,
    speed: float = 261.8,
    damping: float = 0.0,
    gravity: float = 0.0,
    **bar: float,
) -> Tool:
    """The operating point with its bar nearer to the hub, or farther."""
    made = Bar(horizontal=0.05037 * nearness, vertical=0.0225 * nearness, **bar)
    return Tool(hub=Hub(speed=speed), belt=Belt(damping_ratio=damping), bar=made, gravity=gravity)


def bent(knee: float, position: float, nearness: float, **given: float) -> Tool:
    made = tool(nearness, **({"gravity": 9.81} | given))
    return replace(made, bristle=Bristle(knee_position=position, knee_angle_deg=knee))


def wire(
    links: int, modulus: float = 2e11, damping: float = 0.0, knee: float = 0.0, **given: float
) -> Tool:
    bristle = Bristle(
        links=links, modulus=modulus, bending_damping_ratio=damping, knee_angle_deg=knee
    )
    return replace(tool(damping=damping, **given), bristle=bristle)


RIGID = {
    "as is": Tool(),
    "hub speed 500": changed(hub={"speed": 500.0}),
    "hub radius 31 mm": changed(hub={"radius": 0.031}),
    "belt four times as stiff": changed(belt={"stiffness": 0.1}),
    "damping 0.3": changed(belt={"damping_ratio": 0.3}),
    "damping 3": changed(belt={"damping_ratio": 3.0}),
    "length 29 mm": changed(bristle={"length": 0.029}),
    "mass 0.3 g": changed(bristle={"mass": 3e-4}),
    "no thickness": changed(bristle={"wire_diameter": 0.0, "mass": 8.387e-5}),
    "thickness 2 mm": changed(bristle={"wire_diameter": 2e-3}),
    "bar of 8 mm": changed(bar={"radius": 0.008}),
    "bar aside": changed(bar={"horizontal": 0.047}),
    "bar's friction 0.8": changed(bar={"friction": 0.8}),
    "bar's restitution 0.42": changed(bar={"restitution": 0.42}),
    "bar's restitution 1": changed(bar={"restitution": 1.0}),
    "bar's friction and restitution": changed(bar={"friction": 0.4, "restitution": 0.3}),
    "penetration 10 mm": changed(workpart={"penetration": 0.01}),
    "elastic": changed(workpart={"friction": 0.0, "restitution": 1.0}),
    "friction falls": changed(workpart={"friction": 0.6, "restitution_friction": 0.1}),
    "elastic along the surface": changed(contact={"tangential_compliance": 1.21}),
    "hardly elastic along the surface": changed(contact={"tangential_compliance": 5e-5}),
    "inelastic": changed(workpart={"restitution": 0.0}),
    "gravity": replace(Tool(), gravity=3e3),
    "no bar": replace(Tool(), bar=None),
    "no workpart": replace(Tool(), workpart=None),
}
"""Each parameter changed, and parts left out."""

BENT = {
    "held at its end": bent(-27.0, 0.45, 0.926, friction=0.3, damping=0.05),
    "held at its rest": bent(20.0, 0.68, 0.990, friction=0.3, damping=0.05),
    "held at its shank": bent(50.0, 0.42, 0.948, friction=0.3, damping=0.05, speed=200.0),
    "hardly damped": bent(60.0, 0.75, 0.970, friction=0.1),
    "thrown back": bent(-35.0, 0.68, 1.012, restitution=0.42, friction=0.3, damping=0.05),
    "thrown back by its rest": bent(15.0, 0.84, 0.982, restitution=0.42, friction=0.3),
    "touched near the knee": bent(17.0, 0.745, 0.866, friction=0.3, damping=0.05, speed=200.0),
    "touched inside the knee": bent(43.6, 0.7086, 0.7704, friction=0.3),
    "blow in the elbow": bent(31.0, 0.9, 0.875, friction=0.3, damping=0.05, speed=200.0),
    "no bar, bent forward": replace(bent(35.0, 0.75, 1.0, damping=0.02), bar=None),
    "no bar, bent back": replace(bent(-60.0, 0.75, 1.0, damping=0.02), bar=None),
}

WIRES = {
    "two links": wire(2),
    "three links, damped": wire(3, damping=0.05),
    "three links, knee": wire(3, modulus=5e10, knee=-25.0, damping=0.05),
    "slip that turns back and stops": wire(3, modulus=2.1e10, nearness=0.82, friction=0.44),
    "four links, over joints with friction": wire(
        4, modulus=2.92e10, knee=-24.35, nearness=0.7863, friction=0.2395
    ),
}

MAGNIFIED = {"bar's restitution 1": 10.0, "slip that turns back and stops": 10.0}
"""Rows in which blows follow each other, each of which magnifies the error that the one before has left."""

ROWS = [
    *((name, 1e-6) for name in (*RIGID, *BENT, *list(WIRES)[:-1])),
    *(
        (name, 1e-9)
        for name in (
            "as is",
            "damping 0.3",
            "bar's restitution 0.42",
            "bar's friction 0.8",
            "held at its end",
        )
    ),
    *(
        (name, 1e-4)
        for name in (
            "as is",
            "bar's restitution 0.42",
            "held at its shank",
            "touched inside the knee",
            "two links",
        )
    ),
]

NIGHTLY = [
    *((name, accuracy) for name in (*RIGID, *BENT) for accuracy in (1e-4, 1e-9)),
    *((name, 1e-4) for name in WIRES),
    *((name, 1e-6) for name in ("eight links", "bar that throws a wire back", *list(WIRES)[-1:])),
]

TOOLS = RIGID | BENT | WIRES | {
    "eight links": wire(8, modulus=2e10),
    "bar that throws a wire back": wire(3, modulus=1.3e10, restitution=0.42),
}  # fmt: skip


@pytest.mark.parametrize(("name", "accuracy"), ROWS, ids=lambda value: f"{value}")
def test_strike(name: str, accuracy: float) -> None:
    compare(TOOLS[name], accuracy, MAGNIFIED.get(name, 1.0))


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "accuracy"), NIGHTLY, ids=lambda value: f"{value}")
def test_strike_at_other_accuracies(name: str, accuracy: float) -> None:
    compare(
        TOOLS[name],
        accuracy,
        100.0 if name == "bar that throws a wire back" else MAGNIFIED.get(name, 1.0),
    )


def compare(tool: Tool, accuracy: float, magnified: float) -> None:
    settings = Settings(accuracy=accuracy, maximum_steps=5_000_000)
    scene = simulate(tool, settings, stop_after="strike")
    reference = simulate_reference(tool, stop_after="strike", accuracy=max(1e-2 * accuracy, 1e-12))
    tolerance = 10.0 * accuracy * magnified
    assert scene.stop_reason is reference.stop_reason
    assert_same_impacts(scene, reference, tolerance)
    assert_same_sums(scene, reference, 30.0 * tolerance)
    assert_same_end(scene, reference, tolerance)
    works = [(each.compressive_work or (0.0, 0.0))[1] for each in scene.contacts]
    assert max(works, default=0.0) <= 1e-12 * scene.kinetic_energy.max()


def assert_same_impacts(scene: Trajectory, reference: Trajectory, tolerance: float) -> None:
    """Impacts one by one while they are faster than a hundredth of the fastest: each side ends a chatter at its own smallness."""
    hits = [
        [each for each in run.contacts if each.law == "energetic"] for run in (scene, reference)
    ]
    speed = max((abs(each.velocity_before[0]) for each in hits[1]), default=0.0)
    first, second = (
        [each for each in side if -each.velocity_before[0] > 1e-2 * speed] for side in hits
    )
    assert [each.obstacle for each in first] == [each.obstacle for each in second]
    for one, other in zip(first, second, strict=True):
        assert_same_impact(one, other, tolerance, speed)


def assert_same_impact(
    one: ContactRecord, other: ContactRecord, tolerance: float, speed: float
) -> None:
    """Compared on the scale of the larger component; a slow tap has as many digits fewer as it is slower than the fastest."""
    assert one.outcome == other.outcome
    assert one.time == pytest.approx(other.time, rel=tolerance)
    assert one.angles == pytest.approx(other.angles, abs=tolerance)
    rates = max(abs(each) for each in (*other.rates_before, *other.rates_after))
    fraction = speed / -other.velocity_before[0]
    for name, scale in (
        ("rates_before", rates),
        ("rates_after", rates),
        *(
            (name, 2.0 * fraction * max(map(abs, other.impulse)))
            for name in ("impulse", "compressive_impulse")
        ),
        *(
            (name, 2.0 * fraction * max(map(abs, other.compressive_work or ())))
            for name in ("compressive_work", "restitutive_work")
        ),
        *((name, speed) for name in ("velocity_before", "velocity_after")),
    ):
        found, expected = getattr(one, name), getattr(other, name)
        assert found == pytest.approx(expected, rel=0.0, abs=tolerance * scale), name


def assert_same_sums(scene: Trajectory, reference: Trajectory, tolerance: float) -> None:
    """All impulse that each obstacle gave; up to that of the last tap is missing where a chatter ends."""
    scale = max((abs(each.impulse[0]) for each in reference.contacts), default=0.0)
    for obstacle in ("bar", "workpart"):
        own = [
            [each for each in run.contacts if each.obstacle == obstacle]
            for run in (scene, reference)
        ]
        sums = [np.sum([each.impulse for each in side], axis=0) for side in own]
        taps = [[each.impulse[0] for each in side if each.law == "energetic"] for side in own]
        cut = sum(side[-1] for side in taps if len(side) > 2)
        np.testing.assert_allclose(sums[0], sums[1], rtol=tolerance, atol=tolerance * scale + cut)


def assert_same_end(scene: Trajectory, reference: Trajectory, tolerance: float) -> None:
    """State and energies where both end; touches and, located where a force vanishes at a small slope, releases."""
    assert scene.time[-1] == pytest.approx(reference.time[-1], rel=tolerance)
    touches = [[run.event_time("bar touch") or 0.0] for run in (scene, reference)]
    assert touches[0] == pytest.approx(touches[1], rel=tolerance)
    fastest = float(np.abs(reference.rates).max())
    assert scene.angles[-1] == pytest.approx(reference.angles[-1], abs=tolerance)
    assert scene.rates[-1] == pytest.approx(reference.rates[-1], abs=tolerance * fastest)
    np.testing.assert_allclose(
        scene.tip[-1], reference.tip[-1], rtol=0.0, atol=tolerance * np.abs(reference.tip).max()
    )
    size = np.abs(reference.kinetic_energy).max() + np.ptp(reference.potential_energy)
    for energy in ("kinetic_energy", "potential_energy"):
        found, expected = getattr(scene, energy)[-1], getattr(reference, energy)[-1]
        assert found == pytest.approx(expected, abs=2.0 * tolerance * size), energy
    releases = [
        [
            each.time + each.duration
            for each in run.contacts
            if each.law == "sustained" and each.obstacle == "bar"
        ]
        for run in (scene, reference)
    ]
    assert releases[0][:1] == pytest.approx(releases[1][:1], rel=1e3 * tolerance)


@pytest.mark.parametrize(("part", "key"), [("belt", "stiffness"), ("bar", "radius")])
def test_a_difference_is_noticed(part: str, key: str) -> None:
    """The comparison itself: a tool that differs by 1e-4 in one parameter does not pass as the same."""
    value: Any = getattr(getattr(Tool(), part), key)
    other = simulate_reference(changed(**{part: {key: value * 1.0001}}), stop_after="strike")
    with pytest.raises(AssertionError):
        assert_same_impacts(simulate(Tool(), stop_after="strike"), other, 1e-5)
