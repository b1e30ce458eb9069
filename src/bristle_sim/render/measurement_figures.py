"""Figures that compare simulations with measurements.

They show the rebound of spheres over the angle of incidence, and a strike with its high-speed film
and crater.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREY, LIGHT, VERMILION
from bristle_sim.render.drawing import show_points
from bristle_sim.render.style import (
    MICROSECONDS,
    MILLIMETRES,
    Look,
    add_panel,
    blank_figure,
    draw_colours,
    styled,
    write_key,
)
from bristle_sim.studies.film import FOLLOWED, MEASURED, FilmMap
from bristle_sim.studies.measured_impacts import MEASURED_SPHERES, sphere_rebound

SPHERES = {
    "restitution": ("tangential velocity", "after over before"),
    "spin": ("spin (rad/s)", "after"),
    "rebound_angle": ("rebound angle (°)", "after"),
}


@styled()
def measured_figure(compliance: float) -> Figure:
    """Draw velocity ratio, spin and rebound angle of spheres over the angle of incidence.

    Points are measured. Curves are the law of impact for a contact that is rigid along the surface,
    and for one whose ratio of tangential to normal compliance is ``compliance``.
    """
    figure = blank_figure(16.0, 7.6)
    angle = np.linspace(0.5, 62.0, 400)
    for place, (name, (title, words)) in enumerate(SPHERES.items()):
        axes = add_panel(figure, (1.3 + 5.1 * place, 1.9, 3.9, 4.4), title, words)
        axes.set_xlabel("angle of incidence (°)")
        rigid, elastic = (sphere_rebound(angle, each)[name] for each in (0.0, compliance))
        axes.plot(angle, rigid, "--", color=VERMILION, label="rigid along the surface")
        axes.plot(angle, elastic, color=BLUE, label=f"elastic, η² = {compliance:g}")
        measured = MEASURED_SPHERES[name].T
        axes.plot(*measured, "o", color=BLACK, markersize=3.5, label="measured")
    figure.legend(handles=axes.lines, loc="lower center", ncols=3)
    return figure


MAPS = {
    "touches": ("touches", "within 0.5 ms", 1.0),
    "compression_time": ("compression (µs)", "of the first touch", MICROSECONDS),
    "crater_depth": ("crater (µm)", "the deepest", 1e6),
}
"""Title, note and conversion factor of each map."""

# Values larger than this multiple of the measured one are left out of the contour, which would follow
# their jump.
MOST_ABOVE = 3.0
SMEAR = 9  # number of positions of the wire that are drawn for one exposure
LOOKS: dict[str, Look] = {
    "as measured (none: not reached)": {"color": VERMILION, "linewidth": 1.4},
    "nearest pair": {
        "color": BLACK,
        "marker": "o",
        "markerfacecolor": "white",
        "markersize": 5.0,
        "linestyle": "",
    },
    "continuous motion": {"color": BLUE},
    "in the camera's exposures": {"color": BLACK, "linewidth": 3.0},
}
_, NEAREST, MOTION, EXPOSED = LOOKS.values()


@styled()
def film_map_figure(film: FilmMap) -> Figure:
    """Draw maps of the number of touches, the compression time and the crater depth.

    Panels below show the pass that is nearest to the measurement, as a high-speed camera films it.
    """
    figure = blank_figure(16.0, 14.0)
    for number, (name, (title, words, _)) in enumerate(MAPS.items()):
        axes = add_panel(figure, (1.6 + 4.9 * number, 8.6, 3.4, 3.7), title, words)
        _draw_map(axes, film, name, first=number == 0)
    rate = f"{film.grid.frame_rate:g} frames a second"
    exposure = f"{MICROSECONDS * film.grid.exposure:g} µs"
    frames = add_panel(
        figure, (1.5, 1.9, 6.4, 4.4), "the nearest pass, filmed", f"{rate}, exposure {exposure}"
    )
    words = "continuous, and in the camera's frames"
    height = add_panel(figure, (9.6, 1.9, 5.9, 4.4), "the tip over the workpart", words)
    _draw_frames(frames, height, film)
    write_key(figure, LOOKS, columnspacing=1.2)
    return figure


def _draw_map(axes: Axes, film: FilmMap, name: str, *, first: bool) -> None:
    factor = MAPS[name][2]
    values = factor * film.results[name]
    measured = factor * MEASURED[name]
    x, y = (np.arange(each.size) + 0.5 for each in (film.durations, film.dampings))
    draw_colours(axes, x, y, values)
    line = np.ma.masked_invalid(np.where(values > MOST_ABOVE * measured, np.nan, values))
    level = 1.5 if name == "touches" else measured
    if line.count() and line.min() < level < line.max():
        axes.contour(x, y, line, levels=[level], colors=VERMILION, linewidths=1.4)
    row, column = film.nearest
    axes.plot(x[column], y[row], **NEAREST)
    across, up = (
        np.unique(np.linspace(0, each.size - 1, most).round().astype(int))
        for each, most in ((x, 3), (y, 6))
    )
    axes.set_xticks(x[across], [f"{MICROSECONDS * each:.0f}" for each in film.durations[across]])
    axes.set_yticks(y[up], [f"{each:.2g}" * first for each in film.dampings[up]])
    axes.set(xlabel="contact duration (µs)", ylabel="damping ratio of the wire" * first)


def _draw_frames(frames: Axes, height: Axes, film: FilmMap) -> None:
    """Draw the camera's frames of the wire, blurred by the exposure, and the tip's height over
    time.

    The exposures are marked in the curve of the height.
    """
    strike = film.run.event_time("strike") or 0.0
    ground = -MILLIMETRES * film.tool.workpart_depth
    lines = []
    for opened in film.frames:
        during = opened + film.grid.exposure * np.linspace(0.0, 1.0, SMEAR)
        lines.append(MILLIMETRES * film.run.at(during).centre_line)
        for wire in lines[-1]:
            frames.plot(*wire.T, color=BLACK, alpha=1.5 / SMEAR, linewidth=0.8)
        height.plot(
            MICROSECONDS * (during - strike), lines[-1][:, -1, 1] - ground, zorder=3, **EXPOSED
        )
    show_points(frames, [np.array(lines), [0.0, ground - 2.0]], 0.03)
    frames.axhspan(frames.get_ylim()[0], ground, color=LIGHT, zorder=0)
    frames.set(xlabel="along the workpart (mm)", ylabel="above the hub's axis (mm)")
    time = strike + np.linspace(-FOLLOWED, FOLLOWED, 801)
    height.plot(
        MICROSECONDS * (time - strike), MILLIMETRES * film.run.at(time).tip[:, 1] - ground, **MOTION
    )
    height.axhline(0.0, color=GREY, linewidth=0.8)
    height.set(xlabel="time from the strike (µs)", ylabel="height (mm)")
