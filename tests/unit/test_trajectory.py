"""Trajectories: events, tables, summaries and pictures; how they move between samples is in test_interpolation.py."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from bristle_sim import simulate
from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Tool
from bristle_sim.settings import StopReason
from bristle_sim.trajectory import Event, Trajectory
from swinging_bristle import make_trajectory

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    """A run in closed form, of no tool that it knows."""
    events = (
        Event("bar touch", 1e-4),
        Event("bar release", 1.5e-4),
        Event("bar touch", 2e-4),
        Event("strike", 1.4e-3),
    )
    run = make_trajectory(events=events)
    on_bar = dataclasses.replace(run.contacts[0], obstacle="bar", time=1e-4)
    return dataclasses.replace(run, contacts=(on_bar, *run.contacts, run.contacts[0]))


@pytest.fixture(scope="module")
def run() -> Trajectory:
    """A whole pass of the default tool."""
    return simulate(Tool())


def test_a_run_is_summarized_in_five_lines(run: Trajectory):
    lines = repr(run).splitlines()
    assert [line.split(":")[0] for line in lines] == [
        "Trajectory",
        "strike",
        "events",
        "stopped",
        "cost",
    ]
    assert "rebound at 4.53 ms" in lines[1]  # the finding of README
    assert "strike: none" in repr(simulate(Tool(workpart=None)))


def test_a_notebook_shows_a_drawing_to_scale(
    run: Trajectory, trajectory: Trajectory, tmp_path: Path
):
    page = ET.fromstring(run._repr_html_())
    circles = [float(each.attrib["r"]) for each in page.iter(f"{SVG}circle")]
    assert circles == pytest.approx([Tool().hub.radius, Bar().radius], rel=1e-5)  # six digits
    path = next(page.iter(f"{SVG}polyline")).attrib["points"].split()
    assert [float(each) for each in path[0].split(",")] == pytest.approx(
        run.tip[0], rel=1e-5
    )  # six digits
    # A run of no tool still shows its path, and a tool without bar and workpart its hub and wire.
    assert "polyline" in trajectory._repr_html_()
    bare = simulate(Tool(bar=None, workpart=None), start_relative_angle=-0.5)._repr_html_()
    assert (bare.count("<circle"), "<line" in bare) == (1, False)
    wrong = dataclasses.replace(run, parameters={"tool": {}})
    with pytest.raises(ValueError, match="parameters: must describe the tool"):
        wrong._repr_html_()
    assert run.plot()._repr_png_().startswith(b"\x89PNG")  # matplotlib's own way needs pyplot
    film = run.animate(tmp_path / "pass.gif", duration=0.2, fps=10, size=(160, 120))
    assert film.read_bytes().startswith(b"GIF8")


def test_the_tool_is_known_to_its_run(run: Trajectory, trajectory: Trajectory):
    assert run.tool == Tool()
    bare = Tool(bar=None, workpart=None)
    assert simulate(bare).tool == bare
    with pytest.raises(ValueError, match=r"^parameters: must describe the tool"):
        _ = trajectory.tool


def test_tables_hold_every_sample_with_its_unit(run: Trajectory):
    columns = run.columns()
    frame = run.to_dataframe()
    table = run.to_xarray()
    assert all(
        len(column) == len(run.time) and name.endswith(")") for name, column in columns.items()
    )
    np.testing.assert_array_equal(columns["angle_1 (rad)"], run.angles[:, 0])
    np.testing.assert_array_equal(columns["tip_y (m)"], run.tip[:, 1])
    assert list(frame["time"]) == run.time.tolist()
    assert frame.attrs["units"]["rate_1"] == "rad/s"
    assert set(frame.attrs["units"]) == set(frame.columns)
    # Chains of instants in common are moved by a few doubles, so that a time is one of the table's.
    assert np.all(np.diff(table["time"].values) > 0.0)
    np.testing.assert_allclose(table["time"], run.time, rtol=1e-15)
    assert table["instant"].values.tolist() == run.time.tolist()
    units = {variable.attrs.get("units") for variable in table.data_vars.values()}
    assert units <= {"s", "rad", "rad/s", "m", "m/s", "J", "N"}
    middle = table.interp(time=0.5 * (run.time[3] + run.time[4]))
    assert float(middle["angle"].sel(link=1)) == pytest.approx(
        0.5 * (run.angles[3, 0] + run.angles[4, 0]), rel=1e-14
    )
    assert float(table["event_time"].sel(event="strike")) == run.event_time("strike")


@pytest.mark.parametrize(
    ("library", "method"), [("pandas", "to_dataframe"), ("xarray", "to_xarray")]
)
def test_a_missing_library_is_named_with_its_remedy(
    run: Trajectory, library: str, method: str, monkeypatch
):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(
        ImportError, match=rf"^{library}: must be installed: pip install bristle-sim\[sweep\]$"
    ):
        getattr(run, method)()


def test_events_and_contacts_are_found_by_name(trajectory: Trajectory):
    assert trajectory.event_time("bar touch") == 1e-4
    assert trajectory.event_time("bar touch", last=True) == 2e-4
    assert trajectory.event_time("bar touch", last=True, before=1.9e-4) == 1e-4
    assert trajectory.event_time("bar touch", last=True, before=2e-4) == 2e-4
    for name, options in (
        ("bar touch", {"before": 0.5e-4}),
        ("jam", {}),
        ("workpart not reached", {}),
    ):
        assert trajectory.event_time(name, **options) is None
    assert trajectory.first_contact("bar") is trajectory.contacts[0]
    assert trajectory.first_contact("workpart") is trajectory.contacts[1]
    assert trajectory.first_contact("wire") is None


@pytest.mark.parametrize(
    ("name", "likely"),
    [
        ("strik", "strike"),
        ("Strike", "strike"),
        ("bar relese", "bar release"),
        ("work part", "workpart"),
    ],
)
def test_an_unknown_name_is_refused_with_the_likely_one(
    trajectory: Trajectory, name: str, likely: str
):
    call = trajectory.first_contact if likely == "workpart" else trajectory.event_time
    with pytest.raises(
        ValueError, match=rf"^\w+ = '{name}': must be one of [^\n]*; did you mean {likely}\?$"
    ) as refusal:
        call(name)
    names = str(refusal.value).partition("one of ")[2].partition(";")[0].split(" | ")
    assert len(names) == len({*names})


def test_every_stop_reason_has_a_remedy_and_is_saved(trajectory: Trajectory, tmp_path: Path):
    """The advice names the friction of the obstacle that was touched last."""
    for reason in StopReason:
        assert reason.remedy
        stopped = dataclasses.replace(trajectory, stop_reason=reason)
        assert "{" not in stopped.stop_advice
        stopped.save(tmp_path / "run.npz")
        assert Trajectory.load(tmp_path / "run.npz").stop_reason is reason
    jammed = dataclasses.replace(trajectory, stop_reason=StopReason.JAM)
    assert jammed.stop_advice.startswith("less friction")
    assert dataclasses.replace(jammed, contacts=trajectory.contacts[:1]).stop_advice.startswith(
        "less bar_friction"
    )


def test_runs_are_equal_by_value(trajectory: Trajectory):
    """Also where they hold NaN."""
    twin = dataclasses.replace(trajectory, time=trajectory.time.copy())
    assert twin == trajectory
    assert trajectory in [twin]
    assert dataclasses.replace(trajectory, rates=trajectory.rates + 1e-12) != trajectory
    unknown = dataclasses.replace(trajectory, normal_force=np.full_like(trajectory.time, np.nan))
    assert unknown == dataclasses.replace(unknown, normal_force=unknown.normal_force.copy())
    assert trajectory != "run"


def test_an_accuracy_that_is_missed_a_hundredfold_is_said(trajectory: Trajectory):
    """In the summary, and in the answer and the remarks of a report, once."""
    requested = {"settings": {"accuracy": 1e-6}}

    def run(estimate: float | None) -> Trajectory:
        cost = dataclasses.replace(trajectory.cost, error_estimate=estimate)
        return dataclasses.replace(trajectory, cost=cost, parameters=requested)

    line = "accuracy not reached: error estimate 0.0003, 300 times the requested accuracy 1e-06; request a smaller accuracy"
    assert run(3e-4).accuracy_not_reached == line
    assert repr(run(3e-4)).splitlines()[-1] == line
    assert [run(each).accuracy_not_reached for each in (None, 0.0, 9e-5)] == ["", "", ""]
    report = Report(answer="The bristle strikes.", remarks=("a",), not_reached=line)
    again = dataclasses.replace(report, steps=1)
    assert again.answer == "Accuracy not reached: The bristle strikes."
    assert again.remarks == ("a", line)
