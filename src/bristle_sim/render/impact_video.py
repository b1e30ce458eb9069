"""Film of one impact in ultra slow motion: the rods to scale, the tip enlarged, velocities and forces over time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import ConnectionPatch, Rectangle
from numpy.typing import NDArray

from bristle_sim.render.chain_drawing import ChainDrawing
from bristle_sim.render.contact_closeup import CloseUp
from bristle_sim.render.contact_motion import ContactMotion, caption, contact_motion
from bristle_sim.render.contact_panels import NORMAL, TANGENTIAL, ContactPanels
from bristle_sim.render.prefixes import scale_for
from bristle_sim.render.readout import Readout
from bristle_sim.render.story import Phase, phase_at
from bristle_sim.render.style import BLACK, GREY, signed, styled
from bristle_sim.render.time_warp import slow_motion
from bristle_sim.render.video import Stage, checked_video_target, write_video
from bristle_sim.studies.impacts import Impacts

__all__ = ["ImpactScene", "impact_video"]

Array = NDArray[np.float64]

HEADER = 0.14
"""Share of the picture's height above the drawings: caption and read-outs."""

CAPTION_SHOWN = 0.9
"""Film time for which the end of slip keeps its caption, s."""

LETTERS = 15.0
"""Letter height in a picture of 960 x 540, px."""

COLUMNS = (16, 16, 18, 18)
"""Characters of the read-outs: time, slow-down, normal and tangential velocity."""


def impact_video(
    impacts: Impacts,
    path: str | Path,
    *,
    fps: float = 30.0,
    width: int = 960,
    height: int = 540,
    duration: float = 10.0,
    slower: float = 3.0,
) -> Path:
    """Film an impact as the compliant law resolves it in time, to an mp4 or gif file; needs no display.

    Args:
        impacts: the impact under every law; what is filmed is the compliant one, see
            :func:`bristle_sim.studies.timed_contact.with_visible_contact`.
        path: of the file, mp4 or gif.
        fps: frames per second of film.
        width, height: of the picture, px.
        duration: of the film, s.
        slower: how much slower the end of slip is shown than the rest.

    Raises:
        ValueError: for a tip that does not approach, a file that cannot be written or settings out of range.
    """
    checked_video_target(path)
    scene = ImpactScene(impacts, width=width, height=height, duration=duration, slower=slower)
    total = max(2, math.ceil(duration * fps))
    return write_video(path, scene.frames(total), (width, height), fps, total)


