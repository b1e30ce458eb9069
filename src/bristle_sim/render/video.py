"""Write films without a display: a canvas that redraws only what moves, numbers fifty times cheaper than text, mp4 and gif."""

from __future__ import annotations

import string
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bristle_sim.files import checked_target, complete_or_absent
from bristle_sim.render.colours import BLACK
from bristle_sim.render.style import styled

VIDEO_SUFFIXES = (".gif", ".mp4")
DOTS_PER_INCH = 100.0
GIF_COLOURS = 64
GIF_SAMPLES = 30
"""Frames from which the gif's one palette is taken."""


Pixels = NDArray[np.uint8]

CHARACTERS = string.ascii_letters + string.digits + " .,:;+-/=()°²µ·\N{MINUS SIGN}\N{MULTIPLICATION SIGN}"
FONT = "DejaVu Sans Mono"
ADVANCE, LINE, DESCENT = 0.602, 1.35, 0.35
"""Width of a character, height of a line and depth of the baseline's lower edge, in letter sizes."""


class Readout:
    """One line of text in letters of equal width, at a fixed place in the picture.

    Characters darken what is below them, so a light ground shows through. Unknown characters are left blank.
    """

    def __init__(self, left: int, top: int, letter_size: float, *, color: str = BLACK) -> None:
        """Place the line's upper left corner, px from the picture's; ``letter_size`` in px."""
        self.left, self.top, self.text = left, top, ""
        self.advance, self.height = round(ADVANCE * letter_size), round(LINE * letter_size)
        self._letters = _alphabet(letter_size, self.advance, self.height, color)

    def paint(self, picture: Pixels) -> None:
        """Write the text onto an RGBA picture, clipped at its edges."""
        if self.text:
            line = np.concatenate([self._letters.get(each, self._letters[" "]) for each in self.text], axis=1)
            place = picture[self.top : self.top + self.height, self.left : self.left + line.shape[1]]
            np.minimum(place, line[: place.shape[0], : place.shape[1]], out=place)


@lru_cache(maxsize=8)
def _alphabet(letter_size: float, width: int, height: int, color: str) -> dict[str, Pixels]:
    """Return every character as a picture of one size, on white."""
    figure = Figure(figsize=(width / 100.0, height / 100.0), dpi=100.0, facecolor="white")
    canvas: Any = FigureCanvasAgg(figure)
    style: dict[str, Any] = {"family": FONT, "fontsize": 0.72 * letter_size, "color": color, "va": "baseline"}
    text = figure.text(0.0, DESCENT * letter_size / height, "", **style)
    letters = {}
    for character in CHARACTERS:
        text.set_text(character)
        canvas.draw()
        letters[character] = np.array(canvas.buffer_rgba(), dtype=np.uint8)
    return letters


class Stage:
    """A figure of so many pixels whose background is drawn once, and what moves in front of it.

    Add axes and still artists to ``figure``, hand over moving artists to ``add`` and numbers to ``write``, change them
    and take a ``frame``. What is still may change now and then: say so with ``refresh``.
    """

    def __init__(self, width: int, height: int) -> None:
        check_size((width, height))
        with styled():
            self.figure = Figure(figsize=(width / DOTS_PER_INCH, height / DOTS_PER_INCH), dpi=DOTS_PER_INCH)
        self.size = (width, height)
        self._canvas: Any = FigureCanvasAgg(self.figure)
        self._moving: list[Artist] = []
        self._readouts: list[Readout] = []
        self._background: Any = None

    def add(self, *artists: Artist) -> None:
        """Take artists of the figure for moving ones; they are drawn in this order, over everything still."""
        for artist in artists:
            artist.set_animated(True)
        self._moving.extend(artists)
        self.refresh()

    def write(self, *readouts: Readout) -> None:
        """Take readouts, written over everything else."""
        self._readouts.extend(readouts)

    def refresh(self) -> None:
        """Draw what is still anew with the next frame."""
        self._background = None

    def frame(self) -> memoryview:
        """Draw the moving artists and return the picture as height x width x 4 bytes, good until the next frame."""
        if self._background is None:
            with styled():
                self._canvas.draw()
            self._background = self._canvas.copy_from_bbox(self.figure.bbox)
        self._canvas.restore_region(self._background)
        renderer = self._canvas.get_renderer()
        for artist in self._moving:
            artist.draw(renderer)
        pixels = np.asarray(self._canvas.buffer_rgba())
        for readout in self._readouts:
            readout.paint(pixels)
        return memoryview(self._canvas.buffer_rgba())


def checked_video_target(path: str | Path) -> Path:
    """Return the path of a video that can be written, or raise ValueError in one line; cheap, so call it first.

    Raises:
        ValueError: for a suffix other than mp4 and gif, a missing folder, or mp4 where imageio-ffmpeg is missing.
    """
    target = checked_target(path, VIDEO_SUFFIXES)
    if target.suffix.lower() == ".mp4":
        _ffmpeg(target)
    return target


def check_film(suffix: str, size: tuple[int, int], fps: float) -> None:
    """Raise ValueError unless a film of that kind can have this size (px) and so many frames per second.

    A gif counts time in hundredths of a second, and h264 in yuv420p halves both edges.
    """
    kind = suffix.lower()
    highest = 50.0 if kind == ".gif" else 1000.0
    if not 0.0 < fps <= highest:
        raise ValueError(f"fps = {fps:g}: must be 0 < fps <= {highest:g} for {kind} (in 1/s)")
    check_size(size)
    if kind == ".mp4" and any(edge % 2 for edge in size):
        raise ValueError(f"size = {size[0]} x {size[1]}: must be even numbers for .mp4 (in px)")


