"""Draw single impacts on a page each: the impulse plane of the impact at hand, and the families that it belongs to."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREY, VERMILION
from bristle_sim.render.panels import add_panel, draw_panel, explain_marks, name_curves, note, say
from bristle_sim.render.style import blank_figure, scale_for, styled
from bristle_sim.studies.curves import Panel
from bristle_sim.studies.impacts import Impacts
from bristle_sim.studies.impulse_course import ImpulseCourse, energetic_course, recorded_course
from bristle_sim.studies.law_convergence import EngineEnergy

WIDTH, HEIGHT, LEFT, RIGHT, LOWER, UPPER = 6.2, 4.9, 1.5, 9.5, 1.9, 9.0
"""Width and height of a panel, and where the columns and rows of panels begin, cm."""

HAND, OPERATING_POINT = "the impact at hand", "operating point"


PHASE_COLOURS = {
    "compression slip": "#e6eef6",
    "compression reverse slip": "#d3e2f0",
    "compression stick": "#dadde6",
    "restitution slip": "#eff5e8",
    "restitution reverse slip": "#e0ecd2",
    "restitution stick": "#e7e7df",
}

NARROW = 0.09
"""A phase that takes less than this fraction of the panel is not named in it."""

LINES = (("$v_t$", VERMILION, "tangential_velocity"), ("$v_n$", BLUE, "normal_velocity"))


@styled()
def oblique_figure(impacts: Impacts, panels: Mapping[str, Panel]) -> Figure:
    """Draw a radial bristle's strike: impulse plane, rebound ratio (fig. 2.24), final impulse (figs. 2.22, 2.23)."""
    figure = _with_plane(impacts)
    _draw_rebound(figure, (RIGHT, UPPER), impacts, panels.get("rebound over angle"))
    _draw_family(figure, (LEFT, LOWER), "final impulse, by impact angle", panels["impulse by angle"])
    _draw_family(figure, (RIGHT, LOWER), "final impulse, by restitution", panels["impulse by restitution"])
    explain_marks(figure, "energetic", "compliant", HAND)
    return figure


@styled()
def single_pendulum_figure(impacts: Impacts, panels: Mapping[str, Panel]) -> Figure:
    """Draw Stronge's single pendulum: impulse plane, and rebound ratio over angle (fig. 2.26) and friction."""
    figure = _with_plane(impacts, RIGHT + WIDTH - LEFT)
    _draw_rebound(figure, (LEFT, LOWER), impacts, panels.get("rebound over angle"))
    _draw_family(figure, (RIGHT, LOWER), "rebound ratio over friction", panels.get("rebound over friction"))
    explain_marks(figure, "energetic", "compliant", HAND)
    return figure


@styled()
def double_pendulum_figure(impacts: Impacts, panels: Mapping[str, Panel], energy: EngineEnergy | None) -> Figure:
    """Draw Stronge's double pendulum: impulse plane, rates (figs. 2.28, 2.29), impulse (fig. 2.30), the engine's energy.

    ``energy`` is None for a pendulum at rest before the impact.
    """
    figure = _with_plane(impacts)
    title = "final rates over the ratio of masses"
    rates = _draw_family(figure, (RIGHT, UPPER), title, panels["rates over mass ratio"])
    rates.xaxis.set_major_formatter("{x:g}")
    title = "the bristle as a double pendulum (fig. 2.30)"
    _draw_family(figure, (LEFT, LOWER), title, panels["heavy rod"], OPERATING_POINT)
    place = (RIGHT, LOWER, WIDTH, HEIGHT)
    energies = add_panel(figure, place, "the engine's own contact: its energy", _coefficients(impacts))
    if energy is None:
        say(energies, "at rest: no energy to compare")
    else:
        _draw_energy(energies, energy)
    explain_marks(figure, "energetic", "compliant", HAND, OPERATING_POINT)
    return figure


def _with_plane(impacts: Impacts, width: float = WIDTH) -> Figure:
    """Return a page with the impulse plane in its upper left corner."""
    figure = blank_figure(16.0, 15.2)
    axes = add_panel(figure, (LEFT, UPPER, width, HEIGHT), "the impact at hand", _coefficients(impacts))
    resolved = impacts.strikes.get("compliant")
    history = None if resolved is None else resolved.contact.history
    recorded = None if history is None else recorded_course(history)
    _draw_impulse_plane(axes, energetic_course(impacts.chain, impacts.surface), recorded)
    return figure


