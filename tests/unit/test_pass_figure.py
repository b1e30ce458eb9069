"""The picture of a pass: its lines, its texts and their places."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.text import Text

from bristle_sim.parameters import Tool
from bristle_sim.render.pass_figure import pass_figure, spread
from bristle_sim.render.story import key_events
from bristle_sim.trajectory import Event, Trajectory
from swinging_bristle import AMPLITUDE, END, FREQUENCY, STRIKE, artist, make_trajectory


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return make_trajectory()


@pytest.fixture(scope="module")
def figure(run):
    return pass_figure(run, Tool(), until=END)


def test_lines_hold_the_samples(figure, run):
    lag, rate = artist(figure, "retraction"), artist(figure, "relative speed")
    at = [int(np.flatnonzero(np.isclose(lag.get_xdata(), 1e3 * time, atol=1e-12))[0]) for time in run.time[:60]]
    assert lag.get_ydata()[at] == pytest.approx(-np.degrees(run.relative_angle[:60]), abs=1e-9)
    assert rate.get_ydata()[at[:-1]] == pytest.approx(run.relative_rate[:59], abs=1e-6)  # rad/s of 770
    assert lag.get_xdata()[-1] == pytest.approx(1e3 * run.time[-1])


def test_rate_line_jumps_at_the_strike(figure):
    rate = artist(figure, "relative speed")
    jump = rate.get_ydata()[np.isclose(rate.get_xdata(), 1e3 * STRIKE, atol=1e-12)]
    expected = AMPLITUDE * FREQUENCY * math.sin(FREQUENCY * STRIKE)
    assert jump == pytest.approx([expected, -expected], rel=1e-9)


def test_paths_meet_at_the_strike(figure, run):
    struck = 1e3 * run.tip[60]
    assert artist(figure, "tip path").get_xydata()[-1] == pytest.approx(struck, abs=1e-9)
    assert artist(figure, "tip path after the strike").get_xydata()[0] == pytest.approx(struck, abs=1e-9)


def test_ghost_ends_at_the_tip(figure, run):
    number = 1 + [event.name for event in key_events(run)].index("strike")
    assert artist(figure, f"wire {number}").get_xydata()[-1] == pytest.approx(1e3 * run.tip[60], abs=1e-9)


def test_drawing_is_to_scale(figure):
    (left, right), (bottom, top) = figure.axes[0].get_xlim(), figure.axes[0].get_ylim()
    box = figure.axes[0].get_window_extent()
    assert (right - left) / box.width == pytest.approx((top - bottom) / box.height, rel=1e-6)


def overlaps(figure) -> list[tuple[str, str]]:
    """Texts that are written over each other, but for slanted ones, whose boxes say little."""
    figure.draw_without_rendering()
    scales = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    ticks = {id(each) for axis in scales for each in axis.findobj(Text) if each is not axis.label}
    texts = [each for each in figure.findobj(Text) if each.get_text().strip() and id(each) not in ticks]
    boxes = [(each.get_text(), each.get_window_extent()) for each in texts if each.get_rotation() % 90.0 == 0.0]
    pairs = itertools.combinations(boxes, 2)
    return [(one, other) for (one, box), (other, second) in pairs if box.shrunk(0.98, 0.9).overlaps(second)]


def numbers_above(figure) -> list[Text]:
    """Numbers of the events above the panels over time."""
    panel = next(axes for axes in figure.axes if axes.get_ylabel() == "retraction (°)")
    return [each for each in panel.texts if each.get_text().isdigit()]


def test_a_run_without_a_strike_or_obstacles_is_drawn():
    run = make_trajectory(events=(Event("highest relative speed", STRIKE),))
    bare = dataclasses.replace(run, contacts=())
    written = {each.get_text() for each in pass_figure(bare, Tool(bar=None, workpart=None)).findobj(Text)}
    assert "no strike; the run ended:" in written
    assert not {"bar", "workpart"} & written


@given(st.lists(st.floats(0.0, 1.0), max_size=8).map(sorted))
def test_spread_keeps_gap_order_and_bounds(positions):
    moved = spread(positions, 0.1, 0.0, 1.0)
    assert (np.diff(moved) >= 0.1 - 1e-12).all()
    assert ((moved >= -1e-12) & (moved <= 1.0 + 1e-12)).all()
