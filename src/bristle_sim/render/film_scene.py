"""What the films share: slow motion, a header with caption and read-outs, hands on panels over time, and the file."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.render.colours import BLACK
from bristle_sim.render.style import MILLISECONDS, Scale, signed, styled
from bristle_sim.render.video import Readout, Stage, check_film, checked_video_target, write_video

LONGEST = 3600.0
"""Longest film, s."""

NODES = 4001
"""Instants of a time warp: enough for a bump of a thousandth of the run to be smooth."""

HEADER = 0.135
"""Fraction of the picture's height above the drawing: caption and read-outs."""

CLOCK = Scale(MILLISECONDS, "ms")

BORDER = 0.02
"""Free border left and right of the header, as a fraction of the picture's width."""


@dataclass(frozen=True, slots=True)
class TimeWarp:
    """Film time and physical time at the same nodes, both ascending, s; ``slow_down`` is d film/d physical."""

    film: Array
    physical: Array
    slow_down: Array

    def physical_time(self, film_time: ArrayLike) -> Array:
        """Return the run's instant that the film shows at a film time, s."""
        return np.asarray(np.interp(np.asarray(film_time), self.film, self.physical))

    def film_time(self, physical_time: ArrayLike) -> Array:
        """Return the film time at which an instant of the run is shown, s."""
        return np.asarray(np.interp(np.asarray(physical_time), self.physical, self.film))

    def slow_down_at(self, film_time: ArrayLike) -> Array:
        """Return how many seconds of film one second of the run takes."""
        return np.asarray(np.interp(np.asarray(film_time), self.film, self.slow_down))


def slow_motion(
    start: float, end: float, duration: float, focus: Sequence[float] = (), *, slower: float = 4.0, width: float = 0.04
) -> TimeWarp:
    """Show a run from ``start`` to ``end`` in ``duration`` seconds of film.

    The slow-down is s(t) = s_0 (1 + (slower - 1) max_i exp(-((t - t_i)/w)^2/2)), with w = ``width`` (end - start) about
    each instant t_i of ``focus``, and s_0 such that its integral over the run is the duration.

    Raises:
        ValueError: if the run or the film lasts no time, or ``slower`` is less than 1.
    """
    if not end > start:
        raise ValueError(f"film of a run from {start:g} to {end:g}: a run that lasts some time is needed (in s)")
    if not 0.0 < duration <= LONGEST:
        raise ValueError(f"duration = {duration:g}: must be 0 < duration <= {LONGEST:g} (in s)")
    if not 1.0 <= slower < np.inf:
        raise ValueError(f"slower = {slower:g}: must be a finite factor of at least 1 (dimensionless)")
    physical = np.linspace(start, end, NODES)
    bump = np.zeros_like(physical)
    for instant in focus:
        bump = np.maximum(bump, np.exp(-0.5 * ((physical - instant) / (width * (end - start))) ** 2))
    shape = 1.0 + (slower - 1.0) * bump
    steps = 0.5 * (shape[1:] + shape[:-1]) * np.diff(physical)
    elapsed = np.concatenate([[0.0], np.cumsum(steps)])
    return TimeWarp(elapsed * (duration / elapsed[-1]), physical, shape * (duration / elapsed[-1]))


class FilmScene(ABC):
    """The drawing that a film shows, at any film time; a subclass draws what is below the header and moves it.

    Attributes:
        size, letter_size: width and height of the picture by default, px, and height of its letters, px.
        hands: lines across panels over time that show the instant.
    """

    size, letter_size = (640, 480), 13.0

    def __init__(
        self,
        warp: TimeWarp,
        width: int,
        height: int,
        columns: Sequence[tuple[int, str]],
        clock: Scale = CLOCK,
    ) -> None:
        """``columns``: characters and colour of the read-outs after time and slow-down; ``clock``: unit of the time."""
        self.warp, self.clock, self.stage = warp, clock, Stage(width, height)
        self.hands: list[Line2D] = []
        self.letters = letters = self.letter_size * min(width / self.size[0], height / self.size[1])
        with styled():
            look: dict[str, Any] = {"va": "center", "weight": "bold", "color": BLACK, "fontsize": letters}
            self.caption = self.stage.figure.text(BORDER, 1.0 - 0.33 * HEADER, "", **look)
        columns = [(16, BLACK), (15, BLACK), *columns]
        self.readouts = [Readout(0, 0, letters, color=color) for _, color in columns]
        widths = [characters * each.advance for each, (characters, _) in zip(self.readouts, columns, strict=True)]
        gap = ((1.0 - 2.0 * BORDER) * width - sum(widths)) / (len(widths) - 1)
        for number, readout in enumerate(self.readouts):
            readout.left = round(BORDER * width + sum(widths[:number]) + number * gap)
            readout.top = round(0.78 * HEADER * height - 0.5 * readout.height)
        self.stage.write(*self.readouts)

    @abstractmethod
    def move(self, time: float) -> Sequence[str]:
        """Move everything to an instant of the run, s; return the caption and the texts of the read-outs."""

    def show(self, film_time: float) -> None:
        """Move everything to a film time, s; a new caption redraws what is still."""
        time, slow = float(self.warp.physical_time(film_time)), float(self.warp.slow_down_at(film_time))
        shown = time * self.clock.factor
        for hand in self.hands:
            hand.set_xdata([shown, shown])
        caption, *texts = self.move(time)
        if caption != self.caption.get_text():
            self.caption.set_text(caption)
            self.stage.refresh()
        slowed = f"slowed {slow:{'7.0f' if slow < 1e7 else '7.0e'}}\N{MULTIPLICATION SIGN}"
        texts = [f"time {signed(shown, 3, 8)} {self.clock.unit}", slowed, *texts]
        for readout, text in zip(self.readouts, texts, strict=True):
            readout.text = text

    def frames(self, total: int) -> Iterator[memoryview]:
        """Yield ``total`` pictures evenly spaced in film time, the first and the last instant included."""
        for film_time in np.linspace(0.0, self.warp.film[-1], total):
            self.show(float(film_time))
            yield self.stage.frame()


def write_film(path: str | Path, build: Callable[[], FilmScene], fps: float) -> Path:
    """Check the file's name before anything is computed, then build the scene and write its film.

    Raises:
        ValueError: for a file that cannot be written or settings out of range.
        OSError: if the encoder fails.
    """
    target = checked_video_target(path)
    scene = build()
    check_film(target.suffix, scene.stage.size, fps)
    total = max(2, math.ceil(fps * scene.warp.film[-1] - 1e-6))
    return write_video(target, scene.frames(total), scene.stage.size, fps, total)
