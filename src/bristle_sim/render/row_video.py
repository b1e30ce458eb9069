"""Film of a row of bristles whose wires touch each other, in slow motion about the touches and the last strike."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.render.drawing import draw_scale_bar
from bristle_sim.render.film_scene import HEADER, FilmScene, slow_motion, write_film
from bristle_sim.render.neighbours_figure import row_view, touch_place
from bristle_sim.render.style import BLACK, SERIES, signed, styled
from bristle_sim.render.tool_drawing import MILLIMETRES, WireDrawing, draw_tool, name_parts
from bristle_sim.studies.neighbours import Row
from bristle_sim.trajectory.sampled_motion import SampledMotion

LETTERS = 13.0
"""Letter height in a picture of 640 x 480, px."""

SLOWER = 10.0
"""How much slower touches and strikes are shown than the rest."""

AFTER = 0.15
"""How long the film goes on after the last bristle's strike, as a fraction of the time before."""

MARKED = 0.6
"""Film time for which a touch keeps its ring, s."""


def row_video(
    row: Row, path: str | Path, *, fps: float = 30.0, width: int = 640, height: int = 480, duration: float = 12.0
) -> Path:
    """Film a row to an mp4 or gif file; needs no display. Sizes in px, the film's duration in s.

    Raises:
        ValueError: for a file that cannot be written or settings out of range.
    """
    return write_film(path, lambda: RowScene(row, width, height, duration), (width, height), fps, duration)


class RowScene(FilmScene):
    """The drawing that a film of a row shows, at any film time."""

    def __init__(self, row: Row, width: int = 640, height: int = 480, duration: float = 12.0) -> None:
        self.motions = [SampledMotion(run) for run in row.bristles]
        strike, end = row.bristles[-1].event_time("strike"), self.motions[-1].end
        begin = min(row.bristles[0].event_time("bar touch") or 0.0, 0.8 * end)
        until = end if strike is None else min(end, strike + AFTER * (strike - begin))
        touches = [each for each in row.touches if begin <= each <= until]
        strikes = [each for each in (run.event_time("strike") for run in row.bristles) if each is not None]
        focus = [each for each in (*touches, *strikes) if each <= until]
        colors = (SERIES * 2)[: len(row.bristles)]
        columns = ((14, BLACK), (13, BLACK), (26, colors[-1]))
        warp = slow_motion(begin, until, duration, focus, slower=SLOWER, width=0.012)
        letters = LETTERS * min(width / 640.0, height / 480.0)
        super().__init__(warp, width, height, letters, columns)
        self._captions = _captions(row)
        self._rings = [(float(warp.film_time(each)), self._places(row, each)) for each in touches]
        with styled():
            axes = self.stage.figure.add_axes((0.0, 0.0, 1.0, 1.0 - HEADER))
            times = np.linspace(begin, until, 200)
            paths = [motion.centre_line(times) for motion in self.motions]
            view = row_view(row.tool, paths, width / (height * (1.0 - HEADER)))
            view.apply(axes)
            axes.set_axis_off()
            draw_tool(axes, row.tool, view)
            name_parts(axes, row.tool, 0.75 * letters)
            place = (view.right - 0.025 * (view.right - view.left), view.bottom + 0.03 * (view.top - view.bottom))
            draw_scale_bar(axes, 1.0 / MILLIMETRES, place, 0.75 * letters, leftwards=True)
            self.wires = [WireDrawing(axes, row.tool, color=color) for color in colors]
            (self.ring,) = axes.plot([], [], "o", markersize=26, markerfacecolor="none", color=BLACK, zorder=6)
        self.stage.add(*(artist for wire in self.wires for artist in wire.artists), self.ring)

    def show(self, film_time: float) -> None:
        """Move wires, ring and words to a film time, s."""
        time = float(self.warp.physical_time(film_time))
        for wire, motion in zip(self.wires, self.motions, strict=True):
            wire.place(motion.centre_line(time))
        marked = [places for at, places in self._rings if 0.0 <= film_time - at <= MARKED]
        self.ring.set_data(*np.concatenate([np.empty((0, 2)), *marked]).T)
        lag = math.degrees(float(self.motions[-1].retraction(time)))
        texts = (
            f"time {time * 1e3:6.3f} ms",
            f"slowed {float(self.warp.slow_down_at(film_time)):5.0f}\N{MULTIPLICATION SIGN}",
            f"bristle {len(self.wires)} lags by {signed(lag, 1, 6)}°",
        )
        self.write_words([words for start, words in self._captions if start <= time][-1], texts)

    def _places(self, row: Row, time: float) -> Array:
        """Return where wires touch the next ones at an instant, shape (touches, 2), mm."""
        lines = [motion.centre_line(time) for motion in self.motions]
        places = [touch_place(*pair, row.tool.bristle.wire_diameter) for pair in itertools.pairwise(lines)]
        return MILLIMETRES * np.reshape([each for each in places if each is not None], (-1, 2))


def _captions(row: Row) -> list[tuple[float, str]]:
    """Return instants and what happens from them on, in order."""
    found = [(-math.inf, "turning with the hub"), *((each, "wires touch each other") for each in row.touches)]
    for number, run in enumerate(row.bristles, 1):
        name, contact = f"bristle {number}", run.first_contact("workpart")
        strike = math.inf if contact is None else contact.time
        if (met := run.event_time("bar touch", before=strike)) is not None:
            found.append((met, f"{name} meets the bar"))
        if (thrown := run.event_time("bar release", last=True, before=strike)) is not None:
            found.append((thrown, f"the belt throws {name}"))
        if contact is not None:
            rate = contact.rates_before[0] - run.hub_speed
            found.append((strike, f"{name} strikes at {signed(rate, 0)} rad/s relative to the hub"))
    return sorted(found)
