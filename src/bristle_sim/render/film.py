"""Films in slow motion, drawn without a display and written to mp4 and gif files.

Each frame redraws only the moving parts.
"""

from __future__ import annotations

import contextlib
import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from functools import lru_cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw, ImageFont

from bristle_sim.arrays import Array
from bristle_sim.files import checked_target, complete_or_absent
from bristle_sim.readable import MILLISECONDS
from bristle_sim.render.style import BLACK, Scale, signed, styled

HIGHEST_RATE = {".gif": 50.0, ".mp4": 1000.0}
"""Largest number of frames per second, by file suffix. A gif counts time in hundredths of a second."""

LONGEST_FILM = 3600.0  # longest film, s
# Number of nodes of a TimeWarp. Slow motion of an interval as short as 1/1000 of the run is still
# smooth.
NODES = 4001
# Height of the header with caption and read-outs, as a fraction of the picture's height
HEADER = 0.135
# Left edges of the read-outs in the header, as fractions of the picture's width
LEFTS = (0.02, 0.25, 0.47, 0.735)
# Resolution of a picture of default size. A picture of another size has another resolution, so that
# letters and lines keep their size relative to the picture.
DOTS_PER_INCH = 115.0
# Number of colours in the palette of a gif, and largest number of frames from which the palette
# is taken
GIF_COLOURS = 64
GIF_SAMPLES = 30


class TimeWarp(NamedTuple):
    """Piecewise linear map between the time of a run and the time in its film.

    Attributes:
        film: times in the film, s, ascending.
        physical: corresponding times in the run, s, ascending.
    """

    film: Array
    physical: Array

    def physical_time(self, film_time: ArrayLike) -> Array:
        """Return the time in the run (s) that the film shows at a given time in the film (s)."""
        return np.asarray(np.interp(np.asarray(film_time), self.film, self.physical))

    def film_time(self, physical_time: ArrayLike) -> Array:
        """Return the time in the film (s) at which a given time in the run (s) is shown."""
        return np.asarray(np.interp(np.asarray(physical_time), self.physical, self.film))

    def slow_down_at(self, film_time: ArrayLike) -> Array:
        """Return the slow-down at a time in the film (s): seconds of film per second of the run."""
        slow_down = np.gradient(self.film, self.physical)
        return np.asarray(np.interp(np.asarray(film_time), self.film, slow_down))


def slow_motion(
    start: float,
    end: float,
    duration: float,
    focus: Sequence[float] = (),
    *,
    slower: float = 4.0,
    width: float = 0.04,
) -> TimeWarp:
    """Return the ``TimeWarp`` of a film that is slower near chosen times of the run.

    The slow-down at the run time t is s(t) = s_0 (1 + (slower - 1) max_i exp(-((t - t_i)/w)^2/2)).
    The t_i are the times ``focus``, and w = ``width`` (end - start) is a time, s. The factor s_0
    makes the integral of s(t) equal to the film's duration.

    Args:
        start, end: first and last time of the run, s.
        duration: duration of the film, s.
        focus: times of the run at which the film is slowest, s.
        slower: ratio of the slow-down at these times to the slow-down far from them.
        width: the time w that scales a slow interval, as a fraction of the run's duration.

    Raises:
        ValueError: if ``end`` is not after ``start``, or ``duration`` or ``slower`` is out of
            range.
    """
    if not end > start:
        raise ValueError(
            f"film of a run from {start:g} to {end:g}: must be a run of positive duration (in s)"
        )
    if not 0.0 < duration <= LONGEST_FILM:
        raise ValueError(
            f"duration = {duration:g}: must be 0 < duration <= {LONGEST_FILM:g} (in s)"
        )
    if not 1.0 <= slower < np.inf:
        raise ValueError(
            f"slower = {slower:g}: must be a finite factor of at least 1 (dimensionless)"
        )
    physical = np.linspace(start, end, NODES)
    distance = (physical - np.reshape(focus, (-1, 1))) / (width * (end - start))
    shape = 1.0 + (slower - 1.0) * np.exp(-0.5 * distance**2).max(axis=0, initial=0.0)
    elapsed = np.concatenate([[0.0], np.cumsum(0.5 * (shape[1:] + shape[:-1]) * np.diff(physical))])
    return TimeWarp(elapsed * (duration / elapsed[-1]), physical)


