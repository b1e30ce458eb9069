"""Figure of a single impact: velocities of the tip over the normal impulse.

The energetic law is compared with a contact that is resolved in time.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREY, VERMILION
from bristle_sim.render.style import Look, add_panel, blank_figure, note, say, scale_for, styled
from bristle_sim.studies.contact_laws import Impacts
from bristle_sim.studies.impulse_course import ImpulseCourse, energetic_course, recorded_course

PHASE_COLOURS = {
    "compression slip": "#e6eef6", "compression reverse slip": "#d3e2f0", "compression stick": "#dadde6",
    "restitution slip": "#eff5e8", "restitution reverse slip": "#e0ecd2", "restitution stick": "#e7e7df",
}  # fmt: skip
# Width of the narrowest phase whose name is shown, as a fraction of the panel
NARROWEST_NAMED = 0.09
LINES = (("$v_t$", VERMILION, "tangential_velocity"), ("$v_n$", BLUE, "normal_velocity"))


@styled()
def impact_figure(impacts: Impacts) -> Figure:
    """Draw the velocities of the tip over the normal impulse of an impact.

    The energetic law is drawn as lines, a contact that is resolved in time as crosses.
    """
    figure = blank_figure(16.0, 7.4)
    surface = impacts.surface
    recorded = None
    angles = ", ".join(f"{math.degrees(-angle):.4g}°" for angle in impacts.chain.angles)
    later = (
        "" if surface.restitution_friction is None else f", μ₂ = {surface.restitution_friction:.4g}"
    )
    words = (
        f"{angles} to the normal, μ = {surface.friction:.4g}{later}, e* = {surface.restitution:.4g}"
    )
    course = energetic_course(impacts.chain, surface)
    resolved = impacts.strikes.get("compliant")
    if resolved is not None and resolved.contact.history is not None:
        recorded = recorded_course(resolved.contact.history)
        if resolved.contact.outcome != "rebound":  # a tip in stiction stays in contact
            shown = recorded.impulse <= 1.01 * course.impulse[-1]
            recorded = ImpulseCourse(
                recorded.impulse[shown],
                recorded.normal_velocity[shown],
                recorded.tangential_velocity[shown],
            )
        rigid, elastic = (
            (": rigid along the surface", ", elastic")
            if impacts.contact.tangential_compliance
            else ("", "")
        )
        words += f"; lines{rigid or ': energetic law'}, crosses: resolved in time{elastic}"
    _draw_impulse_plane(
        add_panel(figure, (1.45, 1.3, 13.4, 4.9), "the impact over its normal impulse", words),
        course,
        recorded,
    )
    return figure


def _draw_impulse_plane(axes: Axes, course: ImpulseCourse, recorded: ImpulseCourse | None) -> None:
    """Draw the tip's velocities over the normal impulse, with the phases of the impact shaded.

    ``course`` is the energetic law, drawn as straight lines. ``recorded`` is a contact resolved in
    time, drawn as crosses.
    """
    fastest = float(np.abs([course.normal_velocity, course.tangential_velocity]).max())
    impulse = scale_for(float(course.impulse[-1]), "N·s")
    speed = scale_for(fastest, "m/s")
    axes.set(
        xlabel=f"normal impulse p ({impulse.unit})", ylabel=f"velocity of the tip ({speed.unit})"
    )
    if course.impulse.size < 2:
        say(axes, "the tip does not approach: no contact")
        return
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    for name, color, which in LINES:
        place = course.impulse * impulse.factor
        values = getattr(course, which) * speed.factor
        axes.plot(place, values, color=color, gid=which)
        # The name is on the side of the line away from zero.
        quarter = 0.25 * float(place[1])
        side = -1.0 if values[0] < 0.0 else 1.0
        words_at = (quarter, float(np.interp(quarter, place, values)))
        look: Look = {"color": color, "fontsize": 9.0}
        note(axes, name, words_at, (3.0, 3.0 * side), va="top" if side < 0.0 else "bottom", **look)
        if recorded is not None:
            points = (recorded.impulse * impulse.factor, getattr(recorded, which) * speed.factor)
            look = {"markersize": 3.6, "markeredgewidth": 0.8, "zorder": 3, "clip_on": False}
            axes.plot(*points, "x", color=BLACK, gid=f"{which}, resolved in time", **look)
    bottom, top = axes.get_ylim()
    last = max(each.impulse[-1] for each in (course, recorded) if each is not None)
    axes.set_xlim(0.0, 1.03 * last * impulse.factor)
    # room for names above and below
    axes.set_ylim(bottom - 0.06 * (top - bottom), top + 0.24 * (top - bottom))
    _shade_phases(axes, course, impulse.factor)
    _mark_impulses(axes, course, impulse.factor)


def _shade_phases(axes: Axes, course: ImpulseCourse, factor: float) -> None:
    """Shade the phases of an impact, with compression and restitution named above, slip and stick
    below.
    """
    ends = (course.impulse * factor).tolist()
    right = axes.get_xlim()[1]
    halves: dict[str, tuple[float, float]] = {}
    named = []
    for name, start, end in zip(course.phases, ends, ends[1:], strict=False):
        axes.axvspan(start, end, color=PHASE_COLOURS[name], linewidth=0.0, zorder=0)
        half, motion = name.split(" ", 1)
        halves[half] = (halves.get(half, (start, end))[0], end)
        narrow = end - start < 0.25 * ends[-1]
        named.append(
            (motion.replace(" ", "\n") if narrow else motion, 0.89, (start, end), "normal")
        )
    named += [(half, 0.97, place, "bold") for half, place in halves.items()]
    look: Look = {
        "transform": axes.get_xaxis_transform(),
        "ha": "center",
        "va": "top",
        "fontsize": 7.0,
    }
    for words, height, (start, end), weight in named:
        if end - start >= NARROWEST_NAMED * right:
            axes.text(0.5 * (start + end), height, words, linespacing=1.05, weight=weight, **look)


def _mark_impulses(axes: Axes, course: ImpulseCourse, factor: float) -> None:
    """Draw dashed lines at the normal impulses where compression ends, slip ends and contact ends.

    The lines are labelled p_c, p_s and p_f. Coincident lines share one label.
    """
    marks: dict[float, list[str]] = {}
    last = float(course.impulse[-1])
    for name, place in (("p_c", course.compression_end), ("p_s", course.slip_stop), ("p_f", last)):
        if 0.0 < place < math.inf:
            near = next((other for other in marks if abs(other - place) < 0.02 * last), place)
            marks.setdefault(near, []).append(name)
    foot: Look = {
        "xycoords": axes.get_xaxis_transform(),
        "ha": "right",
        "color": BLACK,
        "fontsize": 8.0,
    }
    for place, names in marks.items():
        top = 0.8 if names == ["p_s"] else 1.0  # the line of p_s ends below the name of its phase
        axes.axvline(place * factor, color=BLACK, linewidth=0.7, dashes=(4, 2), zorder=1, ymax=top)
        note(axes, f"${' = '.join(names)}$", (place * factor, 0.03), (-3.0, 0.0), **foot)
