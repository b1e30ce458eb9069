"""Films: slow motion, frames, captions, and files that are written whole or not at all."""

from __future__ import annotations

import io
import math
import shutil
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from bristle_sim.parameters import Tool
from bristle_sim.render import film
from bristle_sim.render.film import Film, slow_motion
from bristle_sim.render.style import BLACK
from bristle_sim.render.tool_films import pass_film
from bristle_sim.trajectory import Trajectory
from swinging_bristle import END, STRIKE, make_trajectory


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return make_trajectory()


class Dot(Film):
    """A dot that goes to the right, and fails on its way if told to."""

    def __init__(self, width=96, height=64, fail=False):
        super().__init__(slow_motion(0.0, 1.0, 1.0), width, height, (BLACK,))
        self.fail = fail
        axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set(xlim=(0, width), ylim=(0, height))
        (self.dot,) = axes.plot([10.0], [20.0], "s", color="black", markersize=6)
        self.moving = [self.dot]

    def move(self, time):
        if self.fail and time > 0.5:
            raise RuntimeError("out of paint")
        self.dot.set_xdata([10.0 + 30.0 * time])
        return "", ""


# The reader of imageio-ffmpeg leaves its pipes to the garbage collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_mp4_has_every_frame_in_the_format_that_plays_everywhere(run, tmp_path):
    reader = pytest.importorskip("imageio_ffmpeg")
    path = pass_film(run, Tool(), width=160, height=120, duration=1.0).write(
        tmp_path / "a.mp4", fps=10.0
    )
    frames = reader.read_frames(str(path))
    about = next(frames)
    assert (about["size"], about["fps"], about["codec"]) == ((160, 120), 10.0, "h264")
    assert about["pix_fmt"].startswith("yuv420p")
    assert sum(1 for _ in frames) == 10
    assert [each.name for each in tmp_path.iterdir()] == ["a.mp4"]


@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_a_failing_film_leaves_no_file(tmp_path, suffix):
    if suffix == ".mp4":
        pytest.importorskip("imageio_ffmpeg")
    with pytest.raises(RuntimeError, match="out of paint"):
        Dot(fail=True).write(tmp_path / f"a{suffix}", 10.0)
    assert not list(tmp_path.iterdir())


# imageio-ffmpeg leaves the pipe of an encoder that ended early to the garbage collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_failing_encoder_is_reported_and_leaves_no_file(tmp_path, monkeypatch):
    pytest.importorskip("imageio_ffmpeg")
    failing = shutil.which("false")
    if failing is None:
        pytest.skip("no program that fails")
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", failing)
    with pytest.raises(OSError, match="ffmpeg failed, it wrote 0 of 10 frames"):
        Dot(320, 240).write(tmp_path / "a.mp4", 10.0)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "size", "fps", "words"),
    [
        ("a.avi", (96, 64), 10.0, "ends in .gif, .mp4"),
        ("none/a.gif", (96, 64), 10.0, "existing, writable folder"),
        ("a.mp4", (97, 64), 10.0, "even numbers"),
        ("a.gif", (8, 24), 10.0, "64 to 8192"),
        ("a.gif", (96, 64), 60.0, "fps <= 50"),
        ("a.mp4", (96, 64), math.nan, "fps = nan"),
    ],
)
def test_bad_films_are_refused_before_the_first_frame(run, tmp_path, name, size, fps, words):
    if name.endswith(".mp4"):
        pytest.importorskip("imageio_ffmpeg")
    with pytest.raises(ValueError, match=words):
        pass_film(run, Tool(), width=size[0], height=size[1]).write(tmp_path / name, fps)
    assert not list(tmp_path.iterdir())


def test_the_smallest_film_has_letters(run, tmp_path):
    pass_film(run, Tool(), width=64, height=64, duration=0.2).write(tmp_path / "a.gif", 10.0)
    with pytest.raises(ValueError, match=r"^size = 63 x 64: must be 64 to 8192"):
        pass_film(run, Tool(), width=63, height=64)


def test_mp4_without_its_encoder_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ValueError, match=r"pip install bristle-sim\[video\]"):
        Dot().write(tmp_path / "a.mp4", 10.0)
    Dot().write(tmp_path / "a.gif", 10.0)  # needs no encoder


@pytest.mark.parametrize(
    ("terminal", "tqdm"), [(False, True), (True, False), (True, True), (None, True)]
)
def test_progress_counts_frames_on_a_terminal_alone(terminal, tqdm, tmp_path, monkeypatch, capsys):
    """Nothing without the library that counts; and a film needs no standard error."""
    stderr = io.StringIO()
    monkeypatch.setattr(stderr, "isatty", lambda: terminal)
    monkeypatch.setattr(film.sys, "stderr", stderr if terminal is not None else None)
    if not tqdm:
        monkeypatch.setitem(sys.modules, "tqdm", None)
    assert Dot().write(tmp_path / "a.gif", 10.0).exists()
    assert ("/10" in stderr.getvalue()) is bool(terminal and tqdm)
    assert bool(stderr.getvalue()) is bool(terminal and tqdm)
    assert capsys.readouterr().out == ""


@given(st.floats(0.0, 1.0), st.floats(1.0, 50.0))
def test_time_warp_is_monotonic_and_spans_run_and_film(focus, slower):
    warp = slow_motion(2.0, 3.0, 8.0, [2.0 + focus], slower=slower)
    film = np.linspace(0.0, 8.0, 999)
    physical = warp.physical_time(film)
    assert (np.diff(physical) > 0.0).all()
    assert physical[[0, -1]] == pytest.approx([2.0, 3.0], rel=1e-12)
    assert warp.film_time(physical) == pytest.approx(film, abs=1e-9)
    assert warp.slow_down_at(warp.film_time(2.0 + focus)) == pytest.approx(
        slower * warp.slow_down_at(film).min(), rel=0.01
    )


def test_scene_tells_the_strike(run):
    scene = pass_film(run, Tool(), width=320, height=240, duration=4.0, until=END)
    for offset, caption in (
        (-0.1, "released: the belt throws the tip"),
        (0.1, "strike"),
        (0.6, "rebound"),
    ):
        scene.show(float(scene.warp.film_time(STRIKE)) + offset)
        assert scene.texts[0] == caption


def test_gif_has_every_frame_at_its_time(run, tmp_path):
    path = pass_film(run, Tool(), width=160, height=120, duration=1.0).write(
        tmp_path / "a.gif", fps=15.0
    )
    with Image.open(path) as film:
        assert (film.n_frames, film.size) == (15, (160, 120))
        durations = []
        for number in range(film.n_frames):
            film.seek(number)
            durations.append(film.info["duration"])
    assert (
        sum(durations) == 1000
    )  # ms, though a fifteenth of a second is no whole number of hundredths
    assert [each.name for each in tmp_path.iterdir()] == ["a.gif"]
