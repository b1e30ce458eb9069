"""Films as files, the canvas and the read-outs."""

from __future__ import annotations

import io
import math
import shutil
import subprocess
import sys

import numpy as np
import pytest

from bristle_sim.parameters import Tool
from bristle_sim.render import video
from bristle_sim.render.pass_video import pass_video
from bristle_sim.render.video import Readout, Stage, write_video
from bristle_sim.trajectory import Trajectory
from swinging_bristle import make_trajectory


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return make_trajectory()


def test_stage_draws_what_is_still_once(monkeypatch):
    stage = Stage(64, 48)
    axes = stage.figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set(xlim=(0, 64), ylim=(0, 48))
    (dot,) = axes.plot([10.0], [20.0], "s", color="black", markersize=6)
    stage.add(dot)
    drawn = []
    draw = stage._canvas.draw
    monkeypatch.setattr(stage._canvas, "draw", lambda: drawn.append(draw()))
    places = []
    for x in (10.0, 40.0):
        dot.set_xdata([x])
        dark = np.argwhere(np.asarray(stage.frame())[..., 0] < 128)
        places.append(dark.mean(axis=0))
    assert len(drawn) == 1
    # Rows count from the top: y = 20 of 48 is row 28, and a pixel's centre is half a pixel off its index.
    assert np.array(places) == pytest.approx(np.array([[28.0, 10.0], [28.0, 40.0]]), abs=1.0)


def test_readout_darkens_its_own_place_alone_and_survives_the_edge():
    readout = Readout(50, 5, 15.0)
    picture = np.full((30, 64, 4), 255, dtype=np.uint8)
    readout.text = "8888 \N{SNOWMAN}"
    readout.paint(picture)
    dark = np.argwhere(picture[..., 0] < 128)
    assert dark.size
    assert dark[:, 1].min() >= 50
    assert dark[:, 0].min() >= 5
    assert dark[:, 0].max() < 5 + readout.height
    blank = np.full_like(picture, 255)
    readout.text = "\N{SNOWMAN}"
    readout.paint(blank)
    assert (blank == 255).all()


# The reader of imageio-ffmpeg leaves its pipes to the garbage collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_mp4_has_every_frame_in_the_format_that_plays_everywhere(run, tmp_path):
    reader = pytest.importorskip("imageio_ffmpeg")
    path = pass_video(run, Tool(), tmp_path / "a.mp4", fps=10.0, width=160, height=120, duration=1.0)
    frames = reader.read_frames(str(path))
    about = next(frames)
    assert (about["size"], about["fps"], about["codec"]) == ((160, 120), 10.0, "h264")
    assert about["pix_fmt"].startswith("yuv420p")
    assert sum(1 for _ in frames) == 10
    assert [each.name for each in tmp_path.iterdir()] == ["a.mp4"]


def grey_frames(count, size=(32, 24), fail_at=None):
    for number in range(count):
        if number == fail_at:
            raise RuntimeError("out of paint")
        yield memoryview(np.full((size[1], size[0], 4), 10 * number, dtype=np.uint8))


@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_a_failing_film_leaves_no_file(tmp_path, suffix):
    with pytest.raises(RuntimeError, match="out of paint"):
        write_video(tmp_path / f"a{suffix}", grey_frames(9, fail_at=5), (32, 24), 10.0)
    with pytest.raises(ValueError, match="frame of shape"):
        write_video(tmp_path / f"a{suffix}", grey_frames(9), (64, 48), 10.0)
    assert not list(tmp_path.iterdir())


def test_a_film_without_frames_is_no_film(tmp_path):
    with pytest.raises(ValueError, match="no frames"):
        write_video(tmp_path / "a.gif", grey_frames(0), (32, 24), 10.0)
    assert not list(tmp_path.iterdir())


def test_a_failing_encoder_is_reported_and_leaves_no_file(tmp_path, monkeypatch):
    encoder = pytest.importorskip("imageio_ffmpeg")
    failing = shutil.which("false")
    if failing is None:
        pytest.skip("no program that fails")
    monkeypatch.setattr(encoder, "get_ffmpeg_exe", lambda: failing)
    with pytest.raises(OSError, match="ffmpeg failed"):
        write_video(tmp_path / "a.mp4", grey_frames(50, size=(320, 240)), (320, 240), 10.0)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "size", "fps", "words"),
    [
        ("a.avi", (32, 24), 10.0, "ends in .gif, .mp4"),
        ("none/a.gif", (32, 24), 10.0, "existing, writable folder"),
        ("a.mp4", (33, 24), 10.0, "even numbers"),
        ("a.gif", (8, 24), 10.0, "16 to 8192"),
        ("a.gif", (32, 24), 60.0, "fps <= 50"),
        ("a.mp4", (32, 24), math.nan, "fps = nan"),
    ],
)
def test_bad_films_are_refused_before_the_first_frame(run, tmp_path, name, size, fps, words):
    if name.endswith(".mp4"):
        pytest.importorskip("imageio_ffmpeg")
    with pytest.raises(ValueError, match=words):
        write_video(tmp_path / name, grey_frames(3, fail_at=0), size, fps)
    with pytest.raises(ValueError, match=words):
        pass_video(run, Tool(), tmp_path / name, fps=fps, width=size[0], height=size[1])
    assert not list(tmp_path.iterdir())


def test_mp4_without_its_encoder_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ValueError, match=r"pip install bristle-sim\[video\]"):
        write_video(tmp_path / "a.mp4", grey_frames(3), (32, 24), 10.0)
    write_video(tmp_path / "a.gif", grey_frames(3), (32, 24), 10.0)  # needs no encoder


class Terminal(io.StringIO):
    """Standard error as a person sees it."""

    def isatty(self):
        return True


def test_progress_is_for_terminals_alone(tmp_path, monkeypatch, capsys):
    write_video(tmp_path / "a.gif", grey_frames(3), (32, 24), 10.0, total=3)
    assert capsys.readouterr() == ("", "")
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setattr(video.sys, "stderr", Terminal())
    write_video(tmp_path / "b.gif", grey_frames(3), (32, 24), 10.0, total=3)
    assert video.sys.stderr.getvalue() == ""


def test_progress_counts_frames_on_standard_error(tmp_path, monkeypatch, capsys):
    pytest.importorskip("tqdm")
    terminal = Terminal()
    monkeypatch.setattr(video.sys, "stderr", terminal)
    write_video(tmp_path / "a.gif", grey_frames(3), (32, 24), 10.0, total=3)
    assert "/3" in terminal.getvalue()
    assert capsys.readouterr().out == ""


def test_drawing_imports_neither_pyplot_nor_a_display():
    modules = "pass_figure", "pass_video", "video"
    imports = "; ".join(f"import bristle_sim.render.{name}" for name in modules)
    script = f"{imports}; import sys; print([name for name in sys.modules if name in ('matplotlib.pyplot', 'tkinter')])"
    answer = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"
