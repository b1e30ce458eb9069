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
def test_only_a_decision_changes_contacts(name: str) -> None:
    """A decision takes no time. Between decisions time passes, and the contacts stay; at the end of the run none is left."""
    tool, options = TOOLS[name]
    *course, last = bs.snapshots(tool, COARSE, **options)
    assert course[0].time == 0.0
    for before, after in itertools.pairwise(course):
        if before.event:
            assert after.time == before.time
            assert not after.event
        else:
            assert after.time > before.time or after.event
            assert [each.link for each in after.contacts] == [each.link for each in before.contacts]
            assert [each.mode for each in after.contacts] == [each.mode for each in before.contacts]
        assert "\n" not in str(after)
    assert last.contacts == ()


def test_a_contact_in_time_loads_unloads_and_ends() -> None:
    """In the phases of the rigid-body law, with Coulomb's force against the slip in each."""
    tool, options = TOOLS["a contact in time"]
    modes = []
    for snapshot in bs.snapshots(tool, COARSE, **options):
        for each in snapshot.contacts:
            if each.obstacle != "workpart":
                continue
            modes.append(each.mode)
            if each.normal_force:
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
