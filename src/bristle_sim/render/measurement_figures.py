"""Figures that compare simulations with measurements.

They show the rebound of spheres over the angle of incidence, a strike with its high-speed film and
crater, and every estimate of the crater's depth.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.readable import MICROMETRES, MICROSECONDS, MILLIMETRES
from bristle_sim.render.drawing import show_points
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LIGHT,
    VERMILION,
    Look,
    blank_figure,
    draw_zero,
    styled,
    write_key,
)
from bristle_sim.studies.crater_study import MEASURED as MEASURED_DEPTH
from bristle_sim.studies.crater_study import CraterStudy
from bristle_sim.studies.film import FOLLOWED, MEASURED, FilmMap
from bristle_sim.studies.measured_impacts import MEASURED_SPHERES, sphere_rebound

SPHERES = {
    "restitution": "tangential velocity after,\ndivided by that before",
    "spin": "spin after (rad/s)",
    "rebound_angle": "rebound angle (°)",
}


@styled()
def measured_figure(compliance: float) -> Figure:
    """Draw the rebound of spheres over the angle of incidence, as measured and as computed.

    The panels show the ratio of tangential velocities, the spin and the rebound angle. Points are
    measurements. One curve is computed for a contact that is rigid along the surface, the other for
    a contact that is elastic along it. ``compliance`` is the ratio of tangential to normal
    compliance of the elastic contact.
    """
    figure = blank_figure(16.0, 7.2)
    angle = np.linspace(0.5, 62.0, 400)
    rigid, elastic = (sphere_rebound(angle, each) for each in (0.0, compliance))
    for axes, (name, title) in zip(figure.subplots(1, 3), SPHERES.items(), strict=True):
        axes.set(title=title, xlabel="angle of incidence (°)")
        axes.plot(angle, rigid[name], "--", color=VERMILION, label="rigid along the surface")
        axes.plot(angle, elastic[name], color=BLUE, label=f"elastic, η² = {compliance:g}")
        measured = MEASURED_SPHERES[name].T
        axes.plot(*measured, "o", color=BLACK, markersize=3.5, label="measured")
    figure.legend(handles=axes.lines, loc="outside lower center", ncols=3)
    return figure


MAPS = {
    "touches": ("touches within 0.5 ms", 1.0),
    "compression_time": ("first compression (µs)", MICROSECONDS),
    "crater_depth": ("deepest crater (µm)", MICROMETRES),
}
"""Title of each map, and factor from SI units to the unit in the title."""

# Values larger than this multiple of the measured value do not count for the contour. The contour
# would otherwise follow the edge at which the values jump.
MOST_ABOVE = 3.0
SMEAR = 9  # number of positions of the wire that are drawn for one exposure
NEAREST: Look = {"color": BLACK, "marker": "o", "markerfacecolor": "white", "linestyle": ""}
EXPOSED: Look = {"color": BLACK, "linewidth": 3.0}
LOOKS: dict[str, Look] = {
    "measured value (no line: not reached)": {"color": VERMILION},
    "nearest pair": NEAREST,
    "continuous motion": {"color": BLUE},
    "during the camera's exposures": EXPOSED,
}


@styled()
def film_map_figure(film: FilmMap) -> Figure:
    """Draw a comparison of simulated strikes with a high-speed film.

    Maps show the number of touches, the compression time and the crater depth. Panels below them
    show the pass whose results are nearest to the measurements, as the camera would film it.
    """
    figure = blank_figure(16.0, 12.5)
    above, below = figure.subfigures(2, squeeze=False).flat
    maps = above.subplots(1, 3, sharey=True)
    for axes, (name, (title, factor)) in zip(maps, MAPS.items(), strict=True):
        axes.set_title(title)
        _draw_map(axes, film, factor * film.results[name], factor * MEASURED[name])
    maps[0].set_ylabel("damping ratio of the wire")
    frames, height = below.subplots(1, 2)
    exposure = MICROSECONDS * film.grid.exposure
    frames.set_title(f"{film.grid.frame_rate:g} frames per second, exposure {exposure:g} µs")
    frames.set(xlabel="along the workpart (mm)", ylabel="above the hub's axis (mm)")
    height.set_title("height of the tip above the workpart")
    height.set(xlabel="time from the strike (µs)", ylabel="height (mm)")
    _draw_frames(frames, height, film)
    write_key(figure, LOOKS)
    return figure


def _draw_map(axes: Axes, film: FilmMap, values: Array, measured: float) -> None:
    """Draw a map over the contact's duration and the wire's damping ratio.

    The contour is where the values equal the measured value.

    Args:
        axes: axes of the map.
        film: the compared passes.
        values: values of the map, in the unit shown.
        measured: measured value, in the unit shown.
    """
    x, y = (np.arange(each.size) + 0.5 for each in (film.durations, film.dampings))
    axes.grid(visible=False)
    axes.figure.colorbar(axes.pcolormesh(x, y, values, rasterized=True), ax=axes)
    line = np.ma.masked_invalid(np.where(values > MOST_ABOVE * measured, np.nan, values))
    level = 1.5 if measured == 1.0 else measured  # 1.5: between one touch and two
    if line.count() and line.min() < level < line.max():
        axes.contour(x, y, line, levels=[level], colors=VERMILION, linewidths=1.4)
    row, column = film.nearest
    axes.plot(x[column], y[row], **NEAREST)
    across, up = (slice(None, None, -(-size // most)) for size, most in ((x.size, 4), (y.size, 6)))
    axes.set_xticks(x[across], [f"{MICROSECONDS * each:.0f}" for each in film.durations[across]])
    axes.set_yticks(y[up], [f"{each:.2g}" for each in film.dampings[up]])
    axes.set_xlabel("contact duration (µs)")


def _draw_frames(frames: Axes, height: Axes, film: FilmMap) -> None:
    """Draw the wire in the frames of a camera, and the tip's height over time.

    The wire is blurred by its motion during an exposure. The exposures are marked on the curve of
    the height.
    """
    strike = film.run.event_time("strike") or 0.0
    ground = -MILLIMETRES * film.tool.workpart_depth
    exposed = np.add.outer(film.frames, film.grid.exposure * np.linspace(0.0, 1.0, SMEAR))
    shown = film.run.at(exposed)
    wires = MILLIMETRES * shown.centre_line.reshape(-1, *shown.centre_line.shape[2:])
    show_points(frames, [wires, [0.0, ground - 2.0]], 0.03)
    for wire in wires:
        frames.plot(*wire.T, color=BLACK, alpha=1.5 / SMEAR, linewidth=0.8)
    frames.axhspan(2.0 * ground, ground, color=LIGHT, zorder=0)
    time = strike + np.linspace(-FOLLOWED, FOLLOWED, 801)
    tip = MILLIMETRES * film.run.at(time).tip[:, 1] - ground
    height.plot(MICROSECONDS * (time - strike), tip, color=BLUE)
    tips = MILLIMETRES * shown.tip[..., 1] - ground
    height.plot(MICROSECONDS * (exposed - strike).T, tips.T, zorder=3, **EXPOSED)
    draw_zero(height)


@styled()
def crater_figure(study: CraterStudy) -> Figure:
    """Draw all estimates of the crater depth (um) as bars, beside the measured depth."""
    rows = _estimates(study)
    names, depths, colors = zip(*rows, strict=True)
    shown = [MICROMETRES * depth for depth in depths]
    offs = [100.0 * (depth / MEASURED_DEPTH - 1.0) for depth in depths]
    off, nearest = min(zip(offs, names, strict=True), key=lambda each: abs(each[0]))
    figure = blank_figure(16.0, 6.6)
    axes = figure.subplots()
    measured = MICROMETRES * MEASURED_DEPTH
    figure.suptitle(
        f"nearest to the measured depth: {' '.join(nearest.split())},"
        f" {abs(off):.0f} % {'deeper' if off > 0.0 else 'shallower'}"
    )
    axes.set_xlabel(
        f"crater depth (µm); line: measured, {measured:.0f} µm, shaded: within 10 % of it"
    )
    axes.axvspan(0.9 * measured, 1.1 * measured, color=GREY, alpha=0.18, linewidth=0.0)
    axes.axvline(measured, color=BLACK, linewidth=1.2)
    labels = [
        f"{name}: {depth:.0f} µm, {off:+.0f} %".replace("-", "\N{MINUS SIGN}")
        for name, depth, off in zip(names, shown, offs, strict=True)
    ]
    axes.barh(labels, shown, color=colors, alpha=0.55, height=0.6)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    return figure


def _estimates(study: CraterStudy) -> list[tuple[str, float, str]]:
    """Return name, value (m) and colour of each estimate of the crater depth that is drawn.

    The estimate from the sum of work and energy is not drawn. With some millimetres it is far
    larger than the others.
    """
    looks = {
        "merchant_crater_depth": (f"Merchant, {study.crater.plies:g} plies", BLUE),
        "merchant_crater_depth_limit": ("Merchant, limit", BLUE),
        "ratio_of_sums": ("ratio of sums (4.66), 5 plies", GREEN),
        "contact_force_depth": ("simulated force", VERMILION),
        "contact_energy_depth": ("simulated energy", VERMILION),
        "contact_energy_depth_inclined": ("simulated energy,\nshear to the surface", VERMILION),
    }
    return [
        (words, study.depths[name], color)
        for name, (words, color) in looks.items()
        if name in study.depths
    ]