class ImpactScene:
    """The drawing that a film of an impact shows, at any film time."""

    @styled()
    def __init__(
        self, impacts: Impacts, *, width: int = 960, height: int = 540, duration: float = 10.0, slower: float = 3.0
    ) -> None:
        self.motion = _resolved(impacts)
        stop = self.motion.slip_stop
        start, end = float(self.motion.time[0]), float(self.motion.time[-1])
        self.warp = slow_motion(start, end, duration, () if stop is None else (stop,), slower=slower, width=0.05)
        self._phases = self._captions(stop)
        self.stage = Stage(width, height)
        self._letters = LETTERS * min(width / 960.0, height / 540.0)
        self._draw_tip(impacts)
        box = (0.685, 0.10, 0.305, 1.0 - HEADER - 0.13)
        self.panels = ContactPanels(self.stage.figure, self.motion, box, 0.6 * self._letters)
        self.stage.add(*self.panels.artists)
        self._add_words(impacts)
        self.show(0.0)

    def frames(self, total: int) -> Iterator[memoryview]:
        """The film in ``total`` pictures evenly spaced in film time, the first and the last instant included."""
        for film_time in np.linspace(0.0, self.warp.film[-1], total):
            self.show(float(film_time))
            yield self.stage.frame()

    def show(self, film_time: float) -> None:
        """Move everything to a film time, s."""
        time = float(self.warp.physical_time(film_time))
        self.close_up.show(time)
        self.chain.point(self.motion.at("tangential_velocity", time), self.motion.at("normal_velocity", time))
        self.panels.show(time)
        self._show_words(film_time, time)

    def _captions(self, stop: float | None) -> tuple[Phase, ...]:
        """The motion's phases, with the end of slip as one of its own for the time its caption stands."""
        if stop is None:
            return self.motion.phases
        middle = float(self.warp.film_time(stop))
        start, end = map(float, self.warp.physical_time(middle + 0.5 * CAPTION_SHOWN * np.array([-1.0, 1.0])))
        before = [phase for phase in self.motion.phases if phase.start < stop]
        after = [Phase(max(phase.start, end), phase.caption) for phase in self.motion.phases[len(before) :]]
        return (*before, Phase(max(start, before[-1].start), "slip stops"), *after)

    def _draw_tip(self, impacts: Impacts) -> None:
        """The chain to scale on the left, and beside it what happens at its tip."""
        top = 1.0 - HEADER
        figure, motion = self.stage.figure, self.motion
        whole = figure.add_axes((0.01, 0.02, 0.2, top - 0.03))
        near = figure.add_axes((0.22, 0.075, 0.36, top - 0.085))
        struck = impacts.strikes["compliant"]
        self.chain = ChainDrawing(whole, struck, impacts.chain.hub_radius, motion.fastest)
        last_rod = struck.centre_line[-1] - struck.centre_line[-2]
        self.close_up = CloseUp(near, motion, last_rod, 0.62 * self._letters)
        _connect(whole, near)
        self._note_enlargement(whole, near)
        self.stage.add(*self.close_up.artists, *self.chain.artists)

    def _note_enlargement(self, whole: Axes, near: Axes) -> None:
        """How much larger the ways of the tip are drawn than the rods."""
        rods = whole.get_window_extent().height / float(np.ptp(whole.get_ylim()))
        ways = near.get_window_extent().width * self.close_up.scale
        deeper = f", depth {self.close_up.stretch:.2g} times more" if self.close_up.stretch > 1.0 else ""
        box = near.get_position()
        self.stage.figure.text(
            box.x0,
            0.028,
            f"the tip's ways are drawn {_rounded(ways / rods)} times larger than the rods{deeper}",
            fontsize=0.58 * self._letters,
            color=GREY,
        )

    def _add_words(self, impacts: Impacts) -> None:
        """Caption and, below it, a row of read-outs; on the right what does not change."""
        width, height = self.stage.size
        clock, surface = self.panels.clock, impacts.surface
        compression = f"compression {self.motion.compression_end * clock.factor:.4g} {clock.unit}"
        if impacts.timing:
            compression += f" ({impacts.timing})"
        touch = f"in touch for {self.motion.touch_end * clock.factor:.4g} {clock.unit}"
        self.stage.figure.text(
            0.99,
            1.0 - 0.32 * HEADER,
            f"{compression}\n{touch}, μ = {surface.friction:.4g}, e* = {surface.restitution:.4g}",
            ha="right",
            va="center",
            fontsize=0.65 * self._letters,
            color=GREY,
        )
        self.caption = self.stage.figure.text(
            0.015, 1.0 - 0.32 * HEADER, "", va="center", fontsize=self._letters, weight="bold", color=BLACK
        )
        colors = (BLACK, BLACK, NORMAL, TANGENTIAL)
        self.readouts = tuple(Readout(0, 0, self._letters, color=color) for color in colors)
        left = round(0.015 * width)
        for readout, characters in zip(self.readouts, COLUMNS, strict=True):
            readout.left, readout.top = left, round(0.78 * HEADER * height - 0.5 * readout.height)
            left += readout.width(characters) + round(0.03 * width)
        self.stage.write(*self.readouts)

    def _show_words(self, film_time: float, time: float) -> None:
        words = caption(phase_at(self._phases, time).caption)
        if words != self.caption.get_text():
            self.caption.set_text(words)
            self.stage.refresh()
        normal, tangential = (self.motion.at(f"{name}_velocity", time) for name in ("normal", "tangential"))
        clock, speed = self.panels.clock, scale_for(self.motion.fastest, "m/s")
        texts = (
            f"time {signed(time * clock.factor, 3, 8)} {clock.unit}",
            f"slowed {_rounded(float(self.warp.slow_down_at(film_time)), plain=True)}\N{MULTIPLICATION SIGN}",
            f"away {signed(normal * speed.factor, 2, 7)} {speed.unit}",
            f"along {signed(tangential * speed.factor, 2, 7)} {speed.unit}",
        )
        for readout, text in zip(self.readouts, texts, strict=True):
            readout.text = text


def _resolved(impacts: Impacts) -> ContactMotion:
    """The motion in the compliant law's contact, or ValueError where that law has none."""
    if "compliant" not in impacts.strikes:
        raise ValueError("contact: not resolved in time for these values; there is no motion to film")
    return contact_motion(impacts.strikes["compliant"].contact)


def _connect(whole: Axes, near: Axes) -> None:
    """A frame around the tip, and a line from it to the close-up."""
    half = 0.025 * float(np.ptp(whole.get_ylim()))
    whole.add_patch(Rectangle((-half, -half), 2.0 * half, 2.0 * half, fill=False, edgecolor=GREY, zorder=6))
    line = ConnectionPatch((half, 0.0), (0.0, 0.2), whole.transData, near.transAxes, color=GREY, linewidth=0.8)
    whole.figure.add_artist(line)


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _rounded(value: float, *, plain: bool = False) -> str:
    """One digit and a power of ten, or the number itself where that is short."""
    if 0.1 <= value < 1e4:
        return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"
    leading, exponent = f"{value:.0e}".split("e")
    if plain:
        return f"{leading}e{int(exponent)}"
    power = f"10{str(int(exponent)).translate(_SUPERSCRIPTS)}"
    return power if leading == "1" else f"{leading}·{power}"
