"""The impulse plane: normal and tangential velocity of the contact point over the normal impulse, phase by phase."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from bristle_sim.render.prefixes import Scale, scale_for
from bristle_sim.render.style import BLACK, BLUE, GREY, VERMILION
from bristle_sim.studies.impulse_course import ImpulseCourse

__all__ = ["PHASE_COLOURS", "draw_impulse_plane"]

PHASE_COLOURS = {
    "compression slip": "#e6eef6",
    "compression reverse slip": "#d3e2f0",
    "compression stick": "#dadde6",
    "restitution slip": "#eff5e8",
    "restitution reverse slip": "#e0ecd2",
    "restitution stick": "#e7e7df",
}

NARROW = 0.09
"""A stretch that takes less than this share of the panel is not named in it."""

LINES = (("$v_t$", VERMILION, "tangential_velocity"), ("$v_n$", BLUE, "normal_velocity"))


def draw_impulse_plane(axes: Axes, course: ImpulseCourse, recorded: ImpulseCourse | None = None) -> None:
    """Draw the energetic law's straight pieces, with a contact resolved in time as points on them.

    Phases are shaded and named; p_c, p_s and p_f are marked. Impulses and velocities take readable prefixes.
    """
    fastest = float(np.abs([course.normal_velocity, course.tangential_velocity]).max())
    impulse, speed = scale_for(course.impulse[-1], "N·s"), scale_for(fastest, "m/s")
    axes.set_xlabel(f"normal impulse p ({impulse.unit})")
    axes.set_ylabel(f"velocity of the tip ({speed.unit})")
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    if course.impulse.size < 2:
        axes.text(0.5, 0.6, "the tip does not approach: no contact", transform=axes.transAxes, ha="center", color=GREY)
        axes.set(xticks=[], yticks=[])
        return
    _draw_velocities(axes, course, impulse, speed)
    if recorded is not None:
        _draw_points(axes, recorded, course.impulse[-1], impulse, speed)
    _frame(axes, course, impulse)
    _shade_phases(axes, course, impulse)
    _mark_impulses(axes, course, impulse)


def _draw_velocities(axes: Axes, course: ImpulseCourse, impulse: Scale, speed: Scale) -> None:
    """Both velocities, each named on the side of its line that is away from zero."""
    for name, color, which in LINES:
        place, values = course.impulse * impulse.factor, getattr(course, which) * speed.factor
        axes.plot(place, values, color=color, gid=which)
        quarter = 0.25 * float(place[1])
        side = -1.0 if values[0] < 0.0 else 1.0
        axes.annotate(
            name,
            (quarter, float(np.interp(quarter, place, values))),
            xytext=(3.0, 3.0 * side),
            textcoords="offset points",
            color=color,
            fontsize=9.0,
            va="top" if side < 0.0 else "bottom",
        )


def _draw_points(axes: Axes, recorded: ImpulseCourse, last: float, impulse: Scale, speed: Scale) -> None:
    """The contact resolved in time, as far as the energetic law goes: a tip that is stuck stays pressed on."""
    shown = recorded.impulse <= 1.01 * last
    look: dict[str, Any] = {"markersize": 3.6, "markeredgewidth": 0.8, "zorder": 3, "clip_on": False}
    for _, _, which in LINES:
        place, value = recorded.impulse * impulse.factor, getattr(recorded, which) * speed.factor
        axes.plot(place[shown], value[shown], "x", color=BLACK, gid=f"{which}, resolved in time", **look)


def _frame(axes: Axes, course: ImpulseCourse, impulse: Scale) -> None:
    """Limits with room for the phases' names above and the impulses' names below."""
    axes.set_xlim(0.0, 1.03 * float(course.impulse[-1]) * impulse.factor)
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom - 0.06 * (top - bottom), top + 0.24 * (top - bottom))


def _shade_phases(axes: Axes, course: ImpulseCourse, impulse: Scale) -> None:
    """Shades from phase to phase; above them compression and restitution, and below these slip or stick."""
    ends = (course.impulse * impulse.factor).tolist()
    halves: dict[str, tuple[float, float]] = {}
    for name, start, end in zip(course.phases, ends, ends[1:], strict=False):
        axes.axvspan(start, end, color=PHASE_COLOURS[name], linewidth=0.0, zorder=0, gid=name)
        half, motion = name.split(" ", 1)
        halves[half] = (halves.get(half, (start, end))[0], end)
        share = (end - start) / ends[-1]
        _write_above(axes, 0.89, motion if share > 0.25 else motion.replace(" ", "\n"), start, end)
    for half, (start, end) in halves.items():
        _write_above(axes, 0.97, half, start, end, weight="bold")


def _write_above(axes: Axes, height: float, words: str, start: float, end: float, **look: Any) -> None:
    """Words centred over a stretch, unless it is too narrow for any."""
    if end - start < NARROW * axes.get_xlim()[1]:
        return
    axes.text(
        0.5 * (start + end),
        height,
        words,
        transform=axes.get_xaxis_transform(),
        ha="center",
        va="top",
        fontsize=7.0,
        linespacing=1.05,
        **look,
    )


def _mark_impulses(axes: Axes, course: ImpulseCourse, impulse: Scale) -> None:
    """Dashed lines at p_c, p_s and p_f; those that fall together share a name."""
    marks: dict[float, list[str]] = {}
    last = float(course.impulse[-1])
    for name, place in (("p_c", course.compression_end), ("p_s", course.slip_stop), ("p_f", last)):
        if 0.0 < place < math.inf:
            near = next((other for other in marks if abs(other - place) < 0.02 * last), place)
            marks.setdefault(near, []).append(name)
    for place, names in marks.items():
        # Slip may stop within compression or restitution, whose names stand above.
        look: dict[str, Any] = {
            "ymax": 0.8 if names == ["p_s"] else 1.0,
            "color": BLACK,
            "linewidth": 0.7,
            "dashes": (4, 2),
        }
        axes.axvline(place * impulse.factor, **look, zorder=1, gid=" ".join(names))
        axes.annotate(
            "$" + " = ".join(names) + "$",
            (place * impulse.factor, 0.03),
            xycoords=axes.get_xaxis_transform(),
            xytext=(-3.0, 0.0),
            textcoords="offset points",
            ha="right",
            fontsize=8.0,
        )
