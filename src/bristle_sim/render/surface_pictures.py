"""Pictures of a blasted surface: its height map, a profile, roughness over time, and a film."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LightSource, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.readable import MICROMETRES, MILLIMETRES
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.style import (
    BLUE,
    GREY,
    SKY,
    VERMILION,
    Scale,
    add_right_scale,
    blank_figure,
    signed,
    styled,
)
from bristle_sim.studies.ground import Ground
from bristle_sim.studies.surface import MEASURED_RZ, BlastedSurface
from bristle_sim.theory.roughness import SECTIONS, roughness_profiles

DEEPEST = 1.0  # percentile of the heights at which the colour scale begins
LIGHT = LightSource(azdeg=270.0, altdeg=40.0)  # light from the left; the tips slide to the right
MAP = "cividis"
FILM_SECONDS = 6.0
PIXELS = 1000  # largest number of pixels of the film's height map in the direction of sliding


@styled()
def surface_figure(made: BlastedSurface) -> Figure:
    """Draw the height map of a blasted surface, a profile, and the roughness Rz over time.

    The profile runs along the direction in which the tips slide; the sections for Rz are marked.
    The coverage is drawn with Rz.
    """
    figure = blank_figure(16.0, 13.5)
    ground, profile, course = figure.subplots(3, height_ratios=(2, 3, 3))
    low, high = MEASURED_RZ
    ground.set_title(
        f"Rz {MICROMETRES * made.rz:.0f} µm (measured {MICROMETRES * low:.0f} to {MICROMETRES * high:.0f} µm)"
        f" at {3600.0 * made.area_rate:.2f} m²/h, {100.0 * made.coverage:.1f} % covered,"
        f" crater rule {made.blasting.crater_rule};\nthe tips slide to the right, the light comes from the left"
    )
    norm = _colours(made)
    _show_heights(ground, made, _lit(made, made.heights, norm))
    figure.colorbar(ScalarMappable(norm, MAP), ax=ground, extend="min", label="height (µm)")
    _draw_profile(profile, made)
    _draw_course(course, made)
    return figure


def _strike_times(made: BlastedSurface, strikes: ArrayLike) -> Array:
    """Return the time (s) in which the simulated area receives a given number of strikes.

    It is the time for which the tool's belt has been over the track.
    """
    part = made.blasting.track_width / made.blasting.ground_width
    return np.asarray(strikes) * (part / made.strike_rate)


def _colours(made: BlastedSurface) -> Normalize:
    deepest = float(np.percentile(made.heights, DEEPEST))
    return Normalize(MICROMETRES * deepest, MICROMETRES * float(made.heights.max()))


def _lit(made: BlastedSurface, heights: Array, norm: Normalize, every: int = 1) -> Array:
    """Return heights (m) as a picture, lit from the left, with the colour scale ``norm``.

    Along the direction of sliding the picture has only every ``every``-th cell.
    """
    across, along = heights.shape
    dx = every * MICROMETRES * made.blasting.ground_length / along
    dy = MICROMETRES * made.blasting.ground_width / across
    shown = MICROMETRES * heights[:, ::every]
    return np.asarray(LIGHT.shade(shown, colormaps[MAP], norm, "soft", vert_exag=1.0, dx=dx, dy=dy))


def _show_heights(axes: Axes, made: BlastedSurface, picture: Array) -> AxesImage:
    length = MILLIMETRES * made.blasting.ground_length
    width = MILLIMETRES * made.blasting.ground_width
    axes.grid(visible=False)
    axes.set(xlabel="along the slide (mm)", ylabel="across (mm)")
    return axes.imshow(picture, extent=(0.0, length, 0.0, width), origin="lower", aspect="auto")


def _draw_profile(axes: Axes, made: BlastedSurface) -> None:
    """Draw the roughness profile through the middle of the surface.

    The profile is the height minus the Gaussian mean line. In each section the range from the
    lowest to the highest point of the profile is shaded.
    """
    step = made.blasting.ground_length / made.heights.shape[1]
    cutoff = made.blasting.cutoff_wavelength
    profile = MICROMETRES * roughness_profiles(
        made.heights[made.heights.shape[0] // 2], step, cutoff
    )
    edges = np.rint(np.arange(SECTIONS + 1) * cutoff / step).astype(int)
    place = MILLIMETRES * step * np.arange(profile.size)
    for first, last in pairwise(edges.tolist()):
        section = profile[first:last]
        ends = MILLIMETRES * step * np.array([first, last])
        axes.fill_between(ends, section.min(), section.max(), color=SKY, alpha=0.25, linewidth=0.0)
        axes.axvline(ends[1], color=GREY, linewidth=0.6)
        words = f"{np.ptp(section):.0f} µm"
        axes.text(ends.mean(), section.max(), words, ha="center", va="bottom", color=GREY)
    axes.plot(place[: edges[-1]], profile[: edges[-1]], color=BLUE, linewidth=0.8)
    axes.set_xlim(0.0, MILLIMETRES * step * edges[-1])
    axes.margins(y=0.15)
    words = f"along the slide (mm); {SECTIONS} section lengths of {MILLIMETRES * cutoff:g} mm"
    axes.set(xlabel=words, ylabel="roughness (µm)")


def _draw_course(axes: Axes, made: BlastedSurface) -> None:
    """Draw roughness Rz and coverage over the time (s) that the belt has been over the track."""
    time = _strike_times(made, made.course["strikes"])
    roughness = MICROMETRES * made.course["rz"]
    low, high = MEASURED_RZ
    axes.axhspan(MICROMETRES * low, MICROMETRES * high, color=GREY, alpha=0.2, linewidth=0.0)
    axes.plot(time, roughness, ".-", color=BLUE)
    axes.set(xlim=(0.0, time[-1]), ylim=(0.0, 1.1 * max(MICROMETRES * high, roughness.max())))
    axes.set_xlabel("time under the belt (s); grey: measured Rz")
    axes.set_ylabel("Rz (µm)", color=BLUE)
    covered = add_right_scale(axes)
    covered.plot(time, 100.0 * made.course["coverage"], color=VERMILION, marker=".")
    covered.set_ylim(0.0, 110.0)
    covered.set_ylabel("coverage (%)", color=VERMILION)


class SurfaceFilm(Film):
    """Film of a surface while the belt passes over it, with curves of Rz and coverage below."""

    size = (800, 500)

    @styled()
    def __init__(
        self,
        made: BlastedSurface,
        *,
        width: int = 800,
        height: int = 500,
        duration: float = FILM_SECONDS,
    ) -> None:
        """Draw the surface before the first strike.

        Args:
            made: the blasted surface.
            width, height: size of the picture, px.
            duration: duration of the film, s.
        """
        self.made = made
        self.times = _strike_times(made, 1.0 + np.arange(made.depths.size))
        warp = slow_motion(0.0, float(self.times[-1]), duration)
        super().__init__(warp, width, height, (BLUE, VERMILION), Scale(1.0, "s"))
        self.ground = Ground(made.body, made.blasting)
        # number of cells of the surface, along the slide, for one cell of the picture
        self.every = math.ceil(made.heights.shape[1] / PIXELS)
        self.norm = _colours(made)
        axes = self.figure.add_axes((0.075, 0.42, 0.9, 0.57 - HEADER))
        self.picture = _show_heights(axes, made, self._picture())
        _draw_course(self.add_timeline((0.075, 0.1, 0.85, 0.2)), made)
        self.moving = [self.picture, *self.hands]

    def _picture(self) -> Array:
        return _lit(self.made, self.ground.heights, self.norm, self.every)

    def move(self, time: float) -> Sequence[str]:
        """Show the surface after the belt has been over the track for a time, s.

        Strikes since the time shown last are added. If ``time`` is before the time shown last, all
        strikes are repeated on the unblasted surface.
        """
        made = self.made
        number = int(np.searchsorted(self.times, time * (1.0 + 1e-12), "right"))
        if number < len(self.ground.taken):
            self.ground = Ground(made.body, made.blasting)
        for each in range(len(self.ground.taken), number):
            x, y = made.places[each].tolist()
            self.ground.strike(x, y, float(made.depths[each]))
        self.picture.set_data(self._picture())
        rz = MICROMETRES * float(np.interp(number, made.course["strikes"], made.course["rz"]))
        caption = f"{number} of {made.depths.size} strikes, {3600.0 * made.area_rate:.2f} m²/h"
        covered = f"covered {100.0 * self.ground.coverage:5.1f} %"
        return caption, f"Rz {signed(rz, 0, 4)} µm", covered