def check_size(size: tuple[int, int]) -> None:
    """Raise ValueError unless a picture can have this size, px."""
    if not all(16 <= edge <= 8192 for edge in size):
        raise ValueError(f"size = {size[0]} x {size[1]}: must be 16 to 8192 along either edge (in px)")


def write_video(
    path: str | Path, frames: Iterable[memoryview], size: tuple[int, int], fps: float, total: int | None = None
) -> Path:
    """Write RGBA frames to an mp4 (h264, yuv420p) or gif file, which appears only when complete.

    Args:
        path: of the file; its suffix decides.
        frames: pictures of height x width x 4 bytes, each used before the next one is requested.
        size: width and height, px; even for mp4.
        fps: frames per second of film.
        total: number of frames, for the progress bar that a terminal is shown.

    Raises:
        ValueError: for what cannot be written; see also :func:`checked_video_target`.
        OSError: if the encoder fails.
    """
    target = checked_video_target(path)
    check_film(target.suffix, size, fps)
    shown = _counted(frames, size, total, target.name)
    with complete_or_absent(target) as partial:
        (_write_mp4 if target.suffix.lower() == ".mp4" else _write_gif)(partial, shown, size, fps)
    return target


def _counted(frames: Iterable[memoryview], size: tuple[int, int], total: int | None, name: str) -> Iterator[memoryview]:
    """Yield the frames, counted on a terminal where tqdm is installed; a raw stream would shear at one of another size."""
    with suppress(ImportError):
        from tqdm import tqdm

        look = {"desc": name, "unit": "frame", "leave": False, "file": sys.stderr, "disable": not sys.stderr.isatty()}
        frames = tqdm(frames, total=total, **look)
    for frame in frames:
        if frame.shape != (size[1], size[0], 4):
            raise ValueError(f"frame of shape {frame.shape}: must be {(size[1], size[0], 4)} (in px)")
        yield frame


def _ffmpeg(target: Path) -> str:
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        raise ValueError(f"{target}: mp4 needs imageio-ffmpeg: pip install bristle-sim[video], or a .gif") from None
    try:
        return str(get_ffmpeg_exe())
    except RuntimeError:
        raise ValueError(f"{target}: imageio-ffmpeg carries no ffmpeg for this machine; a .gif needs none") from None


def _write_mp4(partial: Path, frames: Iterable[memoryview], size: tuple[int, int], fps: float) -> None:
    source = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{size[0]}x{size[1]}", "-r", f"{fps:g}", "-i", "-"]
    encoder = ["-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-preset", "veryfast", "-crf", "18"]
    # Two encoding threads leave the drawing its own core; fixed numbers of threads give the same file anywhere.
    container = ["-threads", "2", "-fflags", "+bitexact", "-movflags", "+faststart", "-f", "mp4", str(partial)]
    command = [_ffmpeg(partial), "-y", "-loglevel", "error", *source, *encoder, *container]
    with tempfile.TemporaryFile() as complaints:
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=complaints) as process:
            assert process.stdin is not None
            try:
                with suppress(BrokenPipeError):  # the encoder ended early; its status and words follow below
                    for frame in frames:
                        process.stdin.write(frame)
            except BaseException:
                process.kill()
                raise
            finally:
                with suppress(BrokenPipeError):
                    process.stdin.close()
        if process.returncode:
            complaints.seek(0)
            words = complaints.read().decode(errors="replace").strip().splitlines()
            raise OSError(f"{partial.name}: ffmpeg failed: {words[-1] if words else process.returncode}")


def _write_gif(partial: Path, frames: Iterable[memoryview], size: tuple[int, int], fps: float) -> None:
    from PIL import Image

    # The common palette needs frames of the whole film, so all are kept, packed: a few kilobytes each.
    packed = [zlib.compress(np.asarray(frame)[..., :3].tobytes(), 1) for frame in frames]
    if not packed:
        raise ValueError(f"{partial.name}: no frames")
    shape = (size[1], size[0], 3)
    pictures = (np.frombuffer(zlib.decompress(each), np.uint8).reshape(shape) for each in packed)
    samples = packed[:: -(-len(packed) // GIF_SAMPLES)]
    chosen = [np.frombuffer(zlib.decompress(each), np.uint8).reshape(shape)[::2, ::2] for each in samples]
    # Every other pixel and line will do; maximum coverage keeps small areas' colours, one round of k-means the large ones'.
    montage, plain = Image.fromarray(np.concatenate(chosen)), Image.Dither.NONE
    palette = montage.quantize(GIF_COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=plain)
    first, *others = (Image.fromarray(each).quantize(palette=palette, dither=plain) for each in pictures)
    # A gif counts hundredths of a second: rounding the instants, not the durations, keeps the film's length.
    instants = [round(100.0 * number / fps) for number in range(len(packed) + 1)]
    durations = [10 * (after - before) for before, after in pairwise(instants)]
    first.save(partial, "GIF", save_all=True, append_images=others, duration=durations, loop=0, optimize=True)
