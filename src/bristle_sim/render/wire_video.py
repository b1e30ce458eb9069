"""Film of the strike of a wire that bends: its deflection enlarged, the contact force, and the bending wave up the wire."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILION
from bristle_sim.render.drawing import View, moving_arrow, point_arrow
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.panels import say
from bristle_sim.render.style import MICROSECONDS, MILLIMETRES, Scale, signed, styled
from bristle_sim.studies.flexible_wire import FlexibleWire
from bristle_sim.theory.cueing import centrifugal_stiffness
from bristle_sim.theory.wire import hinge_stiffness

SHOWN_DEFLECTION, LONGEST_FORCE = 0.35, 0.22
"""The largest deflection of the wire, and the arrow of the largest force, as they are drawn, in lengths of the wire."""

ARRIVED = 0.1
"""Fraction of the largest bending moment at which the wave has reached the hinge next to the root."""

GRID = 400
"""Instants of the map of bending moments."""


class WireFilm(Film):
    """What a film of a wire's strike shows, from the first touch until the wave has come back."""

    size, letter_size = (960, 540), 15.0

    @styled()
    def __init__(self, struck: FlexibleWire, *, width: int = 960, height: int = 540, duration: float = 12.0) -> None:
        end = float(struck.wire.time[-1])
        super().__init__(slow_motion(0.0, end, duration), width, height, (BLUE, ORANGE), Scale(MICROSECONDS, "µs"))
        self.wire, self.rigid = (_Motion(struck, rigid=rigid) for rigid in (False, True))
        length, most = struck.strike.tool.bristle.length, float(np.abs(self.wire.deflections).max())
        self.enlarged = max(1.0, SHOWN_DEFLECTION * length / most) if most else 1.0
        figure, top, small = self.figure, 1.0 - HEADER, 0.62 * self.letters
        self._draw_wire(figure.add_axes((0.0, 0.0, 0.5, top)), small)
        force = figure.add_axes((0.565, 0.55, 0.35, top - 0.6))
        wave = figure.add_axes((0.565, 0.115, 0.35, 0.3))
        for motion, color in ((self.rigid, ORANGE), (self.wire, BLUE)):
            touch, pushed = motion.force
            force.fill_between(touch * MICROSECONDS, pushed, color=color, alpha=0.15, linewidth=0.0)
            force.plot(touch * MICROSECONDS, pushed, color=color, linewidth=1.8)
        force.set_ylim(bottom=0.0)
        self.arrival = _draw_wave(wave, figure.add_axes((0.925, 0.115, 0.012, 0.3)), struck)
        for axes, title in ((force, "normal force (N)"), (wave, "bending moment along the wire (mN m)")):
            axes.set_title(title, loc="left", fontsize=small)
            axes.set_xlim(0.0, end * MICROSECONDS)
            axes.tick_params(labelsize=0.9 * small)
            self.hands.append(axes.axvline(0.0, color=BLACK, linewidth=1.0))
        wave.set_xlabel(wave.get_xlabel(), fontsize=small)
        wave.set_ylabel(wave.get_ylabel(), fontsize=small)
        self.moving = [self.rigid_line, self.wire_line, self.arrow, *self.hands]

    def move(self, time: float) -> tuple[str, ...]:
        """Move wires and arrow to an instant, s."""
        for line, motion in ((self.rigid_line, self.rigid), (self.wire_line, self.wire)):
            points = (motion.straight + self.enlarged * motion.deflection(time)) * MILLIMETRES
            line.set_data(points.real, points.imag)
        forces = [float(np.interp(time, *motion.force, right=0.0)) for motion in (self.wire, self.rigid)]
        size = LONGEST_FORCE * abs(self.wire.straight[-1]) * MILLIMETRES * forces[0] / self.wire.force[1].max()
        foot, tip = points[-1] - 1j * size * np.exp(-1j * self.wire.turned(time)), points[-1]
        point_arrow(self.arrow, (foot.real, foot.imag), (tip.real, tip.imag), shortest=0.3)
        caption = "the wave is at the root"
        if time > self.wire.force[0][-1]:
            caption = "released, the wire swings on"
        elif time < self.arrival or len(self.wire.straight) == 2:
            caption = "the end is struck" + ("; the root does not know of it" if time < self.arrival else "")
        return caption, f"wire {signed(forces[0], 1, 5)} N", f"rigid {signed(forces[1], 1, 5)} N"

    def _draw_wire(self, axes: Axes, letters: float) -> None:
        """Draw the unhindered wire and its root, and add what moves: the wire, the rigid bristle and the force's arrow."""
        straight, box = self.wire.straight * MILLIMETRES, axes.get_window_extent()
        size, tip, links = abs(straight[-1]), straight[-1], len(straight) - 1
        # Below the longest arrow there is room for the words.
        corners = [(tip.real + 0.3 * size, tip.imag - 0.38 * size), (-0.45 * size, 0.1 * size)]
        View.around([corners], box.width / box.height, 0.04).apply(axes)
        axes.set_axis_off()
        axes.plot(straight.real, straight.imag, color=GREY, linewidth=1.2, dashes=(4, 3), label="unhindered")
        (self.rigid_line,) = axes.plot([], [], color=ORANGE, linewidth=2.0, label="rigid bristle")
        look: dict[str, Any] = {"color": BLUE, "linewidth": 3.0, "markersize": 4.0, "markerfacecolor": "white"}
        (self.wire_line,) = axes.plot([], [], "o-", **look, label=f"wire of {links} link{'s' * (links > 1)}")
        axes.plot(0.0, 0.0, "o", color=GREEN, markersize=9, markeredgecolor="white", zorder=4, label="root, on the hub")
        self.arrow = moving_arrow(axes, VERMILION, 2.5, 14.0)
        axes.plot([], [], color=VERMILION, linewidth=2.5, label="normal force on its end")
        axes.legend(loc="upper left", fontsize=letters, borderaxespad=1.0)
        words = "seen from the root, turning with the unhindered wire;\n"
        words += f"deflection from it drawn {self.enlarged:.2g} times as large as it is"
        axes.text(0.03, 0.03, words, transform=axes.transAxes, fontsize=letters, color=GREY)


