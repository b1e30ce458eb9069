"""What the films share: slow motion, a header with caption and read-outs, and pictures evenly spaced in film time."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.render.style import BLACK, styled
from bristle_sim.render.video import Stage, check_film, checked_video_target, write_video

LONGEST = 3600.0
"""Longest film, s."""

NODES = 4001
"""Instants of a time warp: enough for a bump of a thousandth of the run to be smooth."""

HEADER = 0.135
"""Fraction of the picture's height above the drawing: caption and read-outs."""

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


ADVANCE = 0.602
"""Width of a character of the read-outs, whose letters are of equal width, in letter sizes."""


class FilmScene(ABC):
    """The drawing that a film shows, at any film time; a subclass adds what is below the header."""

    def __init__(
        self, warp: TimeWarp, width: int, height: int, letters: float, columns: Sequence[tuple[int, str]]
    ) -> None:
        """``letters``: their size, px; ``columns``: characters and colour of each read-out."""
        self.warp, self.letters, self.stage = warp, letters, Stage(width, height)
        with styled():
            self.caption = self.stage.figure.text(
                BORDER, 1.0 - 0.33 * HEADER, "", va="center", fontsize=letters, weight="bold", color=BLACK
            )
        widths = [characters * ADVANCE * letters / width for characters, _ in columns]
        gap = (1.0 - 2.0 * BORDER - sum(widths)) / (len(widths) - 1)
        look: dict[str, Any] = {"family": "DejaVu Sans Mono", "fontsize": 0.72 * letters, "va": "center"}
        self.readouts = tuple(
            self.stage.figure.text(left, 1.0 - 0.78 * HEADER, "", color=color, **look)
            for left, (_, color) in zip(
                accumulate(widths, lambda x, y: x + y + gap, initial=BORDER), columns, strict=False
            )
        )
        self.stage.add(*self.readouts)

    @abstractmethod
    def show(self, film_time: float) -> None:
        """Move everything to a film time, s."""

    def frames(self, total: int) -> Iterator[memoryview]:
        """Yield ``total`` pictures evenly spaced in film time, the first and the last instant included."""
        for film_time in np.linspace(0.0, self.warp.film[-1], total):
            self.show(float(film_time))
            yield self.stage.frame()

    def write_words(self, caption: str, texts: Sequence[str]) -> None:
        """Change the caption, which redraws what is still, and the read-outs."""
        if caption != self.caption.get_text():
            self.caption.set_text(caption)
            self.stage.refresh()
        for readout, text in zip(self.readouts, texts, strict=True):
            readout.set_text(text)


def write_film(
    path: str | Path, build: Callable[[], FilmScene], size: tuple[int, int], fps: float, duration: float
) -> Path:
    """Check what can be checked before anything is computed, then build the scene and write its film.

    Raises:
        ValueError: for a file that cannot be written or settings out of range.
        OSError: if the encoder fails.
    """
    target = checked_video_target(path)
    check_film(target.suffix, size, fps)
    if not 0.0 < duration <= LONGEST:
        raise ValueError(f"duration = {duration:g}: must be 0 < duration <= {LONGEST:g} (in s)")
    total = max(2, math.ceil(duration * fps))
    return write_video(target, build().frames(total), size, fps, total)
