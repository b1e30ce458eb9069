"""Draw the strike over contact stiffness and wire damping with the measured values as lines, and the pass as a camera sees it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.render.colours import BLACK, BLUE, GREY, LIGHT, VERMILION
from bristle_sim.render.drawing import View
from bristle_sim.render.style import MICROSECONDS, MILLIMETRES, add_panel, blank_figure, styled
from bristle_sim.studies.film import FOLLOWED, MEASURED, FilmMap

PANELS = {
    "touches": ("touches", "within 0.5 ms", 1.0),
    "compression_time": ("compression (µs)", "of the first touch", MICROSECONDS),
    "crater_depth": ("crater (µm)", "the deepest", 1e6),
}
"""Title, note and factor of each map."""

JUMP = 3.0  # values above this multiple of the measured one take no part in its line, which would else follow a jump
NEAREST: dict[str, Any] = {
    "color": BLACK,
    "marker": "o",
    "markerfacecolor": "white",
    "markersize": 5.0,
    "linestyle": "",
}
SMEAR = 9  # places of the wire in an exposure


@styled()
def film_map_figure(film: FilmMap) -> Figure:
    """Draw touches, compression time and crater depth over both unknowns; below, frames of the nearest pass and its motion."""
    figure = blank_figure(16.0, 14.0)
    for number, name in enumerate(PANELS):
        _draw_map(figure, film, name, 1.6 + 4.9 * number)
    rate, exposure = f"{film.grid.frame_rate:g} frames a second", f"{MICROSECONDS * film.grid.exposure:g} µs"
    frames = add_panel(figure, (1.5, 1.9, 6.4, 4.4), "the nearest pass, filmed", f"{rate}, exposure {exposure}")
    words = "continuous, and in the camera's frames"
    height = add_panel(figure, (9.6, 1.9, 5.9, 4.4), "the tip over the workpart", words)
    _draw_frames(frames, height, film)
    named: dict[str, dict[str, Any]] = {
        "as measured (none: not reached)": {"color": VERMILION},
        "nearest pair": NEAREST,
        "continuous motion": {"color": BLUE},
        "in the camera's exposures": {"color": BLACK, "linewidth": 3.0},
    }
    handles = [Line2D([], [], label=name, **look) for name, look in named.items()]
    figure.legend(handles=handles, loc="lower center", ncols=4, columnspacing=1.2)
    return figure


def _draw_map(figure: Figure, film: FilmMap, name: str, left: float) -> None:
    title, words, factor = PANELS[name]
    axes = add_panel(figure, (left, 8.6, 3.4, 3.7), title, words)
    values, measured, (row, column) = factor * film.results[name], factor * MEASURED[name], film.nearest
    axes.grid(visible=False)
    image = axes.pcolormesh(values, cmap="viridis", rasterized=True)
    _, bottom, width, height = axes.get_position().bounds
    scale = figure.add_axes((axes.get_position().x1 + 0.04 * width, bottom, 0.05 * width, height))
    figure.colorbar(image, cax=scale).ax.tick_params(labelsize=6.0, colors=GREY)
    x, y = (np.arange(each.size) + 0.5 for each in (film.durations, film.dampings))
    line = np.ma.masked_invalid(np.where(values > JUMP * measured, np.nan, values))
    level = 1.5 if name == "touches" else measured
    if line.count() and line.min() < level < line.max():
        axes.contour(x, y, line, levels=[level], colors=[VERMILION], linewidths=1.4)
    axes.plot(x[column], y[row], **NEAREST)
    shown = np.unique(np.linspace(0, x.size - 1, 3).round().astype(int))
    axes.set_xticks(x[shown], [f"{MICROSECONDS * film.durations[at]:.0f}" for at in shown])
    at = np.unique(np.linspace(0, y.size - 1, 6).round().astype(int))
    axes.set_yticks(y[at], [f"{film.dampings[each]:.2g}" if left < 2.0 else "" for each in at])
    axes.set(xlabel="contact duration (µs)", ylabel="damping ratio of the wire" if left < 2.0 else "")


def _draw_frames(frames: Axes, height: Axes, film: FilmMap) -> None:
    """Draw the wire smeared over each exposure, and the tip's height with the instants that the frames see."""
    strike, ground = film.run.event_time("strike") or 0.0, -MILLIMETRES * film.tool.workpart_depth
    lines = []
    for opened in film.frames:
        during = opened + film.grid.exposure * np.linspace(0.0, 1.0, SMEAR)
        wires = MILLIMETRES * film.run.at(during).centre_line
        lines.append(wires)
        for wire in wires:
            frames.plot(*wire.T, color=BLACK, alpha=1.5 / SMEAR, linewidth=0.8)
        height.plot(MICROSECONDS * (during - strike), wires[:, -1, 1] - ground, color=BLACK, linewidth=3.0, zorder=3)
    View.around([np.array(lines), np.array([[0.0, ground - 2.0]])], 6.4 / 4.4, 0.03).apply(frames)
    frames.axhspan(frames.get_ylim()[0], ground, color=LIGHT, zorder=0)
    frames.set(xlabel="along the workpart (mm)", ylabel="above the hub's axis (mm)")
    time = strike + np.linspace(-FOLLOWED, FOLLOWED, 801)
    height.plot(MICROSECONDS * (time - strike), MILLIMETRES * film.run.at(time).tip[:, 1] - ground, color=BLUE)
    height.axhline(0.0, color=GREY, linewidth=0.8)
    height.set(xlabel="time from the strike (µs)", ylabel="height (mm)")
