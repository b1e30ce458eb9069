"""Figure and film of the strike of a wire that bends, compared with a rigid bristle.

They show the contact force, quantities of the strike, and the bending wave in the wire.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bristle_sim.arrays import Array
from bristle_sim.render import style
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION
from bristle_sim.render.drawing import (
    WireDrawing,
    close_up,
    draw_film_tool,
    moving_arrow,
    point_arrow,
)
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.studies.flexible_wire import FlexibleWire, measures
from bristle_sim.studies.timed_contact import cubics
from bristle_sim.studies.wire_study import WireStudy
from bristle_sim.theory.wire import hinge_stiffness

LOOKS = {
    "normal_final_impulse": ("impulse", BLUE, "o"),
    "peak_force": ("peak force", VERMILION, "s"),
    "time_in_touch": ("duration", GREEN, "^"),
    "crater_depth": ("crater", PURPLE, "D"),
}
"""Label, colour and marker of each quantity of a strike."""

LINK_COLOURS = (ORANGE, GREEN, BLUE)


@style.styled()
def wire_figure(struck: FlexibleWire, study: WireStudy) -> Figure:
    """Draw the contact force of one strike of a bending wire, and quantities of many strikes.

    The quantities are impulse, peak force, duration and crater depth, over the contact's duration
    and over the number of links that model the wire.
    """
    figure = style.blank_figure(16.0, 13.6)
    size = (6.3, 4.6)
    _draw_force(figure, struck)
    by_links = style.add_panel(figure, (9.4, 8.1, 6.3, 4.2), "measures over the number of links")
    impulse = style.add_panel(figure, (1.4, 1.2, *size), "impulse over the contact's duration")
    others = style.add_panel(figure, (9.4, 1.2, *size), "measures over the contact's duration")
    durations = study.durations * style.MICROSECONDS
    most = max(study.by_duration)
    for name, (words, color, marker) in LOOKS.items():
        look: dict[str, Any] = {"color": color, "marker": marker, "markersize": 3.4, "label": words}
        by_links.plot(study.links, study.by_links[name], **look, linestyle="none")
        others.plot(durations, study.by_duration[most][name], **look)
    for color, (links, found) in zip(
        LINK_COLOURS[-len(study.by_duration) :], study.by_duration.items(), strict=True
    ):
        ratio = found["normal_final_impulse"]
        impulse.plot(durations, ratio, "o-", color=color, markersize=3.0, label=f"{links} links")
    own = struck.strike.contact.duration * style.MICROSECONDS
    for axes in (impulse, others):
        axes.set(xscale="log", xlabel="contact of the rigid bristle, $T$ (µs)")
        axes.xaxis.set_major_formatter("{x:g}")
        if axes.get_xlim()[0] < own < axes.get_xlim()[1]:
            axes.axvline(own, color=BLACK, linewidth=0.8, dashes=(2, 2), zorder=1)
            style.note(axes, "as in a, b", (own, 0.0), (3.0, 5.0), color=BLACK)
    by_links.set(xlabel="number of links", ylabel="wire / rigid bristle")
    impulse.set_ylabel("impulse, wire / rigid bristle")
    others.set_ylabel(f"wire of {most} links / rigid bristle")
    by_links.xaxis.set_major_locator(MaxNLocator(integer=True))
    for axes in (by_links, impulse, others):
        axes.axhline(1.0, color=GREY, linewidth=0.8, dashes=(4, 2), zorder=1)
        axes.set_ylim(bottom=0.0)
        place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (-0.05, 0.985), "ncols": 4}
        axes.legend(**place, handlelength=1.0, handletextpad=0.4, columnspacing=0.8)
    return figure


def _draw_force(figure: Figure, struck: FlexibleWire) -> None:
    rigid, own = (measures(struck.strike, each.contact) for each in (struck.rigid, struck.wire))
    times = rigid["peak_force"] / own["peak_force"]
    axes = style.add_panel(
        figure, (1.4, 8.1, 6.3, 4.2), f"the rigid bristle pushes {times:.2g} times as hard"
    )
    clock = style.scale_for(max(rigid["time_in_touch"], own["time_in_touch"]), "s")
    names = ("rigid bristle", f"wire of {struck.strike.tool.bristle.links} links")
    for run, color, name, values in zip(
        (struck.rigid, struck.wire), (GREY, BLUE), names, (rigid, own), strict=True
    ):
        shown = style.scale_for(values["normal_final_impulse"], "N·s")
        label = f"{name}, {values['normal_final_impulse'] * shown.factor:.3g} {shown.unit}"
        time, force = _force(run)
        axes.fill_between(time * clock.factor, force, color=color, alpha=0.12, linewidth=0.0)
        axes.plot(time * clock.factor, force, color=color, label=label)
    axes.set(xlabel=f"time since the first touch ({clock.unit})", ylabel="normal force (N)")
    axes.set_xlim(left=0.0)
    axes.set_ylim(0.0, 1.3 * max(rigid["peak_force"], own["peak_force"]))
    axes.legend(loc="upper right", labelspacing=0.3)


LONGEST_FORCE = 0.22  # length of the arrow of the largest force, over the height of the drawn wires
# The bending wave has arrived when the moment at the hinge next to the root exceeds this fraction of
# the largest moment.
ARRIVED = 0.1
GRID = 400  # number of instants of the force curves and of the map of bending moments


class WireFilm(Film):
    """Film of a bending wire's strike, from the first touch until the bending wave has returned."""

    size = (960, 540)
    letter_size = 15.0

    @style.styled()
    def __init__(
        self, struck: FlexibleWire, *, width: int = 960, height: int = 540, duration: float = 12.0
    ) -> None:
        warp = slow_motion(0.0, float(struck.wire.time[-1]), duration)
        super().__init__(warp, width, height, (BLUE, ORANGE), style.Scale(style.MICROSECONDS, "µs"))
        self.struck = struck
        small = 0.62 * self.letters
        self._draw_wires(self.figure.add_axes((0.0, 0.0, 0.5, 1.0 - HEADER)), small)
        force = self.add_timeline((0.565, 0.55, 0.35, 0.4 - HEADER), 0.9 * small)
        wave = self.add_timeline((0.565, 0.115, 0.35, 0.3), 0.9 * small)
        for (touch, pushed), color in ((_force(struck.rigid), ORANGE), (_force(struck.wire), BLUE)):
            force.fill_between(
                touch * style.MICROSECONDS, pushed, color=color, alpha=0.15, linewidth=0.0
            )
            force.plot(touch * style.MICROSECONDS, pushed, color=color, linewidth=1.8)
        force.set_ylim(bottom=0.0)
        force.set_title("normal force (N)", loc="left", fontsize=small)
        wave.set_title("bending moment along the wire (mN·m)", loc="left", fontsize=small)
        self.arrival = _draw_wave(wave, struck, small)
        self.moving = [*self.rigid.artists, *self.wire.artists, self.arrow, *self.hands]

    def move(self, time: float) -> tuple[str, ...]:
        """Move wires and the arrow of the force to a time, s."""
        touch, force = _force(self.struck.wire)
        pushed = float(np.interp(time, touch, force, right=0.0))
        rigid = float(np.interp(time, *_force(self.struck.rigid), right=0.0))
        self.rigid.place(_centre_line(self.struck.rigid, time))
        self.wire.place(line := _centre_line(self.struck.wire, time))
        x, y = (line[-1] * style.MILLIMETRES).tolist()
        point_arrow(self.arrow, (x, y - self.longest * pushed / force.max()), (x, y), shortest=0.3)
        caption = "the wave is at the root"
        if time > touch[-1]:
            caption = "released, the wire swings on"
        elif self.struck.strike.tool.bristle.links == 1:
            caption = "the end is struck"
        elif time < self.arrival:
            caption = "the end is struck; the wave is on its way to the root"
        return (
            caption,
            f"wire {style.signed(pushed, 1, 5)} N",
            f"rigid {style.signed(rigid, 1, 5)} N",
        )

    def _draw_wires(self, axes: Axes, letters: float) -> None:
        tool = self.struck.strike.tool
        box = axes.get_window_extent()
        runs = (self.struck.wire, self.struck.rigid)
        points = np.concatenate([np.reshape(run.centre_line, (-1, 2)) for run in runs])
        span = float(np.ptp(points[:, 1]))
        links = tool.bristle.links
        self.longest = LONGEST_FORCE * span * style.MILLIMETRES
        below = points.min(axis=0) - [0.0, LONGEST_FORCE * span]
        draw_film_tool(
            axes,
            tool,
            close_up(np.vstack([points, below]), tool, box.width / box.height, 0.1),
            letters,
        )
        self.rigid, self.wire = (WireDrawing(axes, tool, color=color) for color in (ORANGE, BLUE))
        self.arrow = moving_arrow(axes, VERMILION, 2.5, 14.0)
        wire = f"wire of {links} link{'s' * (links > 1)}"
        named = {"rigid bristle": ORANGE, wire: BLUE, "normal force on its end": VERMILION}
        looks = {name: {"color": color, "linewidth": 2.5} for name, color in named.items()}
        style.write_key(axes, looks, loc="upper left", ncols=1, fontsize=letters, borderaxespad=1.0)