def _draw_wave(axes: Axes, scale: Axes, struck: FlexibleWire) -> float:
    """Draw the bending moments over time and place, root on top; return when the wave is at the hinge next to the root, s."""
    bristle, run = struck.strike.tool.bristle, struck.wire
    time, bends = np.linspace(0.0, run.time[-1], GRID), np.diff(run.angles, axis=1).T
    scale.set_visible(bool(bends.size))
    if not bends.size:
        say(axes, "a rigid bristle does not bend")
        return 0.0
    stiffness = hinge_stiffness(bristle.wire_diameter, bristle.length, bristle.modulus, bristle.links)
    moments = stiffness * np.array([np.interp(time, run.time, each) for each in bends])
    length, most = bristle.length * MILLIMETRES, float(np.abs(moments).max())
    half = 0.5 * length / (len(moments) + 1)
    sides = (0.0, float(time[-1]) * MICROSECONDS, length - half, half)
    look: dict[str, Any] = {"cmap": "RdBu", "vmin": -1e3 * most, "vmax": 1e3 * most, "aspect": "auto"}
    picture = axes.imshow(1e3 * moments, extent=sides, interpolation="bilinear", **look)
    axes.set(ylim=(length, 0.0), xlabel="time since the first touch (µs)", ylabel="from the root (mm)")
    axes.grid(visible=False)
    axes.figure.colorbar(picture, cax=scale)
    scale.tick_params(labelsize="x-small")
    return float(time[np.argmax(np.abs(moments[0]) > ARRIVED * most)])


class _Motion:
    """A strike seen from the root, turning with the wire as it would move unhindered; places as x + iy, m.

    Attributes:
        straight: root, joints and tip of the unhindered wire.
        deflections: how far they are from there, shape (samples, corners).
        force: time and normal force of the contact, s and N.
    """

    def __init__(self, struck: FlexibleWire, *, rigid: bool) -> None:
        strike, run = struck.strike, struck.rigid if rigid else struck.wire
        self._strike, self._time, history = strike, run.time, run.contact.history
        assert history is not None
        self.force = (history.time - history.time[0], history.normal_force)
        arm = -1j * strike.tool.bristle.length / run.angles.shape[1]
        self.straight = np.exp(-1j * strike.impact_angle) * arm * np.arange(run.angles.shape[1] + 1)
        arms = arm * np.exp(1j * (run.angles - self.turned(run.time)[:, np.newaxis]))
        self.deflections = np.pad(np.cumsum(arms, axis=1), ((0, 0), (1, 0))) - self.straight

    def deflection(self, time: float) -> NDArray[np.complex128]:
        """Return how far root, joints and tip are from where they would be."""
        return np.array([np.interp(time, self._time, corner) for corner in self.deflections.T])

    def turned(self, time: Array | float) -> Array:
        """Return how far the unhindered wire has turned: small swings on its belt, on the turning hub."""
        tool = self._strike.tool
        field = float(centrifugal_stiffness(tool.bristle.mass, tool.hub.radius, tool.bristle.length, tool.hub.speed))
        own = math.sqrt((tool.belt.stiffness + field) / tool.bristle.inertia_about_root)
        relative = (self._strike.rate - tool.hub.speed) * np.sinc(own * np.asarray(time) / np.pi)
        return np.asarray((tool.hub.speed + relative) * time)
