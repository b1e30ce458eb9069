"""Velocities and forces of a contact over time, shaded phase by phase, with markers that move along."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.render.colours import BLACK, BLUE, GREY, VERMILION
from bristle_sim.render.contact_motion import ContactMotion
from bristle_sim.render.impulse_plane import PHASE_COLOURS
from bristle_sim.render.style import scale_for

NORMAL, TANGENTIAL = BLUE, VERMILION

ROUNDING = 1e-6
"""Velocities below this fraction of the fastest are drawn as zero."""

PANELS = (
    ("$v_t$, along\nthe surface", "m/s", (("tangential_velocity", TANGENTIAL),)),
    ("$v_n$, away\nfrom it", "m/s", (("normal_velocity", NORMAL),)),
    ("forces\non the tip", "N", (("normal_force", NORMAL), ("tangential_force", TANGENTIAL))),
)

GAP = 0.035
"""Between panels, as a fraction of the figure's height."""


class ContactPanels:
    """Panels one above the other.

    Attributes:
        clock: scale of the times shown.
        markers: each with the quantity it follows and the factor from SI to what is shown.
        artists: what moves.
    """

    def __init__(
        self, figure: Figure, motion: ContactMotion, box: tuple[float, float, float, float], letter_size: float
    ) -> None:
        """``box``: left, bottom, width and height, as shares of the figure."""
        self.motion, self.clock = motion, scale_for(motion.touch_end, "s")
        self.markers: list[tuple[Line2D, str, float]] = []
        self.hands: list[Line2D] = []
        left, bottom, width, height = box
        share = height / len(PANELS)
        for number, (title, unit, lines) in enumerate(PANELS):
            below = len(PANELS) - 1 - number
            axes = figure.add_axes((left, bottom + below * share, width, share - GAP))
            self._draw(axes, title, unit, lines, letter_size)
            axes.tick_params(labelsize=0.9 * letter_size, labelbottom=below == 0)
        axes.set_xlabel(f"time since the first touch ({self.clock.unit})", fontsize=letter_size)
        self.artists: list[Artist] = [*self.hands, *(marker for marker, _, _ in self.markers)]

    def show(self, time: float) -> None:
        """Move hands and markers to an instant, s."""
        shown = time * self.clock.factor
        for marker, name, factor in self.markers:
            marker.set_data([shown], [self.motion.at(name, time) * factor])
        for hand in self.hands:
            hand.set_xdata([shown, shown])

    def _draw(self, axes: Axes, title: str, unit: str, lines: tuple[tuple[str, str], ...], letter_size: float) -> None:
        largest = max(float(np.abs(getattr(self.motion, name)).max()) for name, _ in lines)
        least = ROUNDING * self.motion.fastest if unit == "m/s" else 0.0
        scale = scale_for(max(largest, least), unit)
        time = self.motion.time * self.clock.factor
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        for name, color in lines:
            axes.plot(time, getattr(self.motion, name) * scale.factor, color=color, linewidth=1.8)
            (marker,) = axes.plot([], [], "o", color=color, markersize=6, markeredgecolor="white")
            self.markers.append((marker, name, scale.factor))
        self.hands.append(axes.axvline(0.0, color=BLACK, linewidth=1.0))
        self._shade(axes)
        axes.set_xlim(time[0], time[-1])
        axes.margins(y=0.1)
        if largest < least:
            axes.set_ylim(-least * scale.factor, least * scale.factor)
        axes.set_ylabel(f"{title} ({scale.unit})", fontsize=letter_size)
        axes.locator_params(axis="y", nbins=5)

    def _shade(self, axes: Axes) -> None:
        ends = [*(phase.start for phase in self.motion.phases[1:]), float(self.motion.time[-1])]
        for phase, end in zip(self.motion.phases, ends, strict=True):
            color = PHASE_COLOURS.get(phase.caption, "white")
            axes.axvspan(phase.start * self.clock.factor, end * self.clock.factor, color=color, linewidth=0.0, zorder=0)
