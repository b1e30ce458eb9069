"""Draw a row of bristles at two touches, and the last bristle's strike over the pitch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.render.colours import BLACK, BLUE, SERIES, VERMILION
from bristle_sim.render.drawing import WireDrawing, close_up, draw_film_tool, touch_places
from bristle_sim.render.style import MILLIMETRES, QUANTITIES, add_panel, blank_figure, note, say, styled
from bristle_sim.studies.neighbours import NeighbourRow, root_pitch, strike_values

BESIDE = 0.02  # how far beside a least pitch the strike is computed, deg
STRIKES = ("relative_speed_at_contact", "lag_deg_at_contact", "normal_final_impulse")

LEAST = {
    "least_pitch_to_strike_deg": ("no touch until the one in front strikes", (1, 1)),
    "least_pitch_to_own_strike_deg": ("no touch until its own strike", (4, 2)),
    "least_pitch_whole_pass_deg": ("no touch in the whole pass", (9, 2)),
}
"""Words for the pitches right of a line, and the line's dashes."""


def pitches_to_draw(row: NeighbourRow) -> list[float]:
    """Return pitches to simulate, deg, from close bristles to beyond the least pitch of the whole pass."""
    least = [each.by_theory for each in row.least if each.by_theory is not None]
    if not least:
        return [fraction * row.neighbours.pitch_deg for fraction in (0.5, 0.75, 1.0, 1.5, 2.0)]
    close = 2.5 * root_pitch(row.tool)
    even = [*np.linspace(close, 1.2 * min(least), 17), *np.linspace(1.2 * min(least), 1.1 * max(least), 6)]
    return sorted([*even, *(each + side for each in least for side in (-BESIDE, BESIDE))])


@styled()
def neighbours_figure(row: NeighbourRow, pitches: Sequence[float], strikes: Mapping[str, Array]) -> Figure:
    """Draw a row at two instants, and its last bristle's strike over the pitch in degrees."""
    figure, last = blank_figure(16.0, 13.4), f"bristle {len(row.bristles)}"
    for left, (title, time) in zip((0.2, 8.2), instants(row), strict=True):
        words = f"pitch {row.neighbours.pitch_deg:g}°, {1e3 * time:.3f} ms"
        axes = add_panel(figure, (left, 6.4, 7.6, 5.8), title, words)
        lines = [run.at(time).centre_line for run in row.bristles]
        draw_film_tool(axes, row.tool, close_up(np.array(lines), row.tool, 7.6 / 5.8), 7.0)
        for number, (line, color) in enumerate(zip(lines, SERIES * len(lines), strict=False), 1):
            WireDrawing(axes, row.tool, color=color).place(line)
            look = {"ha": "center", "va": "center", "color": color}
            note(axes, str(number), tuple(0.9 * MILLIMETRES * line[0]), (0.0, 0.0), **look)
        places = touch_places(lines, row.tool.bristle.wire_diameter)
        axes.plot(*places.T, "o", markersize=13.0, markerfacecolor="none", color=BLACK, zorder=6)
    alone = strike_values(row.tool, row.lone)
    for left, name in zip((1.5, 6.8, 12.0), STRIKES, strict=True):
        title, unit, factor = QUANTITIES[name]
        axes = add_panel(figure, (left, 1.9, 3.7, 3.2), title, f"of {last}")
        if (value := alone[name]) is not None:
            axes.axhline(factor * value, color=BLUE, linewidth=1.0, zorder=2, label="bristle alone")
        axes.plot(pitches, factor * strikes[name], "o", label=f"{last} of the row", color=VERMILION, markersize=2.6)
        for each in row.least:
            words, dashes = LEAST[each.name]
            if (least := each.by_theory) is not None:
                axes.axvline(least, color=BLACK, linewidth=0.8, dashes=dashes, zorder=1, label=f"{least:.2f}°: {words}")
        axes.set(xlabel="pitch (°)", ylabel=unit, xlim=(0.0, None))
        if np.isnan(strikes[name]).all():
            say(axes, "no strike at any pitch")
    handles, _ = axes.get_legend_handles_labels()
    figure.legend(handles=handles, loc="lower center", ncols=3, borderaxespad=0.2, columnspacing=1.4)
    return figure


def instants(row: NeighbourRow) -> list[tuple[str, float]]:
    """Return names and times, s, of the first touch and of the last one before the last bristle's strike."""
    front, strike = row.bristles[0].event_time("strike"), row.bristles[-1].event_time("strike")
    until, name = float(row.bristles[-1].time[-1]) if strike is None else strike, f"bristle {len(row.bristles)}"
    touches = [each for each in row.touches if each <= until]
    first = ("start", 0.0) if front is None else ("bristle 1 strikes", front)
    last = ("end of the pass" if strike is None else f"{name} strikes", until)
    if touches:
        first = ("first touch", touches[0])
    if len(touches) > 1:
        last = (f"last touch before {name} strikes" if strike else "last touch", touches[-1])
    return [first, last]