def _force(run: Any) -> tuple[Array, Array]:
    """Return the times from the first touch, s, and the normal forces, N, of a run's contact."""
    history = run.contact.history
    clock = history.time - history.time[0]
    time = np.linspace(0.0, clock[-1], GRID)
    return time, cubics(clock, history.normal_force)(time)


def _centre_line(run: Any, time: float) -> Array:
    """Return root, hinges and tip of the wire at a time, m, by linear interpolation in time."""
    columns = run.centre_line.reshape(run.time.size, -1).T
    return np.reshape([np.interp(time, run.time, column) for column in columns], (-1, 2))


def _draw_wave(axes: Axes, struck: FlexibleWire, letters: float) -> float:
    """Draw the bending moment in the wire over time and position, with the root on top.

    Returns:
        Time at which the bending wave arrives at the hinge next to the root, s.
    """
    bristle = struck.strike.tool.bristle
    run = struck.wire
    time = np.linspace(0.0, run.time[-1], GRID)
    bends = np.diff(run.angles, axis=1).T
    if not bends.size:
        style.say(axes, "a rigid bristle does not bend")
        return 0.0
    stiffness = hinge_stiffness(
        bristle.wire_diameter, bristle.length, bristle.modulus, bristle.links
    )
    moments = stiffness * np.array([np.interp(time, run.time, each) for each in bends])
    length = bristle.length * style.MILLIMETRES
    most = float(np.abs(moments).max())
    half = 0.5 * length / (len(moments) + 1)
    sides = (0.0, float(time[-1]) * style.MICROSECONDS, length - half, half)
    look: dict[str, Any] = {
        "cmap": "RdBu",
        "vmin": -1e3 * most,
        "vmax": 1e3 * most,
        "aspect": "auto",
    }
    picture = axes.imshow(1e3 * moments, extent=sides, interpolation="bilinear", **look)
    axes.set_ylim(length, 0.0)
    axes.set_xlabel("time since the first touch (µs)", fontsize=letters)
    axes.set_ylabel("from the root (mm)", fontsize=letters)
    axes.grid(visible=False)
    style.add_colour_bar(axes, picture, "neither").tick_params(labelsize="x-small")
    return float(time[np.argmax(np.abs(moments[0]) > ARRIVED * most)])
