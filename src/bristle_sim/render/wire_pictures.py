"""Figure and film of the strike of a wire that bends, compared with a rigid bristle.

They show the contact force, the quantities of the strike, and the bending wave in the wire.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import CenteredNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bristle_sim.arrays import Array
from bristle_sim.readable import MICROSECONDS, MILLIMETRES, amount
from bristle_sim.render.drawing import add_arrows, draw_wires
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    VERMILION,
    Look,
    Scale,
    blank_figure,
    say,
    signed,
    styled,
)
from bristle_sim.studies.flexible_wire import FlexibleWire, WireStudy, measures
from bristle_sim.theory.wire import hinge_stiffness
from bristle_sim.trajectory.interpolation import cubics

LOOKS = {
    "normal_final_impulse": ("impulse", BLUE, "o"),
    "peak_force": ("peak force", VERMILION, "s"),
    "time_in_touch": ("duration", GREEN, "^"),
    "crater_depth": ("crater", PURPLE, "D"),
}
"""Label, colour and marker of each quantity of a strike."""


@styled()
def wire_figure(struck: FlexibleWire, study: WireStudy) -> Figure:
    """Draw the contact force of a bending wire's strike, and compare bending wires with a rigid
    one.

    Further panels show impulse, peak force, time in contact and crater depth of a bending wire,
    each divided by that of the rigid wire. These ratios are drawn over the number of links that
    model the wire, and over the contact duration of the rigid wire.

    Args:
        struck: simulated strikes of the bending and of the rigid wire.
        study: the ratios.
    """
    figure = blank_figure(16.0, 12.5)
    panels = figure.subplot_mosaic([["force", "links"], ["duration", "duration"]])
    force, by_links, by_duration = panels.values()
    _draw_force(force, struck)
    by_links.set(xlabel="number of links", ylabel="wire / rigid bristle")
    by_duration.set(
        xscale="log",
        xlabel="contact duration of the rigid bristle, $T$ (µs); dotted: in the panel above",
    )
    by_duration.set_ylabel(f"wire of {struck.strike.tool.bristle.links} links / rigid bristle")
    durations = study.durations * MICROSECONDS
    for name, (words, color, marker) in LOOKS.items():
        look: Look = {"color": color, "marker": marker, "markersize": 3.4, "label": words}
        by_links.plot(study.links, study.by_links[name], **look, linestyle="none")
        by_duration.plot(durations, study.by_duration[name], **look)
    by_links.xaxis.set_major_locator(MaxNLocator(integer=True))
    by_duration.xaxis.set_major_formatter("{x:g}")
    own = struck.strike.contact.duration * MICROSECONDS
    by_duration.axvline(own, color=BLACK, linewidth=0.8, linestyle=":")
    for axes in (by_links, by_duration):
        axes.axhline(1.0, color=GREY, linewidth=0.8, linestyle="--")
        axes.set_ylim(bottom=0.0)
    figure.legend(*by_links.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _draw_force(axes: Axes, struck: FlexibleWire) -> None:
    rigid, own = (measures(struck.strike, each.contact) for each in (struck.rigid, struck.wire))
    times = rigid["peak_force"] / own["peak_force"]
    axes.set_title(f"peak force of the rigid bristle: {times:.2g} times the wire's")
    axes.set(xlabel="time since the first touch (µs)", ylabel="normal force (N)")
    wire = f"wire of {struck.strike.tool.bristle.links} links"
    for run, color, name, values in (
        (struck.rigid, GREY, "rigid bristle", rigid),
        (struck.wire, BLUE, wire, own),
    ):
        label = f"{name}, {amount(values['normal_final_impulse'], 'N s')}"
        _draw_course(axes, run, color, label)
    axes.set_xlim(left=0.0)
    axes.set_ylim(0.0, 1.3 * max(rigid["peak_force"], own["peak_force"]))
    axes.legend(loc="upper right")


def _draw_course(axes: Axes, run: Any, color: str, label: str = "") -> None:
    """Draw the normal force (N) of a contact over time (us), with the area below it shaded."""
    touch, force = _force(run)
    time = MICROSECONDS * touch
    axes.fill_between(time, force, color=color, alpha=0.12, linewidth=0.0)
    axes.plot(time, force, color=color, label=label)


# Length of the arrow of the largest force, as a fraction of the height of the drawn wires
LONGEST_FORCE = 0.22
# The bending wave has arrived when the moment at the hinge next to the root exceeds this fraction of
# the largest moment.
ARRIVED = 0.1
GRID = 400  # number of instants of the force curves and of the map of bending moments


class WireFilm(Film):
    """Film of a bending wire's strike, beside that of a rigid wire.

    The film shows the contact from the first touch, and a short free motion after the contact.
    """

    size = (960, 540)
    letter_size = 15.0

    @styled()
    def __init__(
        self, struck: FlexibleWire, *, width: int = 960, height: int = 540, duration: float = 12.0
    ) -> None:
        warp = slow_motion(0.0, float(struck.wire.time[-1]), duration)
        super().__init__(warp, width, height, (BLUE, ORANGE), Scale(MICROSECONDS, "µs"))
        tool = struck.strike.tool
        self._links = tool.bristle.links
        self._runs = (struck.wire, struck.rigid)
        self._lines = [cubics(run.time, run.centre_line) for run in self._runs]
        axes = self.figure.add_axes((0.0, 0.0, 0.5, 1.0 - HEADER))
        force = self.add_timeline((0.565, 0.55, 0.35, 0.4 - HEADER))
        wave = self.add_timeline((0.565, 0.115, 0.35, 0.3))
        points = np.concatenate([np.reshape(run.centre_line, (-1, 2)) for run in self._runs])
        self._longest = LONGEST_FORCE * float(np.ptp(points[:, 1]))
        below = points.min(axis=0) - [0.0, self._longest]
        colors = (BLUE, ORANGE)
        self.wires = draw_wires(axes, tool, np.vstack([points, below]), colors, margin=0.1)
        self.arrow = add_arrows(axes, VERMILION)
        for run, color in zip(self._runs, colors, strict=True):
            _draw_course(force, run, color)
        force.set_ylim(bottom=0.0)
        force.set_title("normal force (N), shown by the arrow")
        wave.set_title("bending moment along the wire (mN·m)")
        self.arrival = _draw_wave(wave, struck)
        artists = [each for wire in reversed(self.wires) for each in wire.artists]
        self.moving = [*artists, self.arrow, *self.hands]

    def move(self, time: float) -> tuple[str, ...]:
        """Move the wires and the arrow of the force to a time from the first touch, s."""
        touch, force = _force(self._runs[0])
        pushed, rigid = (float(np.interp(time, *_force(run), right=0.0)) for run in self._runs)
        wire, _ = lines = [line(time) for line in self._lines]
        for drawing, line in zip(self.wires, lines, strict=True):
            drawing.place(line)
        up = np.array([0.0, self._longest * pushed / force.max()])
        self.arrow.set_offsets(MILLIMETRES * (wire[-1] - up))
        self.arrow.set_UVC(*(MILLIMETRES * up))
        caption = "the bending wave has reached the root"
        if time > touch[-1]:
            caption = "the end has left the workpart"
        elif self._links == 1:
            caption = "the end is in contact"
        elif time < self.arrival:
            caption = "the end is in contact; a bending wave travels to the root"
        readings = (("wire", pushed), ("rigid", rigid))
        return caption, *(f"{name} {signed(value, 1, 5)} N" for name, value in readings)


def _force(run: Any) -> tuple[Array, Array]:
    """Return times since the first touch (s), and a contact's normal force (N) at these times."""
    history = run.contact.history
    clock = history.time - history.time[0]
    time = np.linspace(0.0, clock[-1], GRID)
    return time, cubics(clock, history.normal_force)(time)


