"""Rows of bristles that touch each other: the scene against the independent solution, whose touches are balanced by hand."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bristle_sim.parameters import Bristle, Tool
from bristle_sim.reference import simulate_row_reference
from bristle_sim.reference.mechanics import Chain
from bristle_sim.scene.simulate import simulate, simulate_row
from bristle_sim.settings import Settings, StopReason
from bristle_sim.trajectory import Trajectory

ACCURACY = 1e-6

SHORT = Settings(accuracy=ACCURACY, hub_turn=1.6)

ELASTIC = {"neighbour_friction": 0.0, "neighbour_restitution": 1.0}


def row(
    bristles: int, pitch_deg: float, tool: Tool | None = None, **changes: float
) -> tuple[Trajectory, ...]:
    surface = ELASTIC | changes
    return simulate_row(
        tool or Tool(), SHORT, bristles=bristles, pitch=math.radians(pitch_deg), **surface
    )


@pytest.mark.parametrize(
    ("bristles", "pitch_deg", "friction", "restitution"),
    [
        (2, 50.0, 0.0, 1.0),
        (2, 17.0, 0.31, 0.42),
        (2, 10.0, 0.0, 1.0),
        (2, 10.0, 0.3, 0.5),
        (3, 16.0, 0.3, 0.2),
    ],
)
def test_a_row_moves_as_in_the_reference(
    bristles: int, pitch_deg: float, friction: float, restitution: float
) -> None:
    """Touches of neighbours up to the first bristle's strike: instants, equal impulses, and all states there."""
    given = {"bristles": bristles, "pitch": math.radians(pitch_deg)}
    given |= {
        "neighbour_friction": friction,
        "neighbour_restitution": restitution,
        "stop_after": "strike",
    }
    runs = simulate_row(Tool(), replace(SHORT, accuracy=1e-7), **given)
    exact = simulate_row_reference(Tool(), accuracy=1e-9, hub_turn=1.6, **given)
    for run, other in zip(runs, exact, strict=True):
        assert run.stop_reason is other.stop_reason
        hits, expected = (
            [
                each
                for each in one.contacts
                if each.law == "energetic" and each.velocity_before[0] < -0.1
            ]
            for one in (run, other)
        )
        assert [each.obstacle for each in hits] == [each.obstacle for each in expected]
        for hit, wanted in zip(hits, expected, strict=True):
            # A hundred times the accuracy: touches follow each other, and magnify what the one before has left.
            assert hit.time == pytest.approx(wanted.time, rel=1e-5)
            assert hit.impulse == pytest.approx(
                wanted.impulse, abs=1e-5 * max(map(abs, wanted.impulse))
            )
        assert run.angles[-1] == pytest.approx(other.angles[-1], abs=1e-5)


BENT_ROWS = {
    "a joint lands on a flank whose own tip already slides": (
        {
            "hub_speed": 142.59586496940608,
            "friction": 0.23007551452231537,
            "restitution": 0.33356244795107354,
            "bar_friction": 0.35538071483891287,
            "bar_restitution": 0.0,
            "belt_stiffness": 0.027432815139575357,
            "penetration": 0.008672091040511826,
            "bar_horizontal": 0.05158182069460632,
            "bar_vertical": 0.021742601686105763,
            "bar_radius": 0.005477749721024647,
            "wire_links": 2,
            "wire_modulus": 62668800749.38488,
            "wire_damping_ratio": 0.02,
        },
        {"pitch": 0.14569024257663593, "neighbour_friction": 0.29856625902756057},
        0.00815,
    ),
    "a tip slides off the other wire's tip onto the other side": (
        {
            "hub_speed": 86.33570366078007,
            "friction": 0.01388230127662542,
            "restitution": 0.0,
            "bar_friction": 0.3016539993456002,
            "bar_restitution": 0.0,
            "belt_stiffness": 0.0032403187547909635,
            "belt_damping_ratio": 0.4416936389514453,
            "penetration": 0.009321788450358562,
            "bar_horizontal": 0.05172375756092477,
            "bar_vertical": 0.025026066598420868,
            "knee_angle_deg": 30.58441271027249,
            "knee_position": 0.8249225031493972,
        },
        {"pitch": 0.11366049579035173, "neighbour_friction": 0.32246402742004665},
        0.0065,
    ),
}