class Film(ABC):
    """Base class of films.

    A subclass draws the picture below the header. Its method ``move`` moves the moving parts to a
    time of the run.

    Attributes:
        size: default width and height of the picture, px.
        letter_size: height of the header's letters in a picture of default size, px.
        moving: artists that change from frame to frame, in drawing order. They are drawn over all
            other artists.
        hands: vertical lines that mark the present time in panels over time.
        texts: texts of the header: the caption, the time, the slow-down and further read-outs.
        canvas: canvas of the figure.
    """

    size = (640, 480)
    letter_size = 13.0

    def __init__(
        self,
        warp: TimeWarp,
        width: int,
        height: int,
        colours: Sequence[str],
        clock: Scale | None = None,
    ) -> None:
        """Prepare a picture that has only its header.

        Args:
            warp: map between the time of the run and the time in the film.
            width, height: size of the picture, px.
            colours: colours of the read-outs that follow time and slow-down.
            clock: unit in which the time is displayed, by default ms.
        """
        if not (64 <= width <= 8192 and 48 <= height <= 8192):
            raise ValueError(
                f"size = {width} x {height}: must be 64 to 8192 wide and 48 to 8192 high (in px)"
            )
        self.warp = warp
        self.clock = clock or Scale(MILLISECONDS, "ms")
        self.pixels = (width, height)
        scale = min(width / self.size[0], height / self.size[1])
        self.letters = self.letter_size * scale
        dots = DOTS_PER_INCH * scale
        edge = 1e-6  # rounding must not lose a pixel
        with styled():
            self.figure = Figure(((width + edge) / dots, (height + edge) / dots), dpi=dots)
        self.canvas: Any = FigureCanvasAgg(self.figure)
        self._still: Any = None
        self._colours = (BLACK, BLACK, *colours)
        self.moving: list[Artist] = []
        self.hands: list[Line2D] = []
        self.texts: tuple[str, ...] = ()

    def add_timeline(self, place: tuple[float, float, float, float]) -> Axes:
        """Add a panel over the time of the run, with a vertical line that marks the present time.

        ``place`` is left, bottom, width and height as fractions of the picture.
        """
        axes = self.figure.add_axes(place)
        axes.set_xlim(*self.warp.physical[[0, -1]] * self.clock.factor)
        self.hands.append(axes.axvline(0.0, color=BLACK, linewidth=1.0))
        return axes

    @abstractmethod
    def move(self, time: float) -> Sequence[str]:
        """Move all moving parts to a time in the run (s).

        Returns:
            The caption, followed by the texts of the read-outs.
        """

    def show(self, film_time: float) -> None:
        """Move all moving parts to a time in the film (s), and update the texts of the header."""
        time = float(self.warp.physical_time(film_time))
        slow = float(self.warp.slow_down_at(film_time))
        shown = time * self.clock.factor
        for hand in self.hands:
            hand.set_xdata([shown, shown])
        caption, *texts = self.move(time)
        slowed = f"slowed {slow:{'7.0f' if slow < 1e7 else '7.0e'}}\N{MULTIPLICATION SIGN}"
        self.texts = (caption, f"time {signed(shown, 3, 8)} {self.clock.unit}", slowed, *texts)

    def frame(self, film_time: float) -> Image.Image:
        """Return the picture at a time in the film (s).

        Parts that do not move are drawn only for the first frame.
        """
        self.show(film_time)
        if self._still is None:
            with styled():
                for artist in self.moving:
                    artist.set_animated(True)
                self.canvas.draw()
            self._still = self.canvas.copy_from_bbox(self.figure.bbox)
        self.canvas.restore_region(self._still)
        for artist in self.moving:
            artist.draw(self.canvas.get_renderer())
        picture = Image.fromarray(np.asarray(self.canvas.buffer_rgba())).convert("RGB")
        width, height = self.pixels
        pen = ImageDraw.Draw(picture)
        caption, *texts = self.texts
        bold = _font("DejaVuSans-Bold", 1.39 * self.letters)
        mono = _font("DejaVuSansMono", self.letters)
        pen.text((LEFTS[0] * width, 0.33 * HEADER * height), caption, BLACK, bold, "lm")
        for left, text, colour in zip(LEFTS, texts, self._colours, strict=False):
            pen.text((left * width, 0.78 * HEADER * height), text, colour, mono, "lm")
        return picture

    def write(self, path: str | Path, fps: float = 30.0) -> Path:
        """Write the film to an mp4 or gif file.

        The file appears only when it is complete. The last frame shows the end of the run. ``fps``
        is the number of frames per second.

        Raises:
            ValueError: if the path is not that of an mp4 or gif file, imageio-ffmpeg is missing for
                an mp4, or ``fps`` or the size is not possible in this format.
            OSError: if the encoder fails.
        """
        target = checked_target(path, tuple(HIGHEST_RATE))
        end = float(self.warp.film[-1])
        kind = target.suffix.lower()
        if kind == ".mp4":
            try:
                import_module("imageio_ffmpeg").get_ffmpeg_exe()
            except (ImportError, RuntimeError):
                advice = "mp4 needs imageio-ffmpeg with an ffmpeg for this machine: pip install bristle-sim[video], or a .gif"
                raise ValueError(f"{target}: {advice}") from None
            if any(edge % 2 for edge in self.pixels):
                raise ValueError(
                    f"size = {self.pixels[0]} x {self.pixels[1]}: must be even numbers for .mp4 (in px)"
                )
        if not 0.0 < fps <= HIGHEST_RATE[kind]:
            raise ValueError(
                f"fps = {fps:g}: must be 0 < fps <= {HIGHEST_RATE[kind]:g} for {kind} (in 1/s)"
            )
        times = np.linspace(0.0, end, max(2, math.ceil(fps * end - 1e-6))).tolist()
        with complete_or_absent(target) as partial:
            (_write_mp4 if kind == ".mp4" else _write_gif)(partial, self, times, fps)
        return target


