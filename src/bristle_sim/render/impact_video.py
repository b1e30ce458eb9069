"""Film of one impact in ultra slow motion: the rods to scale, the tip enlarged, velocities and forces over time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import ConnectionPatch, Rectangle

from bristle_sim.render.contact_motion import ContactMotion, caption, contact_motion
from bristle_sim.render.film_scene import BORDER, HEADER, FilmScene, TimeWarp, slow_motion, write_film
from bristle_sim.render.impact_drawings import NORMAL, TANGENTIAL, ChainDrawing, CloseUp, ContactPanels
from bristle_sim.render.story import Phase, phase_at
from bristle_sim.render.style import BLACK, GREY, scale_for, signed, styled
from bristle_sim.studies.impacts import Impacts

CAPTION_SHOWN = 0.9
"""Film time for which the end of slip keeps its caption, s."""

LETTERS = 15.0
"""Letter height in a picture of 960 x 540, px."""

COLUMNS = ((16, BLACK), (16, BLACK), (18, NORMAL), (18, TANGENTIAL))
"""Characters and colour of the read-outs: time, slow-down, normal and tangential velocity."""


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
        impacts: the impact under every law; the compliant one is filmed, see
            :func:`bristle_sim.studies.timed_contact.with_visible_contact`.
        path: of the file, mp4 or gif.
        fps: frames per second of film.
        width, height: of the picture, px.
        duration: of the film, s.
        slower: how much slower the end of slip is shown than the rest.

    Raises:
        ValueError: for a tip that does not approach, a file that cannot be written or settings out of range.
    """

    def build() -> ImpactScene:
        return ImpactScene(impacts, width=width, height=height, duration=duration, slower=slower)

    return write_film(path, build, (width, height), fps, duration)


class ImpactScene(FilmScene):
    """The drawing that a film of an impact shows, at any film time."""

    @styled()
    def __init__(
        self, impacts: Impacts, *, width: int = 960, height: int = 540, duration: float = 10.0, slower: float = 3.0
    ) -> None:
        self.motion = _resolved(impacts)
        stop = self.motion.slip_stop
        start, end = float(self.motion.time[0]), float(self.motion.time[-1])
        warp = slow_motion(start, end, duration, () if stop is None else (stop,), slower=slower, width=0.05)
        super().__init__(warp, width, height, LETTERS * min(width / 960.0, height / 540.0), COLUMNS)
        self._phases = _captions(self.motion, warp)
        self._draw_tip(impacts)
        box = (0.685, 0.10, 0.305, 1.0 - HEADER - 0.13)
        self.panels = ContactPanels(self.stage.figure, self.motion, box, 0.6 * self.letters)
        self.stage.add(*self.panels.artists)
        self._describe(impacts)
        self.show(0.0)

    def show(self, film_time: float) -> None:
        """Move drawings, markers and read-outs to a film time, s."""
        time = float(self.warp.physical_time(film_time))
        tangential, normal = (self.motion.at(f"{name}_velocity", time) for name in ("tangential", "normal"))
        self.close_up.show(time)
        self.chain.point(tangential, normal)
        self.panels.show(time)
        clock, speed = self.panels.clock, scale_for(self.motion.fastest, "m/s")
        texts = (
            f"time {signed(time * clock.factor, 3, 8)} {clock.unit}",
            f"slowed {_rounded(float(self.warp.slow_down_at(film_time)), plain=True)}\N{MULTIPLICATION SIGN}",
            f"away {signed(normal * speed.factor, 2, 7)} {speed.unit}",
            f"along {signed(tangential * speed.factor, 2, 7)} {speed.unit}",
        )
        self.write_words(caption(phase_at(self._phases, time).caption), texts)

    def _draw_tip(self, impacts: Impacts) -> None:
        """Draw the chain to scale on the left, and beside it the tip at the surface with its enlargement."""
        top = 1.0 - HEADER
        figure, motion = self.stage.figure, self.motion
        whole = figure.add_axes((0.01, 0.02, 0.2, top - 0.03))
        near = figure.add_axes((0.22, 0.075, 0.36, top - 0.085))
        line = impacts.strikes["compliant"].centre_line
        self.chain = ChainDrawing(whole, line, impacts.chain.hub_radius, motion.fastest)
        self.close_up = CloseUp(near, motion, line[-1] - line[-2], 0.62 * self.letters)
        _connect(whole, near)
        self.stage.add(*self.close_up.artists, *self.chain.artists)
        rods = whole.get_window_extent().height / float(np.ptp(whole.get_ylim()))
        ways = near.get_window_extent().width * self.close_up.scale
        deeper = f", depth {self.close_up.stretch:.2g} times more" if self.close_up.stretch > 1.0 else ""
        words = f"the tip's displacements are drawn {_rounded(ways / rods)} times larger than the rods{deeper}"
        figure.text(near.get_position().x0, 0.028, words, fontsize=0.58 * self.letters, color=GREY)

    def _describe(self, impacts: Impacts) -> None:
        """Write durations and coefficients in the upper right corner."""
        clock, surface = self.panels.clock, impacts.surface
        source = f" ({impacts.timing})" if impacts.timing else ""
        words = (
            f"compression {self.motion.compression_end * clock.factor:.4g} {clock.unit}{source}\n"
            f"in touch for {self.motion.touch_end * clock.factor:.4g} {clock.unit},"
            f" μ = {surface.friction:.4g}, e* = {surface.restitution:.4g}"
        )
        place = (1.0 - BORDER, 1.0 - 0.33 * HEADER)
        self.stage.figure.text(*place, words, ha="right", va="center", fontsize=0.65 * self.letters, color=GREY)


def _captions(motion: ContactMotion, warp: TimeWarp) -> tuple[Phase, ...]:
    """Return the motion's phases, with the end of slip as one of its own for the time its caption stands."""
    stop = motion.slip_stop
    if stop is None:
        return motion.phases
    middle = float(warp.film_time(stop))
    start, end = map(float, warp.physical_time(middle + 0.5 * CAPTION_SHOWN * np.array([-1.0, 1.0])))
    before = [phase for phase in motion.phases if phase.start < stop]
    after = [Phase(max(phase.start, end), phase.caption) for phase in motion.phases[len(before) :]]
    return (*before, Phase(max(start, before[-1].start), "slip stops"), *after)


def _resolved(impacts: Impacts) -> ContactMotion:
    """Return the motion in the compliant law's contact, or raise ValueError where that law has none."""
    if "compliant" not in impacts.strikes:
        raise ValueError("contact: not resolved in time for these values; there is no motion to film")
    return contact_motion(impacts.strikes["compliant"].contact)


def _connect(whole: Axes, near: Axes) -> None:
    """Frame the tip, and lead a line from it to the close-up."""
    half = 0.025 * float(np.ptp(whole.get_ylim()))
    whole.add_patch(Rectangle((-half, -half), 2.0 * half, 2.0 * half, fill=False, edgecolor=GREY, zorder=6))
    line = ConnectionPatch((half, 0.0), (0.0, 0.2), whole.transData, near.transAxes, color=GREY, linewidth=0.8)
    whole.figure.add_artist(line)


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _rounded(value: float, *, plain: bool = False) -> str:
    """Format one digit and a power of ten, or the number itself where that is short."""
    if 0.1 <= value < 1e4:
        return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"
    leading, exponent = f"{value:.0e}".split("e")
    if plain:
        return f"{leading}e{int(exponent)}"
    power = f"10{str(int(exponent)).translate(_SUPERSCRIPTS)}"
    return power if leading == "1" else f"{leading}·{power}"