@pytest.mark.parametrize("case", BENT_ROWS)
def test_wires_with_corners_touch_each_other_as_in_the_reference(case: str) -> None:
    """All impulses of wires on each other and of the bar, and the angles at the end, to a hundred times the accuracy."""
    keys, given, until = BENT_ROWS[case]
    tool = Tool().replace(**keys)
    turn = until * tool.hub.speed - given["pitch"]
    given = given | {"bristles": 2, "neighbour_restitution": 0.0}
    runs = simulate_row(tool, Settings(accuracy=1e-7, hub_turn=turn), **given)
    exact = simulate_row_reference(tool, accuracy=1e-9, hub_turn=turn, **given)
    for run, other in zip(runs, exact, strict=True):
        assert run.time[-1] == pytest.approx(other.time[-1], rel=1e-12)
        assert run.angles[-1] == pytest.approx(other.angles[-1], abs=1e-5)
        # Those within an impact's chatter, which each side ends at its own smallness, are shorter.
        lasting, known = (
            [each for each in one.contacts if each.obstacle == "wire" and each.duration > 1e-6]
            for one in (run, other)
        )
        assert len(lasting) == len(known) > 1
        for each, wanted in zip(lasting, known, strict=True):
            assert each.time == pytest.approx(wanted.time, rel=1e-5)
        for obstacle in ("wire", "bar"):
            total, expected = (
                sum(each.impulse[0] for each in one.contacts if each.obstacle == obstacle)
                for one in (run, other)
            )
            assert total == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("links", [1, 2])
def test_wide_apart_each_pass_is_the_lone_one(links: int) -> None:
    """The lone pass, a pitch of the hub's turn later; ten times the requested accuracy."""
    tool = Tool(bristle=Bristle(links=links))
    single_link = simulate(tool, SHORT)
    pitch_deg = 25.3 if links == 2 else 50.0
    for number, run in enumerate(row(2, pitch_deg, tool)):
        later = number * math.radians(pitch_deg) / 261.8
        assert run.event_time("bar touch") - later == pytest.approx(
            single_link.event_time("bar touch"), rel=10.0 * ACCURACY
        )
        strike = run.first_contact("workpart")
        expected = single_link.first_contact("workpart")
        assert strike.time - later == pytest.approx(expected.time, rel=10.0 * ACCURACY)
        assert strike.impulse == pytest.approx(expected.impulse, rel=100.0 * ACCURACY)


def test_the_highest_speed_of_a_bristle_is_recorded_while_another_one_drags() -> None:
    """Wide apart, each bristle has the events of the lone one, a pitch of the hub's turn later; ten times the accuracy."""
    tool = Tool().replace(
        hub_speed=73.997,
        hub_radius=0.0866462,
        bristle_length=0.063774,
        wire_diameter=2.80085e-4,
        belt_stiffness=8.20296e-3,
        belt_damping_ratio=1.21632,
        bar_radius=2.15542e-3,
        bar_horizontal=0.107977,
        bar_vertical=0.0995382,
        penetration=0.0134925,
    )
    pitch = 0.291832
    settings = Settings(accuracy=ACCURACY, hub_turn=2.3)
    lone = simulate(tool, settings, stop_after="strike")
    given = {"bristles": 2, "pitch": pitch, "neighbour_friction": 0.0, "neighbour_restitution": 0.0}
    for number, run in enumerate(simulate_row(tool, settings, stop_after="strike", **given)):
        later = number * pitch / tool.hub.speed
        events = run.events[: len(lone.events)]
        assert "highest relative speed" in [each.name for each in lone.events]
        assert [each.name for each in events] == [each.name for each in lone.events]
        assert [each.time - later for each in events] == pytest.approx(
            [each.time for each in lone.events], rel=10.0 * ACCURACY
        )