@lru_cache(maxsize=8)
def _font(name: str, size: float) -> ImageFont.FreeTypeFont:
    """Return one of matplotlib's fonts, of a given size in px, for drawing with the library Pillow.

    Pillow draws text much faster than matplotlib does. ``name`` is that of the font's file.
    """
    return ImageFont.truetype(
        str(Path(mpl.get_data_path()) / "fonts" / "ttf" / f"{name}.ttf"), size
    )


def _counted(times: Sequence[float]) -> Iterable[float]:
    """Return the times of the frames as an iterable that shows a progress bar.

    The progress bar is absent if standard error is not a terminal or the package tqdm is not
    installed.
    """
    with contextlib.suppress(ImportError):
        if sys.stderr is not None and sys.stderr.isatty():
            counted: Iterable[float] = import_module("tqdm").tqdm(
                times, unit="frame", leave=False, file=sys.stderr
            )
            return counted
    return times


def _write_mp4(partial: Path, film: Film, times: Sequence[float], fps: float) -> None:
    from imageio_ffmpeg import count_frames_and_secs, write_frames

    # Two encoding threads leave one core to the drawing; a fixed number of threads gives the same
    # file on every machine.
    container = ["-threads", "2", "-fflags", "+bitexact", "-movflags", "+faststart", "-f", "mp4"]
    codec = {
        "codec": "libx264",
        "quality": None,
        "output_params": ["-preset", "veryfast", "-crf", "18", *container],
    }
    encoder = write_frames(
        str(partial), film.pixels, fps=fps, macro_block_size=1, ffmpeg_log_level="quiet", **codec
    )
    encoder.send(None)
    # A frame that the encoder refuses ends the film; the written frames are counted below.
    with contextlib.closing(encoder), contextlib.suppress(OSError):
        for time in _counted(times):
            encoder.send(film.frame(time).tobytes())
    written = 0
    with contextlib.suppress(RuntimeError):
        written = count_frames_and_secs(str(partial))[0]
    if written != len(times):
        raise OSError(f"{partial.name}: ffmpeg failed, it wrote {written} of {len(times)} frames")


def _write_gif(partial: Path, film: Film, times: Sequence[float], fps: float) -> None:
    # Every second pixel and line suffices. Maximum coverage keeps the colours of small areas; one
    # round of k-means keeps those of large areas.
    chosen = [
        np.asarray(film.frame(time))[::2, ::2] for time in times[:: -(-len(times) // GIF_SAMPLES)]
    ]
    montage = Image.fromarray(np.concatenate(chosen))
    plain = Image.Dither.NONE
    palette = montage.quantize(GIF_COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=plain)
    first, *others = [
        film.frame(time).quantize(palette=palette, dither=plain) for time in _counted(times)
    ]
    # A gif counts hundredths of a second. To keep the film's length, the instants of the frames are
    # rounded, and not their durations.
    instants = [round(100.0 * number / fps) for number in range(len(times) + 1)]
    durations = [10 * (after - before) for before, after in pairwise(instants)]
    first.save(
        partial,
        "GIF",
        save_all=True,
        append_images=others,
        duration=durations,
        loop=0,
        optimize=True,
    )