def _coefficients(impacts: Impacts) -> str:
    """Write angles and coefficients of the impact at hand."""
    surface = impacts.surface
    angles = ", ".join(f"{math.degrees(-angle):.4g}°" for angle in impacts.chain.angles)
    later = "" if surface.restitution_friction is None else f" (restitution {surface.restitution_friction:.4g})"
    return f"{angles} to the normal, μ = {surface.friction:.4g}{later}, e* = {surface.restitution:.4g}"


def _draw_family(figure: Figure, corner: tuple[float, float], title: str, panel: Panel | None, own: str = HAND) -> Axes:
    """Draw a family, its curves named above it and its levels in it, impulses in a readable unit; or say that it has none."""
    axes = add_panel(figure, (*corner, WIDTH, HEIGHT), title)
    if panel is None:
        say(axes, "at rest before the impact: no ratio")
        return axes
    y = panel.y
    if y.unit.endswith("N·s"):
        scale = scale_for(panel.top or max(float(np.abs(curve.theory).max()) for curve in panel.curves), "N·s")
        y = dataclasses.replace(y, unit=scale.unit, factor=scale.factor)
    draw_panel(axes, dataclasses.replace(panel, y=y), own)
    name_curves(axes, panel)
    lowest, highest = axes.get_ylim()
    for level in panel.levels:
        if level.upright:
            axes.set_ylim(lowest, highest + 0.12 * (highest - lowest))
            box = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}
            words, corner = f"dashed: {level.label}", (1.0, 1.0)
            note(axes, words, corner, (-2.0, -3.0), bbox=box, xycoords="axes fraction", ha="right", va="top")
        else:
            up, va = (-3.0, "top") if level.value > lowest else (3.0, "bottom")
            note(axes, level.label, (float(panel.curves[0].x[-1]), level.value), (0.0, up), ha="right", va=va)
    return axes


def _draw_rebound(figure: Figure, corner: tuple[float, float], impacts: Impacts, panel: Panel | None) -> None:
    """Draw the rebound ratio over the impact angle, with a note where curves are flat."""
    axes = _draw_family(figure, corner, "rebound ratio over the impact angle", panel)
    if panel is None:
        return
    axes.set_xlim(0.0, 90.0)
    rod = impacts.chain
    rest = -rod.hub_radius * rod.hub_speed / (rod.lengths[0] * rod.rates[0])
    if any(np.isclose(curve.theory, rest, atol=1e-9).any() for curve in panel.curves):
        bottom, top = axes.get_ylim()
        axes.set_ylim(bottom, top + 0.07 * (top - bottom))
        note(axes, "flat: stiction, the tip comes to rest", (90.0, rest), (-2.0, 3.0), ha="right", va="bottom")


def _draw_energy(axes: Axes, energy: EngineEnergy) -> None:
    """Draw kinetic energy after over before, over the iterations of the engine's solver; beyond 1 energy is created."""
    top = 1.15 * max(1.3, float(energy.engine.max()))
    axes.axhspan(1.0, top, color="#fbe3d6", linewidth=0.0, zorder=0)
    axes.axhline(energy.energetic, color=BLUE, gid="energetic")
    axes.semilogx(energy.iterations, energy.engine, "o-", color=VERMILION, markersize=3.2, gid="engine")
    axes.axvline(10.0, color=GREY, linewidth=0.7, dashes=(2, 2), zorder=1)
    axes.set_ylim(0.0, top)
    right = float(energy.iterations[-1])
    note(axes, "energy created", (right, 1.0), (0.0, 3.0), ha="right", va="bottom", color=BLACK)
    note(axes, "energetic law", (right, energy.energetic), (0.0, -3.0), ha="right", va="top", color=BLUE)
    note(axes, "engine's own contact", (10.0, 0.9 * top), (4.0, 0.0), va="center", color=VERMILION)
    note(axes, "engine's default", (10.0, 0.03 * top), (4.0, 0.0))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set(xlabel="iterations of the engine's solver", ylabel="kinetic energy, after / before")


