"""A tool in a TOML file: every digit comes back, and what is misspelt is refused with the likely key."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bristle_sim import Settings, Trajectory, simulate
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Hub, Tool, Workpart
from bristle_sim.tool_file import read_keys, read_tool, write_tool

ratio = st.floats(0.0, 1.0)
tools = st.builds(
    Tool,
    hub=st.builds(Hub, speed=st.floats(0.0, 1e6)),
    belt=st.builds(Belt, damping_ratio=ratio),
    bristle=st.builds(Bristle, mass=st.floats(1e-30, 1.0), knee_angle_deg=st.floats(-90.0, 20.0)),
    bar=st.none() | st.builds(Bar, friction=ratio),
    workpart=st.none()
    | st.builds(Workpart, penetration=st.floats(0.0, 1e-3), restitution_friction=st.none() | ratio),
    contact=st.just(Contact("compliant", 1e-4))
    | st.builds(Contact, st.sampled_from(["energetic", "engine"])),
    gravity=ratio,
)


@given(tools)
@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_tool_comes_back_as_it_was_written(tmp_path: Path, tool: Tool):
    write_tool(tool, tmp_path / "tool.toml")
    assert read_tool(tmp_path / "tool.toml") == tool


def test_a_comment_states_meaning_and_source_and_the_value_its_unit(tmp_path: Path):
    write_tool(Tool(), tmp_path / "tool.toml")
    text = (tmp_path / "tool.toml").read_text()
    assert (
        '# speed of the hub\'s rotation (default: Zhang 2020, eq. 2.2)\nhub_speed = "261.8 rad/s"\n'
        in text
    )
    assert "# restitution_friction = none" in text
    assert tomllib.loads(text)["friction"] == 0.31


def test_only_a_mass_that_was_given_is_written(tmp_path: Path):
    for tool, mass in (
        (Tool().replace(bristle_length=0.03), 2.0),
        (Tool().replace(bristle_mass=1e-4), 1.0),
    ):
        write_tool(tool, tmp_path / "tool.toml")
        longer = read_tool(tmp_path / "tool.toml").replace(bristle_length=2.0 * tool.bristle.length)
        assert longer.bristle.mass == pytest.approx(mass * tool.bristle.mass, rel=1e-15)


def read(tmp_path: Path, text: str) -> Tool:
    path = tmp_path / "tool.toml"
    path.write_text(text, encoding="utf-8")
    return read_tool(path)


def test_a_value_may_carry_its_unit_and_what_is_left_out_has_its_default(tmp_path: Path):
    tool = read(tmp_path, 'bar = false\nhub_speed = "3000rpm"\nfriction = 1\n')
    assert tool.hub.speed == pytest.approx(
        100.0 * 3.141592653589793, rel=1e-15
    )  # 3000/60 turns a second
    assert tool.bar is None
    assert tool.workpart == Workpart(friction=1.0)
    assert tool.bristle == Bristle()
    assert read(tmp_path, "\ufeffhub_speed = 300\n") == Tool(
        hub=Hub(speed=300.0)
    )  # after a byte order mark


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hub_sped = 3", r"unknown key 'hub_sped'; did you mean hub_speed\?"),
        ("[hub]\nhub_speed = 3", r"\[hub\]: must have no tables, but one line for each key"),
        ("zzz = 3", "unknown key 'zzz'; must be one of bar_friction"),
        ("hub = false", "unknown key 'hub'; must be one of bar_friction"),
        ("bar = true", "bar = True: must be false, where the tool has none"),
        ("hub_speed = 1" + 400 * "0", "hub_speed = 10000"),
        (
            "hub_speed = -3",
            r"hub_speed = -3.0: must be a finite number with 0 <= hub_speed <= 1e\+06",
        ),
        ("hub_speed = true", "hub_speed = True: must be a finite number"),
        ('contact = "rubber"', "contact = 'rubber': must be one of"),
        ("penetration = 1", "penetration = 1: must be less"),
        ("\x00", "must be a TOML file"),
        ("a = " + 100_000 * "[" + 100_000 * "]", "must be a TOML file"),
    ],
)
def test_what_is_no_tool_is_refused_in_one_line(text: str, words: str, tmp_path: Path):
    with pytest.raises(ValueError, match=words) as refusal:
        read(tmp_path, text)
    assert str(refusal.value).startswith(f"{tmp_path / 'tool.toml'}: ")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("path", [None, 3, b"tool.toml"])
def test_a_path_that_is_no_text_is_refused_in_one_line(path: Any):
    """Of a tool's file and of a run's."""
    run = simulate(Tool(bar=None, workpart=None), Settings(maximum_steps=100))
    for call in (
        lambda: read_tool(path),
        lambda: write_tool(Tool(), path),
        lambda: run.save(path),
        lambda: Trajectory.load(path),
        lambda: run.animate(path),
    ):
        with pytest.raises(ValueError, match=r"^path = [^\n]+: must be the name of a file$"):
            call()


def test_further_keys_stand_beside_those_of_the_tool(tmp_path: Path):
    (tmp_path / "tool.toml").write_text("accuracy = 1e-8\nhub_speed = 3\n")
    assert read_keys(tmp_path / "tool.toml", ["accuracy"]) == {
        "accuracy": 1e-08,
        "hub_speed": 3,
    }
    with pytest.raises(ValueError, match="unknown key 'accuracy'"):
        read_keys(tmp_path / "tool.toml")
