"""The drawn tool: the recorded centre line, the wire's outline, the view."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from bristle_sim.parameters import Bristle, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.render.drawing import WireDrawing
from bristle_sim.render.pass_figure import pass_figure
from bristle_sim.render.story import key_events
from bristle_sim.render.tool_films import pass_film
from bristle_sim.scene.simulate import simulate
from bristle_sim.trajectory import Trajectory
from swinging_bristle import END, artist, make_trajectory


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return make_trajectory()


@pytest.fixture(scope="module")
def figure(run):
    return pass_figure(run, Tool(), until=END)


def kinked(run: Trajectory, corners: int = 5) -> Trajectory:
    """The same run with a centre line that no tool has: four links at odd angles, and with its own velocities."""
    spread_out = np.linspace(0.0, 1.0, corners)[:, None] ** [1.0, 1.7]
    root, tip = run.centre_line[:, :1], run.centre_line[:, 1:]
    lines = root + (0.8 * tip - root) * spread_out
    velocities = (
        run.centre_line_velocity[:, :1] * (1.0 - spread_out) + 0.8 * run.centre_line_velocity[:, 1:] * spread_out
    )
    return dataclasses.replace(run, centre_line=lines, centre_line_velocity=velocities)


def test_pictures_show_the_recorded_centre_line_and_nothing_of_their_own(run):
    """Of whatever shape: were any length, knee or angle of the tool used, wire and record would part."""
    odd = kinked(run)
    figure = pass_figure(odd, Tool(), until=END)
    for number, event in enumerate(key_events(odd), start=1):
        for wire in figure.findobj(lambda each, number=number: each.get_gid() == f"wire {number}"):
            shown = wire.get_xydata()
            # A wire that ends an interval is a sample; the others lie between two: Hermite's cubic, as above.
            assert shown == pytest.approx(1e3 * odd.at(event.time).centre_line, abs=1e-9)
    path = np.concatenate([artist(figure, name).get_xydata() for name in ("tip path", "tip path after the strike")])
    for sample in 1e3 * odd.tip:
        assert np.hypot(*(path - sample).T).min() < 1e-9  # mm: every recorded tip is on the path
    scene = pass_film(odd, Tool(), width=320, height=240, duration=1.0, until=END)
    for number in (10, 30, 60, 100):
        scene.show(float(scene.warp.film_time(odd.time[number])))
        shown = scene.wires[0][0].wire.get_xydata()
        # The warp's inverse is linear between 4001 nodes: an instant off by rounding, times 40 m/s.
        assert shown == pytest.approx(1e3 * odd.centre_line[number], abs=1e-6)
        assert scene.trail.get_xydata()[-1] == pytest.approx(1e3 * odd.tip[number], abs=1e-6)


@pytest.fixture(scope="module", params=[-30.0, 0.0, 30.0, 45.0])
def bent(request) -> tuple[Tool, Trajectory]:
    """A pass of a bent bristle up to its strike, in the scene."""
    tool = Tool(bristle=Bristle(knee_angle_deg=request.param))
    return tool, simulate(tool, stop_after="strike")


def test_a_bent_wire_touches_the_bar_and_strikes_the_workpart_in_the_picture(bent):
    tool, run = bent
    figure = pass_figure(run, tool)
    numbers = {event.name: number for number, event in enumerate(key_events(run), start=1)}
    struck = artist(figure, f"wire {numbers['strike']}").get_xydata()
    assert struck[-1] == pytest.approx(1e3 * run.tip[-1], abs=1e-9)
    assert struck[-1, 1] == pytest.approx(-1e3 * tool.workpart_depth, abs=1e-6)  # mm; where the touch is located
    touching = artist(figure, f"wire {numbers['bar touch']}").get_xydata()
    distance = min(_distance(1e3 * np.array(tool.bar.centre), *piece) for piece in itertools.pairwise(touching))
    assert distance == pytest.approx(1e3 * tool.bar_reach, abs=1e-6)
    speed = math.hypot(*run.first_contact("workpart").velocity_before)
    written = "\n".join(each.get_text() for each in figure.findobj(Text))
    assert f"tip arrives at {speed:.2f} m/s" in written
    assert run.at(run.event_time("strike"), side="before").tip_speed == pytest.approx(speed, rel=1e-9)


def _distance(point: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    """Of a point from a straight piece of wire."""
    along = end - start
    share = min(max(float((point - start) @ along / (along @ along)), 0.0), 1.0)
    return float(np.hypot(*(point - start - share * along)))


def test_the_bent_wire_is_as_long_as_it_is_and_moves_as_it_is_drawn(bent):
    tool, run = bent
    pieces = np.diff(run.centre_line, axis=1)
    lengths = np.hypot(pieces[..., 0], pieces[..., 1])
    assert lengths.sum(axis=1) == pytest.approx(np.full(run.time.size, tool.bristle.length), rel=1e-12)
    step = 1e-8
    longest = int(np.diff(run.time).argmax())
    time = 0.5 * (run.time[longest] + run.time[longest + 1])
    ends = [run.at(time + shift).tip for shift in (-step, step)]
    # The central difference of a cubic is off by h^2 and rounding, 1e-17 m / 1e-8 s of 20 m/s.
    assert run.at(time).tip_speed == pytest.approx(np.hypot(*(ends[1] - ends[0])) / (2.0 * step), rel=1e-7)


def test_scene_and_reference_agree_on_the_centre_line():
    """Written by each from its own kinematics; compared at the strike, where both have a sample."""
    tool = Tool(bristle=Bristle(knee_angle_deg=-30.0))
    run, other = simulate(tool, stop_after="strike"), simulate_reference(tool, accuracy=1e-9, stop_after="strike")
    assert run.centre_line.shape[1:] == other.centre_line.shape[1:] == (3, 2)
    before = [np.flatnonzero(each.time == each.first_contact("workpart").time)[0] for each in (run, other)]
    places = [each.centre_line[at] for each, at in zip((run, other), before, strict=True)]
    velocities = [each.centre_line_velocity[at] for each, at in zip((run, other), before, strict=True)]
    # Accuracy 1e-6, magnified tenfold as elsewhere: of 55 mm and 40 m/s.
    assert places[0] == pytest.approx(places[1], abs=1e-5 * 0.055)
    assert velocities[0] == pytest.approx(velocities[1], abs=1e-5 * 40.0)


def test_a_wire_is_as_thick_as_the_drawing_shows_it():
    """0.7 mm in a picture of 10 mm that is 5 inches, 360 points, wide; and half a point so that a hair can be seen."""
    axes = Figure(figsize=(5.0, 5.0)).add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, 10.0), ylim=(0.0, 10.0))
    tool = Tool(bristle=Bristle(wire_diameter=7e-4))
    assert WireDrawing(axes, tool).wire.get_linewidth() == pytest.approx(0.5 + 0.7 * 36.0)
