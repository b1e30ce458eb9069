"""The picture of a pass: its lines, its texts and their places."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.text import Text

from bristle_sim.parameters import Tool
from bristle_sim.render.pass_figure import pass_figure, spread
from bristle_sim.trajectory import Event, Trajectory
from swinging_bristle import END, STRIKE, artist, make_trajectory


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


def test_drawing_is_to_scale(figure):
    (left, right), (bottom, top) = figure.axes[0].get_xlim(), figure.axes[0].get_ylim()
    box = figure.axes[0].get_window_extent()
    assert (right - left) / box.width == pytest.approx((top - bottom) / box.height, rel=1e-6)


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