def test_one_bristle_is_the_lone_one_to_the_last_digit() -> None:
    (run,), single_link = row(1, 0.0), simulate(Tool(), SHORT)
    assert np.array_equal(run.angles, single_link.angles)
    assert run.events == single_link.events


def test_wires_that_stay_in_contact() -> None:
    """Inelastic neighbours press on each other for a while; their impulses on each other are equal and they do not overlap."""
    damped = replace(Tool(), belt=replace(Tool().belt, damping_ratio=0.05))
    runs = row(2, 10.0, damped, neighbour_friction=0.3, neighbour_restitution=0.0)
    lasting = [
        [each for each in run.contacts if (each.obstacle, each.law) == ("wire", "sustained")]
        for run in runs
    ]
    assert lasting[0]
    for first, second in zip(*lasting, strict=True):
        assert first.impulse == second.impulse
        assert first.impulse[0] > 0.0
    assert runs[0].event_time("wire release") is not None
    assert np.array_equal(runs[0].time, runs[1].time)


FOLDED = {
    "narrow": (Tool(), {"bristles": 2, "pitch": math.radians(1.6)}),
    "slow": (
        Tool().replace(
            hub_speed=156.025,
            bristle_length=0.0351738,
            wire_diameter=1.14112e-3,
            friction=0.526415,
            restitution=0.0,
            bar_friction=0.0,
            bar_restitution=0.0281987,
            belt_stiffness=0.011341,
            bar_radius=7.16728e-3,
            bar_horizontal=0.0155399,
            bar_vertical=0.0478098,
            penetration=8.87316e-3,
        ),
        {"bristles": 3, "pitch": 0.159101},
    ),
}


@pytest.mark.parametrize("accuracy", [1e-7, pytest.param(1e-11, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("case", ["narrow", pytest.param("slow", marks=pytest.mark.nightly)])
def test_wires_that_the_bar_folds_flat_on_each_other_jam(case: str, accuracy: float) -> None:
    """Parallel wires touch at a root too, where no force can turn the wire, while the hub turns on."""
    tool, row = FOLDED[case]
    row = row | {"neighbour_friction": 0.13, "neighbour_restitution": 0.85}
    scene = simulate_row(tool, Settings(accuracy=ACCURACY), **row)
    reference = simulate_row_reference(tool, accuracy=accuracy, **row)
    for runs in (scene, reference):
        assert {run.stop_reason for run in runs} == {StopReason.JAM}
        assert runs[0].angles[-1] == pytest.approx(runs[1].angles[-1], abs=10.0 * ACCURACY)
    # A step of the reference fails within 1e-3 radians of its fastest motion before the wires lie flat.
    early = 1e-3 / Chain(tool, 0.0).fastest_rate
    assert reference[0].time[-1] == pytest.approx(scene[0].time[-1], abs=early)


@pytest.mark.parametrize(
    ("keys", "given"),
    [
        (
            {
                "hub_speed": 459.281,
                "bristle_length": 0.0210072,
                "wire_diameter": 0.000739459,
                "belt_damping_ratio": 0.187155,
                "friction": 0.786962,
                "restitution": 0.299785,
                "bar_friction": 0.0183838,
                "bar_restitution": 0.0,
                "belt_stiffness": 0.037562,
                "bar_radius": 0.00582342,
                "bar_horizontal": 0.0438159,
                "bar_vertical": 0.00901247,
                "penetration": 0.00358708,
                "contact": "compliant",
                "contact_duration": 7.95089e-05,
            },
            {
                "bristles": 2,
                "pitch": 0.0698105,
                "neighbour_friction": 0.339199,
                "neighbour_restitution": 0.477639,
            },
        ),
        (
            {
                "hub_speed": 322.255,
                "bristle_length": 0.0400828,
                "wire_diameter": 0.000736845,
                "friction": 0.150576,
                "restitution": 0.795026,
                "bar_friction": 0.25312,
                "bar_restitution": 0.404143,
                "belt_stiffness": 0.142085,
                "bar_radius": 0.00675974,
                "bar_horizontal": 0.0576011,
                "bar_vertical": 0.0118434,
                "penetration": 0.00205687,
                "contact": "compliant",
                "contact_duration": 0.00014895,
            },
            {
                "bristles": 2,
                "pitch": 0.0807274,
                "neighbour_friction": 0.00678296,
                "neighbour_restitution": 0.106317,
            },
        ),
    ],
    ids=["the reference cannot go on", "no end of impacts in both"],
)
def test_the_endless_impacts_of_a_jam_are_one_record(
    keys: dict[str, Any], given: dict[str, Any]
) -> None:
    """The bar and the other wire wedge the first wire: 256 impacts had hundreds of times the impulse of the run before."""
    tool = Tool().replace(**keys)
    scene = simulate_row(tool, Settings(accuracy=1e-7), **given)
    reference = simulate_row_reference(tool, accuracy=1e-9, **given)
    for run, other in zip(scene, reference, strict=True):
        assert run.stop_reason == other.stop_reason == StopReason.JAM
        jammed = run.event_time("jam")
        assert run.events[-1].time == jammed == pytest.approx(other.event_time("jam"), rel=1e-6)
        for one in (run, other):
            last = [each.outcome for each in one.contacts if each.time >= jammed * (1.0 - 1e-6)]
            assert last in ([], ["jam"])
        assert run.rates[-1] == pytest.approx(other.rates[-1], rel=1e-5)
        for obstacle in {each.obstacle for each in run.contacts}:
            found, expected = (
                np.sum(
                    [
                        each.impulse
                        for each in one.contacts
                        if each.obstacle == obstacle and each.time < jammed * (1.0 - 1e-6)
                    ],
                    axis=0,
                )
                for one in (run, other)
            )
            assert found == pytest.approx(expected, abs=1e-6 * np.hypot(*expected))


def test_records_are_of_the_bristles_that_take_part() -> None:
    """Three in a row: the foremost and the last do not touch each other."""
    runs = row(3, 12.0)
    assert all(len(each.angles) == 1 for run in runs for each in run.contacts)
    partners = [
        {each.neighbour for each in run.contacts if each.obstacle == "wire"} for run in runs
    ]
    assert partners == [{2}, {1, 3}, {2}]
    times = [{each.time for each in run.events if each.name == "wire touch"} for run in runs]
    assert times[0] | times[2] == times[1]


@pytest.mark.parametrize("pitch", [0.0, 0.01])
def test_wires_in_each_other_at_the_start_are_refused(pitch: float) -> None:
    """Also where they coincide, and no direction is the normal's."""
    with pytest.raises(
        ValueError,
        match=r"^pitch = .*must be one at which bristles are clear of each other at the start",
    ):
        simulate_row(Tool(), bristles=2, pitch=pitch, **ELASTIC)


def test_a_number_of_bristles_is_a_whole_one() -> None:
    with pytest.raises(ValueError, match=r"^bristles = 0.*: must be a whole number"):
        simulate_row(Tool(), bristles=0, pitch=0.3, **ELASTIC)


def test_wires_without_thickness_are_refused() -> None:
    """A gap that is a distance of centre lines never becomes negative, so no touch would be found."""
    thin = Tool(bristle=Bristle(wire_diameter=0.0, mass=8.387e-5))
    with pytest.raises(ValueError, match=r"^wire_diameter = 0: must be above 0"):
        row(2, 10.0, thin)
