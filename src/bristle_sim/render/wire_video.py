"""Film of the strike of a wire that bends: its deflection enlarged, the contact force, and the bending wave up the wire."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from bristle_sim.arrays import Array
from bristle_sim.render.drawing import View, moving_arrow, point_arrow
from bristle_sim.render.film_scene import HEADER, FilmScene, slow_motion, write_film
from bristle_sim.render.panels import say
from bristle_sim.render.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILION, signed, styled
from bristle_sim.studies.flexible_wire import FlexibleWire
from bristle_sim.theory.cueing import centrifugal_stiffness
from bristle_sim.theory.wire import hinge_stiffness

Complexes = NDArray[np.complex128]

LETTERS = 15.0
"""Letter height in a picture of 960 x 540, px."""

COLUMNS = ((20, BLACK), (22, BLACK), (18, BLUE), (18, ORANGE))
"""Characters and colour of the read-outs: time, slow-down, force of the wire and of the rigid bristle."""

SHOWN_DEFLECTION, LONGEST_FORCE = 0.35, 0.22
"""The largest deflection of the wire, and the arrow of the largest force, as they are drawn, in lengths of the wire."""

MILLIMETRES, MICROSECONDS = 1e3, 1e6

ARRIVED = 0.1
"""Fraction of the largest bending moment at which the wave has reached the hinge next to the root."""

GRID = 400
"""Instants of the map of bending moments."""


def wire_video(
    struck: FlexibleWire,
    path: str | Path,
    *,
    fps: float = 30.0,
    width: int = 960,
    height: int = 540,
    duration: float = 12.0,
) -> Path:
    """Film a strike, from the first touch until the wave has come back, to an mp4 or gif file; needs no display.

    Raises:
        ValueError: for a file that cannot be written or settings out of range.
    """

    def build() -> WireScene:
        return WireScene(struck, width=width, height=height, duration=duration)

    return write_film(path, build, (width, height), fps, duration)


class WireScene(FilmScene):
    """The drawing that a film of a wire's strike shows, at any film time."""

    @styled()
    def __init__(self, struck: FlexibleWire, *, width: int = 960, height: int = 540, duration: float = 12.0) -> None:
        self.struck = struck
        self.wire, self.rigid = _Motion(struck), _Motion(struck, rigid=True)
        warp = slow_motion(0.0, self.wire.end, duration)
        super().__init__(warp, width, height, LETTERS * min(width / 960.0, height / 540.0), COLUMNS)
        figure, top, small = self.stage.figure, 1.0 - HEADER, 0.62 * self.letters
        most = max(np.abs(self.wire.deflection(time)).max() for time in np.linspace(0.0, self.wire.end, 100))
        self.enlarged = max(1.0, SHOWN_DEFLECTION * self.wire.length / most) if most else 1.0
        self._draw_wire(figure.add_axes((0.0, 0.0, 0.5, top)), small)
        force = figure.add_axes((0.565, 0.55, 0.35, top - 0.6))
        wave = figure.add_axes((0.565, 0.115, 0.35, 0.3))
        self.hands = [self._draw_forces(force, small), self._draw_wave(figure, wave, small)]
        self.stage.add(self.rigid_line, self.wire_line, self.arrow, *self.hands)
        self.show(0.0)

    def show(self, film_time: float) -> None:
        """Move wire, arrow, hands and read-outs to a film time, s."""
        time = float(self.warp.physical_time(film_time))
        for line, motion in ((self.rigid_line, self.rigid), (self.wire_line, self.wire)):
            points = (motion.straight + self.enlarged * motion.deflection(time)) * MILLIMETRES
            line.set_data(points.real, points.imag)
        forces = [motion.force(time) for motion in (self.wire, self.rigid)]
        tip = points[-1]
        length = LONGEST_FORCE * self.wire.length * MILLIMETRES * forces[0] / self.wire.largest
        foot = tip - length * self.wire.normal(time)
        point_arrow(self.arrow, (foot.real, foot.imag), (tip.real, tip.imag), shortest=0.3)
        for hand in self.hands:
            hand.set_xdata([time * MICROSECONDS] * 2)
        texts = (
            f"time {signed(time * MICROSECONDS, 1, 6)} µs",
            f"slowed {float(self.warp.slow_down_at(film_time)):8.0f}\N{MULTIPLICATION SIGN}",
            f"wire {signed(forces[0], 1, 5)} N",
            f"rigid {signed(forces[1], 1, 5)} N",
        )
        self.write_words(self._caption(time), texts)

    def _caption(self, time: float) -> str:
        """Say how far the wave has come."""
        if time > self.wire.touch_time[-1]:
            return "released, the wire swings on"
        if self.struck.strike.tool.bristle.links == 1:
            return "the end is struck"
        return "the end is struck; the root does not know of it" if time < self.arrival else "the wave is at the root"

    def _draw_wire(self, axes: Axes, letters: float) -> None:
        """Draw the unhindered wire and its root, and add what moves: the wire, the rigid bristle and the force's arrow."""
        straight, size = self.wire.straight * MILLIMETRES, self.wire.length * MILLIMETRES
        box = axes.get_window_extent()
        corners = np.array(
            [[straight[-1].real + 0.3 * size, straight[-1].imag - 0.25 * size], [-0.45 * size, 0.1 * size]]
        )
        View.around([corners], box.width / box.height, 0.04).apply(axes)
        axes.set_axis_off()
        axes.plot(straight.real, straight.imag, color=GREY, linewidth=1.2, dashes=(4, 3), label="unhindered")
        (self.rigid_line,) = axes.plot([], [], color=ORANGE, linewidth=2.0, label="rigid bristle")
        links = self.struck.strike.tool.bristle.links
        look: dict[str, Any] = {"color": BLUE, "linewidth": 3.0, "markersize": 4.0, "markerfacecolor": "white"}
        (self.wire_line,) = axes.plot([], [], "o-", **look, label=f"wire of {links} link{'s' * (links > 1)}")
        axes.plot(0.0, 0.0, "o", color=GREEN, markersize=9, markeredgecolor="white", zorder=4, label="root, on the hub")
        self.arrow = moving_arrow(axes, VERMILION, 2.5, 14.0)
        axes.plot([], [], color=VERMILION, linewidth=2.5, label="normal force on its end")
        axes.legend(loc="upper left", fontsize=letters, borderaxespad=1.0)
        words = (
            "seen from the root, turning with the unhindered wire;\n"
            f"deflection from it drawn {self.enlarged:.2g} times as large as it is"
        )
        axes.text(0.03, 0.03, words, transform=axes.transAxes, fontsize=letters, color=GREY)

    def _draw_forces(self, axes: Axes, letters: float) -> Line2D:
        """Draw both forces over time, and return the hand that moves."""
        for motion, color in ((self.rigid, ORANGE), (self.wire, BLUE)):
            axes.fill_between(
                motion.touch_time * MICROSECONDS, motion.touch_force, color=color, alpha=0.15, linewidth=0.0
            )
            axes.plot(motion.touch_time * MICROSECONDS, motion.touch_force, color=color, linewidth=1.8)
        axes.set_xlim(0.0, self.wire.end * MICROSECONDS)
        axes.set_ylim(bottom=0.0)
        axes.set_title("normal force (N)", loc="left", fontsize=letters)
        axes.tick_params(labelsize=0.9 * letters)
        return axes.axvline(0.0, color=BLACK, linewidth=1.0)

    def _draw_wave(self, figure: Figure, axes: Axes, letters: float) -> Line2D:
        """Draw the bending moments over time and place, root on top, and return the hand that moves."""
        time, moments = self.wire.moments()
        at_root = np.abs(moments[:1]).max(axis=0, initial=0.0) > ARRIVED * np.abs(moments).max(initial=0.0)
        self.arrival = float(time[np.argmax(at_root)])
        axes.set_title("bending moment along the wire (mN m)", loc="left", fontsize=letters)
        if not moments.size:
            say(axes, "a rigid bristle does not bend")
            return axes.axvline(0.0, visible=False)
        link, length = self.wire.length / (len(moments) + 1), self.wire.length * MILLIMETRES
        most = float(np.abs(moments).max())
        sides = (0.0, float(time[-1]) * MICROSECONDS, length - 0.5 * link * MILLIMETRES, 0.5 * link * MILLIMETRES)
        look: dict[str, Any] = {"cmap": "RdBu", "vmin": -most * MILLIMETRES, "vmax": most * MILLIMETRES}
        picture = axes.imshow(moments * MILLIMETRES, extent=sides, aspect="auto", interpolation="bilinear", **look)
        axes.set(xlim=sides[:2], ylim=(length, 0.0))
        axes.grid(visible=False)
        axes.set_xlabel("time since the first touch (µs)", fontsize=letters)
        axes.set_ylabel("from the root (mm)", fontsize=letters)
        axes.tick_params(labelsize=0.9 * letters)
        bar = figure.colorbar(picture, cax=figure.add_axes((0.925, 0.115, 0.012, 0.3)))
        bar.ax.tick_params(labelsize=0.9 * letters)
        return axes.axvline(0.0, color=BLACK, linewidth=1.0)


