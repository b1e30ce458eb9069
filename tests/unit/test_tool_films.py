"""The film of a pass, and slow motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from bristle_sim.parameters import Bar, Hub, Tool
from bristle_sim.render.film import slow_motion
from bristle_sim.render.pass_figure import pass_figure
from bristle_sim.render.tool_films import pass_film
from bristle_sim.trajectory import Trajectory
from swinging_bristle import END, STRIKE, make_trajectory


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return make_trajectory()


@given(st.floats(0.0, 1.0), st.floats(1.0, 50.0))
def test_time_warp_is_monotonic_and_spans_run_and_film(focus, slower):
    warp = slow_motion(2.0, 3.0, 8.0, [2.0 + focus], slower=slower)
    film = np.linspace(0.0, 8.0, 999)
    physical = warp.physical_time(film)
    assert (np.diff(physical) > 0.0).all()
    assert physical[[0, -1]] == pytest.approx([2.0, 3.0], rel=1e-12)
    assert warp.film_time(physical) == pytest.approx(film, abs=1e-9)
    assert warp.slow_down_at(warp.film_time(2.0 + focus)) == pytest.approx(slower * warp.slow_down.min(), rel=0.01)


def test_slow_down_is_the_rate_of_film_time():
    warp = slow_motion(0.0, 9e-3, 8.0, [4.5e-3])
    physical = np.linspace(1e-3, 8e-3, 50)
    rate = (warp.film_time(physical + 1e-6) - warp.film_time(physical - 1e-6)) / 2e-6
    # Nodes are 2.2 us apart and the bump 360 us wide: linear interpolation is off by their ratio's square, 4e-5, at most.
    assert warp.slow_down_at(warp.film_time(physical)) == pytest.approx(rate, rel=1e-2)


@pytest.mark.parametrize(
    "bad", [{"end": 0.0}, {"duration": 0.0}, {"duration": math.nan}, {"duration": 1e9}, {"slower": 0.5}]
)
def test_bad_slow_motion_is_refused(bad):
    with pytest.raises(ValueError, match=r"must be|needed"):
        slow_motion(**{"start": 0.0, "end": 1.0, "duration": 8.0} | bad)


def test_scene_tells_the_strike_and_marks_it_where_it_is(run):
    scene = pass_film(run, Tool(), width=320, height=240, duration=4.0, until=END)
    for offset, caption in ((-0.1, "released: the belt throws the tip"), (0.1, "strike"), (0.6, "rebound")):
        scene.show(float(scene.warp.film_time(STRIKE)) + offset)
        assert scene.texts[0] == caption
        assert scene.star.get_visible() == (caption == "strike")
    assert scene.star.get_xydata()[0] == pytest.approx(1e3 * run.tip[60], abs=1e-9)


def test_odd_tools_are_drawn(run):
    thin = Tool(hub=Hub(radius=0.0), bar=Bar(radius=1e-4))
    pass_figure(run, thin).draw_without_rendering()
    scene = pass_film(run, thin, width=320, height=240, duration=1.0)
    assert scene.frame(0.5).size == (320, 240)


def test_gif_has_every_frame_at_its_time(run, tmp_path):
    path = pass_film(run, Tool(), width=160, height=120, duration=1.0).write(tmp_path / "a.gif", fps=15.0)
    with Image.open(path) as film:
        assert (film.n_frames, film.size) == (15, (160, 120))
        durations = []
        for number in range(film.n_frames):
            film.seek(number)
            durations.append(film.info["duration"])
    assert sum(durations) == 1000  # ms, though a fifteenth of a second is no whole number of hundredths
    assert [each.name for each in tmp_path.iterdir()] == ["a.gif"]
