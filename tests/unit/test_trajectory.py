"""Trajectories: events, motion between samples, tables, summaries, pictures, and files that hold them completely or not at all."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from bristle_sim.parameters import Bar, Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactHistory, ContactRecord, Cost, Event, Trajectory


def history(samples: int = 7) -> ContactHistory:
    ramp = np.linspace(0.0, 1.0, samples)
    return ContactHistory(ramp * 1e-5, np.sin(np.pi * ramp), -0.3 * ramp, ramp**2, 1.0 - 2.0 * ramp, 0.1 - ramp)


def impact(time: float, obstacle: str, kept: ContactHistory | None = None) -> ContactRecord:
    return ContactRecord(
        obstacle=obstacle,
        law="compliant" if kept else "energetic",
        outcome="rebound",
        time=time,
        duration=1e-5 if kept else 0.0,
        impulse=(2e-3, -6e-4),
        compressive_impulse=None if obstacle == "bar" else (1e-3, -3e-4),
        compressive_work=None if obstacle == "bar" else (-7e-3, -5e-3),
        restitutive_work=None if obstacle == "bar" else (1e-3, -1e-3),
        velocity_before=(-15.0, 33.0),
        velocity_after=(5.0, 20.0),
        angles=(0.4, 0.1 + 0.2),
        rates_before=(877.1, 1.0 / 3.0),
        rates_after=(-497.1, -0.1),
        phases=("compression slip", "restitution slip"),
        history=kept,
    )


@pytest.fixture
def trajectory() -> Trajectory:
    """Two links on a hub at 2 rad/s; the first lags by 0.5 rad and swings at 3 rad/s relative to the hub."""
    time = np.linspace(0.0, 0.4, 5)
    hub_angle = -1.0 + 2.0 * time
    angles = np.column_stack([hub_angle - 0.5 + 3.0 * time, np.pi * time])
    return Trajectory(
        time=time,
        hub_angle=hub_angle,
        angles=angles,
        rates=np.column_stack([np.full(5, 5.0), np.full(5, np.pi)]),
        centre_line=np.arange(30.0).reshape(5, 3, 2) / 7.0,
        centre_line_velocity=np.arange(30.0).reshape(5, 3, 2) / 3.0,
        kinetic_energy=np.arange(5.0),
        potential_energy=np.arange(5.0) ** 2,
        normal_force=np.zeros(5),
        hub_speed=2.0,
        events=(
            Event("bar touch", 0.1),
            Event("bar release", 0.15),
            Event("bar touch", 0.2),
            Event("strike", 0.1 + 0.2),
        ),
        contacts=(impact(0.1, "bar"), impact(0.3, "workpart", history()), impact(0.35, "workpart", history(2))),
        stop_reason=StopReason.END,
        cost=Cost(0.25, 0.2, 1234, 1e-9),
        parameters={"hub_speed": 2.0, "step": None, "law": "energetic", "nested": {"friction": 0.1}},
    )


def test_relative_motion(trajectory: Trajectory):
    # Differences of numbers near 1: a few roundings.
    np.testing.assert_allclose(trajectory.relative_angle, -0.5 + 3.0 * trajectory.time, atol=1e-15)
    np.testing.assert_allclose(trajectory.retraction, 0.5 - 3.0 * trajectory.time, atol=1e-15)
    np.testing.assert_array_equal(trajectory.tip, trajectory.centre_line[:, 2])
    np.testing.assert_array_equal(trajectory.tip_velocity, trajectory.centre_line_velocity[:, 2])
    np.testing.assert_array_equal(trajectory.relative_rate, 3.0)
    np.testing.assert_array_equal(trajectory.total_energy, [0.0, 2.0, 6.0, 12.0, 20.0])


@pytest.fixture(scope="module")
def run() -> Trajectory:
    """A whole pass of the default tool."""
    return simulate(Tool())


def test_a_run_is_summarized_in_five_lines(run: Trajectory):
    lines = repr(run).splitlines()
    assert [line.split(":")[0] for line in lines] == ["Trajectory", "strike", "events", "stopped", "cost"]
    assert "rebound at 4.53 ms" in lines[1]  # the finding of README
    assert "strike: none" in repr(simulate(Tool(workpart=None)))


def test_a_notebook_shows_a_drawing_to_scale(run: Trajectory, trajectory: Trajectory):
    page = ET.fromstring(run._repr_html_())
    drawing = page.find(".//{*}svg")
    circles = [float(each.attrib["r"]) for each in page.iter("{http://www.w3.org/2000/svg}circle")]
    assert drawing is not None
    assert circles == pytest.approx([Tool().hub.radius, Bar().radius], rel=1e-5)  # six digits
    path = next(page.iter("{http://www.w3.org/2000/svg}polyline")).attrib["points"].split()
    assert [float(each) for each in path[0].split(",")] == pytest.approx(run.tip[0], rel=1e-5)  # six digits
    # What was not a tool still shows its path.
    assert "polyline" in trajectory._repr_html_()


def test_the_tool_is_known_to_its_run(run: Trajectory, trajectory: Trajectory):
    assert run.tool == Tool()
    bare = Tool(bar=None, workpart=None)
    assert simulate(bare).tool == bare
    with pytest.raises(ValueError, match=r"^parameters: must describe the tool"):
        _ = trajectory.tool


def test_a_dataframe_has_a_column_for_each_quantity(run: Trajectory):
    frame = run.to_dataframe()
    assert list(frame["time"]) == run.time.tolist()
    assert frame.attrs["units"]["rate_1"] == "rad/s"
    assert set(frame.attrs["units"]) == set(frame.columns)


def test_a_dataset_can_be_interpolated_in_time(run: Trajectory):
    table = run.to_xarray()
    assert np.all(np.diff(table["time"].values) > 0.0)
    # Chains of instants in common are moved by a few doubles.
    np.testing.assert_allclose(table["time"], run.time, rtol=1e-15)
    assert table["instant"].values.tolist() == run.time.tolist()
    assert {variable.attrs.get("units") for variable in table.data_vars.values()} <= {
        "s",
        "rad",
        "rad/s",
        "m",
        "m/s",
        "J",
        "N",
    }
    middle = table.interp(time=0.5 * (run.time[3] + run.time[4]))
    assert float(middle["angle"].sel(link=1)) == pytest.approx(0.5 * (run.angles[3, 0] + run.angles[4, 0]), rel=1e-14)
    assert float(table["event_time"].sel(event="strike")) == run.event_time("strike")


@pytest.mark.parametrize(("library", "method"), [("pandas", "to_dataframe"), ("xarray", "to_xarray")])
def test_a_missing_library_is_named_with_its_remedy(run: Trajectory, library: str, method: str, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(ImportError, match=rf"^{library}: must be installed: pip install bristle-sim\[sweep\]$"):
        getattr(run, method)()


def test_the_first_cell_of_a_notebook():
    """A notebook asks the value that a cell returns for its picture; matplotlib's own way needs pyplot."""
    pytest.importorskip("xarray")
    run = simulate(Tool())
    table = run.to_xarray().interp(time=[1e-3, 2e-3, 4e-3])
    # Linear between samples h apart: rate h^2 |d2 rate/dt2|/8 off, some (2 pi/50)^2/8 = 2e-3 of the rates' range.
    np.testing.assert_allclose(
        table["rate"].sel(link=1), run.at([1e-3, 2e-3, 4e-3]).rates[:, 0], rtol=0.0, atol=5e-3 * np.ptp(run.rates)
    )
    assert run.plot()._repr_png_().startswith(b"\x89PNG")


