"""Film of a row of bristles whose wires touch each other, in slow motion about the touches and the last strike."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.render.colours import BLACK, SERIES
from bristle_sim.render.drawing import WireDrawing, close_up, draw_film_tool
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.neighbours_figure import touch_places
from bristle_sim.render.story import Phase, phase_at
from bristle_sim.render.style import signed, styled
from bristle_sim.studies.neighbours import Row
from bristle_sim.trajectory.sampled_motion import SampledMotion

SLOWER = 10.0
"""How much slower touches and strikes are shown than the rest."""

AFTER = 0.15
"""How long the film goes on after the last bristle's strike, as a fraction of the time before."""


class RowFilm(Film):
    """The drawing that a film of a row shows, at any film time."""

    def __init__(self, row: Row, width: int = 640, height: int = 480, duration: float = 12.0) -> None:
        self.motions = [SampledMotion(run) for run in row.bristles]
        strike, end = row.bristles[-1].event_time("strike"), self.motions[-1].end
        begin = min(row.bristles[0].event_time("bar touch") or 0.0, 0.8 * end)
        until = end if strike is None else min(end, strike + AFTER * (strike - begin))
        touches = [each for each in row.touches if begin <= each <= until]
        strikes = [each for run in row.bristles if (each := run.event_time("strike")) is not None and each <= until]
        colors = (SERIES * 2)[: len(row.bristles)]
        warp = slow_motion(begin, until, duration, (*touches, *strikes), slower=SLOWER, width=0.012)
        super().__init__(warp, width, height, (colors[-1],))
        self._phases, self._diameter = _phases(row), row.tool.bristle.wire_diameter
        with styled():
            axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0 - HEADER))
            times = np.linspace(begin, until, 200)
            paths = np.concatenate([motion.centre_line(times) for motion in self.motions])
            view = close_up(paths, row.tool, width / (height * (1.0 - HEADER)), margin=0.08)
            draw_film_tool(axes, row.tool, view, 0.75 * self.letters)
            self.wires = [WireDrawing(axes, row.tool, color=color) for color in colors]
            (self.ring,) = axes.plot([], [], "o", markersize=26, markerfacecolor="none", color=BLACK, zorder=6)
        self.moving = [*(artist for wire in self.wires for artist in wire.artists), self.ring]

    def move(self, time: float) -> tuple[str, ...]:
        """Move wires to an instant, s, and rings to where they touch."""
        lines = [motion.centre_line(time) for motion in self.motions]
        for wire, line in zip(self.wires, lines, strict=True):
            wire.place(line)
        self.ring.set_data(*touch_places(lines, self._diameter).T)
        lag = math.degrees(float(self.motions[-1].retraction(time)))
        return phase_at(self._phases, time).caption, f"bristle {len(self.wires)} lags by {signed(lag, 1, 6)}°"


def _phases(row: Row) -> tuple[Phase, ...]:
    """Return what happens from when on, in order."""
    found = [Phase(-math.inf, "turning with the hub"), *(Phase(each, "wires touch each other") for each in row.touches)]
    for number, run in enumerate(row.bristles, 1):
        name, contact = f"bristle {number}", run.first_contact("workpart")
        strike = math.inf if contact is None else contact.time
        if (met := run.event_time("bar touch", before=strike)) is not None:
            found.append(Phase(met, f"{name} meets the bar"))
        if (thrown := run.event_time("bar release", last=True, before=strike)) is not None:
            found.append(Phase(thrown, f"the belt throws {name}"))
        if contact is not None:
            rate = contact.rates_before[0] - run.hub_speed
            found.append(Phase(strike, f"{name} strikes at {signed(rate, 0)} rad/s relative to the hub"))
    return tuple(sorted(found, key=lambda phase: (phase.start, phase.caption)))
