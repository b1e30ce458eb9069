"""Draw a single impact: velocities of the tip over the normal impulse, by the energetic law and in time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREY, VERMILION
from bristle_sim.render.style import add_panel, blank_figure, note, say, scale_for, styled
from bristle_sim.studies.impacts import Impacts
from bristle_sim.studies.impulse_course import ImpulseCourse, energetic_course, recorded_course

LEFT, FOOT, WIDTH, HEIGHT = 1.45, 1.9, 13.4, 4.9  # left and lower edge, width and height of the panel, cm
PHASE_COLOURS = {
    "compression slip": "#e6eef6", "compression reverse slip": "#d3e2f0", "compression stick": "#dadde6",
    "restitution slip": "#eff5e8", "restitution reverse slip": "#e0ecd2", "restitution stick": "#e7e7df",
}  # fmt: skip
NARROW = 0.09  # a phase that takes less than this fraction of the panel is not named in it
LINES = (("$v_t$", VERMILION, "tangential_velocity"), ("$v_n$", BLUE, "normal_velocity"))


@styled()
def impact_figure(impacts: Impacts) -> Figure:
    """Draw an impact on the impulse plane, phase by phase."""
    figure, surface = blank_figure(16.0, 8.0), impacts.surface
    angles = ", ".join(f"{math.degrees(-angle):.4g}°" for angle in impacts.chain.angles)
    later = "" if surface.restitution_friction is None else f", μ₂ = {surface.restitution_friction:.4g}"
    words = f"{angles} to the normal, μ = {surface.friction:.4g}{later}, e* = {surface.restitution:.4g}"
    if impacts.elastic:
        words += "; lines: rigid along the surface, crosses: elastic, in time"
    axes = add_panel(figure, (LEFT, FOOT, WIDTH, HEIGHT), "the impact over its normal impulse", words)
    resolved = impacts.strikes.get("compliant")
    history = None if resolved is None else resolved.contact.history
    recorded = None if history is None else recorded_course(history)
    _draw_impulse_plane(axes, energetic_course(impacts.chain, surface), recorded)
    return figure


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
        axes.axvspan(start, end, color=PHASE_COLOURS[name], linewidth=0.0, zorder=0)
        half, motion = name.split(" ", 1)
        halves[half] = (halves.get(half, (start, end))[0], end)
        narrow = end - start < 0.25 * ends[-1]
        _write_above(axes, 0.89, motion.replace(" ", "\n") if narrow else motion, start, end)
    for half, (start, end) in halves.items():
        _write_above(axes, 0.97, half, start, end, weight="bold")


def _write_above(axes: Axes, height: float, words: str, start: float, end: float, **look: Any) -> None:
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
    foot: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "ha": "right", "color": BLACK, "fontsize": 8.0}
    for place, names in marks.items():
        top = (
            0.8 if names == ["p_s"] else 1.0
        )  # slip may stop within compression or restitution, whose names stand above
        look: dict[str, Any] = {"color": BLACK, "linewidth": 0.7, "dashes": (4, 2), "zorder": 1, "ymax": top}
        axes.axvline(place * factor, **look)
        note(axes, f"${' = '.join(names)}$", (place * factor, 0.03), (-3.0, 0.0), **foot)