def test_events_are_found_by_name(trajectory: Trajectory):
    assert trajectory.event_time("bar touch") == 0.1
    assert trajectory.event_time("bar touch", last=True) == 0.2
    assert trajectory.event_time("bar touch", last=True, before=0.19) == 0.1
    assert trajectory.event_time("bar touch", last=True, before=0.2) == 0.2
    assert trajectory.event_time("bar touch", before=0.05) is None
    assert trajectory.event_time("jam") is None
    assert trajectory.event_time("workpart not reached") is None


@pytest.mark.parametrize(("name", "likely"), [("strik", "strike"), ("Strike", "strike"), ("bar relese", "bar release")])
def test_unknown_event_is_refused_with_the_likely_name(trajectory: Trajectory, name: str, likely: str):
    with pytest.raises(ValueError, match=rf"^name = '{name}': must be one of [^\n]*; did you mean '{likely}'\?$"):
        trajectory.event_time(name)


def test_every_stop_reason_has_a_remedy_and_is_saved(trajectory: Trajectory, tmp_path: Path):
    for reason in StopReason:
        assert reason.remedy
        assert "{" not in reason.advice("bar")
        stopped = dataclasses.replace(trajectory, stop_reason=reason)
        stopped.save(tmp_path / "run.npz")
        assert Trajectory.load(tmp_path / "run.npz").stop_reason is reason


def test_the_advice_names_the_friction_of_the_obstacle_touched_last(trajectory: Trajectory):
    stopped = dataclasses.replace(trajectory, stop_reason=StopReason.JAM)
    assert stopped.stop_advice.startswith("less friction")
    on_bar = dataclasses.replace(stopped, contacts=trajectory.contacts[:1])
    assert on_bar.stop_advice.startswith("less bar_friction")


def test_first_contact(trajectory: Trajectory):
    assert trajectory.first_contact("workpart") is trajectory.contacts[1]
    assert trajectory.first_contact("bar") is trajectory.contacts[0]
    assert trajectory.first_contact("wire") is None
    with pytest.raises(ValueError, match=r"^obstacle = 'bench': must be one of bar, workpart, wire$"):
        trajectory.first_contact("bench")
    with pytest.raises(ValueError, match=r"; did you mean 'workpart'\?$"):
        trajectory.first_contact("work part")


def test_runs_are_equal_by_value(trajectory: Trajectory):
    """Also where they hold NaN."""
    twin = dataclasses.replace(trajectory, time=trajectory.time.copy())
    assert twin == trajectory
    assert trajectory in [twin]
    assert dataclasses.replace(trajectory, rates=trajectory.rates + 1e-12) != trajectory
    unknown = dataclasses.replace(trajectory, normal_force=np.full_like(trajectory.time, np.nan))
    assert unknown == dataclasses.replace(unknown, normal_force=unknown.normal_force.copy())
    assert trajectory != "run"