def _draw_impulse_plane(axes: Axes, course: ImpulseCourse, recorded: ImpulseCourse | None) -> None:
    """Draw the energetic law's straight pieces, shaded by phases, with a contact resolved in time as points on them."""
    last = float(course.impulse[-1])
    fastest = float(np.abs([course.normal_velocity, course.tangential_velocity]).max())
    impulse, speed = scale_for(last, "N·s"), scale_for(fastest, "m/s")
    axes.set(xlabel=f"normal impulse p ({impulse.unit})", ylabel=f"velocity of the tip ({speed.unit})")
    if course.impulse.size < 2:
        say(axes, "the tip does not approach: no contact")
        return
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    for name, color, which in LINES:
        place, values = course.impulse * impulse.factor, getattr(course, which) * speed.factor
        axes.plot(place, values, color=color, gid=which)
        # Named on the side of the line that is away from zero.
        quarter, side = 0.25 * float(place[1]), -1.0 if values[0] < 0.0 else 1.0
        look: dict[str, Any] = {"color": color, "fontsize": 9.0, "va": "top" if side < 0.0 else "bottom"}
        note(axes, name, (quarter, float(np.interp(quarter, place, values))), (3.0, 3.0 * side), **look)
        if recorded is not None:  # up to the energetic law's impulse: a tip in stiction stays pressed on
            shown = recorded.impulse <= 1.01 * last
            points = (recorded.impulse[shown] * impulse.factor, getattr(recorded, which)[shown] * speed.factor)
            look = {"markersize": 3.6, "markeredgewidth": 0.8, "zorder": 3, "clip_on": False}
            axes.plot(*points, "x", color=BLACK, gid=f"{which}, resolved in time", **look)
    bottom, top = axes.get_ylim()
    axes.set_xlim(0.0, 1.03 * last * impulse.factor)
    axes.set_ylim(bottom - 0.06 * (top - bottom), top + 0.24 * (top - bottom))  # room for names above and below
    _shade_phases(axes, course, impulse.factor)
    _mark_impulses(axes, course, impulse.factor)


def _shade_phases(axes: Axes, course: ImpulseCourse, factor: float) -> None:
    """Shade the phases and write compression or restitution above, and slip or stick below that."""
    ends = (course.impulse * factor).tolist()
    halves: dict[str, tuple[float, float]] = {}
    for name, start, end in zip(course.phases, ends, ends[1:], strict=False):
        axes.axvspan(start, end, color=PHASE_COLOURS[name], linewidth=0.0, zorder=0, gid=name)
        half, motion = name.split(" ", 1)
        halves[half] = (halves.get(half, (start, end))[0], end)
        narrow = end - start < 0.25 * ends[-1]
        _write_above(axes, 0.89, motion.replace(" ", "\n") if narrow else motion, start, end)
    for half, (start, end) in halves.items():
        _write_above(axes, 0.97, half, start, end, weight="bold")


def _write_above(axes: Axes, height: float, words: str, start: float, end: float, **look: Any) -> None:
    """Write words centred over a phase, unless it is too narrow for any."""
    if end - start >= NARROW * axes.get_xlim()[1]:
        look |= {"transform": axes.get_xaxis_transform(), "ha": "center", "va": "top", "fontsize": 7.0}
        axes.text(0.5 * (start + end), height, words, linespacing=1.05, **look)


def _mark_impulses(axes: Axes, course: ImpulseCourse, factor: float) -> None:
    """Draw dashed lines at p_c, p_s and p_f; those that fall together share a name."""
    marks: dict[float, list[str]] = {}
    last = float(course.impulse[-1])
    for name, place in (("p_c", course.compression_end), ("p_s", course.slip_stop), ("p_f", last)):
        if 0.0 < place < math.inf:
            near = next((other for other in marks if abs(other - place) < 0.02 * last), place)
            marks.setdefault(near, []).append(name)
    for place, names in marks.items():
        # Slip may stop within compression or restitution, whose names stand above.
        look: dict[str, Any] = {
            "linewidth": 0.7,
            "dashes": (4, 2),
            "zorder": 1,
            "ymax": 0.8 if names == ["p_s"] else 1.0,
        }
        axes.axvline(place * factor, color=BLACK, gid=" ".join(names), **look)
        foot: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "ha": "right", "color": BLACK, "fontsize": 8.0}
        note(axes, f"${' = '.join(names)}$", (place * factor, 0.03), (-3.0, 0.0), **foot)
