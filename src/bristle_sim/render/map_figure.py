"""Maps of the quantities of a strike over the bar's position, with marked positions.

The marks are the printed position, the position by the formula, and the best positions.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.colors import CenteredNorm
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.render import style
from bristle_sim.render.colours import BLACK, BLUE, GREY, VERMILION
from bristle_sim.render.sweep_figures import PERCENTILES
from bristle_sim.studies.cue_map import CueMap

MAPS = ("lag_deg_at_contact", "tip_speed_at_contact", "normal_compressive_work", "crater_depth")


@style.styled()
def map_figure(found: CueMap, x: Array, y: Array, maps: Mapping[str, Array]) -> Figure:
    """Draw maps of four quantities of the strike over the bar's position.

    The quantities are lag, tip speed, normal work of compression and crater depth. White cells are
    positions at which the bar does not lead to a cued strike.

    Args:
        found: the study, with the bar positions to mark.
        x, y: coordinates of the bar on the maps, m.
        maps: values of the quantities by name, as returned by
            :func:`bristle_sim.studies.cue_map.position_map`.
    """
    assert found.tool.bar is not None
    distance = math.hypot(*found.tool.bar.centre) * style.MILLIMETRES
    arc = np.linspace(0.0, math.pi, 721)
    places = (x * style.MILLIMETRES, y * style.MILLIMETRES)
    lags = maps["lag_deg_at_contact"]
    looks = [("s", "white"), ("^", BLUE), ("o", VERMILION), ("+", BLACK)]
    if found.formula is None:
        del looks[1]
    figure = style.blank_figure(16.0, 15.3)
    for axes, name in zip(figure.subplots(2, 2, sharex=True, sharey=True).flat, MAPS, strict=True):
        title, unit, factor = style.STRIKE_LOOKS[name]
        values = factor * maps[name]
        known = values[np.isfinite(values)]
        low, high = np.percentile(known, PERCENTILES) if known.size else (0.0, 1.0)
        look: dict[str, Any] = {"vmin": low, "vmax": high}
        if name == "lag_deg_at_contact":
            half = max(abs(low), abs(high)) or 1.0
            look = {"norm": CenteredNorm(halfrange=half), "cmap": "RdBu"}
        cells = axes.pcolormesh(*places, values, shading="nearest", rasterized=True, **look)
        figure.colorbar(cells, ax=axes, extend="both")
        axes.set_title(f"{title} ({unit})")
        if np.nanmin(lags) < 0.0 < np.nanmax(lags):
            axes.contour(*places, lags, levels=[0.0], colors=BLACK, linewidths=0.9)
        axes.set(xlim=axes.get_xlim(), ylim=axes.get_ylim(), aspect="equal")
        axes.set(xlabel="S_H, along the workpart (mm)", ylabel="S_V, normal to the workpart (mm)")
        axes.label_outer()
        axes.grid(visible=False)
        axes.plot([], [], color=BLACK, linewidth=0.9, label="lag zero")
        label = "bar at its given distance from the hub"
        axes.plot(distance * np.sin(arc), distance * np.cos(arc), "--", color=GREY, label=label)
        for (label, direction), (marker, colour) in zip(found.marks.items(), looks, strict=True):
            place = (distance * math.sin(direction), distance * math.cos(direction))
            words = f"{label}, {math.degrees(direction):.2f}°"
            axes.plot(*place, marker, color=colour, markeredgecolor=BLACK, label=words)
    axes.plot([], [], "s", color="white", markeredgecolor=GREY, label="no cued strike")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure
