"""Snapshots: a run interval by interval is the run that simulate returns."""

from __future__ import annotations

import gc
import itertools

import pymunk
import pytest

import bristle_sim as bs
from bristle_sim.settings import ABSENCES, LARGEST_RETRACTION

COARSE = bs.Settings(accuracy=1e-3)
TOOLS = {
    "impacts": (bs.Tool(), {}),
    "a contact in time": (
        bs.Tool(contact=bs.Contact("compliant", 1e-4)),
        {"stop_after": "workpart release"},
    ),
    "friction at the bar": (bs.Tool(bar=bs.Bar(friction=0.3)), {"stop_after": "strike"}),
    "a wire of links": (bs.Tool(bristle=bs.Bristle(links=2)), {"stop_after": "strike"}),
}


@pytest.mark.parametrize("name", TOOLS)
def test_snapshots_are_the_run_of_simulate(name: str) -> None:
    """Bit for bit, as both drain one loop."""
    tool, options = TOOLS[name]
    run = bs.simulate(tool, COARSE, **options)
    *_, last = seen = [*bs.snapshots(tool, COARSE, **options)]
    assert last.time == run.time[-1]
    assert last.angles == tuple(run.angles[-1].tolist())
    assert last.rates == tuple(run.rates[-1].tolist())
    assert last.stop_reason is run.stop_reason
    assert {each.stop_reason for each in seen[:-2]} == {None}
    # A trajectory keeps one largest retraction, and names at its end the events that never happened.
    expected = [
        (each.name, each.time)
        for each in run.events
        if each.name not in {*ABSENCES, LARGEST_RETRACTION}
    ]
    named = [
        (event, each.time) for each in seen for event in each.events if event != LARGEST_RETRACTION
    ]
    assert named == expected
    impacts = [each for snapshot in seen for each in snapshot.impacts]
    assert [
        (each.obstacle, each.outcome, each.impulse)
        for each in sorted(impacts, key=lambda each: each.time)
    ] == [(each.obstacle, each.outcome, each.impulse) for each in run.contacts]


@pytest.mark.parametrize("name", TOOLS)
def test_contacts_are_those_that_decisions_left(name: str) -> None:
    """What began and has not ended is active; time passes only in intervals; only a decision changes rates."""
    tool, options = TOOLS[name]
    time = 0.0
    active = 0
    for snapshot in bs.snapshots(tool, COARSE, **options):
        assert snapshot.time == pytest.approx(
            time + snapshot.interval, rel=1e-12
        )  # rounding of a difference and a sum
        assert len(snapshot.contacts) == active
        assert snapshot.event or snapshot.rates == snapshot.rates_before
        assert bool(snapshot.event) == bool(snapshot.subject)
        active += len(snapshot.began) - len(snapshot.ended)
        time = snapshot.time
        assert "\n" not in str(snapshot)
    assert active == 0


def test_a_contact_in_time_loads_unloads_and_ends() -> None:
    """In the phases of the rigid-body law, with Coulomb's force against the slip in each."""
    tool, options = TOOLS["a contact in time"]
    modes = []
    for snapshot in bs.snapshots(tool, COARSE, **options):
        modes += [
            each.mode
            for each in (*snapshot.began, *snapshot.changed)
            if each.obstacle == "workpart"
        ]
        for each in snapshot.contacts:
            if each.obstacle == "workpart" and each.normal_force:
                # Coulomb: friction opposes slip, and mu is the ratio of the forces.
                assert each.normal_force > 0.0
                sense = {"slip +": 1.0, "slip -": -1.0}.get(each.mode.split(", ")[1])
                if sense is not None:
                    force = -sense * bs.Workpart().friction * each.normal_force
                    assert each.tangential_force == pytest.approx(force, rel=1e-12)
    rigid = bs.simulate(bs.Tool(), COARSE, stop_after="strike").first_contact("workpart")
    assert rigid.phases == ("compression slip", "restitution slip", "restitution reverse slip")
    assert rigid.velocity_before[1] > 0.0
    assert [mode for mode, _ in itertools.groupby(modes)] == [
        "loading, slip +",
        "unloading, slip +",
        "unloading, slip -",
    ]


def test_an_abandoned_run_leaves_nothing_behind() -> None:
    """No space of the engine survives, and the next run is the same bit for bit."""

    def spaces() -> int:
        gc.collect()
        return sum(isinstance(each, pymunk.Space) for each in gc.get_objects())

    tool, _ = TOOLS["impacts"]
    before = spaces()
    first = bs.simulate(tool, COARSE)
    abandoned = iter(bs.snapshots(tool, COARSE))
    while not next(abandoned).contacts:
        pass
    assert spaces() == before + 1
    del abandoned
    assert spaces() == before
    again = bs.simulate(tool, COARSE)
    assert (again.angles == first.angles).all()


def test_bad_input_is_refused_before_the_first_snapshot() -> None:
    with pytest.raises(ValueError, match="stop_after"):
        bs.snapshots(bs.Tool(), stop_after="bounce")