def _draw_wave(axes: Axes, struck: FlexibleWire) -> float:
    """Draw a map of the bending moment over time and position along the wire, with the root on top.

    Returns:
        Time at which the bending wave arrives at the hinge nearest to the root, s.
    """
    bristle = struck.strike.tool.bristle
    run = struck.wire
    if bristle.links == 1:
        say(axes, "a rigid bristle does not bend")
        return 0.0
    stiffness = hinge_stiffness(
        bristle.wire_diameter, bristle.length, bristle.modulus, bristle.links
    )
    time = np.linspace(0.0, float(run.time[-1]), GRID)
    moments = 1e3 * stiffness * np.diff(cubics(run.time, run.angles)(time), axis=1).T
    most = float(np.abs(moments).max())
    length = bristle.length * MILLIMETRES
    half = 0.5 * length / bristle.links
    sides = (0.0, float(time[-1]) * MICROSECONDS, length - half, half)
    look: Look = {
        "cmap": "RdBu",
        "norm": CenteredNorm(halfrange=most),
        "interpolation": "bilinear",
    }
    picture = axes.imshow(moments, extent=sides, aspect="auto", **look)
    axes.set_ylim(length, 0.0)
    axes.set(xlabel="time since the first touch (µs)", ylabel="from the root (mm)")
    axes.grid(visible=False)
    scale = axes.inset_axes((1.03, 0.0, 0.03, 1.0))
    axes.figure.colorbar(picture, cax=scale).ax.tick_params(labelsize="x-small")
    return float(time[np.argmax(np.abs(moments[0]) > ARRIVED * most)])
