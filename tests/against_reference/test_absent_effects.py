"""An effect that a tool does not call for costs nothing and changes nothing: no part in the engine, not a digit of the run."""

import itertools
from dataclasses import fields, replace

import numpy as np
import pymunk
import pytest

from bristle_sim.parameters import Bar, Belt, Hub, Tool, Workpart
from bristle_sim.scene.simulate import simulate
from bristle_sim.trajectory import Trajectory

RETRACTED = -0.7


class Census:
    """What was added to pymunk spaces, and the functions that were set to be called back."""

    def __init__(self) -> None:
        self.added: list[object] = []
        self.callbacks: list[str] = []

    def count(self, kind: type) -> int:
        return sum(isinstance(each, kind) for each in self.added)


@pytest.fixture
def census(monkeypatch: pytest.MonkeyPatch) -> Census:
    """Listens to ``Space.add`` and to every way of having pymunk call back."""
    found = Census()
    true_add = pymunk.Space.add

    def add(space: pymunk.Space, *parts: object) -> None:
        found.added += parts
        true_add(space, *parts)

    def listen(owner: type, name: str) -> None:
        true = getattr(owner, name)

        def called(*arguments: object, **named: object) -> object:
            found.callbacks.append(name)
            return true(*arguments, **named)

        monkeypatch.setattr(owner, name, called)

    monkeypatch.setattr(pymunk.Space, "add", add)
    listen(pymunk.Space, "on_collision")
    listen(pymunk.Body, "each_arbiter")
    listen(pymunk.Space, "add_post_step_callback")
    return found


@pytest.mark.parametrize(("bar", "workpart"), list(itertools.product([False, True], repeat=2)))
@pytest.mark.parametrize("damping_ratio", [0.0, 0.2])
def test_a_run_builds_only_what_its_tool_has(
    census: Census, bar: bool, workpart: bool, damping_ratio: float
) -> None:
    tool = Tool(
        belt=Belt(damping_ratio=damping_ratio),
        bar=Bar() if bar else None,
        workpart=Workpart() if workpart else None,
    )
    simulate(tool, stop_after="strike")
    assert census.count(pymunk.Body) == 2
    # Contacts are solved for with the joints, not by the engine.
    assert census.count(pymunk.Shape) == 0
    springs = [each for each in census.added if isinstance(each, pymunk.DampedRotarySpring)]
    assert len(springs) == 1
    assert (springs[0].damping > 0.0) == (damping_ratio > 0.0)
    assert census.count(pymunk.Constraint) == 2
    assert census.callbacks == []


def test_a_free_rod_is_one_body_and_one_joint(census: Census) -> None:
    bare = Tool(
        hub=Hub(radius=0.0), belt=Belt(stiffness=0.0), bar=None, workpart=None, gravity=9.81
    )
    simulate(bare, start_relative_angle=0.3)
    assert [type(each) for each in census.added] == [pymunk.Body, pymunk.PivotJoint]
    assert census.callbacks == []


def same_motion(first: Trajectory, second: Trajectory) -> bool:
    return all(
        np.array_equal(getattr(first, each.name), getattr(second, each.name))
        for each in fields(Trajectory)
        if each.name not in ("events", "cost", "parameters", "stop_reason")
    )


def test_zero_values_are_absent_effects() -> None:
    """Gravity, damping and friction of exactly zero give the digits of a run that never heard of them."""
    plain = Tool(bar=None, workpart=None)
    named = Tool(belt=Belt(damping_ratio=0.0), bar=None, workpart=None, gravity=0.0)
    assert same_motion(
        simulate(plain, start_relative_angle=RETRACTED),
        simulate(named, start_relative_angle=RETRACTED),
    )


@pytest.mark.parametrize(
    "present",
    [
        {"bar": Bar(horizontal=0.5, vertical=0.5)},
        {"workpart": Workpart(penetration=-0.5)},
        {
            "bar": Bar(horizontal=0.5, vertical=0.5, friction=0.9, restitution=1.0),
            "workpart": Workpart(penetration=-0.5),
        },
    ],
    ids=["bar", "workpart", "both"],
)
def test_out_of_reach_is_as_good_as_absent(present: dict[str, object]) -> None:
    """The motion does not feel an obstacle that it does not touch.

    With obstacles the error is relative to 1 rad instead of to the swing, so that steps may differ, by the accuracy.
    """
    absent = Tool(bar=None, workpart=None)
    first = simulate(absent, start_relative_angle=RETRACTED)
    second = simulate(replace(absent, **present), start_relative_angle=RETRACTED)
    assert second.time[-1] == first.time[-1]
    assert second.relative_angle[-1] == pytest.approx(first.relative_angle[-1], abs=1e-6)
    assert second.contacts == ()
