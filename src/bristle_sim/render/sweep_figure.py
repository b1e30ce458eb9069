"""Draw a scenario's quantities over one key as lines, over two as maps."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.comparison import readable_unit
from bristle_sim.render.colours import BLUE
from bristle_sim.render.style import axes_at, blank_figure, draw_colours, styled

if TYPE_CHECKING:
    import xarray as xr

COLUMNS, WIDTH, HEIGHT = 3, 6.0, 5.2  # panels in a row, and their size with its margins, cm
TITLE_LETTERS = 32  # letters in a line of a panel's title


@styled()
def sweep_figure(found: xr.Dataset, keys: Sequence[str]) -> Figure:
    """Draw a panel for each quantity; points without a value are gaps, or white.

    Raises:
        ValueError: if no point has a result.
    """
    quantities = [str(name) for name in found.data_vars if name != "failure"]
    names = [name for name in quantities if np.isfinite(found[name].values).any()]
    if not names:
        raise ValueError(f"--plot: must have results to draw; {found['failure'].values.ravel()[0]}")
    rows = math.ceil(len(names) / COLUMNS)
    figure = blank_figure(COLUMNS * WIDTH + 0.6, rows * HEIGHT + 0.4)
    (x, x_label), *others = (_shown(found, key) for key in keys)
    for number, name in enumerate(names):
        column, row = number % COLUMNS, rows - 1 - number // COLUMNS
        axes = axes_at(figure, 1.4 + WIDTH * column, 1.3 + HEIGHT * row, WIDTH - 2.4, HEIGHT - 2.4)
        values, label = _shown(found, name)
        axes.set_title("\n".join(textwrap.wrap(label, TITLE_LETTERS)), loc="left", fontsize=7.5)
        axes.set_xlabel(x_label, fontsize=7.0, labelpad=2.0)
        for y, y_label in others:
            axes.set_ylabel(y_label, fontsize=7.0, labelpad=2.0)
            draw_colours(axes, x, y, values.T if found[name].dims[0] == keys[0] else values)
        if not others:
            axes.plot(x, values, ".-", color=BLUE, markersize=4.0)
            low, high = float(x.min()), float(x.max())  # also those without a result
            room = 0.05 * (high - low) or 0.5
            axes.set_xlim(low - room, high + room)
    return figure


def _shown(found: xr.Dataset, name: str) -> tuple[Array, str]:
    """Return values in a person's unit, and their label with it."""
    values, about = found[name].values, found[name].attrs
    unit, size = readable_unit(str(about.get("units", "1")), values.ravel().tolist())
    unit = {"1": "", "deg": "°"}.get(unit, unit)
    label = str(about.get("long_name", name.removesuffix("_deg").replace("_", " ")))
    return values * (1.0 / size), label + (f" ({unit})" if unit else "")