class _Motion:
    """A strike seen from the root, turning with the wire as it would move unhindered; places as x + iy, m.

    Attributes:
        straight: root, joints and tip of the unhindered wire.
        end: of the motion, s.
        touch_time, touch_force: history of the contact force, s and N.
    """

    def __init__(self, struck: FlexibleWire, *, rigid: bool = False) -> None:
        strike, run = struck.strike, struck.rigid if rigid else struck.wire
        tool = strike.tool
        time, kept = np.unique(run.time, return_index=True)
        self._angles = CubicHermiteSpline(time, run.angles[kept], run.rates[kept])
        self.end, self.length, self._start = float(struck.wire.time[-1]), tool.bristle.length, -strike.impact_angle
        links = run.angles.shape[1]
        self._link = -1j * self.length / links
        self.straight = np.exp(1j * self._start) * self._link * np.arange(links + 1)
        field = float(centrifugal_stiffness(tool.bristle.mass, tool.hub.radius, self.length, tool.hub.speed))
        self._own = math.sqrt((tool.belt.stiffness + field) / tool.bristle.inertia_about_root)
        self._speed, self._relative = tool.hub.speed, strike.rate - tool.hub.speed
        history = run.contact.history
        assert history is not None
        self.touch_time, self.touch_force = history.time - history.time[0], history.normal_force
        self.largest = float(self.touch_force.max())
        wire = (tool.bristle.wire_diameter, self.length, tool.bristle.modulus)
        self._hinge = hinge_stiffness(*wire, links)

    def deflection(self, time: float) -> Complexes:
        """Return how far root, joints and tip are from where they would be."""
        arms = self._link * np.exp(1j * (self._angles(time) - self._turned(time)))
        return np.asarray(np.concatenate([[0.0], np.cumsum(arms)]) - self.straight)

    def normal(self, time: float) -> complex:
        """Return the workpart's normal."""
        return complex(1j * np.exp(-1j * self._turned(time)))

    def force(self, time: float) -> float:
        """Return the normal force, N."""
        return float(np.interp(time, self.touch_time, self.touch_force, right=0.0))

    def moments(self) -> tuple[Array, Array]:
        """Return instants, and the bending moment in each hinge at them, shape (links - 1, instants), N m."""
        time = np.linspace(0.0, self.end, GRID)
        return time, self._hinge * np.diff(self._angles(time), axis=1).T

    def _turned(self, time: float) -> float:
        """Return how far the unhindered wire has turned: small swings on its belt, on the turning hub."""
        swing = self._relative * (math.sin(self._own * time) / self._own if self._own else time)
        return self._speed * time + swing
